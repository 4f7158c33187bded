"""Skies that stand in for others in a window: of the nearest suns, or of the former air."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Float32
from rtbow.render.sky.wanted import Seen, Wanted
from rtbow.tables.sky.rays import FALLING, Eye
from rtbow.tables.sky.seen import PHASE_PARTS, Mirror
from rtbow.world.sky import Surroundings

_METRES_PER_DEGREE = 1000.0
"""A sky of an eye that much higher or lower stands in as well as one of a sun a degree away."""


def turned(wanted: Wanted, by_rad: float) -> Wanted:
    """Give the sky of a sun that is higher, at the zenith at most."""
    altitude = float(np.clip(wanted.eye.sun_altitude_rad + by_rad, -0.5 * np.pi, 0.5 * np.pi))
    return replace(wanted, eye=replace(wanted.eye, sun_altitude_rad=altitude))


def alike(one: Wanted, wanted: Wanted) -> bool:
    """Whether a sky has the parts of another, of a sun of the same colours."""
    parts = one.eye.polarised == wanted.eye.polarised
    layers = len(one.eye.distances_m) == len(wanted.eye.distances_m)
    return parts and layers and one.colours.tobytes() == wanted.colours.tobytes()


def same_place(one: Eye, other: Eye) -> bool:
    """Whether skies of two eyes may be added up."""
    return one.height_m == other.height_m and bool(np.all(one.distances_m == other.distances_m))


def distance(one: Eye, other: Eye) -> float:
    """How far apart two eyes are, in degrees of the sun's altitude."""
    degrees = abs(np.degrees(one.sun_altitude_rad - other.sun_altitude_rad))
    return float(degrees + abs(one.height_m - other.height_m) / _METRES_PER_DEGREE)


def between(one: Seen, other: Seen, share: float, altitude_rad: float) -> Seen:
    """Give what lies between two skies of one eye, at a share of the way to the second."""

    def mean(a: Float32, b: Float32) -> Float32:
        return np.asarray(a + np.float32(share) * (b - a), np.float32)

    def mean_of_both(a: Float32 | None, b: Float32 | None) -> Float32 | None:
        return None if a is None or b is None else mean(a, b)

    (eye, first), (_, second) = one, other
    mirror = None
    if first.mirror is not None and second.mirror is not None:
        mirror = first.mirror._replace(
            sky=mean(first.mirror.sky, second.mirror.sky),
            glare=mean_of_both(first.mirror.glare, second.mirror.glare),
        )
    table = first._replace(
        layers=mean(first.layers, second.layers),
        glare=mean_of_both(first.glare, second.glare),
        ground=mean(first.ground, second.ground),
        mirror=mirror,
    )
    return replace(eye, sun_altitude_rad=altitude_rad), table


def with_parts(seen: Seen, parts: Parts) -> Seen:
    """Give a sky the parts that haze and water have, dark where it has none, or take them away."""
    eye, table = seen
    layers, stokes, rows, columns, channels = table.layers.shape
    glare, phase, mirror = table.glare, table.phase, table.mirror
    if not parts.haze:
        glare = phase = None
    elif glare is None:
        glare = np.zeros((layers, PHASE_PARTS, rows, columns, channels), np.float32)
        phase = np.zeros((PHASE_PARTS, 2), np.float32)
    if not parts.water:
        mirror = None
    else:
        dark = np.zeros((PHASE_PARTS, FALLING, columns, channels), np.float32)
        if mirror is None:
            beyond = np.zeros((stokes, FALLING, channels), np.float32)
            mirror = Mirror(np.zeros((stokes, *dark.shape[1:]), np.float32), None, beyond)
        if not parts.haze:
            mirror = mirror._replace(glare=None)
        elif mirror.glare is None:
            mirror = mirror._replace(glare=dark)
    return eye, table._replace(glare=glare, phase=phase, mirror=mirror)


class Parts(NamedTuple):
    """What a sky's tables have beside clear air and dry ground."""

    haze: bool
    water: bool

    @classmethod
    def of(cls, around: Surroundings) -> Parts:
        """Give those that an air and a ground have."""
        ground = around.ground
        return cls(around.aerosol is not None, ground is not None and ground.water)


def words_for(first: Wanted, second: Wanted | None, *, of_another_air: bool) -> str:
    """Say what sky is shown in the place of another."""
    suns = sorted({round(_altitude_deg(one), 1) + 0.0 for one in (first, second) if one})
    at = " and ".join(f"{sun:g}°" for sun in suns)
    return f"sky of {'the former air' if of_another_air else f'suns at {at}'} for now"


def _altitude_deg(wanted: Wanted) -> float:
    return float(np.degrees(wanted.eye.sun_altitude_rad))
