"""The command line: ``rtbow VERB [SCENE]``.

Every heavy import happens inside the verb that needs it, so that ``rtbow --help`` is quick.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NoReturn

import click

from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.version import __version__
from rtbow.cli.animate import animate
from rtbow.cli.bench import bench
from rtbow.cli.chart import chart
from rtbow.cli.figures import figures
from rtbow.cli.render import render
from rtbow.cli.table import table
from rtbow.cli.view import view

if TYPE_CHECKING:
    pass

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
rtbow.add_command(figures)
rtbow.add_command(render)
rtbow.add_command(table)
rtbow.add_command(bench)
rtbow.add_command(chart)
rtbow.add_command(view)


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
