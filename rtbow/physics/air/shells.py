"""Constituents of the air in spherical shells: where each is, and its columns towards a sun."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Mask, Values, floats
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import (
    ALTITUDE_CURVE,
    column_axes,
    horizon_rad,
    log_columns,
)
from rtbow.physics.constants import EARTH_RADIUS_M, SCALE_HEIGHT_M

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

    @property
    def below(self) -> Array:
        """Shares of the vertical columns below the heights of ``density`` (C, N)."""
        layers = 0.5 * (self.density[:, 1:] + self.density[:, :-1]) * _STEP_M
        return np.concatenate([np.zeros((len(layers), 1)), np.cumsum(layers, axis=1)], axis=1)

    def amounts(self, first_m: Array, last_m: Array, length_m: Array) -> Array:
        """Give shares of the vertical columns along pieces of rays, in one more axis in front (C,
        ...): layers that end within a piece count as far as they reach.

        Args:
            first_m: heights of the pieces' ends, m.
            last_m: of their other ends.
            length_m: their lengths.
        """
        low, high = np.minimum(first_m, last_m), np.maximum(first_m, last_m)
        high = np.maximum(high, low + LEAST_RISE_M)
        return floats((self._below(high) - self._below(low)) / (high - low) * length_m)

    def _below(self, height_m: Array) -> Array:
        """Shares of the vertical columns below heights."""
        last = self.density.shape[1] - 1
        place = np.clip(height_m / TOP_M, 0.0, 1.0) * last
        n = np.minimum(place.astype(np.int64), last - 1)
        within = column_within(place - n, self.density[:, n], self.density[:, n + 1])
        return floats(self.below[:, n] + within)

    def column_at(self, height_m: Array, clearance_rad: Array) -> Array:
        """Interpolate columns towards a sun, in one more axis in front (C, ...).

        Args:
            height_m: heights, m.
            clearance_rad: of the sun above the horizon there, rad; below it as at it.
        """
        rows, columns = self.log_column.shape[1:]
        height = np.minimum(height_m, TOP_M)
        y, x = column_place(height, np.maximum(clearance_rad, 0.0), horizon_rad(height))
        y, x = y * (rows - 1), x * (columns - 1)
        i, j = np.minimum(y.astype(np.int64), rows - 2), np.minimum(x.astype(np.int64), columns - 2)
        v, u, table = y - i, x - j, self.log_column
        low = (1.0 - u) * table[:, i, j] + u * table[:, i, j + 1]
        high = (1.0 - u) * table[:, i + 1, j] + u * table[:, i + 1, j + 1]
        return floats(np.exp((1.0 - v) * low + v * high))


LEAST_RISE_M = 1.0
"""Of a piece of a ray, as far as its density is concerned: differences of columns keep their
digits."""


def column_within(share: Values, low: Values, high: Values) -> Any:
    """Integrate a density from a height at which it is kept, where it is ``low``, over a share of
    the way to the next one, where it is ``high``."""
    return _STEP_M * share * (low + 0.5 * share * (high - low))


def column_place(height_m: Values, clearance_rad: Values, horizon_rad: Values) -> tuple[Any, Any]:
    """Give where heights and altitudes above the horizon lie in ``Shells.log_column``: shares of
    its rows and of its columns."""
    share = np.minimum(clearance_rad / (0.5 * np.pi - horizon_rad), 1.0)
    place = np.log1p(share * np.expm1(ALTITUDE_CURVE)) / ALTITUDE_CURVE
    return np.sqrt(height_m / TOP_M), place


def ground_distance(height_m: Values, sine: Values) -> Any:
    """Give the distance at which falling rays from heights meet the ground, m; at the tangent where
    they would miss it.

    Args:
        height_m: where the rays start, m.
        sine: of their altitudes, below 0.
    """
    r = EARTH_RADIUS_M + height_m
    # Of the root's argument what the ground's sphere leaves: (r sine)² - (r² - R²).
    over = height_m * (r + EARTH_RADIUS_M)
    return over / (-r * sine + np.sqrt(np.maximum((r * sine) ** 2 - over, 0.0)))


def top_distance(height_m: Values, sine: Values) -> Any:
    """Give the distance at which rays from heights leave the air, m, were there no ground."""
    r = EARTH_RADIUS_M + height_m
    rise = (TOP_M - height_m) * (r + EARTH_RADIUS_M + TOP_M)
    return -r * sine + np.sqrt((r * sine) ** 2 + rise)


def ray_ends(height_m: float, sine: Array) -> tuple[Array, Mask]:
    """Give the distances at which rays from a height end, m, and whether they do on the ground."""
    height = floats(height_m)
    meets = (sine < 0.0) & (sine <= np.sin(horizon_rad(height)))
    falling = np.where(meets, sine, -1.0)
    end = np.where(meets, ground_distance(height, falling), top_distance(height, sine))
    return floats(end), meets


SHELL_HEIGHTS_M = np.arange(0.0, TOP_M + 0.5 * _STEP_M, _STEP_M)


def molecular_shells() -> Shells:
    """Give air of molecules alone."""
    density = np.exp(-SHELL_HEIGHTS_M / SCALE_HEIGHT_M) / SCALE_HEIGHT_M
    return Shells(density[None], log_columns(TOP_M, _ROWS, _COLUMNS)[None])


def with_constituent(shells: Shells, density: Array) -> Shells:
    """Add a constituent, last.

    Args:
        shells: the others.
        density: shares of its column at ``SHELL_HEIGHTS_M`` (N,), 1/m.
    """
    column = np.log(np.maximum(_columns(density), _LEAST_COLUMN))
    return Shells(
        np.concatenate([shells.density, density[None]]),
        np.concatenate([shells.log_column, column[None]]),
    )


_LEAST_COLUMN = 1e-12
"""Above a layer there is nothing of it, whose logarithm is none."""


def _columns(density: Array) -> Array:
    """Columns of a constituent towards a sun, laid out as the molecules' (rows, columns): shells of
    even density are summed, within 1e-3 for layers of a kilometre."""
    height, altitude = column_axes(TOP_M, _ROWS, _COLUMNS)
    middle = 0.5 * (density[1:] + density[:-1])
    edges = EARTH_RADIUS_M + SHELL_HEIGHTS_M
    layer = np.flatnonzero(middle)  # a layer's own shells suffice
    if len(layer):
        middle = middle[layer[0] : layer[-1] + 1]
        edges = edges[layer[0] : layer[-1] + 2]
    found = np.empty(altitude.shape)
    for row, (start, angle) in enumerate(zip(EARTH_RADIUS_M + height[:, 0], altitude, strict=True)):
        nearest = start * np.cos(angle)[:, None]

        def along(r: Array, nearest: Array = nearest) -> Array:
            """Distance from the ray's nearest place to the centre."""
            return np.sqrt(np.maximum((r - nearest) * (r + nearest), 0.0))

        rising = np.diff(along(np.maximum(edges, start)), axis=1) @ middle
        whole = np.diff(along(edges[None, :]), axis=1) @ middle
        found[row] = np.where(angle >= 0.0, rising, 2.0 * whole - rising)
    return found
