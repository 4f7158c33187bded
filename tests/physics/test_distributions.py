"""Moments of size distributions against quadrature, and parameters against their closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import gamma

from rtbow.physics.distributions import (
    LEAST_POWER,
    GeneralGamma,
    Lognormal,
    Normal,
    effective_variance,
    modified_gamma,
    ulbrich_moment,
)


def share(density, power, low, high):
    """Share of a moment by quadrature over ln(radius), in pieces."""
    edges = np.log([1e-16, 1e-9, 1e-5, 1e-2, low, 30.0, 300.0, 1500.0, high, 2e4, 1e6, 1e8])
    parts = [
        quad(lambda t: np.exp((power + 1.0) * t) * density(np.exp(t)), a, b, limit=200)[0]
        for a, b in pairwise(edges)
    ]
    return sum(parts[4:8]) / sum(parts)


@pytest.mark.parametrize("power", [0, 2, 3])
@pytest.mark.parametrize(
    ("formula", "density"),
    [
        (GeneralGamma(-0.5, 200.0), lambda r: r**-0.5 * np.exp(-r / 200.0)),
        (GeneralGamma(2.0, 1000.0), lambda r: r**2 * np.exp(-r / 1000.0)),
        (GeneralGamma(1.0, 12.5, 0.5), lambda r: r * np.exp(-np.sqrt(r / 12.5))),
        (GeneralGamma(0.3, 4000.0, 3.0), lambda r: r**0.3 * np.exp(-((r / 4000.0) ** 3))),
        (Lognormal(1.2, 0.79), lambda r: np.exp(-0.5 * (np.log(r / 1.2) / 0.79) ** 2) / r),
        (Lognormal(1000.0, 1.0), lambda r: np.exp(-0.5 * np.log(r / 1000.0) ** 2) / r),
        (Normal(20.0, 100.0), lambda r: np.exp(-0.5 * ((r - 20.0) / 100.0) ** 2)),
        (Normal(4500.0, 400.0), lambda r: np.exp(-0.5 * ((r - 4500.0) / 400.0) ** 2)),
    ],
    ids=lambda one: "density" if callable(one) else str(one),
)
def test_shares_of_moments(formula, density, power):
    expected = share(density, power, 1.0, 5000.0)
    assert formula.share_within(power, 1.0, 5000.0) == pytest.approx(expected, abs=1e-6)
    radius = np.array([3.0, 40.0, 900.0])
    got = np.exp(formula.log_density(radius))
    np.testing.assert_allclose(got / got[1], density(radius) / density(radius[1]), rtol=1e-10)


def test_an_infinite_number_has_no_share():
    assert GeneralGamma(-1.5, 200.0).share_within(0, 1.0, 5000.0) == 0.0
    assert 0.9 < GeneralGamma(-1.5, 200.0).share_within(2, 1.0, 5000.0) < 1.0


def test_rain_m():
    # Deirmendjian's Rain M is r exp(-8.9443 r^0.5), r in mm: its moments are factorials.
    variance = 5040.0 * 39916800.0 / 362880.0**2 - 1.0
    assert effective_variance(1.0, 0.5) == pytest.approx(variance, rel=1e-12)
    formula = modified_gamma(900.0, variance, 0.5)
    assert formula.alpha == pytest.approx(1.0, abs=1e-9)
    # 9!/7! / 8.9443² mm = 0.9 mm, and the scale is 1 mm / 8.9443².
    assert formula.scale_um == pytest.approx(1000.0 / 8.9443**2, rel=1e-4)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0, 5.0])
def test_parameters_give_the_effective_radius_and_variance(exponent):
    for variance in (1e-4, 0.1, effective_variance(LEAST_POWER, exponent)):
        made = modified_gamma(40.0, variance, exponent)
        if variance > 1e-3:  # beyond, the gamma function is beyond float64
            m2, m3, m4 = (
                gamma((made.alpha + k + 1.0) / exponent) * made.scale_um**k for k in (2, 3, 4)
            )
            assert m3 / m2 == pytest.approx(40.0, rel=1e-9)
            assert m2 * m4 / m3**2 - 1.0 == pytest.approx(variance, rel=1e-6)
        assert made.alpha >= LEAST_POWER - 1e-6


def test_ulbrichs_moments():
    # 8000 exp(-2.5 D): 8000/2.5 drops, and 2 · 8000/2.5³ of diameter².
    assert ulbrich_moment(8000.0, 0.0, 2.5, 0) == pytest.approx(3200.0)
    assert ulbrich_moment(8000.0, 0.0, 2.5, 2) == pytest.approx(1024.0)
    value, _ = quad(lambda d: 5e3 * d**-0.5 * np.exp(-2.5 * d), 0.0, np.inf)
    assert ulbrich_moment(5e3, -0.5, 2.5, 0) == pytest.approx(value, rel=1e-6)
    assert ulbrich_moment(1e90, 90.0, 1e-5, 0) == np.inf
