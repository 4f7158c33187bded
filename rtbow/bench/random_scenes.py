"""Scenes drawn at random, to check that what holds for scenes made by hand holds for others."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from rtbow.scene.model import Scene
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.sun import SunAt

_NAME = re.compile(r"random-([1-9][0-9]{0,5})")
_SIZES = ("160, 90", "320, 180", "640, 360", "1280, 720")
_LAMP_SPECTRA = ("LED-B3", "LED-B5", "HP1", "FL2", "FL11", "equal-energy")


def random_seed(name: str | None) -> int | None:
    """Give N of ``random-N``, None for any other name."""
    match = _NAME.fullmatch(name or "")
    return int(match[1]) if match else None


def random_scene(seed: int, overrides: Mapping[str, object], sun: SunAt | None = None) -> Scene:
    """Draw a scene of suns or lamps, drops, air and rain as people make them.

    Args:
        seed: the same one draws the same scene.
        overrides: values by dotted key, as for :func:`rtbow.scene.text.file.load_scene`.
        sun: where and when the first sun is seen.
    """
    return scene_from_text(random_text(seed), f"random-{seed}", overrides=overrides, sun=sun)


def random_text(seed: int) -> str:
    """Draw a scene as TOML."""
    rng = np.random.default_rng([seed, 5])
    extreme = np.random.default_rng([seed, 6])
    picture = np.random.default_rng([seed, 7])
    street = rng.random() < 0.3
    lines = (_street(rng, picture) if street else _sky(rng, extreme)) + _scattering(rng)
    if picture.random() < 0.15:
        lines.insert(1, 'pixel = "area"')  # of [camera]
    return "\n".join(lines) + "\n"


def _number(rng: np.random.Generator, low: float, high: float) -> str:
    return f"{rng.uniform(low, high):.4g}"


def _even_log(rng: np.random.Generator, low: float, high: float) -> str:
    return f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}"


def _scattering(rng: np.random.Generator) -> list[str]:
    orders = ((1, 2), (1,), (2,))[rng.choice(3, p=(0.7, 0.2, 0.1))]
    return ["[scattering]", f"orders = {list(orders)}",
            f"water_temperature_c = {_number(rng, 0.0, 30.0)}"]  # fmt: skip


def _drops(rng: np.random.Generator, grid: tuple[int, int, int], density: tuple[float, float],
           radius_um: tuple[float, float]) -> list[str]:  # fmt: skip
    lines = []
    kind = rng.choice(["constant", "normal", "uniform", "gamma"], p=(0.5, 0.2, 0.15, 0.15))
    if kind != "constant" and kind != "gamma":
        lines += [f"grid = {list(grid)}", f"seed = {rng.integers(1, 1000)}"]
    size = float(_even_log(rng, *radius_um))
    lines += ["[droplets.radius]", f'distribution = "{kind}"']
    if kind == "constant":
        lines.append(f"radius_um = {size:g}")
    elif kind == "normal":
        lines += [f"mean_um = {size:g}", f"std_um = {size * rng.uniform(0.02, 0.2):.4g}"]
    elif kind == "uniform":
        lines += [f"min_um = {0.7 * size:.4g}", f"max_um = {1.4 * size:.4g}"]
    else:
        variance = _number(rng, 0.01, 0.15)
        lines += [f"effective_radius_um = {size:g}", f"effective_variance = {variance}"]
        lines.append('mixing = "local"')
    return [*lines, "[droplets.density]", f"number_per_m3 = {_even_log(rng, *density)}"]


def _sky(rng: np.random.Generator, extreme: np.random.Generator) -> list[str]:
    """Draw a scene under suns; ``extreme`` decides where the sun is low, high, small or wide."""
    altitude, azimuth = rng.uniform(1.0, 50.0), rng.uniform(0.0, 360.0)
    kind = extreme.random()
    if kind < 0.3:
        altitude = extreme.uniform(-2.0, 2.0)  # about the edge of the Earth's shadow, with air
    elif kind < 0.4:
        altitude = extreme.uniform(50.0, 90.0)
    size_px = _SIZES[extreme.integers(4)]
    # Mostly towards the bow, sometimes anywhere.
    bow = azimuth + 180.0 + rng.uniform(-40.0, 40.0)
    look = bow if rng.random() < 0.8 else rng.uniform(0.0, 360.0)
    towards = np.radians(look)
    near, depth, wide = rng.uniform(0.0, 400.0), rng.uniform(300.0, 2500.0), rng.uniform(600, 2500)
    # A box around the middle of the view, along the axes.
    middle = (near + 0.5 * depth) * np.array([np.sin(towards), np.cos(towards)])
    low, high = middle - 0.5 * wide, middle + 0.5 * wide
    lines = [
        "[camera]", f"position_m = [0.0, 0.0, {_even_log(rng, 1.0, 300.0)}]",
        f"azimuth_deg = {look % 360.0:.2f}", f"altitude_deg = {_number(rng, -10.0, 40.0)}",
    ]  # fmt: skip
    fov = _number(rng, 30.0, 110.0)
    if extreme.random() < 0.2:  # narrow: where a pixel is finer than the disc
        fov = _even_log(extreme, 3.0, 30.0)
    lines += [f"fov_deg = {fov}", f"size_px = [{size_px}]"]
    if rng.random() < 0.2:
        lines.append(f"polarizer_deg = {_number(rng, 0.0, 180.0)}")
    for _ in range(1 + (rng.random() < 0.15)):
        lines += ["[[light]]", 'type = "sun"', f"altitude_deg = {altitude:.2f}",
                  f"azimuth_deg = {azimuth:.2f}"]  # fmt: skip
        if rng.random() < 0.3:
            lines.append('spectrum = "equal-energy"')
        if extreme.random() < 0.5:
            lines.append(f"angular_diameter_deg = {_even_log(extreme, 0.02, 1.0)}")
        altitude, azimuth = rng.uniform(1.0, 50.0), azimuth + rng.uniform(-30.0, 30.0)
    lines += [
        "[droplets]",
        f"box_m = [[{low[0]:.1f}, {low[1]:.1f}, 0.0],"
        f" [{high[0]:.1f}, {high[1]:.1f}, {_number(rng, 300.0, 2000.0)}]]",
    ]
    if rng.random() < 0.3:
        lines.append("extinction = true")
    lines += _drops(rng, (24, 24, 16), (100.0, 3000.0), (80.0, 900.0))
    return lines + (["[atmosphere]"] if rng.random() < 0.6 else [])


def _street(rng: np.random.Generator, picture: np.random.Generator) -> list[str]:
    """Draw a scene under lamps; ``picture`` decides how many pixels it has."""
    wide, depth, high = rng.uniform(20.0, 80.0), rng.uniform(30.0, 120.0), rng.uniform(10.0, 40.0)
    lines = [
        "[camera]", f"position_m = [0.0, {_number(rng, 1.0, 12.0)}, 1.6]",
        f"azimuth_deg = {_number(rng, -40.0, 40.0)}",
        f"altitude_deg = {_number(rng, -10.0, 25.0)}",
        f"fov_deg = {_number(rng, 50.0, 115.0)}", f"size_px = [{_SIZES[picture.integers(4)]}]",
    ]  # fmt: skip
    for _ in range(1 + (rng.random() < 0.3)):
        lines += [
            "[[light]]", 'type = "point"',
            f"position_m = [{_number(rng, -8.0, 8.0)}, {_number(rng, -4.0, 30.0)},"
            f" {_number(rng, 3.0, 9.0)}]",
            f'spectrum = "{rng.choice(_LAMP_SPECTRA)}"',
            f"luminous_flux_lm = {_even_log(rng, 1000.0, 20000.0)}",
            f"diameter_m = {rng.choice([0.0, 0.05, 0.1, 0.3])}",
        ]  # fmt: skip
    lines += [
        "[droplets]",
        f"box_m = [[{-wide:.1f}, {_number(rng, -10.0, 15.0)}, 0.0],"
        f" [{wide:.1f}, {depth + 20.0:.1f}, {high:.1f}]]",
    ]
    if rng.random() < 0.2:
        lines.append("extinction = true")
    return lines + _drops(rng, (16, 16, 12), (300.0, 20000.0), (60.0, 600.0))
