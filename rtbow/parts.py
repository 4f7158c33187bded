"""What a scene is made of, as any method of the shader needs it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.arrays import Progress, no_progress
from rtbow.camera import camera_basis
from rtbow.extinction import RainExtinction, rain_extinction
from rtbow.optics import Optics, scene_optics, table_sections
from rtbow.scene import Camera, Scene
from rtbow.sections import Sections
from rtbow.volume import DropletVolume, build_volume


@dataclass(frozen=True)
class Parts:
    """What a scene is made of, as the shader needs it.

    Attributes:
        optics: per-wavelength numbers.
        volume: the drops.
        sections: cross-sections to be laid out in a table, or None for Airy's bows in place.
        rain: the drops' own extinction, or None.
    """

    optics: Optics
    volume: DropletVolume
    sections: Sections | None
    rain: RainExtinction | None


def scene_parts(scene: Scene, progress: Progress = no_progress) -> Parts:
    """Compute a scene's parts.

    Raises:
        InputError: a spectrum or volume is not usable.
    """
    optics = scene_optics(scene)
    volume = build_volume(scene.droplets)
    return Parts(
        optics,
        volume,
        table_sections(scene, optics, volume, progress),
        rain_extinction(scene, optics, volume) if scene.droplets.extinction else None,
    )


def scattering_range(camera: Camera, optics: Optics) -> tuple[float, float]:
    """Least and greatest scattering angle of any sun in the picture, rad."""
    axis, right, up = camera_basis(camera)
    cone = np.arctan(np.hypot(np.linalg.norm(right), np.linalg.norm(up)))
    to_axis = [float(np.arccos(np.clip(sun.direction @ axis, -1.0, 1.0))) for sun in optics.suns]
    # A hair more, for float32.
    return max(min(to_axis) - cone - 1e-4, 0.0), min(max(to_axis) + cone + 1e-4, np.pi)
