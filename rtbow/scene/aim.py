"""Where a camera looks and where rain is, for scenes that say it by what is to be seen.

A scene may say ``camera.look = "antisolar"`` instead of two angles, and ``droplets.around_m``
instead of two corners; the angles and corners that follow are worked out here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rtbow.base.limits import MAX_COORDINATE_M
from rtbow.scene.lights import PointLight, SunLight
from rtbow.scene.table import refused

Vector = tuple[float, float, float]
Corners = tuple[Vector, Vector]

LOOKED_AT = ("azimuth_deg", "altitude_deg")
"""The keys of a camera that follow from where it looks, where it says so by a name."""
_DIGITS = 6
"""Decimals of angles in degrees, as those of suns by time have."""


def look_deg(
    look: str,
    lights: Sequence[SunLight | PointLight],
    eye_m: Vector,
    bow_deg: float,
    box_m: Corners | None,
) -> tuple[float, float]:
    """Give the azimuth and altitude in degrees at which a camera looks.

    Of several suns or lamps the first counts. With lamps alone, ``antisolar`` is the direction
    away from the lamp, about which its bow lies as a sun's does about the antisolar point, and
    ``bow-top`` is where the upper edge of that bow is seen. A lamp's bow is not a circle: a drop
    at the distance r from the eye shows it at the angle g from the direction away from the lamp,
    where drop, eye and lamp make a triangle with the bow's radius B at the drop, so that with the
    lamp at the distance d,

        sin(g - B) = r sin(B) / d.

    Every direction farther out than B meets such a drop somewhere, so the bow's edge is made by
    the nearest ones, and r is the distance of the eye from the drops' box: 0 inside it (g = B, as
    for a sun), and 0 as well for a volume file, whose box is not read here. A box too far from the
    lamp for any bow (r sin B > d) counts as if it were at the farthest distance that has one.

    Args:
        look: ``antisolar``, ``sun``, ``bow-top`` or ``lamp``.
        lights: the scene's.
        eye_m: where the camera is. In the middle of a lamp it looks north, and level.
        bow_deg: radius of the bow about the antisolar point.
        box_m: lower and upper corner of the drops' box, or None if it is not known.

    Returns:
        Azimuth within 0..360, clockwise from north, and altitude within -90..90.

    Raises:
        PydanticCustomError: there is no such light.
    """
    sun = next((light for light in lights if isinstance(light, SunLight)), None)
    lamp = next((light for light in lights if isinstance(light, PointLight)), None)
    if look == "lamp" and lamp is None:
        raise refused('the scene has no lamp; write "sun", "antisolar" or "bow-top"')
    if look == "sun" and sun is None:
        raise refused('the scene has no sun; write "lamp", "antisolar" or "bow-top"')
    rise_deg = bow_deg
    if sun is not None and look != "lamp":
        azimuth_deg, altitude_deg = sun.azimuth_deg, sun.altitude_deg
    else:
        assert lamp is not None  # a scene has a light
        way = [at - eye for at, eye in zip(lamp.position_m, eye_m, strict=True)]
        azimuth_deg = math.degrees(math.atan2(way[0], way[1]))
        altitude_deg = math.degrees(math.atan2(way[2], math.hypot(way[0], way[1])))
        rise_deg = _lamp_bow_deg(bow_deg, math.hypot(*way), _distance_m(eye_m, box_m))
    if look in ("antisolar", "bow-top"):
        azimuth_deg, altitude_deg = azimuth_deg + 180.0, -altitude_deg
    if look == "bow-top":
        altitude_deg += rise_deg
    if altitude_deg > 90.0:  # beyond the zenith, where a low antisolar point has none: -90 is least
        azimuth_deg, altitude_deg = azimuth_deg + 180.0, 180.0 - altitude_deg
    return round(azimuth_deg % 360.0, _DIGITS) % 360.0, round(altitude_deg, _DIGITS)


def _lamp_bow_deg(bow_deg: float, lamp_m: float, drop_m: float) -> float:
    """Give the angle between a lamp's bow in drops at a distance and the way from the lamp."""
    share = drop_m * math.sin(math.radians(bow_deg)) / lamp_m if lamp_m > 0.0 else 0.0
    return bow_deg + math.degrees(math.asin(min(share, 1.0)))


def _distance_m(eye_m: Vector, box_m: Corners | None) -> float:
    """Give the distance from the eye to a box; 0 within it, and without one."""
    if box_m is None:
        return 0.0
    return math.hypot(
        *(max(low - at, at - high, 0.0) for at, low, high in zip(eye_m, *box_m, strict=True))
    )


def box_around(eye_m: Vector, around_m: tuple[float, float], ground_m: float = 0.0) -> Corners:
    """Give the corners of a box of rain that surrounds the eye.

    Its sides run along the axes of the scene, whichever way the camera looks. It ends at the
    greatest coordinates that a scene may have.

    Args:
        eye_m: where the camera is: east, north, up.
        around_m: how far the rain reaches from the eye to the east, west, north and south, and how
            high it goes above the eye. Its floor is the ground, or the eye where that is lower.
        ground_m: height of the ground.
    """
    reach, height = around_m
    east, north, up = eye_m
    low = (east - reach, north - reach, min(up, ground_m))
    high = (east + reach, north + reach, up + height)
    most = MAX_COORDINATE_M
    return (
        (max(low[0], -most), max(low[1], -most), max(low[2], -most)),
        (min(high[0], most), min(high[1], most), min(high[2], most)),
    )
