"""What the window's shader shows of a frame is what pictures on disk show."""

from __future__ import annotations

import numpy as np
import pytest

from glsl_probe import probe
from rtbow.frames.display import _dither, display, gamut_map, srgb_encode
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS
from rtbow.view.window.image import Picture

GREY = np.linspace(0.0, 1.0, 16, dtype=np.float32)[:, None].repeat(3, axis=1)
WEIGHTS = {"weights": tuple(LUMINANCE_WEIGHTS)}


def test_colours_out_of_gamut_are_moved_alike(gl, rng):
    colours = np.float32(rng.uniform(-1.0, 3.0, (20_000, 3)))
    shown = probe(
        gl, ["display/tone.glsl"], "inGamut(colour, weights)", {"colour": colours}, uniforms=WEIGHTS
    )
    np.testing.assert_allclose(shown[:, :3], gamut_map(colours), atol=4e-6)


def test_the_curve_is_srgb(gl):
    values = np.linspace(0.0, 1.0, 5000, dtype=np.float32)
    colours = np.stack([values, values[::-1], values**2], axis=1)
    shown = probe(gl, ["display/tone.glsl"], "srgb(colour)", {"colour": colours})
    # Mesa's pow errs by 3e-6; a code is 4e-3.
    np.testing.assert_allclose(shown[:, :3], srgb_encode(colours), atol=1e-5)


def test_the_dither_is_that_of_pictures(gl):
    rows, columns = np.indices((64, 96))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float32)
    found = probe(gl, ["display/tone.glsl"], "dither(pixel)", {"pixel": pixels})[:, 0]
    difference = np.abs(found - _dither(64, 96).ravel())
    # fract jumps where float32 rounds over a whole number.
    assert np.quantile(np.minimum(difference, 1.0 - difference), 0.99) < 2e-3


def drawn(gl, rgb, exposure_ev, size=None, false_range=None):
    height, width = rgb.shape[:2] if size is None else size
    picture = Picture(gl, GREY)
    picture.take(rgb)
    texture = gl.ctx.texture((width, height), 4)
    target = gl.ctx.framebuffer([texture])
    picture.draw(target, (0, 0, width, height), exposure_ev, false_range)
    data = np.frombuffer(texture.read(), np.uint8).reshape(height, width, 4)
    return data[::-1, :, :3].astype(int)


def test_a_frame_is_shown_as_its_file_is(gl, rng):
    rgb = np.float32(rng.uniform(-200.0, 4000.0, (60, 80, 3)))
    difference = np.abs(drawn(gl, rgb, 11.0) - display(rgb, 11.0).astype(int))
    assert difference.max() <= 1
    assert (difference > 0).mean() < 0.02


def test_a_coarse_frame_is_stretched_over_its_place(gl):
    rgb = np.zeros((2, 2, 3), dtype=np.float32)
    rgb[0, 0] = 4000.0
    shown = drawn(gl, rgb, 11.0, size=(40, 40))
    assert shown[0, 0].min() > 200
    assert shown[0, -1].max() == shown[-1, 0].max() == shown[-1, -1].max() == 0
    assert np.all(np.diff(shown[0, :, 0]) <= 1)


@pytest.mark.parametrize("exposure_ev", [-200.0, 200.0])
def test_the_ends_of_the_exposure_are_white_and_black(gl, exposure_ev):
    rgb = np.full((4, 4, 3), 1000.0, dtype=np.float32)
    assert np.all(drawn(gl, rgb, exposure_ev) == (255 if exposure_ev < 0.0 else 0))


def test_false_colours_follow_the_logarithm_of_luminance(gl):
    luminance = np.float32(10.0 ** np.linspace(0.0, 4.0, 101))
    rgb = np.repeat(luminance[None, :, None], 3, axis=2)
    rgb[0, 0] = 0.0
    shown = drawn(gl, rgb, 0.0, false_range=(0.0, 4.0))[0, :, 0]
    np.testing.assert_allclose(shown[2:-2], 255.0 * np.linspace(0.0, 1.0, 101)[2:-2], atol=10.0)
    assert shown[0] == 0
