"""What a scene fixes for every pixel: wavelengths, bows, air and lights.

The one place where the shader's method and the reference meet; what each makes of these numbers
they share no code for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.arrays import Array, Progress, no_progress
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.drop.airy import Bow, bows
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.physics.sizes import tabled_sizes
from rtbow.scene.model import Scene
from rtbow.world.lights import (
    Lamp,
    Sun,
    lamps,
    suns,
)
from rtbow.world.rain.volume import DropletVolume

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections


@dataclass(frozen=True)
class Optics:
    """Per-wavelength numbers of a scene.

    Attributes:
        wavelength_nm: (W,).
        bows: the scene's bows; none where exact theory has its own.
        air_depth: vertical Rayleigh depth from sea level (W,), zeros without air.
        suns: the lights at infinity.
        sun_weights: for each sun, (W, 3) in lm/m²: a radiance per irradiance [sr⁻¹] summed with
            them gives X, Y, Z, with Y in cd/m².
        lamps: the lights near by.
        lamp_weights: for each lamp, (W, 3) in lm/sr, with which a radiance per radiant intensity
            [m⁻²] does.
    """

    wavelength_nm: Array
    bows: tuple[Bow, ...]
    air_depth: Array
    suns: tuple[Sun, ...]
    sun_weights: tuple[Array, ...]
    lamps: tuple[Lamp, ...]
    lamp_weights: tuple[Array, ...]

    @property
    def has_air(self) -> bool:
        """Whether any wavelength is attenuated by the air."""
        return bool(np.any(self.air_depth > 0.0))


def scene_optics(scene: Scene) -> Optics:
    """Compute a scene's optics at its own wavelength step.

    Raises:
        InputError: a light's spectrum is unknown or unusable.
    """
    the_suns, the_lamps = suns(scene), lamps(scene)
    bins = wavelength_bins(scene.render.wavelength_step_nm)
    nm = bins.wavelength_nm
    index = relative_index(nm, scene.scattering.water_temperature_c)
    orders = scene.scattering.orders if scene.scattering.theory == "airy" else ()
    has_air = scene.atmosphere is not None and scene.atmosphere.rayleigh
    return Optics(
        wavelength_nm=nm,
        bows=bows(orders, nm * 1e-9, index),
        air_depth=rayleigh_depth(nm) if has_air else np.zeros_like(nm),
        suns=the_suns,
        sun_weights=tuple(colour_weights(sun.spectrum, bins) for sun in the_suns),
        lamps=the_lamps,
        lamp_weights=tuple(colour_weights(lamp.spectrum, bins) for lamp in the_lamps),
    )


def table_sections(
    scene: Scene, optics: Optics, volume: DropletVolume, progress: Progress = no_progress
) -> Sections | None:
    """Give the cross-sections of a scene whose drops need a table of them.

    That is exact theory, and mixtures of sizes in either; None for Airy's theory of drops of one
    size at a point, which evaluates the bows in place.

    Args:
        scene: the scene.
        optics: its optics.
        volume: its drops.
        progress: wraps the loop over parts of an exact table that must be built.
    """
    theory = scene.scattering.theory
    if theory == "airy" and volume.sizes is None:
        return None
    # Imported here, with the compiler of what is summed on the CPU.
    from rtbow.tables.sections import water_sections

    radii_um = volume.size_range_um
    if volume.sizes is not None and theory == "mie":
        radii_um = tabled_sizes(volume.sizes).range_um
    return water_sections(
        theory,
        optics.wavelength_nm,
        scene.scattering.water_temperature_c,
        radii_um,
        orders=scene.scattering.orders,
        spread=scene.scattering.size_spread,
        progress=progress,
    )
