"""Frames on disk: radiance as OpenEXR, displayed pictures as PNG."""

import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.exr import (
    NOT_A_FRAME,
    plain_text,
    read_planes,
    string_attributes,
    write_exr_channels,
)
from rtbow.base.files import PathLike, write_atomic
from rtbow.base.version import __version__
from rtbow.frames.display import auto_exposure_ev, display, require_finite
from rtbow.scene.model import Scene

FRAME_SUFFIXES = (".exr", ".png")
EXPOSURE_TEXT = "exposureEV100"
"""Name of the metadata that holds an exposure value."""

# Rec. 709 primaries and D65 as x, y of red, green, blue and white (ITU-R BT.709-6).
CHROMATICITIES = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


def frame_metadata(scene: Scene, command: str, method: str, renderer: str) -> dict[str, str]:
    """Give the strings that say how a frame was made.

    Args:
        scene: the scene that it shows.
        command: the command line that made it.
        method: the method that drew it.
        renderer: the GL device and driver, or the CPU.
    """
    return {
        "scene": scene.source_text,
        "sceneName": scene.source_name,
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
    suffix: str = "",
    *,
    whole_sphere: bool = False,
) -> None:
    """Write a frame in the format of the suffix: radiance as ``.exr``, a picture as ``.png``.

    Args:
        path: The file, ending in ``.exr`` or ``.png``; ``-`` is standard output, with
            a ``suffix``.
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3).
        metadata: Strings that say how the frame was made.
        exposure_ev: Exposure value (ISO 100) of the picture, which ``.exr`` notes as well; None
            chooses one by the frame, and ``.exr`` notes none.
        suffix: Which format; left out, the path's own.
        whole_sphere: Whether it is a panorama, which ``.exr`` notes.

    Raises:
        InputError: The suffix is unknown or the file cannot be written.
        RtbowError: The frame holds a NaN or an infinity.
    """
    suffix = suffix or Path(path).suffix.lower()
    if suffix == ".exr":
        texts = {**metadata, **_exposure_text(exposure_ev)}
        write_exr(path, rgb, texts, whole_sphere=whole_sphere)
    elif suffix == ".png":
        if exposure_ev is None:
            exposure_ev = auto_exposure_ev(rgb)
        write_png(path, display(rgb, exposure_ev), {**metadata, **_exposure_text(exposure_ev)})
    else:
        raise InputError(
            f"{os.fspath(path)}: suffix {suffix!r} is not known; must be .exr or .png; "
            "choose another name"
        )


def _exposure_text(exposure_ev: float | None) -> dict[str, str]:
    return {} if exposure_ev is None else {EXPOSURE_TEXT: f"{exposure_ev:.6g}"}


def write_exr(
    path: PathLike,
    rgb: NDArray[np.float32],
    metadata: Mapping[str, str],
    *,
    whole_sphere: bool = False,
) -> None:
    """Write a frame as OpenEXR with float32 channels R, G, B, whole or not at all.

    Args:
        path: The file.
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3); negative components are kept.
        metadata: String attributes by name.
        whole_sphere: Whether it is a panorama by latitude and longitude, as OpenEXR's own attribute
            ``envmap`` then says. Its axes are up (y), towards the middle of the picture (z) and
            level to the left of that (x); its longitudes rise to the left.

    Raises:
        InputError: The file cannot be written.
        RtbowError: The frame holds a NaN or an infinity, has another shape, or an attribute's name
            is one of OpenEXR's own.
    """
    frame = np.asarray(rgb, dtype=np.float32)
    _require_shape(frame)
    require_finite(frame)
    channels = {c: frame[..., i] for i, c in enumerate("RGB")}
    header: dict[str, Any] = {"chromaticities": CHROMATICITIES, "whiteLuminance": 1.0}
    if whole_sphere:
        import OpenEXR

        header["envmap"] = OpenEXR.ENVMAP_LATLONG
    write_exr_channels(path, channels, metadata, header)


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
        return read_planes(os.fspath(path))
    except NOT_A_FRAME as error:
        raise InputError(
            f"{os.fspath(path)}: not a frame ({error}); must be OpenEXR with channels R, G, B; "
            "choose another file"
        ) from error


def write_png(path: PathLike, display_rgb: NDArray[np.uint8], metadata: Mapping[str, str]) -> None:
    """Write a displayed picture as an sRGB PNG, whole or not at all.

    Args:
        path: The file.
        display_rgb: 8 bit sRGB, shape (h, w, 3).
        metadata: Texts by keyword, of 1 to 79 Latin letters.

    Raises:
        InputError: The file cannot be written.
        RtbowError: The picture has another shape or type.
    """
    write_atomic(path, png_bytes(display_rgb, metadata))


def png_bytes(display_rgb: NDArray[np.uint8], metadata: Mapping[str, str]) -> bytes:
    """Give the bytes of a PNG file; see :func:`write_png`."""
    # Imported late: most runs never write a PNG.
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
        info.add_text(name, plain_text(text))
    buffer = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(display_rgb)).save(buffer, format="PNG", pnginfo=info)
    return buffer.getvalue()


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
        # Not Image.open, which refuses large pictures as an attack.
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
    """Return a frame's texts by name, without reading its pixels; none if it is no frame."""
    return exr_texts(path) if Path(path).suffix.lower() == ".exr" else png_texts(path)


def exr_texts(path: PathLike) -> dict[str, str]:
    """Return the string attributes of an OpenEXR file by name; none if it is not OpenEXR."""
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path), header_only=True) as file:
            return string_attributes(file)
    except (OSError, *NOT_A_FRAME):
        return {}


def png_texts(path: PathLike) -> dict[str, str]:
    """Return the texts before the pixels of a PNG file by keyword; none if it is not PNG."""
    from PIL.PngImagePlugin import PngImageFile

    try:
        with PngImageFile(path) as image:
            return {str(name): text for name, text in image.info.items() if isinstance(text, str)}
    except (OSError, ValueError, SyntaxError):
        return {}


def _require_shape(frame: NDArray[Any]) -> None:
    if frame.ndim != 3 or frame.shape[2] != 3 or frame.size == 0:
        raise RtbowError(f"frame: shape is {frame.shape}; must be (height, width, 3)")
