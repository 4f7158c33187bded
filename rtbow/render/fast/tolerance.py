"""How coarse method ``fast`` may be for a colour difference that the user can bear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rtbow.base.limits import DEFAULT_DELTA_E

Kind = Literal["alike", "smooth", "rough"]
"""Whether drops are of one radius (or mixture), of radii that vary slowly over the grid's cells, or
of radii that differ from each grid point to the next."""

ROUGH = 0.05
"""Mean change of ln(radius) between neighbouring grid points from which a volume is rough."""


BLURRED_STEP_NM = 5.0
"""Step of wavelengths that suffices for sizes mixed within 2 % or more: that blurs their fringes by
more than neighbouring wavelengths differ."""


@dataclass(frozen=True)
class FastSettings:
    """What each approximation of method ``fast`` is allowed.

    Attributes:
        share: the error allowed over the default one.
        samples_per_cell: midpoint samples per grid cell.
        samples_per_log_radius: further ones per cell and change of ln(radius) between its points.
        block: pixels between the nodes at which a path is gathered; 0: at every pixel.
        bend: share by which a straight line between nodes may miss a path's weight.
        texels_per_disc: texels of the colour table within the light's angular radius.
        texels_per_fringe: texels within a bow's width, for lights without a disc.
        wavelength_step_nm: between the wavelengths at which cross-sections are taken; spectra are
            integrated at 1 nm. Fringes of one radius want it fine.
        row_step: distance in ln(radius) of the radii of cross-sections.
        rows_per_fold: rows of radius per factor e, in a volume whose radii vary along a ray by that
            factor; more where they vary less (:func:`hat_rows`).
        colour: relative error left to the fit of the air's colours.
        lamp_block: pixels between nodes under a lamp.
        lamp_bend: share of the light by which a straight line between these may miss.
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
    row_step: float
    rows_per_fold: float
    colour: float
    lamp_block: int
    lamp_bend: float
    lamp_scale: float


def settings_for(delta_e: float, kind: Kind) -> FastSettings:
    """Give settings that keep ΔE2000 within a bound at the 99th percentile of pixels.

    Each number was measured at the default bound by making all others finer
    (``python tools/fast_error.py``); others scale from there as their errors do.

    Args:
        delta_e: the bound.
        kind: of the volume.
    """
    share = delta_e / DEFAULT_DELTA_E
    # Errors of second order in a step: half the error takes the root of two as many.
    finer = share**-0.5
    samples = {"alike": 0.75, "smooth": 1.5, "rough": 3.0}[kind]
    blocks = {"alike": (4, 8), "smooth": (2, 3), "rough": (0, 0)}[kind]
    tight = share <= 0.5
    return FastSettings(
        share=share,
        samples_per_cell=samples * min(max(finer, 0.5), 2.5),
        samples_per_log_radius=24.0 * min(finer, 2.0),
        block=blocks[0] if share < 1.0 else (blocks[1] if share < 4.0 else 4 * (kind != "rough")),
        bend=1.2e-2 * min(share, 4.0),
        texels_per_fringe=6.0 * min(max(finer, 0.5), 2.0),
        texels_per_disc=14.0 * min(max(finer, 0.5), 2.0),
        wavelength_step_nm=(1.0 if tight else 2.0) if kind == "alike" else (2.5 if tight else 5.0),
        # Drawn radii fill a ray's histogram unevenly, so that errors between rows do not cancel.
        row_step=(0.015 if share >= 1.0 else 0.01) * (1.0 / 3.0 if kind == "rough" else 1.0),
        # Where no nodes keep weights of rows, rows cost nothing.
        rows_per_fold=(100.0 if kind == "rough" else 13.0) * min(max(finer, 0.5), 2.5),
        colour=1e-3 * min(share, 4.0),
        lamp_block=0 if kind == "rough" else 4,
        lamp_bend=4e-3 * min(share, 4.0),
        lamp_scale=(1.5 if kind == "rough" else 1.0) * min(max(finer, 0.5), 2.5),
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
