"""What a perspective camera sees: its axes, its rays, what a filter before it passes; float64."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import NO_PLANE
from rtbow.physics.geometry import angle_between, direction
from rtbow.scene.model import Camera

CONE_MARGIN = 2e-3
"""Tables reach this many radians beyond a picture's corners: for float32, and for the same view in
another size, whose sides are rounded to whole pixels."""


@dataclass(frozen=True)
class View:
    """What a camera sees of the world.

    Attributes:
        eye_m: where it is (3,): east, north, up.
        basis: the middle of the picture, right and up (3, 3) on the picture plane at distance 1;
            the latter two are half its extent. Without a shift of the lens the first is the axis.
        axis: unit vector along the lens's axis (3,), across the picture plane.
        size_px: width and height of the picture.
        fov_deg: horizontal field of view, whole angle, of the lens without its shift.
        polarizer: direction (3,) of the field that a polarising filter lets pass; None without one.
        area: whether a pixel is the mean over its solid angle, not the light through its centre.
    """

    eye_m: Array
    basis: Array
    axis: Array
    size_px: tuple[int, int]
    fov_deg: float
    polarizer: Array | None
    area: bool = False

    @property
    def pixel_deg(self) -> float:
        """Mean extent of a pixel, degrees."""
        return self.fov_deg / self.size_px[0]

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

    def angles_from(self, direction: Array) -> tuple[float, float]:
        """Give the least and greatest angle from a direction (3,) to any ray of the picture, rad.

        The range reaches ``CONE_MARGIN`` beyond the picture.
        """
        axis, cone = self.cone
        cone += CONE_MARGIN
        middle = float(np.arccos(np.clip(direction @ axis, -1.0, 1.0)))
        return max(middle - cone, 0.0), min(middle + cone, np.pi)

    def shows_no_more_than(self, other: View) -> bool:
        """Whether this is another view in another size: it has no angle that tables for it lack."""
        same = (
            np.array_equal(self.eye_m, other.eye_m)
            and np.array_equal(self.axis, other.axis)
            and np.array_equal(self.basis[1], other.basis[1])
            and _equal_or_none(self.polarizer, other.polarizer)
            and self.area == other.area
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

    @property
    def plane_pixel(self) -> float:
        """Width of a pixel on the picture plane at distance 1; they are square."""
        return float(2.0 * np.linalg.norm(self.basis[1]) / self.size_px[0])

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

    def probes(self, rays: Array) -> Array:
        """Give what of light's coherency tensor passes the filter, all without one.

        Args:
            rays: unit directions of view (n, 3).

        Returns:
            (n, 3, 3): the light that is seen is the trace of the product of both.
        """
        if self.polarizer is None:
            return np.broadcast_to(np.eye(3), (len(rays), 3, 3))
        field = self.polarizer - (rays @ self.polarizer)[:, None] * rays
        length = np.sum(field**2, axis=1)[:, None, None]
        return floats(field[:, :, None] * field[:, None, :] / np.maximum(length, 1e-30))

    def perpendicular_share(self, towards_light: Array, rays: Array) -> Array:
        """Give the share of the component perpendicular to the scattering plane in what is seen.

        Args:
            towards_light: from the eye to the light (3,), any length.
            rays: unit directions of view (n, 3).

        Returns:
            (n,): cos² of the angle between that component's field and the one that the filter lets
            pass; one half without a filter.
        """
        if self.polarizer is None:
            return np.full(len(rays), 0.5)
        # A filter passes the field along its own direction, as far as that is across the ray.
        field = self.polarizer - (rays @ self.polarizer)[:, None] * rays
        normal = np.cross(towards_light, rays)
        passed = np.sum(field**2, axis=1)
        whole = np.sum(normal**2, axis=1) * passed
        # On the line through the light there is no plane; the mean over all of them is one half.
        blur = NO_PLANE * np.sum(towards_light**2) * passed
        along = np.sum(normal * field, axis=1)
        return floats(0.5 + (along**2 - 0.5 * whole) / np.maximum(whole + blur, 1e-30))


def _equal_or_none(a: Array | None, b: Array | None) -> bool:
    return (a is None and b is None) or (a is not None and b is not None and np.array_equal(a, b))


def view_of(camera: Camera) -> View:
    """Resolve a scene's camera."""
    basis = camera_basis(camera)
    axis = basis[0].copy()
    if any(camera.lens_shift):
        basis[0] += 2.0 * (floats(camera.lens_shift) @ basis[1:])
    return View(
        np.array(camera.position_m), basis, axis, camera.size_px, camera.fov_deg,
        None if camera.polarizer_deg is None else _polarizer(basis, camera.polarizer_deg),
        camera.pixel == "area",
    )  # fmt: skip


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


def pixel_directions(camera: Camera, rows: slice = slice(None)) -> Array:
    """Give unit directions (h, w, 3) through a camera's pixel centres, first row on top."""
    return view_of(camera).pixel_directions(rows)


def _polarizer(basis: Array, polarizer_deg: float) -> Array:
    """Direction (3,) that a filter passes, counterclockwise from the picture's own horizontal."""
    _, right, up = basis
    angle = np.radians(polarizer_deg)
    across, along = right / np.linalg.norm(right), up / np.linalg.norm(up)
    return floats(np.cos(angle) * across + np.sin(angle) * along)
