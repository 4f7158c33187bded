"""Strips: pictures one pixel high across the bows, whose radiance has a closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

import rtbow
from rtbow.base.arrays import Array, floats
from rtbow.physics.geometry import box_span
from rtbow.reference.render import radiance_along
from rtbow.scene.model import Scene
from rtbow.tables.layout import radius_axis, row_sections
from rtbow.tables.sections import Sections
from rtbow.world.optics import scene_optics
from rtbow.world.rain.volume import build_volume
from rtbow.world.world import resolve

_DEPTH_M = 100.0
_ALTITUDE_DEG = 10.0
"""Of the sun; the rays go down as steeply, so that one meets the antisolar point."""
DISC_RAD = float(np.radians(0.5 * 0.533))


def strip_angles() -> Array:
    """Give the scattering angles of a strip's pixels (451,), rad."""
    return floats(np.radians(np.linspace(90.0, 180.0, 451)))


def strip_scene(overrides: dict[str, Any]) -> Scene:
    """Load the scene ``uniform`` as a layer without end, seen from its upper side."""
    layer = {
        "camera.position_m": [0.0, 0.0, _DEPTH_M],
        "light.0.altitude_deg": _ALTITUDE_DEG,
        "droplets.box_m": [[-1e5, -1e5, 0.0], [1e5, 1e5, _DEPTH_M]],
    }
    return rtbow.load_scene("uniform", {**layer, **overrides})


def strip_rays(theta: Array) -> Array:
    """Give the rays (n, 3) that see drops at scattering angles (n,)."""
    # All descend alike; the azimuth from the sun follows from the law of cosines.
    sine, cosine = np.sin(np.radians(_ALTITUDE_DEG)), np.cos(np.radians(_ALTITUDE_DEG))
    turn = np.arccos(np.clip((np.cos(theta) + sine**2) / cosine**2, -1.0, 1.0))
    # The sun is in the south.
    east, north = np.sin(turn), -np.cos(turn)
    return np.stack([cosine * east, cosine * north, np.full_like(theta, -sine)], axis=1)


def reference_strip(scene: Scene, theta: Array) -> Array:
    """Render a strip by the method ``reference``: X, Y, Z (n, 3)."""
    return radiance_along(resolve(scene), strip_rays(theta))


def table_strip(
    scene: Scene, theta: Array, sections: Sections | None = None, passed: Array | None = None
) -> Array:
    """Render a strip from cross-sections: their product with drops per area and the light.

    Args:
        scene: a strip's scene, with one radius or one mixture.
        theta: scattering angles (n,).
        sections: at the scene's wavelengths; left out: the tables', in float64.
        passed: share of the light that arrives at each wavelength (W,); left out: all.

    Returns:
        X, Y, Z (n, 3).
    """
    per_area = drops_per_area(scene, strip_rays(theta))
    return per_area[:, None] * drop_xyz(scene, theta, sections, passed)


def drops_per_area(scene: Scene, rays: Array) -> Array:
    """Give the drops in sight per area, m⁻², along rays (n, 3) through a uniform volume, (n,)."""
    volume = build_volume(scene.droplets)
    entry, leave = box_span(np.array(scene.camera.position_m), rays, volume.box_m)
    return floats(float(volume.number_per_m3.flat[0]) * np.maximum(leave - entry, 0.0))


def drop_xyz(
    scene: Scene, theta: Array, sections: Sections | None = None, passed: Array | None = None
) -> Array:
    """Give X, Y, Z (n, 3) per drop and area, with arguments as :func:`table_strip`."""
    optics, volume = scene_optics(scene), build_volume(scene.droplets)
    sections = sections or scene_sections(scene)
    rows = radius_axis(volume.radius_range_um, volume.sizes)
    both = row_sections(sections, rows, theta, optics.suns[0].disc_rad)
    mean = rows.radius_m[0] ** 2 * both[0].mean(axis=-1)
    colour = optics.sun_weights[0]
    if passed is not None:
        colour = colour * passed[:, None]
    return floats(mean.T @ colour)


def scene_sections(scene: Scene) -> Sections:
    """Give the tables' cross-sections at a scene's wavelengths, for either theory."""
    return resolve(scene).sections()
