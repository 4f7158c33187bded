"""Make scenes/drizzle.npz: drizzle in a street, in gusts that the wind has drawn out.

python tools/make_drizzle.py scenes/drizzle.npz
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter

from rtbow.world.rain.volume import DropletVolume, save_volume

BOX_M = np.array([[-40.0, 6.0, 0.0], [40.0, 70.0, 30.0]])
GRID = (64, 64, 64)
RADIUS_UM = 200.0
DENSITY_PER_M3 = 4000.0
SEED = 3


def drizzle() -> DropletVolume:
    """Compute the volume."""
    rng = np.random.default_rng(SEED)
    gusts = gaussian_filter(rng.standard_normal(GRID), (9.0, 5.0, 7.0), mode="nearest")
    veils = gaussian_filter(rng.standard_normal(GRID), (2.5, 2.5, 12.0), mode="nearest")
    share = 1.0 + 0.45 * gusts / gusts.std() + 0.15 * veils / veils.std()
    density = DENSITY_PER_M3 * np.clip(share, 0.05, None)
    # Soft towards the sides and the top, so that no face shows.
    for axis, ends in enumerate(((0.15, 0.15), (0.0, 0.15), (0.0, 0.25))):
        at = np.linspace(0.0, 1.0, GRID[axis])
        fade = np.ones(GRID[axis])
        for place, width in ((at, ends[0]), (1.0 - at, ends[1])):
            if width > 0.0:
                t = np.clip(place / width, 0.0, 1.0)
                fade *= t * t * (3.0 - 2.0 * t)
        density *= fade.reshape([-1 if k == axis else 1 for k in range(3)])
    # Eleven bits of mantissa are far finer than the drops are known, and pack well.
    return DropletVolume(
        BOX_M,
        np.full(GRID, RADIUS_UM, dtype=np.float32),
        density.astype(np.float16).astype(np.float32),
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python tools/make_drizzle.py OUT.npz")
    save_volume(drizzle(), Path(sys.argv[1]))
