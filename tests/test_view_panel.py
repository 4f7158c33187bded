"""The panel, driven by mouse and keyboard: it shows all of the scene, and changes it alone."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta, timezone
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from panel_driver import KEY, SECTIONS, WIDTH, Stage, staged
from PIL import Image
from pydantic import BaseModel, Field

from rtbow.context import Backend, GlContext
from rtbow.scene import Camera, Scene
from rtbow.scene_droplets import Droplets
from rtbow.scene_file import (
    builtin_scenes,
    load_scene,
    parse_set,
    scene_from_text,
    scene_title,
)
from rtbow.scene_schema import ROOT, Node
from rtbow.scene_values import changed_scene, scene_text, values_of
from rtbow.sun_position import sun_position
from rtbow.view import kinds, look
from rtbow.view.gallery import thumbnail_path
from rtbow.view.messages import FrameDrawn
from rtbow.view.proposals import merged, shortened, split_path, value_at
from rtbow.view.rows import Row, Slide, label_of, rows_of, shown_number
from rtbow.view.state import OVERLAYS, Notice, ViewState
from rtbow.view.status import error_text
from rtbow.view.widgets import spectrum_groups

DISTRIBUTIONS = (
    "constant", "uniform", "normal", "lognormal", "gamma", "modified-gamma", "marshall-palmer",
)  # fmt: skip


@pytest.fixture
def egl(gl_contexts: Callable[[Backend], GlContext]) -> Iterator[GlContext]:
    context = gl_contexts("egl")
    with context.current() as ctx:
        yield context
        assert ctx.error == "GL_NO_ERROR"


@pytest.fixture
def uniform(egl: GlContext) -> Iterator[Stage]:
    """A sun, drops of one radius, air."""
    with staged(egl, "uniform") as stage:
        stage.open_all()
        yield stage


def frame(scene: Scene, **options: Any) -> FrameDrawn:
    given = {
        "number": 1, "scene": scene, "rgb": np.zeros((2, 2, 3), np.float32), "seconds": 0.02,
        "exposure_ev": 14.0, "method": "fast", "unsuited": "", "renderer": "llvmpipe",
    }  # fmt: skip
    return FrameDrawn(**(given | options))


def scene_rows(table: BaseModel, path: str = "", node: Node = ROOT) -> Iterator[Row]:
    """Give the row of each value that a scene's tables may hold, as the schema has them."""
    for row in rows_of(path, type(table), node.models):
        value = getattr(table, row.name)
        child = node.child(row.name)
        assert child is not None
        if isinstance(value, BaseModel):
            yield from scene_rows(value, row.path, child)
        elif row.kind == "tables":
            for number, item in enumerate(value):
                inner = child.child(0)
                assert inner is not None
                yield from scene_rows(item, row.inside(number), inner)
        else:
            yield row


def shown_rows(scene: Scene) -> list[Row]:
    """Give those that go with the rest of the scene."""
    drops = scene.droplets
    without = {"light", "compare"}
    if drops.file is not None:
        without |= {"droplets.box_m", "droplets.grid", "droplets.radius", "droplets.density"}
    else:
        rain = drops.density is not None and drops.density.rain_rate_mm_h is not None
        other = "number_per_m3" if rain else "rain_rate_mm_h"
        without |= {"droplets.file", f"droplets.density.{other}"}
    return [row for row in scene_rows(scene) if row.path not in without]


def value(stage: Stage, path: str) -> Any:
    return value_at(stage.edits.scene, split_path(path))


def is_red(stage: Stage, path: str) -> bool:
    """Whether a widget's field is of the colour of what is refused."""
    left, top, right, bottom = (round(x) for x in stage.seen[path])
    image = stage.paint()[top + 2 : bottom - 2, left + 2 : right - 2].reshape(-1, 3)
    wanted = np.array([look.ERROR_FRAME.x, look.ERROR_FRAME.y, look.ERROR_FRAME.z]) * 255
    return bool((np.abs(image - wanted).max(axis=1) < 3).mean() > 0.3)


# --- all of the scene ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", builtin_scenes())
def test_every_key_of_a_built_in_scene_has_a_widget_inside_the_panel(egl, name):
    with staged(egl, name) as stage:
        stage.open_all()
        rows = shown_rows(stage.edits.scene)
        assert len(rows) > 15
        for row in rows:
            found = [
                path for path in stage.seen
                if path == row.path or path.startswith((f"{row.path}.", f"{row.path}/"))
            ]  # fmt: skip
            assert found, row.path
        for path, (left, _, right, _) in stage.seen.items():
            assert left >= 0.0, path
            assert right <= WIDTH, path


def test_a_key_that_the_scene_does_not_have_yet_gets_a_widget(egl):
    class Haze(BaseModel):
        depth_m: float = Field(
            20.0, ge=1, le=1000, description="how far one sees",
            json_schema_extra={"unit": "m", "effect": "Veils the bow.", "log": True},
        )  # fmt: skip
        kind: Literal["dry", "wet"] = Field("dry", description="its kind")

    class WiderCamera(Camera):
        shake_deg: float = Field(
            1.0, ge=0, le=10, description="how far the camera shakes",
            json_schema_extra={"unit": "deg", "effect": "Blurs the bow."},
        )  # fmt: skip
        tripod: bool = Field(True, description="whether there is one")

    class WiderScene(Scene):
        camera: WiderCamera = Field(WiderCamera(), description="the eye")
        haze: Haze = Field(Haze(), description="thin fog")

    with staged(egl) as stage:
        opened = stage.edits.opened
        wider = WiderScene(**dict(stage.edits.scene) | {"camera": WiderCamera(), "haze": Haze()})
        object.__setattr__(opened, "scene", wider)
        stage.edits.scene = wider
        asked: list[dict[str, object]] = []
        stage.actions.change = lambda changes, gesture=None: asked.append(changes) or ""  # type: ignore[method-assign]
        stage.frames(2)
        stage.open_all()
        tip = "\n".join(stage.tip("haze.depth_m"))
        assert "How far one sees" in tip
        assert "Veils the bow." in tip
        assert "in m" in tip
        assert "1..1000" in tip
        stage.drag("camera.shake_deg", 0.2, 0.7)
        stage.click("camera.tripod")
        stage.enter("haze.depth_m", "50")
        stage.click("haze.kind")
        stage.click("haze.kind=wet")
        last = {key: value for change in asked for key, value in change.items()}
        assert 5.0 < last.pop("camera.shake_deg") < 9.0
        assert last == {"camera.tripod": False, "haze.depth_m": 50, "haze.kind": "wet"}


def test_the_help_of_every_value_holds_its_unit_effect_range_and_key(egl):
    for name in ("uniform", "street-lamp"):
        with staged(egl, name) as stage:
            stage.open_all()
            for row in shown_rows(stage.edits.scene):
                place = next(
                    p for p in stage.seen if f"{p}/".startswith((row.path + "/", row.path + "."))
                )
                tip = "\n".join(stage.tip(place))
                assert row.effect in tip, row.path
                assert row.effect or row.kind == "table"
                assert row.description[1:] in tip
                assert f"--set {row.path}=" in tip.replace("'", "")
                if row.unit:
                    assert f"in {row.unit}" in tip
                if row.kind == "number" and row.node.range:
                    assert row.node.range in tip


# --- every widget changes the scene --------------------------------------------------------------

DRIVEN = {
    "uniform": {},
    "shower": {"camera.polarizer_deg": 10.0, "render.steps": 100},
    "downpour": {"droplets.grid": [8, 8, 8], "droplets.extinction_efficiency": 1.0},
    "fogbow": {"light.0.irradiance_w_m2": 100.0, "compare.right": {}},
    "two-lamps": {},
    "figures/fig7a": {},
}


def drive(stage: Stage, row: Row) -> str:
    """Change a value by its widget; give the path of what was changed."""
    before = value(stage, row.path)
    if row.optional and before is None:
        stage.click(f"{row.path}/on")
        return row.path
    if row.kind == "number":
        share = row.slide.share(before) if row.slide else 0.5
        stage.drag(row.path, share, share + (-0.1 if share > 0.5 else 0.1))
        return row.path
    if row.kind in ("vector", "corners"):
        inside = ".1" if row.kind == "vector" else ".1.1"
        stage.drag(row.path + inside, 0.5, 0.9)
        return row.path + inside
    if row.kind == "flag":
        stage.click(row.path, 0.1)
    elif row.kind in ("choice", "tag"):
        other = next(choice for choice in row.choices if choice != before)
        stage.click(row.path)
        stage.click(f"{row.path}={other}")
    elif row.kind == "spectrum":
        names = [name for _, group in spectrum_groups() for name in group]
        stage.click(row.path)
        stage.click(f"{row.path}={names[names.index(before) + 1]}")
    elif row.kind == "boxes":
        stage.click(row.inside(2), 0.05)
    else:
        stage.click(row.path)
        stage.type(str(builtin_scenes()["default"].parent / "curtain.npz"))
        stage.key(KEY.enter)
    return row.path


@pytest.mark.parametrize("name", DRIVEN)
def test_every_widget_changes_its_value_in_one_step_that_can_be_undone(egl, name):
    with staged(egl, name, changes=DRIVEN[name]) as stage:
        stage.open_all()
        first = stage.edits.scene
        for row in shown_rows(first):
            if row.path == "compare.right":
                continue
            before = value(stage, row.path)
            path = drive(stage, row)
            now = value(stage, row.path)
            assert now != before, row.path
            if row.kind == "number":
                assert stage.edits.changes[path] == now
            if row.kind != "tag" and row.name != "mixing":  # these bring others along
                assert list(stage.edits.changes) == [row.path]
            stage.edits.undo()
            stage.frames(2)
            assert stage.edits.scene == first, row.path
            assert not stage.edits.can_undo


@pytest.mark.parametrize("name", ["uniform", "street-lamp"])
def test_every_number_can_be_typed(egl, name):
    with staged(egl, name) as stage:
        stage.open_all()
        numbers = {
            "light.0.altitude_deg": "12.345", "camera.position_m.2": "17.25",
            "camera.size_px.0": "800", "droplets.radius.radius_um": "1e2",
            "droplets.box_m.0.0": "-70.5", "render.max_delta_e": "0.75",
            "droplets.seed": "99999999999",
            "light.0.luminous_flux_lm": "2e7", "light.0.angular_diameter_deg": "0",
        }  # fmt: skip
        for path, text in numbers.items():
            if path not in stage.seen:
                continue
            stage.enter(path, text)
            assert value(stage, path) == pytest.approx(float(text)), path
        assert not stage.panel.ui.drafts


def test_a_slider_gives_numbers_of_few_digits(uniform):
    uniform.drag("droplets.radius.radius_um", 0.3, 0.61)
    radius = value(uniform, "droplets.radius.radius_um")
    assert radius == float(f"{radius:.3g}")
    uniform.drag("light.0.altitude_deg", 0.5, 0.537)
    altitude = value(uniform, "light.0.altitude_deg")
    assert altitude == round(altitude, 1)
    uniform.drag("droplets.seed", 0.1, 0.5)
    assert isinstance(value(uniform, "droplets.seed"), int)


def test_a_number_beyond_the_slider_can_be_typed_and_is_kept(uniform):
    uniform.enter("camera.azimuth_deg", "725.5")
    assert value(uniform, "camera.azimuth_deg") == 725.5
    uniform.frames(5)
    assert value(uniform, "camera.azimuth_deg") == 725.5


def test_ctrl_click_types_too(uniform):
    uniform.io.add_key_event(KEY.mod_ctrl, True)
    uniform.click("camera.fov_deg")
    uniform.io.add_key_event(KEY.mod_ctrl, False)
    assert uniform.io.want_text_input
    uniform.type("44")
    uniform.key(KEY.enter)
    assert value(uniform, "camera.fov_deg") == 44.0
    uniform.edits.undo()
    assert not uniform.edits.can_undo


def test_a_double_click_leaves_no_trace_of_its_first_click(uniform):
    before = uniform.edits.scene
    uniform.double_click("camera.fov_deg", 0.9)
    uniform.key(KEY.escape)
    assert uniform.edits.scene == before
    assert not uniform.edits.can_undo
    assert not uniform.panel.ui.drafts


def test_a_double_click_takes_back_no_earlier_drag(uniform):
    uniform.drag("camera.fov_deg", 0.5, 0.8)
    fov = value(uniform, "camera.fov_deg")
    uniform.double_click("camera.fov_deg", 0.2)
    uniform.key(KEY.escape)
    assert value(uniform, "camera.fov_deg") == fov
    slide = Slide(5.0, 150.0)
    uniform.double_click("camera.fov_deg", slide.share(fov))  # on the slider: moves nothing
    uniform.key(KEY.escape)
    assert value(uniform, "camera.fov_deg") == fov


def test_a_click_elsewhere_takes_over_what_was_typed(uniform):
    uniform.double_click("camera.fov_deg")
    uniform.type("33")
    uniform.click("section/Theory", 0.9)
    assert value(uniform, "camera.fov_deg") == 33.0


def test_two_drags_are_two_steps(uniform):
    first = value(uniform, "light.0.altitude_deg")
    uniform.drag("light.0.altitude_deg", 0.5, 0.7)
    second = value(uniform, "light.0.altitude_deg")
    uniform.drag("light.0.altitude_deg", 0.7, 0.3)
    uniform.click("Undo")
    assert value(uniform, "light.0.altitude_deg") == second
    uniform.click("Undo")
    assert value(uniform, "light.0.altitude_deg") == first
    uniform.click("Undo")
    assert value(uniform, "light.0.altitude_deg") == first
    uniform.click("Redo")
    uniform.click("Redo")
    assert uniform.edits.can_undo
    assert not uniform.edits.can_redo


# --- what is refused -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "text", "told"),
    [
        ("light.0.altitude_deg", "91", "must be -90..90"),
        ("light.0.altitude_deg", "high", "must be a number, -90..90"),
        ("camera.fov_deg", "nan", "must be a finite number"),
        ("droplets.seed", "1.5", "must be a whole number"),
        ("camera.size_px.1", "0", "must be 1..16384"),
        ("droplets.box_m.1.0", "-99999", "turned inside out along east"),
        ("render.wavelength_step_nm", "7", "must divide"),
    ],
)
def test_refused_text_stays_in_red_with_its_message_and_out_of_the_scene(uniform, path, text, told):
    before = uniform.edits.scene
    assert not is_red(uniform, path)
    uniform.enter(path, text)
    uniform.click("section/Keep", 0.9)
    uniform.frames(10)
    assert uniform.edits.scene is before
    draft = uniform.panel.ui.drafts[path]
    assert draft.text == text
    assert told in draft.message
    assert is_red(uniform, path)
    uniform.key(KEY.escape)
    assert not uniform.panel.ui.drafts
    assert not is_red(uniform, path)


def test_a_refused_text_can_be_made_right(uniform):
    uniform.enter("light.0.altitude_deg", "91")
    uniform.type("9")  # Enter has kept the keyboard, with all selected
    uniform.key(KEY.enter)
    assert value(uniform, "light.0.altitude_deg") == 9.0
    assert not uniform.panel.ui.drafts


def test_reset_clears_what_was_refused(uniform):
    uniform.enter("camera.fov_deg", "50")
    uniform.enter("camera.fov_deg", "500")
    assert is_red(uniform, "camera.fov_deg")
    uniform.click("camera.fov_deg/reset")
    assert not uniform.panel.ui.drafts
    assert value(uniform, "camera.fov_deg") == uniform.edits.opened.scene.camera.fov_deg


def test_what_the_message_repeats_is_left_out():
    text = "--set light.0.altitude_deg = 91.0; must be -90..90"
    assert shortened(text, "light.0.altitude_deg") == "must be -90..90"
    other = "--set droplets.radius.max_um = 5.0; must be greater than min_um = 9"
    assert shortened(other, "droplets.radius.min_um").startswith("droplets.radius.max_um = 5.0;")
    missing = "--set: droplets.grid is missing; give it"
    assert shortened(missing, "droplets.radius.mixing") == "droplets.grid is missing; give it"
    right = "--set compare.right.camera.fov_deg = 0.0; must be greater than 0"
    assert shortened(right, "camera.fov_deg") == "must be greater than 0"


def test_a_window_can_ask_to_drop_what_was_refused_before_escape_closes_it(uniform):
    assert not uniform.panel.forget_refused()
    uniform.enter("camera.fov_deg", "500")
    uniform.click("section/Keep", 0.9)
    uniform.frames(5)
    assert uniform.panel.forget_refused()
    assert not uniform.panel.forget_refused()
    uniform.frames(2)
    assert not is_red(uniform, "camera.fov_deg")


def test_a_drag_steps_over_what_is_refused(uniform):
    """Only divisors of 400 nm are steps; a slider comes to some of them."""
    uniform.drag("render.wavelength_step_nm", 0.5, 0.3, steps=40)
    step = value(uniform, "render.wavelength_step_nm")
    assert step < 5.0
    assert 400.0 / step == pytest.approx(round(400.0 / step))
    assert not uniform.panel.ui.refusals


def test_a_refused_drag_is_red_while_it_lasts(egl):
    changes = {"droplets.radius": {"distribution": "uniform", "min_um": 100.0, "max_um": 200.0}}
    changes |= {"droplets.grid": [4, 4, 4]}
    with staged(egl, "uniform", changes=changes) as stage:
        path = "droplets.radius.min_um"
        x, y = stage.at(path, 0.5)
        stage.mouse(x, y)
        stage.frames(2)
        stage.button(True)
        stage.frames()
        stage.mouse(stage.at(path, 0.95)[0], y)
        stage.frames(2)
        assert value(stage, path) < 200.0
        assert is_red(stage, path)
        assert "must be greater than min_um" in stage.panel.ui.refusals[path].message
        stage.button(False)
        stage.frames(3)
        assert not stage.panel.ui.refusals
        assert not is_red(stage, path)


def test_a_refused_click_is_told(uniform):
    uniform.click("scattering.orders.1", 0.05)
    uniform.click("scattering.orders.2", 0.05)
    assert uniform.edits.scene.scattering.orders == (2,)
    assert uniform.panel.ui.refusals["scattering.orders"].message
    uniform.click("scattering.orders.1", 0.05)
    assert not uniform.panel.ui.refusals
    uniform.click("scattering.orders.1", 0.05)
    uniform.click("scattering.orders.2", 0.05)
    assert uniform.panel.ui.refusals
    uniform.drag("camera.fov_deg", 0.3, 0.6)
    assert not uniform.panel.ui.refusals


# --- reset, copy ---------------------------------------------------------------------------------


def test_an_arrow_shows_where_a_value_differs_and_gives_it_back(uniform):
    first = uniform.edits.scene
    assert not [path for path in uniform.seen if path.endswith("/reset")]
    for row in shown_rows(first):
        drive(uniform, row)
        arrows = [path for path in uniform.seen if path.endswith("/reset")]
        assert arrows == [f"{row.path}/reset"]
        uniform.click(arrows[0])
        assert uniform.edits.scene == first, row.path


def test_the_menu_resets_and_copies_the_option(uniform):
    from imgui_bundle import imgui

    uniform.enter("camera.fov_deg", "50")
    uniform.click("camera.fov_deg", number=1)
    uniform.click("menu/copy")
    words = shlex.split(imgui.get_clipboard_text())
    assert words[0] == "--set"
    key, new = parse_set(words[1])
    assert changed_scene(uniform.edits.opened.scene, {key: new}) == uniform.edits.scene
    uniform.click("camera.fov_deg", number=1)
    uniform.click("menu/reset")
    assert uniform.edits.scene == uniform.edits.opened.scene


def test_the_copied_option_of_every_value_is_understood(egl):
    for name in ("street-lamp", "shower"):
        with staged(egl, name) as stage:
            stage.frames()
            for row in shown_rows(stage.edits.scene):
                words = shlex.split(stage.panel.ui.values.set_text(row.path))
                key, new = parse_set(words[1])
                assert changed_scene(stage.edits.scene, {key: new}) == stage.edits.scene


# --- kinds ---------------------------------------------------------------------------------------


def mean_um(drops: Droplets) -> float:
    radius = drops.radius.model_dump()
    named = [radius[key] for key in radius if key in kinds._MEANS]
    return named[0] if named else 0.5 * (radius["min_um"] + radius["max_um"])


@pytest.mark.parametrize("before", DISTRIBUTIONS)
@pytest.mark.parametrize("after", DISTRIBUTIONS)
def test_every_distribution_turns_into_every_other(before, after):
    node = ROOT.child("droplets").child("radius")
    scene = load_scene("uniform")
    first = scene.droplets.radius.radius_um
    for kind in (before, after):
        table = kinds.radius_table(scene.droplets, kind, node)
        scene = changed_scene(scene, {f"droplets.{key}": value for key, value in table.items()})
        assert scene.droplets.radius.distribution == kind
    if "marshall-palmer" not in (before, after):
        assert mean_um(scene.droplets) == pytest.approx(first, rel=0.02)
    assert load_scene("uniform", {"droplets": values_of(scene)["droplets"]}) == scene


def test_a_distribution_keeps_the_spread_and_the_mixing():
    node = ROOT.child("droplets").child("radius")
    scene = load_scene("fogbow")  # gamma, local
    table = kinds.radius_table(scene.droplets, "lognormal", node)["radius"]
    assert table["median_um"] == 10.0
    assert table["log_std"] == pytest.approx(0.02**0.5, rel=0.01)
    assert table["mixing"] == "local"


def test_chosen_distributions_come_and_go(uniform):
    first = uniform.edits.scene
    for kind in DISTRIBUTIONS[1:]:
        uniform.click("droplets.radius.distribution")
        uniform.click(f"droplets.radius.distribution={kind}")
        assert uniform.edits.scene.droplets.radius.distribution == kind
        assert not uniform.panel.ui.refusals
        uniform.click("droplets.radius.distribution/reset")
        assert uniform.edits.scene == first


def test_drops_come_from_a_file_and_go_back(egl):
    with staged(egl, "shower") as stage:
        box = "droplets.box_m.0.0"
        assert box not in stage.seen
        stage.click("droplets.source")
        stage.click("droplets.source=a description")
        assert stage.edits.scene.droplets.file is None
        assert box in stage.seen
        assert stage.edits.scene.droplets.box_m == ((-2000.0, 300.0, 0.0), (2000.0, 1500.0, 1250.0))
        assert 100.0 < stage.edits.scene.droplets.radius.radius_um < 600.0
        stage.click("droplets.source")
        stage.click("droplets.source=a file")
        assert stage.edits.scene == stage.edits.opened.scene


def test_no_volume_is_read_for_a_click(egl, monkeypatch):
    """A volume may hold many millions of drops; its box is all that is needed."""
    monkeypatch.setattr("rtbow.volume.load_volume", lambda path: 1 / 0)
    with staged(egl, "shower") as stage:
        stage.click("droplets.source")
        stage.click("droplets.source=a description")
        assert stage.edits.scene.droplets.box_m == ((-2000.0, 300.0, 0.0), (2000.0, 1500.0, 1250.0))


class Dry(BaseModel):
    kind: Literal["dry"] = Field("dry", description="its kind")
    depth_m: float = Field(20.0, ge=1, le=1000, description="how far one sees")
    dust: float = Field(0.5, ge=0, le=1, description="how dusty it is")


class Wet(BaseModel):
    kind: Literal["wet"] = Field("wet", description="its kind")
    depth_m: float = Field(20.0, ge=1, le=1000, description="how far one sees")
    drop_um: float = Field(ge=1, le=50, description="how large its drops are")


def test_a_table_of_kinds_that_is_no_light_gets_a_table_of_its_own(egl):
    class WiderScene(Scene):
        haze: Annotated[Dry | Wet, Field(discriminator="kind")] = Field(
            Dry(), description="thin fog"
        )

    with staged(egl) as stage:
        wider = WiderScene(**dict(stage.edits.scene) | {"haze": Dry(depth_m=70.0)})
        object.__setattr__(stage.edits.opened, "scene", wider)
        stage.edits.scene = wider
        asked: list[dict[str, object]] = []
        stage.actions.change = lambda changes, gesture=None: asked.append(changes) or ""  # type: ignore[method-assign]
        stage.frames(2)
        stage.open_all()
        stage.click("haze.kind")
        stage.click("haze.kind=wet")
        table = asked[-1]["haze"]
        assert Wet.model_validate(table).depth_m == 70.0
        assert table.keys() == {"kind", "depth_m", "drop_um"}


def test_mixing_per_point_brings_a_grid(egl):
    with staged(egl, "downpour") as stage:
        stage.click("droplets.radius.mixing")
        stage.click("droplets.radius.mixing=per-point")
        assert stage.edits.scene.droplets.radius.mixing == "per-point"
        assert stage.edits.scene.droplets.grid is not None


def test_a_sun_becomes_a_lamp_in_the_same_direction_and_back(uniform):
    uniform.click("light.0.spectrum")
    uniform.click("light.0.spectrum=equal-energy")
    uniform.click("light.0.type")
    uniform.click("light.0.type=point")
    lamp = uniform.edits.scene.light[0]
    assert lamp.type == "point"
    assert lamp.spectrum == "equal-energy"
    assert lamp.position_m[1] < 0.0  # the sun was in the south
    uniform.click("light.0.type")
    uniform.click("light.0.type=sun")
    assert uniform.edits.scene.light[0].azimuth_deg == pytest.approx(180.0)
    assert uniform.edits.scene.light[0].spectrum == "equal-energy"


def test_lights_are_added_and_removed(uniform):
    first = uniform.edits.scene
    uniform.click("light/add point")
    uniform.click("light/add sun")
    assert [light.type for light in uniform.edits.scene.light] == ["sun", "point", "sun"]
    uniform.drag("light.1.luminous_flux_lm", 0.4, 0.8)
    assert uniform.edits.scene.light[1].luminous_flux_lm > 8000.0
    uniform.click("light.2/remove")
    uniform.click("light.1/remove")
    assert uniform.edits.scene == first
    assert "light.0/remove" not in uniform.seen


def test_the_air_goes_and_comes(egl):
    with staged(egl, "shower") as stage:
        stage.open_all()
        stage.click("atmosphere/on", 0.1)
        assert stage.edits.scene.atmosphere is None
        assert "atmosphere.rayleigh" not in stage.seen
        stage.click("atmosphere/on", 0.1)
        assert stage.edits.scene.atmosphere.rayleigh
        assert "atmosphere.rayleigh" in stage.seen


def test_a_spectrum_of_ones_own(uniform, tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("wavelength_nm,value\n380,1\n780,2\n")
    for text in (str(tmp_path / "none.csv"), str(path)):
        if uniform.panel.ui.drafts:
            uniform.key(KEY.escape)
        uniform.click("light.0.spectrum")
        uniform.click("light.0.spectrum=file")
        uniform.type(text)
        uniform.key(KEY.enter)
        if text == str(path):
            assert uniform.edits.scene.light[0].spectrum == text
        else:
            assert uniform.edits.scene.light[0].spectrum == "E490"
            assert "file not found" in uniform.panel.ui.drafts["light.0.spectrum"].message


def test_a_volume_file_that_is_not_there_is_refused(egl, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.npz").write_text("no archive")
    np.savez(tmp_path / "half.npz", radius_um=np.ones((2, 2, 2)), box_m=np.zeros((2, 3)))
    shutil.copy(builtin_scenes()["default"].parent / "curtain.npz", tmp_path / "own.npz")
    with staged(egl, "shower") as stage:
        before = stage.edits.scene
        for text, told in (
            ("none.npz", "volume file not found"), ("notes.npz", "is not a volume file"),
            ("half.npz", "lacks number_per_m3"), (".", "is not a volume file"),
        ):  # fmt: skip
            stage.click("droplets.file")
            stage.type(text)
            stage.key(KEY.enter)
            assert told in stage.panel.ui.drafts["droplets.file"].message
            assert is_red(stage, "droplets.file")
            assert stage.edits.scene is before
            stage.key(KEY.escape)
            stage.frames(2)
        stage.click("droplets.file")
        stage.type(" own.npz ")
        stage.key(KEY.enter)
        assert stage.edits.scene.droplets.file == str(tmp_path / "own.npz")


def test_a_file_of_the_right_side_that_is_not_there_is_refused(egl):
    with staged(egl, "uniform", changes={"compare.right": {}}) as stage:
        stage.open_all()
        for text in ("droplets.file = none.npz", "light.0.spectrum = none.csv"):
            stage.click("compare.right")
            stage.type(text)
            stage.key(KEY.enter)
            assert "not found" in stage.panel.ui.drafts["compare.right"].message
            assert stage.edits.scene.compare.right == {}
            stage.key(KEY.escape)
            stage.frames(2)


# --- two sides -----------------------------------------------------------------------------------


def test_the_right_side_changes_alone(egl):
    with staged(egl, "shower") as stage:
        stage.open_all()
        left = stage.edits.scene
        stage.click("view.split", 0.05)
        assert stage.actions.asked == [("split", True)]
        stage.click("view.side/right", 0.1)
        assert stage.state.side == "right"
        stage.enter("camera.fov_deg", "30")
        stage.drag("light.0.altitude_deg", 0.6, 0.55)
        stage.click("atmosphere.rayleigh")
        scene = stage.edits.scene
        assert scene.camera == left.camera
        assert scene.light == left.light
        right = scene.parts()[-1][0]
        assert right.camera.fov_deg == 30.0
        assert right.light[0].altitude_deg != 20.0
        assert right.atmosphere.rayleigh is False
        stage.click("light.0.altitude_deg/reset")
        assert "light.0.altitude_deg" not in stage.edits.scene.compare.right
        stage.drag("camera.size_px.0", 0.5, 0.8)
        assert stage.edits.scene.camera.size_px == left.camera.size_px
        assert "compare.right.camera.fov_deg=30" in "\n".join(stage.tip("camera.fov_deg"))


def test_kinds_change_on_the_right(egl):
    with staged(
        egl, "uniform", changes={"compare.right": {"droplets.radius.radius_um": 50.0}}
    ) as s:
        s.open_all()
        s.state.side = "right"
        s.frames(2)
        for kind in ("gamma", "marshall-palmer", "uniform", "constant"):
            s.click("droplets.radius.distribution")
            s.click(f"droplets.radius.distribution={kind}")
            assert s.edits.scene.parts()[-1][0].droplets.radius.distribution == kind
            assert s.edits.scene.droplets.radius.distribution == "constant"
        s.click("light/add point")
        assert len(s.edits.scene.parts()[-1][0].light) == 2
        assert len(s.edits.scene.light) == 1


def test_the_right_side_is_shown_without_any_width(egl):
    changes = {"compare": {"split": 1.0, "right": {"camera.fov_deg": 30.0}}}
    with staged(egl, "uniform", changes=changes) as stage:
        stage.open_all()
        stage.state.side = "right"
        stage.frames(2)
        stage.double_click("camera.fov_deg")
        assert stage.panel.ui.drafts["camera.fov_deg"].text == "30.0"


def test_what_differs_on_the_right_is_listed_added_and_taken_out(egl):
    with staged(egl, "uniform", changes={"compare.right": {"camera.fov_deg": 30.0}}) as stage:
        stage.open_all()
        stage.click("compare.right")
        stage.type("camera.altitude_deg = 5")
        stage.key(KEY.enter)
        right = {"camera.fov_deg": 30.0, "camera.altitude_deg": 5}
        assert stage.edits.scene.compare.right == right
        stage.click("compare.right/remove camera.fov_deg")
        assert stage.edits.scene.compare.right == {"camera.altitude_deg": 5}


def test_a_value_on_the_right_replaces_what_is_inside_it():
    right = {"droplets": {"radius": {"distribution": "constant", "radius_um": 5.0}}}
    table = {"distribution": "gamma"}
    assert merged(right, {"droplets.radius": table}) == {"droplets.radius": table}
    assert merged({"a.b": 1, "a.bc": 2}, {"a.b": None}) == {"a.bc": 2}


def test_the_right_side_leaves_out_what_the_left_has(egl):
    with staged(egl, "shower", changes={"compare.right": {}}) as stage:
        stage.open_all()
        stage.state.side = "right"
        stage.frames(2)
        before = stage.edits.scene
        stage.click("atmosphere/on", 0.1)
        assert stage.edits.scene.atmosphere is not None
        assert stage.edits.scene.parts()[1][0].atmosphere is None
        assert scene_from_text(scene_text(stage.edits.scene)) == stage.edits.scene
        stage.click("atmosphere/on", 0.1)
        assert stage.edits.scene.parts()[1][0] == before.parts()[1][0]


# --- the sun by date -----------------------------------------------------------------------------


def test_the_sun_stands_where_it_does_at_a_date_time_and_place(uniform):
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.latitude", "59.9")
    uniform.enter("by date.longitude", "10.75")
    uniform.enter("by date.date", "2026-06-21")
    uniform.enter("by date.time", "18:30")
    uniform.enter("by date.offset", "2")
    when = datetime(2026, 6, 21, 18, 30, tzinfo=timezone(timedelta(hours=2)))
    found = sun_position(when, 59.9, 10.75)
    sun = uniform.edits.scene.light[0]
    assert sun.altitude_deg == pytest.approx(found.altitude_deg, abs=0.006)
    assert sun.azimuth_deg == pytest.approx(found.azimuth_deg, abs=0.006)
    before = uniform.edits.scene
    uniform.drag("by date.time", 0.5, 0.4)
    assert uniform.edits.scene.light[0].azimuth_deg != sun.azimuth_deg
    uniform.edits.undo()
    assert uniform.edits.scene == before


def stands(stage: Stage) -> tuple[float, float]:
    sun = stage.edits.scene.light[0]
    return sun.altitude_deg, sun.azimuth_deg


def test_date_time_and_place_go_back_with_the_sun(uniform):
    sun = uniform.panel.sun
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.date", "2026-06-21")
    uniform.enter("by date.time", "18:30")
    uniform.drag("by date.time", 0.5, 0.4)
    later = sun.minutes
    assert later != 18 * 60 + 30
    uniform.enter("by date.latitude", "20")
    for _ in range(2):
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Undo")
        assert (sun.minutes, sun.latitude_deg) == (later, 48.0)
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Undo")
        assert sun.minutes == 18 * 60 + 30
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Redo")
        uniform.click("Redo")
        assert (sun.minutes, sun.latitude_deg) == (later, 20.0)
    while uniform.edits.can_undo:
        uniform.click("Undo")
    assert not sun.on
    uniform.click("Redo")
    assert sun.on


def test_a_sun_that_was_moved_by_hand_is_not_that_of_the_date(uniform):
    uniform.click("by date.use", 0.1)
    assert "by date.time" in uniform.seen
    uniform.enter("light.0.altitude_deg", "12.3")
    assert not uniform.panel.sun.on
    assert "by date.time" not in uniform.seen
    uniform.click("Undo")
    assert uniform.panel.sun.on
    uniform.click("by date.use", 0.1)
    uniform.frames(3)
    assert not uniform.panel.sun.on
    uniform.enter("light.0.altitude_deg", "12.3")
    uniform.click("Undo")
    assert not uniform.panel.sun.on


@pytest.mark.parametrize(("year", "days"), [(2026, 365), (2028, 366)])
def test_the_slider_of_days_ends_with_its_year(uniform, year, days):
    sun = uniform.panel.sun
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.date", f"{year}-06-21")
    uniform.drag("by date.date", 0.5, 1.2)
    assert str(sun.day) == f"{year}-12-31"
    assert sun.day.timetuple().tm_yday == days
    uniform.drag("by date.date", 0.9, -0.2)
    assert str(sun.day) == f"{year}-01-01"


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("by date.date", "yesterday"), ("by date.date", "2500-01-01"), ("by date.time", "25:99"),
        ("by date.offset", "99"), ("by date.latitude", "91"), ("by date.longitude", "west"),
    ],
)  # fmt: skip
def test_a_wrong_date_or_place_is_refused(uniform, path, text):
    uniform.click("by date.use", 0.1)
    before = uniform.edits.scene
    uniform.enter(path, text)
    assert uniform.panel.ui.drafts[path].message
    assert uniform.edits.scene is before
    assert is_red(uniform, path)


# --- the picture, scenes, keeping ----------------------------------------------------------------


def test_how_the_picture_is_shown_is_chosen(uniform):
    state = uniform.state
    state.frame = frame(uniform.edits.scene)
    for method in ("fast", "spectral", "reference", "auto"):
        uniform.click("view.method")
        uniform.click(f"view.method={method}")
        assert state.method == method
    uniform.click("view.exposure", 0.1)
    assert state.exposure_ev == 14.0
    uniform.drag("view.exposure_ev", 0.5, 0.9)
    assert state.exposure_ev > 14.5
    uniform.enter("view.exposure_ev", "-7.5")
    assert state.exposure_ev == -7.5
    uniform.click("view.exposure", 0.1)
    assert state.exposure_ev is None
    uniform.drag("view.target_fps", 0.5, 0.9)
    assert state.target_fps > 50.0
    for name in OVERLAYS:
        uniform.click(f"view.overlays.{name}", 0.05)
        assert state.overlays == {name}
        uniform.click(f"view.overlays.{name}", 0.05)
    assert uniform.edits.scene is uniform.edits.opened.scene


@pytest.mark.parametrize("ev", [None, 12.0])
def test_how_the_picture_is_shown_goes_back_to_what_the_window_was_opened_with(egl, ev):
    with staged(egl, "uniform", state=ViewState("spectral", ev, target_fps=20.0)) as stage:
        state = stage.state
        state.frame = frame(stage.edits.scene)
        stage.frames(2)
        assert not [path for path in stage.seen if path.endswith("/reset")]
        stage.click("view.method")
        stage.click("view.method=fast")
        stage.drag("view.target_fps", 0.5, 0.9)
        stage.click("view.exposure", 0.1)
        assert (state.exposure_ev is None) == (ev is not None)
        arrows = {"view.method/reset", "view.exposure/reset", "view.target_fps/reset"}
        assert {path for path in stage.seen if path.endswith("/reset")} == arrows
        for path in arrows:
            stage.click(path)
        assert (state.method, state.exposure_ev, state.target_fps) == ("spectral", ev, 20.0)
        assert not [path for path in stage.seen if path.endswith("/reset")]
        if ev is not None:
            stage.enter("view.exposure_ev", "3")
            stage.enter("view.exposure_ev", "400")
            assert is_red(stage, "view.exposure_ev")
            stage.click("view.exposure_ev/reset")
            assert state.exposure_ev == ev
            assert not stage.panel.ui.drafts


def test_the_help_of_the_panels_own_values_holds_their_options(uniform):
    tip = uniform.tip("view.method")
    assert "--method auto|fast|spectral|reference" in tip
    assert "a number" not in "\n".join(tip)


def test_circles_of_chosen_orders(uniform):
    state = uniform.state
    assert state.circle_orders == (1, 2)
    assert "view.circle_orders.3" not in uniform.seen
    uniform.click("view.overlays.circles", 0.05)
    uniform.click("view.circle_orders.4", 0.05)
    uniform.click("view.circle_orders.1", 0.05)
    assert state.circle_orders == (2, 4)
    uniform.click("view.circle_orders/reset")
    assert state.circle_orders == (1, 2)


def test_what_is_read_under_the_cursor_goes_and_comes(uniform):
    for expected in (False, True):
        uniform.click("view.readout", 0.05)
        assert uniform.state.readout_open is expected


def test_built_in_scenes_open_with_a_click_on_their_picture(egl):
    with staged(egl, "uniform") as stage:
        stage.click("section/Scenes")
        stage.click("group/figures", 0.1)
        stage.frames(20)
        names = list(builtin_scenes())
        for name in names:
            left, top, right, bottom = (round(x) for x in stage.seen[f"scenes/{name}"])
            picture = np.asarray(Image.open(thumbnail_path(name)).convert("RGB"), dtype=float)
            shown = stage.paint()[top:bottom, left:right][: round((right - left) * 9 / 16)]
            assert abs(float(shown.mean()) - float(picture.mean())) < 12.0, name
            assert scene_title(builtin_scenes()[name])
            stage.click(f"scenes/{name}")
        assert stage.actions.asked == [("open", name) for name in names]


def test_a_scenes_title_is_read_once(egl, monkeypatch):
    read: list[Any] = []
    monkeypatch.setattr(
        "rtbow.view.gallery.scene_title", lambda path: read.append(path) or "a title"
    )
    with staged(egl, "uniform") as stage:
        monkeypatch.setattr("rtbow.view.gallery.builtin_scenes", lambda: 1 / 0)
        stage.click("section/Scenes")
        for _ in range(3):
            for name in ("fogbow", "shower"):
                stage.hover(f"scenes/{name}")
                stage.frames(20)
        assert read == [builtin_scenes()["fogbow"], builtin_scenes()["shower"]]


def test_every_built_in_scene_has_a_small_picture():
    folder = thumbnail_path("default").parent
    found = {p.relative_to(folder).with_suffix("").as_posix() for p in folder.rglob("*.png")}
    assert found == set(builtin_scenes())
    for name in found:
        with Image.open(thumbnail_path(name)) as image:
            assert image.size == (128, 72)


def test_a_file_is_opened_by_its_path(uniform):
    uniform.click("open")
    uniform.type("storm.toml")
    uniform.key(KEY.enter)
    uniform.state.recent = ["other.toml"]
    uniform.frames(2)
    assert uniform.actions.asked == [("open", "storm.toml")]


def test_frames_scenes_and_commands_are_kept(uniform, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "uniform-01.png").touch()
    uniform.frames(70)
    uniform.click("keep/save frame")
    uniform.click("keep/save scene")
    uniform.click("keep.frame")
    uniform.type("out/bow.exr")
    uniform.key(KEY.enter)
    uniform.click("keep/.exr", 0.1)
    uniform.click("keep/save frame")
    uniform.click("keep.scene")
    uniform.type("bow.toml")
    uniform.key(KEY.enter)
    uniform.click("keep/save scene")
    uniform.click("keep/copy command")
    assert uniform.actions.asked == [
        ("frame", ("uniform-02.exr", "uniform-02.png")),
        ("scene", "uniform-01.toml"),
        ("frame", ("out/bow.png",)),
        ("scene", "bow.toml"),
        ("command", "rtbow render uniform"),
    ]


def test_another_file_is_replaced_after_a_question(uniform, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "other.toml").write_text("precious")
    uniform.click("keep.scene")
    uniform.type("other.toml")
    uniform.key(KEY.enter)
    uniform.click("keep/save scene")
    assert uniform.actions.asked == []
    uniform.click("keep/leave it")
    assert "keep/replace it" not in uniform.seen
    uniform.click("keep/save scene")
    uniform.click("keep/replace it")
    assert uniform.actions.asked == [("replace", "other.toml")]
    assert "keep/replace it" not in uniform.seen
    uniform.click("keep/save scene")
    uniform.click("keep.scene")
    uniform.type("free.toml")
    uniform.key(KEY.enter)
    assert "keep/replace it" not in uniform.seen
    uniform.edits.save(tmp_path / "free.toml")
    uniform.frames(2)
    uniform.click("keep/save scene")
    assert uniform.actions.asked[1:] == [("scene", str(tmp_path / "free.toml"))]


def test_the_bound_of_the_error_is_that_of_the_frame_and_of_full_size(uniform):
    state = uniform.state
    assert error_text(state) == ("", True)
    scene = changed_scene(uniform.edits.scene, {"render.max_delta_e": 0.25})
    state.frame = frame(scene)
    assert error_text(state) == ("ΔE 99 % ≤ 0.25", True)
    uniform.frames(2)
    top = uniform.seen["section/Scenes"][1]
    state.scale = 0.5
    assert error_text(state) == ("ΔE 99 % ≤ 0.25 at full size", False)
    uniform.frames(2)
    assert uniform.seen["status/error"][2] < WIDTH
    assert uniform.seen["section/Scenes"][1] == top  # it does not jump while things move
    state.frame = frame(scene, method="spectral")
    assert error_text(state) == ("", True)


def test_the_head_tells_how_the_picture_came_about(uniform):
    plain = uniform.seen["section/Scenes"][1]
    state = uniform.state
    state.frame = frame(uniform.edits.scene, method="spectral", unsuited="the lamp is near")
    uniform.frames(2)
    with_reason = uniform.seen["section/Scenes"][1]
    assert with_reason > plain
    state.show_progress("frame", (0.25, "building the table"))
    uniform.frames(2)
    assert uniform.seen["section/Scenes"][1] == with_reason  # nothing moves under the hand
    state.tell("frame", "droplets.file: there is no such file")
    state.notices = [Notice("done", "info", 1e9), Notice("broken", "error", 1e9)]
    uniform.frames(2)
    assert uniform.seen["section/Scenes"][1] > with_reason + 60.0
    uniform.click("notice/1/close")
    assert [notice.text for notice in state.notices] == ["done"]


def test_the_keys_are_listed_until_the_window_is_closed(egl):
    with staged(egl, "uniform", height=800, width=800) as stage:
        stage.state.help_open = True
        stage.frames(5)
        assert stage.state.help_open
        image = stage.paint()
        assert image[300:500, 250:550].std() > 10.0


def test_the_panel_is_short_enough_to_scroll_and_skips_what_is_out_of_sight(egl):
    """Rows out of sight are not drawn, and come back where they were."""
    with staged(egl, "uniform", height=300) as stage:
        stage.frames(5)
        assert "render.max_delta_e" not in stage.seen
        whole = stage.scroll[1]
        stage.mouse(100.0, 200.0)
        for _ in range(40):
            stage.io.add_mouse_wheel_event(0.0, -5.0)
            stage.frames(2)
        assert "render.max_delta_e" in stage.seen
        assert "light.0.altitude_deg" not in stage.seen
        assert stage.scroll[0] == stage.scroll[1] == whole
        stage.drag("render.max_delta_e", 0.3, 0.6)
        assert "render.max_delta_e" in stage.edits.changes


@pytest.mark.parametrize("name", ["downpour", "street-lamp", "shower"])
def test_whatever_hands_do_the_scene_stays_one_that_can_be_saved(egl, rng, name):
    texts = ["0", "-1", "1e9", "nan", "5", "abc", "%s%n", "none", "9" * 400, "[1, 2]", "2026-02-30"]
    keys = [KEY.enter, KEY.escape, KEY.tab]
    with staged(egl, name, height=int(rng.choice([300, 3000]))) as stage:
        stage.edits.change({"compare": {"right": {}}})
        for _ in range(120):
            stage.state.side = "right" if rng.random() < 0.4 else "left"
            places = [path for path in stage.seen if not path.startswith("scenes/")]
            path, share = str(rng.choice(places)), float(rng.random())
            stage.hover(path, share)
            stage.press()
            if path not in stage.seen:
                continue
            if rng.random() < 0.4:
                stage.press()
                stage.type(str(rng.choice(texts)))
                stage.key(keys[rng.integers(3)])
            elif rng.random() < 0.5:
                stage.drag(path, share, float(rng.random()), steps=3)
            if rng.random() < 0.1:
                stage.edits.undo()
        scene = stage.edits.scene
        assert scene_from_text(scene_text(scene)) == scene


# --- dense displays ------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1.25, 1.5, 2.0])
@pytest.mark.parametrize("name", ["shower", "street-lamp"])
def test_on_a_dense_display_all_is_larger_alike(egl, name, scale):
    def places(by: float) -> dict[str, tuple[float, float, float, float]]:
        size = {"height": round(4000 * by), "width": round(WIDTH * by), "scale": by}
        with staged(egl, name, **size) as stage:
            stage.state.frame = frame(stage.edits.scene)
            stage.open_all()
            stage.click("by date.use", 0.1) if "by date.use" in stage.seen else None
            stage.frames(3)
            return dict(stage.seen)

    plain, dense = places(1.0), places(scale)
    assert plain.keys() == dense.keys()
    for path, (left, top, right, bottom) in plain.items():
        found = dense[path]
        assert 0.0 <= found[0] < found[2] <= scale * WIDTH, path
        wide, high = scale * (right - left), scale * (bottom - top)
        # Letters are not drawn alike at all sizes.
        assert found[2] - found[0] == pytest.approx(wide, abs=0.08 * wide + 3.0), path
        assert found[3] - found[1] == pytest.approx(high, abs=0.03 * high + 2.0), path


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_letters_stay_inside_their_fields(egl, scale):
    """Of a number's own letters, some pixels of its field are left all around."""
    size = {"height": round(4000 * scale), "width": round(WIDTH * scale), "scale": scale}
    with staged(egl, "shower", **size) as stage:
        stage.open_all()
        stage.mouse(-100.0, -100.0)
        stage.frames(3)
        image = stage.paint()
        for row in shown_rows(stage.edits.scene):
            if row.kind != "number" or row.path not in stage.seen:
                continue
            left, top, right, bottom = (round(x) for x in stage.seen[row.path])
            bright = image[top:bottom, left:right].min(axis=2) > 150
            assert bright.any(), row.path
            rows, columns = np.nonzero(bright)
            assert min(rows.min(), bottom - top - 1 - rows.max()) >= 2 * scale, row.path
            assert min(columns.min(), right - left - 1 - columns.max()) >= 2 * scale, row.path


@pytest.mark.parametrize("width", [240, WIDTH])
def test_letters_stay_inside_their_buttons(egl, width):
    with staged(egl, "uniform", width=width) as stage:
        stage.edits.change({"camera.fov_deg": 50.0})
        stage.edits.change({"camera.fov_deg": 60.0})
        stage.edits.undo()
        stage.frames(3)
        image = stage.paint()
        for name in ("Undo", "Redo"):
            left, top, right, bottom = (round(x) for x in stage.seen[name])
            bright = image[top:bottom, left:right].min(axis=2) > 150
            columns = np.nonzero(bright.any(axis=0))[0]
            assert min(columns.min(), right - left - 1 - columns.max()) >= 4, name


# --- what rows are made of -----------------------------------------------------------------------


def test_labels_are_keys_without_their_units():
    found = {
        ("altitude_deg", "deg"): "altitude", ("irradiance_w_m2", "W/m²"): "irradiance",
        ("number_per_m3", "1/m³"): "number", ("rain_rate_mm_h", "mm/h"): "rain rate",
        ("water_temperature_c", "°C"): "water temperature", ("mean_um", "µm"): "mean",
        ("size_px", "px"): "size", ("log_std", ""): "log std",
        ("luminous_flux_lm", "lm"): "luminous flux",
    }  # fmt: skip
    for (name, unit), label in found.items():
        assert label_of(name, unit) == label


@pytest.mark.parametrize(
    "slide",
    [
        Slide(-90.0, 90.0), Slide(1.0, 5000.0, log=True), Slide(1e-4, 0.45, log=True),
        Slide(0.0, 5.0), Slide(1.0, 1000.0, log=True, whole=True), Slide(-2000.0, 2000.0),
    ],
)  # fmt: skip
def test_a_slider_goes_from_end_to_end_and_back(slide):
    assert slide.value(0.0) == slide.low
    assert slide.value(1.0) == slide.high
    values = [slide.value(x) for x in np.linspace(0.0, 1.0, 200)]
    assert values == sorted(values)
    assert len(set(values)) > 100
    assert slide.share(10**400) == 1.0
    for x in np.linspace(0.0, 1.0, 200):
        assert slide.share(slide.value(x)) == pytest.approx(x, abs=0.06 if slide.whole else 0.005)
    assert slide.share(slide.high * 10.0) == 1.0
    assert slide.share(slide.low - 1.0) == 0.0


def test_numbers_are_shown_short():
    assert [shown_number(x) for x in (20.0, 0.533, 3e6, 1e-4, 654.95, 7, 10**40)] == [
        "20", "0.533", "3e6", "0.0001", "654.95", "7", "100000…0000",
    ]  # fmt: skip


def test_sections_are_all_there(uniform):
    found = [path.removeprefix("section/") for path in uniform.seen if path.startswith("section/")]
    assert found == list(SECTIONS)
