"""Albedo spectra by name and from files, and every way a file can be wrong."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.scene.text.values import scene_files, scene_text
from rtbow.world.measured.albedo import load_albedo
from rtbow.world.sky import surroundings

WHOLE = "wavelength_nm,value\n380,0.1\n580,0.5\n780,0.3\n"


def written(tmp_path, text):
    path = tmp_path / "soil.csv"
    path.write_text(text)
    return str(path)


def test_numbers_names_and_files(tmp_path):
    nm = np.array([380.0, 550.0, 580.0, 680.0])
    np.testing.assert_array_equal(load_albedo(0.3).at(nm), np.full(4, 0.3))
    # Feister and Grewe: the green of grass, and the edge of the infrared.
    np.testing.assert_allclose(load_albedo("grass").at(nm), [0.019, 0.089, 0.069, 0.035])
    found = load_albedo(written(tmp_path, WHOLE)).at(nm)
    np.testing.assert_allclose(found, [0.1, 0.44, 0.5, 0.4])


def test_a_changed_file_is_read_again(tmp_path):
    path = written(tmp_path, WHOLE)
    assert load_albedo(path).at(np.array([580.0])) == [0.5]
    written(tmp_path, WHOLE.replace("0.5", "0.6"))
    assert load_albedo(path).at(np.array([580.0])) == [0.6]


@pytest.mark.parametrize(
    "text",
    [
        "Wavelength (nm);Reflectance\n380;0,2\n780;0,2\n",
        "wavenumber (1/cm),reflectance\n12000,0.2\n27000,0.2\n",
    ],
)
def test_reflectances_are_shares_whatever_they_are_over(tmp_path, text):
    albedo = load_albedo(written(tmp_path, text))
    np.testing.assert_allclose(albedo.at(np.array([400.0, 700.0])), 0.2)


def test_means_hold_the_light(tmp_path):
    albedo = load_albedo(written(tmp_path, WHOLE))
    assert albedo.means(np.array([580.0]), 100.0)[0] == pytest.approx(0.5 - 0.25 * 50 * 0.003)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("wavelength_nm,value\n400,0.1\n700,0.3\n", ("400-700 nm", "380-780 nm")),
        ("wavelength_nm,value\n380,10\n550,34.2\n780,20\n", ("34.2", "550 nm", "divide")),
        ("wavelength_nm,value\n380,0.1\n550,1.2\n780,0.2\n", ("1.2", "must be 0..1")),
    ],
    ids=["short", "percent", "more"],
)
def test_what_is_no_albedo_is_refused(tmp_path, text, words):
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=r"soil\.csv") as refused:
        load_albedo(path)
    assert all(word in str(refused.value) for word in words)


def test_an_unknown_name_says_which_there_are():
    with pytest.raises(InputError, match=r"grass.* ground\.water = true"):
        load_albedo("water")


def test_what_is_wrong_is_named_by_scene_and_key(tmp_path):
    short = written(tmp_path, "wavelength_nm,value\n380,0.1\n600,0.3\n")
    for albedo, words in (("gras", "albedo 'gras' is not known"), (short, "380-600 nm")):
        scene = rtbow.load_scene("uniform", {"ground.albedo": albedo})
        with pytest.raises(InputError) as refused:
            surroundings(scene)
        assert str(refused.value).startswith("uniform: ground.albedo: ")
        assert words in str(refused.value)
        assert "\n" not in str(refused.value)


def test_a_scenes_file_is_found_beside_it(tmp_path):
    written(tmp_path, WHOLE)
    scene = tmp_path / "scene.toml"
    scene.write_text(scene_text(rtbow.load_scene("uniform")) + '\n[ground]\nalbedo = "soil.csv"\n')
    loaded = rtbow.load_scene(scene)
    assert scene_files(loaded) == (str(tmp_path / "soil.csv"),)
    assert 'albedo = "soil.csv"' in scene_text(loaded, tmp_path)
