"""The panel's widgets: each changes the scene, refuses what is wrong, and gives back what was."""

from __future__ import annotations

import shlex

import pytest

from panel_driver import KEY, Stage, is_red, shown_rows, staged, value
from rtbow.scene.text.file import builtin_scenes, parse_set
from rtbow.scene.text.values import changed_scene
from rtbow.view.document.proposals import shortened
from rtbow.view.panel.rows import Row, Slide
from rtbow.view.panel.widgets import spectrum_groups

# --- Every widget changes the scene ---------------------------------------------------------------

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
        # Not from the very edge, which the field's frame covers.
        share = max(row.slide.share(before), 0.03) if row.slide else 0.5
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


LEADING = ("look", "focal_length_mm", "around_m")
"""Keys that bring others along, as ``mixing`` and tags do."""


@pytest.mark.slow
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
            if row.kind != "tag" and row.name not in ("mixing", *LEADING):
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
            "camera.size_px.1": "999",
            "light.0.luminous_flux_lm": "2e7", "light.0.angular_diameter_deg": "0",
        }  # fmt: skip
        for path, text in numbers.items():
            if path not in stage.seen:
                continue
            stage.enter(path, text)
            assert value(stage, path) == pytest.approx(float(text)), path
        assert not stage.panel.rows.drafts.texts


def test_a_slider_gives_numbers_of_few_digits(uniform):
    uniform.drag("droplets.radius.radius_um", 0.3, 0.61)
    radius = value(uniform, "droplets.radius.radius_um")
    assert radius == float(f"{radius:.3g}")
    uniform.drag("light.0.altitude_deg", 0.5, 0.537)
    altitude = value(uniform, "light.0.altitude_deg")
    assert altitude == round(altitude, 1)
    uniform.drag("camera.size_px.0", 0.1, 0.5)
    assert isinstance(value(uniform, "camera.size_px.0"), int)


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
    assert not uniform.panel.rows.drafts.texts


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


# --- What is refused ------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "text", "told"),
    [
        ("light.0.altitude_deg", "91", "must be -90..90"),
        ("light.0.altitude_deg", "high", "must be a number, -90..90"),
        ("camera.fov_deg", "nan", "must be a finite number"),
        ("camera.size_px.0", "1.5", "must be a whole number"),
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
    draft = uniform.panel.rows.drafts.texts[path]
    assert draft.text == text
    assert told in draft.message
    assert is_red(uniform, path)
    uniform.key(KEY.escape)
    assert not uniform.panel.rows.drafts.texts
    assert not is_red(uniform, path)


def test_a_refused_text_can_be_made_right(uniform):
    uniform.enter("light.0.altitude_deg", "91")
    uniform.type("9")  # Enter has kept the keyboard, with all selected
    uniform.key(KEY.enter)
    assert value(uniform, "light.0.altitude_deg") == 9.0
    assert not uniform.panel.rows.drafts.texts


def test_reset_clears_what_was_refused(uniform):
    uniform.enter("camera.fov_deg", "50")
    uniform.enter("camera.fov_deg", "500")
    assert is_red(uniform, "camera.fov_deg")
    uniform.click("camera.fov_deg/reset")
    assert not uniform.panel.rows.drafts.texts
    assert value(uniform, "camera.fov_deg") == uniform.edits.opened.scene.camera.fov_deg


def test_what_the_message_repeats_is_left_out():
    text = "--set light.0.altitude_deg = 91.0; must be -90..90 deg"
    assert shortened(text, "light.0.altitude_deg") == "must be -90..90 deg"
    other = "--set droplets.radius.max_um = 5.0; must be greater than min_um = 9"
    assert shortened(other, "droplets.radius.min_um").startswith("droplets.radius.max_um = 5.0;")
    missing = "--set: droplets.grid is missing; give it"
    assert shortened(missing, "droplets.radius.mixing") == "droplets.grid is missing; give it"
    right = "--set compare.right.camera.fov_deg = 0.0; must be 1e-06 or more"
    assert shortened(right, "camera.fov_deg") == "must be 1e-06 or more"


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
    assert not uniform.panel.rows.drafts.refusals


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
        assert "must be greater than min_um" in stage.panel.rows.drafts.refusals[path].message
        stage.button(False)
        stage.frames(3)
        assert not stage.panel.rows.drafts.refusals
        assert not is_red(stage, path)


def test_a_refused_click_is_told(uniform):
    uniform.click("scattering.orders.1", 0.05)
    uniform.click("scattering.orders.2", 0.05)
    assert uniform.edits.scene.scattering.orders == (2,)
    assert uniform.panel.rows.drafts.refusals["scattering.orders"].message
    uniform.click("scattering.orders.1", 0.05)
    assert not uniform.panel.rows.drafts.refusals
    uniform.click("scattering.orders.1", 0.05)
    uniform.click("scattering.orders.2", 0.05)
    assert uniform.panel.rows.drafts.refusals
    uniform.drag("camera.fov_deg", 0.3, 0.6)
    assert not uniform.panel.rows.drafts.refusals


# --- Reset, copy ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_an_arrow_shows_where_a_value_differs_and_gives_it_back(uniform):
    first = uniform.edits.scene
    assert not [path for path in uniform.seen if path.endswith("/reset")]
    for row in shown_rows(first):
        drive(uniform, row)
        arrows = [path for path in uniform.seen if path.endswith("/reset")]
        assert f"{row.path}/reset" in arrows
        assert len(arrows) == 1 or row.name in LEADING
        uniform.edits.undo() if row.name in LEADING else uniform.click(arrows[0])
        uniform.frames(2)
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
                words = shlex.split(stage.panel.rows.tips.help_of(row, False)[-1][0])
                key, new = parse_set(words[1])
                assert changed_scene(stage.edits.scene, {key: new}) == stage.edits.scene
