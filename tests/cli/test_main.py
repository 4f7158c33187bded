"""The command line: what it writes, what it says, and the codes it exits with."""

from __future__ import annotations

import errno
import fcntl
import os
import pickle
import pty
import re
import resource
import select
import shlex
import signal
import struct
import termios
import zipfile

import click
import numpy as np
import pytest
from PIL import Image

import rtbow.base.files
import rtbow.cli.main
import rtbow.gl.context
import rtbow.render.renderer
from command_line import (
    SMALL,
    Result,
    assert_message,
    assert_refused,
    contents,
    execute,
    spawn,
)
from rtbow import __version__
from rtbow.base.resources import resource_dir
from rtbow.frames.image import read_exr
from rtbow.scene.text.file import builtin_scenes

FAST = "method fast\n"
"""What stderr says where ``auto`` chose."""
UNIFORM = (resource_dir("scenes") / "uniform.toml").read_text("utf-8")


# --- What is written ---------------------------------------------------------------------------


def test_both_files_say_how_they_were_made(call, tmp_path):
    args = ("render", "uniform", "-o", "bow.exr", "-o", "bow.png", *SMALL, "--exposure", "12")
    result = call(*args)
    assert result == Result(0, "bow.exr\nbow.png\n", FAST)
    assert sorted(contents(tmp_path)) == ["bow.exr", "bow.png"]

    rgb, texts = read_exr("bow.exr")
    assert rgb.shape == (18, 32, 3)
    assert np.all(np.isfinite(rgb))
    assert rgb.max() > 100.0
    assert texts["command"] == shlex.join(["rtbow", *args])
    assert texts["rtbowVersion"] == __version__
    assert texts["method"] == "fast"
    assert texts["renderer"] not in ("", "CPU, float64")
    # The scene's text makes the same frame again.
    assert texts["scene"] == f"{UNIFORM}# --set camera.size_px=[32, 18]\n"

    with Image.open("bow.png") as picture:
        assert picture.size == (32, 18)
        assert picture.mode == "RGB"
        for key in ("scene", "command", "rtbowVersion", "method", "renderer"):
            assert picture.text[key] == texts[key]
        assert picture.text["exposureEV100"] == "12"


def test_the_reference_says_that_it_is_one(call):
    assert (
        call("render", "uniform", "-o", "b.exr", "--size", "8x5", "--method", "reference").code == 0
    )
    texts = read_exr("b.exr")[1]
    assert texts["method"] == "reference"
    assert texts["renderer"] == "CPU, float64"


def test_what_auto_chose_is_told_beside_the_paths(call):
    args = ("render", "uniform", "-o", "b.exr", "--size", "8x5")
    assert call(*args) == Result(0, "b.exr\n", FAST)
    args += ("--set", "light.0.angular_diameter_deg=0")
    result = call(*args)
    assert result.out == "b.exr\n"
    assert re.fullmatch(r"method spectral: .* = 0: drops under a point of light .*\n", result.err)
    assert "use --method spectral" not in result.err
    assert read_exr("b.exr")[1]["method"] == "spectral"
    assert call(*args, "-q") == Result(0, "", "")
    assert call(*args, "--method", "spectral") == Result(0, "b.exr\n", "")


def test_the_error_that_fast_may_make(call):
    size = ("--size", "8x5", "-q")
    for method in ("fast", "auto"):
        args = ("-o", "a.exr", "--max-delta-e", "2", "--method", method)
        assert call("render", "uniform", *args, *size) == Result(0, "", "")
        assert "# --set render.max_delta_e=2.0\n" in read_exr("a.exr")[1]["scene"]
    # In a scene, it waits for the method that takes it.
    for method in ("spectral", "reference"):
        args = ("-o", "a.exr", "--set", "render.max_delta_e=2", "--method", method)
        assert call("render", "uniform", *args, *size) == Result(0, "", "")


def test_without_a_scene_the_default_one(call):
    assert call("render", "-o", "a.exr", "--size", "8x5", "-q") == Result(0, "", "")
    assert call("render", "default", "-o", "b.exr", "--size", "8x5", "-q") == Result(0, "", "")
    np.testing.assert_array_equal(read_exr("a.exr")[0], read_exr("b.exr")[0])


def test_the_seed_draws_other_drops(call):
    rain = ("--set", "droplets.radius={distribution='uniform', min_um=100, max_um=900}")
    grid = ("--set", "droplets.grid=[4, 4, 4]", "--size", "8x5", "-q")
    for name, seed in (("a", "7"), ("b", "7"), ("c", "8"), ("d", "9" * 40)):
        output = ("-o", f"{name}.exr", "--seed", seed)
        assert call("render", "uniform", *rain, *grid, *output) == Result(0, "", "")
    a, b, c, d = (read_exr(f"{name}.exr")[0] for name in "abcd")
    np.testing.assert_array_equal(a, b)
    assert np.any(a != c)
    assert np.any(a != d)


@pytest.mark.parametrize(
    "name", ["with space.exr", "regenbogen-ä-虹.png", "UPPER.EXR", "./here.exr", ".hidden.png"]
)
def test_names_of_all_kinds(call, tmp_path, name):
    assert call("render", "uniform", "-o", name, "--size", "4x3") == Result(0, f"{name}\n", FAST)
    assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize("size", ["1x1", "1x9", "9x1", "007X05"])
def test_small_sizes(call, size):
    assert call("render", "uniform", "-o", "x.exr", "-o", "x.png", "--size", size, "-q").code == 0
    width, height = (int(side) for side in size.lower().split("x"))
    assert read_exr("x.exr")[0].shape == (height, width, 3)


@pytest.mark.usefixtures("no_rendering")
@pytest.mark.parametrize("again", ["x.exr", "./x.exr"])
def test_the_same_output_twice_is_refused(call, tmp_path, again):
    result = call("render", "uniform", "-o", "x.exr", "-o", "x.png", "-o", again)
    assert_refused(result, f"-o {again}: is given twice; give it once")
    assert contents(tmp_path) == {}


def test_a_device_beside_a_file(call, tmp_path):
    (tmp_path / "null.exr").symlink_to(os.devnull)
    outputs = ("-o", "x.exr", "-o", "null.exr")
    assert call("render", "uniform", *outputs, "--size", "4x3", "-q") == Result(0, "", "")
    assert list(contents(tmp_path)) == ["x.exr"]
    assert (tmp_path / "null.exr").is_symlink()


def test_a_spectrum_is_found_beside_the_scene_or_where_set_was_typed(call, tmp_path):
    """The red lamp lies beside the scene, the blue one where the command is typed."""
    folder = tmp_path / "my scènes"
    folder.mkdir()
    (folder / "lamp.csv").write_text("380,0\n600,0\n610,1\n780,1\n", "utf-8")
    (tmp_path / "lamp.csv").write_bytes(
        b"\xef\xbb\xbfnm,value\r\n380,1\r\n450,1\r\n460,0\r\n780,0\r\n"
    )
    scene = folder / "rain.TOML"
    text = UNIFORM.replace('type = "sun"', 'type = "sun"\nspectrum = "lamp.csv"')
    # As some editors write it.
    scene.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    name = "my scènes/rain.TOML"
    assert call("render", name, "-o", "red.exr", *SMALL, "-q") == Result(0, "", "")
    setting = ("--set", "light.0.spectrum=lamp.csv")
    assert call("render", name, "-o", "blue.exr", *SMALL, *setting, "-q") == Result(0, "", "")
    red, blue = (read_exr(f"{c}.exr")[0].sum(axis=(0, 1)) for c in ("red", "blue"))
    assert red[0] > 0 > red[2]
    assert blue[2] > 0 > blue[1]


@pytest.mark.parametrize("quoted", ["FL2", '"FL2"', "'FL2'"])
def test_text_in_set_with_and_without_quotes(call, quoted):
    args = ("--size", "4x3", "--set", f"light.0.spectrum={quoted}", "-q")
    assert call("render", "uniform", "-o", "x.exr", *args) == Result(0, "", "")


@pytest.mark.parametrize(
    "setting",
    [
        "camera.altitude_deg=90",
        "camera.altitude_deg=-90",
        "camera.azimuth_deg=1e300",
        "camera.fov_deg=179.999999999",
        "camera.fov_deg=1e-300",
        "camera.position_m=[0, 0, -100]",
        "camera.position_m=[0, 600, 500]",
        "camera.position_m=[0, 0, 9e6]",
        "droplets.box_m=[[-1e7, -1e7, -1e7], [1e7, 1e7, 1e7]]",
        "droplets.density.number_per_m3=0",
        "light.0.angular_diameter_deg=0",
        "light.0.altitude_deg=-90",
        "scattering.orders=[2]",
        "render.steps=1",
        "render.wavelength_step_nm=40",
    ],
)
def test_ends_of_the_allowed_ranges_render(call, setting):
    """The frame's finiteness is checked before it is written."""
    args = ("--set", setting, "--set", "atmosphere.rayleigh=true", "--size", "8x5", "-q")
    assert call("render", "uniform", "-o", "x.exr", *args) == Result(0, "", "")


# --- What is refused ---------------------------------------------------------------------------


WRONG_ARGUMENTS = [
    (("nosuch",), "no built-in scene", ", ".join(builtin_scenes())),
    (("unifrom",), 'named "unifrom"', "did you mean uniform?"),
    (("uniform.toml",), "uniform.toml: there is no such file", "without .toml"),
    (("missing.toml",), "missing.toml: there is no such file; check the path"),
    (("",), 'named ""'),
    ((".",), "is a folder"),
    (("folder.toml",), "folder.toml: is a folder; name a scene file in it"),
    (("bow.png",), "'bow.png' is a picture's name, not a scene's; did you mean -o bow.png?"),
    (("out/bow.EXR",), "did you mean -o out/bow.EXR?"),
    (("uniform", "shower"), "unexpected extra argument (shower)", "rtbow render --help"),
    (("uniform", "--ouput", "y.exr"), "--ouput", "--output"),
    (("uniform", "--size", "0x10"), "0x10", "1..16384"),
    (("uniform", "--size", "100000x10"), "100000x10", "1..16384"),
    (("uniform", "--size", f"{'9' * 5000}x2"), "1..16384"),
    *(
        (("uniform", "--size", size), "is not a size", "such as 640x360")
        for size in ("", "x", "640", "640x", "-1x5", "8 x 8", "8x8x8", "²x2", "٣x٣", "1e3x5")
    ),
    *(
        (
            ("uniform", "--max-delta-e", error),
            f"'--max-delta-e': '{error}' is no error that method fast can keep",
            "write a number, 0.25..20, such as 0.5, or leave it out",
        )
        for error in ("0", "-1", "nan", "inf", "0.01", "20.1", "small", "")
    ),
    *(
        (
            ("uniform", "--max-delta-e", "2", "--method", method),
            f"--max-delta-e 2: methods auto and fast alone take it, not --method {method}; leave",
        )
        for method in ("spectral", "reference")
    ),
    (("uniform", "--method", "quick"), "quick", "auto", "fast", "spectral", "reference"),
    (("uniform", "--backend", "vulkan"), "vulkan", "egl", "osmesa", "window"),
    *(
        (("uniform", f"--exposure={ev}"), "is not an exposure", "auto", "-200..200, such as 13")
        for ev in ("bright", "nan", "inf", "1e9", "-201", "", "1,5")
    ),
    (("uniform", "--seed=-1"), "-1", "x>=0"),
    (("uniform", "--seed=1.5"), "'1.5' is not a valid whole number"),
    (("uniform", "--seed="), "--seed"),
]


@pytest.mark.parametrize(("args", "words"), [(args, words) for args, *words in WRONG_ARGUMENTS])
def test_wrong_arguments(call, tmp_path, no_rendering, args, words):
    (tmp_path / "folder.toml").mkdir()
    assert_refused(call("render", *args, "-o", "x.exr"), *words)
    assert contents(tmp_path) == {}


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--max-delta-e", "0"), "'--max-delta-e': '0' is no error that method fast can keep"),
        (("--max-delta-e", "1", "--method", "spectral"), "--max-delta-e 1: methods auto and fast"),
        (("--method", "quick"), "'quick'"),
        (("--exposure", "1e9"), "'1e9' is not an exposure; write auto, or an EV at ISO 100, -200"),
        (("bow.png",), "not a scene's; name a .toml file or a built-in scene (rtbow scenes lists"),
    ],
)
def test_wrong_arguments_of_the_window(call, args, words):
    assert_refused(call("view", *args), words)


def test_an_output_in_the_scenes_place(call, tmp_path, no_rendering):
    assert_refused(call("render", "bow.png"), "did you mean -o bow.png?")
    for name, data in {"notes": b"rain", "shot": b"\x89PNG\r\n", "list": b"380,1\n"}.items():
        (tmp_path / name).write_bytes(data)
        result = call("render", name, "-o", "x.exr")
        assert_refused(result, "no built-in scene")
        assert ".toml" not in result.err
    (tmp_path / "rain.txt").write_text(UNIFORM, "utf-8")
    assert_refused(call("render", "rain.txt", "-o", "x.exr"), "once its name ends with .toml")


WRONG_SETTINGS = [
    ("nope", "write key.path=value"),
    ("", "write key.path=value"),
    ("=5", "write key.path=value"),
    ("camera.fov_deg=", "write key.path=value"),
    ("camera.fov=5", "unknown key camera.fov", "did you mean camera.fov_deg?"),
    ("light.0.altitud_deg=5", "did you mean light.0.altitude_deg?"),
    ("title=5", "unknown key title", "camera, light"),
    ("camera.fov_deg.x=5", "camera.fov_deg is a single value"),
    ("light=[]", "light = []", "[[light]]"),
    ("light.0=5", "light.0 = 5", "must be a table"),
    ("light.1.altitude_deg=5", "light has 1 item"),
    ("light.-1.altitude_deg=5", "light is a list of 1 item", "such as light.0"),
    ('light.0.spectrum="FL2', "is not a TOML value"),
    ("camera.azimuth_deg=north", '"north"', "must be a number"),
    ("camera.azimuth_deg=true", "true", "must be a number"),
    ("camera.position_m=[0, 0]", "camera.position_m", "list of 3 numbers"),
    ("camera.position_m.0=nan", "nan", "finite"),
    ("camera.azimuth_deg=inf", "inf", "finite"),
    (f"camera.azimuth_deg={'9' * 5000}", "camera.azimuth_deg", "must be a number"),
    ("droplets.radius.radius_um=nan", "droplets.radius.radius_um = nan", "1..5000"),
    ("droplets.radius.radius_um=1e999", "radius_um = inf", "1..5000"),
    ("droplets.radius.radius_um=-3", "radius_um = -3", "1..5000"),
    ("droplets.radius.radius_um=0", "radius_um = 0", "1..5000"),
    ("droplets.density.number_per_m3=-1", "number_per_m3 = -1", "0..1e12"),
    ("droplets.density.number_per_m3=1e36", "number_per_m3 = 1e+36", "0..1e12"),
    ("droplets.grid=[1024, 1024, 1024]", "has 1,073,741,824 points", "[512, 512, 512]"),
    ("droplets.box_m=[[0, 0, 0], [1, 1, -1]]", "turned inside out along up (0 to -1)"),
    ("droplets.box_m=[[0, 0, 0], [1, 0, 1]]", "flat along north (0 to 0)"),
    ("droplets.grid=[1, 2, 2]", "droplets.grid.0 = 1", "2..1024"),
    ("droplets.seed=-1", "droplets.seed = -1", "0 or more"),
    ("camera.fov_deg=0", "camera.fov_deg = 0", "greater than 0 and less than 180"),
    ("camera.fov_deg=-5", "camera.fov_deg = -5", "greater than 0 and less than 180"),
    ("camera.fov_deg=180", "camera.fov_deg = 180", "greater than 0 and less than 180"),
    ("camera.size_px=[16385, 1]", "16385", "1..16384"),
    ("droplets.extinction=1", "droplets.extinction = 1", "true or false"),
    ("scattering.theory=ray", "scattering.theory", 'one of "airy", "mie"'),
    ("scattering.size_spread=2", "size_spread = 2", "0.01..0.2"),
    ("camera.polarizer_deg=left", "polarizer_deg", "must be a number"),
    ("light.0.type=lamp", 'light.0.type = "lamp"', 'must be one of "sun", "point"'),
    ("light.0.luminous_flux_lm=5", "does not belong to type", "which takes altitude_deg"),
    ("compare.right.camera.fov=5", "compare.right.camera.fov: unknown key", "camera.fov_deg?"),
    ("compare.right.camera.size_px=[4, 4]", "compare.right.camera.size_px: both parts share it"),
    ("scattering.orders=[3]", "scattering.orders.0 = 3", "1..2"),
    ("render.steps=0", "render.steps = 0", "1..100000"),
    ("render.wavelength_step_nm=7", "render.wavelength_step_nm = 7", "6.25 and 8"),
]


@pytest.mark.parametrize(
    ("setting", "words"), [(setting, words) for setting, *words in WRONG_SETTINGS]
)
def test_wrong_settings(call, tmp_path, no_rendering, setting, words):
    result = call("render", "uniform", "-o", "x.exr", "--set", setting)
    assert_refused(result, "--set", *words)
    assert contents(tmp_path) == {}


LAMP = '[[light]]\ntype = "point"'
WRONG_SCENES = [
    ("camera {", "not valid TOML: Expected '='", "(at line 1, column 8)"),
    (UNIFORM.replace("radius_um", "radius_mm"), "did you mean droplets.radius.radius_um?"),
    (UNIFORM.replace("azimuth_deg = 0.0", 'azimuth_deg = "north"'), '"north"; must be a number'),
    (UNIFORM.replace("300.0", "-3"), "droplets.radius.radius_um = -3; must be 1..5000"),
    (UNIFORM.replace("300.0", "nan"), "droplets.radius.radius_um = nan; must be a finite number"),
    (f"{UNIFORM}{LAMP}\nposition_m = [0, 0, 4]", "light.1.luminous_flux_lm is missing; give a"),
    (f"{UNIFORM}{LAMP}\nluminous_flux_lm = 5", "light.1.position_m is missing; give a list of 3"),
    (f"{UNIFORM}[compare]", "compare.right is missing; give a table of scene keys and values"),
    (f"{UNIFORM}[compare.right.camera]\nfov = 5", "compare.right.camera.fov: unknown key"),
    (UNIFORM.replace("[[light]]", "[light]"), "[[light]], in double brackets"),
    (
        f"{UNIFORM} [light] # one more\n",
        "(at line ",
        "write [[light]], in double brackets, for each",
    ),
    (f'{UNIFORM}[scattering]\ntheory = "ray"', 'must be one of "airy", "mie"'),
    (f"{UNIFORM}\0", "not valid TOML"),
]


@pytest.mark.parametrize(("text", "words"), [(text, words) for text, *words in WRONG_SCENES])
def test_wrong_scenes(call, tmp_path, no_rendering, text, words):
    (tmp_path / "rain.toml").write_text(text, "utf-8")
    assert_refused(call("render", "rain.toml", "-o", "x.exr"), "rain.toml: ", *words)
    assert list(contents(tmp_path)) == ["rain.toml"]


WRONG_SPECTRA = [
    (b"", "holds no spectrum"),
    (b"wavelength_nm,value\n", "holds no spectrum"),
    (b"780,1\n380,1\n", ":2: wavelength 380 nm does not follow 780 nm; sort"),
    (b"380,1\n380,1\n780,1\n", ":2: wavelength 380 nm does not follow 380 nm"),
    (b"a,b\n380,1\n500,much\n780,1\n", ":3: expected two numbers", "500,much"),
    (b"380;1\n780;1\n", ":2: expected two numbers"),
    (b"380,1,2\n780,1,2\n", ":1: expected two numbers"),
    (b"400,1\n780,1\n", "covers 400-780 nm; must reach 380-780 nm"),
    (b"380,1\n700,1\n", "covers 380-700 nm; must reach 380-780 nm"),
    (b"380,1\n500,nan\n780,1\n", ":2: NaN and infinity are not allowed"),
    (b"380,1\n500,-1\n780,1\n", ":2: value -1 is negative"),
    (b"380,0\n780,0\n", "is zero over 380-780 nm"),
    ("380,1\n780,1\n".encode("utf-16"), "cannot be read as a CSV spectrum"),
]


@pytest.mark.parametrize(("data", "words"), [(data, words) for data, *words in WRONG_SPECTRA])
def test_wrong_spectra(call, tmp_path, data, words):
    (tmp_path / "lamp.csv").write_bytes(data)
    args = ("--set", "light.0.spectrum=lamp.csv", *SMALL)
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), "lamp.csv", *words)
    assert list(contents(tmp_path)) == ["lamp.csv"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("E491", "did you mean E490"),
        ("fl2", "did you mean FL2"),
        (
            "missing.csv",
            "missing.csv: spectrum file not found; check the path: in a scene file it starts at"
            " that file's folder, elsewhere at the current one; must hold two or more lines"
            " wavelength_nm,value over 380-780 nm; or name E490, equal-energy or a CIE illuminant",
        ),
        ("folder.csv", "must hold two or more lines wavelength_nm,value"),
        (".", "is not known"),
    ],
)
def test_unknown_spectra(call, tmp_path, name, words):
    (tmp_path / "folder.csv").mkdir()
    args = ("--set", f"light.0.spectrum={name}", *SMALL)
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), words)
    assert contents(tmp_path) == {}


POINTS = np.full((3, 3, 3), 300.0, np.float32)
VOLUME = {
    "radius_um": POINTS,
    "number_per_m3": 3.0 * POINTS,
    "box_m": np.array([[-100.0, 100.0, 0.0], [100.0, 200.0, 100.0]]),
}
HOLED = np.where(np.arange(27).reshape(3, 3, 3) == 5, np.nan, POINTS)

WRONG_VOLUMES = [
    ({"number_per_m3": None}, "lacks number_per_m3"),
    ({"radius_um": None, "box_m": None}, "lacks radius_um, box_m"),
    ({"number_per_m3": POINTS[:2]}, "(3, 3, 3)", "(2, 3, 3)"),
    ({"radius_um": HOLED}, "radius_um must be finite"),
    ({"number_per_m3": HOLED}, "number_per_m3 has values that are negative, not finite or beyond"),
    (
        {"number_per_m3": -POINTS},
        "number_per_m3 has values that are negative, not finite or beyond",
    ),
    ({"number_per_m3": 1e40 * POINTS.astype("f8")}, "not finite or beyond"),
    ({"radius_um": 0.0 * POINTS}, "1-5000 µm"),
    ({"radius_um": POINTS[:1], "number_per_m3": POINTS[:1]}, "(1, 3, 3)"),
    ({"box_m": VOLUME["box_m"][::-1]}, "box_m", "second greater"),
    ({"box_m": VOLUME["box_m"][[0, 0]]}, "box_m", "second greater"),
    ({"box_m": 1e300 * VOLUME["box_m"]}, "box_m", "±1e+07 m"),
    ({"box_m": np.zeros(1000)}, "box_m has shape (1000,)"),
    ({"radius_um": np.array([{}], dtype=object)}, "not a readable volume"),
    ({"radius_um": POINTS.astype(str)}, "not numbers"),
]


@pytest.mark.parametrize(
    ("changes", "words"), [(changes, words) for changes, *words in WRONG_VOLUMES]
)
def test_wrong_volumes(call, tmp_path, changes, words):
    arrays = {name: value for name, value in (VOLUME | changes).items() if value is not None}
    np.savez(tmp_path / "rain.npz", **arrays)
    args = ("--set", "droplets.file=rain.npz", *SMALL)
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), "rain.npz: ", *words)
    assert list(contents(tmp_path)) == ["rain.npz"]


@pytest.mark.parametrize(
    "data", [b"", b"radius", pickle.dumps({"radius_um": 1}), b"PK\x03\x04cut off", b"\x93NUMPY"]
)
def test_volumes_of_another_kind(call, tmp_path, data):
    (tmp_path / "rain.npz").write_bytes(data)
    args = ("--set", "droplets.file=rain.npz", *SMALL)
    result = call("render", "uniform", "-o", "x.exr", *args)
    assert_refused(result, "rain.npz: ", "expected an .npz with radius_um")
    assert "allow_pickle" not in result.err  # no advice to take a risk


def test_a_pickle_inside_a_volume_is_not_run(call, tmp_path):
    class Trap:
        def __reduce__(self):
            return open, (str(tmp_path / "sprung"), "w")

    np.savez(tmp_path / "rain.npz", **VOLUME | {"radius_um": np.array([Trap()], dtype=object)})
    args = ("--set", "droplets.file=rain.npz", *SMALL)
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), "rain.npz: ")
    assert list(contents(tmp_path)) == ["rain.npz"]


def test_a_damaged_volume(call, tmp_path):
    np.savez_compressed(tmp_path / "rain.npz", **VOLUME)
    data = bytearray((tmp_path / "rain.npz").read_bytes())
    with zipfile.ZipFile(tmp_path / "rain.npz") as archive:
        offset = archive.getinfo("number_per_m3.npy").header_offset
    data[offset + 60 : offset + 90] = b"\xff" * 30
    (tmp_path / "rain.npz").write_bytes(data)
    args = ("--set", "droplets.file=rain.npz", *SMALL)
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), "not a readable volume")


def test_a_missing_volume(call):
    for name, words in (
        ("missing.npz", "volume file not found; check the path: in a"),
        (".", "not a readable volume"),
    ):
        args = ("--set", f"droplets.file={name}", *SMALL)
        assert_refused(call("render", "uniform", "-o", "x.exr", *args), words)


def test_what_names_a_missing_volume_is_told(call, tmp_path):
    (tmp_path / "mine.toml").write_text(
        '[[light]]\n[droplets]\nextinction = false\nfile = "rain.npz"\n', "utf-8"
    )
    rain = f"{tmp_path}/rain.npz: volume file not found"
    for method in ("fast", "reference"):
        args = ("-o", "x.exr", "--method", method, *SMALL)
        assert_refused(
            call("render", "mine.toml", *args), f"mine.toml: line 4: droplets.file: {rain}"
        )
        for setting in ("droplets.file=rain.npz", "droplets={file='rain.npz'}"):
            key = setting.partition("=")[0]
            result = call("render", "mine.toml", *args, "--set", setting)
            assert_refused(result, f"rtbow: --set {key}: {rain}")
    result = call("render", "uniform", *args, "--set", "compare.right.droplets.file=rain.npz")
    assert_refused(result, f"uniform, right part: droplets.file: {rain}")


def test_a_size_that_the_device_does_not_take(call, tmp_path, monkeypatch):
    monkeypatch.setattr(
        rtbow.gl.context.GlContext,
        "limits",
        property(lambda _: rtbow.gl.context.Limits(64, 256, 32, (64, 64)), lambda *_: None),
        raising=False,
    )
    result = call("render", "uniform", "-o", "x.exr", "--size", "65x2")
    assert_message(result, 3, "camera.size_px = [65, 2]", "up to 64 pixels", "--method reference")
    result = call(
        "render", "uniform", "-o", "x.exr", "--size", "8x5", "--set", "droplets.grid=[2,2,33]"
    )
    assert_message(result, 3, "(2, 2, 33)", "up to 32 points", "--method reference")
    assert contents(tmp_path) == {}


# --- Outputs that cannot be written ------------------------------------------------------------


@pytest.mark.parametrize(
    ("output", "words"),
    [
        ("x.jpg", "suffix .jpg is not known; must be .exr or .png; write for example x.exr"),
        ("x", "has no suffix; must be .exr or .png"),
        ("", "has no suffix"),
        (".", "has no suffix"),
        ("-", "has no suffix"),
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


# --- Ctrl-C and SIGTERM ------------------------------------------------------------------------

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


# --- The machine -------------------------------------------------------------------------------

NO_GL = {
    "code": 'import rtbow.gl.osmesa; rtbow.gl.osmesa._OSMESA_LIBRARIES = ("libOSMesa-none.so",)',
    "env": {
        "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent",
        "DISPLAY": "",
        "WAYLAND_DISPLAY": "",
        "RTBOW_EGL_DEVICE": "",
    },
}


def test_without_gl_the_packages_are_named(tmp_path):
    result = execute("render", "uniform", "-o", "x.exr", *SMALL, cwd=tmp_path, **NO_GL)
    assert_message(result, 3, "no OpenGL 3.3 core context here")
    for package in ("libegl1", "libgl1", "libgl1-mesa-dri", "libosmesa6", "xvfb"):
        assert package in result.err
    assert contents(tmp_path) == {}


def test_without_gl_the_reference_and_the_rest_work(tmp_path):
    args = ("-o", "x.exr", "--size", "8x5", "--method", "reference")
    result = execute("render", "uniform", *args, cwd=tmp_path, **NO_GL)
    assert result == Result(0, "x.exr\n", "")
    result = execute("info", cwd=tmp_path, **NO_GL)
    assert result.code == 0
    assert result.out.count("does not work") == 3


def test_a_named_backend_that_is_not_there(call, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("render", "uniform", "-o", "x.exr", *SMALL, "--backend", "window")
    assert_message(result, 3, "backend window", "no display")


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_each_headless_backend(call, backend):
    args = ("-o", "x.exr", *SMALL, "--backend", backend)
    assert call("render", "uniform", *args) == Result(0, "x.exr\n", FAST)


def test_too_little_memory(call, tmp_path, monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(rtbow.render.renderer.Renderer, "_render_shader", fail)
    result = call("render", "uniform", "-o", "x.exr")
    assert_message(result, 3, "not enough memory; render smaller")
    assert contents(tmp_path) == {}


def test_strict_warnings_and_no_home(tmp_path):
    """Nothing warns, and the cache is a help but not a need."""
    env = {"PYTHONWARNINGS": "error", "HOME": "/nonexistent", "RTBOW_CACHE_DIR": "/proc/nowhere"}
    args = ("render", "uniform", "-o", "x.exr", "-o", "x.png", *SMALL)
    assert execute(*args, cwd=tmp_path, env=env) == Result(0, "x.exr\nx.png\n", FAST)


# --- What is shown -----------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["fast", "spectral", "reference"])
def test_a_pipe_sees_no_progress(tmp_path, method):
    args = ("render", "uniform", "-o", "x.exr", "--size", "8x20", "--method", method)
    assert execute(*args, cwd=tmp_path) == Result(0, "x.exr\n", "")


def commands(group: click.Group, *names: str):
    for name, command in group.commands.items():
        yield (*names, name), command
        if isinstance(command, click.Group):
            yield from commands(command, *names, name)


VERBS = dict(commands(rtbow.cli.main.rtbow))


@pytest.mark.parametrize("names", [(), *VERBS], ids=" ".join)
def test_help_has_an_example_that_works(call, monkeypatch, names):
    result = call(*names, "--help")
    assert result.code == 0
    assert result.err == ""
    assert result.out.startswith(f"Usage: {' '.join(('rtbow', *names))} ")
    assert call(*names, "-h") == result
    example = re.search(r"Example: rtbow (.*?)\n\n", result.out, re.DOTALL)
    assert example
    args = example[1].split()
    assert args[: len(names)] == list(names)
    # Up to the verb's own function, the example is read as it would be typed.
    for command in VERBS.values():
        if not isinstance(command, click.Group):
            monkeypatch.setattr(command, "callback", lambda **_: None)
    assert call(*args).code == 0


def test_no_verb_shows_the_help(call):
    result = call()
    assert result.code == 0
    assert "Usage: rtbow" in result.out
    assert_refused(call("rendr"), "No such command 'rendr'", "rtbow --help")
    assert_refused(call("table", "exprt"), "No such command 'exprt'", "rtbow table --help")


def test_version(call):
    assert call("--version").out == f"rtbow, version {__version__}\n"


def test_scenes_are_listed_one_line_each(call):
    result = call("scenes")
    assert result.code == 0
    folder = resource_dir("scenes")
    names = sorted(str(p.relative_to(folder))[: -len(".toml")] for p in folder.rglob("*.toml"))
    assert "figures/fig1" in names
    lines = result.out.splitlines()
    assert [line.split()[0] for line in lines] == names
    for line in lines:
        name, _, title = line.partition("  ")
        assert name
        assert len(title.split()) > 3


def test_info(call, monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    result = call("info")
    assert (result.code, result.err) == (0, "")
    first, *backends, packages, cache = result.out.splitlines()
    assert first.startswith(f"rtbow {__version__}, Python 3.")
    for backend in ("egl", "osmesa"):
        assert any(re.match(rf"{backend} +works: .+, OpenGL \d\.\d", line) for line in backends)
    assert any(line.startswith("window") for line in backends)
    assert re.search(r"moderngl \d.* numpy \d", packages)
    assert cache == f"cache: {tmp_path / 'cache'}, 0.0 MiB"
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("args", [["--help"], ["render", "--help"], ["--version"], ["nosuch"]])
def test_what_needs_no_numbers_loads_none(tmp_path, args):
    code = """
import atexit, sys
heavy = {"numpy", "scipy", "moderngl", "pydantic", "colour", "OpenEXR", "PIL", "numba", "tqdm"}
atexit.register(lambda: print("LOADED", sorted(heavy & set(sys.modules))))
"""
    assert execute(*args, cwd=tmp_path, code=code).out.endswith("LOADED []\n")


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


def test_other_system_errors_are_defects(monkeypatch):
    def call(**_):
        raise SystemError("something else")

    monkeypatch.setattr(rtbow.cli.main.rtbow, "main", call)
    with pytest.raises(SystemError):
        rtbow.cli.main.main()
