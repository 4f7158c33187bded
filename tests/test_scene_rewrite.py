"""Changed values go into the text that a person wrote, and nothing else of it changes."""

from pathlib import Path

import pytest

from rtbow.scene_file import builtin_scenes, load_scene, scene_from_text
from rtbow.scene_rewrite import rewritten
from rtbow.scene_values import changed_scene

TEXT = """\
# My evening

[camera]   # where I stood
position_m = [0.0, 0.0, 1.7]
fov_deg = 60.0 # a wide lens

[[light]]
altitude_deg = 12.5  # measured
[[light]]
type = "point"
position_m = [3.0, 8.0, 4.0]
luminous_flux_lm = 800.0

# the rain
[droplets]
box_m = [[-200.0, 100.0, 0.0], [200.0, 300.0, 200.0]]
radius = { distribution = "constant", radius_um = 300.0 } # small
density = { number_per_m3 = 1000.0 }
"""


def after(changes, text=TEXT, folder="."):
    scene = changed_scene(scene_from_text(text), changes)
    found = rewritten(text, scene, Path(folder))
    assert found is None or scene_from_text(found, folder=Path(folder)) == scene
    return found


@pytest.mark.parametrize(
    ("changes", "old", "new"),
    [
        ({"light.0.altitude_deg": 7.25}, "altitude_deg = 12.5 ", "altitude_deg = 7.25 "),
        ({"light.1.luminous_flux_lm": 90.0}, "luminous_flux_lm = 800.0", "luminous_flux_lm = 90.0"),
        ({"camera.fov_deg": 61.0}, "fov_deg = 60.0 #", "fov_deg = 61.0 #"),
        ({"droplets.radius.radius_um": 80.0}, "radius_um = 300.0 }", "radius_um = 80.0 }"),
        ({"droplets.density.number_per_m3": 2.5}, "number_per_m3 = 1000.0", "number_per_m3 = 2.5"),
        ({"light.0.azimuth_deg": 190.0}, "measured\n", "measured\nazimuth_deg = 190.0\n"),
    ],
)
def test_one_value_alone_changes(changes, old, new):
    assert TEXT.count(old) == 1
    assert after(changes) == TEXT.replace(old, new)


def test_nothing_changes_nothing():
    assert after({}) == TEXT


def test_what_was_not_written_is_added_and_what_is_left_out_goes():
    found = after({"camera.azimuth_deg": 5.0, "render.max_delta_e": 0.4, "camera.fov_deg": 61.0})
    for line in (
        "# My evening",
        "[camera]   # where I stood",
        "# the rain",
        "altitude_deg = 12.5  #",
    ):
        assert line in found
    assert "azimuth_deg = 5.0" in found
    split = after({"compare": {"split": 0.3, "right": {"droplets.radius.radius_um": 80.0}}})
    assert "# small" in split
    assert after({"compare": None}, split).count("split") == 0


def test_lights_that_come_and_go_are_written(tmp_path):
    scene = scene_from_text(TEXT)
    alone = scene.model_copy(update={"light": scene.light[:1]})
    found = rewritten(TEXT, alone, tmp_path)
    assert found is not None
    assert scene_from_text(found) == alone
    assert "# measured" not in found or 'type = "point"' not in found


def test_text_that_says_something_else_by_now_is_not_trusted(tmp_path):
    """What cannot be had by replacing values is for the caller to write out whole."""
    assert rewritten("[camera", scene_from_text(TEXT), tmp_path) is None
    volume = builtin_scenes()["shower"]
    scene = load_scene("shower")
    assert rewritten(volume.read_text(), scene, volume.parent) == volume.read_text()
    elsewhere = rewritten(volume.read_text(), scene, tmp_path)
    assert elsewhere is None or scene_from_text(elsewhere, folder=tmp_path) == scene
