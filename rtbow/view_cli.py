"""The verb ``rtbow view``: the live window."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.cli_options import (
    Exposure,
    WholeNumber,
    backend_option,
    max_delta_e_option,
    set_option,
    size_option,
)

if TYPE_CHECKING:
    from rtbow.renderer import Method
    from rtbow.view.app import Viewer

LIVE_METHODS = ("auto", "fast", "spectral", "reference")


@click.command()
@click.argument("scene", required=False)
@size_option("Width and height of the picture in pixels, such as 640x360.")
@backend_option
@click.option(
    "--method",
    type=click.Choice(LIVE_METHODS),
    default="auto",
    show_default=True,
    help="As for render; it can be changed in the window.",
)
@max_delta_e_option("Error that method fast may make, as for render.")
@set_option("light.0.altitude_deg=5")
@click.option(
    "--exposure",
    type=Exposure(),
    default="auto",
    show_default=True,
    metavar="auto|EV",
    help="Exposure: auto, or an EV at ISO 100.",
)
@click.option(
    "--watch", is_flag=True, help="Take over the scene file, what it names, and shaders as saved."
)
@click.option(
    "--frames", type=WholeNumber(min=1), metavar="N", help="Close after N pictures of the window."
)
@click.option(
    "--screenshot", metavar="FILE", help="Write the window's last picture before it closes: .png."
)
def view(
    scene: str | None,
    size: tuple[int, int] | None,
    backend: Any,
    method: Method,
    max_delta_e: float | None,
    settings: tuple[str, ...],
    exposure: float | None,
    watch: bool,
    frames: int | None,
    screenshot: str | None,
) -> None:
    """Explore a scene in a window; F1 there lists the keys.

    Example: rtbow view shower --watch
    """
    from rtbow.files import check_writable
    from rtbow.scene_file import load_scene, parse_set
    from rtbow.scene_schema import toml_text

    typed = list(settings)
    if size is not None:
        typed.append(f"camera.size_px={toml_text(list(size))}")
    if max_delta_e is not None:
        typed.append(f"render.max_delta_e={max_delta_e:g}")
    if screenshot is not None:
        check_writable(screenshot, (".png",))
    loaded = load_scene(scene, dict(map(parse_set, typed)))
    from rtbow.view.app import Viewer
    from rtbow.view.edits import Opened

    viewer = Viewer(Opened(loaded, scene, tuple(typed)), method, backend, exposure, watch=watch)
    try:
        viewer.run(frames, Path(screenshot) if screenshot is not None else None)
    except BaseException:
        _recover(viewer)
        raise
    finally:
        viewer.close()


def _recover(viewer: Viewer) -> None:
    """Write what would be lost, and say where."""
    path = viewer.recover()
    if path is not None:
        click.echo(f"the scene's unsaved changes are in {path}", file=sys.stderr)
