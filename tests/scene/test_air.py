"""What air and ground refuse, each in one line that says what is allowed."""

from __future__ import annotations

import pytest

from rtbow.base.errors import InputError
from rtbow.physics.air.aerosol import MIXTURES, mixture_optics
from rtbow.scene.air import _MOST_VIOLET_DEPTH
from rtbow.scene.text.file import load_scene
from rtbow.tables.sky.field import FIELD_NM

AIR, HAZE = "atmosphere", "atmosphere.aerosol"
CUSTOM = {f"{HAZE}.model": "custom"}

REFUSED = [
    ({"ground.albedo": -0.1}, "ground.albedo = -0.1; must be 0..1"),
    ({"ground.albedo": 1.1}, "ground.albedo = 1.1; must be 0..1"),
    ({f"{AIR}.ozone_du": -1.0}, f"{AIR}.ozone_du = -1.0; must be 0..1000 DU"),
    ({f"{HAZE}.optical_depth_550": -0.1}, f"{HAZE}.optical_depth_550 = -0.1; must be 0..2"),
    ({f"{HAZE}.optical_depth_550": 2.1},
     f"{HAZE}.optical_depth_550 = 2.1; must be 0..2: up to there the sky holds its error"),
    ({**CUSTOM, f"{HAZE}.optical_depth_550": 1.9, f"{HAZE}.angstrom_exponent": 2.0},
     "a depth of 3.98 at 380 nm, where the sky holds its error up to 3.2; lower optical_depth_550"
     " or angstrom_exponent"),
    ({**CUSTOM, f"{HAZE}.single_scattering_albedo": 1.2}, "albedo = 1.2; must be 0..1"),
    ({**CUSTOM, f"{HAZE}.asymmetry": 1.0}, f"{HAZE}.asymmetry = 1.0; must be -0.9..0.9"),
    ({**CUSTOM, f"{HAZE}.asymmetry": -1.0}, f"{HAZE}.asymmetry = -1.0; must be -0.9..0.9"),
    ({**CUSTOM, f"{HAZE}.scale_height_m": 2e5}, "scale_height_m = 200000.0; must be 100..20000 m"),
    ({f"{HAZE}.asymmetry": 0.5}, 'asymmetry goes with model = "custom"; leave it out, or change'),
    ({f"{HAZE}.model": "urban"}, 'must be one of "continental-clean", "continental-average"'),
    ({f"{AIR}.rayleigh": False, f"{AIR}.sky": True}, f"{AIR}.sky = true; needs rayleigh = true"),
    ({f"{AIR}.rayleigh": False, f"{AIR}.ozone_du": 300.0}, "ozone_du = 300.0; needs rayleigh ="),
    ({f"{AIR}.rayleigh": False, **CUSTOM}, "needs rayleigh = true: there is no air without"),
    ({f"{AIR}.sky": True, "camera.position_m": [0.0, 0.0, -5.0]},
     "-5 m up; must be 0..100000 with atmosphere.sky or ground: above the ground"),
    ({"ground.albedo": 0.1, "camera.position_m": [0.0, 0.0, 2e5]}, "200000 m up; must be 0..1000"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "words"), REFUSED)
def test_what_is_refused(changes, words):
    with pytest.raises(InputError) as refused:
        load_scene("uniform", changes)
    assert words in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize("changes", [
    {f"{HAZE}.optical_depth_550": 2.0},
    {**CUSTOM, f"{HAZE}.optical_depth_550": 2.0, f"{HAZE}.angstrom_exponent": 1.2},
    {**CUSTOM, f"{HAZE}.angstrom_exponent": 4.0},
    {**CUSTOM, f"{HAZE}.single_scattering_albedo": 1.0, f"{HAZE}.asymmetry": -0.9},
    {f"{AIR}.sky": True, "camera.position_m": [0.0, 0.0, 0.0]},
])  # fmt: skip
def test_what_is_allowed_up_to_its_bound(changes):
    load_scene("uniform", changes)


def test_no_mixture_is_thicker_in_violet_than_a_free_aerosol_may_be():
    depths = [mixture_optics(mixture, FIELD_NM, 2.0).depth for mixture in MIXTURES.values()]
    assert 3.0 < max(depth.max() for depth in depths) < _MOST_VIOLET_DEPTH


def test_rain_around_an_eye_begins_at_its_ground():
    high = {"ground.height_m": 1200.0, "camera.position_m": [0.0, 0.0, 1300.0]}
    around = {"droplets.box_m": None, "droplets.around_m": [400.0, 700.0]}
    low, top = load_scene("uniform", {**high, **around}).droplets.box_m
    assert (low[2], top[2]) == (1200.0, 2000.0)
