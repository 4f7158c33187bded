"""Compiled trilinear interpolation in a grid whose outermost points lie on the box's faces."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled


@compiled()
def _cell(at: float, low: float, high: float, count: int) -> tuple[int, float, int]:
    """First grid point of the cell that holds a coordinate, the share towards the next, and the
    step to it: 0 where there is but one point."""
    if count == 1:
        return 0, 0.0, 0
    place = (at - low) / (high - low) * (count - 1)
    index = min(max(int(np.floor(place)), 0), count - 2)
    return index, place - index, 1


@compiled()
def interpolate(point: Array, box: Array, moments: Array) -> tuple[float, float]:
    """Trilinear density and density · radius at a point of the box."""
    nz, ny, nx = moments.shape[:3]
    x, fx, sx = _cell(point[0], box[0, 0], box[1, 0], nx)
    y, fy, sy = _cell(point[1], box[0, 1], box[1, 1], ny)
    z, fz, sz = _cell(point[2], box[0, 2], box[1, 2], nz)
    density, product = 0.0, 0.0
    for k in range(2):
        share_z = fz if k else 1.0 - fz
        for j in range(2):
            share_y = share_z * (fy if j else 1.0 - fy)
            for i in range(2):
                share = share_y * (fx if i else 1.0 - fx)
                if share != 0.0:
                    at = moments[z + k * sz, y + j * sy, x + i * sx]
                    density += share * at[0]
                    product += share * at[1]
    return density, product
