"""The sky as one eye sees it under one sun: tables over altitude and azimuth, for shaders.

Rays are summed here with NumPy, apart from the reference's compiled sums: what both share is the
field of what was scattered before, the shells, and the formulas of the molecules' phase function.
Single scattering is that of each piece's middle, by the share of the piece that the sun lights.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Float32, Indices, floats
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import top_distance
from rtbow.physics.light.fresnel import reflected_amplitudes
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.field import FIELD_NM
from rtbow.tables.sky.light import (
    COMPONENTS,
    HARMONICS,
    SCATTERED,
    Air,
    Scattered,
    harmonics,
)
from rtbow.tables.sky.rays import (
    AZIMUTHS,
    FALLING,
    RISING,
    Eye,
    Places,
    RowRays,
    Start,
    Suns,
    from_eye,
    heights,
    lit_share,
)

PHASE_PARTS = 3
"""Powers of the logarithm of the wavelength that an aerosol's phase function is taken as."""


class SkyTable(NamedTuple):
    """A sky as one eye sees it under one sun.

    Rows are altitudes: ``RISING`` from the horizon to the zenith, by the square of their place,
    then ``FALLING`` from it to the nadir, by the cube: from near the ground it is a few kilometres
    away at the horizon and some hundred metres 0.2 degrees below. Columns are azimuths from the
    sun's, evenly. The horizon's own ray is in both halves: above the ground, and ending on it.

    Attributes:
        layers: light that the air adds up to each distance and, as the last layer, in all, for each
            of S Stokes components (L, S, rows, columns, 3); without what aerosol makes of the sun's
            own light.
        glare: that, over its phase function (L, PHASE_PARTS, rows, columns, 3): the phase function
            at each wavelength is taken as parts times powers of ln(wavelength / 550 nm), 0 first,
            and so is the light; None where there is no aerosol.
        phase: the parts of the phase function (PHASE_PARTS, angles), 1/sr, at angles from the sun
            that are even in their square root: within 1 % of it for continental aerosol, and 3 %
            for maritime, whose aureole is ten times as narrow.
        ground: light of the ground that arrives (S, rows, columns, 3); none of water.
        beyond: share of a light above the air that arrives, times its colour (RISING, 3).
        horizon_rad: altitude of the horizon, rad.
        mirror: what water mirrors; None of other ground.
    """

    layers: Float32
    glare: Float32 | None
    phase: Float32 | None
    ground: Float32
    beyond: Float32
    horizon_rad: float
    mirror: Mirror | None


class Mirror(NamedTuple):
    """What still water shows along falling rays, as it arrives at the eye.

    Attributes:
        sky: (S, FALLING, columns, 3), without what aerosol makes of the sun's own light.
        glare: that, over its phase function at the angle of the mirrored ray from the sun, I alone
            (PHASE_PARTS, FALLING, columns, 3), as of :class:`SkyTable`.
        beyond: share of an unpolarised light above the air that arrives sharply, times its colour
            (S, FALLING, 3).
    """

    sky: Float32
    glare: Float32 | None
    beyond: Float32


def sky_table(
    air: Air, field: Scattered, glow: float, eye: Eye, colours: Array, ground: Array
) -> SkyTable:
    """Sum a sky.

    Args:
        air: the air and the ground, at ``FIELD_NM``.
        field: what was scattered before.
        glow: share of what the air scatters that counts.
        eye: where from, and under what.
        colours: what a radiance per irradiance above the air counts for in each channel
            (W, 3).
        ground: the same of an irradiance of the ground, whose albedo is in it (W, 3).
    """
    rays = RowRays.of(air, from_eye(eye), eye.distances_m)
    weights = _weights(air, glow, rays)
    light = _light(air, field, eye, rays, polarised=eye.polarised)
    added = np.asarray(np.matmul(light.molecules, _coloured(weights.molecules, colours)))
    glare = phase = None
    if light.haze is not None:
        added[0] += np.matmul(light.haze, _coloured(weights.haze, colours))
        single = [np.matmul(light.sun, _coloured(part * weights.haze, colours)) for part in _PARTS]
        glare = _at_layers(np.stack(single), rays)
        phase = np.linalg.lstsq(_PARTS.T, air.phase.T, rcond=None)[0].astype(np.float32)
    return SkyTable(
        _at_layers(added, rays),
        glare,
        phase,
        _ground_light(air, field, eye, rays, ground),
        (rays.beam[:RISING] @ colours).astype(np.float32),
        float(horizon_rad(eye.height_m)),
        _mirror(air, field, glow, eye, rays, colours) if np.any(air.water > 0.0) else None,
    )


_PARTS = np.stack([np.log(FIELD_NM / 550.0) ** k for k in range(PHASE_PARTS)])


class _Light(NamedTuple):
    """What is there to be scattered into rays, at the middles of their pieces.

    Attributes:
        molecules: over their phase function's factor, all light (S, rows, pieces, columns, W).
        haze: times its phase function, light that was scattered before (rows, pieces, columns, W);
            None where there is none.
        sun: its irradiance, of that above the air (rows, pieces, columns, W).
    """

    molecules: Float32
    haze: Float32 | None
    sun: Float32


def _light(air: Air, field: Scattered, eye: Eye, rays: RowRays, *, polarised: bool) -> _Light:
    places = Places.of(eye, rays)
    sun = _sunlight(air, eye, rays, places)
    molecules = _for_molecules(field, places, polarised=polarised)
    molecules += _single_phase(eye, rays, polarised=polarised) * sun
    return _Light(molecules, _for_haze(field, places) if air.hazy else None, sun)


class _Weights(NamedTuple):
    """How much of that arrives, scattered by molecules and by aerosol (rows, pieces, W)."""

    molecules: Array
    haze: Array


def _weights(air: Air, glow: float, rays: RowRays) -> _Weights:
    arriving = glow * rays.arriving
    return _Weights(SCATTERED * arriving * rays.scattered, arriving * rays.hazed)


def _mirror(
    air: Air, field: Scattered, glow: float, eye: Eye, rays: RowRays, colours: Array
) -> Mirror:
    """Sum what water mirrors at the end of the falling ones among rays."""
    sine = rays.start.sine[RISING:]
    _, turn_s, turn_c = heights(rays.start.height_m, sine, rays.edges[RISING:, -1])
    # The falling rays' altitudes at the water, which the mirrored ones have above it.
    rise = np.clip(-(turn_c * sine + turn_s * np.sqrt(1.0 - sine**2)), 1e-12, 1.0)
    start = Start(0.0, rise, turn_s, turn_c, top_distance(0.0, rise))
    mirrored = RowRays.of(air, start, np.zeros(0))
    across, within = reflected_amplitudes(air.water, rise[:, None])  # (FALLING, W)
    both, less = 0.5 * (across**2 + within**2), 0.5 * (across**2 - within**2)
    # I, Q and U after the mirror of those before it: both rays are in one upright plane.
    none = np.zeros_like(both)
    mueller = [[both, less, none], [less, both, none], [none, none, across * within]]
    mueller = mueller[: 3 if eye.polarised else 1]
    passed, beam = rays.through[RISING:], rays.beam[RISING:] * mirrored.beam
    weights = _weights(air, glow, mirrored)
    light = _light(air, field, eye, mirrored, polarised=True)

    def summed(what: Float32, weight: Array, share: Array) -> Float32:
        each = _coloured((share * passed)[:, None] * weight, colours)
        return np.asarray(np.matmul(what, each).sum(axis=1))

    sky = np.stack([
        sum(summed(light.molecules[k], weights.molecules, row[k]) for k in range(3))
        for row in mueller
    ])  # fmt: skip
    glare = None
    if light.haze is not None:
        for out, row in zip(sky, mueller, strict=True):
            out += summed(light.haze, weights.haze, row[0])
        glare = np.stack([summed(light.sun, part * weights.haze, both) for part in _PARTS])
    beyond = np.stack([(row[0] * beam) @ colours for row in mueller])
    return Mirror(sky.astype(np.float32), glare, beyond.astype(np.float32))


def _coloured(weights: Array, colours: Array) -> Float32:
    """Weights (rows, pieces, W) in each channel (rows, pieces, W, 3)."""
    return (weights[..., None] * colours).astype(np.float32)


def _at_layers(added: Float32, rays: RowRays) -> Float32:
    """Sum what pieces add (S, rows, pieces, columns, 3) up to each layer's distance and in all."""
    summed = np.cumsum(added, axis=2, dtype=np.float32)
    layers = [
        np.take_along_axis(summed, at[None, :, None, None, None], axis=2)[:, :, 0]
        for at in rays.last_piece
    ]
    return np.stack([*layers, summed[:, :, -1]])


def _for_molecules(field: Scattered, places: Places, *, polarised: bool) -> Float32:
    """What was scattered before, for molecules to scatter (S, rows, pieces, columns, W)."""
    stokes = _multiple_weights(places.suns, places.cosine, places.side)
    parts = slice(0, COMPONENTS)
    return np.stack([
        _multiple(field, places, parts, np.stack(part, axis=-1))
        for part in stokes[: 3 if polarised else 1]
    ])  # fmt: skip


def _for_haze(field: Scattered, places: Places) -> Float32:
    """What was scattered before, for aerosol to scatter (rows, pieces, columns, W)."""
    harmonic = np.zeros((HARMONICS, *places.zenith.shape))
    harmonics(places.cosine[..., None], places.side[..., None], places.suns.along, harmonic)
    parts = slice(COMPONENTS, COMPONENTS + HARMONICS)
    return _multiple(field, places, parts, np.moveaxis(harmonic, 0, -1))


def _multiple_weights(suns: Suns, cosine: Array, side: Array) -> list[list[Array]]:
    """What of the four components of A each of I, Q and U has along rays (rows, n, columns)."""
    u, v = cosine[..., None], side[..., None]
    c, s = suns.along, suns.across
    across = [s * s, c * c, np.zeros_like(c), np.zeros_like(c)]
    upright = [u * u * c * c, u * u * s * s, v * v + 0.0 * c, -2.0 * u * v * c]
    # Seen along the ray the sun's azimuth is at the other side of the horizontal.
    tilted = [s * c * u, -s * c * u, np.zeros_like(c), -s * v]
    return [
        [a + b for a, b in zip(across, upright, strict=True)],
        [a - b for a, b in zip(across, upright, strict=True)],
        [2.0 * a for a in tilted],
    ]


def _multiple(field: Scattered, places: Places, parts: slice, weights: Array) -> Float32:
    """Sum parts of what was scattered before by weights (rows, n, columns, parts), as it is at
    places: (rows, n, columns, W)."""
    i, v = _between(field.heights_m, places.height)
    j, u = _between(field.zeniths_rad, places.zenith)
    share = u.astype(np.float32)[..., None]
    # (H, parts, Z, W), so that one product sums the parts for all zenith angles and wavelengths.
    mean = np.ascontiguousarray(field.mean[:, :, parts].transpose(0, 2, 1, 3), dtype=np.float32)
    light = np.empty((*places.zenith.shape, mean.shape[-1]), dtype=np.float32)
    for row, weight in enumerate(weights.astype(np.float32)):
        # A row's places see the sun within a few degrees: the nodes about these alone.
        nodes = slice(int(j[row].min()), int(j[row].max()) + 2)
        here = mean[:, :, nodes].reshape(len(mean), mean.shape[1], -1)
        up = v[row].astype(np.float32)[:, None, None]
        there = here[i[row]]
        there += up * (here[i[row] + 1] - there)
        summed = np.matmul(weight, there).reshape(*weight.shape[:2], -1, mean.shape[-1])
        at = (j[row] - nodes.start)[..., None, None]
        near = np.take_along_axis(summed, at, axis=2)[:, :, 0]
        far = np.take_along_axis(summed, at + 1, axis=2)[:, :, 0]
        light[row] = near + share[row] * (far - near)
    return light


def _between(nodes: Array, at: Array) -> tuple[Indices, Array]:
    """Index of the lower node of each place, and the share of the step, held at the ends."""
    inside = np.clip(at, nodes[0], nodes[-1])
    index = np.clip(np.searchsorted(nodes, inside, "right") - 1, 0, len(nodes) - 2)
    return index, floats((inside - nodes[index]) / (nodes[index + 1] - nodes[index]))


def _single_phase(eye: Eye, rays: RowRays, *, polarised: bool) -> Float32:
    """I, Q and U of sunlight, of mean tensor (1 - s s) / 2, seen along rays (S, rows, 1, columns,
    1)."""
    sine = rays.start.sine[:, None]
    cosine = np.sqrt(1.0 - sine**2)
    azimuth = np.linspace(0.0, np.pi, AZIMUTHS)
    level = np.cos(eye.sun_altitude_rad)
    forward = level * np.cos(azimuth)
    turn_s, turn_c = rays.start.turned_sine[:, None], rays.start.turned_cosine[:, None]
    up = turn_c * np.sin(eye.sun_altitude_rad) + turn_s * forward
    forward = turn_c * forward - turn_s * np.sin(eye.sun_altitude_rad)
    # The sun along the ray's horizontal, to the side of growing azimuth, and its upright.
    across = -level * np.sin(azimuth) * np.ones_like(sine)
    upright = cosine * up - sine * forward
    first, second = 0.5 * (1.0 - across**2), 0.5 * (1.0 - upright**2)
    parts = [first + second, first - second, -across * upright]
    chosen = np.stack(parts[: 3 if polarised else 1])
    return chosen[:, :, None, :, None].astype(np.float32)


def _sunlight(air: Air, eye: Eye, rays: RowRays, places: Places) -> Float32:
    """The sun's irradiance at pieces, of that above the air (rows, n, columns, W)."""
    height = places.height[..., None]
    clear = 0.5 * np.pi - places.zenith - horizon_rad(height)
    columns = shells_of(air).column_at(height, clear)
    depth = np.tensordot(columns.astype(np.float32), air.depth.astype(np.float32), (0, 0))
    sunlight = np.exp(-depth)
    sunlight *= lit_share(eye, rays).astype(np.float32)[..., None]
    return sunlight


def _ground_light(air: Air, field: Scattered, eye: Eye, rays: RowRays, ground: Array) -> Float32:
    """Light of the ground at the end of rays that meet it (S, rows, columns, 3), unpolarised."""
    stokes = 3 if eye.polarised else 1
    light = np.zeros((stokes, RISING + FALLING, AZIMUTHS, 3), dtype=np.float32)
    falling = slice(RISING, None)
    end = rays.edges[falling, -1:]
    _, turn_s, turn_c = heights(eye.height_m, rays.start.sine[falling, None], end)
    cosine = Suns.of(eye, turn_s, turn_c).cosine[:, 0]  # (FALLING, columns)
    zenith = np.arccos(np.clip(cosine, -1.0, 1.0))
    j, u = _between(field.zeniths_rad, zenith)
    irradiance = (1.0 - u)[..., None] * field.ground[j] + u[..., None] * field.ground[j + 1]
    columns = shells_of(air).column_at(np.zeros_like(zenith), 0.5 * np.pi - zenith)
    direct = np.exp(-np.tensordot(columns, air.depth, (0, 0)))
    irradiance += np.maximum(cosine, 0.0)[..., None] * direct
    light[0, falling] = irradiance / np.pi * rays.through[falling, None, :] @ ground
    return light
