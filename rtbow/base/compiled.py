"""Numba with its compiled code kept in rtbow's own cache folder, or nowhere."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
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
from numba import njit, prange  # noqa: E402

__all__ = ["compiled", "prange"]


def compiled(*, parallel: bool = False, contract: bool = False) -> Callable[[Function], Function]:
    """Compile a function of numbers and arrays when it is first called.

    Args:
        parallel: run its ``prange`` loops on all cores.
        contract: let a product and a sum become one instruction, rounded once.
    """
    loose = {"contract"} if contract else False
    return cast(
        Callable[[Function], Function],
        njit(cache=_KEEP, parallel=parallel, fastmath=loose, nogil=True),
    )
