"""Rays of a sky's table: where they start, their pieces, and the sun as places along them have it.

A ray and its mirror image in water lie in one vertical plane: a table has one for each altitude,
and for each azimuth from the sun the sun's place relative to that plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import ground_distance, top_distance
from rtbow.physics.constants import EARTH_RADIUS_M
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.light import Air

RISING, FALLING = 48, 44
"""Rows above and below the horizon."""
AZIMUTHS = 25
"""Columns, from the sun's azimuth to the opposite one."""
_PIECES = 56
"""Of a ray through the air, beside those that end at a layer's distance."""


@dataclass(frozen=True)
class Eye:
    """Where from and under what a sky is seen.

    Attributes:
        height_m: of the eye.
        sun_altitude_rad: of the sun there.
        distances_m: up to which the air's light is told apart, ascending (D,).
        polarised: whether all of I, Q and U are asked for; else I alone. Q is along the horizontal
            less across it, U at 45 degrees from it towards the zenith.
    """

    height_m: float
    sun_altitude_rad: float
    distances_m: Array
    polarised: bool


def row_altitudes(horizon: float) -> Array:
    """Give the altitudes of a table's rows (RISING + FALLING,), rad."""
    up, down = np.linspace(0.0, 1.0, RISING) ** 2, np.linspace(0.0, 1.0, FALLING) ** 3
    above = horizon + (0.5 * np.pi - horizon) * up
    return np.concatenate([above, horizon - (0.5 * np.pi + horizon) * down])


class Start(NamedTuple):
    """Where rays start, each in the vertical plane of a row.

    Attributes:
        height_m: above the ground.
        sine: of their altitudes there (rows,).
        turned_sine: of the angle by which the vertical there is turned from the eye's (rows,).
        turned_cosine: of it.
        end: distance at which they end (rows,), m.
    """

    height_m: float
    sine: Array
    turned_sine: Array
    turned_cosine: Array
    end: Array

    def turned(self, sine: Array, cosine: Array) -> tuple[Array, Array]:
        """Give sine and cosine of the whole angle from the eye's vertical, where that along the
        rays is given so (rows, n)."""
        first_s, first_c = self.turned_sine[:, None], self.turned_cosine[:, None]
        return sine * first_c + cosine * first_s, cosine * first_c - sine * first_s


def from_eye(eye: Eye) -> Start:
    """The rays of a table's rows."""
    altitude = row_altitudes(float(horizon_rad(eye.height_m)))
    sine = np.sin(altitude)
    falls = np.arange(len(altitude)) >= RISING
    sine[falls] = np.minimum(sine[falls], -1e-12)  # from the ground itself, as well
    end = np.where(
        falls,
        ground_distance(eye.height_m, np.where(falls, sine, -1.0)),
        top_distance(eye.height_m, sine),
    )
    return Start(eye.height_m, sine, np.zeros(len(sine)), np.ones(len(sine)), end)


@dataclass(frozen=True)
class RowRays:
    """Rays in pieces, in the vertical plane of each.

    Attributes:
        start: where they start.
        edges: of the pieces (rows, S + 1), m.
        arriving: share of what a piece scatters per depth that arrives (rows, S, W).
        scattered: depth of the pieces by which molecules scatter (rows, S, W).
        hazed: the same of aerosol (rows, S, W).
        through: share of light from the ray's end that arrives (rows, W).
        beam: the same of what is seen sharply.
        last_piece: the last piece up to each distance (D, rows).
    """

    start: Start
    edges: Array
    arriving: Array
    scattered: Array
    hazed: Array
    through: Array
    beam: Array
    last_piece: list[Indices]

    @classmethod
    def of(cls, air: Air, start: Start, distances_m: Array) -> RowRays:
        """Divide rays into pieces, of which some end at distances (D,)."""
        end = start.end[:, None]
        dense = end * np.linspace(0.0, 1.0, _PIECES + 1) ** 2
        layers = np.minimum(distances_m, end)
        edges = np.sort(np.concatenate([dense, layers], axis=1), axis=1)
        height = heights(start.height_m, start.sine[:, None], edges)[0]
        shells = shells_of(air)
        amounts = shells.amounts(height[:, :-1], height[:, 1:], np.diff(edges, axis=1))
        each = np.einsum("cas,cw->casw", amounts, air.depth)
        thick = each.sum(axis=0)  # (rows, S, W)
        before = np.cumsum(thick, axis=1) - thick
        mean = np.where(thick > 0.0, -np.expm1(-thick) / np.maximum(thick, 1e-300), 1.0)
        arriving = mean * np.exp(-before)
        through = np.exp(-thick.sum(axis=1))
        beam = np.exp(-amounts.sum(axis=2).T @ air.beam)
        last = [np.maximum((edges[:, 1:] <= at[:, None]).sum(axis=1) - 1, 0) for at in layers.T]
        hazed = air.scattering * each[-1]
        return cls(start, edges, arriving, each[0], hazed, through, beam, last)


def heights(start_m: float, sine: Array, distance: Array) -> tuple[Array, Array, Array]:
    """Heights along rays, m, and sines and cosines of the angle that the vertical has turned."""
    r0 = EARTH_RADIUS_M + start_m
    up, along = r0 + distance * sine, distance * np.sqrt(1.0 - sine**2)
    r = np.hypot(up, along)
    rise = distance * (2.0 * r0 * sine + distance) / (r + r0)
    return np.maximum(start_m + rise, 0.0), along / r, up / r


@dataclass(frozen=True)
class Suns:
    """The sun as places along rays have it, in their own frames (rows, n, columns).

    Attributes:
        cosine: of its zenith angle.
        across: sine of the azimuth between ray and sun.
        along: cosine of it.
    """

    cosine: Array
    across: Array
    along: Array

    @classmethod
    def of(cls, eye: Eye, sine: Array, cosine: Array) -> Suns:
        """Turn the vertical in the ray's plane by an angle (rows, n), given as sine and cosine."""
        azimuth = np.linspace(0.0, np.pi, AZIMUTHS)
        up, level = np.sin(eye.sun_altitude_rad), np.cos(eye.sun_altitude_rad)
        turn_s, turn_c = sine[..., None], cosine[..., None]
        forward, aside = level * np.cos(azimuth), level * np.sin(azimuth)
        zenith = turn_c * up + turn_s * forward
        along = turn_c * forward - turn_s * up
        size = np.hypot(along, aside)
        level = size > 1e-9  # under a sun in the zenith all azimuths are alike
        size = np.where(level, size, 1.0)
        return cls(zenith, np.where(level, aside / size, 0.0), np.where(level, along / size, 1.0))


@dataclass(frozen=True)
class Places:
    """The middles of rays' pieces.

    Attributes:
        height: (rows, n), m.
        zenith: angle of the sun from the zenith there (rows, n, columns), rad.
        suns: the sun as it stands there.
        cosine: of the ray's own zenith angle there (rows, n).
        side: sine of it.
    """

    height: Array
    zenith: Array
    suns: Suns
    cosine: Array
    side: Array

    @classmethod
    def of(cls, eye: Eye, rays: RowRays) -> Places:
        """Give the places of rays as an eye's sun lights them."""
        start, sine = rays.start, rays.start.sine[:, None]
        middle = 0.5 * (rays.edges[:, 1:] + rays.edges[:, :-1])
        height, turn_s, turn_c = heights(start.height_m, sine, middle)
        suns = Suns.of(eye, *start.turned(turn_s, turn_c))
        zenith = np.arccos(np.clip(suns.cosine, -1.0, 1.0))
        level = np.sqrt(1.0 - sine**2)
        cosine, side = sine * turn_c + level * turn_s, level * turn_c - sine * turn_s
        return cls(height, zenith, suns, cosine, side)


def lit_share(eye: Eye, rays: RowRays) -> Array:
    """Share of each piece that the sun reaches (rows, n, columns): its altitude above the horizon
    is taken to change evenly along a piece."""
    start = rays.start
    height, turn_s, turn_c = heights(start.height_m, start.sine[:, None], rays.edges)
    cosine = Suns.of(eye, *start.turned(turn_s, turn_c)).cosine
    zenith = np.arccos(np.clip(cosine, -1.0, 1.0))
    clear = 0.5 * np.pi - zenith - horizon_rad(height)[..., None]
    first, last = clear[:, :-1], clear[:, 1:]
    most, least = np.maximum(first, last), np.minimum(first, last)
    crossing = most / np.where(most > least, most - least, 1.0)
    return np.where(least >= 0.0, 1.0, np.where(most <= 0.0, 0.0, crossing))
