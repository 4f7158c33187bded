"""Cameras that look at the bow, rain around them, and what is said of bows that nobody sees."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.values import changed_scene, differences, scene_text, values_of
from rtbow.sequence.animation import Move, plan_animation
from rtbow.view.picture.navigate import fly, towards
from rtbow.world.visibility import horizon_notes, sun_notes
from rtbow.world.world import moved, resolve
from textbook import towards as unit

INDEX = 1.33300
"""Of water at 20 °C and 589.3 nm (Handbook of Chemistry and Physics)."""


def bow_radius_deg(reflections: int, index: float = INDEX) -> float:
    """Find the ray of least deviation among a million, by Snell's law alone."""
    incidence = np.linspace(0.0, np.pi / 2, 1_000_001)[1:-1]
    refraction = np.arcsin(np.sin(incidence) / index)
    deviation = reflections * np.pi + 2 * incidence - 2 * (reflections + 1) * refraction
    least = np.degrees(deviation.min())
    return 180.0 - least if reflections == 1 else least - 180.0


def looking(scene) -> np.ndarray:
    return unit(scene.camera.azimuth_deg, scene.camera.altitude_deg)


def sunny(look: object, altitude: float, azimuth: float, **changes: object):
    sun = {"light.0.altitude_deg": altitude, "light.0.azimuth_deg": azimuth}
    return rtbow.load_scene("uniform", {"camera.look": look, **sun, **changes})


@pytest.mark.parametrize(("altitude", "azimuth"), [(20, 180), (3.5, 275.25), (-4, 10), (70, 333)])
def test_looks_at_the_sun_and_opposite_to_it(altitude, azimuth):
    sun = unit(azimuth, altitude)
    np.testing.assert_allclose(looking(sunny("sun", altitude, azimuth)), sun, atol=1e-7)
    np.testing.assert_allclose(looking(sunny("antisolar", altitude, azimuth)), -sun, atol=1e-7)
    top = looking(sunny("bow-top", altitude, azimuth))
    assert np.degrees(np.arccos(top @ -sun)) == pytest.approx(bow_radius_deg(1), abs=0.01)
    # No other point of the circle is higher: sun, zenith and top are in one plane.
    assert np.cross(sun, [0.0, 0.0, 1.0]) @ top == pytest.approx(0.0, abs=1e-7)
    assert top[2] == pytest.approx(np.sin(np.radians(bow_radius_deg(1) - altitude)), abs=2e-4)


def test_the_top_beyond_the_zenith():
    scene = sunny("bow-top", -60.0, 90.0)
    assert scene.camera.azimuth_deg == 90.0
    assert scene.camera.altitude_deg == pytest.approx(180.0 - 60.0 - bow_radius_deg(1), abs=0.01)


def test_the_top_of_other_bows():
    secondary = sunny("bow-top", 10.0, 0.0, **{"scattering.orders": [2]})
    assert secondary.camera.altitude_deg == pytest.approx(bow_radius_deg(2) - 10.0, abs=0.01)
    glass = sunny("bow-top", 5.0, 0.0, **{"scattering.refractive_index": 1.5})
    assert glass.camera.altitude_deg == pytest.approx(bow_radius_deg(1, 1.5) - 5.0, abs=1e-3)


def test_a_lamp_and_the_top_of_its_bow():
    eye, lamp = np.array([0.0, 7.0, 1.5]), np.array([0.0, 0.0, 6.0])
    way = (lamp - eye) / np.linalg.norm(lamp - eye)
    at_lamp = rtbow.load_scene("street-lamp", {"camera.look": "lamp"})
    np.testing.assert_allclose(looking(at_lamp), way, atol=1e-7)
    away = rtbow.load_scene("street-lamp", {"camera.look": "antisolar"})
    np.testing.assert_allclose(looking(away), -way, atol=1e-7)
    # The box begins 1 m before the eye: a drop there, on the line of sight, sees the bow's angle.
    top = looking(rtbow.load_scene("street-lamp", {"camera.look": "bow-top"}))
    drop = eye + 1.0 * top
    sides = [(x - drop) / np.linalg.norm(x - drop) for x in (eye, lamp)]
    assert np.degrees(np.arccos(sides[0] @ sides[1])) == pytest.approx(bow_radius_deg(1), abs=0.01)
    inside = {"camera.look": "bow-top", "droplets.around_m": [50, 30]}
    within = looking(rtbow.load_scene("street-lamp", inside))
    assert np.degrees(np.arccos(within @ -way)) == pytest.approx(bow_radius_deg(1), abs=0.01)


def test_angles_in_one_list():
    scene = rtbow.load_scene("uniform", {"camera.look": [250, 12.5]})
    camera = scene.camera
    assert (camera.azimuth_deg, camera.altitude_deg, camera.look) == (250.0, 12.5, None)


def test_rain_around_the_camera():
    around = {"droplets.around_m": [300, 200], "camera.position_m": [10.0, -20.0, 2.0]}
    scene = rtbow.load_scene("uniform", around)
    assert scene.droplets.box_m == ((-290.0, -320.0, 0.0), (310.0, 280.0, 202.0))
    below = changed_scene(scene, {"camera.position_m": [0.0, 0.0, -30.0]})
    assert below.droplets.box_m == ((-300.0, -300.0, -30.0), (300.0, 300.0, 170.0))
    edge = changed_scene(scene, {"camera.position_m": [1e7, 0.0, 0.0]})
    assert edge.droplets.box_m[1][0] == 1e7


def test_text_and_differences_read_back():
    plain = rtbow.load_scene("uniform")
    scene = changed_scene(plain, {"camera.look": "antisolar", "droplets.around_m": [50, 40]})
    assert {"azimuth_deg", "altitude_deg"}.isdisjoint(values_of(scene)["camera"])
    assert "box_m" not in values_of(scene)["droplets"]
    assert scene_from_text(scene_text(scene)) == scene
    assert type(scene).model_validate(scene.model_dump()) == scene
    assert changed_scene(plain, differences(plain, scene)) == scene
    assert changed_scene(scene, differences(scene, plain)) == plain


def test_the_last_choice_wins_and_the_view_follows():
    scene = sunny("antisolar", 20.0, 180.0)
    later = changed_scene(scene, {"light.0.altitude_deg": 5.0, "light.0.azimuth_deg": 250.0})
    assert (later.camera.azimuth_deg, later.camera.altitude_deg) == (70.0, -5.0)
    world = resolve(scene)
    shared = moved(world, later)
    assert shared is not None
    assert shared.volume is world.volume
    np.testing.assert_allclose(shared.view.basis[0], -unit(250.0, 5.0), atol=1e-7)
    by_hand = changed_scene(later, {"camera.altitude_deg": 5.0})
    assert (by_hand.camera.look, by_hand.camera.altitude_deg) == (None, 5.0)
    assert changed_scene(by_hand, {"camera.look": "sun"}).camera.altitude_deg == 5.0
    around = changed_scene(scene, {"droplets.around_m": [50, 40]})
    box = [[0.0, 9.0, 0.0], [5.0, 19.0, 5.0]]
    assert changed_scene(around, {"droplets.box_m": box}).droplets.around_m is None


def test_turning_and_flying_by_hand():
    scene = sunny("antisolar", 20.0, 180.0, **{"droplets.around_m": [50, 40]})
    turned = scene.with_camera(towards(scene.camera, np.array([1.0, 0.0, 0.0])))
    assert (turned.camera.look, turned.camera.azimuth_deg) == (None, 90.0)
    flown = scene.with_camera(fly(scene.camera, 0.0, 0.0, 1.0, 1.0, 10.0))
    assert flown.camera.look == "antisolar"
    assert flown.droplets.box_m[1][2] == pytest.approx(51.6)


def test_films_follow_the_sun():
    overrides = {"camera.look": "bow-top"}
    film = plan_animation("uniform", overrides, 3, [Move("light.0.altitude_deg", 0.0, 50.0)])
    tops = [film.at(number).camera.altitude_deg for number in range(3)]
    assert tops == pytest.approx([bow_radius_deg(1) - sun for sun in (0.0, 25.0, 50.0)], abs=0.01)
    assert film.only_places
    (note,) = film.notes()
    assert note.startswith("frame 2: light.0: the sun stands at 50.0 degrees")
    around = {"droplets.around_m": [50, 40]}
    flight = plan_animation("uniform", around, 2, [Move("camera.position_m.0", 0.0, 9.0)])
    assert not flight.only_places


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"camera.look": "up"}, 'camera.look = "up"; must be one of "antisolar", "sun", "bow-top"'),
        ({"camera.look": [1]}, "or [azimuth, altitude] in degrees, the altitude -90..90"),
        ({"camera.look": [1, 95]}, "or [azimuth, altitude] in degrees, the altitude -90..90"),
        ({"camera.look": True}, "or [azimuth, altitude]"),
        ({"camera.look": "lamp"}, "the scene has no lamp; write"),
        (
            {"camera.look": "sun", "camera.azimuth_deg": 3},
            "camera.azimuth_deg cannot be given together with camera.look; leave one of the two",
        ),
        ({"camera.look": [1, 2], "camera.altitude_deg": 3}, "camera.altitude_deg cannot be given"),
        (
            {"droplets.around_m": [5, 5], "droplets.box_m": [[0, 0, 0], [1, 1, 1]]},
            "droplets.box_m cannot be given together with droplets.around_m; leave one of the two",
        ),
        ({"droplets.around_m": [5]}, "must be a list of 2 numbers, each 0.001..1e7"),
        ({"droplets.around_m": [0, 5]}, "droplets.around_m.0 = 0; must be 0.001..1e7"),
        ({"droplets.box_m": None}, "or rain around the camera, such as around_m = [1000, 800]"),
    ],
)
def test_what_is_refused(changes, words):
    with pytest.raises(rtbow.InputError) as caught:
        rtbow.load_scene("uniform", changes)
    assert words in str(caught.value)


def test_scenes_of_one_kind_of_light_and_of_files():
    with pytest.raises(rtbow.InputError, match="the scene has no sun; write"):
        rtbow.load_scene("street-lamp", {"camera.look": "sun"})
    with pytest.raises(rtbow.InputError, match=r"around_m cannot be .* carries its own box"):
        rtbow.load_scene("shower", {"droplets.around_m": [5, 5]})


# --- What is below the horizon, or out of the picture


@pytest.mark.parametrize(
    ("altitude", "count", "words"),
    [(42.0, 0, ""), (43.0, 1, "the 42.5 of the primary bow"), (54.0, 2, "of the secondary bow"),
     (-0.2, 0, ""), (-3.0, 1, "stands at -3.0 degrees, below the horizon")],
)  # fmt: skip
def test_suns_and_bows_below_the_horizon(altitude, count, words):
    notes = horizon_notes(rtbow.load_scene("uniform", {"light.0.altitude_deg": altitude}))
    assert len(notes) == count
    assert words in " ".join(notes)


def test_whether_the_bow_is_in_the_picture():
    sun = "59.9,10.7,2026-07-01T19:30+02:00"
    placed, outside = sun_notes(rtbow.load_scene("uniform", sun=sun))
    assert "altitude 18.78, azimuth 283.89 degrees" in placed
    assert "the bow is outside the picture: its centre is at azimuth 103.9" in outside
    turned = {"camera.look": "bow-top"}
    assert len(sun_notes(rtbow.load_scene("uniform", turned, sun))) == 1
    dry = {**turned, "droplets.box_m": [[0, 200, 0], [100, 300, 9]]}
    assert "there is no rain where the bow would be" in sun_notes(
        rtbow.load_scene("uniform", dry, sun)
    )[1]  # fmt: skip
    rain = {**turned, "droplets.around_m": [1000, 800]}
    assert len(sun_notes(rtbow.load_scene("uniform", rain, sun))) == 1
    assert sun_notes(rtbow.load_scene("uniform")) == ()
