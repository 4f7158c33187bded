"""Skies with aerosol, ozone and ground against other programs', and conservation."""

from __future__ import annotations

from functools import cache

import numpy as np

from rtbow.physics.air.aerosol import free_optics
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.tables.sky.air import Haze, make_air
from rtbow.tables.sky.field import no_field, sky_field
from skies.check import Check, rms, worst
from skies.gathered import light_kept, polarisation, stokes
from textbook import hazy_sky

SETTINGS = tuple(range(1, 11))
SINGLE_SETTINGS = (2, 7, 9)


def setting(number):
    """Rows of a setting, and its air."""
    rows = [row for row in hazy_sky() if row["setting"] == number]
    one, nm = rows[0], np.array([rows[0]["wavelength_nm"]])
    optics = free_optics(
        nm, one["aerosol_depth"], 0.0, one["single_scattering_albedo"], one["asymmetry"]
    )
    absorber = np.array([one["absorber_depth"]]) if one["absorber_depth"] else None
    haze = Haze(optics, one["scale_height_m"], np.inf)
    return rows, make_air(rayleigh_depth(nm), np.array([one["ground_albedo"]]), absorber, haze)


def _ray(row):
    return row["sun_altitude_deg"], row["elevation_deg"], row["azimuth_from_sun_deg"]


@cache
def compared(number):
    """Deviations of a setting's places: from SASKTRAN2, and from the Monte Carlo where it has a
    value, relative; and of the degree of polarisation, absolute."""
    rows, air = setting(number)
    field = sky_field(air)
    found = np.array([stokes(air, field, *_ray(row))[:, 0] for row in rows])
    other = np.array([row["monte_carlo_per_sr"] for row in rows])
    return (
        found[:, 0] / [row["radiance_per_sr"] for row in rows] - 1.0,
        (found[:, 0] / other - 1.0)[~np.isnan(other)],
        polarisation(found.T) - [row["polarisation"] for row in rows],
    )


def published(*numbers):
    """Some settings together. SASKTRAN2 is 0.5 to 1.1 % too bright in the mean, for its flat
    layers; the Monte Carlo has noise of 0.2 to 0.55 %."""
    whole, apart, polarised = map(np.concatenate, zip(*map(compared, numbers), strict=True))
    yield Check("aerosol, all orders: rms", rms(whole), 0.015)
    yield Check("aerosol, all orders: worst", worst(whole), 0.025)
    yield Check("the same against a Monte Carlo: mean", float(np.mean(apart)), 0.006)
    yield Check("the same against a Monte Carlo: rms", rms(apart))
    yield Check("the same against a Monte Carlo: worst", worst(apart), 0.03)
    yield Check("aerosol, degree of polarisation, absolute: worst", worst(polarised), 0.025)


def single(number):
    """One scattering with the whole of the aerosol's depth: no peak is taken out of it."""
    rows, air = setting(number)
    one = rows[0]
    optics = free_optics(
        np.array([550.0]), 1.0, 0.0, one["single_scattering_albedo"], one["asymmetry"]
    )
    whole = air._replace(
        depth=air.beam, scattering=optics.scattering, phase=optics.phase, albedo=np.zeros(1)
    )
    field = no_field(1, hazy=True)
    found = np.array([stokes(whole, field, *_ray(row))[0, 0] for row in rows])
    deviation = found / [row["single_per_sr"] for row in rows] - 1.0
    yield Check(f"aerosol, one scattering, setting {number}: worst", worst(deviation), 4e-3)


def conserved():
    """Aerosol of depth 0.3 that absorbs nothing, over black ground."""
    nm, sun_deg = np.array([550.0]), 40.0
    optics = free_optics(nm, 0.3, 0.0, 1.0, 0.7)
    air = make_air(rayleigh_depth(nm), np.zeros(1), None, Haze(optics, 1200.0, np.inf))
    passed = np.exp(-air.depth.sum() / np.sin(np.radians(sun_deg)))
    lost = 1.0 - light_kept(air, sky_field(air), sun_deg, passed)
    yield Check("aerosol that absorbs nothing, light that is lost", float(lost[0]), 0.015)
