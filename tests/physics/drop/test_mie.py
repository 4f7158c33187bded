"""Exact scattering against published 50-digit values, miepython and series summed by mpmath."""

import mpmath
import numpy as np
import pytest

from rtbow.physics.drop.mie import (
    DEBYE_SETS,
    amplitudes,
    coefficients,
    debye_coefficients,
    efficiency,
    intensities,
)

# x, m, Q_ext: computed with 50 digits by mpmath's Bessel functions.
EFFICIENCIES = [
    (100.0, 1.333, 2.11996783888),
    (1000.0, 1.333, 2.02281143322),
    (5000.0, 1.333, 2.00821639018),
    (24802.0, 1.3435, 2.00277178305),
]


@pytest.mark.parametrize(("x", "m", "expected"), EFFICIENCIES)
def test_extinction_efficiency(x, m, expected):
    assert efficiency(x, m) == pytest.approx(expected, rel=1e-10)


def test_amplitudes_of_a_drop_of_three_millimetres():
    # 50 digits again; a recurrence begun at |mx| + 15 would be wrong by order 1 here, and its
    # extinction would look right.
    s1, s2 = (s[0, 0] for s in amplitudes(24802.0, 1.3435, np.radians([137.9]), False))
    assert abs(s1) == pytest.approx(abs(-2067.326 + 2094.398j), rel=1e-6)
    assert s1.real == pytest.approx(-2067.326, abs=2e-3)
    assert s1.imag == pytest.approx(2094.398, abs=2e-3)
    assert s2.real == pytest.approx(825.1190, abs=2e-3)
    assert abs(s2.imag) == pytest.approx(1376.686, abs=2e-3)


def exact_coefficients(n, x, m):
    """a_n and b_n from Bohren and Huffman's equation 4.88, with 40 digits."""
    with mpmath.workdps(40):
        x, m = mpmath.mpf(x), mpmath.mpf(m)
        y = m * x

        def psi(k, z):
            return mpmath.sqrt(mpmath.pi * z / 2) * mpmath.besselj(k + mpmath.mpf(1) / 2, z)

        def xi(k, z):
            hankel = mpmath.besselj(k + 0.5, z) + 1j * mpmath.bessely(k + 0.5, z)
            return mpmath.sqrt(mpmath.pi * z / 2) * hankel

        slope = psi(n - 1, y) / psi(n, y) - n / y
        found = []
        for factor in (slope / m + n / x, slope * m + n / x):
            found.append(
                complex((factor * psi(n, x) - psi(n - 1, x)) / (factor * xi(n, x) - xi(n - 1, x)))
            )
        return found


@pytest.mark.parametrize("x", [0.7, 12.3, 100.0, 777.7])
def test_coefficients(x):
    a, b = coefficients(x, 1.336)
    for n in {1, 2, len(a) // 3 or 1, int(x) or 1, len(a)}:
        exact_a, exact_b = exact_coefficients(n, x, 1.336)
        assert abs(a[n - 1] - exact_a) < 1e-11
        assert abs(b[n - 1] - exact_b) < 1e-11


@pytest.mark.parametrize(("x", "m"), [(3.0, 1.33), (150.0, 1.34), (24802.0, 1.3435)])
def test_amplitudes_are_those_of_miepython(x, m):
    miepython = pytest.importorskip("miepython", reason="compared where it is installed")
    theta = np.radians(np.array([0.0, 0.3, 10.0, 90.0, 137.9, 179.0, 180.0]))
    theirs = miepython.S1_S2(complex(m, 0.0), x, np.cos(theta), norm="wiscombe")
    ours = amplitudes(x, m, theta, False)
    for one, other in zip(ours, theirs, strict=True):
        scale = np.abs(other).max()
        # Up to the sign of i; 2e-7 at worst.
        assert np.abs(np.abs(one[0]) - np.abs(other)).max() < 1e-6 * scale


@pytest.mark.parametrize("x", [100.0, 1000.0])
def test_extinction_is_the_forward_amplitude(x):
    # The optical theorem: Q_ext = 4 Re S(0) / x²; nothing of the series is shared but a and b.
    s1, s2 = (s[0, 0] for s in amplitudes(x, 1.333, np.array([0.0]), False))
    assert s1 == pytest.approx(s2, rel=1e-12)
    assert 4.0 * s1.real / x**2 == pytest.approx(efficiency(x, 1.333), rel=1e-10)


def test_scattered_light_is_what_extinction_takes():
    x, m = 40.0, 1.333
    nodes, weights = np.polynomial.legendre.leggauss(400)
    total = intensities(x, m, np.arccos(nodes), False).sum(axis=0) @ weights
    assert total / x**2 == pytest.approx(efficiency(x, m), rel=1e-10)


def test_debyes_orders_add_up_to_the_whole():
    """The first sets, and by the geometric series that they begin, all of them."""
    x, m = 500.0, 1.34
    a, b = coefficients(x, m)
    split_a, split_b = debye_coefficients(x, m)
    assert split_a.shape == (DEBYE_SETS, len(a))
    for whole, split in ((a, split_a), (b, split_b)):
        # Orders follow each other by one factor, the inner reflection, so that the rest of the
        # series is known from the first ones: p1 / (1 - factor).
        inner = split[2] / split[1]
        geometric = split[0] + split[1] / (1.0 - inner)
        strong = np.abs(split[1]) > 1e-9
        assert np.abs(geometric - whole)[strong].max() < 1e-10
        assert np.abs(split[3] - split[2] * inner)[strong].max() < 1e-12


def test_debyes_first_order_is_the_reflection_of_geometric_optics():
    # At the right angle, far from diffraction: Fresnel's reflection at 45 degrees, x²/4 R.
    x, m = 5000.0, 1.333
    i = np.pi / 4.0
    r = np.arcsin(np.sin(i) / m)
    fresnel = np.array(
        [np.sin(i - r) ** 2 / np.sin(i + r) ** 2, np.tan(i - r) ** 2 / np.tan(i + r) ** 2]
    )
    s1, s2 = amplitudes(x, m, np.array([np.pi / 2.0]), True)
    found = np.array([abs(s1[0, 0]) ** 2, abs(s2[0, 0]) ** 2])
    np.testing.assert_allclose(found, 0.25 * x**2 * fresnel, rtol=5e-3)


def test_rayleigh_limit():
    # |S1|² = x⁶ ((m² - 1) / (m² + 2))², |S2|² = cos² of it: Bohren and Huffman, section 5.1.
    x, m = 1e-2, 1.333
    theta = np.array([0.0, 1.0, 2.5])
    expected = x**6 * ((m**2 - 1.0) / (m**2 + 2.0)) ** 2
    got = intensities(x, m, theta, False)
    np.testing.assert_allclose(got[0], expected, rtol=1e-3)
    np.testing.assert_allclose(got[1], expected * np.cos(theta) ** 2, rtol=1e-3)
