"""Scenes made in Python: from dicts, keyword arguments and arrays."""

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.scene.text.file import scene_from_text
from rtbow.world.world import moved, resolve
from scene_samples import BASE

CAMERA = {"size_px": (64, 36)}
DROPLETS = {
    "box_m": [[-1500.0, 200.0, 0.0], np.array([1500.0, 1200.0, 1100.0])],
    "radius": {"distribution": "constant", "radius_um": np.float64(500)},
    "density": {"number_per_m3": 1000},
}
NM = np.linspace(380.0, 780.0, 41)
BOX = [[-500, 200, 0], [500, 900, 800]]


def rain(**changes):
    number = np.zeros((4, 3, 2))
    number[1:3] = 300.0
    return rtbow.Volume(**{"radius_um": 400.0, "number_per_m3": number, "box_m": BOX} | changes)


def test_the_same_as_from_a_file():
    expected = scene_from_text(BASE)
    sun = {"type": "sun", "altitude_deg": 20}
    whole = {"camera": CAMERA, "light": [sun], "droplets": DROPLETS}
    assert rtbow.make_scene(whole) == expected
    assert rtbow.make_scene(**whole) == expected
    got = rtbow.make_scene({"camera": CAMERA}, light=sun, droplets=DROPLETS)
    assert got == expected
    assert scene_from_text(got.source_text) == expected


def test_arrays_are_drawn():
    values = 1.0 + np.sin(NM / 30.0)
    volume = rain()
    scene = rtbow.make_scene(
        light=[{"spectrum": "mine"}, {"altitude_deg": 5.0}],
        droplets={"extinction": True},
        volume=volume,
        spectra={"mine": (NM, values)},
        compare={"right": {"light.1.spectrum": "mine"}},
        camera={"size_px": [8, 4]},
    )
    world = resolve(scene)
    spectrum = world.optics.suns[0].spectrum
    assert np.array_equal(spectrum.wavelength_nm, NM)
    assert spectrum.value / spectrum.value[0] == pytest.approx(values / values[0])
    assert np.array_equal(world.volume.number_per_m3, volume.number_per_m3)
    assert world.volume.radius_um[1, 0, 0] == 400.0
    assert np.array_equal(world.volume.box_m, BOX)
    (_, left), (right, _) = scene.parts()
    assert left.stop == 4
    assert right.light[1].spectrum == scene.light[0].spectrum
    # The same arrays are the same scene, whose world is kept; other arrays are another one.
    again = {"light": {"spectrum": "mine"}, "camera": {"size_px": [8, 4]}}
    first, second = (
        rtbow.make_scene(again, volume=rain(), spectra={"mine": (NM, values)}) for _ in range(2)
    )
    assert first == second
    world = resolve(first)
    followed = moved(world, second)
    assert followed is not None
    assert followed.volume is world.volume
    other = rtbow.make_scene(again, volume=rain(radius_um=401), spectra={"mine": (NM, values)})
    assert other != first


def test_later_changes_of_an_array_do_no_harm():
    number = np.full((2, 2, 2), 5.0)
    volume = rain(number_per_m3=number)
    number[:] = -1.0
    assert np.all(volume.number_per_m3 == 5.0)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"radius_um": -3.0}, "Volume: radius_um[1, 0, 0] = -3 where number_per_m3 is 300"),
        ({"number_per_m3": 5.0}, "Volume: radius_um () and number_per_m3 ()"),
        ({"radius_um": np.ones((2, 2))}, "do not fit; give both one shape"),
        ({"radius_um": "wide"}, "Volume: radius_um: must be an array of numbers"),
        ({"radius_um": 1j}, "Volume: radius_um: must be an array of numbers"),
        ({"box_m": [[0, 0, 0], [1, 1]]}, "Volume: box_m: must be an array of numbers"),
        ({"box_m": [[0, 0, 0], [1, 1, -1]]}, "the second greater along east, north and up"),
        ({"number_per_m3": np.full((2, 2, 2), np.nan)}, "= nan"),
    ],
)
def test_what_is_no_volume(changes, says):
    with pytest.raises(InputError) as caught:
        rain(**changes)
    assert says in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({}, "scene: droplets is missing"),
        ({"lihgt": {}}, "scene: unknown key lihgt; did you mean light?"),
        ({"light": {"altitude_deg": 91}}, "scene: light.0.altitude_deg = 91; must be -90..90 deg"),
        ({"light": {"spectrum": "sodium"}}, "scene: light.0.spectrum: spectrum 'sodium' is not"),
        ({"light": {"spectrum": "no.csv"}}, "no.csv"),
        ({"droplets": {"file": "no.npz"}}, "scene: droplets.file: "),
        ({"volume": 3}, "volume is of type int; must be a rtbow.Volume"),
        ({"volume": rain(), "droplets": {"file": "no.npz"}}, "droplets.file is given, too"),
        ({"volume": rain(), "droplets": {"grid": [2, 2, 2]}}, "droplets.grid cannot be given"),
        ({"spectra": {"FL2": (NM, NM)}}, "the name of a built-in spectrum"),
        ({"spectra": {"a/b": (NM, NM)}}, "must be named by a word"),
        ({"spectra": {"mine": NM}}, "must be a pair of arrays"),
        ({"spectra": {"mine": (NM, NM[1:])}}, "must be two of one length"),
        ({"spectra": {"mine": (NM, NM * np.nan)}}, "must hold finite numbers"),
        ({"spectra": {"mine": (NM, NM)}}, 'no light has spectrum = "mine"'),
        ({"light": {"spectrum": "mine"}, "spectra": {"mine": (NM[5:], NM[5:])}},
         'light.0.spectrum: spectra["mine"]: covers 430-780 nm'),
        ({"light": {"spectrum": "mine"}, "spectra": {"mine": (NM, -NM)}}, 'spectra["mine"]'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_when_the_scene_is_made(arguments, says):
    given = {"light": {}, **({"droplets": DROPLETS} if "volume" not in arguments else {})}
    if not arguments:
        given = {"light": {}}
    with pytest.raises(InputError) as caught:
        rtbow.make_scene(**{**given, **arguments})
    assert says in str(caught.value)
    assert "rtbow-arrays" not in str(caught.value)


def test_a_dict_that_is_none():
    for values, says in [("uniform", "use load_scene"), ({"light": {}}, "light is given twice")]:
        with pytest.raises(InputError, match=says):
            rtbow.make_scene(values, light={})
