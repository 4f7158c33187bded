"""Arguments, scenes, spectra and volumes that are wrong: one line says what and where."""

from __future__ import annotations

import pickle
import zipfile

import numpy as np
import pytest

import rtbow.gl.context
from command_line import SMALL, assert_message, assert_refused, contents
from rtbow.scene.text.file import builtin_scenes
from scene_samples import UNIFORM

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
    ("camera.fov_deg=0", "camera.fov_deg = 0", "1e-06 or more and less than 180"),
    ("camera.fov_deg=-5", "camera.fov_deg = -5", "1e-06 or more and less than 180"),
    ("camera.fov_deg=180", "camera.fov_deg = 180", "1e-06 or more and less than 180"),
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
    (UNIFORM.replace("300.0", "-3"), "droplets.radius.radius_um = -3; must be 1..5000 µm"),
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
    (b"wavelength_nm,value\n", "holds no table of numbers"),
    (b"380,1\n600,1\n500,1\n780,1\n", ":3: 500 does not follow 600 in rising order; sort"),
    (b"380,1\n380,1\n780,1\n", ":2: 380 does not follow 380"),
    (b"a,b\n380,1\n500,much\n780,1\n", ":3: expected two numbers", "500,much"),
    (b"380,1,2\n780,1,2\n", "has 2 columns of values; choose one", "lamp.csv#2"),
    (b"400,1\n780,1\n", "covers 400-780 nm; must reach 380-780 nm", '"zero"', '"hold"'),
    (b"380,1\n700,1\n", "covers 380-700 nm; must reach 380-780 nm"),
    (b"380,1\n500,nan\n780,1\n", ":2: NaN and infinity are not allowed"),
    (b"380,1\n500,-1\n780,1\n", ":2: value -1 is negative"),
    (b"380,0\n780,0\n", "is zero over 380-780 nm"),
    (b"0.38,1\n0.5,1\n0.78,1\n", "looks like \u00b5m, not nm"),
    (b"\x00\x01\x02", "is not text"),
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
            " that file's folder, elsewhere at the current one; must hold a table of wavelengths"
            " and values",
        ),
        ("folder.csv", "is a folder"),
        (".", "is a folder"),
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
    ({"radius_um": HOLED}, "radius_um[0, 1, 2] = nan", "must be 1-5000 µm"),
    ({"number_per_m3": HOLED}, "number_per_m3[0, 1, 2] = nan;", "must be 0..1e+12"),
    (
        {"number_per_m3": -POINTS},
        "number_per_m3[0, 0, 0] = -300 (the first of 27 such points); must be 0..1e+12",
    ),
    (
        {"number_per_m3": 1e40 * POINTS.astype("f8")},
        "number_per_m3[0, 0, 0] = inf",
        "must be 0..1e+12",
    ),
    ({"radius_um": 0.0 * POINTS}, "1-5000 µm"),
    ({"radius_um": POINTS[:1], "number_per_m3": POINTS[:1]}, "(1, 3, 3)"),
    ({"box_m": VOLUME["box_m"][::-1]}, "box_m", "second greater"),
    ({"box_m": VOLUME["box_m"][[0, 0]]}, "box_m", "second greater"),
    ({"box_m": 1e300 * VOLUME["box_m"]}, "box_m", "±1e+07 m"),
    ({"box_m": np.zeros(1000)}, "box_m has shape (1000,)"),
    ({"radius_um": np.array([{}], dtype=object)}, "radius_um holds |O, not numbers"),
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
    assert_refused(call("render", "uniform", "-o", "x.exr", *args), "number_per_m3 cannot be read")


def test_a_missing_volume(call):
    for name, words in (
        ("missing.npz", "volume file not found; check the path: in a"),
        (".", "not a readable volume"),
    ):
        args = ("--set", f"droplets.file={name}", *SMALL)
        assert_refused(call("render", "uniform", "-o", "x.exr", *args), words)


def test_a_missing_volume_is_named_with_its_key(call, tmp_path):
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
