"""Frames on disk: radiance as OpenEXR, displayed pictures as PNG."""

import io
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow import __version__
from rtbow.display import auto_exposure_ev, display, require_finite
from rtbow.errors import InputError, RtbowError
from rtbow.files import PathLike, write_atomic
from rtbow.scene import Scene

FRAME_SUFFIXES = (".exr", ".png")

# Rec. 709 primaries and D65 as x, y of red, green, blue and white (ITU-R BT.709-6).
CHROMATICITIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)

# Names that mean something else in every OpenEXR header. The last three can be written as
# strings, but OpenEXR's own Python reader then hides them.
_RESERVED_ATTRIBUTES = frozenset(
    {
        "channels",
        "chromaticities",
        "compression",
        "dataWindow",
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
_NOT_A_FRAME = (RuntimeError, ValueError, TypeError, KeyError)


def frame_metadata(scene: Scene, command: str, method: str, renderer: str) -> dict[str, str]:
    """Give the strings that say how a frame was made.

    Args:
        scene: what it shows.
        command: the command line that made it.
        method: that drew it.
        renderer: the GL device and driver, or the CPU.
    """
    return {
        "scene": scene.source_text,
        "command": command,
        "rtbowVersion": __version__,
        "method": method,
        "renderer": renderer,
    }


def write_frame(
    path: PathLike,
    rgb: NDArray[np.float32],
    metadata: Mapping[str, str],
    exposure_ev: float | None = None,
) -> None:
    """Write a frame as the file's suffix says: ``.exr`` radiance or ``.png`` displayed picture.

    Args:
        path: Where the file shall stand, ending in ``.exr`` or ``.png``.
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3).
        metadata: Strings that say how the frame was made.
        exposure_ev: Exposure value (ISO 100) of the picture; None chooses one by the frame.

    Raises:
        InputError: The suffix is unknown or the file cannot be written.
        RtbowError: The frame holds a NaN or an infinity.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".exr":
        write_exr(path, rgb, metadata)
    elif suffix == ".png":
        if exposure_ev is None:
            exposure_ev = auto_exposure_ev(rgb)
        said = {**metadata, "exposureEV100": f"{exposure_ev:.6g}"}
        write_png(path, display(rgb, exposure_ev), said)
    else:
        raise InputError(
            f"{os.fspath(path)}: suffix {suffix!r} is not known; must be .exr or .png; "
            "choose another name"
        )


def write_exr(path: PathLike, rgb: NDArray[np.float32], metadata: Mapping[str, str]) -> None:
    """Write a frame as OpenEXR with float32 channels R, G, B, whole or not at all.

    Args:
        path: Where the file shall stand.
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3); negative components are kept.
        metadata: String attributes by name.

    Raises:
        InputError: The file cannot be written.
        RtbowError: The frame holds a NaN or an infinity, has another shape, or an attribute's name
            is one of OpenEXR's own.
    """
    frame = np.asarray(rgb, dtype=np.float32)
    _require_shape(frame)
    require_finite(frame)
    channels = {c: frame[..., i] for i, c in enumerate("RGB")}
    header = {"chromaticities": CHROMATICITIES, "whiteLuminance": 1.0}
    write_exr_channels(path, channels, metadata, header)


def write_exr_channels(
    path: PathLike,
    channels: Mapping[str, NDArray[np.float32]],
    metadata: Mapping[str, str],
    header: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Write named float32 channels as OpenEXR, whole or not at all.

    Args:
        path: Where the file shall stand.
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
    texts = {item: _plain(text) for item, text in metadata.items()}
    planes = {c: np.ascontiguousarray(plane, dtype=np.float32) for c, plane in channels.items()}
    write_atomic(path, _exr_bytes(path, planes, {**texts, **header}))


def read_exr(path: PathLike) -> tuple[NDArray[np.float32], dict[str, str]]:
    """Return the radiance and the string attributes of an OpenEXR file.

    Args:
        path: A file with channels R, G, B.

    Returns:
        Frame, shape (h, w, 3), and attributes by name.

    Raises:
        InputError: The file cannot be read or is not such a frame.
    """
    try:
        with open(path, "rb"):
            pass
    except (OSError, ValueError) as error:
        what = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"{os.fspath(path)}: cannot be read: {what}; check the name and its permissions"
        ) from error
    try:
        return _read_exr(os.fspath(path))
    except _NOT_A_FRAME as error:
        raise InputError(
            f"{os.fspath(path)}: not a frame ({error}); must be OpenEXR with channels R, G, B; "
            "choose another file"
        ) from error


def write_png(path: PathLike, display_rgb: NDArray[np.uint8], metadata: Mapping[str, str]) -> None:
    """Write a displayed picture as an sRGB PNG, whole or not at all.

    Args:
        path: Where the file shall stand.
        display_rgb: 8 bit sRGB, shape (h, w, 3).
        metadata: Texts by keyword, of 1 to 79 Latin letters.

    Raises:
        InputError: The file cannot be written.
        RtbowError: The picture has another shape or type.
    """
    # Here, since most runs never write a PNG.
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    _require_shape(display_rgb)
    if display_rgb.dtype != np.uint8:
        raise RtbowError(f"picture: type is {display_rgb.dtype}; must be uint8")
    info = PngInfo()
    # Rendering intent 0, perceptual; gAMA is 1/2.2 for readers that know no sRGB (PNG, 11.3.2.5).
    info.add(b"sRGB", b"\x00")
    info.add(b"gAMA", (45455).to_bytes(4, "big"))
    for name, text in metadata.items():
        # Latin-1 goes into tEXt, everything else as UTF-8 into iTXt.
        info.add_text(name, _plain(text))
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(display_rgb)).save(buffer, format="PNG", pnginfo=info)
    write_atomic(path, buffer.getvalue())


def read_png(path: PathLike) -> tuple[NDArray[np.uint8], dict[str, str]]:
    """Return the picture and the texts of a PNG file.

    Args:
        path: A file of 8 bit RGB.

    Returns:
        Picture, shape (h, w, 3), and texts by keyword.

    Raises:
        InputError: The file cannot be read or is not such a picture.
    """
    from PIL.PngImagePlugin import PngImageFile

    try:
        # Not Image.open, which takes large pictures for an attack.
        with PngImageFile(path) as image:
            if image.mode != "RGB":
                raise ValueError(f"mode {image.mode}")
            picture = np.asarray(image)
            return picture, {name: str(text) for name, text in image.text.items()}
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(
            f"{os.fspath(path)}: not a picture ({error}); must be a PNG of 8 bit RGB; choose "
            "another file"
        ) from error


def frame_texts(path: PathLike) -> dict[str, str]:
    """Return what a frame says of itself, without its pixels; nothing of a file that is none."""
    return exr_texts(path) if Path(path).suffix.lower() == ".exr" else png_texts(path)


def exr_texts(path: PathLike) -> dict[str, str]:
    """Return the string attributes of an OpenEXR file; none of a file that is no such one."""
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path), header_only=True) as file:
            return _texts(file)
    except (OSError, *_NOT_A_FRAME):
        return {}


def png_texts(path: PathLike) -> dict[str, str]:
    """Return the texts before the pixels of a PNG file; none of a file that is no such one."""
    from PIL.PngImagePlugin import PngImageFile

    try:
        with PngImageFile(path) as image:
            return {str(name): text for name, text in image.info.items() if isinstance(text, str)}
    except (OSError, ValueError, SyntaxError):
        return {}


def _require_shape(frame: NDArray[Any]) -> None:
    if frame.ndim != 3 or frame.shape[2] != 3 or frame.size == 0:
        raise RtbowError(f"frame: shape is {frame.shape}; must be (height, width, 3)")


def _plain(text: str) -> str:
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
    except _NOT_A_FRAME:
        complete = False
    if not complete:
        raise InputError(
            f"{os.fspath(path)}: cannot be written: OpenEXR left it incomplete; "
            "free some memory, or raise the limit on file size (ulimit -f)"
        )
    return Path(name).read_bytes()


def _read_exr(name: str) -> tuple[NDArray[np.float32], dict[str, str]]:
    # Here and not above: OpenEXR takes long to import, and most verbs never need it.
    import OpenEXR

    with OpenEXR.File(name, separate_channels=True) as file:
        channels = file.channels()
        missing = [c for c in "RGB" if c not in channels]
        if missing:
            raise ValueError(f"no channel {', '.join(missing)}")
        planes = [np.asarray(channels[c].pixels, dtype=np.float32) for c in "RGB"]
        return np.stack(planes, axis=-1), _texts(file)


def _texts(file: Any) -> dict[str, str]:
    """Return the string attributes of an open file: on closing, OpenEXR empties its header."""
    return {item: text for item, text in file.header().items() if isinstance(text, str)}
