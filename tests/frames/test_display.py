"""From radiance to a displayed picture."""

import math

import numpy as np
import pytest

from rtbow.base.errors import InputError, RtbowError
from rtbow.frames.display import (
    auto_exposure_ev,
    display,
    gamut_map,
    max_luminance,
    require_finite,
    srgb_encode,
)
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS


def random_colours(scale=1.0):
    rng = np.random.default_rng(7)
    return scale * rng.normal(0.3, 0.5, size=(200, 150, 3))


def decode(codes):
    value = codes / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


# --- gamut


def test_gamut_map_gives_colours_that_can_be_shown():
    shown = gamut_map(random_colours(3.0))
    assert shown.min() >= 0.0
    assert shown.max() <= 1.0


def test_gamut_map_keeps_luminance():
    colours = random_colours()
    luminance = np.clip(colours @ LUMINANCE_WEIGHTS, 0.0, 1.0)
    # Rounding of float64 only; worst measured 3e-16.
    np.testing.assert_allclose(gamut_map(colours) @ LUMINANCE_WEIGHTS, luminance, atol=1e-15)


def test_gamut_map_leaves_colours_inside_alone():
    colours = np.random.default_rng(1).uniform(0.0, 1.0, size=(50, 50, 3))
    np.testing.assert_allclose(gamut_map(colours), colours, rtol=0.0, atol=1e-15)


def test_gamut_map_moves_towards_grey_just_far_enough():
    colours = random_colours()
    luminance = colours @ LUMINANCE_WEIGHTS
    shown = gamut_map(colours)
    outside = ((colours < 0).any(-1) | (colours > 1).any(-1)) & (luminance > 0) & (luminance < 1)
    touching = np.minimum(shown.min(-1), 1.0 - shown.max(-1))
    np.testing.assert_allclose(touching[outside], 0.0, atol=1e-15)
    # On the straight line from grey to the colour: differences to grey keep their ratios.
    offset, moved = (c - luminance[..., None] for c in (colours, shown))
    cross = np.cross(offset[outside], moved[outside])
    np.testing.assert_allclose(cross, 0.0, atol=1e-14)


@pytest.mark.parametrize(
    ("colour", "shown"),
    [
        ((5.0, 5.0, 5.0), (1.0, 1.0, 1.0)),
        ((9.0, 2.0, -1.0), (1.0, 1.0, 1.0)),
        ((-1.0, -1.0, -1.0), (0.0, 0.0, 0.0)),
        ((1.0, -0.5, 0.0), (0.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ((1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    ],
)
def test_gamut_map_of_extremes(colour, shown):
    np.testing.assert_array_equal(gamut_map(np.array(colour)), shown)


def test_gamut_map_of_a_known_colour():
    # Y = 0.2126·(-0.1) + 0.7152·0.5 = 0.33634; towards grey by Y / (Y + 0.1).
    share = 0.33634 / 0.43634
    grey = 0.33634
    expected = [0.0, grey + share * (0.5 - grey), grey * (1.0 - share)]
    np.testing.assert_allclose(gamut_map(np.array([-0.1, 0.5, 0.0])), expected, atol=1e-15)


def test_gamut_map_with_infinite_white_leaves_bright_colours():
    colours = np.array([[700.0, 3.0, 2.0], [1e30, 0.0, 0.0]])
    np.testing.assert_array_equal(gamut_map(colours, white=math.inf), colours)


# --- exposure


def test_exposure_follows_photographic_convention():
    # ISO 12232: L_max = 78 / (S q) · 2^EV with S = 100, q = 0.65; sunny 16 is EV 15.
    assert max_luminance(0.0) == pytest.approx(78.0 / (100.0 * 0.65), rel=1e-15)
    assert max_luminance(15.0) == pytest.approx(39321.6, rel=1e-15)


def test_one_exposure_value_more_halves_the_shown_light():
    frame = np.full((4, 4, 3), 1.2 * 2.0**9)
    brighter, darker = (decode(display(frame, ev).astype(float)).mean() for ev in (10.0, 11.0))
    assert brighter == pytest.approx(0.5, abs=0.005)
    assert darker == pytest.approx(0.25, abs=0.005)


def test_auto_exposure_of_a_grey_frame_shows_four_fifths():
    frame = np.full((16, 16, 3), 3000.0, dtype=np.float32)
    assert max_luminance(auto_exposure_ev(frame)) * 0.8 == pytest.approx(3000.0, rel=1e-12)


def test_auto_exposure_looks_at_lit_pixels_only():
    frame = np.zeros((100, 100, 3))
    frame[:10, :10] = 50.0
    assert max_luminance(auto_exposure_ev(frame)) * 0.8 == pytest.approx(50.0, rel=1e-12)


def test_auto_exposure_ignores_a_few_very_bright_pixels():
    frame = np.full((100, 100, 3), 10.0)
    frame[0, :30] = 1e9
    assert max_luminance(auto_exposure_ev(frame)) * 0.8 == pytest.approx(10.0, rel=1e-12)


def test_auto_exposure_does_not_clip_saturated_colours():
    # Pure blue: luminance is 0.07 of the component that would clip.
    frame = np.zeros((20, 20, 3))
    frame[..., 2] = 400.0
    relative = gamut_map(frame / max_luminance(auto_exposure_ev(frame)), white=math.inf)
    assert relative.max() == pytest.approx(0.8, rel=1e-12)


def test_auto_exposure_scales_with_the_frame():
    frame = random_colours()
    assert auto_exposure_ev(frame * 8.0) == pytest.approx(auto_exposure_ev(frame) + 3.0, abs=1e-12)


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_auto_exposure_of_a_black_frame_is_defined(value):
    frame = np.full((4, 4, 3), value, dtype=np.float32)
    ev = auto_exposure_ev(frame)
    assert math.isfinite(ev)
    assert not display(frame, ev).any()


@pytest.mark.parametrize("value", [1.4e-45, 3e38])
def test_exposure_of_extreme_frames(value):
    frame = np.full((4, 4, 3), value, dtype=np.float32)
    shown = decode(display(frame, auto_exposure_ev(frame)).astype(float))
    np.testing.assert_allclose(shown, 0.8, atol=0.01)


@pytest.mark.parametrize("ev", [math.nan, math.inf, -math.inf, 2000.0, -2000.0])
def test_senseless_exposure_is_explained(ev):
    with pytest.raises(InputError, match=r"exposure: .*must be auto or"):
        display(np.ones((2, 2, 3)), ev)


# --- the picture


def test_srgb_curve():
    # IEC 61966-2-1; 0.21404114 and 0.5 are the usual pair of mid grey.
    assert srgb_encode(np.array([0.0, 0.001, 0.21404114, 1.0])) == pytest.approx(
        [0.0, 0.01292, 0.5, 1.0], abs=1e-8
    )


def test_every_code_value_comes_back_as_itself():
    codes = np.arange(256, dtype=np.uint8)
    linear = decode(codes.astype(float))
    frame = np.broadcast_to(linear[None, :, None], (64, 256, 3)) * max_luminance(3.0)
    picture = display(frame, 3.0)
    assert picture.dtype == np.uint8
    np.testing.assert_array_equal(picture, np.broadcast_to(codes[None, :, None], (64, 256, 3)))


def test_dither_keeps_the_mean_of_a_dark_gradient():
    # 0 to 6 code values over 512 pixels: 85 pixels to a step, a visible band without dither.
    wanted = np.linspace(0.0, 6.0, 512)
    linear = decode(wanted)
    frame = np.broadcast_to(linear[None, :, None], (64, 512, 3)) * max_luminance(0.0)
    codes = display(frame, 0.0)[..., 0].astype(float)
    assert np.abs(codes - wanted).max() < 1.0
    means = codes.reshape(8, 8, 64, 8).mean(axis=(1, 3))
    # Rounding alone is off by up to 0.5; worst measured with dither 0.05.
    assert np.abs(means - wanted.reshape(64, 8).mean(axis=1)).max() < 0.06


def test_picture_is_reproducible_and_grey_stays_grey():
    rng = np.random.default_rng(3)
    frame = np.repeat(rng.uniform(0.0, 2.0, size=(40, 60, 1)), 3, axis=2)
    picture = display(frame, 0.0)
    np.testing.assert_array_equal(picture, display(frame.copy(), 0.0))
    assert (picture == picture[..., :1]).all()


def test_frame_is_left_as_it_was():
    frame = random_colours().astype(np.float32)
    before = frame.copy()
    display(frame, auto_exposure_ev(frame))
    np.testing.assert_array_equal(frame, before)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_not_finite_pixel_is_named(bad):
    frame = np.ones((5, 7, 3), dtype=np.float32)
    frame[2, 3, 1] = bad
    frame[4, 0, 0] = bad
    message = r"pixel row 2, column 3 is \[1\.0, .*2 of 35 pixels"
    for function in (require_finite, auto_exposure_ev, lambda rgb: display(rgb, 0.0)):
        with pytest.raises(RtbowError, match=message) as caught:
            function(frame)
        assert caught.value.exit_code == 1
