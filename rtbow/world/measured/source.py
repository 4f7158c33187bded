"""A user's file as bytes of text: what is no text is refused, and little is ever quoted."""

from __future__ import annotations

import codecs
import hashlib
import io
import os
import stat
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from rtbow.base.errors import CHECK_PATH, InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

MOST_BYTES = 256 * 2**20
"""Size of a file that is read: five million lines of two columns take half of it."""
MOST_TEXT_BYTES = 32 * 2**20
"""Size of a file that is held as a whole: one that is not numbers in equal lines throughout."""
HEAD_BYTES = 32 * 2**10
_MOST_QUOTED = 40

_WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
_FOREIGN = {
    b"PK\x03\x04": "a spreadsheet or an archive (zip); save the spectrum as CSV",
    b"\xd0\xcf\x11\xe0": "a spreadsheet (Excel); save the spectrum as CSV",
    b"\x89HDF": "HDF5 or NetCDF; write the spectrum to a CSV file",
    b"CDF": "NetCDF; write the spectrum to a CSV file",
    b"SIMPLE  =": "FITS; write the spectrum to a CSV file",
    b"\x1f\x8b": "compressed (gzip); unpack it",
    b"%PDF": "a PDF document; save the spectrum as CSV",
}
_TEXT_CONTROLS = b"\t\n\r\f\x1a"
_CONTROLS = bytes(sorted({*range(32), 127} - set(_TEXT_CONTROLS)))
EXPECTED = "must hold a table of wavelengths and values as text, such as lines wavelength_nm,value"


def quoted(text: str, most: int = _MOST_QUOTED) -> str:
    """Return the beginning of a foreign text in quotes, with what is not printable escaped."""
    return repr(text if len(text) <= most else text[: most - 1] + "…")


def file_state(path: Path) -> str:
    """Give a digest of a file's content.

    Raises:
        InputError: there is no such file, or it cannot be read as a spectrum.
    """
    with _explaining(path):
        status = os.stat(path)  # before it is opened: a pipe would wait for its writer
        if stat.S_ISDIR(status.st_mode):
            raise InputError(f"{path}: cannot be read: is a folder; {EXPECTED}")
        if not stat.S_ISREG(status.st_mode):
            raise InputError(f"{path}: is not a regular file; write the spectrum to one")
        if status.st_size > MOST_BYTES:
            raise InputError(
                f"{path}: has {status.st_size / 2**20:.0f} MiB; at most"
                f" {MOST_BYTES // 2**20} MiB are read as a spectrum; thin it out"
            )
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def open_text(path: Path) -> Iterator[BinaryIO]:
    """Open a file as a stream of bytes in which digits, separators and line ends are ASCII.

    Byte-order marks are taken off, and UTF-16 is turned into UTF-8.

    Raises:
        InputError: the file cannot be read or is not text.
    """
    with _explaining(path), path.open("rb") as file:
        head = file.read(HEAD_BYTES)
        encoding = _wide_encoding(head)
        if encoding:
            yield io.BytesIO(_narrowed(path, file, encoding))
            return
        for magic, what in _FOREIGN.items():
            if head.startswith(magic):
                raise InputError(f"{path}: is not text but {what}")
        if head.translate(None, _CONTROLS) != head:
            raise InputError(f"{path}: is not text; {EXPECTED}")
        file.seek(len(codecs.BOM_UTF8) if head.startswith(codecs.BOM_UTF8) else 0)
        yield file


def whole_text(path: Path, why: str) -> str:
    """Return a file's text, its lines ended by newlines.

    Args:
        path: the file.
        why: the reason to say if it is too large to be held as a whole.

    Raises:
        InputError: the file cannot be read, is not text or is too large.
    """
    with open_text(path) as stream:
        data = stream.read(MOST_TEXT_BYTES + 1)
    if len(data) > MOST_TEXT_BYTES:
        raise InputError(
            f"{path}: {why}; such a file is read up to {MOST_TEXT_BYTES // 2**20} MiB; thin it out"
        )
    if data.translate(None, _CONTROLS) != data:
        at = next(n for n, byte in enumerate(data) if byte in _CONTROLS)
        line = data.count(b"\n", 0, at) + 1
        raise InputError(f"{path}:{line}: holds a control character; {EXPECTED}")
    return decoded(data).replace("\r\n", "\n").replace("\r", "\n")


def decoded(data: bytes) -> str:
    """Decode text that is UTF-8 or else Latin-1."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _wide_encoding(head: bytes) -> str:
    """Return which UTF-16 a text's beginning is, or nothing."""
    for mark, encoding in _WIDE.items():
        if head.startswith(mark):
            return encoding
    even, odd = head[0:400:2], head[1:400:2]
    if len(odd) >= 4:  # digits and separators have a zero byte beside them
        if odd.count(0) > 0.8 * len(odd) and not even.count(0):
            return "utf-16-le"
        if even.count(0) > 0.8 * len(even) and not odd.count(0):
            return "utf-16-be"
    return ""


def _narrowed(path: Path, file: BinaryIO, encoding: str) -> bytes:
    file.seek(0)
    data = file.read(MOST_TEXT_BYTES + 1)
    if len(data) > MOST_TEXT_BYTES:
        raise InputError(
            f"{path}: is UTF-16, read up to {MOST_TEXT_BYTES // 2**20} MiB; save it as UTF-8"
        )
    try:
        return data.decode(encoding).removeprefix("\ufeff").encode("utf-8")
    except UnicodeError:
        raise InputError(f"{path}: is not text; {EXPECTED}") from None


@contextmanager
def _explaining(path: Path) -> Iterator[None]:
    """Turn the system's errors about reading a file into an InputError."""
    try:
        yield
    except FileNotFoundError:
        raise InputError(f"{path}: spectrum file not found; {CHECK_PATH}; {EXPECTED}") from None
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise InputError(f"{path}: cannot be read: {reason}; {EXPECTED}") from None
    except ValueError as error:  # a NUL in the name
        raise InputError(f"{str(path)!r}: not a file name ({error}); {EXPECTED}") from None
