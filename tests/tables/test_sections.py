"""The extinction efficiency of water drops against sums of the test's own, and its limit."""

import numpy as np
import pytest
from scipy.special import jv, yv

from rtbow.physics.drop.water import relative_index
from rtbow.tables.sections import extinction_efficiencies

# Extinction by exact theory, written out once more on SciPy's Bessel functions: Bohren and Huffman
# (1983), equations 4.53 and 4.62.


def coefficients(x, m):
    """a_n and b_n of a sphere of the size x and relative index m, n = 1, 2, ..."""
    orders = np.arange(0, int(x + 5.0 * np.cbrt(x) + 4.0))
    n = orders[1:]

    def with_slope(bessel, z):
        """z j_n(z) or z y_n(z), and its slope."""
        values = np.sqrt(0.5 * np.pi * z) * bessel(orders + 0.5, z)
        return values[1:], values[:-1] - n / z * values[1:]

    (outer, outer_slope), (inner, inner_slope) = with_slope(jv, x), with_slope(jv, m * x)
    second, second_slope = with_slope(yv, x)
    xi, xi_slope = outer + 1j * second, outer_slope + 1j * second_slope
    a = (m * inner * outer_slope - outer * inner_slope) / (m * inner * xi_slope - xi * inner_slope)
    b = (inner * outer_slope - m * outer * inner_slope) / (inner * xi_slope - m * xi * inner_slope)
    return a, b


def extinction(x, m):
    """Q_ext."""
    a, b = coefficients(x, m)
    n = np.arange(1, len(a) + 1)
    return 2.0 / x**2 * float(((2 * n + 1) * (a + b).real).sum())


def mean_over_spread(function, x, spread=0.02, count=141):
    """Mean of a function of the size over a log-normal spread about x."""
    t = np.linspace(-3.5, 3.5, count)
    weight = np.exp(-0.5 * t**2)
    values = np.array([function(float(size)) for size in x * np.exp(spread * t)])
    return np.tensordot(weight, values, axes=(0, 0)) / weight.sum()


NM = 550.0
INDEX = float(relative_index(np.array([NM]), 20.0)[0])


def efficiency(x, nm=NM):
    """The package's Q_ext at size parameters (n,)."""
    radius_m = np.asarray(x) * nm * 1e-9 / (2.0 * np.pi)
    return extinction_efficiencies(radius_m, np.array([nm]), 20.0)[:, 0]


@pytest.mark.parametrize("x", [20.0, 60.0, 100.0, 200.0, 400.0, 700.0])
def test_extinction_efficiency(x):
    """From cloud droplets, where Q swings between 1.8 and 2.5, to the limit of large drops."""
    exact = mean_over_spread(lambda size: extinction(size, INDEX), x)
    assert efficiency([x])[0] == pytest.approx(exact, rel=4e-4)  # 2e-4 at worst


@pytest.mark.parametrize("x", [2900.0, 5000.0])
def test_light_that_grazes_the_edge(x):
    """Q - 2 falls as x^(-2/3), by 1.9924 (Nussenzveig and Wiscombe): here from the sum itself."""
    exact = mean_over_spread(lambda size: extinction(size, INDEX), x, count=41)
    edge = (np.array([exact, efficiency([x])[0]]) - 2.0) * x ** (2.0 / 3.0)
    np.testing.assert_allclose(edge, 1.9924, rtol=0.05)


@pytest.mark.parametrize("nm", [380.0, 460.0, 500.0, 550.0, 780.0])
def test_extinction_has_no_step_where_the_limit_takes_over(nm):
    """Between sizes a hundred-thousandth apart Q changes by no more than the table's own noise."""
    q = efficiency(np.exp(np.arange(np.log(100.0), np.log(6000.0), 1e-5)), nm)
    assert np.abs(np.diff(q)).max() < 3.5e-4  # 2.7e-4, at x = 3000
