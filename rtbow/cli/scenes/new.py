"""The verb ``rtbow new``: a scene file to begin with."""

from __future__ import annotations

import os
import shlex
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.base.errors import InputError
from rtbow.cli.options import sun_at, sun_option

if TYPE_CHECKING:
    from rtbow.scene.text.sun import SunAt

_MOST_MM_H = 1000.0
_PLACE = "48.1,11.6"


def rain_rate(value: Any) -> float:
    """Read a rain rate in mm/h."""
    try:
        rate = float(value)
    except ValueError:
        rate = 0.0
    if not 0.0 < rate <= _MOST_MM_H:  # NaN too
        raise click.BadParameter(
            f"{value!r} is not a rain rate; write a number of mm/h, greater than 0 and up to"
            f" {_MOST_MM_H:g}, such as 5"
        )
    return rate


@click.command()
@click.argument("file", metavar="NAME.toml", type=click.Path())
@sun_option
@click.option(
    "--rain",
    type=rain_rate,
    metavar="MM_PER_H",
    help="Rain rate; below 1 drizzle of small drops, from 1 on rain of all sizes; left out: 5.",
)
@click.option(
    "--lamp",
    metavar="SPECTRUM",
    help="A street lamp instead of the sun, by its spectrum, such as LED-B3, HP1 or lamp.csv.",
)
@click.option("--overwrite", is_flag=True, help="Replace a file of this name.")
def new(
    file: str, sun: SunAt | None, rain: float | None, lamp: str | None, overwrite: bool
) -> None:
    """Write a scene file to begin with, and print the command that renders it.

    It has a bow in the middle of the picture, rain all around the camera, and comments. Without
    --sun, --rain and --lamp, a terminal is asked for place, time and rain.

    Example: rtbow new bow.toml --sun 59.9,10.7,2026-07-01T19:30+02:00 --rain 5
    """  # fmt: skip
    from rtbow.base.files import check_writable, write_atomic
    from rtbow.scene.starter import RAIN_MM_H, starter_text
    from rtbow.scene.text.file import scene_from_text
    from rtbow.world.lights import light_notes
    from rtbow.world.visibility import horizon_notes, sun_notes

    check_writable(file, (".toml",))
    if os.path.lexists(file) and not overwrite:
        raise InputError(f"{file}: exists; choose another name, or add --overwrite")
    if lamp is not None and sun is not None:
        raise InputError("--lamp takes the sun's place, and --sun needs one; leave one of them out")
    if sun is None and rain is None and lamp is None and _asks():
        sun, rain = _asked_sun(), _asked_rain(RAIN_MM_H)
    folder = Path(file).absolute().parent
    spectrum = None if lamp is None else _from_folder(lamp, folder)
    text = starter_text(RAIN_MM_H if rain is None else rain, sun, spectrum)
    scene = scene_from_text(text, file, folder)
    notes = (*sun_notes(scene), *horizon_notes(scene), *light_notes(scene))
    write_atomic(file, text.encode())
    click.echo(file)
    name = file if not file.startswith("-") else f"./{file}"
    click.echo(shlex.join(["rtbow", "render", name, "-o", str(Path(name).with_suffix(".png"))]))
    for note in notes:
        click.echo(f"note: {note}", err=True)


def _from_folder(spectrum: str, folder: Path) -> str:
    """Give a light's spectrum as a file in a folder names it."""
    from rtbow.base.files import absolute
    from rtbow.scene.lights import spectrum_file

    if not spectrum_file(spectrum):
        return spectrum
    path = Path(absolute(spectrum))
    return path.relative_to(folder).as_posix() if folder in path.parents else str(path)


def _asks() -> bool:
    """Whether there is somebody to be asked."""
    return sys.stdin is not None and sys.stdin.isatty()


def _asked_sun() -> SunAt:
    now = datetime.now().astimezone().isoformat(timespec="minutes")
    place = click.prompt(
        "Latitude and longitude in degrees, north and east positive",
        default=_PLACE,
        value_proc=lambda text: _place(text, now),
        err=True,
    )
    sun: SunAt = click.prompt(
        "Date and time there, with its offset from UTC",
        default=now,
        value_proc=lambda text: sun_at(f"{place},{text}"),
        err=True,
    )
    return sun


def _place(text: str, now: str) -> str:
    sun_at(f"{text},{now}")  # says what is wrong with it
    return text


def _asked_rain(rate: float) -> float:
    asked: float = click.prompt("Rain in mm/h", default=rate, value_proc=rain_rate, err=True)
    return asked
