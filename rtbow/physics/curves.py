"""Smooth curves through a few points, as SciPy has them, whose import takes longer than a sky."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats


def spline_shares(nodes: Array, at: Array) -> Array:
    """Give the shares of values at nodes (N,), evenly apart, in those at places within them (V, N)
    of the cubic spline through them: of one cubic in the first two steps and the last two."""
    count, step = len(nodes), nodes[1] - nodes[0]
    # Second derivatives: equal slopes at inner nodes, even third derivatives at the ends.
    system, bend = np.zeros((count, count)), np.zeros((count, count))
    for row in range(1, count - 1):
        system[row, row - 1 : row + 2] = 1.0, 4.0, 1.0
        bend[row, row - 1 : row + 2] = floats([1.0, -2.0, 1.0]) * 6.0 / step**2
    system[0, :3] = system[-1, -3:] = 1.0, -2.0, 1.0
    second = np.linalg.solve(system, bend)
    place = (floats(at) - nodes[0]) / step
    low = np.clip(place.astype(np.int64), 0, count - 2)
    u = (place - low)[:, None]
    each = np.eye(count)
    straight = (1.0 - u) * each[low] + u * each[low + 1]
    v = 1.0 - u
    curved = (v**3 - v) * second[low] + (u**3 - u) * second[low + 1]
    return floats(straight + step**2 / 6.0 * curved)


def monotone_cubic(nodes: Array, values: Array, at: Array) -> Array:
    """Interpolate by cubics that have no extremum between points, same shape as the places.

    Source: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 300 (1984).

    Args:
        nodes: points (N,), ascending.
        values: at the nodes (N,).
        at: places between the first and the last node.
    """
    step = np.diff(nodes)
    rise = np.diff(values) / step
    first, second = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = (first + second) / (first / rise[:-1] + second / rise[1:])
    inner = np.where(rise[:-1] * rise[1:] > 0.0, inner, 0.0)
    slope = np.concatenate([[_end(step, rise)], inner, [_end(step[::-1], rise[::-1])]])
    n = np.clip(np.searchsorted(nodes, at, "right") - 1, 0, len(step) - 1)
    h, u = step[n], (at - nodes[n]) / step[n]
    v = 1.0 - u
    return floats(
        v * v * (1.0 + 2.0 * u) * values[n] + u * u * (1.0 + 2.0 * v) * values[n + 1]
        + h * u * v * (v * slope[n] - u * slope[n + 1])
    )  # fmt: skip


def _end(step: Array, rise: Array) -> float:
    """Slope at an end: that of the parabola through three points, unless it overshoots."""
    slope = ((2.0 * step[0] + step[1]) * rise[0] - step[0] * rise[1]) / (step[0] + step[1])
    if slope * rise[0] <= 0.0:
        return 0.0
    if rise[0] * rise[1] < 0.0 and abs(slope) > 3.0 * abs(rise[0]):
        return float(3.0 * rise[0])
    return float(slope)
