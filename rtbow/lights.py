"""The scene's lights with their spectra in absolute units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.arrays import Array
from rtbow.camera import direction
from rtbow.errors import InputError
from rtbow.scene import Scene, SunLight
from rtbow.spectrum import E490, Spectrum, load_spectrum


@dataclass(frozen=True)
class Sun:
    """A uniform disc at infinity.

    Attributes:
        direction: unit vector (3,) *to* the disc's centre: east, north, up.
        altitude_rad: its altitude above the horizon.
        disc_rad: angular radius, 0 for a point.
        spectrum: irradiance above the air, W m⁻² nm⁻¹, on a surface facing the light.
    """

    direction: Array
    altitude_rad: float
    disc_rad: float
    spectrum: Spectrum


def _sun(light: SunLight) -> Sun:
    spectrum = load_spectrum(light.spectrum)
    if light.irradiance_w_m2 is not None:
        spectrum = spectrum.scaled(light.irradiance_w_m2)
    elif not spectrum.absolute:
        spectrum = spectrum.scaled(load_spectrum(E490).visible)
    return Sun(
        direction=direction(light.azimuth_deg, light.altitude_deg),
        altitude_rad=float(np.radians(light.altitude_deg)),
        disc_rad=float(np.radians(0.5 * light.angular_diameter_deg)),
        spectrum=spectrum,
    )


def suns(scene: Scene) -> tuple[Sun, ...]:
    """Give the scene's suns.

    Raises:
        InputError: a spectrum is unknown or its file unusable.
    """
    found = []
    for number, light in enumerate(scene.light):
        try:
            found.append(_sun(light))
        except InputError as error:
            raise InputError(f"{scene.source_name}: light.{number}.spectrum: {error}") from None
    return tuple(found)
