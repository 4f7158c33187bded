"""The scene's models: defaults, limits, cross checks, and the document that describes them."""

import math
import pickle
import re
from typing import Any

import pytest
from pydantic import ValidationError

from checkout import ROOT as CHECKOUT
from rtbow.scene.droplets import Density, Droplets, density_key
from rtbow.scene.lights import SunLight
from rtbow.scene.model import Camera, Render, Scattering, Scene
from rtbow.scene.radius import ConstantRadius, MarshallPalmerRadius
from rtbow.scene.text.file import parse_set, scene_from_text
from rtbow.scene.text.schema import ROOT, Node, node_at, suggestion, toml_text, walk_fields

README = CHECKOUT / "scenes" / "README.md"


def droplets(**changes: Any) -> dict[str, Any]:
    parts: dict[str, Any] = {
        "box_m": [[-1, -2, -3], [1, 2, 3]],
        "radius": {"distribution": "constant", "radius_um": 500},
        "density": {"number_per_m3": 1000},
    }
    return {key: value for key, value in (parts | changes).items() if value is not None}


def scene(**changes: Any) -> Scene:
    return Scene.model_validate({"light": [{}], "droplets": droplets()} | changes)


def test_defaults_are_those_of_the_documented_example():
    got = scene()
    assert got.camera == Camera(
        position_m=(0.0, 0.0, 1.6),
        azimuth_deg=0.0,
        altitude_deg=20.0,
        fov_deg=75.0,
        size_px=(1280, 720),
    )
    assert got.light == (
        SunLight(
            type="sun",
            altitude_deg=20.0,
            azimuth_deg=180.0,
            spectrum="E490",
            angular_diameter_deg=0.533,
            irradiance_w_m2=None,
        ),
    )
    assert got.droplets.grid is None
    assert got.droplets.seed == 1
    assert got.droplets.extinction is False
    assert got.atmosphere is None
    assert got.scattering == Scattering(theory="airy", orders=(1, 2), water_temperature_c=20.0)
    assert got.render == Render(wavelength_step_nm=5.0, steps=None)


def test_an_empty_atmosphere_table_means_air():
    assert scene(atmosphere={}).atmosphere.rayleigh is True


def test_integers_become_floats_and_lists_become_tuples():
    got = scene()
    assert got.droplets.box_m == ((-1.0, -2.0, -3.0), (1.0, 2.0, 3.0))
    assert isinstance(got.droplets.box_m[0][0], float)
    assert isinstance(got.droplets.radius.radius_um, float)


def test_a_scene_survives_dump_json_and_pickle():
    got = scene(atmosphere={}, render={"steps": 8}).with_source("text", "name")
    assert Scene.model_validate(got.model_dump()) == got
    assert Scene.model_validate_json(got.model_dump_json()) == got
    copy = pickle.loads(pickle.dumps(got))
    assert copy == got
    assert (copy.source_text, copy.source_name) == ("text", "name")


def test_a_scene_is_frozen_hashable_and_equal_by_value():
    got = scene()
    with pytest.raises(ValidationError):
        got.camera.fov_deg = 3.0
    with pytest.raises(ValidationError):
        got.render = Render()
    other = got.with_source("another text", "another name")
    assert other == got
    assert hash(other) == hash(got)
    assert got.source_text == ""  # with_source leaves the first one alone
    assert scene(render={"steps": 3}) != got
    assert got != "scene"


def test_orders_are_sorted_so_that_equal_sets_are_equal():
    assert Scattering(orders=(2, 1)) == Scattering(orders=(1, 2))


@pytest.mark.parametrize("radius_um", [1, 5000, 1.5])
def test_both_ends_of_the_radius_range_are_allowed(radius_um):
    assert ConstantRadius(distribution="constant", radius_um=radius_um).radius_um == radius_um


@pytest.mark.parametrize("radius_um", [0.999, 5000.1, math.nan, math.inf, True, "500"])
def test_radii_outside_it_are_not(radius_um):
    with pytest.raises(ValidationError):
        ConstantRadius(distribution="constant", radius_um=radius_um)


@pytest.mark.parametrize("step", [0.05, 0.1, 1, 2.5, 5, 6.25, 8, 10, 40, 400 / 11, 400 / 17])
def test_steps_that_divide_the_range_are_allowed(step):
    assert Render(wavelength_step_nm=step).wavelength_step_nm == step


@pytest.mark.parametrize(
    ("step", "neighbours"),
    [(3, "2.5 and 3.125"), (7, "6.25 and 8"), (39, "25 and 40"), (0.051, "0.05 and 0.0625")],
)
def test_other_steps_name_neighbours_that_are_themselves_allowed(step, neighbours):
    with pytest.raises(ValidationError, match=f"as {neighbours} do"):
        Render(wavelength_step_nm=step)
    for neighbour in neighbours.split(" and "):
        Render(wavelength_step_nm=float(neighbour))


@pytest.mark.parametrize("distribution", ["uniform", "normal", "marshall-palmer"])
def test_a_distribution_needs_a_grid(distribution):
    keys = {"mean_um": 5, "std_um": 1} if distribution == "normal" else {"min_um": 1, "max_um": 2}
    parts = droplets(
        radius={"distribution": distribution, **keys},
        density={density_key(distribution): 5.0},
    )
    with pytest.raises(ValidationError, match="draws a radius at each grid point") as caught:
        Droplets.model_validate(parts)
    assert caught.value.errors()[0]["loc"] == ("grid",)
    assert Droplets.model_validate(parts | {"grid": [2, 3, 1024]}).grid == (2, 3, 1024)


def test_marshall_palmer_takes_a_rain_rate_and_no_number():
    radius = {"distribution": "marshall-palmer", "min_um": 50, "max_um": 2000}
    got = Droplets.model_validate(
        droplets(radius=radius, density={"rain_rate_mm_h": 5}, grid=[4, 4, 4])
    )
    assert got.radius == MarshallPalmerRadius(
        distribution="marshall-palmer", min_um=50.0, max_um=2000.0
    )
    assert got.density == Density(rain_rate_mm_h=5.0)


def test_a_file_stands_alone():
    assert Droplets(file="shower.npz").box_m is None
    assert Droplets(file="shower.npz", box_m=None, radius=None).box_m is None
    with pytest.raises(ValidationError) as caught:
        Droplets.model_validate(droplets(file="shower.npz", grid=[4, 4, 4]))
    where = [problem["loc"][0] for problem in caught.value.errors()]
    assert where == ["box_m", "grid", "radius", "density"]


def test_without_a_file_all_parts_are_required_at_once():
    with pytest.raises(ValidationError) as caught:
        Droplets()
    assert [p["loc"][0] for p in caught.value.errors()] == ["box_m", "radius", "density"]


def test_no_drops_is_an_allowed_density():
    assert Droplets.model_validate(droplets(density={"number_per_m3": 0})).density == Density(
        number_per_m3=0.0
    )


# --- the schema, asked by key


def fields() -> list[Any]:
    return [pytest.param(t, k, f, id=f"{t}.{k}") for t, k, f in walk_fields()]


def node_of(table: str, key: str) -> Node:
    node: Node | None = ROOT
    for part in [*table.split("."), key]:
        node = node.child(int(part) if part.isdigit() else part)
        assert node is not None
    return node


def test_the_walk_meets_every_table_once():
    places = [f"{table}.{key}" for table, key, _ in walk_fields()]
    assert len(places) == len(set(places))
    assert {place.rpartition(".")[0] for place in places} == {
        "camera",
        "light.0",
        "droplets",
        "droplets.radius",
        "droplets.density",
        "atmosphere",
        "atmosphere.aerosol",
        "ground",
        "scattering",
        "render",
        "compare",
    }


@pytest.mark.parametrize(("table", "key", "field"), fields())
def test_every_field_says_what_it_is_in_which_unit(table, key, field):
    assert field.description
    assert field.json_schema_extra["effect"]
    unit = field.json_schema_extra["unit"]
    suffixes = {
        "um": "µm",
        "km": "km",
        "m": "m",
        "deg": "deg",
        "px": "px",
        "nm": "nm",
        "m2": "W/m²",
        "m3": "1/m³",
        "h": "mm/h",
        "lm": "lm",
        "c": "°C",
        "mm": "mm",
        "kg": "g/kg",
        "du": "DU",
        "hpa": "hPa",
    }
    per_length = {"lambda_per_mm": "1/mm"}
    assert unit == per_length.get(key, suffixes.get(key.rpartition("_")[2], ""))


@pytest.mark.parametrize(
    ("table", "key", "expected"),
    [
        ("camera", "fov_deg", "a number, 1e-06 or more and less than 180 deg"),
        ("camera", "size_px", "a list of 2 whole numbers, each 1..16384 px"),
        ("camera", "azimuth_deg", "a number"),
        ("light.0", "irradiance_w_m2", "a number, greater than 0 and up to 1e12 W/m²"),
        ("light.0", "spectrum", "text in quotes"),
        ("droplets", "seed", "a whole number, 0 or more"),
        ("droplets", "box_m", "a list of 2 lists of 3 numbers, each -1e7..1e7 m"),
        ("droplets.radius", "std_um", "a number, 0.1..5000 µm"),
        (
            "droplets.radius",
            "distribution",
            'one of "constant", "uniform", "normal", "lognormal", "gamma", "modified-gamma",'
            ' "marshall-palmer", "table"',
        ),
        ("scattering", "theory", 'one of "airy", "mie"'),
        ("droplets.radius", "mixing", 'one of "per-point", "local"'),
        ("scattering", "orders", "a list of one or more whole numbers, each 1..2"),
        ("atmosphere", "rayleigh", "true or false"),
    ],
)
def test_the_schema_says_in_words_what_is_allowed(table, key, expected):
    assert node_of(table, key).expects() == expected


@pytest.mark.parametrize(
    ("unknown", "hint"),
    [
        ("lights", "did you mean light?"),
        ("seed", "did you mean droplets.seed?"),
        ("altitude_deg", "did you mean camera.altitude_deg or light.0.altitude_deg?"),
        (
            "xyz",
            "known here: camera, light, droplets, atmosphere, ground, scattering, render, compare",
        ),
    ],
)
def test_suggestions(unknown, hint):
    assert suggestion("", ROOT, unknown) == hint


# --- scenes/README.md


def readme_rows() -> dict[tuple[str, str], list[str]]:
    """Return the cells of each key's row, by table (as in ``--set``) and key."""
    rows = {}
    table = ""
    for line in README.read_text(encoding="utf-8").splitlines():
        if heading := re.fullmatch(r"## `\[+([a-z.]+)\]+`", line):
            table = {"light": "light.0"}.get(heading[1], heading[1])
        elif line.startswith("## "):
            table = ""
        elif table and (row := re.fullmatch(r"\| `([a-z0-9_]+)` \| (.*) \|", line)):
            cells = row[2].split(" | ")
            if len(cells) == 4:
                rows[table, row[1]] = cells
    return rows


def test_the_readme_knows_no_other_keys():
    assert readme_rows().keys() == {(table, key) for table, key, _ in walk_fields()}


@pytest.mark.parametrize(("table", "key", "field"), fields())
def test_the_readme_gives_each_keys_unit_range_and_default(table, key, field):
    unit, allowed, default, meaning = readme_rows()[table, key]
    assert unit == (field.json_schema_extra["unit"] or "–")
    node = node_of(table, key)
    item = node.child(0)
    while item is not None and item.child(0) is not None:
        item = item.child(0)
    assert (item or node).range in allowed
    for choice in re.findall(r'"[^"]+"', node.expects()):
        assert f"`{choice}`" in allowed
    if field.is_required():
        assert default == "required"
    elif field.default is None:
        assert default == "left out"
    else:
        assert default == f"`{toml_text(field.default)}`"
    assert meaning


def test_the_readmes_examples_work():
    text = README.read_text(encoding="utf-8")
    example, *additions = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    scene_from_text(example)
    assert len(additions) == 4
    for addition in additions:
        table = addition.splitlines()[0]
        if table in example.splitlines():  # instead of the example's own
            before, _, after = example.partition(f"{table}\n")
            scene_from_text(before + after[after.index("\n[") :] + addition)
        else:
            scene_from_text(example + addition)
    commands = re.search(r"```sh\n(.*?)```", text, re.DOTALL)[1].replace("\\\n", " ")
    for command in commands.splitlines():
        changes = dict(parse_set(arg) for arg in re.findall(r"--set (\S+)", command))
        assert changes
        scene_from_text(example, overrides=changes)
    for quoted in re.findall(r"`--set '(.*?)'`", text):
        scene_from_text(example, overrides=dict([parse_set(quoted)]))
    lights = dict([parse_set(re.search(r"`--set '(light=.*?)'`", text)[1])])
    assert len(scene_from_text(example, overrides=lights).light) == 2


def test_what_lies_under_a_key():
    for table, key, _ in walk_fields():
        assert node_at(f"{table}.{key}") is not None
    for key, kind in {
        "light.7.altitude_deg": float,
        "camera.position_m.2": float,
        "droplets.box_m.1.0": float,
        "droplets.grid.0": int,
        "camera.polarizer_deg": float,
        "droplets.radius.std_um": float,
        "compare.right.light.0.altitude_deg": float,
    }.items():
        found = node_at(key)
        assert found is not None
        assert found.annotation is kind
    for key in ("", "camera.", "camera.nope", "camera.position_m.3", "camera.position_m.x",
                "light.altitude_deg", "light.-1.altitude_deg", "camera.fov_deg.0"):  # fmt: skip
        assert node_at(key) is None, key
