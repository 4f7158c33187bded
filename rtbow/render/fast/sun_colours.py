"""Method ``fast`` under a sun: tables of its colours, for one range of air columns each."""

from __future__ import annotations

import moderngl
import numpy as np

from rtbow.base.arrays import Array, Progress
from rtbow.base.errors import UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.program import row_texture
from rtbow.physics.air.rayleigh import Column
from rtbow.physics.drop.airy import bow_width
from rtbow.physics.light.spectrum import Spectrum
from rtbow.render.colours.basis import mean_column_error
from rtbow.render.colours.pixels import pixel_levels
from rtbow.render.colours.table import (
    ColourTable,
    chords,
    colour_table,
    fringe_step,
    fringes_missed,
    over_pixels,
)
from rtbow.render.fast.columns import DARK_COLUMN
from rtbow.render.fast.light import LightPlan, plan_light
from rtbow.render.fast.shared import Plan
from rtbow.render.fast.tolerance import node_step_nm
from rtbow.render.haze import SunHaze
from rtbow.world.lights import Sun

_ROAMING_DEGREE = 2
"""The polynomial in the column has at least this degree for suns that move, so that programs need
not change on the way."""
_WORST_FIT = 5.0
"""A fit of the air's colours is refused whose error is this many times the allowed one."""
_TABLES = 6
"""So many tables are kept for suns that move to and fro."""
_FALL_OFF_ROWS = 3
"""Rows of a table beside its colours, as a rule."""
_SHARP_STEP_NM = 1.0
"""Step of wavelengths, that of the reference, where nothing blurs the fringes of single ones."""
_FINER_STEPS_NM = (2.5, 2.0, _SHARP_STEP_NM)
_TOO_FINE = (
    "light.N.angular_diameter_deg = 0: drops under a point of light show fringes that method fast"
    " does not follow; use --method spectral, or give the light a diameter"
)


def plan_sunlight(
    plan: Plan, sun: Sun, column: Column, most_texels: int, *, roaming: bool
) -> LightPlan:
    """Decide what a sun's colours are tabled for.

    Args:
        plan: the world's.
        sun: the sun.
        column: range of air columns; tables of a roaming sun serve every range.
        most_texels: along a table.
        roaming: for all columns and all angles.

    Raises:
        UnsuitedError: nothing blurs fringes that are too fine for the tables.
    """
    sharp = sun.disc_rad == 0.0 and plan.world.bows_in_place
    if sharp and len(plan.radii.rows) > 1:
        raise UnsuitedError(_TOO_FINE)
    whole = Column(0.0, DARK_COLUMN) if roaming and plan.world.optics.has_air else column
    chord = _chords(plan, sun, most_texels, everywhere=roaming)
    step_nm = _SHARP_STEP_NM if sharp else _step_nm(plan, sun, everywhere=roaming)
    levels = None
    if plan.world.view.area:
        blur = float(np.hypot(sun.disc_rad, plan.world.narrowest_bow_rad))
        texels = len(chord) * (plan.components * len(plan.radii.rows) + _FALL_OFF_ROWS)
        levels = pixel_levels(plan.world.view, blur, texels, roaming=roaming)
    return plan_light(
        plan,
        _spectrum(plan, sun),
        whole,
        chord,
        disc_rad=sun.disc_rad,
        step_nm=step_nm,
        levels=levels,
    )


def _step_nm(plan: Plan, sun: Sun, *, everywhere: bool) -> float:
    """Give the step of wavelengths of a table: the settings', or the first finer one that follows
    the fringes which the sun's disc leaves at the table's angles."""
    world, settings = plan.world, plan.settings
    if not world.bows_in_place:
        return node_step_nm(settings, blurred=True)
    step_nm = node_step_nm(settings, blurred=False)
    low, high = (0.0, np.pi) if everywhere else world.view.angles_from(sun.direction)
    largest, scatterer = world.volume.size_range_um[1] * 1e-6, world.scatterer
    for step in (step_nm, *(step for step in _FINER_STEPS_NM if step < step_nm)):
        step_nm = step
        missed = fringes_missed(
            scatterer.orders, largest, low, high, scatterer.medium, sun.disc_rad, step
        )
        if missed <= settings.fringes_missed:
            break
    return step_nm


def _spectrum(plan: Plan, sun: Sun) -> Spectrum:
    """The sun's spectrum behind what dims it alike for all drops."""
    return sun.spectrum if plan.world.haze is None else SunHaze(plan.world, sun).spectrum()


def sunlight_degree(light: LightPlan, column: Column, *, roaming: bool) -> int:
    """Give the degree of the polynomial in the column of a table for a range of columns."""
    degree = light.degree(column)
    return max(degree, _ROAMING_DEGREE) if roaming and degree else degree


class SunColours:
    """The colours of one sun's light, baked once, and their tables for ranges of air columns.

    Args:
        gl: the context; it must be current here and in every method.
        light: what the colours are tabled for.
        building: wraps the loop over parts of an exact table that has to be built first.
    """

    def __init__(self, gl: GlContext, light: LightPlan, building: Progress) -> None:
        self._gl, self.light = gl, light
        self._tables: dict[Column, tuple[ColourTable, moderngl.Texture]] = {}
        self._baked = light.bake(gl, building)

    def behind(self, column: Column, degree: int) -> tuple[ColourTable, moderngl.Texture]:
        """Give the table for a range of columns, made unless it is one of the last few.

        Args:
            column: the range.
            degree: of its polynomial in the column.

        Returns:
            The table, and its values on the device.

        Raises:
            UnsuitedError: the range is so wide that no polynomial follows its colours.
        """
        if column not in self._tables:
            table = colour_table(self._baked, column, degree)
            error = max(table.fit_error, mean_column_error(self.light.basis, column))
            if error > _WORST_FIT * self.light.tolerance:
                raise UnsuitedError(
                    "atmosphere: the air between light, drops and eye differs so much that method"
                    " fast does not follow its colours; use --method spectral"
                )
            if self.light.levels is not None:
                table = over_pixels(table, self._baked.chord, self.light.levels)
            self._tables[column] = table, row_texture(self._gl, table.values)
            if len(self._tables) > _TABLES:
                self._tables.pop(next(iter(self._tables)))
        return self._tables[column]

    @property
    def textures(self) -> list[moderngl.Texture]:
        """The textures of the tables that are kept."""
        return [texture for _, texture in self._tables.values()]


def _chords(plan: Plan, sun: Sun, most: int, *, everywhere: bool) -> Array:
    """Choose the table's angles: those in the picture, finely enough for its drops and disc."""
    world = plan.world
    low, high = (0.0, np.pi) if everywhere else world.view.angles_from(sun.direction)
    largest = world.volume.size_range_um[1] * 1e-6
    if sun.disc_rad > 0.0 or not world.bows_in_place:
        per_disc, unit = plan.settings.texels_per_disc, world.scatterer.medium.bow_unit
        step = np.hypot(sun.disc_rad / per_disc, 0.6 / per_disc * bow_width(largest, unit))
        return chords(low, high, float(step), most)
    step = fringe_step(world.scatterer.orders, largest, low, high, world.scatterer.medium)
    chord = chords(low, high, step, most + 1)
    if len(chord) > most:
        raise UnsuitedError(_TOO_FINE)
    return chord
