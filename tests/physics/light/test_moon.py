"""Moonlight against published illuminances, and the Moon's place against the almanac."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest

from rtbow.physics.light.moon import diameter_deg, moonlight, reflectance
from rtbow.physics.light.spectrum import luminous
from rtbow.physics.light.sun_position import moon_position
from rtbow.world.measured.spectra import load_spectrum

MEAN_KM = 384_400.0


def illuminance(phase_deg, distance_km=MEAN_KM):
    """Above the air, in lux."""
    return luminous(moonlight(load_spectrum("E490"), phase_deg, distance_km))


@pytest.mark.parametrize("phase_deg", [10.0, 45.0, 90.0, 120.0])
def test_illuminance_by_phase(phase_deg):
    """Krisciunas and Schaefer 1991, eqs. 9 and 20: V of the Moon, and footcandles from it; the two
    agree to 5 %."""
    magnitude = -12.73 + 0.026 * phase_deg + 4e-9 * phase_deg**4
    footcandle = 10.0 ** (-0.4 * (magnitude + 16.57))
    assert illuminance(phase_deg) == pytest.approx(10.764 * footcandle, rel=0.05)


def test_full_and_half_moon():
    """A full Moon gives a quarter to 0.4 lx above the air, half a Moon a ninth of one 7 degrees
    from full (Russell 1916), and the sun 400 000 times as much (magnitudes -26.74 and -12.73)."""
    assert 0.25 < illuminance(7.0) < illuminance(0.0) < 0.4
    assert illuminance(7.0) / illuminance(90.0) == pytest.approx(9.0, rel=0.1)
    assert luminous(load_spectrum("E490")) / illuminance(7.0) == pytest.approx(4.6e5, rel=0.1)


def test_colour_and_distance():
    violet, red = reflectance(np.array([400.0, 700.0]), 30.0)
    assert 1.6 < red / violet < 1.9  # the soil of the Moon is brown
    assert illuminance(30.0, MEAN_KM / 1.1) == pytest.approx(1.21 * illuminance(30.0), rel=1e-9)
    assert diameter_deg(MEAN_KM) == pytest.approx(0.518, abs=5e-4)


@pytest.mark.parametrize(
    ("when", "phase_deg"),
    [
        (datetime(2024, 1, 18, 3, 53, tzinfo=UTC), 90.0),  # first quarter
        (datetime(2025, 9, 7, 18, 12, tzinfo=UTC), 0.3),  # in the middle of a total eclipse
        (datetime(2024, 4, 8, 18, 21, tzinfo=UTC), 180.0),  # eclipse of the sun
    ],
)
def test_phases_of_the_almanac(when, phase_deg):
    """Parallax shifts the phase by up to a degree from that of the Earth's centre."""
    assert moon_position(when, 20.0, 0.0).phase_deg == pytest.approx(phase_deg, abs=1.2)


def test_moon_before_the_sun():
    """At Mazatlan in the middle of the total eclipse of 2024-04-08 both stand at one place."""
    from rtbow.physics.light.sun_position import sun_position

    when = datetime(2024, 4, 8, 18, 9, 30, tzinfo=UTC)
    moon, sun = moon_position(when, 23.2, -106.4), sun_position(when, 23.2, -106.4)
    assert moon.altitude_deg == pytest.approx(sun.altitude_deg, abs=0.05)
    assert moon.azimuth_deg == pytest.approx(sun.azimuth_deg, abs=0.1)
    assert diameter_deg(moon.distance_km) > 0.54  # total, not annular
