"""Work in parts: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

from rtbow.base.errors import RtbowError, UnavailableError

Part = TypeVar("Part")
Result = TypeVar("Result")

_WORKERS_S = 20.0
"""Seconds to wait for the first worker of a cluster."""
_POOL_RETRIES = 5
"""Pools of processes that are tried, one after another, as long as processes are killed."""


def cores() -> int:
    """Count the cores that this process may use, or all where the system does not say."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _end_with(parent: int) -> None:
    """End this process once its parent is gone, which cannot end it when it is killed itself."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def in_processes(
    work: Callable[[Part], Result], todo: Sequence[Part], workers: int
) -> Iterator[tuple[Part, Result]]:
    """Do the parts of a job in processes of this machine; a killed process costs its own part only.

    Args:
        work: what is done with a part; a function of a module, which the processes import.
        todo: the parts, hashable, in the order in which they are begun.
        workers: how many processes.

    Yields:
        A part and its result, as they come.

    Raises:
        RtbowError: the processes keep dying.
    """
    left = set(todo)
    for _ in range(_POOL_RETRIES):
        try:
            with ProcessPoolExecutor(
                workers,
                mp_context=get_context("spawn"),
                initializer=_end_with,
                initargs=(os.getpid(),),
            ) as pool:
                running = {pool.submit(work, part): part for part in todo if part in left}
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


def on_cluster(
    work: Callable[[Part], tuple[str, Result]], todo: Sequence[Part], scheduler: str, code: str
) -> Iterator[tuple[Part, Result]]:
    """Do the parts of a job on a Dask cluster, which gives those of a lost worker to another.

    Args:
        work: what is done with a part; it returns the digest of its own code with the result.
        todo: the parts.
        scheduler: address of the cluster's scheduler.
        code: the digest that the workers must have, too.

    Yields:
        A part and its result, as they come.

    Raises:
        RtbowError: a part failed on the cluster.
        UnavailableError: no scheduler or worker answers, Dask is not installed, or the workers
            have other code.
    """
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
        running = {client.submit(work, part, pure=False): part for part in todo}
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
            if digest != code:
                raise UnavailableError(
                    f"--scheduler {scheduler}: its workers have another version of rtbow; install"
                    " this one there"
                )
            yield running[future], result
