"""Compiled loops of the reference for cross-sections given at each pixel's own angle."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.base.compiled import compiled, prange


@compiled()
def _between(rows: Array, place: float) -> float:
    """Cubic (Lagrange) interpolation along evenly spaced values; one value is everywhere alike."""
    count = len(rows)
    if count == 1:
        return float(rows[0])
    if count < 4:
        base = min(max(int(place), 0), count - 2)
        return float(rows[base] + (place - base) * (rows[base + 1] - rows[base]))
    base = min(max(int(place), 1), count - 3)
    f = place - base
    return float(
        -f * (f - 1.0) * (f - 2.0) / 6.0 * rows[base - 1]
        + (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0 * rows[base]
        - (f + 1.0) * f * (f - 2.0) / 2.0 * rows[base + 1]
        + (f + 1.0) * f * (f - 1.0) / 6.0 * rows[base + 2]
    )


@compiled(parallel=True)
def integrate_rows(
    start: Indices,
    weight: Array,
    row: Array,
    area: Array,
    column: Array,
    depth: Array,
    sections: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
) -> Array:
    """Sum the samples of each pixel over wavelengths, for one sun.

    Args:
        start: first sample of each pixel (n + 1,).
        weight: density times length per sample, m⁻².
        row: place of each sample's radius along the rows.
        area: radius squared per sample, m².
        column: air column towards sun and eye per sample, in H0.
        depth: optical depth of the rain towards sun and eye per sample, at 550 nm.
        sections: cross-section over the radius squared (n, W, rows), sr⁻¹.
        air_depth: vertical optical depth (W,).
        rain_ratio: the rain's extinction over that at 550 nm (W,).
        colour: (W, C), lm/m² for X, Y, Z.

    Returns:
        Sums per pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    total = np.zeros((len(start) - 1, colour.shape[1]))
    for pixel in prange(len(start) - 1):
        for w in range(len(air_depth)):
            radiance = 0.0
            for k in range(start[pixel], start[pixel + 1]):
                section = area[k] * _between(sections[pixel, w], row[k])
                passed = np.exp(-air_depth[w] * column[k] - rain_ratio[w] * depth[k])
                radiance += weight[k] * section * passed
            for c in range(colour.shape[1]):
                total[pixel, c] += radiance * colour[w, c]
    return total


@compiled()
def _on_axis(values: Array, angles: Array, theta: float) -> float:
    """Linear interpolation over ascending angles; ends hold beyond them."""
    if theta <= angles[0]:
        return float(values[0])
    if theta >= angles[-1]:
        return float(values[-1])
    k = np.searchsorted(angles, theta) - 1
    f = (theta - angles[k]) / (angles[k + 1] - angles[k])
    return float(values[k] + f * (values[k + 1] - values[k]))


@compiled(parallel=True)
def integrate_lamp_rows(
    start: Indices,
    pieces: Array,
    row: Array,
    column: Array,
    depth: Array,
    perpendicular: Array,
    angles: Array,
    sections: Array,
    running: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
) -> Array:
    """Sum the pieces of each pixel over wavelengths, for one lamp.

    Args:
        start: first piece of each pixel (n + 1,).
        pieces: as :func:`rtbow.reference.lamp.lamp_pieces` gives them (m, 6).
        row: place of each piece's radius along the rows.
        column: air column towards lamp and eye per piece, in H0.
        depth: optical depth of the rain towards lamp and eye per piece, at 550 nm.
        perpendicular: share of the first component per pixel (n,).
        angles: scattering angles of the sections (U,).
        sections: cross-sections over the radius squared, without a disc (W, rows, 2, U).
        running: their integrals over the angle, the same shape.
        air_depth: vertical optical depth (W,).
        rain_ratio: the rain's extinction over that at 550 nm (W,).
        colour: (W, C), lm/sr for X, Y, Z.

    Returns:
        Sums per pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    total = np.zeros((len(start) - 1, colour.shape[1]))
    rows = sections.shape[1]
    for pixel in prange(len(start) - 1):
        means = np.empty(rows)
        for k in range(start[pixel], start[pixel + 1]):
            low, high, disc = pieces[k, 3], pieces[k, 4], pieces[k, 5]
            count = 1 if disc == 0.0 else 24
            first = min(max(int(row[k]) - 1, 0), max(rows - 4, 0))
            for w in range(len(air_depth)):
                for r in range(first, min(first + 4, rows)):
                    means[r] = 0.0
                    for component in range(2):
                        share = perpendicular[pixel]
                        if component == 1:
                            share = 1.0 - share
                        value, integral = sections[w, r, component], running[w, r, component]
                        for j in range(count):
                            at = (j + 0.5) * np.pi / count
                            shift = disc * np.cos(at) if count > 1 else 0.0
                            chord = 2.0 / count * np.sin(at) ** 2 if count > 1 else 1.0
                            if abs(high - low) > 1e-5:
                                rise = _on_axis(integral, angles, high + shift)
                                rise -= _on_axis(integral, angles, low + shift)
                                means[r] += share * chord * rise / (high - low)
                            else:
                                middle = 0.5 * (low + high) + shift
                                means[r] += share * chord * _on_axis(value, angles, middle)
                section = _between(means[first : min(first + 4, rows)], row[k] - first)
                passed = np.exp(-air_depth[w] * column[k] - rain_ratio[w] * depth[k])
                value_here = pieces[k, 1] * pieces[k, 2] ** 2 * section * passed
                for c in range(colour.shape[1]):
                    total[pixel, c] += value_here * colour[w, c]
    return total
