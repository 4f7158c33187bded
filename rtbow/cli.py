"""The command line: ``rtbow VERB [SCENE]``.

Every heavy import happens inside the verb that needs it, so that ``rtbow --help`` is quick.
"""

from __future__ import annotations

import errno
import os
import shlex
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from rtbow.animate_cli import animate
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.version import __version__
from rtbow.bench_cli import bench
from rtbow.chart_cli import chart
from rtbow.cli_options import (
    Numbers,
    WholeNumber,
    backend_option,
    exposure_option,
    max_delta_e_option,
    method_option,
    progress_bar,
    quiet_option,
    scene_argument,
    set_option,
    size_option,
    typed_overrides,
)
from rtbow.physics.constants import SUN_DIAMETER_DEG
from rtbow.view_cli import view

if TYPE_CHECKING:
    from rtbow.render.renderer import Method, Renderer
    from rtbow.tables.sections import Theory

INTERRUPTED = 130  # 128 + SIGINT, as shells report it
PIPE_CLOSED = 141  # 128 + SIGPIPE
TERMINATED = 143  # 128 + SIGTERM

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
# Before click 8.2 a missing verb is no error.
_NO_VERB = getattr(click.exceptions, "NoArgsIsHelpError", ())


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="rtbow")
def rtbow() -> None:
    """Render rainbows as radiance, from first principles.

    SCENE is a path to a .toml file or the name of a built-in scene (rtbow scenes lists them);
    without one, the default scene.

    Example: rtbow render uniform -o bow.exr -o bow.png
    """


@rtbow.command()
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
@size_option("Width and height in pixels, such as 640x360.")
@backend_option
@method_option
@max_delta_e_option()
@set_option("light.0.altitude_deg=5")
@exposure_option("Exposure of the .png: auto, or an EV at ISO 100.")
@click.option("--seed", type=WholeNumber(min=0), metavar="N", help="Seed of the random drops.")
@quiet_option
def render(
    scene: str | None,
    outputs: tuple[str, ...],
    size: tuple[int, int] | None,
    backend: Any,
    method: Method,
    max_delta_e: float | None,
    settings: tuple[str, ...],
    exposure: float | None,
    seed: int | None,
    quiet: bool,
) -> None:
    """Render one frame.

    Example: rtbow render shower -o shower.exr -o shower.png --set light.0.altitude_deg=10
    """  # fmt: skip
    from rtbow.base.files import check_distinct, check_writable
    from rtbow.frames.image import FRAME_SUFFIXES, frame_metadata, write_frame

    overrides = typed_overrides(settings, size, max_delta_e, method)
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
            f"--seed {seed}: the drops of {loaded.source_name} come from a volume file, where"
            " nothing is drawn; leave --seed out"
        )
    with Renderer(loaded, backend) as renderer:
        rgb = renderer.render(
            method,
            progress_bar("rendering", quiet),
            progress_bar("building the table", quiet, "part"),
        )
        metadata = frame_metadata(
            loaded,
            shlex.join(["rtbow", *sys.argv[1:]]),
            renderer.method_used,
            renderer.gl_renderer,
        )
    for path in outputs:
        write_frame(path, rgb, metadata, exposure)
    if not quiet:
        for path in outputs:
            click.echo(path)
        if method == "auto":  # beside the paths, which scripts read
            click.echo(_chosen(renderer), err=True)


def _chosen(renderer: Renderer) -> str:
    """Tell which method ``auto`` chose, and why."""
    # Without the remedy, which was taken.
    why = renderer.unsuited.rpartition("; ")[0] or renderer.unsuited
    return f"method {renderer.method_used}" + (f": {why}" if why else "")


@rtbow.command()
def scenes() -> None:
    """List the built-in scenes, one line each.

    Example: rtbow scenes
    """
    from rtbow.scene.text.file import builtin_scenes, scene_title

    found = builtin_scenes()
    width = max(len(name) for name in found)
    for name, path in found.items():
        click.echo(f"{name:<{width}}  {scene_title(path)}")


@rtbow.command()
@click.option("-o", "--output", "output", required=True, metavar="DIR", help="Folder to write to.")
@click.option("--only", multiple=True, metavar="NAME", help="Such as fig5f. May be repeated.")
@size_option("Width and height in pixels; left out: 480x270.")
@backend_option
@quiet_option
def figures(
    output: str, only: tuple[str, ...], size: tuple[int, int] | None, backend: Any, quiet: bool
) -> None:
    """Render the paper's figures, with a page of pictures and measured claims.

    What is finished stays: an interrupted run goes on where it was.

    Example: rtbow figures -o figures --only fig5f
    """  # fmt: skip
    from rtbow.study.figures import DEFAULT_SIZE, make_figures

    verdicts = make_figures(
        Path(output),
        list(only),
        size or DEFAULT_SIZE,
        backend,
        lambda name: progress_bar(name, quiet),
    )
    if not quiet:
        for verdict in verdicts:
            state = {True: "holds", False: "does not hold", None: "not measured"}[verdict.holds]
            click.echo(f"figure {verdict.claim.figure}: {state}: {verdict.claim.text}")
        click.echo(str(Path(output) / "index.html"))


@rtbow.command()
def info() -> None:
    """Show the GL backends that work here, versions, and the cache.

    Example: rtbow info
    """
    import platform

    from rtbow.base.cache import cache_dir, cache_size
    from rtbow.gl.context import probe_backends

    click.echo(f"rtbow {__version__}, Python {platform.python_version()}, {platform.platform()}")
    for report in probe_backends():
        if report.ok:
            click.echo(f"{report.backend:<8}works: {report.renderer}, OpenGL {report.version}")
        else:
            click.echo(f"{report.backend:<8}does not work: {report.reason}")
            if report.help:
                click.echo(f"{'':<8}{report.help}")
    from importlib.metadata import version

    names = ("moderngl", "glfw", "numpy", "scipy", "numba", "colour-science", "OpenEXR")
    click.echo("packages: " + ", ".join(f"{name} {version(name)}" for name in names))
    click.echo(f"cache: {cache_dir()}, {cache_size() / 2**20:.1f} MiB")


rtbow.add_command(animate)
rtbow.add_command(bench)
rtbow.add_command(chart)
rtbow.add_command(view)


@rtbow.group()
def table() -> None:
    """Build, inspect and export the scattering table.

    Example: rtbow table export airy.npz --radius-um 100,500
    """


@table.command("build")
@click.option(
    "--theory",
    type=click.Choice(["airy", "mie"]),
    default="airy",
    show_default=True,
    help="mie: exact, minutes; the one that ships needs no build.",
)
@click.option(
    "--spread",
    type=float,
    default=2.0,
    show_default=True,
    metavar="PERCENT",
    help="Spread of sizes about each radius (mie).",
)
@click.option(
    "--max-radius-um",
    type=float,
    default=1500.0,
    show_default=True,
    metavar="UM",
    help="Largest drop (mie).",
)
@click.option(
    "--workers", type=WholeNumber(1, 1024), metavar="N", help="Processes; left out: one per core."
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="A Dask scheduler to build on, such as tcp://host:8786."
)
@quiet_option
def table_build(
    theory: str,
    spread: float,
    max_radius_um: float,
    workers: int | None,
    scheduler: str | None,
    quiet: bool,
) -> None:
    """Build a table, store it in the cache and say how long it took.

    What is finished stays: an interrupted build goes on where it was.

    Example: rtbow table build --theory mie
    """  # fmt: skip
    from rtbow.tables.report import describe_build, describe_mie_build

    if theory == "airy":
        if (spread, max_radius_um, workers, scheduler) != (2.0, 1500.0, None, None):
            raise InputError(
                "--spread, --max-radius-um, --workers and --scheduler go with --theory mie; add it"
            )
        text = describe_build()
    else:
        text = describe_mie_build(
            spread, max_radius_um, progress_bar("building", quiet, "part"), workers, scheduler
        )
    if not quiet:
        click.echo(text)


@table.command("info")
@click.option(
    "--samples",
    type=WholeNumber(100, 1_000_000),
    default=4000,
    show_default=True,
    metavar="N",
    help="Random look-ups to compare with direct evaluation, per disc.",
)
def table_info(samples: int) -> None:
    """Show the table's arrays and its measured look-up error.

    Example: rtbow table info
    """  # fmt: skip
    from rtbow.tables.report import describe_table

    for line in describe_table(samples):
        click.echo(line)


@table.command("export")
@click.argument("output")
@click.option("--theory", type=click.Choice(["airy", "mie"]), default="airy", show_default=True)
@click.option(
    "--disc",
    "disc_deg",
    type=float,
    default=SUN_DIAMETER_DEG,
    show_default=True,
    metavar="DEG",
    help="Angular diameter of the light's disc; 0 for a point.",
)
@click.option(
    "--spread",
    type=float,
    default=2.0,
    show_default=True,
    metavar="PERCENT",
    help="Spread of sizes about each radius (mie).",
)
@click.option(
    "--radius-um",
    type=Numbers(),
    metavar="A,B,...",
    help="Drop radii; left out: 64 from 10 to 1500.",
)
@click.option(
    "--wavelength-nm",
    type=Numbers(),
    metavar="A,B,...",
    help="Wavelengths; left out: 380 to 780 by 5.",
)
@click.option(
    "--angles",
    type=WholeNumber(2, 1_000_000),
    default=2001,
    show_default=True,
    metavar="N",
    help="Scattering angles from 0 to 180 degrees.",
)
@quiet_option
def table_export(
    output: str,
    theory: Theory,
    disc_deg: float,
    spread: float,
    radius_um: tuple[float, ...] | None,
    wavelength_nm: tuple[float, ...] | None,
    angles: int,
    quiet: bool,
) -> None:
    """Write the plain table (radius x wavelength x angle) for other programs: .npz or .exr.

    Example: rtbow table export airy.npz --radius-um 100,500 --disc 0
    """  # fmt: skip
    from rtbow.base.files import check_writable

    check_writable(output, (".npz", ".exr"))
    from rtbow.tables.export import (
        PlainTable,
        default_radii_um,
        default_wavelengths_nm,
        export_table,
    )

    if theory == "airy" and spread != 2.0:
        raise InputError("--spread goes with --theory mie: Airy's table has none; add it")
    wanted = PlainTable(
        theory,
        default_radii_um() if radius_um is None else radius_um,
        default_wavelengths_nm() if wavelength_nm is None else wavelength_nm,
        angles,
        disc_deg,
        round(spread / 100.0, 9),
    )
    export_table(
        Path(output),
        wanted,
        progress_bar("exporting", quiet, "radius"),
        progress_bar("building the table", quiet, "part"),
    )
    if not quiet:
        click.echo(output)


class _Terminated(SystemExit):
    """SIGTERM came; like Ctrl-C, it is no error that anything on its way should handle."""


@contextmanager
def _orderly_termination() -> Iterator[None]:
    """Let SIGTERM end what runs as Ctrl-C does, by an exception, so that it tidies up."""
    ours = threading.current_thread() is threading.main_thread()  # where Python takes signals
    if not ours or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return

    def end(*_: object) -> None:
        # `timeout` sends it twice; the second one must not break off the tidying up.
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        raise _Terminated(TERMINATED)

    signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def main() -> None:
    """Run the command line and exit with the codes that scripts rely on.

    0 done; 2 the input is wrong; 3 the machine lacks something; 1 a defect of rtbow; 130 Ctrl-C;
    141 the reader of the output left, as in ``rtbow info | head -1``; 143 SIGTERM.
    """
    try:
        with _orderly_termination():
            code = rtbow.main(prog_name="rtbow", standalone_mode=False)
    except _Terminated:
        _say_terminated()
    except SystemExit as stop:  # click's answer to a reader that left, or to the shell's Tab
        sys.exit(PIPE_CLOSED if stop.code == 1 else stop.code)
    except _NO_VERB as error:
        click.echo(error.format_message())
        sys.exit(0)
    except click.UsageError as error:
        verb = error.ctx.command_path if error.ctx else "rtbow"
        click.echo(f"{verb}: {error.format_message().rstrip('.')} (see {verb} --help)", err=True)
        sys.exit(InputError.exit_code)
    except click.ClickException as error:
        error.show()
        sys.exit(InputError.exit_code)
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted; nothing was left half written", err=True)
        sys.exit(INTERRUPTED)
    except RtbowError as error:
        click.echo(f"rtbow: {error}", err=True)
        sys.exit(error.exit_code)
    except MemoryError:
        click.echo("rtbow: not enough memory; render smaller or use a coarser volume", err=True)
        sys.exit(UnavailableError.exit_code)
    except OSError as error:
        if error.errno not in _FULL:
            raise
        # Files explain themselves, so what is full is where standard output goes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python writes the rest when it exits
        click.echo(
            f"rtbow: standard output cannot be written: {os.strerror(error.errno)}; free some "
            "space or send it elsewhere",
            err=True,
        )
        sys.exit(InputError.exit_code)
    except SystemError as error:
        # Ctrl-C within compiled code: Numba's call "returned a result with an exception set".
        if _comes_from(error, _Terminated):
            _say_terminated()
        if not _comes_from(error, KeyboardInterrupt):
            raise
        click.echo("interrupted; nothing was left half written", err=True)
        sys.exit(INTERRUPTED)
    sys.exit(code if isinstance(code, int) else 0)


def _say_terminated() -> NoReturn:
    click.echo("terminated; nothing was left half written", err=True)
    sys.exit(TERMINATED)


def _comes_from(error: BaseException | None, kind: type[BaseException]) -> bool:
    """Whether an error, or what it was raised from, is of a kind."""
    while error is not None and not isinstance(error, kind):
        error = error.__cause__ or error.__context__
    return error is not None


if __name__ == "__main__":
    main()
