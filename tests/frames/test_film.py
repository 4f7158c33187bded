"""Films: what is encoded comes back, odd sides, and no half film whatever happens."""

from __future__ import annotations

import builtins
import os
import resource
import signal
from fractions import Fraction

import av
import numpy as np
import pytest
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc

from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.frames.display import display, max_luminance
from rtbow.frames.film import even_sides, film_at, film_texts

COLOURS = [
    (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255),
    (128, 128, 128), (20, 20, 20), (200, 150, 50), (0, 0, 0),
]  # fmt: skip


def bars(height: int = 64, width: int = 256) -> np.ndarray:
    """Stripes of saturated and grey colours, far wider than a block of the encoder."""
    columns = np.arange(width) * len(COLOURS) // width
    return np.broadcast_to(np.array(COLOURS, np.uint8)[columns], (height, width, 3)).copy()


def read(path) -> tuple[list[np.ndarray], av.container.InputContainer]:
    container = av.open(str(path))
    with container:
        pictures = [
            frame.to_ndarray(
                format="rgb24",
                src_colorspace=Colorspace.ITU709,
                src_color_range=ColorRange.MPEG,
                dst_color_range=ColorRange.JPEG,
            )
            for frame in container.decode(video=0)
        ]
    return pictures, container


def test_pictures_come_back_in_their_order_and_colours(tmp_path):
    """Colours to 2 of 255, measured 1, in the middle of the stripes."""
    path = tmp_path / "film.mp4"
    pictures = [bars(), bars()[:, ::-1], np.full((64, 256, 3), 77, np.uint8)]
    with film_at(path, (256, 64)) as film:
        for picture in pictures:
            film.add(picture)
    back, _ = read(path)
    assert len(back) == 3
    for ours, theirs in zip(pictures, back, strict=True):
        assert theirs.shape == (64, 256, 3)
        middle = np.s_[8:-8, 16::32]
        np.testing.assert_allclose(theirs[middle].astype(int), ours[middle].astype(int), atol=2)


def test_what_players_are_told(tmp_path):
    path = tmp_path / "film.mp4"
    said = {"scene": "a = 1\n# ä 虹\n", "command": "rtbow animate", "rtbowVersion": "1"}
    with film_at(path, (32, 16), 25.0, said) as film:
        for _ in range(5):
            film.add(np.zeros((16, 32, 3), np.uint8))
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        codec = stream.codec_context
        assert (codec.name, codec.pix_fmt) == ("h264", "yuv420p")
        assert (stream.average_rate, stream.frames) == (25, 5)
        assert container.duration == 200_000  # microseconds
        assert (codec.width, codec.height) == (32, 16)
        assert codec.color_range == ColorRange.MPEG
        assert codec.colorspace == Colorspace.ITU709
        assert codec.color_primaries == ColorPrimaries.BT709
        assert codec.color_trc == ColorTrc.IEC61966_2_1
        assert said.items() <= dict(container.metadata).items()
    data = path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # plays before it is all there


@pytest.mark.parametrize(
    ("fps", "rate"), [(1.0, 1), (24.0, 24), (29.97, Fraction(2997, 100)), (240.0, 240)]
)
def test_rates(tmp_path, fps, rate):
    with film_at(tmp_path / "film.mp4", (2, 2), fps) as film:
        film.add(np.zeros((2, 2, 3), np.uint8))
    with av.open(str(tmp_path / "film.mp4")) as container:
        assert container.streams.video[0].average_rate == rate


@pytest.mark.parametrize("size", [(1, 1), (3, 2), (2, 3), (161, 91)])
def test_odd_sides_repeat_their_last_row_and_column(tmp_path, size):
    width, height = size
    picture = np.full((height, width, 3), 90, np.uint8)
    with film_at(tmp_path / "film.mp4", size) as film:
        film.add(picture)
    (back,), _ = read(tmp_path / "film.mp4")
    assert back.shape == (height + height % 2, width + width % 2, 3)
    assert np.abs(back.astype(int) - 90).max() <= 2


def test_what_a_film_says_of_itself(tmp_path):
    path = tmp_path / "film.mp4"
    assert film_texts(path) == {}
    with film_at(path, (16, 16), 25.0, {"scene": "ä\n"}) as film:
        film.add(bars(16, 16))
    assert film_texts(path)["scene"] == "ä\n"
    for data in (path.read_bytes()[:200], b"", b"another file", b"#EXTM3U\n/etc/hostname\n"):
        path.write_bytes(data)
        assert "scene" not in film_texts(path)


def test_padding():
    picture = np.arange(3 * 5 * 3, dtype=np.uint8).reshape(3, 5, 3)
    padded = even_sides(picture)
    np.testing.assert_array_equal(padded[:3, :5], picture)
    np.testing.assert_array_equal(padded[3, :5], picture[2])
    np.testing.assert_array_equal(padded[:3, 5], picture[:, 4])
    np.testing.assert_array_equal(even_sides(padded), padded)


@pytest.mark.parametrize("fps", [0.0, -30.0, 241.0, float("nan"), float("inf")])
def test_rates_that_are_refused(tmp_path, fps):
    with (
        pytest.raises(InputError, match=r"must be 1\.\.240"),
        film_at(tmp_path / "a.mp4", (2, 2), fps),
    ):
        pass
    assert os.listdir(tmp_path) == []


def test_pictures_that_do_not_belong(tmp_path):
    with film_at(tmp_path / "film.mp4", (8, 8)) as film:
        film.add(np.zeros((8, 8, 3), np.uint8))
        for wrong in (np.zeros((8, 10, 3), np.uint8), np.zeros((8, 8, 3)), np.zeros((8, 8), "u1")):
            with pytest.raises(RtbowError, match="film: picture of shape"):
                film.add(wrong)


def stop(film) -> None:
    for _ in range(100):  # more than the encoder looks ahead, so that some are on disk
        film.add(np.zeros((8, 8, 3), np.uint8))
    raise KeyboardInterrupt


def test_an_interrupt_spares_the_old_film(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt), film_at(path, (8, 8)) as film:
        stop(film)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["film.mp4"]


def noise(film) -> None:
    rng = np.random.default_rng(1)
    for _ in range(60):
        film.add(rng.integers(0, 256, (128, 128, 3), dtype=np.uint8))


def test_no_room_spares_the_old_film_and_is_explained(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"old")
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, limits[1]))
    try:
        with (
            pytest.raises(InputError, match=r"film.mp4: cannot be written: .*; raise the limit"),
            film_at(path, (128, 128)) as film,
        ):
            noise(film)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["film.mp4"]


def test_without_pyav(tmp_path, monkeypatch):
    true_import = builtins.__import__

    def no_av(name, *args):
        if name == "av":
            raise ImportError("libx264.so.165: cannot open shared object file")
        return true_import(name, *args)

    monkeypatch.setattr(builtins, "__import__", no_av)
    with (
        pytest.raises(
            UnavailableError, match=r"PyAV does not load \(libx264.*pip install.*or write"
        ),
        film_at(tmp_path / "film.mp4", (8, 8)),
    ):
        pass
    assert os.listdir(tmp_path) == []


def test_without_the_encoder(tmp_path, monkeypatch):
    monkeypatch.setattr(av, "codecs_available", frozenset({"mpeg4"}))
    with pytest.raises(UnavailableError, match="libx264"), film_at(tmp_path / "film.mp4", (8, 8)):
        pass


def test_dark_gradients_stay_smooth(tmp_path):
    """A ramp from 8 to 24 of 255, dithered: means of 8 columns come back to 0.5.

    Measured: 0.43, which are roundings to 219 levels; x264's default of 23 gives 0.7.
    """
    codes = np.linspace(8.0, 24.0, 256) / 255.0
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    grey = np.broadcast_to(linear[None, :, None], (64, 256, 3)) * max_luminance(0.0)
    picture = display(grey.astype(np.float32), 0.0)
    with film_at(tmp_path / "film.mp4", (256, 64)) as film:
        for _ in range(12):
            film.add(picture)
    with av.open(str(tmp_path / "film.mp4")) as container:
        *_, last = container.decode(video=0)
    luma = last.to_ndarray()[:64].astype(float)  # 16..235; to RGB, FFmpeg rounds down
    means = luma.mean(axis=0).reshape(-1, 8).mean(axis=1)
    wanted = 16.0 + 219.0 * codes.reshape(-1, 8).mean(axis=1)
    np.testing.assert_allclose(means, wanted, atol=0.5)
