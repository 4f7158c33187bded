"""What of suns and their bows can be seen: above the horizon, within the picture, in rain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.physics.drop.medium import Medium
from rtbow.physics.geometry import box_span, direction
from rtbow.scene.lights import SunLight
from rtbow.scene.model import Scene
from rtbow.world.camera.resolve import view_of
from rtbow.world.rain.box import box_of

NAMES = {1: "primary", 2: "secondary"}
"""Bows by internal reflections."""
_CIRCLE = 720
"""Points of a bow that are looked at, half a degree apart."""
_SEEN_NM = (400.0, 700.0)
"""Ends of the spectrum whose light the eye sees well enough to give a bow its edges."""


@dataclass(frozen=True)
class Hidden:
    """A sun, or a bow, that is wholly below the horizon.

    Attributes:
        light: number of the sun among the lights.
        sun_deg: its altitude.
        bow: internal reflections of the bow; 0 for the sun itself.
        bow_deg: radius of the bow's outer edge about the antisolar point; 0 for the sun itself.
        below_deg: how far below the horizon the bow's top is, or the sun's centre.
    """

    light: int
    sun_deg: float
    bow: int
    bow_deg: float
    below_deg: float

    def __str__(self) -> str:
        place = f"light.{self.light}: the sun stands at {self.sun_deg:.1f} degrees"
        if not self.bow:
            return f"{place}, below the horizon: it lights no rain near the ground"
        return (
            f"{place}, more than the {self.bow_deg:.1f} of the {NAMES[self.bow]} bow, which lies"
            f" wholly below the horizon, its top by {self.below_deg:.1f} degrees"
        )


def outer_edge_deg(medium: Medium, reflections: int) -> float:
    """Give the radius of a bow's outer edge about the antisolar point, degrees.

    It is the red edge of the primary and the violet one of the secondary bow.
    """
    return max(medium.bow_radius_deg(reflections, nm) for nm in _SEEN_NM)


def hidden(scene: Scene) -> Iterator[Hidden]:
    """Give the scene's suns that are below the horizon, and the bows of others that are."""
    scattering = scene.scattering
    orders = _bows(scene)
    for number, light in enumerate(scene.light):
        if not isinstance(light, SunLight):
            continue
        altitude = light.altitude_deg
        if altitude < -0.5 * light.angular_diameter_deg:
            yield Hidden(number, altitude, 0, 0.0, -altitude)
            continue
        for bow in orders:
            radius = outer_edge_deg(scattering.medium, bow)
            if altitude > radius:
                yield Hidden(number, altitude, bow, radius, altitude - radius)


def _bows(scene: Scene) -> tuple[int, ...]:
    return tuple(NAMES) if scene.scattering.theory == "mie" else scene.scattering.orders


def horizon_notes(scene: Scene) -> tuple[str, ...]:
    """Say which suns and bows of a scene are wholly below the horizon; without repetition."""
    parts = [part for part, _ in scene.parts()]
    return tuple(dict.fromkeys(str(found) for part in parts for found in hidden(part)))


def sun_notes(scene: Scene) -> tuple[str, ...]:
    """Say where the first sun that is placed by time stands, and whether its bow is in the picture.

    The bow is that of the fewest reflections; where sun or bow are below the horizon, nothing is
    said of it here (see :func:`horizon_notes`).
    """
    light = next((x for x in scene.light if isinstance(x, SunLight) and x.time is not None), None)
    if light is None:
        return ()
    altitude, azimuth = light.altitude_deg, light.azimuth_deg
    note = (
        f"the sun at {light.time}, latitude {light.latitude_deg:g}, longitude"
        f" {light.longitude_deg:g}: altitude {altitude:.2f}, azimuth {azimuth:.2f} degrees"
    )
    if altitude < 0.0:
        return (note,)
    radius = scene.scattering.medium.bow_radius_deg(_bows(scene)[0])
    bow = _circle(-direction(azimuth, altitude), np.radians(radius))
    bow = bow[bow[:, 2] > 0.0]
    if not len(bow):
        return (note,)
    camera, centre_deg = scene.camera, (azimuth + 180.0) % 360.0
    seen = bow[view_of(camera).shows(bow)]
    if not len(seen):
        return note, (
            f"the bow is outside the picture: its centre is at azimuth {centre_deg:.1f}, altitude"
            f" {-altitude:.1f} degrees, and the camera looks at azimuth {camera.azimuth_deg:.1f},"
            f" altitude {camera.altitude_deg:.1f}; --set camera.look=bow-top turns it there"
        )
    box = box_of(scene.droplets)
    if box is not None and not _cross(floats(camera.position_m), seen, box).any():
        return note, (
            f"there is no rain where the bow would be, about azimuth {centre_deg:.1f} degrees;"
            " --set droplets.around_m=[1000,800] puts rain all around the camera"
        )
    return (note,)


def _circle(axis: Array, radius_rad: float) -> Array:
    """Give unit vectors (n, 3) at an angle from an axis (3,)."""
    aside = np.eye(3)[np.argmin(np.abs(axis))]
    across = np.cross(axis, aside)
    across /= np.linalg.norm(across)
    turn = np.linspace(0.0, 2.0 * np.pi, _CIRCLE, endpoint=False)[:, None]
    around = np.cos(turn) * across + np.sin(turn) * np.cross(axis, across)
    return floats(np.cos(radius_rad) * axis + np.sin(radius_rad) * around)


def _cross(eye_m: Array, rays: Array, box_m: Array) -> NDArray[np.bool_]:
    """Give which rays (n, 3) go through a box."""
    entry, leave = box_span(eye_m, rays, box_m)
    return np.asarray(entry < leave)
