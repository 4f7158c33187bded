"""The command line as tests run it, and checks of how a run ended."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from checkout import ROOT

SMALL = ("--size", "32x18")


class Summary:
    """What stderr says of a frame, in three lines at most, whatever its numbers; and what follows.

    Equal to a text that has that form.
    """

    def __init__(self, method: str, reason: str = "", notes: str = "") -> None:
        """Give the method, the pattern of why ``auto`` took it, and the text of the notes."""
        why = f": {reason}" if reason else ""
        frame = r"[0-9.]+ s, peak [0-9.e+-]+ cd/m2(, EV -?[0-9.]+)?(, CIEDE2000 at most [^\n]+)?\n"
        bows = r"(([a-z0-9. ]+ bow: radius [0-9.]+(, width [0-9.]+)? deg(; )?)+\n)?"
        self.pattern = f"method {method}{why}\n{frame}{bows}{re.escape(notes)}"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, str) and re.fullmatch(self.pattern, other) is not None

    def __repr__(self) -> str:
        return f"<text like {self.pattern!r}>"

    __hash__ = None  # type: ignore[assignment]


FAST = Summary("fast")
"""What stderr says where ``auto`` chose."""


@dataclass(frozen=True)
class Result:
    """How a run ended."""

    code: int
    out: str
    err: str | Summary


def spawn(*args: str, cwd: Path, code: str = "", **options) -> subprocess.Popen[str]:
    """Start the command line as a process of its own; ``code`` runs before it."""
    env = {**os.environ, "PYTHONPATH": str(ROOT), **options.pop("env", {})}
    start = ["-c", f"{code}\nfrom rtbow.cli.main import main\nmain()"] if code else ["-m", "rtbow"]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | options
    # Whoever runs the tests in the background of a shell has Ctrl-C ignored, and so have they.
    streams.setdefault("preexec_fn", lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    return subprocess.Popen([sys.executable, *start, *args], cwd=cwd, env=env, text=True, **streams)


def execute(*args: str, **options) -> Result:
    """Run the command line as a process of its own."""
    with spawn(*args, **options) as process:
        out, err = process.communicate(timeout=240)
    return Result(process.returncode, out or "", err or "")


def names(folder: Path) -> list[str]:
    """Return the names of everything in a folder."""
    return sorted(path.name for path in folder.iterdir())


def contents(folder: Path) -> dict[str, bytes]:
    """Return the bytes of each file in a folder and those inside it, by path."""
    files = (p for p in folder.rglob("*") if p.is_file() and not p.is_symlink())
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def assert_message(result: Result, code: int, *words: str) -> None:
    """Check that a run ended with a message on stderr and nothing else."""
    assert result.code == code, result
    assert result.out == ""
    assert result.err.startswith("rtbow")
    assert "Traceback" not in result.err
    assert "Warning" not in result.err
    for word in words:
        assert word in result.err


def assert_refused(result: Result, *words: str) -> None:
    """Check that a run ended with one line about wrong input."""
    assert_message(result, 2, *words)
    assert result.err.count("\n") == 1, result.err
