"""``rtbow render``: one frame."""

from __future__ import annotations

import shlex
import sys
import time
from typing import TYPE_CHECKING, Any

import click

from rtbow.base.errors import InputError
from rtbow.cli.options import (
    Drawing,
    WholeNumber,
    drawing_options,
    json_option,
    progress_bar,
    quiet_option,
    scene_argument,
)
from rtbow.cli.result.summary import STREAM, Made, check_json, summary_lines, write_json

if TYPE_CHECKING:
    from rtbow.base.arrays import Float32
    from rtbow.scene.model import Scene
    from rtbow.scene.text.sun import SunAt

_STREAM_FORMAT = "png"


@click.command()
@scene_argument
@click.option(
    "-o",
    "--output",
    "outputs",
    multiple=True,
    required=True,
    metavar="OUT",
    help="Where to write: .exr linear radiance, .png picture, - standard output. May be repeated.",
)
@click.option(
    "--format",
    "stream_format",
    type=click.Choice(["png", "exr"]),
    help=f"What -o - writes; left out: {_STREAM_FORMAT}.",
)
@drawing_options(
    size="Width and height in pixels, such as 640x360.",
    example="light.0.altitude_deg=5",
    exposure="Exposure of the .png: auto, or an EV at ISO 100.",
)
@click.option("--seed", type=WholeNumber(min=0), metavar="N", help="Seed of the random drops.")
@json_option
@quiet_option
def render(
    scene: str | None,
    outputs: tuple[str, ...],
    stream_format: str | None,
    drawing: Drawing,
    seed: int | None,
    json_file: str | None,
    quiet: bool,
) -> None:
    """Render one frame.

    SCENE may be -: a scene is then read from standard input.

    Afterwards three lines at most on stderr say what was made: method, time, peak luminance,
    exposure, stated error, and radius and width of each sun's bows.

    Example: rtbow render shower -o shower.exr -o shower.png --set light.0.altitude_deg=10
    """  # fmt: skip
    from rtbow.base.files import check_distinct, check_writable
    from rtbow.frames.image import FRAME_SUFFIXES, frame_metadata, write_frame

    overrides = drawing.overrides()
    check_distinct(outputs)
    check_json(json_file, outputs)
    streams = STREAM in outputs
    _check_stream(streams, stream_format)
    files = [path for path in outputs if path != STREAM]
    for path in files:  # before the long work, not after it
        check_writable(path, FRAME_SUFFIXES)
    from rtbow.render.renderer import Renderer

    if seed is not None:
        overrides["droplets.seed"] = seed
    loaded = _scene(scene, overrides, drawing.sun)
    if seed is not None and loaded.droplets.file is not None:
        raise InputError(
            f"--seed {seed}: the drops of {loaded.source_name} come from a volume file, not"
            " from random numbers; leave --seed out"
        )
    began = time.perf_counter()
    with Renderer(loaded, drawing.backend) as renderer:
        rgb = renderer.render(
            drawing.method,
            progress_bar("rendering", quiet),
            progress_bar("building the table", quiet, "part"),
        )
        seconds = time.perf_counter() - began
        exposure = _exposure(drawing, outputs, stream_format, rgb)
        made = Made(
            loaded.source_name,
            shlex.join(["rtbow", *sys.argv[1:]]),
            renderer.method_used,
            renderer.unsuited,
            loaded.render.max_delta_e if renderer.method_used == "fast" else None,
            seconds,
            renderer.gl_renderer,
            exposure,
            # Of the bow itself, the picture says more.
            (*drawing.notes(loaded)[:1], *renderer.notes, *renderer.unseen),
            outputs,
        )
        told = json_file is not None or not quiet
        numbers = renderer.measured(rgb, fringes=json_file is not None) if told else None
    metadata = frame_metadata(loaded, made.command, made.method, made.gl_renderer)
    for path in files:
        write_frame(path, rgb, metadata, exposure, whole_sphere=loaded.camera.whole_sphere)
    if streams:  # last: its reader may leave
        suffix = f".{stream_format or _STREAM_FORMAT}"
        whole = loaded.camera.whole_sphere
        write_frame(STREAM, rgb, metadata, exposure, suffix, whole_sphere=whole)
    if json_file is not None and numbers is not None:
        write_json(json_file, made.as_json(numbers))
    if not quiet and numbers is not None:
        for path in files:
            click.echo(path, err=streams or json_file == STREAM)
        for line in summary_lines(made, numbers):  # not among the paths, which scripts read
            click.echo(line, err=True)
        for note in made.notes:
            click.echo(f"note: {note}", err=True)


def _check_stream(asked: bool, stream_format: str | None) -> None:
    """Refuse a format without ``-o -``, and a picture that would fill a terminal."""
    if not asked and stream_format is not None:
        raise InputError(
            f"--format {stream_format} goes with -o -, standard output; the format of a file is"
            " that of its name; add -o -, or leave --format out"
        )
    if asked and sys.stdout is not None and sys.stdout.isatty():
        raise InputError(
            "-o -: standard output is a terminal; send it to a file or a program, such as"
            " rtbow render -o - | magick png:- bow.jpg, or name a file"
        )


def _scene(name: str | None, overrides: dict[str, Any], sun: SunAt | None) -> Scene:
    """Read the scene of a name, or from standard input."""
    from rtbow.scene.text.file import load_scene, scene_from_stream

    if name != STREAM:
        return load_scene(name, overrides, sun)
    if sys.stdin is None:
        raise InputError("<stdin>: is closed; send a scene there, as in rtbow render - < bow.toml")
    if sys.stdin.isatty():
        click.echo("reading a scene from the terminal; end it with Ctrl-D", err=True)
    return scene_from_stream(sys.stdin.buffer, "<stdin>", overrides, sun)


def _exposure(
    drawing: Drawing, outputs: tuple[str, ...], stream_format: str | None, rgb: Float32
) -> float | None:
    """Give the exposure value of the run's picture; None where it has none, and none was asked."""
    if drawing.exposure is not None:
        return drawing.exposure
    from rtbow.frames.display import auto_exposure_ev

    shown = (stream_format or _STREAM_FORMAT) == "png" and STREAM in outputs
    shown = shown or any(path.lower().endswith(".png") for path in outputs)
    return auto_exposure_ev(rgb) if shown else None
