"""What a scene's drops make of one of its lights, as method ``fast`` tables it."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, Progress
from rtbow.physics.air.rayleigh import Column
from rtbow.physics.light.spectrum import Spectrum
from rtbow.render.colours.bake import Drops, outcomes
from rtbow.render.colours.basis import light_basis
from rtbow.render.colours.table import BakedLight, hat_fit, unfolded
from rtbow.render.fast.shared import FastScene, rain_colour
from rtbow.render.fast.tolerance import node_step_nm

MOST_TEXELS = 16_384
"""Texels along a table, at most, also of devices that take more."""


def bake_light(
    here: FastScene, spectrum: Spectrum, column: Column, chord: Array, building: Progress, *,
    disc_rad: float = 0.0, step_nm: float | None = None,
) -> BakedLight:  # fmt: skip
    """Sum what a scene's drops send back over the wavelengths of a light.

    Args:
        here: the scene.
        spectrum: of the light.
        column: of air that tables will be asked for.
        chord: folded chords of their angles (N,), even.
        building: wraps the loop over parts of an exact table that has to be built first.
        disc_rad: angular radius of the light's disc.
        step_nm: between wavelengths of cross-sections; the settings' own if left out.
    """
    scene, radii = here.scene, here.radii
    drops = Drops(scene.scattering, np.exp(radii.fine), here.parts.volume.sizes)
    if step_nm is None:
        step_nm = node_step_nm(here.settings, blurred=not drops.on_device)
    basis = light_basis(spectrum, step_nm, column, rain_colour(here))
    found = outcomes(
        here.gl, drops, basis, unfolded(chord), disc_rad,
        components=scene.camera.polarizer_deg is not None, progress=building,
    )  # fmt: skip
    fit = hat_fit(radii.fine, radii.rows)
    fitted = np.einsum("rf,bcfnx->bcrnx", fit, found, optimize=True)
    return BakedLight.of(basis, chord, fitted, radii.shares)


def most_texels(here: FastScene) -> int:
    """Give the texels that a table of a scene may have along its angles."""
    return min(here.gl.limits.texture_2d, MOST_TEXELS)
