"""Rows of the bench that nothing measured."""

from __future__ import annotations

from dataclasses import replace

from rtbow.bench.row import BenchRow, Machine, Memory, SampleDifference, ScalingPoint, Times, Timing
from rtbow.bench.scaling import AXES
from rtbow.frames.difference import FrameDifference, Spread

LLVMPIPE = "llvmpipe (LLVM 15.0.6, 256 bits)"


def made_up(scene="uniform", method="fast", setting=None, ms=2.0, error=0.2, **more) -> BenchRow:
    """A row of one frame time and one error (99th percentile of ΔE2000)."""
    frame, floor = Timing(ms, 0.9 * ms, 1.1 * ms, 9), Timing(1.0, 0.9, 1.1, 10)
    difference = FrameDifference(Spread(error / 5, error, 2 * error), Spread(0.0, 0.0, 0.0), 1e-3)
    records = {
        "common": {},
        "size_px": (640, 360),
        "machine": Machine(LLVMPIPE, "egl", "Some CPU", 2, 0.5),
        "command": "rtbow bench --json a.json",
        "times": Times(frame, floor, 9.0 * ms),
        "memory": Memory(200.0, "row", 150.0, 1_500_000),
        "error": SampleDifference(difference, 400, 390, "400 of 230400 pixels", 1.0),
        "spectral_ms": 1000.0,
        "spectral_step_nm": 5.0,
    }
    return BenchRow(scene, method, setting or {}, **{**records, **more})


def skipped(row: BenchRow, reason: str) -> BenchRow:
    """The row, had the method refused its scene."""
    return replace(row, times=None, memory=None, error=None, skipped=reason)


def some_rows() -> list[BenchRow]:
    step = {"render.wavelength_step_nm": 5.0}
    rain = {"droplets.extinction": True}
    unlike = {"spectral_ms": None, "spectral_step_nm": None}
    return [
        made_up("uniform", "spectral", step, 1000.0, 0.09),
        made_up("uniform", "fast", {"render.max_delta_e": 0.1}, 2.5, 0.08),
        made_up("uniform", "fast", {"render.max_delta_e": 0.5}, 1.25, 0.4),
        made_up("shower", "spectral", step, 29_312.7, 0.09, common=rain),
        made_up("shower", "fast", {}, 4.5, 0.6, common=rain),
        skipped(made_up("downpour", "fast"), "no\n filter; leave it out"),
        made_up("figures/fig5f", "fast", {}, 20.0, 0.5, **unlike),
    ]


def some_scaling_rows() -> list[BenchRow]:
    rows = [
        replace(made_up("shower", ms=0.1 * value, scaling=ScalingPoint(axis, value)), error=None)
        for axis, values in AXES.items()
        for value in values
    ]
    return [*rows[:-1], skipped(rows[-1], "about 70 s; may take 60 s")]
