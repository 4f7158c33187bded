"""Output files that are written whole or not at all, and input files that are no pipe or device."""

import contextlib
import errno
import os
import secrets
import shlex
import stat
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from rtbow.base.errors import InputError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_A_DAY_S = 86_400.0

PathLike = str | os.PathLike[str]

STANDARD_OUTPUT = "-"
"""The name that stands for standard output."""

# Temporary files carry this name beside their target, so that leftovers of a killed process
# can be told from the user's own files.
TEMPORARY_PREFIX = ".rtbow-"
TEMPORARY_SUFFIX = ".tmp"

"""Files up to this size are read to see whether they changed, within a millisecond."""

_REMEDIES = {
    errno.ENOSPC: "free some space or choose another folder",
    errno.EDQUOT: "free some of your quota or choose another folder",
    errno.EFBIG: "raise the limit on file size (ulimit -f) or choose another file system",
    errno.EACCES: "choose a place you may write to",
    errno.EPERM: "choose a place you may write to",
    errno.EROFS: "choose a folder on a file system that can be written",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ELOOP: "remove the loop of symbolic links or choose another name",
    errno.EPIPE: "keep the reader of this pipe open until the file is complete",
}


def open_regular(path: PathLike) -> BinaryIO:
    """Open an input file, and nothing that could keep a reader waiting or never ends.

    Raises:
        OSError: it cannot be opened, or is a pipe or a device.
    """
    try:
        # Without waiting: a named pipe that nobody writes to would hold the run up for ever.
        file = open(path, "rb", opener=_open_at_once)  # noqa: SIM115  # the caller closes it
    except ValueError as error:
        raise OSError(errno.EINVAL, f"not a file name ({error})") from error
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise OSError(errno.EINVAL, "is a pipe or a device; must be a file")
    return file


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def read_limited(path: PathLike, most: int) -> bytes:
    """Read an input file, unless it is larger than anything of its kind.

    Args:
        path: the file.
        most: bytes that are accepted; no more are read.

    Raises:
        OSError: it cannot be read, or is larger.
    """
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        # Read even so: the size of a file that grows, or of one in /proc, says nothing.
        data = b"" if size > most else file.read(most + 1)
        if size > most or len(data) > most:
            size = max(size, len(data))
            raise OSError(errno.EFBIG, f"has {size:,} bytes; must have up to {most:,}")
    return data


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files that killed processes left in a folder of this program's own.

    Those that a running process writes are locked and stay. Where the system has no such locks,
    files of the last day stay.
    """
    with contextlib.suppress(OSError):
        for file in folder.glob(f"{TEMPORARY_PREFIX}*{TEMPORARY_SUFFIX}"):
            with contextlib.suppress(OSError):
                if _abandoned(file):
                    file.unlink()


def _abandoned(temporary: Path) -> bool:
    if fcntl is None:
        return time.time() - temporary.stat().st_mtime > _A_DAY_S
    with open_regular(temporary) as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
    return True


def _lock(descriptor: int) -> None:
    """Mark a temporary file as one whose writer lives, until the file is closed."""
    if fcntl is not None:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def write_atomic(path: PathLike, data: bytes, mode: int = 0o666) -> None:
    """Write a file whole or not at all: what stood there before stays until the last byte is safe.

    The bytes go to a temporary file beside the target (beside what a symbolic link points to),
    which then takes its place. A new file gets the permissions that the umask leaves, an existing
    one keeps its own. A device, a pipe or the process's own output cannot be replaced and is
    written to directly.

    Args:
        path: Where the file is to be; ``-`` is standard output.
        data: The whole content.
        mode: Permissions of a new file, of which the umask takes some away.

    Raises:
        InputError: The file cannot be written there; says why and what to do.
    """
    try:
        stream = _open_stream(path)
        if stream is not None:
            _write_and_close(stream, data, sync=False)
            return
        target, previous = _regular_target(path)
        temporary = _temporary_beside(target)
        try:
            descriptor = _create(temporary, mode)
            _lock(descriptor)
            if previous is not None:
                _take_over_permissions(temporary, previous)
            _write_and_close(descriptor, data, sync=True)
            os.replace(temporary, target)
        except BaseException:
            # BaseException: an interrupt from the keyboard must not leave a half-written file.
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
    except OSError as error:
        raise _explained(path, error) from error


@contextlib.contextmanager
def replacing(path: PathLike) -> Iterator[Path]:
    """Give a temporary file, for a library that writes to a name, and put it in the path's place.

    It takes the place as :func:`write_atomic` does, when the block is left without an exception;
    else it is removed.

    Args:
        path: Where the file is to be.

    Yields:
        An empty file, on the same file system where the path is no device or pipe.

    Raises:
        InputError: The file cannot be written there; says why and what to do.
    """
    with explaining(path):
        streams = _stream_kind(path) is not None
        target, previous = (None, None) if streams else _regular_target(path)
        if target is None:
            temporary = Path(tempfile.gettempdir()) / _temporary_name()
        else:
            temporary = _temporary_beside(target)
        os.close(_create(temporary))
    try:
        yield temporary
        with explaining(path):
            if target is None:
                write_atomic(path, temporary.read_bytes())
            else:
                if previous is not None:
                    _take_over_permissions(temporary, previous)
                _sync(temporary)
                os.replace(temporary, target)
    finally:
        # Also after an interrupt from the keyboard; a file that took its place is gone from here.
        with contextlib.suppress(OSError):
            temporary.unlink()


@contextlib.contextmanager
def explaining(path: PathLike) -> Iterator[None]:
    """Turn the system's errors about writing a file into an InputError that says what to do."""
    try:
        yield
    except OSError as error:
        raise _explained(path, error) from error


def check_writable(path: PathLike, suffixes: Sequence[str]) -> None:
    """Check before long work that a file can be written; leave nothing behind.

    Args:
        path: Where the file is to be.
        suffixes: The allowed endings with their dots, in lower case, such as ``(".exr", ".png")``;
            upper and lower case are the same.

    Raises:
        InputError: The ending is unknown, or the file cannot be written there; says why and what
            to do.
    """
    check_suffix(path, suffixes)
    try:
        if _stream_kind(path) is not None:
            if not os.access(path, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            return
        target, _ = _regular_target(path)
        # Only a real file is proof: permission bits know nothing of quotas, network file systems
        # or a folder without room for one more entry.
        temporary = _temporary_beside(target)
        try:
            os.close(_create(temporary))
        finally:
            with contextlib.suppress(OSError):
                temporary.unlink()
    except OSError as error:
        raise _explained(path, error) from error


def check_distinct(paths: Sequence[PathLike]) -> None:
    """Raise InputError if two of the names that were typed after ``-o`` lead to one place."""
    seen: set[str] = set()
    for path in paths:
        place = absolute(path)
        if place in seen:
            raise InputError(f"-o {_shown(path)}: is given twice; give it once")
        seen.add(place)


def absolute(path: PathLike) -> str:
    """Give a path from the root on, as :func:`os.path.abspath` does.

    Raises:
        InputError: it starts at the current folder, and that was deleted.
    """
    try:
        return os.path.abspath(path)
    except FileNotFoundError:
        raise InputError(
            f"{_shown(path)}: starts at the current folder, which was deleted; change to another"
            " folder (cd), or give the path from the root on"
        ) from None


def check_suffix(path: PathLike, suffixes: Sequence[str], example: PathLike | None = None) -> None:
    """Raise InputError unless a name has one of the endings.

    Args:
        path: the name.
        suffixes: as for :func:`check_writable`.
        example: what to write instead; None is the name with the first ending.
    """
    suffix = Path(path).suffix
    if suffix.lower() in suffixes:
        return
    allowed = " or ".join(suffixes)
    what = f"suffix {suffix} is not known" if suffix else "the name has no suffix"
    if example is None:
        named = bool(Path(path).name)
        example = Path(path).with_suffix(suffixes[0]) if named else f"frame{suffixes[0]}"
    raise InputError(
        f"{_shown(path)}: {what}; must be {allowed}; write for example {_shown(example)}"
    )


def _status(path: PathLike) -> os.stat_result | None:
    """Return what stands at a path, links followed, or None where nothing does."""
    try:
        return os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except ValueError as error:
        raise InputError(
            f"{os.fspath(path)!r}: not a file name ({error}); choose another name"
        ) from error


def _stream_kind(path: PathLike) -> int | str | None:
    """Return what to write to directly, own descriptor or path, or None for a regular file."""
    if os.fspath(path) == STANDARD_OUTPUT:
        return 1
    status = _status(path)
    if status is None or stat.S_ISDIR(status.st_mode):
        return None
    # `-o link_to_dev_stdout.exr >> log`: replacing the log by name would lose what it holds.
    for descriptor in (1, 2):
        with contextlib.suppress(OSError):
            if os.path.samestat(os.fstat(descriptor), status):
                return descriptor
    # A file that was deleted while open is reached through /proc, but has no name to replace.
    if not stat.S_ISREG(status.st_mode) or not os.path.exists(os.path.realpath(path)):
        return os.fspath(path)
    return None


def _open_stream(path: PathLike) -> int | None:
    """Open a device, a pipe or own output for writing; None for a regular or missing file."""
    kind = _stream_kind(path)
    if isinstance(kind, int):
        return os.dup(kind)
    return None if kind is None else os.open(kind, os.O_WRONLY | getattr(os, "O_BINARY", 0))


def _regular_target(path: PathLike) -> tuple[Path, os.stat_result | None]:
    """Return the file that symbolic links lead to, and its status where it exists."""
    status = _status(path)
    target = Path(os.path.realpath(path))
    if status is not None and stat.S_ISDIR(status.st_mode):
        raise InputError(
            f"{_shown(path)}: is a folder; must be a file; add a file name after the folder's"
        )
    if status is not None and not os.access(target, os.W_OK):
        # Replacing it would succeed in a folder of one's own, against the wish of its owner.
        raise InputError(
            f"{_shown(path)}: is write-protected; choose another name, or allow it with: "
            f"chmod u+w {_shown(shlex.quote(os.fspath(path)))}"
        )
    _check_folder(path, target.parent)
    return target, status


def _check_folder(path: PathLike, folder: Path) -> None:
    """Raise InputError, naming the first missing part, unless the folder exists."""
    # As typed where that is possible: `out/a`, not the whole way from the root.
    typed = Path(path).parent
    if Path(os.path.realpath(typed)) == folder:
        folder = typed
    for part in (*reversed(folder.parents), folder):
        status = _status(part)
        if status is None:
            raise InputError(
                f"{_shown(path)}: there is no folder {_shown(part)}; create it with: "
                f"mkdir -p {_shown(shlex.quote(os.fspath(folder)))}"
            )
        if not stat.S_ISDIR(status.st_mode):
            raise InputError(
                f"{_shown(path)}: {_shown(part)} is a file; must be a folder; choose another folder"
            )


def _temporary_beside(target: Path) -> Path:
    # Not built from the target's name, which may already be as long as the system allows.
    return target.with_name(_temporary_name())


def _temporary_name() -> str:
    return f"{TEMPORARY_PREFIX}{secrets.token_hex(8)}{TEMPORARY_SUFFIX}"


def _create(temporary: Path, mode: int = 0o666) -> int:
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    return os.open(temporary, flags, mode)


def _take_over_permissions(temporary: Path, previous: os.stat_result) -> None:
    if hasattr(os, "chown"):
        # Only the superuser may give a file away; for anyone else the owner is the same anyhow.
        with contextlib.suppress(OSError):
            os.chown(temporary, previous.st_uid, previous.st_gid)
    # After the owner: a change of owner takes special permission bits away.
    os.chmod(temporary, stat.S_IMODE(previous.st_mode))


def _write_and_close(descriptor: int, data: bytes, *, sync: bool) -> None:
    try:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(descriptor, rest) :]
        if sync:
            # Before the rename: a full disk may show only now, and after a power cut the new
            # name must not stand before an empty file.
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _explained(path: PathLike, error: OSError) -> InputError:
    what = os.strerror(error.errno) if error.errno else str(error)
    remedy = _REMEDIES.get(error.errno or 0, "choose another place")
    name = "standard output" if os.fspath(path) == STANDARD_OUTPUT else _shown(path)
    return InputError(f"{name}: cannot be written: {what}; {remedy}")


def _shown(path: PathLike) -> str:
    # A name with bytes that are not text would break the message itself.
    return os.fspath(path).encode("utf-8", "backslashreplace").decode()
