"""Directions, angles and a ray's way through a box, float64."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats


def direction(azimuth_deg: float, altitude_deg: float) -> Array:
    """Give the unit vector (3,) east, north, up towards an azimuth and altitude."""
    azimuth, altitude = np.radians(azimuth_deg), np.radians(altitude_deg)
    towards = np.array(
        [
            np.sin(azimuth) * np.cos(altitude),
            np.cos(azimuth) * np.cos(altitude),
            np.sin(altitude),
        ]
    )
    # The sine of 180 degrees is 1e-16 in float64: south is south, and along a box's face.
    return np.where(np.abs(towards) < 1e-15, 0.0, towards)


def box_span(origin: Array, directions: Array, box: Array) -> tuple[Array, Array]:
    """Give where rays are inside a box.

    Args:
        origin: ray start (3,), or one for each ray (..., 3).
        directions: unit directions (..., 3).
        box: lower and upper corner (2, 3).

    Returns:
        Distances of entry (0 inside) and exit, each (...); entry >= exit where a ray misses.
    """
    entry = np.zeros(directions.shape[:-1])
    leave = np.full(directions.shape[:-1], np.inf)
    for axis in range(3):
        d = directions[..., axis]
        parallel = d == 0.0
        safe = np.where(parallel, 1.0, d)
        start = origin[..., axis]
        near = (box[0, axis] - start) / safe
        far = (box[1, axis] - start) / safe
        low, high = np.minimum(near, far), np.maximum(near, far)
        # A ray along a face counts as inside; one beside the box never enters.
        within = (box[0, axis] <= start) & (start <= box[1, axis])
        entry = np.maximum(entry, np.where(parallel, np.where(within, -np.inf, np.inf), low))
        leave = np.minimum(leave, np.where(parallel, np.where(within, np.inf, -np.inf), high))
    return entry, leave


def angle_between(directions: Array, axis: Array) -> Array:
    """Give the angle (...) between unit vectors (..., 3), rad; exact near 0 and pi, too."""
    chord = np.linalg.norm(directions - axis, axis=-1)
    return floats(2.0 * np.arctan2(chord, np.linalg.norm(directions + axis, axis=-1)))
