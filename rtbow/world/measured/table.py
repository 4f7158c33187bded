"""Tables of numbers in text of any dialect: their header, and their rows block by block.

Numbers in equal lines are parsed by NumPy, a block of the file at a time; whatever else, comments
between rows or broken lines, is read line by line.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError
from rtbow.world.measured.dialect import (
    Dialect,
    find_dialect,
    is_comment,
    is_mark,
    uncommented,
)
from rtbow.world.measured.points import Lines
from rtbow.world.measured.source import (
    EXPECTED,
    HEAD_BYTES,
    decoded,
    open_text,
    quoted,
    whole_text,
)
from rtbow.world.measured.units import ABSCISSA_NAME

_BLOCK_BYTES = 2**18
_TRIED_LINES = 200
_SAMPLED_LINES = 5000
"""Among which the dialect of a long file is found."""
_SPACE, _NEWLINE = ord(" "), ord("\n")
_NO_TABLE = "holds no table of numbers; "
_STRAY_ROWS = 2
"""Rows of a header that look like numbers, at most; the table has ten times as many."""


@dataclass(frozen=True)
class Block:
    """Some rows of a table.

    Attributes:
        lines: the line of each row in the file (n,), from 1; of a file that is not one of lines,
            the number of each value.
        columns: (n, width); NaN where a cell holds no number.
    """

    lines: Lines
    columns: Array


@dataclass(frozen=True)
class Table:
    """A table of numbers with what its file says of it.

    Attributes:
        format: the file's format in words.
        header: lines before the table, and comments.
        names: of its columns; empty where the file names none.
        units: of its columns; empty where they have no row of their own.
        width: number of columns.
        read: gives the rows, from the first one on each time.
        fixed: unit of the abscissa and of values, where the format itself defines them.
    """

    format: str
    header: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    width: int
    read: Callable[[], Iterator[Block]]
    fixed: tuple[str, str] | None = None


class UnevenError(Exception):
    """The rows are not numbers in equal lines throughout."""


def quick_table(path: Path) -> Table | None:
    """Take a file for numbers in equal lines below a header; None if it does not begin so.

    Reading its rows may still raise :class:`UnevenError`.
    """
    with open_text(path) as stream:
        offset = stream.tell()
        head = stream.read(HEAD_BYTES)
    if b"\r" in head.replace(b"\r\n", b"") or b'"' in head:
        return None
    raw = head.splitlines(keepends=True)
    if len(head) == HEAD_BYTES:
        raw.pop()  # cut off
    lines = [decoded(line) for line in raw]
    dialect = find_dialect(lines[-_TRIED_LINES:])
    if dialect is None:
        return None
    end = next((n for n in reversed(range(len(lines))) if _strict_width(dialect, lines[n])), 0)
    width = _strict_width(dialect, lines[end])
    start = end
    while start and _strict_width(dialect, lines[start - 1]) == width:
        start -= 1
    if not width or any(_strict_width(dialect, line) for line in lines[:start]):
        return None
    header = tuple(lines[:start])
    first_byte = offset + sum(map(len, raw[:start]))

    def read() -> Iterator[Block]:
        with open_text(path) as stream:
            stream.seek(first_byte)
            yield from _quick_blocks(stream, dialect, width, start + 1)

    names, units = _column_texts(header, dialect, width)
    return Table(dialect.description, header, names, units, width, read)


def _strict_width(dialect: Dialect, line: str) -> int:
    """Return the number of columns of a row of finite numbers, 0 of any other line."""
    cells = dialect.cells(line)
    numbers = [dialect.number(cell) for cell in cells]
    if len(cells) < 2 or not all(n is not None and np.isfinite(n) for n in numbers):
        return 0
    return len(cells)


def _quick_blocks(stream: BinaryIO, dialect: Dialect, width: int, line: int) -> Iterator[Block]:
    changed = bytes.maketrans(
        (dialect.separator or "\t").encode() + b"\r\t" + b"dDqQ", b" " * 3 + b"eeee"
    )
    if dialect.decimal == ",":
        changed = bytes(ord(".") if n == ord(",") else byte for n, byte in enumerate(changed))
    rest = b""
    while True:
        read = stream.read(_BLOCK_BYTES)
        data = rest + read
        if not read:
            data = data.rstrip(b"\r\n\t \x1a")
            data += b"\n" if data else b""
        cut = data.rfind(b"\n") + 1
        data, rest = data[:cut], data[cut:]
        if data:
            yield _block(data, changed, dialect, width, line, last=not read)
            line += data.count(b"\n")
        elif len(rest) > HEAD_BYTES:
            raise UnevenError
        if not read:
            return


def _block(
    data: bytes, changed: bytes, dialect: Dialect, width: int, line: int, *, last: bool
) -> Block:
    """Parse whole lines, the first of which is ``line``, past what stands between rows.

    These are blank lines and comments and, if the file ends with these lines, a footer.
    """
    try:
        columns = _parsed(data, data.translate(changed), dialect, width)
        return Block(np.arange(line, line + len(columns)), columns)
    except UnevenError:
        raw = data.split(b"\n")[:-1]
        kept = [n for n, text in enumerate(raw) if text.strip() and not is_comment(decoded(text))]
        while last and kept and not _begins_with_number(dialect, decoded(raw[kept[-1]])):
            kept.pop()
        if len(kept) in (0, len(raw)):
            raise
    data = b"".join(raw[n] + b"\n" for n in kept)
    return Block(line + np.array(kept), _parsed(data, data.translate(changed), dialect, width))


def _begins_with_number(dialect: Dialect, line: str) -> bool:
    cells = dialect.cells(line)
    return bool(cells) and dialect.number(cells[0]) is not None


def _parsed(data: bytes, plain: bytes, dialect: Dialect, width: int) -> Array:
    """Parse whole lines into (n, width); UnevenError unless each has just so many numbers."""
    text = np.frombuffer(plain, np.uint8)
    ends = np.flatnonzero(text == _NEWLINE)
    blank = (text == _SPACE) | (text == _NEWLINE)
    begins = np.flatnonzero(~blank & np.concatenate([[True], blank[:-1]]))
    if not _evenly(begins, ends, width):
        raise UnevenError
    if dialect.separator:
        separators = np.flatnonzero(np.frombuffer(data, np.uint8) == ord(dialect.separator))
        if not _evenly(separators, ends, width - 1):
            raise UnevenError
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            numbers = np.fromstring(plain, dtype=np.float64, sep=" ")
        except (ValueError, DeprecationWarning):
            raise UnevenError from None
    if numbers.size != width * len(ends) or not np.isfinite(numbers).all():
        raise UnevenError
    return numbers.reshape(-1, width)


def _evenly(places: Lines, ends: Lines, count: int) -> bool:
    """Whether there are ``count`` places in each of the lines that end at ``ends``."""
    return bool(np.all(np.searchsorted(places, ends) == count * np.arange(1, len(ends) + 1)))


def careful_table(path: Path) -> Table:
    """Read a table line by line, past comments and blank lines, up to a footer.

    Raises:
        InputError: the file holds no table, or a line of it is broken.
    """
    text = whole_text(path, "its lines are not all rows of numbers alike")
    lines = text.rstrip("\x1a").split("\n")
    if not any(not is_comment(line) for line in lines if line.strip()):
        raise InputError(f"{path}: holds no spectrum; {EXPECTED}")
    dialect = find_dialect(lines[:: 1 + len(lines) // _SAMPLED_LINES])
    if dialect is None:
        raise InputError(f"{path}: {_NO_TABLE}{EXPECTED}")
    rows = _rows(path, lines, dialect)
    width = len(rows[0][1])
    columns = np.array([numbers for _, numbers in rows], dtype=np.float64)
    block = Block(np.array([line for line, _ in rows]), columns)
    first = rows[0][0] - 1
    header = (*lines[:first], *(line for line in lines[first:] if is_comment(line)))
    names, units = _column_texts(tuple(lines[:first]), dialect, width)
    return Table(dialect.description, header, names, units, width, lambda: iter((block,)))


_Rows = list[tuple[int, list[float]]]


def _rows(path: Path, lines: list[str], dialect: Dialect) -> _Rows:
    """Give the rows of the table with their lines."""
    runs, breaks = _runs(lines, dialect)
    if not runs:
        raise InputError(f"{path}: {_NO_TABLE}{EXPECTED}")
    longest = max(runs, key=len)
    at = runs.index(longest)
    stray = sum(len(run) for run in runs[:at])
    if stray and (stray > _STRAY_ROWS or len(longest) < 10 * stray):
        longest, at = runs[0], 0
    width = len(longest[0][1])
    if at + 1 < len(runs):
        _refuse_line(path, lines, dialect, breaks[at], width)
    last = longest[-1][0]
    for number, line in enumerate(lines[last:], last + 1):
        if not is_comment(line) and _begins_with_number(dialect, line):
            _refuse_line(path, lines, dialect, number, width)
    return longest


def _runs(lines: list[str], dialect: Dialect) -> tuple[list[_Rows], list[int]]:
    """Give runs of rows of equal width, and the line that ends each of them."""
    runs: list[_Rows] = []
    breaks: list[int] = []
    open_ = False
    for number, line in enumerate(lines, 1):
        if not line.strip() or is_comment(line):
            continue
        row = None if is_mark(line) else _row(dialect, line)
        if open_ and row is not None:
            row = _with_gaps(dialect, line, row, len(runs[-1][0][1]))
        if open_ and (row is None or len(row) != len(runs[-1][0][1])):
            breaks.append(number)
            open_ = False
        if row is None:
            continue
        if not open_:
            runs.append([])
            open_ = True
        runs[-1].append((number, row))
    return runs, breaks


def _row(dialect: Dialect, line: str) -> list[float] | None:
    """Read a row: two cells or more, the first of them a number and one more, too."""
    cells = dialect.cells(line)
    numbers = [dialect.number(cell) for cell in cells]
    if len(cells) < 2 or numbers[0] is None or all(n is None for n in numbers[1:]):
        return None
    return [np.nan if n is None else n for n in numbers]


def _with_gaps(dialect: Dialect, line: str, row: list[float], width: int) -> list[float]:
    """Fill a row whose last cells are empty, as spreadsheets write columns of several lengths."""
    gaps = width - len(row)
    if gaps <= 0 or not dialect.separator or line.count(dialect.separator) < width - 1:
        return row
    return [*row, *[np.nan] * gaps]


def _refuse_line(path: Path, lines: list[str], dialect: Dialect, number: int, width: int) -> None:
    line = lines[number - 1].strip()
    count = "two numbers" if width == 2 else f"{width} numbers"
    full = [text for text in lines if text.strip()]
    rows = sum(_row(dialect, text) is not None for text in full)
    shown = f"; got {quoted(line)}" if 2 * rows >= len(full) else ""  # of a table, not of any text
    raise InputError(
        f"{path}:{number}: expected {count} in {dialect.description}, as in the rows before{shown}"
    )


def _column_texts(
    header: tuple[str, ...], dialect: Dialect, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Find the columns' names and, where these have a row of their own, units in a header."""
    rows: list[tuple[str, ...]] = []
    for line in reversed(header):
        text = uncommented(line)
        if not text or is_mark(line):
            continue
        cells = _header_cells(text, dialect, width)
        if cells is None or len(rows) == 2:
            break
        rows.append(cells)
    if not rows:
        return (), ()
    if len(rows) == 2 and _are_units(rows[0]):
        return rows[1], rows[0]
    return rows[0], ()


def _header_cells(text: str, dialect: Dialect, width: int) -> tuple[str, ...] | None:
    """Split a line of a header into as many cells as the table has columns; None if it has not."""
    ways = [re.split(r"\s{2,}|\t", text), re.split("[,;|]", text)]
    if dialect.separator:
        ways.insert(0, dialect.cells(text))
    if ABSCISSA_NAME.search(text.split()[0]):  # words of a sentence are no names
        ways.append(text.split())
    for cells in ways:
        if len(cells) == width and all(len(cell) < 200 for cell in cells):
            return tuple(cell.strip().strip('"') for cell in cells)
    return None


_UNIT = re.compile(
    r"[\[(]?\s*(nm|[uµμ]m|microns?|å|ang(strom)?s?|cm\^?(-1|⁻¹)|1/cm|[tgm]?hz|ev|m)\s*[\])]?", re.I
)


def _are_units(cells: tuple[str, ...]) -> bool:
    return bool(_UNIT.fullmatch(cells[0]))


def numbers_table(
    format_: str,
    nm: Array,
    columns: Array,
    names: tuple[str, ...],
    header: tuple[str, ...] = (),
    fixed: tuple[str, str] | None = None,
) -> Table:
    """Make a table of wavelengths (n,) and values (n, c) that another reader has read."""
    block = Block(np.arange(1, len(nm) + 1), np.column_stack([nm, columns]))
    whole = ("wavelength", *names)
    return Table(format_, header, whole, (), len(whole), lambda: iter((block,)), fixed)
