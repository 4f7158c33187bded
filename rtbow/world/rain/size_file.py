"""Drop sizes from a user's file: columns of diameter and density, or a disdrometer's classes."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.errors import CHECK_PATH, InputError
from rtbow.base.limits import MAX_DENSITY_PER_M3
from rtbow.physics.size_classes import PARSIVEL_MIDDLES_MM, PARSIVEL_WIDTHS_MM, SizeClasses

_EXPECTED = (
    "must hold lines diameter_um,number_per_m3_um (drops per m3 and per um of diameter), or the 32"
    " classes of an OTT Parsivel (log10 of N(D) in m-3 mm-1, -9.999 for none)"
)
_RAIN_MM = (1.5, 40.0)
"""Instruments count raindrops from below the first diameter on, and none above the second."""
_MOST_LINES = 4096
_MOST_BYTES = 4_000_000
_NONE = -9.99
"""Logarithms up to this mean no drops; Parsivels write -9.999."""
_MOST_LOG = 15.0
_MIDDLE_OFF_MM = 1.1e-3
"""OTT prints the middles of its classes cut to three decimals."""
_CLASSES = len(PARSIVEL_MIDDLES_MM)


@dataclass(frozen=True)
class _Line:
    """A line of the file that is no comment: its number, and its cells."""

    number: int
    cells: tuple[str, ...]


@dataclass(frozen=True)
class _Columns:
    """Which column holds what, in which units; None where there is no such column.

    Attributes:
        diameter, width, density: places of the columns.
        mm: millimetres in the unit of the diameters, and of the widths.
        per_m3_mm: m⁻³ mm⁻¹ in the unit of the densities.
        logarithm: whether the densities are given as log10.
        names: of the columns, for messages.
    """

    diameter: int | None
    width: int | None
    density: int
    mm: tuple[float, float]
    per_m3_mm: float
    logarithm: bool
    names: tuple[str, ...]


def read_size_file(path: Path) -> SizeClasses:
    """Read drop sizes: ``diameter_um,number_per_m3_um``, or a Parsivel's 32 classes.

    Commas, semicolons (then with decimal commas, too), tabs or blanks part the columns; ``#``
    begins a comment. A header names the columns and their units (um or mm, per m3 or cm3, log10 or
    not); without one there are the two columns above, or the 32 logarithms alone.

    Raises:
        InputError: the file cannot be read, or does not hold such a table; names line and column.
    """
    lines = _lines(path)
    header = lines[0] if any(_number(cell) is None for cell in lines[0].cells) else None
    rows = _upright(path, lines if header is None else lines[1:])
    if not rows:
        raise InputError(f"{path}: holds no numbers; {_EXPECTED}")
    columns = _guessed(path, rows) if header is None else _named(path, header)
    return _classes(path, rows, columns)


def _lines(path: Path) -> list[_Line]:
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"{path}: is larger than {_MOST_BYTES:,} bytes; {_EXPECTED}")
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(
            f"{path}: file of drop sizes not found; {CHECK_PATH}; {_EXPECTED}"
        ) from None
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{path}: cannot be read as text ({error}); {_EXPECTED}") from None
    parts = [(n, line.partition("#")[0].strip()) for n, line in enumerate(text.splitlines(), 1)]
    kept = [(n, line) for n, line in parts if line]
    if not kept:
        raise InputError(f"{path}: is empty; {_EXPECTED}")
    if len(kept) > _MOST_LINES:
        raise InputError(f"{path}: has {len(kept)} lines; must have up to {_MOST_LINES}")
    mark = _separator([line for _, line in kept])
    return [_Line(n, tuple(_cells(line, mark))) for n, line in kept]


def _separator(lines: Sequence[str]) -> str:
    # Commas between digits, with blanks between the numbers, are decimal ones.
    decimal = any(re.search(r"\d,\d+ +\d", line) for line in lines)
    marks = [";", "\t"] if decimal else [";", "\t", ","]
    return next((mark for mark in marks if any(mark in line for line in lines)), " ")


def _cells(line: str, mark: str) -> list[str]:
    cells = line.split() if mark == " " else line.rstrip(mark).split(mark)
    cells = [cell.strip().strip("\"'") for cell in cells]
    # Where commas do not part the columns they are decimal ones.
    return cells if mark == "," else [re.sub(r"(?<=\d),(?=\d)", ".", cell) for cell in cells]


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _upright(path: Path, rows: list[_Line]) -> list[_Line]:
    """Turn one spectrum on one line, as telegrams hold it, into a column."""
    if rows and all(len(row.cells) == _CLASSES for row in rows):
        if len(rows) > 1:
            raise InputError(
                f"{path}: holds {len(rows)} spectra of {_CLASSES} classes; give one of them, or"
                " their mean"
            )
        return [_Line(rows[0].number, (cell,)) for cell in rows[0].cells]
    return rows


def _named(path: Path, header: _Line) -> _Columns:
    """Understand a header."""
    names = header.cells
    lowered = [name.lower().replace("µ", "u").replace("μ", "u") for name in names]
    diameter = _find(lowered, r"diam|^mid|^centre|^center|^size|^d(_|$| |\()")
    width = _find(lowered, r"width|^delta|^dd")
    density = _find(lowered, r"log|number|^n(_|$| |\()|conc|per_(c?m)3")
    if len(names) == _CLASSES or density is None or (diameter is None and len(names) > 1):
        lacking = "number_per_m3_um" if density is None else "diameter_um"
        raise InputError(
            f"{path}:{header.number}: the header names {', '.join(names)}, and no {lacking};"
            f" {_EXPECTED}"
        )
    logarithm = "log" in lowered[density]
    if diameter is None:
        return _Columns(None, None, density, (1.0, 1.0), 1.0, True, names)
    mm = tuple(
        1.0 if at is None else _unit_mm(path, header, names[at], lowered[at])
        for at in (diameter, width)
    )
    per_mm = 1.0 / _unit_mm(path, header, names[density], lowered[density])
    per_m3 = 1e6 if re.search(r"cm-?\^?-?3", lowered[density]) else 1.0
    return _Columns(diameter, width, density, (mm[0], mm[1]), per_m3 * per_mm, logarithm, names)


def _find(names: Sequence[str], pattern: str) -> int | None:
    return next((n for n, name in enumerate(names) if re.search(pattern, name)), None)


def _unit_mm(path: Path, header: _Line, name: str, lowered: str) -> float:
    """Give the millimetres in a column's unit of length, by its name."""
    if re.search(r"(^|[^a-z0-9])(um|micron)", lowered):
        return 1e-3
    if re.search(r"(^|[^a-z0-9])mm", lowered):
        return 1.0
    raise InputError(
        f"{path}:{header.number}: column {name} does not say whether it is in um or mm; name it"
        " such as diameter_um, width_mm, number_per_m3_um or log10_N_per_m3_mm"
    )


def _guessed(path: Path, rows: Sequence[_Line]) -> _Columns:
    """Understand columns without a header."""
    first = rows[0]
    if len(first.cells) == 1 and len(rows) == _CLASSES:
        return _Columns(None, None, 0, (1.0, 1.0), 1.0, True, ("log10 of N(D)",))
    if len(first.cells) == 2:
        _check_micrometres(path, rows)
        documented = ("diameter_um", "number_per_m3_um")
        return _Columns(0, None, 1, (1e-3, 1e-3), 1e3, False, documented)
    raise InputError(
        f"{path}:{first.number}: {len(rows)} lines of {len(first.cells)} numbers without a header;"
        f" {_EXPECTED}; name other columns in a header, such as mid_mm,width_mm,log10_N_per_m3_mm"
    )


def _check_micrometres(path: Path, rows: Sequence[_Line]) -> None:
    """Refuse diameters without a unit that are those of raindrops in mm, not of any in µm."""
    given = [_number(row.cells[0]) for row in rows]
    diameters = [number for number in given if number is not None]
    if diameters and max(diameters) < _RAIN_MM[1] and min(diameters) < _RAIN_MM[0]:
        extent = f"{min(diameters):g} to {max(diameters):g}"
        raise InputError(
            f"{path}:{rows[0].number}: diameters of {extent} without a unit, which count as um,"
            " look like mm; begin the file with a line that names its columns, such as"
            " diameter_mm,number_per_m3_mm (or diameter_um,number_per_m3_um)"
        )


def _classes(path: Path, rows: Sequence[_Line], columns: _Columns) -> SizeClasses:
    """Read the numbers of all lines, and make classes of them."""
    if columns.diameter is None and len(rows) != _CLASSES:
        raise InputError(
            f"{path}: holds {len(rows)} numbers without diameters; a Parsivel has {_CLASSES}"
            f" classes; {_EXPECTED}"
        )
    density = floats([_density(path, row, columns) for row in rows]) * columns.per_m3_mm
    if columns.diameter is None:
        diameter = PARSIVEL_MIDDLES_MM
    else:
        diameter = _diameters(path, rows, columns.diameter, columns) * columns.mm[0]
    if columns.width is not None:
        width = _diameters(path, rows, columns.width, columns, ascending=False) * columns.mm[1]
    else:
        width = _widths(path, diameter)
    number = density * width
    if not number.any():
        raise InputError(f"{path}: holds no drops: every density is 0; give a spectrum with drops")
    if number.sum() > MAX_DENSITY_PER_M3:
        raise InputError(
            f"{path}: amounts to {number.sum():.3g} drops per m3; must be up to"
            f" {MAX_DENSITY_PER_M3:g}; check the units of its columns"
        )
    filled = number > 0.0
    return SizeClasses(500.0 * diameter[filled], 500.0 * width[filled], number[filled])


def _density(path: Path, row: _Line, columns: _Columns) -> float:
    value = _value(path, row, columns.density, columns)
    if not columns.logarithm:
        if value < 0.0:
            raise InputError(
                f"{_cell(path, row, columns.density, columns)} {value:g} is negative; must be 0 or"
                " more; a column of logarithms is named log10_N_per_m3_mm"
            )
        return value
    if value > _MOST_LOG:
        raise InputError(
            f"{_cell(path, row, columns.density, columns)} {value:g} is no logarithm of a drop"
            " density; must be up to 15; a column of the densities themselves is named"
            " number_per_m3_mm"
        )
    return 0.0 if value <= _NONE else 10.0**value


def _diameters(
    path: Path, rows: Sequence[_Line], column: int, columns: _Columns, *, ascending: bool = True
) -> Array:
    """Read a column of lengths, each above 0 and, if asked, above the one before."""
    values: list[float] = []
    for row in rows:
        value = _value(path, row, column, columns)
        if value <= 0.0:
            raise InputError(f"{_cell(path, row, column, columns)} {value:g}; must be above 0")
        if ascending and values and value <= values[-1]:
            raise InputError(
                f"{_cell(path, row, column, columns)} {value:g} does not follow {values[-1]:g};"
                " sort the lines by increasing diameter"
            )
        values.append(value)
    return floats(values)


def _value(path: Path, row: _Line, column: int, columns: _Columns) -> float:
    if len(row.cells) != len(columns.names):
        raise InputError(
            f"{path}:{row.number}: has {len(row.cells)} columns; expected"
            f" {len(columns.names)}: {', '.join(columns.names)}"
        )
    value = _number(row.cells[column])
    if value is None or not math.isfinite(value):
        raise InputError(
            f"{_cell(path, row, column, columns)} {row.cells[column]!r} is no finite number"
        )
    return value


def _cell(path: Path, row: _Line, column: int, columns: _Columns) -> str:
    return f"{path}:{row.number}: column {columns.names[column]}:"


def _widths(path: Path, diameter_mm: Array) -> Array:
    """Give widths of classes of which only the middles are known: OTT's, or half-way to the
    neighbours, so that sums over classes are those of the trapezoidal rule."""
    nearest = np.abs(PARSIVEL_MIDDLES_MM - diameter_mm[:, None]).argmin(axis=1)
    if np.all(np.abs(PARSIVEL_MIDDLES_MM[nearest] - diameter_mm) < _MIDDLE_OFF_MM):
        return floats(PARSIVEL_WIDTHS_MM[nearest])
    if len(diameter_mm) < 2:
        raise InputError(
            f"{path}: holds one diameter, of which the class may have any width; add a column"
            ' width_um, or choose distribution = "constant"'
        )
    gaps = np.diff(diameter_mm)
    every = np.concatenate([gaps[:1], gaps, gaps[-1:]])
    return floats(0.5 * (every[1:] + every[:-1]))
