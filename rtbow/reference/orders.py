"""Light that rain scatters more than once, and what sky and ground light in it: by random walks.

Unbiased but for the cells of the phase function (:mod:`rtbow.tables.orders.phase`) and for what is
interpolated: the air's transmission towards a sun, and the light from outside of the rain, which
is that at the middle of its box. Light counts as unpolarised after the first drop; a filter takes
half.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.physics.air.earth_shadow import place_over_sphere
from rtbow.physics.air.rayleigh import horizon_rad, sun_column
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.geometry import box_span
from rtbow.reference.paths import Counted, Layers, Lights, Rain, walk
from rtbow.reference.rays import Rays, moments_of
from rtbow.reference.sky import Sky
from rtbow.tables.orders.phase import rain_phase
from rtbow.tables.sky.air import shells_of
from rtbow.world.lights import NEAREST_M, Sun
from rtbow.world.rain.extinction import NO_SUN_DISC_RAD, mean_extinction_along, with_second
from rtbow.world.world import World, with_step

STEP_NM = 20.0
"""Between wavelengths: what is scattered twice has no fringes, and colours of spectra with lines
are sums over whole bins."""
_NODES = 1024
"""Heights of the air's layers, and..."""
_SUN_NODES = (97, 33)
"""...heights and distances at which a sun's light is known."""
_RAY_NODES = 257
"""Places along a ray between which the rain's depth grows evenly."""
_SKY_ROWS, _SKY_COLUMNS = 31, 37
"""Of the light from outside: above and below the horizon, dense there; and all around."""


_MOST_DROPS = 1_000_000
"""Of a path, which none is ever as long as."""


def counted_in(world: World) -> Counted | None:
    """Give which light of a world is counted beside what suns and lamps send by way of one drop;
    None where that is all, or there are no drops."""
    wanted = world.scatters_again or world.skylight
    if not wanted or world.rain is None or world.rain.greatest <= 0.0:
        return None
    return Counted(world.scatters_again, world.skylight, _MOST_DROPS, False)


class Estimate(NamedTuple):
    """Light along rays.

    Attributes:
        mean: linear X, Y, Z in cd/m² (n, 3).
        error: standard error of each (n, 3).
    """

    mean: Array
    error: Array


@dataclass(frozen=True)
class Orders:
    """A world, ready for random walks.

    Attributes:
        world: the world, at a coarse step of wavelengths.
        rain: the rain.
        layers: the air.
        lights: what lights the drops.
        chances: running sum of the wavelengths' chances (W + 1,).
    """

    world: World
    rain: Rain
    layers: Layers
    lights: Lights
    chances: Array

    @classmethod
    def of(cls, world: World, building: Progress = no_progress, step_nm: float = STEP_NM) -> Orders:
        """Prepare a world.

        Args:
            world: the world; walks take fewer wavelengths than it has.
            building: wraps the loop over parts of tables that must be built.
            step_nm: between these.
        """
        world = with_step(world, step_nm)
        optics = world.optics
        return cls(
            world, _rain(world, building), _layers(world), _lights(world, building),
            _chances([*optics.sun_weights, *optics.lamp_weights]),
        )  # fmt: skip

    def along(
        self, rays: Array, counted: Counted, *, paths: int, seed: int = 0, batches: int = 16
    ) -> Estimate:
        """Estimate what arrives along rays from the eye (n, 3).

        Args:
            rays: unit directions.
            counted: which light.
            paths: from each ray, in all.
            seed: of the random numbers: the same gives the same light.
            batches: independent parts, of which the error is told.
        """
        eye = self.world.view.eye_m
        entry, leave = box_span(eye, rays, self.rain.box)
        ends, depths = _along(self.world, rays, entry, np.maximum(leave, entry))
        each = max(paths // batches, 1)
        found = walk(
            np.ascontiguousarray(rays), eye, ends, depths, self.chances, self.rain, self.layers,
            self.lights, counted, batches, each, seed,
        )  # fmt: skip
        if self.world.view.polarizer is not None:
            found = 0.5 * found
        error = found.std(axis=0, ddof=1) / np.sqrt(batches)
        return Estimate(found.mean(axis=0), error)

    def passed(self, rays: Array) -> Array:
        """Give the share of light at 550 nm that passes all of the rain along rays (n, 3)."""
        entry, leave = box_span(self.world.view.eye_m, rays, self.rain.box)
        depths = _along(self.world, rays, entry, np.maximum(leave, entry))[1]
        return np.exp(-depths[:, -1])


def _chances(weights: list[Array]) -> Array:
    """Chances of wavelengths by what they count for, none left out."""
    share = sum(np.abs(one).sum(axis=1) / max(np.abs(one).sum(), 1e-300) for one in weights)
    share = floats(share) / np.sum(share)
    share = 0.95 * share + 0.05 / len(share)
    return floats(np.concatenate([[0.0], np.cumsum(share)[:-1], [1.0]]))


def _rain(world: World, building: Progress) -> Rain:
    assert world.rain is not None
    volume, optics, scatterer = world.volume, world.optics, world.scatterer
    discs = [sun.disc_rad for sun in optics.suns]
    phase = rain_phase(
        scatterer.medium, scatterer.spread, volume.size_range_um, volume.sizes,
        optics.wavelength_nm, max(discs, default=NO_SUN_DISC_RAD), building,
    )  # fmt: skip
    return Rain(
        volume.box_m, with_second(world.rain.field),
        moments_of(volume), world.rain.greatest,
        world.rain.ratio, float(phase.radius_m[0]), phase.per_fold, np.cos(phase.edges_rad),
        phase.density, phase.running,
    )  # fmt: skip


def _heights(world: World) -> Array:
    """Heights of the layers: of all of the box, the eye and the lamps."""
    ends = [*world.volume.box_m[:, 2], world.view.eye_m[2]]
    ends += [lamp.position_m[2] for lamp in world.optics.lamps]
    return np.linspace(min(ends) - 1.0, max(ends) + 1.0, _NODES)


def _layers(world: World) -> Layers:
    z = _heights(world)
    step = float(z[1] - z[0])
    density = np.exp(-z / SCALE_HEIGHT_M)
    columns, beams = [-density], [world.optics.air_depth]
    if world.haze is not None:
        air = world.haze.air(world.optics.wavelength_nm)
        above = world.haze.above_ground(z)
        amounts = shells_of(air).amounts(above[:-1], above[1:], np.full(len(z) - 1, step))[1:]
        columns += [np.concatenate([[0.0], np.cumsum(one)]) for one in amounts]
        beams += list(air.beam[1:])
    above = floats(columns)
    return Layers(float(z[0]), 1.0 / step, above, np.gradient(above, step, axis=1), floats(beams))


def _lights(world: World, building: Progress) -> Lights:
    optics, waves = world.optics, len(world.optics.wavelength_nm)
    suns, lamps = optics.suns, optics.lamps
    spans = [_sun_span(world, sun) for sun in suns]
    rows, sky = _outside(world, building)
    none = np.zeros((0, waves, 3))
    return Lights(
        floats([sun.direction for sun in suns]).reshape(-1, 3),
        floats([sun.disc_rad for sun in suns]),
        floats([_sun_left(world, *pair) for pair in zip(suns, spans, strict=True)]).reshape(
            -1, *_SUN_NODES, waves
        ),
        floats(spans).reshape(-1, 4),
        floats([lamp.position_m for lamp in lamps]).reshape(-1, 3),
        floats([lamp.radius_m for lamp in lamps]),
        NEAREST_M**2,
        floats(optics.sun_weights) if suns else none,
        floats(optics.lamp_weights) if lamps else none,
        sky,
        rows,
    )


def _sun_span(world: World, sun: Sun) -> tuple[float, float, float, float]:
    """Heights of the box, and its extent along a sun's azimuth."""
    low, high = world.volume.box_m
    level = sun.direction[:2] / max(float(np.hypot(*sun.direction[:2])), 1e-300)
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])]) @ level
    return float(low[2]), float(high[2]), float(corners.min()), float(corners.max())


def _sun_left(world: World, sun: Sun, span: tuple[float, float, float, float]) -> Array:
    """Share of a sun's light that reaches places (H, D, W)."""
    optics, (low, high, near, far) = world.optics, span
    z, along = np.meshgrid(
        np.linspace(low, high, _SUN_NODES[0]), np.linspace(near, far, _SUN_NODES[1]), indexing="ij"
    )
    if not optics.has_air and world.haze is None:
        return np.ones((*z.shape, len(optics.wavelength_nm)))
    height, altitude = z.ravel(), np.full(z.size, sun.altitude_rad)
    if world.shades(sun):
        level = sun.direction[:2] / max(float(np.hypot(*sun.direction[:2])), 1e-300)
        points = np.column_stack([along.ravel()[:, None] * level, z.ravel()])
        height, altitude = place_over_sphere(points, world.view.eye_m, sun.direction)
    with np.errstate(over="ignore"):
        depth = np.zeros((z.size, len(optics.wavelength_nm)))
        if optics.has_air:
            column = sun_column(height, altitude)
            depth = np.where(np.isfinite(column), column, 1e6)[:, None] * optics.air_depth
        if world.haze is not None:
            above = world.haze.above_ground(height)
            air = world.haze.air(optics.wavelength_nm)
            clear = altitude - horizon_rad(above)
            depth = depth + shells_of(air).column_at(above, clear)[1:].T @ air.beam[1:]
    return floats(np.exp(-depth).reshape(*z.shape, -1))


def _outside(world: World, building: Progress) -> tuple[Array, Array]:
    """Light from outside of the rain, as it is at the middle of the box: altitudes (A,), and per
    irradiance of each sun (S, A, B, W)."""
    suns, waves = world.optics.suns, len(world.optics.wavelength_nm)
    if world.around is None or not suns:
        return np.array([-1.0, 1.0]), np.zeros((len(suns), 2, 2, waves))
    middle = world.volume.box_m.mean(axis=0)
    middle[2] = max(middle[2], world.around.ground_m)
    horizon = float(horizon_rad(world.around.above_ground(middle[2:])[0]))
    t = np.linspace(0.0, 1.0, _SKY_ROWS) ** 2
    edge = 1e-6
    falling = horizon - edge - (0.5 * np.pi + horizon - edge) * t[::-1]
    rows = np.concatenate([falling, horizon + edge + (0.5 * np.pi - horizon - edge) * t])
    turn = np.linspace(0.0, 2.0 * np.pi, _SKY_COLUMNS)
    altitude, azimuth = np.meshgrid(rows, turn, indexing="ij")
    level = np.cos(altitude)
    rays = np.stack(
        [level * np.sin(azimuth), level * np.cos(azimuth), np.sin(altitude)], axis=-1
    ).reshape(-1, 3)
    nothing = np.zeros(len(rays))
    ways = Rays(middle, rays, nothing, nothing, nothing)
    sky = Sky.of(world.around, world.optics.wavelength_nm, lit=True, progress=building)
    edges = sky.edges(ways)
    rain, probes = np.zeros(edges.shape), np.broadcast_to(np.eye(3), (len(rays), 3, 3))
    seen = [
        sky.along(
            ways, edges, rain, np.ones(waves), replace(sun, visible=False), probes,
            lambda _, __, at: np.zeros(at.shape),
        )
        for sun in suns
    ]  # fmt: skip
    return rows, floats(seen).reshape(len(suns), *altitude.shape, waves)


def _along(world: World, rays: Array, entry: Array, leave: Array) -> tuple[Array, Array]:
    """Places along rays and the rain's depth up to there, at 550 nm: each (n, M)."""
    assert world.rain is not None
    eye, volume = world.view.eye_m, world.volume
    count = 2 if volume.uniform else _RAY_NODES
    ends = entry[:, None] + (leave - entry)[:, None] * np.linspace(0.0, 1.0, count)
    lengths = np.diff(ends)
    start = eye + ends[:, :-1, None] * rays[:, None, :]
    start = np.clip(start, *volume.box_m).reshape(-1, 3)
    ways = np.repeat(rays, count - 1, axis=0)
    mean = mean_extinction_along(start, ways, lengths.ravel(), volume, world.rain.field)
    pieces = mean.reshape(lengths.shape) * lengths
    return floats(ends), np.concatenate([np.zeros((len(rays), 1)), np.cumsum(pieces, axis=1)], 1)
