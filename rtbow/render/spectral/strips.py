"""Rows of a frame in strips, so that an interrupt is heard and progress shows on a slow device."""

from __future__ import annotations

import time
from collections.abc import Iterator

from rtbow.base.arrays import Progress

_TILE_SECONDS = 0.15
"""Time that a strip is to take."""
_BLOCK = 4
"""Mesa's CPU driver shades blocks of 4 x 4 pixels: a strip that cuts them pays for their whole."""


def strips(height: int, progress: Progress) -> Iterator[tuple[int, int]]:
    """Cut rows into strips that take about ``_TILE_SECONDS`` each, by the time of the last one.

    Yields the first row and the number of rows; ``progress`` sees every row once.
    """
    rows = iter(progress(range(height)))
    first, count = 0, _BLOCK
    while first < height:
        # Down to a multiple of the block, counted from GL's first row, which is the lowest.
        bottom = max(height - first - count, 0) // _BLOCK * _BLOCK
        count = height - first - bottom
        begun = time.perf_counter()
        yield first, count
        for _ in range(count):
            next(rows, None)
        spent = max(time.perf_counter() - begun, 1e-6)
        first += count
        count = max(int(count * min(max(_TILE_SECONDS / spent, 0.25), 4.0)), 1)
    next(rows, None)  # lets the wrapper finish its line
