"""A perspective camera: rays through places of a picture plane; float64."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.geometry import angle_between, direction
from rtbow.scene.model import Camera
from rtbow.world.camera.view import CONE_MARGIN, View


@dataclass(frozen=True, kw_only=True)
class Perspective(View):
    """What a perspective camera sees of the world (:class:`rtbow.world.camera.view.View`).

    The vectors of ``basis`` lead to the picture plane at distance 1: to the middle of the picture,
    and over half its extent to the right and up. Without a shift of the lens the first is the axis.
    A filter is one before the lens: ``polarizer`` is the direction (3,) of the field that it
    passes. ``fov_deg`` is that of the lens without its shift.

    Attributes:
        axis: unit vector along the lens's axis (3,), across the picture plane.
    """

    axis: Array

    @property
    def pixel_rad(self) -> float:
        """Width of a pixel on the picture plane at distance 1; they are square."""
        return float(2.0 * np.linalg.norm(self.basis[1]) / self.size_px[0])

    @property
    def mean_pixel_squared(self) -> float:
        """Mean of the squared extents of the pixels nearest to the axis and farthest from it."""
        least, most = self.off_axis
        return 0.5 * self.pixel_rad**2 * (math.cos(least) ** 4 + math.cos(most) ** 4)

    @cached_property
    def cone(self) -> tuple[Array, float]:
        """The cone that holds the picture, through its corners: axis (3,) and half angle, rad."""
        middle, right, up = self.basis
        if not self.shifted:
            return middle, float(np.arctan(np.hypot(np.linalg.norm(right), np.linalg.norm(up))))
        towards = middle / np.linalg.norm(middle)
        return towards, float(np.arccos(np.clip(self._corners @ towards, -1.0, 1.0)).max())

    @property
    def shifted(self) -> bool:
        """Whether the lens is shifted, so that its axis is not in the middle of the picture."""
        return not np.array_equal(self.basis[0], self.axis)

    @property
    def _corners(self) -> Array:
        """Unit vectors towards the corners (4, 3)."""
        width, height = self.size_px
        across, down = floats([0.0, width, 0.0, width]), floats([0.0, 0.0, height, height])
        return self.rays_through(across, down)[0]

    @cached_property
    def off_axis(self) -> tuple[float, float]:
        """Least and greatest angle of a ray of the picture from the lens's axis, rad."""
        if not self.shifted:
            return 0.0, self.cone[1]
        middle, right, up = self.basis
        offset = middle - self.axis
        # Of the picture plane's point nearest to the axis, in half extents from the middle.
        nearest = offset + sum(
            np.clip(-(offset @ side) / (side @ side), -1.0, 1.0) * side for side in (right, up)
        )
        farthest = np.arccos(np.clip(self._corners @ self.axis, -1.0, 1.0)).max()
        return float(np.arctan(np.linalg.norm(nearest))), float(farthest)

    @property
    def fields_deg(self) -> tuple[float, float]:
        """Horizontal and vertical field of view: angles between the middles of opposite sides."""
        width, height = self.size_px
        across = floats([0.0, width, 0.5 * width, 0.5 * width])
        left, right, top, bottom = self.rays_through(
            across, floats([0.5 * height, 0.5 * height, 0.0, height])
        )[0]
        angles = np.degrees(angle_between(np.stack([left, top]), np.stack([right, bottom])))
        return float(angles[0]), float(angles[1])

    def shows_no_more_than(self, other: View) -> bool:
        """Whether this is another view in another size: it has no angle that tables for it lack."""
        if not (isinstance(other, Perspective) and self.is_alike(other)):
            return False
        same = np.array_equal(self.axis, other.axis) and np.array_equal(
            self.basis[1], other.basis[1]
        )
        beyond = self.cone[1] - other.cone[1]
        if not np.array_equal(self.basis[0], other.basis[0]):  # the other's shift
            beyond += float(angle_between(self.cone[0], other.cone[0]))
        # Half of the margin is left to float32.
        return same and bool(beyond <= 0.5 * CONE_MARGIN)

    def pixel_directions(self, rows: slice = slice(None)) -> Array:
        """Give unit directions (h, w, 3) through the pixel centres, first row on top.

        Args:
            rows: which rows; all by default.
        """
        width, height = self.size_px
        forward, right, up = self.basis
        x = (np.arange(width) + 0.5) / width * 2.0 - 1.0
        y = 1.0 - (np.arange(height)[rows] + 0.5) / height * 2.0
        rays = forward + x[None, :, None] * right + y[:, None, None] * up
        return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

    def rays_through(self, columns: Array, rows: Array) -> tuple[Array, Array]:
        """Give rays through places in the picture, and how much solid angle lies about each.

        Args:
            columns: places in pixels from the left edge (n,); centres lie at halves.
            rows: places from the upper edge (n,).

        Returns:
            Unit directions (n, 3), and solid angle per area of the picture plane at distance 1
            (n,): the cube of the cosine of the angle from the axis.
        """
        width, height = self.size_px
        forward, right, up = self.basis
        x, y = columns / width * 2.0 - 1.0, 1.0 - rows / height * 2.0
        rays = forward + x[:, None] * right + y[:, None] * up
        length = np.linalg.norm(rays, axis=1)
        return floats(rays / length[:, None]), floats(length**-3.0)

    def places_of(self, vectors: Array) -> tuple[Array, Array]:
        """Give where vectors from the eye (n, 3), of any length, meet the picture plane.

        Returns:
            Columns and rows (n,) as for :meth:`rays_through`; NaN behind the plane.
        """
        depth, x, y = np.linalg.solve(self.basis.T, vectors.T)
        depth = np.where(depth > 0.0, depth, np.nan)
        width, height = self.size_px
        return (x / depth + 1.0) * 0.5 * width, (1.0 - y / depth) * 0.5 * height

    def ray_extents(self, rays: Array) -> Array:
        """Give by how much each component of pixels' rays changes from one side to the other.

        Args:
            rays: through the pixels' centres (n, 3).

        Returns:
            (n, 3): the root of the sum of squares over both sides.
        """
        _, right, up = self.basis
        size = np.array(self.size_px, dtype=float)
        squares = sum(
            ((axis - (rays @ axis)[:, None] * rays) / count) ** 2
            for axis, count in zip((right, up), size, strict=True)
        )
        return floats(2.0 * (rays @ self.axis)[:, None] * np.sqrt(squares))

    def block_extents(self, rays: Array, block: int) -> tuple[Array, Array]:
        """Bound the rays of blocks of pixels (:meth:`View.block_extents`)."""
        pixel = self.ray_extents(rays)
        return pixel, (block + 2) * pixel

    def passed_field(self, rays: Array) -> Array:
        """Give the field that the filter passes along its own direction, as far as that is across
        rays (n, 3), of any length (n, 3)."""
        assert self.polarizer is not None
        return floats(self.polarizer - (rays @ self.polarizer)[:, None] * rays)

    # --- The same camera otherwise

    def turned(self, azimuth_deg: float, altitude_deg: float) -> Perspective:
        """Give the view of the camera turned so that its middle has another direction."""
        old, new = _axes(*self.looking_deg), _axes(azimuth_deg, altitude_deg)
        return replace(self, basis=self.basis @ old.T @ new, axis=self.axis @ old.T @ new)

    def widened(self, fov_deg: float) -> Perspective:
        """Give the view with another horizontal field of view, degrees, whole angle."""
        forward, right, up = self.basis
        scale = np.tan(0.5 * np.radians(fov_deg)) / np.linalg.norm(right)
        return replace(self, basis=np.stack([forward, scale * right, scale * up]), fov_deg=fov_deg)


def perspective(camera: Camera) -> Perspective:
    """Resolve a scene's camera."""
    basis = camera_basis(camera)
    axis = basis[0].copy()
    if any(camera.lens_shift):
        basis[0] += 2.0 * (floats(camera.lens_shift) @ basis[1:])
    polarizer = camera.polarizer_deg
    return Perspective(
        eye_m=np.array(camera.position_m),
        basis=basis,
        size_px=camera.size_px,
        polarizer=None if polarizer is None else _polarizer(basis, polarizer),
        area=camera.pixel == "area",
        axis=axis,
        fov_deg=camera.fov_deg,
    )


def camera_basis(camera: Camera) -> Array:
    """Give the camera's axes, scaled to the picture plane at distance 1.

    Returns:
        (3, 3): forward, along the lens's axis; right (scaled by half the picture's width), up (by
        half its height).
    """
    azimuth = np.radians(camera.azimuth_deg)
    forward = direction(camera.azimuth_deg, camera.altitude_deg)
    right = np.array([np.cos(azimuth), -np.sin(azimuth), 0.0])
    up = np.cross(right, forward)
    if camera.roll_deg:
        roll = np.radians(camera.roll_deg)
        right, up = (
            np.cos(roll) * right - np.sin(roll) * up,
            np.cos(roll) * up + np.sin(roll) * right,
        )
    width, height = camera.size_px
    half = np.tan(0.5 * np.radians(camera.fov_deg))
    return np.stack([forward, right * half, up * (half * height / width)])


def _axes(azimuth_deg: float, altitude_deg: float) -> Array:
    """Give unit vectors forward, right and up (3, 3) of a camera without roll."""
    return camera_basis(
        Camera(azimuth_deg=azimuth_deg, altitude_deg=altitude_deg, fov_deg=90.0, size_px=(1, 1))
    )


def _polarizer(basis: Array, polarizer_deg: float) -> Array:
    """Direction (3,) that a filter passes, counterclockwise from the picture's own horizontal."""
    _, right, up = basis
    angle = np.radians(polarizer_deg)
    across, along = right / np.linalg.norm(right), up / np.linalg.norm(up)
    return floats(np.cos(angle) * across + np.sin(angle) * along)
