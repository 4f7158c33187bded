"""The files that a world was made of, and whether they still hold what they held then.

What counts is their content: a file may be rewritten with as many bytes within one tick of the file
system's clock. Large files are not read again for each frame where their status alone is proof.
"""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rtbow.base.cache import file_digest

_ALWAYS_READ_BYTES = 65536
"""Files up to this size are read each time, which takes less than a tenth of a millisecond."""
_SETTLED_S = 2.0
"""A file that had not changed for so long shows any later change in its status: the coarsest clock
of a file system in use, FAT's, ticks every two seconds."""

_Status = tuple[int, ...]


@dataclass(frozen=True)
class InputFile:
    """A file as it was read.

    Attributes:
        path: where it is.
        status: device, inode, size and the times of its last changes; empty if it was not there,
            or is no regular file: a pipe can be read but once.
        digest: hash of its content; empty if it could not be read.
        settled: whether any change after this shows in its status.
    """

    path: str
    status: _Status
    digest: str
    settled: bool

    @classmethod
    def read(cls, path: str) -> InputFile:
        """Give a file as it is now."""
        # The status first: a change while the content is read then shows in it.
        status = _status(path)
        try:
            digest = file_digest(Path(path)) if status else ""
        except OSError:
            digest = ""
        changed_s = max(status[-2:], default=0) * 1e-9
        size = status[2] if status else 0
        settled = size > _ALWAYS_READ_BYTES and time.time() - changed_s > _SETTLED_S
        return cls(path, status, digest, settled)

    @property
    def unchanged(self) -> bool:
        """Whether the file holds the same content now."""
        if self.settled and _status(self.path) == self.status:
            return True
        return InputFile.read(self.path).digest == self.digest


def input_files(paths: Iterable[str]) -> tuple[InputFile, ...]:
    """Give files as they are now, each once."""
    return tuple(InputFile.read(path) for path in dict.fromkeys(paths))


def _status(path: str) -> _Status:
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return ()
    if not stat.S_ISREG(found.st_mode):
        return ()
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
