"""Two skies that were measured, and rtbow's: aerosol and the instrument's north are fitted.

The aerosol is OPAC's continental average in its phase function and its absorption, with Angstrom's
depth, beta (wavelength / µm)^-alpha. An rms of 6.0 and 10.8 % is left; the other continental
mixtures leave 5.9 to 6.4 % and 10.7 to 10.9 %, the maritime one 8.1 and 10.9 %, the phase function
of Cornette and Shanks 9.1 and 10.8 %.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from checkout import ROOT
from rtbow.physics.air.aerosol import AerosolOptics
from rtbow.physics.air.ozone import ozone_depth
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.constants import SEA_LEVEL_HPA
from rtbow.physics.light.sun_position import sun_position
from rtbow.scene.air import Aerosol as AerosolKeys
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.field import no_field, sky_field
from rtbow.world.measured.albedo import load_albedo
from rtbow.world.measured.spectra import load_spectrum
from rtbow.world.sky import haze_of
from skies.check import Check, rms
from skies.gathered import direction, stokes

FITTED_NM = np.arange(400.0, 681.0, 40.0)
CHECKED_NM = np.array([440.0, 560.0, 680.0])
NEAREST_DEG = 25.0
"""Nearer to the sun nothing is compared: the light changes by per cents a degree there, and
azimuths are known to some degrees."""
_BAND_NM = 20.0
_LATITUDE_DEG, _LONGITUDE_DEG, _PRESSURE_HPA = 42.4434, -76.482, 962.0
_OZONE_DU = 330.0
MODEL = "continental-average"
_DEPTHS = np.array([0.005, 0.04, 0.09, 0.16])
"""Of aerosol, between which skies are cubics of it while it is fitted."""


class Aerosol(NamedTuple):
    """What is fitted of a sky.

    Attributes:
        beta: vertical depth at 1 µm.
        alpha: Angstrom's exponent.
        turned_deg: what is to be added to measured azimuths.
    """

    beta: float
    alpha: float
    turned_deg: float

    def depth(self, wavelength_nm):
        """Its depth at wavelengths."""
        return self.beta * (wavelength_nm / 1000.0) ** -self.alpha


class Day(NamedTuple):
    """A sky that was measured.

    Attributes:
        when: in the middle of two minutes.
        sun_au: the sun's distance, au.
        aerosol: as :func:`fitted` found it.
    """

    when: datetime
    sun_au: float
    aerosol: Aerosol

    @property
    def name(self):
        return f"{self.when:%Y-%m-%d}"


DAYS = (
    Day(datetime(2013, 5, 27, 13, 46, tzinfo=UTC), 1.0133, Aerosol(0.0319, 1.26, 6.9)),
    Day(datetime(2013, 9, 24, 17, 31, tzinfo=UTC), 1.0030, Aerosol(0.0133, 0.74, 0.1)),
)


def air(wavelength_nm, depth, model=MODEL):
    """Air over grass at wavelengths, with depths of aerosol there (W,)."""
    haze = haze_of(AerosolKeys(model=model), wavelength_nm)
    optics = AerosolOptics(depth, haze.optics.scattering, haze.optics.phase)
    return make_air(
        _PRESSURE_HPA / SEA_LEVEL_HPA * rayleigh_depth(wavelength_nm),
        load_albedo("grass").at(wavelength_nm),
        ozone_depth(wavelength_nm, _OZONE_DU),
        replace(haze, optics=optics),
    )


@cache
def _rows():
    text = (ROOT / "tests" / "tables" / "sky" / "measured.csv").read_text("utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if line[0] != "#"))


class _Sky:
    """A day's directions, and what was measured there at wavelengths."""

    def __init__(self, day, wavelength_nm):
        rows = [row for row in _rows() if row["day"] == day.name]
        self.altitude, self.azimuth = (
            np.array([float(row[key]) for row in rows]) for key in ("elevation_deg", "azimuth_deg")
        )
        self.radiance = np.array([[float(row[f"{nm:g}"]) for nm in wavelength_nm] for row in rows])
        self.sun = sun_position(day.when, _LATITUDE_DEG, _LONGITUDE_DEG, pressure_hpa=_PRESSURE_HPA)
        sunlight, half = load_spectrum("E490"), 0.5 * _BAND_NM
        mean = [sunlight.integral(nm - half, nm + half) / _BAND_NM for nm in wavelength_nm]
        self.irradiance = np.array(mean) / day.sun_au**2

    def from_sun(self, turned_deg):
        """Azimuths from the sun's."""
        return self.azimuth + turned_deg - self.sun.azimuth_deg

    def far(self, turned_deg):
        """Which directions count."""
        rays = np.array([
            direction(*ray) for ray in zip(self.altitude, self.from_sun(turned_deg), strict=True)
        ])  # fmt: skip
        towards = direction(self.sun.altitude_deg)
        return rays @ towards < np.cos(np.radians(NEAREST_DEG))

    def gathered(self, air, field, turned_deg):
        """Radiance per irradiance (directions, W)."""
        return np.array([
            stokes(air, field, self.sun.altitude_deg, *ray, pieces=150)[0]
            for ray in zip(self.altitude, self.from_sun(turned_deg), strict=True)
        ])  # fmt: skip


@cache
def _solved():
    """The air of both days at ``CHECKED_NM``, as wavelengths of one, and its field."""
    depths = [day.aerosol.depth(CHECKED_NM) for day in DAYS]
    both = air(np.tile(CHECKED_NM, len(DAYS)), np.concatenate(depths))
    return both, sky_field(both)


def deviations(day, *, single=False):
    """How far a day's sky with its frozen aerosol is from what was measured (directions far from
    the sun, W), relative; of all orders, or of the sun's light scattered once over a black
    ground."""
    sky, turned = _Sky(day, CHECKED_NM), day.aerosol.turned_deg
    both, field = _solved()
    if single:
        both = both._replace(albedo=np.zeros_like(both.albedo))
        field = no_field(len(both.albedo), hazy=True)
    first = len(CHECKED_NM) * DAYS.index(day)
    found = sky.gathered(both, field, turned)[:, first : first + len(CHECKED_NM)]
    return (found * sky.irradiance / sky.radiance - 1.0)[sky.far(turned)]


def checks(day, deviation=None):
    """The day's sky, or another's deviation from it."""
    deviation = deviations(day) if deviation is None else deviation
    what = f"{day.name}, beyond {NEAREST_DEG:g}° from the sun"
    yield Check(f"{what}: rms", rms(deviation), 0.14)
    yield Check(f"{what}: mean", float(np.mean(deviation)), 0.05)  # a fifth less scattered fails


def fitted(model=MODEL, *, single=False):
    """Fit each day's aerosol over ``FITTED_NM``: least squares of the relative deviations. Some
    minutes.

    Args:
        model: whose phase function and absorption the aerosol has, one of a
            scene's ``atmosphere.aerosol.model``.
        single: of one scattering over a black ground.

    Yields:
        A day with its aerosol as it is found, and the deviations that it leaves (directions, W).
    """
    waves, many = len(FITTED_NM), len(_DEPTHS)
    stack = air(np.repeat(FITTED_NM, many), np.tile(_DEPTHS, waves), model)
    if single:
        stack = stack._replace(albedo=np.zeros(waves * many))
    field = no_field(waves * many, hazy=True) if single else sky_field(stack)
    for day in DAYS:
        yield _fitted_day(day, stack, field)


def _fitted_day(day, stack, field):
    sky = _Sky(day, FITTED_NM)

    def skies(turned):
        light = sky.gathered(stack, field, turned)
        return light.reshape(len(light), len(FITTED_NM), len(_DEPTHS))[sky.far(turned)]

    def left(light, turned, numbers):
        aerosol = Aerosol(*numbers, turned)
        shares = _between_depths(aerosol.depth(FITTED_NM))
        found = np.sum(light * shares, axis=-1) * sky.irradiance
        return found / sky.radiance[sky.far(turned)] - 1.0

    def best(turned):
        light = skies(turned)
        return minimize(
            lambda numbers: rms(left(light, turned, numbers)), [0.03, 1.2], method="Nelder-Mead"
        )

    turned = minimize_scalar(
        lambda turned: best(turned).fun, bounds=(-12.0, 12.0), options={"xatol": 0.3}
    ).x
    numbers = best(turned).x
    found = Aerosol(*(float(number) for number in numbers), float(turned))
    return day._replace(aerosol=found), left(skies(turned), turned, numbers)


def _between_depths(depth):
    """Shares of skies at ``_DEPTHS`` in those at depths (W, depths): a cubic through all four."""
    shares = np.ones((len(depth), len(_DEPTHS)))
    for i, node in enumerate(_DEPTHS):
        for other in np.delete(_DEPTHS, i):
            shares[:, i] *= (depth - other) / (node - other)
    return shares
