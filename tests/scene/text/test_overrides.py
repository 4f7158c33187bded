"""Overrides: what they replace, add and drop, and what is said about wrong ones."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rtbow.scene.droplets import Density
from rtbow.scene.lights import PointLight
from rtbow.scene.radius import ConstantRadius, MarshallPalmerRadius, UniformRadius
from rtbow.scene.text.file import scene_from_text
from scene_samples import BASE, problems


def loaded(overrides: dict[str, Any], text: str = BASE):
    return scene_from_text(text, "storm.toml", overrides=overrides)


def test_overrides_replace_and_add_values():
    got = loaded(
        {
            "light.0.altitude_deg": 5,
            "camera.size_px": [640, 360],
            "camera.fov_deg": 60,
            "atmosphere.rayleigh": False,
            "render.steps": 9,
            "droplets.box_m.1.2": 900,
        }
    )
    assert got.light[0].altitude_deg == 5.0
    assert got.camera.size_px == (640, 360)
    assert got.camera.fov_deg == 60.0
    assert got.atmosphere.rayleigh is False
    assert got.render.steps == 9
    assert got.droplets.box_m[1] == (1500.0, 1200.0, 900.0)


def test_items_of_a_list_that_the_file_leaves_out_start_from_the_default():
    assert loaded({"camera.position_m.2": 50}).camera.position_m == (0.0, 0.0, 50.0)


def test_numpy_values_and_paths_are_taken_for_what_they_hold():
    got = loaded(
        {
            "camera.size_px": np.array([8, 4]),
            "droplets.seed": np.int64(7),
            "light.0.altitude_deg": np.float32(0.5),
            "light.0.spectrum": Path("lamp.csv"),
        }
    )
    assert got.camera.size_px == (8, 4)
    assert got.droplets.seed == 7
    assert got.light[0].altitude_deg == 0.5
    assert got.light[0].spectrum == str(Path.cwd() / "lamp.csv")


def test_whole_tables_come_before_keys_inside_them_and_are_not_changed():
    light = [{"altitude_deg": 1}, {"altitude_deg": 2}]
    got = loaded({"light.1.altitude_deg": 3, "light": light})
    assert [sun.altitude_deg for sun in got.light] == [1.0, 3.0]
    assert light == [{"altitude_deg": 1}, {"altitude_deg": 2}]


def test_none_takes_a_value_out():
    text = BASE + "[atmosphere]\n[render]\nsteps = 4\n"
    got = loaded({"atmosphere": None, "render.steps": None}, text)
    assert got.atmosphere is None
    assert got.render.steps is None


CHANGE = {
    "droplets.radius.distribution": "uniform",
    "droplets.radius.min_um": 300,
    "droplets.radius.max_um": 700,
    "droplets.grid": [4, 4, 4],
}


@pytest.mark.parametrize("keys", [list(CHANGE), list(reversed(CHANGE))])
def test_a_new_distribution_drops_the_keys_of_the_old_in_any_order(keys):
    got = loaded({key: CHANGE[key] for key in keys})
    assert got.droplets.radius == UniformRadius(distribution="uniform", min_um=300, max_um=700)
    assert got.droplets.density == Density(number_per_m3=1000.0)


def test_a_new_distribution_drops_the_other_way_to_give_the_density():
    rain = CHANGE | {
        "droplets.radius.distribution": "marshall-palmer",
        "droplets.density.rain_rate_mm_h": 5,
    }
    got = loaded(rain)
    assert got.droplets.radius == MarshallPalmerRadius(
        distribution="marshall-palmer", min_um=300, max_um=700
    )
    assert got.droplets.density == Density(rain_rate_mm_h=5.0)


LAMP = {"light.0.type": "point", "light.0.position_m": [0, 1, 2], "light.0.luminous_flux_lm": 9}


@pytest.mark.parametrize("keys", [list(LAMP), list(reversed(LAMP))])
def test_a_new_kind_of_light_drops_the_keys_of_the_old_in_any_order(keys):
    text = BASE.replace("altitude_deg = 20.0", 'altitude_deg = 20.0\nspectrum = "FL2"', 1)
    got = loaded({key: LAMP[key] for key in keys}, text)
    assert got.light == (
        PointLight(position_m=(0.0, 1.0, 2.0), luminous_flux_lm=9.0, spectrum="FL2"),
    )
    (line,) = problems(text, LAMP | {"light.0.altitude_deg": 3})
    assert line.startswith("--set light.0.altitude_deg does not belong to type")
    assert loaded({"light.0.type": "sun"}, text).light[0].altitude_deg == 20.0


def test_only_keys_of_the_old_distribution_are_dropped():
    text = BASE.replace("radius_um = 500.0", "radius_um = 500.0\nradius_mm = 3")
    (line,) = problems(text, CHANGE)
    assert line.startswith("storm.toml: unknown key droplets.radius.radius_mm")
    same = {"droplets.radius.distribution": "constant"}
    (line,) = problems(BASE.replace("radius_um =", "min_um = 3\nradius_um ="), same)
    assert line.startswith("storm.toml: droplets.radius.min_um does not belong")


@pytest.mark.parametrize(
    ("overrides", "line"),
    [
        (
            {"droplets.radius.distribution": "normal"},
            "--set droplets.radius.distribution: droplets.radius.mean_um is missing; ",
        ),
        ({"light.0.type": "point"}, "--set light.0.type: light.0.position_m is missing; "),
        ({"droplets.density.number_per_m3": None}, "--set droplets.density.number_per_m3"),
        ({"droplets.radius": None}, "--set droplets.radius"),
        ({"scattering.salinity_g_kg": 5, "scattering.refractive_index": 1.5}, "--set scattering."),
    ],
)
def test_an_override_is_to_blame_for_what_it_makes_wrong_elsewhere(overrides, line):
    assert problems(BASE, overrides)[0].startswith(line)


def test_of_several_overrides_the_one_to_blame_is_named():
    deep = BASE.replace("[-1500.0, 200.0, 0.0]", "[-1500.0, 200.0, -999999.0]")
    (line,) = problems(deep, {"atmosphere.rayleigh": True, "droplets.seed": 3})
    assert line.startswith(
        "--set atmosphere.rayleigh: droplets.box_m = [-1500.0, 200.0, -999999.0]"
    )
    salty = {"scattering.salinity_g_kg": 5, "scattering.water_temperature_c": 50}
    (line,) = problems(BASE, {"droplets.seed": 3, **salty})
    assert line.startswith("--set scattering.salinity_g_kg = 5; goes with")


def test_a_radius_table_replaces_the_whole_table():
    radius = {"distribution": "constant", "radius_um": 20}
    got = loaded({"droplets.radius": radius})
    assert got.droplets.radius == ConstantRadius(distribution="constant", radius_um=20)


def test_a_new_volume_file_replaces_the_description(tmp_path):
    got = loaded({"droplets.file": str(tmp_path / "a.npz"), "droplets.seed": 3})
    assert got.droplets.file == str(tmp_path / "a.npz")
    assert got.droplets.radius is None
    assert got.droplets.box_m is None


@pytest.mark.parametrize(
    ("overrides", "lines"),
    [
        (
            {"light.0.altitude_deg": 99},
            ["--set light.0.altitude_deg = 99; must be -90..90 deg"],
        ),
        (
            {"camera.size_px": [0, 16]},
            ["--set camera.size_px.0 = 0; must be 1..16384 px"],
        ),
        (
            {"camera.size_px.1": 0},
            ["--set camera.size_px.1 = 0; must be 1..16384 px"],
        ),
        (
            {"droplets.radius.distribution": "unform"},
            [
                '--set droplets.radius.distribution = "unform"; '
                'must be one of "constant", "uniform", "normal", "lognormal", "gamma", '
                '"modified-gamma", "marshall-palmer", "table"'
            ],
        ),
        (
            {"droplets.radius.min_um": 5},
            [
                '--set droplets.radius.min_um does not belong to distribution = "constant", '
                "which takes radius_um; leave it out or change the distribution "
                'to one of "uniform", "marshall-palmer"'
            ],
        ),
        (
            {"droplets.density.rain_rate_mm_h": 5},
            [
                "--set droplets.density.rain_rate_mm_h does not go with "
                'distribution = "constant"; give number_per_m3 instead'
            ],
        ),
        (
            {"droplets.file": "a.npz", "droplets.radius.radius_um": 5},
            [
                "--set droplets.radius cannot be given together with droplets.file: "
                "the volume file carries its own radius; leave one of the two out"
            ],
        ),
        (
            {"light": [{"foo": 3}]},
            [
                "--set: unknown key light.0.foo; known here: type, altitude_deg, azimuth_deg, "
                "spectrum, beyond, angular_diameter_deg, visible, irradiance_w_m2, time, "
                "latitude_deg, longitude_deg, moon_phase_deg, moon_distance_km"
            ],
        ),
        (
            {"droplets.radus.radius_um": 5, "camera.fov": 60},
            [
                "--set droplets.radus.radius_um: unknown key droplets.radus; "
                "did you mean droplets.radius?",
                "--set camera.fov: unknown key camera.fov; did you mean camera.fov_deg?",
            ],
        ),
        (
            {"light.1.altitude_deg": 5},
            ["--set light.1.altitude_deg: light has 1 item; the last is light.0"],
        ),
        (
            {"light.altitude_deg": 5},
            [
                "--set light.altitude_deg: light is a list of 1 item; "
                "name one by its number, such as light.0"
            ],
        ),
        (
            {"light.-1.altitude_deg": 5},
            [
                "--set light.-1.altitude_deg: light is a list of 1 item; "
                "name one by its number, such as light.0"
            ],
        ),
        (
            {"camera.size_px.2": 5},
            ["--set camera.size_px.2: camera.size_px has 2 items; the last is camera.size_px.1"],
        ),
        (
            {"droplets.grid.0": 5},
            ["--set droplets.grid.0: droplets.grid is not given; set it as a whole"],
        ),
        (
            {"camera.fov_deg.x": 5},
            [
                "--set camera.fov_deg.x: camera.fov_deg is a single value and has nothing "
                "inside it; write camera.fov_deg=…"
            ],
        ),
        ({"camera..x": 5}, ["--set camera..x: write a key such as light.0.altitude_deg"]),
    ],
    ids=lambda value: next(iter(value), "") if isinstance(value, dict) else "",
)
def test_a_wrong_override_is_named_as_one(overrides, lines):
    got = problems(BASE, overrides)
    assert sorted(got) == sorted(lines)


def test_a_wrong_file_stays_the_files_fault_beside_overrides():
    got = problems(
        BASE.replace("[camera]\nsize_px = [64, 36]", "camera = 5"),
        {"camera.fov_deg": 60, "light.0.altitude_deg": 99},
    )
    assert got == [
        "storm.toml: camera = 5; must be a table: write [camera]",
        "--set light.0.altitude_deg = 99; must be -90..90 deg",
    ]
