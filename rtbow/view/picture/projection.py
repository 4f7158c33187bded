"""Where directions and points lie in the picture, and curves of them as lines on the screen.

Pixels are counted from the upper left corner of what is shown, to the right and down, so that
(0.5, 0.5) is the middle of the first one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.scene.model import Camera, Scene
from rtbow.world.camera.perspective import camera_basis

_TOLERANCE_PX = 0.25
"""How far a chord may be from its curve, half-way along."""
_PIECES = 64
"""Chords of a curve before any is halved."""
_MOST_HALVINGS = 24
_NEAR = 1e-9
"""Nearest depth of a line, over its greatest distance: what reaches the eye has no picture."""

Lines = list[Array]
"""Lines of a picture: pixels (n, 2) each, n at least 2."""


@dataclass(frozen=True)
class View:
    """A camera's picture, of the size in which it is shown.

    Attributes:
        camera: its whole picture fills the view, stretched where that has another shape.
        size_px: width and height on the screen.
        columns: where in the view this camera's picture is seen, from left to right, in pixels;
            None for all of it. The two parts of a split picture share the view.
    """

    camera: Camera
    size_px: tuple[int, int]
    columns: tuple[float, float] | None = None

    @cached_property
    def eye_m(self) -> Array:
        """Where the eye is (3,)."""
        return floats(self.camera.position_m)

    @cached_property
    def area(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of what is seen, in pixels."""
        left, right = self.columns or (0.0, float(self.size_px[0]))
        return left, 0.0, right, float(self.size_px[1])

    @cached_property
    def _matrix(self) -> Array:
        """From vectors to homogeneous pixels: (3, 3), rows x, y and depth."""
        forward, right, up = camera_basis(self.camera)
        width, height = self.size_px
        across, upwards = right / (right @ right), up / (up @ up)
        shift_right, shift_up = self.camera.lens_shift
        return np.stack(
            [
                0.5 * width * ((1.0 - 2.0 * shift_right) * forward + across),
                0.5 * height * ((1.0 + 2.0 * shift_up) * forward - upwards),
                forward,
            ]
        )

    @cached_property
    def _inverse(self) -> Array:
        return floats(np.linalg.inv(self._matrix))

    @cached_property
    def _sides(self) -> Array:
        """Inward normals (4, 3) of the planes through the eye and the sides of what is seen."""
        left, top, right, bottom = self.area
        x, y, depth = self._matrix
        normals = np.stack(
            [x - left * depth, right * depth - x, y - top * depth, bottom * depth - y]
        )
        return floats(normals / np.linalg.norm(normals, axis=1, keepdims=True))

    @cached_property
    def _least_depth(self) -> float:
        """Depth of the unit vectors towards the corners, the least of any that is seen."""
        left, top, right, bottom = self.area
        corners = floats([[x, y] for x in (left, right) for y in (top, bottom)])
        return float((self.directions(corners) @ self._matrix[2]).min())

    def directions(self, pixels: Array) -> Array:
        """Give unit vectors (..., 3) through points of the picture (..., 2)."""
        pixels = floats(pixels)
        rays = pixels @ self._inverse[:, :2].T + self._inverse[:, 2]
        return floats(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

    def pixels(self, vectors: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Give where vectors from the eye lie in the picture.

        Args:
            vectors: of any length (..., 3).

        Returns:
            Pixels (..., 2), NaN behind the picture plane, and whether they are seen (...).
        """
        x, y, depth = np.moveaxis(floats(vectors) @ self._matrix.T, -1, 0)
        safe = np.where(depth > 0.0, depth, np.nan)
        pixels = np.stack([x / safe, y / safe], axis=-1)
        left, top, right, bottom = self.area
        # NaN is nowhere.
        seen = (pixels[..., 0] >= left) & (pixels[..., 0] <= right)
        seen &= (pixels[..., 1] >= top) & (pixels[..., 1] <= bottom)
        return pixels, seen

    def chain(self, points_m: Array) -> Lines:
        """Give the straight lines between points (n, 3), in the scene's metres, as they are seen.

        They are cut at the picture's sides and just before the eye, so that what passes by it
        leaves the picture where it does.
        """
        return self._clipped(floats(points_m) - self.eye_m)

    def curve(self, path: Callable[[Array], Array], start: float, end: float) -> Lines:
        """Give a curve on the sphere of directions as it is seen.

        Args:
            path: takes places along the curve (n,) and gives unit vectors (n, 3); it turns evenly
                enough that a 64th of it has no bend of its own.
            start: first place.
            end: last place.

        Returns:
            Lines cut at the picture's sides, their chords within half a pixel of the curve.
        """
        places = np.linspace(start, end, _PIECES + 1)
        vectors = path(places)
        for _ in range(_MOST_HALVINGS):
            halves = 0.5 * (places[:-1] + places[1:])
            between = path(halves)
            coarse = np.flatnonzero(self._coarse(vectors[:-1], between, vectors[1:]))
            if not coarse.size:
                break
            places = np.insert(places, coarse + 1, halves[coarse])
            vectors = np.insert(vectors, coarse + 1, between[coarse], axis=0)
        return self._clipped(vectors)

    def circle(self, axis: Array, radius_rad: float) -> Lines:
        """Give a circle about a direction as it is seen.

        Args:
            axis: unit vector to its centre (3,).
            radius_rad: angle from there; pi/2 is a great circle.
        """
        # It starts where it is farthest from the middle of the picture.
        away = _across(axis, -self._matrix[2])
        side = np.cross(axis, away)

        def path(turn: Array) -> Array:
            about = np.cos(turn)[:, None] * away + np.sin(turn)[:, None] * side
            return floats(np.cos(radius_rad) * axis + np.sin(radius_rad) * about)

        lines = self.curve(path, 0.0, 2.0 * np.pi)
        # Where even that is seen, what ends there goes on.
        if len(lines) > 1 and np.allclose(lines[0][0], lines[-1][-1], rtol=0.0, atol=1e-6):
            lines[0] = np.concatenate([lines.pop()[:-1], lines[0]])
        return lines

    def _coarse(self, start: Array, middle: Array, end: Array) -> NDArray[np.bool_]:
        """Tell which pieces of a curve (n, 3) are to be halved."""
        # A piece is not farther from its chord than twice what its middle is.
        bulge = 2.0 * np.linalg.norm(middle - 0.5 * (start + end), axis=1)
        outside = np.maximum(start @ self._sides.T, end @ self._sides.T) < -bulge[:, None]
        seen = ~outside.any(axis=1)
        depths = np.stack([start, middle, end]) @ self._matrix[2]
        front = depths.min(axis=0) > 0.25 * self._least_depth
        # What reaches behind the picture is halved until it is outside.
        measured, coarse = seen & front, seen & ~front
        a, m, b = (self.pixels(v[measured])[0] for v in (start, middle, end))
        chord = b - a
        share = np.sum((m - a) * chord, axis=1) / np.maximum(np.sum(chord**2, axis=1), 1e-300)
        foot = a + np.clip(share, 0.0, 1.0)[:, None] * chord
        coarse[measured] = np.linalg.norm(m - foot, axis=1) > _TOLERANCE_PX
        return np.asarray(coarse)

    def _clipped(self, vectors: Array) -> Lines:
        """Give the chords between vectors from the eye (n, 3), cut at the picture's sides."""
        if len(vectors) < 2:
            return []
        near = _NEAR * np.abs(vectors).max()
        inside = np.column_stack([vectors @ self._sides.T, vectors @ self._matrix[2] - near])
        first, last = inside[:-1], inside[1:]
        # Where each chord crosses each plane; shares of the chord.
        change = np.where(first == last, 1.0, last - first)
        crossing = -first / change
        start = np.where(first < 0.0, crossing, 0.0).max(axis=1)
        end = np.where(last < 0.0, crossing, 1.0).min(axis=1)
        beyond = np.any((first < 0.0) & (last < 0.0), axis=1)
        kept = np.flatnonzero(~beyond & (start < end))
        if not kept.size:
            return []
        begin, chord = vectors[:-1][kept], np.diff(vectors, axis=0)[kept]
        starts = self.pixels(begin + start[kept, None] * chord)[0]
        ends = self.pixels(begin + end[kept, None] * chord)[0]
        joined = (np.diff(kept) == 1) & (start[kept[1:]] == 0.0)
        runs = np.split(np.arange(len(kept)), np.flatnonzero(~joined) + 1)
        return [floats(np.concatenate([starts[run], ends[run[-1:]]])) for run in runs]


def _across(axis: Array, towards: Array) -> Array:
    """Give the unit vector (3,) across an axis that leans most towards a direction."""
    across = towards - (towards @ axis) * axis
    length = np.linalg.norm(across)
    if length < 1e-9:
        return _across(axis, np.eye(3)[np.argmin(np.abs(axis))])
    return floats(across / length)


def whole_size(area: tuple[float, float, float, float]) -> tuple[int, int]:
    """Give the width and height, the last two numbers of an area, in whole units."""
    return round(area[2]), round(area[3])


def part_views(scene: Scene, size_px: tuple[int, int]) -> tuple[tuple[Scene, View], ...]:
    """Give the scenes that share a picture, each with its view.

    Args:
        scene: the scene.
        size_px: width and height in which its picture is shown.

    Raises:
        InputError: a ``compare`` without the scene of its right part.
    """
    per_column = size_px[0] / scene.camera.size_px[0]
    return tuple(
        (part, View(part.camera, size_px, (columns.start * per_column, columns.stop * per_column)))
        for part, columns in scene.parts()
    )


def part_at(
    scene: Scene, size_px: tuple[int, int], pixel: tuple[float, float]
) -> tuple[Scene, View]:
    """Give the scene that is seen at a point of the picture, with its view; as above."""
    parts = part_views(scene, size_px)
    for part, view in parts[:-1]:
        if pixel[0] < view.area[2]:
            return part, view
    return parts[-1]


def azimuth_altitude_deg(vector: Array) -> tuple[float, float]:
    """Give azimuth (-180..180, clockwise from north) and altitude of a vector (3,), degrees."""
    east, north, up = (float(x) for x in vector)
    altitude = np.degrees(np.arctan2(up, np.hypot(east, north)))
    return float(np.degrees(np.arctan2(east, north))), float(altitude)
