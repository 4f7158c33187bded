"""Lights placed by time and place, and the Moon."""

from __future__ import annotations

from datetime import datetime

import pytest

import rtbow
from rtbow.physics.light.sun_position import sun_position
from rtbow.scene.text.values import changed_scene, scene_text, values_of
from rtbow.world.lights import suns
from rtbow.world.world import moved, resolve

PLACE = {"light.0.latitude_deg": 48.1, "light.0.longitude_deg": 11.6}
TIME = "2013-05-27T17:46:00Z"
AT_TIME = {"light.0.time": TIME, **PLACE}


def test_sun_of_a_time():
    light = rtbow.load_scene("uniform", AT_TIME).light[0]
    sun = sun_position(datetime.fromisoformat(TIME), 48.1, 11.6)
    assert light.altitude_deg == pytest.approx(sun.altitude_deg, abs=1e-6)
    assert light.azimuth_deg == pytest.approx(sun.azimuth_deg, abs=1e-6)
    # TOML's own time is the same as its text.
    toml = rtbow.load_scene("uniform", {**AT_TIME, "light.0.time": datetime.fromisoformat(TIME)})
    assert toml.light[0].azimuth_deg == light.azimuth_deg


def test_text_reads_back():
    from rtbow.scene.text.file import scene_from_text

    scene = rtbow.load_scene("uniform", AT_TIME)
    text = scene_text(scene)
    assert "altitude_deg" not in text.split("[[light]]")[1].split("[droplets]")[0]
    assert values_of(scene_from_text(text, "again")) == values_of(scene)
    assert scene_from_text(text, "again").light == scene.light


def test_last_choice_wins():
    scene = rtbow.load_scene("uniform", AT_TIME)
    by_hand = changed_scene(scene, {"light.0.altitude_deg": 5.0}).light[0]
    assert (by_hand.altitude_deg, by_hand.time, by_hand.latitude_deg) == (5.0, None, None)
    later = changed_scene(scene, {"light.0.time": "2013-05-27T18:46:00Z"}).light[0]
    assert later.altitude_deg < scene.light[0].altitude_deg
    elsewhere = changed_scene(scene, {"light.0.latitude_deg": 10.0}).light[0]
    assert elsewhere.altitude_deg != scene.light[0].altitude_deg


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"light.0.time": TIME}, "give latitude_deg and longitude_deg"),
        ({**AT_TIME, "light.0.time": "noon"}, "'noon' is no date and time; write for example 2013"),
        ({**AT_TIME, "light.0.time": "2013-05-27T13:46:00"}, "has no offset from UTC"),
        ({**AT_TIME, "light.0.time": "1066-10-14T12:00Z"}, "year 1066: must be 1900..2100"),
        ({**AT_TIME, "light.0.latitude_deg": 91.0}, "latitude"),
        ({**AT_TIME, "light.0.altitude_deg": 5.0}, "beside time, which makes it"),
        ({"light.0.moon_phase_deg": 90.0}, 'goes with spectrum = "moon"'),
        ({"light.0.spectrum": "moon", "light.0.moon_phase_deg": 150.0}, "must be 0..120"),
    ],
)
def test_refused_times(changes, words):
    with pytest.raises(rtbow.InputError) as error:
        rtbow.load_scene("uniform", changes)
    assert words in str(error.value)


def test_world_follows_time():
    world = resolve(rtbow.load_scene("uniform", AT_TIME))
    after = moved(world, rtbow.load_scene("uniform", {**AT_TIME, "light.0.time": "2013-05-27T18Z"}))
    assert after is not None
    assert after.optics.suns[0].altitude_rad < world.optics.suns[0].altitude_rad


def test_moon_as_a_light():
    full, half = (
        suns(rtbow.load_scene("uniform", {"light.0.spectrum": "moon", "light.0.moon_phase_deg": g}))
        for g in (7.0, 90.0)
    )
    assert full[0].spectrum.visible / half[0].spectrum.visible == pytest.approx(9.3, rel=0.05)
    assert full[0].disc_rad == pytest.approx(0.00452, rel=1e-3)
    scene = rtbow.load_scene(
        "uniform", {**AT_TIME, "light.0.spectrum": "moon", "light.0.time": "2024-01-25T22:00Z"}
    )
    light = scene.light[0]
    assert light.moon_phase_deg == pytest.approx(4.0, abs=2.0)  # four hours after it was full
    assert light.altitude_deg > 50.0
