"""The extinction efficiency of water drops against sums of the test's own, and its limit."""

import numpy as np
import pytest

from mie_sums import extinction, mean_over_spread
from rtbow.physics.drop.water import relative_index
from rtbow.tables.sections import extinction_efficiencies

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
