"""The Earth's shadow in the air: half a cylinder behind a spherical Earth, along straight rays.

The sphere touches sea level below the eye, where the sun has the altitude that a scene gives it:
places elsewhere see it higher or lower, by an angle of their distance over the Earth's radius. With
``q`` from the Earth's centre to a place and ``s`` the unit vector towards the sun, a place is dark
where ``q·s < 0`` and its distance from the axis, |q - (q·s) s|, is less than the radius. That is a
convex body, so that any straight line is dark over one stretch at most.
"""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Values, floats
from rtbow.physics.constants import EARTH_RADIUS_M


def edge_height_m(altitude_rad: Values) -> Array:
    """Give the height up to which the shadow reaches where the sun has an altitude below 0, m."""
    # R (1/cos - 1) without its loss of digits near the horizon.
    return floats(2.0 * EARTH_RADIUS_M * np.sin(0.5 * altitude_rad) ** 2 / np.cos(altitude_rad))


def place_over_sphere(points_m: Array, eye_m: Array, towards: Array) -> tuple[Array, Array]:
    """Give the heights of places above the sphere, and the sun's altitude there.

    Args:
        points_m: places (..., 3): east, north, up, m.
        eye_m: the eye (3,), m, below which the sphere touches sea level.
        towards: unit vector (3,) towards the sun, as seen from there.

    Returns:
        Heights in m and altitudes in rad, each (...).
    """
    height = _excess(points_m, eye_m)[1]
    sine = _sunward(points_m, eye_m, towards) / (EARTH_RADIUS_M + height)
    return height, floats(np.arcsin(np.clip(sine, -1.0, 1.0)))


def shadow_span(
    points_m: Array, directions: Array, eye_m: Array, towards: Array
) -> tuple[Array, Array]:
    """Give where straight lines are in the Earth's shadow.

    The square of the distance from the axis less the radius's, over twice the radius, is a height
    in metres, of which large numbers are no part: a t² + b t + c along a line.

    Args:
        points_m: places that the lines pass (..., 3), m.
        directions: their unit directions (..., 3).
        eye_m: the eye (3,), m, below which the sphere touches sea level.
        towards: unit vector (3,) towards the sun, as seen from there.

    Returns:
        Distances from the places at which the shadow begins and ends, each (...), infinite where it
        has no end; the beginning is no less than the end where a line stays out of it.
    """
    radius = EARTH_RADIUS_M
    c, outward, sunward = cylinder(points_m, eye_m, towards)
    along = directions @ towards
    a = np.sum(np.cross(directions, towards) ** 2, axis=-1) / (2.0 * radius)
    b = np.sum(outward * directions, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
        # The sum of like signs keeps its digits; the other root follows from the product of both.
        half = -0.5 * (b + np.where(b < 0.0, -root, root))
        first, second = half / a, c / half
        # Beside the cylinder's axis a line is within the cylinder or without, all of it.
        parallel = (a == 0.0) & (b == 0.0)
        begin = np.where(parallel, -np.inf, np.minimum(first, second))
        end = np.where(parallel, np.inf, np.maximum(first, second))
        crossing = -sunward / along
    begin = np.where((along < 0.0) & (crossing > begin), crossing, begin)
    end = np.where((along > 0.0) & (crossing < end), crossing, end)
    clear = np.where(parallel, c >= 0.0, root == 0.0) | ((along == 0.0) & (sunward >= 0.0))
    return np.where(clear, np.inf, begin), np.where(clear, np.inf, end)


def shadow_reaches(box_m: Array, eye_m: Array, towards: Array) -> bool:
    """Whether any part of a box (2, 3) is in the Earth's shadow.

    Args:
        box_m: lower and upper corner (2, 3), m.
        eye_m: the eye (3,), m, below which the sphere touches sea level.
        towards: unit vector (3,) towards the sun, as seen from there.
    """
    # The lowest places are the darkest, and of these the ones on the rim: the height over the
    # shadow's edge has no least value but where the sun is in the zenith.
    low, high = box_m
    corners = np.array([low, [high[0], low[1], low[2]], [high[0], high[1], low[2]],
                        [low[0], high[1], low[2]]])  # fmt: skip
    along = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    lengths = (high - low)[[0, 1, 0, 1]]
    begin, end = shadow_span(corners, along, eye_m, towards)
    return bool(np.any((begin < end) & (begin < lengths) & (end > 0.0)))


def _from_foot(points_m: Array, eye_m: Array) -> Array:
    """Places (..., 3) relative to where the sphere touches sea level, m."""
    return floats(points_m - np.array([eye_m[0], eye_m[1], 0.0]))


def cylinder(points_m: Array, eye_m: Array, towards: Array) -> tuple[Array, Array, Array]:
    """Give how places lie in the cylinder of which the Earth's shadow is the half without the sun.

    Args:
        points_m: the places (..., 3), m.
        eye_m: below which the ground is level (3,), m.
        towards: unit direction towards the sun (3,).

    Returns:
        The square of the distance from the axis less the radius's, over twice the radius (...), m,
        below 0 inside; its gradient (..., 3); and how far the places lie towards the sun from the
        Earth's centre (...), m.
    """
    sunward = _sunward(points_m, eye_m, towards)
    clear = _excess(points_m, eye_m)[0] - sunward**2 / (2.0 * EARTH_RADIUS_M)
    across = _from_foot(points_m, eye_m) - sunward[..., None] * towards
    return clear, across / EARTH_RADIUS_M + np.array([0.0, 0.0, 1.0]), sunward


def _sunward(points_m: Array, eye_m: Array, towards: Array) -> Array:
    """Give how far places (...) lie towards the sun from the Earth's centre, m."""
    return floats(_from_foot(points_m, eye_m) @ towards + EARTH_RADIUS_M * towards[2])


def _excess(points_m: Array, eye_m: Array) -> tuple[Array, Array]:
    """Give (q² - R²) / 2R and |q| - R of places (...), m, without subtracting large numbers."""
    offset = _from_foot(points_m, eye_m)
    excess = offset[..., 2] + np.sum(offset**2, axis=-1) / (2.0 * EARTH_RADIUS_M)
    return excess, 2.0 * excess / (1.0 + np.sqrt(1.0 + 2.0 * excess / EARTH_RADIUS_M))
