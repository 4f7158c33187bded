"""What is around the drops and gives light of its own: the air, and the ground below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, no_progress
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.air.shells import molecular_shells
from rtbow.scene.model import Scene
from rtbow.tables.sky.field import FIELD_NM, no_field, sky_field
from rtbow.tables.sky.transport import Air, Scattered


@dataclass(frozen=True)
class Surroundings:
    """What is around the drops.

    Attributes:
        has_air: whether there is air at all.
        glows: whether the air's own light is drawn.
        albedo: of the ground; None where there is none, and what is below the horizon is black.
    """

    has_air: bool
    glows: bool
    albedo: float | None

    def air(self, wavelength_nm: Array) -> Air:
        """Give the air and the ground, black where there is none, at wavelengths (W,)."""
        depth = rayleigh_depth(wavelength_nm) if self.has_air else np.zeros(len(wavelength_nm))
        albedo = np.full(len(wavelength_nm), self.albedo or 0.0)
        return Air(*molecular_shells(), depth[None], albedo)

    def field(self, progress: Progress = no_progress) -> Scattered:
        """Give what the air has scattered of a sun's light, at ``FIELD_NM``; nothing where it does
        not glow.

        Args:
            progress: wraps the loop over orders of scattering, where they are not kept.
        """
        if not self.glows:
            return no_field(len(FIELD_NM))
        return sky_field(self.air(FIELD_NM), progress)


def surroundings(scene: Scene) -> Surroundings | None:
    """Give what a scene has around its drops; None if there is nothing."""
    if not scene.has_surroundings:
        return None
    air, ground = scene.atmosphere, scene.ground
    has_air = air is not None and air.rayleigh
    return Surroundings(has_air, scene.glows, None if ground is None else ground.albedo)


def surroundings_notes(scene: Scene) -> tuple[str, ...]:
    """Say what of the lights a scene's surroundings do not show."""
    if scene.has_surroundings and any(light.type == "point" for light in scene.light):
        return ("lamps light the drops alone, not the air that glows nor the ground",)
    return ()
