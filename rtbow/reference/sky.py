"""The air's own light, the ground and the suns' discs along rays, in float64.

Pieces of a ray are dense near the eye and within the rain. What comes along each is dimmed by the
air and the rain before it. The light of single scattering is that of each piece's middle; what was
scattered before is interpolated in :mod:`rtbow.tables.sky`'s field.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.base.compiled import compiled, prange
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.air.shells import Shells, molecules_density, shells
from rtbow.physics.constants import VISIBLE_NM
from rtbow.reference.rays import Rays
from rtbow.tables.sky.field import SkyField, no_field, sky_field
from rtbow.tables.sky.transport import gather_ray, ray_end
from rtbow.world.lights import Sun
from rtbow.world.sky import Surroundings

_PIECES = 160
"""Of a ray through the air, outside of the rain: twice as many change a sky by 1e-3 at most."""
_RAIN_PIECES = 32
_FIELD_STEP_NM = 25.0
"""Between wavelengths at which the field is solved: cubics between them are within 1e-4."""


@dataclass(frozen=True)
class Sky:
    """What is around the drops, ready to be gathered along rays.

    Attributes:
        around: what there is.
        air: the constituents over height.
        depth: their vertical depths (C, W).
        albedo: of the ground (W,); zeros where there is none.
        field: what was scattered before; of zeros where the air does not glow.
    """

    around: Surroundings
    air: Shells
    depth: Array
    albedo: Array
    field: SkyField

    @classmethod
    def of(
        cls, around: Surroundings, wavelength_nm: Array, air_depth: Array,
        progress: Progress = no_progress,
    ) -> Sky:  # fmt: skip
        """Solve for a sky at wavelengths (W,) with the molecules' vertical depths (W,)."""
        air = shells([molecules_density])
        whole = np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1.0, _FIELD_STEP_NM)
        albedo = around.albedo or 0.0
        if around.glows:
            depth = rayleigh_depth(whole)[None]
            field = sky_field(air, depth, np.full(len(whole), albedo), progress)
            field = field.at(whole, wavelength_nm)
        else:
            field = no_field(len(wavelength_nm))
        return cls(around, air, floats(air_depth)[None], np.full(len(wavelength_nm), albedo), field)

    def ground_distance(self, eye_m: Array, directions: Array) -> Array:
        """Distances at which rays (n, 3) meet the ground, m; infinite where they do not."""
        if self.around.albedo is None:
            return np.full(len(directions), np.inf)
        ends = [ray_end(max(float(eye_m[2]), 0.0), float(ray[2])) for ray in directions]
        return floats([distance if met else np.inf for distance, met in ends])

    def edges(self, rays: Rays) -> Array:
        """Give where each ray's pieces end (n, S + 1), m, ascending from 0."""
        height = max(float(rays.origin[2]), 0.0)
        end = floats([ray_end(height, float(ray[2]))[0] for ray in rays.directions])
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
        disc = np.where(angle < 2.0 * np.sin(0.5 * sun.disc_rad), _disc_radiance(sun), 0.0)
        return _gather_rays(
            max(float(rays.origin[2]), 0.0), sun.direction, rays.directions, edges, rain,
            rain_ratio, self.depth, self.air.density, self.air.log_column, self.albedo,
            self.field.heights_m, self.field.zeniths_rad, self.field.mean, self.field.ground,
            float(self.around.glows), np.ascontiguousarray(probes), disc,
        )  # fmt: skip


def _disc_radiance(sun: Sun) -> float:
    """Radiance of a sun's even disc, per irradiance, 1/sr; 0 for a point, which no pixel shows."""
    if sun.disc_rad == 0.0:
        return 0.0
    return float(1.0 / (4.0 * np.pi * np.sin(0.5 * sun.disc_rad) ** 2))


@compiled(parallel=True)
def _gather_rays(
    height: float, sun: Array, rays: Array, edges: Array, rain: Array, rain_ratio: Array,
    depth: Array, density: Array, log_column: Array, albedo: Array, heights: Array,
    zeniths: Array, field: Array, ground: Array, glow: float, probes: Array, disc: Array,
) -> Array:  # fmt: skip
    waves = depth.shape[1]
    seen = np.zeros((len(rays), waves))
    for n in prange(len(rays)):
        out, through = np.zeros((waves, 1)), np.zeros(waves)
        gather_ray(
            height, sun, rays[n], edges[n], rain[n], rain_ratio, depth, density, log_column,
            albedo, heights, zeniths, field, ground, True, glow, probes[n : n + 1], out, through,
        )  # fmt: skip
        free = not ray_end(height, rays[n, 2])[1]
        half = 0.5 * (probes[n, 0, 0] + probes[n, 1, 1] + probes[n, 2, 2])
        half -= 0.5 * (rays[n] @ probes[n] @ rays[n])
        for w in range(waves):
            seen[n, w] = out[w, 0]
            if free:
                seen[n, w] += disc[n] * half * through[w]
    return seen
