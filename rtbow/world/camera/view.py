"""What a camera sees of the world, whatever its projection: rays, pixels, a filter; float64."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Mask, floats
from rtbow.base.limits import NO_PLANE

CONE_MARGIN = 2e-3
"""Tables reach this many radians beyond a picture's corners: for float32, and for the same view in
another size, whose sides are rounded to whole pixels."""


@dataclass(frozen=True, kw_only=True)
class View(ABC):
    """What a camera sees of the world.

    Attributes:
        eye_m: where it is (3,): east, north, up.
        basis: middle of the picture, to its right and up (3, 3), as the projection takes them.
        size_px: width and height of the picture.
        fov_deg: horizontal field of view, whole angle.
        polarizer: what a polarising filter passes, as the projection takes it; None without one.
        area: whether a pixel is the mean over its solid angle, not the light through its centre.
    """

    eye_m: Array
    basis: Array
    size_px: tuple[int, int]
    fov_deg: float
    polarizer: Array | None
    area: bool = False

    # --- What each projection says of itself

    @property
    @abstractmethod
    def pixel_rad(self) -> float:
        """Extent along a side that no pixel exceeds, rad."""

    @property
    @abstractmethod
    def mean_pixel_squared(self) -> float:
        """Square of a typical pixel's extent, rad²."""

    @property
    @abstractmethod
    def cone(self) -> tuple[Array, float]:
        """A cone that holds the picture: axis (3,) and half angle, rad."""

    @property
    @abstractmethod
    def fields_deg(self) -> tuple[float, float]:
        """Horizontal and vertical field of view, degrees."""

    @abstractmethod
    def pixel_directions(self, rows: slice = slice(None)) -> Array:
        """Give unit directions (h, w, 3) through the pixel centres, first row on top.

        Args:
            rows: which rows; all by default.
        """

    @abstractmethod
    def rays_through(self, columns: Array, rows: Array) -> tuple[Array, Array]:
        """Give rays through places in the picture, and how much solid angle lies about each.

        Args:
            columns: places in pixels from the left edge (n,); centres lie at halves.
            rows: places from the upper edge (n,).

        Returns:
            Unit directions (n, 3), and solid angle per area of the picture (n,), in a unit that is
            one for the whole picture.
        """

    @abstractmethod
    def places_of(self, vectors: Array) -> tuple[Array, Array]:
        """Give where vectors from the eye (n, 3), of any length, lie in the picture or beside it.

        Returns:
            Columns and rows (n,) as for :meth:`rays_through`; NaN for what has no place.
        """

    @abstractmethod
    def ray_extents(self, rays: Array) -> Array:
        """Give by how much each component of pixels' rays changes from one side to the other.

        Args:
            rays: through the pixels' centres (n, 3).

        Returns:
            (n, 3): the root of the sum of squares over both sides.
        """

    @abstractmethod
    def block_extents(self, rays: Array, block: int) -> tuple[Array, Array]:
        """Bound the rays of blocks of pixels.

        Args:
            rays: through the middles of blocks (n, 3).
            block: pixels along a block's sides.

        Returns:
            Of a pixel anywhere in a block (n, 3), as :meth:`ray_extents`; and of the block and a
            pixel around it (n, 3): components differ from the middle's by no more than half.
        """

    @abstractmethod
    def passed_field(self, rays: Array) -> Array:
        """Give the field that the filter passes, across rays (n, 3), of any length (n, 3)."""

    @abstractmethod
    def shows_no_more_than(self, other: View) -> bool:
        """Whether this is another view in another size: it has no angle that tables for it lack."""

    @abstractmethod
    def turned(self, azimuth_deg: float, altitude_deg: float) -> View:
        """Give the view of the camera turned so that its middle has another direction."""

    @abstractmethod
    def widened(self, fov_deg: float) -> View:
        """Give the view with another horizontal field of view, degrees, whole angle."""

    # --- What follows for all of them

    @property
    def pixel_deg(self) -> float:
        """Mean extent of a pixel across the picture, degrees."""
        return self.fov_deg / self.size_px[0]

    @property
    def looking_deg(self) -> tuple[float, float]:
        """Azimuth and altitude of the middle of the picture, degrees."""
        forward, right, _ = self.basis
        length = np.hypot(forward[0], forward[1])
        level = forward[:2] if length > 1e-6 else np.array([-right[1], right[0]])
        azimuth = np.degrees(np.arctan2(level[0], level[1]))
        return float(azimuth), float(np.degrees(np.arctan2(forward[2], length)))

    @property
    def forward(self) -> Array:
        """Unit vector through the middle of the picture (3,)."""
        return floats(self.basis[0] / np.linalg.norm(self.basis[0]))

    def shows(self, vectors: Array) -> Mask:
        """Tell which vectors from the eye (n, 3) are in the picture (n,)."""
        column, row = self.places_of(vectors)
        width, height = self.size_px  # NaN is nowhere
        return np.asarray((column >= 0) & (column <= width) & (row >= 0) & (row <= height))

    def angles_from(self, direction: Array) -> tuple[float, float]:
        """Give the least and greatest angle from a direction (3,) to any ray of the picture, rad.

        The range reaches ``CONE_MARGIN`` beyond the picture.
        """
        axis, cone = self.cone
        cone += CONE_MARGIN
        middle = float(np.arccos(np.clip(direction @ axis, -1.0, 1.0)))
        return max(middle - cone, 0.0), min(middle + cone, np.pi)

    def is_alike(self, other: View) -> bool:
        """Whether another view has its eye, its filter and its kind of pixels."""
        return (
            type(self) is type(other)
            and np.array_equal(self.eye_m, other.eye_m)
            and _equal_or_none(self.polarizer, other.polarizer)
            and self.area == other.area
        )

    def probes(self, rays: Array) -> Array:
        """Give what of light's coherency tensor passes the filter, all without one.

        Args:
            rays: unit directions of view (n, 3).

        Returns:
            (n, 3, 3): the light that is seen is the trace of the product of both.
        """
        if self.polarizer is None:
            return np.broadcast_to(np.eye(3), (len(rays), 3, 3))
        field = self.passed_field(rays)
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
        field = self.passed_field(rays)
        normal = np.cross(towards_light, rays)
        passed = np.sum(field**2, axis=1)
        whole = np.sum(normal**2, axis=1) * passed
        # On the line through the light there is no plane; the mean over all of them is one half.
        blur = NO_PLANE * np.sum(towards_light**2) * passed
        along = np.sum(normal * field, axis=1)
        return floats(0.5 + (along**2 - 0.5 * whole) / np.maximum(whole + blur, 1e-30))


def _equal_or_none(a: Array | None, b: Array | None) -> bool:
    return (a is None and b is None) or (a is not None and b is not None and np.array_equal(a, b))
