"""A shader's tables of a sky against the sums along single rays that the reference makes."""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.field import FIELD_NM, between_field_nm, kept_field
from rtbow.tables.sky.rays import AZIMUTHS, FALLING, RISING, Eye
from rtbow.tables.sky.seen import sky_table
from rtbow.world.measured.spectra import load_spectrum
from skies.check import Check, rms, worst
from skies.gathered import stokes

AIR = make_air(rayleigh_depth(FIELD_NM), np.full(len(FIELD_NM), 0.3))
COLOURS = np.eye(len(FIELD_NM))[:, [1, 7, 15]]
"""Channels of one wavelength each: 405, 555 and 755 nm."""


@cache
def field():
    """What that air has scattered."""
    return kept_field(AIR)


def summed(height_m, sun_deg, altitude_deg, azimuth_deg, until_m=np.inf, colours=COLOURS):
    """I, Q and U (3, channels) along a ray, up to a distance or with what is at its end."""
    light = stokes(
        AIR, field(), sun_deg, altitude_deg, azimuth_deg,
        height_m=height_m, until_m=until_m, pieces=400,
    )  # fmt: skip
    return light @ colours


def table(height_m, sun_deg, distances_m=(), colours=COLOURS):
    """The tables of an eye's sky."""
    eye = Eye(height_m, np.radians(sun_deg), np.array(distances_m), polarised=True)
    return sky_table(AIR, field(), 1.0, eye, colours, AIR.albedo[:, None] * colours)


def looked_up(made, altitude_deg, azimuth_deg):
    """I (channels,) along a ray, between rows and columns as the shader finds it."""
    whole = made.layers[-1, 0] + made.ground[0]
    above = np.radians(altitude_deg) - made.horizon_rad
    rows, quarter = (RISING, 0.5 * np.pi) if above >= 0.0 else (FALLING, -0.5 * np.pi)
    share = above / (quarter - made.horizon_rad)
    row = share ** (1.0 / 2.0 if above >= 0.0 else 1.0 / 3.0) * (rows - 1)
    column = abs(azimuth_deg) / 180.0 * (AZIMUTHS - 1)
    i, j = min(int(row), rows - 2), min(int(column), AZIMUTHS - 2)
    v, u = row - i, column - j
    i += 0 if above >= 0.0 else RISING
    (a, b), (c, d) = whole[i : i + 2, j : j + 2]
    return (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * c + u * d)


class Seen(NamedTuple):
    """Skies that are compared: the eye's height, m, and the suns."""

    height_m: float
    suns_deg: tuple[float, ...]


NEAR = Seen(2.0, (90.0, 60.0, 20.0, 5.0, 0.0, -2.0, -4.0))
HIGH = Seen(10_000.0, (-2.0,))


def along_rays(seen, rays=400):
    """Single rays, even over the sphere: X, Y and Z of sunlight, each relative to itself."""
    rng = np.random.default_rng(1)
    bins = wavelength_bins(1.0)
    weights = colour_weights(load_spectrum("E490"), bins)
    xyz = between_field_nm(bins.wavelength_nm).T @ weights
    found = []
    for sun in seen.suns_deg:
        made = table(seen.height_m, sun, colours=xyz)
        for _ in range(rays):
            ray = np.degrees(np.arcsin(rng.uniform(-1.0, 1.0))), rng.uniform(0.0, 180.0)
            truth = summed(seen.height_m, sun, *ray, colours=xyz)[0]
            found.append(looked_up(made, *ray) / truth - 1.0)
    suns = " to ".join({f"{max(seen.suns_deg):g}°": 0, f"{min(seen.suns_deg):g}°": 0})
    what = f"shaders' tables, rays from {seen.height_m:g} m, suns at {suns}"
    yield Check(f"{what}: rms", rms(found))
    yield Check(f"{what}: worst", worst(found))
