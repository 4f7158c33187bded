"""``rtbow render``: one frame."""

from __future__ import annotations

import shlex
import sys
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
    from rtbow.render.renderer import Renderer


@click.command()
@scene_argument
@click.option(
    "-o",
    "--output",
    "outputs",
    multiple=True,
    required=True,
    metavar="OUT",
    help="Where to write: .exr linear radiance, .png picture. May be repeated.",
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
    drawing: Drawing,
    seed: int | None,
    quiet: bool,
) -> None:
    """Render one frame.

    Example: rtbow render shower -o shower.exr -o shower.png --set light.0.altitude_deg=10
    """  # fmt: skip
    from rtbow.base.files import check_distinct, check_writable
    from rtbow.frames.image import FRAME_SUFFIXES, frame_metadata, write_frame

    overrides = drawing.overrides()
    check_distinct(outputs)
    for path in outputs:  # before the long work, not after it
        check_writable(path, FRAME_SUFFIXES)
    from rtbow.render.renderer import Renderer
    from rtbow.scene.text.file import load_scene

    if seed is not None:
        overrides["droplets.seed"] = seed
    loaded = load_scene(scene, overrides)
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
        notes = renderer.notes
        metadata = frame_metadata(
            loaded,
            shlex.join(["rtbow", *sys.argv[1:]]),
            renderer.method_used,
            renderer.gl_renderer,
        )
    for path in outputs:
        write_frame(path, rgb, metadata, drawing.exposure)
    if not quiet:
        for path in outputs:
            click.echo(path)
        for note in notes:
            click.echo(f"note: {note}", err=True)
        if drawing.method == "auto":  # not among the paths, which scripts read
            click.echo(_chosen(renderer), err=True)


def _chosen(renderer: Renderer) -> str:
    """Return which method ``auto`` chose, and why."""
    reason = renderer.unsuited.rpartition("; ")[0] or renderer.unsuited  # without its remedy
    return f"method {renderer.method_used}" + (f": {reason}" if reason else "")
