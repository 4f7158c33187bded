"""The air's own light, the ground and the suns' discs along rays, in float64.

Pieces of a ray are dense near the eye and within the rain. What comes along each is dimmed by the
air and the rain before it. The light of single scattering is that of each piece's middle; what was
scattered before is interpolated in :mod:`rtbow.tables.sky`'s field.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Mask, Progress, floats, no_progress
from rtbow.base.compiled import compiled, prange
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import ray_ends
from rtbow.physics.constants import EARTH_RADIUS_M
from rtbow.physics.light.fresnel import reflected_amplitudes
from rtbow.reference.rays import Rays
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.field import field_at, no_field
from rtbow.tables.sky.light import Air, Path, Scattered
from rtbow.tables.sky.transport import gather_ray
from rtbow.world.lights import Sun
from rtbow.world.sky import Surroundings

_PIECES = 160
"""Of a ray through the air, outside of the rain: twice as many change a sky by 1e-3 at most."""
_RAIN_PIECES = 32


@dataclass(frozen=True)
class Sky:
    """What is around the drops, ready to be gathered along rays.

    Attributes:
        around: what there is.
        air: the air and the ground; an albedo of 0 where there is none.
        scattered: what was scattered before; nothing where the air does not glow.
    """

    around: Surroundings
    air: Air
    scattered: Scattered

    @classmethod
    def of(
        cls, around: Surroundings, wavelength_nm: Array, *, lit: bool,
        progress: Progress = no_progress,
    ) -> Sky:  # fmt: skip
        """Solve for a sky.

        Args:
            around: what there is.
            wavelength_nm: the wavelengths (W,).
            lit: whether there is a sun; without one there is nothing to solve.
            progress: wraps the loop over orders of scattering.
        """
        air = around.air(wavelength_nm)
        scattered = no_field(len(wavelength_nm), hazy=air.hazy)
        if around.glows and lit:
            scattered = field_at(around.field(progress), wavelength_nm)
        return cls(around, air, scattered)

    def _height(self, eye_m: Array) -> float:
        """Of the eye (3,) above the ground, m."""
        return float(self.around.above_ground(eye_m)[2])

    def ground_distance(self, eye_m: Array, directions: Array) -> Array:
        """Distances at which rays from the eye (3,) meet the ground (n,), m; infinite where they do
        not."""
        if self.around.ground is None:
            return np.full(len(directions), np.inf)
        end, meets = ray_ends(self._height(eye_m), directions[:, 2])
        return np.where(meets, end, np.inf)

    def edges(self, rays: Rays) -> Array:
        """Give where each ray's pieces end (n, S + 1), m, ascending from 0."""
        end = ray_ends(self._height(rays.origin), rays.directions[:, 2])[0]
        dense = end[:, None] * np.linspace(0.0, 1.0, _PIECES + 1) ** 2
        through = rays.leave > rays.entry
        first = np.where(through, np.minimum(rays.entry, end), 0.0)
        last = np.where(through, np.minimum(rays.leave, end), 0.0)
        rain = first[:, None] + (last - first)[:, None] * np.linspace(0.0, 1.0, _RAIN_PIECES + 1)
        return np.sort(np.concatenate([dense, rain], axis=1), axis=1)

    def along(
        self, rays: Rays, edges: Array, rain: Array, rain_ratio: Array, sun: Sun, probes: Array,
        rain_from: RainFrom,
    ) -> Array:  # fmt: skip
        """Give what comes along rays by one sun, per irradiance above the air (n, W), 1/sr.

        Args:
            rays: the rays.
            edges: from :meth:`edges`.
            rain: optical depth of rain up to the middle of each piece, and to the end (n, S + 1).
            rain_ratio: of the rain's depth at each wavelength over that (W,).
            sun: the sun.
            probes: what of the light is seen (n, 3, 3).
            rain_from: gives the rain along mirrored rays.
        """
        height = self._height(rays.origin)
        ways = _Ways(
            height, rays.directions, np.broadcast_to(sun.direction, rays.directions.shape).copy(),
            np.ascontiguousarray(probes[:, None]),
        )  # fmt: skip
        ground = self.around.ground
        wet = ground is not None and ground.water
        sky = self._without_ground() if wet else self
        seen, through = sky._gather(ways, edges, rain, rain_ratio)
        rain_left = np.exp(-np.multiply.outer(rain[:, -1], rain_ratio))
        seen = seen[:, 0] + self._disc(ways, sun) * _half(ways)[:, 0, None] * rain_left
        if wet:
            falls = ray_ends(height, rays.directions[:, 2])[1]
            sharp = self._sharp(ways, edges, falls) * rain_left[falls]

            def beyond(directions: Array, at: Array) -> Array:
                return rain_from(falls, directions, at)

            seen[falls] += self._mirrored(
                ways, edges, falls, sun, through[falls], sharp, beyond, rain_ratio
            )
        return seen

    def _without_ground(self) -> Sky:
        """The same over black."""
        nothing = np.zeros_like(self.air.albedo)
        return replace(self, air=self.air._replace(albedo=nothing, water=nothing))

    def _gather(
        self, ways: _Ways, edges: Array, rain: Array, rain_ratio: Array
    ) -> tuple[Array, Array]:
        return _gather_rays(
            ways, edges, rain, rain_ratio, self.air, self.scattered, float(self.around.glows)
        )

    def _disc(self, ways: _Ways, sun: Sun) -> Array:
        """Radiance of a sun's disc that arrives sharply along rays, per irradiance above the air
        (n, W); none past the ground."""
        apart = np.linalg.norm(ways.directions - ways.suns, axis=1)
        clear = np.arcsin(np.clip(ways.directions[:, 2], -1, 1)) - horizon_rad(ways.height_m)
        free = (apart < 2.0 * np.sin(0.5 * sun.disc_rad)) & (clear >= 0.0)
        disc = np.zeros((len(clear), len(self.air.albedo)))
        heights = np.full(int(free.sum()), ways.height_m)
        columns = shells_of(self.air).column_at(heights, clear[free])
        disc[free] = sun.disc_radiance * np.exp(-columns.T @ self.air.beam)
        return disc

    def _sharp(self, ways: _Ways, edges: Array, chosen: Mask) -> Array:
        """Share of light from chosen rays' ends that arrives sharply through the air (m, W)."""
        ends = np.linspace(0.0, 1.0, _PIECES + 1) ** 2 * edges[chosen, -1:]
        level = np.hypot(*ways.directions[chosen, :2].T)[:, None]
        start = EARTH_RADIUS_M + ways.height_m
        up = start + ends * ways.directions[chosen, 2:]
        height = np.maximum(np.hypot(up, ends * level) - EARTH_RADIUS_M, 0.0)
        shells = shells_of(self.air)
        amounts = shells.amounts(height[:, :-1], height[:, 1:], np.diff(ends, axis=1)).sum(axis=2)
        return floats(np.exp(-amounts.T @ self.air.beam))

    def _mirrored(
        self, ways: _Ways, edges: Array, falls: Mask, sun: Sun, through: Array, sharp: Array,
        rain_along: Callable[[Array, Array], Array], rain_ratio: Array,
    ) -> Array:  # fmt: skip
        """What still water at the end of falling rays mirrors, as it arrives (m, W)."""
        rays, suns = ways.directions[falls], ways.suns[falls]
        up = rays * edges[falls, -1:]
        up[:, 2] += EARTH_RADIUS_M + ways.height_m
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        rise = -np.sum(rays * up, axis=1)
        level = np.cross(up, rays)
        size = np.linalg.norm(level, axis=1, keepdims=True)
        level = np.where(size > 1e-9, level / np.maximum(size, 1e-300), [1.0, 0.0, 0.0])
        # Axes at the water (m, 3, 3): along the rays, across them, up.
        axes = np.stack([np.cross(level, up), level, up], axis=1)
        mirrored = rays + 2.0 * rise[:, None] * up
        end = ray_ends(0.0, rise)[0]
        pieces = end[:, None] * np.linspace(0.0, 1.0, _PIECES + 1) ** 2
        middles = 0.5 * (pieces[:, 1:] + pieces[:, :-1])
        rain = rain_along(mirrored, np.concatenate([middles, pieces[:, -1:]], axis=1))
        mirrored, suns = (np.einsum("nij,nj->ni", axes, x) for x in (mirrored, suns))
        # The coherency tensor along level, upright and both, in the axes at the water.
        across = np.broadcast_to([0.0, 1.0, 0.0], mirrored.shape)
        upright = np.cross(mirrored, across)
        fields = [(across, across), (upright, upright), (across, upright), (upright, across)]
        tensors = [a[:, :, None] * b[:, None, :] for a, b in fields]
        probes = np.stack([*tensors[:2], 0.5 * (tensors[2] + tensors[3])], axis=1)
        beyond = _Ways(0.0, np.ascontiguousarray(mirrored), np.ascontiguousarray(suns), probes)
        light = self._without_ground()._gather(beyond, pieces, rain, rain_ratio)[0]
        light *= through[:, None]
        sharp = sharp * np.exp(-np.multiply.outer(rain[:, -1], rain_ratio))
        light[:, :2] += (0.5 * self._disc(beyond, sun) * sharp)[:, None]
        first, second = reflected_amplitudes(self.air.water, np.clip(rise, 0.0, 1.0)[:, None])
        # Seen along the ray, level and upright are those of the mirrored one.
        probe, level = ways.probes[falls, 0], level[:, None, :]
        upright = np.cross(rays[:, None, :], level)
        ll, uu, lu = (
            np.einsum("nai,nij,naj->na", a, probe, b)
            for a, b in ((level, level), (upright, upright), (level, upright))
        )
        seen = ll * first**2 * light[:, 0] + uu * second**2 * light[:, 1]
        return np.asarray(seen + 2.0 * lu * first * second * light[:, 2])


RainFrom = Callable[[Mask, Array, Array], Array]
"""Gives the optical depth of rain at 550 nm from the ground under chosen rays (n,) along unit
directions (m, 3) up to distances (m, S), m: (m, S)."""


class _Ways(NamedTuple):
    """Rays from a height, and what is seen along them.

    Attributes:
        height_m: of their start above the ground.
        directions: unit vectors, up is the vertical there (n, 3).
        suns: towards the sun, in the same axes (n, 3).
        probes: what of the light is seen (n, K, 3, 3).
    """

    height_m: float
    directions: Array
    suns: Array
    probes: Array


def _half(ways: _Ways) -> Array:
    """What probes get of unpolarised light of radiance 1 (n, K)."""
    rays, probes = ways.directions, ways.probes
    along = np.einsum("ni,nkij,nj->nk", rays, probes, rays)
    return np.asarray(0.5 * (np.einsum("nkii->nk", probes) - along))


@compiled(parallel=True)
def _gather_rays(
    ways: _Ways, edges: Array, rain: Array, rain_ratio: Array, air: Air, scattered: Scattered,
    glow: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Give what probes get along rays (n, K, W), and the share of light from their ends that
    arrives (n, W)."""
    rays, probed, waves = len(edges), ways.probes.shape[1], air.depth.shape[1]
    seen, passed = np.zeros((rays, probed, waves)), np.zeros((rays, waves))
    for n in prange(rays):
        path = Path(ways.height_m, ways.directions[n], edges[n], rain[n], rain_ratio)
        gather_ray(
            path, ways.suns[n], air, scattered, True, glow, ways.probes[n], seen[n], passed[n]
        )
    return seen, passed
