"""Moving the camera: what is grabbed stays under the cursor, and a scene's ranges are kept."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtbow.scene.model import Camera
from rtbow.scene.text.file import load_scene
from rtbow.view.picture import navigate
from textbook import pinhole
from textbook import towards as unit

VIEW = (900, 500)


def pixel_of(camera, vector):
    return pinhole(camera, vector, VIEW)


def camera(azimuth=30.0, altitude=10.0, fov=70.0):
    return Camera(azimuth_deg=azimuth, altitude_deg=altitude, fov_deg=fov, size_px=(1800, 1000))


def valid(moved):
    assert Camera.model_validate(moved.model_dump()) == moved
    assert -180.0 <= moved.azimuth_deg <= 180.0
    return moved


def drag(before, dx, dy, at=(450.0, 250.0)):
    """Turn a camera as a drag of the mouse from a point does."""
    grabbed = navigate.View(before, VIEW).directions(np.array(at))
    return navigate.hold(before, grabbed, (at[0] + dx, at[1] + dy), VIEW)


def test_a_drag_to_the_right_turns_left_and_one_down_raises():
    moved = valid(drag(camera(), 10.0, 20.0))
    assert moved.azimuth_deg < 30.0
    assert moved.altitude_deg > 10.0


@pytest.mark.parametrize("altitude", [-60.0, -20.0, 0.0, 45.0, 65.0])
@pytest.mark.parametrize("grabbed", [(450.0, 250.0), (30.0, 40.0), (890.0, 480.0)])
def test_what_is_grabbed_stays_under_the_cursor(altitude, grabbed):
    before = camera(altitude=altitude)
    held = navigate.View(before, VIEW).directions(np.array(grabbed))
    at = pixel_of(before, held)
    np.testing.assert_allclose(at, grabbed, atol=1e-9)
    for dx, dy in ((3.0, 0.0), (0.0, 5.0), (-8.0, 4.0), (-2.0, -3.0)):
        moved = valid(drag(before, dx, dy, grabbed))
        np.testing.assert_allclose(pixel_of(moved, held) - at, (dx, dy), atol=1e-6)


def test_the_zenith_is_the_end():
    moved = camera(altitude=80.0)
    for _ in range(100):
        moved = valid(drag(moved, 0.0, 30.0))
    assert moved.altitude_deg == 90.0
    for _ in range(100):
        moved = valid(drag(moved, 0.0, -30.0))
    assert moved.altitude_deg == -90.0
    assert moved.azimuth_deg == pytest.approx(30.0, abs=1e-6)


def test_azimuths_go_round():
    moved = camera(azimuth=179.9)
    azimuths = []
    for _ in range(400):
        moved = valid(drag(moved, -12.0, 0.0))
        azimuths.append(moved.azimuth_deg)
    steps = (np.diff(azimuths) + 180.0) % 360.0 - 180.0
    assert np.all(steps > 0.0)
    assert min(azimuths) < -170.0
    assert max(azimuths) > 170.0


@settings(max_examples=300, deadline=None)
@given(
    st.floats(-180, 180), st.floats(-90, 90), st.floats(1, 150),
    st.floats(0, 900), st.floats(0, 500), st.floats(-900, 900), st.floats(-500, 500),
)  # fmt: skip
def test_no_drag_leaves_the_range(azimuth, altitude, fov, x, y, dx, dy):
    before = camera(azimuth, altitude, fov)
    moved = valid(drag(before, dx, dy, (x, y)))
    assert np.isfinite([moved.azimuth_deg, moved.altitude_deg]).all()
    back = drag(before, 0.0, 0.0, (x, y))
    # Where the cursor is on a pole's other side there are two cameras; none turns without a drag.
    assert back.altitude_deg == pytest.approx(before.altitude_deg, abs=1e-5)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ((1, 0, 0), (0.0, -1.0, 0.0)),  # looking east, the right is south
        ((0, 1, 0), (np.cos(np.radians(30.0)), 0.0, np.sin(np.radians(30.0)))),
        ((0, 0, -1), (0.0, 0.0, -1.0)),
        ((-1, 0, 0), (0.0, 1.0, 0.0)),
    ],
)
def test_flying_goes_where_the_camera_looks(keys, expected):
    start = Camera(position_m=(5.0, 6.0, 7.0), azimuth_deg=90.0, altitude_deg=30.0)
    moved = valid(navigate.fly(start, *keys, seconds=0.5, speed_m_s=40.0))
    way = np.array(moved.position_m) - start.position_m
    np.testing.assert_allclose(way, 20.0 * np.array(expected), atol=1e-12)


def test_two_keys_are_not_faster_and_half_a_key_is_slower():
    for keys, speed in (((1, 1, 0), 1.0), ((1, 1, 1), 1.0), ((0, 0.5, 0), 0.5), ((0, 0, 0), 0.0)):
        moved = navigate.fly(Camera(position_m=(0.0, 0.0, 0.0)), *keys, 1.0, 10.0)
        assert np.linalg.norm(moved.position_m) == pytest.approx(10.0 * speed)


def test_flying_ends_where_scenes_do():
    far = Camera(position_m=(9_999_990.0, 0.0, 0.0), azimuth_deg=90.0, altitude_deg=0.0)
    moved = valid(navigate.fly(far, 0, 1, 0, 10.0, 1000.0))
    assert moved.position_m[0] == 1e7
    assert valid(navigate.fly(moved, 0, -1, 0, 1.0, 1000.0)).position_m[0] == 1e7 - 1000.0


def test_a_click_enlarges_by_a_tenth():
    zoomed = valid(navigate.zoom(camera(), 1.0))
    vector = unit(31.0, 10.5)
    before, after = (pixel_of(c, vector) - (450.0, 250.0) for c in (camera(), zoomed))
    np.testing.assert_allclose(after, 1.1 * before, rtol=1e-9)
    assert navigate.zoom(zoomed, -1.0).fov_deg == pytest.approx(70.0)
    twice = navigate.zoom(navigate.zoom(camera(), 0.25), 0.75)
    assert twice.fov_deg == pytest.approx(zoomed.fov_deg)


def test_zoom_has_ends_but_leaves_a_scenes_own():
    assert valid(navigate.zoom(camera(), 1000.0)).fov_deg == 1.0
    assert valid(navigate.zoom(camera(), -1000.0)).fov_deg == 150.0
    for own in (0.2, 175.0):
        scenes = camera(fov=own)
        for clicks in (-1.0, 0.0, 1.0):
            fov = valid(navigate.zoom(scenes, clicks)).fov_deg
            assert min(own, 1.0) <= fov <= max(own, 150.0)
        assert navigate.zoom(scenes, 0.0).fov_deg == pytest.approx(own)


def test_zoom_leaves_what_is_under_the_cursor():
    at = (200.0, 90.0)
    vector = navigate.View(camera(), VIEW).directions(np.array(at))
    for clicks in (-2.0, 1.0, 5.0):
        moved = valid(navigate.zoom(camera(), clicks, VIEW, at))
        np.testing.assert_allclose(pixel_of(moved, vector), at, atol=1e-6)


@pytest.mark.parametrize(("azimuth", "altitude"), [(0, 0), (-170, 40), (180, -5), (77, 89.9)])
def test_towards_centres(azimuth, altitude):
    moved = valid(navigate.towards(camera(), 3.0 * unit(azimuth, altitude)))
    np.testing.assert_allclose(pixel_of(moved, unit(azimuth, altitude)), (450.0, 250.0), atol=1e-6)


def test_towards_the_zenith_keeps_the_azimuth():
    moved = valid(navigate.towards(camera(), np.array([0.0, 0.0, 2.0])))
    assert (moved.azimuth_deg, moved.altitude_deg) == (30.0, 90.0)


def test_antisolar_of_a_sun():
    # default.toml: the sun in the south at 20 degrees.
    np.testing.assert_allclose(navigate.antisolar(load_scene("curtain")), unit(0.0, -20.0))


def test_antisolar_of_a_lamp():
    # street-lamp.toml: eye (0, 7, 1.5), lamp (0, 0, 6).
    away = navigate.antisolar(load_scene("street-lamp"))
    np.testing.assert_allclose(away, np.array([0.0, 7.0, -4.5]) / np.hypot(7.0, 4.5))


def test_antisolar_of_an_eye_in_its_lamp():
    scene = load_scene("street-lamp", {"camera.position_m": [0.0, 0.0, 6.0]})
    np.testing.assert_allclose(navigate.antisolar(scene), unit(0.0, 8.0))


def test_the_sun_comes_before_lamps():
    lights = [load_scene("street-lamp").light[0], load_scene("curtain").light[0]]
    scene = load_scene("curtain").model_copy(update={"light": tuple(lights)})
    np.testing.assert_allclose(navigate.antisolar(scene), unit(0.0, -20.0))


def test_cruising_scales_with_the_scene():
    box = np.array([[-60.0, 8.0, 0.0], [60.0, 80.0, 30.0]])
    scene = load_scene("street-lamp")
    here = navigate.cruise_m_s(scene, box)
    assert 2.0 < here < 20.0  # through 72 m of rain in some seconds
    far = load_scene("street-lamp", {"camera.position_m": [0.0, 1080.0, 1.5]})
    assert navigate.cruise_m_s(far, box) == pytest.approx(here - 0.25 * 1.0 + 250.0)
    large = load_scene("street-lamp", {"camera.position_m": [0.0, 7000.0, 1500.0]})
    assert navigate.cruise_m_s(large, 1000.0 * box) == pytest.approx(1000.0 * here)
