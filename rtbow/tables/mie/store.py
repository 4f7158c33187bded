"""The Lorenz-Mie tables at hand: the one that ships, those in the cache, or one built on demand."""

from __future__ import annotations

import hashlib
import lzma
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Progress, floats, no_progress
from rtbow.base.cache import cached_arrays, file_digest, source_digest
from rtbow.base.errors import RtbowError
from rtbow.base.files import write_atomic
from rtbow.base.limits import TABLE_RADII_UM
from rtbow.tables.mie.average import mean_efficiency
from rtbow.tables.mie.axes import COMPACT_FILE, DEFAULT_SPREAD, INDEX_RANGE, MieAxes
from rtbow.tables.mie.build import build_mie_table, kept_table
from rtbow.tables.mie.lookup import MieTable, node_range, standard_axes

_PER_OCTAVE = 256.0
"""Steps of the stored logarithm per factor of two: 0.14 % at most from rounding."""


def pack(table: MieTable) -> bytes:
    """Write a standard table compactly: logarithms in small steps, their second differences along
    the angle, compressed with LZMA."""
    steps = np.rint(np.log2(table.values) * _PER_OCTAVE).astype(np.int32)
    # Second differences along the angle are small numbers, and compress.
    second = np.diff(np.diff(steps, axis=-1, prepend=0), axis=-1, prepend=0).astype("<i2")
    planes = second.ravel().view(np.uint8).reshape(-1, 2).T
    header = np.array([table.first, *table.values.shape], dtype="<i4").tobytes()
    body = planes.tobytes() + table.efficiency.astype("<f4").tobytes()
    content = header + lzma.compress(body, preset=9 | lzma.PRESET_EXTREME)
    return _mark(table.axes, content) + content


def _mark(axes: MieAxes, content: bytes) -> bytes:
    """What a file begins with: a hash of the layout and of all that follows."""
    return hashlib.sha256(repr(axes).encode() + content).digest()


def unpack(data: bytes) -> MieTable:
    """Read what :func:`pack` wrote.

    Raises:
        RtbowError: the bytes are damaged, or of a table with another layout.
    """
    axes = standard_axes(DEFAULT_SPREAD)
    size = hashlib.sha256().digest_size
    mark, content = data[:size], data[size:]
    if mark != _mark(axes, content):
        raise RtbowError(
            "the Lorenz-Mie table that comes with rtbow is damaged or of another version; install"
            " rtbow anew"
        )
    first, *shape = np.frombuffer(content[:20], dtype="<i4").tolist()
    count = int(np.prod(shape))
    body = lzma.decompress(content[20:])
    planes = np.frombuffer(body[: 2 * count], dtype=np.uint8).reshape(2, -1)
    second = np.ascontiguousarray(planes.T).view("<i2").reshape(shape).astype(np.int32)
    steps = second.cumsum(axis=-1).cumsum(axis=-1)
    values = np.exp2(steps / _PER_OCTAVE).astype(np.float32)
    efficiency = np.frombuffer(body[2 * count :], dtype="<f4").reshape(shape[:2])
    return MieTable(axes, first, values, efficiency.astype(np.float64))


def write_compact(full: MieTable, path: Path = COMPACT_FILE) -> None:
    """Make the file that ships from a full table."""
    write_atomic(path, pack(full))


@lru_cache(maxsize=1)
def compact_table() -> MieTable:
    """Give the table that ships; unpacked once, then from the cache."""

    def build() -> dict[str, NDArray[np.float64] | NDArray[np.float32] | NDArray[np.int64]]:
        table = unpack(COMPACT_FILE.read_bytes())
        return {
            "values": table.values,
            "efficiency": table.efficiency,
            "first": np.array(table.first),
        }

    kept = cached_arrays(
        "mie-compact",
        f"{file_digest(COMPACT_FILE)} {source_digest('physics.drop', 'tables.mie')}",
        build,
    )
    axes = standard_axes(DEFAULT_SPREAD)
    return MieTable(axes, int(kept["first"]), kept["values"], kept["efficiency"])


_held: dict[tuple[float, tuple[float, float], tuple[float, float]], MieTable] = {}
"""The last tables that were given, by spread, radii and indices."""
_MOST_HELD = 2


_LEAST_UM = (1.0, 10.0, 100.0, 500.0, 1500.0)
_GREATEST_UM = (10.0, 50.0, 150.0, 500.0, 1000.0, 1500.0, 2500.0, 5000.0)


def range_candidates(radii_um: tuple[float, float]) -> list[tuple[float, float]]:
    """Give the ranges of radii that tables are built for and that hold some radii, the least work
    first. Few ranges serve all scenes, so that another radius seldom needs another table."""
    ranges = [
        (low, high)
        for low in _LEAST_UM
        for high in _GREATEST_UM
        if low <= radii_um[0] and radii_um[1] <= high
    ]
    # The work grows as the square of the size, and a little with the range.
    return sorted(ranges, key=lambda ends: (ends[1], -ends[0]))


def mie_table(
    spread: float,
    radii_um: tuple[float, float],
    progress: Progress = no_progress,
    index_range: tuple[float, float] = INDEX_RANGE,
) -> MieTable:
    """Give a table that holds some radii: the full one if it was built, the one that ships, or one
    built now for these radii (minutes for large drops; kept in the cache).

    Args:
        spread: standard deviation of ln(radius).
        radii_um: least and greatest radius.
        progress: wraps the loop over the parts that are built.
        index_range: of the drops.
    """
    key = (spread, radii_um, index_range)
    if key not in _held:
        while len(_held) >= _MOST_HELD:
            del _held[next(iter(_held))]
        _held[key] = _find_table(spread, radii_um, progress, index_range)
    return _held[key]


def _find_table(
    spread: float,
    radii_um: tuple[float, float],
    progress: Progress,
    index_range: tuple[float, float],
) -> MieTable:
    axes = standard_axes(spread, index_range)
    for ends in range_candidates(radii_um):
        kept = kept_table(axes, ends)
        if kept is not None:
            return kept
    low, high = TABLE_RADII_UM
    usual = spread == DEFAULT_SPREAD and index_range == INDEX_RANGE
    if usual and low <= radii_um[0] and radii_um[1] <= high:
        return compact_table()
    return build_mie_table(axes, range_candidates(radii_um)[0], progress)


@lru_cache(maxsize=4)
def efficiency_table(axes: MieAxes, radii_um: tuple[float, float]) -> MieTable:
    """Give a table that holds extinction efficiencies alone, for radii up to those of large drops'
    limit: a second of work, kept in the cache."""
    first, end = node_range(axes, radii_um)

    def build() -> dict[str, NDArray[np.float64]]:
        nodes = floats(np.arange(first, end) * axes.step)
        return {"q": np.stack([mean_efficiency(axes, nodes, float(m)) for m in axes.index_nodes])}

    key = f"{source_digest('physics.drop', 'tables.mie')} {axes} {radii_um}"
    efficiency = cached_arrays("mie-efficiency", key, build)["q"]
    return MieTable(axes, first, np.zeros((*efficiency.shape, 2, 0), np.float32), efficiency)
