"""Arrays of numbers read from ``.npz`` files that anyone may have made.

``numpy.load`` trusts a file's headers: it takes the memory that they claim, evaluates them as
Python, and fails in as many ways as there are readers beneath it. Here type and shape of an array
are known before memory is taken for it, its data are read piece by piece and must be exactly as
long as the header says, and whatever is wrong is one kind of error.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO, Any, BinaryIO

import numpy as np

from rtbow.base.errors import InputError, UnavailableError, cut

_CHUNK = 1 << 18
"""Bytes unpacked at a time."""
_MOST_AT_ONCE = 1 << 20
"""Bytes of the file read at a time: the archive's directory, which is read whole, has a few
hundred."""
_MOST_HEADER = 10_000
"""Characters of an array's header; those of plain numbers have about 100."""
_MOST_DEFLATED = 1040
"""Deflate shortens at most 1032 times."""
_WAYS = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}
"""Those of NumPy. Memory for others is set by the file."""

_ITEM = r"""(?: (?P<{0}>['"])(?:descr|fortran_order|shape)(?P={0}) \s*:\s*
    (?: '[^'\\]*' | "[^"\\]*" | True | False | \( [\d\s,L]* \) ) )"""
_HEADER = re.compile(
    r"\s*\{{\s* {} \s*,\s* {} \s*,\s* {} \s*,?\s*\}}\s*".format(
        *(_ITEM.format(name) for name in ("a", "b", "c"))
    ),
    re.VERBOSE,
)
_TYPE = re.compile(r"""['"]descr['"]\s*:\s*['"]([<>|=]?[fiu]\d{1,2})['"]""")
_ANY_TYPE = re.compile(r"""['"]descr['"]\s*:\s*['"]?([^'"]*)""")
_FORTRAN = re.compile(r"""['"]fortran_order['"]\s*:\s*(True|False)""")
_SHAPE = re.compile(r"""['"]shape['"]\s*:\s*\(([\d\s,L]*)\)""")
_LENGTH = re.compile(r"\d{1,19}")


@dataclass(frozen=True)
class Header:
    """What an array says of itself.

    Attributes:
        dtype: of real numbers.
        shape: its lengths.
        fortran: the first index runs fastest.
        size: bytes that the header takes.
    """

    dtype: np.dtype[Any]
    shape: tuple[int, ...]
    fortran: bool
    size: int

    @property
    def count(self) -> int:
        """Items in the array."""
        return math.prod(self.shape)


class Npz:
    """The arrays of an open file.

    Every method raises InputError, whose message follows the file's name, where the file does not
    hold what it should.
    """

    def __init__(self, file: BinaryIO) -> None:
        with _explained("not a readable .npz file"):
            self._archive = zipfile.ZipFile(_Frugal(file))
        self._members: dict[str, list[zipfile.ZipInfo]] = {}
        for member in self._archive.infolist():
            self._members.setdefault(member.filename.removesuffix(".npy"), []).append(member)

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return list(self._members)

    def header(self, name: str) -> Header:
        """Read what an array says of itself, and check that its data have the length for it."""
        with _explained(f"{name} cannot be read"), self._open(name) as member:
            header = _header(name, member)
        there = self._member(name).file_size - header.size
        wanted = header.count * header.dtype.itemsize
        if there != wanted:
            raise InputError(
                f"{name} {_shape_text(header.shape)} has {there:,} bytes of data where its header"
                f" tells of {wanted:,}: the file is damaged"
            )
        return header

    def read(self, name: str, header: Header, dtype: np.dtype[Any] | type) -> np.ndarray[Any, Any]:
        """Read an array, converted to a type of real numbers; too large ones become infinite.

        Args:
            name: the array's.
            header: as :meth:`header` gave it, found acceptable by the caller.
            dtype: of the result, for which alone memory is taken.
        """
        with _explained(f"{name} cannot be read"):
            values = np.empty(header.count, dtype)
            first = 0
            for piece in self._pieces(name, header):
                with np.errstate(over="ignore", invalid="ignore", under="ignore"):
                    values[first : first + len(piece)] = piece
                first += len(piece)
        return values.reshape(header.shape, order="F" if header.fortran else "C")

    def _pieces(self, name: str, header: Header) -> Iterator[np.ndarray[Any, Any]]:
        left = header.count * header.dtype.itemsize
        with self._open(name) as member:
            _exactly(member, header.size)
            while left:
                data = _exactly(member, min(left, _CHUNK // 16 * header.dtype.itemsize))
                left -= len(data)
                yield np.frombuffer(data, header.dtype)
            member.read(1)  # the end, where zipfile compares check sums

    def _member(self, name: str) -> zipfile.ZipInfo:
        members = self._members[name]
        if len(members) > 1:
            raise InputError(f"holds {name} {len(members)} times; leave one of them")
        member = members[0]
        if member.flag_bits & 1:
            raise InputError("is encrypted; save it without a password")
        if member.compress_type not in _WAYS:
            raise InputError(
                f"{name} is compressed in a way that NumPy does not use; write the file with"
                " numpy.savez_compressed"
            )
        if member.file_size > _MOST_DEFLATED * (member.compress_size + 1):
            raise InputError(f"{name} cannot be as long as the file says: the file is damaged")
        return member

    def _open(self, name: str) -> IO[bytes]:
        return self._archive.open(self._member(name))


class _Frugal(io.RawIOBase):
    """A file of which no more is read at once than an archive of a few arrays needs."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def read(self, size: int | None = -1) -> bytes:
        wanted = _MOST_AT_ONCE + 1 if size is None or size < 0 else size
        data = b"" if wanted > _MOST_AT_ONCE + 1 else self._file.read(wanted)
        if wanted > _MOST_AT_ONCE + 1 or len(data) > _MOST_AT_ONCE:
            raise ValueError("its directory is longer than that of a few arrays")
        return data

    def seek(self, offset: int, whence: int = 0) -> int:
        return self._file.seek(offset, whence)

    def tell(self) -> int:
        return self._file.tell()

    def seekable(self) -> bool:
        return True


@contextmanager
def _explained(what: str) -> Iterator[None]:
    """Turn all that the readers raise into an InputError."""
    try:
        yield
    except InputError:
        raise
    except MemoryError as error:
        raise UnavailableError(f"{what}: not enough memory; use a coarser volume") from error
    except Exception as error:
        # Damaged bytes fail in as many ways as zipfile and zlib have.
        raise InputError(f"{what}: {cut(str(error) or type(error).__name__)}") from None


def _exactly(member: IO[bytes], size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        more = member.read(size - len(data))
        if not more:
            raise InputError("its data end early: the file is damaged")
        data += more
    return bytes(data)


def _header(name: str, member: IO[bytes]) -> Header:
    """Read an array's header: magic, version, length, and a dictionary of Python's (NEP 1)."""
    start = _exactly(member, 8)
    if not start.startswith(b"\x93NUMPY"):
        raise InputError(f"{name} is not an array of NumPy's")
    width = {1: 2, 2: 4, 3: 4}.get(start[6])
    if width is None or start[7] != 0:
        raise InputError(f"{name} has a header of version {start[6]}.{start[7]}; must be 1.0-3.0")
    length = int.from_bytes(_exactly(member, width), "little")
    if length > _MOST_HEADER:
        raise InputError(
            f"{name} has a header of {length:,} bytes; must have up to {_MOST_HEADER:,}"
        )
    text = _exactly(member, length).decode("latin1")
    return Header(*_described(name, text), 8 + width + length)


def _described(name: str, text: str) -> tuple[np.dtype[Any], tuple[int, ...], bool]:
    """Read type, shape and order from a header's text, without evaluating it."""
    kind, order, shape = _TYPE.search(text), _FORTRAN.search(text), _SHAPE.search(text)
    if not kind and (other := _ANY_TYPE.search(text)):
        what = other[1].strip()
        raise InputError(
            f"{name} holds {'records' if what[:1] in '[{' else cut(what)}, not numbers"
        )
    lengths = _LENGTH.findall(shape[1]) if shape else []
    if not (kind and order and shape and _HEADER.fullmatch(text)) or len(lengths) > 32:
        raise InputError(f"{name} has a damaged header: {cut(ascii(text.strip()))}")
    try:
        dtype = np.dtype(kind[1])
    except TypeError:
        raise InputError(f"{name} holds {kind[1]}, which this machine's NumPy lacks") from None
    return dtype, tuple(map(int, lengths)), order[1] == "True"


def _shape_text(shape: tuple[int, ...]) -> str:
    return cut(str(shape))
