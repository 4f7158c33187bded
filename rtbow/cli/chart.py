"""The verb ``rtbow chart``: charts of the scattering tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.cli.options import (
    Option,
    choice_option,
    disc_option,
    grouped,
    number_option,
    numbers_option,
    progress_bar,
    quiet_option,
    spread_option,
    two_sides,
)

if TYPE_CHECKING:
    from rtbow.study.charts import Component, Scale, Setup
    from rtbow.study.lee import Normalise


def _raster_size(value: Any) -> tuple[int, int]:
    """Read ``300x400``."""
    sides = two_sides(value)
    if sides is None:
        raise click.BadParameter(f"{value!r} is not a size; write radii and angles such as 300x400")
    return sides


def _setup(theory: str, disc: float, spread: float, temperature: float) -> Setup:
    from rtbow.study.charts import Setup

    theories = ("airy", "mie") if theory == "both" else (theory,)
    return Setup(theories, disc, spread, temperature)  # type: ignore[arg-type]


def _shared(theory: str) -> Option:
    """Add the options that every chart has."""
    return grouped(
        click.option(
            "-o", "--output", required=True, metavar="OUT", help="File to write: .png or .svg."
        ),
        choice_option("--theory", ("airy", "mie", "both"), "Theory of the single drop.", theory),
        disc_option,
        spread_option,
        number_option(
            "--temperature", 20.0, "C", "Temperature of the water, -12..60 degrees Celsius."
        ),
        quiet_option,
    )


@click.group()
def chart() -> None:
    """Draw the scattering tables: .png or .svg.

    Example: rtbow chart lee -o lee.png
    """


@chart.command("profile")
@_shared("airy")
@numbers_option("--radius-um", (500.0,), "Drop radii, 1..5000; left out: 500.")
@numbers_option("--wavelength-nm", (550.0,), "Wavelengths, 380..780; left out: 550.")
@choice_option(
    "--component",
    ("mean", "perpendicular", "parallel"),
    "Polarisation, against the scattering plane; mean: unpolarised light.",
)
@choice_option(
    "--scale",
    ("linear", "log"),
    "Scale of the cross-section; linear draws a panel for each radius.",
)
@click.option("--difference", is_flag=True, help="Add a panel of Airy minus Mie.")
@number_option(
    "--from-deg", None, "DEG", "Least scattering angle; left out: 115 (linear) or 0 (log)."
)
@number_option("--to-deg", 180.0, "DEG", "Greatest scattering angle.")
def chart_profile(
    output: str,
    theory: str,
    disc: float,
    spread: float,
    temperature: float,
    quiet: bool,
    radius_um: tuple[float, ...],
    wavelength_nm: tuple[float, ...],
    component: Component,
    scale: Scale,
    difference: bool,
    from_deg: float | None,
    to_deg: float,
) -> None:
    """Draw the differential cross-section against the angle.

    Example: rtbow chart profile -o bow.svg --radius-um 100,500 --theory both --difference
    """  # fmt: skip
    from rtbow.base.errors import InputError
    from rtbow.base.files import check_writable
    from rtbow.frames.plot import PLOT_SUFFIXES
    from rtbow.study.charts import PROFILE_FROM_DEG, draw_profiles, profiles

    check_writable(output, PLOT_SUFFIXES)
    if difference and theory != "both":
        raise InputError(
            f"--difference: Airy minus Mie needs both theories, not --theory {theory}; add"
            " --theory both"
        )
    angles = (PROFILE_FROM_DEG[scale] if from_deg is None else from_deg, to_deg)
    setup = _setup(theory, disc, spread, temperature)
    progress = progress_bar("building the table", quiet, "part")
    data = profiles(setup, radius_um, wavelength_nm, angles, component, progress)
    draw_profiles(Path(output), data, scale, difference)
    if not quiet:
        click.echo(output)


@chart.command("lee")
@_shared("both")
@number_option("--radius-from", 10.0, "UM", "Least radius, um.")
@number_option("--radius-to", 1000.0, "UM", "Greatest radius, um.")
@number_option("--from-deg", 135.0, "DEG", "Least scattering angle.")
@number_option("--to-deg", 147.0, "DEG", "Greatest scattering angle.")
@choice_option(
    "--normalise",
    ("column", "none"),
    "column: each radius to its greatest luminance; none: luminance per area of drop.",
)
@click.option(
    "--size",
    type=_raster_size,
    default=(300, 400),
    metavar="RxA",
    help="Radii and angles of the raster; left out: 300x400.",
)
def chart_lee(
    output: str,
    theory: str,
    disc: float,
    spread: float,
    temperature: float,
    quiet: bool,
    radius_from: float,
    radius_to: float,
    from_deg: float,
    to_deg: float,
    normalise: Normalise,
    size: tuple[int, int],
) -> None:
    """Draw Lee diagrams: the colours of the bow over the radius of the drops.

    Example: rtbow chart lee -o lee.png --theory both --radius-from 5
    """  # fmt: skip
    from rtbow.base.files import check_writable
    from rtbow.frames.plot import PLOT_SUFFIXES
    from rtbow.study.lee import draw_lee, lee_raster

    check_writable(output, PLOT_SUFFIXES)
    setup = _setup(theory, disc, spread, temperature)
    radii, angles = (radius_from, radius_to), (from_deg, to_deg)
    data = lee_raster(setup, radii, angles, size, progress_bar("colours", quiet, "step"))
    draw_lee(Path(output), data, normalise)
    if not quiet:
        click.echo(output)
