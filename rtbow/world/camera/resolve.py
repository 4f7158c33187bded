"""The view of a scene's camera, of whatever projection."""

from __future__ import annotations

from rtbow.base.arrays import Array
from rtbow.scene.model import Camera
from rtbow.world.camera.panorama import panorama
from rtbow.world.camera.perspective import perspective
from rtbow.world.camera.view import View


def view_of(camera: Camera) -> View:
    """Resolve a scene's camera."""
    return panorama(camera) if camera.whole_sphere else perspective(camera)


def pixel_directions(camera: Camera, rows: slice = slice(None)) -> Array:
    """Give unit directions (h, w, 3) through a camera's pixel centres, first row on top."""
    return view_of(camera).pixel_directions(rows)
