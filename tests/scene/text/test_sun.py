"""The sun by place and time in one text, and scenes to begin with."""

from __future__ import annotations

import io
from datetime import UTC, datetime

import pytest

import rtbow
import rtbow.cli.scenes.new
from command_line import assert_refused, names
from rtbow.scene.text.sun import SunAt
from rtbow.world.rain.volume import scene_volume

OSLO = "59.9,10.7,2026-07-01T19:30+02:00"
EVENING = datetime(2026, 7, 1, 17, 30, tzinfo=UTC)


@pytest.mark.parametrize(
    "sun",
    [OSLO, "59.9, 10.7, 2026-07-01T17:30Z", "59.9,10.7,2026-07-01 17:30", (59.9, 10.7, EVENING),
     (59.9, 10.7, "2026-07-01T19:30+02:00"), SunAt(59.9, 10.7, EVENING)],
)  # fmt: skip
def test_the_sun_of_a_place_and_time(sun):
    light = rtbow.load_scene("uniform", sun=sun).light[0]
    # NOAA's solar calculator gives 18.8 and 283.9 degrees.
    assert light.altitude_deg == pytest.approx(18.8, abs=0.1)
    assert light.azimuth_deg == pytest.approx(283.9, abs=0.1)
    assert rtbow.load_scene("uniform", sun=sun).source_text.count("# --set light.0.time=") == 1


def test_the_first_sun_is_meant():
    lights = [{"type": "point", "position_m": [0, 0, 5], "luminous_flux_lm": 9.0}, {}, {}]
    lamp, sun, other = rtbow.load_scene("uniform", {"light": lights}, OSLO).light
    assert (lamp.type, sun.altitude_deg > 18.0, other.altitude_deg) == ("point", True, 20.0)
    changed = rtbow.load_scene("street-lamp", {"light.0.type": "sun"}, OSLO)
    assert changed.light[0].azimuth_deg == pytest.approx(283.9, abs=0.1)


@pytest.mark.parametrize(
    ("scene", "changes", "sun", "words"),
    [
        ("uniform", {}, "59.9,10.7", "must be latitude, longitude (degrees, north"),
        ("uniform", {}, 5, "sun 5: must be latitude, longitude"),
        ("uniform", {}, "59.9,10.7,2026-07-01", "is a date without a time"),
        ("uniform", {}, "59.9,10.7,noon", "noon is no date and time; write for example 2026"),
        ("uniform", {}, "99,10.7,2026-07-01T12:00Z", "latitude = 99; must be -90..90"),
        ("uniform", {}, "nan,10.7,2026-07-01T12:00Z", "latitude = nan; must be -90..90"),
        ("uniform", {}, "9,10.7,1066-07-01T12:00Z", "year 1066: must be 1900..2100"),
        ("uniform", {"light.0.altitude_deg": 5}, OSLO, "light.0.altitude_deg: the sun is placed"),
        ("street-lamp", {}, OSLO, "street-lamp: has no sun to be placed by time"),
    ],
)
def test_what_is_no_place_and_time(scene, changes, sun, words):
    with pytest.raises(rtbow.InputError) as caught:
        rtbow.load_scene(scene, changes, sun)
    assert words in str(caught.value)


# --- rtbow new


@pytest.mark.parametrize(
    ("options", "rate"),
    [((), 5.0), (("--sun", OSLO, "--rain", "20"), 20.0), (("--lamp", "LED-B3"), 5.0),
     (("--rain", "0.3"), 0.3)],
)  # fmt: skip
def test_a_scene_to_begin_with(call, tmp_path, options, rate):
    result = call("new", "bow.toml", *options)
    assert result.code == 0
    assert result.out == "bow.toml\nrtbow render bow.toml -o bow.png\n"
    assert ("note: the sun at 2026-07-01T19:30" in result.err) == ("--sun" in options)
    assert result.err.count("note: ") == ("--sun" in options)
    scene = rtbow.load_scene(tmp_path / "bow.toml")
    assert scene.camera.look == "bow-top"
    low, high = scene_volume(scene).box_m
    assert (low <= scene.camera.position_m).all()
    assert (scene.camera.position_m <= high).all()
    # Marshall and Palmer's law of drop sizes is not exact in the rate.
    assert rain_rate_of(call) == pytest.approx(rate, rel=0.2)


def rain_rate_of(call) -> float:
    """Read the rain rate that ``rtbow info`` works out from the drops."""
    line = next(x for x in call("info", "bow.toml").out.splitlines() if "mm/h" in x)
    return float(line.split("mm/h")[0].split()[-1])


def test_new_says_where_no_bow_is(call, tmp_path):
    noon = call("new", "noon.toml", "--sun", "0,0,2026-03-20T12:00Z")
    assert noon.code == 0
    assert "more than the 42.5 of the primary bow, which lies wholly below the horizon" in noon.err
    night = call("new", "night.toml", "--sun", "48,11,2026-03-20T00:00Z")
    assert "below the horizon: it lights no rain" in night.err
    assert names(tmp_path) == ["night.toml", "noon.toml"]


def test_new_replaces_nothing_unasked(call, tmp_path):
    (tmp_path / "bow.toml").write_text("mine", "utf-8")
    assert_refused(call("new", "bow.toml"), "bow.toml: exists; choose another name, or add --over")
    assert (tmp_path / "bow.toml").read_text("utf-8") == "mine"
    assert call("new", "bow.toml", "--overwrite").code == 0
    assert rtbow.load_scene(tmp_path / "bow.toml").camera.look == "bow-top"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("bow.png",), "must be .toml"),
        (("no/bow.toml",), "there is no folder no"),
        (("bow.toml", "--rain", "0"), "is not a rain rate; write a number of mm/h"),
        (("bow.toml", "--rain", "nan"), "is not a rain rate"),
        (("bow.toml", "--lamp", "LED-B33"), "LED-B33"),
        (("bow.toml", "--lamp", "no.csv"), "no.csv"),
        (("bow.toml", "--lamp", "HP1", "--sun", OSLO), "--lamp takes the sun's place"),
    ],
)
def test_what_new_refuses(call, tmp_path, options, words):
    assert_refused(call("new", *options), words)
    assert names(tmp_path) == []


def test_a_terminal_is_asked(call, tmp_path, monkeypatch):
    monkeypatch.setattr(rtbow.cli.scenes.new, "_asks", lambda: True)
    answers = "95,10.7\n59.9,10.7\n2026-07-01\n2026-07-01T19:30+02:00\n20\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(answers))
    result = call("new", "bow.toml")
    assert result.code == 0
    assert "latitude = 95; must be" in result.err
    assert "is a date without a time" in result.err
    scene = rtbow.load_scene(tmp_path / "bow.toml")
    assert scene.light[0].azimuth_deg == pytest.approx(283.9, abs=0.1)
    assert scene.droplets.density.rain_rate_mm_h == 20.0
