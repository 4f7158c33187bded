"""Numba, with its compiled code kept in rtbow's own cache folder.

Numba's own cache ends the run where a file of it is damaged or its disk is full, and it trusts
whoever can write there, though reading compiled code executes it. This one costs time only: a file
counts if its digest is right, and any other one is compiled anew and replaced.

Loops on all cores run on Numba's threading layer: GNU's OpenMP on Linux, which several threads may
use at once, but which ends a process that was forked from one that had used it. Such a process runs
the same loops on one core, compiled for that: it is one of several workers as a rule.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import multiprocessing
import os
import pickle
import platform
import shutil
import signal
import stat
import threading
from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba import njit, prange
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from rtbow.base.cache import FOLDER_VARIABLE, code_dir, others_may_write
from rtbow.base.errors import RtbowError, notice
from rtbow.base.files import open_regular, remove_leftovers, write_atomic
from rtbow.base.resources import PACKAGE

__all__ = ["compiled", "prange"]

Function = TypeVar("Function", bound=Callable[..., Any])

# Numba has no types.
_rebuild: Callable[..., Any] = CompileResult._rebuild
_dumps: Callable[..., bytes] = dumps

_MOST_VERSIONS = 4
"""Versions of the source whose compiled code is kept; that of older ones is removed."""
_MOST_BYTES = 64 << 20
"""The largest function takes a hundredth of it."""

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
    one_core = njit(fastmath=loose, nogil=True)

    def plain(function: Function) -> Function:
        return cast(Function, _kept(one_core, function))

    if not parallel:
        return plain
    all_cores = njit(parallel=True, fastmath=loose, nogil=True)

    def choosing(function: Function) -> Function:
        on_all, on_one = _kept(all_cores, function), _kept(one_core, _renamed(function))

        @wraps(function)
        def call(*args: Any) -> Any:
            with _signals_afterwards():
                return on_one(*args) if _forked_from_threads else on_all(*args)

        return cast(Function, call)

    return choosing


@contextlib.contextmanager
def _signals_afterwards() -> Iterator[None]:
    """Keep the handlers of Ctrl-C and SIGTERM until the end.

    Numba hands results to Python piece by piece and does not look for exceptions between them: one
    that a handler raises there ends the process where a function gives several arrays. Python
    calls handlers after the compiled code as it is.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers run in the main thread alone
        return
    came: list[tuple[int, Any]] = []
    before: dict[int, Any] = {}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            handler = signal.getsignal(number)
            if callable(handler):
                before[number] = handler
                signal.signal(number, lambda *signalled: came.append(signalled))
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
        for one, frame in came:
            before[one](one, frame)


def _kept(compile_later: Callable[..., Any], function: Callable[..., Any]) -> Any:
    """Give a function that is compiled when it is called, from the cache where it is there."""
    dispatcher = compile_later(function)
    if hasattr(dispatcher, "_cache"):  # not under NUMBA_DISABLE_JIT
        dispatcher._cache = _KeptCode(function)
    return dispatcher


def _renamed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Copy a function under a name of its own: compiled code is kept by names."""
    assert isinstance(function, FunctionType)
    copy = FunctionType(function.__code__, function.__globals__, f"{function.__name__}_on_one_core")
    copy.__qualname__ = f"{function.__qualname__}_on_one_core"
    copy.__module__ = function.__module__
    return copy


class _KeptCode(_Cache):
    """The compiled code of one function, a file for each signature.

    The files' names hold all that the code depends on, so that there is no index which two
    processes could spoil.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = function.__name__
        self._place = (function.__module__, function.__qualname__)
        self._enabled = True

    @property
    def cache_path(self) -> str | None:
        folder = _folder()
        return str(folder) if folder else None

    def enable(self) -> None:
        self._enabled = True

    def disable(self) -> None:
        self._enabled = False

    def flush(self) -> None:
        """Forget nothing: a changed source has a folder of its own."""

    def load_overload(self, sig: object, target_context: Any) -> Any:
        """Return the code for a signature, or None where none is kept that can be trusted."""
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        if path is None:
            return None
        try:
            payload = _verified(path)
            return _rebuild(target_context, *pickle.loads(payload))
        except FileNotFoundError:
            return None
        except Exception:
            # A pickle fails in any way that its classes do; each means "compile it".
            with contextlib.suppress(OSError):
                path.unlink()
            return None

    def save_overload(self, sig: object, data: Any) -> None:
        """Keep the code for a signature, where the cache folder can be used."""
        if any(not lifted.can_cache for lifted in data.lifted) or data.library.has_dynamic_globals:
            return
        path = self._path(sig, data.codegen)
        if path is None:
            return
        payload = _dumps(data._reduce())
        with contextlib.suppress(OSError, RtbowError, MemoryError):
            # Others may not write, whatever the umask allows.
            path.parent.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            path.parent.mkdir(exist_ok=True, mode=0o700)
            _forget_old_versions(path.parent)
            if _trusted(path.parent):
                write_atomic(path, _sealed(path.name, payload), mode=0o600)

    def _path(self, sig: object, codegen: Any) -> Path | None:
        folder = _folder() if self._enabled else None
        if folder is None:
            return None
        key = (self._place, sig, codegen.magic_tuple(), numba.__version__,
               platform.python_version())  # fmt: skip
        return folder / f"{self._name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"


def _sealed(name: str, payload: bytes) -> bytes:
    """Give the content of a file: a digest of its name and of what follows."""
    return hashlib.sha256(name.encode() + b"\0" + payload).digest() + payload


def _verified(path: Path) -> bytes:
    """Read what was sealed under a name.

    Raises:
        OSError: it cannot be read.
        ValueError: damaged, foreign, or within reach of others.
    """
    with open_regular(path) as file:
        status = os.fstat(file.fileno())
        if hasattr(os, "getuid") and status.st_uid not in (os.getuid(), 0):
            raise ValueError("belongs to another user")
        if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and os.name == "posix":
            raise ValueError("can be written by others")
        data = file.read(_MOST_BYTES)
    payload = data[hashlib.sha256().digest_size :]
    if _sealed(path.name, payload) != data:
        raise ValueError("damaged")
    return payload


@functools.cache
def _folder() -> Path | None:
    """Return the folder of this version's compiled code, or None where there is none to use."""
    folder = code_dir() / _kernels_digest()
    # Without a home folder the path starts with a literal "~", which nobody wants created.
    if not folder.is_absolute() or not _trusted(folder):
        return None
    remove_leftovers(folder)
    return folder


def _trusted(folder: Path) -> bool:
    reason = others_may_write(folder)
    # A build's workers have nothing to add to what their parent said.
    if reason and multiprocessing.parent_process() is None:
        notice(
            f"compiled code is not kept: {reason}; nobody else may write there (chmod go-w), or"
            f" set {FOLDER_VARIABLE} to a folder of your own"
        )
    return not reason


def _forget_old_versions(newest: Path) -> None:
    """Remove the compiled code of all but the last few versions of the source."""
    versions = [path for path in newest.parent.iterdir() if path.is_dir() and path != newest]
    versions.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for version in versions[_MOST_VERSIONS - 1 :]:
        shutil.rmtree(version, ignore_errors=True)


@functools.cache
def _kernels_digest() -> str:
    """Hash of all modules with compiled code, which holds that of the functions it calls."""
    mark = b"rtbow.base.compiled import"
    texts = [path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))]
    return hashlib.sha256(b"\0".join(t for t in texts if mark in t)).hexdigest()[:16]
