"""Lorenz-Mie intensities averaged over a narrow spread of sizes: one block of the table's nodes."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.compiled import compiled
from rtbow.physics.drop.mie import efficiency, intensities
from rtbow.tables.mie.axes import MieAxes

_REACH = 3.5
"""Standard deviations of ln x on either side that a mean covers: all but 5e-4 of it."""
_COHERENT_PHASE = 10.0
"""Below x = this over the spread, interference between Debye's orders is left after the averaging
and whole amplitudes are summed; above, it is less than exp(-22), and orders add as intensities."""
_LEAST_DEBYE_SIZE = 110.0
"""Debye's coefficients need all of a drop's waves to propagate inside: from x = 102 on."""
_COHERENT_STEPS = 384.0
"""Samples per spread of whole amplitudes: enough for the mean over resonances..."""
_RESONANT_SIZE = 400.0
"""...down to this x; in proportion to x below, where single resonances weigh more."""
_ORDER_STEPS = 12.0
"""Samples per spread, at least, of orders that add as intensities."""


def coherent(axes: MieAxes, x: float) -> bool:
    """Whether whole amplitudes are summed at this size, not Debye's orders."""
    return x < max(_COHERENT_PHASE / axes.spread, _LEAST_DEBYE_SIZE)


def _sample_sizes(axes: MieAxes, low: float, high: float, whole: bool) -> tuple[Array, Array]:
    """Sizes from low to high (ln x), and the share of ln x that each stands for."""
    if whole:
        # By the first size: blocks of nodes are short.
        step = axes.spread / _COHERENT_STEPS * min(np.exp(low) / _RESONANT_SIZE, 1.0)
        even = np.arange(low, high + step, step)
        return floats(even), np.full(len(even), step)
    at, steps = [low], [0.0]
    while at[-1] <= high:
        # The phase between the two rays of a bow, up to 0.27 x at 170 degrees: where it grows
        # by 2 pi from sample to sample, fringes would not average out.
        follow = 2.0 * np.pi / (0.27 * np.exp(at[-1]) + 4.0 / axes.spread)
        steps.append(min(axes.spread / _ORDER_STEPS, follow))
        at.append(at[-1] + steps[-1])
    steps[0] = steps[1]
    return np.array(at), np.array(steps)


@compiled()
def _accumulate(
    log_x: Array, share: Array, m: float, theta: Array, debye: bool,
    nodes: Array, spread: float, reach: float,
) -> tuple[Array, Array]:  # fmt: skip
    sums = np.zeros((len(nodes), 2, len(theta)))
    totals = np.zeros(len(nodes))
    for i in range(len(log_x)):
        x = np.exp(log_x[i])
        value = intensities(x, m, theta, debye) / (x * x)
        for j in range(len(nodes)):
            away = (log_x[i] - nodes[j]) / spread
            if abs(away) <= reach:
                weight = share[i] * np.exp(-0.5 * away * away)
                totals[j] += weight
                for c in range(2):
                    for k in range(len(theta)):
                        sums[j, c, k] += weight * value[c, k]
    return sums, totals


@compiled()
def _accumulate_efficiency(
    log_x: Array, share: Array, m: float, nodes: Array, spread: float, reach: float
) -> Array:
    sums, totals = np.zeros(len(nodes)), np.zeros(len(nodes))
    for i in range(len(log_x)):
        value = efficiency(np.exp(log_x[i]), m)
        for j in range(len(nodes)):
            away = (log_x[i] - nodes[j]) / spread
            if abs(away) <= reach:
                weight = share[i] * np.exp(-0.5 * away * away)
                totals[j] += weight
                sums[j] += weight * value
    return sums / totals


def mean_intensities(axes: MieAxes, nodes: Array, m: float, theta: Array) -> Array:
    """Average |S1|² and |S2|² over sizes, log-normally spread about some nodes.

    All nodes are treated as the first one is: as whole amplitudes, or by Debye's orders.

    Args:
        axes: gives the spread.
        nodes: ln x of the nodes (n,), ascending.
        m: relative index.
        theta: scattering angles (T,), rad.

    Returns:
        |S|²/x², perpendicular and parallel, (n, 2, T).
    """
    whole = coherent(axes, float(np.exp(nodes[0])))
    margin = _REACH * axes.spread
    log_x, share = _sample_sizes(axes, float(nodes[0]) - margin, float(nodes[-1]) + margin, whole)
    sums, totals = _accumulate(log_x, share, m, theta, not whole, nodes, axes.spread, _REACH)
    return floats(sums / totals[:, None, None])


def node_intensities(axes: MieAxes, nodes: Array, m: float) -> Array:
    """Average at all of the table's angles (see :func:`mean_intensities`), (n, 2, T).

    The angles that the size needs are computed, and a cubic spline joins them.
    """
    from scipy.interpolate import CubicSpline

    theta = axes.angles(m)
    kept = axes.needed_angles(float(np.exp(nodes[0])), m)
    means = mean_intensities(axes, nodes, m, theta[kept])
    values = CubicSpline(theta[kept], means, axis=2)(theta)
    # Next to a dark ring a spline may pass below zero.
    return floats(np.maximum(values, 0.5 * means.min(axis=2, keepdims=True)))


def mean_efficiency(axes: MieAxes, nodes: Array, m: float) -> Array:
    """Average the extinction efficiency over sizes as :func:`mean_intensities` does: (n,)."""
    margin = _REACH * axes.spread
    low, high = float(nodes[0]) - margin, float(nodes[-1]) + margin
    step = axes.spread / _ORDER_STEPS
    log_x = np.arange(low, high + step, step)
    share = np.full(len(log_x), step)
    return floats(_accumulate_efficiency(log_x, share, m, nodes, axes.spread, _REACH))
