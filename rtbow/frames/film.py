"""Films of displayed pictures: H.264 in MP4, written whole or not at all.

PyAV brings FFmpeg's libraries and the encoder x264 in its wheel. PyAV is BSD, FFmpeg as built there
LGPL 3, x264 GPL 2 or later: this package uses them and contains none of them, but whoever passes on
both in one bundle passes it on under the GPL.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.files import PathLike, explaining, replacing

if TYPE_CHECKING:
    import av
    from av.container import OutputContainer
    from av.video.stream import VideoStream

FILM_SUFFIXES = (".mp4",)
DEFAULT_FPS = 30.0
FPS_RANGE = (1.0, 240.0)

# x264's constant quality: 6 less halves the errors. 18 counts as visually lossless, but loses the
# dither of dark gradients; with 12 files of rainbows are still small, since they are smooth.
_CRF = 12
_PRESET = "medium"
# The index comes first, so that players start early; and texts may have names of our own.
_MOV_FLAGS = "+faststart+use_metadata_tags"


class Film:
    """A film that is being written; made by :func:`film_at`."""

    def __init__(self, path: PathLike, container: OutputContainer, stream: VideoStream) -> None:
        self._path = path
        self._container = container
        self._stream = stream

    def add(self, picture: NDArray[np.uint8]) -> None:
        """Append a picture.

        Args:
            picture: 8 bit sRGB, shape (h, w, 3). The last row or column of an odd side is shown
                twice, since 2 × 2 pixels of H.264 (4:2:0) share their colour.

        Raises:
            InputError: the film cannot be written.
            RtbowError: the picture has another shape or type.
        """
        import av
        from av.video.reformatter import ColorRange, Colorspace

        padded = even_sides(picture)
        if padded.shape != (self._stream.height, self._stream.width, 3):
            raise RtbowError(f"film: picture of shape {picture.shape} among others of another")
        frame = av.VideoFrame.from_ndarray(padded, format="rgb24").reformat(
            format="yuv420p",
            src_color_range=ColorRange.JPEG,
            dst_color_range=ColorRange.MPEG,
            src_colorspace=Colorspace.ITU709,
            dst_colorspace=Colorspace.ITU709,
        )
        self._encode(frame)

    def _encode(self, frame: av.VideoFrame | None) -> None:
        """Encode a frame; None ends the film."""
        with explaining(self._path):
            self._container.mux(self._stream.encode(frame))


def film_texts(path: PathLike) -> dict[str, str]:
    """Return a film's texts by name; none if the file is no film.

    Raises:
        UnavailableError: PyAV does not load here.
    """
    _require_encoder(path)
    import av

    try:
        # An open file of a given format: of a name, FFmpeg would follow playlists and addresses.
        with (
            open(path, "rb") as file,
            av.open(file, format="mp4", metadata_errors="replace") as film,
        ):
            return dict(film.metadata)
    except (OSError, ValueError, av.FFmpegError):
        return {}


@contextmanager
def film_at(
    path: PathLike,
    size_px: tuple[int, int],
    fps: float = DEFAULT_FPS,
    metadata: Mapping[str, str] | None = None,
) -> Iterator[Film]:
    """Give a film to add pictures to; it takes its place when the block ends without exception.

    Args:
        path: the file; what is there stays until the film is whole.
        size_px: width and height of the pictures.
        fps: pictures a second, 1 to 240.
        metadata: strings that say how the film was made, by name.

    Raises:
        InputError: the frame rate is out of range, or the film cannot be written.
        UnavailableError: the encoder does not load here.
    """
    check_fps(fps)
    _require_encoder(path)
    with replacing(path) as temporary:
        with explaining(path):
            container, stream = _open(temporary, size_px, fps, metadata or {})
        try:
            film = Film(path, container, stream)
            yield film
            film._encode(None)
        except BaseException:
            with suppress(OSError):  # the film is thrown away
                container.close()
            raise
        with explaining(path):
            container.close()


def check_fps(fps: float) -> None:
    """Raise InputError unless a frame rate is within ``FPS_RANGE``."""
    low, high = FPS_RANGE
    if not low <= fps <= high:  # NaN too
        raise InputError(f"--fps {fps:g}: must be {low:g}..{high:g} pictures a second")


def even_sides(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Give a picture with its last row and column repeated where their number is odd.

    Raises:
        RtbowError: the picture is not 8 bit RGB.
    """
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
        raise RtbowError(f"film: picture of shape {picture.shape}, type {picture.dtype}")
    height, width, _ = picture.shape
    padded = np.pad(picture, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return np.ascontiguousarray(padded)


def _open(
    temporary: Path, size_px: tuple[int, int], fps: float, metadata: Mapping[str, str]
) -> tuple[OutputContainer, VideoStream]:
    import av
    from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc

    container = av.open(str(temporary), "w", format="mp4", options={"movflags": _MOV_FLAGS})
    container.metadata.update(metadata)
    # 29.97 becomes 2997/100, as it was typed.
    rate = Fraction(fps).limit_denominator(1001)
    stream = container.add_stream(
        "libx264", rate=rate, options={"crf": str(_CRF), "preset": _PRESET}
    )
    width, height = size_px
    stream.width, stream.height = width + width % 2, height + height % 2
    stream.pix_fmt = "yuv420p"  # what every player plays
    codec = stream.codec_context
    codec.color_range = ColorRange.MPEG
    codec.colorspace = Colorspace.ITU709
    codec.color_primaries = ColorPrimaries.BT709
    codec.color_trc = ColorTrc.IEC61966_2_1  # the sRGB curve
    return container, stream


def _require_encoder(path: PathLike) -> None:
    try:
        import av

        found = "libx264" in av.codecs_available
        why = "this PyAV comes without the encoder libx264"
    except ImportError as error:
        found, why = False, f"PyAV does not load ({error})"
    if not found:
        raise UnavailableError(
            f"{path}: {why}; install the wheel with: pip install --force-reinstall av, or write"
            " frames, such as frame_%04d.png"
        )
