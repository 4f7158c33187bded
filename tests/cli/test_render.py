"""``rtbow render``: what it writes, and from what."""

from __future__ import annotations

import shlex

import numpy as np
import pytest
from PIL import Image

from command_line import FAST, SMALL, Result, Summary, contents, execute
from rtbow import __version__
from rtbow.base.arrays import Steps
from rtbow.cli import options
from rtbow.frames.image import read_exr
from scene_samples import UNIFORM


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
        for key in ("scene", "sceneName", "command", "rtbowVersion", "method", "renderer"):
            assert picture.text[key] == texts[key]
        assert picture.text["exposureEV100"] == texts["exposureEV100"] == "12"


def test_the_reference_says_that_it_is_one(call):
    assert (
        call("render", "uniform", "-o", "b.exr", "--size", "8x5", "--method", "reference").code == 0
    )
    texts = read_exr("b.exr")[1]
    assert texts["method"] == "reference"
    assert texts["renderer"] == "CPU, float64"


def test_auto_names_its_choice_on_stderr(call):
    args = ("render", "uniform", "-o", "b.exr", "--size", "8x5")
    assert call(*args) == Result(0, "b.exr\n", FAST)
    args += ("--set", "light.0.angular_diameter_deg=0")
    result = call(*args)
    assert result.out == "b.exr\n"
    assert result.err == Summary("spectral", ".* = 0: drops under a point of light .*")
    assert "use --method spectral" not in result.err
    assert read_exr("b.exr")[1]["method"] == "spectral"
    assert call(*args, "-q") == Result(0, "", "")
    assert call(*args, "--method", "spectral") == Result(0, "b.exr\n", Summary("spectral"))


def test_the_tolerated_error_is_noted_in_the_scene(call):
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


@pytest.mark.slow
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


@pytest.mark.parametrize("size", ["1x1", "1x9", "9x1", "007X05"])
def test_small_sizes(call, size):
    assert call("render", "uniform", "-o", "x.exr", "-o", "x.png", "--size", size, "-q").code == 0
    width, height = (int(side) for side in size.lower().split("x"))
    assert read_exr("x.exr")[0].shape == (height, width, 3)


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


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting",
    [
        "camera.altitude_deg=90",
        "camera.altitude_deg=-90",
        "camera.azimuth_deg=1e300",
        "camera.fov_deg=179.999999999",
        "camera.fov_deg=1e-6",
        "camera.position_m=[0, 0, -100]",
        "camera.position_m=[0, 600, 500]",
        "camera.position_m=[0, 0, 9e6]",
        "droplets.box_m=[[-1e7, -1e7, -1e5], [1e7, 1e7, 1e7]]",
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


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_each_headless_backend(call, backend):
    args = ("-o", "x.exr", *SMALL, "--backend", backend)
    assert call("render", "uniform", *args) == Result(0, "x.exr\n", FAST)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fast", "spectral", "reference"])
def test_a_pipe_sees_no_progress(tmp_path, method):
    args = ("render", "uniform", "-o", "x.exr", "--size", "8x20", "--method", method)
    assert execute(*args, cwd=tmp_path) == Result(0, "x.exr\n", Summary(method))


def test_a_pipe_is_told_what_is_built_if_that_is_slow(monkeypatch, capsys):
    timers = []

    class Timer:
        daemon = False

        def __init__(self, after_s, call, args, kwargs):
            self.fire, self.cancelled = lambda: call(*args, **kwargs), False
            timers.append(self)

        def start(self):
            pass

        def cancel(self):
            self.cancelled = True

    monkeypatch.setattr(options.threading, "Timer", Timer)
    progress = options.progress_bar("building the table", False)
    for _ in progress(Steps(1, "a mixture")):
        timers[0].fire()
    assert capsys.readouterr().err == "building the table: a mixture\n"
    assert timers[0].cancelled
    # Neither what is drawn nor what was asked to be quiet.
    assert list(options.progress_bar("rendering", False)(range(2))) == [0, 1]
    assert list(options.progress_bar("building the table", True)(Steps(2, "it"))) == [0, 1]
    assert len(timers) == 1


@pytest.mark.slow
def test_strict_warnings_and_no_home(tmp_path):
    """Nothing warns, and the cache is a help but not a need."""
    env = {"PYTHONWARNINGS": "error", "HOME": "/nonexistent", "RTBOW_CACHE_DIR": "/proc/nowhere"}
    args = ("render", "uniform", "-o", "x.exr", "-o", "x.png", *SMALL)
    assert execute(*args, cwd=tmp_path, env=env) == Result(0, "x.exr\nx.png\n", FAST)
