"""The camera's rays."""

import numpy as np
import pytest

from rtbow import Renderer, load_scene
from rtbow.physics.geometry import direction
from rtbow.scene.lens import zoomed
from rtbow.scene.model import Camera
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.values import changed_scene, differences, values_of
from rtbow.view.picture.projection import View as Picture
from rtbow.world.camera.perspective import camera_basis
from rtbow.world.camera.resolve import pixel_directions, view_of
from scene_samples import BASE, problems


@pytest.mark.parametrize("size_px", [(64, 36), (9, 40), (1, 1)])
@pytest.mark.parametrize("fov_deg", [2.0, 84.0, 150.0])
def test_a_cone_through_the_corners_holds_the_picture(size_px, fov_deg):
    camera = Camera(size_px=size_px, fov_deg=fov_deg, azimuth_deg=70.0, altitude_deg=-30.0)
    axis, half = view_of(camera).cone
    assert np.linalg.norm(axis) == pytest.approx(1.0)
    angles = np.arccos(np.clip(pixel_directions(camera) @ axis, -1.0, 1.0))
    assert angles.max() < half
    forward, right, up = camera_basis(camera)
    for corner in (forward + right + up, forward - right + up, forward + right - up):
        assert np.arccos(corner @ axis / np.linalg.norm(corner)) == pytest.approx(half)


def seen_at(x_mm, y_mm, focal_mm, roll_deg=0.0):
    """Give azimuth and altitude, degrees, of what a level camera that looks north has at a place of
    its picture, in mm on the sensor to the right and up from the lens's axis."""
    turn = np.radians(roll_deg)
    right = x_mm * np.cos(turn) + y_mm * np.sin(turn)
    up = y_mm * np.cos(turn) - x_mm * np.sin(turn)
    azimuth = np.degrees(np.arctan(right / focal_mm))
    return azimuth, np.degrees(np.arctan(up / np.hypot(focal_mm, right)))


@pytest.mark.parametrize(
    ("changes", "frame_mm", "focal_mm"),
    [
        ({"focal_length_mm": 50.0}, (36.0, 24.0), 50.0),
        ({"focal_length_mm": 24.0, "roll_deg": 90.0}, (36.0, 24.0), 24.0),
        ({"focal_length_mm": 24.0, "lens_shift": (0.25, -0.5)}, (36.0, 24.0), 24.0),
        ({"focal_length_mm": 8.0, "sensor_mm": (17.3, 13.0), "roll_deg": -20.0,
          "lens_shift": (-1.0, 0.3), "size_px": (160, 90)}, (17.3, 17.3 * 9 / 16), 8.0),
        ({"focal_length_mm": 35.0, "size_px": (40, 60)}, (24.0, 36.0), 35.0),
        ({"focal_length_mm": 35.0, "sensor_mm": (24.0, 36.0), "size_px": (50, 50)}, (24.0, 24.0),
         35.0),
        ({"fov_deg": 90.0, "roll_deg": 30.0, "lens_shift": (0.0, 0.5)}, (2.0, 4 / 3), 1.0),
    ],
)  # fmt: skip
def test_where_the_corner_pixels_look(changes, frame_mm, focal_mm):
    camera = Camera(**{"size_px": (60, 40), "altitude_deg": 0.0, **changes})
    view = view_of(camera)
    rays = view.pixel_directions()
    (width_mm, height_mm), (width, height) = frame_mm, camera.size_px
    for column in (0, width - 1):
        for row in (0, height - 1):
            x = ((column + 0.5) / width - 0.5 + camera.lens_shift[0]) * width_mm
            y = (0.5 - (row + 0.5) / height + camera.lens_shift[1]) * height_mm
            azimuth, altitude = seen_at(x, y, focal_mm, camera.roll_deg)
            assert rays[row, column] == pytest.approx(direction(azimuth, altitude), abs=1e-12)
            # The window's own projection, the other way.
            at, seen = Picture(camera, camera.size_px).pixels(rays[row, column])
            assert at == pytest.approx([column + 0.5, row + 0.5], abs=1e-9)
            assert seen
    axis, half = view.cone
    assert np.arccos(np.clip(rays @ axis, -1.0, 1.0)).max() < half
    least, most = view.off_axis
    angles = np.arccos(np.clip(rays @ view.axis, -1.0, 1.0))
    assert least <= angles.min() + 1e-9
    assert least == pytest.approx(angles.min(), abs=0.03)
    assert most >= angles.max()


@pytest.mark.parametrize(
    # Makers' tables of full-frame lenses: horizontal and vertical angle of view.
    ("focal_mm", "across", "upright"),
    [(14, 104.3, 81.2), (24, 73.7, 53.1), (35, 54.4, 37.8), (50, 39.6, 27.0), (200, 10.3, 6.9)],
)
def test_published_angles_of_view(focal_mm, across, upright):
    view = view_of(Camera(focal_length_mm=focal_mm, size_px=(60, 40)))
    assert view.fields_deg == pytest.approx((across, upright), abs=0.06)
    turned = view_of(Camera(focal_length_mm=focal_mm, size_px=(40, 60), roll_deg=10.0))
    assert turned.fields_deg == pytest.approx((upright, across), abs=0.06)


def test_the_field_of_view_of_a_shifted_lens():
    view = view_of(Camera(focal_length_mm=12.0, size_px=(60, 40), lens_shift=(0.0, 0.5)))
    assert view.fields_deg[1] == pytest.approx(np.degrees(np.arctan(24 / 12)))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("focal_length_mm = 50\nfov_deg = 75", "camera.fov_deg cannot be given together with"),
        ("sensor_mm = [36, 24]", "camera.sensor_mm goes with focal_length_mm"),
        ("focal_length_mm = 0", "camera.focal_length_mm = 0; must be 0.1..10000 mm"),
        ("focal_length_mm = 5\nsensor_mm = [36]", "camera.sensor_mm = [36]; must be a list of 2"),
        ("focal_length_mm = true", "camera.focal_length_mm = true; must be a number"),
        ("lens_shift = [0, 3]", "camera.lens_shift.1 = 3; must be -2..2"),
        ("shift = [0, 1]", "did you mean camera.lens_shift?"),
        ("focal_length = 50", "did you mean camera.focal_length_mm?"),
    ],
)
def test_what_is_no_lens(text, says):
    (line,) = problems(BASE.replace("size_px = [64, 36]", text))
    assert says in line


def test_a_lens_replaces_a_field_of_view_and_the_other_way_round():
    lens = {"camera.focal_length_mm": 50}
    wide = BASE.replace("[camera]", "[camera]\nfov_deg = 100")
    got = scene_from_text(wide, overrides=lens)
    assert got.camera.fov_deg == pytest.approx(39.598, abs=1e-3)
    assert "fov_deg" not in values_of(got)["camera"]
    back = changed_scene(got, {"camera.fov_deg": 100})
    assert back == scene_from_text(wide)
    assert differences(got, back) == {"camera.focal_length_mm": None, "camera.fov_deg": 100}
    assert changed_scene(got, differences(got, back)) == back
    closer = got.camera.model_copy(update=zoomed(got.camera, 20.0))
    assert view_of(closer).fields_deg[0] == pytest.approx(20.0)
    assert closer.focal_length_mm == pytest.approx(18.0 / np.tan(np.radians(10.0)))
    assert Camera(**closer.model_dump(exclude={"fov_deg"})).fov_deg == pytest.approx(20.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "pixel"),
    [("reference", "centre"), ("spectral", "centre"), ("fast", "centre"), ("spectral", "area"),
     ("fast", "area")],
)  # fmt: skip
def test_a_shifted_picture_is_a_part_of_a_larger_one(method, pixel):
    view = {"camera.altitude_deg": 10.0, "camera.roll_deg": 25.0, "camera.pixel": pixel,
            "render.wavelength_step_nm": 40.0}  # fmt: skip
    half = np.tan(np.radians(30.0))
    whole = load_scene("uniform", {**view, "camera.size_px": [24, 16], "camera.fov_deg": 60.0})
    fov_deg = float(np.degrees(2.0 * np.arctan(half / 3.0)))
    part = {"camera.size_px": [8, 8], "camera.fov_deg": fov_deg, "camera.lens_shift": [-1, 0.5]}
    frames = []
    for scene in (whole, load_scene("uniform", {**view, **part})):
        with Renderer(scene) as renderer:
            frames.append(renderer.render(method=method)[:8, :8])
    expected, got = frames
    assert expected.max() > 0.0
    # Measured: 1e-5 (spectral) of the brightest; fast makes tables for each picture's own angles,
    # which differ by 1.8e-4.
    share = 3e-4 if method == "fast" else 3e-5
    assert got == pytest.approx(expected, rel=0.0, abs=share * float(expected.max()))
