"""Directions, points and curves in the picture, against a pinhole camera and dense points."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rtbow.scene.model import Camera
from rtbow.scene.text.file import load_scene
from rtbow.view.picture.projection import View, azimuth_altitude_deg, part_at, part_views
from rtbow.world.camera.resolve import pixel_directions
from textbook import pinhole
from textbook import towards as unit

SIZE = (800, 450)


def view_of(azimuth=0.0, altitude=0.0, fov=80.0, columns=None, position=(0.0, 0.0, 0.0)):
    camera = Camera(
        azimuth_deg=azimuth, altitude_deg=altitude, fov_deg=fov, size_px=(1600, 900),
        position_m=position,
    )  # fmt: skip
    return View(camera, SIZE, columns)


def inside(view, pixels, margin=0.0):
    left, right = view.columns or (0.0, SIZE[0])
    x, y = pixels[..., 0], pixels[..., 1]
    seen = (x >= left + margin) & (x <= right - margin) & (y >= margin) & (y <= SIZE[1] - margin)
    return seen


def distance_to(lines, points):
    """Distance of points (n, 2) from the nearest of some lines."""
    best = np.full(len(points), np.inf)
    for line in lines:
        for a, b in itertools.pairwise(line):
            along = (points - a) @ (b - a) / max((b - a) @ (b - a), 1e-12)
            nearest = a + np.clip(along, 0.0, 1.0)[:, None] * (b - a)
            best = np.minimum(best, np.linalg.norm(points - nearest, axis=1))
    return best


def dense(lines):
    """Points along lines, a pixel apart at most."""
    found = [np.empty((0, 2))]
    for line in lines:
        for a, b in itertools.pairwise(line):
            share = np.linspace(0.0, 1.0, 2 + int(np.linalg.norm(b - a)))[:, None]
            found.append(a + share * (b - a))
    return np.concatenate(found)


def assert_same_curve(view, lines, vectors, within=0.5):
    """Lines are those that dense vectors (n, 3) from the eye make, and no others."""
    for line in lines:
        assert line.shape[0] >= 2
        assert line.shape[1] == 2
    drawn = dense(lines)
    assert inside(view, drawn, -1e-6).all()
    pixels = pinhole(view.camera, vectors, SIZE)
    # A curve that all but touches a side may have its chords beyond.
    seen = pixels[inside(view, pixels, within)]
    if len(seen):
        assert len(lines) >= 1
        assert distance_to(lines, seen).max() < within
    if len(drawn):
        # The dense points are at most a pixel apart where they are seen.
        near = pixels[inside(view, pixels, -60.0)]
        gaps = np.linalg.norm(drawn[::7, None] - near[None], axis=-1).min(axis=1)
        assert gaps.max() < within + 1.5


@pytest.mark.parametrize("altitude", [-90.0, -35.0, 0.0, 60.0, 90.0])
@pytest.mark.parametrize("fov", [0.5, 40.0, 150.0, 179.0])
def test_pixels_are_a_pinhole_cameras(altitude, fov, rng):
    view = view_of(123.0, altitude, fov)
    vectors = np.concatenate(
        [
            rng.normal(size=(300, 3)),
            unit(123.0, altitude) + 0.02 * fov / 80 * rng.normal(size=(300, 3)),
        ]
    )
    pixels, seen = view.pixels(vectors)
    expected = pinhole(view.camera, vectors, SIZE)
    np.testing.assert_allclose(pixels, expected, rtol=1e-9, atol=1e-7)
    np.testing.assert_array_equal(seen, inside(view, expected))
    assert seen.any()


def test_directions_are_the_cameras():
    camera = Camera(azimuth_deg=-50.0, altitude_deg=33.0, fov_deg=95.0, size_px=(40, 30))
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    got = View(camera, (40, 30)).directions(np.stack([x, y], axis=-1))
    np.testing.assert_allclose(got, pixel_directions(camera), atol=1e-14)
    # Shown twice as large, the same places are the same directions.
    large = View(camera, (80, 60)).directions(np.stack([2.0 * x, 2.0 * y], axis=-1))
    np.testing.assert_allclose(large, got, atol=1e-14)


def test_columns_of_a_part_are_what_is_seen():
    view = view_of(columns=(200.0, 500.0))
    vectors = View(view.camera, SIZE).directions(np.array([[199.0, 9], [201.0, 9], [501.0, 9]]))
    assert view.pixels(vectors)[1].tolist() == [False, True, False]


TURNS = np.linspace(0.0, 2.0 * np.pi, 40_001)


def circle(axis, radius):
    """Points of a circle about an axis, by rotation."""
    start = Rotation.from_rotvec(radius * np.cross(axis, [0.36, 0.48, 0.8]) / np.linalg.norm(
        np.cross(axis, [0.36, 0.48, 0.8]))).apply(axis)  # fmt: skip
    return Rotation.from_rotvec(TURNS[:, None] * axis).apply(start)


CIRCLES = {
    "primary": (unit(0.0, -20.0), 42.4),
    "secondary": (unit(0.0, -20.0), 51.0),
    "horizon": (unit(0.0, 90.0), 90.0),
    "whole": (unit(2.0, 1.0), 15.0),
    "small": (unit(20.0, 5.0), 0.3),
    "about the sun": (unit(180.0, 20.0), 137.6),
    "behind": (unit(180.0, 0.0), 30.0),
    "upright": (unit(90.0, 0.0), 90.0),
    "all but a point": (unit(180.0, 0.0), 179.9),
}


@pytest.mark.parametrize("name", CIRCLES)
@pytest.mark.parametrize(
    ("azimuth", "altitude", "fov"),
    [(0, 0, 84), (10, 22.5, 84), (-30, 60, 120), (0, 22.4, 1), (90, 0, 160), (0, -90, 100)],
)
def test_circles(name, azimuth, altitude, fov):
    axis, radius = CIRCLES[name]
    view = view_of(azimuth, altitude, fov)
    lines = view.circle(axis, np.radians(radius))
    vectors = circle(axis, np.radians(radius))
    if fov == 1:  # more points where the picture is narrow
        place = np.argmax(vectors @ unit(azimuth, altitude))
        turn = TURNS[place] + 1e-2 * np.linspace(-4.0, 4.0, 40_001)
        vectors = Rotation.from_rotvec(turn[:, None] * axis).apply(vectors[0])
    assert_same_curve(view, lines, vectors)


@pytest.mark.slow
@settings(max_examples=100, deadline=None)
@given(
    st.floats(-180, 180), st.floats(-90, 90), st.floats(20, 170),
    st.floats(-180, 180), st.floats(-90, 90), st.floats(0.5, 179),
)  # fmt: skip
def test_any_circle(azimuth, altitude, fov, axis_azimuth, axis_altitude, radius):
    view = view_of(azimuth, altitude, fov)
    axis = unit(axis_azimuth, axis_altitude)
    lines = view.circle(axis, np.radians(radius))
    assert_same_curve(view, lines, circle(axis, np.radians(radius)))
    assert sum(map(len, lines)) < 400


def test_a_circle_that_passes_by_the_widest_of_pictures():
    # Worst 0.18 px; 0.5 where pieces that reach behind the picture are left as they are.
    view, axis = view_of(102.4, -87.57, 178.995), unit(163.9, 32.13)
    pixels = pinhole(view.camera, circle(axis, np.radians(35.63)), SIZE)
    lines = view.circle(axis, np.radians(35.63))
    assert distance_to(lines, pixels[inside(view, pixels, 0.5)]).max() < 0.3


def test_a_piece_may_bend_into_the_picture():
    # A 64th of the circle is 5.6 degrees, and the middle of one is its top: the rest is below.
    top = np.pi / 64.0

    def path(turn):
        side, height = np.sin(turn - top), np.cos(turn - top)
        return np.stack([side, 1.2 * np.ones_like(turn), height], axis=1) / np.sqrt(2.44)

    view = view_of(0.0, np.degrees(np.arctan(1.0 / 1.2)), 0.02)
    lines = view.curve(path, 0.0, 2.0 * np.pi)
    assert_same_curve(view, lines, path(top + np.linspace(-1e-3, 1e-3, 20_001)))
    assert len(lines) == 1


def test_circles_are_seen_in_pieces_where_they_leave_the_picture():
    # The primary at 84 degrees across: one arch. From above, its sides alone.
    axis = unit(0.0, -20.0)
    assert len(view_of(0.0, 22.5, 84.0).circle(axis, np.radians(42.4))) == 1
    assert len(view_of(0.0, -20.0, 95.0).circle(axis, np.radians(42.4))) == 2
    closed = view_of(0.0, -20.0, 140.0).circle(axis, np.radians(42.4))
    assert len(closed) == 1
    np.testing.assert_allclose(closed[0][0], closed[0][-1], atol=1e-6)


def test_a_part_sees_its_columns_alone():
    view = view_of(0.0, 0.0, 100.0, columns=(400.0, 650.0))
    lines = view.circle(unit(0.0, 0.0), np.radians(30.0))
    assert_same_curve(view, lines, circle(unit(0.0, 0.0), np.radians(30.0)))


def edge(a, b):
    return np.asarray(a, float) + np.linspace(0.0, 1.0, 60_001)[:, None] * (
        np.asarray(b, float) - np.asarray(a, float)
    )


EDGES = {
    "in front": ([-10.0, 50.0, -5.0], [10.0, 50.0, 5.0]),
    "from in front to behind": ([5.0, 40.0, 3.0], [5.0, -60.0, 3.0]),
    "over the eye": ([0.0, -30.0, 2.0], [0.0, 30.0, 2.0]),
    "behind": ([-5.0, -10.0, 0.0], [5.0, -10.0, 0.0]),
    "through the corner": ([-80.0, 60.0, 20.0], [10.0, 60.0, 60.0]),
    "across everything": ([-1e7, 1.0, 0.3], [1e7, 1.0, 0.3]),
    "beside": ([-90.0, 10.0, 0.0], [-70.0, 10.0, 5.0]),
}


@pytest.mark.parametrize("name", EDGES)
@pytest.mark.parametrize("position", [(0.0, 0.0, 0.0), (3.0, -2.0, 1.5)])
def test_edges(name, position):
    view = view_of(8.0, 12.0, 90.0, position=position)
    a, b = EDGES[name]
    lines = view.chain(np.array([a, b]))
    points = edge(a, b)
    if name == "across everything":
        points = edge([-20.0, 1.0, 0.3], [20.0, 1.0, 0.3])
    assert_same_curve(view, lines, points - np.array(position), within=0.01)
    for line in lines:
        assert len(line) == 2  # straight lines are seen as straight


def test_an_edge_that_meets_the_eye_has_no_wild_end():
    lines = view_of().chain(np.array([[0.0, 10.0, 0.0], [0.0, 0.0, 0.0], [0.0, -10.0, 0.0]]))
    assert np.isfinite(np.concatenate([np.empty((0, 2)), *lines])).all()
    assert view_of().chain(np.array([[1.0, 1.0, 1.0]])) == []


def test_chains_stay_joined():
    corners = np.array([[-5.0, 50.0, 0.0], [0.0, 50.0, 5.0], [5.0, 50.0, 0.0], [500.0, 50.0, 0.0]])
    lines = view_of().chain(corners)
    assert [len(line) for line in lines] == [4]
    np.testing.assert_allclose(lines[0][:3], pinhole(view_of().camera, corners[:3], SIZE))
    assert lines[0][3] == pytest.approx((SIZE[0], lines[0][0][1]))
    outside = np.array([[-5.0, 50.0, 0.0], [0.0, 50.0, 500.0], [5.0, 50.0, 0.0]])
    assert [len(line) for line in view_of().chain(outside)] == [2, 2]


def test_parts_share_the_view():
    scene = load_scene("curtain", {"compare": {"split": 0.25, "right": {"camera.fov_deg": 40.0}}})
    (left, first), (right, second) = part_views(scene, (640, 360))
    assert (left.camera.fov_deg, right.camera.fov_deg) == (84.0, 40.0)
    assert first.columns == (0.0, 160.0)
    assert second.columns == (160.0, 640.0)
    assert part_at(scene, (640, 360), (159.9, 5.0))[0] is left
    assert part_at(scene, (640, 360), (160.1, 5.0))[0] is right
    ((whole, view),) = part_views(load_scene("curtain"), (640, 360))
    assert view.camera is whole.camera
    assert view.columns == (0.0, 640.0)


@pytest.mark.parametrize(("azimuth", "altitude"), [(0, 0), (170, -80), (-90, 45), (12.5, 89.0)])
def test_angles_of_a_vector(azimuth, altitude):
    got = azimuth_altitude_deg(7.0 * unit(azimuth, altitude))
    assert got == pytest.approx((azimuth, altitude), abs=1e-9)
