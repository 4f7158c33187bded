"""Sequences: what moves, what is kept, one exposure, and tables that are not built twice."""

from __future__ import annotations

import json
import os
import shlex
import signal
from pathlib import Path

import av
import numpy as np
import pytest

import rtbow.frames.image
import rtbow.render.fast.method
import rtbow.render.renderer
import rtbow.sequence.run
from command_line import SMALL, Result, assert_refused, contents, execute, names, spawn
from rtbow.base.errors import InputError
from rtbow.frames.display import BLACK_FRAME_EV, auto_exposure_ev, display
from rtbow.frames.image import png_texts, read_exr, read_png, write_png
from rtbow.scene.text.file import load_scene
from rtbow.sequence.run import sequence_exposure_ev

pytestmark = pytest.mark.slow

RISE = ("--key", "light.0.altitude_deg=2:40")


@pytest.fixture
def drawn(monkeypatch):
    """Altitudes of the light in the frames that were rendered, in order."""
    altitudes: list[float] = []
    true_render = rtbow.render.renderer.Renderer.render

    def render(self, *args, **more):
        altitudes.append(self.scene.light[0].altitude_deg)
        return true_render(self, *args, **more)

    monkeypatch.setattr(rtbow.render.renderer.Renderer, "render", render)
    return altitudes


def film_pictures(path: Path) -> list[np.ndarray]:
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


# --- What is refused ---------------------------------------------------------------------------


NOTHING_DRAWN = [
    (("--key", "light.0.altitude_deg"), "write key.path=from:to, such as light.0.altitude_deg=2"),
    (("--key", "light.0.altitude_deg=5"), "write key.path=from:to"),
    (("--key", "=2:3"), "write key.path=from:to"),
    (("--key", "camera.fov_deg=:3"), "write key.path=from:to"),
    (("--key", "camera.fov_deg=2:3:4"), "3:4 is not a number"),
    (("--key", "camera.fov_deg=wide:3"), "--key camera.fov_deg: wide is not a number"),
    (("--key", "camera.fov_deg=nan:3"), "camera.fov_deg: nan; both ends must be finite"),
    (("--key", "camera.fov_deg=3:inf"), "camera.fov_deg: inf; both ends must be finite"),
    (("--key", "camera.fov_deg=0:90"), "--key camera.fov_deg = 0.0; must be 1e-06 or more and"),
    (("--key", "camera.fov_deg=90:180"), "--key camera.fov_deg = 180.0; must be 1e-06 or more"),
    (("--key", "camera.fov=2:3"), "--key camera.fov: unknown key", "did you mean camera.fov_deg?"),
    (("--key", "light.1.altitude_deg=2:3"), "--key light.1.altitude_deg: light has 1 item"),
    (("--key", "camera.position_m=0:3"), "name an item of this list", "camera.position_m.0=0:10"),
    (("--key", "light.0=0:3"), "only numbers move", "must be a table"),
    (("--key", "light.0.spectrum=0:3"), "only numbers move", "must be text in quotes"),
    (("--key", "atmosphere.rayleigh=0:1"), "only numbers move", "must be true or false"),
    (("--key", "light.0.type=0:1"), "only numbers move", 'one of "sun", "point"'),
    (("--key", "camera.size_px.0=8:16"), "all frames have one size; give it with --size"),
    (("--key", "droplets.seed=1:2.5"), "2.5 is not a whole number"),
    (("--key", "droplets.grid.0=2:3"), "--key droplets.grid.0: droplets.grid is not given"),
    (("--key", "render.steps=1:200000"), "--key render.steps = 200000; must be 1..100000"),
    (("--key", "render.wavelength_step_nm=5:10"), "frame 1: --key render.wavelength_step_nm = 7.5",
     "must divide 380-780 nm evenly"),
    ((*RISE, *RISE), "--key light.0.altitude_deg: is given twice"),
    ((*RISE, "--set", "light.0.altitude_deg=3"), "has one value by --set, too; give one"),
    (("--key", "render.max_delta_e=1:2", "--max-delta-e", "1"), "has one value by --set, too"),
    ((), "nothing moves; add --key"),
    ((*RISE, "--set", "camera.fov_deg=0"), "--set camera.fov_deg = 0; must be 1e-06 or more"),
    ((*RISE, "--method", "spectral", "--max-delta-e", "1"), "methods auto and fast alone"),
    ((*RISE, "--frames", "0"), "'0' is no number of frames", "1..100000, such as 120"),
    ((*RISE, "--frames", "4m"), "'4m' is no number of frames", "or seconds, such as 4s"),
    ((*RISE, "--frames", "-1s"), "'-1s' is no number of frames"),
    ((*RISE, "--frames", "4s"), "--frames 4s: of how many a second?", "such as --fps 25"),
    ((*RISE, "--frames", "2e3s", "--fps", "60"), "1..100000 frames, which take 0.0167..1.67e+03 s"),
    ((*RISE, "--frames", "1s", "--fps", "1,5"), "'1,5' is not a number; write 1.5 with a point"),
    ((*RISE, "--fps", "30"), "--fps 30 goes with a film, or with --frames in seconds; add"),
    ((*RISE, "--fps", "nan", "-o", "a.mp4"), "--fps nan: must be 1..240"),
    ((*RISE, "--fps", "0", "-o", "a.mp4"), "--fps 0: must be 1..240"),
    ((*RISE, "-o", "a_%d.jpg"), "a_%d.jpg: suffix .jpg is not", "write for example a_%d.exr"),
    ((*RISE, "-o", "a.jpg"), "a.jpg: suffix .jpg is not known", "write for example a%04d.exr"),
    ((*RISE, "-o", "a_%d"), "a_%d: the name has no suffix", "write for example a_%d.exr"),
    ((*RISE, "-o", f"{'a' * 300}.jpg"), "suffix .jpg is not known"),
    ((*RISE, "-o", "frame.exr"), "hold the frame's number once", "write for example frame%04d.exr"),
    ((*RISE, "-o", "%d_%d.png"), "hold the frame's number once"),
    ((*RISE, "-o", "%s.png"), "hold the frame's number once"),
    ((*RISE, "-o", "a%04f.png"), "hold the frame's number once"),
    ((*RISE, "-o", "a%%.png"), "hold the frame's number once"),
    ((*RISE, "-o", "a%d.jpg"), "suffix .jpg is not known; must be .exr or .png or .mp4"),
    ((*RISE, "-o", "no/a%d.png"), "there is no folder no", "mkdir -p no"),
    ((*RISE, "-o", "no/a.mp4"), "there is no folder no", "mkdir -p no"),
    ((*RISE, "-o", "f.avi"), "f.avi: suffix .avi is not known", "write for example f.mp4"),
    ((*RISE, "-o", "f_%04d.MOV"), "suffix .MOV is not known", "write for example f.mp4"),
    ((*RISE, "-o", "f_%04d.mp4"), "f_%04d.mp4: a film is one file", "write for example f.mp4"),
    ((*RISE, "-o", "%d.mp4"), "%d.mp4: a film is one file", "write for example film.mp4"),
    ((*RISE, "-o", "./x%d.exr"), "-o ./x%d.exr: is given twice; give it once"),
    ((*RISE, "-o", "f.mp4", "-o", "f.mp4"), "-o f.mp4: is given twice; give it once"),
    (("--sun-path", "48,11"), "is not a place and a date", "such as 48.1,11.6,2024-12-21"),
    (("--sun-path", "48,11,2024-13-01"), "is not a place and a date"),
    (("--sun-path", "north,11,2024-01-01"), "is not a place and a date"),
    (("--sun-path", "91,11,2024-01-01"), "--sun-path 91,11,2024-01-01: latitude = 91; must be"),
    (("--sun-path", "nan,11,2024-01-01"), "latitude = nan; must be -90..90"),
    (("--sun-path", "-78,15,2024-06-21"), "polar night", "choose another date or place"),
    (("--sun-path", "48,11,1850-06-21"), "year 1850: must be 1900..2100"),
    (("--sun-path", "48,11", "--from", "2024-01-01T09:00Z"), "add --from and --to with two times"),
    (("--sun-path", "48,11", "--from", "2024-01-01T09:00Z", "--to", "2024-01-01T09:00+01:00"),
     "must be later than --from 2024-01-01T09:00:00+00:00"),
    (("--sun-path", "48,11,2024-01-01", "--to", "2024-01-01T09:00"), "has a date, whose whole day"),
    (("--sun-path", "98,11", "--from", "2024-01-01T09:00", "--to", "2024-01-01T10:00"),
     "--sun-path 98,11: latitude = 98"),
    ((*RISE, "--from", "2024-01-01T09:00Z"), "--from and --to go with --sun-path LAT,LON"),
    (("--sun-path", "48,11,2024-01-01", "--from", "2024-01-01"), "is a date without a time"),
    (("--sun-path", "48,11,2024-01-01", "--sun", "48,11,2024-01-01T09:00"), "leave one of the two"),
    ((*RISE, "--sun-path", "48,11,2024-01-01"), "--sun-path moves light.0.altitude_deg"),
    (("--set", "light.0.azimuth_deg=3", "--sun-path", "48,11,2024-01-01"), "--sun-path moves"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("frames", "rate", "count"),
    [("0.1s", ("--fps", "25"), 2), ("0.1s", ("-o", "f.mp4"), 3), ("0.05s", ("--fps", "40"), 2)],
)
def test_frames_in_seconds(call, monkeypatch, frames, rate, count):
    planned = []

    def plan(name, overrides, number, *rest):
        planned.append(number)
        raise InputError("enough")

    monkeypatch.setattr("rtbow.sequence.animation.plan_animation", plan)
    assert call("animate", *RISE, "--frames", frames, *rate, "-o", "%d.exr").code == 2
    assert planned == [count]


@pytest.mark.parametrize(("args", "words"), [(args, words) for args, *words in NOTHING_DRAWN])
@pytest.mark.usefixtures("no_rendering")
def test_what_is_refused_before_anything_is_drawn(call, tmp_path, args, words):
    assert_refused(call("animate", "uniform", "--frames", "3", "-o", "x%d.exr", *args), *words)
    assert names(tmp_path) == []


def test_a_lamp_follows_no_path_of_the_sun(call):
    day = ("--sun-path", "48,11,2024-01-01", "--frames", "2", "-o", "x%d.exr")
    result = call("animate", "street-lamp", *day)
    assert result.code == 2
    assert "--sun-path moves light 0, which is a lamp in street-lamp; choose" in result.err


# --- Frames ------------------------------------------------------------------------------------


def test_frames_are_numbered_from_the_start_to_the_end(call, tmp_path, drawn):
    result = call("animate", "uniform", *RISE, "--frames", "3", "-o", "f_%03d.exr", *SMALL)
    assert result == Result(0, "f_%03d.exr\n", "3 frames drawn by method fast\n")
    files = ["f_000.exr", "f_001.exr", "f_002.exr"]
    assert names(tmp_path) == ["f.sequence.json", *files]
    assert drawn == [2.0, 2.0, 21.0, 40.0]  # the first once more, with tables for all places
    assert len({read_exr(name)[0].tobytes() for name in files}) == 3


def test_one_frame_is_the_start(call, tmp_path, drawn):
    assert call("animate", *RISE, "--frames", "1", "-o", "%d.exr", "--size", "8x5", "-q") == Result(
        0, "", ""
    )
    assert drawn == [2.0]
    assert "light.0.altitude_deg=2.0" in read_exr("0.exr")[1]["scene"]


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_render_makes_the_frame_again_from_what_it_says(call, tmp_path, suffix):
    """To the error of method fast in float32: measured 8e-4 of the brightest pixel."""
    moves = (*RISE, "--key", "camera.position_m.0=0:30", "--set", "light.0.spectrum=FL2")
    args = ("--frames", "4", "-o", f"a %d.{suffix}", *SMALL, "--max-delta-e", "0.4", "-q")
    assert call("animate", "uniform", *moves, *args).code == 0
    path = f"a 2.{suffix}"
    read = read_exr if suffix == "exr" else read_png
    frame, said = read(path)
    words = shlex.split(said["command"])
    assert words[:3] == ["rtbow", "render", "uniform"]
    assert words[-2:] == ["-o", path]
    assert said["animation"].startswith("rtbow animate uniform --key light.0.altitude_deg=2:40")
    assert said["method"] == "fast"
    os.remove(path)
    assert call(*words[1:]).code == 0
    again, told = read(path)
    assert told["scene"] == said["scene"]
    assert told["method"] == said["method"]
    if suffix == "exr":
        assert np.abs(again - frame).max() < 2e-3 * frame.max()
    else:
        assert told["exposureEV100"] == said["exposureEV100"]
        assert np.abs(again.astype(int) - frame).max() <= 2
        assert np.mean(again != frame) < 0.2


def test_the_method_asked_for_draws(call):
    for method in ("spectral", "reference"):
        args = ("--frames", "2", "-o", f"{method}%d.exr", "--size", "8x5", "--method", method)
        result = call("animate", "uniform", *RISE, *args)
        assert result == Result(0, f"{method}%d.exr\n", "2 frames drawn\n")
    one, other = (read_exr(f"{method}1.exr") for method in ("spectral", "reference"))
    assert other[1]["renderer"] == "CPU, float64"
    assert np.abs(one[0] - other[0]).max() < 2e-3 * other[0].max()


def test_whole_numbers_move(call):
    rain = (
        "--set", "droplets.radius={distribution='uniform', min_um=100, max_um=900}",
        "--set", "droplets.grid=[4, 4, 4]", "--key", "droplets.seed=1:3",
        "--method", "spectral",  # which has no table of all these radii to make for each frame
    )  # fmt: skip
    args = ("--frames", "3", "-o", "%d.exr", "--size", "8x5", "-q")
    assert call("animate", "uniform", *rain, *args) == Result(0, "", "")
    assert "# --set droplets.seed=2\n" in read_exr("1.exr")[1]["scene"]
    assert np.any(read_exr("0.exr")[0] != read_exr("1.exr")[0])


# --- Tables ------------------------------------------------------------------------------------


@pytest.fixture
def made(monkeypatch):
    """How many passes and lights of method fast, and renderers, were constructed."""
    counts = {"FastMethod": 0, "FastSun": 0, "Renderer": 0}

    def count(kind: type) -> None:
        true_init = kind.__init__

        def init(self, *args, **more):
            counts[kind.__name__] += 1
            true_init(self, *args, **more)

        monkeypatch.setattr(kind, "__init__", init)

    for kind in (
        rtbow.render.fast.method.FastMethod,
        rtbow.render.fast.method.FastSun,
        rtbow.render.renderer.Renderer,
    ):
        count(kind)
    return counts


@pytest.mark.parametrize(
    "moves",
    [
        RISE,
        ("--key", "camera.azimuth_deg=-20:20", "--key", "camera.fov_deg=60:50"),
        ("--sun-path", "48.1,11.6,2024-12-21"),
    ],
    ids=["light", "camera", "sun-path"],
)
def test_moving_places_build_tables_once(call, made, moves):
    """Once for the first frame, and once more for all places (``Renderer.prepare_moves``)."""
    args = ("--frames", "12", "-o", "%d.exr", "-o", "%d.png", *SMALL, "-q")
    assert call("animate", "uniform", *moves, *args) == Result(0, "", "")
    assert made == {"FastMethod": 1, "FastSun": 2, "Renderer": 1}


def test_what_changes_the_drops_builds_tables_for_each_frame(call, made):
    args = ("--frames", "4", "-o", "%d.exr", *SMALL, "-q")
    assert call("animate", "uniform", "--key", "droplets.radius.radius_um=200:500", *args).code == 0
    assert made == {"FastMethod": 4, "FastSun": 4, "Renderer": 1}


@pytest.mark.parametrize(
    "moves",
    [RISE, ("--sun-path", "48.1,11.6,2024-12-21"), ("--key", "camera.fov_deg=20:110")],
    ids=["light", "sun-path", "zoom"],
)
def test_frames_do_not_depend_on_where_a_run_began(call, moves):
    """A run that goes on draws, bit by bit, what the whole run drew."""
    args = ("animate", *moves, "--frames", "5", "-o", "%d.exr", "--size", "64x36", "-q")
    assert call(*args).code == 0
    whole = [read_exr(f"{k}.exr")[0] for k in range(5)]
    for first in (1, 4):
        for number in range(first, 5):
            os.remove(f"{number}.exr")
        assert call(*args).code == 0
        for number in range(first, 5):
            np.testing.assert_array_equal(read_exr(f"{number}.exr")[0], whole[number])


# --- What is kept ------------------------------------------------------------------------------

FIVE = ("animate", "uniform", *RISE, "--frames", "5", *SMALL)
RECORD = "frames.sequence.json"
ALTITUDES = [2.0, 11.5, 21.0, 30.5, 40.0]


@pytest.mark.parametrize("outputs", [("%d.exr",), ("%d.png",), ("%d.exr", "%d.png")])
def test_a_second_run_draws_nothing_and_needs_no_gl(call, tmp_path, request, outputs):
    args = (*FIVE, *(word for one in outputs for word in ("-o", one)))
    assert call(*args).code == 0
    before = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()}
    assert tmp_path / RECORD in before
    request.getfixturevalue("no_rendering")
    said = "".join(f"{one}\n" for one in outputs)
    assert call(*args) == Result(0, said, "0 frames drawn, 5 kept\n")
    after = {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()}
    assert after == before


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_frames_that_are_missing_or_damaged_are_drawn(call, tmp_path, drawn, suffix):
    args = (*FIVE, "-o", f"%d.{suffix}")
    assert call(*args).code == 0
    whole = contents(tmp_path)
    os.remove(f"1.{suffix}")
    (tmp_path / f"3.{suffix}").write_bytes(whole[f"3.{suffix}"][:-200])
    (tmp_path / f"4.{suffix}").write_bytes(whole[f"4.{suffix}"][:-700])
    drawn.clear()
    assert call(*args).err == "3 frames drawn by method fast, 2 kept\n"
    assert set(drawn) == {ALTITUDES[k] for k in (1, 3, 4)}
    assert contents(tmp_path) == whole


def test_frames_without_a_record_are_made_anew(call, tmp_path):
    """As an earlier version left them, or a process that was killed before it listed them."""
    assert call(*FIVE, "-o", "%d.exr").code == 0
    record = json.loads((tmp_path / RECORD).read_bytes())
    for number in (2, 4):
        del record["frames"][f"{number}.exr"]
    (tmp_path / RECORD).write_text(json.dumps(record))
    assert call(*FIVE, "-o", "%d.exr").err == "2 frames drawn by method fast, 3 kept\n"
    assert call(*FIVE, "-o", "%d.exr").err == "0 frames drawn, 5 kept\n"
    (tmp_path / RECORD).unlink()
    assert call(*FIVE, "-o", "%d.exr").err == "5 frames drawn by method fast\n"


def test_a_sequence_may_be_moved(call, tmp_path, monkeypatch):
    assert call(*FIVE, "-o", "%d.exr", "-o", "%d.png").code == 0
    files = contents(tmp_path)
    (tmp_path / "copy").mkdir()
    for name, data in files.items():
        (tmp_path / "copy" / name).write_bytes(data)
    monkeypatch.chdir("copy")
    assert call(*FIVE, "-o", "%d.png", "-o", "%d.exr").err == "0 frames drawn, 5 kept\n"


def test_pictures_that_were_scaled_are_made_anew(call):
    """Programs that do so keep a picture's texts."""
    assert call(*FIVE, "-o", "%d.png").code == 0
    picture, said = read_png("2.png")
    write_png("2.png", picture[::2, ::2], said)
    assert call(*FIVE, "-o", "%d.png").err == "1 frame drawn by method fast, 4 kept\n"
    np.testing.assert_array_equal(read_png("2.png")[0], picture)


@pytest.mark.parametrize(
    ("change", "kept"),
    [
        (("--method", "spectral"), 0),
        (("--size", "32x20"), 0),
        (("--set", "light.0.spectrum=FL2"), 0),
        (("--key", "camera.azimuth_deg=0:4"), 0),
        (("--max-delta-e", "2"), 0),
        (("--frames", "3"), 3),  # each second frame of the five
        (("--frames", "9"), 1),  # the first, which is the same
        (("--backend", "osmesa"), 5),
        (("-o", "film.mp4"), 5),
    ],
)
def test_frames_of_another_command_are_made_anew(call, change, kept):
    """What a frame's number now means decides; what cannot change the frame is no matter."""
    assert call(*FIVE, "-o", "%d.exr").code == 0
    if change[0] == "--frames" and change[1] == "3":
        for number, source in ((1, 2), (2, 4)):
            os.replace(f"{source}.exr", f"{number}.exr")
    result = call(*FIVE, "-o", "%d.exr", *change)
    assert result.code == 0
    count = int(change[1]) if change[0] == "--frames" else 5
    assert result.err.startswith(f"{count - kept} frames drawn")
    assert ("kept" in result.err) == (kept > 0)


def test_frames_of_another_version_are_made_anew(call, monkeypatch):
    assert call(*FIVE, "-o", "%d.exr").code == 0
    for module in (rtbow.sequence.run, rtbow.frames.image):
        monkeypatch.setattr(module, "__version__", "0.0.test")
    assert call(*FIVE, "-o", "%d.exr").err == "5 frames drawn by method fast\n"
    assert call(*FIVE, "-o", "%d.exr").err == "0 frames drawn, 5 kept\n"


def test_frames_of_changed_files_are_made_anew(call, tmp_path):
    lamp = tmp_path / "lamp.csv"
    lamp.write_text("380,0\n600,0\n610,1\n780,1\n")
    args = (*FIVE, "-o", "%d.exr", "--set", "light.0.spectrum=lamp.csv")
    assert call(*args).err.startswith("5 frames drawn")
    assert call(*args).err.endswith("5 kept\n")
    lamp.write_text("380,1\n450,1\n460,0\n780,0\n")
    assert call(*args).err.startswith("5 frames drawn")


def test_pictures_come_from_radiance_that_is_there(call, drawn):
    assert call(*FIVE, "-o", "%d.exr").code == 0
    drawn.clear()
    assert call(*FIVE, "-o", "%d.exr", "-o", "%d.png").err == "0 frames drawn, 5 kept\n"
    assert drawn == []
    rgb, said = read_exr("3.exr")
    picture, told = read_png("3.png")
    np.testing.assert_array_equal(picture, display(rgb, float(told["exposureEV100"])))
    for name in ("method", "renderer", "scene"):
        assert told[name] == said[name]


@pytest.mark.parametrize("suffix", ["exr", "png"])
def test_an_interrupted_run_leaves_whole_files_and_goes_on(
    call, tmp_path, drawn, monkeypatch, suffix
):
    writer = f"write_{suffix}"
    true_write = getattr(rtbow.sequence.run, writer)

    def interrupted(path, *args, **more):
        if path == f"3.{suffix}":
            raise KeyboardInterrupt
        true_write(path, *args, **more)

    args = (*FIVE, "-o", f"%d.{suffix}", "-o", "film.mp4", "--overwrite")
    (tmp_path / "film.mp4").write_bytes(b"old")
    monkeypatch.setattr(rtbow.sequence.run, writer, interrupted)
    result = call(*args)
    assert (result.code, result.out) == (130, "")
    assert result.err.strip() == "interrupted; nothing was left half written"
    assert names(tmp_path) == [*(f"{k}.{suffix}" for k in range(3)), "film.mp4", RECORD]
    assert (tmp_path / "film.mp4").read_bytes() == b"old"
    monkeypatch.setattr(rtbow.sequence.run, writer, true_write)
    drawn.clear()
    assert call(*args).err == "2 frames drawn by method fast, 3 kept\n"
    assert len(film_pictures(tmp_path / "film.mp4")) == 5
    # A picture knows the exposure; radiance is asked for it, and the last frame drawn for it.
    assert set(drawn) == set(ALTITUDES[3:])


FRAMES = 80
"""Of a run that is broken off: after the first few there are seconds of work left."""


@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
    ids=["ctrl-c", "sigterm"],
)
def test_broken_off_and_again(tmp_path, number, code, word):
    """As typed: a process of its own is broken off after some frames, and the next goes on."""
    args = [
        "animate",
        "uniform",
        *RISE,
        "--frames",
        str(FRAMES),
        "-o",
        "%03d.exr",
        "-o",
        "film.mp4",
        *SMALL,
    ]
    with spawn(*args, cwd=tmp_path) as process:
        try:
            while not (tmp_path / "004.exr").exists():
                assert process.poll() is None
            process.send_signal(number)
            err = process.communicate(timeout=60)[1]
        finally:
            process.kill()
    assert process.returncode == code
    assert err.rstrip().endswith(f"{word}; nothing was left half written")
    *left, record = names(tmp_path)
    assert record == RECORD
    assert left[:5] == [f"{k:03d}.exr" for k in range(5)]
    assert len(left) < FRAMES
    assert all(name.endswith(".exr") for name in left)
    for name in left:
        read_exr(tmp_path / name)
    listed = json.loads((tmp_path / RECORD).read_bytes())["frames"]
    assert len(listed) in (len(left) - 1, len(left))  # without one that was just finished
    done = execute(*args, cwd=tmp_path)
    assert done.code == 0, done.err
    assert done.err.endswith(f", {len(listed)} kept\n")
    assert len(film_pictures(tmp_path / "film.mp4")) == FRAMES


# --- What is in the way ------------------------------------------------------------------------


@pytest.fixture
def foreign(tmp_path):
    """Files of the frames' names that are none of a sequence."""
    write_png("1.png", np.zeros((18, 32, 3), np.uint8), {"command": "rtbow render"})
    (tmp_path / "2.png").write_bytes(b"a letter")
    (tmp_path / "4.png").write_bytes(b"")
    return contents(tmp_path)


def test_files_of_others_are_refused_before_anything_is_drawn(
    call, tmp_path, foreign, no_rendering
):
    result = call(*FIVE, "-o", "%d.exr", "-o", "%d.png")
    assert_refused(
        result,
        "1.png: is there, and rtbow animate did not write it (3 such files); choose another folder"
        " or name, remove them, or let --overwrite replace them",
    )
    assert contents(tmp_path) == foreign


def test_one_file_of_others(call, tmp_path, no_rendering):
    (tmp_path / "3.exr").touch()
    assert_refused(
        call(*FIVE, "-o", "%d.exr"),
        "3.exr: is there, and rtbow animate did not write it; choose another folder or name,"
        " remove it, or let --overwrite replace it",
    )


@pytest.mark.parametrize("overwrite", [(), ("--overwrite",)])
@pytest.mark.usefixtures("no_rendering")
def test_folders_are_refused_before_anything_is_drawn(call, tmp_path, overwrite):
    (tmp_path / "3.exr").mkdir()
    (tmp_path / "1.exr").touch()
    result = call(*FIVE, "-o", "%d.exr", *overwrite)
    assert_refused(result, "3.exr: is a folder; must be a file; choose another name, or move it")
    assert "--overwrite" not in result.err
    assert names(tmp_path) == ["1.exr", "3.exr"]


@pytest.mark.parametrize("text", ["{}", "[1]", "a letter", '{"frames": [], "exposure_ev": {}}'])
def test_a_file_in_the_records_place(call, tmp_path, text):
    (tmp_path / RECORD).write_text(text)
    result = call(*FIVE, "-o", "%d.exr", "-o", "%d.png")
    assert_refused(result, f"{RECORD}: is there, and rtbow animate did not write it; choose")
    assert contents(tmp_path) == {RECORD: text.encode()}
    assert call(*FIVE, "-o", "%d.exr", "--overwrite").err == "5 frames drawn by method fast\n"
    assert call(*FIVE, "-o", "%d.exr").err == "0 frames drawn, 5 kept\n"


@pytest.mark.usefixtures("no_rendering")
def test_a_film_of_others_is_refused_before_anything_is_drawn(call, tmp_path):
    (tmp_path / "film.mp4").write_bytes(b"a holiday")
    (tmp_path / "2.png").write_bytes(b"a letter")
    before = contents(tmp_path)
    args = (*FIVE, "-o", "%d.png", "-o", "film.mp4")
    assert_refused(call(*args), "2.png: is there, and rtbow animate did not write it (2 such files")
    (tmp_path / "2.png").unlink()
    del before["2.png"]
    message = (
        "film.mp4: is there, and rtbow animate did not write it; choose another folder or name,"
        " remove it, or let --overwrite replace it"
    )
    assert_refused(call(*args), message)
    # A film as another program makes it.
    with av.open("film.mp4", "w") as container:
        container.add_stream("libx264", rate=25, width=16, height=16, pix_fmt="yuv420p")
        container.metadata["title"] = "a holiday"
        container.start_encoding()
    before = contents(tmp_path)
    assert_refused(call(*args), message)
    assert contents(tmp_path) == before


def test_a_film_of_ones_own_is_replaced(call, tmp_path):
    args = ("animate", "uniform", *RISE, "--frames", "2", "-o", "film.mp4", "-q", *SMALL)
    (tmp_path / "film.mp4").write_bytes(b"a holiday")
    assert call(*args, "--overwrite").code == 0
    assert call(*args, "--frames", "3").code == 0
    assert len(film_pictures(tmp_path / "film.mp4")) == 3


def test_files_of_others_are_replaced_on_demand(call, foreign):
    result = call(*FIVE, "-o", "%d.png", "--overwrite")
    assert result == Result(0, "%d.png\n", "5 frames drawn by method fast\n")
    assert call(*FIVE, "-o", "%d.png").err == "0 frames drawn, 5 kept\n"


def test_a_frame_that_render_made_is_not_the_sequences(call):
    assert call(*FIVE, "-o", "%d.exr", "-q").code == 0
    words = shlex.split(read_exr("2.exr")[1]["command"])
    assert call(*words[1:], "-q").code == 0
    assert_refused(call(*FIVE, "-o", "%d.exr"), "2.exr: is there, and rtbow animate did not")


def test_frames_of_a_longer_sequence_are_told(call, tmp_path):
    assert call(*FIVE, "-o", "%d.exr", "-o", "a_%02d.png", "-q").code == 0
    short = (*FIVE, "--frames", "3", "-o", "%d.exr")
    drawn = "2 frames drawn by method fast, 1 kept\n"
    said = "3.exr and 1 more lie beyond the last frame of this run; remove them if they do not"
    assert call(*short).err == f"{drawn}{said} belong to it\n"
    os.remove("4.exr")
    assert call(*short).err.endswith("3.exr lies beyond the last frame of this run; remove it if"
                                     " it does not belong to it\n")  # fmt: skip
    assert call(*short, "-q") == Result(0, "", "")
    assert call(*short, "-o", "a_%02d.png").err.count("3.exr and 2 more lie beyond") == 1
    assert {"3.exr", "a_03.png", "a_04.png"} <= set(names(tmp_path))


# --- Exposure ----------------------------------------------------------------------------------


def lit(level: float, size: tuple[int, int] = (6, 8)) -> np.ndarray:
    return np.full((*size, 3), level, np.float32)


def test_the_brightest_frame_sets_the_exposure():
    evs = [auto_exposure_ev(lit(level)) for level in (10.0, 5000.0, 300.0)]
    chosen = sequence_exposure_ev([lit(level) for level in (10.0, 5000.0, 300.0)])
    assert chosen == pytest.approx(max(evs), abs=1e-4)
    assert chosen == float(f"{chosen:.6g}")


def test_black_frames_say_nothing_about_exposure():
    """A lamp's frames lie near EV 4, far below the 15 of a frame without light."""
    night = lit(10.0)
    assert sequence_exposure_ev([lit(0.0), night]) == pytest.approx(
        auto_exposure_ev(night), abs=1e-4
    )
    assert sequence_exposure_ev([lit(0.0)]) == BLACK_FRAME_EV


def test_one_exposure_for_the_whole_sequence(call):
    """The sun rises through red: frames of their own would be exposed alike."""
    assert call("animate", *RISE, "--frames", "5", "-o", "%d.exr", "-o", "%d.png", *SMALL).code == 0
    evs = {png_texts(f"{k}.png")["exposureEV100"] for k in range(5)}
    frames = [read_exr(f"{k}.exr")[0] for k in range(5)]
    own = [auto_exposure_ev(rgb) for rgb in frames]
    assert max(own) - min(own) > 0.5
    assert evs == {f"{max(own[0], own[2], own[4]):.6g}"}
    for number, rgb in enumerate(frames):
        picture = display(rgb, float(min(evs)))
        np.testing.assert_array_equal(read_png(f"{number}.png")[0], picture)


def test_an_exposure_of_ones_own(call):
    assert call(*FIVE, "-o", "%d.png", "--exposure", "12").code == 0
    said = png_texts("4.png")
    assert said["exposureEV100"] == "12"
    assert "--exposure=12.0" in said["command"]
    assert call(*FIVE, "-o", "%d.png", "--exposure", "12").err == "0 frames drawn, 5 kept\n"
    assert call(*FIVE, "-o", "%d.png", "--exposure", "13").err.startswith("5 frames drawn")


def test_pictures_of_another_range_do_not_lend_their_exposure(call):
    assert call(*FIVE, "-o", "%d.png").code == 0
    first = png_texts("0.png")["exposureEV100"]
    dim = ("animate", "uniform", "--key", "light.0.altitude_deg=1:1.5", "--frames", "5", *SMALL)
    assert call(*dim, "-o", "%d.png").err.startswith("5 frames drawn")
    assert {png_texts(f"{k}.png")["exposureEV100"] for k in range(5)} != {first}


def test_what_the_scene_names_counts_for_the_exposure(call, tmp_path):
    """A spectrum's file that has changed since lends its earlier brightness to no picture."""
    (tmp_path / "lamp.csv").write_text("380,1\n780,1\n")
    args = (*FIVE, "-o", "%d.png", "--set", "light.0.spectrum=lamp.csv")
    args = (*args, "--set", "light.0.irradiance_w_m2=none")
    assert call(*args).code == 0
    first = {png_texts(f"{k}.png")["exposureEV100"] for k in range(5)}
    (tmp_path / "lamp.csv").write_text("380,1\n500,1\n501,0\n780,0\n")
    assert call(*args).err.startswith("5 frames drawn")
    second = {png_texts(f"{k}.png")["exposureEV100"] for k in range(5)}
    assert len(first) == len(second) == 1
    assert first != second


# --- Films -------------------------------------------------------------------------------------


def test_a_film_shows_the_pictures(call, tmp_path):
    """In their brightness: 2 × 2 pixels share a colour, and these are small pictures."""
    assert call(*FIVE, "-o", "%d.png", "-o", "film.mp4", "--fps", "12").code == 0
    pictures = film_pictures(tmp_path / "film.mp4")
    assert len(pictures) == 5
    for number, picture in enumerate(pictures):
        stored = read_png(f"{number}.png")[0]
        ours, theirs = (one @ [0.2126, 0.7152, 0.0722] for one in (stored, picture))
        assert np.abs(ours - theirs).mean() < 4.0
    with av.open("film.mp4") as container:
        assert container.streams.video[0].average_rate == 12
        said = dict(container.metadata)
    assert said["command"].startswith("rtbow animate uniform")
    assert said["scene"] == load_scene("uniform", {"camera.size_px": [32, 18]}).source_text
    assert said["exposureEV100"] == png_texts("0.png")["exposureEV100"]


def test_a_film_alone_and_one_of_kept_frames_are_the_same(call, tmp_path, drawn):
    assert call(*FIVE, "-o", "alone.mp4").err == "5 frames drawn by method fast\n"
    assert names(tmp_path) == ["alone.mp4"]
    alone = film_pictures(tmp_path / "alone.mp4")
    assert call(*FIVE, "-o", "%d.exr").code == 0
    assert call(*FIVE, "-o", "%d.png").code == 0
    drawn.clear()
    for suffix in ("exr", "png"):
        result = call(*FIVE, "-o", f"%d.{suffix}", "-o", f"{suffix}.mp4")
        assert result.err == "0 frames drawn, 5 kept\n"
        np.testing.assert_array_equal(film_pictures(tmp_path / f"{suffix}.mp4"), alone)
    assert drawn == []


def test_each_frame_is_drawn_once_in_spite_of_the_exposure(call, drawn):
    assert call(*FIVE, "-o", "film.mp4").code == 0
    # First, first again with tables for all places, middle and last for the exposure, the rest.
    assert drawn == [2.0, 2.0, 21.0, 40.0, 11.5, 30.5]


def test_odd_sizes(call, tmp_path):
    args = ("--frames", "2", "-o", "film.mp4", "--size", "31x17", "-q")
    assert call("animate", "uniform", *RISE, *args) == Result(0, "", "")
    assert film_pictures(tmp_path / "film.mp4")[0].shape == (18, 32, 3)


def test_a_failure_in_drawing_spares_the_old_film(call, tmp_path, monkeypatch):
    (tmp_path / "film.mp4").write_bytes(b"old")

    def fail(*_):
        raise InputError("the volume is gone; bring it back")

    monkeypatch.setattr(rtbow.sequence.run, "display", fail)
    result = call(*FIVE, "-o", "film.mp4", "--overwrite")
    assert (result.code, result.out) == (2, "")
    assert names(tmp_path) == ["film.mp4"]
    assert (tmp_path / "film.mp4").read_bytes() == b"old"
