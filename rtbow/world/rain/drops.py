"""Size distributions of a scene: as sizes that stand for one, or as drops drawn at grid points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.physics.sizes import MARSHALL_PALMER_N0_M4, Sizes, marshall_palmer, marshall_palmer_slope
from rtbow.scene.droplets import Density
from rtbow.scene.radius import (
    ConstantRadius,
    GammaRadius,
    LognormalRadius,
    MarshallPalmerRadius,
    ModifiedGammaRadius,
    NormalRadius,
    Radius,
    UniformRadius,
)

_FINE_STEP = 1e-3
"""Step in ln(radius) on which distributions are tabulated."""
_NODE_STEP = 0.01
"""Step in ln(radius) of the sizes that stand for a distribution: half the width of the exact
table's own spread; Airy's function is averaged over each step."""
_LEFT_OUT = 1e-6
"""A distribution is cut off at each end by this share of the drops' area."""


def _modified_gamma_slopes(radius: ModifiedGammaRadius) -> tuple[float, float]:
    """Exponent alpha and rate b [µm^-gamma] of r^alpha exp(-b r^gamma).

    Moments are Gamma((alpha + k + 1) / gamma) up to powers of b; the effective variance
    M2 M4 / M3² - 1 falls with alpha, so that it has one solution.
    """
    from scipy.optimize import brentq
    from scipy.special import gammaln

    g = radius.exponent

    def variance(alpha: float) -> float:
        log_moment = [gammaln((alpha + k + 1.0) / g) for k in (2, 3, 4)]
        return float(np.expm1(log_moment[0] + log_moment[2] - 2.0 * log_moment[1]))

    # From all but a spike at zero to all but a line.
    low, high = -2.9, 4.0 / (g * radius.effective_variance) + 10.0
    while variance(high) > radius.effective_variance:
        high *= 2.0
    alpha = float(
        brentq(lambda a: variance(a) - radius.effective_variance, low, high)
        if variance(low) > radius.effective_variance
        else low
    )
    ratio = np.exp(gammaln((alpha + 4.0) / g) - gammaln((alpha + 3.0) / g))
    return alpha, float((ratio / radius.effective_radius_um) ** g)


def _log_density(radius: Radius, rain_rate_mm_h: float | None) -> Callable[[Array], Array]:
    """Logarithm of the number of drops per µm of radius, up to a constant."""
    match radius:
        case UniformRadius():
            return np.zeros_like
        case NormalRadius():
            return lambda a: -0.5 * ((a - radius.mean_um) / radius.std_um) ** 2
        case LognormalRadius():
            return lambda a: -np.log(a) - 0.5 * (np.log(a / radius.median_um) / radius.log_std) ** 2
        case GammaRadius():
            # Hansen and Travis, Space Sci. Rev. 16, 527 (1974), equation 2.56.
            v = radius.effective_variance
            return lambda a: (1.0 - 3.0 * v) / v * np.log(a) - a / (radius.effective_radius_um * v)
        case ModifiedGammaRadius():
            # Deirmendjian, Electromagnetic Scattering on Spherical Polydispersions (1969).
            alpha, rate = _modified_gamma_slopes(radius)
            return lambda a: alpha * np.log(a) - rate * a**radius.exponent
        case MarshallPalmerRadius():
            assert rain_rate_mm_h is not None  # the scene checks that it goes with it
            slope = marshall_palmer_slope(rain_rate_mm_h)
            return lambda a: -slope * 2e-6 * a
        case ConstantRadius():
            raise AssertionError("one radius has no density")


def _support(radius: Radius) -> tuple[float, float]:
    if isinstance(radius, UniformRadius | MarshallPalmerRadius):
        return radius.min_um, radius.max_um
    return MIN_RADIUS_UM, MAX_RADIUS_UM


def _tabulated(radius: Radius, rain_rate_mm_h: float | None) -> tuple[Array, Array]:
    """Radii (µm) evenly in the logarithm, and the number of drops per ln(radius) there."""
    low, high = _support(radius)
    step = _FINE_STEP
    if isinstance(radius, NormalRadius):
        step = min(step, 0.1 * radius.std_um / radius.mean_um)
    count = max(64, int(np.ceil(np.log(high / low) / step)))
    at = np.geomspace(low, high, count + 1)
    log_number = _log_density(radius, rain_rate_mm_h)(at) + np.log(at)
    return floats(at), floats(np.exp(log_number - log_number.max()))


def distribution(radius: Radius, density: Density) -> Sizes:
    """Give a whole distribution as a set of sizes.

    Args:
        radius: the distribution of radii.
        density: the number of drops, or the rain rate.

    Returns:
        Sizes evenly in ln(radius), each with the number of drops around it; what is cut off at
        the ends is a millionth of the drops' area.
    """
    if isinstance(radius, ConstantRadius):
        return Sizes(
            np.array([radius.radius_um * 1e-6]), np.array([1.0]), density.number_per_m3 or 0.0
        )
    at, number = _tabulated(radius, density.rain_rate_mm_h)
    # Area decides what may be left out.
    area = np.cumsum(number * at**2)
    first = int(np.searchsorted(area, _LEFT_OUT * area[-1]))
    last = int(np.searchsorted(area, (1.0 - _LEFT_OUT) * area[-1]))
    low, high = at[max(first - 1, 0)], at[min(last + 1, len(at) - 1)]
    count = max(8, int(np.ceil(np.log(high / low) / _NODE_STEP)))
    edges = np.geomspace(low, high, count + 1)
    # Each size stands for the drops between two edges, with their mean area.
    step = np.log(at[1] / at[0])
    drops, areas = (
        np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * step)])
        for f in (number, number * at**2)
    )
    log_at, log_edges = np.log(at), np.log(edges)
    amount = np.diff(np.interp(log_edges, log_at, drops))
    surface = np.diff(np.interp(log_edges, log_at, areas))
    kept = amount > 0.0
    radius_um = np.sqrt(surface[kept] / amount[kept])
    total = density.number_per_m3 or 0.0
    if isinstance(radius, MarshallPalmerRadius):
        assert density.rain_rate_mm_h is not None
        slope = marshall_palmer_slope(density.rain_rate_mm_h)
        ends = np.exp(-slope * 2e-6 * np.array([radius.min_um, radius.max_um]))
        total = float(MARSHALL_PALMER_N0_M4 / slope * (ends[0] - ends[1]))
    # What is cut off by area may be many of the small drops.
    return Sizes(
        radius_um * 1e-6, amount[kept] / amount.sum(), total * float(amount.sum() / drops[-1])
    )


def quantiles(radius: Radius, share: Array) -> Array:
    """Give the radii (µm) below which shares (n,) of the drops lie."""
    at, number = _tabulated(radius, None)
    step = np.log(at[1] / at[0])
    drops = np.concatenate([[0.0], np.cumsum(0.5 * (number[1:] + number[:-1]) * step)])
    # Where hardly any drops are, shares do not grow in float64.
    rising = np.concatenate([[True], np.diff(drops) > 0.0])
    return floats(np.exp(np.interp(share * drops[-1], drops[rising], np.log(at)[rising])))


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
        case MarshallPalmerRadius():
            assert density.rain_rate_mm_h is not None  # the scene checks that it goes with it
            radii_um = rng.uniform(radius.min_um, radius.max_um, count)
            width_m = 2e-6 * (radius.max_um - radius.min_um)
            number = width_m * marshall_palmer(2e-6 * radii_um, density.rain_rate_mm_h)
        case _:
            # By inversion of the share of the whole: no loop that might not end.
            radii_um = quantiles(radius, rng.random(count))
    return radii_um * 1e-6, number
