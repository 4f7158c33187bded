"""Ozone: how much light its layer takes, by wavelength, and where it lies."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Values, floats
from rtbow.physics.curves import monotone_cubic

_DEPTH_NM = (450.0, 500.0, 550.0, 575.0, 600.0, 625.0, 650.0, 700.0)
_DEPTH = (0.0014, 0.0096, 0.0265, 0.0378, 0.0405, 0.0302, 0.0197, 0.0067)
"""Vertical depth of 300 DU at 233 K: Serdyuchenko et al., Atmos. Meas. Tech. 7, 625 (2014),
smoothed over 10 nm; Bogumil et al. (2003) are within 4 % of it."""
_DEPTH_DU = 300.0
_ENDS_NM = (400.0, 780.0)
"""Where the Chappuis bands have faded."""

_MIDDLE_M, _HALF_WIDTH_M = 25_000.0, 15_000.0
"""The layer: a tent over height, from 10 to 40 km."""


def ozone_depth(wavelength_nm: Array, column_du: float) -> Array:
    """Give the vertical optical depth of absorption by ozone, same shape as the wavelengths.

    A monotone cubic through eight published values; between them the bands' structure is within 5 %
    of the greatest depth.

    Args:
        wavelength_nm: wavelengths, nm.
        column_du: all of the ozone above a place, Dobson units.
    """
    nm = np.concatenate([_ENDS_NM[:1], _DEPTH_NM, _ENDS_NM[1:]])
    depth = np.concatenate([[0.0], _DEPTH, [0.0]])
    values = monotone_cubic(nm, depth, np.clip(wavelength_nm, *_ENDS_NM))
    return floats(column_du / _DEPTH_DU * values)


def ozone_density(height_m: Values) -> Array:
    """Give the share of the vertical column that a metre of height holds, 1/m."""
    away = np.abs(floats(height_m) - _MIDDLE_M) / _HALF_WIDTH_M
    return floats(np.maximum(1.0 - away, 0.0) / _HALF_WIDTH_M)
