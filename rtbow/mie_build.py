"""Building the Lorenz-Mie table in parts: in parallel, resumable, on this machine or a cluster."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import astuple, dataclass
from functools import lru_cache
from multiprocessing import get_context

import numpy as np

from rtbow.arrays import Array, Progress, floats, no_progress
from rtbow.cache import forget_arrays, keep_arrays, kept_arrays, source_digest
from rtbow.errors import RtbowError, UnavailableError
from rtbow.mie_average import coherent, mean_efficiency, node_intensities
from rtbow.mie_axes import MieAxes
from rtbow.mie_table import MieTable, node_range

_BLOCK_LOG = 0.48
"""Extent of a part in ln x: its sizes share angles and samples, which follow its first one. A mean
reaches 3.5 spreads beyond its outermost nodes, which parts compute twice: 29 % of the work with the
standard spread, for parts of less than a minute each up to 1500 µm."""
_WORKERS_S = 20.0
"""How long a cluster without workers is waited for."""
_POOL_RETRIES = 5
"""How often a pool of processes is made anew after one of them was killed."""


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
    return source_digest("airy", "mie", "mie_axes", "mie_average")


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


def _end_with(parent: int) -> None:
    """End this process when its parent is gone: a killed one cannot say so, and would leave it."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _local(todo: list[Part], workers: int) -> Results:
    """Compute parts in processes of this machine; a killed process costs its own part only."""
    left = set(todo)
    for _ in range(_POOL_RETRIES):
        try:
            with ProcessPoolExecutor(
                workers,
                mp_context=get_context("spawn"),
                initializer=_end_with,
                initargs=(os.getpid(),),
            ) as pool:
                running = {pool.submit(compute_part, part): part for part in todo if part in left}
                try:
                    for done in as_completed(running):
                        result = done.result()
                        left.discard(running[done])
                        yield running[done], result
                except BaseException:
                    pool.shutdown(wait=False, cancel_futures=True)
                    # A part takes a minute: leaving the pool would wait for those in work.
                    for process in list((pool._processes or {}).values()):
                        process.kill()
                    raise
            return
        except BrokenProcessPool:
            continue
    raise RtbowError(
        f"building the table: its processes ended {_POOL_RETRIES} times, as when memory runs out;"
        " what is finished is kept: run it again, with fewer --workers (a script of your own must"
        " have its code under `if __name__ == '__main__':`, since processes import it)"
    )


def _cluster(todo: list[Part], scheduler: str) -> Results:
    """Compute parts on a Dask cluster, which gives those of a lost worker to another."""
    try:
        from distributed import Client
        from distributed import as_completed as futures_completed
    except ImportError:
        raise UnavailableError(
            "a Dask cluster needs the package distributed; install it, as with"
            " pip install '.[cluster]' in a checkout"
        ) from None
    try:
        client = Client(scheduler, timeout="5s")  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        raise UnavailableError(
            f"--scheduler {scheduler}: no Dask scheduler answers there ({error}); start one with"
            " `dask scheduler` and workers with `dask worker`"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=_WORKERS_S)
        except TimeoutError:
            raise UnavailableError(
                f"--scheduler {scheduler}: it has no workers; start some with `dask worker`"
            ) from None
        # A lost worker's parts go to another one; the scheduler counts how often.
        running = {client.submit(_checked_part, part, pure=False): part for part in todo}
        results = iter(
            futures_completed(  # type: ignore[no-untyped-call]
                list(running), with_results=True
            )
        )
        while True:
            try:
                future, (digest, result) = next(results)
            except StopIteration:
                return
            except Exception as error:
                raise RtbowError(
                    f"--scheduler {scheduler}: a part failed there ({type(error).__name__}:"
                    f" {error}); what is finished is kept: run it again"
                ) from error
            if digest != _digest():
                raise UnavailableError(
                    f"--scheduler {scheduler}: its workers have another version of rtbow; install"
                    " this one there"
                )
            yield running[future], result


def _checked_part(part: Part) -> tuple[str, dict[str, Array]]:
    """Compute a part, and say by which code."""
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
    workers = workers or _cores()
    results = _cluster(todo, scheduler) if scheduler else _local(todo, min(workers, len(todo) or 1))
    if todo:
        for part, arrays in _with_progress(results, len(found), len(every), progress):
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


def _cores() -> int:
    """Cores that this process may use, where the system tells."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _with_progress(results: Results, done: int, count: int, progress: Progress) -> Results:
    # The hook wraps a loop over numbers; results come as they are ready. What was done before
    # shows as done.
    steps = iter(progress(range(count)))
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
