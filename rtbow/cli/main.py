"""The command line: ``rtbow VERB [SCENE]``.

Every heavy import happens inside the verb that needs it, so that ``rtbow --help`` is quick.
"""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import click

from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.version import __version__
from rtbow.cli.animate import animate
from rtbow.cli.bench import bench
from rtbow.cli.chart import chart
from rtbow.cli.figures import figures
from rtbow.cli.info import info
from rtbow.cli.render import render
from rtbow.cli.result.measure import measure
from rtbow.cli.scenes.new import new
from rtbow.cli.table import table
from rtbow.cli.view import view

_TERMINATED = 128 + signal.SIGTERM  # as shells report it


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

    paths = builtin_scenes()
    width = max(map(len, paths))
    for name, path in paths.items():
        click.echo(f"{name:<{width}}  {scene_title(path)}")


@rtbow.command()
def spectra() -> None:
    """List the spectra known by name: what each is, colour temperature, colour rendering index.

    Example: rtbow spectra
    """
    from rtbow.study.spectra import spectrum_list

    for line in spectrum_list():
        click.echo(line)


for _verb in (animate, bench, chart, figures, info, measure, new, render, table, view):
    rtbow.add_command(_verb)


class _Terminated(SystemExit):
    """SIGTERM came; like Ctrl-C, it is no error for others to handle."""


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
        raise _Terminated(_TERMINATED)

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
    except BaseException as error:
        cause = _interruption(error) or error
        exit_of = next((_EXITS[kind] for kind in type(cause).__mro__ if kind in _EXITS), None)
        if exit_of is None:
            raise
        code, message = exit_of(cause)
        if message:
            click.echo(message, err=code != 0)
    sys.exit(code if isinstance(code, int) else 0)


def _interruption(error: BaseException) -> BaseException | None:
    """Return the Ctrl-C or SIGTERM behind an error from compiled code, if there is one.

    Numba raises a SystemError then: its call "returned a result with an exception set".
    """
    inner: BaseException | None = error if isinstance(error, SystemError) else None
    while inner is not None and not isinstance(inner, KeyboardInterrupt | _Terminated):
        inner = inner.__cause__ or inner.__context__
    return inner


def _stop(code: object) -> tuple[int, str]:
    """Give exit code and message of a SystemExit, whose code may be a text."""
    if code == 1:
        return 128 + signal.SIGPIPE, ""
    return (code or 0, "") if isinstance(code, int | None) else (1, str(code))


def _usage(error: click.UsageError) -> str:
    verb = error.ctx.command_path if error.ctx else "rtbow"
    return f"{verb}: {error.format_message().rstrip('.')} (see {verb} --help)"


def _system_error(error: OSError) -> tuple[int, str]:
    """Say that standard output is full, or the current folder gone; files explain themselves."""
    if error.errno == errno.ENOENT and not _in_a_folder():
        return InputError.exit_code, (
            "rtbow: the current folder was deleted; change to another one (cd) and try again"
        )
    if error.errno not in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        raise error
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python writes the rest when it exits
    return InputError.exit_code, (
        f"rtbow: standard output cannot be written: {os.strerror(error.errno)}; free some "
        "space or send it elsewhere"
    )


def _aborted(error: click.Abort) -> tuple[int, str]:
    """Tell Ctrl-C from the end of a file, which click takes for Ctrl-D at a prompt."""
    if isinstance(error.__cause__, EOFError):
        raise error.__cause__  # there are no prompts: a defect
    return _INTERRUPTED


def _in_a_folder() -> bool:
    try:
        return bool(os.getcwd())
    except FileNotFoundError:
        return False


_INTERRUPTED = (130, "interrupted; nothing was left half written")  # 128 + SIGINT, as shells do

_EXITS: dict[Any, Callable[[Any], tuple[int, str]]] = {
    _Terminated: lambda _: (_TERMINATED, "terminated; nothing was left half written"),
    # Raised by click: 1 where the reader of the output left, 0 in answer to the shell's Tab.
    SystemExit: lambda error: _stop(error.code),
    # Since click 8.2 a missing verb is an error.
    getattr(click.exceptions, "NoArgsIsHelpError", None): lambda error: (0, error.format_message()),
    click.UsageError: lambda error: (InputError.exit_code, _usage(error)),
    click.ClickException: lambda error: (InputError.exit_code, f"rtbow: {error.format_message()}"),
    click.Abort: lambda error: _aborted(error),
    KeyboardInterrupt: lambda _: _INTERRUPTED,
    RtbowError: lambda error: (error.exit_code, f"rtbow: {error}"),
    MemoryError: lambda _: (
        UnavailableError.exit_code,
        "rtbow: not enough memory; render smaller or use a coarser volume",
    ),
    OSError: _system_error,
}
"""Exit code and message by exception; an error of several kinds ends as the narrowest of them."""


if __name__ == "__main__":
    main()
