"""Points along the axes of a scaling run.

No time is compared with anything: machines differ.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from rtbow.bench.report import table_lines
from rtbow.bench.row import Times, Timing
from rtbow.bench.run import Measurement, Plan, TooSlowError, measure
from rtbow.bench.scaling import AXES, lights_like, run_scaling, write_smooth_volume
from rtbow.scene.text.file import load_scene
from rtbow.world.rain.volume import load_volume

QUICK = Plan(size_px=(32, 18), methods=("spectral",), frames=3)


def test_scaling_rows_name_axis_and_value():
    axes = {"pixels": (64, 256), "steps": (4,), "grid": (3,), "lights": (2,)}
    assert axes.keys() == AXES.keys()
    rows = run_scaling("uniform", replace(QUICK, size_px=(16, 9)), axes=axes)
    assert [(r.scaling.axis, r.scaling.value) for r in rows] == [
        ("pixels", 64), ("pixels", 256), ("steps", 4), ("grid", 3), ("lights", 2),
    ]  # fmt: skip
    assert [r.size_px for r in rows] == [(8, 8), (16, 16), (16, 9), (16, 9), (16, 9)]
    for row in rows:
        assert row.skipped is None
        assert row.frame_ms > 0.0
        assert row.memory.texture_bytes > 0
        assert row.error is None
        assert "rtbow-bench" not in json.dumps(row.as_json())  # no folder that is gone by now
    lines = "\n".join(table_lines(rows))
    for words in ("8²", "3³", "lights", "steps"):
        assert words in lines


def test_points_that_would_take_too_long_are_skipped(monkeypatch):
    seen = []

    def slow(scene, row, plan, sample, show, limit_s):
        seen.append(row.scaling.value)
        frame_ms = 125.0 * row.scaling.value
        timing = Timing(frame_ms, frame_ms, frame_ms, 3)
        return Measurement(replace(row, times=Times(timing, timing, frame_ms + 500.0)))

    monkeypatch.setattr("rtbow.bench.scaling.measure", slow)
    rows = run_scaling("uniform", QUICK, 12.0, axes={"steps": (8, 16, 32, 64)})
    # Half a second of set-up and five frames: 5.5 s, 10.5 s, 20.5 s, 40.5 s.
    assert seen == [8, 16]
    assert rows[2].skipped == "about 20 s by the point before; may take 12 s"
    assert rows[3].skipped == "about 40 s by the point before; may take 12 s"
    assert rows[3].times is None


def test_nothing_follows_a_point_that_took_too_long(monkeypatch):
    def slow(scene, row, *args):
        raise TooSlowError("a frame takes 9 s")

    monkeypatch.setattr("rtbow.bench.scaling.measure", slow)
    first, second = run_scaling("uniform", QUICK, 2.0, axes={"steps": (8, 16)})
    assert first.skipped == "a frame takes 9 s; a point may take 2 s"
    assert second.skipped == "more than the point before; may take 2 s"


def test_a_frame_beyond_the_limit_ends_its_point():
    scene = QUICK.scene("uniform", {})
    row = QUICK.row(scene, "spectral", {})
    with pytest.raises(TooSlowError):
        measure(scene, row, QUICK, limit_s=1e-3)


def test_too_large_a_grid_is_not_tried(monkeypatch):
    monkeypatch.setattr("rtbow.bench.scaling.free_mib", lambda: 10.0)
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
