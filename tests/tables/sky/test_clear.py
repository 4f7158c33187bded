"""Fields of clear air that come with the program, against those that are solved for."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.air.ozone import ozone_depth
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.fresnel import diffuse_reflectance
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.clear import MOST_OZONE, WATER_INDEX, clear_field
from rtbow.tables.sky.field import no_field, solved_field

NM = np.array([400.0, 600.0, 740.0])


def clear(pressure_hpa, ozone_du, albedo, index=0.0):
    water = np.full(3, index) if index else None
    ground = diffuse_reflectance(water) if index else np.array(albedo)
    ozone = ozone_depth(NM, ozone_du) if ozone_du else None
    return make_air(rayleigh_depth(NM, pressure_hpa), ground, ozone, water=water)


@pytest.mark.slow
@pytest.mark.parametrize(
    "of",
    [
        (1013.25, 300.0, (0.03, 0.07, 0.5)),
        (700.0, 0.0, (0.8, 0.8, 0.8)),
        (1050.0, 420.0, (0.0, 0.0, 0.0), WATER_INDEX),
    ],
    ids=["grass", "snow", "water"],
)
def test_they_are_those_that_are_solved_for(of):
    air = clear(*of)
    known, solved = clear_field(air, no_field(3)), solved_field(air)
    zenith = np.degrees(solved.zeniths_rad)
    light = solved.mean[:, :, :3].sum(axis=2, keepdims=True)
    error = np.abs(known.mean - solved.mean) / light
    ground = np.abs(known.ground / solved.ground - 1.0)
    for last, bound in ((92.1, 1e-3), (96.1, 2e-3)):
        assert error[:, zenith < last].max() < bound
        assert ground[zenith < last].max() < bound


@pytest.mark.slow
def test_what_is_one_index_of_water_for_all_light():
    found = clear_field(clear(1013.25, 300.0, (), WATER_INDEX), no_field(3))
    own = clear(1013.25, 300.0, (), 1.0)._replace(water=relative_index(NM, 15.0))
    own = own._replace(albedo=diffuse_reflectance(own.water))
    solved = solved_field(own)
    light = solved.mean[:, :, :3].sum(axis=2, keepdims=True)
    assert (np.abs(found.mean - solved.mean) / light)[
        :, np.degrees(solved.zeniths_rad) < 96
    ].max() < 5e-3


def test_what_is_not_known_is_left_to_the_solver():
    thick = ozone_depth(np.array([600.0]), 460.0)
    assert thick > MOST_OZONE
    assert clear_field(clear(1000.0, 460.0, (0.1, 0.1, 0.1)), no_field(3)) is None
    two = clear(1000.0, 0.0, (0.1, 0.1, 0.1))._replace(water=np.array([0.0, 1.3, 1.3]))
    assert clear_field(two, no_field(3)) is None
