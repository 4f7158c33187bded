"""Compiled loops of the reference for cross-sections given at each pixel's own angle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled, prange
from rtbow.reference.lamp import Pieces
from rtbow.reference.rays import Attenuation, Samples, transmission


class LampSections(NamedTuple):
    """Cross-sections over the radius squared without a disc, at some angles.

    Attributes:
        angle: scattering angles (U,), rad, ascending.
        section: of each of two components (W, rows, 2, U), sr⁻¹.
        running: its integral over the angle, the same shape.
    """

    angle: Array
    section: Array
    running: Array


@compiled()
def _between(rows: Array, place: float) -> float:
    """Cubic (Lagrange) interpolation along evenly spaced values; a single one holds everywhere."""
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
    samples: Samples,
    attenuation: Attenuation,
    row: Array,
    area: Array,
    sections: Array,
    colour: Array,
) -> Array:
    """Sum the samples of each pixel over wavelengths, for one sun.

    Args:
        samples: samples of n pixels.
        attenuation: what attenuates towards sun and eye.
        row: place of each sample's radius along the rows (m,).
        area: radius squared of each sample (m,), m².
        sections: cross-section over the radius squared at each pixel (n, W, rows), sr⁻¹.
        colour: weight of each wavelength in each channel (W, C), lm/m² for X, Y, Z.

    Returns:
        Sums for each pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    start = samples.start
    total = np.zeros((len(start) - 1, colour.shape[1]))
    for pixel in prange(len(start) - 1):
        for w in range(len(attenuation.air_depth)):
            radiance = 0.0
            for k in range(start[pixel], start[pixel + 1]):
                section = area[k] * _between(sections[pixel, w], row[k])
                radiance += samples.weight[k] * section * transmission(attenuation, k, w)
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


@compiled()
def _mean_section(
    section: Array,
    running: Array,
    angles: Array,
    low: float,
    high: float,
    disc: float,
    share: float,
) -> float:
    """Mean cross-section over a piece at a lamp, and over the lamp's disc about each of its points.

    Args:
        section: cross-section of each component over the radius squared (2, U), sr⁻¹.
        running: its integral over the angle (2, U).
        angles: scattering angles (U,), rad.
        low: scattering angle at one end, rad.
        high: scattering angle at the other end, rad.
        disc: the lamp's angular radius, rad.
        share: share of the first component.
    """
    # 24 chords across the disc average fringes out to within 2e-6 of their height where up to 9 of
    # them lie across it; fringes so fine that more do may keep up to 0.65 of their height.
    count = 1 if disc == 0.0 else 24
    mean = 0.0
    for component in range(2):
        portion = share if component == 0 else 1.0 - share
        for j in range(count):
            at = (j + 0.5) * np.pi / count
            shift = disc * np.cos(at) if count > 1 else 0.0
            chord = 2.0 / count * np.sin(at) ** 2 if count > 1 else 1.0
            if abs(high - low) > 1e-5:
                rise = _on_axis(running[component], angles, high + shift)
                rise -= _on_axis(running[component], angles, low + shift)
                mean += portion * chord * rise / (high - low)
            else:
                middle = 0.5 * (low + high) + shift
                mean += portion * chord * _on_axis(section[component], angles, middle)
    return mean


@compiled(parallel=True)
def integrate_lamp_rows(
    pieces: Pieces,
    attenuation: Attenuation,
    row: Array,
    share: Array,
    sections: LampSections,
    colour: Array,
) -> Array:
    """Sum the pieces of each pixel over wavelengths, for one lamp.

    Args:
        pieces: pieces of n pixels.
        attenuation: what attenuates towards lamp and eye.
        row: place of each piece's radius along the rows (m,).
        share: share of the first component for each pixel (n,).
        sections: cross-sections in rows of radii.
        colour: weight of each wavelength in each channel (W, C), lm/sr for X, Y, Z.

    Returns:
        Sums for each pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    start = pieces.start
    total = np.zeros((len(start) - 1, colour.shape[1]))
    rows = sections.section.shape[1]
    for pixel in prange(len(start) - 1):
        means = np.empty(rows)
        for k in range(start[pixel], start[pixel + 1]):
            first = min(max(int(row[k]) - 1, 0), max(rows - 4, 0))
            end = min(first + 4, rows)
            for w in range(len(attenuation.air_depth)):
                for r in range(first, end):
                    means[r] = _mean_section(
                        sections.section[w, r],
                        sections.running[w, r],
                        sections.angle,
                        pieces.first[k],
                        pieces.last[k],
                        pieces.disc[k],
                        share[pixel],
                    )
                section = _between(means[first:end], row[k] - first)
                passed = transmission(attenuation, k, w)
                value = pieces.weight[k] * pieces.radius[k] ** 2 * section * passed
                for c in range(colour.shape[1]):
                    total[pixel, c] += value * colour[w, c]
    return total
