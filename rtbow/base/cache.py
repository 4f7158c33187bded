"""Arrays that are slow to build, kept in the user's cache folder between runs.

The folder also holds compiled code (:mod:`rtbow.base.compiled`), which is executed when it is read:
:func:`others_may_write` says whether others could have put it there.
"""

import contextlib
import functools
import hashlib
import io
import os
import re
import stat
import zipfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.files import (
    TEMPORARY_PREFIX,
    TEMPORARY_SUFFIX,
    open_regular,
    remove_leftovers,
    write_atomic,
)
from rtbow.base.resources import PACKAGE

Arrays = dict[str, np.ndarray[Any, np.dtype[Any]]]

FOLDER_VARIABLE = "RTBOW_CACHE_DIR"

_DIGEST = "sha256"
# Only what this module wrote is counted and cleared: the variable may name a shared folder.
_OWN_FILE = re.compile(
    rf".+-[0-9a-f]{{16}}\.(npz|nbc)|{re.escape(TEMPORARY_PREFIX)}[0-9a-f]+{re.escape(TEMPORARY_SUFFIX)}"
)


def cache_dir() -> Path:
    """Return the cache folder, which need not exist: ``RTBOW_CACHE_DIR`` or the user's own.

    A folder that is not absolute cannot be used.
    """
    chosen = os.environ.get(FOLDER_VARIABLE)
    if chosen:
        place = os.path.expanduser(chosen)
        with contextlib.suppress(FileNotFoundError):  # the current folder was deleted
            place = os.path.abspath(place)
        return Path(place)
    return Path(platformdirs.user_cache_dir("rtbow", appauthor=False))


@contextlib.contextmanager
def quiet_matplotlib() -> Iterator[None]:
    """Import and use Matplotlib within the block without its remarks about its own cache folder.

    It warns where there is no home to keep its list of fonts in, and while it makes that list; both
    cost time only.
    """
    import logging

    log = logging.getLogger("matplotlib")
    level = log.level
    if level == logging.NOTSET:  # whoever chose a level wants its messages
        log.setLevel(logging.ERROR)
    try:
        yield
    finally:
        log.setLevel(level)


def cached_arrays(name: str, key: str, build: Callable[[], Mapping[str, Any]]) -> Arrays:
    """Return the arrays kept under a name and key, or build and keep them.

    What is read is verified against a digest of key, names, shapes, types and contents, so that
    a damaged or foreign file is built anew and replaced. A cache folder that cannot be used
    costs time only: the arrays are then built in every run.

    Args:
        name: Kind of content, the readable part of the file's name.
        key: Everything the content depends on, the version of the building code included.
        build: Makes the arrays, of any shapes and types but objects.

    Returns:
        The arrays by name; equal whether built or read, and free to be changed by the caller.

    Raises:
        RtbowError: ``build`` gave an array of Python objects, or raised this error itself.
    """
    kept = kept_arrays(name, key)
    if kept is not None:
        return kept
    arrays = {item: np.asarray(value) for item, value in build().items()}
    keep_arrays(name, key, arrays)
    return arrays


def kept_arrays(name: str, key: str) -> Arrays | None:
    """Return the arrays kept under a name and key, or None (see :func:`cached_arrays`)."""
    path = _path(name, key)
    return _load(path, name, key) if path else None


def keep_arrays(name: str, key: str, arrays: Arrays) -> bool:
    """Keep arrays under a name and key, where the cache folder can be used.

    Returns:
        Whether they lie there now.

    Raises:
        RtbowError: an array of Python objects.
    """
    for item, array in arrays.items():
        if array.dtype.hasobject:
            raise RtbowError(f"cache {name}: array {item} holds Python objects; must hold numbers")
    path = _path(name, key)
    if path is None:
        return False
    try:
        # Compiled code lies there, too: others may not write, whatever the umask allows.
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_atomic(path, _packed(arrays, name, key))
    except (OSError, RtbowError, MemoryError):
        return False
    return True


def forget_oldest(name: str, most: int) -> None:
    """Remove all but the newest files of a kind of content."""
    with contextlib.suppress(OSError):
        files = [file for file in _own_files() if file.name.startswith(f"{name}-")]
        files.sort(key=lambda file: file.stat().st_mtime, reverse=True)
        for file in files[most:]:
            file.unlink(missing_ok=True)


def forget_arrays(name: str, key: str) -> None:
    """Remove what is kept under a name and key, if anything is."""
    path = _path(name, key)
    if path:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def _path(name: str, key: str) -> Path | None:
    """Return the file for a name and key, or None where there is no folder for it."""
    folder = cache_dir()
    # Without a home folder the path starts with a literal "~", which nobody wants created.
    if not folder.is_absolute():
        return None
    _tidy_once(folder)
    return folder / f"{name}-{hashlib.sha256(_encoded(key)).hexdigest()[:16]}.npz"


@functools.cache
def _tidy_once(folder: Path) -> None:
    """Remove what killed processes left in the cache folder, once in a process."""
    remove_leftovers(folder)


def code_dir() -> Path:
    """Return the folder within the cache folder under which compiled code lies."""
    return cache_dir() / "numba"


def others_may_write(folder: Path) -> str:
    """Say why code from a folder of the cache must not be trusted; empty if it may be.

    The folder itself and those up to the cache folder must belong to this user, or to the
    superuser, and group and others may not write there; a cache folder with the sticky bit, such
    as ``/tmp``, will do, since nobody else can replace what lies in it. Of the folders above it
    none may be open to all without that bit. Systems without such rights are trusted.

    Args:
        folder: the cache folder, or one within it. Those that do not exist are passed over.

    Returns:
        The reason and the remedy, to follow a colon.
    """
    if not hasattr(os, "getuid"):
        return ""
    root, last = Path(os.path.realpath(cache_dir())), Path(os.path.realpath(folder))
    for place in (last, *last.parents):
        try:
            status = place.stat()
        except FileNotFoundError:
            continue
        except OSError as error:
            return f"{place} cannot be examined ({error.strerror})"
        own = place == root or root in place.parents
        reason = _distrust(status, own=own, code=place not in (root, *root.parents))
        if reason:
            return f"{place} {reason}"
    return ""


def _distrust(status: os.stat_result, *, own: bool, code: bool) -> str:
    """Say what is wrong with a folder's owner or rights.

    Args:
        status: the folder's.
        own: it is the cache folder or within it.
        code: it is within it.
    """
    mode = status.st_mode
    if own and status.st_uid not in (os.getuid(), 0):
        return f"belongs to another user (number {status.st_uid})"
    sticky = bool(mode & stat.S_ISVTX) and not code
    if mode & (stat.S_IWGRP | stat.S_IWOTH if own else stat.S_IWOTH) and not sticky:
        return f"can be written by others (mode {stat.S_IMODE(mode):04o})"
    return ""


def source_digest(*names: str) -> str:
    """Give a hash of the code of packages, for keys of what they compute.

    Args:
        names: packages or modules within rtbow, such as ``physics.drop``; of a package all modules
            count, those of its packages too.
    """
    texts: list[bytes] = []
    for name in names:
        place = PACKAGE.joinpath(*name.split("."))
        modules = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
        texts.extend(module.read_bytes() for module in modules)
    return hashlib.sha256(b"\0".join(texts)).hexdigest()[:16]


def file_digest(path: Path) -> str:
    """Give a hash of a file's content."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def cache_size() -> int:
    """Return the bytes that this program's files take in the cache folder."""
    total = 0
    for file in _own_files():
        # Another process may clear the cache at this moment.
        with contextlib.suppress(OSError):
            total += file.stat().st_size
    return total


def clear_cache() -> None:
    """Remove this program's files from the cache folder, leaving any others alone.

    Raises:
        InputError: A file cannot be removed; says which and why.
    """
    for file in _own_files():
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(
                f"{file}: cannot be removed: {error.strerror}; remove it by hand, or set "
                f"{FOLDER_VARIABLE} to a folder of your own"
            ) from error


def _own_files() -> Iterator[Path]:
    for folder in (cache_dir(), *_folders(code_dir())):
        with contextlib.suppress(OSError):
            files = sorted(folder.iterdir())
            yield from (file for file in files if _OWN_FILE.fullmatch(file.name) and file.is_file())


def _folders(parent: Path) -> list[Path]:
    try:
        return sorted(path for path in parent.iterdir() if path.is_dir() and not path.is_symlink())
    except OSError:
        return []


def _encoded(text: str) -> bytes:
    # Keys may hold file names, and those may hold bytes that are not text.
    return text.encode("utf-8", "surrogatepass")


def _digest(arrays: Arrays, name: str, key: str) -> str:
    digest = hashlib.sha256()
    for text in (name, key):
        digest.update(hashlib.sha256(_encoded(text)).digest())
    for item in sorted(arrays):
        array = arrays[item]
        digest.update(repr((item, array.dtype.descr, array.shape)).encode())
        if array.nbytes:
            digest.update(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)
    return digest.hexdigest()


def _packed(arrays: Arrays, name: str, key: str) -> bytes:
    buffer = io.BytesIO()
    # What np.savez does, but without its reserved names and with nothing that depends on the
    # time: two processes that build the same arrays write the same bytes.
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for item, array in {**arrays, _DIGEST: np.array(_digest(arrays, name, key))}.items():
            with archive.open(zipfile.ZipInfo(f"{item}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)
    return buffer.getvalue()


def _load(path: Path, name: str, key: str) -> Arrays | None:
    """Return the arrays of a file, or None where it is missing, damaged or of another key."""
    try:
        # Opened here, since np.load leaves a file open that turns out to be damaged.
        with open_regular(path) as file, np.load(file, allow_pickle=False) as archive:
            arrays = {item: np.asarray(archive[item]) for item in archive.files}
        digest = str(arrays.pop(_DIGEST))
        return arrays if digest == _digest(arrays, name, key) else None
    except Exception:
        # Damaged bytes fail in as many ways as zip and npy readers have; each means "build it".
        return None
