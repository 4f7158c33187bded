"""Scenes written as TOML, and as overrides of another scene, read as the same scene."""

import itertools
from pathlib import Path

import pytest

from rtbow.base.errors import InputError
from rtbow.bench.random_scenes import random_scene
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene, parse_set, scene_from_text
from rtbow.scene.text.schema import toml_text
from rtbow.scene.text.values import changed_scene, differences, scene_files, scene_text, values_of

NAMES = sorted(builtin_scenes())


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    return [load_scene(name) for name in NAMES] + [random_scene(n, {}) for n in range(1, 11)]


def test_toml_of_a_scene_reads_as_the_same_scene(scenes):
    for scene in scenes:
        assert scene_from_text(scene_text(scene)) == scene


def test_toml_of_compared_scenes_has_their_right_part():
    scene = load_scene("figures/fig7a") if "figures/fig7a" in NAMES else load_scene()
    split = changed_scene(scene, {"compare.right": {"scattering.orders": [1]}})
    again = scene_from_text(scene_text(split))
    assert again.parts()[1][0].scattering.orders == (1,)
    assert again == split


def test_any_digits_of_a_number_are_kept():
    scene = changed_scene(load_scene(), {"camera.azimuth_deg": 0.1 + 0.2})
    assert scene_from_text(scene_text(scene)).camera.azimuth_deg == 0.1 + 0.2


def test_volumes_beside_the_file_are_named_relative_to_it(tmp_path: Path):
    inside, outside = tmp_path / "rain" / "a.npz", tmp_path.parent / "b.npz"
    scene = load_scene("shower", {"droplets.file": inside})
    assert 'file = "rain/a.npz"' in scene_text(scene, tmp_path)
    scene = load_scene("shower", {"droplets.file": outside})
    assert f'file = "{outside.as_posix()}"' in scene_text(scene, tmp_path)


def test_differences_lead_from_any_scene_to_any_other(scenes):
    for one, other in itertools.permutations(scenes, 2):
        assert changed_scene(one, differences(one, other)) == other


def test_differences_as_typed_lead_there_too(scenes):
    for one, other in itertools.pairwise(scenes):
        typed = [f"{key}={toml_text(value)}" for key, value in differences(one, other).items()]
        assert changed_scene(one, dict(map(parse_set, typed))) == other


def test_equal_scenes_do_not_differ(scenes):
    for scene in scenes:
        assert differences(scene, scene) == {}


def test_one_changed_value_is_one_difference():
    one = load_scene()
    other = changed_scene(one, {"light.0.altitude_deg": 7.5})
    assert differences(one, other) == {"light.0.altitude_deg": 7.5}


def test_none_takes_a_value_out_when_typed():
    scene = load_scene(None, {"camera.polarizer_deg": 30.0})
    assert changed_scene(scene, dict([parse_set("camera.polarizer_deg=none")])) == load_scene()


def test_refused_changes_name_the_key():
    with pytest.raises(InputError, match=r"light\.0\.altitude_deg = 100"):
        changed_scene(load_scene(), {"light.0.altitude_deg": 100})


def test_values_have_no_tuples():
    assert isinstance(values_of(load_scene())["light"], list)


def test_files_that_a_scene_names(tmp_path: Path):
    assert scene_files(load_scene("uniform")) == ()
    volume, lamp, other = (str(tmp_path / name) for name in ("a.npz", "b.csv", "c.csv"))
    split = load_scene(
        "uniform",
        {
            "droplets.file": volume,
            "light.0.spectrum": lamp,
            "compare.right": {"light.0.spectrum": other},
        },
    )
    assert sorted(scene_files(split)) == [volume, lamp, other]


def test_what_the_right_part_leaves_out_is_kept():
    scene = load_scene(None, dict([parse_set("compare.right.atmosphere=none")]))
    assert scene.atmosphere is not None
    assert scene.parts()[1][0].atmosphere is None
    again = scene_from_text(scene_text(scene))
    assert again.parts()[1][0] == scene.parts()[1][0]
    typed = [f"{key}={toml_text(value)}" for key, value in differences(load_scene(), scene).items()]
    assert changed_scene(load_scene(), dict(map(parse_set, typed))).parts()[1][0].atmosphere is None


@pytest.mark.parametrize("part", ['a"b', "a\\b", "a\tb", "a\nb", "\x7f", "虹 é", "'"])
def test_any_name_of_a_file_is_kept(part):
    scene = changed_scene(load_scene("shower"), {"droplets.file": f"/rain/{part}.npz"})
    assert scene_from_text(scene_text(scene)) == scene


def test_lists_of_numbers_are_written_on_one_line():
    text = scene_text(load_scene("uniform"))
    assert "\nbox_m = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]\n" in text
    assert "\norders = [1, 2]\n" in text


def test_tables_are_set_apart_by_empty_lines():
    text = scene_text(load_scene("uniform"))
    assert all(part.startswith("[") for part in text.split("\n\n"))
    assert text.count("\n[") == text.count("\n\n[") > 4
