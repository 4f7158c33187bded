"""Compiled loops of the reference for lamps: pieces of rays in angle, and their sum."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.base.compiled import compiled, prange
from rtbow.physics.drop.airy_compiled import (
    AIRY_LOW,
    airy_grid,
    airy_squared_at,
    running_at,
    running_grid,
)
from rtbow.reference.rays import (
    LEAST_NODES,
    cut_by_depth,
    cut_ray,
    node_count,
)
from rtbow.world.rain.volume_compiled import interpolate

_DISTANCE_RATIO = 1.07
"""Largest ratio of the distances from a lamp with a diameter to the ends of a piece."""


PIECES_PER_NODE = 6
"""Pieces with drops of one size each, per node that a piece of a ray takes under a sun: within 0.02
(CIEDE2000, 99 %) of four times as many, with drops of 81-162 µm drawn at each point and a lamp that
is a point."""


@compiled()
def _cut_by_distance(cuts: Array, foot: float, nearest: float) -> Array:
    """Cut further where the distance from the lamp grows by ``_DISTANCE_RATIO``.

    On a line that all but passes through the lamp the angle does not turn any more, while the
    lamp's apparent size still changes.
    """
    farthest = max(abs(cuts[0] - foot), abs(cuts[-1] - foot))
    more = list(cuts)
    reach = nearest
    while reach < farthest:
        for t in (foot - reach, foot + reach):
            if cuts[0] < t < cuts[-1]:
                more.append(t)
        reach *= _DISTANCE_RATIO
    return np.sort(np.array(more))


@compiled()
def lamp_pieces(
    origin: Array,
    rays: Array,
    entry: Array,
    leave: Array,
    box: Array,
    moments: Array,
    longest: Array,
    lamp: Array,
    lamp_radius: float,
    finest: float,
    nearest: float,
    field: Array,
    thickest: float,
) -> tuple[Indices, Array]:
    """Cut rays into pieces that are small in angle at a lamp and lie within one grid cell.

    Args:
        origin: the eye (3,), m.
        rays: unit directions (n, 3).
        entry: distance of entry into the box (n,).
        leave: distance of exit (n,).
        box: corners (2, 3), m.
        moments: density and density · radius (nz, ny, nx, 2).
        longest: longest piece of each ray (n,), m.
        lamp: the lamp's centre (3,), m.
        lamp_radius: its radius, m; the part of a ray inside is left out.
        finest: largest angle of a piece at the lamp, rad.
        nearest: rays pass a lamp's centre no nearer than this, m.
        field: extinction (nz, ny, nx, 2), first channel, 1/m.
        thickest: greatest optical depth of a piece; infinite where nothing attenuates.

    Returns:
        First piece of each ray (n + 1,) and per piece (m, 6): distance of its middle [m], density
        times the integral of dt/d² [m⁻⁴], radius [m], the scattering angles at its ends [rad],
        and the lamp's angular radius [rad].
    """
    counts = np.array([moments.shape[2], moments.shape[1], moments.shape[0]])
    start = np.zeros(len(rays) + 1, dtype=np.int64)
    pieces = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)]
    towards = lamp - origin
    for pixel in range(len(rays)):
        ray = rays[pixel]
        foot = np.sum(towards * ray)
        side = max(np.sqrt(np.sum((towards - foot * ray) ** 2)), nearest)
        chord = np.sqrt(max(lamp_radius**2 - side**2, 0.0))
        if entry[pixel] < leave[pixel]:
            cuts = cut_ray(origin, ray, entry[pixel], leave[pixel], box, counts, longest[pixel])
            if lamp_radius > 0.0:
                cuts = _cut_by_distance(cuts, foot, max(side, lamp_radius))
            if np.isfinite(thickest):
                cuts = cut_by_depth(origin, ray, cuts, box, field, thickest)
            for k in range(len(cuts) - 1):
                for part in range(2):  # before and behind the lamp's own sphere
                    low = cuts[k] if part == 0 else max(cuts[k], foot + chord)
                    high = min(cuts[k + 1], foot - chord) if part == 0 else cuts[k + 1]
                    if chord == 0.0:
                        low, high = cuts[k], (cuts[k + 1] if part == 0 else cuts[k])
                    if high <= low:
                        continue
                    first, last = np.arctan((low - foot) / side), np.arctan((high - foot) / side)
                    number = max(1, int(np.ceil((last - first) / finest)))
                    # Within a piece drops are of one size: pieces follow the radius, too.
                    nodes = node_count(origin, ray, low, high, box, moments)
                    if nodes > LEAST_NODES:
                        number = max(number, PIECES_PER_NODE * nodes)
                    turn = (last - first) / number
                    # Beside the line through the lamp the angles are all but pi/2 and equal:
                    # there steps in 1/distance are steps in angle.
                    thin = (last - first) < 1e-6
                    for j in range(number):
                        if thin:
                            a, b = low, high
                            light = (b - a) / (side**2 + (a - foot) * (b - foot))
                            middle = 0.5 * (a + b) - foot
                        else:
                            a = foot + side * np.tan(first + j * turn)
                            b = foot + side * np.tan(first + (j + 1) * turn)
                            light = turn / side
                            middle = side * np.tan(first + (j + 0.5) * turn)
                        density, product = interpolate(origin + (foot + middle) * ray, box, moments)
                        if density > 0.0:
                            d = max(np.sqrt(side**2 + middle**2), lamp_radius * (1.0 + 1e-9))
                            pieces.append(
                                (
                                    foot + middle,
                                    density * light,
                                    product / density,
                                    np.arctan2(side, foot - a),
                                    np.arctan2(side, foot - b),
                                    np.arcsin(lamp_radius / d),
                                )
                            )
        start[pixel + 1] = len(pieces) - 1
    table = np.empty((len(pieces) - 1, 6))
    for n in range(1, len(pieces)):
        for c in range(6):
            table[n - 1, c] = pieces[n][c]
    return start, table


@compiled(parallel=True)
def _integrate_lamp(
    start: Indices,
    pieces: Array,
    column: Array,
    depth: Array,
    perpendicular: Array,
    bows: Array,
    sides: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
    running: Array,
    grid: Array,
) -> Array:
    pixels, wavelengths = len(start) - 1, len(air_depth)
    total = np.zeros((pixels, colour.shape[1]))
    for pixel in prange(pixels):
        for k in range(start[pixel], start[pixel + 1]):
            radius, disc = pieces[k, 2], pieces[k, 5]
            scale_power, strength_power = radius ** (2.0 / 3.0), radius ** (7.0 / 3.0)
            for w in range(wavelengths):
                section = 0.0
                for b in range(len(sides)):
                    scale = bows[b, 1, w] * scale_power
                    low = scale * sides[b] * (pieces[k, 3] - bows[b, 0, w])
                    high = scale * sides[b] * (pieces[k, 4] - bows[b, 0, w])
                    spread = scale * disc
                    if max(low, high) + spread < AIRY_LOW:
                        continue
                    # Chords across the disc; fringes of the running integral are weak, so that
                    # nodes for the phase across the disc's inner part are plenty.
                    phase = 2.0 * np.sqrt(max(max(low, high) + spread, 1.0)) * spread
                    count = 1 if disc == 0.0 else 10 + int(min(0.3 * phase + 4.0 * spread, 240.0))
                    mean = 0.0
                    for j in range(count):
                        angle = (j + 0.5) * np.pi / count
                        shift = spread * np.cos(angle)
                        chord = 2.0 / count * np.sin(angle) ** 2 if count > 1 else 1.0
                        if abs(high - low) > 1e-3:
                            rise = running_at(high + shift, running) - running_at(
                                low + shift, running
                            )
                            mean += chord * rise / (high - low)
                        else:
                            mean += chord * airy_squared_at(0.5 * (low + high) + shift, grid)
                    share = perpendicular[pixel]
                    strength = share * bows[b, 2, w] + (1.0 - share) * bows[b, 3, w]
                    section += strength * strength_power * mean
                passed = np.exp(-air_depth[w] * column[k] - rain_ratio[w] * depth[k])
                value = pieces[k, 1] * section * passed
                for c in range(colour.shape[1]):
                    total[pixel, c] += value * colour[w, c]
    return total


def integrate_lamp(
    start: Indices,
    pieces: Array,
    column: Array,
    depth: Array,
    perpendicular: Array,
    bows: Array,
    sides: Array,
    air_depth: Array,
    rain_ratio: Array,
    colour: Array,
) -> Array:
    """Sum the pieces of each pixel over wavelengths, for one lamp.

    Args:
        start: first piece of each pixel (n + 1,).
        pieces: as :func:`lamp_pieces` gives them (m, 6).
        column: air column towards lamp and eye per piece, in H0 (m,).
        depth: optical depth of the rain towards lamp and eye per piece, at 550 nm (m,).
        perpendicular: share of the bows' first strength per pixel (n,).
        bows: (bows, 4, W): angle, scale and two strengths per wavelength.
        sides: (bows,): +1 or -1.
        air_depth: vertical optical depth (W,).
        rain_ratio: the rain's extinction over that at 550 nm (W,).
        colour: (W, C), lm/sr for X, Y, Z.

    Returns:
        Sums per pixel (n, C): X, Y, Z with Y in cd/m², by weights that give these.
    """
    grids = (running_grid(), airy_grid())
    return np.asarray(
        _integrate_lamp(
            start, pieces, column, depth, perpendicular, bows, sides, air_depth, rain_ratio,
            colour, *grids,
        )
    )  # fmt: skip
