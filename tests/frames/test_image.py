"""Frames on disk."""

import os
import resource
import signal
import struct
import zlib

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from rtbow.base.errors import InputError, RtbowError
from rtbow.frames import image
from rtbow.frames.display import auto_exposure_ev, display
from rtbow.frames.image import png_texts, read_exr, read_png, write_exr, write_frame, write_png

METADATA = {
    "scene": '[camera]\nsize_px = [5, 7]  # "größer", 大',
    "command": "rtbow render -o frame.exr",
    "renderer": "llvmpipe (LLVM 15.0.6, 256 bits)",
    "an_attribute_with_a_name_of_more_than_31_letters": "kept",
    "empty": "",
}


@pytest.fixture
def frame():
    rng = np.random.default_rng(5)
    values = rng.normal(100.0, 300.0, size=(7, 5, 3)).astype(np.float32)
    values[0, 0] = [1e-42, -3e38, 3e38]  # denormal and extreme values of float32
    return values


def picture():
    return np.arange(7 * 5 * 3, dtype=np.uint8).reshape(7, 5, 3)


def png_chunks(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    position, chunks = 8, []
    while position < len(data):
        (length,) = struct.unpack(">I", data[position : position + 4])
        body = data[position + 4 : position + 8 + length]
        (check,) = struct.unpack(">I", data[position + 8 + length : position + 12 + length])
        assert zlib.crc32(body) == check
        chunks.append((body[:4], body[4:]))
        position += 12 + length
    return chunks


# --- OpenEXR


def test_exr_round_trip_is_exact(tmp_path, frame):
    path = tmp_path / "frame.exr"
    write_exr(path, frame, METADATA)
    back, metadata = read_exr(path)
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, frame)
    assert metadata == METADATA
    assert os.listdir(tmp_path) == ["frame.exr"]


def test_a_panorama_says_so_in_openexrs_own_attribute(tmp_path, frame):
    write_frame(tmp_path / "whole.exr", frame, METADATA, whole_sphere=True)
    write_frame(tmp_path / "lens.exr", frame, METADATA)
    # Name, type, size of the value, ENVMAP_LATLONG: as ImfEnvmap.h has them.
    stored = b"envmap\0envmap\0\x01\0\0\0\x00"
    assert stored in (tmp_path / "whole.exr").read_bytes()
    assert b"envmap" not in (tmp_path / "lens.exr").read_bytes()
    back, metadata = read_exr(tmp_path / "whole.exr")
    np.testing.assert_array_equal(back, frame)
    assert metadata == METADATA


def test_exr_has_separate_float_channels_and_standard_attributes(tmp_path, frame):
    path = tmp_path / "frame.exr"
    write_exr(path, frame, METADATA)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        assert sorted(channels) == ["B", "G", "R"]
        for index, name in enumerate("RGB"):
            assert channels[name].pixels.dtype == np.float32
            np.testing.assert_array_equal(channels[name].pixels, frame[..., index])
        header = dict(file.header())
    assert header["compression"] == OpenEXR.ZIP_COMPRESSION
    assert header["whiteLuminance"] == 1.0
    rec709_d65 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
    assert header["chromaticities"] == pytest.approx(rec709_d65, rel=1e-7)
    assert header["scene"] == METADATA["scene"]


def test_exr_first_row_is_on_top(tmp_path):
    frame = np.zeros((4, 6, 3), dtype=np.float32)
    frame[0, 1, 0] = 1.0
    write_exr(tmp_path / "frame.exr", frame, {})
    with OpenEXR.File(str(tmp_path / "frame.exr"), separate_channels=True) as file:
        assert file.channels()["R"].pixels[0, 1] == 1.0
        low, high = file.header()["dataWindow"]
    assert (low.tolist(), high.tolist()) == ([0, 0], [5, 3])


def test_exr_takes_arrays_of_any_layout(tmp_path, frame):
    views = {
        "flipped": frame[::-1, ::2],
        "float64": frame[1:].astype(np.float64),
        "read-only": np.broadcast_to(np.float32(2.5), (3, 4, 3)),
        "fortran": np.asfortranarray(frame),
    }
    for name, view in views.items():
        write_exr(tmp_path / f"{name}.exr", view, {})
        np.testing.assert_array_equal(read_exr(tmp_path / f"{name}.exr")[0], view)


def test_exr_leaves_frame_and_metadata_as_they_were(tmp_path, frame):
    before, metadata = frame.copy(), dict(METADATA)
    write_exr(tmp_path / "frame.exr", frame, metadata)
    np.testing.assert_array_equal(frame, before)
    assert metadata == METADATA


def test_exr_without_memory_files(tmp_path, frame, monkeypatch):
    def none(name):
        raise OSError("not here")

    monkeypatch.setattr(image.os, "memfd_create", none)
    write_exr(tmp_path / "frame.exr", frame, METADATA)
    np.testing.assert_array_equal(read_exr(tmp_path / "frame.exr")[0], frame)


def test_exr_text_with_bytes_that_are_not_text(tmp_path, frame):
    # File names from the command line may hold such bytes.
    write_exr(tmp_path / "frame.exr", frame, {"command": "bad \udcff name\0"})
    assert read_exr(tmp_path / "frame.exr")[1] == {"command": "bad \\udcff name\\x00"}


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_not_finite_frame_is_refused(tmp_path, frame, bad):
    frame[3, 4, 2] = bad
    for name in ("frame.exr", "frame.png"):
        with pytest.raises(RtbowError, match="pixel row 3, column 4"):
            write_frame(tmp_path / name, frame, {}, None)
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize("name", ["version", "type", "channels", "chunkCount", ""])
def test_attribute_that_would_be_lost_is_refused(tmp_path, frame, name):
    with pytest.raises(RtbowError, match="OpenEXR's own"):
        write_exr(tmp_path / "frame.exr", frame, {name: "text"})


@pytest.mark.parametrize("shape", [(7, 5), (7, 5, 4), (3, 7, 5), (0, 5, 3)])
def test_frame_of_another_shape_is_refused(tmp_path, shape):
    with pytest.raises(RtbowError, match="must be \\(height, width, 3\\)"):
        write_exr(tmp_path / "frame.exr", np.zeros(shape, dtype=np.float32), {})
    with pytest.raises(RtbowError, match="must be \\(height, width, 3\\)"):
        write_png(tmp_path / "frame.png", np.zeros(shape, dtype=np.uint8), {})


# A small file is written when it is closed, where OpenEXR reports nothing; a large one before.
@pytest.mark.parametrize(("size", "limit"), [(5, 500), (32, 500), (32, 4000)])
@pytest.mark.parametrize("memory", [True, False])
def test_exr_is_never_silently_cut_off(tmp_path, monkeypatch, size, limit, memory):
    if not memory:
        monkeypatch.delattr(image.os, "memfd_create")
    path = tmp_path / "frame.exr"
    path.write_bytes(b"old")
    noise = np.random.default_rng(0).normal(size=(size, size, 3)).astype(np.float32)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))
    try:
        with pytest.raises(InputError, match=r"frame\.exr: cannot be written: .*ulimit -f"):
            write_exr(path, noise, {})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["frame.exr"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="only Linux has /dev/full")
@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_full_disk_is_reported(tmp_path, frame, suffix):
    path = tmp_path / f"full{suffix}"
    path.symlink_to("/dev/full")
    with pytest.raises(InputError, match="free some space"):
        write_frame(path, frame, {}, 0.0)


def test_reading_explains_what_is_wrong(tmp_path, frame):
    path = tmp_path / "frame.exr"
    with pytest.raises(InputError, match=r"frame\.exr: cannot be read: No such file"):
        read_exr(path)
    write_exr(path, frame, {})
    path.write_bytes(path.read_bytes()[:400])
    with pytest.raises(InputError, match=r"frame\.exr: not a frame"):
        read_exr(path)
    grey = {"Y": np.zeros((4, 4), dtype=np.float32)}
    with OpenEXR.File({}, grey) as file:
        file.write(str(path))
    with pytest.raises(InputError, match=r"no channel R, G, B"):
        read_exr(path)


# --- PNG


def test_png_round_trip_with_texts(tmp_path):
    path = tmp_path / "frame.png"
    write_png(path, picture(), METADATA)
    with Image.open(path) as back:
        back.load()
        assert back.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(back), picture())
        assert dict(back.text) == METADATA
    assert os.listdir(tmp_path) == ["frame.png"]


def test_png_is_read_back_with_its_texts(tmp_path, rng):
    picture = rng.integers(0, 256, (5, 7, 3), dtype=np.uint8)
    texts = {"scene": "a = 1\r\n# ä 虹\n", "command": "rtbow render", "empty": ""}
    write_png(tmp_path / "a.png", picture, texts)
    back, said = read_png(tmp_path / "a.png")
    np.testing.assert_array_equal(back, picture)
    assert back.dtype == np.uint8
    assert said == texts
    assert png_texts(tmp_path / "a.png").items() >= texts.items()
    assert png_texts(tmp_path / "missing.png") == {}


@pytest.mark.parametrize("kept", [0, 8, 200, -60])
def test_a_png_that_is_cut_off_is_no_picture(tmp_path, rng, kept):
    path = tmp_path / "a.png"
    write_png(path, rng.integers(0, 256, (20, 30, 3), dtype=np.uint8), {"scene": "text"})
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"a\.png: not a picture .*; must be a PNG of 8 bit RGB"):
        read_png(path)


def test_other_pictures_are_refused(tmp_path):
    Image.new("L", (4, 4)).save(tmp_path / "grey.png")
    Image.new("RGB", (4, 4)).save(tmp_path / "no.png", format="JPEG")
    for name in ("grey.png", "no.png", "missing.png"):
        with pytest.raises(InputError, match="not a picture"):
            read_png(tmp_path / name)


def test_png_says_that_it_is_srgb(tmp_path):
    path = tmp_path / "frame.png"
    write_png(path, picture(), METADATA)
    chunks = png_chunks(path)
    kinds = [kind for kind, _ in chunks]
    assert dict(chunks)[b"sRGB"] == b"\0"
    assert dict(chunks)[b"gAMA"] == (45455).to_bytes(4, "big")
    # The standard wants both before the pixels.
    assert max(kinds.index(b"sRGB"), kinds.index(b"gAMA")) < kinds.index(b"IDAT")
    assert {b"tEXt", b"iTXt"} <= set(kinds)


def test_png_of_another_type_is_refused(tmp_path):
    with pytest.raises(RtbowError, match="must be uint8"):
        write_png(tmp_path / "frame.png", picture().astype(np.float32), {})


# --- by suffix


def test_frame_is_written_as_its_suffix_says(tmp_path, frame):
    frame[0, 0] = 100.0
    write_frame(tmp_path / "a.EXR", frame, METADATA, 3.0)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.EXR")[0], frame)
    for name, given, used in (("b.png", 8.0, 8.0), ("c.png", None, auto_exposure_ev(frame))):
        write_frame(tmp_path / name, frame, METADATA, given)
        with Image.open(tmp_path / name) as back:
            np.testing.assert_array_equal(np.asarray(back), display(frame, used))
            assert float(back.text["exposureEV100"]) == pytest.approx(used, rel=1e-5)
            assert back.text["scene"] == METADATA["scene"]


def test_unknown_suffix_is_explained(tmp_path, frame):
    with pytest.raises(InputError, match=r"must be \.exr or \.png"):
        write_frame(tmp_path / "a.jpg", frame, {}, None)
