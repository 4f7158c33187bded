"""Method ``fast`` under a sun: tables of its colours, for one range of air columns each."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from rtbow.base.arrays import Array, Progress
from rtbow.base.errors import UnsuitedError
from rtbow.gl.program import row_texture
from rtbow.physics.air.rayleigh import Column
from rtbow.render.colours.basis import column_degree, mean_column_error
from rtbow.render.colours.table import (
    ColourTable,
    bow_width,
    chords,
    colour_table,
    fringe_step,
)
from rtbow.render.fast.columns import DARK_COLUMN
from rtbow.render.fast.light import bake_light, most_texels
from rtbow.render.fast.shared import FastScene
from rtbow.world.lights import Sun
from rtbow.world.world import cone_range

_ROAMING_DEGREE = 2
"""Of the polynomial in the column, at least, for suns that move: so that none is of another."""
_WORST_FIT = 5.0
"""Of the error allowed to the fit of the air's colours: what cannot be followed is refused."""
_TABLES = 6
"""Tables that are kept for suns that move to and fro."""
_SHARP_STEP_NM = 1.0
"""Between wavelengths, where nothing blurs what is of one wavelength: that of the reference."""
_TOO_FINE = (
    "light.N.angular_diameter_deg = 0: drops under a point of light show fringes that method fast"
    " does not follow; use --method spectral, or give the light a diameter"
)


@dataclass(frozen=True)
class SunTable:
    """A table for some range of columns, on the device.

    Attributes:
        table: itself.
        texture: its values.
        grey: depth per column that weights carry, which the table leaves out.
    """

    table: ColourTable
    texture: moderngl.Texture
    grey: float


class SunColours:
    """What drops make of one sun's light, baked once, and the tables for ranges of air columns.

    Args:
        here: the scene, whose GL context must be current here and in every method.
        number: which of its suns.
        column: range of columns, of which a roaming one takes no notice.
        building: wraps the loop over parts of an exact table that has to be built first.
        roaming: bake for all columns and all angles.
    """

    def __init__(
        self, here: FastScene, number: int, column: Column, building: Progress, *, roaming: bool
    ) -> None:
        self._gl, self._tolerance, self._roaming = here.gl, here.settings.colour, roaming
        self._tables: dict[Column, SunTable] = {}
        sun = here.parts.optics.suns[number]
        sharp = sun.disc_rad == 0.0 and _one_size_each(here)
        if sharp and len(here.radii.rows) > 1:
            raise UnsuitedError(_TOO_FINE)
        whole = Column(0.0, DARK_COLUMN) if roaming and here.parts.optics.has_air else column
        self._baked = bake_light(
            here, sun.spectrum, whole, _chords(here, sun, everywhere=roaming), building,
            disc_rad=sun.disc_rad, step_nm=_SHARP_STEP_NM if sharp else None,
        )  # fmt: skip

    def behind(self, column: Column) -> SunTable:
        """Give the table for a range of columns, made if it is none of the last few.

        Raises:
            UnsuitedError: the range is so wide that no polynomial follows its colours.
        """
        if column not in self._tables:
            basis = self._baked.basis
            degree = column_degree(basis, column, self._tolerance)
            if self._roaming and degree:
                degree = max(degree, _ROAMING_DEGREE)
            table = colour_table(self._baked, column, degree)
            error = max(table.fit_error, mean_column_error(basis, column))
            if error > _WORST_FIT * self._tolerance:
                raise UnsuitedError(
                    "atmosphere: the air between light, drops and eye differs so much that method"
                    " fast does not follow its colours; use --method spectral"
                )
            texture = row_texture(self._gl, table.values)
            self._tables[column] = SunTable(table, texture, basis.grey(column.middle))
            if len(self._tables) > _TABLES:
                self._tables.pop(next(iter(self._tables)))
        return self._tables[column]

    @property
    def textures(self) -> list[moderngl.Texture]:
        """Those of the tables that are kept."""
        return [one.texture for one in self._tables.values()]


def _chords(here: FastScene, sun: Sun, *, everywhere: bool) -> Array:
    """Choose the table's angles: those in the picture, finely enough for its drops and disc."""
    low, high = (0.0, np.pi) if everywhere else cone_range(here.scene.camera, sun)
    largest = here.parts.volume.size_range_um[1] * 1e-6
    most = most_texels(here)
    if sun.disc_rad > 0.0 or not _one_size_each(here):
        per_disc = here.settings.texels_per_disc
        step = np.hypot(sun.disc_rad / per_disc, 0.6 / per_disc * bow_width(largest))
        return chords(low, high, float(step), most)
    step = fringe_step(here.scene.scattering.orders, largest, low, high)
    found = chords(low, high, step, most + 1)
    if len(found) > most:
        raise UnsuitedError(_TOO_FINE)
    return found


def _one_size_each(here: FastScene) -> bool:
    """Whether nothing but a light's disc blurs fringes: Airy's theory, one size at each point."""
    return here.scene.scattering.theory == "airy" and here.parts.volume.sizes is None
