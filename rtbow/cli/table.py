"""``rtbow table``: the scattering table, built, inspected and exported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from rtbow.base.errors import InputError
from rtbow.base.limits import TABLE_RADII_UM
from rtbow.cli.options import (
    SPREAD_PERCENT,
    WholeNumber,
    choice_option,
    disc_option,
    number_option,
    numbers_option,
    progress_bar,
    quiet_option,
    spread_option,
)

if TYPE_CHECKING:
    from rtbow.tables.sections import Theory

_SUFFIXES = {"arrays": (".npz", ".exr"), "mitsuba": (".xml", ".txt"), "texture": (".exr",)}
_COLUMNS = 2001


@click.group()
def table() -> None:
    """Build, inspect and export the scattering table.

    Example: rtbow table export airy.npz --radius-um 100,500
    """


@table.command("build")
@choice_option(
    "--theory", ("airy", "mie"), "mie: exact, minutes; the one that ships needs no build."
)
@spread_option
@number_option("--max-radius-um", TABLE_RADII_UM[1], "UM", "Largest drop (mie).")
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
    """Build a table, store it in the cache and show how long it took.

    An interrupted build continues where it stopped.

    Example: rtbow table build --theory mie
    """  # fmt: skip
    from rtbow.tables.report import describe_build, describe_mie_build

    if theory == "airy":
        defaults = (SPREAD_PERCENT, TABLE_RADII_UM[1], None, None)
        if (spread, max_radius_um, workers, scheduler) != defaults:
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
@click.option(
    "--for",
    "purpose",
    type=click.Choice(tuple(_SUFFIXES)),
    default="arrays",
    show_default=True,
    help="arrays: .npz or .exr; mitsuba: a phase function, .xml or .txt; texture: colours, .exr.",
)
@choice_option("--theory", ("airy", "mie"), "Theory of the single drop.")
@disc_option
@spread_option
@numbers_option("--radius-um", None, "Drop radii; left out: 64 from 10 to 1500.")
@numbers_option("--wavelength-nm", None, "Wavelengths; left out: 380 to 780 by 5.")
@click.option(
    "--angles",
    type=WholeNumber(2, 1_000_000),
    metavar="N",
    help="Even steps from 0 to 180 degrees; left out: angles that follow peak and bows (.npz), 2001"
    " (.exr), 20001 steps of the cosine (mitsuba), 4000 cells (texture).",
)
@click.option(
    "--spectrum", metavar="NAME", help="The light of a texture: a name or a file; left out: E490."
)
@click.option(
    "--beyond",
    type=click.Choice(("zero", "hold")),
    help="What a spectrum's file that ends within 380-780 nm has beyond; left out: it is refused.",
)
@quiet_option
def table_export(
    output: str,
    purpose: Literal["arrays", "mitsuba", "texture"],
    theory: Theory,
    disc: float,
    spread: float,
    radius_um: tuple[float, ...] | None,
    wavelength_nm: tuple[float, ...] | None,
    angles: int | None,
    spectrum: str | None,
    beyond: Literal["zero", "hold"] | None,
    quiet: bool,
) -> None:
    """Write the scattering of drops for other programs.

    Plain arrays hold radius x wavelength x angle. Phase functions keep the forward peak's share
    however coarse their steps are; those for Mitsuba have one radius and one wavelength.

    \b
    Examples:
      rtbow table export airy.npz --radius-um 100,500 --disc 0
      rtbow table export drops.xml --for mitsuba --theory mie --radius-um 500 --wavelength-nm 550
      rtbow table export drops.exr --for texture --theory mie
    """  # fmt: skip
    from rtbow.base.files import check_writable

    check_writable(output, _SUFFIXES[purpose])
    from rtbow.tables.export import (
        PlainTable,
        default_radii_um,
        default_wavelengths_nm,
        export_table,
    )

    if theory == "airy" and spread != SPREAD_PERCENT:
        raise InputError("--spread goes with --theory mie: Airy's table has none; add it")
    if spectrum is not None and purpose != "texture":
        raise InputError("--spectrum goes with --for texture: the others have no colour; add it")
    if beyond is not None and spectrum is None:
        raise InputError("--beyond goes with --spectrum and its file; add it, or leave it out")
    if purpose == "arrays" and angles is None and output.lower().endswith(".exr"):
        angles = _COLUMNS
    wanted = PlainTable(
        theory,
        default_radii_um() if radius_um is None else radius_um,
        default_wavelengths_nm() if wavelength_nm is None else wavelength_nm,
        angles,
        disc,
        round(spread / 100.0, 9),
    )
    progress = progress_bar("exporting", quiet, "radius")
    building = progress_bar("building the table", quiet, "part")
    if purpose == "mitsuba":
        from rtbow.tables.exchange import write_mitsuba

        write_mitsuba(Path(output), wanted, building)
    elif purpose == "texture":
        from rtbow.scene.lights import E490
        from rtbow.tables.exchange import write_texture
        from rtbow.world.measured.spectra import load_spectrum

        light = load_spectrum(spectrum or E490, beyond)
        write_texture(Path(output), wanted, light, progress, building)
    else:
        export_table(Path(output), wanted, progress, building)
    if not quiet:
        click.echo(output)
