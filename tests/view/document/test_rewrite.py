"""Changed values go into the text that a person wrote, and nothing else of it changes."""

from pathlib import Path

import pytest

from rtbow.base.errors import InputError
from rtbow.scene.text.file import builtin_scenes, load_scene, scene_from_text
from rtbow.scene.text.values import changed_scene
from rtbow.view.document.rewrite import rewritten

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


POINT = {"type": "point", "position_m": [1.0, 2.0, 3.0], "luminous_flux_lm": 500.0}
LAMP = TEXT[TEXT.index("[[light]]\ntype") : TEXT.index("# the rain")]


def test_lights_that_stay_keep_their_text(tmp_path):
    scene = scene_from_text(TEXT)
    sun, lamp = scene.light
    first = rewritten(TEXT, scene.model_copy(update={"light": (sun,)}), tmp_path)
    assert first == TEXT.replace(LAMP, "") or "measured" in first
    assert "luminous_flux_lm" not in first
    last = rewritten(TEXT, scene.model_copy(update={"light": (lamp,)}), tmp_path)
    assert "measured" not in last
    assert LAMP.strip() in last
    assert "# the rain" in last
    three = changed_scene(scene, {"light": [*(one.model_dump() for one in scene.light), POINT]})
    found = rewritten(TEXT, three, tmp_path)
    assert "measured" in found
    assert LAMP.strip() in found
    assert scene_from_text(found) == three


def test_a_sun_becomes_a_lamp(tmp_path):
    found = after({"light.0": POINT})
    assert found.count('type = "point"') == 2
    assert "# where I stood" in found
    assert "altitude_deg" not in found


@pytest.mark.parametrize("ending", ["light = [{ altitude_deg = 3.0 }, { altitude_deg = 4.0 }]\n"])
def test_lights_on_one_line_stay_there(tmp_path, ending):
    text = ending + TEXT[: TEXT.index("[[light]]")] + TEXT[TEXT.index("# the rain") :]
    found = after({"light.1": POINT}, text)
    assert found.startswith("light = [{ altitude_deg = 3.0 }, {")
    assert after({"light.1.altitude_deg": 5.0}, text) == text.replace("4.0", "5.0")


def test_whatever_is_changed_the_text_reads_as_that_scene(tmp_path):
    """All built-in texts, each changed in ways that people change scenes."""
    changes = (
        {"light.0.spectrum": "FL2"}, {"light.0": POINT}, {"camera.fov_deg": 33.0},
        {"atmosphere.rayleigh": False}, {"scattering.theory": "mie"}, {"render.steps": 50},
        {"compare": {"split": 0.3, "right": {"camera.fov_deg": 20.0}}}, {"camera.polarizer_deg": 3},
        {"droplets.radius": {"distribution": "constant", "radius_um": 9.0}},
    )  # fmt: skip
    tried = 0
    for name, path in builtin_scenes().items():
        text, scene = path.read_text(), load_scene(name)
        for change in changes:
            try:
                changed = changed_scene(scene, change)
            except InputError:
                continue
            found = rewritten(text, changed, path.parent)
            assert found is not None, (name, change)
            assert scene_from_text(found, folder=path.parent) == changed
            first = text.splitlines()[0]
            assert not first.startswith("#") or found.startswith(first)
            tried += 1
    assert tried > 100


def test_a_volume_is_named_from_where_the_file_lies(tmp_path):
    rain = builtin_scenes()["shower"]
    text = rain.read_text()
    changed = changed_scene(load_scene("shower"), {"light.0.altitude_deg": 7.5})
    beside = rewritten(text, changed, rain.parent)
    assert 'file = "shower.npz"' in beside
    # Elsewhere the same text would name another file.
    elsewhere = rewritten(text, changed, tmp_path)
    assert elsewhere != beside
    assert scene_from_text(elsewhere, folder=tmp_path) == changed


@pytest.mark.parametrize("text", ["[camera", "", "light = 3", "[camera]\nfov_deg = 900.0"])
def test_text_that_is_no_scene_is_not_changed(text, tmp_path):
    assert rewritten(text, scene_from_text(TEXT), tmp_path) is None


def test_what_reads_as_another_scene_is_not_given(tmp_path, monkeypatch):
    changed = changed_scene(scene_from_text(TEXT), {"camera.fov_deg": 61.0})
    assert rewritten(TEXT, changed, tmp_path) is not None
    monkeypatch.setattr(
        "rtbow.view.document.rewrite._merge", lambda *_: None
    )  # as if it had missed one
    assert rewritten(TEXT, changed, tmp_path) is None
