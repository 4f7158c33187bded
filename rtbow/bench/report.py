"""What ``rtbow bench`` prints and writes: a table for the terminal, and JSON."""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path

from rtbow.base.files import write_atomic
from rtbow.bench.row import BenchRow, ScalingPoint, Times
from rtbow.bench.run import STEP_KEY, TOLERANCE_KEY

COLUMNS = 100
"""Characters of a line on the terminal, at most."""
DASH = "–"


# --- Words and numbers -------------------------------------------------------------------------


def short(value: float | None, digits: int = 3) -> str:
    """Write a number with few digits, a dash for None."""
    if value is None:
        return DASH
    if value == 0.0:
        return "0"
    if abs(value) >= 10 ** (digits - 1):
        return f"{value:.0f}"
    if abs(value) < 1e-3:
        return f"{value:.0e}"
    text = f"{value:.{digits}g}"
    return f"{value:.{digits - 1}e}" if "e" in text else text


def method_text(row: BenchRow) -> str:
    """Name a row's method, and what sets it apart from others of its method."""
    parts = []
    for key, value in row.setting.items():
        if key == TOLERANCE_KEY:
            parts.append(f"ΔE≤{value:g}")
        elif key == STEP_KEY:
            parts.append(f"{value:g} nm")
        else:
            parts.append(_assignment(key, value))
    return f"{row.method} {', '.join(parts)}".rstrip()


def scene_text(row: BenchRow) -> str:
    """Name a row's scene, and the overrides that all rows of its run share."""
    common = ", ".join(_assignment(key, value) for key, value in row.common.items())
    return f"{row.scene} with {common}" if common else row.scene


def _assignment(key: str, value: object) -> str:
    return f"{key}={json.dumps(value, ensure_ascii=False)}"


def size_text(row: BenchRow) -> str:
    """Write a frame's width and height."""
    return "{} × {}".format(*row.size_px)


def device_text(row: BenchRow) -> str:
    """Name what drew a row's frames: many CPUs go by one renderer's name."""
    return f"{row.machine.gl_renderer}, {row.machine.cpu_count} × {row.machine.cpu}"


_POWERS = {"pixels": (0.5, "²"), "grid": (1.0, "³")}
"""Axes whose values are shown as a side and its power: the exponent to the side, and the sign."""


def point_text(point: ScalingPoint) -> str:
    """Write a value along an axis of a scaling run."""
    exponent, sign = _POWERS.get(point.axis, (1.0, ""))
    return f"{point.value**exponent:g}{sign}"


def axis_of(row: BenchRow) -> str:
    """Name a row's axis in a scaling run; empty for any other row."""
    return row.scaling.axis if row.scaling else ""


def skipped_text(row: BenchRow) -> str:
    """Say what was skipped, and why."""
    point = f", {point_text(row.scaling)}" if row.scaling else ""
    return f"{method_text(row)}{point}: skipped: {' '.join((row.skipped or '').split())}"


def error_cells(row: BenchRow) -> tuple[str, str, str, str]:
    """Write median, 99th percentile and greatest of ΔE2000, and L2 in percent."""
    if row.difference is None:
        return DASH, DASH, DASH, DASH
    delta_e, percent = row.difference.delta_e, 100.0 * row.difference.l2
    colour = short(delta_e.median, 2), short(delta_e.p99, 2), short(delta_e.worst, 2)
    return *colour, f"{short(percent, 2)} %"


def quartiles(times: Times) -> str:
    """Write the quartiles of a frame's time, in ms."""
    return f"{short(times.frame.q25_ms)}–{short(times.frame.q75_ms)}"


def megapixels(row: BenchRow) -> str:
    """Write how many million pixels a method draws in a second."""
    return short(row.pixels_per_second and 1e-6 * row.pixels_per_second)


def memory_cells(row: BenchRow) -> tuple[str, str]:
    """Write the process's peak and the method's textures, in MiB."""
    if row.memory is None:
        return DASH, DASH
    return short(row.memory.peak_rss_mib), short(row.memory.texture_bytes / 2**20, 2)


def grouped(rows: Iterable[BenchRow], key: Callable[[BenchRow], Hashable]) -> list[list[BenchRow]]:
    """Part rows by a key, in the order in which keys first come."""
    groups: dict[Hashable, list[BenchRow]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return list(groups.values())


# --- JSON --------------------------------------------------------------------------------------


def write_json(path: Path, rows: Iterable[BenchRow]) -> None:
    """Write rows as JSON, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    fields = [row.as_json() for row in rows]
    text = json.dumps(fields, indent=1, ensure_ascii=False, allow_nan=False)
    write_atomic(path, f"{text}\n".encode())


# --- The table on the terminal -----------------------------------------------------------------

_TIMES_LEGEND = (
    "ms/frame: median of n frames, with quartiles; ×floor: times the floor, a pass with one table"
    " look-up per pixel"
)
_ERROR_LEGEND = (
    "faster: times as quick as spectral; ΔE: ΔE2000 against the float64 reference at 1 nm (median,"
    " 99 %, worst); L2: relative, of X, Y, Z"
)
_MEMORY_LEGEND = "RSS, tex: MiB, the process's peak and the method's textures"


def table_lines(rows: Sequence[BenchRow]) -> Iterator[str]:
    """Give the lines of a report for a terminal of ``COLUMNS`` characters.

    Args:
        rows: of one run, along scaling axes or not.
    """
    machine = next((row.machine for row in rows if row.machine.gl_renderer), rows[0].machine)
    yield from _wrapped(f"{machine.gl_renderer} by {machine.backend}")
    yield from _wrapped(f"{machine.cpu_count} × {machine.cpu}; rtbow {machine.rtbow_version}")
    groups = grouped(rows, lambda row: (scene_text(row), axis_of(row)))
    tables = [_table(group) for group in groups]
    # All at once, so that the columns of all groups are in line.
    lines = iter(_aligned([cells for table in tables for cells in table]))
    for group, table in zip(groups, tables, strict=True):
        yield ""
        yield from _wrapped(_heading(group))
        yield from islice(lines, len(table))
        for row in group:
            if row.skipped:
                yield from _wrapped(skipped_text(row), indent="  ")
    yield ""
    legends = [_TIMES_LEGEND, *([] if rows[0].scaling else [_ERROR_LEGEND]), _MEMORY_LEGEND]
    yield from _wrapped("; ".join(legends))


def _heading(group: Sequence[BenchRow]) -> str:
    first = next((row for row in group if not row.skipped), group[0])
    parts = [scene_text(first)]
    if axis_of(first) != "pixels":
        parts[0] += f", {size_text(first)}"
        floors = sorted(row.times.floor.median_ms for row in group if row.times)
        if floors:
            ends = dict.fromkeys([short(floors[0]), short(floors[-1])])
            parts.append(f"floor {'–'.join(ends)} ms")
    if first.error:
        parts.append(f"ΔE on {first.error.pixels} of {math.prod(first.size_px)} pixels")
    return "; ".join(parts)


def _table(group: Sequence[BenchRow]) -> list[list[str]]:
    """Give the titles and the cells of a group's rows; nothing where all were skipped."""
    cells = [_cells(row, row.times) for row in group if row.times]
    return [list(cells[0]), *(list(line.values()) for line in cells)] if cells else []


def _cells(row: BenchRow, times: Times) -> dict[str, str]:
    """Give a row's cells by their titles."""
    cells = {"method": method_text(row)}
    if row.scaling:
        cells[row.scaling.axis] = point_text(row.scaling)
    cells["ms/frame"] = short(times.frame.median_ms)
    cells["25–75 %"] = quartiles(times)
    cells["n"] = str(times.frame.frames)
    if not row.scaling:
        cells["Mpx/s"] = megapixels(row)
    cells["×floor"] = short(row.floor_ratio)
    if not row.scaling:
        cells["faster"] = short(row.speed_up)
        cells |= zip(("ΔE50", "ΔE99", "ΔEmax", "L2"), error_cells(row), strict=True)
    cells |= zip(("RSS", "tex"), memory_cells(row), strict=True)
    return cells


def _aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Align the columns of rows, the first to the left, all others to the right."""
    # Imported here, as it is of use once all is measured.
    from tabulate import DataRow, TableFormat, tabulate

    # Two blanks between columns, one where the lines have no room for them.
    for gap in ("  ", " "):
        cells = DataRow("", gap, "")
        form = TableFormat(None, None, None, None, cells, cells, 0, None)
        text: str = tabulate(
            rows, tablefmt=form, disable_numparse=True, colglobalalign="right", colalign=("left",)
        )
        lines = text.splitlines()
        if max(map(len, lines), default=0) <= COLUMNS:
            break
    return lines


def _wrapped(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, COLUMNS, initial_indent=indent, subsequent_indent=indent)
