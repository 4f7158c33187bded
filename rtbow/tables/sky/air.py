"""The air's constituents as its light is gathered from them: molecules, ozone and aerosol."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import cached_arrays, source_digest
from rtbow.physics.air.aerosol import AerosolOptics, layer_density, moments_of
from rtbow.physics.air.ozone import ozone_density
from rtbow.physics.air.shells import (
    SHELL_HEIGHTS_M,
    Shells,
    molecular_shells,
    with_constituent,
)
from rtbow.tables.sky.light import DEGREE, Air


@dataclass(frozen=True)
class Haze:
    """An aerosol and its layer.

    Attributes:
        optics: what it does at the wavelengths.
        scale_height_m: of its density.
        top_m: height at which it ends; infinite where it does not.
    """

    optics: AerosolOptics
    scale_height_m: float
    top_m: float


@cache
def _shells(ozone: bool, layer: tuple[float, float] | None) -> Shells:
    """Give where constituents are: molecules, ozone if there is any, and aerosol of a layer by its
    scale height and top. Kept, for its columns take a second."""

    def build() -> dict[str, Array]:
        shells = molecular_shells()
        if ozone:
            shells = with_constituent(shells, ozone_density(SHELL_HEIGHTS_M))
        if layer is not None:
            shells = with_constituent(shells, layer_density(SHELL_HEIGHTS_M, *layer))
        return shells._asdict()

    code = source_digest("base.limits", "physics", "tables.sky")
    kept = cached_arrays("shells", f"{code} {ozone} {layer}", build)
    return Shells(floats(kept["density"]), floats(kept["log_column"]))


def make_air(
    molecules: Array, albedo: Array, ozone: Array | None = None, haze: Haze | None = None,
    water: Array | None = None,
) -> Air:  # fmt: skip
    """Put air together, at W wavelengths.

    Args:
        molecules: vertical depth of the molecules (W,).
        albedo: of the ground (W,).
        ozone: vertical depth of the ozone (W,), if there is any.
        haze: the aerosol, if there is any.
        water: refractive index of a ground that is water (W,), if it is.
    """
    water = np.zeros(len(molecules)) if water is None else water
    layer = None if haze is None else (haze.scale_height_m, haze.top_m)
    shells, waves = _shells(ozone is not None, layer), len(molecules)
    depths = [molecules] if ozone is None else [molecules, ozone]
    if haze is None:
        zero, nothing = np.zeros(waves), np.zeros((DEGREE + 1, waves))
        return Air(
            shells.density, shells.below, shells.log_column, np.stack(depths), np.stack(depths),
            albedo, water, False, zero, nothing, np.zeros((2, waves)),
        )  # fmt: skip
    optics = haze.optics
    moments = moments_of(optics.phase, DEGREE + 1)
    forward = moments[-1]
    kept = 1.0 - forward * optics.scattering  # of the depth, without the forward peak
    return Air(
        shells.density,
        shells.below,
        shells.log_column,
        np.stack([*depths, optics.depth * kept]),
        np.stack([*depths, optics.depth]),
        albedo,
        water,
        True,
        optics.scattering * (1.0 - forward) / kept,
        (moments[:-1] - forward) / (1.0 - forward),
        optics.phase / (1.0 - forward),
    )


def shells_of(air: Air) -> Shells:
    """Give where an air's constituents are."""
    return Shells(air.density, air.log_column)
