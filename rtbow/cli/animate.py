"""The verb ``rtbow animate``: frames and films of a scene, some keys of which move."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

import click

from rtbow.base.errors import InputError
from rtbow.cli.options import (
    Drawing,
    WholeNumber,
    drawing_options,
    progress_bar,
    quiet_option,
    scene_argument,
)

if TYPE_CHECKING:
    from rtbow.physics.light.sun_position import SunPosition
    from rtbow.render.renderer import MethodName
    from rtbow.sequence.run import Report


@dataclass(frozen=True)
class _Day:
    """A place and a date, with the text that was typed."""

    text: str
    latitude_deg: float
    longitude_deg: float
    day: date

    def positions(self, count: int) -> tuple[SunPosition, ...]:
        from rtbow.physics.light.sun_position import sun_path

        try:
            return sun_path(self.latitude_deg, self.longitude_deg, self.day, count)
        except InputError as error:
            raise InputError(f"--sun-path {self.text}: {error}") from None


def _place_and_date(value: str) -> _Day:
    """Read ``48.1,11.6,2024-12-21``."""
    try:
        latitude, longitude, day = value.split(",")
        return _Day(value, float(latitude), float(longitude), date.fromisoformat(day.strip()))
    except ValueError:
        raise click.BadParameter(
            f"{value!r} is not a place and a date; write latitude, longitude (degrees, north"
            " and east positive) and date, such as 48.1,11.6,2024-12-21"
        ) from None


@click.command()
@scene_argument
@click.option(
    "--key",
    "keys",
    multiple=True,
    metavar="KEY.PATH=FROM:TO",
    help="Move a number of the scene evenly, such as light.0.altitude_deg=2:40. May be repeated.",
)
@click.option(
    "--sun-path",
    type=_place_and_date,
    metavar="LAT,LON,DATE",
    help="Move light 0, a sun, from sunrise to sunset of a date and place (degrees, north and east"
    " positive), such as 48.1,11.6,2024-12-21; from midnight to midnight where it does not set.",
)
@click.option(
    "--frames",
    "count",
    type=WholeNumber(1, 100_000),
    required=True,
    metavar="N",
    help="Number of frames.",
)
@click.option(
    "-o",
    "--output",
    "outputs",
    multiple=True,
    required=True,
    metavar="OUT",
    help="Frames, such as out/frame_%04d.exr (linear radiance) or .png, numbered from 0; or a film:"
    " .mp4. May be repeated.",
)
@click.option(
    "--overwrite",
    is_flag=True,
    help="Replace files in the way, even if rtbow animate did not write them.",
)
@click.option("--fps", type=float, metavar="FPS", help="Pictures a second of a film; left out: 30.")
@drawing_options(
    size="Width and height in pixels, such as 640x360.",
    example="droplets.extinction=true",
    exposure="Exposure of .png and .mp4: auto, one for all frames by the brightest of the first,"
    " middle and last; or an EV at ISO 100.",
)
@quiet_option
def animate(
    scene: str | None,
    keys: tuple[str, ...],
    sun_path: _Day | None,
    count: int,
    outputs: tuple[str, ...],
    overwrite: bool,
    fps: float | None,
    drawing: Drawing,
    quiet: bool,
) -> None:
    """Render a sequence of frames, or a film, while keys of the scene move.

    Frames that an earlier run made of the same scene are kept, so that an interrupted run goes on
    where it stopped; NAME.sequence.json beside them lists those that are done. Frames of other
    sequences are replaced. A film is always written anew, from the frames if they are kept.

    Example: rtbow animate --key light.0.altitude_deg=0:40 --frames 120 -o rise_%04d.png -o rise.mp4
    """  # fmt: skip
    if not keys and sun_path is None:
        raise InputError(
            "nothing moves; add --key, such as --key light.0.altitude_deg=2:40, or --sun-path"
        )
    overrides = drawing.overrides()
    from rtbow.frames.film import DEFAULT_FPS, check_fps
    from rtbow.sequence import run as sequence
    from rtbow.sequence.animation import parse_move, plan_animation
    from rtbow.sequence.outputs import frames_beyond, parse_outputs

    moves = [parse_move(text) for text in keys]
    wanted = parse_outputs(outputs)
    if fps is not None:
        check_fps(fps)
        if not wanted.films:
            raise InputError(f"--fps {fps:g} goes with a film; add one, such as -o film.mp4")
    positions = () if sun_path is None else sun_path.positions(count)
    animation = plan_animation(scene, overrides, count, moves, positions)
    report = sequence.animate(
        animation,
        wanted,
        method=drawing.method,
        backend=drawing.backend,
        exposure_ev=drawing.exposure,
        fps=DEFAULT_FPS if fps is None else fps,
        overwrite=overwrite,
        command=shlex.join(["rtbow", *sys.argv[1:]]),
        show=lambda label, unit: progress_bar(label, quiet, unit),
    )
    if not quiet:
        for output in outputs:
            click.echo(output)
        for note in report.notes:
            click.echo(f"note: {note}", err=True)
        click.echo(_summary(report, drawing.method), err=True)  # apart from the names, for scripts
        left = frames_beyond(wanted, count)
        if left:
            click.echo(_left_over(left), err=True)


def _summary(report: Report, method: MethodName) -> str:
    """Say how many frames were drawn, and how many kept."""
    drawn = f"{report.drawn} frame{'' if report.drawn == 1 else 's'} drawn"
    if method == "auto" and report.methods:
        drawn += f" by method {', '.join(report.methods)}"
    return drawn + (f", {report.kept} kept" if report.kept else "")


def _left_over(paths: list[str]) -> str:
    """Name the frames that lie beyond the last, as a longer sequence leaves them."""
    more = len(paths) - 1
    which = f"{paths[0]} and {more} more lie" if more else f"{paths[0]} lies"
    them = "them if they do" if more else "it if it does"
    return f"{which} beyond the last frame of this run; remove {them} not belong to it"
