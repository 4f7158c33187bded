"""What is said of frames without a bow, and that the proposed values help."""

import re

import numpy as np
import pytest

import rtbow
from rtbow.frames.bows.reasons import is_black, reasons
from rtbow.world.world import resolve

SMALL = {"camera.size_px": [24, 14]}
TIMED = {"time": "2013-06-27T12:00:00Z", "latitude_deg": 48.0, "longitude_deg": 11.0}
LAMP = {"type": "point", "position_m": [0.0, -100.0, 3.0], "luminous_flux_lm": 1e4}
NEAR = [[-50.0, 5.0, 0.0], [50.0, 60.0, 50.0]]


def said(name, changes, light=1.0):
    """What is said of a scene whose pixels all have one value."""
    scene = rtbow.load_scene(name, {**SMALL, **changes})
    parts = scene.parts()
    frame = np.full((14, 24, 3), light, np.float32)
    columns = [filled for _, filled in parts]
    return reasons(
        [resolve(part) for part, _ in parts], columns, [is_black(frame[:, c]) for c in columns]
    )


@pytest.mark.parametrize("name", ["uniform", "curtain", "street-lamp", "two-lamps", "fogbow"])
def test_nothing_is_said_where_a_bow_shows(name):
    assert said(name, {}) == ()


def test_a_camera_that_follows_is_told_where_to_look():
    """Angles beside camera.look would be refused."""
    wide = {"camera.look": "antisolar", "camera.fov_deg": 60.0}
    (note,) = said("uniform", wide, 0.0)
    angles = re.search(r"camera\.look = \[(\S+), (\S+)\] shows", note)
    assert angles, note
    look = [float(angles[1]), float(angles[2])]
    assert said("uniform", {**wide, "camera.look": look}) == ()


CASES = {
    "behind": ({"camera.azimuth_deg": 180.0, "droplets.box_m": [[-1e3] * 3, [1e3] * 3]},
               ("opposite the sun (light.0), behind the camera",)),
    "beside": ({"camera.fov_deg": 10.0, "camera.altitude_deg": 8.0}, ("outside of the picture",)),
    "rain": ({"camera.azimuth_deg": 180.0}, ("droplets.box_m", "outside of the picture")),
    "high sun": ({"light.0.altitude_deg": 60.0}, ("60 deg high", "below the horizon")),
    "sun beside": ({"light.0.azimuth_deg": 0.0}, ("light.0",)),
    "secondary": ({"light.0.altitude_deg": 45.0, "scattering.orders": [1]}, ("45 deg high",)),
    "lamp": ({"light": [LAMP], "droplets.box_m": NEAR, "camera.azimuth_deg": 180.0},
             ("outside of the picture",)),
    "no drops": ({"droplets.density.number_per_m3": 0.0}, ("there are no drops",)),
    "night": ({"light.0.altitude_deg": -10.0}, ("10 deg below the horizon", "without air")),
    "dusk": ({"light.0.altitude_deg": -10.0, "atmosphere.rayleigh": True},
             ("10 deg below the horizon", "behind the Earth")),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_reason_and_a_value_that_helps(case):
    changes, words = CASES[case]
    (line,) = said("uniform", changes, light=float(case == "night"))
    assert all(word in line for word in words), line
    assert line.startswith("the picture is black: ") or case == "night"
    cure = {k: float(v) for k, v in re.findall(r"([a-z0-9_.]+_(?:deg|m3)) = (-?[\d.]+)", line)}
    assert cure, line
    assert said("uniform", changes | cure) == (), line


def test_a_lit_picture_without_a_bow_is_not_called_black():
    (line,) = said("uniform", CASES["high sun"][0])
    assert line.startswith("no bow in the picture: ")


def test_a_sun_by_time_is_given_no_altitude():
    (line,) = said("uniform", {"light": [TIMED]})
    assert "another light.0.time" in line
    assert "altitude_deg =" not in line


def test_rain_that_lets_no_light_through():
    thick = {"droplets.extinction": True, "droplets.density.number_per_m3": 1e9}
    (line,) = said("uniform", thick, light=0.0)
    assert "optical depth" in line
    assert "droplets.extinction = false" in line


def test_each_part_of_a_split_picture_speaks_once():
    high = {"compare.split": 0.5, "compare.right": {"light.0.altitude_deg": 60.0}}
    (line,) = said("uniform", high)
    assert "60 deg high" in line
    both = {"light.0.altitude_deg": 60.0, "compare.split": 0.5}
    both["compare.right"] = {"droplets.density.number_per_m3": 500.0}
    assert len(said("uniform", both)) == 1


def test_the_renderer_says_it_of_its_last_frame():
    lit = rtbow.load_scene("uniform", SMALL)
    black = rtbow.load_scene("uniform", {**SMALL, "camera.azimuth_deg": 180.0})
    with rtbow.Renderer(black) as renderer:
        assert renderer.unseen == ()
        assert not renderer.render("reference").any()
        assert renderer.unseen == said("uniform", {"camera.azimuth_deg": 180.0}, light=0.0)
        renderer.show(lit)
        assert renderer.render("reference").any()
        assert renderer.unseen == ()


@pytest.mark.parametrize("low", [-300.0, -900.0])
def test_rain_below_the_ground_is_hidden_by_it(low):
    buried = {"droplets.box_m": [[-500.0, 300.0, low], [500.0, 1200.0, 0.0]]}
    (line,) = said("uniform", {**buried, "ground.albedo": 0.3})
    assert line.startswith("no bow in the picture: the rain (droplets.box_m) lies below the ground")
    assert not any("below the ground" in line for line in said("uniform", buried))
    part = {"droplets.box_m": [[-500.0, 300.0, low], [500.0, 1200.0, 900.0]]}
    assert said("uniform", {**part, "ground.albedo": 0.3}) == ()


def test_before_a_sky_the_picture_is_not_black_and_the_reason_stands():
    (line,) = said("uniform", {"atmosphere.sky": True, "light.0.altitude_deg": 60.0})
    assert line.startswith("no bow in the picture: the sun (light.0) is 60 deg high")
