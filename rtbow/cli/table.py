"""``rtbow table``: the scattering table, built, inspected and exported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtbow.base.errors import InputError
from rtbow.cli.options import (
    Numbers,
    WholeNumber,
    progress_bar,
    quiet_option,
)
from rtbow.physics.constants import SUN_DIAMETER_DEG

if TYPE_CHECKING:
    from rtbow.tables.sections import Theory


@click.group()
def table() -> None:
    """Build, inspect and export the scattering table.

    Example: rtbow table export airy.npz --radius-um 100,500
    """


@table.command("build")
@click.option(
    "--theory",
    type=click.Choice(["airy", "mie"]),
    default="airy",
    show_default=True,
    help="mie: exact, minutes; the one that ships needs no build.",
)
@click.option(
    "--spread",
    type=float,
    default=2.0,
    show_default=True,
    metavar="PERCENT",
    help="Spread of sizes about each radius (mie).",
)
@click.option(
    "--max-radius-um",
    type=float,
    default=1500.0,
    show_default=True,
    metavar="UM",
    help="Largest drop (mie).",
)
@click.option(
    "--workers", type=WholeNumber(1, 1024), metavar="N", help="Processes; left out: one per core."
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="A Dask scheduler to build on, such as tcp://host:8786."
)
@quiet_option
def table_build(
    theory: str,
    spread: float,
    max_radius_um: float,
    workers: int | None,
    scheduler: str | None,
    quiet: bool,
) -> None:
    """Build a table, store it in the cache and say how long it took.

    What is finished stays: an interrupted build goes on where it was.

    Example: rtbow table build --theory mie
    """  # fmt: skip
    from rtbow.tables.report import describe_build, describe_mie_build

    if theory == "airy":
        if (spread, max_radius_um, workers, scheduler) != (2.0, 1500.0, None, None):
            raise InputError(
                "--spread, --max-radius-um, --workers and --scheduler go with --theory mie; add it"
            )
        text = describe_build()
    else:
        text = describe_mie_build(
            spread, max_radius_um, progress_bar("building", quiet, "part"), workers, scheduler
        )
    if not quiet:
        click.echo(text)


@table.command("info")
@click.option(
    "--samples",
    type=WholeNumber(100, 1_000_000),
    default=4000,
    show_default=True,
    metavar="N",
    help="Random look-ups to compare with direct evaluation, per disc.",
)
def table_info(samples: int) -> None:
    """Show the table's arrays and its measured look-up error.

    Example: rtbow table info
    """  # fmt: skip
    from rtbow.tables.report import describe_table

    for line in describe_table(samples):
        click.echo(line)


@table.command("export")
@click.argument("output")
@click.option("--theory", type=click.Choice(["airy", "mie"]), default="airy", show_default=True)
@click.option(
    "--disc",
    "disc_deg",
    type=float,
    default=SUN_DIAMETER_DEG,
    show_default=True,
    metavar="DEG",
    help="Angular diameter of the light's disc; 0 for a point.",
)
@click.option(
    "--spread",
    type=float,
    default=2.0,
    show_default=True,
    metavar="PERCENT",
    help="Spread of sizes about each radius (mie).",
)
@click.option(
    "--radius-um",
    type=Numbers(),
    metavar="A,B,...",
    help="Drop radii; left out: 64 from 10 to 1500.",
)
@click.option(
    "--wavelength-nm",
    type=Numbers(),
    metavar="A,B,...",
    help="Wavelengths; left out: 380 to 780 by 5.",
)
@click.option(
    "--angles",
    type=WholeNumber(2, 1_000_000),
    default=2001,
    show_default=True,
    metavar="N",
    help="Scattering angles from 0 to 180 degrees.",
)
@quiet_option
def table_export(
    output: str,
    theory: Theory,
    disc_deg: float,
    spread: float,
    radius_um: tuple[float, ...] | None,
    wavelength_nm: tuple[float, ...] | None,
    angles: int,
    quiet: bool,
) -> None:
    """Write the plain table (radius x wavelength x angle) for other programs: .npz or .exr.

    Example: rtbow table export airy.npz --radius-um 100,500 --disc 0
    """  # fmt: skip
    from rtbow.base.files import check_writable

    check_writable(output, (".npz", ".exr"))
    from rtbow.tables.export import (
        PlainTable,
        default_radii_um,
        default_wavelengths_nm,
        export_table,
    )

    if theory == "airy" and spread != 2.0:
        raise InputError("--spread goes with --theory mie: Airy's table has none; add it")
    wanted = PlainTable(
        theory,
        default_radii_um() if radius_um is None else radius_um,
        default_wavelengths_nm() if wavelength_nm is None else wavelength_nm,
        angles,
        disc_deg,
        round(spread / 100.0, 9),
    )
    export_table(
        Path(output),
        wanted,
        progress_bar("exporting", quiet, "radius"),
        progress_bar("building the table", quiet, "part"),
    )
    if not quiet:
        click.echo(output)
