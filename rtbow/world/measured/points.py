"""Points of a spectrum gathered block by block: in order, finite, none below zero, not too many."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from rtbow.base.arrays import Array
from rtbow.physics.constants import VISIBLE_NM

Lines = np.ndarray[Any, np.dtype[np.int64]]
"""Numbers of lines in a file, from 1."""
MOST_POINTS = 100_000
"""Beyond, points are averaged."""
FINE_NM = 0.005
"""Step of those averages: a tenth of the finest that a scene can ask for."""
NOISE = 0.05
"""Of the greatest value: what is as little below zero is noise about a dark level."""

_KNOTS = round((VISIBLE_NM[1] - VISIBLE_NM[0]) / FINE_NM) + 1


@dataclass
class Points:
    """What has been gathered.

    Attributes:
        count: points so far.
        lowest_nm: least wavelength.
        highest_nm: greatest wavelength.
        negative: how many values are below zero.
        least: the least value.
        least_line: its line in the file.
        greatest: the greatest value.
        steps_nm: least and greatest distance of neighbours.
    """

    count: int = 0
    lowest_nm: float = np.inf
    highest_nm: float = -np.inf
    negative: int = 0
    least: float = np.inf
    least_line: int = 0
    greatest: float = -np.inf
    steps_nm: tuple[float, float] = (np.inf, 0.0)
    _kept: list[tuple[Array, Array]] = field(default_factory=list)
    _sums: Array | None = None
    _last: tuple[float, float] | None = None

    def add(self, nm: Array, values: Array, lines: Lines) -> None:
        """Add points (n,) that follow those before in rising or in falling order throughout.

        Args:
            nm: their wavelengths.
            values: per nm.
            lines: of the file.
        """
        self.lowest_nm = min(self.lowest_nm, float(nm.min()))
        self.highest_nm = max(self.highest_nm, float(nm.max()))
        if values.min() < self.least:
            self.least = float(values.min())
            self.least_line = int(lines[values.argmin()])
        self.greatest = max(self.greatest, float(values.max()))
        self.negative += int(np.count_nonzero(values < 0.0))
        self.count += len(nm)
        before = [] if self._last is None else [self._last[0]]
        steps = np.abs(np.diff(nm, prepend=before))
        if len(steps):
            low, high = self.steps_nm
            self.steps_nm = (min(low, float(steps.min())), max(high, float(steps.max())))
        self._last = (float(nm[-1]), float(values[-1]))
        self._kept.append((nm, np.maximum(values, 0.0)))
        if self.count > MOST_POINTS:
            self._average()

    @property
    def averaged(self) -> bool:
        """Whether there were so many points that they have been averaged."""
        return self._sums is not None

    def result(self) -> tuple[Array, Array]:
        """Give wavelengths (n,), rising, and values (n,)."""
        if self._sums is None:
            nm, values = self._joined()
            return nm, values
        self._average()
        knots = np.linspace(*VISIBLE_NM, _KNOTS)
        weights = np.full(_KNOTS, FINE_NM)
        weights[[0, -1]] *= 0.5
        covered = (knots >= self.lowest_nm) & (knots <= self.highest_nm)
        return knots[covered], (self._sums / weights)[covered]

    def _joined(self) -> tuple[Array, Array]:
        nm = np.concatenate([part[0] for part in self._kept])
        values = np.concatenate([part[1] for part in self._kept])
        return (nm[::-1], values[::-1]) if nm[0] > nm[-1] else (nm, values)

    def _average(self) -> None:
        """Put the points that are kept into the averages; the last stays, to go on from.

        A value at a knot is the mean of the spectrum under a triangle that is two steps wide. Such
        triangles add up to one, and times their knots to the wavelength: the integral over any
        stretch and its centre are kept, and no value leaves the range of those it was made from.
        """
        if self._sums is None:
            self._sums = np.zeros(_KNOTS)
        nm, values = self._joined()
        falling = self._kept[0][0][0] > self._kept[-1][0][-1]
        end = slice(0, 1) if falling else slice(-1, None)
        self._kept = [(nm[end].copy(), values[end].copy())]
        low, high = max(nm[0], VISIBLE_NM[0]), min(nm[-1], VISIBLE_NM[1])
        if not low < high:
            return
        first = int(np.floor((low - VISIBLE_NM[0]) / FINE_NM))
        knots = VISIBLE_NM[0] + FINE_NM * np.arange(
            first, int(np.ceil((high - VISIBLE_NM[0]) / FINE_NM)) + 1
        )
        cuts = np.unique(np.concatenate([[low, high], nm, knots]))
        cuts = cuts[(cuts >= low) & (cuts <= high)]
        middle, width = 0.5 * (cuts[:-1] + cuts[1:]), np.diff(cuts)
        cell = np.clip(((middle - VISIBLE_NM[0]) / FINE_NM).astype(np.int64), 0, _KNOTS - 2)
        start = VISIBLE_NM[0] + FINE_NM * cell
        at_ends, at_middle = np.interp(cuts, nm, values), np.interp(middle, nm, values)
        # Simpson's rule is exact for the product of two lines.
        whole = width * (at_ends[:-1] + 4.0 * at_middle + at_ends[1:]) / 6.0
        right = (
            (cuts[:-1] - start) * at_ends[:-1]
            + 4.0 * (middle - start) * at_middle
            + (cuts[1:] - start) * at_ends[1:]
        ) * (width / (6.0 * FINE_NM))
        at, span = cell - cell[0], int(cell[-1] - cell[0]) + 1
        into = self._sums[cell[0] : cell[0] + span + 1]
        into[:-1] += np.bincount(at, whole - right, span)
        into[1:] += np.bincount(at, right, span)
