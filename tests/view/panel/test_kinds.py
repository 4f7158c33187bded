"""Kinds of lights and drops that turn into one another in the panel, on either side of a split."""

from __future__ import annotations

import shutil
from typing import Annotated, Literal

import numpy as np
import pytest
from pydantic import BaseModel, Field

from panel_driver import KEY, is_red, staged
from rtbow.scene.droplets import Droplets
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene, scene_from_text
from rtbow.scene.text.schema import ROOT
from rtbow.scene.text.values import changed_scene, scene_text, values_of
from rtbow.view.document.proposals import merged
from rtbow.view.panel import kinds

DISTRIBUTIONS = (
    "constant", "uniform", "normal", "lognormal", "gamma", "modified-gamma", "marshall-palmer",
    "table",
)  # fmt: skip


# --- Kinds ----------------------------------------------------------------------------------------


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
    if not {"marshall-palmer", "table"} & {before, after}:
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
        assert not uniform.panel.rows.drafts.refusals
        uniform.click("droplets.radius.distribution/reset")
        assert uniform.edits.scene == first


def test_drops_that_count_themselves_are_shown_without_a_density(egl):
    with staged(egl, "fogbow") as stage:
        assert "droplets.radius.effective_variance" in stage.seen
        assert "droplets.radius.n0" not in stage.seen
        stage.edits.change(
            {
                "droplets.radius.n0": 8e3, "droplets.radius.mu": 2.0,
                "droplets.radius.lambda_per_mm": 4.0,
            }
        )  # fmt: skip
        stage.frames(2)
        assert {"droplets.radius.n0", "droplets.radius.mu"} <= stage.seen.keys()
        assert "droplets.radius.effective_variance" not in stage.seen
        assert not any(path.startswith("droplets.density.") for path in stage.seen)
        stage.click("droplets.radius.distribution")
        stage.click("droplets.radius.distribution=table")
        assert stage.edits.scene.droplets.radius.distribution == "table"
        assert stage.edits.scene.droplets.density is None
        assert "droplets.radius.file" in stage.seen


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
    monkeypatch.setattr("rtbow.world.rain.volume.load_volume", lambda path: 1 / 0)
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


def test_a_mixture_of_aerosol_leaves_out_the_numbers_of_a_free_one(egl):
    changes = {"atmosphere.aerosol": {"model": "custom", "asymmetry": 0.5}}
    with staged(egl, "uniform", changes=changes) as stage:
        stage.open_all()
        stage.click("atmosphere.aerosol.model")
        stage.click("atmosphere.aerosol.model=maritime-clean")
        aerosol = stage.edits.scene.atmosphere.aerosol
        assert (aerosol.model, aerosol.asymmetry) == ("maritime-clean", None)
        stage.edits.undo()
        assert stage.edits.scene.atmosphere.aerosol.asymmetry == 0.5


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
        if uniform.panel.rows.drafts.texts:
            uniform.key(KEY.escape)
        uniform.click("light.0.spectrum")
        uniform.click("light.0.spectrum=file")
        uniform.type(text)
        uniform.key(KEY.enter)
        if text == str(path):
            assert uniform.edits.scene.light[0].spectrum == text
        else:
            assert uniform.edits.scene.light[0].spectrum == "E490"
            assert "file not found" in uniform.panel.rows.drafts.texts["light.0.spectrum"].message


def test_a_volume_file_that_is_not_there_is_refused(egl, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.npz").write_text("no archive")
    np.savez(tmp_path / "half.npz", radius_um=np.ones((2, 2, 2)), box_m=np.zeros((2, 3)))
    shutil.copy(builtin_scenes()["default"].parent / "curtain.npz", tmp_path / "own.npz")
    with staged(egl, "shower") as stage:
        before = stage.edits.scene
        for text, told in (
            ("none.npz", "volume file not found"), ("notes.npz", "not a volume file"),
            ("half.npz", "lacks number_per_m3"), (".", "not a volume file"),
        ):  # fmt: skip
            stage.click("droplets.file")
            stage.type(text)
            stage.key(KEY.enter)
            assert told in stage.panel.rows.drafts.texts["droplets.file"].message
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
            assert "not found" in stage.panel.rows.drafts.texts["compare.right"].message
            assert stage.edits.scene.compare.right == {}
            stage.key(KEY.escape)
            stage.frames(2)


# --- Two sides ------------------------------------------------------------------------------------


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
        assert stage.panel.rows.drafts.texts["camera.fov_deg"].text == "30.0"


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
