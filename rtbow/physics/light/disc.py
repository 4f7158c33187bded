"""Averages over the light's disc, on the sphere."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array, floats


@lru_cache(maxsize=256)
def _gauss_legendre(count: int) -> tuple[Array, Array]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return floats(nodes), floats(weights)


def disc_nodes(theta_rad: float, radius_rad: float, count: int) -> tuple[Array, Array]:
    """Give quadrature nodes for the mean over a uniform disc of a function of the angle.

    The disc's centre makes the angle ``theta`` with the axis; the mean over the disc becomes one
    integral over the angle, weighted by the share of each circle about the axis that lies inside
    the disc. Exact on the sphere, at the poles too, where a flat convolution is not.

    Args:
        theta_rad: angle between axis and disc centre, rad, 0..pi.
        radius_rad: angular radius of the disc, rad; 0 gives the one angle itself.
        count: nodes over the disc; pi times as many where it covers a pole.

    Returns:
        Angles (n,) in rad within 0..pi and weights (n,) that sum to 1.
    """
    if radius_rad <= 0.0:
        return np.array([theta_rad]), np.array([1.0])
    # Mirrored so that only the pole at 0 needs care.
    mirrored = theta_rad > 0.5 * np.pi
    centre = np.pi - theta_rad if mirrored else theta_rad

    low, high = abs(centre - radius_rad), centre + radius_rad
    half = 0.5 * (high - low)
    # With the pole inside the weight does not vanish at the lower end: Gauss-Legendre nodes need
    # no more than pi/2 times as many as the midpoint rule.
    pole_inside = centre < radius_rad
    if pole_inside:
        nodes, gauss = _gauss_legendre(int(np.ceil(0.5 * np.pi * count)))
        t, dt = floats(0.5 * np.pi * (nodes + 1.0)), floats(0.5 * np.pi * gauss)
    else:
        t, dt = _midpoints(count)
    angles, weights = _circles(floats(centre), floats(low), floats(half), radius_rad, t, dt)

    if pole_inside:  # circles about the pole that lie wholly inside the disc
        full = 0.5 * low * (nodes + 1.0)
        angles = np.concatenate([full, angles])
        weights = np.concatenate([np.sin(full) * np.pi * 0.5 * low * gauss, weights])
    total = weights.sum()
    if total <= 0.0:  # a disc exactly on the pole leaves the outer piece empty
        return np.array([theta_rad]), np.array([1.0])
    return (np.pi - angles if mirrored else angles), weights / total


def disc_nodes_off_poles(theta_rad: Array, radius_rad: float, count: int) -> tuple[Array, Array]:
    """Give the nodes and weights of :func:`disc_nodes` for many discs that cover no pole.

    Args:
        theta_rad: angles between axis and disc centre (U,), at least the radius from 0 and pi.
        radius_rad: angular radius of the discs, rad, above 0.
        count: nodes over each disc.

    Returns:
        Angles and weights, (U, count) each.
    """
    theta = floats(theta_rad)[:, None]
    mirrored = theta > 0.5 * np.pi
    centre = np.where(mirrored, np.pi - theta, theta)
    low, high = np.abs(centre - radius_rad), centre + radius_rad
    t, dt = _midpoints(count)
    angles, weights = _circles(centre, low, 0.5 * (high - low), radius_rad, t, dt)
    total = weights.sum(axis=1, keepdims=True)
    # A disc too small for its angles to differ leaves no weight: all nodes are its centre.
    weights = np.where(total > 0.0, weights, 1.0) / np.where(total > 0.0, total, float(count))
    return floats(np.where(mirrored, np.pi - angles, angles)), floats(weights)


def _midpoints(count: int) -> tuple[Array, Array]:
    """Places of t in :func:`_circles` and their shares: where its weight vanishes at both ends the
    midpoint rule converges exponentially."""
    return floats((np.arange(count) + 0.5) * np.pi / count), np.full(count, np.pi / count)


def _circles(
    centre: Array, low: Array, half: Array, radius_rad: float, t: Array, dt: Array
) -> tuple[Array, Array]:
    """Angles of circles about the axis, and the area of each that lies inside a disc.

    theta = middle - half cos(t): the weight's square-root ends become smooth in t.
    """
    angles = floats(low + half * (1.0 - np.cos(t)))
    offset = angles - centre
    ratio = (
        np.sin(0.5 * (radius_rad + offset)) * np.sin(0.5 * (radius_rad - offset))
        / (np.sin(angles) * np.sin(centre) + 1e-300)
    )  # fmt: skip
    inside = 2.0 * np.arcsin(np.sqrt(np.clip(ratio, 0.0, 1.0)))
    return angles, floats(np.sin(angles) * inside * half * np.sin(t) * dt)


def disc_mean(
    function: Callable[[Array], Array], theta_rad: float, radius_rad: float, count: int
) -> Array:
    """Average ``function`` of the angle over a disc (see :func:`disc_nodes`).

    Args:
        function: takes angles (n,) in rad, returns values (n, ...).
        theta_rad: angle between axis and disc centre, rad.
        radius_rad: angular radius of the disc, rad.
        count: quadrature nodes; a phase of P rad across the radius needs P/2 + 16.

    Returns:
        The mean, shape (...).
    """
    angles, weights = disc_nodes(theta_rad, radius_rad, count)
    return np.tensordot(weights, function(angles), axes=(0, 0))
