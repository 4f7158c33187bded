"""Pixels wider than what a shader follows within one are drawn in parts."""

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import UnsuitedError
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.render.wide_pixels import WIDEST_RAD, parts_of
from rtbow.scene.model import Camera
from rtbow.world.camera.resolve import view_of

RAIN = {"droplets": {"around_m": [500.0, 400.0], "radius": {"distribution": "constant",
        "radius_um": 500.0}, "density": {"number_per_m3": 1000.0}},
        "camera.altitude_deg": -20.0, "camera.lens_shift": [0.1, 0.2]}  # fmt: skip


def scene(fov_deg, size, pixel, **changes):
    camera = {"camera.fov_deg": fov_deg, "camera.size_px": size, "camera.pixel": pixel}
    return rtbow.load_scene("uniform", {**RAIN, **camera, **changes})


def frame(scene, method="fast"):
    with rtbow.Renderer(scene) as renderer:
        return renderer.render(method).astype(np.float64)


def solid_angles(fov_deg, width, height, shift=(0.1, 0.2)):
    """Of each pixel: a rectangle's, by its corners' arc tangents."""
    half = np.tan(np.radians(0.5 * fov_deg))
    x = half * (np.linspace(-1.0, 1.0, width + 1) + 2.0 * shift[0])
    y = half * height / width * (np.linspace(1.0, -1.0, height + 1) + 2.0 * shift[1])
    corner = np.arctan(x * y[:, None] / np.sqrt(1.0 + x**2 + y[:, None] ** 2))
    return np.abs(np.diff(np.diff(corner, axis=0), axis=1))


def mean_of_centres(fov_deg, size, parts):
    width, height = size
    fine = frame(scene(fov_deg, [parts * width, parts * height], "centre"))
    solid = solid_angles(fov_deg, parts * width, parts * height)[..., None]
    light, whole = (
        values.reshape(height, parts, width, parts, -1).sum(axis=(1, 3))
        for values in (solid * fine, solid)
    )
    return light / whole


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fov_deg", "size", "parts"), [(100.0, [1, 1], 800), (140.0, [8, 5], 150), (90.0, [20, 12], 40)]
)
@pytest.mark.parametrize("method", ["fast", "spectral"])
def test_wide_pixels_are_means_too(fov_deg, size, parts, method):
    truth = mean_of_centres(fov_deg, size, parts)
    got = frame(scene(fov_deg, size, "area", **{"render.wavelength_step_nm": 4.0}), method)
    solid = solid_angles(fov_deg, *size)[..., None]
    assert (solid * got).sum() == pytest.approx((solid * truth).sum(), rel=2e-3)
    assert frame_difference(rgb_to_xyz(got), rgb_to_xyz(truth)).delta_e.worst < 0.5


def test_what_lies_beside_a_split_is_drawn_in_parts_too():
    compared = {"compare": {"split": 0.4, "right": {"light.0.altitude_deg": 8.0}}}
    got = frame(scene(100.0, [5, 3], "area", **compared))
    left = frame(scene(100.0, [5, 3], "area"))
    right = frame(scene(100.0, [5, 3], "area", **{"light.0.altitude_deg": 8.0}))
    np.testing.assert_allclose(got[:, :2], left[:, :2], rtol=1e-5)
    np.testing.assert_allclose(got[:, 2:], right[:, 2:], rtol=1e-5)


def test_pictures_that_move_are_cut_anew():
    moves = [(100.0, [64, 36]), (100.0, [6, 4]), (30.0, [64, 36]), (140.0, [8, 5])]
    assert len({parts_of(scene_view(*move)) for move in moves}) == 3
    with rtbow.Renderer(scene(100.0, [40, 22], "area")) as renderer:
        for fov_deg, size in moves:
            renderer.show(scene(fov_deg, size, "area"))
            got = renderer.render("fast")
            assert got.shape == (size[1], size[0], 3)
            anew = frame(scene(fov_deg, size, "area"))
            worst = frame_difference(rgb_to_xyz(got.astype(np.float64)), rgb_to_xyz(anew)).delta_e
            assert worst.p99 < 0.5


def scene_view(fov_deg, size, pixel="area"):
    return view_of(Camera(fov_deg=fov_deg, size_px=tuple(size), pixel=pixel))


def test_progress_sees_each_row_of_the_picture_once():
    seen = []
    with rtbow.Renderer(scene(100.0, [6, 4], "area")) as renderer:
        for method in ("fast", "spectral"):
            rows = []
            renderer.render(method, lambda each, rows=rows: (rows.append(r) or r for r in each))
            seen.append(rows)
    assert seen == [[0, 1, 2, 3]] * 2


def test_narrow_pixels_and_centres_are_whole():
    assert parts_of(scene_view(90.0, [44, 25])) == 1  # 45 mrad
    assert parts_of(scene_view(75.0, [64, 36])) == 1
    assert parts_of(scene_view(100.0, [1, 1], "centre")) == 1
    assert parts_of(scene_view(90.0, [1, 1])) == np.ceil(2.0 / WIDEST_RAD)


def test_more_parts_than_a_shader_draws_are_left_to_the_reference():
    with pytest.raises(UnsuitedError, match=r"camera.pixel: .* --method reference"):
        parts_of(scene_view(179.99, [40, 20]))
