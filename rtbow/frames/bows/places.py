"""Where the bows of a world stand, and whether a picture can show them: geometric optics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.physics.drop.airy import unit_angle
from rtbow.physics.geometry import angle_between, box_span
from rtbow.world.camera.view import View

if TYPE_CHECKING:
    from rtbow.world.lights import Lamp, Sun
    from rtbow.world.world import World

EXTREMES_NM = (680.0, 440.0)
"""Wavelengths of the outer and inner edge of the primary bow as an eye sees it."""

_SAMPLES = 33
"""Rays along each side of the picture with which rain and bows are looked for."""
_FRINGE_UNITS = {1: 2.0, 2: 3.5}
"""How far the main maximum reaches beyond the ray of least deviation, in units of Airy's argument
at the primary, by number of reflections: the secondary is 1.8 times as wide."""
_CIRCLE_STEP_DEG = 1.0
_SPHERE_STEP_DEG = 2.0


@dataclass(frozen=True)
class Band:
    """The scattering angles of a bow's main maximum.

    Attributes:
        reflections: internal reflections, 1 primary, 2 secondary.
        least_rad: where it begins, rad; pi is backwards.
        greatest_rad: where it ends.
    """

    reflections: int
    least_rad: float
    greatest_rad: float

    @property
    def middle_rad(self) -> float:
        """Half-way between its ends, rad."""
        return 0.5 * (self.least_rad + self.greatest_rad)


def orders_of(world: World) -> tuple[int, ...]:
    """Give the numbers of internal reflections of the bows that a world draws and eyes see."""
    # Exact theory has all bows, of which two are seen.
    return world.scatterer.orders if world.scatterer.theory == "airy" else (1, 2)


def bands_of(world: World) -> tuple[Band, ...]:
    """Give the scattering angles of a world's bows, by its largest drops, which light it most."""
    medium = world.scatterer.medium
    size = 2.0 * np.pi * world.volume.size_range_um[1] * 1e-6 / (EXTREMES_NM[1] * 1e-9)
    bands = []
    for order in orders_of(world):
        red, violet = (np.radians(medium.descartes_deg(order, nm)) for nm in EXTREMES_NM)
        fringe = float(unit_angle(size, _FRINGE_UNITS[order], medium.bow_unit))
        violet += fringe if order == 1 else -fringe
        bands.append(Band(order, float(min(red, violet)), float(max(red, violet))))
    return tuple(bands)


@dataclass(frozen=True)
class Sight:
    """What a part of a picture can show: the rain's box, and the bows of lights in it.

    Attributes:
        view: the eye and the picture.
        columns: the part's columns of pixels.
        box_m: lower and upper corner of where there are drops (2, 3).
        suns: the suns.
        lamps: the lamps.
        bands: of the bows.
    """

    view: View
    columns: slice
    box_m: Array
    suns: tuple[Sun, ...]
    lamps: tuple[Lamp, ...]
    bands: tuple[Band, ...]

    @cached_property
    def _rain_rays(self) -> Array:
        """Rays of the picture that pass the rain's box (n, 3)."""
        rays = np.concatenate([self._grid(), self._towards_box()])
        entry, leave = box_span(self.view.eye_m, rays, self.box_m)
        return floats(rays[entry < leave])

    def _grid(self) -> Array:
        """Rays over the part, its edges included (n, 3)."""
        height = self.view.size_px[1]
        x = np.linspace(self.columns.start, self.columns.stop, _SAMPLES)
        y = np.linspace(0.0, height, _SAMPLES)
        columns, rows = (floats(place.ravel()) for place in np.meshgrid(x, y))
        return self.view.rays_through(columns, rows)[0]

    def _towards_box(self) -> Array:
        """Rays towards corners and middle of the box, where the part shows them (n, 3).

        A box that is far away would slip through a grid of rays.
        """
        corners = np.stack(np.meshgrid(*self.box_m.T), axis=-1).reshape(-1, 3)
        middle = self.box_m.mean(axis=0)
        # Just inside the corners, which rays would pass by a rounding error.
        points = np.concatenate([[middle], middle + (1.0 - 1e-6) * (corners - middle)])
        away = points - self.view.eye_m
        column, _ = self.view.places_of(away)
        seen = self.view.shows(away)
        seen &= (column >= self.columns.start) & (column <= self.columns.stop)
        return floats(away[seen] / np.linalg.norm(away[seen], axis=1, keepdims=True))

    @property
    def rain_shows(self) -> bool:
        """Whether any ray of the part meets the rain's box."""
        return bool(len(self._rain_rays))

    @property
    def bow_shows(self) -> bool:
        """Whether any ray of the part meets a bow of any light within the rain's box."""
        rays = self._rain_rays
        if not len(rays):
            return False
        # Rain in the picture is one convex patch: angles from an axis have no gap.
        for sun in self.suns:
            angles = np.pi - angle_between(rays, -sun.direction)
            if any(self._meets(band, angles.min(), angles.max()) for band in self.bands):
                return True
        return any(self._lamp_meets(lamp, rays).any() for lamp in self.lamps)

    @staticmethod
    def _meets(band: Band, least: float, greatest: float) -> bool:
        return bool(least <= band.greatest_rad and greatest >= band.least_rad)

    def _lamp_meets(self, lamp: Lamp, rays: Array) -> NDArray[np.bool_]:
        """Tell which rays through the rain (n, 3) meet a bow of a lamp there (n,)."""
        eye = self.view.eye_m
        ends = []
        for distance in box_span(eye, rays, self.box_m):
            to_lamp = lamp.position_m - eye - distance[:, None] * rays
            length = np.linalg.norm(to_lamp, axis=1, keepdims=True)
            ends.append(angle_between(to_lamp / np.maximum(length, 1e-9), rays))
        # Along a ray away from the eye the scattering angle only grows.
        least, greatest = np.minimum(*ends), np.maximum(*ends)
        meets = [(least <= b.greatest_rad) & (greatest >= b.least_rad) for b in self.bands]
        return np.asarray(np.any(meets, axis=0))

    def bow_directions(self) -> Array:
        """Give directions (n, 3) in which a bow of some light stands in the rain, seen or not.

        Those of the first light and the first of its bows that have any.
        """
        for sun in self.suns:
            for band in self.bands:
                found = self._in_rain(_circle(-sun.direction, np.pi - band.middle_rad))
                if len(found):
                    return found
        rays = self._in_rain(_sphere()) if self.lamps else np.empty((0, 3))
        for lamp in self.lamps:
            found = rays[self._lamp_meets(lamp, rays)]
            if len(found):
                return found
        return np.empty((0, 3))

    def _in_rain(self, rays: Array) -> Array:
        entry, leave = box_span(self.view.eye_m, rays, self.box_m)
        return floats(rays[entry < leave])

    # --- Other cameras and suns

    @property
    def looking_deg(self) -> tuple[float, float]:
        """Azimuth and altitude of the camera, degrees."""
        return self.view.looking_deg

    def turned(self, azimuth_deg: float, altitude_deg: float) -> Sight:
        """Give the same with the camera turned towards another direction."""
        return replace(self, view=self.view.turned(azimuth_deg, altitude_deg))

    def widened(self, fov_deg: float) -> Sight:
        """Give the same with another horizontal field of view, degrees, whole angle."""
        return replace(self, view=self.view.widened(fov_deg))


def sight_of(world: World, columns: slice) -> Sight | None:
    """Give what a world's picture can show in some of its columns; None where no drops are."""
    box = world.volume.filled_box_m
    if box is None:
        return None
    optics = world.optics
    return Sight(world.view, columns, box, optics.suns, optics.lamps, bands_of(world))


def _circle(axis: Array, radius_rad: float) -> Array:
    """Give directions (n, 3) on a circle about an axis, from its highest point on to both sides."""
    up = np.array([0.0, 0.0, 1.0]) - axis[2] * axis
    if np.linalg.norm(up) < 1e-9:
        up = np.array([0.0, 1.0, 0.0])
    up = up / np.linalg.norm(up)
    side = np.cross(axis, up)
    half = np.radians(np.arange(0.0, 180.0 + _CIRCLE_STEP_DEG, _CIRCLE_STEP_DEG))
    turn = np.stack([half, -half], axis=1).ravel()[:, None]
    around = np.cos(turn) * up + np.sin(turn) * side
    return floats(np.cos(radius_rad) * axis + np.sin(radius_rad) * around)


def _sphere() -> Array:
    """Give directions (n, 3) all around, from the horizon on upwards, then downwards."""
    return np.concatenate(list(_levels()))


def _levels() -> Iterator[Array]:
    up = np.radians(np.arange(0.0, 90.0, _SPHERE_STEP_DEG))
    for altitude in [*up, *-up[1:]]:
        count = max(int(360.0 * np.cos(altitude) / _SPHERE_STEP_DEG), 1)
        azimuth = 2.0 * np.pi * np.arange(count) / count
        level = np.cos(altitude)
        yield np.column_stack(
            [level * np.sin(azimuth), level * np.cos(azimuth), np.full(count, np.sin(altitude))]
        )
