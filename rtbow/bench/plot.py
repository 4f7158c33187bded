"""What ``rtbow bench --plot`` draws: speed against error, and times along the scaling axes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rtbow.bench.report import (
    axis_of,
    device_text,
    grouped,
    method_text,
    point_text,
    scene_text,
    size_text,
)
from rtbow.bench.row import BenchRow, ScalingPoint
from rtbow.frames.plot import (
    COLOURS,
    GREY,
    GRID_GREY,
    caption,
    legend,
    log_scale,
    new_figure,
    save,
    style,
)

_LEAST_DELTA_E = 1e-4
"""Where errors below it are drawn: a logarithm has no place for 0."""
_MARKERS = "osD^vP*X<>ph"


def pareto_front(points: Sequence[tuple[float, float]]) -> list[int]:
    """Give the points that no other equals or beats in both numbers, of which less is better.

    Args:
        points: pairs of numbers.

    Returns:
        Their indices, by increasing first number; of equal points the first.
    """
    front: list[int] = []
    for index in sorted(range(len(points)), key=lambda i: (*points[i], i)):
        if not front or points[index][1] < points[front[-1]][1]:
            front.append(index)
    return front


def draw_speed(path: Path, rows: Sequence[BenchRow]) -> bool:
    """Plot time per frame against error, with each scene's Pareto front: ``.png`` or ``.svg``.

    Args:
        path: where to.
        rows: rows of one device; those without time or error are left out.

    Returns:
        Whether there was anything to plot, and a file was written.

    Raises:
        InputError: the file cannot be written.
    """
    shown = [row for row in rows if row.times and row.difference]
    if not shown:
        return False
    variants = list(dict.fromkeys(method_text(row) for row in shown))
    with style():
        figure = new_figure(9.0, 6.2)
        axis = figure.subplots()
        for number, group in enumerate(grouped(shown, scene_text)):
            _draw_scene(axis, number, group, variants)
        for number, variant in enumerate(variants):
            axis.plot([], [], _marker(number), color=GREY, label=variant)
        floors = [row.times.floor.median_ms for row in shown if row.times]
        axis.axhspan(min(floors), max(floors), color=GRID_GREY, lw=2.0, label="floor", zorder=0.5)
        axis.margins(0.08)
        log_scale(axis, "x")
        log_scale(axis, "y")
        axis.set_xlabel("ΔE2000 against the reference, 99th percentile")
        axis.set_ylabel("time per frame, ms (median)")
        _grid(axis)
        # Beside the points, which may be anywhere.
        axis.legend(
            fontsize=8.5, frameon=False, loc="upper left", bbox_to_anchor=(1.01, 1.0),
            borderaxespad=0.0,
        )  # fmt: skip
        caption(
            figure,
            f"{_sizes_text(shown)}, {device_text(shown[0])}. Lines: no other method or setting of"
            " the scene is quicker with no more error. Floor: one table look-up per pixel",
        )
        save(figure, path)
    return True


def _marker(number: int) -> str:
    return _MARKERS[number % len(_MARKERS)]


def _draw_scene(axis: Any, number: int, group: Sequence[BenchRow], variants: Sequence[str]) -> None:
    # Where colours repeat, dashes and fills tell scenes apart; None fills with the line's colour.
    turn, colour = divmod(number, len(COLOURS))
    line = {"color": COLOURS[colour], "mfc": (None, "white", "0.8")[turn % 3]}
    points = [
        (max(row.difference.delta_e.p99, _LEAST_DELTA_E), row.times.frame.median_ms)
        for row in group
        if row.difference and row.times
    ]
    front = [points[i] for i in pareto_front(points)]
    dashes = ("-", "--", ":")[turn % 3]
    axis.plot(*zip(*front, strict=True), dashes, **line, lw=1.2, alpha=0.7, drawstyle="steps-post")
    # A shape that is no method's.
    axis.plot([], [], "H", **line, ms=9, label=scene_text(group[0]))
    for row, point in zip(group, points, strict=True):
        axis.plot(*point, _marker(variants.index(method_text(row))), **line, ms=6)


def draw_scaling(path: Path, rows: Sequence[BenchRow]) -> bool:
    """Plot time per frame and texture memory against each scaling axis: ``.png`` or ``.svg``.

    Args:
        path: where to.
        rows: rows of one device; those without an axis or a time are left out.

    Returns:
        Whether there was anything to plot, and a file was written.

    Raises:
        InputError: the file cannot be written.
    """
    shown = [row for row in rows if row.scaling and row.times]
    if not shown:
        return False
    panels = grouped(shown, axis_of)
    methods = list(dict.fromkeys(method_text(row) for row in shown))
    with style():
        figure = new_figure(1.5 + 3.1 * len(panels), 5.8)
        grid = figure.subplots(2, len(panels), squeeze=False, sharex="col", sharey="row")
        for column, group in enumerate(panels):
            _draw_axis(grid[:, column], group, methods)
        for row in grid[:, 0]:  # which the others share
            log_scale(row, "y")
        grid[0, 0].set_ylabel("time per frame, ms (median)")
        grid[1, 0].set_ylabel("textures, MiB")
        legend(grid[0, 0], 1)
        others = [row for row in shown if axis_of(row) != "pixels"]
        size = f", {_sizes_text(others)} but along pixels" if others else ""
        caption(
            figure,
            f"{scene_text(shown[0])}{size}, {device_text(shown[0])}."
            " Floor: one table look-up per pixel",
        )
        save(figure, path)
    return True


SCALING_LABELS = {
    "pixels": "pixels",
    "steps": "steps along a ray (render.steps)",
    "grid": "grid points",
    "lights": "lights",
}
"""What the values along each axis of a scaling run are."""


def _points(rows: Sequence[BenchRow]) -> list[tuple[int, float, float]]:
    """Give value, time of a frame in ms and textures in MiB of scaling rows."""
    return [
        (row.scaling.value, row.times.frame.median_ms, row.memory.texture_bytes / 2**20)
        for row in rows
        if row.scaling and row.times and row.memory
    ]


def _draw_axis(pair: Any, group: Sequence[BenchRow], methods: Sequence[str]) -> None:
    for rows in grouped(group, method_text):
        number = methods.index(method_text(rows[0]))
        line = {
            "color": COLOURS[(number + 1) % len(COLOURS)],
            "marker": _marker(number),
            # The second on top of the first where both are alike.
            "ms": 7 if number == 0 else 4,
            "ls": "-" if number == 0 else "--",
            "label": method_text(rows[0]),
        }
        places, times, sizes = zip(*_points(rows), strict=True)
        pair[0].plot(places, times, **line)
        pair[1].plot(places, sizes, **line)
    floors: dict[ScalingPoint, float] = {}
    for row in group:
        if row.scaling and row.times:
            floor = row.times.floor.median_ms
            floors[row.scaling] = min(floor, floors.get(row.scaling, floor))
    points = sorted(floors, key=lambda point: point.value)
    values = [point.value for point in points]
    least = [floors[point] for point in points]
    pair[0].plot(values, least, ":", color=COLOURS[0], lw=1.0, label="floor")
    for axis in pair:
        axis.set_xscale("log")
        axis.set_xticks(values, [point_text(point) for point in points])
        axis.xaxis.minorticks_off()
        _grid(axis)
    pair[1].tick_params(axis="x", labelrotation=45.0)
    pair[1].set_xlabel(SCALING_LABELS[points[0].axis])


def _grid(axis: Any) -> None:
    axis.grid(color=GRID_GREY, lw=0.6)
    axis.set_axisbelow(True)


def _sizes_text(rows: Sequence[BenchRow]) -> str:
    return ", ".join(dict.fromkeys(size_text(row) for row in rows))
