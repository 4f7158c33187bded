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

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled, prange
from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import ALTITUDE_CURVE
from rtbow.physics.constants import EARTH_RADIUS_M

_SCATTERED = 3.0 / (8.0 * np.pi)
COMPONENTS = 4
"""Of the mean field A."""


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


@compiled()
def _columns_to_sun(height: float, sine: float, log_column: Array, columns: Array) -> bool:
    """Look up the constituents' columns towards the sun; False where the Earth is in the way."""
    horizon = -2.0 * np.arcsin(np.sqrt(0.5 * height / (EARTH_RADIUS_M + height)))
    altitude = np.arcsin(min(max(sine, -1.0), 1.0))
    if altitude < horizon:
        return False
    share = (altitude - horizon) / (0.5 * np.pi - horizon)
    q = np.log1p(share * np.expm1(ALTITUDE_CURVE)) / ALTITUDE_CURVE
    rows, count = log_column.shape[1], log_column.shape[2]
    y, x = np.sqrt(min(height / TOP_M, 1.0)) * (rows - 1), q * (count - 1)
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
    r = EARTH_RADIUS_M + height
    # Of the root's argument what the ground's sphere leaves: (r sine)² - (r² - R²).
    over = height * (r + EARTH_RADIUS_M)
    below = (r * sine) ** 2 - over
    if sine < 0.0 and below >= 0.0:
        return over / (-r * sine + np.sqrt(below)), True
    rise = (TOP_M - height) * (r + EARTH_RADIUS_M + TOP_M)
    return -r * sine + np.sqrt((r * sine) ** 2 + rise), False


@compiled()
def gather_ray(
    height: float, sun: Array, ray: Array, edges: Array, rain: Array, rain_ratio: Array,
    depth: Array, density: Array, log_column: Array, albedo: Array, heights: Array,
    zeniths: Array, field: Array, ground: Array, direct: bool, glow: float, probes: Array,
    out: Array, through: Array,
) -> None:  # fmt: skip
    """Sum what comes along a ray from the air and the ground, as seen by some probes.

    Args:
        height: of the ray's start, m; the frame's up is there.
        sun: unit direction towards it there (3,).
        ray: unit direction (3,).
        edges: distances of the pieces' ends, ascending from 0 (S + 1,).
        rain: optical depth of rain from the start to the middle of each piece (S,), and to the
            ray's end as the last one (S + 1,).
        rain_ratio: of the rain's depth at each wavelength over that (W,).
        depth: vertical depths (C, W), of which the first is of what scatters.
        density: of the constituents at even heights (C, N), 1/m.
        log_column: as in :class:`rtbow.physics.air.shells.Shells`.
        albedo: of the ground (W,).
        heights: of the field's nodes (H,), m.
        zeniths: of the sun's, rad (Z,).
        field: the mean field of what was scattered before (H, Z, W, 4), over the irradiance.
        ground: irradiance of the ground by what was scattered before (Z, W).
        direct: with the light that comes from the sun itself.
        glow: share of what the air scatters that counts.
        probes: symmetric tensors (K, 3, 3): a probe gets the trace of its product with the light's.
        out: filled with what the probes get, per irradiance above the air (W, K), 1/sr.
        through: filled with the share of light from the ray's end that arrives (W,).
    """
    waves, kinds, probed = depth.shape[1], depth.shape[0], len(probes)
    steps = len(edges) - 1
    columns, amount = np.zeros(kinds), np.zeros(kinds)
    across = np.zeros((probed, 3, 3))
    weight = np.zeros((probed, COMPONENTS + 1))
    axes = np.zeros((3, 3))
    # What of a probe is across the ray.
    for k in range(probed):
        for a in range(3):
            for b in range(3):
                value = 0.0
                for c in range(3):
                    for d in range(3):
                        left = (1.0 if a == c else 0.0) - ray[a] * ray[c]
                        right = (1.0 if d == b else 0.0) - ray[d] * ray[b]
                        value += left * probes[k, c, d] * right
                across[k, a, b] = value
    out[:] = 0.0
    through[:] = 1.0
    for step in range(steps):
        s = 0.5 * (edges[step] + edges[step + 1])
        length = edges[step + 1] - edges[step]
        r = 0.0
        for a in range(3):
            axes[2, a] = s * ray[a] + (EARTH_RADIUS_M + height if a == 2 else 0.0)
            r += axes[2, a] ** 2
        r = np.sqrt(r)
        # (r² - r0²) / (r + r0), without the loss of digits of r - R.
        rise = s * (2.0 * (EARTH_RADIUS_M + height) * ray[2] + s) / (r + EARTH_RADIUS_M + height)
        here = min(max(height + rise, 0.0), TOP_M)
        sine = 0.0
        for a in range(3):
            axes[2, a] /= r
            sine += axes[2, a] * sun[a]
        level = 0.0
        for a in range(3):
            axes[0, a] = sun[a] - sine * axes[2, a]
            level += axes[0, a] ** 2
        if level < 1e-12:  # under a sun in the zenith all azimuths are alike
            for a in range(3):
                axes[0, a] = (1.0 if a == 0 else 0.0) - axes[2, 0] * axes[2, a]
            level = 1.0 - axes[2, 0] ** 2
        level = np.sqrt(level)
        for a in range(3):
            axes[0, a] /= level
        axes[1, 0] = axes[2, 1] * axes[0, 2] - axes[2, 2] * axes[0, 1]
        axes[1, 1] = axes[2, 2] * axes[0, 0] - axes[2, 0] * axes[0, 2]
        axes[1, 2] = axes[2, 0] * axes[0, 1] - axes[2, 1] * axes[0, 0]
        for k in range(probed):
            trace = 0.0
            for component in range(COMPONENTS + 1):
                weight[k, component] = 0.0
            for a in range(3):
                trace += across[k, a, a]
                for b in range(3):
                    value = across[k, a, b]
                    for component in range(3):
                        weight[k, component] += value * axes[component, a] * axes[component, b]
                    weight[k, 3] += 2.0 * value * axes[0, a] * axes[2, b]
                    weight[k, 4] -= 0.5 * value * sun[a] * sun[b]
            weight[k, 4] += 0.5 * trace  # sunlight: half of what is across its direction
        place = here / TOP_M * (density.shape[1] - 1)
        n = min(int(place), density.shape[1] - 2)
        for c in range(kinds):
            share = place - n
            amount[c] = ((1.0 - share) * density[c, n] + share * density[c, n + 1]) * length
        lit = direct and _columns_to_sun(here, sine, log_column, columns)
        i, v = _place(here, heights)
        j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), zeniths)
        w00, w01, w10, w11 = (1.0 - v) * (1.0 - u), (1.0 - v) * u, v * (1.0 - u), v * u
        for w in range(waves):
            thick, towards = 0.0, 0.0
            for c in range(kinds):
                thick += depth[c, w] * amount[c]
                towards += depth[c, w] * columns[c]
            passed = np.exp(-thick)
            share = 1.0 if thick == 0.0 else depth[0, w] * amount[0] / thick
            scattered = glow * _SCATTERED * through[w] * (1.0 - passed) * share
            scattered *= np.exp(-rain[step] * rain_ratio[w])
            through[w] *= passed
            sunlight = np.exp(-towards) if lit else 0.0
            near, far = field[i, j, w], field[i, j + 1, w]
            near_up, far_up = field[i + 1, j, w], field[i + 1, j + 1, w]
            for component in range(COMPONENTS):
                mean = w00 * near[component] + w01 * far[component]
                mean += w10 * near_up[component] + w11 * far_up[component]
                mean *= scattered
                for k in range(probed):
                    out[w, k] += mean * weight[k, component]
            for k in range(probed):
                out[w, k] += scattered * sunlight * weight[k, 4]
    for w in range(waves):
        through[w] *= np.exp(-rain[steps] * rain_ratio[w])
    _add_ground(
        height, sun, ray, edges[steps], depth, log_column, albedo, zeniths, ground, direct,
        across, through, out,
    )  # fmt: skip


@compiled()
def _add_ground(
    height: float, sun: Array, ray: Array, end: float, depth: Array, log_column: Array,
    albedo: Array, zeniths: Array, ground: Array, direct: bool, across: Array, through: Array,
    out: Array,
) -> None:  # fmt: skip
    """Add the light of a Lambertian ground at the end of a ray that meets it, unpolarised."""
    if not ray_end(height, ray[2])[1]:
        return
    kinds, waves = depth.shape
    columns = np.zeros(kinds)
    sine, r = 0.0, 0.0
    for a in range(3):
        along = end * ray[a] + (EARTH_RADIUS_M + height if a == 2 else 0.0)
        sine += along * sun[a]
        r += along * along
    sine /= np.sqrt(r)
    lit = direct and sine > 0.0 and _columns_to_sun(0.0, sine, log_column, columns)
    j, u = _place(np.arccos(min(max(sine, -1.0), 1.0)), zeniths)
    for w in range(waves):
        irradiance = (1.0 - u) * ground[j, w] + u * ground[j + 1, w]
        if lit:
            towards = 0.0
            for c in range(kinds):
                towards += depth[c, w] * columns[c]
            irradiance += sine * np.exp(-towards)
        light = 0.5 * albedo[w] / np.pi * irradiance * through[w]
        for k in range(len(across)):
            out[w, k] += light * (across[k, 0, 0] + across[k, 1, 1] + across[k, 2, 2])


@compiled(parallel=True)
def gather_nodes(
    depth: Array, density: Array, log_column: Array, albedo: Array, heights: Array, zeniths: Array,
    field: Array, ground: Array, direct: bool, sines: Array, weights: Array, azimuths: int,
    steps: int, probes: Array,
) -> tuple[Array, Array]:  # fmt: skip
    """Give the next order's mean field (H, Z, W, 4) and irradiance of the ground (Z, W).

    Args:
        depth: and those up to ``direct`` as for :func:`gather_ray`.
        sines: of the rays' altitudes at each height (H, A).
        weights: of these rays' shares of solid angle over 2 pi (H, A).
        azimuths: over half a circle, from the sun's on: the other half is its image.
        steps: pieces of a ray.
        probes: the field's components, as probes (4, 3, 3).
    """
    many, waves = len(zeniths), depth.shape[1]
    mean = np.zeros((len(heights), many, waves, COMPONENTS))
    below = np.zeros((many, waves))
    for node in prange(len(heights) * many):
        i, j = node // many, node % many
        sun, ray = np.zeros(3), np.zeros(3)
        sun[0], sun[2] = np.sin(zeniths[j]), np.cos(zeniths[j])
        out, through = np.zeros((waves, COMPONENTS)), np.zeros(waves)
        edges, rain, dry = np.zeros(steps + 1), np.zeros(steps + 1), np.zeros(waves)
        for a in range(sines.shape[1]):
            ray[2] = sines[i, a]
            level = np.sqrt(max(1.0 - ray[2] * ray[2], 0.0))
            end = ray_end(heights[i], ray[2])[0]
            for step in range(steps + 1):
                edges[step] = end * (step / steps) ** 2
            for p in range(azimuths):
                angle = np.pi * (p + 0.5) / azimuths
                ray[0], ray[1] = level * np.cos(angle), level * np.sin(angle)
                gather_ray(
                    heights[i], sun, ray, edges, rain, dry, depth, density, log_column, albedo,
                    heights, zeniths, field, ground, direct, 1.0, probes, out, through,
                )  # fmt: skip
                weight = weights[i, a] * 2.0 * np.pi / azimuths
                for w in range(waves):
                    for component in range(COMPONENTS):
                        mean[i, j, w, component] += weight * out[w, component]
                    if i == 0 and ray[2] > 0.0:
                        total = out[w, 0] + out[w, 1] + out[w, 2]
                        below[j, w] += weight * ray[2] * total
    return mean, below
