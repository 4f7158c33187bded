"""Numba with its compiled code kept in rtbow's own cache folder, or nowhere."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from rtbow.cache import cache_dir

Function = TypeVar("Function", bound=Callable[..., Any])


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


# Numba reads the folder when it is imported, and fails at the first function that it cannot
# cache beside the source, as in a read-only installation without a home.
_FOLDER = cache_dir() / "numba"
_KEEP = _writable(_FOLDER)
if _KEEP:
    os.environ.setdefault("NUMBA_CACHE_DIR", str(_FOLDER))


# After the folder is set.
from numba import njit, prange  # noqa: E402

__all__ = ["compiled", "prange"]


def compiled(*, parallel: bool = False) -> Callable[[Function], Function]:
    """Compile a function of numbers and arrays when it is first called.

    Args:
        parallel: run its ``prange`` loops on all cores.
    """
    return cast(Callable[[Function], Function], njit(cache=_KEEP, parallel=parallel))
