"""What drops are made of: indices against published digits, bows against rays traced by hand."""

import numpy as np
import pytest

from rtbow.physics.drop.airy import bow, bow_unit
from rtbow.physics.drop.medium import Medium


def bow_radius_deg(index, reflections):
    """Angle from the antisolar point of the ray that is turned least, by trying rays."""
    b = np.sin(np.linspace(0.01, 0.5 * np.pi, 400_001))
    turn = (
        np.degrees(2.0 * np.arcsin(b) - 2.0 * (reflections + 1) * np.arcsin(b / index))
        + 180.0 * reflections
    )
    least = turn.min() % 360.0
    return abs(180.0 - least) if reflections == 1 else abs(least - 180.0)


@pytest.mark.parametrize(
    ("medium", "radius_deg"),
    [
        (Medium(), 42.08),
        (Medium(salinity_g_kg=35.0), 41.16),
        (Medium(refractive_index=1.5), 22.84),
    ],
    ids=str,
)
def test_primary_bow(medium, radius_deg):
    nm = np.array([589.3])
    index = medium.index(nm)
    got = 180.0 - np.degrees(bow(1, nm * 1e-9, index).angle_rad[0])
    assert got == pytest.approx(bow_radius_deg(index[0], 1), abs=1e-4)
    assert got == pytest.approx(radius_deg, abs=0.01)


@pytest.mark.parametrize("index", [1.2, 1.5, 1.9])
def test_bows_of_any_index(index):
    for reflections in (1, 2):
        the_bow = bow(reflections, np.array([5e-7]), np.array([index]))
        got = abs(180.0 - np.degrees(the_bow.angle_rad[0]))
        assert got == pytest.approx(bow_radius_deg(index, reflections), abs=1e-3)
        assert np.isfinite(the_bow.strength[0])


@pytest.mark.parametrize(
    ("temperature_c", "salinity", "violet", "red"),
    [  # Austin and Halikas (1976) at 400 and 700 nm, as in Mobley, Light and Water, table 3.8
        (0.0, 0.0, 1.344186, 1.331084),
        (0.0, 35.0, 1.351415, 1.337906),
        (30.0, 0.0, 1.342081, 1.329128),
        (30.0, 35.0, 1.348752, 1.335316),
    ],
)
def test_index_of_the_sea(temperature_c, salinity, violet, red):
    got = Medium(temperature_c, salinity).index(np.array([400.0, 700.0]))
    assert got == pytest.approx([violet, red], abs=5e-5)


def test_units_of_airys_argument():
    # h^(1/3) with h = (p² - 1)² / p² · sqrt((p² - n²) / (n² - 1)³), p = 2: van de Hulst, 13.2.
    for index in (1.2, 1.333, 1.5, 1.9):
        h = 9.0 / 4.0 * np.sqrt((4.0 - index**2) / (index**2 - 1.0) ** 3)
        assert bow_unit(index) == pytest.approx(h ** (1.0 / 3.0), rel=1e-9)
    assert Medium(salinity_g_kg=40.0).bow_unit == Medium().bow_unit
