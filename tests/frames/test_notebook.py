"""Frames in a notebook."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

import rtbow
from rtbow.base.errors import InputError
from rtbow.frames.display import auto_exposure_ev, display
from rtbow.frames.image import write_frame


@pytest.fixture
def frame(rng):
    return rng.uniform(0.0, 4000.0, (4, 6, 3)).astype(np.float32)


@pytest.mark.parametrize("exposure_ev", [None, 13, 12.5])
def test_a_notebook_draws_the_displayed_picture(frame, exposure_ev):
    before = frame.copy()
    picture = rtbow.show(frame, exposure_ev)
    ev = auto_exposure_ev(frame) if exposure_ev is None else exposure_ev
    with Image.open(io.BytesIO(picture._repr_png_())) as image:
        assert image.format == "PNG"
        np.testing.assert_array_equal(np.asarray(image), display(frame, ev))
    assert picture.exposure_ev == ev
    assert repr(picture) == f"<picture of 6 x 4 pixels at EV {ev:.2f}>"
    np.testing.assert_array_equal(frame, before)


@pytest.mark.parametrize(
    "wrong",
    [3, "x", None, [[[1, 2, 3]]], np.zeros((3, 4)), np.zeros((3, 4, 4)), np.zeros((0, 3, 3)),
     np.array([[["a", "b", "c"]]])],
)  # fmt: skip
def test_what_is_no_frame(wrong):
    with pytest.raises(rtbow.InputError, match=r"show takes a frame.*what Renderer\.render"):
        rtbow.show(wrong)


@pytest.mark.parametrize("wrong", ["auto", np.nan, 1e9, [3], True])
def test_what_is_no_exposure(frame, wrong):
    with pytest.raises(rtbow.InputError, match=r"exposure_ev = .*must be a number, -200\.\.200"):
        rtbow.show(frame, wrong)


def test_a_frame_that_is_not_finite(frame):
    frame[1, 2, 0] = np.nan
    with pytest.raises(rtbow.RtbowError, match="row 1, column 2"):
        rtbow.show(frame)


def test_tone_map_gives_what_a_png_shows(tmp_path):
    frame = np.random.default_rng(1).normal(2000.0, 1500.0, (5, 7, 3)).astype(np.float32)
    for ev in (None, 11.5):
        path = tmp_path / f"{ev}.png"
        write_frame(path, frame, {}, exposure_ev=ev)
        with Image.open(path) as picture:
            assert np.array_equal(np.asarray(picture), rtbow.tone_map(frame, ev=ev))
    with pytest.raises(InputError, match=r"tone_map takes a frame"):
        rtbow.tone_map([1, 2, 3])
    with pytest.raises(InputError, match=r"ev = 'bright'; must be a number, -200\.\.200 EV"):
        rtbow.tone_map(frame, ev="bright")
