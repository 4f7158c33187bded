"""Shapes of method ``fast``'s programs: each compiles, and none carries what its scene lacks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rtbow.gl.context import GlContext, open_context
from rtbow.gl.glsl import Define, compile_program
from rtbow.gl.program import GlProgram
from rtbow.render.fast.method import FastMethod
from rtbow.render.spectral.method import SpectralMethod
from rtbow.scene.model import Scene
from rtbow.world.rain.volume import DropletVolume, save_volume
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

BOX = [[-50.0, 10.0, 0.0], [50.0, 90.0, 60.0]]
SUN = {"type": "sun", "altitude_deg": 20.0}
LAMP = {"type": "point", "position_m": [0.0, -2.0, 4.0], "luminous_flux_lm": 1000.0}
POINT = LAMP | {"diameter_m": 0.0}


# --- Scenes and the programs made for them ----------------------------------------------------


@pytest.fixture(scope="module")
def context() -> Iterator[GlContext]:
    context = open_context("osmesa")
    yield context
    context.close()


@dataclass(frozen=True)
class Made:
    """A program that a scene made.

    Attributes:
        fragment: file of its fragment stage.
        defines: its switches and constants.
        program: itself.
    """

    fragment: str
    defines: Mapping[str, Define]
    program: GlProgram


def save_grid(folder: Path, several: bool) -> str:
    """A smooth grid of drops in a file, of one radius or several."""
    place = np.linspace(0.0, 1.0, 6)[:, None, None] + np.zeros((6, 5, 4))
    radius = 5.0 + (0.5 * place if several else 0.0 * place)
    path = folder / f"several-{several}.npz"
    number = np.float32(1e4 * (1.0 + place))
    save_volume(DropletVolume(np.array(BOX), np.float32(radius), number), path)
    return str(path)


Switches = Mapping[str, Any]


def make(
    folder: Path, light: Switches = SUN, *, grid: bool = False, several: bool = False,
    air: bool = False, rain: bool = False, polarizer: bool = False,
) -> Scene:  # fmt: skip
    drops: dict[str, Any] = {
        "box_m": BOX,
        "radius": {"distribution": "constant", "radius_um": 5.0},
        "density": {"number_per_m3": 1e4},
    }
    if grid or several:
        drops = {"file": save_grid(folder, several)}
    parts = {
        "camera": {
            "size_px": [20, 12], "fov_deg": 4.0, "altitude_deg": 20.0,
            "polarizer_deg": 30.0 if polarizer else None,
        },
        "light": [dict(light)],
        "droplets": drops | ({"extinction": True} if rain else {}),
        "render": {"wavelength_step_nm": 40.0, "max_delta_e": 20.0},  # small tables
    } | ({"atmosphere": {}} if air else {})  # fmt: skip
    return Scene.model_validate(parts)


@pytest.fixture
def programs(context, monkeypatch, tmp_path) -> Callable[..., list[Made]]:
    """Give the programs that the shader makes for a scene, its tables' own left out."""
    made: list[Made] = []
    real = GlProgram.__init__

    def watched(self: GlProgram, gl: GlContext, fragment: str, defines: Any) -> None:
        real(self, gl, fragment, defines)
        made.append(Made(fragment, dict(defines), self))

    monkeypatch.setattr(GlProgram, "__init__", watched)

    def programs_of(
        light: Switches = SUN, method: Any = FastMethod, **switches: bool
    ) -> list[Made]:
        made.clear()
        with context.current():
            method(context, resolve(make(tmp_path, light, **switches))).draw()
        return [one for one in made if one.fragment != "fast/bake.frag"]

    return programs_of


def names_of(made: list[Made]) -> set[str]:
    assert made
    return set().union(*(one.program.names for one in made))


# --- Every shape compiles ---------------------------------------------------------------------

AIRS = {
    "none": {"AIR": False, "NEAR_AIR": False, "SHADOW": False},
    "near": {"AIR": True, "NEAR_AIR": True, "SHADOW": False},
    "far": {"AIR": True, "NEAR_AIR": False, "SHADOW": False},
    "shadow": {"AIR": True, "NEAR_AIR": False, "SHADOW": True},
    "edge": {"AIR": True, "NEAR_AIR": False, "SHADOW": True, "PIECES": 3},
}
RAINS = ((False, False), (True, False), (True, True))
DROPS = ((False, False), (True, False), (True, True))
BLOCKS = (False, True)


def shared(drops: Any, rain: Any, polarizer: bool, degree: int) -> dict[str, Define]:
    """Switches that suns and lamps share: grid, radii, rain, polariser, degree in the column."""
    return {
        "GRID": drops[0],
        "SEVERAL_RADII": drops[1],
        "RADIUS_ROWS": 9 if drops[1] else 1,
        "EXTINCTION": rain[0],
        "RAIN_COLOUR": rain[1],
        "LEAST_STEPS": 48 if rain[0] else (12 if drops[0] else 1),
        "POLARIZER": polarizer,
        "COMPONENTS": 2 if polarizer else 1,
        "COLUMN_DEGREE": degree,
    }


def sun_shapes() -> Iterator[dict[str, Define]]:
    every = product(DROPS, RAINS, (False, True), AIRS.values(), BLOCKS)
    for number, (drops, rain, polarizer, air, block) in enumerate(every):
        even = not drops[0] and not rain[0] and not air["SHADOW"]
        if even and block:
            continue
        # Loops over degrees and groups are alike in all of these: each shape has some other.
        degree = 1 + number % 5 if air["AIR"] else 0
        groups = 1 + number % 7 if drops[1] and block else 0
        yield {
            **shared(drops, rain, polarizer, degree),
            **air,
            "BLOCKS": block,
            "DIRECT": (4 if air["AIR"] else 1) if even else 0,
            "HAT_GROUPS": groups,
        }


def lamp_shapes() -> Iterator[dict[str, Define]]:
    every = product(DROPS, RAINS, (False, True), (False, True), (False, True), BLOCKS)
    for number, (drops, rain, polarizer, air, disc, block) in enumerate(every):
        even = not drops[0] and not rain[0]
        if block and even:
            continue
        yield {
            **shared(drops, rain, polarizer, 1 + number % 5 if air else 0),
            "AIR": air,
            "LAMP_DISC": disc,
            "EVEN": even,
            "EVEN_STEPS": 4 if air else 1,
            "BLOCKS": block,
        }


def compiled(context: GlContext, shapes: set[tuple[str, tuple[tuple[str, Define], ...]]]) -> int:
    with context.current() as ctx:
        for fragment, defines in sorted(shapes, key=str):
            compile_program(ctx, "common/fullscreen.vert", fragment, dict(defines)).release()
        assert ctx.error == "GL_NO_ERROR"
    return len(shapes)


def test_every_shape_under_a_sun_compiles(context, programs):
    base = programs(several=True, air=True)[0].defines
    shapes = set()
    for shape in sun_shapes():
        assert base.keys() >= shape.keys()
        whole = {**base, **shape}
        shapes.add(("fast/sun/pixel.frag", tuple(whole.items())))
        if shape["BLOCKS"]:
            # What these have no use for is left at one value: fewer that are truly different.
            plain = {"POLARIZER": False, "COMPONENTS": 1, "RAIN_COLOUR": False, "COLUMN_DEGREE": 0}
            path = {**whole, **plain}
            shapes.add(("fast/sun/node.frag", tuple(path.items())))
            if shape["HAT_GROUPS"]:
                some = {"HAT_GROUPS": shape["HAT_GROUPS"]}
                hats = {**base, **some, "BLOCKS": True, "SEVERAL_RADII": True}
                shapes.add(("fast/sun/hats.frag", tuple(hats.items())))
                shapes.add(("fast/flags.frag", tuple(hats.items())))
    flags = {**base, "SEVERAL_RADII": False, "HAT_GROUPS": 0, "BLOCKS": True}
    shapes.add(("fast/flags.frag", tuple(flags.items())))
    assert compiled(context, shapes) > 120


def test_every_shape_under_a_lamp_compiles(context, programs):
    base = programs(LAMP, several=True, air=True)[0].defines
    shapes = set()
    for shape in lamp_shapes():
        assert base.keys() >= shape.keys()
        whole = tuple({**base, **shape}.items())
        shapes.add(("fast/lamp/pixel.frag", whole))
        if shape["BLOCKS"]:
            shapes.add(("fast/lamp/node.frag", whole))
    flags = {**base, "SEVERAL_RADII": False, "PARTS": True}
    shapes.add(("fast/flags.frag", tuple(flags.items())))
    assert compiled(context, shapes) > 120


def test_every_shape_of_the_bake_compiles(context, monkeypatch, tmp_path):
    baked: list[Mapping[str, Define]] = []
    real = GlProgram.__init__

    def watched(self: GlProgram, gl: GlContext, fragment: str, defines: Any) -> None:
        real(self, gl, fragment, defines)
        if fragment == "fast/bake.frag":
            baked.append(dict(defines))

    monkeypatch.setattr(GlProgram, "__init__", watched)
    with context.current():
        FastMethod(context, resolve(make(tmp_path)))
    shapes = set()
    for disc, polarizer, count in product((False, True), (False, True), range(1, 9)):
        for sides in ("1.0", "-1.0", "1.0, -1.0"):
            bows = sides.count(",") + 1
            changes = {
                "DISC": disc, "POLE": disc, "WIDE": disc, "POLARIZER": polarizer,
                "OUTCOMES": count, "BOW_COUNT": bows, "BOW_SIDE": f"float[]({sides})",
            }  # fmt: skip
            assert baked[0].keys() >= changes.keys()
            shapes.add(("fast/bake.frag", tuple({**baked[0], **changes}.items())))
    assert compiled(context, shapes) == 96


# --- What a scene does not use ----------------------------------------------------------------

# What a program passes on counts as used as a whole: the members of these structs that every
# scene has ("air.eyeHeight", "rows.middle") say nothing.
AIR_NAMES = {
    "air.perMetre", "air.grey", "air.sunward", "air.sunAltitude", "air.table", "air.middle",
    "air.reach",
}  # fmt: skip
RADII_NAMES = {"hats", "hats0", "rows.first", "rows.perFold", "leastShare", "hatRow"}
GRID_NAMES = {"volume.moments", "volume.gridLow", "volume.gridPerMetre", "volume.toLight"}
NODE_NAMES = {"nodes", "flags", "tolerance.first", "manySteps"}
RAIN_NAMES = {"volume.toLight", "volume.extinction"}
BY_LIGHT = [("sun", SUN), ("lamp", LAMP), ("point", POINT)]
by_light = pytest.mark.parametrize("light", [light for _, light in BY_LIGHT],
                                   ids=[name for name, _ in BY_LIGHT])  # fmt: skip


@by_light
def test_an_even_volume_has_neither_grid_nor_nodes(programs, light):
    made = programs(light)
    assert len(made) == 1
    unused = AIR_NAMES | RADII_NAMES | GRID_NAMES | NODE_NAMES | RAIN_NAMES
    unused |= {"camera.pass", "march.cellsPerMetre", "march.airPerMetre", "march.fixedSteps"}
    assert not names_of(made) & unused
    assert "volume.density" in names_of(made)


@by_light
@pytest.mark.parametrize("grid", [False, True])
def test_air(programs, light, grid):
    assert not names_of(programs(light, grid=grid)) & AIR_NAMES
    wanted = {"air.eyeHeight", "air.grey"}
    wanted |= {"air.sunward", "air.perMetre"} if light is SUN else {"air.middle"}
    assert names_of(programs(light, grid=grid, air=True)) >= wanted


def test_a_sun_that_stands_high_has_no_table_of_columns(programs):
    assert not names_of(programs(air=True)) & {"air.table", "air.sunAltitude"}
    low = names_of(programs(SUN | {"altitude_deg": -0.1}, air=True))
    assert low >= {"air.table", "air.sunAltitude"}
    assert "air.sunward" not in low


@by_light
def test_radii(programs, light):
    one = names_of(programs(light, grid=True))
    assert not one & RADII_NAMES
    assert one >= {"volume.moments", "nodes", "flags"}
    assert "volume.density" not in one
    wanted = {"rows.middle", "rows.first"} | ({"hats", "firstRow"} if light is SUN else set())
    assert names_of(programs(light, several=True)) >= wanted


@by_light
@pytest.mark.parametrize("grid", [False, True])
def test_polarizer(programs, light, grid):
    assert "camera.pass" not in names_of(programs(light, grid=grid))
    assert "camera.pass" in names_of(programs(light, grid=grid, polarizer=True))


@by_light
def test_rain_that_does_not_dim(programs, light):
    assert not names_of(programs(light, grid=True)) & RAIN_NAMES
    grid = names_of(programs(light, grid=True, rain=True))
    assert "volume.toLight" in grid
    assert "volume.extinction" not in grid
    even = names_of(programs(light, rain=True))
    assert "volume.extinction" in even
    assert not even & GRID_NAMES


def test_a_point_lamp_has_no_disc(programs):
    assert "scene.discs.first" not in names_of(programs(POINT))
    assert "scene.discs.first" in names_of(programs(LAMP))
    # Of several radii each has its own rows, averaged in place.
    assert "scene.discs.first" not in names_of(programs(LAMP, several=True))


@by_light
@pytest.mark.parametrize("rain", [False, True])
def test_the_programs_of_a_scene_are_shapes_that_were_compiled(programs, light, rain):
    wanted = list(sun_shapes() if light is SUN else lamp_shapes())
    free = {"COLUMN_DEGREE", "HAT_GROUPS", "RADIUS_ROWS", "DIRECT", "EVEN_STEPS"}
    known = {tuple(sorted((k, v) for k, v in shape.items() if k not in free)) for shape in wanted}
    for switches in ({}, {"grid": True}, {"several": True}, {"air": True, "polarizer": True}):
        compose = programs(light, rain=rain, **switches)[0].defines
        own = {k: compose[k] for k in wanted[0] if k not in free}
        assert tuple(sorted(own.items())) in known, own


# --- The same of method `spectral` ------------------------------------------------------------


def spectral_names(programs: Callable[..., list[Made]], light: Switches, **switches: bool):
    return names_of(programs(light, SpectralMethod, **switches))


@by_light
def test_spectral_programs_have_nothing_unused(programs, light):
    plain = spectral_names(programs, light)
    unused = {"camera.pass", "volume.moments", "volume.toLights", "volume.extinction"}
    assert not plain & (unused | {"sunTheory.sections", "lampTheory.sections"})
    if light is SUN:
        assert not plain & {"lamps[0].centre", "lampSteps"}
    else:
        assert not plain & {"suns[0].towards", "air.columns"}
    assert "camera.pass" in spectral_names(programs, light, polarizer=True)
    grid = spectral_names(programs, light, several=True)
    assert "volume.moments" in grid
    assert not grid & {"volume.density", "volume.radius", "volume.toLights"}
    assert "volume.toLights" in spectral_names(programs, light, grid=True, rain=True)
    assert "volume.extinction" in spectral_names(programs, light, rain=True)


def test_spectral_lights_without_a_disc_read_no_tables_of_it(programs):
    for light, disc in ((SUN | {"angular_diameter_deg": 0.0}, False), (SUN, True)):
        (made,) = programs(light, SpectralMethod)
        assert ("sunTheory.fringe" in made.program.textures) is disc
