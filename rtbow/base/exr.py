"""OpenEXR files of float32 channels, written whole or not at all."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.files import PathLike, write_atomic

# Names that mean something else in every OpenEXR header. The last three can be written as
# strings, but OpenEXR's own Python reader then hides them.
_RESERVED_ATTRIBUTES = frozenset(
    {
        "channels",
        "chromaticities",
        "compression",
        "dataWindow",
        "envmap",
        "displayWindow",
        "lineOrder",
        "pixelAspectRatio",
        "screenWindowCenter",
        "screenWindowWidth",
        "type",
        "whiteLuminance",
        "chunkCount",
        "tiles",
        "version",
    }
)


# What OpenEXR raises, by where a file was cut off or damaged.
NOT_A_FRAME = (RuntimeError, ValueError, TypeError, KeyError)


def write_exr_channels(
    path: PathLike,
    channels: Mapping[str, NDArray[np.float32]],
    metadata: Mapping[str, str],
    header: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Write named float32 channels as OpenEXR, whole or not at all.

    Args:
        path: Where the file is to be.
        channels: Arrays of one shape (h, w) by channel name.
        metadata: String attributes by name.
        header: Further attributes of OpenEXR's own.

    Raises:
        InputError: The file cannot be written.
        RtbowError: An attribute's name is one of OpenEXR's own.
    """
    for name in metadata:
        if not name or name in _RESERVED_ATTRIBUTES:
            raise RtbowError(f"frame attribute {name!r}: the name is one of OpenEXR's own")
    texts = {item: plain_text(text) for item, text in metadata.items()}
    planes = {c: np.ascontiguousarray(plane, dtype=np.float32) for c, plane in channels.items()}
    write_atomic(path, _exr_bytes(path, planes, {**texts, **header}))


def plain_text(text: str) -> str:
    """Return a text without what neither format can hold: zero bytes and undecodable ones."""
    return text.encode("utf-8", "backslashreplace").decode().replace("\0", "\\x00")


Planes = dict[str, NDArray[np.float32]]


def _exr_bytes(path: PathLike, planes: Planes, header: Mapping[str, Any]) -> bytes:
    """Return the channels as the bytes of an OpenEXR file.

    OpenEXR writes to file names only and reports no error of a full disk, so it gets a file in
    memory (or, without that, a temporary one), and what it wrote is read back before it is used.
    """
    try:
        descriptor = os.memfd_create("rtbow-frame")
    except (AttributeError, OSError):
        descriptor = None
    if descriptor is not None:
        try:
            name = f"/proc/self/fd/{descriptor}"
            if os.path.exists(name):
                return _written(path, name, planes, header)
        finally:
            os.close(descriptor)
    try:
        with tempfile.TemporaryDirectory() as folder:
            return _written(path, os.path.join(folder, "frame.exr"), planes, header)
    except OSError as error:
        raise InputError(
            f"{os.fspath(path)}: cannot be written: no temporary file ({error.strerror}); "
            "set TMPDIR to a folder with space"
        ) from error


def _written(path: PathLike, name: str, planes: Planes, header: Mapping[str, Any]) -> bytes:
    """Let OpenEXR write channels under a name, verify them, and return the file's bytes."""
    import OpenEXR

    own = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    try:
        # OpenEXR replaces the arrays inside the dictionary, so it gets one for it alone.
        with OpenEXR.File({**header, **own}, dict(planes)) as file:
            file.write(name)
        with OpenEXR.File(name, separate_channels=True) as file:
            back = file.channels()
            complete = all(np.array_equal(back[c].pixels, plane) for c, plane in planes.items())
    except NOT_A_FRAME:
        complete = False
    if not complete:
        raise InputError(
            f"{os.fspath(path)}: cannot be written: OpenEXR left it incomplete; "
            "free some memory, or raise the limit on file size (ulimit -f)"
        )
    return Path(name).read_bytes()


def read_planes(name: str) -> tuple[NDArray[np.float32], dict[str, str]]:
    """Read R, G and B of a file (h, w, 3) and its string attributes; raises what OpenEXR raises."""
    # Here and not above: OpenEXR takes long to import, and most verbs never need it.
    import OpenEXR

    with OpenEXR.File(name, separate_channels=True) as file:
        channels = file.channels()
        missing = [c for c in "RGB" if c not in channels]
        if missing:
            raise ValueError(f"no channel {', '.join(missing)}")
        planes = [np.asarray(channels[c].pixels, dtype=np.float32) for c in "RGB"]
        return np.stack(planes, axis=-1), string_attributes(file)


def string_attributes(file: Any) -> dict[str, str]:
    """Return the string attributes of an open file: on closing, OpenEXR empties its header."""
    return {item: text for item, text in file.header().items() if isinstance(text, str)}
