"""What ``rtbow bench`` shows: a table for the terminal, JSON, and a plot of speed against error."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rtbow.base.files import write_atomic
from rtbow.bench.row import BenchRow
from rtbow.bench.run import STEP_KEY, TOLERANCE_KEY
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

Fields = Mapping[str, Any]
"""A row as JSON holds it (see :class:`rtbow.bench.run.BenchRow`)."""

COLUMNS = 100
"""Characters of a line on the terminal, at most."""
_DASH = "–"
_LEAST_DELTA_E = 1e-4
"""Errors below are drawn here: a logarithm has no place for 0."""
_MARKERS = "osD^vP*X<>ph"


# --- Words and numbers -------------------------------------------------------------------------


def short(value: float | None, digits: int = 3) -> str:
    """Write a number with few digits, a dash for None."""
    if value is None:
        return _DASH
    if value == 0.0:
        return "0"
    if abs(value) >= 10 ** (digits - 1):
        return f"{value:.0f}"
    if abs(value) < 1e-3:
        return f"{value:.0e}"
    text = f"{value:.{digits}g}"
    return f"{value:.{digits - 1}e}" if "e" in text else text


def share(value: float | None) -> str:
    """Write a share in percent."""
    return _DASH if value is None else f"{short(100.0 * value, 2)} %"


def setting_text(row: Fields) -> str:
    """Name what sets a row apart from others of its method."""
    parts = []
    for key, value in row["setting"].items():
        if key == TOLERANCE_KEY:
            parts.append(f"ΔE≤{value:g}")
        elif key == STEP_KEY:
            parts.append(f"{value:g} nm")
        else:
            parts.append(_assignment(key, value))
    return ", ".join(parts)


def method_text(row: Fields) -> str:
    """Name a row's method and setting."""
    return f"{row['method']} {setting_text(row)}".rstrip()


def scene_text(row: Fields) -> str:
    """Name a row's scene and the overrides that all rows share."""
    common = ", ".join(_assignment(key, value) for key, value in row["common"].items())
    return f"{row['scene']} with {common}" if common else str(row["scene"])


def _assignment(key: str, value: object) -> str:
    return f"{key}={json.dumps(value, ensure_ascii=False)}"


def fields_of(rows: Iterable[BenchRow]) -> list[dict[str, Any]]:
    """Give rows as JSON holds them."""
    return [row.as_json() for row in rows]


def write_json(path: Path, rows: Iterable[BenchRow]) -> None:
    """Write rows as JSON, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    text = json.dumps(fields_of(rows), indent=1, ensure_ascii=False, allow_nan=False)
    write_atomic(path, f"{text}\n".encode())


# --- The table on the terminal -----------------------------------------------------------------

_TITLES = (
    "method", "ms/frame", "25–75 %", "n", "Mpx/s", "×floor", "faster", "ΔE50", "ΔE99", "ΔEmax",
    "L2", "RSS", "tex",
)  # fmt: skip
_SCALING_TITLES = ("ms/frame", "25–75 %", "n", "×floor", "RSS", "tex")
_LEGEND = (
    "ms/frame: median of n frames, with quartiles; ×floor: times the floor, a pass with one table"
    " look-up per pixel; faster: times as quick as spectral; ΔE: ΔE2000 against the float64"
    " reference at 1 nm (median, 99 %, worst); L2: relative, of X, Y, Z; RSS, tex: MiB, the"
    " process's peak and the method's textures"
)
_SCALING_LEGEND = (
    "ms/frame: median of n frames, with quartiles; ×floor: times the floor, a pass with one table"
    " look-up per pixel; RSS, tex: MiB, the process's peak and the method's textures"
)


def table_lines(rows: Sequence[BenchRow]) -> Iterator[str]:
    """Give the lines of a report for a terminal of ``COLUMNS`` characters."""
    fields = fields_of(rows)
    yield from _machine(fields)
    groups = grouped(fields, lambda row: (scene_text(row), _axis(row)))
    tables = _aligned([_table_cells(group) for group in groups])
    for group, lines in zip(groups, tables, strict=True):
        yield ""
        yield from _wrapped(_heading(group))
        if len(lines) > 1:  # more than the titles
            yield from lines
        for row in group:
            if row["skipped"]:
                value = f"{_value(row)}, " if row["scaling"] else ""
                reason = " ".join(row["skipped"].split())
                yield from _wrapped(f"{value}{method_text(row)}: skipped: {reason}", indent="  ")
    yield ""
    errors = any(row["scaling"] is None for row in fields)
    yield from _wrapped(_LEGEND if errors else _SCALING_LEGEND)


def _table_cells(group: Sequence[Fields]) -> list[tuple[str, ...]]:
    """Give the titles and the cells of a group's rows."""
    measured = [row for row in group if not row["skipped"]]
    if not _axis(group[0]):
        return [_TITLES, *map(_cells, measured)]
    return [("method", _axis(group[0]), *_SCALING_TITLES), *map(_scaling_cells, measured)]


def grouped(rows: Iterable[Fields], key: Any) -> list[list[Fields]]:
    """Part rows by a key, in the order in which keys first come."""
    groups: dict[Any, list[Fields]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return list(groups.values())


def _axis(row: Fields) -> str:
    return str(row["scaling"]["axis"]) if row["scaling"] else ""


def _value(row: Fields) -> str:
    return axis_value(_axis(row), row["scaling"]["value"])


def _machine(rows: Sequence[Fields]) -> Iterator[str]:
    first = next((row for row in rows if row["gl_renderer"]), rows[0])
    yield from _wrapped(f"{first['gl_renderer']} by {first['backend']}")
    yield from _wrapped(f"{first['cpu_count']} × {first['cpu']}; rtbow {first['rtbow_version']}")


def _heading(group: Sequence[Fields]) -> str:
    first = next((row for row in group if not row["skipped"]), group[0])
    parts = [scene_text(first)]
    if _axis(first) != "pixels":
        parts[0] += ", {} × {}".format(*first["size_px"])
        floors = sorted(row["floor_ms"] for row in group if row["floor_ms"] is not None)
        if floors:
            ends = dict.fromkeys([short(floors[0]), short(floors[-1])])
            parts.append(f"floor {'–'.join(ends)} ms")
    if first["error_pixels"]:
        width, height = first["size_px"]
        parts.append(f"ΔE on {first['error_pixels']} of {width * height} pixels")
    return "; ".join(parts)


def _cells(row: Fields) -> tuple[str, ...]:
    speed = row["pixels_per_second"]
    return (
        method_text(row),
        *_times(row),
        _DASH if speed is None else short(speed * 1e-6),
        short(row["floor_ratio"]),
        short(row["speed_up"]),
        short(row["delta_e_p50"], 2),
        short(row["delta_e_p99"], 2),
        short(row["delta_e_max"], 2),
        share(row["relative_l2"]),
        *_sizes(row),
    )


def _scaling_cells(row: Fields) -> tuple[str, ...]:
    times, sizes = _times(row), _sizes(row)
    return method_text(row), _value(row), *times, short(row["floor_ratio"]), *sizes


def _times(row: Fields) -> tuple[str, str, str]:
    spread = f"{short(row['frame_ms_q25'])}–{short(row['frame_ms_q75'])}"
    return short(row["frame_ms"]), spread, str(row["frames"])


def _sizes(row: Fields) -> tuple[str, str]:
    return short(row["peak_rss_mib"]), short(row["texture_bytes"] / 2**20, 2)


def _aligned(tables: Sequence[Sequence[Sequence[str]]]) -> list[list[str]]:
    """Align the cells of tables, alike in all with as many columns; the first column to the left.

    There are two blanks between columns where the lines have room for them.
    """
    widths: dict[int, list[int]] = {}
    for table in tables:
        for row in table:
            known = widths.setdefault(len(row), [0] * len(row))
            widths[len(row)] = [max(w, len(cell)) for w, cell in zip(known, row, strict=True)]
    aligned = []
    for table in tables:
        width = widths[len(table[0])]
        gap = "  " if sum(width) + 2 * len(width) - 2 <= COLUMNS else " "
        aligned.append(
            [
                gap.join([row[0].ljust(width[0]), *map(str.rjust, row[1:], width[1:])]).rstrip()
                for row in table
            ]
        )
    return aligned


def _wrapped(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, COLUMNS, initial_indent=indent, subsequent_indent=indent)


# --- Plots -------------------------------------------------------------------------------------


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


def draw_speed(path: Path, rows: Sequence[Fields]) -> bool:
    """Plot time per frame against error, with each scene's Pareto front: ``.png`` or ``.svg``.

    Args:
        path: where to.
        rows: rows of one device; those without time or error are left out.

    Returns:
        Whether there was anything to plot, and a file was written.

    Raises:
        InputError: the file cannot be written.
    """
    shown = [r for r in rows if r["frame_ms"] is not None and r["delta_e_p99"] is not None]
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
        floors = [row["floor_ms"] for row in shown]
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
            f"{_sizes_text(shown)}, {shown[0]['gl_renderer']},"
            f" {shown[0]['cpu_count']} × {shown[0]['cpu']}. Lines: no other method or setting of"
            " the scene is quicker with no more error. Floor: one table look-up per pixel",
        )
        save(figure, path)
    return True


def _marker(number: int) -> str:
    return _MARKERS[number % len(_MARKERS)]


_FILLS = (None, "white", "0.8")
"""Of points whose colours repeat; None is the line's own."""


def _line(number: int) -> dict[str, Any]:
    """Give the colour of one of several lines, and dashes where colours repeat."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "ls": ("-", "--", ":")[number // len(COLOURS) % 3],
    }


def _draw_scene(axis: Any, number: int, group: Sequence[Fields], variants: Sequence[str]) -> None:
    line = {**_line(number), "mfc": _FILLS[number // len(COLOURS) % len(_FILLS)]}
    points = [(max(row["delta_e_p99"], _LEAST_DELTA_E), row["frame_ms"]) for row in group]
    front = [points[i] for i in pareto_front(points)]
    axis.plot(
        *zip(*front, strict=True), **line, lw=1.2, alpha=0.7, drawstyle="steps-post",
    )  # fmt: skip
    # A shape that is no method's.
    axis.plot([], [], "H", color=line["color"], ms=9, mfc=line["mfc"], label=scene_text(group[0]))
    for row, point in zip(group, points, strict=True):
        marker = _marker(variants.index(method_text(row)))
        axis.plot(*point, marker, color=line["color"], ms=6, mfc=line["mfc"])


def draw_scaling(path: Path, rows: Sequence[Fields]) -> bool:
    """Plot time per frame and texture memory against each scaling axis: ``.png`` or ``.svg``.

    Args:
        path: where to.
        rows: rows of one device; those without an axis or a time are left out.

    Returns:
        Whether there was anything to plot, and a file was written.

    Raises:
        InputError: the file cannot be written.
    """
    shown = [row for row in rows if row["scaling"] is not None and row["frame_ms"] is not None]
    if not shown:
        return False
    panels = grouped(shown, _axis)
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
        first = shown[0]
        others = [row for row in shown if _axis(row) != "pixels"]
        size = f", {_sizes_text(others)} but along pixels" if others else ""
        caption(
            figure,
            f"{scene_text(first)}{size}, {first['gl_renderer']},"
            f" {first['cpu_count']} × {first['cpu']}. Floor: one table look-up per pixel",
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


_POWERS = {"pixels": (0.5, "²"), "grid": (1.0, "³")}
"""Axes whose values are shown as a side and its power: the exponent to the side, and the sign."""


def axis_value(axis: str, value: float) -> str:
    """Write a value along an axis of a scaling run."""
    exponent, sign = _POWERS.get(axis, (1.0, ""))
    return f"{value**exponent:g}{sign}"


def _draw_axis(pair: Any, group: Sequence[Fields], methods: Sequence[str]) -> None:
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
        values = [one["scaling"]["value"] for one in rows]
        pair[0].plot(values, [one["frame_ms"] for one in rows], **line)
        pair[1].plot(values, [one["texture_bytes"] / 2**20 for one in rows], **line)
    floors: dict[float, list[float]] = {}
    for one in group:
        floors.setdefault(one["scaling"]["value"], []).append(one["floor_ms"])
    values = sorted(floors)
    least = [min(floors[value]) for value in values]
    pair[0].plot(values, least, ":", color=COLOURS[0], lw=1.0, label="floor")
    name = _axis(group[0])
    for axis in pair:
        axis.set_xscale("log")
        axis.set_xticks(values, [axis_value(name, value) for value in values])
        axis.xaxis.minorticks_off()
        _grid(axis)
    pair[1].tick_params(axis="x", labelrotation=45.0)
    pair[1].set_xlabel(SCALING_LABELS.get(name, name))


def _grid(axis: Any) -> None:
    axis.grid(color=GRID_GREY, lw=0.6)
    axis.set_axisbelow(True)


def _sizes_text(rows: Sequence[Fields]) -> str:
    return ", ".join(dict.fromkeys("{} × {}".format(*row["size_px"]) for row in rows))
