"""Make scenes/shower.npz: a rain curtain a kilometre deep, with soft-edged shafts.

The shafts lean with the wind, are streaked along their lean, carry the largest drops in their
cores and on their lee side (wind sorts drops by their fall speed), and thin out towards the box's
faces, so that no face shows. Run it again to change the shower: everything follows from the seed.

    python tools/make_shower.py scenes/shower.npz
    python tools/make_shower.py scenes/curtain.npz 700     # drops of one radius, 700 µm
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter

from rtbow.base.arrays import Array, floats
from rtbow.world.rain.volume import DropletVolume, save_volume

BOX_M = np.array([[-2000.0, 300.0, 0.0], [2000.0, 1500.0, 1250.0]])
GRID = (112, 64, 64)
SEED = 20
LEAN = 0.28
"""Horizontal metres east per metre of height: the wind blows from the west, drops fall east."""

# Shafts: east and north of the axis at the ground, radius, share of the peak density.
SHAFTS = (
    (-1250.0, 900.0, 330.0, 0.75),
    (-560.0, 760.0, 260.0, 1.00),
    (120.0, 980.0, 420.0, 0.80),
    (760.0, 820.0, 240.0, 0.95),
    (1330.0, 1000.0, 300.0, 0.65),
)
PEAK_DENSITY_PER_M3 = 1500.0
DRIZZLE_DENSITY_PER_M3 = 260.0
PATCHINESS = 0.06
CORE_RADIUS_UM, EDGE_RADIUS_UM = 430.0, 270.0


def smoothstep(low: float, high: float, x: Array) -> Array:
    """Rise smoothly from 0 below ``low`` to 1 above ``high``."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return floats(t * t * (3.0 - 2.0 * t))


def streaks(rng: np.random.Generator, sizes: tuple[float, ...], lean_cells: Array) -> Array:
    """Give smooth noise of mean 0 and deviation 1, streaked along the shafts' lean."""
    noise = gaussian_filter(rng.standard_normal(GRID), sizes, mode="wrap")
    # Shear the noise as the shafts lean, level by level, by whole cells and the rest linearly.
    for k, shift in enumerate(lean_cells):
        whole = int(np.floor(shift))
        part = shift - whole
        level = noise[:, :, k]
        noise[:, :, k] = (1.0 - part) * np.roll(level, whole, 0) + part * np.roll(
            level, whole + 1, 0
        )
    return floats((noise - noise.mean()) / noise.std())


def shower(one_radius_um: float | None) -> DropletVolume:
    """Compute the volume, with its own radii or with one for all."""
    rng = np.random.default_rng(SEED)
    axes = [np.linspace(BOX_M[0, k], BOX_M[1, k], GRID[k]) for k in range(3)]
    east, north, up = np.meshgrid(*axes, indexing="ij")
    cell = (BOX_M[1] - BOX_M[0]) / (np.array(GRID) - 1)
    lean_cells = -LEAN * axes[2] / cell[0]
    fine = streaks(rng, (2.0, 2.5, 14.0), lean_cells)
    broad = streaks(rng, (6.0, 6.0, 24.0), lean_cells)

    # Falling, a drop drifts east: higher up the shaft stands further west.
    foot = east + LEAN * up
    core = np.zeros(GRID)
    lee = np.zeros(GRID)
    for x, y, radius, share in SHAFTS:
        distance2 = ((foot - x) / radius) ** 2 + ((north - y) / (0.8 * radius)) ** 2
        shaft = share * np.exp(-0.5 * distance2)
        core += shaft
        lee += shaft * np.clip((foot - x) / radius, -1.5, 1.5)
    core = np.clip(core * (1.0 + 0.30 * fine + 0.22 * broad), 0.0, None)
    drizzle = np.clip(1.0 + 0.35 * broad, 0.0, None)
    density = PEAK_DENSITY_PER_M3 * core + DRIZZLE_DENSITY_PER_M3 * drizzle

    # Soft towards the sides, the front and back, and the cloud base.
    density *= smoothstep(0.0, 450.0, east - BOX_M[0, 0]) * smoothstep(0, 450.0, BOX_M[1, 0] - east)
    density *= smoothstep(0.0, 250.0, north - BOX_M[0, 1]) * smoothstep(
        0.0, 250.0, BOX_M[1, 1] - north
    )
    density *= smoothstep(0.0, 350.0, BOX_M[1, 2] - up)

    radius_um = EDGE_RADIUS_UM + (CORE_RADIUS_UM - EDGE_RADIUS_UM) * np.clip(
        smoothstep(0.0, 1.0, core) + 0.25 * lee, 0.0, 1.3
    )
    # No two places have quite the same drops: this is what blurs the fringes of real bows.
    patches = gaussian_filter(rng.standard_normal(GRID), 0.8, mode="wrap")
    patches = 1.0 + PATCHINESS * patches / patches.std()
    radius_um *= patches
    density /= patches**3  # the same water everywhere
    if one_radius_um is not None:
        # The same water in drops of one size.
        density *= (CORE_RADIUS_UM / one_radius_um) ** 3
        radius_um = np.full(GRID, one_radius_um)
    # Eleven bits of mantissa are far finer than the drops are known, and pack well.
    return DropletVolume(
        BOX_M,
        radius_um.astype(np.float16).astype(np.float32),
        density.astype(np.float16).astype(np.float32),
    )


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: python tools/make_shower.py OUT.npz [RADIUS_UM]")
    save_volume(shower(float(sys.argv[2]) if len(sys.argv) == 3 else None), Path(sys.argv[1]))
