"""What is measured, and what a row says of it.

No time is compared with anything: machines differ.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from pydantic import TypeAdapter

from rtbow.base.errors import InputError
from rtbow.bench.row import BenchRow, Timing
from rtbow.bench.run import Plan, frames_for, run_bench, shader_methods
from rtbow.render.renderer import METHODS, Renderer

QUICK = Plan(size_px=(32, 18), methods=("spectral",), frames=3, error_pixels=80)
# What scripts read.
INTERFACE = {
    "scene", "method", "size_px", "frame_ms", "floor_ms", "delta_e_p50", "delta_e_p99",
    "delta_e_max", "relative_l2", "gl_renderer",
}  # fmt: skip


@pytest.fixture(scope="module")
def measured() -> BenchRow:
    """One row, measured."""
    (row,) = run_bench(["uniform"], QUICK)
    return row


def leaves(record: dict) -> dict:
    """All values of a row as JSON holds it, by their own keys."""
    found = {}
    for key, value in record.items():
        found |= leaves(value) if isinstance(value, dict) else {key: value}
    return found


def test_a_row_has_every_number(measured):
    row = measured.as_json()
    assert row.keys() >= INTERFACE
    assert row["scene"] == "uniform"
    assert row["method"] == "spectral"
    assert row["setting"] == {"render.wavelength_step_nm": 5.0}
    values = leaves(row)
    values.pop("load_average")  # 0 on an idle machine, and not known on every system
    for key, value in values.items():
        if isinstance(value, int | float):
            assert math.isfinite(value), key
            assert value > 0.0, key
    assert {key for key, value in values.items() if value is None} == {"scaling", "skipped"}
    assert row["frame_ms"] == row["times"]["frame"]["median_ms"]
    assert row["delta_e_p99"] == row["error"]["difference"]["delta_e"]["p99"]
    copy = json.loads(json.dumps(row))
    assert copy["size_px"] == [32, 18]
    assert TypeAdapter(BenchRow).validate_python(copy) == measured


def test_a_row_says_how_it_was_measured(measured):
    frame, floor, error = measured.times.frame, measured.times.floor, measured.error
    assert frame.frames == 3
    assert floor.frames == 4  # before each frame and after the last
    assert frame.q25_ms <= frame.median_ms <= frame.q75_ms
    assert measured.pixels_per_second == pytest.approx(32 * 18 / frame.median_ms * 1e3)
    assert measured.floor_ratio == pytest.approx(frame.median_ms / floor.median_ms)
    assert measured.speed_up == 1.0
    assert measured.spectral_step_nm == measured.wavelength_step_nm == 5.0
    assert error.reference_step_nm == 1.0
    assert error.pixels == 80
    assert 0 < error.pixels_lit <= 80
    assert "80 of 576 pixels" in error.sample
    assert measured.machine.gl_renderer
    assert measured.machine.cpu


def test_timings_are_quartiles_in_ms():
    assert Timing.of([0.001, 0.005, 0.002, 0.004, 0.003]) == Timing(3.0, 2.0, 4.0, 5)


def test_errors_are_those_of_the_frame(measured):
    """Small, not zero: float32 at 5 nm against float64 at 1 nm."""
    delta_e = measured.difference.delta_e
    # 0.09 at the 99th percentile of the whole frame at 640 x 360.
    assert 1e-3 < delta_e.p99 < 0.3
    assert delta_e.median <= delta_e.p99 <= delta_e.worst
    assert 1e-6 < measured.difference.l2 < 0.01


def test_a_spoiled_frame_shows(monkeypatch, measured):
    right = Renderer.render

    def spoiled(self, *args):
        return right(self, *args) * np.float32([1.3, 1.0, 0.8])

    monkeypatch.setattr(Renderer, "render", spoiled)
    (row,) = run_bench(["uniform"], QUICK)
    assert row.difference.delta_e.p99 > 5.0
    assert row.difference.delta_e.median > 10.0 * measured.difference.delta_e.median
    assert row.difference.l2 > 0.05


def test_a_frame_upside_down_shows(monkeypatch):
    """The sample takes the reference and the frame at the same places."""
    right = Renderer.render
    monkeypatch.setattr(Renderer, "render", lambda self, *args: right(self, *args)[::-1])
    (row,) = run_bench(["uniform"], QUICK)
    assert row.difference.delta_e.p99 > 5.0


def test_without_error_pixels_there_is_no_error():
    (row,) = run_bench(["uniform"], replace(QUICK, error_pixels=0))
    assert row.frame_ms > 0.0
    assert row.error is None
    assert row.as_json()["delta_e_p99"] is None


def test_a_row_says_why_a_method_refused_its_scene(monkeypatch):
    right = Renderer.render

    def refuse(self, *args):
        if self.scene.source_name == "curtain":
            raise InputError("not this one")
        return right(self, *args)

    monkeypatch.setattr(Renderer, "render", refuse)
    first, second = run_bench(["curtain", "uniform"], replace(QUICK, error_pixels=10))
    assert first.skipped == "not this one"
    assert first.times is first.memory is first.error is None
    assert first.machine.gl_renderer == second.machine.gl_renderer != ""
    assert second.skipped is None
    with pytest.raises(InputError, match="not this one"):
        run_bench(["curtain"], QUICK)


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
