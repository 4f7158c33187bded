"""Rays of a perspective camera and their way through a box, float64."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import NO_PLANE
from rtbow.physics.geometry import direction
from rtbow.scene.model import Camera


def camera_basis(camera: Camera) -> Array:
    """Give the camera's axes, scaled to the picture plane at distance 1.

    Returns:
        (3, 3): forward, right (scaled by half the picture's width), up (by half its height).
    """
    azimuth = np.radians(camera.azimuth_deg)
    forward = direction(camera.azimuth_deg, camera.altitude_deg)
    right = np.array([np.cos(azimuth), -np.sin(azimuth), 0.0])
    up = np.cross(right, forward)
    width, height = camera.size_px
    half = np.tan(0.5 * np.radians(camera.fov_deg))
    return np.stack([forward, right * half, up * (half * height / width)])


def picture_cone(camera: Camera) -> tuple[Array, float]:
    """Give the cone that holds the picture, through its corners: axis (3,) and half angle, rad."""
    axis, right, up = camera_basis(camera)
    return axis, float(np.arctan(np.hypot(np.linalg.norm(right), np.linalg.norm(up))))


def pixel_directions(camera: Camera, rows: slice = slice(None)) -> Array:
    """Give unit directions through the pixel centres, first row on top.

    Args:
        camera: the camera.
        rows: which rows; all by default.

    Returns:
        (h, w, 3).
    """
    width, height = camera.size_px
    forward, right, up = camera_basis(camera)
    x = (np.arange(width) + 0.5) / width * 2.0 - 1.0
    y = 1.0 - (np.arange(height)[rows] + 0.5) / height * 2.0
    rays = forward + x[None, :, None] * right + y[:, None, None] * up
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))


def polarizer_pass(camera: Camera) -> Array:
    """Give the direction (3,) of the field that the camera's polarising filter lets pass.

    ``polarizer_deg`` turns it from the picture's horizontal, counterclockwise as the eye sees it.
    """
    _, right, up = camera_basis(camera)
    angle = np.radians(camera.polarizer_deg or 0.0)
    across, along = right / np.linalg.norm(right), up / np.linalg.norm(up)
    return floats(np.cos(angle) * across + np.sin(angle) * along)


def perpendicular_share(camera: Camera, towards_light: Array, rays: Array) -> Array:
    """Give the share of the component perpendicular to the scattering plane in what is seen.

    Args:
        camera: with or without a polarising filter.
        towards_light: from the eye to the light (3,), any length.
        rays: unit directions of view (n, 3).

    Returns:
        (n,): cos² of the angle between that component's field and the one that the filter lets
        pass; one half without a filter.
    """
    if camera.polarizer_deg is None:
        return np.full(len(rays), 0.5)
    passing = polarizer_pass(camera)
    # A filter passes the field along its own direction, as far as that is across the ray.
    field = passing - (rays @ passing)[:, None] * rays
    normal = np.cross(towards_light, rays)
    passed = np.sum(field**2, axis=1)
    whole = np.sum(normal**2, axis=1) * passed
    # On the line through the light there is no plane, and the mean over all of them is one half.
    blur = NO_PLANE * np.sum(towards_light**2) * passed
    along = np.sum(normal * field, axis=1)
    return floats(0.5 + (along**2 - 0.5 * whole) / np.maximum(whole + blur, 1e-30))
