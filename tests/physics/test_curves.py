"""Curves through points, against SciPy's."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from rtbow.physics.curves import monotone_cubic, spline_shares


def test_the_spline_is_scipys():
    rng = np.random.default_rng(3)
    nodes, at = np.linspace(380.0, 780.0, 17), rng.uniform(380.0, 780.0, 200)
    values = rng.normal(size=(17, 3))
    found = spline_shares(nodes, np.append(at, [380.0, 780.0])) @ values
    expected = CubicSpline(nodes, values)(np.append(at, [380.0, 780.0]))
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10)


def test_the_monotone_cubic_is_scipys():
    rng = np.random.default_rng(4)
    for _ in range(20):
        nodes = np.cumsum(rng.uniform(0.1, 2.0, 9))
        values = rng.normal(size=9) * (rng.random(9) > 0.2)
        at = np.append(rng.uniform(nodes[0], nodes[-1], 100), nodes)
        expected = PchipInterpolator(nodes, values)(at)
        np.testing.assert_allclose(monotone_cubic(nodes, values, at), expected, atol=1e-12)
