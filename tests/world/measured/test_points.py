"""Points by the million are averaged, and nothing is lost of what counts."""

import numpy as np
import pytest

import rtbow.world.measured.points as points
from rtbow.physics.light.spectrum import Spectrum, bin_means, colour_weights, wavelength_bins
from rtbow.world.measured.points import Points


def gathered(nm, values, parts):
    got = Points()
    for part in np.array_split(np.arange(len(nm)), parts):
        got.add(nm[part], values[part], part + 1)
    return got


@pytest.fixture
def fine(monkeypatch):
    """A spectrum of sharp lines on a slope, some of its points denser than the averages."""
    monkeypatch.setattr(points, "MOST_POINTS", 1000)
    rng = np.random.default_rng(5)
    nm = np.unique(np.concatenate([rng.uniform(300.0, 900.0, 30_000), np.arange(500, 501, 1e-4)]))
    return nm, 1.0 + nm / 500.0 + 50.0 * rng.random(len(nm)) ** 20


@pytest.mark.parametrize("falling", [False, True])
def test_averages_keep_integral_and_centre(fine, falling):
    nm, values = fine
    order = slice(None, None, -1) if falling else slice(None)
    got = gathered(nm[order], values[order], 37)
    assert got.averaged
    assert got.count == len(nm)
    assert (got.lowest_nm, got.highest_nm) == (nm[0], nm[-1])
    before, after = Spectrum("", nm, values), Spectrum("", *got.result())
    assert len(after.wavelength_nm) == 80_001
    assert after.value.min() >= values.min()
    assert after.value.max() <= values.max()
    assert after.visible == pytest.approx(before.visible, rel=1e-9)
    bins = wavelength_bins(5.0)
    ours, theirs = colour_weights(after, bins), colour_weights(before, bins)
    np.testing.assert_allclose(ours.sum(axis=0), theirs.sum(axis=0), rtol=1e-9)
    np.testing.assert_allclose(bin_means(after, bins), bin_means(before, bins), rtol=1e-3)


def test_blocks_do_not_matter(fine):
    one, other = gathered(*fine, 7), gathered(*fine, 90)
    np.testing.assert_allclose(one.result()[1], other.result()[1], rtol=1e-9)
    assert one.steps_nm == other.steps_nm


def test_a_range_that_ends_within_the_visible_stays(fine):
    nm, values = fine
    inside = (nm > 400.0) & (nm < 700.0)
    got = gathered(nm[inside], values[inside], 20)
    at, average = got.result()
    assert (at[0], at[-1]) == (pytest.approx(400.0, abs=0.06), pytest.approx(700.0, abs=0.06))
    assert np.all(average[1:-1] > 1.0)


def test_few_points_stay_as_they_are():
    nm, values = np.linspace(300.0, 900.0, 5000), np.linspace(1.0, 2.0, 5000)
    got = gathered(nm[::-1], values[::-1], 3)
    assert not got.averaged
    np.testing.assert_array_equal(got.result()[0], nm)
    np.testing.assert_array_equal(got.result()[1], values)
