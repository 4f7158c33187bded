"""Light that molecules scatter into straight rays through spherical shells, compiled.

Light is a coherency tensor: of the field's components across its direction, whose trace is the
radiance and of which a polariser passes ``f·C·f``. Molecules that are small against the wavelength
scatter into a direction v what of the mean field is across it,

    S(v) = 3/(8 pi) P A P,   P = 1 - v v,   A = integral of C over all directions,

so that all orders of scattering, polarised, follow from the six numbers of A at each place. Over a
sphere under a sun A depends on height and the sun's zenith angle alone, and has four components in
the frame of the local vertical and the sun: A = a xx + b yy + c uu + d (xu + ux), with u up and x
towards the sun's azimuth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled, prange
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import column_place, ground_distance, top_distance
from rtbow.physics.constants import EARTH_RADIUS_M

SCATTERED = 3.0 / (8.0 * np.pi)
COMPONENTS = 4
"""Of the mean field A."""


class Air(NamedTuple):
    """Air over a ground.

    Attributes:
        density: of its constituents over height, as in :class:`rtbow.physics.air.shells.Shells`;
            the first one scatters as molecules do, the others absorb.
        log_column: their columns towards a sun, as there.
        depth: their vertical depths (C, W).
        albedo: of the ground (W,).
    """

    density: Array
    log_column: Array
    depth: Array
    albedo: Array


class Scattered(NamedTuple):
    """What has been scattered at least once, per irradiance above the air.

    Attributes:
        heights_m: of the nodes (H,).
        zeniths_rad: of the sun at the nodes (Z,).
        mean: the four components of A (H, Z, W, 4).
        ground: diffuse irradiance of the ground (Z, W).
    """

    heights_m: Array
    zeniths_rad: Array
    mean: Array
    ground: Array


class Path(NamedTuple):
    """A ray in pieces, and the rain along it.

    Attributes:
        height_m: of its start; the frame's up is there.
        ray: unit direction (3,).
        edges: distances of the pieces' ends, m, ascending from 0 (S + 1,).
        rain: optical depth of rain from the start to the middle of each piece, and to the end of
            the last one (S + 1,).
        rain_ratio: of the rain's depth at each wavelength over that (W,).
    """

    height_m: float
    ray: Array
    edges: Array
    rain: Array
    rain_ratio: Array


@compiled()
def _place(x: float, nodes: Array) -> tuple[int, float]:
    """Where a value lies between ascending nodes: the lower one's index and the share of the step,
    held at the ends."""
    last = len(nodes) - 1
    if x <= nodes[0]:
        return 0, 0.0
    if x >= nodes[last]:
        return last - 1, 1.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if nodes[middle] <= x:
            low = middle
        else:
            high = middle
    return low, (x - nodes[low]) / (nodes[low + 1] - nodes[low])


_horizon = compiled()(horizon_rad)
_column_place = compiled()(column_place)
_ground_distance = compiled()(ground_distance)
_top_distance = compiled()(top_distance)


@compiled()
def _columns_to_sun(height: float, sine: float, log_column: Array, columns: Array) -> bool:
    """Look up the constituents' columns towards the sun; False where the Earth is in the way."""
    horizon = _horizon(height)
    altitude = np.arcsin(min(max(sine, -1.0), 1.0))
    if altitude < horizon:
        return False
    rows, count = log_column.shape[1], log_column.shape[2]
    y, x = _column_place(min(height, TOP_M), altitude - horizon, horizon)
    y, x = y * (rows - 1), x * (count - 1)
    i, j = min(int(y), rows - 2), min(int(x), count - 2)
    v, u = y - i, x - j
    for c in range(len(columns)):
        table = log_column[c]
        low = (1.0 - u) * table[i, j] + u * table[i, j + 1]
        high = (1.0 - u) * table[i + 1, j] + u * table[i + 1, j + 1]
        columns[c] = np.exp((1.0 - v) * low + v * high)
    return True


@compiled()
def ray_end(height: float, sine: float) -> tuple[float, bool]:
    """Distance at which a ray from a height leaves the air, m, or meets the ground, and which."""
    if sine < 0.0 and sine <= np.sin(_horizon(height)):
        return _ground_distance(height, sine), True
    return _top_distance(height, sine), False


@compiled()
def _across(probe: Array, ray: Array) -> Array:
    """The part of a probe that light along a ray meets: P N P (3, 3)."""
    across = np.zeros((3, 3))
    for a in range(3):
        for b in range(3):
            for c in range(3):
                for d in range(3):
                    left = (1.0 if a == c else 0.0) - ray[a] * ray[c]
                    right = (1.0 if d == b else 0.0) - ray[d] * ray[b]
                    across[a, b] += left * probe[c, d] * right
    return across


@compiled()
def _local_frame(path: Path, distance: float, sun: Array, axes: Array) -> tuple[float, float]:
    """Fill in the frame at a distance along a ray: towards the sun's azimuth, across, up (3, 3).

    Returns:
        The height there, m, and the sine of the sun's altitude.
    """
    start = EARTH_RADIUS_M + path.height_m
    up = axes[2]
    for a in range(3):
        up[a] = distance * path.ray[a] + (start if a == 2 else 0.0)
    r = np.sqrt(up[0] ** 2 + up[1] ** 2 + up[2] ** 2)
    # (r² - r0²) / (r + r0), without the loss of digits of r - R.
    rise = distance * (2.0 * start * path.ray[2] + distance) / (r + start)
    for a in range(3):
        up[a] /= r
    sine = up[0] * sun[0] + up[1] * sun[1] + up[2] * sun[2]
    towards = axes[0]
    for a in range(3):
        towards[a] = sun[a] - sine * up[a]
    level = towards[0] ** 2 + towards[1] ** 2 + towards[2] ** 2
    if level < 1e-12:  # under a sun in the zenith all azimuths are alike
        for a in range(3):
            towards[a] = (1.0 if a == 0 else 0.0) - up[0] * up[a]
        level = 1.0 - up[0] ** 2
    for a in range(3):
        towards[a] /= np.sqrt(level)
    axes[1, 0] = up[1] * towards[2] - up[2] * towards[1]
    axes[1, 1] = up[2] * towards[0] - up[0] * towards[2]
    axes[1, 2] = up[0] * towards[1] - up[1] * towards[0]
    return min(max(path.height_m + rise, 0.0), TOP_M), sine


@compiled()
def _weigh(across: Array, axes: Array, sun: Array, weights: Array) -> None:
    """Fill in what a probe gets of each component of A and, as the last one, of sunlight."""
    weights[:] = 0.0
    for a in range(3):
        for b in range(3):
            value = across[a, b]
            for component in range(3):
                weights[component] += value * axes[component, a] * axes[component, b]
            weights[3] += 2.0 * value * axes[0, a] * axes[2, b]
            weights[4] -= 0.5 * value * sun[a] * sun[b]
    # Half of sunlight's field is along each direction across it.
    weights[4] += 0.5 * (across[0, 0] + across[1, 1] + across[2, 2])


@compiled()
def _amounts(density: Array, height: float, length: float, amounts: Array) -> None:
    """Fill in the share of each constituent's vertical column along a length at a height."""
    last = density.shape[1] - 1
    place = height / TOP_M * last
    n = min(int(place), last - 1)
    share = place - n
    for c in range(len(amounts)):
        amounts[c] = ((1.0 - share) * density[c, n] + share * density[c, n + 1]) * length


@compiled()
def gather_ray(
    path: Path, sun: Array, air: Air, before: Scattered, direct: bool, glow: float, probes: Array,
    out: Array, through: Array,
) -> None:  # fmt: skip
    """Sum what comes along a ray from the air and the ground, as seen by some probes.

    Args:
        path: the ray.
        sun: unit direction towards it at the ray's start (3,).
        air: what scatters and absorbs, and the ground below.
        before: what was scattered before.
        direct: with the light that comes from the sun itself.
        glow: share of what the air scatters that counts.
        probes: symmetric tensors (K, 3, 3): a probe gets the trace of its product with the light's.
        out: filled with what the probes get, per irradiance above the air (W, K), 1/sr.
        through: filled with the share of light from the ray's end that arrives (W,).
    """
    kinds, waves = air.depth.shape
    probed = len(probes)
    columns, amounts, axes = np.zeros(kinds), np.zeros(kinds), np.zeros((3, 3))
    across, weight = np.zeros((probed, 3, 3)), np.zeros((probed, COMPONENTS + 1))
    for k in range(probed):
        across[k] = _across(probes[k], path.ray)
    out[:] = 0.0
    through[:] = 1.0
    for step in range(len(path.edges) - 1):
        first, last = path.edges[step], path.edges[step + 1]
        height, sine = _local_frame(path, 0.5 * (first + last), sun, axes)
        for k in range(probed):
            _weigh(across[k], axes, sun, weight[k])
        _amounts(air.density, height, last - first, amounts)
        lit = direct and _columns_to_sun(height, sine, air.log_column, columns)
        i, v = _place(height, before.heights_m)
        j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), before.zeniths_rad)
        w00, w01, w10, w11 = (1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u
        for w in range(waves):
            thick, towards = 0.0, 0.0
            for c in range(kinds):
                thick += air.depth[c, w] * amounts[c]
                towards += air.depth[c, w] * columns[c]
            passed = np.exp(-thick)
            share = 1.0 if thick == 0.0 else air.depth[0, w] * amounts[0] / thick
            scattered = glow * SCATTERED * through[w] * (1.0 - passed) * share
            scattered *= np.exp(-path.rain[step] * path.rain_ratio[w])
            through[w] *= passed
            sunlight = np.exp(-towards) if lit else 0.0
            near, far = before.mean[i, j, w], before.mean[i, j + 1, w]
            near_up, far_up = before.mean[i + 1, j, w], before.mean[i + 1, j + 1, w]
            for component in range(COMPONENTS):
                mean = w00 * near[component] + w01 * far[component]
                mean += w10 * near_up[component] + w11 * far_up[component]
                mean *= scattered
                for k in range(probed):
                    out[w, k] += mean * weight[k, component]
            for k in range(probed):
                out[w, k] += scattered * sunlight * weight[k, COMPONENTS]
    for w in range(waves):
        through[w] *= np.exp(-path.rain[-1] * path.rain_ratio[w])
    if ray_end(path.height_m, path.ray[2])[1]:
        _add_ground(path, sun, air, before, direct, across, through, out)


@compiled()
def _add_ground(
    path: Path, sun: Array, air: Air, before: Scattered, direct: bool, across: Array,
    through: Array, out: Array,
) -> None:  # fmt: skip
    """Add the light of a Lambertian ground at the end of a ray, unpolarised."""
    kinds, waves = air.depth.shape
    columns = np.zeros(kinds)
    sine = _local_frame(path, path.edges[-1], sun, np.zeros((3, 3)))[1]
    lit = direct and sine > 0.0
    lit = lit and _columns_to_sun(0.0, sine, air.log_column, columns)
    j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), before.zeniths_rad)
    for w in range(waves):
        irradiance = (1.0 - u) * before.ground[j, w] + u * before.ground[j + 1, w]
        if lit:
            towards = 0.0
            for c in range(kinds):
                towards += air.depth[c, w] * columns[c]
            irradiance += sine * np.exp(-towards)
        light = 0.5 * air.albedo[w] / np.pi * irradiance * through[w]
        for k in range(len(across)):
            out[w, k] += light * (across[k, 0, 0] + across[k, 1, 1] + across[k, 2, 2])


@compiled(parallel=True)
def gather_nodes(
    air: Air, before: Scattered, direct: bool, sines: Array, weights: Array, azimuths: int,
    steps: int, probes: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Give the next order's mean field (H, Z, W, 4) and irradiance of the ground (Z, W).

    Args:
        air: as for :func:`gather_ray`.
        before: the order before.
        direct: whether that is the sun's own light.
        sines: of the rays' altitudes at each height (H, A).
        weights: of these rays' shares of solid angle over 2 pi (H, A).
        azimuths: over half a circle, from the sun's on: the other half is its image.
        steps: pieces of a ray.
        probes: the field's components, as probes (4, 3, 3).
    """
    many, waves = len(before.zeniths_rad), air.depth.shape[1]
    mean = np.zeros(before.mean.shape)
    below = np.zeros(before.ground.shape)
    for node in prange(len(before.heights_m) * many):
        i, j = node // many, node % many
        height, zenith = before.heights_m[i], before.zeniths_rad[j]
        sun = np.array([np.sin(zenith), 0.0, np.cos(zenith)])
        ray, out, through = np.zeros(3), np.zeros((waves, COMPONENTS)), np.zeros(waves)
        edges, rain, dry = np.zeros(steps + 1), np.zeros(steps + 1), np.zeros(waves)
        path = Path(height, ray, edges, rain, dry)
        for a in range(sines.shape[1]):
            ray[2] = sines[i, a]
            level = np.sqrt(max(1.0 - ray[2] * ray[2], 0.0))
            end = ray_end(height, ray[2])[0]
            for step in range(steps + 1):
                edges[step] = end * (step / steps) ** 2
            for p in range(azimuths):
                angle = np.pi * (p + 0.5) / azimuths
                ray[0], ray[1] = level * np.cos(angle), level * np.sin(angle)
                gather_ray(path, sun, air, before, direct, 1.0, probes, out, through)
                weight = weights[i, a] * 2.0 * np.pi / azimuths
                for w in range(waves):
                    for component in range(COMPONENTS):
                        mean[i, j, w, component] += weight * out[w, component]
                    if i == 0 and ray[2] > 0.0:
                        total = out[w, 0] + out[w, 1] + out[w, 2]
                        below[j, w] += weight * ray[2] * total
    return mean, below
