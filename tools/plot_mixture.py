"""Plot how radii drawn at grid points approach a mixture of all sizes as the grid grows.

    python tools/plot_mixture.py docs/charts/mixture.png

It plots two errors of the primary bow's profile against `mixing = "local"`: that of the mean over
the grid points, which falls as one over the root of their number; and that of a rendered frame,
where radii are interpolated between the points (the paper's rule), so that the error levels off at
the difference that interpolation makes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import rtbow
from rtbow.base.arrays import Array
from rtbow.tables.sections import water_sections
from rtbow.world.rain.drops import distribution, quantiles

RADIUS = {"distribution": "lognormal", "median_um": 100.0, "log_std": 0.3}
GRIDS = (2, 3, 4, 6, 8, 12, 16, 24, 32)
SEEDS = 6


def scene(radius: dict[str, Any], grid: int | None, seed: int) -> rtbow.Scene:
    """A strip of pixels up through the top of the bow, without air."""
    droplets: dict[str, Any] = {
        "box_m": [[-500.0, 200.0, -200.0], [500.0, 1200.0, 1000.0]],
        "radius": radius,
        "density": {"number_per_m3": 1000.0},
        "seed": seed,
    }
    if grid is not None:
        droplets["grid"] = [grid] * 3
    return rtbow.Scene.model_validate(
        {
            "camera": {"size_px": [24, 48], "fov_deg": 12.0, "altitude_deg": 20.0},
            "light": [{"altitude_deg": 20.0}],
            "droplets": droplets,
            "render": {"wavelength_step_nm": 40.0},
        }
    )


def frame(radius: dict[str, Any], grid: int | None, seed: int = 1) -> Array:
    """Luminance of a frame."""
    with rtbow.Renderer(scene(radius, grid, seed)) as renderer:
        rgb = renderer.render("spectral").astype(np.float64)
    return np.asarray(rgb @ [0.2126, 0.7152, 0.0722])


def main(path: Path) -> None:
    """Draw the plot."""
    drops = scene(RADIUS | {"mixing": "local"}, None, 1).droplets
    assert drops.radius is not None
    assert drops.density is not None
    theta = np.radians(np.linspace(137.0, 160.0, 60))
    sections = water_sections("airy", np.array([550.0]), 20.0, (15.0, 600.0))
    whole = sections.mixed(distribution(drops.radius, drops.density), theta, 0.00465)[0].mean(1)
    rng = np.random.default_rng(1)
    points, frames = [], []
    exact = frame(RADIUS | {"mixing": "local"}, None)
    for grid in GRIDS:
        trials = []
        for _ in range(SEEDS):
            radius_m = quantiles(drops.radius, rng.random(grid**3)) * 1e-6
            mean = np.zeros(len(theta))
            for start in range(0, len(radius_m), 256):
                part = radius_m[start : start + 256]
                mean += sections.sections(part, theta, 0.00465)[:, 0].mean(2).sum(0)
            trials.append(np.mean((mean / len(radius_m) / whole - 1.0) ** 2))
        points.append(np.sqrt(np.mean(trials)))
        drawn = [frame(RADIUS, grid, seed) for seed in range(1, SEEDS + 1)]
        frames.append(np.sqrt(np.mean([((f - exact) / exact.max()) ** 2 for f in drawn])))
    counts = np.array(GRIDS) ** 3.0
    slope = np.polyfit(np.log(counts), np.log(points), 1)[0]

    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.loglog(counts, points, "o-", label=f"mean over grid points: slope {slope:.2f}")
    axes.loglog(counts, frames, "s-", label="frame, radii interpolated between the points")
    axes.loglog(counts, points[0] * (counts / counts[0]) ** -0.5, "k:", label="slope −1/2")
    axes.set_xlabel("grid points")
    axes.set_ylabel("error (RMS, relative to the mixture)")
    axes.set_title("Radii drawn per point against all sizes at each point", fontsize=10)
    axes.grid(True, which="both", lw=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
