"""Sky, ground and suns as the shader adds them, against the reference's rays."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.physics.light.spectrum import luminous
from rtbow.render.fast.nodes import block_for
from rtbow.world.measured.spectra import load_spectrum
from rtbow.world.world import resolve
from skies.frames import (
    CLEAR_CASES,
    HAZE,
    HAZY_CASES,
    METHODS,
    NARROW,
    SCENE,
    WATER,
    difference,
    drawn,
)

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", HAZY_CASES)
def test_hazy_frames_are_the_references(method, case):
    delta_e = difference(method, HAZY_CASES[case])
    assert delta_e.p99 < 0.5
    assert delta_e.worst < 1.2
    assert delta_e.median < 0.1  # 2 % of the light are 0.2


def test_what_haze_colours_too_differently_is_left_to_spectral():
    low = {**HAZE, "atmosphere.sky": False, "light.0.altitude_deg": 4.0}
    with rtbow.Renderer(rtbow.load_scene("uniform", {**SCENE, **low})) as renderer:
        renderer.render()
        assert renderer.method_used == "spectral"
        assert "450 nm" in renderer.unsuited


@pytest.mark.parametrize("changes", [
    {"light.0.altitude_deg": -1.5, "camera.azimuth_deg": 180.0},
    {"light.0.altitude_deg": 0.05, "droplets.box_m": [[-3e3, 2e2, 0.0], [3e3, 9e3, 9e3]]},
], ids=["shadow", "spread"])  # fmt: skip
def test_a_sun_whose_way_through_ozone_differs_is_left_to_the_reference(changes):
    scene = rtbow.load_scene("uniform", {**SCENE, **HAZE, "atmosphere.sky": False, **changes})
    with rtbow.Renderer(scene) as renderer:
        renderer.render()
        assert renderer.method_used == "reference"
        assert "light.0" in renderer.unsuited


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CLEAR_CASES)
def test_frames_are_the_references(method, case):
    delta_e = difference(method, CLEAR_CASES[case])
    assert delta_e.p99 < 0.5
    assert delta_e.worst < 1.0


def test_narrow_pictures_are_drawn_at_nodes():
    view = resolve(rtbow.load_scene("uniform", {**SCENE, **NARROW})).view
    assert block_for(view, 8) == 2
    assert block_for(resolve(rtbow.load_scene("uniform", SCENE)).view, 8) == 0


def test_a_grid_dims_what_is_behind_it():
    changes = {"droplets.extinction": True, "atmosphere.sky": True, "ground.albedo": 0.2}
    delta_e = difference("fast", changes, "shower")
    assert delta_e.p99 < 0.5
    assert delta_e.worst < 1.0


@pytest.mark.parametrize("around", [{}, {**WATER, "droplets.extinction": True}])
def test_pixels_that_the_horizon_crosses_show_both_sides(around):
    view = {"camera.pixel": "area", "camera.fov_deg": 40.0, "camera.altitude_deg": 0.3}
    changes = {**around, **view}
    sharp = {**changes, "camera.pixel": "centre", "camera.size_px": [256, 144]}
    fine = drawn("fast", sharp).reshape(18, 8, 32, 8, 3).mean(axis=(1, 3))
    means = rgb_to_xyz(drawn("fast", changes))
    assert frame_difference(means, rgb_to_xyz(fine)).delta_e.worst < 0.6


def test_it_follows_the_sun_and_the_eye():
    moved = {"light.0.altitude_deg": 11.0, "camera.position_m": [0.0, 0.0, 400.0]}
    with rtbow.Renderer(rtbow.load_scene("uniform", SCENE)) as renderer:
        renderer.render("fast")
        renderer.show(rtbow.load_scene("uniform", {**SCENE, **moved}))
        there = renderer.render("fast")
        assert renderer.method_used == "fast"
        renderer.show(rtbow.load_scene("uniform", {**SCENE, **moved, "ground.albedo": 0.9}))
        white = renderer.render("fast")
    np.testing.assert_allclose(there, drawn("fast", moved), rtol=5e-3, atol=1.0)
    assert white.sum() > 1.2 * there.sum()


def test_drops_below_the_ground_are_left_to_the_reference():
    changes = {"droplets.box_m": [[-200.0, 50.0, -300.0], [200.0, 400.0, 100.0]]}
    with rtbow.Renderer(rtbow.load_scene("uniform", {**SCENE, **changes})) as renderer:
        renderer.render()
        assert renderer.method_used == "reference"
        assert "ground" in renderer.unsuited


def test_haze_that_water_mirrors_through_a_filter_is_left_to_the_reference():
    changes = {**WATER, **HAZE, "camera.polarizer_deg": 0.0}
    with rtbow.Renderer(rtbow.load_scene("uniform", {**SCENE, **changes})) as renderer:
        renderer.render()
        assert renderer.method_used == "reference"
        assert "polarizer" in renderer.unsuited


def test_a_sky_without_a_sun_is_dark():
    frame = drawn("fast", {"camera.pixel": "centre"}, "street-lamp")
    assert np.all(np.isfinite(frame))


@pytest.mark.parametrize("disc_deg", [0.05, 0.533, 3.0])
@pytest.mark.parametrize(
    "changes",
    [
        {"camera.fov_deg": 60.0, "camera.size_px": [48, 28]},
        {"camera.fov_deg": 61.7, "camera.size_px": [48, 28], "camera.roll_deg": 30.0},
        {"camera.projection": "panorama", "camera.size_px": [160, 80]},
    ],
    ids=["lens", "rolled", "panorama"],
)
def test_a_disc_gives_its_irradiance_whatever_its_pixels_are(changes, disc_deg):
    bare = {
        "atmosphere": None, "ground.albedo": 0.0, "camera.pixel": "area",
        "light.0.angular_diameter_deg": disc_deg, "light.0.spectrum": "equal-energy",
        "light.0.irradiance_w_m2": 1.0, "light.0.altitude_deg": 63.3, "camera.azimuth_deg": 170.0,
        "droplets.box_m": [[-10.0, 90_000.0, 0.0], [10.0, 90_010.0, 10.0]],
    }  # fmt: skip
    lens = {} if "camera.projection" in changes else {"camera.altitude_deg": 60.0}
    scene = rtbow.load_scene("uniform", {**bare, **lens, **changes})
    with rtbow.Renderer(scene) as renderer:
        frame = renderer.render("fast")
    width, height = changes["camera.size_px"]
    if "camera.projection" in changes:
        edges = np.sin(0.5 * np.pi - np.pi * np.arange(height + 1) / height)
        solid = (edges[:-1] - edges[1:])[:, None] * np.full(width, 2.0 * np.pi / width)
    else:
        pixel = 2.0 * np.tan(np.radians(0.5 * changes["camera.fov_deg"])) / width
        x, y = (pixel * (np.arange(n) + 0.5 - 0.5 * n) for n in (width, height))
        solid = pixel**2 * (1.0 + x**2 + y[:, None] ** 2) ** -1.5
    lux = float((rgb_to_xyz(frame)[..., 1] * solid).sum())
    expected = luminous(load_spectrum("equal-energy").scaled(1.0))
    assert lux == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("method", METHODS)
def test_the_sun_in_the_water_is_where_a_sphere_mirrors_it(method):
    """From 10 km up the water that mirrors it leans by a degree, and its image is 2 degrees lower
    than in a plane."""
    bare = {
        "atmosphere": None, "ground": {"water": True}, "camera.position_m": [0.0, 0.0, 10_000.0],
        "light.0.altitude_deg": 3.0, "light.0.angular_diameter_deg": 1.0,
        "camera.size_px": [32, 160], "camera.fov_deg": 1.6, "camera.altitude_deg": -5.0,
        "camera.azimuth_deg": 180.0,
    }  # fmt: skip
    frame = rgb_to_xyz(drawn(method, bare))[..., 1].astype(np.float64)
    half = 5.0 * np.tan(np.radians(0.8))
    down = np.degrees(np.arctan(half * ((np.arange(160) + 0.5) / 80.0 - 1.0)))
    found = 5.0 + (down @ frame).sum() / frame.sum()
    # By bisection on the angle at the Earth's centre: what the eye sees falls as steeply on the
    # water there as the sun's light does.
    near, far = 0.0, np.radians(3.0)
    radius = 6_371_000.0
    for _ in range(50):
        turn = 0.5 * (near + far)
        sine, cosine = radius * np.sin(turn), radius * np.cos(turn)
        dip = np.arctan2(radius + 10_000.0 - cosine, sine)
        near, far = (turn, far) if dip - turn > np.radians(3.0) + turn else (near, turn)
    assert 4.5 < np.degrees(dip) < 5.5
    assert found == pytest.approx(np.degrees(dip), abs=0.03)


def test_an_eye_far_above_the_air_is_left_to_the_reference():
    high = {"camera.position_m": [0.0, 0.0, 40_000.0], "camera.size_px": [4, 3]}
    with rtbow.Renderer(rtbow.load_scene("uniform", {**SCENE, **high})) as renderer:
        renderer.render()
        assert renderer.method_used == "reference"
        assert "15000 m" in renderer.unsuited
