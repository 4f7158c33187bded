"""A line of the table."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """A number of the document.

    Attributes:
        what: what was measured.
        found: the number.
        bound: below which its size is to be; None where nothing is asserted of it.
        unit: one of ``UNITS``.
    """

    what: str
    found: float
    bound: float | None = None
    unit: str = "%"

    @property
    def holds(self) -> bool:
        """Whether the bound is met."""
        return self.bound is None or abs(self.found) < self.bound

    def cells(self) -> tuple[str, str, str]:
        """Write the line's cells."""
        bound = "" if self.bound is None else self._text(self.bound)
        return self.what, self._text(self.found) + ("" if self.holds else ", not met"), bound

    def _text(self, value: float) -> str:
        factor, digits = UNITS[self.unit]
        return f"{factor * value:.{digits}f} {self.unit}".rstrip()


UNITS = {"%": (100.0, 2), "": (1.0, 4), "ΔE2000": (1.0, 2), "ms": (1.0, 1), "s": (1.0, 2),
         "°": (1.0, 1)}  # fmt: skip
"""Factors and decimals of numbers."""

Rows = Iterator[Row]


def rows_of(checks: Iterable[Any], unit: str = "%") -> Rows:
    """Give the lines of what tests check (``skies.check.Check``)."""
    for check in checks:
        yield Row(check.what, check.found, check.bound, unit)
