"""The verb ``rtbow chart``: pictures of the scattering table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.cli.options import (
    Numbers,
    Option,
    Verb,
    progress_bar,
    quiet_option,
    two_sides,
)
from rtbow.physics.constants import SUN_DIAMETER_DEG

if TYPE_CHECKING:
    from rtbow.study.charts import (
        Component,
        Normalise,
        Scale,
        Setup,
    )

    _RasterType = click.ParamType[tuple[int, int]]
else:  # generic since click 8.4 alone
    _RasterType = click.ParamType


class _Raster(_RasterType):
    name = "RxA"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Parse ``300x400``."""
        sides = two_sides(value)
        if sides is None:
            self.fail(f"{value!r} is not a size; write radii and angles such as 300x400", param)
        return sides


def _setup(theory: str, disc: float, spread: float, temperature: float) -> Setup:
    from rtbow.study.charts import Setup

    theories = ("airy", "mie") if theory == "both" else (theory,)
    return Setup(theories, disc, spread, temperature)  # type: ignore[arg-type]


def _shared(theory: str) -> Option:
    """Add the options that every chart has."""
    options: list[Option] = [
        click.option("-o", "--output", required=True, metavar="OUT", help="Where: .png or .svg."),
        click.option(
            "--theory",
            type=click.Choice(["airy", "mie", "both"]),
            default=theory,
            show_default=True,
            help="Theory of the single drop.",
        ),
        click.option(
            "--disc",
            type=float,
            default=SUN_DIAMETER_DEG,
            show_default=True,
            metavar="DEG",
            help="Angular diameter of the light's disc, 0..5; 0 for a point.",
        ),
        click.option(
            "--spread",
            type=float,
            default=2.0,
            show_default=True,
            metavar="PERCENT",
            help="Standard deviation of ln(radius), 1..20 (mie).",
        ),
        click.option(
            "--temperature",
            type=float,
            default=20.0,
            show_default=True,
            metavar="C",
            help="Of the water, -12..60 degrees Celsius.",
        ),
        quiet_option,
    ]

    def add(verb: Verb) -> Verb:
        for option in reversed(options):
            verb = option(verb)
        return verb

    return add


@click.group()
def chart() -> None:
    """Draw the scattering table: .png or .svg.

    Example: rtbow chart lee -o lee.png
    """


@chart.command("profile")
@_shared("airy")
@click.option(
    "--radius-um",
    type=Numbers(),
    default=(500.0,),
    metavar="A,B,...",
    help="Drop radii, 1..5000; left out: 500.",
)
@click.option(
    "--wavelength-nm",
    type=Numbers(),
    default=(550.0,),
    metavar="A,B,...",
    help="Wavelengths, 380..780; left out: 550.",
)
@click.option(
    "--component",
    type=click.Choice(["mean", "perpendicular", "parallel"]),
    default="mean",
    show_default=True,
    help="Polarisation, against the scattering plane; mean: unpolarised light.",
)
@click.option(
    "--scale",
    type=click.Choice(["linear", "log"]),
    default="linear",
    show_default=True,
    help="Of the cross-section; linear draws a panel for each radius.",
)
@click.option("--difference", is_flag=True, help="Add a panel of Airy minus Mie.")
@click.option(
    "--from-deg",
    type=float,
    metavar="DEG",
    help="Least scattering angle; left out: 115 (linear) or 0 (log).",
)
@click.option(
    "--to-deg",
    type=float,
    default=180.0,
    show_default=True,
    metavar="DEG",
    help="Greatest scattering angle.",
)
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
    from rtbow.study.charts import (
        CHART_SUFFIXES,
        PROFILE_FROM_DEG,
        draw_profiles,
        profiles,
    )

    check_writable(output, CHART_SUFFIXES)
    if difference and theory != "both":
        raise InputError(
            f"--difference: Airy minus Mie needs both theories, not --theory {theory}; add"
            " --theory both"
        )
    angles = (PROFILE_FROM_DEG[scale] if from_deg is None else from_deg, to_deg)
    setup = _setup(theory, disc, spread, temperature)
    data = profiles(
        setup,
        radius_um,
        wavelength_nm,
        angles,
        component,
        progress_bar("building the table", quiet, "part"),
    )
    draw_profiles(Path(output), data, scale, difference)
    if not quiet:
        click.echo(output)


@chart.command("lee")
@_shared("both")
@click.option(
    "--radius-from",
    type=float,
    default=10.0,
    show_default=True,
    metavar="UM",
    help="Least radius, um.",
)
@click.option(
    "--radius-to",
    type=float,
    default=1000.0,
    show_default=True,
    metavar="UM",
    help="Greatest radius, um.",
)
@click.option(
    "--from-deg",
    type=float,
    default=135.0,
    show_default=True,
    metavar="DEG",
    help="Least scattering angle.",
)
@click.option(
    "--to-deg",
    type=float,
    default=147.0,
    show_default=True,
    metavar="DEG",
    help="Greatest scattering angle.",
)
@click.option(
    "--normalise",
    type=click.Choice(["column", "none"]),
    default="column",
    show_default=True,
    help="column: each radius to its greatest luminance; none: luminance per area of drop.",
)
@click.option(
    "--size",
    type=_Raster(),
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
    from rtbow.study.charts import CHART_SUFFIXES
    from rtbow.study.lee import draw_lee, lee_raster

    check_writable(output, CHART_SUFFIXES)
    setup = _setup(theory, disc, spread, temperature)
    radii, angles = (radius_from, radius_to), (from_deg, to_deg)
    data = lee_raster(setup, radii, angles, size, progress_bar("colours", quiet, "step"))
    draw_lee(Path(output), data, normalise)
    if not quiet:
        click.echo(output)
