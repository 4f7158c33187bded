"""All directions in one picture: rays, solid angles and filters, against closed forms."""

import numpy as np
import pytest

import rtbow
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of
from rtbow.world.report import scene_report
from rtbow.world.world import resolve


def towards(azimuth_deg, altitude_deg):
    """East, north, up of azimuths clockwise from north and altitudes."""
    azimuth, altitude = np.broadcast_arrays(np.radians(azimuth_deg), np.radians(altitude_deg))
    level = np.cos(altitude)
    return np.stack([level * np.sin(azimuth), level * np.cos(azimuth), np.sin(altitude)], axis=-1)


def panorama(width=64, **values):
    return view_of(Camera(projection="panorama", size_px=(width, width // 2), **values))


@pytest.mark.parametrize("azimuth_deg", [0.0, 70.0, -135.0])
def test_columns_are_azimuths_and_rows_altitudes(azimuth_deg):
    rays = panorama(8, azimuth_deg=azimuth_deg).pixel_directions()
    assert rays.shape == (4, 8, 3)
    columns = azimuth_deg + np.array([-157.5, -112.5, -67.5, -22.5, 22.5, 67.5, 112.5, 157.5])
    rows = np.array([67.5, 22.5, -22.5, -67.5])
    expected = towards(columns[None, :], rows[:, None])
    np.testing.assert_allclose(rays, expected, rtol=0.0, atol=1e-15)
    some = panorama(8, azimuth_deg=azimuth_deg).pixel_directions(slice(1, 3))
    np.testing.assert_array_equal(some, rays[1:3])


def test_edges_are_behind_above_and_below():
    view = panorama(64, azimuth_deg=30.0)
    middle, left, right, top, bottom = view.rays_through(
        np.array([32.0, 0.0, 64.0, 7.0, 50.0]), np.array([16.0, 16.0, 16.0, 0.0, 32.0])
    )[0]
    np.testing.assert_allclose(middle, towards(30.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(left, towards(210.0, 0.0), atol=1e-15)
    np.testing.assert_allclose(right, towards(210.0, 0.0), atol=1e-15)
    np.testing.assert_allclose([top, bottom], [[0, 0, 1], [0, 0, -1]], atol=1e-15)


def test_solid_angles_are_those_of_zones():
    view = panorama(64)
    row = np.arange(32) + 0.5
    _, shares = view.rays_through(np.full(32, 3.0), row)
    edges = np.sin(np.pi * (0.5 - np.arange(33) / 32.0))  # Archimedes
    zones = 2.0 * np.pi * (edges[:-1] - edges[1:])
    assert zones.sum() == pytest.approx(4.0 * np.pi)
    np.testing.assert_allclose(shares / shares.sum(), zones / zones.sum(), rtol=1e-12)


def test_places_lead_back(rng):
    view = panorama(64, azimuth_deg=200.0)
    columns, rows = rng.uniform(0.0, 64.0, 500), rng.uniform(0.0, 32.0, 500)
    rays, _ = view.rays_through(columns, rows)
    back = view.places_of(7.0 * rays)
    np.testing.assert_allclose(back, [columns, rows], atol=1e-9)
    assert view.shows(rng.normal(size=(500, 3))).all()
    assert view.angles_from(np.array([0.0, 0.6, 0.8])) == (0.0, np.pi)


@pytest.mark.parametrize("block", [4, 16])
@pytest.mark.parametrize("width", [64, 200, 640])
def test_bounds_of_blocks_hold_their_rays(rng, width, block):
    view = panorama(width, azimuth_deg=50.0)
    across = rng.integers(0, -(-width // block), 400)
    down = rng.integers(0, -(-width // 2 // block), 400)
    down[:100], down[100:200] = 0, -(-width // 2 // block) - 1
    rays, _ = view.rays_through((across + 0.5) * block, (down + 0.5) * block)
    pixel, wide = view.block_extents(rays, block)
    for _ in range(40):
        columns = across * block + rng.uniform(-0.5, block + 0.5, 400)
        rows = down * block + rng.uniform(-0.5, block + 0.5, 400)
        inside = (rows > 0.0) & (rows < width / 2)
        within, _ = view.rays_through(columns[inside], rows[inside])
        assert np.all(np.abs(within - rays[inside]) <= 0.5 * wide[inside] + 1e-12)
        assert np.all(view.ray_extents(within) <= pixel[inside] + 1e-12)


def test_extents_of_rays_are_differences(rng):
    view = panorama(6400, azimuth_deg=50.0)
    columns, rows = rng.uniform(0.0, 6400.0, 100), rng.uniform(50.0, 3150.0, 100)
    ends = [view.rays_through(columns + x, rows + y)[0] for x, y in
            ((0.5, 0.0), (-0.5, 0.0), (0.0, 0.5), (0.0, -0.5))]  # fmt: skip
    expected = np.hypot(ends[0] - ends[1], ends[2] - ends[3])
    got = view.ray_extents(view.rays_through(columns, rows)[0])
    np.testing.assert_allclose(got, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("polarizer_deg", [0.0, 30.0, -60.0, 90.0])
def test_a_filter_is_that_of_a_lens_turned_there(rng, polarizer_deg):
    """In the middle of a picture a lens's horizontal is level, wherever it looks."""
    light, view = rng.normal(size=3), panorama(polarizer_deg=polarizer_deg)
    for azimuth, altitude in ((0.0, 0.0), (70.0, 35.0), (200.0, -50.0), (-90.0, 89.0)):
        lens = view_of(
            Camera(azimuth_deg=azimuth, altitude_deg=altitude, polarizer_deg=polarizer_deg)
        )
        ray = towards(azimuth, altitude)[None]
        np.testing.assert_allclose(
            view.perpendicular_share(light, ray), lens.perpendicular_share(light, ray), atol=1e-12
        )
        np.testing.assert_allclose(view.probes(ray), lens.probes(ray), atol=1e-12)


def test_a_turned_panorama_needs_no_other_tables():
    before, after = panorama(64), panorama(32, azimuth_deg=90.0)
    assert after.shows_no_more_than(before)
    assert not panorama(64, polarizer_deg=0.0).shows_no_more_than(before)
    lens = view_of(Camera())
    assert not before.shows_no_more_than(lens)
    assert not lens.shows_no_more_than(before)


def test_what_is_said_of_it():
    scene = rtbow.load_scene("curtain", {"camera.projection": "panorama"})
    assert "all directions, 0.281 deg a pixel, 1280 x 640 px" in scene_report(scene)
    (note,) = (one for one in resolve(scene).notes if "panorama" in one)
    assert note.endswith(
        "altitude_deg, fov_deg of its camera left out; size_px = [1280, 640] instead of [1280, 720]"
    )
    sized = {"camera.projection": "panorama", "camera.size_px": [64, 32]}
    (note,) = resolve(rtbow.load_scene("curtain", sized)).notes
    assert note.endswith("altitude_deg, fov_deg of its camera left out")
    plain = rtbow.make_scene(
        camera={"projection": "panorama"}, light={}, droplets={
            "around_m": [9, 9], "radius": {"distribution": "constant", "radius_um": 9},
            "density": {"number_per_m3": 9},
        },
    )  # fmt: skip
    assert not resolve(plain).notes
