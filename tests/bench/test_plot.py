"""Plots of rows."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from bench_rows import made_up, some_rows, some_scaling_rows
from rtbow.bench.plot import draw_scaling, draw_speed, pareto_front
from rtbow.bench.row import ScalingPoint, Timing


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


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_plots_are_written(tmp_path, suffix):
    speed, scaling = tmp_path / f"speed{suffix}", tmp_path / f"scaling{suffix}"
    assert draw_speed(speed, some_rows())
    assert draw_scaling(scaling, some_scaling_rows())
    if suffix == ".svg":
        shown = re.findall(r"<text[^>]*>([^<]*)</text>", speed.read_text("utf-8"))
        assert {"uniform", "figures/fig5f", "fast ΔE≤0.5", "spectral 5 nm", "floor"} <= set(shown)
        shown = re.findall(r"<text[^>]*>([^<]*)</text>", scaling.read_text("utf-8"))
        assert {"4096²", "512³", "lights", "textures, MiB"} <= set(shown)
    assert speed.stat().st_size > 2000
    nothing = tmp_path / f"nothing{suffix}"
    assert not draw_speed(nothing, [])
    assert not draw_scaling(nothing, some_rows())
    assert not nothing.exists()


@pytest.mark.parametrize("ratio", [1.0, 1.02, 3.0, 15.0, 150.0, 250.0, 1e5])
def test_logarithmic_axes_show_a_decade_with_numbers(monkeypatch, ratio):
    """Also where errors, times or sizes are alike: what tells them apart is then noise."""
    figures = []
    monkeypatch.setattr("rtbow.bench.plot.save", lambda figure, path: figures.append(figure))
    # Not from 1, 2 or 5 on, where ticks are.
    speed, steps = [], []
    for factor, value in ((1.0, 8), (ratio, 512)):
        row = made_up(ms=3.3 * factor, error=0.33 * factor)
        row = replace(row, times=replace(row.times, floor=Timing(3.3, 3.3, 3.3, 9)))
        speed.append(row)
        memory = replace(row.memory, texture_bytes=3_300_000 * factor)
        steps.append(replace(row, memory=memory, scaling=ScalingPoint("steps", value)))
    assert draw_speed(Path("speed.png"), speed)
    assert draw_scaling(Path("scaling.png"), steps)
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
