"""Colours averaged over pixels: trapezoids, and what of them is a wider disc."""

import numpy as np
import pytest

from rtbow.physics.light.disc import disc_mean
from rtbow.render.colours.pixels import PixelLevels, over_pixels, pixel_levels
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of


def brute(function, at, u, v, count=400):
    """The mean over u by v evenly spaced places."""
    offsets = (np.arange(count) + 0.5) / count - 0.5
    shift = (u * offsets[:, None] + v * offsets).ravel()
    return np.array([function(x + shift).mean() for x in at])


def test_means_are_those_over_the_pixel():
    def bow(chord):
        slope = np.where(chord > 1.2, -40.0, 400.0)
        return np.exp(slope * (chord - 1.2)) + 0.1 * chord

    chord = np.linspace(1.0, 1.5, 4001)
    levels = PixelLevels(np.array([0.0, 1e-3, 4e-3]), 3, 1e-4)
    lines = over_pixels(bow(chord)[:, None], chord, levels)[..., 0]
    assert lines.shape == (9, 4001)
    pick = slice(400, 3600, 200)
    for line, (u, v) in zip(lines, levels.extents(), strict=True):
        # Straight lines between the columns are off by 2e-4 at the tip.
        np.testing.assert_allclose(line[pick], brute(bow, chord[pick], u, v), rtol=0.0, atol=1e-3)


def test_shapes_have_the_same_variance():
    levels = PixelLevels(np.array([1e-3]), 12, 1e-4)
    extents = np.array(list(levels.extents()))
    np.testing.assert_allclose((extents**2).sum(axis=1), 1e-3)
    shape = 2.0 * extents.prod(axis=1) / 1e-3
    np.testing.assert_allclose(shape, (np.arange(12) + 0.5) / 12.0)


def test_the_poles_mirror():
    chord = np.linspace(0.0, 2.0 * np.sqrt(2.0), 2001)
    levels = PixelLevels(np.array([2.5e-3]), 1, 1e-4)
    ((u, v),) = levels.extents()
    middle = np.sqrt(2.0)
    for values, at in (
        (np.abs, (0.0, 0.02)),
        (lambda c: 2.0 * middle - np.where(c > 2.0 * middle, 4.0 * middle - c, c), (2.0 * middle,)),
    ):
        got = np.interp(at, chord, over_pixels(values(chord)[:, None], chord, levels)[0, :, 0])
        np.testing.assert_allclose(got, brute(values, at, u, v), atol=1e-5)


def test_levels_reach_from_nothing_to_the_widest_pixel():
    view = view_of(Camera(size_px=(160, 90), fov_deg=150.0))
    levels = pixel_levels(view, 5e-3, 10_000, roaming=False)
    assert levels.squared[0] == 0.0
    assert levels.squared[-1] == pytest.approx((2.0 * np.tan(np.radians(75.0)) / 160) ** 2)
    assert levels.hold(view)
    assert not levels.hold(view_of(Camera(size_px=(80, 45), fov_deg=150.0)))
    wider = pixel_levels(view, 5e-3, 10_000, roaming=True)
    assert wider.hold(view_of(Camera(size_px=(80, 45), fov_deg=150.0)))
    steps = np.diff(np.log(levels.squared + levels.blur))
    np.testing.assert_allclose(steps, steps[0])
    assert levels.per_level == pytest.approx(1.0 / steps[0])


def test_many_radii_have_fewer_levels():
    view = view_of(Camera(size_px=(160, 90), fov_deg=150.0))
    few = pixel_levels(view, 5e-3, 60 * 5000, roaming=False)
    assert len(few.squared) * few.shapes <= 6_000_000 // (60 * 5000)


def test_a_wider_disc_has_the_pixels_variance():
    # A disc of radius r and a square of width w: together as a disc of r² + w²/3.
    radius, width, theta = 4.65e-3, 4e-3, 2.4
    squared = radius**2 + width**2 / 3.0

    def moment(angle):
        return (angle - theta) ** 2

    both = disc_mean(moment, theta, radius, 64) + width**2 / 12.0
    # The sphere's curvature changes either by 1e-5 of itself.
    assert disc_mean(moment, theta, np.sqrt(squared), 64) == pytest.approx(both, rel=1e-4)
    assert both == pytest.approx(0.25 * squared, rel=1e-4)
