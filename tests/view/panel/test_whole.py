"""The panel, driven by mouse and keyboard: it shows all of the scene, and how it is shown."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import pytest
from PIL import Image
from pydantic import BaseModel, Field

from panel_driver import KEY, SECTIONS, WIDTH, is_red, shown_rows, staged
from rtbow.scene.model import Camera, Scene
from rtbow.scene.text.file import builtin_scenes, load_scene, scene_from_text, scene_title
from rtbow.scene.text.values import changed_scene, scene_text
from rtbow.view.document.messages import FrameDrawn
from rtbow.view.document.state import OVERLAYS, Notice, ViewState
from rtbow.view.panel.kinds import left_out_of
from rtbow.view.panel.rows import Slide, label_of, shown_number, shown_unit
from rtbow.view.panel.sections.gallery import thumbnail_path
from rtbow.view.panel.sections.status import error_text

# --- All of the scene -----------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [n for n in builtin_scenes() if not load_scene(n).camera.whole_sphere]
)
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


@pytest.mark.slow
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


def frame(scene: Scene, **options: Any) -> FrameDrawn:
    given = {
        "number": 1, "scene": scene, "rgb": np.zeros((2, 2, 3), np.float32), "seconds": 0.02,
        "exposure_ev": 14.0, "method": "fast", "unsuited": "", "renderer": "llvmpipe",
    }  # fmt: skip
    return FrameDrawn(**(given | options))


# --- The picture, scenes, keeping -----------------------------------------------------------------


@pytest.mark.slow
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
            assert not stage.panel.rows.drafts.texts


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
        "rtbow.view.panel.sections.gallery.scene_title", lambda path: read.append(path) or "a title"
    )
    with staged(egl, "uniform") as stage:
        monkeypatch.setattr("rtbow.view.panel.sections.gallery.builtin_scenes", lambda: 1 / 0)
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


def test_a_frame_is_replaced_after_a_question(uniform, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.png").write_text("precious")
    uniform.click("keep.frame")
    uniform.type("a")
    uniform.key(KEY.enter)
    uniform.click("keep/save frame")
    assert uniform.actions.asked == []
    uniform.click("keep/leave it")
    assert uniform.actions.asked == []
    uniform.click("keep/save frame")
    uniform.click("keep/replace it")
    assert uniform.actions.asked == [("frame", ("a.exr", "a.png"))]
    assert "keep/replace it" not in uniform.seen


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
    state.scale = 1.0
    uniform.hover("status/error")
    before = uniform.paint().astype(int)
    uniform.frames(60)
    assert np.abs(uniform.paint() - before).mean() > 0.1  # a tip says what that means
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
    state.report("frame", "droplets.file: there is no such file")
    state.notices = [Notice("done", "info", 1e9), Notice("broken", "error", 1e9)]
    uniform.frames(2)
    assert uniform.seen["section/Scenes"][1] > with_reason + 30.0
    assert "notice/0/close" not in uniform.seen  # what went well stands over the picture
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


@pytest.mark.slow
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


# --- Dense displays -------------------------------------------------------------------------------


@pytest.mark.slow
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


LONG = {
    "camera.position_m": [-1234.56, -1000.25, -0.0123456],
    "camera.lens_shift": [-0.123456, 0.123456],
    "droplets.box_m": [[-1234.56, -987.654, 0.123456], [1234.56, 1987.65, 1100.25]],
    "droplets.density.number_per_m3": 123456.0,
}
"""Numbers of many digits."""
AROUND = {"droplets.around_m": [1234.56, 987.654], "droplets.box_m": None}


@pytest.mark.parametrize("scale", [1.0, 2.0])
@pytest.mark.parametrize(
    ("name", "changes"), [("shower", None), ("uniform", LONG), ("uniform", LONG | AROUND)]
)
def test_letters_stay_inside_their_fields(egl, name, changes, scale):
    """Of a number's own letters, some pixels of its field are left all around."""
    size = {"height": round(4000 * scale), "width": round(WIDTH * scale), "scale": scale}
    with staged(egl, name, changes=changes, **size) as stage:
        stage.open_all()
        stage.mouse(-100.0, -100.0)
        stage.frames(3)
        image = stage.paint()
        shown = shown_rows(stage.edits.scene)
        numbers = [row.path for row in shown if row.kind == "number" and row.path in stage.seen]
        for row in shown:
            if row.kind in ("vector", "corners"):
                inside = [path for path in stage.seen if path.startswith(f"{row.path}.")]
                numbers += inside
        for path in numbers:
            left, top, right, bottom = (round(x) for x in stage.seen[path])
            bright = image[top:bottom, left:right].min(axis=2) > 150
            assert bright.any(), path
            rows, columns = np.nonzero(bright)
            assert min(rows.min(), bottom - top - 1 - rows.max()) >= 2 * scale, path
            assert min(columns.min(), right - left - 1 - columns.max()) >= 2 * scale, path


SLIDERS = {
    "camera.altitude_deg": (-90.0, 90.0),
    "camera.position_m.1": (-2000.0, 2000.0),
    "scattering.salinity_g_kg": (0.0, 40.0),  # g reaches below the line
}


@pytest.mark.parametrize("scale", [1.0, 1.25, 2.0])
def test_a_handle_covers_no_part_of_its_number(egl, scale):
    size = {"height": round(2000 * scale), "width": round(WIDTH * scale), "scale": scale}
    with staged(egl, "uniform", **size) as stage:
        stage.click("section/Theory")
        stage.click("section/Camera")
        stage.mouse(-100.0, -100.0)
        places: dict[str, list[float]] = {path: [] for path in SLIDERS}
        starts: dict[str, list[float]] = {path: [] for path in SLIDERS}
        for share in (0.0, 0.5, 1.0):
            stage.edits.change({p: (1 - share) * a + share * b for p, (a, b) in SLIDERS.items()})
            stage.frames(2)
            image = stage.paint().astype(float)
            for path in SLIDERS:
                left, top, right, bottom = (round(x) for x in stage.seen[path])
                field = image[top:bottom, left:right]
                handle = field[..., 2] - field[..., 0] > 60.0
                letters = (field.min(axis=2) > 90.0) & ~handle  # which are grey
                assert np.nonzero(letters)[0].max() < np.nonzero(handle)[0].min(), (path, share)
                places[path].append(np.nonzero(handle)[1].mean() / (right - left))
                starts[path].append(np.nonzero(letters)[1].min() / scale)
        for path in SLIDERS:
            assert places[path] == pytest.approx([0.05, 0.5, 0.95], abs=0.02)
            assert np.ptp(starts[path]) <= 3.0  # the number stands still


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


# --- What rows are made of ------------------------------------------------------------------------


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


def test_what_holds_where_a_number_is_left_out_has_its_unit(uniform):
    rows = {row.path: row for row in shown_rows(uniform.edits.scene)}
    assert rows["light.0.irradiance_w_m2"].absent_text == "654.95 W/m²"
    assert rows["camera.polarizer_deg"].absent_text == "no filter"
    moon = load_scene("uniform", {"light.0.spectrum": "moon"}).light[0]
    row = left_out_of(rows["light.0.irradiance_w_m2"], moon)
    assert 0.0015 < row.start < 0.0025  # a 400,000th of the sun's, as published
    assert row.absent_text == f"{row.start:.4g} W/m²"


def test_units_are_those_that_the_model_names():
    units = {"deg": "20°", "1/m³": "20 per m³", "%": "20 %", "µm": "20 µm", "": "20"}
    for unit, text in units.items():
        assert f"20{shown_unit(unit)}" == text


def test_orders_are_named(uniform):
    row = next(r for r in shown_rows(uniform.edits.scene) if r.path == "scattering.orders")
    assert row.names == ("1 primary", "2 secondary")


def test_numbers_are_shown_short():
    assert [shown_number(x) for x in (20.0, 0.533, 3e6, 1e-4, 654.95, 7, 10**40)] == [
        "20", "0.533", "3e6", "0.0001", "654.95", "7", "100000…0000",
    ]  # fmt: skip


def test_sections_are_all_there(uniform):
    found = [path.removeprefix("section/") for path in uniform.seen if path.startswith("section/")]
    assert found == list(SECTIONS)
