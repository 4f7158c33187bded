"""Method ``fast``: what its programs for suns and lamps share about a scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from rtbow import atmosphere, constants
from rtbow.airy import RADIUS_POWER
from rtbow.arrays import Array, floats
from rtbow.camera import camera_basis, polarizer_pass
from rtbow.colour import XYZ_TO_RGB
from rtbow.colour_bake import middle_radius
from rtbow.colour_table import ColourTable
from rtbow.context import GlContext
from rtbow.errors import UnsuitedError
from rtbow.fast_settings import FastSettings, hat_rows
from rtbow.fast_volume import greatest_depth, kind_of, light_range_um, radius_spread
from rtbow.gl_program import GlProgram, volume_texture
from rtbow.glsl import Define
from rtbow.lights import Lamp, Sun
from rtbow.parts import Parts
from rtbow.scene import Camera, Scene
from rtbow.section_table import radius_axis
from rtbow.spectral_layout import MAX_STEPS, MOST_LOOPS, matrix_literal
from rtbow.steps import LEAST_RAIN_SAMPLES, StepRates, lamp_steps, most_steps, step_rates
from rtbow.volume import DropletVolume

_WIDEST_BLOCK_DEG = 1.1
"""Angle between nodes, at most: what they gather bends over several degrees."""
_LEFT_OUT = 2e-5
"""Share of the light at each end of the radii whose drops count at the last row's radius."""
_LEAST_STEPS = 12
"""Steps along any ray through a grid: on short ones a few cells' errors do not average out."""


@dataclass(frozen=True)
class RadiusRows:
    """Radii of a table, as logarithms of metres.

    Attributes:
        fine: at which cross-sections are taken (F,).
        rows: that they are fitted to (R,), even; one of one radius or mixture.
        middle: from which weights are counted.
    """

    fine: Array
    rows: Array
    middle: float


def radius_rows(volume: DropletVolume, settings: FastSettings) -> RadiusRows:
    """Choose the radii of a volume's tables."""
    range_um = volume.size_range_um
    if kind_of(volume) == "smooth":
        # A few drops at the ends, which hardly count, would take many rows.
        range_um = light_range_um(volume, _LEFT_OUT)
    radii = radius_axis(range_um, volume.sizes, settings.row_step).radius_m
    fine, middle = np.log(radii), float(np.log(middle_radius(radii)))
    if len(fine) == 1:
        return RadiusRows(fine, fine, middle)
    per_fold = hat_rows(radius_spread(volume), settings)
    count = min(2 + int((fine[-1] - fine[0]) * per_fold), len(fine))
    return RadiusRows(fine, np.linspace(fine[0], fine[-1], count), middle)


def rain_colour(parts: Parts, settings: FastSettings) -> Callable[[Array], Array] | None:
    """Give the rain's extinction at wavelengths (nm) over that at its own one, where it shows."""
    rain, nm = parts.rain, parts.optics.wavelength_nm
    if rain is None:
        return None
    ratio = rain.ratio
    depth = min(greatest_depth(parts.volume, rain.greatest), 3.0)
    if np.abs(ratio - 1.0).max() * depth < settings.colour:
        return None
    return lambda at: floats(np.interp(at, nm, ratio))


def march_rates(parts: Parts, settings: FastSettings) -> StepRates:
    """Give the samples per metre that the drops, the air and the rain ask for."""
    rain = parts.rain.greatest if parts.rain is not None else 0.0
    return step_rates(
        parts.volume, parts.optics, rain, settings.samples_per_cell, settings.samples_per_log_radius
    )


def scene_defines(scene: Scene, parts: Parts, table: ColourTable) -> dict[str, Define]:
    """Give the switches and constants that all programs of one light share."""
    rain, even = parts.rain is not None, parts.volume.uniform
    return {
        "EARTH_RADIUS_M": constants.EARTH_RADIUS_M,
        "SCALE_HEIGHT_M": constants.SCALE_HEIGHT_M,
        "MAX_HEIGHT_M": atmosphere.MAX_HEIGHT_M,
        "ALTITUDE_CURVE": atmosphere.ALTITUDE_CURVE,
        "XYZ_TO_RGB": matrix_literal(XYZ_TO_RGB),
        "NO_PLANE": constants.NO_PLANE,
        "RADIUS_POWER": RADIUS_POWER,
        "MAX_STEPS": MAX_STEPS,
        "LEAST_STEPS": LEAST_RAIN_SAMPLES if rain else (1 if even else _LEAST_STEPS),
        "GRID": not even,
        "SEVERAL_RADII": table.rows > 1,
        "AIR": parts.optics.has_air,
        "EXTINCTION": rain,
        "ATTENUATION": False,
        "POLARIZER": scene.camera.polarizer_deg is not None,
        "RAIN_COLOUR": table.rain,
        "COMPONENTS": table.components,
        "COLUMN_DEGREE": table.degree,
        "RADIUS_ROWS": table.rows,
    }


def set_scene(program: GlProgram, scene: Scene, parts: Parts, box_m: Array) -> None:
    """Set the uniforms that all programs of method ``fast`` share."""
    camera, volume = scene.camera, parts.volume
    eye = parts.eye_m
    program.set("frameSize", tuple(float(n) for n in camera.size_px))
    program.set("cameraBasis", tuple(camera_basis(camera).ravel()))
    program.set("eyeHeight", float(eye[2]))
    program.set(
        "eyeAir",
        float(np.exp(-max(eye[2], -1e5) / constants.SCALE_HEIGHT_M) / constants.SCALE_HEIGHT_M),
    )
    if camera.polarizer_deg is not None:
        program.set("polarizerPass", tuple(polarizer_pass(camera)))
    program.set("boxLow", tuple(box_m[0] - eye))
    program.set("boxHigh", tuple(box_m[1] - eye))
    program.set("gridLow", tuple(volume.box_m[0] - eye))
    program.set("gridPerMetre", tuple(1.0 / (volume.box_m[1] - volume.box_m[0])))
    program.set("uniformDensity", float(volume.number_per_m3[0, 0, 0]))
    program.set("uniformExtinction", parts.rain.greatest if parts.rain is not None else 0.0)


def set_march(
    program: GlProgram, scene: Scene, rates: StepRates, radii: RadiusRows, grey: float
) -> None:
    """Set the uniforms of the march and of the weights that it gathers."""
    program.set("greyAir", grey)
    program.set("middleRadius", radii.middle)
    if len(radii.rows) > 1:
        per_fold = (len(radii.rows) - 1) / float(radii.rows[-1] - radii.rows[0])
        program.set("radiusRows", (float(radii.rows[0]) - radii.middle, per_fold))
    program.set("cellsPerMetre", tuple(rates.cells_per_metre))
    program.set("airPerMetre", rates.air_per_metre)
    program.set("fixedSteps", scene.render.steps or 0)


def bind_rain(
    gl: GlContext, programs: Sequence[GlProgram], light: Sun | Lamp, parts: Parts
) -> None:
    """Upload the rain's depths towards a light, where the rain attenuates."""
    if parts.rain is not None and not parts.volume.uniform:
        from rtbow.extinction import mean_extinction_towards

        towards = mean_extinction_towards(light, parts.volume, parts.rain.field)
        depths = volume_texture(gl, towards[..., None])
        for program in programs:
            program.bind("rainToLight", depths)


def block_for(camera: Camera, most: int) -> int:
    """Give the pixels between nodes, fewer than ``most`` where they are wide; 0 for no nodes."""
    pixel_deg = camera.fov_deg / camera.size_px[0]
    block = min(most, int(_WIDEST_BLOCK_DEG / pixel_deg))
    return block if block > 1 else 0


def check_loops(scene: Scene, parts: Parts, settings: FastSettings, per_step: int) -> None:
    """Check that a ray's march fits in one pass of a driver that counts loops.

    Args:
        scene: the scene.
        parts: its parts.
        settings: how coarse.
        per_step: iterations of loops within a step, itself included.

    Raises:
        UnsuitedError: it does not.
    """
    rates = march_rates(parts, settings)
    steps = scene.render.steps or most_steps(rates, parts.volume)
    if parts.optics.lamps and scene.render.steps is None:
        steps = max(steps, 2 * lamp_steps(rates, parts.volume))
    if steps * per_step > MOST_LOOPS:
        raise UnsuitedError(
            f"{steps} steps along a ray are more than a shader's loops hold in one pass; use a"
            " smaller render.steps, a coarser volume, or --method spectral, which takes several"
        )


def blocks_of(size_px: tuple[int, int], block: int) -> tuple[int, int]:
    """Give the blocks of pixels that cover a picture, along both sides."""
    return -(-size_px[0] // block), -(-size_px[1] // block)


def flag_target(gl: GlContext, blocks: tuple[int, int]) -> moderngl.Texture:
    """Make the texture that says how each block is drawn."""
    flags = gl.ctx.texture(blocks, 4, dtype="f1")
    flags.filter = (moderngl.NEAREST, moderngl.NEAREST)
    flags.repeat_x = flags.repeat_y = False
    return flags
