"""The verb ``rtbow bench``: speed against error."""

from __future__ import annotations

import math
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.cli.options import (
    WholeNumber,
    backend_option,
    max_delta_e_option,
    number,
    progress_bar,
    quiet_option,
    scene_completions,
    scene_name,
    set_option,
    size_option,
    sun_option,
)

if TYPE_CHECKING:
    from rtbow.base.arrays import Progress
    from rtbow.bench.row import BenchRow
    from rtbow.bench.run import Plan, Show
    from rtbow.scene.text.sun import SunAt

_ALL = "all"


def _pixel_count(value: str) -> int | str:
    """Read ``400`` or ``all``."""
    if value.lower() == _ALL:
        return _ALL
    if not (value.isascii() and value.isdigit()):
        raise click.BadParameter(
            f"{value!r} is not a number of pixels; write 400, 0 for none, or all"
        )
    return int(value[:20])  # more than any frame has; Python refuses to read thousands


@click.command()
@click.argument(
    "scenes",
    nargs=-1,
    type=scene_name,
    metavar="[SCENE]...",
    shell_complete=scene_completions,
)
@click.option("--json", "json_file", metavar="FILE", help="Write all numbers: .json.")
@click.option("--plot", "plot_file", metavar="FILE", help="Draw speed against error: .png or .svg.")
@size_option("Width and height in pixels; left out: 640x360.")
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="METHOD",
    help="Such as spectral. May be repeated; left out: all methods of the shader.",
)
@max_delta_e_option(
    "Largest error that method fast may make, a row each. May be repeated.", multiple=True
)
@set_option("droplets.extinction=true")
@sun_option
@click.option(
    "--frames",
    type=WholeNumber(3, 10_000),
    metavar="N",
    help="Timed frames of each row; left out: 9 to 99, or 3 where one takes over 5 s.",
)
@click.option(
    "--error-pixels",
    type=_pixel_count,
    metavar="N|all",
    help="Pixels compared with the reference; 0: none; left out: 400.",
)
@backend_option
@click.option(
    "--scaling", is_flag=True, help="Time one scene over pixels, steps, grid points and lights."
)
@click.option(
    "--scaling-limit-s",
    type=number,
    metavar="S",
    help="Time that a point of --scaling may take; left out: 60.",
)
@quiet_option
def bench(
    scenes: tuple[str, ...],
    json_file: str | None,
    plot_file: str | None,
    size: tuple[int, int] | None,
    methods: tuple[str, ...],
    max_delta_e: tuple[float, ...],
    settings: tuple[str, ...],
    sun: SunAt | None,
    frames: int | None,
    error_pixels: int | str | None,
    backend: Any,
    scaling: bool,
    scaling_limit_s: float | None,
    quiet: bool,
) -> None:
    """Measure speed against error.

    Each method draws each SCENE; random-1, random-2 and so on are drawn at random. Its frame is
    compared with the float64 reference. Method spectral takes 5 nm, unless --set
    render.wavelength_step_nm says otherwise.

    Example: rtbow bench uniform shower --json bench.json --plot bench.png
    """  # fmt: skip
    from rtbow.base.errors import InputError
    from rtbow.base.files import check_writable

    if json_file is not None:
        check_writable(json_file, (".json",))
    if plot_file is not None:
        from rtbow.frames.plot import PLOT_SUFFIXES

        check_writable(plot_file, PLOT_SUFFIXES)
    if scaling and error_pixels is not None:
        raise InputError("--error-pixels: --scaling compares no pixels; leave one of the two out")
    if scaling and len(scenes) > 1:
        raise InputError(f"--scaling takes one scene, not {len(scenes)}; name one")
    if plot_file is not None and error_pixels == 0:
        raise InputError("--plot: speed is drawn against error; leave --error-pixels 0 out")
    if not scaling and scaling_limit_s is not None:
        raise InputError("--scaling-limit-s goes with --scaling; add it")
    plan = _plan(size, methods, max_delta_e, settings, sun, frames, error_pixels, backend)
    rows = _measured(scenes, plan, scaling, scaling_limit_s, _shown(quiet))
    written = []
    if json_file is not None:
        from rtbow.bench.report import write_json

        write_json(Path(json_file), rows)
        written.append(json_file)
    if plot_file is not None:
        _draw(Path(plot_file), rows, scaling)
        written.append(plot_file)
    if not quiet:
        from rtbow.bench.report import table_lines

        for line in [*table_lines(rows), *written]:
            click.echo(line)


def _plan(
    size: tuple[int, int] | None,
    methods: tuple[str, ...],
    tolerances: tuple[float, ...],
    settings: tuple[str, ...],
    sun: SunAt | None,
    frames: int | None,
    error_pixels: int | str | None,
    backend: Any,
) -> Plan:
    from rtbow.bench.run import DEFAULT_ERROR_PIXELS, DEFAULT_SIZE, Plan, shader_methods
    from rtbow.scene.text.file import parse_set

    changes = dict(parse_set(text) for text in settings)
    if size is not None:
        changes.pop("camera.size_px", None)
    pixels: int | str | None = DEFAULT_ERROR_PIXELS if error_pixels is None else error_pixels
    return Plan(
        size or DEFAULT_SIZE,
        tuple(dict.fromkeys(methods)) or shader_methods(),  # type: ignore[arg-type]
        tuple(dict.fromkeys(tolerances)),
        changes,
        backend,
        frames,
        None if isinstance(pixels, str) else pixels,
        shlex.join(["rtbow", *sys.argv[1:]]),
        sun,
    )


def _measured(
    scenes: tuple[str, ...], plan: Plan, scaling: bool, limit_s: float | None, show: Show
) -> list[BenchRow]:
    if not scaling:
        from rtbow.bench.run import run_bench

        return run_bench(scenes or (None,), plan, show)
    from rtbow.base.errors import InputError
    from rtbow.bench.scaling import DEFAULT_LIMIT_S, run_scaling

    limit = DEFAULT_LIMIT_S if limit_s is None else limit_s
    if not 0.0 < limit < math.inf:  # NaN is not, either
        raise InputError(
            f"--scaling-limit-s {limit:g}: must be a finite number of seconds, greater than 0"
        )
    return run_scaling(scenes[0] if scenes else None, plan, limit, show)


def _shown(quiet: bool) -> Show:
    def show(label: str, unit: str) -> Progress:
        return progress_bar(label, quiet, unit)

    return show


def _draw(path: Path, rows: list[BenchRow], scaling: bool) -> None:
    from rtbow.base.errors import InputError
    from rtbow.bench.plot import draw_scaling, draw_speed

    if not (draw_scaling if scaling else draw_speed)(path, rows):
        raise InputError(f"{path}: no row has a time and an error; there is nothing to draw")
