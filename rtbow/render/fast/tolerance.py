"""How coarse method ``fast`` may be for the colour difference that a scene allows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rtbow.base.limits import DEFAULT_DELTA_E

Kind = Literal["alike", "smooth", "rough"]
"""How radii vary over a volume: not at all (one radius or mixture), slowly over the grid's cells,
or from each grid point to the next."""

ROUGH = 0.05
"""A volume is rough from this mean change of ln(radius) between neighbouring grid points."""
BLURRED_STEP_NM = 5.0
"""Sizes mixed within 2 % or more need no finer step of wavelengths: that blurs their fringes by
more than neighbouring wavelengths differ."""


@dataclass(frozen=True)
class FastSettings:
    """How coarse each approximation of method ``fast`` is.

    Attributes:
        share: allowed error, as a multiple of the default one.
        samples_per_cell: midpoint samples per grid cell.
        samples_per_log_radius: further samples per cell and unit of ln(radius) between its points.
        block: pixels between the nodes at which a path is gathered; 0: at every pixel.
        bend: relative error that interpolation between nodes may leave in a path's weight.
        texels_per_disc: texels of the colour table within the light's angular radius.
        texels_per_fringe: texels within a bow's width, for lights without a disc.
        wavelength_step_nm: step of the wavelengths at which cross-sections are taken; spectra are
            integrated at 1 nm. Fringes of one radius need a fine one.
        fringes_missed: amplitude that a light's disc may leave of fringes too fine for that step,
            of that without a disc; a finer step is taken where it leaves more.
        row_step: step in ln(radius) of the radii at which cross-sections are taken.
        rows_per_fold: rows of radius per factor e, in a volume whose radii vary along a ray by that
            factor; more where they vary less (:func:`hat_rows`).
        colour: relative error left to the fit of the air's colours.
        lamp_block: pixels between nodes under a lamp.
        lamp_bend: the error that interpolation between these may leave, as a share of the light.
        lamp_scale: factor of the steps in angle along a ray that a lamp lights.
    """

    share: float
    samples_per_cell: float
    samples_per_log_radius: float
    block: int
    bend: float
    texels_per_disc: float
    texels_per_fringe: float
    wavelength_step_nm: float
    fringes_missed: float
    row_step: float
    rows_per_fold: float
    colour: float
    lamp_block: int
    lamp_bend: float
    lamp_scale: float


@dataclass(frozen=True)
class _Measured:
    """The numbers that depend on the kind of volume; several are for tight and loose bounds.

    Attributes:
        samples_per_cell: at the default bound.
        blocks: pixels between nodes below the default bound, from it, and from four times it.
        wavelength_steps_nm: up to half the default bound, and above.
        fringes_missed: amplitude left of fringes that these do not follow, at the default bound;
            radii that vary along a ray blur them, too.
        row_steps: distances in ln(radius) below the default bound, and from it.
        rows_per_fold: at the default bound.
        lamp_block: pixels between nodes under a lamp.
        lamp_scale: factor of the steps in angle at the default bound.
    """

    samples_per_cell: float
    blocks: tuple[int, int, int]
    wavelength_steps_nm: tuple[float, float]
    fringes_missed: float
    row_steps: tuple[float, float]
    rows_per_fold: float
    lamp_block: int
    lamp_scale: float


# Each number was measured at the default bound by making all others finer
# (``python tools/fast_error.py``). In rough volumes drawn radii fill a ray's histogram unevenly,
# so that errors between rows do not cancel; but rows cost nothing, since no nodes keep weights of
# them.
_MEASURED: dict[Kind, _Measured] = {
    "alike": _Measured(0.75, (4, 8, 4), (1.0, 2.0), 0.03, (0.01, 0.015), 13.0, 4, 1.0),
    "smooth": _Measured(1.5, (2, 3, 4), (2.5, 5.0), 0.1, (0.01, 0.015), 13.0, 4, 1.0),
    "rough": _Measured(
        3.0, (0, 0, 0), (2.5, 5.0), 0.1, (0.01 * (1.0 / 3.0), 0.015 * (1.0 / 3.0)), 100.0, 0, 1.5
    ),
}


def settings_for(delta_e: float, kind: Kind) -> FastSettings:
    """Give settings that keep ΔE2000 within a bound at the 99th percentile of pixels.

    Args:
        delta_e: the bound.
        kind: of the volume.
    """
    measured = _MEASURED[kind]
    share = float(delta_e) / DEFAULT_DELTA_E  # comparisons below count, as NumPy's would not
    # Errors of counts are of second order in a step: half the error takes the root of two as many.
    finer = share**-0.5
    count = min(max(finer, 0.5), 2.5)
    texels = min(max(finer, 0.5), 2.0)
    # Tolerances are errors themselves.
    error = min(share, 4.0)
    return FastSettings(
        share=share,
        samples_per_cell=measured.samples_per_cell * count,
        samples_per_log_radius=24.0 * min(finer, 2.0),
        block=measured.blocks[(share >= 1.0) + (share >= 4.0)],
        bend=1.2e-2 * error,
        texels_per_fringe=6.0 * texels,
        texels_per_disc=14.0 * texels,
        wavelength_step_nm=measured.wavelength_steps_nm[share > 0.5],
        fringes_missed=measured.fringes_missed * error,
        row_step=measured.row_steps[share >= 1.0],
        rows_per_fold=measured.rows_per_fold * count,
        colour=1e-3 * error,
        lamp_block=measured.lamp_block,
        lamp_bend=4e-3 * error,
        lamp_scale=measured.lamp_scale * count,
    )


def hat_rows(spread: float, settings: FastSettings) -> float:
    """Give the rows per factor e of the radius that the drops of a ray are counted at.

    Between rows a straight line is fitted, whose error averages out over the radii that a ray
    meets: the wider they spread, the fewer rows suffice, down to what the finest fringes need.

    Args:
        spread: deviation of ln(radius) along a ray.
        settings: how coarse.
    """
    return settings.rows_per_fold * min(max(0.27 / max(spread, 1e-6), 1.0), 5.0)


def node_step_nm(settings: FastSettings, *, blurred: bool) -> float:
    """Give the step of wavelengths of cross-sections, which divides the visible evenly.

    Args:
        settings: how coarse.
        blurred: whether fringes are blurred already, by a mixture or the spread of exact theory.
    """
    step = settings.wavelength_step_nm
    return max(step, BLURRED_STEP_NM) if blurred else step
