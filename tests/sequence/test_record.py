"""Records: what counts as done, and what is left of them when a process is killed."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest

from command_line import SMALL, execute, names, spawn
from rtbow.base.errors import InputError
from rtbow.frames.image import read_exr, write_exr
from rtbow.sequence.outputs import Pattern
from rtbow.sequence.record import Record, is_record, open_records

DARK = np.zeros((2, 2, 3), np.float32)


@pytest.fixture
def at_once(monkeypatch):
    """Every frame is written into the record as soon as it is done."""
    monkeypatch.setattr("rtbow.sequence.record._SECONDS_BETWEEN_WRITES", -1.0)


@pytest.fixture
def record(tmp_path, monkeypatch):
    """The path of a record that lists two frames."""
    monkeypatch.chdir(tmp_path)
    with open_records(["f.sequence.json"]) as records:
        for number in (0, 1):
            write_exr(f"f_{number}.exr", DARK + number, {})
            records["f.sequence.json"].add(f"f_{number}.exr", f"scene {number}")
        records["f.sequence.json"].set_exposure("scenes", 12.5)
    return "f.sequence.json"


def test_what_was_done_is_known(record):
    known = Record(record)
    assert known.has("f_0.exr", "scene 0")
    assert known.has("f_1.exr", "scene 1")
    assert not known.has("f_0.exr", "scene 1")
    assert not known.has("f_2.exr", "scene 2")
    assert known.exposure_ev("scenes") == 12.5
    assert known.exposure_ev("others") is None


def test_frames_that_are_gone_or_others_are_not_done(record):
    os.remove("f_0.exr")
    status, data = os.stat("f_1.exr"), Path("f_1.exr").read_bytes()
    Path("f_1.exr").write_bytes(data[:-1] + bytes([data[-1] ^ 1]))  # as large, and as old
    os.utime("f_1.exr", ns=(status.st_atime_ns, status.st_mtime_ns))
    assert not Record(record).has("f_0.exr", "scene 0")
    assert not Record(record).has("f_1.exr", "scene 1")


def test_copies_and_renamed_frames_are_done(record):
    os.replace("f_1.exr", "f_0.exr")
    os.utime("f_0.exr", (0, 0))
    assert Record(record).has("f_0.exr", "scene 1")
    assert not Record(record).has("f_0.exr", "scene 0")


def test_devices_are_not_listed(record):
    os.symlink(os.devnull, "f_2.exr")
    known = Record(record)
    known.add("f_2.exr", "scene 2")
    assert not known.has("f_2.exr", "scene 2")


def test_each_frame_is_listed_when_it_is_whole(record, at_once):
    known = Record(record)
    for number in (2, 3):
        write_exr(f"f_{number}.exr", DARK + number, {})
        known.add(f"f_{number}.exr", f"scene {number}")
        assert Record(record).has(f"f_{number}.exr", f"scene {number}")
    assert Record(record).has("f_0.exr", "scene 0")


def test_names_of_any_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"\xff.exr")
    write_exr(name, DARK, {})
    with open_records(["f.sequence.json"]) as records:
        records["f.sequence.json"].add(name, "\udcff")
    assert Record("f.sequence.json").has(name, "\udcff")


def test_what_a_record_is(record):
    assert is_record(record)
    content = json.loads(Path(record).read_bytes())
    for key, value in (("frames", None), ("frames", {"a": "b"}), ("exposure_ev", {"a": 1e9})):
        Path(record).write_text(json.dumps({**content, key: value}), encoding="utf-8")
        assert not is_record(record), key
    assert not is_record("missing")
    assert not is_record(".")


def test_a_record_that_cannot_be_written_is_explained(tmp_path):
    with (
        pytest.raises(InputError, match=r"f\.sequence\.json: there is no folder"),
        open_records([f"{tmp_path}/no/f.sequence.json"]) as records,
    ):
        records[f"{tmp_path}/no/f.sequence.json"].set_exposure("scenes", 1.0)


@pytest.mark.parametrize(
    ("pattern", "name"),
    [
        ("out/frame_%04d.exr", "out/frame.sequence.json"),
        ("%d.png", "frames.sequence.json"),
        ("100%%_%d.png", "100%.sequence.json"),
        ("50%dry/100%%/f%02d_b.PNG", "50%dry/100%/f_b.sequence.json"),
    ],
)
def test_where_records_lie(pattern, name):
    assert Pattern(pattern).record == name


def test_killed_and_again(tmp_path):
    """Without a moment to tidy up: all that is listed is whole, and is not drawn again."""
    args = [
        "animate",
        "uniform",
        "--key",
        "light.0.altitude_deg=2:40",
        "--frames",
        "60",
        "-o",
        "f_%02d.exr",
    ]
    every = "from rtbow.sequence import record; record._SECONDS_BETWEEN_WRITES = -1.0"
    with spawn(*args, *SMALL, cwd=tmp_path, code=every) as process:
        try:
            while not (tmp_path / "f_04.exr").exists():
                assert process.poll() is None
            process.send_signal(signal.SIGKILL)
            process.communicate(timeout=60)
        finally:
            process.kill()
    listed = json.loads((tmp_path / "f.sequence.json").read_bytes())["frames"]
    assert 4 <= len(listed) < 60
    for name in listed:
        read_exr(tmp_path / name)
    done = execute(*args, *SMALL, cwd=tmp_path)
    assert done.err.endswith(f", {len(listed)} kept\n")
    assert len([name for name in names(tmp_path) if name.endswith(".exr")]) == 60
