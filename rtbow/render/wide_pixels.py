"""Pixels that are means over more than what a shader follows within one: drawn in parts.

Across a pixel the shaders take the scattering angle to change evenly and the length of rain to be
that of a few rays. Where pixels are too wide for that, the picture is drawn with several times as
many, of which each is the mean, weighted by their solid angles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, floats, no_progress
from rtbow.base.errors import UnsuitedError
from rtbow.world.camera.panorama import Panorama
from rtbow.world.camera.view import View
from rtbow.world.world import World

if TYPE_CHECKING:
    from rtbow.gl.program import FrameTarget
    from rtbow.render.method import Method, ShaderMethod

WIDEST_RAD = 0.046
"""The widest pixel on the picture plane at distance 1 that is drawn as a whole; its mean is within
1.6 (CIEDE2000) of that of 16 x 16 parts, and those of all but one in a hundred within 0.5."""
WIDEST_OF_PANORAMA_RAD = 0.0125
"""The same of a panorama, whose pixels are as wide all along the horizon, and at the poles are
triangles."""
_MOST_PIXELS = 1 << 24
"""More parts than this, of all pixels, are left to the reference."""


def parts_of(view: View) -> int:
    """Give into how many parts a pixel is cut along each side; 1 where it is drawn as a whole.

    Raises:
        UnsuitedError: the picture has more parts than a shader draws.
    """
    if not view.area:
        return 1
    widest = WIDEST_OF_PANORAMA_RAD if isinstance(view, Panorama) else WIDEST_RAD
    parts = math.ceil(view.pixel_rad / widest)
    width, height = view.size_px
    if parts > 1 and parts * parts * width * height > _MOST_PIXELS:
        raise UnsuitedError(
            f"camera.pixel: pixels as areas that are {math.degrees(view.pixel_rad):.3g} degrees"
            f" wide would take {parts} x {parts} parts each; use a smaller camera.fov_deg, more"
            " pixels, or --method reference"
        )
    return parts


def in_parts(world: World) -> World:
    """Give a world whose picture has the parts as its pixels, itself where these are whole.

    Raises:
        UnsuitedError: see :func:`parts_of`.
    """
    parts = parts_of(world.view)
    if parts == 1:
        return world
    width, height = world.view.size_px
    return replace(world, view=replace(world.view, size_px=(parts * width, parts * height)))


def whole(method: Method, world: World) -> Method:
    """Give a method whose pixels are a world's, from one that draws ``in_parts(world)``."""
    return _InParts(method, world) if world.view.area else method


def unwrapped(method: Method) -> Method:
    """Give the method that draws the parts, without the rain's glow; itself where pixels are drawn
    as a whole."""
    method = method._method if isinstance(method, _InParts) else method
    return getattr(method, "beneath", method)


class _InParts:
    """A method that draws pixels in parts (:class:`rtbow.render.method.Method`).

    Args:
        method: which draws the parts; it was made for ``in_parts(world)``.
        world: whose picture is wanted.
    """

    def __init__(self, method: Method, world: World) -> None:
        self._method, self._view = method, world.view

    @property
    def name(self) -> ShaderMethod:
        """What the command line calls the method."""
        return self._method.name

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        return self._method.texture_bytes

    def move(self, world: World) -> bool:
        """Take over another world (see :class:`rtbow.render.method.Method`)."""
        moved = self._method.move(in_parts(world))
        if moved:
            self._view = world.view
        return moved

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take."""
        self._method.prepare_moves()

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame's parts and wait until they are done."""
        parts = parts_of(self._view)
        return self._method.draw(_rows_of(progress, parts), self._part_columns(columns, parts))

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        parts = parts_of(self._view)
        if parts == 1:
            return self._method.render(progress, columns)
        of_parts = self._part_columns(columns, parts)
        drawn = self._method.render(_rows_of(progress, parts), of_parts)
        return _means(self._view, drawn, of_parts.start, parts)

    def _part_columns(self, columns: slice, parts: int) -> slice:
        left, right, _ = columns.indices(self._view.size_px[0])
        return slice(parts * left, parts * right)


def _means(view: View, drawn: Float32, left: int, parts: int) -> Float32:
    """Average parts over pixels, weighted by their solid angles.

    Args:
        view: the picture.
        drawn: its parts (parts · h, parts · w, 3).
        left: the first column that they fill.
        parts: along each side of a pixel.
    """
    height, width = (n // parts for n in drawn.shape[:2])
    across = (left + np.arange(drawn.shape[1]) + 0.5) / parts
    means = np.empty((height, width, 3), dtype=np.float32)
    for row in range(height):
        down = row + (np.arange(parts) + 0.5) / parts
        x, y = np.meshgrid(across, down)
        solid = _grouped(view.rays_through(x.ravel(), y.ravel())[1], parts, width, 1)
        light = _grouped(floats(drawn[row * parts : (row + 1) * parts]), parts, width, 3)
        means[row] = (solid * light).sum(axis=(0, 2)) / solid.sum(axis=(0, 2))
    return means


def _grouped(values: Array, parts: int, width: int, channels: int) -> Array:
    """Sort a row of pixels' parts by pixel: (parts, width, parts, channels)."""
    return values.reshape(parts, width, parts, channels)


def _rows_of(progress: Progress, parts: int) -> Progress:
    """Let a wrapper of the loop over a picture's rows see each when all of its parts are done."""

    def over_parts(rows: Iterable[int]) -> Iterator[int]:
        each = list(rows)
        pixels = iter(progress(range(len(each) // parts)))
        for number, row in enumerate(each):
            if number % parts == 0:
                next(pixels, None)
            yield row
        next(pixels, None)  # lets the wrapper finish its line

    return over_parts
