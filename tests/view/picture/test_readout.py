"""What is under the cursor, against angles and colours worked out otherwise."""

import csv
from pathlib import Path

import numpy as np
import pytest

from rtbow.base.resources import resource_dir
from rtbow.physics.drop.water import relative_index
from rtbow.reference.render import radiance_along
from rtbow.scene.text.file import load_scene
from rtbow.view.picture.readout import (
    distance_text,
    frame_value,
    profile,
    read_pixel,
    spectrum_at,
    text_of,
)
from rtbow.world.world import resolve
from textbook import cross_section, mean_on_sphere, pinhole
from textbook import towards as unit

SIZE = (1280, 720)
WHITE = np.ones((9, 16, 3), dtype=np.float32)


def angle_deg(a, b):
    a, b = np.asarray(a, float), np.asarray(b, float)
    return np.degrees(np.arccos(np.clip(a @ b / np.linalg.norm(a) / np.linalg.norm(b), -1, 1)))


def pixel_of(scene, vector, size=SIZE):
    x, y = pinhole(scene.camera, vector, size)
    return float(x), float(y)


@pytest.mark.parametrize(("azimuth", "altitude"), [(0.0, 22.0), (-30.0, 5.0), (25.0, 35.0)])
def test_angles_under_a_sun(azimuth, altitude):
    scene = load_scene("curtain")
    ray = unit(azimuth, altitude)
    reading = read_pixel(WHITE, scene, SIZE, pixel_of(scene, ray))
    assert reading.scene == scene
    np.testing.assert_allclose(reading.direction, ray, atol=1e-9)
    assert (reading.azimuth_deg, reading.altitude_deg) == pytest.approx((azimuth, altitude))
    (sun,) = reading.lights
    assert sun.name == "sun"
    away = angle_deg(ray, unit(0.0, -20.0))
    assert sun.opposite_deg == pytest.approx(away, abs=1e-6)
    if reading.rain_m is not None:
        assert sun.scattering_deg == pytest.approx((180.0 - away,) * 2, abs=1e-6)


def test_angles_under_a_lamp():
    # street-lamp.toml: eye (0, 7, 1.5), lamp (0, 0, 6), rain [-60, 8, 0] to [60, 80, 30].
    scene = load_scene("street-lamp")
    for target in ([3.0, 80.0, 12.0], [-10.0, 80.0, 25.0]):  # on the far side
        eye, lamp = np.array([0.0, 7.0, 1.5]), np.array([0.0, 0.0, 6.0])
        way = target - eye
        reading = read_pixel(WHITE, scene, SIZE, pixel_of(scene, way))
        near = eye + way * (1.0 / way[1])
        (light,) = reading.lights
        assert light.name == "lamp"
        assert light.opposite_deg == pytest.approx(angle_deg(way, eye - lamp), abs=1e-6)
        # Between where the light comes from and where it goes to: the drop, then the eye.
        expected = [angle_deg(drop - lamp, eye - drop) for drop in (near, np.array(target))]
        assert light.scattering_deg == pytest.approx(expected, abs=1e-6)
        lengths = [np.linalg.norm(near - eye), np.linalg.norm(way)]
        assert reading.rain_m == pytest.approx(lengths, rel=1e-9)


def test_beside_the_rain_there_are_no_scattering_angles():
    scene = load_scene("street-lamp", {"camera.azimuth_deg": 180.0})
    reading = read_pixel(WHITE, scene, SIZE, (640.0, 360.0))
    assert reading.rain_m is None
    assert reading.lights[0].scattering_deg is None
    assert dict(text_of(reading))["rain"] == "none"


def test_an_eye_in_the_rain_sees_it_from_nought():
    scene = load_scene("street-lamp", {"camera.position_m": [0.0, 30.0, 1.5]})
    reading = read_pixel(WHITE, scene, SIZE, (640.0, 360.0))
    assert reading.rain_m[0] == 0.0
    assert reading.lights[0].scattering_deg[0] == pytest.approx(
        180.0 - reading.lights[0].opposite_deg
    )


# IEC 61966-2-1: primaries and white; u', v' as in CIE 15 for D65.
@pytest.mark.parametrize(
    ("rgb", "xy", "luminance"),
    [
        ((1.0, 1.0, 1.0), (0.3127, 0.3290), 1.0),
        ((50.0, 0.0, 0.0), (0.64, 0.33), 10.63),
        ((0.0, 2.0, 0.0), (0.30, 0.60), 1.4304),
        ((0.0, 0.0, 100.0), (0.15, 0.06), 7.22),
    ],
)
def test_colours(rgb, xy, luminance):
    frame = np.tile(np.array(rgb, dtype=np.float32), (4, 4, 1))
    reading = read_pixel(frame, load_scene("curtain"), SIZE, (600.0, 300.0))
    assert reading.luminance == pytest.approx(luminance, rel=1e-6)
    assert reading.xy == pytest.approx(xy, abs=2e-4)
    x, y = xy
    below = -2.0 * x + 12.0 * y + 3.0  # CIE 15:2004, equation 8.25
    assert reading.uv == pytest.approx((4.0 * x / below, 9.0 * y / below), abs=3e-4)
    if rgb == (1.0, 1.0, 1.0):
        assert reading.uv == pytest.approx((0.1978, 0.4683), abs=1e-4)


def test_darkness_has_no_colour():
    reading = read_pixel(np.zeros((4, 4, 3)), load_scene("curtain"), SIZE, (600.0, 300.0))
    assert reading.xy is None
    assert reading.uv is None
    names = dict(text_of(reading))
    assert names["luminance"] == "0 cd/m²"
    assert "x, y" not in names


def test_text_has_units():
    scene = load_scene("curtain")
    frame = np.full((9, 16, 3), 1234.56, dtype=np.float32)
    ray = unit(0.0, 22.0)
    lines = dict(text_of(read_pixel(frame, scene, SIZE, pixel_of(scene, ray))))
    assert lines["azimuth"] == "0.00°"
    assert lines["altitude"] == "22.00°"
    assert lines["from antisolar point"] == "42.00°"
    assert lines["scattering"] == "138.00°"
    assert lines["luminance"] == "1,235 cd/m²"
    assert lines["x, y"].startswith("0.31")
    assert " m to " in lines["rain"]
    two = load_scene("two-lamps")
    lines = dict(text_of(read_pixel(frame, two, SIZE, (640.0, 300.0))))
    assert {"from opposite the lamp 0", "from opposite the lamp 1", "scattering 1"} <= set(lines)
    assert "° to " in lines["scattering 0"]


@pytest.mark.parametrize(
    ("metres", "text"),
    [(0.0, "0 m"), (0.5, "0.5000 m"), (12.345, "12.35 m"), (999.4, "999.4 m"),
     (1234.56, "1.235 km"), (2e-5, "2.000e-05 m"), (1e7, "10,000 km")],
)  # fmt: skip
def test_distances(metres, text):
    assert distance_text(metres) == text


def test_a_frame_is_stretched_over_the_view():
    frame = np.arange(2 * 4 * 3, dtype=np.float32).reshape(2, 4, 3)
    for pixel, row, column in (
        ((0.0, 0.0), 0, 0), ((319.9, 359.9), 0, 0), ((320.1, 360.1), 1, 1),
        ((1279.9, 10.0), 0, 3), ((1280.0, 720.0), 1, 3), ((-5.0, 900.0), 1, 0),
    ):  # fmt: skip
        np.testing.assert_array_equal(frame_value(frame, SIZE, pixel), frame[row, column])


def test_a_split_picture_tells_of_the_part_under_the_cursor():
    right = {"light.0.altitude_deg": 5.0, "camera.fov_deg": 50.0}
    scene = load_scene("curtain", {"compare": {"split": 0.5, "right": right}})
    ray = unit(-15.0, 20.0)
    reading = read_pixel(WHITE, scene, SIZE, pixel_of(scene, ray))
    assert reading.lights[0].opposite_deg == pytest.approx(angle_deg(ray, unit(0.0, -20.0)))
    (_, part) = (part for part, _ in scene.parts())
    ray = unit(15.0, 20.0)
    reading = read_pixel(WHITE, scene, SIZE, pixel_of(part, ray))
    assert reading.scene is part
    np.testing.assert_allclose(reading.direction, ray, atol=1e-9)
    assert reading.lights[0].opposite_deg == pytest.approx(angle_deg(ray, unit(0.0, -5.0)))


def test_each_part_has_its_own_rain():
    right = {"droplets.box_m": [[-60.0, 20.0, 0.0], [60.0, 80.0, 30.0]]}
    scene = load_scene("street-lamp", {"compare": {"split": 0.5, "right": right}})
    spans = [read_pixel(WHITE, scene, SIZE, (x, 300.0)).rain_m for x in (600.0, 680.0)]
    # The eye is 1 m before the left rain and 13 m before the right one.
    assert spans[1][0] == pytest.approx(13.0 * spans[0][0])
    assert spans[1][1] == pytest.approx(spans[0][1])


def e490(low, high):
    """Mean irradiance of ASTM E490 between two wavelengths, from its table."""
    text = Path(resource_dir("data") / "astm_e490_00a.csv").read_text().splitlines()[4:]
    table = np.array([[float(cell) for cell in row[:2]] for row in csv.reader(text)])
    fine = np.linspace(low, high, 20_001)
    return np.interp(fine, *table.T).mean()


def test_the_spectrum_of_a_uniform_rain():
    changes = {
        "camera.position_m": [0.0, 0.0, 0.0],
        "droplets": {
            "box_m": [[-1000.0, 100.0, 0.0], [1000.0, 1100.0, 2000.0]],
            "radius": {"distribution": "constant", "radius_um": 60.0},
            "density": {"number_per_m3": 500.0},
        },
        "atmosphere": None,
        "scattering.orders": [1],
    }
    scene = load_scene("curtain", changes)
    ray = unit(0.0, 21.0)
    nm, radiance = spectrum_at(scene, ray)
    np.testing.assert_array_equal(nm, np.arange(380.0, 781.0))
    assert radiance.shape == (401,)
    length = 1000.0 / ray[1]
    for k in (40, 170, 300):
        index = float(relative_index(np.array([nm[k]]), 20.0)[0])
        theta = np.radians(180.0 - 41.0)
        section = mean_on_sphere(
            lambda t, index=index, k=k: cross_section(index, nm[k] * 1e-9, 60e-6, t, 1),
            theta, np.radians(0.5 * 0.533), rings=40, spokes=96,
        )  # fmt: skip
        expected = e490(nm[k] - 0.5, nm[k] + 0.5) * 500.0 * length * section
        assert radiance[k] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", ["shower", "street-lamp", "two-lamps"])
def test_the_spectrum_sums_to_what_is_seen(name):
    from rtbow.physics.light.colour import colour_matching

    scene = load_scene(name)
    ray = unit(2.0, 15.0)
    nm, radiance = spectrum_at(scene, ray)
    fine = scene.render.model_copy(update={"wavelength_step_nm": 1.0})
    xyz = radiance_along(resolve(scene.model_copy(update={"render": fine})), ray[None])[0]
    at, cmf = colour_matching()
    widths = np.r_[0.5, np.ones(399), 0.5]
    summed = [(radiance * widths) @ np.interp(nm, at, f) for f in cmf.T]
    # Worst 3.5e-5: spectrum and functions are not even within a nanometre.
    np.testing.assert_allclose(summed, xyz, rtol=1e-4)


def ramp(width, height, size=SIZE):
    """A frame whose value is the place in the view, in its pixels, in the first two channels."""
    x = (np.arange(width) + 0.5) * size[0] / width
    y = (np.arange(height) + 0.5) * size[1] / height
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None], 1.0), axis=-1)


@pytest.mark.parametrize("frame_px", [(1280, 720), (400, 225)])
@pytest.mark.parametrize("pixel", [(640.5, 100.0), (200.0, 300.0), (1100.0, 650.0), (3.0, 3.0)])
def test_a_profile_runs_through_the_point(pixel, frame_px):
    scene = load_scene("curtain")
    found = profile(ramp(*frame_px), scene, SIZE, pixel, 701)
    assert found.angle_deg.shape == found.luminance.shape == (701,)
    steps = np.diff(found.angle_deg)
    assert np.all(steps > 0.0)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-9)
    # On the line that joins the antisolar point, below the picture, with the point.
    foot = np.array(pixel_of(scene, unit(0.0, -20.0)))
    along, across = found.pixels - foot, np.array(pixel) - foot
    aside = along[:, 0] * across[1] - along[:, 1] * across[0]
    np.testing.assert_allclose(aside / np.linalg.norm(across), 0.0, atol=1e-6)
    assert np.linalg.norm(found.pixels - pixel, axis=1).min() < 2.0
    # From side to side of the picture.
    for x, y in found.pixels[[0, -1]]:
        assert min(abs(x), abs(x - 1280.0), abs(y), abs(y - 720.0)) < 1e-6
    assert found.pixels.min() > -1e-6
    # Values are those between the frame's pixels, and held from the outermost centres on.
    half = 0.5 * 1280 / frame_px[0]
    inner = np.clip(found.pixels, half, np.array(SIZE) - half)
    np.testing.assert_allclose(found.rgb[:, :2], inner, atol=1e-6)
    np.testing.assert_allclose(found.rgb[:, 2], 1.0, rtol=1e-12)


def test_a_profiles_angles_are_those_from_the_antisolar_point():
    scene = load_scene("curtain")
    found = profile(ramp(*SIZE), scene, SIZE, (300.0, 200.0), 300)
    for k in (0, 100, 299):
        x, y = found.pixels[k]
        # The ray through a pixel, by the two angles of a pinhole camera.
        focal = 640.0 / np.tan(np.radians(42.0))
        right, up = x - 640.0, 360.0 - y
        tilt = np.radians(22.5)
        ray = [right, focal * np.cos(tilt) - up * np.sin(tilt),
               focal * np.sin(tilt) + up * np.cos(tilt)]  # fmt: skip
        assert found.angle_deg[k] == pytest.approx(angle_deg(ray, unit(0.0, -20.0)), abs=1e-6)


def test_a_profile_begins_at_the_antisolar_point_if_that_is_seen():
    scene = load_scene("curtain", {"camera.altitude_deg": -20.0, "camera.fov_deg": 110.0})
    frame = ramp(*SIZE)
    for pixel in ((900.0, 300.0), (640.0, 360.0)):  # the second is that point
        found = profile(frame, scene, SIZE, pixel)
        assert found.angle_deg[0] == pytest.approx(0.0, abs=1e-6)
        np.testing.assert_allclose(found.pixels[0], (640.0, 360.0), atol=1e-6)
    assert np.all(np.diff(found.pixels[:, 1]) < 0.0)  # upwards
    np.testing.assert_allclose(found.pixels[:, 0], 640.0, atol=1e-6)


def test_a_profile_ends_at_the_sun():
    scene = load_scene("curtain", {"camera.azimuth_deg": 180.0, "camera.altitude_deg": 20.0})
    found = profile(ramp(*SIZE), scene, SIZE, (300.0, 200.0))
    assert found.angle_deg[-1] == pytest.approx(180.0, abs=1e-6)
    np.testing.assert_allclose(found.pixels[-1], (640.0, 360.0), atol=1e-6)


def test_a_profile_keeps_to_its_part():
    right = {"atmosphere.rayleigh": False}
    changes = {"compare": {"split": 0.5, "right": right}, "camera.altitude_deg": -20.0}
    scene = load_scene("curtain", changes)
    frame = ramp(*SIZE)
    frame[:, 640:, 2] = 100.0
    left = profile(frame, scene, SIZE, (400.0, 300.0))
    # It starts where the parts meet, with the value of its own last column.
    assert left.pixels[0, 0] == pytest.approx(640.0)
    assert left.pixels[:, 0].max() <= 640.0 + 1e-6
    np.testing.assert_array_equal(left.rgb[:, 2], 1.0)
    found = profile(frame, scene, SIZE, (660.0, 300.0))
    assert found.pixels[:, 0].min() >= 640.0 - 1e-6
    np.testing.assert_array_equal(found.rgb[:, 2], 100.0)


def test_a_profile_of_a_lamp_starts_opposite_it():
    scene = load_scene("street-lamp", {"camera.altitude_deg": -20.0})
    found = profile(ramp(*SIZE), scene, SIZE, (700.0, 100.0))
    opposite = pixel_of(scene, [0.0, 7.0, -4.5])
    np.testing.assert_allclose(found.pixels[0], opposite, atol=1e-6)
