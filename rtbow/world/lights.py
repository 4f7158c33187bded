"""The scene's lights with their spectra in absolute units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError
from rtbow.physics.constants import MOON_DISTANCE_KM
from rtbow.physics.geometry import direction
from rtbow.physics.light.moon import moonlight
from rtbow.physics.light.spectrum import Spectrum, luminous
from rtbow.scene.lights import E490, MOON, PointLight, SunLight
from rtbow.scene.model import Scene
from rtbow.world.measured.spectra import load_spectrum, spectrum_notes

NEAREST_M = 1e-3
"""Rays pass the centre of a point lamp no nearer than this: through the centre the integral of 1/d²
has no limit. A lamp with a diameter needs no such guard, since no drops are inside it."""

_LEAST_DRAWN_RAD = 1e-7
"""A disc smaller than this is between float32's directions."""


@dataclass(frozen=True)
class Sun:
    """A uniform disc at infinity.

    Attributes:
        direction: unit vector (3,) *to* the disc's centre: east, north, up.
        altitude_rad: its altitude above the horizon.
        disc_rad: angular radius, 0 for a point.
        spectrum: irradiance above the air, W m⁻² nm⁻¹, on a surface facing the light.
        visible: whether the disc is drawn where there is a sky or a ground.
    """

    direction: Array
    altitude_rad: float
    disc_rad: float
    spectrum: Spectrum
    visible: bool = True

    @property
    def disc_radiance(self) -> float:
        """Radiance of the even disc as it is drawn, per irradiance, 1/sr; 0 for a point, or a disc
        as small as one, which no pixel shows."""
        if self.disc_rad < _LEAST_DRAWN_RAD or not self.visible:
            return 0.0
        return float(1.0 / (4.0 * np.pi * np.sin(0.5 * self.disc_rad) ** 2))


@dataclass(frozen=True)
class Lamp:
    """A glowing sphere that radiates equally in all directions.

    Attributes:
        position_m: its centre (3,): east, north, up.
        radius_m: half its diameter, 0 for a point.
        spectrum: spectral radiant intensity, W sr⁻¹ nm⁻¹.
    """

    position_m: Array
    radius_m: float
    spectrum: Spectrum


def _sun(light: SunLight) -> Sun:
    if light.spectrum == MOON:
        spectrum = moonlight(
            load_spectrum(E490),
            light.moon_phase_deg or 0.0,
            light.moon_distance_km or MOON_DISTANCE_KM,
        )
    else:
        spectrum = load_spectrum(light.spectrum, light.beyond)
    if light.irradiance_w_m2 is not None:
        spectrum = spectrum.scaled(light.irradiance_w_m2)
    elif not spectrum.absolute:
        spectrum = spectrum.scaled(load_spectrum(E490).visible)
    return Sun(
        direction=direction(light.azimuth_deg, light.altitude_deg),
        altitude_rad=float(np.radians(light.altitude_deg)),
        disc_rad=float(np.radians(0.5 * light.angular_diameter_deg)),
        spectrum=spectrum,
        visible=light.visible,
    )


def irradiance_w_m2(light: SunLight) -> float:
    """Give a sun's irradiance over 380-780 nm above the air, on a surface that faces it.

    Raises:
        InputError: a spectrum is unknown or its file unusable.
    """
    return _sun(light).spectrum.visible


def _lamp(light: PointLight) -> Lamp:
    spectrum = load_spectrum(light.spectrum, light.beyond)
    # The flux leaves into 4 pi: intensity is the flux's spectrum over that.
    watts = spectrum.visible * light.luminous_flux_lm / luminous(spectrum)
    return Lamp(
        position_m=np.array(light.position_m),
        radius_m=0.5 * light.diameter_m,
        spectrum=spectrum.scaled(watts / (4.0 * np.pi)),
    )


def _resolved(scene: Scene) -> Iterator[Sun | Lamp]:
    for number, light in enumerate(scene.light):
        try:
            yield _sun(light) if isinstance(light, SunLight) else _lamp(light)
        except InputError as error:
            raise InputError(f"{scene.source_name}: light.{number}.spectrum: {error}") from None


def suns(scene: Scene) -> tuple[Sun, ...]:
    """Give the scene's suns.

    Raises:
        InputError: a spectrum is unknown or its file unusable.
    """
    return tuple(light for light in _resolved(scene) if isinstance(light, Sun))


def lamps(scene: Scene) -> tuple[Lamp, ...]:
    """Give the scene's lamps.

    Raises:
        InputError: a spectrum is unknown or its file unusable.
    """
    return tuple(light for light in _resolved(scene) if isinstance(light, Lamp))


def light_notes(scene: Scene) -> tuple[str, ...]:
    """Give what is doubtful about the files of the lights' spectra.

    Raises:
        InputError: a spectrum is unknown or its file unusable.
    """
    notes = [note for light in scene.light for note in spectrum_notes(light.spectrum, light.beyond)]
    return tuple(dict.fromkeys(notes))
