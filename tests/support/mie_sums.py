"""Extinction by exact theory, written out once more on SciPy's Bessel functions.

Bohren and Huffman (1983), equations 4.53 and 4.62; shares no code with rtbow.
"""

import numpy as np
from scipy.special import jv, yv


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
