"""Numba with its compiled code kept in rtbow's own cache folder, or nowhere.

Loops on all cores run on Numba's threading layer: GNU's OpenMP on Linux, which several threads may
use at once, but which ends a process that was forked from one that had used it. Such a process runs
the same loops on one core, compiled for that: it is one of several workers as a rule.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

from rtbow.base.cache import cache_dir
from rtbow.base.resources import PACKAGE

Function = TypeVar("Function", bound=Callable[..., Any])


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _kernels_digest() -> str:
    """Hash of all modules with compiled code.

    Numba looks at a function's own file alone, and would go on with what it compiled in from
    another file before that one changed.
    """
    mark = b"rtbow.base.compiled import"
    texts = [path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))]
    return hashlib.sha256(b"\0".join(t for t in texts if mark in t)).hexdigest()[:16]


# Numba reads the folder when it is imported, and fails at the first function that it cannot
# cache beside the source, as in a read-only installation without a home.
_FOLDER = cache_dir() / "numba" / _kernels_digest()
_KEEP = _writable(_FOLDER)
if _KEEP:
    os.environ.setdefault("NUMBA_CACHE_DIR", str(_FOLDER))


# After the folder is set.
import numba  # noqa: E402
from numba import njit, prange  # noqa: E402

__all__ = ["compiled", "prange"]

_UNFORKABLE_LAYERS = ("omp",)
_forked_from_threads = False


def _note_fork() -> None:
    """In a forked process, see whether its parent had threads that are missing here."""
    global _forked_from_threads
    try:
        layer = numba.threading_layer()  # type: ignore[attr-defined]
    except ValueError:  # none had been started
        return
    _forked_from_threads = _forked_from_threads or layer in _UNFORKABLE_LAYERS


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def compiled(*, parallel: bool = False, contract: bool = False) -> Callable[[Function], Function]:
    """Compile a function of numbers and arrays when it is first called.

    Args:
        parallel: run its ``prange`` loops on all cores; it is then called from Python alone.
        contract: let a product and a sum become one instruction, rounded once.
    """
    loose = {"contract"} if contract else False
    one_core = njit(cache=_KEEP, fastmath=loose, nogil=True)
    if not parallel:
        return cast(Callable[[Function], Function], one_core)
    all_cores = njit(cache=_KEEP, parallel=True, fastmath=loose, nogil=True)

    def choosing(function: Function) -> Function:
        on_all, on_one = all_cores(function), one_core(_renamed(function))

        @wraps(function)
        def call(*args: Any) -> Any:
            return on_one(*args) if _forked_from_threads else on_all(*args)

        return cast(Function, call)

    return choosing


def _renamed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Copy a function under a name of its own: Numba keeps compiled code by the name alone."""
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, f"{function.__name__}_on_one_core")
    copy.__qualname__ = f"{function.__qualname__}_on_one_core"
    copy.__module__ = function.__module__
    return copy
