"""The command line as tests run it, and checks of how a run ended."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from checkout import ROOT

SMALL = ("--size", "32x18")
FAST = "method fast\n"
"""What stderr says where ``auto`` chose."""


@dataclass(frozen=True)
class Result:
    """How a run ended."""

    code: int
    out: str
    err: str


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
