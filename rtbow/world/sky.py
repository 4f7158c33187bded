"""What is around the drops and gives light of its own: the air, and the ground below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.physics.air.aerosol import MIXTURES, AerosolOptics, free_optics, mixture_optics
from rtbow.physics.air.ozone import ozone_depth
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.scene.air import Aerosol
from rtbow.scene.model import Scene
from rtbow.tables.sky.air import Haze, make_air
from rtbow.tables.sky.field import FIELD_NM, between_field_nm, no_field, sky_field
from rtbow.tables.sky.transport import Air, Scattered

_CUSTOM = {
    "optical_depth_550": 0.15,
    "angstrom_exponent": 1.3,
    "single_scattering_albedo": 0.93,
    "asymmetry": 0.7,
    "scale_height_m": 1200.0,
}
"""Of a custom aerosol, what it does not give."""


@dataclass(frozen=True)
class Surroundings:
    """What is around the drops.

    Attributes:
        has_air: whether there is air at all.
        glows: whether the air's own light is drawn.
        albedo: of the ground; None where there is none, and what is below the horizon is black.
        ozone_du: column of ozone, Dobson units.
        aerosol: the haze, or None.
    """

    has_air: bool
    glows: bool
    albedo: float | None
    ozone_du: float
    aerosol: Aerosol | None

    def air(self, wavelength_nm: Array) -> Air:
        """Give the air and the ground, black where there is none, at wavelengths (W,)."""
        nm = floats(wavelength_nm)
        albedo = np.full(len(nm), self.albedo or 0.0)
        if not self.has_air:
            return make_air(np.zeros(len(nm)), albedo)
        ozone = ozone_depth(nm, self.ozone_du) if self.ozone_du else None
        haze = None if self.aerosol is None else haze_of(self.aerosol, nm)
        return make_air(rayleigh_depth(nm), albedo, ozone, haze)

    def field(self, progress: Progress = no_progress) -> Scattered:
        """Give what the air has scattered of a sun's light, at ``FIELD_NM``; nothing where it does
        not glow.

        Args:
            progress: wraps the loop over orders of scattering, where they are not kept.
        """
        if not self.glows:
            return no_field(len(FIELD_NM), hazy=self.aerosol is not None)
        return sky_field(self.air(FIELD_NM), progress)


def surroundings(scene: Scene) -> Surroundings | None:
    """Give what a scene has around its drops; None if there is nothing."""
    if not scene.has_surroundings:
        return None
    air, ground = scene.atmosphere, scene.ground
    has_air = air is not None and air.rayleigh
    albedo = None if ground is None else ground.albedo
    if air is None:
        return Surroundings(False, False, albedo, 0.0, None)
    return Surroundings(has_air, air.sky, albedo, air.ozone_du, air.aerosol)


def haze_of(aerosol: Aerosol, wavelength_nm: Array) -> Haze:
    """Give an aerosol's optics at wavelengths (W,), and its layer."""
    if aerosol.model == "custom":
        own = {key: getattr(aerosol, key) for key in _CUSTOM}
        *numbers, scale_height_m = (
            _CUSTOM[key] if value is None else value for key, value in own.items()
        )
        return Haze(free_optics(wavelength_nm, *numbers), scale_height_m, np.inf)
    mixture = MIXTURES[aerosol.model]
    given = aerosol.optical_depth_550
    nodes = mixture_optics(mixture, FIELD_NM, mixture.depth if given is None else given)
    shares = between_field_nm(wavelength_nm).T
    optics = AerosolOptics(nodes.depth @ shares, nodes.scattering @ shares, nodes.phase @ shares)
    return Haze(optics, mixture.scale_height_m, mixture.top_m)


def dimming_air(scene: Scene) -> Surroundings | None:
    """Give the air whose ozone and aerosol dim the drops' light beside its molecules; None where
    there are neither."""
    air = scene.atmosphere
    if air is None or (air.aerosol is None and air.ozone_du == 0.0):
        return None
    return Surroundings(air.rayleigh, False, None, air.ozone_du, air.aerosol)


def surroundings_notes(scene: Scene) -> tuple[str, ...]:
    """Say what of the lights a scene's surroundings do not show."""
    if scene.has_surroundings and any(light.type == "point" for light in scene.light):
        return ("lamps light the drops alone, not the air that glows nor the ground",)
    return ()
