"""Building the Lorenz-Mie table in parts: in parallel, resumable, on this machine or a cluster."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import astuple, dataclass
from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array, Progress, Steps, floats, no_progress
from rtbow.base.cache import forget_arrays, keep_arrays, kept_arrays, source_digest
from rtbow.base.jobs import cores, in_processes, on_cluster
from rtbow.tables.mie.average import coherent, mean_efficiency, node_intensities
from rtbow.tables.mie.axes import MieAxes
from rtbow.tables.mie.lookup import MieTable, node_range

_BLOCK_LOG = 0.48
"""Extent of a part in ln x: its sizes share angles and samples, which follow its first one. A mean
reaches 3.5 spreads beyond its outermost nodes, which parts compute twice: 29 % of the work with the
standard spread, for parts of less than a minute each up to 1500 µm."""


@dataclass(frozen=True)
class Part:
    """A part of the table: one index, some sizes.

    Attributes:
        axes: the table's layout.
        index: which index.
        nodes: first node and end along ln x.
    """

    axes: MieAxes
    index: int
    nodes: tuple[int, int]

    @property
    def key(self) -> str:
        """What its content depends on."""
        return f"{_digest()} {astuple(self)}"

    @property
    def cost(self) -> float:
        """How long it takes, in no particular unit."""
        low, high = (float(np.exp(n * self.axes.step)) for n in self.nodes)
        weight = 30.0 * high if coherent(self.axes, low) else 1.0 * high**2
        return weight * (high - low) / high


@lru_cache(maxsize=1)
def _digest() -> str:
    """Hash of the code as this process has it; read once, whatever happens to the files."""
    return source_digest("physics.drop", "tables.mie")


def compute_part(part: Part) -> dict[str, Array]:
    """Compute a part's intensities (sizes, 2, angles) and Q_ext (sizes,)."""
    nodes = floats(np.arange(*part.nodes) * part.axes.step)
    m = float(part.axes.index_nodes[part.index])
    return {
        "values": node_intensities(part.axes, nodes, m),
        "efficiency": mean_efficiency(part.axes, nodes, m),
    }


def parts(axes: MieAxes, nodes: tuple[int, int]) -> list[Part]:
    """Cut a table into parts, the longest work first. Blocks lie on a grid of their own, so that
    tables of other radii share them."""
    found: list[Part] = []
    start = nodes[0]
    block = max(round(_BLOCK_LOG / axes.step), 1)
    while start < nodes[1]:
        end = min((start // block + 1) * block, nodes[1])
        found.extend(Part(axes, index, (start, end)) for index in range(axes.indices))
        start = end
    return sorted(found, key=lambda part: -part.cost)


Results = Iterator[tuple[Part, dict[str, Array]]]


def _checked_part(part: Part) -> tuple[str, dict[str, Array]]:
    """Compute a part, and give the digest of the code with it."""
    return _digest(), compute_part(part)


def build_mie_table(
    axes: MieAxes,
    radii_um: tuple[float, float],
    progress: Progress = no_progress,
    workers: int | None = None,
    scheduler: str | None = None,
) -> MieTable:
    """Build a table, or read it from the cache where it lies already.

    Finished parts are kept in the cache as they come, so that a build that was stopped goes on
    where it was; when all are there they are joined and removed.

    Args:
        axes: the layout.
        radii_um: least and greatest radius it must hold.
        progress: wraps the loop over parts.
        workers: processes; left out: one per core.
        scheduler: address of a Dask scheduler to use instead.

    Raises:
        RtbowError: the processes keep dying.
        UnavailableError: no scheduler at the address, or Dask is not installed.
    """
    kept = kept_table(axes, radii_um)
    if kept is not None:
        return kept
    nodes = node_range(axes, radii_um)
    every = parts(axes, nodes)
    found: dict[Part, dict[str, Array]] = {}
    for part in every:
        arrays = kept_arrays("mie-part", part.key)
        if arrays is not None:
            found[part] = arrays
    todo = [part for part in every if part not in found]
    workers = workers or cores()
    results: Results = (
        on_cluster(_checked_part, todo, scheduler, _digest())
        if scheduler
        else in_processes(compute_part, todo, min(workers, len(todo) or 1))
    )
    if todo:
        low, high = radii_um
        steps = Steps(len(every), f"exact theory of drops of {low:g} to {high:g} um")
        for part, arrays in _with_progress(results, len(found), progress(steps)):
            arrays["values"] = arrays["values"].astype(np.float32)
            keep_arrays("mie-part", part.key, arrays)
            found[part] = arrays
    table = _join(axes, nodes, found)
    arrays = {"values": table.values, "efficiency": table.efficiency}
    if keep_arrays("mie", _table_key(axes, nodes), arrays):
        for part in every:
            forget_arrays("mie-part", part.key)
    return table


def kept_table(axes: MieAxes, radii_um: tuple[float, float]) -> MieTable | None:
    """Give a table from the cache, if it was built."""
    nodes = node_range(axes, radii_um)
    kept = kept_arrays("mie", _table_key(axes, nodes))
    if kept is None:
        return None
    return MieTable(axes, nodes[0], kept["values"], kept["efficiency"])


def _table_key(axes: MieAxes, nodes: tuple[int, int]) -> str:
    return f"{_digest()} {astuple(axes)} {nodes}"


def _with_progress(results: Results, done: int, wrapped: Iterable[int]) -> Results:
    # The hook wraps a loop over numbers; results come as they are ready. What was done before
    # shows as done.
    steps = iter(wrapped)
    for _ in range(done):
        next(steps, None)
    for result in results:
        next(steps, None)
        yield result
    next(steps, None)


def _join(axes: MieAxes, nodes: tuple[int, int], found: dict[Part, dict[str, Array]]) -> MieTable:
    sizes = nodes[1] - nodes[0]
    values = np.zeros((axes.indices, sizes, 2, len(axes.angle_nodes)), dtype=np.float32)
    efficiency = np.zeros((axes.indices, sizes))
    for part, arrays in found.items():
        rows = slice(part.nodes[0] - nodes[0], part.nodes[1] - nodes[0])
        values[part.index, rows] = arrays["values"]
        efficiency[part.index, rows] = arrays["efficiency"]
    return MieTable(axes, nodes[0], values, efficiency)
