"""What a scene is made of, as any method of the shader needs it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.arrays import (
    Array,
    Float32,
    Progress,
    no_progress,
)
from rtbow.scene.model import Camera, Scene
from rtbow.world.camera import picture_cone
from rtbow.world.lights import Sun, lamps, suns
from rtbow.world.optics import Optics, scene_optics, table_sections
from rtbow.world.rain.volume import DropletVolume, scene_volume

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections
    from rtbow.world.rain.extinction import RainExtinction


CONE_MARGIN = 2e-3
"""Radians beyond a picture's corners that tables hold: for float32, and for the same view in
another size, whose sides are rounded to whole pixels."""


@dataclass(frozen=True)
class Parts:
    """What a scene is made of, as the shader needs it.

    Attributes:
        optics: per-wavelength numbers.
        volume: the drops.
        sections: cross-sections to be laid out in a table, or None for Airy's bows in place.
        rain: the drops' own extinction, or None.
        eye_m: where the camera is (3,).
    """

    optics: Optics
    volume: DropletVolume
    sections: Sections | None
    rain: RainExtinction | None
    eye_m: Array

    @property
    def rain_per_m(self) -> float:
        """Greatest extinction by the rain, 1/m; 0 where it does not attenuate."""
        return self.rain.greatest if self.rain is not None else 0.0

    def moments(self) -> Float32:
        """Give what the shader interpolates at grid points: density, density times radius and,
        where rain dims rain, extinction; (nz, ny, nx, 2 or 3)."""
        moments = self.volume.moments()
        if self.rain is None:
            return moments
        field = self.rain.field.astype(np.float32)[..., None]
        return np.concatenate([moments, field], axis=-1)


def scene_parts(scene: Scene, progress: Progress = no_progress, *, tables: bool = True) -> Parts:
    """Compute a scene's parts.

    Args:
        scene: the scene.
        progress: wraps the loop over parts of an exact table that has to be built first.
        tables: with cross-sections, where the scene needs a table of them.

    Raises:
        InputError: a spectrum or volume is not usable.
    """
    optics = scene_optics(scene)
    volume = scene_volume(scene)
    return Parts(
        optics,
        volume,
        table_sections(scene, optics, volume, progress) if tables else None,
        _rain(scene, optics, volume) if scene.droplets.extinction else None,
        np.array(scene.camera.position_m),
    )


def moved_parts(parts: Parts, before: Scene, scene: Scene) -> Parts:
    """Give the parts of a scene that differs from theirs in where camera and lights are.

    Args:
        parts: those of the scene before.
        before: that scene.
        scene: the other one. Where its lights are the same, so are its optics.
    """
    optics = parts.optics
    if scene.light != before.light:
        # Spectra do not move, and their sums over the wavelengths would take a while.
        optics = replace(optics, suns=suns(scene), lamps=lamps(scene))
    return replace(parts, optics=optics, eye_m=np.array(scene.camera.position_m))


def _rain(scene: Scene, optics: Optics, volume: DropletVolume) -> RainExtinction:
    # Imported here, with the compiler of what is summed on the CPU.
    from rtbow.world.rain.extinction import rain_extinction

    return rain_extinction(scene, optics, volume)


def cone_range(camera: Camera, sun: Sun) -> tuple[float, float]:
    """Least and greatest scattering angle of a sun in the picture and ``CONE_MARGIN`` beyond it."""
    axis, cone = picture_cone(camera)
    cone += CONE_MARGIN
    middle = float(np.arccos(np.clip(sun.direction @ axis, -1.0, 1.0)))
    return max(middle - cone, 0.0), min(middle + cone, np.pi)


def scattering_range(camera: Camera, optics: Optics) -> tuple[float, float]:
    """Least and greatest scattering angle of any sun in the picture, rad."""
    ends = [cone_range(camera, sun) for sun in optics.suns]
    return min(low for low, _ in ends), max(high for _, high in ends)
