"""Pixels as means over their area, by each method of the shader: against finer pictures' means."""

import numpy as np
import pytest

import rtbow
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz

pytestmark = pytest.mark.slow

DROPS = {"droplets.radius.radius_um": 500.0, "render.wavelength_step_nm": 4.0}
WIDE = {**DROPS, "camera.fov_deg": 100.0}
LAMP = {"camera.fov_deg": 110.0}


def frame(name, size, method, pixel, changes):
    scene = rtbow.load_scene(name, {"camera.size_px": size, "camera.pixel": pixel, **changes})
    with rtbow.Renderer(scene) as renderer:
        return renderer.render(method).astype(np.float64)


def mean_of_finer(name, size, changes, parts=16):
    fine = [parts * n for n in size]
    split = frame(name, fine, "fast", "centre", changes)
    return split.reshape(size[1], parts, size[0], parts, 3).mean(axis=(1, 3))


def delta_e(rgb, truth):
    return frame_difference(rgb_to_xyz(rgb), rgb_to_xyz(truth)).delta_e


@pytest.mark.parametrize(
    ("name", "method", "size", "changes"),
    [
        ("uniform", "fast", [96, 54], WIDE),
        ("uniform", "spectral", [32, 18], {**DROPS, "camera.fov_deg": 30.0}),
        ("curtain", "fast", [96, 54], {}),
        ("two-lamps", "fast", [96, 54], LAMP),
    ],
)
def test_pixels_are_the_means_of_finer_ones(name, method, size, changes):
    truth = mean_of_finer(name, size, changes)
    centres = delta_e(frame(name, size, "fast", "centre", changes), truth)
    assert centres.worst > 3.0
    error = delta_e(frame(name, size, method, "area", changes), truth)
    assert error.p99 < 0.5
    assert error.worst < 1.5


GAMMA = {
    "droplets.radius": {
        "distribution": "gamma", "effective_radius_um": 300.0, "effective_variance": 0.05,
        "mixing": "local",
    },
    "render.wavelength_step_nm": 4.0,
    "camera.fov_deg": 60.0,
}  # fmt: skip
DIMMING = {**DROPS, "camera.fov_deg": 60.0, "droplets.extinction": True,
           "droplets.density.number_per_m3": 3000.0}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "method", "changes"),
    [
        ("uniform", "spectral", GAMMA),
        ("uniform", "fast", DIMMING),
        ("uniform", "spectral", DIMMING),
        ("curtain", "spectral", {"render.wavelength_step_nm": 4.0}),
        ("two-lamps", "spectral", LAMP),
    ],
)
def test_whatever_a_scene_holds(name, method, changes):
    """Mixtures, rain that dims, grids, lamps."""
    size = [64, 36] if name == "curtain" else [48, 27]
    truth = mean_of_finer(name, size, changes, 12)
    error = delta_e(frame(name, size, method, "area", changes), truth)
    assert error.p99 < 0.7
    assert error.worst < 1.5


@pytest.mark.parametrize("method", ["fast", "spectral"])
def test_rays_that_are_level_with_the_rains_floor(method):
    """A level camera of an odd height: the middle row's centres never meet the box's floor, and
    half of each of its pixels does."""
    changes = {**DROPS, "camera.fov_deg": 90.0, "camera.altitude_deg": 0.0,
               "light.0.altitude_deg": 5.0}  # fmt: skip
    size = [65, 37]
    truth = mean_of_finer("uniform", size, changes, 36)[18]
    row = frame("uniform", size, method, "area", changes)[18]
    assert truth.max() > 0.0
    # Of the row as a whole: a pixel of 1.4 degrees on the bow misses by more. With half the row
    # taken for rain, 1.4 times as bright.
    np.testing.assert_allclose(row.sum(axis=0), truth.sum(axis=0), rtol=0.02)


def test_a_filters_components_are_averaged_too():
    changes = {**WIDE, "camera.polarizer_deg": 30.0}
    truth = mean_of_finer("uniform", [64, 36], changes, 12)
    error = delta_e(frame("uniform", [64, 36], "fast", "area", changes), truth)
    assert error.p99 < 0.6
    assert error.worst < 1.5


def test_a_light_that_is_too_faint_for_float32_is_black():
    changes = {**WIDE, "light.0.irradiance_w_m2": 5e-324, "atmosphere.rayleigh": True}
    assert not frame("uniform", [8, 4], "fast", "area", changes).any()


def test_wide_pixels_follow_a_moving_sun():
    changes = {**WIDE, "camera.size_px": [96, 54], "camera.pixel": "area"}
    with rtbow.Renderer(rtbow.load_scene("uniform", changes)) as renderer:
        renderer.render("fast")
        for altitude, size in ((12.0, [96, 54]), (12.0, [64, 36]), (9.0, [128, 72])):
            moved = {**changes, "light.0.altitude_deg": altitude, "camera.size_px": size}
            renderer.show(rtbow.load_scene("uniform", moved))
            got = renderer.render("fast")
            anew = frame(
                "uniform", size, "fast", "area", {**WIDE, "light.0.altitude_deg": altitude}
            )
            # Tables for suns that move have fewer levels and shapes.
            error = delta_e(got.astype(np.float64), anew)
            assert error.p99 < 0.5, (altitude, size)
            assert error.worst < 1.5, (altitude, size)
