"""Moving the camera: each function gives another camera, within a scene's limits."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.geometry import direction
from rtbow.scene import lens
from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.lights import SunLight
from rtbow.scene.model import Camera, Scene
from rtbow.scene.table import Coordinate
from rtbow.scene.text.schema import Node
from rtbow.view.picture.projection import View, azimuth_altitude_deg
from rtbow.world.camera.perspective import camera_basis

ZOOM_PER_CLICK = 1.1
"""Magnification by one click of the wheel, in the middle of the picture."""
FOV_DEG = (1.0, 150.0)
"""Range of fields of view that the wheel reaches; a scene's own may be beyond it."""
_REACH_M = float(next(x.le for x in Node.of(Coordinate).metadata if hasattr(x, "le")))
"""Greatest distance of a scene's coordinates from the origin."""

Point = tuple[float, float]
"""A place in the picture: pixels from its left and upper side."""


def hold(camera: Camera, towards: Array, at_px: Point, view_px: tuple[int, int]) -> Camera:
    """Turn the camera so that a direction is seen at a point of the picture.

    The picture's sides stay upright: where that leaves no such turn, the camera comes as near to it
    as it can, or looks straight up or down.

    Args:
        camera: the camera.
        towards: unit vector (3,).
        at_px: where it is to be seen.
        view_px: the view's width and height.
    """
    # The ray through the pixel of a camera that looks north: right, ahead and up of its picture.
    level = camera.model_copy(update={"azimuth_deg": 0.0, "altitude_deg": 0.0})
    right, ahead, up = View(level, view_px).directions(floats(at_px))
    # Tilted by an altitude it rises to ahead sin + up cos, a sine of altitude + lean.
    size, lean = np.hypot(ahead, up), np.arctan2(up, ahead)
    rise = np.arcsin(np.clip(towards[2] / size, -1.0, 1.0))
    both = np.degrees([rise - lean, np.pi - rise - lean])
    tilts = (both + 180.0) % 360.0 - 180.0
    # The nearer of the two, so that nothing flips; upside down is not reached, the pole is.
    nearer = tilts[np.argmin(np.abs(tilts - camera.altitude_deg))]
    altitude_deg = float(np.clip(nearer, -90.0, 90.0))
    altitude = np.radians(altitude_deg)
    flat = ahead * np.cos(altitude) - up * np.sin(altitude)
    azimuth_deg = camera.azimuth_deg
    if np.hypot(towards[0], towards[1]) > 1e-12 and np.hypot(flat, right) > 1e-12:
        turn = np.arctan2(towards[0], towards[1]) - np.arctan2(right, flat)
        azimuth_deg = float(np.degrees(turn))
    return _turned(camera, azimuth_deg, altitude_deg)


def fly(
    camera: Camera, right: float, ahead: float, up: float, seconds: float, speed_m_s: float
) -> Camera:
    """Move the camera for a while.

    Args:
        camera: the camera.
        right: share of the speed along the picture's right, -1..1.
        ahead: share along the direction of view.
        up: share straight up; all three together are no faster than one.
        seconds: how long.
        speed_m_s: how fast.
    """
    forward, across, _ = camera_basis(camera)
    way = right * across / np.linalg.norm(across) + ahead * forward + up * np.array([0.0, 0.0, 1.0])
    way = way / max(1.0, float(np.linalg.norm(way)))
    position = np.clip(camera.position_m + way * (seconds * speed_m_s), -_REACH_M, _REACH_M)
    return camera.model_copy(update={"position_m": tuple(float(x) for x in position)})


def zoom(
    camera: Camera,
    clicks: float,
    view_px: tuple[int, int] | None = None,
    at_px: Point | None = None,
) -> Camera:
    """Change the field of view as the mouse's wheel does.

    Args:
        camera: the camera.
        clicks: of the wheel; each enlarges by ``ZOOM_PER_CLICK``, negative ones make smaller.
        view_px: the view's width and height, if what is under the cursor is to stay there.
        at_px: where the cursor is.
    """
    half = np.tan(np.radians(0.5 * camera.fov_deg)) / ZOOM_PER_CLICK**clicks
    # A scene's own field of view may be beyond the wheel's: it is never made more so.
    low, high = min(FOV_DEG[0], camera.fov_deg), max(FOV_DEG[1], camera.fov_deg)
    fov_deg = float(np.clip(np.degrees(2.0 * np.arctan(half)), low, high))
    zoomed = camera.model_copy(update=lens.zoomed(camera, fov_deg))
    if view_px is None or at_px is None:
        return zoomed
    under = View(camera, view_px).directions(floats(at_px))
    return hold(zoomed, under, at_px, view_px)


def towards(camera: Camera, vector: Array) -> Camera:
    """Turn the camera so that a direction (3,), of any length, is in the middle of the picture."""
    if any(camera.lens_shift):  # the lens's axis is elsewhere
        width, height = camera.size_px
        unit = floats(vector / np.linalg.norm(vector))
        return hold(camera, unit, (0.5 * width, 0.5 * height), camera.size_px)
    azimuth_deg, altitude_deg = azimuth_altitude_deg(vector)
    if abs(altitude_deg) > 90.0 - 1e-9:  # straight up and down there is no azimuth
        azimuth_deg = camera.azimuth_deg
    return _turned(camera, azimuth_deg, altitude_deg)


def antisolar(scene: Scene) -> Array:
    """Give the unit vector (3,) away from the first sun; without one, away from the first lamp.

    About it a sun's bows are circles. For an eye in the middle of a lamp, it is where the camera
    looks.
    """
    for light in scene.light:
        if isinstance(light, SunLight):
            return -direction(light.azimuth_deg, light.altitude_deg)
    camera = scene.camera
    away = floats(camera.position_m) - scene.light[0].position_m  # type: ignore[union-attr]
    distance = np.linalg.norm(away)
    if distance == 0.0:
        return direction(camera.azimuth_deg, camera.altitude_deg)
    return floats(away / distance)


def cruise_m_s(scene: Scene, box_m: Array) -> float:
    """Give a speed that suits a scene's size, m/s.

    A quarter of the way to the rain in a second, and through it in about eight.

    Args:
        scene: the scene, whose eye counts.
        box_m: the rain's lower and upper corner (2, 3).
    """
    eye = floats(scene.camera.position_m)
    distance = np.linalg.norm(np.clip(eye, box_m[0], box_m[1]) - eye)
    extent = np.exp(np.mean(np.log(box_m[1] - box_m[0])))
    return float(0.25 * distance + extent / 8.0)


def _turned(camera: Camera, azimuth_deg: float, altitude_deg: float) -> Camera:
    """Give the camera that looks elsewhere, by angles; azimuths are kept within -180..180."""
    angles = (azimuth_deg + 180.0) % 360.0 - 180.0, float(np.clip(altitude_deg, -90, 90))
    return camera.model_copy(update={**dict(zip(LOOKED_AT, angles, strict=True)), "look": None})
