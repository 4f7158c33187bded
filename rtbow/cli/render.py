"""``rtbow render``: one frame."""

from __future__ import annotations

import shlex
import sys
from typing import TYPE_CHECKING, Any

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
    from rtbow.render.renderer import Renderer
    from rtbow.scene.model import Scene

_STREAM = "-"
"""The name of standard input among scenes, and of standard output among outputs."""
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
@quiet_option
def render(
    scene: str | None,
    outputs: tuple[str, ...],
    stream_format: str | None,
    drawing: Drawing,
    seed: int | None,
    quiet: bool,
) -> None:
    """Render one frame.

    SCENE may be -: a scene is then read from standard input.

    Example: rtbow render shower -o shower.exr -o shower.png --set light.0.altitude_deg=10
    """  # fmt: skip
    from rtbow.base.files import check_distinct, check_writable
    from rtbow.frames.image import FRAME_SUFFIXES, frame_metadata, write_frame

    overrides = drawing.overrides()
    check_distinct(outputs)
    streams = _STREAM in outputs
    _check_stream(streams, stream_format)
    files = [path for path in outputs if path != _STREAM]
    for path in files:  # before the long work, not after it
        check_writable(path, FRAME_SUFFIXES)
    from rtbow.render.renderer import Renderer

    if seed is not None:
        overrides["droplets.seed"] = seed
    loaded = _scene(scene, overrides)
    if seed is not None and loaded.droplets.file is not None:
        raise InputError(
            f"--seed {seed}: the drops of {loaded.source_name} come from a volume file, not"
            " from random numbers; leave --seed out"
        )
    with Renderer(loaded, drawing.backend) as renderer:
        rgb = renderer.render(
            drawing.method,
            progress_bar("rendering", quiet),
            progress_bar("building the table", quiet, "part"),
        )
        notes = (*renderer.notes, *renderer.unseen)
        metadata = frame_metadata(
            loaded,
            shlex.join(["rtbow", *sys.argv[1:]]),
            renderer.method_used,
            renderer.gl_renderer,
        )
    for path in files:
        write_frame(path, rgb, metadata, drawing.exposure)
    if streams:  # last: its reader may leave
        suffix = f".{stream_format or _STREAM_FORMAT}"
        write_frame(_STREAM, rgb, metadata, drawing.exposure, suffix)
    if not quiet:
        for path in files:
            click.echo(path, err=streams)
        if drawing.method == "auto":  # not among the paths, which scripts read
            click.echo(_chosen(renderer), err=True)
        for note in notes:
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


def _scene(name: str | None, overrides: dict[str, Any]) -> Scene:
    """Read the scene of a name, or from standard input."""
    from rtbow.scene.text.file import load_scene, scene_from_stream

    if name != _STREAM:
        return load_scene(name, overrides)
    if sys.stdin is None:
        raise InputError("<stdin>: is closed; send a scene there, as in rtbow render - < bow.toml")
    if sys.stdin.isatty():
        click.echo("reading a scene from the terminal; end it with Ctrl-D", err=True)
    return scene_from_stream(sys.stdin.buffer, "<stdin>", overrides)


def _chosen(renderer: Renderer) -> str:
    """Return which method ``auto`` chose, and why."""
    reason = renderer.unsuited.rpartition("; ")[0] or renderer.unsuited  # without its remedy
    return f"method {renderer.method_used}" + (f": {reason}" if reason else "")
