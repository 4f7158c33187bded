"""Airy's bow against its textbook formula, derived here again, and against exact Mie peaks."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import airy

from rtbow.physics.drop.airy import (
    PRIMARY_UNIT,
    RADIUS_POWER,
    SCALE_POWER,
    airy_squared,
    airy_squared_and_integral,
    bow,
    bows,
    descartes_ray,
    unit_angle,
)
from rtbow.physics.drop.water import relative_index
from textbook import cross_section, stationary_ray

NM = np.array([380.0, 450.0, 550.0, 650.0, 780.0])
INDEX = np.array([1.3435, 1.3392, 1.3347, 1.3320, 1.3290])


def section(reflections, wavelength_m, index, radius_m, theta):
    """The same through the module's five numbers."""
    the_bow = bow(reflections, np.array([wavelength_m]), np.array([index]))
    z = the_bow.scale * radius_m**SCALE_POWER * the_bow.side * (theta - the_bow.angle_rad)
    return float((the_bow.strength * radius_m**RADIUS_POWER * airy_squared(z))[0])


def peak(reflections, wavelength_m, index, radius_m):
    """Angle (degrees) and height of the first fringe, by search."""
    near = (137.0, 143.0) if reflections == 1 else (124.0, 130.5)
    grid = np.linspace(*near, 4001)
    values = [section(reflections, wavelength_m, index, radius_m, np.radians(t)) for t in grid]
    top = grid[int(np.argmax(values))]
    found = minimize_scalar(
        lambda t: -section(reflections, wavelength_m, index, radius_m, np.radians(t)),
        bounds=(top - 0.01, top + 0.01),
        method="bounded",
        options={"xatol": 1e-7},
    )
    return found.x, -found.fun


@pytest.mark.parametrize("reflections", [1, 2])
@pytest.mark.parametrize("index", INDEX)
def test_descartes_ray_is_stationary(reflections, index):
    i, r, turn = descartes_ray(reflections, np.array(index))
    b, least, _ = stationary_ray(index, reflections)
    assert np.sin(i) == pytest.approx(b, abs=1e-14)
    assert np.sin(i) == pytest.approx(index * np.sin(r), abs=1e-14)
    assert turn == pytest.approx(least, abs=1e-13)


@pytest.mark.parametrize("reflections", [1, 2])
def test_bow_angle_and_side(reflections):
    got = bow(reflections, NM * 1e-9, INDEX)
    for angle, index in zip(got.angle_rad, INDEX, strict=True):
        least = stationary_ray(index, reflections)[1]
        # The turn of the secondary's ray exceeds pi: it arrives from the other side.
        assert angle == pytest.approx(least if reflections == 1 else 2.0 * np.pi - least, abs=1e-13)
    # The bright side is towards the antisolar point for the primary, away from it for the other.
    assert got.side == (1.0 if reflections == 1 else -1.0)
    light = section(reflections, NM[2] * 1e-9, INDEX[2], 5e-4, got.angle_rad[2] + got.side * 0.005)
    dark = section(reflections, NM[2] * 1e-9, INDEX[2], 5e-4, got.angle_rad[2] - got.side * 0.04)
    assert light > 1e3 * dark
    assert got.pole_rad == (np.pi if reflections == 1 else 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("reflections", [1, 2])
@pytest.mark.parametrize("radius_um", [10.0, 100.0, 1500.0])
@pytest.mark.parametrize("k", range(len(NM)))
def test_cross_section_is_the_formulas(reflections, radius_um, k):
    wavelength, radius = NM[k] * 1e-9, radius_um * 1e-6
    turn = stationary_ray(INDEX[k], reflections)[1]
    edge = turn if reflections == 1 else 2.0 * np.pi - turn
    _, top = peak(reflections, wavelength, INDEX[k], radius)
    for theta in (edge, edge - 0.02, edge + 0.02, edge + 0.1, edge - 0.1, 0.1, 2.0, 3.1):
        expected = cross_section(INDEX[k], wavelength, radius, theta, reflections)
        got = section(reflections, wavelength, INDEX[k], radius, theta)
        # Worst 2e-11 of the peak: Airy's function at arguments of hundreds, in float64.
        assert got == pytest.approx(expected, abs=1e-10 * top, rel=0.0)


@pytest.mark.parametrize(("reflections", "component"), [(1, 0.04), (2, 0.11)])
def test_polarisation_is_that_of_the_fresnel_terms(reflections, component):
    # The primary's light is 96 % and the secondary's 90 % polarised along the bow, van de Hulst,
    # section 13.23: parallel to perpendicular 0.04 and 0.11.
    got = bow(reflections, np.array([589e-9]), np.array([4.0 / 3.0]))
    assert (got.parallel / got.perpendicular)[0] == pytest.approx(component, abs=0.01)
    assert got.strength == pytest.approx(0.5 * (got.parallel + got.perpendicular))


@pytest.mark.parametrize(
    ("wavelength_nm", "airy_m2_sr", "mie_m2_sr"),
    [(450.0, 4.23e-9, 4.27e-9), (550.0, 3.85e-9, 3.88e-9), (650.0, 3.59e-9, 3.60e-9)],
)
def test_primary_peak_of_100_um(wavelength_nm, airy_m2_sr, mie_m2_sr):
    # The Mie values: exact theory, p = 2 peak in air, a size spread of 2 % averaged out.
    index = float(relative_index(np.array(wavelength_nm), 20.0))
    _, height = peak(1, wavelength_nm * 1e-9, index, 100e-6)
    assert height == pytest.approx(airy_m2_sr, abs=0.006e-9)
    assert height == pytest.approx(mie_m2_sr, rel=0.012)  # worst 1.0 %


@pytest.mark.slow
@pytest.mark.parametrize(
    ("radius_um", "primary_deg", "secondary_deg", "mie_primary_deg", "mie_secondary_deg"),
    [
        (10.0, 142.36, None, 141.72, None),
        (50.0, 139.60, 126.11, 139.50, 126.35),
        (100.0, 139.07, 127.05, 139.03, 127.21),
        (250.0, 138.66, 127.79, 138.65, 127.81),
        (500.0, 138.47, 128.12, 138.48, 128.12),
        (1000.0, 138.36, None, 138.36, None),
    ],
)
def test_peak_angles(radius_um, primary_deg, secondary_deg, mie_primary_deg, mie_secondary_deg):
    # Mie: exact theory with a size spread of 3 %. Airy's is a theory of large drops: what it
    # misses shrinks as a^(-2/3) to a^(-4/3), from 0.64 degrees at 10 µm to 0.01.
    room = 0.65 * (10.0 / radius_um) + 0.015
    for reflections, airy_deg, mie_deg in (
        (1, primary_deg, mie_primary_deg),
        (2, secondary_deg, mie_secondary_deg),
    ):
        if airy_deg is not None:
            got, _ = peak(reflections, 550e-9, 1.33468, radius_um * 1e-6)
            assert got == pytest.approx(airy_deg, abs=0.011)
            # The secondary's error is some 2.5 times the primary's.
            assert got == pytest.approx(mie_deg, abs=room * (1.0 if reflections == 1 else 2.5))


def test_first_fringe_of_airys_square():
    # Ai'(t) = 0 first at t = -1.0187929716 (Abramowitz and Stegun, table 10.13).
    z = np.linspace(0.0, 2.0, 200_001)
    assert z[np.argmax(airy_squared(z))] == pytest.approx(1.0187929716, abs=1e-5)
    assert airy_squared(np.array(1.0187929716)) == pytest.approx(0.53565666**2, abs=1e-8)


def test_airys_square_and_integral_by_mpmath():
    z = np.array([-9.0, -2.0, 0.0, 1.0187929716, 5.0, 16.0, 80.0, 300.0])
    value, integral = airy_squared_and_integral(z)
    for at, got, area in zip(z, value, integral, strict=True):
        assert got == pytest.approx(float(mpmath.airyai(-at)) ** 2, rel=1e-10, abs=1e-15)
        slope = float(mpmath.airyai(-at, derivative=1))
        assert area == pytest.approx(at * float(mpmath.airyai(-at)) ** 2 + slope**2, rel=1e-9)


@pytest.mark.parametrize("z", [-2.0, 0.0, 1.0, 3.7, 12.0])
def test_the_integral_is_one(z):
    expected, _ = quad(lambda t: airy(-t)[0] ** 2, -14.0, z, limit=400, epsabs=1e-13)
    assert airy_squared_and_integral(np.array(z))[1] == pytest.approx(expected, rel=1e-8)


def test_powers_of_the_radius():
    # z goes as x^(2/3) and C as a² x^(1/3): from x/c with c as x^(1/3), and x³/c²/k².
    assert pytest.approx(2 / 3) == SCALE_POWER
    assert pytest.approx(7 / 3) == RADIUS_POWER


@pytest.mark.parametrize("temperature_c", [-12.0, 20.0, 60.0])
@pytest.mark.parametrize("nm", [380.0, 550.0, 780.0])
@pytest.mark.parametrize("radius_m", [10e-6, 1500e-6])
def test_unit_of_airys_argument(radius_m, nm, temperature_c):
    """One over the bow's own scale, for any drop, wavelength and water."""
    index = relative_index(np.array([nm]), temperature_c)
    size = 2.0 * np.pi * radius_m / (nm * 1e-9)
    exact = [1.0 / (b.scale * radius_m**SCALE_POWER) for b in bows((1, 2), nm * 1e-9, index)]
    # 2.5 % at the violet end of cold water, -1.8 % at the red end of hot water.
    assert unit_angle(size) == pytest.approx(exact[0][0], rel=0.03)
    assert 1.74 < float(exact[1][0]) / unit_angle(size) < 1.82  # the secondary's: 2.97 to 3.09
    assert unit_angle(size, 0.5) == pytest.approx(0.5 * unit_angle(size), rel=1e-15)
    if temperature_c == 20.0 and nm == 550.0:
        assert unit_angle(size) == pytest.approx(exact[0][0], rel=0.005)


def test_unit_is_where_the_first_dark_ring_says():
    """From the textbook's ray: the wavefront's curvature h gives (h/2)^(1/3) x^(-2/3)."""
    _, _, second = stationary_ray(1.3343, 1)
    assert pytest.approx((0.5 * second) ** (1.0 / 3.0), rel=0.005) == PRIMARY_UNIT


def test_bows_are_each_of_their_order():
    both = bows((1, 2), NM * 1e-9, INDEX)
    assert [b.reflections for b in both] == [1, 2]
    for one, k in zip(both, (1, 2), strict=True):
        np.testing.assert_array_equal(one.scale, bow(k, NM * 1e-9, INDEX).scale)
    # The secondary is fainter and wider.
    assert np.all(both[1].strength < both[0].strength)
    assert np.all(both[1].scale < both[0].scale)
