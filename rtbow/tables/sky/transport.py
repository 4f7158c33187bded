"""Light that the air scatters into straight rays through spherical shells, compiled.

The tensors and harmonics that it is summed in are those of :mod:`rtbow.tables.sky.light`.
"""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled, prange
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import (
    LEAST_RISE_M,
    column_place,
    column_within,
    ground_distance,
    top_distance,
)
from rtbow.physics.constants import EARTH_RADIUS_M
from rtbow.physics.light.fresnel import reflected_amplitudes
from rtbow.tables.sky.light import (
    COMPONENTS,
    HARMONICS,
    SCATTERED,
    Air,
    Path,
    Scattered,
    harmonics,
)

_harmonics = compiled()(harmonics)


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
_column_within = compiled()(column_within)
_ground_distance = compiled()(ground_distance)
_top_distance = compiled()(top_distance)
_reflected_amplitudes = compiled()(reflected_amplitudes)


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
    return _height_at(path, distance), sine


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
def _height_at(path: Path, distance: float) -> float:
    """Height at a distance along a ray, m: without the loss of digits of a difference of radii."""
    start = EARTH_RADIUS_M + path.height_m
    up = start + distance * path.ray[2]
    r = np.sqrt(up * up + (1.0 - path.ray[2] ** 2) * distance * distance)
    rise = distance * (2.0 * start * path.ray[2] + distance) / (r + start)
    return float(min(max(path.height_m + rise, 0.0), TOP_M))


@compiled()
def _below(air: Air, c: int, height: float) -> float:
    """Share of a constituent's vertical column below a height."""
    last = air.density.shape[1] - 1
    place = height / TOP_M * last
    n = min(int(place), last - 1)
    within = _column_within(place - n, air.density[c, n], air.density[c, n + 1])
    return float(air.below[c, n] + within)


@compiled()
def _amounts(air: Air, first: float, last: float, length: float, amounts: Array) -> None:
    """Fill in the share of each constituent's vertical column along a length between heights."""
    low, high = min(first, last), max(first, last)
    high = max(high, low + LEAST_RISE_M)
    for c in range(len(amounts)):
        amounts[c] = (_below(air, c, high) - _below(air, c, low)) / (high - low) * length


@compiled()
def _phase_at(air: Air, cosine: float, phase: Array) -> None:
    """Fill in the aerosol's phase function (W,) at a scattering angle."""
    last = len(air.phase) - 1
    place = np.sqrt(np.arccos(min(max(cosine, -1.0), 1.0)) / np.pi) * last
    n = min(int(place), last - 1)
    share = place - n
    for w in range(len(phase)):
        phase[w] = (1.0 - share) * air.phase[n, w] + share * air.phase[n + 1, w]


@compiled()
def _interpolate(
    before: Scattered, height: float, sine: float, count: int, weights: Array, local: Array
) -> None:
    """Fill in what was scattered before at a place: components of A (4, W), and as one more row the
    sum of the harmonics by weights (HARMONICS,), where there are any."""
    i, v = _place(height, before.heights_m)
    j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), before.zeniths_rad)
    waves = local.shape[1]
    local[:] = 0.0
    for corner in range(4):
        up, right = corner // 2, corner % 2
        share = (v if up else 1.0 - v) * (u if right else 1.0 - u)
        if share == 0.0:
            continue
        # Rows of arrays as arrays of their own would cost more than what is done with them.
        for component in range(COMPONENTS):
            for w in range(waves):
                local[component, w] += share * before.mean[i + up, j + right, component, w]
        for n in range(count):
            factor, row = share * weights[n], COMPONENTS + n
            for w in range(waves):
                local[COMPONENTS, w] += factor * before.mean[i + up, j + right, row, w]


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
        out: filled with what the probes get, per irradiance above the air (K, W), 1/sr.
        through: filled with the share of light from the ray's end that arrives (W,).
    """
    kinds, waves = air.depth.shape
    # A field without harmonics has scattered nothing that aerosol could scatter again.
    probed, count = len(probes), before.mean.shape[2] - COMPONENTS
    columns, amounts, axes = np.zeros(kinds), np.zeros(kinds), np.zeros((3, 3))
    across, weight = np.zeros((probed, 3, 3)), np.zeros((probed, COMPONENTS + 1))
    seen = np.zeros(probed)
    for k in range(probed):
        across[k] = _across(probes[k], path.ray)
        seen[k] = 0.5 * (across[k, 0, 0] + across[k, 1, 1] + across[k, 2, 2])
    local, harmonic = np.zeros((COMPONENTS + 1, waves)), np.zeros(HARMONICS)
    sunlight, phase, by_molecules = np.zeros(waves), np.zeros(waves), np.zeros(waves)
    if air.hazy:
        _phase_at(air, path.ray[0] * sun[0] + path.ray[1] * sun[1] + path.ray[2] * sun[2], phase)
    out[:] = 0.0
    through[:] = 1.0
    reached = _height_at(path, path.edges[0])
    for step in range(len(path.edges) - 1):
        first, last = path.edges[step], path.edges[step + 1]
        height, sine = _local_frame(path, 0.5 * (first + last), sun, axes)
        for k in range(probed):
            _weigh(across[k], axes, sun, weight[k])
        left, reached = reached, _height_at(path, last)
        _amounts(air, left, reached, last - first, amounts)
        lit = direct and _columns_to_sun(height, sine, air.log_column, columns)
        if count:
            _harmonics_of(path.ray, axes, harmonic)
        _interpolate(before, height, sine, count, harmonic, local)
        for w in range(waves):
            thick, towards = 0.0, 0.0
            for c in range(kinds):
                thick += air.depth[c, w] * amounts[c]
                towards += air.depth[c, w] * columns[c]
            passed = np.exp(-thick)
            arrives = glow * through[w]
            if path.rain[step] > 0.0:
                arrives *= np.exp(-path.rain[step] * path.rain_ratio[w])
            arrives *= 1.0 if thick == 0.0 else (1.0 - passed) / thick
            through[w] *= passed
            sunlight[w] = np.exp(-towards) if lit else 0.0
            by_molecules[w] = arrives * SCATTERED * air.depth[0, w] * amounts[0]
            # What aerosol scatters, unpolarised, takes the place of its harmonics' sum.
            local[COMPONENTS, w] += phase[w] * sunlight[w]
            local[COMPONENTS, w] *= arrives * air.scattering[w] * air.depth[-1, w] * amounts[-1]
        for k in range(probed):
            for component in range(COMPONENTS):
                for w in range(waves):
                    out[k, w] += weight[k, component] * by_molecules[w] * local[component, w]
            for w in range(waves):
                out[k, w] += weight[k, COMPONENTS] * by_molecules[w] * sunlight[w]
            if air.hazy:
                for w in range(waves):
                    out[k, w] += seen[k] * local[COMPONENTS, w]
    for w in range(waves):
        through[w] *= np.exp(-path.rain[-1] * path.rain_ratio[w])
    if ray_end(path.height_m, path.ray[2])[1]:
        _add_ground(path, sun, air, before, direct, seen, through, out)


@compiled()
def _harmonics_of(ray: Array, axes: Array, out: Array) -> None:
    """Fill in the harmonics of a ray's direction in a local frame."""
    along = ray[0] * axes[0, 0] + ray[1] * axes[0, 1] + ray[2] * axes[0, 2]
    aside = ray[0] * axes[1, 0] + ray[1] * axes[1, 1] + ray[2] * axes[1, 2]
    up = ray[0] * axes[2, 0] + ray[1] * axes[2, 1] + ray[2] * axes[2, 2]
    level = np.sqrt(along * along + aside * aside)
    _harmonics(up, level, along / level if level > 0.0 else 1.0, out)


@compiled()
def _add_ground(
    path: Path, sun: Array, air: Air, before: Scattered, direct: bool, seen: Array,
    through: Array, out: Array,
) -> None:  # fmt: skip
    """Add the light of a Lambertian ground at the end of a ray, unpolarised. Water counts as one
    that sends back as much of the sun's light and of the sky's as it mirrors of them."""
    kinds, waves = air.depth.shape
    columns = np.zeros(kinds)
    sine = _local_frame(path, path.edges[-1], sun, np.zeros((3, 3)))[1]
    lit = direct and sine > 0.0
    lit = lit and _columns_to_sun(0.0, sine, air.log_column, columns)
    j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), before.zeniths_rad)
    for w in range(waves):
        irradiance = (1.0 - u) * before.ground[j, w] + u * before.ground[j + 1, w]
        sent = air.albedo[w] * irradiance
        if lit:
            towards = 0.0
            for c in range(kinds):
                towards += air.depth[c, w] * columns[c]
            share = air.albedo[w]
            if air.water[w] > 0.0:
                across, within = _reflected_amplitudes(air.water[w], sine)
                share = 0.5 * (across * across + within * within)
            sent += share * sine * np.exp(-towards)
        light = sent / np.pi * through[w]
        for k in range(len(seen)):
            out[k, w] += light * seen[k]


@compiled(parallel=True)
def gather_nodes(
    air: Air, before: Scattered, direct: bool, sines: Array, weights: Array, azimuths: int,
    steps: int, probes: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Give the next order's mean field, I_lm without chi_l, and irradiance of the ground (Z, W).

    Args:
        air: as for :func:`gather_ray`; its phase function is to be the cut one.
        before: the order before.
        direct: whether that is the sun's own light.
        sines: of the rays' altitudes at each height (H, A).
        weights: of these rays' shares of solid angle over 2 pi (H, A).
        azimuths: over half a circle, from the sun's on: the other half is its image.
        steps: pieces of a ray.
        probes: the field's components, as probes (4, 3, 3).

    Returns:
        The field as ``before.mean``, and the irradiance.
    """
    many, waves = len(before.zeniths_rad), air.depth.shape[1]
    mean = np.zeros(before.mean.shape)
    below = np.zeros(before.ground.shape)
    for node in prange(len(before.heights_m) * many):
        i, j = node // many, node % many
        height, zenith = before.heights_m[i], before.zeniths_rad[j]
        sun = np.array([np.sin(zenith), 0.0, np.cos(zenith)])
        ray, out, through = np.zeros(3), np.zeros((COMPONENTS, waves)), np.zeros(waves)
        total, harmonic = np.zeros(waves), np.zeros(HARMONICS)
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
                for component in range(COMPONENTS):
                    for w in range(waves):
                        mean[i, j, component, w] += weight * out[component, w]
                for w in range(waves):
                    total[w] = out[0, w] + out[1, w] + out[2, w]
                if air.hazy:
                    _harmonics(ray[2], level, np.cos(angle), harmonic)
                    for n in range(HARMONICS):
                        for w in range(waves):
                            mean[i, j, COMPONENTS + n, w] += weight * harmonic[n] * total[w]
                if i == 0 and ray[2] > 0.0:
                    for w in range(waves):
                        below[j, w] += weight * ray[2] * total[w]
    return mean, below
