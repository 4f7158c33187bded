"""Means over the solid angle of pixels, by quadrature."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rtbow.base.arrays import Array, Indices, floats
from rtbow.world.camera.view import View

_LATTICES = (
    (34, 21), (55, 21), (89, 55), (144, 89), (233, 89), (377, 233), (610, 377), (987, 377),
    (1597, 987), (2584, 1597), (4181, 1597), (6765, 4181), (10946, 6765), (17711, 6765),
)  # fmt: skip
"""Points and generators of lattices, odd ones so that places along each side are midpoints."""
_LEAST_POINTS = 34.0
_POINTS_PER_DISC = 16.0
"""Points of a pixel for each radius of the light's disc along its diagonal, beside the least."""
_POINT_LIGHT_RAD = 5e-4
"""What counts as the radius of a light without a disc: fringes of large drops are as fine."""


def pixel_points(view: View, disc_rad: float) -> Array:
    """Give places within a pixel that are even along every direction, (n, 2), from 0 to 1.

    A lattice of Fibonacci numbers: n points have n places along each side, where a grid has only
    the root of n, so that fringes across a pixel are summed as by n points, however they lie. No
    more than 17711 are taken, which follow a light without a disc over pixels of up to 22 degrees,
    and a sun over a single pixel of 120.

    Args:
        view: the picture.
        disc_rad: angular radius of the narrowest light.
    """
    # The picture plane's pixels subtend the most in its middle.
    wide = view.pixel_rad * np.sqrt(2.0) / max(disc_rad, _POINT_LIGHT_RAD)
    wanted = _LEAST_POINTS + _POINTS_PER_DISC * wide
    count, generator = next((n for n in _LATTICES if n[0] >= wanted), _LATTICES[-1])
    index = np.arange(count) + 0.5
    return floats(np.stack([index / count, index * generator / count % 1.0], axis=1))


def pixel_means(
    view: View,
    rows: Indices,
    columns: Indices,
    disc_rad: float,
    radiance: Callable[[Array], Array],
    rays_at_a_time: int,
) -> Array:
    """Average what comes along rays over pixels, each weighted by its solid angle.

    A lattice of twice as many points changes no pixel by more than 0.5 % of the brightest, with
    pixels of 1.7 degrees across the primary bow (``tests/reference/test_pixels.py``).

    Args:
        view: the picture.
        rows: row of each pixel, first on top (n,).
        columns: column of each (n,).
        disc_rad: angular radius of the narrowest light.
        radiance: takes unit directions (n, 3), returns values (n, channels).
        rays_at_a_time: how many of these it is to take; no fewer than there are pixels.

    Returns:
        Means (n, channels).
    """
    total: Array | float = 0.0
    whole: Array | float = 0.0
    points = pixel_points(view, disc_rad)
    together = max(rays_at_a_time // max(len(rows), 1), 1)
    for first in range(0, len(points), together):
        across, down = points[first : first + together].T
        rays, shares = view.rays_through(
            (columns + across[:, None]).ravel(), (rows + down[:, None]).ravel()
        )
        values = radiance(rays).reshape(len(across), len(rows), -1)
        for share, value in zip(shares.reshape(len(across), -1), values, strict=True):
            total = total + share[:, None] * value
            whole = whole + share
    return floats(total / np.asarray(whole)[:, None])
