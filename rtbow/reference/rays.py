"""Compiled loops of the reference: samples along rays, and the sum over wavelengths."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.base.compiled import compiled, prange
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER
from rtbow.physics.drop.airy_compiled import airy_grid, airy_squared_at
from rtbow.world.rain.volume_compiled import interpolate

LEAST_NODES = 3
"""Nodes for a piece of a ray whose drops are of one size."""
NODES_PER_LOG_RADIUS = 30.0


@compiled()
def cut_ray(
    origin: Array, ray: Array, entry: float, leave: float, box: Array, counts: Array, longest: float
) -> Array:
    """Distances at which a ray is cut: its ends, the grid's planes, and pieces <= longest."""
    cuts = [entry, leave]
    for axis in range(3):
        if counts[axis] > 1 and ray[axis] != 0.0:
            spacing = (box[1, axis] - box[0, axis]) / (counts[axis] - 1)
            for k in range(1, counts[axis] - 1):
                t = (box[0, axis] + k * spacing - origin[axis]) / ray[axis]
                if entry < t < leave:
                    cuts.append(t)
    ordered = np.sort(np.array(cuts))
    if not np.isfinite(longest):
        return ordered
    fine = [ordered[0]]
    for k in range(len(ordered) - 1):
        length = ordered[k + 1] - ordered[k]
        pieces = max(1, int(np.ceil(length / longest)))
        for j in range(1, pieces + 1):
            fine.append(ordered[k] + length * j / pieces)
    return np.array(fine)


@compiled()
def optical_depth(
    origin: Array, ray: Array, start: float, end: float, box: Array, field: Array
) -> float:
    """Integral of a field (nz, ny, nx, 2), its first channel, along a ray within its box.

    Exact: cut at the grid's planes, between which the field is a cubic along the ray.
    """
    if end <= start:
        return 0.0
    counts = np.array([field.shape[2], field.shape[1], field.shape[0]])
    cuts = cut_ray(origin, ray, start, end, box, counts, np.inf)
    total = 0.0
    for k in range(len(cuts) - 1):
        half, middle = 0.5 * (cuts[k + 1] - cuts[k]), 0.5 * (cuts[k + 1] + cuts[k])
        for side in (-1.0, 1.0):
            # Gauss-Legendre with two nodes, exact for cubics.
            at = origin + (middle + side * half * 0.5773502691896258) * ray
            total += half * interpolate(at, box, field)[0]
    return total


_UNSEEN_DEPTH = 50.0
"""Optical depth behind which nothing is seen."""


@compiled()
def cut_by_depth(
    origin: Array, ray: Array, cuts: Array, box: Array, field: Array, thickest: float
) -> Array:
    """Cut further, so that no piece is optically thicker than that as far as anything is seen.

    Dense fog shows its first metres, or micrometres, only: even pieces would all lie behind them.
    """
    fine = [cuts[0]]
    depth, last = 0.0, np.inf
    for k in range(len(cuts) - 1):
        start = cuts[k]
        while start < cuts[k + 1]:
            # From a guess by the piece before, halved until it is thin.
            end = min(cuts[k + 1], start + 2.0 * last) if depth < _UNSEEN_DEPTH else cuts[k + 1]
            part = optical_depth(origin, ray, start, end, box, field)
            while part > thickest and depth < _UNSEEN_DEPTH:
                middle = 0.5 * (start + end)
                if middle <= start or middle >= end:  # neighbours in float64
                    break
                end = middle
                part = optical_depth(origin, ray, start, end, box, field)
            fine.append(end)
            depth += part
            last = end - start
            start = end
    return np.array(fine)


@compiled()
def cut_at_levels(origin: Array, ray: Array, cuts: Array, levels: Array) -> Array:
    """Cut further where a ray crosses some heights."""
    more = list(cuts)
    for level in levels:
        if ray[2] != 0.0:
            t = (level - origin[2]) / ray[2]
            if cuts[0] < t < cuts[-1]:
                more.append(t)
    return np.sort(np.array(more))


@compiled()
def node_count(
    origin: Array, ray: Array, start: float, end: float, box: Array, moments: Array
) -> int:
    """Nodes for a piece of a ray: 3 where drops are of a size, more where the radius changes.

    Density times radius is a cubic along a ray, which 2 nodes integrate; the fringes that the
    cross-section shows between a small and a large radius are what asks for more.
    """
    least, most = np.inf, 0.0
    for share in (0.0, 0.5, 1.0):
        at = origin + (start + share * (end - start)) * ray
        density, product = interpolate(at, box, moments)
        if density > 0.0:
            least, most = min(least, product / density), max(most, product / density)
    if most <= least:
        return LEAST_NODES
    return LEAST_NODES + int(np.ceil(NODES_PER_LOG_RADIUS * np.log(most / least)))


def sample_rays(
    origin: Array,
    rays: Array,
    entry: Array,
    leave: Array,
    box: Array,
    moments: Array,
    longest: Array,
    rules: Array,
    levels: Array | None = None,
    field: Array | None = None,
    thickest: float = np.inf,
) -> tuple[Indices, Array, Array, Array]:
    """Place Gauss-Legendre samples between the cuts of each ray, where there are drops.

    Args:
        origin: the eye (3,), m.
        rays: unit directions (n, 3).
        entry: distance of entry into the box (n,); at or beyond ``leave`` where a ray misses.
        leave: distance of exit (n,).
        box: corners (2, 3), m.
        moments: density and density · radius, (nz, ny, nx, 2).
        longest: longest piece of each ray (n,), m.
        rules: Gauss-Legendre nodes on -1..1 and weights (most, 2, most); rule n has n + 1 nodes.
        levels: heights at which light sets in, if any, m (k,).
        field: extinction of rain that attenuates (nz, ny, nx, 2), first channel, 1/m.
        thickest: greatest optical depth of a piece.

    Returns:
        First sample of each ray (n + 1,), and per sample the distance [m], density times length
        [m⁻²] and radius [m].
    """
    levels = np.zeros(0) if levels is None else levels
    if field is None:
        field, thickest = np.zeros((1, 1, 1, 2)), np.inf
    found: tuple[Indices, Array, Array, Array] = _sample_rays(
        origin, rays, entry, leave, box, moments, longest, rules, levels, field, thickest
    )
    return found


@compiled()
def _sample_rays(
    origin: Array,
    rays: Array,
    entry: Array,
    leave: Array,
    box: Array,
    moments: Array,
    longest: Array,
    rules: Array,
    levels: Array,
    field: Array,
    thickest: float,
) -> tuple[Indices, Array, Array, Array]:
    counts = np.array([moments.shape[2], moments.shape[1], moments.shape[0]])
    start = np.zeros(len(rays) + 1, dtype=np.int64)
    distance, weight, radius = [0.0], [0.0], [0.0]
    for pixel in range(len(rays)):
        if entry[pixel] < leave[pixel]:
            cuts = cut_ray(
                origin, rays[pixel], entry[pixel], leave[pixel], box, counts, longest[pixel]
            )
            if len(levels):
                cuts = cut_at_levels(origin, rays[pixel], cuts, levels)
            if np.isfinite(thickest):
                cuts = cut_by_depth(origin, rays[pixel], cuts, box, field, thickest)
            for k in range(len(cuts) - 1):
                half = 0.5 * (cuts[k + 1] - cuts[k])
                count = node_count(origin, rays[pixel], cuts[k], cuts[k + 1], box, moments)
                count = min(count, len(rules))
                for j in range(count):
                    t = cuts[k] + half * (1.0 + rules[count - 1, 0, j])
                    density, product = interpolate(origin + t * rays[pixel], box, moments)
                    if density > 0.0:
                        distance.append(t)
                        weight.append(density * half * rules[count - 1, 1, j])
                        radius.append(product / density)
        start[pixel + 1] = len(distance) - 1
    return start, np.array(distance)[1:], np.array(weight)[1:], np.array(radius)[1:]


@compiled(parallel=True)
def _integrate(
    start: Indices,
    weight: Array,
    radius_scale: Array,
    radius_strength: Array,
    column: Array,
    depth: Array,
    disc_start: Indices,
    disc_angle: Array,
    disc_weight: Array,
    perpendicular: Array,
    bows: Array,
    sides: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
    grid: Array,
) -> Array:
    pixels, wavelengths = len(start) - 1, len(air_depth)
    total = np.zeros((pixels, colour.shape[1]))
    for pixel in prange(pixels):
        share = perpendicular[pixel]
        for w in range(wavelengths):
            radiance = 0.0
            section = 0.0
            last = -1.0
            for k in range(start[pixel], start[pixel + 1]):
                # Neighbouring samples of one radius share their cross-section: that is all there
                # is to a constant radius.
                if abs(radius_scale[k] - last) > 1e-10 * last:
                    last = radius_scale[k]
                    section = 0.0
                    for b in range(len(sides)):
                        angle, scale = bows[b, 0, w], bows[b, 1, w] * last
                        strength = share * bows[b, 2, w] + (1.0 - share) * bows[b, 3, w]
                        mean = 0.0
                        for j in range(disc_start[pixel], disc_start[pixel + 1]):
                            z = scale * sides[b] * (disc_angle[j] - angle)
                            mean += disc_weight[j] * airy_squared_at(z, grid)
                        section += strength * radius_strength[k] * mean
                passed = np.exp(-air_depth[w] * column[k] - rain_ratio[w] * depth[k])
                radiance += weight[k] * section * passed
            for c in range(colour.shape[1]):
                total[pixel, c] += radiance * colour[w, c]
    return total


def integrate_spectrum(
    start: Indices,
    weight: Array,
    radius: Array,
    column: Array,
    depth: Array,
    disc_start: Indices,
    disc_angle: Array,
    disc_weight: Array,
    perpendicular: Array,
    bows: Array,
    sides: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
) -> Array:
    """Sum the samples of each pixel over wavelengths, for one light.

    Args:
        start: first sample of each pixel (n + 1,).
        weight: density times length per sample, m⁻².
        radius: per sample, m.
        column: air column towards light and eye per sample, in H0.
        depth: optical depth of the rain towards light and eye per sample, at 550 nm.
        disc_start: first disc node of each pixel (n + 1,).
        disc_angle: scattering angles over the disc, rad.
        disc_weight: their weights, summing to 1 per pixel.
        perpendicular: share of the bows' first strength per pixel (n,).
        bows: (bows, 4, W): angle, scale and two strengths per wavelength.
        sides: (bows,): +1 or -1.
        air_depth: vertical optical depth (W,).
        rain_ratio: the rain's extinction over that at 550 nm (W,).
        colour: (W, C), lm/m² for X, Y, Z.

    Returns:
        Sums per pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    return np.asarray(
        _integrate(
            start, weight, radius**SCALE_POWER, radius**RADIUS_POWER, column, depth, disc_start,
            disc_angle, disc_weight, perpendicular, bows, sides, air_depth, rain_ratio, colour,
            airy_grid(),
        )
    )  # fmt: skip
