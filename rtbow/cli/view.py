"""The verb ``rtbow view``: the live window."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rtbow.cli.options import Drawing, WholeNumber, drawing_options, scene_argument

if TYPE_CHECKING:
    from rtbow.view.app import Viewer


@click.command()
@scene_argument
@drawing_options(
    size="Width and height of the picture in pixels, such as 640x360.",
    example="light.0.altitude_deg=5",
    exposure="Exposure: auto, or an EV at ISO 100.",
)
@click.option(
    "--watch", is_flag=True, help="Reload the scene file, files it names, and shaders when saved."
)
@click.option(
    "--frames", type=WholeNumber(min=1), metavar="N", help="Close after N pictures of the window."
)
@click.option(
    "--screenshot", metavar="FILE", help="Write the window's last picture before it closes: .png."
)
def view(
    scene: str | None,
    drawing: Drawing,
    watch: bool,
    frames: int | None,
    screenshot: str | None,
) -> None:
    """Explore a scene in a window; F1 there lists the keys.

    Example: rtbow view shower --watch
    """
    from rtbow.base.files import check_writable
    from rtbow.scene.text.file import load_scene, typed_override

    overrides = drawing.placed(scene)
    if screenshot is not None:
        check_writable(screenshot, (".png",))
    loaded = load_scene(scene, overrides)
    for note in drawing.notes(loaded):
        _say(f"note: {note}")
    from rtbow.view.app import Viewer
    from rtbow.view.document.edits import Opened

    typed = tuple(typed_override(*one) for one in overrides.items())
    opened = Opened(loaded, scene, typed)
    viewer = Viewer(opened, drawing.method, drawing.backend, drawing.exposure, watch=watch)
    try:
        viewer.run(frames, Path(screenshot) if screenshot is not None else None)
    except BaseException:
        _recover(viewer, cameras=True)
        try:
            viewer.close(_say)
        except Exception as error:  # the first error counts
            _say(str(error))
        raise
    _recover(viewer)
    viewer.close(_say)


def _recover(viewer: Viewer, *, cameras: bool = False) -> None:
    """Say where unsaved changes are; never raises, whatever goes wrong."""
    try:
        for unsaved in viewer.recover(cameras=cameras):
            if unsaved.path is not None:
                _say(f"unsaved changes are in {unsaved.path}; rtbow view offers them")
                continue
            if unsaved.problem:
                _say(f"unsaved changes could not be kept: {unsaved.problem}")
            _say(f"this shows them again: {unsaved.command}")
    except Exception as error:
        _say(f"unsaved changes could not be kept: {error}")


def _say(text: str) -> None:
    click.echo(text, err=True)
