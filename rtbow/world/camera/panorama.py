"""A panorama: the whole sphere of directions by azimuth and altitude; float64."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.geometry import direction
from rtbow.scene.model import Camera
from rtbow.world.camera.view import View

_MEAN_SQUARED = 0.75
"""Mean over rows and directions of the square of a pixel's extent, in squares of its height: 1 from
below to above, and cos² of the altitude across, a half in the mean."""


@dataclass(frozen=True, kw_only=True)
class Panorama(View):
    """What a panorama shows of the world (:class:`rtbow.world.camera.view.View`).

    Columns are even in azimuth, from 180 degrees to the left of the middle to 180 to its right, and
    rows in altitude, from the zenith on top to the nadir. The unit vectors of ``basis`` are level
    towards the middle of the picture, level to the right, and up. There is no lens that a filter
    could be before: ``polarizer`` is the direction (2,) of the field that is seen along each ray,
    to the right on a level, and across both, upwards.
    """

    @property
    def pixel_rad(self) -> float:
        """Height of a pixel, and width of one at the horizon."""
        return float(np.pi / self.size_px[1])

    @property
    def mean_pixel_squared(self) -> float:
        """Square of a pixel's extent, rad², in the mean over rows and directions."""
        return _MEAN_SQUARED * self.pixel_rad**2

    @property
    def cone(self) -> tuple[Array, float]:
        """A cone that holds the picture: all directions."""
        return self.basis[0], np.pi

    @property
    def fields_deg(self) -> tuple[float, float]:
        """Horizontal and vertical field of view, degrees."""
        return 360.0, 180.0

    def shows_no_more_than(self, other: View) -> bool:
        """Whether tables for another view have all that this one shows, as all panoramas do."""
        return self.is_alike(other)

    def pixel_directions(self, rows: slice = slice(None)) -> Array:
        """Give unit directions (h, w, 3) through the pixel centres, first row on top.

        Args:
            rows: which rows; all by default.
        """
        width, height = self.size_px
        columns, down = np.meshgrid(np.arange(width) + 0.5, np.arange(height)[rows] + 0.5)
        rays, _ = self.rays_through(columns.ravel(), down.ravel())
        return rays.reshape(*columns.shape, 3)

    def rays_through(self, columns: Array, rows: Array) -> tuple[Array, Array]:
        """Give rays through places in the picture, and how much solid angle lies about each.

        Args:
            columns: places in pixels from the left edge (n,); centres lie at halves.
            rows: places from the upper edge (n,).

        Returns:
            Unit directions (n, 3), and solid angle per area of the picture (n,): the cosine of the
            altitude.
        """
        width, height = self.size_px
        aside = 2.0 * np.pi * (columns / width - 0.5)
        altitude = np.pi * (0.5 - rows / height)
        level = np.cos(altitude)
        parts = np.stack([level * np.cos(aside), level * np.sin(aside), np.sin(altitude)], axis=1)
        return floats(parts @ self.basis), floats(level)

    def places_of(self, vectors: Array) -> tuple[Array, Array]:
        """Give where vectors from the eye (n, 3), of any length, lie in the picture.

        Returns:
            Columns and rows (n,) as for :meth:`rays_through`.
        """
        ahead, right, up = self.basis @ vectors.T
        width, height = self.size_px
        aside, altitude = np.arctan2(right, ahead), np.arctan2(up, np.hypot(ahead, right))
        return (aside / (2.0 * np.pi) + 0.5) * width, (0.5 - altitude / np.pi) * height

    def ray_extents(self, rays: Array) -> Array:
        """Give by how much each component of pixels' rays changes from one side to the other.

        Args:
            rays: through the pixels' centres (n, 3).

        Returns:
            (n, 3): the root of the sum of squares over both sides.
        """
        right, up = _level_and_upright(rays, self.basis[1])
        width, height = self.size_px
        level = np.hypot(rays[:, 0], rays[:, 1])[:, None]
        across, upwards = 2.0 * np.pi / width * level * right, np.pi / height * up
        return floats(np.hypot(across, upwards))

    def block_extents(self, rays: Array, block: int) -> tuple[Array, Array]:
        """Bound the rays of blocks of pixels (:meth:`View.block_extents`)."""
        right, up = _level_and_upright(rays, self.basis[1])
        width, height = self.size_px
        sides = floats([2.0 * np.pi / width, np.pi / height])
        turn, rise = 0.5 * (block + 2) * sides
        azimuth, altitude = np.arctan2(rays[:, 0], rays[:, 1]), np.arcsin(rays[:, 2])
        lowest, highest = altitude - rise, altitude + rise
        # A block that reaches a pole has all azimuths.
        turns = np.where(np.maximum(np.abs(lowest), np.abs(highest)) < 0.5 * np.pi, turn, np.pi)
        up_low, up_high = _cosines(0.5 * np.pi - altitude, rise)
        level = np.cos(np.maximum(np.abs(altitude) - rise, 0.0))
        least_level = np.maximum(np.cos(np.abs(altitude) + rise), 0.0)
        bounds = []
        for towards in (azimuth - 0.5 * np.pi, azimuth):  # its sine, its cosine
            low, high = _cosines(towards, turns)
            low = np.where(low < 0.0, low * level, low * least_level)
            bounds.append((low, np.where(high > 0.0, high * level, high * least_level)))
        bounds.append((up_low, up_high))
        wide = [
            2.0 * np.maximum(high - rays[:, k], rays[:, k] - low)
            for k, (low, high) in enumerate(bounds)
        ]
        # A pixel's sides turn with it.
        aside, upright = np.abs(right) + turn, np.abs(up) + turn + rise
        pixel = np.hypot(
            sides[0] * level[:, None] * np.minimum(aside, 1.0),
            sides[1] * np.minimum(upright, 1.0),
        )
        return floats(pixel), floats(np.stack(wide, axis=1))

    def passed_field(self, rays: Array) -> Array:
        """Give the field that the filter passes, unit vectors across rays (n, 3)."""
        assert self.polarizer is not None
        right, up = _level_and_upright(rays, self.basis[1])
        return floats(self.polarizer[0] * right + self.polarizer[1] * up)

    def turned(self, azimuth_deg: float, altitude_deg: float) -> Panorama:
        """Give the view of the camera turned to another azimuth; it stays level."""
        return replace(self, basis=_axes(azimuth_deg))

    def widened(self, fov_deg: float) -> Panorama:
        """Give the view itself, which has all there is."""
        return self


def panorama(camera: Camera) -> Panorama:
    """Resolve a scene's camera."""
    angle = None if camera.polarizer_deg is None else np.radians(camera.polarizer_deg)
    return Panorama(
        eye_m=np.array(camera.position_m),
        basis=_axes(camera.azimuth_deg),
        size_px=camera.size_px,
        fov_deg=360.0,
        polarizer=None if angle is None else floats([np.cos(angle), np.sin(angle)]),
        area=camera.pixel == "area",
    )


def _axes(azimuth_deg: float) -> Array:
    """Give unit vectors (3, 3): level towards an azimuth, level to the right of that, and up."""
    ahead, up = direction(azimuth_deg, 0.0), floats([0.0, 0.0, 1.0])
    return np.stack([ahead, np.cross(ahead, up), up])


def _level_and_upright(rays: Array, at_zenith: Array) -> tuple[Array, Array]:
    """Give unit vectors across rays (n, 3): level to the right, and upwards across both.

    Args:
        rays: unit directions (n, 3).
        at_zenith: what is to the right of a ray to the zenith or the nadir (3,).
    """
    level = np.hypot(rays[:, 0], rays[:, 1])[:, None]
    aside = np.stack([rays[:, 1], -rays[:, 0], np.zeros(len(rays))], axis=1)
    right = np.where(level > 0.0, aside / np.where(level > 0.0, level, 1.0), at_zenith)
    return floats(right), floats(np.cross(right, rays))


def _cosines(angle: Array, reach: Array | float) -> tuple[Array, Array]:
    """Give the least and the greatest cosine of angles up to a reach from others (n,), rad."""
    ends = np.cos(angle - reach), np.cos(angle + reach)
    turn = np.abs((angle + np.pi) % (2.0 * np.pi) - np.pi)
    least = np.where(np.pi - turn <= reach, -1.0, np.minimum(*ends))
    return floats(least), floats(np.where(turn <= reach, 1.0, np.maximum(*ends)))
