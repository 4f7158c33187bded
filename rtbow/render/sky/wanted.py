"""Skies that pictures ask for, and who makes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rtbow.base.arrays import Array, Progress
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.tables.sky.field import FIELD_NM, between_field_nm
from rtbow.tables.sky.light import Scattered
from rtbow.tables.sky.rays import Eye
from rtbow.tables.sky.seen import SkyTable, sky_table
from rtbow.world.lights import Sun
from rtbow.world.sky import Surroundings
from rtbow.world.world import World

_LAYERS = 20
"""Distances up to which the air's light is told apart, where rain dims it: their roots are even up
to the box's far end."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """A sky that is asked for.

    Attributes:
        around: the air and the ground.
        eye: where from, and under what sun.
        colours: see :func:`rtbow.tables.sky.seen.sky_table`.
        ground: see there.
    """

    around: Surroundings
    eye: Eye
    colours: Array
    ground: Array

    @property
    def place(self) -> tuple[object, ...]:
        """All that tells it from other skies of its air."""
        eye = self.eye
        return (
            eye.height_m, eye.sun_altitude_rad, eye.polarised, eye.distances_m.tobytes(),
            self.colours.tobytes(),
        )  # fmt: skip

    def same_as(self, other: Wanted) -> bool:
        """Whether another one asks for the same sky."""
        return self.place == other.place and self.around == other.around

    def made(self, field: Scattered) -> SkyTable:
        """Sum the sky from what its air has scattered: some tenths of a second."""
        air, glow = self.around.air(FIELD_NM), float(self.around.glows)
        return sky_table(air, field, glow, self.eye, self.colours, self.ground)


Seen = tuple[Eye, SkyTable]
"""A sky, and the eye that sees it."""


class Skies(Protocol):
    """Makes the skies that are drawn, at once or beside the pictures."""

    def solve(self, around: Surroundings, building: Progress) -> None:
        """See to it that what air has scattered is known, or will be.

        Args:
            around: the air and the ground.
            building: wraps the loop over orders of scattering, where they are not kept.
        """

    def seen(self, wanted: Sequence[Wanted]) -> list[Seen | None]:
        """Give skies, or what stands in for them; None where nothing can.

        A sky that was given before is the same object.
        """


class SkiesAtOnce:
    """Makes the skies of one air when they are asked for (:class:`Skies`)."""

    def __init__(self) -> None:
        self._made: dict[tuple[object, ...], Seen] = {}

    def solve(self, around: Surroundings, building: Progress) -> None:
        """Solve for what air has scattered, or take it from the cache."""
        self._field = around.field(building)

    def seen(self, wanted: Sequence[Wanted]) -> list[Seen | None]:
        """Give skies; those of before that are asked for again are kept."""
        before, self._made = self._made, {}
        for one in wanted:
            self._made[one.place] = before.get(one.place) or (one.eye, one.made(self._field))
        return [self._made[one.place] for one in wanted]


def eye_of(world: World, sun: Sun) -> Eye:
    """Where from and under what a sun's sky is seen."""
    eye, distances = world.view.eye_m, np.zeros(0)
    if world.rain is not None:
        corners = np.maximum(np.abs(world.volume.box_m - eye).max(axis=0), 1.0)
        farthest = float(np.linalg.norm(corners))
        distances = farthest * np.linspace(0.0, 1.0, _LAYERS) ** 2
    polarised = world.view.polarizer is not None
    assert world.around is not None
    height = float(world.around.above_ground(eye)[2])
    return Eye(height, sun.altitude_rad, distances, polarised)


def colours_of(around: Surroundings, sun: Sun) -> tuple[Array, Array]:
    """What a radiance per irradiance at each of ``FIELD_NM`` counts for in R, G and B (W, 3): that
    of cubics through them, under the sun's spectrum at 1 nm; and what one that the ground sends
    back does, whose albedo may have edges between them."""
    bins = wavelength_bins(1.0)
    xyz = colour_weights(sun.spectrum, bins)
    shares = between_field_nm(bins.wavelength_nm).T
    sent = around.ground_light(bins.wavelength_nm)[:, None] * xyz
    return xyz_to_rgb(shares @ xyz), xyz_to_rgb(shares @ sent)
