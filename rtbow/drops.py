"""Drop sizes: radii and number densities drawn at the points of a grid."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from rtbow.arrays import Array
from rtbow.constants import MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.scene import (
    ConstantRadius,
    Density,
    MarshallPalmerRadius,
    NormalRadius,
    Radius,
    UniformRadius,
)

MARSHALL_PALMER_N0_M4 = 8e6
"""N0 of equation 1: 0.08 cm⁻⁴ = 8e6 drops per m³ and per m of diameter."""


def marshall_palmer_slope(rain_rate_mm_h: float) -> float:
    """Give Lambda of equation 1 in m⁻¹: 41 R^-0.21 per cm of diameter."""
    return float(4100.0 * rain_rate_mm_h**-0.21)


def marshall_palmer(diameter_m: Array, rain_rate_mm_h: float) -> Array:
    """Give N_D, drops per m³ and per m of diameter, same shape as ``diameter_m``.

    Source: Marshall and Palmer, J. Meteorol. 5, 165 (1948); equation 1 of Fujiwara et al.
    """
    d = np.asarray(diameter_m, dtype=np.float64)
    return MARSHALL_PALMER_N0_M4 * np.exp(-marshall_palmer_slope(rain_rate_mm_h) * d)


def _normal_radii(rng: Generator, mean: float, std: float, count: int) -> Array:
    """Draw from a normal distribution cut to the allowed radii."""
    # By inversion of its share of the whole: no loop that might not end.
    from scipy.stats import truncnorm

    low, high = (MIN_RADIUS_UM - mean) / std, (MAX_RADIUS_UM - mean) / std
    return np.asarray(truncnorm.ppf(rng.random(count), low, high) * std + mean)


def draw_drops(radius: Radius, density: Density, count: int, rng: Generator) -> tuple[Array, Array]:
    """Draw radius and number density at ``count`` grid points.

    In ``marshall-palmer`` radii are drawn evenly and each point carries the density of its own
    size class, so that the mean over the points is the whole distribution.

    Args:
        radius: the distribution of radii.
        density: the number of drops, or the rain rate.
        count: grid points.
        rng: source of the draws; the same seed gives the same drops.

    Returns:
        Radii in m and densities in m⁻³, each (count,).
    """
    number = np.full(count, density.number_per_m3 or 0.0)
    match radius:
        case ConstantRadius():
            radii_um = np.full(count, radius.radius_um)
        case UniformRadius():
            radii_um = rng.uniform(radius.min_um, radius.max_um, count)
        case NormalRadius():
            radii_um = _normal_radii(rng, radius.mean_um, radius.std_um, count)
        case MarshallPalmerRadius():
            assert density.rain_rate_mm_h is not None  # the scene checks that it goes with it
            radii_um = rng.uniform(radius.min_um, radius.max_um, count)
            width_m = 2e-6 * (radius.max_um - radius.min_um)
            number = width_m * marshall_palmer(2e-6 * radii_um, density.rain_rate_mm_h)
    return radii_um * 1e-6, number
