"""Drop sizes: radii and number densities drawn at the points of a grid."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from rtbow.base.arrays import Array
from rtbow.physics.sizes import marshall_palmer
from rtbow.scene.droplets import Density
from rtbow.scene.radius import (
    ConstantRadius,
    MarshallPalmerRadius,
    Radius,
    UniformRadius,
)
from rtbow.world.rain.sizes import quantiles


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
