"""The reference's pixels as means over their solid angle."""

import numpy as np
import pytest

import rtbow
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference import pixels
from rtbow.reference.pixels import pixel_means, pixel_points
from rtbow.reference.render import radiance_of_pixels, render_reference
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of
from rtbow.world.world import resolve


@pytest.mark.parametrize("fov_deg", [2.0, 90.0, 150.0])
def test_points_are_even_along_both_sides(fov_deg):
    points = pixel_points(view_of(Camera(size_px=(160, 90), fov_deg=fov_deg)), 4.65e-3)
    middles = (np.arange(len(points)) + 0.5) / len(points)
    np.testing.assert_allclose(np.sort(points, axis=0), np.stack([middles, middles], axis=1))


def test_more_points_for_wider_pixels():
    counts = [
        len(pixel_points(view_of(Camera(size_px=(64, 36), fov_deg=fov)), 4.65e-3))
        for fov in (2.0, 75.0, 150.0)
    ]
    assert counts == sorted(set(counts))


def test_a_mean_over_the_solid_angle():
    # The mean of the height over a pyramid of solid angle: by Gauss's rule on the picture plane.
    camera = Camera(size_px=(1, 1), fov_deg=100.0, altitude_deg=0.0)
    half = np.tan(np.radians(50.0))
    nodes, weights = np.polynomial.legendre.leggauss(60)
    x, y = np.meshgrid(half * nodes, half * nodes)
    length = np.sqrt(1.0 + x**2 + y**2)
    share = np.outer(weights, weights) / length**3
    expected = np.sum(share / length) / share.sum()
    # 4 asin(sin² a) steradians, a = 50°, from a side.
    assert half**2 * np.sum(np.outer(weights, weights) / length**3) == pytest.approx(
        4.0 * np.arcsin(np.sin(np.radians(50.0)) ** 2), rel=1e-9
    )
    zero = np.array([0])
    got = pixel_means(view_of(camera), zero, zero, 4.65e-3, lambda rays: rays[:, 1:2], 1)
    assert got[0, 0] == pytest.approx(expected, rel=2e-3)


CHANGES = {"render.wavelength_step_nm": 40.0, "camera.fov_deg": 10.0, "camera.altitude_deg": 22.0}
SIZE = {"camera.size_px": [6, 4]}


@pytest.mark.slow
def test_a_frame_is_the_mean_of_finer_ones():
    area = rtbow.load_scene("uniform", {**CHANGES, **SIZE, "camera.pixel": "area"})
    fine = rtbow.load_scene(
        "uniform", {**CHANGES, "camera.size_px": [96, 64], "camera.pixel": "centre"}
    )
    got = render_reference(resolve(area))
    split = render_reference(resolve(fine)).reshape(4, 16, 6, 16, 3).mean(axis=(1, 3))
    bright = split.max()
    np.testing.assert_allclose(got, split, rtol=0.0, atol=6e-3 * bright)
    centres = render_reference(
        resolve(rtbow.load_scene("uniform", {**CHANGES, **SIZE, "camera.pixel": "centre"}))
    )
    assert np.abs(centres - split).max() > 0.05 * bright


@pytest.mark.slow
def test_twice_as_many_points_change_little(monkeypatch):
    world = resolve(rtbow.load_scene("uniform", {**CHANGES, **SIZE, "camera.pixel": "area"}))
    rows, columns = np.indices((4, 6)).reshape(2, -1)
    once = radiance_of_pixels(world, rows, columns)
    count = len(pixel_points(world.view, world.optics.suns[0].disc_rad))
    larger = next(n for n in pixels._LATTICES if n[0] > 1.9 * count)
    monkeypatch.setattr(pixels, "_LATTICES", (larger,))
    twice = radiance_of_pixels(world, rows, columns)
    assert not np.array_equal(twice, once)
    assert np.abs(twice - once).max() < 5e-3 * twice.max()


def test_a_single_pixel_holds_a_whole_bow():
    """A ring as wide as the bow of half-millimetre drops, off the axis: by its closed form."""
    radius, width = np.radians(42.0), 8e-3

    def ring(rays, middle):
        return np.exp(-0.5 * ((np.arccos(rays @ middle) - radius) / width) ** 2)[:, None]

    # 2 pi sin(radius) times a bell curve's integral, but for its width's square; over the pyramid.
    light = 2.0 * np.pi * np.sin(radius) * np.exp(-0.5 * width**2) * np.sqrt(2.0 * np.pi) * width
    expected = light / (4.0 * np.arcsin(np.sin(np.radians(50.0)) ** 2))
    view = view_of(Camera(size_px=(1, 1), fov_deg=100.0, altitude_deg=0.0))
    zero = np.array([0])
    for altitude in np.radians([0.0, 2.0, 4.0, 6.0, 7.0]):
        middle = np.array([0.0, np.cos(altitude), np.sin(altitude)])
        got = pixel_means(view, zero, zero, 4.65e-3, lambda rays, m=middle: ring(rays, m), 1000)
        # Up to 9 % off with no more than 987 points.
        assert got[0, 0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_some_pixels_are_those_of_the_frame():
    changes = {"render.wavelength_step_nm": 40.0, "camera.size_px": [5, 3], "camera.pixel": "area"}
    world = resolve(rtbow.load_scene("uniform", {**changes, "camera.fov_deg": 10.0}))
    frame = rgb_to_xyz(render_reference(world))
    rows, columns = np.array([0, 2]), np.array([4, 1])
    np.testing.assert_allclose(
        radiance_of_pixels(world, rows, columns), frame[rows, columns], rtol=1e-9
    )
