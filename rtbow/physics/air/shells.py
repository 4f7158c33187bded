"""Constituents of the air in spherical shells: where each is, and its columns towards a sun."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import log_columns
from rtbow.physics.constants import SCALE_HEIGHT_M

_STEP_M = 100.0
"""Between heights at which densities are kept: straight lines between them are within 2e-5 of the
molecules'."""
_ROWS, _COLUMNS = 160, 384


class Shells(NamedTuple):
    """Constituents of the air over height and, towards a sun, over height and altitude.

    Amounts are shares of a vertical column from sea level. Rays are straight: without refraction,
    which adds 8 % to a column at the horizon and 2 % at 5 degrees.

    Attributes:
        density: of each constituent at even heights from 0 to ``TOP_M`` (C, N), 1/m.
        log_column: logarithms of the columns towards a sun (C, rows, columns), laid out as
            :func:`rtbow.physics.air.rayleigh.log_columns` says. Bilinear look-up is within 2e-4 of
            a molecules' column.
    """

    density: Array
    log_column: Array


@cache
def molecular_shells() -> Shells:
    """Give air of molecules alone."""
    height = np.arange(0.0, TOP_M + 0.5 * _STEP_M, _STEP_M)
    density = np.exp(-height / SCALE_HEIGHT_M) / SCALE_HEIGHT_M
    return Shells(density[None], log_columns(TOP_M, _ROWS, _COLUMNS)[None])
