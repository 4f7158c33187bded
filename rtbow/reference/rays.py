"""Compiled loops of the reference along rays: cuts, optical depths, samples and their sum."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Indices, Mask
from rtbow.base.compiled import compiled, prange
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER
from rtbow.physics.drop.airy_compiled import airy_grid, airy_squared_at
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.rain.volume_compiled import interpolate
from rtbow.world.steps import UNSEEN_DEPTH

LEAST_NODES = 3
"""Nodes for a piece of a ray whose drops are of one size."""
NODES_PER_LOG_RADIUS = 30.0
"""Further nodes for a piece per unit of the logarithm of its largest over its smallest radius.

With drops of 81-162 µm drawn at each grid point luminance is within 4e-5 of that with four times as
many under the sun, and 3e-4 under a point at infinity, at steps of 5 nm; at steps of 40 nm, over
which fewer fringes average out, within 5e-3 and 5e-2. Where a small sun's fringes are finer there
are more (393-787 µm, 0.026 degrees: within 0.2 in CIEDE2000)."""
_MOST_NODES = 192
"""Nodes for a piece at most."""


class Rays(NamedTuple):
    """Rays from the eye through the box of drops.

    Attributes:
        origin: the eye (3,), m.
        directions: unit vectors (n, 3).
        entry: distance of entry into the box (n,), m; at or beyond ``leave`` where a ray misses.
        leave: distance of exit (n,), m.
        longest: longest piece of each ray (n,), m.
    """

    origin: Array
    directions: Array
    entry: Array
    leave: Array
    longest: Array

    def some(self, chosen: Mask) -> Rays:
        """Give the chosen ones."""
        return Rays(self.origin, *(each[chosen] for each in self[1:]))


def moments_of(volume: DropletVolume) -> Array:
    """Density and density times radius in float64, (nz, ny, nx, 2).

    Their ratio is then the radius to the last digits, and drops of one radius stay of one radius.
    """
    density = volume.number_per_m3.astype(np.float64)
    moments = np.stack([density, density * volume.radius_um.astype(np.float64) * 1e-6], axis=-1)
    return np.ascontiguousarray(moments.transpose(2, 1, 0, 3))


class Grid(NamedTuple):
    """The rain in its box, trilinear between grid points; the outermost lie on the box's faces.

    Attributes:
        box: corners (2, 3), m.
        moments: density in m⁻³, and density times radius in m⁻² (nz, ny, nx, 2).
        extinction: extinction at 550 nm in 1/m, and a channel that is not used (nz, ny, nx, 2).
        crowding: of the nodes where the radius changes
            (:func:`rtbow.world.steps.fringe_crowding`).
    """

    box: Array
    moments: Array
    extinction: Array
    crowding: float = 1.0


class Samples(NamedTuple):
    """Samples along some rays, those of a ray next to each other.

    Attributes:
        start: first sample of each ray, and the end of the last (n + 1,).
        distance: from the eye (m,), m, ascending along a ray.
        weight: density times length (m,), m⁻².
        radius: drop radius (m,), m.
    """

    start: Indices
    distance: Array
    weight: Array
    radius: Array


class Attenuation(NamedTuple):
    """What attenuates the light from a light to each sample and on to the eye.

    Attributes:
        column: air column (m,), in H0.
        depth: optical depth of the rain at 550 nm (m,).
        air_depth: vertical optical depth of the air (W,).
        rain_ratio: the rain's extinction over that at 550 nm (W,).
        others: columns of the air's other constituents (m, C); C may be 0.
        others_depth: their vertical depths (C, W).
    """

    column: Array
    depth: Array
    air_depth: Array
    rain_ratio: Array
    others: Array
    others_depth: Array


class DiscNodes(NamedTuple):
    """Nodes over a light's disc for each pixel, those of a pixel next to each other.

    Attributes:
        start: first node of each pixel, and the end of the last (n + 1,).
        angle: scattering angles (m,), rad.
        weight: weights (m,), which sum to 1 for each pixel.
    """

    start: Indices
    angle: Array
    weight: Array


class Bows(NamedTuple):
    """Airy's bows at each wavelength.

    Attributes:
        angle: scattering angle of the geometric bow (bows, W), rad.
        scale: Airy's argument per radian from the bow, over radius^⅔ (bows, W), m^-⅔.
        first: strength of the first component, over radius^7/3 (bows, W), m^-⅓ sr⁻¹.
        second: the same of the second; a pixel has shares of both that sum to 1.
        side: +1 where the bow's light lies at larger angles, or -1 (bows,).
    """

    angle: Array
    scale: Array
    first: Array
    second: Array
    side: Array


@compiled()
def cut_ray(origin: Array, ray: Array, start: float, end: float, box: Array, field: Array) -> Array:
    """Distances at which a ray is cut between two: both, and where it crosses the grid's planes."""
    cuts = [start, end]
    for axis in range(3):
        count = field.shape[2 - axis]
        if count > 1 and ray[axis] != 0.0:
            spacing = (box[1, axis] - box[0, axis]) / (count - 1)
            for k in range(1, count - 1):
                t = (box[0, axis] + k * spacing - origin[axis]) / ray[axis]
                if start < t < end:
                    cuts.append(t)
    return np.sort(np.array(cuts))


@compiled()
def cut_by_length(cuts: Array, longest: float) -> Array:
    """Cut further, evenly, so that no piece is longer than that."""
    if not np.isfinite(longest):
        return cuts
    fine = [cuts[0]]
    for k in range(len(cuts) - 1):
        length = cuts[k + 1] - cuts[k]
        pieces = max(1, int(np.ceil(length / longest)))
        for j in range(1, pieces + 1):
            fine.append(cuts[k] + length * j / pieces)
    return np.array(fine)


@compiled()
def cut_by_depth(origin: Array, ray: Array, cuts: Array, grid: Grid, thickest: float) -> Array:
    """Cut further, so that no piece is optically thicker than that as far as anything is seen.

    Dense fog shows its first metres, or micrometres, only: even pieces would all lie behind them.
    """
    if not np.isfinite(thickest):
        return cuts
    fine = [cuts[0]]
    depth, last = 0.0, np.inf
    for k in range(len(cuts) - 1):
        start = cuts[k]
        while start < cuts[k + 1]:
            # From a guess by the piece before, halved until it is thin.
            end = min(cuts[k + 1], start + 2.0 * last) if depth < UNSEEN_DEPTH else cuts[k + 1]
            part = optical_depth(origin, ray, start, end, grid)
            while part > thickest and depth < UNSEEN_DEPTH:
                middle = 0.5 * (start + end)
                if middle <= start or middle >= end:  # neighbours in float64
                    break
                end = middle
                part = optical_depth(origin, ray, start, end, grid)
            fine.append(end)
            depth += part
            last = end - start
            start = end
    return np.array(fine)


@compiled()
def _cut_at(cuts: Array, distances: Array) -> Array:
    """Cut further at some distances, as far as they lie within."""
    more = list(cuts)
    for t in distances:
        if cuts[0] < t < cuts[-1]:
            more.append(t)
    return np.sort(np.array(more))


@compiled()
def optical_depth(origin: Array, ray: Array, start: float, end: float, grid: Grid) -> float:
    """Optical depth of the rain at 550 nm between two distances along a ray within the box.

    Exact: cut at the grid's planes, between which the extinction is a cubic along the ray.
    """
    if end <= start:
        return 0.0
    cuts = cut_ray(origin, ray, start, end, grid.box, grid.extinction)
    total = 0.0
    for k in range(len(cuts) - 1):
        half, middle = 0.5 * (cuts[k + 1] - cuts[k]), 0.5 * (cuts[k + 1] + cuts[k])
        for side in (-1.0, 1.0):
            # Gauss-Legendre with two nodes, exact for cubics.
            at = origin + (middle + side * half * 0.5773502691896258) * ray
            total += half * interpolate(at, grid.box, grid.extinction)[0]
    return total


@compiled(parallel=True)
def depths_along(rays: Rays, start: Indices, distance: Array, grid: Grid) -> Array:
    """Optical depth of the rain at 550 nm from the eye to samples along rays.

    Args:
        rays: n rays.
        start: first sample of each ray, and the end of the last (n + 1,).
        distance: of each sample (m,), m, ascending along a ray.
        grid: the rain.

    Returns:
        (m,).
    """
    depths = np.zeros(len(distance))
    for pixel in prange(len(rays.directions)):
        ray = rays.directions[pixel]
        depth, reached = 0.0, rays.entry[pixel]
        for k in range(start[pixel], start[pixel + 1]):
            depth += optical_depth(rays.origin, ray, reached, distance[k], grid)
            reached = max(reached, distance[k])
            depths[k] = depth
    return depths


@compiled(parallel=True)
def depths_of_paths(points: Array, directions: Array, lengths: Array, grid: Grid) -> Array:
    """Optical depth of the rain at 550 nm along paths within the box.

    Args:
        points: where they begin (n, 3), m.
        directions: unit vectors (n, 3).
        lengths: (n,), m.
        grid: the rain.

    Returns:
        (n,).
    """
    depths = np.zeros(len(points))
    for i in prange(len(points)):
        depths[i] = optical_depth(points[i], directions[i], 0.0, lengths[i], grid)
    return depths


@compiled()
def node_count(origin: Array, ray: Array, start: float, end: float, grid: Grid) -> int:
    """Nodes for a piece of a ray: 3 where drops are of one size, more where the radius changes.

    Density times radius is a cubic along a ray, which 2 nodes integrate; the fringes that the
    cross-section shows between a small and a large radius are what asks for more.
    """
    least, most = np.inf, 0.0
    for share in (0.0, 0.5, 1.0):
        at = origin + (start + share * (end - start)) * ray
        density, product = interpolate(at, grid.box, grid.moments)
        if density > 0.0:
            least, most = min(least, product / density), max(most, product / density)
    if most <= least:
        return LEAST_NODES
    return LEAST_NODES + int(np.ceil(grid.crowding * NODES_PER_LOG_RADIUS * np.log(most / least)))


@lru_cache(maxsize=1)
def _gauss_rules() -> Array:
    """Gauss-Legendre rules of 1 to ``_MOST_NODES`` nodes on -1..1: (rules, 2, nodes), padded."""
    rules = np.zeros((_MOST_NODES, 2, _MOST_NODES))
    for n in range(1, _MOST_NODES + 1):
        rules[n - 1, :, :n] = np.polynomial.legendre.leggauss(n)
    return rules


@compiled()
def _sample_rays(rays: Rays, grid: Grid, edges: Array, thickest: float, rules: Array) -> Samples:
    origin = rays.origin
    start = np.zeros(len(rays.directions) + 1, dtype=np.int64)
    distance, weight, radius = [0.0], [0.0], [0.0]
    for pixel in range(len(rays.directions)):
        ray = rays.directions[pixel]
        if rays.entry[pixel] < rays.leave[pixel]:
            cuts = cut_ray(
                origin, ray, rays.entry[pixel], rays.leave[pixel], grid.box, grid.moments
            )
            cuts = cut_by_length(cuts, rays.longest[pixel])
            if edges.shape[1]:
                cuts = _cut_at(cuts, edges[pixel])
            cuts = cut_by_depth(origin, ray, cuts, grid, thickest)
            for k in range(len(cuts) - 1):
                half = 0.5 * (cuts[k + 1] - cuts[k])
                count = node_count(origin, ray, cuts[k], cuts[k + 1], grid)
                count = min(count, len(rules))
                for j in range(count):
                    t = cuts[k] + half * (1.0 + rules[count - 1, 0, j])
                    density, product = interpolate(origin + t * ray, grid.box, grid.moments)
                    if density > 0.0:
                        distance.append(t)
                        weight.append(density * half * rules[count - 1, 1, j])
                        radius.append(product / density)
        start[pixel + 1] = len(distance) - 1
    return Samples(start, np.array(distance)[1:], np.array(weight)[1:], np.array(radius)[1:])


def sample_rays(rays: Rays, grid: Grid, edges: Array, thickest: float) -> Samples:
    """Place Gauss-Legendre samples between the cuts of each ray, where there are drops.

    Args:
        rays: n rays.
        grid: the rain.
        edges: distances at which light sets in or ends (n, k), m; k may be 0.
        thickest: greatest optical depth of a piece; infinite where nothing attenuates.
    """
    samples: Samples = _sample_rays(rays, grid, edges, thickest, _gauss_rules())
    return samples


@compiled()
def transmission(attenuation: Attenuation, k: int, w: int) -> float:
    """Share of the light at wavelength w that reaches the eye by way of sample k."""
    exponent = -attenuation.air_depth[w] * attenuation.column[k]
    exponent -= attenuation.rain_ratio[w] * attenuation.depth[k]
    for c in range(attenuation.others.shape[1]):
        exponent -= attenuation.others_depth[c, w] * attenuation.others[k, c]
    return float(np.exp(exponent))


@compiled()
def bow_strength(bows: Bows, b: int, w: int, share: float) -> float:
    """Strength of bow b at wavelength w for a share of the first component, m^-⅓ sr⁻¹."""
    return float(share * bows.first[b, w] + (1.0 - share) * bows.second[b, w])


@compiled(parallel=True)
def _integrate(
    samples: Samples,
    radius_scale: Array,
    radius_strength: Array,
    attenuation: Attenuation,
    disc: DiscNodes,
    share: Array,
    bows: Bows,
    colour: Array,
    airy: Array,
) -> Array:
    pixels, wavelengths = len(samples.start) - 1, len(attenuation.air_depth)
    total = np.zeros((pixels, colour.shape[1]))
    for pixel in prange(pixels):
        for w in range(wavelengths):
            radiance = 0.0
            section = 0.0
            last = -1.0
            for k in range(samples.start[pixel], samples.start[pixel + 1]):
                # Neighbouring samples of one radius share their cross-section: that is all there
                # is to a constant radius.
                if abs(radius_scale[k] - last) > 1e-10 * last:
                    last = radius_scale[k]
                    section = 0.0
                    for b in range(len(bows.side)):
                        angle, scale = bows.angle[b, w], bows.scale[b, w] * last
                        mean = 0.0
                        for j in range(disc.start[pixel], disc.start[pixel + 1]):
                            z = scale * bows.side[b] * (disc.angle[j] - angle)
                            mean += disc.weight[j] * airy_squared_at(z, airy)
                        strength = bow_strength(bows, b, w, share[pixel])
                        section += strength * radius_strength[k] * mean
                radiance += samples.weight[k] * section * transmission(attenuation, k, w)
            for c in range(colour.shape[1]):
                total[pixel, c] += radiance * colour[w, c]
    return total


def integrate_spectrum(
    samples: Samples,
    attenuation: Attenuation,
    disc: DiscNodes,
    share: Array,
    bows: Bows,
    colour: Array,
) -> Array:
    """Sum the samples of each pixel over wavelengths, for one sun.

    Args:
        samples: samples of n pixels.
        attenuation: what attenuates towards sun and eye.
        disc: nodes over the sun's disc.
        share: share of the bows' first component for each pixel (n,).
        bows: Airy's bows.
        colour: weight of each wavelength in each channel (W, C), lm/m² for X, Y, Z.

    Returns:
        Sums for each pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    scale, strength = samples.radius**SCALE_POWER, samples.radius**RADIUS_POWER
    return np.asarray(
        _integrate(samples, scale, strength, attenuation, disc, share, bows, colour, airy_grid())
    )
