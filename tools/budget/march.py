"""What the march leaves: samples along a ray against the reference's quadrature."""

from __future__ import annotations

from typing import Any

import rtbow
from budget.error_budget import Measurement, Row, Stage
from budget.frames import SIZE, SIZE_NAME, frame
from rtbow.frames.difference import frame_difference
from rtbow.scene.model import Scene
from rtbow.world.optics import scene_optics
from rtbow.world.rain.volume import build_volume
from rtbow.world.steps import most_steps, step_rates

_STEP_NM = 20.0
_SCENES: tuple[tuple[str, str, dict[str, Any]], ...] = (
    ("default", "default", {}),
    ("shower", "shower", {}),
    ("random radii", "figures/fig5d", {}),
    ("random radii, exact theory", "figures/fig5d", {"scattering.theory": "mie"}),
)


def default_steps(scene: Scene) -> int:
    """Give the most samples that a ray through a scene takes by default."""
    optics, volume = scene_optics(scene), build_volume(scene.droplets)
    return most_steps(step_rates(volume, optics), volume)


def measure() -> Measurement:
    """Compare half, all and twice the samples with the reference at the same wavelengths."""
    for label, name, more in _SCENES:
        step = _STEP_NM if not more else 2.0 * _STEP_NM
        common = {"camera.size_px": SIZE, "render.wavelength_step_nm": step, **more}
        scene = rtbow.load_scene(name, common)
        truth = frame(scene, "reference")
        most = default_steps(scene)
        where = f"`{name}`, {SIZE_NAME}, {step:g} nm"
        difference = frame_difference(frame(scene, "spectral"), truth)
        yield Row(f"{label}: default", where, difference, headline=name == "default")
        for words, steps in (("half", most // 2), ("as many", most), ("double", 2 * most)):
            fixed = rtbow.load_scene(name, {**common, "render.steps": steps})
            difference = frame_difference(frame(fixed, "spectral"), truth)
            yield Row(f"{label}: {words}, {steps} on every ray", where, difference)
    yield (
        "By default a ray takes samples by what it crosses; the fixed numbers are half, all and"
        " twice those of the longest such ray, on every ray."
    )


MARCH = Stage(
    "March step",
    "The shader against the method `reference` at the same wavelengths: both have the "
    "wavelength step's error alike. The shader's table and its float32 are part of the "
    "difference.",
    measure,
)
