"""Names of frames: patterns, what is proposed in place of a wrong one, and what is there."""

from __future__ import annotations

import os

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.frames.image import exr_texts, frame_texts, png_texts, write_exr, write_png
from rtbow.sequence.outputs import Pattern, check_places, frames_beyond, parse_outputs


def test_patterns():
    assert Pattern("out/frame_%04d.exr").path(7) == "out/frame_0007.exr"
    assert Pattern("out/frame_%04d.exr").path(12345) == "out/frame_12345.exr"
    assert Pattern("100%%_%d.png").path(3) == "100%_3.png"
    assert Pattern("50%dry/100%%/f_%02d.png").path(3) == "50%dry/100%%/f_03.png".replace("%%", "%")
    assert Pattern("%02d.PNG").suffix == ".png"


@pytest.mark.parametrize(
    ("typed", "proposed"),
    [
        ("a_%d.jpg", "a_%d.exr"),
        ("out/a_%03d_b.tif", "out/a_%03d_b.exr"),
        ("100%%_%d.jpg", "100%%_%d.exr"),
        ("a.jpg", "a%04d.exr"),
        ("a%.jpg", "a%04d.exr"),
        ("a_%d_%d.jpg", "a_%04d.exr"),
        ("a_%d", "a_%d.exr"),
        ("a_%d.", "a_%d.exr"),
        ("%d", "%d.exr"),
        ("", "frame_%04d.exr"),
        (".", "frame_%04d.exr"),
        ("out", "out/frame_%04d.exr"),
        ("out/", "out/frame_%04d.exr"),
        ("a.png", "a%04d.png"),
        ("a_%s.PNG", "a_%04d.PNG"),
    ],
)
def test_what_is_proposed_names_frames(tmp_path, monkeypatch, typed, proposed):
    monkeypatch.chdir(tmp_path)
    os.mkdir("out")
    with pytest.raises(InputError) as caught:
        parse_outputs([typed])
    assert str(caught.value).endswith(f"write for example {proposed}")
    assert [one.text for one in parse_outputs([proposed]).frames] == [proposed]


@pytest.mark.parametrize(
    ("typed", "proposed"),
    [
        ("a.avi", "a.mp4"),
        ("out/a_%04d.mkv", "out/a.mp4"),
        ("out/%d.mp4", "out/film.mp4"),
        ("100%%_%d.mp4", "100%%.mp4"),
        ("a%03d_b.MP4", "a_b.mp4"),
    ],
)
def test_what_is_proposed_names_a_film(tmp_path, monkeypatch, typed, proposed):
    monkeypatch.chdir(tmp_path)
    os.mkdir("out")
    with pytest.raises(InputError) as caught:
        parse_outputs([typed])
    assert str(caught.value).endswith(f"write for example {proposed}")
    assert parse_outputs([proposed]).films == (proposed,)


def test_frames_beyond_a_number(tmp_path):
    for name in (
        "f_9.exr",
        "f_010.exr",
        "f_11.exr",
        "f_100.exr",
        "f_.exr",
        "f_12.png",
        "xf_13.exr",
    ):
        (tmp_path / name).touch()
    found = frames_beyond(parse_outputs([f"{tmp_path}/f_%d.exr"]), 10)
    assert found == [f"{tmp_path}/f_11.exr", f"{tmp_path}/f_100.exr"]
    assert frames_beyond(parse_outputs([f"{tmp_path}/f_%03d.exr"]), 9) == [
        f"{tmp_path}/f_010.exr",
        f"{tmp_path}/f_100.exr",
    ]
    assert Pattern("nowhere/%d.exr").beyond(0) == []


def test_percent_signs_and_dots_are_no_wildcards(tmp_path):
    for name in ("50%_7.exr", "50x_8.exr", "50%_9xexr"):
        (tmp_path / name).touch()
    assert Pattern(f"{tmp_path}/50%%_%d.exr").beyond(0) == [f"{tmp_path}/50%_7.exr"]


def test_devices_may_stand_in_a_frames_place(tmp_path):
    (tmp_path / "1.exr").symlink_to(os.devnull)
    (tmp_path / "2.exr").symlink_to("nowhere")
    (tmp_path / "f.mp4").symlink_to(os.devnull)
    outputs = parse_outputs([f"{tmp_path}/%d.exr", f"{tmp_path}/f.mp4"])
    check_places(outputs, 3, overwrite=False)


@pytest.mark.parametrize("suffix", ["exr", "EXR", "png"])
def test_texts_are_read_without_the_pixels(tmp_path, suffix):
    path = tmp_path / f"f.{suffix}"
    assert frame_texts(path) == {}
    if suffix == "png":
        write_png(path, np.ones((200, 300, 3), np.uint8), {"animation": "a", "scene": "ä\n"})
    else:
        write_exr(path, np.ones((200, 300, 3), np.float32), {"animation": "a", "scene": "ä\n"})
    path.write_bytes(path.read_bytes()[:-100])
    assert frame_texts(path).items() >= {"animation": "a", "scene": "ä\n"}.items()
    path.write_bytes(b"another file")
    assert frame_texts(path) == exr_texts(path) == png_texts(path) == {}
