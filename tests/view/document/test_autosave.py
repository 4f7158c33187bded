"""Files of unsaved scenes: each window has its own, and takes over what earlier ones have left."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rtbow.scene.text.file import builtin_scenes, load_scene
from rtbow.scene.text.values import changed_scene
from rtbow.view.document.autosave import Autosave, origin
from rtbow.view.document.edits import Opened


@pytest.fixture(autouse=True)
def data(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    return tmp_path / "rtbow" / "unsaved"


def opened(name: str | None = "uniform") -> Opened:
    return Opened(load_scene(name), name)


def changed(scene, altitude_deg: float):
    return changed_scene(scene, {"light.0.altitude_deg": altitude_deg})


def left_by_another(data: Path, name: str | None = "uniform", altitude_deg: float = 3.0) -> Path:
    """The file of a window whose process has ended."""
    window, source = Autosave(), opened(name)
    window.keep(source, changed(source.scene, altitude_deg))
    (unsaved,) = window.finish()
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    path = unsaved.path
    return path.rename(path.with_name(path.name.replace(f"-{os.getpid()}-", f"-{ended.pid}-")))


def test_two_windows_on_one_scene_keep_and_forget_their_own(data):
    source = opened()
    first, second = Autosave(), Autosave()
    first.keep(source, changed(source.scene, 3.0))
    second.keep(source, changed(source.scene, 4.0))
    second.forget(source)
    assert second.finish() == []
    (unsaved,) = first.finish()
    assert list(data.iterdir()) == [unsaved.path]
    assert load_scene(unsaved.path).light[0].altitude_deg == 3.0


def test_windows_that_are_open_are_not_robbed(data):
    source = opened()
    window = Autosave()
    window.keep(source, changed(source.scene, 3.0))
    window.finish()
    assert Autosave().left() == []
    (path,) = data.iterdir()
    parents = path.with_name(path.name.replace(f"-{os.getpid()}-", f"-{os.getppid()}-"))
    path.rename(parents)
    assert Autosave().left() == []


def test_what_was_left_goes_to_the_first_who_takes_it(data):
    path = left_by_another(data)
    first, second = Autosave(), Autosave()
    assert first.left() == second.left() == [path]
    source, scene = opened(origin(path)), load_scene(path)
    assert first.claim(path, source, scene)
    assert not second.claim(path, source, scene)
    assert second.left() == []
    first.keep(source, changed(scene, 5.0))
    (unsaved,) = first.finish()
    assert [load_scene(file).light[0].altitude_deg for file in data.iterdir()] == [5.0]
    assert unsaved.path != path


@pytest.mark.parametrize("name", [None, "uniform", "mine.toml"])
def test_a_file_says_what_was_changed(data, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(f"{builtin_scenes()['uniform'].read_text()}\n# mine\n")
    path = left_by_another(data, name)
    assert origin(path) == (str(tmp_path / name) if name == "mine.toml" else name)
    if name == "mine.toml":
        assert path.read_text().endswith("\n# mine\n")


def test_the_newest_that_were_left_come_first_and_very_old_ones_go(data):
    path = left_by_another(data)
    for number in range(25):
        copy = path.with_name(re.sub(r"[0-9a-f]+\.toml$", f"{number:08x}.toml", path.name))
        copy.write_bytes(path.read_bytes())
        os.utime(copy, (number, number))
    path.unlink()
    left = Autosave().left()
    assert [int(file.stat().st_mtime) for file in left] == list(range(24, 4, -1))
    assert len(list(data.iterdir())) == 20


def test_a_folder_that_cannot_be_written_is_told(data):
    data.parent.mkdir(parents=True)
    data.write_text("not a folder")
    window, source = Autosave(), opened()
    assert window.left() == []
    window.keep(source, changed(source.scene, 3.0))
    (unsaved,) = window.finish()
    assert unsaved.path is None
    assert unsaved.problem
    assert unsaved.command == "rtbow view uniform --set light.0.altitude_deg=3.0"


def test_a_moved_camera_alone_needs_no_file(data):
    source = opened()
    scene = changed_scene(source.scene, {"camera.fov_deg": 33.0})
    for cameras in (False, True):
        window = Autosave()
        window.keep(source, scene)
        (unsaved,) = window.finish(cameras=cameras)
        assert (unsaved.path is not None) == cameras
        assert not unsaved.problem
    assert len(list(data.iterdir())) == 1
