"""What still water mirrors: the sky and the sun above it, by Fresnel's formulas in angles."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.physics.geometry import direction
from rtbow.reference.render import radiance_along
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

WATER = {
    "droplets.box_m": [[-10.0, 90_000.0, 0.0], [10.0, 90_010.0, 10.0]], "ground.water": True,
    "render.wavelength_step_nm": 40.0, "camera.position_m": [0.0, 0.0, 0.0],
}  # fmt: skip
INDEX = 1.335
"""Of water relative to air in the middle of the visible; blue and red light's are within 0.006."""


def luminance(changes, azimuth, altitude):
    world = resolve(rtbow.load_scene("uniform", {**WATER, **changes}))
    return radiance_along(world, direction(azimuth, altitude)[None])[0, 1]


def amplitudes(incidence_deg):
    """Of fields across the plane of incidence and within it, by the angles."""
    incidence = np.radians(incidence_deg)
    refracted = np.arcsin(np.sin(incidence) / INDEX)
    less, more = incidence - refracted, incidence + refracted
    return -np.sin(less) / np.sin(more), np.tan(less) / np.tan(more)


@pytest.mark.parametrize("sun", [12.0, 37.0, 70.0])
def test_the_sun_in_the_water(sun):
    changes = {"light.0.altitude_deg": sun, "ground.water": True}
    above = luminance(changes, 180.0, sun)
    first, second = amplitudes(90.0 - sun)
    share = 0.5 * (first**2 + second**2)
    assert luminance(changes, 180.0, -sun) == pytest.approx(share * above, rel=0.02)
    assert luminance(changes, 180.0, -sun - 0.4) == 0.0
    high = {**changes, "camera.position_m": [0.0, 0.0, 10_000.0]}
    lean = np.degrees(10_000.0 / np.tan(np.radians(sun)) / 6_371_000.0)  # of the water below
    assert luminance(high, 180.0, -sun - 2.0 * lean + 0.2) > 0.0
    assert luminance(high, 180.0, -sun - 2.0 * lean + 0.35) == 0.0


@pytest.mark.parametrize("filter_deg", [0.0, 90.0, 45.0, -30.0])
def test_the_sky_in_the_water_through_a_filter(filter_deg):
    """Level fields are mirrored across the plane, upright ones within it; both keep their phase."""
    sky = {"atmosphere.rayleigh": True, "atmosphere.sky": True, "light.0.altitude_deg": 25.0}

    def seen(altitude, angle):
        camera = {"camera.altitude_deg": altitude, "camera.azimuth_deg": 100.0}
        return luminance({**sky, **camera, "camera.polarizer_deg": angle}, 100.0, altitude)

    level, upright, tilted = (seen(35.0, angle) for angle in (0.0, 90.0, 45.0))
    both = tilted - 0.5 * (level + upright)
    assert abs(both) > 0.05 * tilted
    first, second = amplitudes(55.0)
    c, s = np.cos(np.radians(filter_deg)), np.sin(np.radians(filter_deg))
    expected = c * c * first**2 * level + s * s * second**2 * upright
    expected += 2.0 * c * s * first * second * both
    assert seen(-35.0, filter_deg) == pytest.approx(expected, rel=0.02, abs=2e-3 * level)


def test_rain_that_stands_on_water_shows_no_line_at_the_horizon():
    """Its flat floor is some 0.1 m above the water where rays near the horizon meet it."""
    world = resolve(rtbow.load_scene("moonbow", {"render.wavelength_step_nm": 40.0}))
    rays = [direction(40.0, altitude) for altitude in np.arange(-0.31, 0.1, 0.02)]
    seen = radiance_along(world, np.array(rays))[:, 1]
    assert np.all(np.abs(np.diff(np.log(seen))) < 0.006)
