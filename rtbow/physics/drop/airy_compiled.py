"""Compiled Airy functions: Ai² and its running integral, to 1e-7 everywhere."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled
from rtbow.physics.drop.airy import airy_squared_and_integral

AIRY_LOW, AIRY_HIGH, AIRY_PER_UNIT = -14.0, 34.0, 128
"""Range in z and density of the grids on which Airy's functions are stepped."""


@lru_cache(maxsize=1)
def airy_grid() -> Array:
    """Values and slopes of Ai²(-z) on a fine grid, from scipy: (n, 2)."""
    from scipy.special import airy

    z = np.linspace(AIRY_LOW, AIRY_HIGH, int((AIRY_HIGH - AIRY_LOW) * AIRY_PER_UNIT) + 1)
    value, slope = airy(-z)[:2]
    return np.ascontiguousarray(np.stack([value**2, -2.0 * value * slope], axis=1))


@compiled()
def _hermite(z: float, grid: Array) -> float:
    """Cubic between the values and slopes of two neighbours on the grid."""
    at = (z - AIRY_LOW) * AIRY_PER_UNIT
    k = int(at)
    f = at - k
    g = 1.0 - f
    left = (1.0 + 2.0 * f) * grid[k, 0] + f * grid[k, 1] / AIRY_PER_UNIT
    right = (1.0 + 2.0 * g) * grid[k + 1, 0] - g * grid[k + 1, 1] / AIRY_PER_UNIT
    return float(g * g * left + f * f * right)


@compiled()
def airy_squared_at(z: float, grid: Array) -> float:
    """Ai²(-z) to 1e-7 of its peak or better everywhere.

    Cubic Hermite steps of 1/128 up to z = 34, whose error is h⁴/384 times the fourth derivative;
    beyond, modulus and phase of Abramowitz and Stegun 10.4.78-79.
    """
    if z < AIRY_LOW:
        return 0.0
    if z >= AIRY_HIGH - 0.01:
        root = np.sqrt(z)
        cubed = 1.0 / (z * z * z)
        modulus = (1.0 - 5.0 / 32.0 * cubed) / (np.pi * root)
        phase = 0.25 * np.pi + 2.0 / 3.0 * z * root * (
            1.0 - 5.0 / 32.0 * cubed + 1105.0 / 6144.0 * cubed * cubed
        )
        return float(modulus * np.sin(phase) ** 2)
    return _hermite(z, grid)


@lru_cache(maxsize=1)
def running_grid() -> Array:
    """Running integrals of Ai²(-z) and Ai²(-z) itself, their slope, on a fine grid: (n, 2)."""
    count = int((AIRY_HIGH - AIRY_LOW) * AIRY_PER_UNIT) + 1
    value, integral = airy_squared_and_integral(np.linspace(AIRY_LOW, AIRY_HIGH, count))
    return np.ascontiguousarray(np.stack([integral, value], axis=1))


@compiled()
def running_at(z: float, grid: Array) -> float:
    """Integral of Ai²(-z) from the shadow up to z, to 1e-7: Hermite steps, asymptotic beyond."""
    if z < AIRY_LOW:
        return 0.0
    if z >= AIRY_HIGH - 0.01:
        root = np.sqrt(z)
        cubed = z * root
        psi = 4.0 / 3.0 * cubed - 5.0 / (24.0 * cubed)
        mean = root / np.pi * (1.0 + 1.0 / (32.0 * cubed * cubed))
        ripple = np.cos(psi) / (4.0 * np.pi * z) + np.sin(psi) / (8.0 * np.pi * z * cubed)
        return float(mean - ripple)
    return _hermite(z, grid)
