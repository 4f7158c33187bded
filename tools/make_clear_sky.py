"""Solve for the fields of clear air that come with the program: rtbow/data/clear-sky.npz.

Takes about ten minutes on two cores.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from tqdm import tqdm

from rtbow.base.arrays import Array
from rtbow.physics.light.fresnel import diffuse_reflectance
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.clear import (
    ALBEDOS,
    FILE,
    MOLECULES,
    OZONE,
    WATER_INDEX,
    Coded,
    coded,
    packed,
)
from rtbow.tables.sky.field import solved_field
from rtbow.tables.sky.light import Scattered

DATA = Path(__file__).parent.parent / "rtbow" / "data"


def main(path: Path) -> None:
    """Write the file."""
    same = np.ones(len(MOLECULES))
    water = same * WATER_INDEX
    grounds: list[tuple[Array, Array | None]] = [(same * albedo, None) for albedo in ALBEDOS]
    grounds.append((diffuse_reflectance(water), water))
    black: dict[float, Scattered] = {}
    kept: list[Coded] = []
    for albedo, index in tqdm(grounds):
        for ozone in OZONE:
            air = make_air(MOLECULES, albedo, same * ozone, water=index)
            field = solved_field(air)
            kept.append(coded(field, black.setdefault(ozone, field), MOLECULES))
    mean, ground = (
        np.reshape(parts, (len(grounds), len(OZONE), *np.shape(parts[0])))
        for parts in ([one.mean for one in kept], [one.ground for one in kept])
    )
    file = packed(kept[0]._replace(mean=mean, ground=ground))
    np.savez_compressed(path, allow_pickle=False, **file)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DATA / FILE)
