"""Random walks of light through rain, backward from the eye, compiled.

A path begins on a ray with a drop that it cannot miss: rays are forced to scatter, and weighted
with the share that would. From there on it flies free distances through the rain (Woodcock's
method) and turns by the phase function. At every drop but the first the lights are looked at: what
arrives from them at the first is the single scattering, which is summed elsewhere. A path that
leaves the rain sees the sky or the ground.

Source: Lux and Koblinger, Monte Carlo Particle Transport Methods (1991), chapters 3 and 5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Indices
from rtbow.base.compiled import compiled, prange
from rtbow.world.rain.volume_compiled import interpolate

_EVEN = (
    0.881271461633570,
    0.776639389089768,
    0.684430129585343,
    0.603168740685728,
    0.531555397715791,
)
"""Steps of numbers that fill five dimensions evenly: powers of the root of x⁶ = x + 1."""
_ABOUT_LIGHTS = (0.5, 0.3, 0.2, 0.15, 0.1, 0.1, 0.05, 0.05, 0.05, 0.0)
"""Share of paths that turn about the way to a light, at their first drops and from then on: each
such turn may weigh more than one, and those of hundreds would grow without limit."""


class Rain(NamedTuple):
    """The rain as paths meet it.

    Attributes:
        box: corners (2, 3), m.
        extinction: at 550 nm, 1/m, and nothing (nz, ny, nx, 2).
        moments: density, and density times radius (nz, ny, nx, 2), for the radius.
        greatest: extinction anywhere, 1/m.
        ratio: of the extinction at each wavelength to that at 550 nm (W,).
        first_radius: of the phase function's rows, m.
        rows_per_fold: of them.
        edges: cosines of the ends of its cells (N + 1,), falling.
        density: per steradian (R, W, N).
        running: (R, W, N + 1).
    """

    box: Array
    extinction: Array
    moments: Array
    greatest: float
    ratio: Array
    first_radius: float
    rows_per_fold: float
    edges: Array
    density: Array
    running: Array


class Layers(NamedTuple):
    """What the air takes between two places.

    Attributes:
        low: least height, m.
        per_m: nodes per metre.
        above: constituents' columns from the lowest height up to the nodes (C, H).
        rate: of the constituents at the nodes (C, H): columns per metre.
        beam: depth per column (C, W).
    """

    low: float
    per_m: float
    above: Array
    rate: Array
    beam: Array


class Lights(NamedTuple):
    """What lights the drops.

    Attributes:
        suns: unit vectors towards them (S, 3).
        discs: their angular radii (S,).
        sun_left: share of their light that reaches places over height and distance along their
            azimuth (S, H, D, W).
        sun_box: lowest and highest height, least and greatest of these distances for each (S, 4).
        lamps: places (L, 3), m.
        lamp_radii: (L,), m.
        nearest: squared distance to a lamp, at least, m².
        sun_weights: (S, W, C).
        lamp_weights: (L, W, C).
        sky: light from outside of the rain per irradiance of each sun, over altitude and azimuth
            (S, A, B, W), 1/sr; rows as ``sky_rows`` has them, columns even from azimuth 0 on.
        sky_rows: altitudes (A,), rad; twice that of the horizon.
    """

    suns: Array
    discs: Array
    sun_left: Array
    sun_box: Array
    lamps: Array
    lamp_radii: Array
    nearest: float
    sun_weights: Array
    lamp_weights: Array
    sky: Array
    sky_rows: Array


class Counted(NamedTuple):
    """Which light is counted.

    Attributes:
        several: that of suns and lamps, scattered twice and more.
        skylight: that from outside, scattered once, and more often where ``several``.
        most: drops of a path, at most.
        single: that of suns and lamps scattered once, too: for tests.
    """

    several: bool
    skylight: bool
    most: int
    single: bool


@compiled()
def _uniform(state: Indices) -> float:
    """The next of a sequence of numbers even in [0, 1) (SplitMix64: Steele et al., 2014)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@compiled()
def _cell_of(values: Array, at: float) -> int:
    """The cell of ascending ends that holds a value."""
    low, high = 0, len(values) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if values[middle] <= at:
            low = middle
        else:
            high = middle
    return low


@compiled()
def _exit(point: Array, towards: Array, box: Array) -> float:
    """Distance from a point in a box to where a direction leaves it."""
    leave = np.inf
    for axis in range(3):
        if towards[axis] > 0.0:
            leave = min(leave, (box[1, axis] - point[axis]) / towards[axis])
        elif towards[axis] < 0.0:
            leave = min(leave, (box[0, axis] - point[axis]) / towards[axis])
    return max(leave, 0.0)


@compiled()
def _pieces(towards: Array, length: float, rain: Rain) -> int:
    """Pieces of a way through a grid: of half a cell."""
    rate = 0.0
    for axis in range(3):
        extent = rain.box[1, axis] - rain.box[0, axis]
        cells = rain.extinction.shape[2 - axis] - 1
        rate = max(rate, abs(towards[axis]) * cells / extent)
    return 1 + int(2.0 * rate * length)


@compiled()
def _depth(point: Array, towards: Array, length: float, rain: Rain, at: Array) -> float:
    """Optical depth of rain at 550 nm along a way within the box: by midpoints of half a cell."""
    if rain.extinction.size == 2:  # even rain
        return float(length * rain.extinction[0, 0, 0, 0])
    pieces = _pieces(towards, length, rain)
    total = 0.0
    for k in range(pieces):
        for axis in range(3):
            at[axis] = point[axis] + (k + 0.5) / pieces * length * towards[axis]
        total += interpolate(at, rain.box, rain.extinction)[0]
    return total * length / pieces


@compiled()
def _distance_at(
    depth: float, point: Array, towards: Array, length: float, rain: Rain, at: Array
) -> float:
    """How far along a way rain of an optical depth at 550 nm lies: by the pieces of ``_depth``."""
    if rain.extinction.size == 2:  # even rain
        return float(min(depth / rain.extinction[0, 0, 0, 0], length))
    pieces = _pieces(towards, length, rain)
    step, total = length / pieces, 0.0
    for k in range(pieces):
        for axis in range(3):
            at[axis] = point[axis] + (k + 0.5) * step * towards[axis]
        piece = step * interpolate(at, rain.box, rain.extinction)[0]
        if total + piece >= depth and piece > 0.0:
            return (k + (depth - total) / piece) * step
        total += piece
    return length


@compiled()
def _air(low: float, high: float, length: float, wave: int, layers: Layers) -> float:
    """Share of light that the air leaves over a straight way between two heights."""
    depth = 0.0
    last = layers.above.shape[1] - 1
    first = min(max((low - layers.low) * layers.per_m, 0.0), last - 1e-9)
    second = min(max((high - layers.low) * layers.per_m, 0.0), last - 1e-9)
    i, j = int(first), int(second)
    for c in range(layers.above.shape[0]):
        if abs(high - low) < 1.0:
            column = length * layers.rate[c, i]
        else:
            start = layers.above[c, i] + (first - i) * (layers.above[c, i + 1] - layers.above[c, i])
            end = layers.above[c, j] + (second - j) * (layers.above[c, j + 1] - layers.above[c, j])
            column = length * (end - start) / (high - low)
        depth += layers.beam[c, wave] * column
    return float(np.exp(-depth))


@compiled()
def _sun_left(sun: int, point: Array, wave: int, lights: Lights) -> float:
    """Share of a sun's light that reaches a place through the air."""
    nodes = lights.sun_left[sun]
    low, high, near, far = lights.sun_box[sun]
    towards = lights.suns[sun]
    level = np.hypot(towards[0], towards[1])
    along = 0.0
    if level > 0.0:
        along = (point[0] * towards[0] + point[1] * towards[1]) / level
    z = min(max((point[2] - low) / max(high - low, 1e-9), 0.0), 1.0) * (nodes.shape[0] - 1)
    d = min(max((along - near) / max(far - near, 1e-9), 0.0), 1.0) * (nodes.shape[1] - 1)
    i, j = min(int(z), nodes.shape[0] - 2), min(int(d), nodes.shape[1] - 2)
    u, v = z - i, d - j
    return float(
        (1.0 - u) * ((1.0 - v) * nodes[i, j, wave] + v * nodes[i, j + 1, wave])
        + u * ((1.0 - v) * nodes[i + 1, j, wave] + v * nodes[i + 1, j + 1, wave])
    )  # fmt: skip


@compiled()
def _row_of(point: Array, rain: Rain, state: Indices) -> int:
    """The row of the phase function at a place: of two that are near, one by chance."""
    rows = rain.density.shape[0]
    if rows == 1:
        return 0
    density, product = interpolate(point, rain.box, rain.moments)
    if density <= 0.0:
        return 0
    place = np.log(product / density / rain.first_radius) * rain.rows_per_fold
    place = min(max(place, 0.0), rows - 1.0)
    row = min(int(place), rows - 2)
    return int(row + (1 if _uniform(state) < place - row else 0))


@compiled()
def _phase(row: int, wave: int, cosine: float, rain: Rain) -> float:
    """The phase function, 1/sr; none within the cut."""
    if cosine > rain.edges[0]:
        return 0.0
    low, high = 0, len(rain.edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if rain.edges[middle] >= cosine:
            low = middle
        else:
            high = middle
    return float(rain.density[row, wave, low])


@compiled()
def _turn(towards: Array, cosine: float, turn: float) -> None:
    """Turn a unit vector by an angle into a direction about it."""
    sine = np.sqrt(max(1.0 - cosine * cosine, 0.0))
    x, y, z = towards
    level = np.hypot(x, y)
    a, b = sine * np.cos(turn), sine * np.sin(turn)
    if level > 1e-12:
        towards[0] = cosine * x + (a * x * z - b * y) / level
        towards[1] = cosine * y + (a * y * z + b * x) / level
        towards[2] = cosine * z - a * level
    else:
        towards[0], towards[1], towards[2] = a, b, cosine * np.sign(z)
    size = np.sqrt(towards[0] ** 2 + towards[1] ** 2 + towards[2] ** 2)
    towards /= size


@compiled()
def _sky(sun: int, towards: Array, wave: int, lights: Lights) -> float:
    """Light from outside of the rain in a direction, per irradiance of a sun."""
    rows = lights.sky_rows
    columns = lights.sky.shape[2] - 1
    altitude = np.arctan2(towards[2], np.hypot(towards[0], towards[1]))
    i = min(max(_cell_of(rows, altitude), 0), len(rows) - 2)
    u = min(max((altitude - rows[i]) / max(rows[i + 1] - rows[i], 1e-12), 0.0), 1.0)
    turn = np.arctan2(towards[0], towards[1]) / (2.0 * np.pi)
    place = (turn - np.floor(turn)) * columns
    j = min(int(place), columns - 1)
    v = place - j
    nodes = lights.sky[sun]
    return float(
        (1.0 - u) * ((1.0 - v) * nodes[i, j, wave] + v * nodes[i, j + 1, wave])
        + u * ((1.0 - v) * nodes[i + 1, j, wave] + v * nodes[i + 1, j + 1, wave])
    )  # fmt: skip


@compiled()
def _from_lights(
    point: Array, towards: Array, weight: float, wave: int, row: int, rain: Rain, layers: Layers,
    lights: Lights, aims: Array, light: Array, work: Array,
) -> None:  # fmt: skip
    """Add what a drop scatters of suns and lamps back along a path."""
    to, at = work[0], work[1]
    for s in range(len(aims)):
        squared = _way_to(s, point, lights, aims, to)
        phase = _phase(row, wave, np.dot(to, towards), rain)
        if phase <= 0.0:
            continue
        length = _exit(point, to, rain.box)
        if s < len(lights.suns):
            left = _sun_left(s, point, wave, lights)
            colour = lights.sun_weights[s, wave]
        else:
            lamp, distance = s - len(lights.suns), np.sqrt(squared)
            length = min(length, distance)
            left = _air(point[2], lights.lamps[lamp, 2], distance, wave, layers)
            left /= max(squared, lights.nearest)
            colour = lights.lamp_weights[lamp, wave]
        if left > 0.0:
            depth = _depth(point, to, length, rain, at) * rain.ratio[wave]
            light += weight * phase * left * np.exp(-depth) * colour


@compiled()
def _aim(lights: Lights, state: Indices, aims: Array) -> None:
    """Choose a place on every light, for all of a path: a direction to a sun, evenly over its disc,
    or a place on a lamp (S + L, 3)."""
    for s in range(len(lights.suns)):
        cosine = 1.0 - _uniform(state) * 2.0 * np.sin(0.5 * lights.discs[s]) ** 2
        aims[s] = lights.suns[s]
        _turn(aims[s], cosine, 2.0 * np.pi * _uniform(state))
    for s in range(len(lights.lamps)):
        z = 2.0 * _uniform(state) - 1.0
        turn, level = 2.0 * np.pi * _uniform(state), np.sqrt(1.0 - z * z)
        aim, radius = aims[len(lights.suns) + s], lights.lamp_radii[s]
        aim[0] = lights.lamps[s, 0] + radius * level * np.cos(turn)
        aim[1] = lights.lamps[s, 1] + radius * level * np.sin(turn)
        aim[2] = lights.lamps[s, 2] + radius * z


@compiled()
def _scattered(
    point: Array, towards: Array, wave: int, row: int, drop: int, rain: Rain, lights: Lights,
    aims: Array, counted: Counted, even: Array, state: Indices, work: Array,
) -> float:  # fmt: skip
    """Turn a path at a drop; give what that weighs.

    Light comes round by one turn back and many small ones, in any order. The phase function about
    the path has those that turn back last; about the way to a light, those that do so first. Of
    both, at the first drops, neither weighs more than twice (Veach and Guibas, SIGGRAPH 1995).
    """
    running = rain.running[row, wave]
    chance = even[1] if drop == 0 else _uniform(state)
    cell = _cell_of(running, chance)
    within = (chance - running[cell]) / max(running[cell + 1] - running[cell], 1e-300)
    cosine = rain.edges[cell] + within * (rain.edges[cell + 1] - rain.edges[cell])
    turn = 2.0 * np.pi * (even[2] if drop == 0 else _uniform(state))
    count = len(aims)
    share = _ABOUT_LIGHTS[min(drop, len(_ABOUT_LIGHTS) - 1)] if counted.several else 0.0
    if share <= 0.0 or count == 0:
        _turn(towards, cosine, turn)
        return 1.0
    before, to = work[0], work[1]
    before[:] = towards
    if (even[3] if drop == 0 else _uniform(state)) < share:
        _way_to(int(_uniform(state) * count), point, lights, aims, towards)
    _turn(towards, cosine, turn)
    phase = _phase(row, wave, np.dot(before, towards), rain)
    mixed = 0.0
    for light in range(count):
        _way_to(light, point, lights, aims, to)
        mixed += _phase(row, wave, np.dot(to, towards), rain) / count
    return phase / max((1.0 - share) * phase + share * mixed, 1e-300)


@compiled()
def _way_to(light: int, point: Array, lights: Lights, aims: Array, to: Array) -> float:
    """Unit vector from a place to a sun, or to one of the lamps behind them; the squared distance
    to a lamp."""
    if light < len(lights.suns):
        to[:] = aims[light]
        return np.inf
    to[:] = aims[light] - point
    squared = to[0] ** 2 + to[1] ** 2 + to[2] ** 2
    if squared > 0.0:
        to /= np.sqrt(squared)
    else:
        to[2] = 1.0
    return float(squared)


@compiled()
def _add_outside(towards: Array, weight: float, wave: int, lights: Lights, light: Array) -> None:
    """Add light from outside of the rain."""
    for s in range(len(lights.suns)):
        light += weight * _sky(s, towards, wave, lights) * lights.sun_weights[s, wave]


@compiled()
def _path(
    ray: Array, origin: Array, ends: Array, depths: Array, wave: int, rain: Rain, layers: Layers,
    lights: Lights, counted: Counted, even: Array, state: Indices, light: Array, work: Array,
    aims: Array,
) -> None:  # fmt: skip
    """Follow one path at one wavelength, and add the light that it finds (C,).

    Args:
        ends: distances along the ray (M,).
        depths: of the rain up to there, at 550 nm (M,).
        even: numbers in [0, 1), for what happens first, that are more even than chance.
    """
    _aim(lights, state, aims)
    ratio = rain.ratio[wave]
    share = -np.expm1(-depths[-1] * ratio)
    depth = -np.log1p(-even[0] * share) / ratio
    cell = _cell_of(depths, depth)
    span = max(depths[cell + 1] - depths[cell], 1e-300)
    distance = ends[cell] + (ends[cell + 1] - ends[cell]) * min((depth - depths[cell]) / span, 1.0)
    point, towards = work[2], work[3]
    point[:] = origin + distance * ray
    towards[:] = ray
    for axis in range(3):
        point[axis] = min(max(point[axis], rain.box[0, axis]), rain.box[1, axis])
    weight = share * _air(origin[2], point[2], distance, wave, layers)
    most = rain.greatest * ratio
    for drop in range(counted.most):
        row = _row_of(point, rain, state)
        if counted.several and (drop > 0 or counted.single):
            _from_lights(point, towards, weight, wave, row, rain, layers, lights, aims, light, work)
        weight *= _scattered(
            point, towards, wave, row, drop, rain, lights, aims, counted, even, state, work
        )
        leave = _exit(point, towards, rain.box)
        flown, height = 0.0, point[2]
        if drop == 0:
            # Whatever leaves the rain here sees what is outside, and whatever does not goes on.
            depth = _depth(point, towards, leave, rain, work[1])
            share = -np.expm1(-depth * ratio)
            if counted.skylight:
                _add_outside(towards, weight * (1.0 - share), wave, lights, light)
            if share <= 0.0 or not counted.several:
                return
            weight *= share
            depth = -np.log1p(-even[4] * share) / ratio
            flown = _distance_at(depth, point, towards, leave, rain, work[1])
            for axis in range(3):
                point[axis] = min(
                    max(point[axis] + flown * towards[axis], rain.box[0, axis]), rain.box[1, axis]
                )
            weight *= _air(height, point[2], flown, wave, layers)
            continue
        while True:
            flown -= np.log1p(-_uniform(state)) / most
            if flown >= leave:
                break
            for axis in range(3):
                work[1, axis] = point[axis] + flown * towards[axis]
            here = interpolate(work[1], rain.box, rain.extinction)[0]
            if _uniform(state) * rain.greatest < here:
                break
        if flown >= leave:
            if counted.skylight:
                _add_outside(towards, weight, wave, lights, light)
            return
        point[:] = work[1]
        weight *= _air(height, point[2], flown, wave, layers)


@compiled(parallel=True)
def walk(
    rays: Array, origin: Array, ends: Array, depths: Array, chances: Array, rain: Rain,
    layers: Layers, lights: Lights, counted: Counted, batches: int, paths: int, seed: int,
) -> Array:  # fmt: skip
    """Follow paths from every ray.

    Args:
        rays: unit directions (n, 3).
        origin: the eye (3,).
        ends: distances along them (n, M); the first where they enter the rain.
        depths: of the rain up to there at 550 nm (n, M).
        chances: running sum of the wavelengths' chances (W + 1,), from 0 to 1.
        rain: the rain.
        layers: the air.
        lights: what lights them.
        counted: which light counts.
        batches: independent means to make.
        paths: of each.
        seed: of the random numbers.

    Returns:
        The means (batches, n, C), weighed.
    """
    channels = lights.sun_weights.shape[2]
    found = np.zeros((batches, len(rays), channels))
    for k in prange(batches * len(rays)):
        b, n = k // len(rays), k % len(rays)
        if depths[n, -1] <= 0.0:
            continue
        state = np.array([np.uint64(seed * 1_000_003 + k)])
        for _ in range(4):
            _uniform(state)
        state[0] ^= np.uint64(k) << np.uint64(32)
        work, light, total = np.zeros((4, 3)), np.zeros(channels), np.zeros(channels)
        aims = np.zeros((len(lights.suns) + len(lights.lamps), 3))
        even, shift = np.zeros(len(_EVEN)), np.zeros(len(_EVEN))
        for d in range(len(_EVEN)):
            shift[d] = _uniform(state)
        for p in range(paths):
            light[:] = 0.0
            for d in range(len(_EVEN)):
                even[d] = (shift[d] + p * _EVEN[d]) % 1.0
            chance = (p + _uniform(state)) / paths
            wave = _cell_of(chances, chance)
            _path(
                rays[n], origin, ends[n], depths[n], wave, rain, layers, lights, counted, even,
                state, light, work, aims,
            )  # fmt: skip
            total += light / (chances[wave + 1] - chances[wave])
        found[b, n] = total / paths
    return found
