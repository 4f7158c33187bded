"""Outputs: which names are taken, and what becomes of files when they cannot be written."""

from __future__ import annotations

import errno
import os
import resource

import pytest

import rtbow.base.files
from command_line import FAST, SMALL, Result, assert_refused, contents, execute
from rtbow.frames.image import read_exr
from scene_samples import UNIFORM


@pytest.mark.parametrize(
    "name", ["with space.exr", "regenbogen-ä-虹.png", "UPPER.EXR", "./here.exr", ".hidden.png"]
)
def test_names_of_all_kinds(call, tmp_path, name):
    assert call("render", "uniform", "-o", name, "--size", "4x3") == Result(0, f"{name}\n", FAST)
    assert (tmp_path / name).stat().st_size > 100


def test_a_device_beside_a_file(call, tmp_path):
    (tmp_path / "null.exr").symlink_to(os.devnull)
    outputs = ("-o", "x.exr", "-o", "null.exr")
    assert call("render", "uniform", *outputs, "--size", "4x3", "-q") == Result(0, "", "")
    assert list(contents(tmp_path)) == ["x.exr"]
    assert (tmp_path / "null.exr").is_symlink()


@pytest.mark.usefixtures("no_rendering")
@pytest.mark.parametrize("again", ["x.exr", "./x.exr"])
def test_the_same_output_twice_is_refused(call, tmp_path, again):
    result = call("render", "uniform", "-o", "x.exr", "-o", "x.png", "-o", again)
    assert_refused(result, f"-o {again}: is given twice; give it once")
    assert contents(tmp_path) == {}


def test_an_output_in_the_scenes_place(call, tmp_path, no_rendering):
    assert_refused(call("render", "bow.png"), "did you mean -o bow.png?")
    for name, data in {"notes": b"rain", "shot": b"\x89PNG\r\n", "list": b"380,1\n"}.items():
        (tmp_path / name).write_bytes(data)
        result = call("render", name, "-o", "x.exr")
        assert_refused(result, "no built-in scene")
        assert ".toml" not in result.err
    (tmp_path / "rain.txt").write_text(UNIFORM, "utf-8")
    assert_refused(call("render", "rain.txt", "-o", "x.exr"), "once its name ends with .toml")


@pytest.mark.parametrize(
    ("output", "words"),
    [
        ("x.jpg", "suffix .jpg is not known; must be .exr or .png; write for example x.exr"),
        ("x", "has no suffix; must be .exr or .png"),
        ("", "has no suffix"),
        (".", "has no suffix"),
        ("/dev/null", "/dev/null: the name has no suffix"),
        ("out/x.exr", "there is no folder out; create it with: mkdir -p out"),
        ("folder.exr", "folder.exr: is a folder"),
        ("file/x.exr", "file is a file; must be a folder"),
        (f"{'a' * 300}.exr", "File name too long"),
        ("x\0.exr", "not a file name"),
    ],
)
def test_wrong_outputs(call, tmp_path, no_rendering, output, words):
    (tmp_path / "folder.exr").mkdir()
    (tmp_path / "file").write_bytes(b"old")
    # The good one comes first, and is not written either.
    assert_refused(call("render", "uniform", "-o", "good.exr", "-o", output), words)
    assert contents(tmp_path) == {"file": b"old"}


def test_no_output_at_all(call):
    assert_refused(call("render", "uniform"), "'-o' / '--output'", "rtbow render --help")
    assert_refused(call("render", "uniform", "-o"), "-o")


@pytest.mark.parametrize(
    ("code", "words"),
    [(errno.EACCES, "Permission denied; choose"), (errno.EROFS, "Read-only file system; choose")],
)
def test_a_folder_that_cannot_be_written(call, tmp_path, monkeypatch, no_rendering, code, words):
    def refuse(path):
        raise OSError(code, os.strerror(code), os.fspath(path))

    # Simulated, since a superuser may write anywhere.
    monkeypatch.setattr(rtbow.base.files, "_create", refuse)
    assert_refused(call("render", "uniform", "-o", "x.exr"), "x.exr: cannot be written", words)
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_a_full_disk(call, tmp_path, suffix):
    (tmp_path / f"x.{suffix}").symlink_to("/dev/full")
    result = call("render", "uniform", "-o", f"x.{suffix}", *SMALL)
    assert_refused(result, f"x.{suffix}: cannot be written: No space left on device; free")
    assert contents(tmp_path) == {}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("verb", "suffix"),
    [
        ("render uniform --size 64x36 -o", "exr"),
        ("render uniform --size 64x36 -o", "png"),
        ("table export --radius-um 100", "exr"),
        ("table export --radius-um 100", "npz"),
    ],
)
def test_a_limit_on_file_size_spares_the_old_file(tmp_path, verb, suffix):
    (tmp_path / f"x.{suffix}").write_bytes(b"old")
    limit = (1024, resource.RLIM_INFINITY)
    result = execute(
        *verb.split(),
        f"x.{suffix}",
        cwd=tmp_path,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit),
    )
    assert_refused(result, f"x.{suffix}: cannot be written", "ulimit -f")
    assert contents(tmp_path) == {f"x.{suffix}": b"old"}


@pytest.mark.parametrize("suffix", ["exr", "png"])
@pytest.mark.parametrize("step", ["write", "fsync", "replace"])
def test_a_failure_at_the_end_spares_the_old_file(call, tmp_path, monkeypatch, suffix, step):
    (tmp_path / f"x.{suffix}").write_bytes(b"old")

    def fail(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(rtbow.base.files.os, step, fail)
    result = call("render", "uniform", "-o", f"x.{suffix}", "--size", "4x3")
    monkeypatch.undo()
    assert_refused(result, f"x.{suffix}: cannot be written: No space left on device")
    assert contents(tmp_path) == {f"x.{suffix}": b"old"}


def test_full_standard_output(tmp_path):
    with open("/dev/full", "w") as full:
        result = execute("scenes", cwd=tmp_path, stdout=full)
    assert_refused(result, "standard output cannot be written: No space left on device")


def test_closed_standard_output(tmp_path):
    """The frame is written all the same."""
    args = ("render", "uniform", "-o", "x.exr", "--size", "4x3")
    result = execute(*args, cwd=tmp_path, preexec_fn=lambda: os.close(1))
    assert (result.code, result.err) == (0, FAST)
    assert read_exr(tmp_path / "x.exr")[0].shape == (3, 4, 3)


def test_a_reader_that_leaves(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as pipe:
        result = execute("scenes", cwd=tmp_path, stdout=pipe)
    assert (result.code, result.err) == (141, "")
