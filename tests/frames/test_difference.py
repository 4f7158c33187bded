"""Colour differences, and how far a frame is from another."""

import numpy as np
import pytest

from rtbow.frames.difference import Spread, delta_e_2000, frame_difference
from rtbow.physics.light.colour import D65_XYZ

# Sharma, Wu, Dalal, Color Res. Appl. 30, 21 (2005), table 1: pairs 1, 4, 7, 10, 17, 25, 31, 34.
SHARMA = [
    ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
    ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
    ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
    ((50.0, 2.4900, -0.0010), (50.0, -2.4900, 0.0010), 7.1792),
    ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
]


def xyz_of(lab, white):
    """CIE 1976 L*a*b* to X, Y, Z, by its definition."""
    fy = (lab[0] + 16.0) / 116.0
    f = np.array([fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0])
    low = 3.0 * (6.0 / 29.0) ** 2 * (f - 4.0 / 29.0)
    return white * np.where(f > 6.0 / 29.0, f**3, low)


@pytest.mark.parametrize(("first", "second", "expected"), SHARMA)
def test_delta_e_of_published_pairs(first, second, expected):
    white = 7.0 * D65_XYZ
    found = delta_e_2000(xyz_of(first, white), xyz_of(second, white), white)
    # Printed with four digits.
    assert found == pytest.approx(expected, abs=6e-5)


def test_delta_e_keeps_the_shape():
    white = 1e4 * D65_XYZ
    grey = np.full((2, 3, 1), 0.2) * white
    assert delta_e_2000(grey, grey, white).shape == (2, 3)
    assert np.abs(delta_e_2000(grey, grey, white)).max() < 1e-12


def test_frame_difference_of_equal_brightening():
    rng = np.random.default_rng(3)
    frame = rng.uniform(10.0, 100.0, (8, 9, 1)) * D65_XYZ
    found = frame_difference(1.01 * frame, frame)
    assert found.l2 == pytest.approx(0.01)
    # X, Y or Z of D65: Z is greatest.
    level = np.percentile(frame[..., 1], 99.5)
    assert found.relative.worst == pytest.approx(0.01 * frame.max() / level)
    assert 0.0 < found.delta_e.median <= found.delta_e.p99 <= found.delta_e.worst < 0.5


def test_frame_difference_does_not_depend_on_the_unit():
    rng = np.random.default_rng(4)
    first, second = rng.uniform(0.1, 1.0, (2, 50, 3))
    one, other = frame_difference(first, second), frame_difference(9e3 * first, 9e3 * second)
    assert one.delta_e.worst == pytest.approx(other.delta_e.worst)
    assert one.relative.p99 == pytest.approx(other.relative.p99)


def test_black_pixels_do_not_count():
    frame = np.zeros((10, 10, 3))
    frame[0] = D65_XYZ
    found = frame_difference(1.1 * frame, frame)
    assert found.relative.median == pytest.approx(0.1 * D65_XYZ.max(), rel=1e-3)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_frames_with_holes_are_refused(bad):
    frame = np.ones((4, 3))
    broken = frame.copy()
    broken[1, 2] = bad
    with pytest.raises(ValueError, match="NaN"):
        frame_difference(broken, frame)
    with pytest.raises(ValueError, match="shapes"):
        frame_difference(frame[:2], frame)
    with pytest.raises(ValueError, match="no light"):
        frame_difference(frame, 0.0 * frame)


def test_a_sample_says_where_the_whole_frames_percentile_lies():
    """Of 1000 samples of 500 numbers each, 95 % enclose the true percentile, 99 of 0 to 100."""
    rng = np.random.default_rng(3)
    enclosed = 0
    for _ in range(1000):
        low, high = Spread.of(rng.uniform(0.0, 100.0, 500)).p99_range
        enclosed += low <= 99.0 <= high
    assert 940 <= enclosed <= 985


def test_a_small_sample_has_no_upper_end():
    assert Spread.of(np.arange(367.0)).p99_range == (358.0, None)
    assert Spread.of(np.arange(368.0)).p99_range == (359.0, 367.0)
