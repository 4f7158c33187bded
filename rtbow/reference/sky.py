"""The air's own light, the ground and the suns' discs along rays, in float64.

Pieces of a ray are dense near the eye and within the rain. What comes along each is dimmed by the
air and the rain before it. The light of single scattering is that of each piece's middle; what was
scattered before is interpolated in :mod:`rtbow.tables.sky`'s field.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Mask, Progress, no_progress
from rtbow.base.compiled import compiled, prange
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.air.shells import ray_ends
from rtbow.reference.rays import Rays
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.field import field_at, no_field
from rtbow.tables.sky.transport import Air, Path, Scattered, gather_ray
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

    def ground_distance(self, height_m: float, directions: Array) -> Array:
        """Distances at which rays from a height meet the ground (n,), m; infinite where they do
        not."""
        if self.around.albedo is None:
            return np.full(len(directions), np.inf)
        end, meets = ray_ends(height_m, directions[:, 2])
        return np.where(meets, end, np.inf)

    def edges(self, rays: Rays) -> Array:
        """Give where each ray's pieces end (n, S + 1), m, ascending from 0."""
        end = ray_ends(float(rays.origin[2]), rays.directions[:, 2])[0]
        dense = end[:, None] * np.linspace(0.0, 1.0, _PIECES + 1) ** 2
        through = rays.leave > rays.entry
        first = np.where(through, np.minimum(rays.entry, end), 0.0)
        last = np.where(through, np.minimum(rays.leave, end), 0.0)
        rain = first[:, None] + (last - first)[:, None] * np.linspace(0.0, 1.0, _RAIN_PIECES + 1)
        return np.sort(np.concatenate([dense, rain], axis=1), axis=1)

    def along(
        self, rays: Rays, edges: Array, rain: Array, rain_ratio: Array, sun: Sun, probes: Array
    ) -> Array:
        """Give what comes along rays by one sun, per irradiance above the air (n, W), 1/sr.

        Args:
            rays: the rays.
            edges: from :meth:`edges`.
            rain: optical depth of rain up to the middle of each piece, and to the end (n, S + 1).
            rain_ratio: of the rain's depth at each wavelength over that (W,).
            sun: the sun.
            probes: what of the light is seen (n, 3, 3).
        """
        angle = np.linalg.norm(rays.directions - sun.direction, axis=1)
        on = angle < 2.0 * np.sin(0.5 * sun.disc_rad)
        disc = np.where(on, sun.disc_radiance, 0.0)[:, None] * self._beam(rays, on)
        return _gather_rays(
            rays, edges, rain, rain_ratio, sun.direction, self.air, self.scattered,
            float(self.around.glows), np.ascontiguousarray(probes), disc,
        )  # fmt: skip

    def _beam(self, rays: Rays, chosen: Mask) -> Array:
        """Share of light from above the air that arrives sharply along chosen rays (n, W); none
        past the ground."""
        height, altitude = float(rays.origin[2]), np.arcsin(np.clip(rays.directions[:, 2], -1, 1))
        clear = altitude - horizon_rad(height)
        arrives = np.zeros((len(altitude), len(self.air.albedo)))
        free = chosen & (clear >= 0.0)
        columns = shells_of(self.air).column_at(np.full(int(free.sum()), height), clear[free])
        arrives[free] = np.exp(-columns.T @ self.air.beam)
        return arrives


@compiled(parallel=True)
def _gather_rays(
    rays: Rays, edges: Array, rain: Array, rain_ratio: Array, sun: Array, air: Air,
    scattered: Scattered, glow: float, probes: Array, disc: Array,
) -> Array:  # fmt: skip
    height, waves = rays.origin[2], air.depth.shape[1]
    seen = np.zeros((len(edges), waves))
    for n in prange(len(edges)):
        ray = rays.directions[n]
        out, through = np.zeros((1, waves)), np.zeros(waves)
        path = Path(height, ray, edges[n], rain[n], rain_ratio)
        gather_ray(path, sun, air, scattered, True, glow, probes[n : n + 1], out, through)
        half = 0.5 * (probes[n, 0, 0] + probes[n, 1, 1] + probes[n, 2, 2])
        half -= 0.5 * (ray @ probes[n] @ ray)
        for w in range(waves):
            seen[n, w] = out[0, w]
            rain_left = np.exp(-rain[n, -1] * rain_ratio[w])
            seen[n, w] += disc[n, w] * half * rain_left
    return seen
