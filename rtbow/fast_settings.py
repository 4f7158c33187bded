"""How coarse method ``fast`` may be for a colour difference that the user can bear."""

from __future__ import annotations

from dataclasses import dataclass

from rtbow.constants import DEFAULT_DELTA_E


@dataclass(frozen=True)
class FastSettings:
    """What each approximation of method ``fast`` is allowed.

    Attributes:
        samples_per_cell: midpoint samples per grid cell.
        block: pixels between the nodes at which a path is gathered; 0: at every pixel.
        bend: share by which a straight line between nodes may miss a path's weight.
        texels_per_disc: texels of the colour table within the light's angular radius.
        wavelength_step_nm: between the wavelengths at which cross-sections are taken; spectra are
            integrated at 1 nm.
        row_step: distance of the table's rows in ln(radius).
        colour: relative error left to the fit of the air's colours.
        hat_scale: factor of the rows of radius that a ray's drops are counted at.
        samples_per_log_radius: further samples per cell and per change of ln(radius).
        lamp_scale: factor of the steps in angle along a ray that a lamp lights.
    """

    samples_per_cell: float
    block: int
    bend: float
    texels_per_disc: float
    wavelength_step_nm: float
    row_step: float
    colour: float
    hat_scale: float
    samples_per_log_radius: float
    lamp_scale: float


def settings_for(delta_e: float) -> FastSettings:
    """Give settings that keep ΔE2000 within a bound at the 99th percentile of pixels.

    Args:
        delta_e: the bound, ``LEAST_DELTA_E`` or more.
    """
    # Shares of the error: each part was measured on its own (docs/performance.md).
    share = delta_e / DEFAULT_DELTA_E
    tight = delta_e < 0.25
    return FastSettings(
        samples_per_cell=min(max(0.75 * share**-0.5, 0.35), 1.5),
        block=2 if tight else (4 if delta_e < 1.5 else 8),
        bend=min(6e-3 * share, 0.03),
        texels_per_disc=min(max(6.0 * share**-0.5, 3.0), 10.0),
        wavelength_step_nm=2.0 if tight else 5.0,
        row_step=min(max(0.02 * share**0.5, 0.01), 0.03),
        colour=min(1e-3 * share, 5e-3),
        hat_scale=min(max(share**-0.5, 0.5), 2.0),
        samples_per_log_radius=3.0 * share**-0.5,
        lamp_scale=min(max(0.75 * share**-0.5, 0.35), 1.5),
    )


def hat_rows(spread: float, settings: FastSettings) -> float:
    """Give the rows per factor e of the radius that the drops of a ray are counted at.

    Between rows a straight line is fitted, whose error averages out over the radii that a ray
    meets: the wider they spread, the fewer rows suffice, down to what the finest fringes need.

    Args:
        spread: deviation of ln(radius) along a ray.
        settings: how coarse.
    """
    return settings.hat_scale * min(max(3.0 / max(spread, 1e-6), 11.0), 60.0)
