"""The drops as method ``fast`` sees them: where there are any, and how rough they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.air import rayleigh
from rtbow.physics.air.earth_shadow import edge_height_m, place_over_sphere
from rtbow.physics.air.rayleigh import Column
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.drop.airy import RADIUS_POWER
from rtbow.render.fast.tolerance import ROUGH, Kind
from rtbow.world.lights import Lamp, Sun
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import roughness

DARK_COLUMN = 75.0
"""Hardly any light is left behind this column: twice the way to a sun at the horizon."""


def filled_box(volume: DropletVolume) -> Array:
    """Give the part of the box that has drops (2, 3), without extent where there are none."""
    if volume.uniform:
        return volume.box_m
    box = volume.filled_box_m
    return np.stack([volume.box_m[0]] * 2) if box is None else box


def kind_of(volume: DropletVolume) -> Kind:
    """Classify a volume by how its radii vary."""
    least, most = volume.radius_range_um
    if volume.uniform or least == most:
        return "alike"
    return "rough" if roughness(volume) > ROUGH else "smooth"


def light_range_um(volume: DropletVolume, share: float) -> tuple[float, float]:
    """Give the radii, µm, beyond each of which drops have no more than a share of the light."""
    filled = volume.number_per_m3 > 0.0
    log = np.log(volume.radius_um[filled].astype(np.float64))
    order = np.argsort(log)
    light = np.cumsum(volume.number_per_m3[filled][order] * np.exp(RADIUS_POWER * log[order]))
    low, high = np.interp([share, 1.0 - share], light / light[-1], log[order])
    return float(np.exp(low)), float(np.exp(high))


def light_shares(volume: DropletVolume, rows: Array) -> Array:
    """Give the share of the light of a volume's drops that counts at each row of radius.

    Args:
        volume: the drops.
        rows: logarithms of radii in metres (R,), even, two or more.

    Returns:
        (R,), 1 in sum.
    """
    filled = volume.number_per_m3 > 0.0
    log = np.log(volume.radius_um[filled].astype(np.float64) * 1e-6)
    light = volume.number_per_m3[filled] * np.exp(RADIUS_POWER * (log - rows[-1]))
    place = np.clip((log - rows[0]) / (rows[1] - rows[0]), 0.0, len(rows) - 1.0)
    lower = np.minimum(place.astype(np.int64), len(rows) - 2)
    upper_share = place - lower
    row_light = np.bincount(lower, light * (1.0 - upper_share), len(rows))
    row_light += np.bincount(lower + 1, light * upper_share, len(rows))
    return floats(row_light / row_light.sum())


def radius_spread(volume: DropletVolume) -> float:
    """Give how much radii differ along a ray: the deviation of ln(radius) along the grid's lines,
    weighted by the light of their drops, of the median line."""
    if volume.uniform or volume.radius_range_um[0] == volume.radius_range_um[1]:
        return 0.0
    filled = volume.number_per_m3 > 0.0
    log = np.log(np.where(filled, volume.radius_um, np.float32(1.0)))
    weight = np.where(filled, volume.number_per_m3 * np.exp(np.float32(RADIUS_POWER) * log), 0.0)
    widest = 0.0
    for axis in range(3):
        total = weight.sum(axis=axis, dtype=np.float64)
        safe = np.maximum(total, 1e-300)
        mean = (weight * log).sum(axis=axis, dtype=np.float64) / safe
        square = (weight * log * log).sum(axis=axis, dtype=np.float64) / safe
        deviation = np.sqrt(np.maximum(square - mean**2, 0.0)).ravel()
        lit = total.ravel() > 1e-3 * total.max()
        widest = max(widest, float(np.median(deviation[lit])))
    return widest


@dataclass(frozen=True)
class SunColumns:
    """The air between a sun, the drops and the eye.

    Attributes:
        column: range over all drops.
        cubic: column towards the sun as a cubic in the height (4,), constant first; None where no
            cubic follows it, for a sun at the horizon.
    """

    column: Column
    cubic: Array | None

    def seen(self, box_m: Array, eye_m: Array) -> SunColumns:
        """Add the way from the drops in a box (2, 3) to an eye (3,) to columns towards a sun."""
        high = min(self.column.high + eye_column(box_m, eye_m), DARK_COLUMN)
        return SunColumns(Column(self.column.low, high), self.cubic)


_CUBIC_ERROR = 2e-3
"""A cubic may miss the column by this much, which is 1e-3 of the light at 380 nm."""


def sun_columns(sun: Sun, box_m: Array, eye_m: Array) -> SunColumns:
    """Give the columns of light from a sun to the eye by way of the drops in a box.

    Args:
        sun: the sun.
        box_m: where the drops are (2, 3).
        eye_m: the eye (3,).
    """
    return sunward_columns(sun, box_m).seen(box_m, eye_m)


_PLACES = 9
"""Places along each side of a box at which the columns over a sphere are looked at."""


def shaded_columns(sun: Sun, box_m: Array, eye_m: Array) -> SunColumns:
    """Give the columns of light from a sun that the Earth keeps from a part of a box (2, 3)."""
    sides = [np.linspace(box_m[0, axis], box_m[1, axis], _PLACES) for axis in range(3)]
    places = np.stack(np.meshgrid(*sides), axis=-1)
    height, altitude = place_over_sphere(places, eye_m, sun.direction)
    # Of each plumb line, the place that light reaches along the ground has the greatest column.
    edge = np.where(altitude < 0.0, edge_height_m(altitude), 0.0)
    height = np.concatenate([height, edge])
    altitude = np.concatenate([altitude, np.maximum(altitude, rayleigh.horizon_rad(edge) + 1e-9)])
    towards = rayleigh.sun_column(height, altitude)
    inside = (height <= box_m[1, 2] + 1.0) & (towards < DARK_COLUMN)
    if not np.any(inside):
        return SunColumns(Column(DARK_COLUMN - 1.0, DARK_COLUMN), None)
    return SunColumns(Column(float(towards[inside].min()), float(towards[inside].max())), None)


def sunward_columns(sun: Sun, box_m: Array) -> SunColumns:
    """Give the columns of light from a sun to the drops in a box (2, 3)."""
    heights = np.linspace(max(box_m[0, 2], 0.0), max(box_m[1, 2], 1.0), 33)
    towards = rayleigh.sun_column(heights, sun.altitude_rad)
    seen = towards[towards < DARK_COLUMN]
    if len(seen) == 0:
        return SunColumns(Column(DARK_COLUMN - 1.0, DARK_COLUMN), None)
    column = Column(float(seen.min()), float(seen.max()))
    if len(seen) < len(towards):
        return SunColumns(column, None)
    cubic = np.polynomial.polynomial.Polynomial.fit(heights, towards, 3)
    if np.abs(cubic(heights) - towards).max() > _CUBIC_ERROR or box_m[0, 2] < 0.0:
        return SunColumns(column, None)
    coefficients = cubic.convert().coef
    padded = np.zeros(4)
    padded[: len(coefficients)] = coefficients
    return SunColumns(column, padded)


_NEAR_RISE = 0.6
"""The series of a segment's column holds within 1e-4 up to this rise, in scale heights."""
_NEAR_DEPTH = 0.3
"""The series of its attenuation holds within 1e-4 up to this grey depth."""


def is_near(box_m: Array, eye_m: Array, column: Column, grey: float) -> bool:
    """Whether short series suffice for the air: with drops not far above or below the eye."""
    rise = float(np.abs(box_m[:, 2] - eye_m[2]).max()) / SCALE_HEIGHT_M
    return rise < _NEAR_RISE and column.reach * grey < _NEAR_DEPTH


def eye_column(box_m: Array, eye_m: Array) -> float:
    """Give the greatest column between the eye and a corner of a box."""
    corners = floats([[box_m[i, 0], box_m[j, 1], box_m[k, 2]] for i in (0, 1) for j in (0, 1)
                      for k in (0, 1)])  # fmt: skip
    return _greatest_column(eye_m, corners)


def lamp_column(lamp: Lamp, box_m: Array, eye_m: Array) -> Column:
    """Give the columns of light from a lamp to the eye by way of the drops in a box."""
    return Column(0.0, eye_column(box_m, eye_m) + eye_column(box_m, lamp.position_m))


def _greatest_column(start_m: Array, ends_m: Array) -> float:
    away = ends_m - start_m
    length = np.linalg.norm(away, axis=1)
    rise = away[:, 2] / np.maximum(length, 1e-9)
    with np.errstate(over="ignore"):  # far below the ground
        columns = rayleigh.segment_column(start_m[2], rise, length)
    return min(float(columns.max()), DARK_COLUMN)


def greatest_depth(volume: DropletVolume, greatest_per_m: float) -> float:
    """Bound the depth of rain on any way through the box and out again."""
    return 2.0 * greatest_per_m * float(np.linalg.norm(volume.box_m[1] - volume.box_m[0]))
