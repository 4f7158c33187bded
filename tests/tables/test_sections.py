"""The extinction efficiency of water drops against sums of the test's own, and its limit."""

import numpy as np
import pytest
from scipy.special import jv, yv

from rtbow.base.errors import InputError
from rtbow.physics.drop import mie
from rtbow.physics.drop.airy import bow
from rtbow.physics.drop.medium import Medium
from rtbow.physics.drop.water import relative_index
from rtbow.tables.mie.axes import INDEX_RANGE
from rtbow.tables.mie.efficiency import extinction_efficiencies
from rtbow.tables.mie.lookup import index_range_of, standard_axes

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
    return extinction_efficiencies(radius_m, np.array([nm]), Medium())[:, 0]


@pytest.mark.slow
@pytest.mark.parametrize("x", [20.0, 60.0, 100.0, 200.0, 400.0, 700.0])
def test_extinction_efficiency(x):
    """From cloud droplets, where Q swings between 1.8 and 2.5, to the limit of large drops."""
    exact = mean_over_spread(lambda size: extinction(size, INDEX), x)
    assert efficiency([x])[0] == pytest.approx(exact, rel=4e-4)  # 2e-4 at worst


@pytest.mark.slow
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


@pytest.mark.parametrize(
    ("x", "expected"), [(10.0, 2.881999), (100.0, 2.094388), (1000.0, 2.013945)]
)
def test_extinction_of_glass(x, expected):
    """Wiscombe's published digits for an index of 1.5 (MIEV0, 1979), and their mean over 2 %."""
    assert mie.efficiency(x, 1.5) == pytest.approx(expected, abs=1e-6)
    around = x * np.exp(0.02 * np.linspace(-3.5, 3.5, 1501))
    weight = np.exp(-0.5 * np.linspace(-3.5, 3.5, 1501) ** 2)
    mean = np.average([mie.efficiency(at, 1.5) for at in around], weights=weight)
    glass = Medium(refractive_index=1.5)
    radius_m = np.array([x * 550e-9 / (2.0 * np.pi)])
    got = extinction_efficiencies(radius_m, np.array([550.0]), glass)[0, 0]
    assert got == pytest.approx(mean, rel=2e-3)


@pytest.mark.slow
def test_salt_water_has_efficiencies_of_its_own_index():
    radius_m, nm = np.array([1.5e-6]), np.array([400.0])
    sea, fresh = (
        extinction_efficiencies(radius_m, nm, medium)[0, 0]
        for medium in (Medium(salinity_g_kg=35.0), Medium())
    )
    x = 2.0 * np.pi * radius_m[0] / 400e-9 * np.exp(0.02 * np.linspace(-3.5, 3.5, 801))
    weight = np.exp(-0.5 * np.linspace(-3.5, 3.5, 801) ** 2)
    m = float(Medium(salinity_g_kg=35.0).index(nm)[0])
    assert sea == pytest.approx(
        np.average([mie.efficiency(a, m) for a in x], weights=weight), rel=1e-3
    )
    assert abs(sea - fresh) > 0.01


@pytest.mark.parametrize("m", [1.25, 1.5, 1.8])
def test_one_index_has_a_layout_of_its_own(m):
    axes = standard_axes(0.1, index_range_of(np.array([m, m])))
    assert axes.index_nodes == pytest.approx([m])
    theta = axes.angles(m)
    np.testing.assert_allclose(axes.angle_places(theta, m), np.arange(len(theta)), atol=1e-6)
    # Nodes are densest about the bows of that index.
    for reflections in (1, 2):
        edge = float(bow(reflections, np.array(1e-6), np.array(m)).angle_rad)
        gap = np.diff(theta)[np.searchsorted(theta, edge) - 1]
        assert gap < 0.06 * np.median(np.diff(theta)[theta[1:] < 1.0]) or gap < 1e-3


def test_indices_that_no_table_holds():
    assert index_range_of(np.array([1.33, 1.34])) == INDEX_RANGE
    assert index_range_of(np.array([1.5])) == (1.5, 1.5)
    low, high = index_range_of(Medium(0.0, 40.0).index(np.array([380.0, 780.0])))
    assert low < 1.3372 < 1.3548 < high
    for temperature_c in (0.0, 10.0, 20.0, 30.0):
        for salinity in (0.5, 5.0, 15.0, 20.0, 25.0, 40.0):
            index = Medium(temperature_c, salinity).index(np.array([380.0, 780.0]))
            low, high = index_range_of(index)
            assert low <= index.min() < index.max() <= high
    with pytest.raises(InputError, match="theory mie holds"):
        index_range_of(np.array([1.4, 1.5]))
