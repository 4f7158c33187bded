"""``rtbow measure``, and the numbers that ``rtbow render`` gives of what it made."""

import json
import re

import numpy as np
import pytest

from command_line import Result, Summary, assert_refused, contents
from rtbow.base.exr import write_exr_channels
from rtbow.frames.image import read_exr, read_png, write_exr

WIDE = ("--size", "96x54")
"""Pixels of 0.8 degrees in scene uniform."""


@pytest.fixture
def frame(call):
    """A frame of scene uniform with drops of 1 mm, and what was said and written of it."""
    args = ("render", "uniform", *WIDE, "--set", "droplets.radius.radius_um=1000")
    result = call(*args, "-o", "bow.exr", "-o", "bow.png", "--json", "render.json")
    with open("render.json", encoding="utf-8") as file:
        return result, json.load(file)


def test_render_says_what_it_made_and_measure_says_the_same(call, frame):
    result, made = frame
    assert (result.code, result.out) == (0, "bow.exr\nbow.png\n")
    assert result.err == Summary("fast")
    assert result.err.count("\n") == 3
    assert made["scene"] == "uniform"
    assert made["outputs"] == ["bow.exr", "bow.png"]
    assert (made["method"], made["max_delta_e"], made["notes"]) == ("fast", 0.5, [])
    rgb, texts = read_exr("bow.exr")
    luminance = rgb @ np.array([0.2126, 0.7152, 0.0722])
    assert made["peak_luminance_cd_m2"] == pytest.approx(luminance.max(), rel=1e-6)
    assert made["mean_luminance_cd_m2"] == pytest.approx(luminance.mean(), rel=1e-4)
    # The frame knows the exposure of the picture of its run.
    assert texts["exposureEV100"] == read_png("bow.png")[1]["exposureEV100"]
    assert float(texts["exposureEV100"]) == pytest.approx(made["exposure_ev100"], rel=1e-5)
    assert [(bow["light"], bow["bow"]) for bow in made["bows"]] == [
        ("light.0", "primary"), ("light.0", "secondary"),
    ]  # fmt: skip
    # By Descartes, of light of 550 nm in water (index 1.3347): 41.9 and 51.3 degrees; drops of 1 mm
    # shift them by 0.1 and 0.2, the pixels by some tenths.
    primary, secondary = (bow["radius_deg"] for bow in made["bows"])
    assert primary == pytest.approx(41.8, abs=0.4)
    assert secondary == pytest.approx(51.5, abs=0.4)
    assert f"radius {primary:.2f}" in result.err

    told = call("measure", "bow.exr", "--json", "-")
    assert told.code == 0
    numbers = json.loads(told.out)
    assert numbers["bows"] == made["bows"]
    assert numbers["exposure_ev100"] == float(texts["exposureEV100"])
    assert re.search(rf"(?m)^primary: +radius {primary:.2f} ", told.err)
    quiet = call("measure", "bow.exr", "-q", "--json", "measure.json")
    assert quiet == Result(0, "", "")
    with open("measure.json", encoding="utf-8") as file:
        assert json.load(file) == numbers


def test_a_scene_is_rendered_first(call, tmp_path):
    args = ("--size", "24x14", "--set", "camera.azimuth_deg=180")
    result = call("measure", "uniform", *args, "--method", "reference")
    assert result.code == 0
    assert result.out.splitlines() == [
        "frame:        uniform, 24 x 14 pixels",
        "luminance:    peak 0, mean 0 cd/m2",
        "bows:         none that can be measured",
    ]
    black, coarse = result.err.splitlines()
    assert black.startswith("note: the picture is black: the rain (droplets.box_m) lies outside")
    assert "too coarse to measure bows" in coarse
    assert contents(tmp_path) == {}


def test_a_black_frame_says_why(call):
    args = ("--size", "8x5", "--set", "camera.azimuth_deg=180", "--method", "reference")
    result = call("render", "uniform", "-o", "x.exr", *args)
    note = result.err.splitlines()[-1]
    assert note.startswith("note: the picture is black: ")
    assert note.endswith("camera.azimuth_deg = 0 shows the bow")
    assert "exposureEV100" not in read_exr("x.exr")[1]  # there is no picture
    assert call("render", "uniform", "-o", "x.exr", *args, "-q") == Result(0, "", "")


def test_frames_without_a_scene_are_refused(call):
    rgb = np.ones((4, 6, 3), np.float32)
    write_exr("other.exr", rgb, {})
    assert_refused(call("measure", "other.exr"), "other.exr: holds no scene in its metadata")
    scene = "[[light]]\n[droplets]\nfile = 'gone.npz'\n# --set camera.size_px=[6, 4]\n"
    write_exr("moved.exr", rgb, {"scene": scene})
    assert_refused(call("measure", "moved.exr"), "moved.exr (its scene)", "gone.npz", "not found")
    write_exr("cropped.exr", rgb[:, :3], {"scene": scene})
    assert_refused(call("measure", "cropped.exr"), "has 3 x 4 pixels, its scene 6 x 4")
    write_exr("broken.exr", rgb, {"scene": scene.replace("[6, 4]", "")})
    assert call("measure", "broken.exr").code == 2
    write_exr_channels("grey.exr", {"Y": rgb[..., 0]}, {})
    assert_refused(call("measure", "grey.exr"), "grey.exr: not a frame")
    assert_refused(call("measure", "none.exr"), "none.exr: cannot be read")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("measure", "a.png"), "a.png: is a displayed picture"),
        (("measure", "a.exr", "--size", "64x36"), "--size goes with a SCENE"),
        (("measure", "a.exr", "--method", "auto"), "--method goes with a SCENE"),
        (("measure", "uniform", "--json", "a.txt"), "must be .json"),
        (("render", "uniform", "-o", "-", "--json", "-"), "standard output takes the picture"),
        (("render", "uniform", "-o", "a.exr", "--json", "none/a.json"), "none/a.json: "),
    ],
)
def test_refusals(call, tmp_path, args, words):
    assert_refused(call(*args), words)
    assert contents(tmp_path) == {}
