"""Sky, ground and suns as the shader adds them, against the reference's rays."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import XYZ_TO_RGB

pytestmark = pytest.mark.slow

SCENE = {
    "camera.size_px": [32, 18], "camera.fov_deg": 100.0, "camera.altitude_deg": 12.0,
    "render.wavelength_step_nm": 5.0, "atmosphere.rayleigh": True, "atmosphere.sky": True,
    "ground.albedo": 0.3,
}  # fmt: skip
WATER = {"ground.albedo": None, "ground.water": True, "camera.altitude_deg": -10.0}
GLINT = {
    **WATER, "camera.azimuth_deg": 160.0, "camera.altitude_deg": -20.0,
    "light.0.angular_diameter_deg": 5.0,
}  # fmt: skip
TOWARDS = {"camera.azimuth_deg": 180.0, "light.0.angular_diameter_deg": 5.0}
PLATEAU = {
    "ground.height_m": 3000.0, "camera.position_m": [0.0, 0.0, 3001.6],
    "droplets.box_m": [[-200.0, 50.0, 3000.0], [200.0, 400.0, 3300.0]],
    "atmosphere.pressure_hpa": 990.0,
}  # fmt: skip
"""The ground, the eye and the drops of ``uniform`` three kilometres up."""


def drawn(method, changes, name="uniform"):
    with rtbow.Renderer(rtbow.load_scene(name, {**SCENE, **changes})) as renderer:
        return renderer.render(method)


def xyz(frame):
    return frame.astype(float) @ np.linalg.inv(XYZ_TO_RGB).T


HAZE = {
    "atmosphere.aerosol.model": "custom", "atmosphere.aerosol.optical_depth_550": 0.2,
    "atmosphere.ozone_du": 300.0,
}  # fmt: skip


@pytest.mark.parametrize("method", ["fast", "spectral"])
@pytest.mark.parametrize("changes", [
    {**HAZE, "atmosphere.sky": False},
    {**HAZE, "droplets.extinction": True},
    {**HAZE, "camera.polarizer_deg": 40.0},
    {**HAZE, **TOWARDS, "light.0.altitude_deg": 8.0},
    {**HAZE, "atmosphere.sky": False, "ground.albedo": 0.8, "camera.altitude_deg": -20.0},
    {**HAZE, **GLINT},
    {**HAZE, **PLATEAU},
], ids=["bow", "dim", "filter", "sun", "ground", "glint", "plateau"])  # fmt: skip
def test_hazy_frames_are_the_references(method, changes):
    if method == "fast":  # a low sun's haze is left to spectral
        changes = {**changes, "render.max_delta_e": 2.0}
    difference = frame_difference(xyz(drawn(method, changes)), xyz(drawn("reference", changes)))
    assert difference.delta_e.p99 < 0.5
    assert difference.delta_e.worst < 1.2
    assert difference.delta_e.median < 0.1  # 2 % of the light are 0.2


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


@pytest.mark.parametrize("method", ["fast", "spectral"])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"droplets.extinction": True},
        {"camera.polarizer_deg": -50.0, "droplets.extinction": True},
        {"camera.polarizer_deg": 20.0, "camera.azimuth_deg": 100.0},
        {**TOWARDS, "light.0.altitude_deg": 8.0},
        {**TOWARDS, "light.0.altitude_deg": 0.5},
        {"light.0.altitude_deg": -2.0, "camera.azimuth_deg": 150.0},
        {"camera.position_m": [0.0, 0.0, 10_000.0], "camera.altitude_deg": -5.0},
        {"atmosphere.sky": False},
        {"atmosphere.sky": False, "atmosphere.rayleigh": False},
        {**WATER, "droplets.extinction": True},
        {**WATER, "camera.polarizer_deg": 35.0, "camera.azimuth_deg": 110.0},
        GLINT,
        {**WATER, "camera.position_m": [0.0, 0.0, 4000.0], "light.0.altitude_deg": 4.0},
        {"ground.albedo": "grass", "camera.altitude_deg": -15.0},
        PLATEAU,
    ],
    ids=[
        "clear", "dim", "filter-dim", "filter", "sun", "sunset", "dusk", "high", "ground", "moon",
        "water-dim", "water-filter", "glint", "water-high", "grass", "plateau",
    ],
)  # fmt: skip
def test_frames_are_the_references(method, changes):
    difference = frame_difference(xyz(drawn(method, changes)), xyz(drawn("reference", changes)))
    assert difference.delta_e.p99 < 0.5
    assert difference.delta_e.worst < 1.0


def test_a_grid_dims_what_is_behind_it():
    changes = {"droplets.extinction": True, "atmosphere.sky": True, "ground.albedo": 0.2}
    difference = frame_difference(
        xyz(drawn("fast", changes, "shower")), xyz(drawn("reference", changes, "shower"))
    )
    assert difference.delta_e.p99 < 0.5
    assert difference.delta_e.worst < 1.0


def test_pixels_that_the_horizon_crosses_show_both_sides():
    changes = {"camera.pixel": "area", "camera.fov_deg": 40.0, "camera.altitude_deg": 0.3}
    sharp = {**changes, "camera.pixel": "centre", "camera.size_px": [256, 144]}
    fine = drawn("fast", sharp).reshape(18, 8, 32, 8, 3).mean(axis=(1, 3))
    difference = frame_difference(xyz(drawn("fast", changes)), xyz(fine))
    assert difference.delta_e.worst < 0.6


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
