"""Constituents of the air in spherical shells: where each is, and its columns towards a sun."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Values, floats
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import ALTITUDE_CURVE, horizon_rad
from rtbow.physics.constants import EARTH_RADIUS_M, SCALE_HEIGHT_M

Density = Callable[[Values], Array]
"""Gives the share of a vertical column that a metre holds, 1/m, at heights in m."""

_STEP_M = 100.0
"""Between heights at which densities are kept: straight lines between them are within 2e-5 of the
molecules'."""
_ROWS, _COLUMNS = 160, 384


def molecules_density(height_m: Values) -> Array:
    """Give the share of the vertical column of molecules that a metre of height holds, 1/m."""
    return floats(np.exp(-floats(height_m) / SCALE_HEIGHT_M) / SCALE_HEIGHT_M)


@dataclass(frozen=True)
class Shells:
    """Constituents of the air over height and, towards a sun, over height and altitude.

    Columns are shares of a vertical one from sea level, along straight rays: without refraction,
    which adds 8 % at the horizon and 2 % at 5 degrees.

    Attributes:
        density: of each constituent at even heights from 0 to ``TOP_M`` (C, N), 1/m.
        log_column: logarithms of the columns towards a sun (C, rows, columns): over the root of the
            height, and the altitude above its horizon by ``ALTITUDE_CURVE``. Bilinear look-up is
            within 2e-4 of a molecules' column.
    """

    density: Array
    log_column: Array


def shells(densities: Sequence[Density]) -> Shells:
    """Tabulate constituents."""
    height = np.arange(0.0, TOP_M + 0.5 * _STEP_M, _STEP_M)
    return Shells(
        np.stack([density(height) for density in densities]),
        np.stack([_log_columns(density) for density in densities]),
    )


def _log_columns(density: Density) -> Array:
    height = TOP_M * np.linspace(0.0, 1.0, _ROWS)[:, None] ** 2
    q = np.linspace(0.0, 1.0, _COLUMNS)[None, :]
    horizon = horizon_rad(height)
    share = np.expm1(ALTITUDE_CURVE * q) / np.expm1(ALTITUDE_CURVE)
    altitude = horizon + (0.5 * np.pi - horizon) * share
    sine = np.sin(np.maximum(altitude, horizon + 1e-9))
    up = _rising(density, np.broadcast_to(height, sine.shape), np.abs(sine))
    # A ray that descends passes its lowest point: the whole level path through it, less the part
    # behind the start.
    radius = EARTH_RADIUS_M + height
    lowest = np.maximum(height - 2.0 * radius * np.sin(0.5 * np.arcsin(sine)) ** 2, 0.0)
    through = 2.0 * _rising(density, lowest, np.zeros_like(lowest))
    column = np.where(sine >= 0.0, up, through - up)
    return floats(np.log(np.maximum(column, 1e-12)))


_GAUSS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(24)
_PARTS = 5


def _rising(density: Density, height_m: Array, sine: Array) -> Array:
    """Columns of rays that do not descend, from heights up to where the air ends."""
    radius = EARTH_RADIUS_M + height_m
    top = EARTH_RADIUS_M + TOP_M
    rise = top**2 - radius**2
    length = rise / (radius * sine + np.sqrt(np.maximum((radius * sine) ** 2 + rise, 0.0)) + 1e-9)
    total = np.zeros_like(height_m)
    for part in range(_PARTS):
        for x, weight in zip(_GAUSS, _GAUSS_WEIGHTS, strict=True):
            u = (part + 0.5 * (x + 1.0)) / _PARTS
            s = length * u * u  # dense near the start, where the air is
            gain = 2.0 * radius * sine * s + s * s
            gained = gain / (np.sqrt(radius**2 + gain) + radius)
            total += 0.5 * weight / _PARTS * 2.0 * u * length * density(height_m + gained)
    return total
