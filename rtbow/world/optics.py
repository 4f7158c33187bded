"""Per-wavelength numbers of a scene: wavelengths, bows, the air's depth and the lights' weights.

The shader's methods and the reference both start from these numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from rtbow.base.arrays import Array
from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.physics.constants import SEA_LEVEL_HPA
from rtbow.physics.drop.airy import Bow, bows
from rtbow.physics.light.spectrum import Bins, Spectrum, bin_means, colour_weights, wavelength_bins
from rtbow.scene.model import Scene
from rtbow.world.lights import Lamp, Sun, lamps, suns


@dataclass(frozen=True)
class Optics:
    """Per-wavelength numbers of a scene.

    Attributes:
        bins: the W wavelengths and the bins around them.
        bows: the scene's bows; none where exact theory has its own.
        air_depth: vertical Rayleigh depth from height 0 (W,), zeros without air.
        pressure_hpa: of the air at height 0.
        suns: the lights at infinity.
        sun_weights: for each sun, (W, 3) in lm/m²: a radiance per irradiance [sr⁻¹] summed with
            them gives X, Y, Z, with Y in cd/m².
        lamps: the lights near by.
        lamp_weights: for each lamp, (W, 3) in lm/sr, with which a radiance per radiant intensity
            [m⁻²] does.
    """

    bins: Bins
    bows: tuple[Bow, ...]
    air_depth: Array
    pressure_hpa: float
    suns: tuple[Sun, ...]
    sun_weights: tuple[Array, ...]
    lamps: tuple[Lamp, ...]
    lamp_weights: tuple[Array, ...]

    @property
    def wavelength_nm(self) -> Array:
        """Wavelengths in air (W,)."""
        return self.bins.wavelength_nm

    @property
    def has_air(self) -> bool:
        """Whether any wavelength is attenuated by the air."""
        return bool(np.any(self.air_depth > 0.0))

    @property
    def lights(self) -> tuple[Sun | Lamp, ...]:
        """The suns, then the lamps."""
        return (*self.suns, *self.lamps)

    def weighed(self, weigh: Callable[[Spectrum, Bins], Array]) -> Optics:
        """Give the same with other weights, made from each light's spectrum."""
        return replace(
            self,
            sun_weights=tuple(weigh(sun.spectrum, self.bins) for sun in self.suns),
            lamp_weights=tuple(weigh(lamp.spectrum, self.bins) for lamp in self.lamps),
        )

    def apart(self) -> Optics:
        """Give the same with weights that keep each wavelength in a channel of its own.

        The weights are then (W, W), in W m⁻² nm⁻¹ of a sun and W sr⁻¹ nm⁻¹ of a lamp.
        """
        return self.weighed(lambda spectrum, bins: np.diag(bin_means(spectrum, bins)))


def scene_optics(scene: Scene) -> Optics:
    """Compute a scene's optics at its own wavelength step.

    Raises:
        InputError: a light's spectrum is unknown or unusable.
    """
    bins = wavelength_bins(scene.render.wavelength_step_nm)
    nm = bins.wavelength_nm
    index = scene.scattering.medium.index(nm)
    orders = scene.scattering.orders if scene.scattering.theory == "airy" else ()
    has_air = scene.atmosphere is not None and scene.atmosphere.rayleigh
    pressure = SEA_LEVEL_HPA if scene.atmosphere is None else scene.atmosphere.pressure_hpa
    return Optics(
        bins=bins,
        bows=bows(orders, nm * 1e-9, index),
        air_depth=rayleigh_depth(nm, pressure) if has_air else np.zeros_like(nm),
        pressure_hpa=pressure,
        suns=suns(scene),
        sun_weights=(),
        lamps=lamps(scene),
        lamp_weights=(),
    ).weighed(colour_weights)
