"""Reflection by a smooth surface of a clear medium: Fresnel's formulas."""

from __future__ import annotations

from typing import Any

import numpy as np

from rtbow.base.arrays import Array, Values, floats

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def reflected_amplitudes(index: Values, cosine: Values) -> tuple[Any, Any]:
    """Give what is reflected of a field across the plane of incidence, and of one within it.

    Args:
        index: refractive index beyond the surface, over that before it; 1 or more.
        cosine: of the angle of incidence, 0 to 1.

    Returns:
        Amplitudes per amplitude that arrives; both squared at a right angle are
        ((n - 1) / (n + 1))². Within the plane fields count along the ray's direction of travel
        crossed with the normal of the plane, for either ray.
    """
    beyond = np.sqrt(np.square(index) - 1.0 + np.square(cosine))  # n cos(refracted angle)
    across = (cosine - beyond) / (cosine + beyond)
    dense = np.square(index) * cosine
    return across, (dense - beyond) / (dense + beyond)


def reflectance(index: Values, cosine: Values) -> Any:
    """Give the share of unpolarised light that is reflected."""
    across, within = reflected_amplitudes(index, cosine)
    return 0.5 * (across * across + within * within)


def diffuse_reflectance(index: Array) -> Array:
    """Give the share that is reflected of light from all sides alike, same shape as the index:
    0.066 of water's."""
    cosine = 0.5 * (_NODES + 1.0)
    return floats(reflectance(floats(index)[..., None], cosine) @ (_WEIGHTS * cosine))
