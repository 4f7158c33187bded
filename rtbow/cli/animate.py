"""The verb ``rtbow animate``: frames and films of a scene, some keys of which move."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime
from typing import TYPE_CHECKING, Any, TypeVar

import click

from rtbow.base.errors import InputError, cut
from rtbow.cli.options import (
    Drawing,
    drawing_options,
    number,
    progress_bar,
    quiet_option,
    scene_argument,
)

if TYPE_CHECKING:
    from rtbow.physics.light.sun_position import SunPosition
    from rtbow.render.renderer import MethodName
    from rtbow.sequence.run import Report


MOST_FRAMES = 100_000


@dataclass(frozen=True)
class _Path:
    """A place and perhaps a date, with the text that was typed."""

    text: str
    latitude_deg: float
    longitude_deg: float
    day: date | None

    def positions(
        self, count: int, hours: tuple[datetime | None, datetime | None]
    ) -> tuple[SunPosition, ...]:
        """Give where the sun is seen in each frame: along the day, or between two times."""
        from rtbow.physics.light.sun_position import sun_between, sun_path

        start, end = hours
        place = self.latitude_deg, self.longitude_deg
        if self.day is not None:
            if start is not None or end is not None:
                raise InputError(
                    f"--sun-path {self.text}: has a date, whose whole day the sun takes; leave it"
                    " out, or --from and --to"
                )
            return self._named(lambda day: sun_path(*place, day, count), self.day)
        if start is None or end is None:
            raise InputError(
                f"--sun-path {self.text}: is not {_A_DAY}; or add --from and --to with two times,"
                " such as 2024-12-21T14:00+01:00"
            )
        if end <= start:
            raise InputError(
                f"--to {end.isoformat()}: must be later than --from {start.isoformat()}"
            )
        return self._named(lambda ends: sun_between(*place, *ends, count), (start, end))

    def _named(
        self, path: Callable[[_Times], tuple[SunPosition, ...]], times: _Times
    ) -> tuple[SunPosition, ...]:
        try:
            return path(times)
        except InputError as error:
            raise InputError(f"--sun-path {self.text}: {error}") from None


_Times = TypeVar("_Times")
_A_DAY = (
    "a place and a date; write latitude, longitude (degrees, north and east positive) and date,"
    " such as 48.1,11.6,2024-12-21"
)


def _place_and_date(value: str) -> _Path:
    """Read ``48.1,11.6,2024-12-21``, or the place alone."""
    try:
        latitude, longitude, *days = value.split(",")
        if len(days) > 1:
            raise ValueError
        day = date.fromisoformat(days[0].strip()) if days else None
        return _Path(value, float(latitude), float(longitude), day)
    except ValueError:
        raise click.BadParameter(f"{value!r} is not {_A_DAY}") from None


def _moment(value: Any) -> datetime:
    """Read a date and time; without an offset from UTC it is in UTC."""
    from rtbow.scene.text.sun import moment

    try:
        return moment(value)
    except InputError as error:
        raise click.BadParameter(str(error)) from None


def _frame_count(value: str) -> int | float:
    """Read a number of frames, or seconds, such as ``4s``, which stay a float."""
    text = str(value).strip()
    seconds = text.removesuffix("s")
    try:
        if seconds == text:
            if 1 <= (count := int(text)) <= MOST_FRAMES:
                return count
        elif math.isfinite(time := float(seconds)) and time > 0.0:
            return time
    except ValueError:
        pass
    raise click.BadParameter(
        f"{cut(repr(text))} is no number of frames; write a whole number, 1..{MOST_FRAMES}, such as"
        " 120, or seconds, such as 4s"
    )


def _counted(count: int | float, fps: float | None, film: bool) -> int:
    """Give the number of frames that seconds take; a number of frames stays as it is.

    Args:
        count: as :func:`_frame_count` reads it.
        fps: pictures a second, if they were given.
        film: whether a film is written, which has some rate in any case.
    """
    if isinstance(count, int):
        return count
    from rtbow.frames.film import DEFAULT_FPS

    if fps is None and not film:
        raise InputError(f"--frames {count:g}s: of how many a second? Add --fps, such as --fps 25")
    rate = DEFAULT_FPS if fps is None else fps
    frames = round(count * rate) if count * rate <= 2 * MOST_FRAMES else 2 * MOST_FRAMES
    if not 1 <= frames <= MOST_FRAMES:
        raise InputError(
            f"--frames {count:g}s: at {rate:g} a second; must be 1..{MOST_FRAMES} frames, which"
            f" take {1.0 / rate:.3g}..{MOST_FRAMES / rate:.3g} s"
        )
    return frames


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
    metavar="LAT,LON[,DATE]",
    help="Move light 0, a sun, from sunrise to sunset of a date and place (degrees, north and east"
    " positive), such as 48.1,11.6,2024-12-21; from midnight to midnight where it does not set."
    " Without a date, from --from to --to.",
)
@click.option(
    "--from",
    "start",
    type=_moment,
    metavar="TIME",
    help="First time of --sun-path LAT,LON, such as 2024-12-21T14:00+01:00; without +01:00 in UTC.",
)
@click.option("--to", "end", type=_moment, metavar="TIME", help="Last time of --sun-path LAT,LON.")
@click.option(
    "--frames",
    "count",
    type=_frame_count,
    required=True,
    metavar="N|SECONDSs",
    help="Number of frames, such as 120; or seconds, such as 4s, with --fps or a film.",
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
@click.option(
    "--fps",
    type=number,
    metavar="FPS",
    help="Pictures a second; left out: 30 in a film.",
)
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
    sun_path: _Path | None,
    start: datetime | None,
    end: datetime | None,
    count: int | float,
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
    if sun_path is None and (start is not None or end is not None):
        raise InputError("--from and --to go with --sun-path LAT,LON; add it")
    if sun_path is not None and drawing.sun is not None:
        raise InputError("--sun-path moves the sun, and --sun places it; leave one of the two out")
    overrides = drawing.placed(scene)
    from rtbow.frames.film import DEFAULT_FPS, check_fps
    from rtbow.sequence import run as sequence
    from rtbow.sequence.animation import parse_move, plan_animation
    from rtbow.sequence.outputs import frames_beyond, parse_outputs

    moves = [parse_move(text) for text in keys]
    wanted = parse_outputs(outputs)
    if fps is not None:
        check_fps(fps)
        if not wanted.films and isinstance(count, int):
            raise InputError(
                f"--fps {fps:g} goes with a film, or with --frames in seconds; add one, such as"
                " -o film.mp4 or --frames 4s"
            )
    count = _counted(count, fps, bool(wanted.films))
    positions = () if sun_path is None else sun_path.positions(count, (start, end))
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
        for note in (*drawing.notes(animation.scene), *animation.notes(), *report.notes):
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
