"""What is around the drops and gives light of its own: the air, and the ground below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.base.errors import InputError
from rtbow.physics.air.aerosol import MIXTURES, AerosolOptics, free_optics, mixture_optics
from rtbow.physics.air.ozone import ozone_depth
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.fresnel import diffuse_reflectance
from rtbow.scene.air import CUSTOM_AEROSOL, Aerosol
from rtbow.scene.model import Scene
from rtbow.tables.sky.air import Haze, make_air
from rtbow.tables.sky.field import FIELD_NM, between_field_nm, no_field, sky_field
from rtbow.tables.sky.light import Air, Scattered
from rtbow.world.measured.albedo import Albedo, load_albedo

_WATER_C = 15.0
"""Of a ground that is water: 20 degrees more change what it mirrors by 0.5 %."""


@dataclass(frozen=True)
class Ground:
    """What is below.

    Attributes:
        albedo: share of light that it sends back evenly; None of water, which mirrors.
        height_m: above the height 0 of the scene.
    """

    albedo: Albedo | None
    height_m: float

    @property
    def water(self) -> bool:
        """Whether it is still water."""
        return self.albedo is None


@dataclass(frozen=True)
class Surroundings:
    """What is around the drops.

    Attributes:
        pressure_hpa: of the air at the scene's height 0; 0 where there is no air at all.
        glows: whether the air's own light is drawn.
        ground: the ground; None where there is none, and what is below the horizon is black.
        ozone_du: column of ozone, Dobson units.
        aerosol: the haze, or None.
    """

    pressure_hpa: float
    glows: bool
    ground: Ground | None
    ozone_du: float
    aerosol: Aerosol | None

    @property
    def ground_m(self) -> float:
        """Height of the ground; all shells of air begin there."""
        return 0.0 if self.ground is None else self.ground.height_m

    def above_ground(self, height_m: Array) -> Array:
        """Give heights above the ground, where they are; m."""
        return np.maximum(height_m - self.ground_m, 0.0)

    def air(self, wavelength_nm: Array) -> Air:
        """Give the air and the ground, black where there is none, at wavelengths (W,)."""
        nm = floats(wavelength_nm)
        albedo, water = self._ground(nm)
        if self.pressure_hpa == 0.0:
            return make_air(np.zeros(len(nm)), albedo, water=water)
        ozone = ozone_depth(nm, self.ozone_du) if self.ozone_du else None
        haze = None if self.aerosol is None else haze_of(self.aerosol, nm)
        above = self.pressure_hpa * float(np.exp(-self.ground_m / SCALE_HEIGHT_M))
        return make_air(rayleigh_depth(nm, above), albedo, ozone, haze, water)

    def _ground(self, nm: Array) -> tuple[Array, Array | None]:
        """Albedo and, of water, index."""
        if self.ground is None:
            return np.zeros(len(nm)), None
        if self.ground.albedo is not None:
            return self.ground.albedo.at(nm), None
        index = relative_index(nm, _WATER_C)
        return diffuse_reflectance(index), index

    def ground_light(self, wavelength_nm: Array) -> Array:
        """Give the ground's albedo at wavelengths (W,); 0 of water and of none."""
        ground = self.ground
        if ground is None or ground.albedo is None:
            return np.zeros(len(wavelength_nm))
        return ground.albedo.at(wavelength_nm)

    def field(self, progress: Progress = no_progress) -> Scattered:
        """Give what the air has scattered of a sun's light, at ``FIELD_NM``; nothing where it does
        not glow.

        Args:
            progress: wraps the loop over orders of scattering, where they are not kept.
        """
        if not self.glows:
            return no_field(len(FIELD_NM), hazy=self.aerosol is not None)
        air = self.air(FIELD_NM)
        if self.ground is not None and self.ground.albedo is not None:
            # Each stands for the wavelengths about it.
            means = self.ground.albedo.means(FIELD_NM, float(FIELD_NM[1] - FIELD_NM[0]))
            air = air._replace(albedo=means)
        return sky_field(air, progress)


def surroundings(scene: Scene) -> Surroundings | None:
    """Give what a scene has around its drops; None if there is nothing.

    Raises:
        InputError: the ground's albedo is unknown or unusable.
    """
    if not scene.has_surroundings:
        return None
    air, ground = scene.atmosphere, None
    if scene.ground is not None:
        try:
            albedo = None if scene.ground.water else load_albedo(scene.ground.albedo)
        except InputError as error:
            raise InputError(f"{scene.source_name}: ground.albedo: {error}") from None
        ground = Ground(albedo, scene.ground.height_m)
    if air is None:
        return Surroundings(0.0, False, ground, 0.0, None)
    pressure = air.pressure_hpa if air.rayleigh else 0.0
    return Surroundings(pressure, air.sky, ground, air.ozone_du, air.aerosol)


def haze_of(aerosol: Aerosol, wavelength_nm: Array) -> Haze:
    """Give an aerosol's optics at wavelengths (W,), and its layer."""
    if aerosol.model == "custom":
        own = {key: getattr(aerosol, key) for key in CUSTOM_AEROSOL}
        *numbers, scale_height_m = (
            CUSTOM_AEROSOL[key] if value is None else value for key, value in own.items()
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
    pressure = air.pressure_hpa if air.rayleigh else 0.0
    # Black, for it dims nothing, but at its height.
    ground = None if scene.ground is None else Ground(load_albedo(0.0), scene.ground.height_m)
    return Surroundings(pressure, False, ground, air.ozone_du, air.aerosol)


def surroundings_notes(scene: Scene) -> tuple[str, ...]:
    """Say what of the lights a scene's surroundings do not show."""
    if scene.has_surroundings and any(light.type == "point" for light in scene.light):
        return ("lamps light the drops alone, not the air that glows nor the ground",)
    return ()
