"""Method ``fast``: the plan, uniforms and defines that its suns and lamps share."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import GlProgram, volume_texture
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.drop.airy import RADIUS_POWER
from rtbow.render.colours.bake import middle_radius
from rtbow.render.colours.pixels import RIGHT_ANGLE_CHORD
from rtbow.render.fast.columns import (
    filled_box,
    greatest_depth,
    kind_of,
    light_range_um,
    light_shares,
    radius_spread,
)
from rtbow.render.fast.tolerance import FastSettings, hat_rows, settings_for
from rtbow.render.haze import hazy_rates
from rtbow.render.uniforms import common_defines, common_uniforms, set_uniforms
from rtbow.tables.layout import radius_axis
from rtbow.world.lights import Lamp, Sun
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import (
    LEAST_RAIN_SAMPLES,
    StepRates,
    fringe_crowding,
    grid_cells,
    rates_on_grid,
)
from rtbow.world.world import World

_LEFT_OUT = 2e-5
"""At each end of the radii, drops with this share of the light count at the last row's radius."""
DARK = 1e4
"""The shader's column where the Earth is in the way: no light is left behind it at all."""
LEAST_STEPS = 12
"""Least steps along a ray through a grid: on short ones a few cells' errors do not average out."""


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
class Plan:
    """How a world is drawn, decided for all lights before the device is touched.

    Attributes:
        world: the world.
        settings: how coarse each approximation is.
        box_m: the part of the volume that has drops (2, 3).
        radii: of the tables.
        grid_cells: samples per metre along each axis that the grid alone asks for (3,).
        rates: samples per metre of ray.
        frugal: whether tables are refused that take far longer than the frame by ``spectral``.
    """

    world: World
    settings: FastSettings
    box_m: Array
    radii: RadiusRows
    grid_cells: Array
    rates: StepRates
    frugal: bool = False

    def moved(self, world: World) -> Plan:
        """Give the plan for a world that differs in where camera and lights are."""
        rates = self.rates
        if world.optics is not self.world.optics:
            rates = _rates(world, self.grid_cells)
        return replace(self, world=world, rates=rates)

    @property
    def components(self) -> int:
        """Components of the light that tables keep apart: 2 for a polariser."""
        return 1 if self.world.view.polarizer is None else 2

    @cached_property
    def uniforms(self) -> Mapping[str, Any]:
        """Uniforms that the programs of all lights share."""
        world, rows = self.world, self.radii.rows
        volume, eye = world.volume, world.view.eye_m
        height = float(eye[2])
        uniforms = {
            **common_uniforms(world, self.box_m, self.rates),
            "air.perMetre": float(np.exp(-max(height, -1e5) / SCALE_HEIGHT_M) / SCALE_HEIGHT_M),
            "rows.middle": self.radii.middle,
        }
        if not volume.uniform:
            uniforms["volume.gridLow"] = tuple(volume.box_m[0] - eye)
            uniforms["volume.gridPerMetre"] = tuple(1.0 / (volume.box_m[1] - volume.box_m[0]))
        if len(rows) > 1:
            per_fold = (len(rows) - 1) / float(rows[-1] - rows[0])
            uniforms["rows.first"] = float(rows[0]) - self.radii.middle
            uniforms["rows.perFold"] = per_fold
        return uniforms


def plan_world(world: World, *, frugal: bool = False) -> Plan:
    """Decide what follows from a world's volume and the error that it allows.

    Args:
        world: the world.
        frugal: refuse tables that take far longer than the frame by ``spectral``.
    """
    volume = world.volume
    settings = settings_for(world.fineness.max_delta_e, kind_of(volume))
    per_log_radius = settings.samples_per_log_radius * fringe_crowding(volume, world.optics)
    cells = grid_cells(volume, settings.samples_per_cell, per_log_radius)
    return Plan(
        world, settings, filled_box(volume), radius_rows(volume, settings), cells,
        _rates(world, cells), frugal,
    )  # fmt: skip


def _rates(world: World, cells: Array) -> StepRates:
    rates = rates_on_grid(cells, world.volume, world.optics, world.rain_per_m)
    return hazy_rates(rates, world)


def rain_colour(plan: Plan) -> Callable[[Array], Array] | None:
    """Give the rain's extinction at wavelengths (nm) over that at its own one, where it shows."""
    world = plan.world
    if world.rain is None:
        return None
    ratio, nm = world.rain.ratio, world.optics.wavelength_nm
    depth = min(greatest_depth(world.volume, world.rain.greatest), 3.0)
    if np.abs(ratio - 1.0).max() * depth < plan.settings.colour:
        return None
    return lambda at: floats(np.interp(at, nm, ratio))


def light_defines(plan: Plan, *, degree: int, rain: bool) -> dict[str, Define]:
    """Give the switches and constants that all programs of one light share.

    Args:
        plan: the world's.
        degree: of the polynomial in the air column that the light's colours follow.
        rain: whether its table has a row for the rain's colour.
    """
    world, rows = plan.world, len(plan.radii.rows)
    least = 1 if world.volume.uniform else LEAST_STEPS
    return {
        **common_defines(world),
        "RADIUS_POWER": RADIUS_POWER,
        "RIGHT_ANGLE_CHORD": RIGHT_ANGLE_CHORD,
        "DARK": DARK,
        "LEAST_STEPS": least if world.rain is None else LEAST_RAIN_SAMPLES,
        "SEVERAL_RADII": rows > 1,
        "ATTENUATION": False,
        "RAIN_COLOUR": rain,
        "COMPONENTS": plan.components,
        "COLUMN_DEGREE": degree,
        "RADIUS_ROWS": rows,
    }


def set_scene(program: GlProgram, plan: Plan, grey: float) -> None:
    """Set the uniforms that all programs share, and the depth per column that weights carry."""
    set_uniforms(program, plan.uniforms)
    program.set("air.grey", grey)


def bind_rain(
    gl: GlContext, programs: Sequence[GlProgram], light: Sun | Lamp, world: World
) -> None:
    """Upload the rain's depths towards a light, where the rain attenuates."""
    rain, volume = world.rain, world.volume
    if rain is not None and not volume.uniform:
        from rtbow.world.rain.extinction import mean_extinction_towards

        towards = mean_extinction_towards(light, volume, rain.field)
        depths = volume_texture(gl, towards[..., None])
        for program in programs:
            program.bind("volume.toLight", depths)
