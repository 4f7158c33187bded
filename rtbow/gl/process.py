"""GL in several threads and processes: what a process opened is of no use to those forked from it.

A forked process has its parent's memory but none of its threads, and a driver waits for its own
for ever: Mesa's llvmpipe draws with a pool of threads, a GPU's driver has a connection that only
one process may use. So contexts of the parent are left alone, and so is every backend that the
parent had opened, whose library holds state of its own beside the contexts.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from types import TracebackType

_ON_CPU = ("llvmpipe", "softpipe", "swrast", "Software Rasterizer")
"""Mesa's names for drawing on the CPU."""

FORK_HELP = (
    'start workers by "spawn" or "forkserver", as in multiprocessing.get_context("spawn").Pool()'
    ' or ProcessPoolExecutor(mp_context=get_context("spawn")); or let the first frame be drawn'
    " after the fork, in the workers alone; method reference works here"
)


class Lock:
    """A re-entrant lock of threads, which a forked process never finds held by its parent's."""

    def __init__(self) -> None:
        self._renew()

    def _renew(self) -> None:
        self._process, self._lock = os.getpid(), threading.RLock()

    def __enter__(self) -> None:
        if self._process != os.getpid():
            self._renew()
        self._lock.acquire()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._lock.release()


_opened: dict[str, str] = {}
"""Backends that this process has opened, and the renderer of each."""
_inherited: dict[str, str] = {}
"""The same of the processes that it was forked from."""


def note_opened(backend: str, renderer: str) -> None:
    """Remember that this process has opened a backend."""
    _opened[backend] = renderer


def unusable(backend: str) -> str:
    """Say why a backend cannot be opened in this process; empty if nothing is known against it."""
    if backend not in _inherited:
        return ""
    return "was opened before this process was forked, and its driver does not work after a fork"


def left_a_gpu() -> bool:
    """Whether a process that this one was forked from had opened a GPU, which is of no use here."""
    return any(not renderer.startswith(_ON_CPU) for renderer in _inherited.values())


def after_fork(action: Callable[[], None]) -> None:
    """Have something done in each process forked from this one, before any other code runs."""
    if hasattr(os, "register_at_fork"):  # where there is no fork, there is nothing to do
        os.register_at_fork(after_in_child=action)


def _inherit() -> None:
    _inherited.update(_opened)
    _opened.clear()


after_fork(_inherit)
