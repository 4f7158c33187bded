"""What float32 and the GL driver leave, where nothing is marched."""

from __future__ import annotations

from typing import Any

import numpy as np

import rtbow
from budget.error_budget import Measurement, Row, Stage
from budget.frames import SIZE, SIZE_NAME, frame
from budget.strips import drop_xyz, drops_per_area
from rtbow.base.arrays import Array, floats
from rtbow.frames.difference import frame_difference
from rtbow.scene.model import Scene
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.lights import suns


def same_table_frame(scene: Scene) -> Array:
    """Render a uniform scene without air from the tables, in float64: X, Y, Z (h, w, 3)."""
    rays = pixel_directions(scene.camera).reshape(-1, 3)
    towards = suns(scene)[0].direction
    away = np.linalg.norm(towards - rays, axis=1)
    theta = 2.0 * np.arctan2(away, np.linalg.norm(towards + rays, axis=1))
    xyz = drops_per_area(scene, rays)[:, None] * drop_xyz(scene, theta)
    width, height = scene.camera.size_px
    return floats(xyz.reshape(height, width, 3))


def measure() -> Measurement:
    """Compare the shader with float64: the same look-ups, and the reference."""
    exact = {"scattering.theory": "mie", "droplets.radius.radius_um": 100.0}
    cases: tuple[tuple[str, float, dict[str, Any]], ...] = (
        ("Airy, 300 µm", 5.0, {}),
        ("Airy, 30 µm", 5.0, {"droplets.radius.radius_um": 30.0}),
        ("exact, 100 µm", 40.0, exact),
    )
    for label, step, more in cases:
        common = {"camera.size_px": SIZE, "render.wavelength_step_nm": step, **more}
        scene = rtbow.load_scene("uniform", common)
        drawn = frame(scene, "spectral")
        where = f"`uniform`, {SIZE_NAME}, {step:g} nm"
        difference = frame_difference(drawn, same_table_frame(scene))
        yield Row(f"{label}: against the same table in float64", where, difference)
        difference = frame_difference(drawn, frame(scene, "reference"))
        headline = label == "Airy, 300 µm"
        yield Row(f"{label}: against the reference", where, difference, headline=headline)
    air = {
        "camera.size_px": SIZE,
        "atmosphere.rayleigh": True,
        "render.wavelength_step_nm": 20.0,
        "render.steps": 400,
    }
    scene = rtbow.load_scene("uniform", air)
    difference = frame_difference(frame(scene, "spectral"), frame(scene, "reference"))
    yield Row(
        "Airy, 300 µm, in air, 400 steps: against the reference",
        f"`uniform` with air, {SIZE_NAME}, 20 nm", difference,
    )  # fmt: skip


FLOAT32 = Stage(
    "float32 in the shader",
    "The shader's frame of a uniform volume, where the march has no error, against the "
    "same look-ups in float64 (rounding and texture filtering alone; the table of exact "
    "theory is resampled for the shader and interpolated linearly) and against the "
    "reference (the table's error as well).",
    measure,
)
