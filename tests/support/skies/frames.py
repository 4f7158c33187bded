"""Frames with sky, ground and suns as the shader draws them, against the reference's rays."""

from __future__ import annotations

import rtbow
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz

SCENE = {
    "camera.size_px": [32, 18], "camera.fov_deg": 100.0, "camera.altitude_deg": 12.0,
    "render.wavelength_step_nm": 5.0, "atmosphere.rayleigh": True, "atmosphere.sky": True,
    "ground.albedo": 0.3,
}  # fmt: skip
TOWARDS = {"camera.azimuth_deg": 180.0, "light.0.angular_diameter_deg": 5.0}
HAZE = {
    "atmosphere.aerosol.model": "custom", "atmosphere.aerosol.optical_depth_550": 0.2,
    "atmosphere.ozone_du": 300.0,
}  # fmt: skip
WATER = {"ground.water": True, "camera.altitude_deg": -10.0}
GLINT = {
    **WATER, "camera.azimuth_deg": 160.0, "camera.altitude_deg": -20.0,
    "light.0.angular_diameter_deg": 5.0,
}  # fmt: skip
PLATEAU = {
    "ground.height_m": 3000.0, "camera.position_m": [0.0, 0.0, 3001.6],
    "droplets.box_m": [[-200.0, 50.0, 3000.0], [200.0, 400.0, 3300.0]],
    "atmosphere.pressure_hpa": 990.0,
}  # fmt: skip
"""The ground, the eye and the drops of ``uniform`` three kilometres up."""
NARROW = {"camera.fov_deg": 14.0, "camera.altitude_deg": 1.0}
"""Pixels so small that the sky is drawn at nodes some of them apart."""
METHODS = ("fast", "spectral")

CLEAR_CASES = {
    "clear": {},
    "dim": {"droplets.extinction": True},
    "filter-dim": {"camera.polarizer_deg": -50.0, "droplets.extinction": True},
    "filter": {"camera.polarizer_deg": 20.0, "camera.azimuth_deg": 100.0},
    "sun": {**TOWARDS, "light.0.altitude_deg": 8.0},
    "sunset": {**TOWARDS, "light.0.altitude_deg": 0.5},
    "dusk": {"light.0.altitude_deg": -2.0, "camera.azimuth_deg": 150.0},
    "high": {"camera.position_m": [0.0, 0.0, 10_000.0], "camera.altitude_deg": -5.0},
    "ground": {"atmosphere.sky": False},
    "moon": {"atmosphere.sky": False, "atmosphere.rayleigh": False},
    "water-dim": {**WATER, "droplets.extinction": True},
    "water-filter": {**WATER, "camera.polarizer_deg": 35.0, "camera.azimuth_deg": 110.0},
    "glint": GLINT,
    "water-high": {
        **WATER, "camera.position_m": [0.0, 0.0, 4000.0], "light.0.altitude_deg": 4.0,
    },
    "grass": {"ground.albedo": "grass", "camera.altitude_deg": -15.0},
    "plateau": PLATEAU,
    "ozone-shadow": {
        "atmosphere.ozone_du": 300.0, "atmosphere.sky": False, "light.0.altitude_deg": -0.5,
        "droplets.box_m": [[-2000.0, 300.0, 0.0], [2000.0, 1500.0, 1250.0]],
        "camera.altitude_deg": 30.0, "camera.fov_deg": 60.0,
    },
    "thin": {
        "atmosphere.pressure_hpa": 500.0, "atmosphere.sky": False, "light.0.altitude_deg": 5.0,
    },
    "water-shower": {
        **WATER, "droplets.extinction": True, "light.0.altitude_deg": 28.0,
        "droplets.box_m": [[-3000.0, 500.0, 0.0], [1000.0, 2500.0, 1500.0]],
        "droplets.density.number_per_m3": 600.0,
    },
    "water-horizon": {
        **WATER, "droplets.extinction": True, "droplets.density.number_per_m3": 600.0,
        "camera.fov_deg": 0.6, "camera.altitude_deg": -0.1,
        "droplets.box_m": [[-3000.0, 500.0, 0.0], [3000.0, 2500.0, 1500.0]],
    },
    "nodes": NARROW,
    "nodes-filter-dim": {
        **NARROW, "camera.polarizer_deg": 30.0, "droplets.extinction": True,
        "camera.azimuth_deg": 70.0,
    },
    "nodes-sun": {**NARROW, "camera.azimuth_deg": 178.0, "camera.altitude_deg": 18.0},
    "nodes-glint": {
        **NARROW, "ground.water": True, "camera.azimuth_deg": 182.0, "camera.altitude_deg": -18.0,
    },
}  # fmt: skip
HAZY_CASES = {
    "bow": {**HAZE, "atmosphere.sky": False},
    "dim": {**HAZE, "droplets.extinction": True},
    "filter": {**HAZE, "camera.polarizer_deg": 40.0},
    "sun": {**HAZE, **TOWARDS, "light.0.altitude_deg": 8.0},
    "ground": {
        **HAZE, "atmosphere.sky": False, "ground.albedo": 0.8, "camera.altitude_deg": -20.0,
    },
    "glint": {**HAZE, **GLINT},
    "plateau": {**HAZE, **PLATEAU},
    "nodes-sun": {
        **HAZE, **NARROW, "camera.azimuth_deg": 178.0, "camera.altitude_deg": 17.0,
    },
}  # fmt: skip


def drawn(method, changes, name="uniform"):
    """A frame of a scene with ``SCENE`` and changes."""
    with rtbow.Renderer(rtbow.load_scene(name, {**SCENE, **changes})) as renderer:
        return renderer.render(method)


def difference(method, changes, name="uniform"):
    """Of a method's frame from the reference's, as colours."""
    if method == "fast" and "atmosphere.aerosol.model" in changes:
        changes = {**changes, "render.max_delta_e": 2.0}  # a low sun's haze is left to spectral
    frames = (drawn(each, changes, name) for each in (method, "reference"))
    return frame_difference(*map(rgb_to_xyz, frames)).delta_e
