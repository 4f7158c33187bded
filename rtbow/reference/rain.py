"""Compiled loops of the reference for the rain's own optical depth."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.base.compiled import compiled, prange
from rtbow.reference.rays import optical_depth


@compiled(parallel=True)
def depths_along(
    origin: Array,
    rays: Array,
    entry: Array,
    start: Indices,
    distance: Array,
    box: Array,
    field: Array,
) -> Array:
    """Optical depth from the eye to samples that follow each other along rays.

    Args:
        origin: the eye (3,), m.
        rays: unit directions (n, 3).
        entry: distance of entry into the box (n,).
        start: first sample of each ray (n + 1,).
        distance: of each sample (m,), ascending along a ray.
        box: corners (2, 3), m.
        field: extinction (nz, ny, nx, 2), first channel, 1/m.

    Returns:
        (m,).
    """
    depths = np.zeros(len(distance))
    for pixel in prange(len(rays)):
        depth, reached = 0.0, entry[pixel]
        for k in range(start[pixel], start[pixel + 1]):
            depth += optical_depth(origin, rays[pixel], reached, distance[k], box, field)
            reached = max(reached, distance[k])
            depths[k] = depth
    return depths


@compiled(parallel=True)
def depths_of_paths(
    points: Array, directions: Array, lengths: Array, box: Array, field: Array
) -> Array:
    """Optical depth from points (n, 3) over lengths (n,) in directions (n, 3), (n,)."""
    depths = np.zeros(len(points))
    for i in prange(len(points)):
        depths[i] = optical_depth(points[i], directions[i], 0.0, lengths[i], box, field)
    return depths
