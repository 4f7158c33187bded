"""The bench: what a row says, that errors are measured, and what the reports make of rows.

No time is compared with anything: machines differ.
"""

from __future__ import annotations

import json
import math
import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import rtbow.bench.error
import rtbow.bench.run
import rtbow.bench.scaling
from checkout import ROOT
from rtbow.base.errors import InputError, UnavailableError
from rtbow.bench.error import (
    PixelSample,
    colour_error,
    reference_xyz,
    sample_pixels,
)
from rtbow.bench.floor import TABLE_SIDE, FloorPass
from rtbow.bench.memory import PeakMemory, cpu_count, cpu_name
from rtbow.bench.report import (
    COLUMNS,
    draw_scaling,
    draw_speed,
    fields_of,
    pareto_front,
    short,
    table_lines,
    write_json,
)
from rtbow.bench.row import BenchRow
from rtbow.bench.run import (
    Plan,
    TooSlowError,
    frames_for,
    run_bench,
    shader_methods,
)
from rtbow.bench.scaling import (
    AXES,
    lights_like,
    run_scaling,
    write_smooth_volume,
)
from rtbow.cli.main import rtbow as command_line
from rtbow.gl.context import open_context
from rtbow.physics.light.colour import rgb_to_xyz, xyz_to_rgb
from rtbow.reference.render import radiance_along, render_reference
from rtbow.render.renderer import METHODS, Renderer
from rtbow.scene.text.file import load_scene
from rtbow.world.camera import pixel_directions
from rtbow.world.rain.volume import load_volume

SMALL = (32, 18)
QUICK = Plan(size_px=SMALL, methods=("spectral",), frames=3, error_pixels=80)
# What scripts read: the interface's own keys, and those that go with them.
INTERFACE = {
    "scene", "method", "size_px", "frame_ms", "floor_ms", "delta_e_p50", "delta_e_p99",
    "delta_e_max", "relative_l2", "gl_renderer",
}  # fmt: skip
NUMBERS = (
    "frame_ms", "frame_ms_q25", "frame_ms_q75", "first_frame_ms", "pixels_per_second", "floor_ms",
    "floor_ms_q25", "floor_ms_q75", "floor_ratio", "speed_up", "spectral_ms", "delta_e_p50",
    "delta_e_p99", "delta_e_max", "relative_l2", "peak_rss_mib", "texture_bytes",
)  # fmt: skip


@pytest.fixture
def tools(monkeypatch):
    """The folder of tools, importable as it is for a script there."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))


@pytest.fixture(scope="module")
def measured() -> BenchRow:
    """One row, measured."""
    (row,) = run_bench(["uniform"], QUICK)
    return row


def made_up(scene="uniform", method="fast", setting=None, ms=2.0, error=0.2, **more) -> BenchRow:
    """A row that nothing measured."""
    numbers = {
        "common": {}, "size_px": (640, 360), "frames": 9, "frame_ms": ms, "frame_ms_q25": 0.9 * ms,
        "frame_ms_q75": 1.1 * ms, "first_frame_ms": 9.0 * ms, "pixels_per_second": 2.304e8 / ms,
        "floor_ms": 1.0, "floor_ms_q25": 0.9, "floor_ms_q75": 1.1, "floor_frames": 10,
        "floor_ratio": ms, "spectral_ms": 1000.0, "spectral_step_nm": 5.0, "speed_up": 1000.0 / ms,
        "delta_e_p50": error / 5.0, "delta_e_p99": error, "delta_e_max": 2.0 * error,
        "relative_l2": 1e-3, "error_pixels": 400, "error_sample": "400 of 230400 pixels",
        "peak_rss_mib": 200.0, "texture_bytes": 1_500_000,
        "gl_renderer": "llvmpipe (LLVM 15.0.6, 256 bits)", "backend": "egl", "cpu": "Some CPU",
        "cpu_count": 2, "load_average": 0.5, "command": "rtbow bench --json a.json",
    }  # fmt: skip
    return BenchRow(scene, method, setting or {}, **{**numbers, **more})


# --- What is measured --------------------------------------------------------------------------


def test_a_row_has_every_number(measured):
    row = measured.as_json()
    assert row.keys() >= INTERFACE
    assert row["scene"] == "uniform"
    assert row["method"] == "spectral"
    assert row["setting"] == {"render.wavelength_step_nm": 5.0}
    assert row["size_px"] == [32, 18]
    assert row["frames"] == 3
    assert row["floor_frames"] == 4  # before each frame and after the last
    for key in NUMBERS:
        assert isinstance(row[key], float | int), key
        assert math.isfinite(row[key]), key
        assert row[key] > 0.0, key
    assert row["frame_ms_q25"] <= row["frame_ms"] <= row["frame_ms_q75"]
    assert row["pixels_per_second"] == pytest.approx(32 * 18 / row["frame_ms"] * 1e3)
    assert row["floor_ratio"] == pytest.approx(row["frame_ms"] / row["floor_ms"])
    assert row["speed_up"] == 1.0
    assert row["spectral_step_nm"] == row["wavelength_step_nm"] == 5.0
    assert row["reference_step_nm"] == 1.0
    assert row["error_pixels"] == 80
    assert 0 < row["error_pixels_lit"] <= 80
    assert "80 of 576 pixels" in row["error_sample"]
    assert row["gl_renderer"]
    assert row["cpu"]
    assert row["cpu_count"] >= 1
    assert row["scaling"] is None
    assert row["skipped"] is None
    assert json.loads(json.dumps(row)) == row


def test_errors_are_those_of_the_frame(measured):
    """Small, not zero: float32 at 5 nm against float64 at 1 nm."""
    # 0.09 at the 99th percentile of the whole frame at 640 x 360.
    assert 1e-3 < measured.delta_e_p99 < 0.3
    assert measured.delta_e_p50 <= measured.delta_e_p99 <= measured.delta_e_max
    assert 1e-6 < measured.relative_l2 < 0.01


def test_a_spoiled_frame_shows(monkeypatch, measured):
    right = Renderer.render

    def spoiled(self, *args):
        return right(self, *args) * np.float32([1.3, 1.0, 0.8])

    monkeypatch.setattr(Renderer, "render", spoiled)
    (row,) = run_bench(["uniform"], QUICK)
    assert row.delta_e_p99 > 5.0
    assert row.delta_e_p50 > 10.0 * measured.delta_e_p50
    assert row.relative_l2 > 0.05


def test_a_frame_upside_down_shows(monkeypatch):
    """The sample takes the reference and the frame at the same places."""
    right = Renderer.render
    monkeypatch.setattr(Renderer, "render", lambda self, *args: right(self, *args)[::-1])
    (row,) = run_bench(["uniform"], QUICK)
    assert row.delta_e_p99 > 5.0


def test_without_error_pixels_there_is_no_error():
    (row,) = run_bench(["uniform"], replace(QUICK, error_pixels=0))
    assert row.frame_ms is not None
    assert row.delta_e_p99 is row.relative_l2 is row.reference_step_nm is None
    assert row.error_pixels == 0


def test_a_method_that_refuses_a_scene_is_told(monkeypatch):
    right = Renderer.render

    def refuse(self, *args):
        if self.scene.source_name == "default":
            raise InputError("not this one")
        return right(self, *args)

    monkeypatch.setattr(Renderer, "render", refuse)
    first, second = run_bench(["default", "uniform"], replace(QUICK, error_pixels=10))
    assert first.skipped == "not this one"
    assert first.frame_ms is None
    assert first.gl_renderer == second.gl_renderer != ""
    assert second.skipped is None
    with pytest.raises(InputError, match="not this one"):
        run_bench(["default"], QUICK)


def test_spectral_is_the_honest_one_unless_it_is_set():
    # The figure's own file says 10 nm.
    scene = QUICK.scene("figures/fig5f", dict(QUICK.variants()[0][1]))
    assert scene.render.wavelength_step_nm == 5.0
    plan = replace(QUICK, settings={"render.wavelength_step_nm": 20.0})
    assert plan.variants() == [("spectral", {})]
    assert plan.scene("uniform", {}).render.wavelength_step_nm == 20.0


def test_methods_are_the_shaders():
    assert "spectral" in shader_methods()
    assert set(shader_methods()) == set(METHODS) - {"auto", "reference"}


def test_slow_frames_are_fewer():
    assert frames_for(60.0) == 3
    assert frames_for(2.0) == 9
    assert 9 < frames_for(0.02) <= 99
    assert frames_for(0.0) == 99


def test_the_floor_is_one_look_up_per_pixel():
    with open_context() as gl:
        floor = FloorPass(gl, (8, 4))
        floor.draw()
        frame = floor.read()
    assert frame.shape == (4, 8, 3)
    # The table rises from 0 in the first texel's middle to 1 in the last's.
    x = (np.arange(8) + 0.5) / 8 * TABLE_SIDE - 0.5
    np.testing.assert_allclose(frame[0, :, 0], x / (TABLE_SIDE - 1), atol=2e-3)
    assert np.all(np.diff(frame[:, 0, 1]) < 0.0)  # up the picture


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_a_frame_too_large_for_the_floor(backend):
    with (
        open_context(backend) as gl,
        pytest.raises(UnavailableError, match="1000000 x 1 pixels; bench at a smaller size"),
    ):
        FloorPass(gl, (1_000_000, 1))


def test_peak_memory_grows_with_what_is_held():
    memory = PeakMemory()
    held = np.ones(30_000_000, dtype=np.uint8)
    assert memory.mib() is None or memory.mib() > held.nbytes / 2**20
    if memory.since == "row":
        assert memory.mib() >= memory.start_mib + 20.0
        del held
        assert PeakMemory().mib() < memory.mib() + 20.0
    assert cpu_count() >= 1
    assert cpu_name()


# --- Pixels and their reference ----------------------------------------------------------------


@pytest.mark.parametrize("size", [(640, 360), (7, 5), (100, 1), (1, 90), (33, 200)])
@pytest.mark.parametrize("count", [1, 3, 17, 34, 400])
def test_a_sample_has_its_count_and_no_pixel_twice(size, count):
    sample = sample_pixels(size, count)
    assert len(sample) == min(count, size[0] * size[1])
    assert len(set(zip(sample.rows, sample.columns, strict=True))) == len(sample)
    assert sample.rows.min() >= 0
    assert sample.columns.min() >= 0
    assert sample.rows.max() < size[1]
    assert sample.columns.max() < size[0]


def test_a_sample_is_spread_evenly_and_the_same_each_time():
    sample = sample_pixels((640, 360), 400)
    for places, side in ((sample.rows, 360), (sample.columns, 640)):
        quarters = np.histogram(places, bins=4, range=(0, side))[0]
        assert quarters.min() >= 80
        assert quarters.max() <= 120
    assert np.array_equal(sample.rows, sample_pixels((640, 360), 400).rows)
    assert sample_pixels((9, 5), None).whole
    assert sample_pixels((9, 5), 1000).describe() == "all 45 pixels"


def test_the_reference_is_that_of_the_whole_frame(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    scene = load_scene("uniform", {"camera.size_px": [12, 7], "render.wavelength_step_nm": 20.0})
    whole = render_reference(load_scene("uniform", {
        "camera.size_px": [12, 7], "render.wavelength_step_nm": 1.0,
    }))  # fmt: skip
    sample = sample_pixels((12, 7), 30)
    np.testing.assert_allclose(
        xyz_to_rgb(reference_xyz(scene, sample)), sample.of(whole), rtol=1e-9, atol=1e-9
    )


def test_both_parts_of_a_comparison_have_their_own_reference(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    split = {"split": 0.5, "right": {"droplets.density.number_per_m3": 3000.0}}
    scene = load_scene("uniform", {"camera.size_px": [12, 6], "compare": split})
    plain = load_scene("uniform", {"camera.size_px": [12, 6]})
    sample = sample_pixels((12, 6), None)
    both, one = (reference_xyz(each, sample).reshape(6, 12, 3) for each in (scene, plain))
    np.testing.assert_allclose(both[:, :6], one[:, :6])
    np.testing.assert_allclose(both[:, 6:], 3.0 * one[:, 6:])
    assert one[:, 6:].max() > 0.0


def test_the_reference_is_kept_between_runs(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    calls = []

    def counted(scene, rays):
        calls.append(len(rays))
        return np.ones((len(rays), 3))

    monkeypatch.setattr("rtbow.reference.render.radiance_along", counted)
    few, more = sample_pixels((12, 7), 10), sample_pixels((12, 7), 11)
    size = {"camera.size_px": [12, 7]}
    scene = load_scene("uniform", size)
    for _ in range(2):
        reference_xyz(scene, few)
    assert calls == [10]
    # What methods alone read makes no other reference; other pixels and other drops do.
    reference_xyz(load_scene("uniform", {**size, "render.wavelength_step_nm": 10.0}), few)
    assert calls == [10]
    reference_xyz(scene, more)
    reference_xyz(load_scene("uniform", {**size, "droplets.radius.radius_um": 301.0}), few)
    assert calls == [10, 11, 10]


def test_another_volume_of_the_same_name_is_another_reference(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    calls = []
    monkeypatch.setattr(
        "rtbow.reference.render.radiance_along",
        lambda scene, rays: calls.append(scene) or np.ones((len(rays), 3)),
    )
    path = tmp_path / "drops.npz"
    box = np.array([[-1.0, 1.0, 0.0], [1.0, 2.0, 1.0]])
    changes = {"camera.size_px": [8, 4], "droplets.file": str(path)}
    for side in (2, 3, 3):
        write_smooth_volume(path, side, box)
        reference_xyz(load_scene("uniform", changes), sample_pixels((8, 4), 5))
    assert len(calls) == 2


def test_a_dark_reference_has_no_error():
    assert colour_error(np.zeros((4, 3)), np.zeros((4, 3))) is None
    # Float32 ends where the dark side of a bow goes on: nobody sees either.
    assert colour_error(np.zeros((4, 3)), np.full((4, 3), 1e-25)) is None
    same = np.full((4, 3), 2.0)
    assert colour_error(same, rgb_to_xyz(same)).delta_e.worst == 0.0


def test_rays_are_those_of_the_pixels():
    scene = load_scene("uniform", {"camera.size_px": [9, 5]})
    sample = sample_pixels((9, 5), 12)
    rays = rtbow.bench.error._rays(scene, sample.rows, sample.columns)
    expected = pixel_directions(scene.camera)[sample.rows, sample.columns]
    np.testing.assert_array_equal(rays, expected)
    assert radiance_along(scene, rays[:2]).shape == (2, 3)


# --- Scaling -----------------------------------------------------------------------------------


def test_scaling_rows_name_axis_and_value():
    axes = {"pixels": (64, 256), "steps": (4,), "grid": (3,), "lights": (2,)}
    assert axes.keys() == AXES.keys()
    rows = run_scaling("uniform", replace(QUICK, size_px=(16, 9)), axes=axes)
    assert [(r.scaling["axis"], r.scaling["value"]) for r in rows] == [
        ("pixels", 64), ("pixels", 256), ("steps", 4), ("grid", 3), ("lights", 2),
    ]  # fmt: skip
    assert [r.size_px for r in rows] == [(8, 8), (16, 16), (16, 9), (16, 9), (16, 9)]
    for row in rows:
        assert row.skipped is None
        assert row.frame_ms > 0.0
        assert row.texture_bytes > 0
        assert row.delta_e_p99 is None
        assert "rtbow-bench" not in json.dumps(row.as_json())  # no folder that is gone by now
    lines = "\n".join(table_lines(rows))
    for words in ("8²", "3³", "lights", "steps"):
        assert words in lines


def test_points_that_would_take_too_long_are_skipped(monkeypatch):
    seen = []

    def slow(scene, row, plan, sample, show, limit_s):
        seen.append(row.scaling["value"])
        frame_ms = 125.0 * row.scaling["value"]
        done = replace(row, frame_ms=frame_ms, first_frame_ms=frame_ms + 500.0)
        return rtbow.bench.run.Measurement(done)

    monkeypatch.setattr(rtbow.bench.scaling, "measure", slow)
    rows = run_scaling("uniform", QUICK, 12.0, axes={"steps": (8, 16, 32, 64)})
    # Half a second of set-up and five frames: 5.5 s, 10.5 s, 20.5 s, 40.5 s.
    assert seen == [8, 16]
    assert rows[2].skipped == "about 20 s by the point before; may take 12 s"
    assert rows[3].skipped == "about 40 s by the point before; may take 12 s"
    assert rows[3].frame_ms is None


def test_nothing_follows_a_point_that_took_too_long(monkeypatch):
    def slow(scene, row, *args):
        raise TooSlowError("a frame takes 9 s")

    monkeypatch.setattr(rtbow.bench.scaling, "measure", slow)
    first, second = run_scaling("uniform", QUICK, 2.0, axes={"steps": (8, 16)})
    assert first.skipped == "a frame takes 9 s; a point may take 2 s"
    assert second.skipped == "more than the point before; may take 2 s"


def test_a_frame_beyond_the_limit_ends_its_point():
    scene = QUICK.scene("uniform", {})
    row = BenchRow("uniform", "spectral", {}, {}, SMALL)
    with pytest.raises(TooSlowError):
        rtbow.bench.run.measure(scene, row, QUICK, limit_s=1e-3)


def test_too_large_a_grid_is_not_tried(monkeypatch):
    monkeypatch.setattr(rtbow.bench.scaling, "free_mib", lambda: 10.0)
    plan = replace(QUICK, size_px=(8, 4))
    small, large = run_scaling("uniform", plan, axes={"grid": (2, 256)})
    assert small.skipped is None
    assert "256³ points takes about" in large.skipped


def test_lights_stand_side_by_side():
    suns = lights_like(load_scene("uniform"), 4)
    assert [light["azimuth_deg"] for light in suns] == [180.0, 183.0, 177.0, 186.0]
    lamps = lights_like(load_scene("street-lamp"), 3)
    assert [light["position_m"][0] for light in lamps] == [0.0, 0.5, -0.5]
    assert {light["luminous_flux_lm"] for light in lamps} == {8000.0}
    assert len(load_scene("street-lamp", {"light": lamps}).light) == 3


def test_the_smooth_volume_is_one(tmp_path):
    box = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    write_smooth_volume(tmp_path / "v.npz", 5, box)
    volume = load_volume(tmp_path / "v.npz")
    assert volume.shape == (5, 5, 5)
    assert volume.number_per_m3.min() > 0.0
    assert 300.0 <= volume.radius_range_um[0] < volume.radius_range_um[1] <= 700.0


# --- Reports -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "front"),
    [
        ([], []),
        ([(1.0, 1.0)], [0]),
        ([(1.0, 5.0), (2.0, 4.0), (3.0, 3.0)], [0, 1, 2]),
        ([(3.0, 3.0), (1.0, 5.0), (2.0, 6.0), (2.5, 3.5)], [1, 3, 0]),
        ([(1.0, 1.0), (2.0, 2.0), (0.5, 3.0)], [2, 0]),
        ([(1.0, 2.0), (1.0, 1.0), (1.0, 1.0)], [1]),
        ([(1.0, 1.0), (2.0, 1.0)], [0]),
    ],
)
def test_pareto_front(points, front):
    assert pareto_front(points) == front


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0"), (12345.6, "12346"), (1.2345, "1.23"), (0.012345, "0.0123"),
     (0.0001234, "1e-04"), (99.6, "99.6"), (999.9, "1000")],
)  # fmt: skip
def test_short_numbers(value, text):
    assert short(value) == text


def some_rows() -> list[BenchRow]:
    step = {"render.wavelength_step_nm": 5.0}
    rain = {"droplets.extinction": True}
    return [
        made_up("uniform", "spectral", step, 1000.0, 0.09),
        made_up("uniform", "fast", {"render.max_delta_e": 0.1}, 2.5, 0.08),
        made_up("uniform", "fast", {"render.max_delta_e": 0.5}, 1.25, 0.4),
        made_up("shower", "spectral", step, 29_312.7, 0.09, common=rain),
        made_up("shower", "fast", {}, 4.5, 0.6, common=rain),
        replace(made_up("downpour", "fast"), frame_ms=None, skipped="no\n filter; leave it out"),
        made_up("figures/fig5f", "fast", {}, 20.0, 0.5, speed_up=None, spectral_step_nm=None),
    ]


def some_scaling_rows() -> list[BenchRow]:
    rows = []
    for axis, values in AXES.items():
        for value in values:
            row = made_up("shower", ms=0.1 * value, scaling={"axis": axis, "value": value})
            rows.append(replace(row, delta_e_p99=None, error_pixels=0))
    rows[-1] = replace(rows[-1], frame_ms=None, skipped="about 70 s; may take 60 s")
    return rows


def test_the_table_fits_a_terminal():
    for rows in (some_rows(), some_scaling_rows()):
        lines = list(table_lines(rows))
        assert max(map(len, lines)) <= COLUMNS
        text = "\n".join(lines)
        assert "llvmpipe (LLVM 15.0.6, 256 bits)" in text
        assert "skipped: " in text
    lines = list(table_lines(some_rows()))
    titles = [line for line in lines if line.startswith("method")]
    assert len(titles) == 3
    assert len(set(titles)) == 1  # columns of all scenes stand in line
    assert any("shower with droplets.extinction=true, 640 × 360" in line for line in lines)
    assert "  fast: skipped: no filter; leave it out" in lines


def test_json_is_whole_rows(tmp_path):
    path = tmp_path / "bench.json"
    path.write_text("old")
    write_json(path, some_rows())
    assert json.loads(path.read_text("utf-8")) == fields_of(some_rows())
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, [made_up(error=math.nan)])
    assert json.loads(path.read_text("utf-8")) == fields_of(some_rows())


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_plots_are_written(tmp_path, suffix):
    speed, scaling = tmp_path / f"speed{suffix}", tmp_path / f"scaling{suffix}"
    assert draw_speed(speed, fields_of(some_rows()))
    assert draw_scaling(scaling, fields_of(some_scaling_rows()))
    if suffix == ".svg":
        shown = re.findall(r"<text[^>]*>([^<]*)</text>", speed.read_text("utf-8"))
        assert {"uniform", "figures/fig5f", "fast ΔE≤0.5", "spectral 5 nm", "floor"} <= set(shown)
        shown = re.findall(r"<text[^>]*>([^<]*)</text>", scaling.read_text("utf-8"))
        assert {"4096²", "512³", "lights", "textures, MiB"} <= set(shown)
    assert speed.stat().st_size > 2000
    nothing = tmp_path / f"nothing{suffix}"
    assert not draw_speed(nothing, [])
    assert not draw_scaling(nothing, fields_of(some_rows()))
    assert not nothing.exists()


@pytest.mark.parametrize("ratio", [1.0, 1.02, 3.0, 15.0, 150.0, 250.0, 1e5])
def test_logarithmic_axes_show_a_decade_with_numbers(monkeypatch, ratio):
    """Also where errors, times or sizes are alike: what tells them apart is then noise."""
    figures = []
    monkeypatch.setattr("rtbow.bench.report.save", lambda figure, path: figures.append(figure))
    # Not from 1, 2 or 5 on, where ticks are.
    speed = [made_up(ms=3.3 * one, error=0.33 * one, floor_ms=3.3) for one in (1.0, ratio)]
    steps = [
        replace(row, texture_bytes=3_300_000 * one, scaling={"axis": "steps", "value": value})
        for row, one, value in zip(speed, (1.0, ratio), (8, 512), strict=True)
    ]
    assert draw_speed(Path("speed.png"), fields_of(speed))
    assert draw_scaling(Path("scaling.png"), fields_of(steps))
    (one,), (times, sizes) = (figure.axes for figure in figures)
    shown = (
        (one.xaxis, 0.33), (one.yaxis, 3.3), (times.yaxis, 3.3), (sizes.yaxis, 3.3e6 / 2**20),
    )  # fmt: skip
    for axis, least in shown:
        assert axis.get_scale() == "log"
        low, high = axis.get_view_interval()
        assert high / low > max(10.0, ratio) * 0.999
        assert low < least <= ratio * least < high
        assert high / low < 15.0 * ratio**1.2  # with margins
        ticks = [tick for tick in axis.get_majorticklocs() if low <= tick <= high]
        assert len(ticks) >= 2
        write = axis.get_major_formatter()
        assert [float(write(tick)) for tick in ticks] == pytest.approx(ticks)
        assert axis.get_minor_formatter()(ticks[0]) == ""


# --- The command line --------------------------------------------------------------------------


def bench(*args):
    return CliRunner().invoke(command_line, ["bench", *map(str, args)])


def test_the_verb_writes_what_it_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["rtbow", "bench", "uniform"])
    file, plot = tmp_path / "b.json", tmp_path / "b.png"
    result = bench(
        "uniform", "uniform", "--size", "16x9", "--method", "spectral", "--frames", 3,
        "--error-pixels", 40, "--set", "droplets.radius.radius_um=400", "--json", file,
        "--plot", plot,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    (row,) = json.loads(file.read_text("utf-8"))  # one, though it was named twice
    assert row["common"] == {"droplets.radius.radius_um": 400}
    assert row["command"] == "rtbow bench uniform"
    assert plot.stat().st_size > 2000
    lines = result.output.splitlines()
    assert lines[-2:] == [str(file), str(plot)]
    assert any(line.startswith("spectral 5 nm ") for line in lines)
    quiet = bench("uniform", "--size", "8x4", "--method", "spectral", "--error-pixels", 0, "-q")
    assert quiet.output == ""


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("unifrom",), 'no built-in scene named "unifrom"; did you mean uniform'),
        (("unifrom",), "? random-1, random-2 and so on, to random-999999, are drawn at random"),
        (("nope",), ". random-1, random-2 and so on, to random-999999, are drawn at random"),
        (("random-0",), "random-1, random-2 and so on"),
        (("--method", "reference"), "--method reference: cannot be timed; must be "),
        (("--method", "quick"), "--method quick: cannot be timed; must be "),
        (("--method", "spectral", "--max-delta-e", "0.5"), "goes with method fast; add"),
        (("--json", "b.txt"), "must be .json"),
        (("--json", "nowhere/b.json"), "there is no folder nowhere"),
        (("--plot", "b.pdf"), "must be .png or .svg"),
        (("--plot", "b.png", "--error-pixels", "0"), "leave --error-pixels 0 out"),
        (("--scaling", "uniform", "shower"), "--scaling takes one scene, not 2"),
        (("--scaling", "--error-pixels", "3"), "--scaling compares no pixels"),
        (("--scaling-limit-s", "3"), "goes with --scaling; add it"),
        (("--scaling", "--scaling-limit-s", "nan"), "nan: must be a finite number of seconds"),
        (("--scaling", "--scaling-limit-s", "inf"), "inf: must be a finite number of seconds"),
        (("--scaling", "--scaling-limit-s", "0"), "0: must be a finite number of seconds, greater"),
        (("--set", "radius=3"), "unknown key radius"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, args, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(words)):
        command_line.main(["bench", *args], standalone_mode=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--size", "big"), "is not a size"),
        (("--error-pixels", "-4"), "is not a number of pixels; write 400, 0 for none, or all"),
        (("--frames", "2"), "3<=x<=10000"),
        (("--max-delta-e", "0.5", "--max-delta-e", "0"), "'0' is no error that method fast can"),
        (("--max-delta-e", "nan"), "write a number, 0.25..20"),
        (("plot.png",), "name a .toml file or a built-in scene"),
    ],
)
def test_bad_options(args, words):
    result = bench(*args)
    assert result.exit_code == 2
    assert words in result.output


# --- docs/performance.md -----------------------------------------------------------------------


def test_the_document_says_what_is_met(tmp_path, tools):
    import performance

    gpu = replace(made_up("uniform", "fast", {}, 0.02, 0.3), gl_renderer="NVIDIA H200/PCIe/SSE2")
    files = [tmp_path / "a.json", tmp_path / "b.json"]
    write_json(files[0], some_rows())
    write_json(files[1], [*some_scaling_rows(), made_up("shower", "fast", {}, 8.0, 0.3)])
    output = tmp_path / "docs" / "performance.md"
    written = performance.write_document(performance.read_rows(files), output)
    text = output.read_text("utf-8")
    device = "llvmpipe (LLVM 15.0.6, 256 bits)"
    # uniform: the quickest that keeps the error; speed 1000 / 1.25, floor 1.25.
    assert (
        "| uniform | fast ΔE≤0.5 | 800 (≥ 500): met | 1.25 (≤ 1.5): met | 0.4 (≤ 0.5): met |"
        f" 1.25 | {device} |"
    ) in text
    assert "| shower | fast | 125 (≥ 200): **not met** | 8 (≤ 4): **not met** | 0.3" in text
    assert "| shower with droplets.extinction=true | fast | 222 (≥ 100): met" in text
    assert "0.6 (≤ 0.5): **not met**" in text
    assert "| figures/fig5f | fast | not measured | 20 (≤ 25): met | 0.5 (≤ 1): met |" in text
    assert "| lamp-shower | – | not measured | not measured | not measured |" in text
    assert "## On a GPU\n\nNot measured. No row was drawn on a GPU.\n" in text
    assert "rtbow bench --json a.json" in text
    assert "- downpour, fast: skipped: no filter; leave it out" in text
    assert "- shower, fast, 16: skipped: about 70 s; may take 60 s" in text
    assert "| 4096² | 1 |" in text
    for line in text.splitlines():
        if line.startswith("| ") and not line.startswith(("| ---", "| scene")):
            assert line.endswith((f"| {device} |", "| device |")), line
    for path in written:
        assert path.stat().st_size > 0
        if path.suffix == ".png":
            assert f"]({path.relative_to(output.parent).as_posix()})" in text
    assert len(written) == 3
    write_json(files[1], [gpu])
    performance.write_document(performance.read_rows(files), output)
    text = output.read_text("utf-8")
    assert "### NVIDIA H200/PCIe/SSE2" in text.partition("## On a GPU")[2]
    assert "No row was drawn on a GPU" not in text


def test_later_files_replace_earlier_rows(tmp_path, tools):
    import performance

    files = [tmp_path / "a.json", tmp_path / "b.json"]
    write_json(files[0], [made_up(ms=3.0), made_up("shower", ms=3.0)])
    write_json(files[1], [made_up(ms=4.0)])
    rows = performance.read_rows(files)
    assert [(row["scene"], row["frame_ms"]) for row in rows] == [("uniform", 4.0), ("shower", 3.0)]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be read: No such file"),
        ("[", "cannot be read: not JSON"),
        ("{}", "is not a list of rows"),
        ("[3]", "is not a list of rows"),
        ('[{"scene": "uniform"}]', "row 0 lacks method"),
    ],
)
def test_files_that_are_no_rows(tmp_path, tools, content, words):
    import performance

    path = tmp_path / "a.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=re.escape(words)):
        performance.read_rows([path])


def test_every_target_is_a_row_of_its_own(tools):
    import performance

    keys = [(target.scene, *target.settings) for target in performance.TARGETS]
    assert len(set(keys)) == len(keys) == 6


@pytest.mark.parametrize(
    ("renderer", "gpu"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", False),
        ("softpipe", False),
        ("SWR (LLVM 8.0)", False),
        ("", False),
        ("NVIDIA H200/PCIe/SSE2", True),
        ("Mesa Intel(R) Graphics (ADL GT2)", True),
    ],
)
def test_what_counts_as_a_gpu(tools, renderer, gpu):
    import performance

    assert performance.on_gpu({"gl_renderer": renderer}) is gpu


def test_samples_of_frames_are_float64():
    sample = PixelSample((2, 1), np.array([0]), np.array([1]))
    found = sample.of(np.arange(6, dtype=np.float32).reshape(1, 2, 3))
    assert found.dtype == np.float64
    assert found.tolist() == [[3.0, 4.0, 5.0]]
