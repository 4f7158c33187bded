"""Method ``fast``: the drops, spectra and angles that the colours of one light are tabled for."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rtbow.base.arrays import Array, Progress
from rtbow.gl.context import GlContext
from rtbow.physics.air.rayleigh import Column
from rtbow.physics.light.spectrum import Spectrum
from rtbow.render.colours.bake import Drops, outcomes
from rtbow.render.colours.basis import LightBasis, column_degree, light_basis
from rtbow.render.colours.pixels import PixelLevels
from rtbow.render.colours.table import BakedLight, hat_fit, unfolded
from rtbow.render.fast.shared import Plan, RadiusRows, rain_colour
from rtbow.render.fast.tolerance import node_step_nm

MOST_TEXELS = 16_384
"""A table has no more texels along its angles than this, even where the device takes more."""


@dataclass(frozen=True)
class LightPlan:
    """The drops, spectra and angles that a light's colours are tabled for.

    Attributes:
        drops: whose colours.
        radii: the rows that they are fitted to.
        basis: the light's spectrum behind any column of air in its range.
        chord: folded chords of the scattering angles (N,), even.
        disc_rad: angular radius of the light's disc.
        components: whether both components are kept apart.
        tolerance: relative error left to the fit of the air's colours.
        levels: extents of pixels that are means over their area; None for their centres.
    """

    drops: Drops
    radii: RadiusRows
    basis: LightBasis
    chord: Array
    disc_rad: float
    components: bool
    tolerance: float
    levels: PixelLevels | None = None
    _degrees: dict[Column, int] = field(default_factory=dict, repr=False)

    def degree(self, column: Column) -> int:
        """Give the degree of the polynomial that follows the light's colours over a range."""
        if column not in self._degrees:
            self._degrees[column] = column_degree(self.basis, column, self.tolerance)
        return self._degrees[column]

    @property
    def evaluations(self) -> int:
        """Evaluations of a bow that its tables take on the device; 0 where they are summed from
        exact tables, which ``spectral`` needs as well."""
        if not self.drops.on_device:
            return 0
        components = 2 if self.components else 1
        nodes = len(self.basis.wavelength_nm) * len(self.chord)
        return components * nodes * len(self.drops.radius_m)

    def bake(self, gl: GlContext, building: Progress) -> BakedLight:
        """Sum what the drops send back over the wavelengths of the light.

        Args:
            gl: the context; it must be current.
            building: wraps the loop over parts of an exact table that has to be built first.
        """
        colours = outcomes(
            gl, self.drops, self.basis, unfolded(self.chord), self.disc_rad,
            components=self.components, progress=building,
        )  # fmt: skip
        fit = hat_fit(self.radii.fine, self.radii.rows)
        fitted = np.einsum("rf,bcfnx->bcrnx", fit, colours, optimize=True)
        return BakedLight.of(self.basis, self.chord, fitted, self.radii.shares)


def plan_light(
    plan: Plan, spectrum: Spectrum, column: Column, chord: Array, *,
    disc_rad: float = 0.0, step_nm: float | None = None, levels: PixelLevels | None = None,
) -> LightPlan:  # fmt: skip
    """Decide what a light's colours are tabled for.

    Args:
        plan: the world's.
        spectrum: of the light.
        column: of air that tables will be asked for.
        chord: folded chords of their angles (N,), even.
        disc_rad: angular radius of the light's disc.
        step_nm: between wavelengths of cross-sections; the settings' own if left out.
        levels: extents of pixels that are means over their area; None for their centres.
    """
    world = plan.world
    drops = Drops(world.scatterer, np.exp(plan.radii.fine), world.volume.sizes)
    if step_nm is None:
        step_nm = node_step_nm(plan.settings, blurred=not drops.on_device)
    pressure = world.optics.pressure_hpa
    basis = light_basis(spectrum, step_nm, column, rain_colour(plan), pressure)
    return LightPlan(
        drops, plan.radii, basis, chord, disc_rad, plan.components == 2, plan.settings.colour,
        levels,
    )  # fmt: skip


def most_texels(gl: GlContext) -> int:
    """Give the texels that a table may have along its angles."""
    return min(gl.limits.texture_2d, MOST_TEXELS)
