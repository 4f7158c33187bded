"""Size distributions of a scene: as sizes that stand for one, or as drops drawn at grid points.

A formula's number of drops counts every radius above 0. Those outside the radii that can be drawn
are left out, and :func:`left_out` says how much of each moment goes with them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.physics.distributions import (
    Formula,
    GeneralGamma,
    Lognormal,
    Normal,
    modified_gamma,
    ulbrich_moment,
)
from rtbow.physics.size_classes import SizeClasses
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
    TableRadius,
    UniformRadius,
)
from rtbow.world.rain.size_file import read_size_file

_FINE_STEP = 1e-3
"""Step in ln(radius) on which distributions are tabulated."""
_NODE_STEP = 0.01
"""Step in ln(radius) of the sizes that stand for a distribution: half the width of the exact
table's own spread; Airy's function is averaged over each step."""
_LEFT_OUT = 1e-6
"""A distribution is cut off at each end by this share of the drops' area..."""
_LEFT_OUT_NUMBER = 1e-4
"""...and by no more than this share of their number, which small drops may have without area, and
of their volume."""
_TOLD = 1e-3
"""Shares of a moment beyond the radii that can be drawn are told from this on."""
_MOMENTS = {0: "number", 2: "cross-section area", 3: "liquid water"}


@dataclass(frozen=True)
class _Cumulated:
    """A distribution over the radii that can be drawn, on a fine grid.

    Attributes:
        radius_um: (n,), evenly in the logarithm.
        number: drops per ln(radius) there (n,), in any unit.
        drops: number of drops up to each radius (n,).
        areas: sum of their radius² (n,).
    """

    radius_um: Array
    number: Array
    drops: Array
    areas: Array

    @property
    def ends_um(self) -> tuple[float, float]:
        """The radii beyond which hardly any area, number and volume is left."""
        at, last = self.radius_um, len(self.radius_um) - 1
        # Area decides what may be left out, and the others where area hardly has them.
        first, end = _cuts(self.number * at**2, _LEFT_OUT)
        first = min(first, _cuts(self.number, _LEFT_OUT_NUMBER)[0])
        end = max(end, _cuts(self.number * at**3, _LEFT_OUT_NUMBER)[1])
        return float(at[max(first - 1, 0)]), float(at[min(end + 1, last)])


def _cuts(moment: Array, share: float) -> tuple[int, int]:
    """Places of a moment per ln(radius) between which all but a share at each end lies."""
    up_to = np.cumsum(moment)
    low = int(np.searchsorted(up_to, share * up_to[-1]))
    return low, int(np.searchsorted(up_to, (1.0 - share) * up_to[-1]))


def _formula(radius: Radius) -> Formula | None:
    """Give the formula of a distribution that goes on beyond the radii that can be drawn."""
    match radius:
        case NormalRadius():
            return Normal(radius.mean_um, radius.std_um)
        case LognormalRadius():
            return Lognormal(radius.median_um, radius.log_std)
        case GammaRadius(effective_radius_um=float(a), effective_variance=float(v)):
            return GeneralGamma((1.0 - 3.0 * v) / v, a * v)
        case GammaRadius(mu=float(mu), lambda_per_mm=float(rate)):
            return GeneralGamma(mu, 500.0 / rate)
        case ModifiedGammaRadius(effective_radius_um=a, effective_variance=v, exponent=g):
            return modified_gamma(a, v, g)
    return None


def _log_density(radius: Radius, rain_rate_mm_h: float | None) -> Callable[[Array], Array]:
    """Logarithm of the number of drops per µm of radius, up to a constant."""
    match radius:
        case UniformRadius():
            return np.zeros_like
        case MarshallPalmerRadius():
            assert rain_rate_mm_h is not None  # the scene checks that it goes with it
            slope = marshall_palmer_slope(rain_rate_mm_h)
            return lambda a: -slope * 2e-6 * a
    formula = _formula(radius)
    assert formula is not None  # one radius and a table have no density
    return formula.log_density


def _support(radius: Radius) -> tuple[float, float]:
    if isinstance(radius, UniformRadius | MarshallPalmerRadius):
        return radius.min_um, radius.max_um
    return MIN_RADIUS_UM, MAX_RADIUS_UM


def _cumulated(radius: Radius, rain_rate_mm_h: float | None) -> _Cumulated:
    """Tabulate a formula."""
    low, high = _support(radius)
    step = _FINE_STEP
    if isinstance(radius, NormalRadius):
        step = min(step, 0.1 * radius.std_um / radius.mean_um)
    count = max(64, int(np.ceil(np.log(high / low) / step)))
    at = np.geomspace(low, high, count + 1)
    log_number = _log_density(radius, rain_rate_mm_h)(at) + np.log(at)
    number = np.exp(log_number - log_number.max())
    step = np.log(at[1] / at[0])
    drops, areas = (
        np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * step)])
        for f in (number, number * at**2)
    )
    return _Cumulated(floats(at), floats(number), floats(drops), floats(areas))


def _cumulated_classes(classes: SizeClasses) -> _Cumulated | None:
    """Tabulate counted drops; None where none of them can be drawn."""
    low, high = np.clip(classes.range_um, MIN_RADIUS_UM, MAX_RADIUS_UM)
    if not low < high:
        return None
    count = max(64, int(np.ceil(np.log(high / low) / _FINE_STEP)))
    at = np.geomspace(low, high, count + 1)
    drops, areas = (sums - sums[0] for sums in (classes.cumulated(at, p) for p in (0, 2)))
    return _Cumulated(floats(at), np.diff(drops, prepend=0.0), drops, areas)


def _sizes_of(fine: _Cumulated, number_per_m3: float) -> Sizes:
    """Give the sizes that stand for a distribution of a number of drops."""
    low, high = fine.ends_um
    count = max(8, int(np.ceil(np.log(high / low) / _NODE_STEP)))
    edges = np.geomspace(low, high, count + 1)
    # Each size stands for the drops between two edges, with their mean area.
    log_at, log_edges = np.log(fine.radius_um), np.log(edges)
    amount = np.diff(np.interp(log_edges, log_at, fine.drops))
    surface = np.diff(np.interp(log_edges, log_at, fine.areas))
    kept = amount > 0.0
    radius_um = np.sqrt(surface[kept] / amount[kept])
    # What is cut off by area may be many of the small drops.
    return Sizes(
        radius_um * 1e-6,
        amount[kept] / amount.sum(),
        number_per_m3 * float(amount.sum() / fine.drops[-1]),
    )


_NO_DROPS = Sizes(np.array([MIN_RADIUS_UM * 1e-6]), np.array([1.0]), 0.0)


def distribution(radius: Radius, density: Density) -> Sizes:
    """Give a whole distribution as a set of sizes.

    Args:
        radius: the distribution of radii.
        density: the number of drops, or the rain rate; neither of a distribution that counts them.

    Returns:
        Sizes evenly in ln(radius), each with the number of drops around it. What is cut off at
        the ends is a millionth of the drops' area, and at most 1e-4 of their number and volume.

    Raises:
        InputError: the file of drop sizes is not usable.
    """
    if isinstance(radius, ConstantRadius):
        return Sizes(
            np.array([radius.radius_um * 1e-6]), np.array([1.0]), density.number_per_m3 or 0.0
        )
    if isinstance(radius, TableRadius):
        fine_or_none = _cumulated_classes(read_size_file(Path(radius.file)))
        if fine_or_none is None:
            return _NO_DROPS
        return _sizes_of(fine_or_none, float(fine_or_none.drops[-1]))
    fine = _cumulated(radius, density.rain_rate_mm_h)
    return _sizes_of(fine, _number_within(radius, density, fine))


def _number_within(radius: Radius, density: Density, fine: _Cumulated) -> float:
    """Give the number of drops per m³ of the radii that can be drawn."""
    if isinstance(radius, MarshallPalmerRadius):
        assert density.rain_rate_mm_h is not None
        slope = marshall_palmer_slope(density.rain_rate_mm_h)
        ends = np.exp(-slope * 2e-6 * np.array([radius.min_um, radius.max_um]))
        return float(MARSHALL_PALMER_N0_M4 / slope * (ends[0] - ends[1]))
    formula = _formula(radius)
    if formula is None:
        return density.number_per_m3 or 0.0
    if isinstance(radius, GammaRadius) and radius.ulbrich is not None:
        # By area, which is finite down to mu = -3: a quarter of the sum of diameter² in mm².
        area_um2 = 2.5e5 * ulbrich_moment(*radius.ulbrich, 2)
        within = area_um2 * formula.share_within(2, MIN_RADIUS_UM, MAX_RADIUS_UM)
        return within * float(fine.drops[-1] / fine.areas[-1])
    return (density.number_per_m3 or 0.0) * formula.share_within(0, MIN_RADIUS_UM, MAX_RADIUS_UM)


def left_out(radius: Radius) -> str:
    """Say how much of a distribution lies beyond the radii that can be drawn.

    Returns:
        The moments of which that is more than a thousandth, in words; empty if there are none.

    Raises:
        InputError: the file of drop sizes is not usable.
    """
    shares = {power: 1.0 - _share_within(radius, power) for power in _MOMENTS}
    told = [f"{_percent(s)} of their {_MOMENTS[p]}" for p, s in shares.items() if s > _TOLD]
    if not told:
        return ""
    return (
        f"drops outside {MIN_RADIUS_UM:g}..{MAX_RADIUS_UM:g} um of radius are left out:"
        f" {', '.join(told)}"
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share < 0.995 else "nearly all"


def _share_within(radius: Radius, power: int) -> float:
    source: Formula | SizeClasses | None = (
        read_size_file(Path(radius.file)) if isinstance(radius, TableRadius) else _formula(radius)
    )
    return 1.0 if source is None else source.share_within(power, MIN_RADIUS_UM, MAX_RADIUS_UM)


def quantiles(radius: Radius, share: Array) -> Array:
    """Give the radii (µm) below which shares (n,) of the drops lie."""
    return _quantiles(_cumulated(radius, None), share)


def _quantiles(fine: _Cumulated, share: Array) -> Array:
    drops = fine.drops
    # Where hardly any drops are, shares do not grow in float64.
    rising = np.concatenate([[True], np.diff(drops) > 0.0])
    at = np.log(fine.radius_um)[rising]
    return floats(np.exp(np.interp(share * drops[-1], drops[rising], at)))


def draw_drops(radius: Radius, density: Density, count: int, rng: Generator) -> tuple[Array, Array]:
    """Draw radius and number density at ``count`` grid points.

    In ``marshall-palmer`` radii are drawn evenly and each point carries the density of its own
    size class, so that the mean over the points is the whole distribution.

    Args:
        radius: the distribution of radii.
        density: the number of drops, or the rain rate; neither of a distribution that counts them.
        count: grid points.
        rng: source of the draws; the same seed gives the same drops.

    Returns:
        Radii in m and densities in m⁻³, each (count,).

    Raises:
        InputError: the file of drop sizes is not usable.
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
        case TableRadius():
            counted = _cumulated_classes(read_size_file(Path(radius.file)))
            if counted is None:
                return np.full(count, MIN_RADIUS_UM * 1e-6), np.zeros(count)
            radii_um = _quantiles(counted, rng.random(count))
            number = np.full(count, counted.drops[-1])
        case _:
            # By inversion of the share of the whole: no loop that might not end.
            fine = _cumulated(radius, None)
            radii_um = _quantiles(fine, rng.random(count))
            number = np.full(count, _number_within(radius, density, fine))
    return radii_um * 1e-6, number
