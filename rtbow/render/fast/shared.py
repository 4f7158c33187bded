"""Method ``fast``: what its programs for suns and lamps share about a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import moderngl
import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.errors import UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import GlProgram, volume_texture
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.drop.airy import RADIUS_POWER
from rtbow.render.colours.bake import middle_radius
from rtbow.render.colours.table import RIGHT_ANGLE_CHORD, ColourTable
from rtbow.render.fast.columns import (
    filled_box,
    greatest_depth,
    kind_of,
    light_range_um,
    light_shares,
    radius_spread,
)
from rtbow.render.fast.tolerance import FastSettings, hat_rows
from rtbow.render.uniforms import (
    MOST_LOOPS,
    common_defines,
    common_uniforms,
    set_uniforms,
)
from rtbow.scene.model import Camera, Scene
from rtbow.tables.layout import radius_axis
from rtbow.world.lights import Lamp, Sun
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import (
    LEAST_RAIN_SAMPLES,
    StepRates,
    grid_cells,
    lamp_steps,
    most_steps,
    rates_on_grid,
)
from rtbow.world.world import Parts, moved_parts

_WIDEST_BLOCK_DEG = 1.1
"""Angle between nodes, at most: what they gather bends over several degrees."""
_LEFT_OUT = 2e-5
"""Share of the light at each end of the radii whose drops count at the last row's radius."""
DARK = 1e4
"""Column behind which no light is left at all: the shader's, where the Earth is in the way."""
_LEAST_STEPS = 12
"""Steps along any ray through a grid: on short ones a few cells' errors do not average out."""


@dataclass(frozen=True)
class RadiusRows:
    """Radii of a table, as logarithms of metres.

    Attributes:
        fine: at which cross-sections are taken (F,).
        rows: that they are fitted to (R,), even; one of one radius or mixture.
        middle: from which weights are counted.
        shares: of the volume's light that counts at each row (R,).
    """

    fine: Array
    rows: Array
    middle: float
    shares: Array


def radius_rows(volume: DropletVolume, settings: FastSettings) -> RadiusRows:
    """Choose the radii of a volume's tables."""
    range_um = volume.size_range_um
    if kind_of(volume) == "smooth":
        # A few drops at the ends, which hardly count, would take many rows.
        range_um = light_range_um(volume, _LEFT_OUT)
    radii = radius_axis(range_um, volume.sizes, settings.row_step).radius_m
    fine, middle = np.log(radii), float(np.log(middle_radius(radii)))
    if len(fine) == 1:
        return RadiusRows(fine, fine, middle, np.ones(1))
    per_fold = hat_rows(radius_spread(volume), settings)
    count = min(2 + int((fine[-1] - fine[0]) * per_fold), len(fine))
    rows = np.linspace(fine[0], fine[-1], count)
    return RadiusRows(fine, rows, middle, light_shares(volume, rows))


@dataclass(frozen=True)
class FastScene:
    """A scene on a GL context, as the programs of all its lights see it.

    Attributes:
        gl: the context.
        scene: the scene.
        parts: what it is made of.
        settings: how coarse.
        box_m: the part of the volume that has drops (2, 3).
        radii: of the tables.
        grid_cells: samples per metre along each axis that the grid alone asks for (3,).
        rates: samples per metre of ray.
        drops: the volume's moments; None for an even one.
    """

    gl: GlContext
    scene: Scene
    parts: Parts
    settings: FastSettings
    box_m: Array
    radii: RadiusRows
    grid_cells: Array
    rates: StepRates
    drops: moderngl.Texture3D | None

    def moved(self, scene: Scene) -> FastScene:
        """Give a scene that differs in where camera and lights are; the volume's part is shared."""
        parts = moved_parts(self.parts, self.scene, scene)
        rates = self.rates
        if parts.optics is not self.parts.optics:
            rates = _rates(parts, self.grid_cells)
        return replace(self, scene=scene, parts=parts, rates=rates)

    @cached_property
    def view(self) -> Mapping[str, Any]:
        """Uniforms that the programs of all lights share."""
        return _view(self)


def fast_scene(gl: GlContext, scene: Scene, parts: Parts, settings: FastSettings) -> FastScene:
    """Work out what follows from a scene's volume, and upload it."""
    volume = parts.volume
    cells = grid_cells(volume, settings.samples_per_cell, settings.samples_per_log_radius)
    return FastScene(
        gl, scene, parts, settings, filled_box(volume), radius_rows(volume, settings),
        cells, _rates(parts, cells),
        None if volume.uniform else volume_texture(gl, parts.moments()),
    )  # fmt: skip


def _rates(parts: Parts, cells: Array) -> StepRates:
    return rates_on_grid(cells, parts.volume, parts.optics, parts.rain_per_m)


def rain_colour(here: FastScene) -> Callable[[Array], Array] | None:
    """Give the rain's extinction at wavelengths (nm) over that at its own one, where it shows."""
    rain, nm = here.parts.rain, here.parts.optics.wavelength_nm
    if rain is None:
        return None
    ratio = rain.ratio
    depth = min(greatest_depth(here.parts.volume, rain.greatest), 3.0)
    if np.abs(ratio - 1.0).max() * depth < here.settings.colour:
        return None
    return lambda at: floats(np.interp(at, nm, ratio))


def scene_defines(here: FastScene, table: ColourTable) -> dict[str, Define]:
    """Give the switches and constants that all programs of one light share."""
    rain, even = here.parts.rain is not None, here.parts.volume.uniform
    return {
        **common_defines(here.scene, here.parts),
        "RADIUS_POWER": RADIUS_POWER,
        "RIGHT_ANGLE_CHORD": RIGHT_ANGLE_CHORD,
        "DARK": DARK,
        "LEAST_STEPS": LEAST_RAIN_SAMPLES if rain else (1 if even else _LEAST_STEPS),
        "SEVERAL_RADII": table.rows > 1,
        "ATTENUATION": False,
        "RAIN_COLOUR": table.rain,
        "COMPONENTS": table.components,
        "COLUMN_DEGREE": table.degree,
        "RADIUS_ROWS": table.rows,
    }


def set_scene(program: GlProgram, here: FastScene, grey: float) -> None:
    """Set the uniforms that all programs share, and the depth per column that weights carry."""
    set_uniforms(program, here.view)
    program.set("greyAir", grey)


def _view(here: FastScene) -> dict[str, Any]:
    volume, eye, rows = here.parts.volume, here.parts.eye_m, here.radii.rows
    height = float(eye[2])
    view = {
        **common_uniforms(here.scene, here.parts, here.box_m, here.rates),
        "eyeAir": float(np.exp(-max(height, -1e5) / SCALE_HEIGHT_M) / SCALE_HEIGHT_M),
        "middleRadius": here.radii.middle,
    }
    if not volume.uniform:
        view["gridLow"] = tuple(volume.box_m[0] - eye)
        view["gridPerMetre"] = tuple(1.0 / (volume.box_m[1] - volume.box_m[0]))
    if len(rows) > 1:
        per_fold = (len(rows) - 1) / float(rows[-1] - rows[0])
        view["radiusRows"] = (float(rows[0]) - here.radii.middle, per_fold)
    return view


def bind_rain(programs: Sequence[GlProgram], light: Sun | Lamp, here: FastScene) -> None:
    """Upload the rain's depths towards a light, where the rain attenuates."""
    rain, volume = here.parts.rain, here.parts.volume
    if rain is not None and not volume.uniform:
        from rtbow.world.rain.extinction import mean_extinction_towards

        towards = mean_extinction_towards(light, volume, rain.field)
        depths = volume_texture(here.gl, towards[..., None])
        for program in programs:
            program.bind("rainToLight", depths)


def block_for(camera: Camera, most: int) -> int:
    """Give the pixels between nodes, fewer than ``most`` where they are wide; 0 for no nodes."""
    pixel_deg = camera.fov_deg / camera.size_px[0]
    block = min(most, int(_WIDEST_BLOCK_DEG / pixel_deg))
    return block if block > 1 else 0


def check_loops(here: FastScene, per_step: int) -> None:
    """Check that a ray's march fits in one pass of a driver that counts loops.

    Args:
        here: the scene.
        per_step: iterations of loops within a step, itself included.

    Raises:
        UnsuitedError: it does not.
    """
    fixed, volume = here.scene.render.steps, here.parts.volume
    steps = fixed or most_steps(here.rates, volume)
    if here.parts.optics.lamps and fixed is None:
        steps = max(steps, 2 * lamp_steps(here.rates, volume))
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
