"""The index of water against the release's check values, and the bow angles that follow."""

import numpy as np
import pytest

from rtbow.physics.drop.water import iapws_index, relative_index, water_density

DENSITY_20C = 998.2063  # kg/m³ at 20 °C and 101325 Pa, IAPWS-95


def bow_radius_deg(index: float, reflections: int) -> float:
    """Angle from the antisolar point of the ray of least deviation, found by search."""
    b = np.linspace(0.7, 0.99, 200_001)
    turn = reflections * np.pi + 2.0 * np.arcsin(b) - 2.0 * (reflections + 1) * np.arcsin(b / index)
    k = int(np.argmin(turn))
    curve = np.polynomial.Polynomial.fit(b[k - 500 : k + 501], turn[k - 500 : k + 501], 4)
    least = min(curve(root.real) for root in curve.deriv().roots() if abs(root.real - b[k]) < 1e-3)
    return abs(180.0 - np.degrees(least))


@pytest.mark.parametrize(
    ("density", "temperature_k", "wavelength_um", "index"),
    [
        (997.047435, 298.15, 0.2265, 1.39277824),
        (30.4758534, 773.15, 0.5893, 1.00949307),
    ],
)
def test_check_values_of_the_release(density, temperature_k, wavelength_um, index):
    # IAPWS R9-97, section 5 (all digits given there).
    assert iapws_index(np.array(wavelength_um), temperature_k, density) == pytest.approx(
        index, abs=0.51e-8
    )


@pytest.mark.parametrize(
    ("wavelength_nm", "primary_deg", "secondary_deg"),
    [
        (400.0, 40.567, 53.621),
        (500.0, 41.529, 51.880),
        (589.3, 42.027, 50.982),
        (700.0, 42.440, 50.238),
    ],
)
def test_descartes_angles_in_vacuum(wavelength_nm, primary_deg, secondary_deg):
    index = float(iapws_index(np.array(wavelength_nm * 1e-3), 293.15, DENSITY_20C))
    # Published to three digits: half a unit of the last.
    assert bow_radius_deg(index, 1) == pytest.approx(primary_deg, abs=0.0006)
    assert bow_radius_deg(index, 2) == pytest.approx(secondary_deg, abs=0.0006)


@pytest.mark.parametrize("temperature_c", [0.0, 4.0, 10.0, 20.0, 30.0, 40.0])
def test_density(temperature_c):
    # Tanaka et al., Metrologia 38, 301 (2001): the CIPM's formula, 0 to 40 °C.
    t = temperature_c
    warmth = (t - 3.983035) ** 2 * (t + 301.797) / (522528.9 * (t + 69.34881))
    # Worst 0.0033 kg/m³, at 0 °C: Kell's fit is older. That is 1e-6 in the index.
    assert water_density(t) == pytest.approx(999.974950 * (1.0 - warmth), abs=0.004)


def test_density_at_room_temperature_in_digits():
    assert water_density(20.0) == pytest.approx(DENSITY_20C, abs=0.003)
    assert water_density(4.0) == pytest.approx(999.975, abs=0.004)


def test_water_is_densest_near_4_degrees():
    temperature = np.linspace(0.0, 10.0, 1001)
    densest = temperature[np.argmax([water_density(t) for t in temperature])]
    assert densest == pytest.approx(3.98, abs=0.02)


def test_supercooled_water_stays_smooth():
    # Handbooks' values for -10 and -20 °C, to the digits that they share.
    assert water_density(-10.0) == pytest.approx(998.1, abs=0.05)
    assert water_density(-20.0) == pytest.approx(993.6, abs=0.1)


@pytest.mark.parametrize(
    ("temperature_c", "index"), [(10.0, 1.33369), (20.0, 1.33299), (30.0, 1.33192)]
)
def test_relative_index_is_the_handbooks(temperature_c, index):
    # Tilton and Taylor, J. Res. NBS 20, 419 (1938): relative to air, sodium D line.
    # Worst 2.5e-5: the air is that of 15 °C at every temperature.
    got = relative_index(np.array([589.3]), temperature_c)
    assert got.shape == (1,)
    assert got[0] == pytest.approx(index, abs=4e-5)


def test_relative_index_is_that_of_vacuum_over_air():
    # Worst 7e-7: the density differs by 0.002 kg/m³.
    nm = np.array([380.0, 550.0, 780.0])
    vacuum = iapws_index(nm / 1000.0, 293.15, DENSITY_20C)
    np.testing.assert_allclose(relative_index(nm, 20.0) * 1.000277, vacuum, rtol=0.0, atol=1e-6)


def test_colder_water_bends_more():
    nm = np.array([400.0, 550.0, 700.0])
    cold, warm = relative_index(nm, 0.0), relative_index(nm, 30.0)
    assert np.all(cold > warm + 1e-3)
    assert np.all(np.diff(cold) < 0.0)
    # A higher index: the primary shrinks and the secondary widens, by 0.3 and 0.6 degrees.
    assert bow_radius_deg(cold[1], 1) < bow_radius_deg(warm[1], 1) - 0.2
    assert bow_radius_deg(cold[1], 2) > bow_radius_deg(warm[1], 2) + 0.4
