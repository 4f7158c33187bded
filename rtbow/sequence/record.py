"""Records of sequences: which frames are done, and what each of them was made of.

A record lies beside its frames as ``NAME.sequence.json``. It lists a frame once its file is whole,
with a hash of the file's bytes, so that a frame which was damaged or replaced since does not count
as done. A process that is killed leaves its last frames out of the record, and lists none too many.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from rtbow.base.cache import file_digest
from rtbow.base.errors import InputError
from rtbow.base.files import write_atomic
from rtbow.base.version import __version__
from rtbow.frames.display import EV_LIMIT

RECORD_SUFFIX = ".sequence.json"
_SECONDS_BETWEEN_WRITES = 1.0
"""Writing a long record after each frame would take longer than drawing the frames."""

_Frames = dict[str, tuple[str, str]]
"""By file name: digests of what the frame was made of, and of its file's bytes."""


class Record:
    """The record of the frames that have a folder and a name in common."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._exposure, self._frames = _read(path) or ({}, {})
        self._done = set(self._frames.values())
        self._changed = False
        self._written_s = -float("inf")

    def has(self, path: str, made_of: str) -> bool:
        """Whether a file is, byte by byte, a frame that was made of this; renamed ones count."""
        return (made_of, content_digest(path)) in self._done

    def add(self, path: str, made_of: str) -> None:
        """List a frame whose file is whole; a device is passed over."""
        if content := content_digest(path):
            self._frames[os.path.basename(path)] = made_of, content
            self._done.add((made_of, content))
            self._changed = True
            if time.monotonic() - self._written_s > _SECONDS_BETWEEN_WRITES:
                self.write()

    def exposure_ev(self, made_of: str) -> float | None:
        """Give the exposure value (ISO 100) that was chosen by these frames; None if none was."""
        return self._exposure.get(made_of)

    def set_exposure(self, made_of: str, ev: float) -> None:
        """Keep the exposure value that was chosen by some frames, instead of any other."""
        self._changed |= self._exposure != {made_of: ev}
        self._exposure = {made_of: ev}

    def write(self) -> None:
        """Write what has changed, if anything; InputError if that is not possible."""
        if self._changed:
            frames = {
                name: {"made_of": made_of, "content": content}
                for name, (made_of, content) in sorted(self._frames.items())
            }
            record = {"rtbow": __version__, "exposure_ev": self._exposure, "frames": frames}
            write_atomic(self._path, json.dumps(record, indent=1).encode())
            self._changed, self._written_s = False, time.monotonic()


def _read(path: str) -> tuple[dict[str, float], _Frames] | None:
    """Give a record's exposures by what they were chosen by, and its frames; None if it is none."""
    try:
        record = json.loads(Path(path).read_bytes())
        exposure = {key: float(ev) for key, ev in record["exposure_ev"].items()}
        frames = {
            name: (str(frame["made_of"]), str(frame["content"]))
            for name, frame in record["frames"].items()
        }
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None
    return (exposure, frames) if all(abs(ev) <= EV_LIMIT for ev in exposure.values()) else None


def is_record(path: str) -> bool:
    """Whether a file is the record of a sequence."""
    return _read(path) is not None


@contextmanager
def open_records(paths: Iterable[str]) -> Iterator[dict[str, Record]]:
    """Give records by their paths, as earlier runs left them; write them when the block ends."""
    records = {path: Record(path) for path in paths}
    try:
        yield records
    except BaseException:
        for record in records.values():
            with suppress(InputError):  # what ended the run is what its user needs to hear
                record.write()
        raise
    for record in records.values():
        record.write()


def content_digest(path: str) -> str:
    """Give a hash of a file's bytes; empty if it is no regular file or cannot be read."""
    try:
        return file_digest(Path(path)) if os.path.isfile(path) else ""
    except OSError:
        return ""


def digest(*texts: str) -> str:
    """Give a hash of some texts."""
    return hashlib.sha256("\0".join(texts).encode("utf-8", "surrogatepass")).hexdigest()[:16]
