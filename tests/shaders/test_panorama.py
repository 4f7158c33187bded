"""The shader's panorama: its rays, and what of a pixel's solid angle lies where."""

import numpy as np
import pytest

from glsl_probe import probe
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of

FILES = ["common/camera.glsl"]
AREA = {"PANORAMA": True, "PIXEL_AREA": True, "POLARIZER": False}


def camera_of(width, azimuth_deg=50.0):
    view = view_of(
        Camera(projection="panorama", size_px=(width, width // 2), azimuth_deg=azimuth_deg)
    )
    return view, {"size": (float(width), width / 2.0), "basis": view.basis.T}


def ask(gl, expression, inputs, uniforms, defines=AREA):
    return probe(gl, FILES, expression, inputs, uniforms=uniforms, defines=defines)


@pytest.mark.parametrize("area", [False, True])
@pytest.mark.parametrize("azimuth_deg", [0.0, 123.0, -77.0])
def test_rays_through_places(gl, rng, azimuth_deg, area):
    view, uniforms = camera_of(640, azimuth_deg)
    place = rng.uniform((0.0, 0.0), (640.0, 320.0), (2000, 2)).astype(np.float32).astype(float)
    got = ask(gl, "rayThrough(Camera(size, basis), place)", {"place": place}, uniforms,
              {**AREA, "PIXEL_AREA": area})[:, :3]  # fmt: skip
    exact, _ = view.rays_through(place[:, 0], 320.0 - place[:, 1])
    np.testing.assert_allclose(got, exact, rtol=0.0, atol=6e-7)


def quadrature(view, columns, rows, count=400):
    """Directions over pixels whose centres are given, and their solid angles: (n, count², …)."""
    x, y = np.meshgrid(
        (np.arange(count) + 0.5) / count - 0.5, (np.arange(count) + 0.5) / count - 0.5
    )
    rays, shares = [], []
    for column, row in zip(columns, rows, strict=True):
        ray, share = view.rays_through(column + x.ravel(), row + y.ravel())
        rays.append(ray)
        shares.append(share / share.sum())
    return np.array(rays), np.array(shares)


def test_a_pixels_ray_and_extents_are_those_of_its_solid_angle(gl):
    """From the equator to the triangle at the pole, in pixels of 2 degrees."""
    view, uniforms = camera_of(180)
    rows = np.array([0.5, 1.5, 2.5, 7.5, 20.5, 44.5, 60.5, 88.5, 89.5])
    columns = np.full(len(rows), 31.5)
    rays, shares = quadrature(view, columns, rows)
    middle = np.sum(shares[..., None] * rays, axis=1)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    place = np.stack([columns, 90.0 - rows], axis=1)
    got = ask(gl, "pixelRay(Camera(size, basis), place)", {"place": place}, uniforms)[:, :3]
    side = np.pi / 90.0
    np.testing.assert_allclose(got, middle, rtol=0.0, atol=1e-3 * side)
    extents = ask(gl, "pixelExtents(Camera(size, basis), ray)", {"ray": middle}, uniforms)[:, :2]
    right = np.stack([middle[:, 1], -middle[:, 0], 0.0 * middle[:, 0]], axis=1)
    right /= np.linalg.norm(right, axis=1)[:, None]
    for k, axis in enumerate((right, np.cross(right, middle))):
        aside = np.sum(rays * axis[:, None], axis=2)
        mean = np.sum(shares * aside, axis=1)
        wide = np.sqrt(12.0 * np.sum(shares * (aside - mean[:, None]) ** 2, axis=1))
        np.testing.assert_allclose(extents[:, k], wide, rtol=3e-3)


@pytest.mark.parametrize("row", [0.5, 3.5, 44.5, 70.5, 89.5])
def test_even_places_have_even_solid_angles(gl, row):
    """Below a place lies the share of the pixel's zone that lies below in the square."""
    _, uniforms = camera_of(180)
    at = np.stack([np.linspace(-0.5, 0.5, 41), np.linspace(-0.5, 0.5, 41)], axis=1)
    place = np.broadcast_to([10.5, 90.0 - row], at.shape)
    got = ask(gl, "evenPlace(pixelRays(Camera(size, basis), place), at)",
              {"place": place, "at": at}, uniforms)[:, :2]  # fmt: skip
    np.testing.assert_allclose(got[:, 0], at[:, 0], atol=1e-6)
    sine = np.sin(np.pi * ((90.0 - row + got[:, 1]) / 90.0 - 0.5))
    ends = np.sin(np.pi * ((90.0 - row + np.array([-0.5, 0.5])) / 90.0 - 0.5))
    below = (sine - ends[0]) / (ends[1] - ends[0])
    np.testing.assert_allclose(below, at[:, 1] + 0.5, atol=2e-3)
