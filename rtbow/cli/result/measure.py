"""The verb ``rtbow measure``: the numbers of a frame and of its bows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from rtbow.base.errors import InputError
from rtbow.cli.options import (
    backend_option,
    frame_or_scene_completions,
    json_option,
    method_option,
    progress_bar,
    quiet_option,
    set_option,
    size_option,
)
from rtbow.cli.result.summary import bow_label, check_json, write_json

if TYPE_CHECKING:
    from rtbow.frames.bows.measured import BowMeasures, FrameMeasures

_LABEL = 14
"""Characters before the text of a line."""


@click.command()
@click.argument(
    "subject",
    metavar="[FRAME.exr|SCENE]",
    required=False,
    shell_complete=frame_or_scene_completions,
)
@json_option
@size_option("Width and height in pixels of a SCENE's frame, such as 640x360.")
@backend_option
@method_option
@set_option("light.0.altitude_deg=5")
@quiet_option
def measure(
    subject: str | None,
    json_file: str | None,
    size: tuple[int, int] | None,
    backend: Any,
    method: Any,
    settings: tuple[str, ...],
    quiet: bool,
) -> None:
    """Measure a frame: luminance, and radius, width, contrast and colour of each sun's bows.

    FRAME.exr is a frame that rtbow wrote: the scene in its metadata says where camera and sun are.
    A SCENE is rendered first.

    Radii are angles from the antisolar point, widths full widths at half maximum, contrast is
    (peak - dark) / (peak + dark) with the dark band between the bows. Bows of lamps are not
    circles, and are left out.

    Example: rtbow measure shower --size 640x360 --json -
    """
    check_json(json_file)
    if subject is not None and subject.lower().endswith((".exr", ".png")):
        _refuse_options(subject, size, settings)
        name, numbers, exposure = _of_frame(subject)
    else:
        name, numbers, exposure = _of_scene(subject, size, backend, method, settings, quiet)
    if json_file is not None:
        write_json(json_file, {"subject": name, "exposure_ev100": exposure, **numbers.as_json()})
    if quiet:
        return
    for label, text in _lines(name, numbers, exposure):
        click.echo(f"{label + ':':<{_LABEL}}{text}", err=json_file == "-")
    for note in numbers.left_out:
        click.echo(f"note: {note}", err=True)


def _refuse_options(subject: str, size: tuple[int, int] | None, settings: tuple[str, ...]) -> None:
    context = click.get_current_context()
    for name, parameter in (("--size", "size"), ("--set", "settings"), ("--method", "method"),
                            ("--backend", "backend")):  # fmt: skip
        source = context.get_parameter_source(parameter)
        if source is click.core.ParameterSource.COMMANDLINE:
            raise InputError(
                f"{name} goes with a SCENE, which is rendered; {subject} is a frame: leave {name}"
                " out"
            )


def _of_frame(path: str) -> tuple[str, FrameMeasures, float | None]:
    """Measure a frame on file."""
    from rtbow.frames.bows.stored import stored_frame

    frame = stored_frame(path)
    return path, frame.measured(), frame.exposure_ev


def _of_scene(
    name: str | None,
    size: tuple[int, int] | None,
    backend: Any,
    method: Any,
    settings: tuple[str, ...],
    quiet: bool,
) -> tuple[str, FrameMeasures, float | None]:
    """Render a scene, and measure that."""
    from rtbow.render.renderer import Renderer
    from rtbow.scene.text.file import load_scene, parse_set

    overrides = dict(parse_set(text) for text in settings)
    if size is not None:
        overrides["camera.size_px"] = list(size)
    scene = load_scene(name, overrides)
    with Renderer(scene, backend) as renderer:
        rgb = renderer.render(
            method,
            progress_bar("rendering", quiet),
            progress_bar("building the table", quiet, "part"),
        )
        numbers = renderer.measured(rgb)
        for note in () if quiet else (*renderer.notes, *renderer.unseen):
            click.echo(f"note: {note}", err=True)
    return scene.source_name, numbers, None


def _lines(name: str, numbers: FrameMeasures, exposure: float | None) -> Iterator[tuple[str, str]]:
    width, height = numbers.size_px
    shown = "" if exposure is None else f", shown at EV {exposure:g}"
    yield "frame", f"{name}, {width} x {height} pixels{shown}"
    yield (
        "luminance",
        f"peak {numbers.peak_luminance_cd_m2:.4g}, mean {numbers.mean_luminance_cd_m2:.4g} cd/m2",
    )
    if not numbers.bows:
        yield "bows", "none that can be measured"
    for bow in numbers.bows:
        yield bow_label(bow, numbers.bows), ", ".join(_bow_texts(bow))
        fringes = _fringe_text(bow)
        if fringes:
            yield "  fringes", fringes


def _bow_texts(bow: BowMeasures) -> Iterator[str]:
    yield f"radius {bow.radius_deg:.2f}{_rgb(bow.radius_rgb_deg)}"
    if bow.width_deg is not None:
        yield f"width {bow.width_deg:.2f}{_rgb(bow.width_rgb_deg)} deg"
    if bow.peak_luminance_cd_m2 is not None:
        yield f"{bow.peak_luminance_cd_m2:.4g} cd/m2"
    if bow.contrast is not None:
        yield f"contrast {bow.contrast:.3f}"
    if bow.chromaticity_uv is not None:
        u, v = bow.chromaticity_uv
        yield f"u' {u:.4f} v' {v:.4f}"


def _fringe_text(bow: BowMeasures) -> str:
    parts = []
    if bow.supernumerary_maxima is not None:
        parts.append(f"{bow.supernumerary_maxima} supernumerary maxima")
    if bow.supernumerary_contrast is not None:
        parts.append(f"contrast {bow.supernumerary_contrast:.3g}")
    if bow.supernumerary_chroma is not None:
        parts.append(f"chroma {bow.supernumerary_chroma:.2g}")
    return ", ".join(parts)


def _rgb(values: tuple[float | None, float | None, float | None]) -> str:
    if all(value is None for value in values):
        return ""
    texts = ["-" if value is None else f"{value:.2f}" for value in values]
    return f" ({' '.join(texts)} in R G B)"
