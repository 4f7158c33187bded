"""Changing a scene by hand: nothing refused is taken, nothing taken is lost."""

import shlex
from pathlib import Path

import pytest

from rtbow.errors import InputError
from rtbow.scene_file import load_scene, parse_set
from rtbow.view.edits import Edits, Opened


@pytest.fixture
def edits() -> Edits:
    return Edits(Opened(load_scene("uniform"), "uniform"))


def altitude(edits: Edits) -> float:
    return edits.scene.light[0].altitude_deg


def test_a_refused_change_leaves_all_as_it_was(edits):
    before = edits.scene
    with pytest.raises(InputError, match=r"light\.0\.altitude_deg = 91"):
        edits.change({"light.0.altitude_deg": 91.0})
    assert edits.scene is before
    assert not edits.can_undo


def test_changes_are_undone_and_made_again_in_order(edits):
    first = altitude(edits)
    edits.change({"light.0.altitude_deg": 5.0})
    edits.change({"light.0.altitude_deg": 6.0})
    edits.undo()
    assert altitude(edits) == 5.0
    edits.undo()
    assert altitude(edits) == first
    edits.undo()
    edits.redo()
    edits.redo()
    edits.redo()
    assert altitude(edits) == 6.0
    assert not edits.can_redo


def test_a_drag_is_one_change(edits):
    first = altitude(edits)
    for value in (1.0, 2.0, 3.0):
        edits.change({"light.0.altitude_deg": value}, gesture="drag")
    edits.end_gesture()
    edits.change({"light.0.altitude_deg": 4.0}, gesture="drag")
    edits.undo()
    assert altitude(edits) == 3.0
    edits.undo()
    assert altitude(edits) == first


def test_a_new_change_forgets_what_was_undone(edits):
    edits.change({"light.0.altitude_deg": 5.0})
    edits.undo()
    edits.change({"camera.fov_deg": 50.0})
    assert not edits.can_redo


def test_reset_gives_one_value_back(edits):
    first = altitude(edits)
    edits.change({"light.0.altitude_deg": 5.0, "camera.fov_deg": 50.0})
    edits.reset("light.0.altitude_deg")
    assert altitude(edits) == first
    assert edits.scene.camera.fov_deg == 50.0


def test_reset_gives_a_value_back_that_was_taken_out_with_its_table(edits):
    before = edits.scene
    edits.change(
        {"droplets.radius": {"distribution": "gamma", "mixing": "local",
                             "effective_radius_um": 300.0, "effective_variance": 0.1}}
    )  # fmt: skip
    edits.reset("droplets.radius.effective_radius_um")
    assert edits.scene == before


def test_opening_another_scene_can_be_undone(edits):
    first = edits.scene
    edits.change({"camera.fov_deg": 50.0})
    edits.open(Opened(load_scene("red-sun"), "red-sun"))
    assert edits.changes == {}
    edits.undo()
    assert edits.opened.name == "uniform"
    edits.reset("camera.fov_deg")
    assert edits.scene == first


def test_a_saved_scene_loads_as_the_same(edits, tmp_path: Path):
    edits.change({"light.0.altitude_deg": 0.1 + 0.2})
    assert edits.unsaved
    edits.save(tmp_path / "found.toml")
    assert not edits.unsaved
    assert load_scene(tmp_path / "found.toml") == edits.scene
    assert edits.command() == f"rtbow render {tmp_path / 'found.toml'}"


def test_a_scene_is_saved_as_toml_alone(edits, tmp_path: Path):
    with pytest.raises(InputError, match=r"ends with \.toml"):
        edits.save(tmp_path / "found.txt")


def test_the_command_makes_the_same_scene(edits):
    edits.change({"light.0.spectrum": "FL2", "camera.polarizer_deg": 10.0})
    edits.change({"droplets.radius.radius_um": 333.3})
    words = shlex.split(edits.command("render", "-o", "a b.exr"))
    assert words[:3] == ["rtbow", "render", "uniform"]
    assert words[-2:] == ["-o", "a b.exr"]
    assert words[3:-2:2] == ["--set"] * 3
    assert load_scene("uniform", dict(map(parse_set, words[4:-2:2]))) == edits.scene
