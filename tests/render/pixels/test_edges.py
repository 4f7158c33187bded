"""Blocks of pixels at the edges of the rain."""

import numpy as np
import pytest

from rtbow.physics.geometry import box_span
from rtbow.render.edges import BLOCK, edge_blocks, rectangles
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of

BOX = np.array([[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]])
CAMERAS = (
    {},
    {"fov_deg": 140.0, "altitude_deg": 60.0},
    {"azimuth_deg": 120.0, "altitude_deg": -20.0},
    {"position_m": (0.0, 600.0, 500.0)},
    {"position_m": (0.0, 0.0, 0.0), "altitude_deg": 0.0},
    {"position_m": (4000.0, 600.0, 2500.0), "azimuth_deg": 270.0, "altitude_deg": -25.0},
)


def lengths(view, finer=1):
    """Length of rain through the middles of pixels, cut into finer ones."""
    width, height = view.size_px
    y, x = (np.indices((height * finer, width * finer)).reshape(2, -1) + 0.5) / finer
    entry, leave = box_span(view.eye_m, view.rays_through(x, y)[0], BOX)
    return np.maximum(leave - entry, 0.0).reshape(height * finer, width * finer)


@pytest.mark.parametrize("camera", CAMERAS)
def test_elsewhere_a_pixels_centre_stands_for_its_mean(camera):
    view = view_of(Camera(size_px=(64, 36), **camera))
    centre, finer = lengths(view), lengths(view, 8)
    mean = finer.reshape(36, 8, 64, 8).mean(axis=(1, 3))
    edges = np.kron(edge_blocks(view, BOX), np.ones((BLOCK, BLOCK)))[::-1][-36:, :64] > 0.0
    # Blocks count from below, and the picture fills them.
    assert np.abs(mean - centre)[~edges].max(initial=0.0) < 0.02 * max(centre.max(), 1.0)
    assert np.all((mean > 0.0)[~edges] == (centre > 0.0)[~edges])


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.6), (0.0, 600.0, 500.0), (100.0, 500.0, -300.0)])
@pytest.mark.parametrize("width", [64, 200])
def test_so_it_does_in_a_panorama(width, place):
    view = view_of(Camera(size_px=(width, width // 2), position_m=place, projection="panorama"))
    centre, finer, height = lengths(view), lengths(view, 8), width // 2
    mean = finer.reshape(height, 8, width, 8).mean(axis=(1, 3))
    edges = np.kron(edge_blocks(view, BOX), np.ones((BLOCK, BLOCK)))[::-1][-height:, :width] > 0.0
    assert np.abs(mean - centre)[~edges].max(initial=0.0) < 0.02 * max(centre.max(), 1.0)
    assert np.all((mean > 0.0)[~edges] == (centre > 0.0)[~edges])


def test_most_of_a_panorama_has_none():
    view = view_of(Camera(projection="panorama", size_px=(1280, 640)))
    assert 0.0 < edge_blocks(view, BOX).mean() < 0.1


def test_most_of_a_picture_has_none():
    view = view_of(Camera(size_px=(640, 360)))
    assert 0.0 < edge_blocks(view, BOX).mean() < 0.1


def test_a_lamps_surroundings_count():
    view = view_of(Camera(size_px=(64, 36), position_m=(0.0, 600.0, 500.0), altitude_deg=0.0))
    assert not edge_blocks(view, BOX).any()
    found = edge_blocks(view, BOX, np.array([0.0, 700.0, 500.0]))
    row, column = 18 // BLOCK, 32 // BLOCK
    assert found[row, column]
    assert not found[0, 0]


def test_rectangles_cover_each_block_once(rng):
    for size_px in ((64, 36), (61, 33)):
        rows, columns = -(-size_px[1] // BLOCK), -(-size_px[0] // BLOCK)
        mask = rng.random((rows, columns)) < 0.4
        covered = np.zeros((rows * BLOCK, columns * BLOCK), dtype=int)
        for left, bottom, right, top in 0.5 * rectangles(mask, size_px) + 0.5:
            x = slice(round(left * size_px[0]), round(right * size_px[0]))
            covered[round(bottom * size_px[1]) : round(top * size_px[1]), x] += 1
        expected = np.kron(mask, np.ones((BLOCK, BLOCK), dtype=int))
        inside = np.s_[: size_px[1], : size_px[0]]
        np.testing.assert_array_equal(covered[inside], expected[inside])
    assert len(rectangles(np.ones((9, 16), dtype=bool), (64, 36))) == 1
    assert rectangles(np.zeros((9, 16), dtype=bool), (64, 36)).shape == (0, 4)
