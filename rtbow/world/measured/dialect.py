"""How a text writes rows of numbers: its separator and its decimal point or comma."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdDqQ][+-]?\d{1,4})?")
_LONGEST_NUMBER = 100
_LONGEST_MARK = 200
# Fortran drops the letter where the exponent has three digits.
_LETTERLESS = re.compile(r"([+-]?\d*\.\d+)([+-]\d{3})")
_NOT_FINITE = {"nan", "inf", "+inf", "-inf", "infinity", "+infinity", "-infinity"}
COMMENTS = ("#", "%", "//", "!", "*", ";")
_SPACES = ""
_NAMES = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", _SPACES: "spaces"}
_MARK = re.compile(r">{3,}|<{3,}|[-+=|:_\s]*--[-+=|:_\s]*$")


@dataclass(frozen=True)
class Dialect:
    """How numbers stand in a line.

    Attributes:
        separator: between cells; empty for any spaces and tabs.
        decimal: ``.`` or ``,``.
    """

    separator: str
    decimal: str

    def cells(self, line: str) -> list[str]:
        """Split a line into its cells, less any empty ones at its end."""
        if self.separator == _SPACES:
            return line.split()
        if '"' in line:
            try:
                cells = next(csv.reader([line], delimiter=self.separator, strict=False), [])
            except csv.Error:
                cells = line.split(self.separator)
        else:
            cells = line.split(self.separator)
        cells = [cell.strip() for cell in cells]
        while cells and not cells[-1]:
            cells.pop()
        if self.separator == "|" and cells and not cells[0]:  # a table with bars around it
            cells = cells[1:]
        return cells

    def number(self, cell: str) -> float | None:
        """Read a number, NaN and infinity among them; None if it is none."""
        if len(cell) > _LONGEST_NUMBER:
            return None
        if self.decimal == ",":
            if "." in cell or cell.endswith(","):
                return None
            cell = cell.replace(",", ".")
        if _NUMBER.fullmatch(cell):
            try:
                return float(cell)
            except ValueError:
                return float(re.sub("[dDqQ]", "e", cell))
        if parts := _LETTERLESS.fullmatch(cell):
            return float(f"{parts[1]}e{parts[2]}")
        return float(cell) if cell.lower() in _NOT_FINITE else None

    @property
    def description(self) -> str:
        """The dialect in words."""
        comma = ", decimal comma" if self.decimal == "," else ""
        return f"text, columns separated by {_NAMES[self.separator]}{comma}"


_DIALECTS = tuple(
    Dialect(separator, decimal)
    for separator in ("\t", ";", "|", ",", _SPACES)
    for decimal in (".", ",")
)


def is_comment(line: str) -> bool:
    """Whether a line that is not blank is a comment."""
    return line.lstrip().startswith(COMMENTS)


def is_mark(line: str) -> bool:
    """Whether a line marks where data begin or end: Ocean Optics' arrows, or a rule of dashes."""
    return len(line) <= _LONGEST_MARK and bool(_MARK.match(line))


def uncommented(line: str) -> str:
    """Return a line without the sign of a comment before it."""
    return line.strip().lstrip("#%!*/;").strip()


def find_dialect(lines: Sequence[str]) -> Dialect | None:
    """Find the dialect that reads most of the lines as rows of numbers; None if none does."""
    text = "\n".join(lines)
    best, most = None, (0, 0)
    for dialect in _DIALECTS:
        if dialect.separator and dialect.separator not in text:
            continue
        if dialect.decimal == "," and "," not in text:
            continue
        score = _score(dialect, lines)
        if score > most:
            best, most = dialect, score
    return best


def _score(dialect: Dialect, lines: Sequence[str]) -> tuple[int, int]:
    """Count the rows of the commonest width that hold nothing but numbers, and any rows."""
    strict: Counter[int] = Counter()
    loose = 0
    for line in lines:
        cells = dialect.cells(line)
        if len(cells) < 2 or dialect.number(cells[0]) is None:
            continue
        numbers = [dialect.number(cell) for cell in cells[1:] if cell]
        loose += any(number is not None for number in numbers)
        if all(number is not None for number in numbers):
            strict[len(cells)] += 1
    return max(strict.values(), default=0), loose
