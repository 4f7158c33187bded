"""Fields of clear air that come with the program, against those that are solved for."""

from __future__ import annotations

import numpy as np

from rtbow.physics.air.ozone import ozone_depth
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.fresnel import diffuse_reflectance
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.clear import WATER_INDEX, clear_field
from rtbow.tables.sky.field import no_field, solved_field
from skies.check import Check

NM = np.array([400.0, 600.0, 740.0])
CASES = {
    "grass": (1013.25, 300.0, (0.03, 0.07, 0.5)),
    "snow": (700.0, 0.0, (0.8, 0.8, 0.8)),
    "water": (1050.0, 420.0, (0.0, 0.0, 0.0), WATER_INDEX),
}
"""Pressure, ozone, and the ground's albedo at these wavelengths or its one index."""


def clear(pressure_hpa, ozone_du, albedo, index=0.0):
    """Air without aerosol."""
    water = np.full(3, index) if index else None
    ground = diffuse_reflectance(water) if index else np.array(albedo)
    ozone = ozone_depth(NM, ozone_du) if ozone_du else None
    return make_air(rayleigh_depth(NM, pressure_hpa), ground, ozone, water=water)


def _apart(known, solved):
    """Deviations over the sun's zenith angle, deg: of the mean and of the ground's irradiance."""
    light = solved.mean[:, :, :3].sum(axis=2, keepdims=True)
    mean = np.abs(known.mean - solved.mean) / light
    return np.degrees(solved.zeniths_rad), mean, np.abs(known.ground / solved.ground - 1.0)


def fields(case):
    """At all nodes, of suns down to -2 and to -6 degrees."""
    air = clear(*CASES[case])
    zenith, mean, ground = _apart(clear_field(air, no_field(3)), solved_field(air))
    for last, bound in ((92.1, 1e-3), (96.1, 2e-3)):
        found = max(mean[:, zenith < last].max(), ground[zenith < last].max())
        what = f"fields that come with the program, {case}, suns to {90.0 - last:.0f}°: worst"
        yield Check(what, float(found), bound)


def one_index():
    """Water of one index for all light, against water of its own at each wavelength."""
    found = clear_field(clear(1013.25, 300.0, (), WATER_INDEX), no_field(3))
    own = clear(1013.25, 300.0, (), 1.0)._replace(water=relative_index(NM, 15.0))
    own = own._replace(albedo=diffuse_reflectance(own.water))
    zenith, mean, _ = _apart(found, solved_field(own))
    yield Check("water of one index for all light: worst", float(mean[:, zenith < 96].max()), 5e-3)
