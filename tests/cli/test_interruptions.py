"""Ctrl-C and SIGTERM: what runs ends in order, and no file is left half written."""

from __future__ import annotations

import fcntl
import os
import pty
import re
import select
import signal
import struct
import termios

import pytest

import rtbow.base.files
import rtbow.cli.main
from command_line import Result, contents, spawn

pytestmark = pytest.mark.slow

# Minutes of work in rows of a few milliseconds: a narrow strip of sky, full of drops.
TALL = "--size 64x16384 --set camera.fov_deg=0.1 --set render.wavelength_step_nm=0.1"
LONG = {
    "spectral": f"render uniform -o x.exr -o x.png --method spectral {TALL}",
    "reference": f"render uniform -o x.exr --method reference {TALL}",
    "export": "table export x.npz --angles 15000 --disc 5",
}


def read_terminal(reader: int, until: bytes | None = None) -> bytes:
    """Read what is shown until it matches, or until no process writes there any more."""
    shown = b""
    while until is None or not re.search(until, shown):
        assert select.select([reader], [], [], 60.0)[0], shown
        try:
            data = os.read(reader, 1000)
        except OSError:  # how Linux says that the terminal has no more writers
            break
        if not data:
            break
        shown += data
    return shown


@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, b"interrupted"), (signal.SIGTERM, 143, b"terminated")],
    ids=["ctrl-c", "sigterm"],
)
@pytest.mark.parametrize("work", LONG)
def test_long_work_is_broken_off(tmp_path, work, number, code, word):
    for name in ("x.exr", "x.npz"):
        (tmp_path / name).write_bytes(b"old")
    reader, terminal = pty.openpty()
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    process = spawn(*LONG[work].split(), cwd=tmp_path, stderr=terminal)
    try:
        os.close(terminal)
        shown = read_terminal(reader, until=rb" [1-9][0-9]*/[0-9]")  # rows that are done
        process.send_signal(number)
        if number == signal.SIGTERM:
            process.send_signal(number)  # as `timeout` does, which ends the group, too
        shown += read_terminal(reader)
        out, _ = process.communicate(timeout=60)
    finally:
        process.kill()
        os.close(reader)
    assert process.returncode == code
    assert out == ""
    assert b"Traceback" not in shown
    assert b"Exception ignored" not in shown
    assert shown.rstrip().endswith(word + b"; nothing was left half written")
    assert contents(tmp_path) == {"x.exr": b"old", "x.npz": b"old"}


@pytest.mark.parametrize("suffix", ["exr", "png"])
@pytest.mark.parametrize("step", ["write", "fsync", "replace"])
def test_ctrl_c_while_writing(call, tmp_path, monkeypatch, suffix, step):
    (tmp_path / f"x.{suffix}").write_bytes(b"old")

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(rtbow.base.files.os, step, interrupt)
    result = call("render", "uniform", "-o", f"x.{suffix}", "--size", "4x3")
    monkeypatch.undo()
    assert result.code == 130
    assert result.err.strip() == "interrupted; nothing was left half written"
    assert contents(tmp_path) == {f"x.{suffix}": b"old"}


@pytest.mark.parametrize("suffix", ["exr", "png"])
@pytest.mark.parametrize("step", ["write", "fsync", "replace"])
def test_sigterm_while_writing(call, tmp_path, monkeypatch, suffix, step):
    (tmp_path / f"x.{suffix}").write_bytes(b"old")

    def terminate(*_):
        signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(rtbow.base.files.os, step, terminate)
    result = call("render", "uniform", "-o", f"x.{suffix}", "--size", "4x3", "-q")
    monkeypatch.undo()
    assert result == Result(143, "", "terminated; nothing was left half written\n")
    assert contents(tmp_path) == {f"x.{suffix}": b"old"}
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_sigterm_that_is_ignored_stays_so(call, monkeypatch):
    monkeypatch.setattr(
        rtbow.cli.main.rtbow, "main", lambda **_: signal.raise_signal(signal.SIGTERM)
    )
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        assert call() == Result(0, "", "")
    finally:
        signal.signal(signal.SIGTERM, before)


def test_ctrl_c_within_compiled_code(monkeypatch, capsys):
    def call(**_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SystemError("returned a result with an exception set") from error

    monkeypatch.setattr(rtbow.cli.main.rtbow, "main", call)
    with pytest.raises(SystemExit) as stop:
        rtbow.cli.main.main()
    assert stop.value.code == 130
    assert capsys.readouterr().err == "interrupted; nothing was left half written\n"


def test_sigterm_within_compiled_code(call, monkeypatch):
    def work(**_):
        try:
            signal.raise_signal(signal.SIGTERM)
        except SystemExit as error:
            raise SystemError("returned a result with an exception set") from error

    monkeypatch.setattr(rtbow.cli.main.rtbow, "main", work)
    assert call() == Result(143, "", "terminated; nothing was left half written\n")
