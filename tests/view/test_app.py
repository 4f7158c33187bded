"""The live window on a screen of its own, driven by mouse and keyboard through the X server."""

from __future__ import annotations

import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import glfw
import numpy as np
import pytest
from imgui_bundle import imgui, implot
from PIL import Image
from pydantic import BaseModel

import rtbow
import rtbow.frames.image
import rtbow.scene.text.file
from rtbow.base.errors import UnavailableError
from rtbow.bench.memory import PeakMemory
from rtbow.frames.display import display
from rtbow.reference.render import spectral_radiance_along
from rtbow.scene.text.file import load_scene
from rtbow.scene.text.values import changed_scene
from rtbow.view.app import Viewer
from rtbow.view.document.edits import Opened
from rtbow.view.document.messages import Failed
from rtbow.view.panel.rows import rows_of
from rtbow.view.picture.navigate import antisolar
from rtbow.view.picture.projection import View
from rtbow.view.picture.readout import read_pixel
from rtbow.view.worker.pace import Order
from rtbow.world.world import resolve
from screen import ICONIC, NORMAL, SCREEN_PX, Hands

pytestmark = pytest.mark.slow

SIZE = (320, 180)
WINDOW = (SIZE[0] + 340, 600)
PATIENCE_S = 120.0


class Session:
    """A window and somebody's hands."""

    def __init__(self, viewer: Viewer, hands: Hands, unsaved: Path) -> None:
        self.viewer, self.hands = viewer, hands
        self._unsaved = unsaved
        self.earlier: set[Path] = set()

    def kept(self, stem: str) -> list[Path]:
        """The files that hold what was not saved of a scene, without those of earlier tests."""
        return [path for path in self._unsaved.glob(f"{stem}-*.toml") if path not in self.earlier]

    def until(self, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, (self.viewer.state.stale, self.viewer.state.notices)
            self.viewer.step()

    def settle(self) -> None:
        self.steps(3)
        self.until(lambda: self.viewer.settled)

    def steps(self, count: int) -> None:
        """Go on for some pictures of the window."""
        self.viewer.state.wake()
        goal = self.viewer.painted + count
        end = time.monotonic() + PATIENCE_S
        while self.viewer.painted < goal and time.monotonic() < end:
            self.viewer.state.wake()
            self.viewer.step()

    def tap(self, key: str, *modifiers: str) -> None:
        for name in (*modifiers, key):
            self.hands.key(name, True)
            self.steps(1)
        for name in (key, *reversed(modifiers)):
            self.hands.key(name, False)
            self.steps(1)

    def middle(self) -> tuple[float, float]:
        area = self.viewer.stage.view_units()
        assert area is not None
        return area[0] + 0.5 * area[2], area[1] + 0.5 * area[3]

    def move(self, x: float, y: float) -> None:
        self.hands.move(x, y)
        self.steps(2)

    def drag(self, start: tuple[float, float], end: tuple[float, float], pieces: int = 8) -> None:
        self.move(*start)
        self.hands.button(True)
        self.steps(2)
        for k in range(1, pieces + 1):
            self.move(*(a + (b - a) * k / pieces for a, b in zip(start, end, strict=True)))
        self.hands.button(False)
        self.steps(2)

    def click(self, x: float, y: float, times: int = 1) -> None:
        self.move(x, y)
        for _ in range(times):
            self.hands.button(True)
            self.steps(1)
            self.hands.button(False)
            self.steps(1)
        self.steps(2)

    def fail(self, kind: str, message: str) -> None:
        """Have the renderer say that it cannot draw the next frame."""
        worker = self.viewer.worker
        self.viewer.change({"light.0.altitude_deg": 12.5})
        self.until(lambda: worker.busy)
        reply = Failed(max(worker.pending), kind, message)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(worker, "replies", lambda: [reply])
            self.viewer.step()

    def right_click(self, x: float, y: float) -> None:
        self.move(x, y)
        self.hands.button(True, 3)
        self.steps(2)
        self.hands.button(False, 3)

    def picture(self) -> np.ndarray:
        """The part of the window that shows the scene: 8 bit sRGB (h, w, 3)."""
        left, bottom, width, height = self.viewer.stage.view_rect()
        whole = self.viewer.stage.image()
        top = len(whole) - bottom - height
        return whole[top : top + height, left : left + width]


def opened(name: str, *overrides: str, size: tuple[int, int] = SIZE) -> Opened:
    from rtbow.scene.text.file import parse_set

    typed = (*overrides, f"camera.size_px={list(size)}")
    return Opened(load_scene(name, dict(map(parse_set, typed))), name, typed)


@pytest.fixture(scope="module")
def session(screen: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Session]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("current"))
        data = tmp_path_factory.mktemp("data")
        patch.setenv("XDG_DATA_HOME", str(data))
        viewer, hands = Viewer(opened("uniform")), Hands(screen)
        glfw.set_window_pos(viewer.stage.window.handle, 0, 0)
        glfw.set_window_size(viewer.stage.window.handle, *WINDOW)
        yield Session(viewer, hands, data / "rtbow" / "unsaved")
        viewer.close()
        hands.close()


@pytest.fixture
def live(session: Session) -> Iterator[Session]:
    """The window on its first scene, settled, the mouse over the panel."""
    viewer = session.viewer
    viewer.edits.open(opened("uniform"))
    viewer.state.overlays.clear()
    viewer.state.notices.clear()
    viewer.hud.unmark()
    viewer.state.panel_open, viewer.state.help_open, viewer.state.side = True, False, "left"
    viewer.state.exposure_ev = None
    session.move(SIZE[0] + 150, 5)
    session.settle()
    session.earlier |= set(session.kept("*"))
    yield session
    for key in ("Shift_L", "Control_L", *"wasdqe"):
        session.hands.key(key, False)
    session.hands.button(False)
    session.steps(2)


# --- The picture --------------------------------------------------------------------------------


def test_the_picture_is_that_of_render(live):
    shown = live.viewer.state.frame
    assert shown.scene.camera.pixel == "area"  # all drops are alike
    with rtbow.Renderer(shown.scene) as renderer:
        rgb = renderer.render()
    assert shown.scene.camera.size_px == SIZE
    expected_ev = rtbow.frames.display.auto_exposure_ev(rgb)
    np.testing.assert_allclose(shown.exposure_ev, expected_ev, atol=0.05)
    expected = display(rgb, shown.exposure_ev).astype(int)
    # Another context's floats round to another code here and there.
    difference = np.abs(live.picture().astype(int) - expected)
    assert difference.max() <= 1
    assert (difference > 0).mean() < 0.02


def test_the_bow_is_where_the_panel_says(live):
    live.viewer.change({"light.0.altitude_deg": 10.0, "camera.altitude_deg": 25.0})
    live.settle()
    high = live.picture().sum(axis=2).astype(float)
    live.viewer.change({"light.0.altitude_deg": 25.0})
    live.settle()
    low = live.picture().sum(axis=2).astype(float)
    column = SIZE[0] // 2
    # The primary's top stands at 42 degrees less the sun's altitude; 15 degrees lower now.
    fov = live.viewer.edits.scene.camera.fov_deg
    focal = 0.5 * SIZE[0] / np.tan(np.radians(0.5 * fov))
    row = [90 - focal * np.tan(np.radians(42.0 - sun - 25.0)) for sun in (10.0, 25.0)]
    found = [float(np.argmax(image[:, column])) for image in (high, low)]
    np.testing.assert_allclose(found, row, atol=6.0)


def test_exposure_and_false_colours(live):
    before = live.picture().astype(float).mean()
    live.viewer.state.exposure_ev = live.viewer.state.frame.exposure_ev + 2.0
    live.steps(2)
    assert live.picture().astype(float).mean() < 0.6 * before
    live.tap("l")
    assert "false" in live.viewer.state.overlays
    colours = live.picture().reshape(-1, 3)
    # Viridis ends in dark violet and yellow.
    assert np.any((colours[:, 2] > 70) & (colours[:, 0] < 80) & (colours[:, 1] < 60))
    assert np.any((colours[:, 0] > 180) & (colours[:, 2] < 90))


def test_overlays_come_and_go_with_their_keys(live):
    plain = live.picture()
    for key in "cgb":
        live.tap(key)
        live.settle()
        drawn = live.picture()
        changed = np.any(drawn != plain, axis=2).mean()
        assert 0.002 < changed < 0.5, key
        live.tap(key)
        live.settle()
        assert np.any(live.picture() != plain, axis=2).mean() < 1e-3


# --- Moving about -------------------------------------------------------------------------------


def test_a_drag_turns_the_view_with_the_mouse(live):
    x, y = live.middle()
    before = live.viewer.edits.scene.camera
    live.drag((x, y), (x + 40, y + 20))
    after = live.viewer.edits.scene.camera
    focal = 0.5 * SIZE[0] / np.tan(np.radians(0.5 * before.fov_deg))
    assert after.azimuth_deg - before.azimuth_deg == pytest.approx(
        -np.degrees(40 / focal / np.cos(np.radians(before.altitude_deg))), rel=0.25
    )
    assert after.altitude_deg - before.altitude_deg == pytest.approx(
        np.degrees(20 / focal), rel=0.25
    )
    live.viewer.undo()
    assert live.viewer.edits.scene.camera == before
    assert not live.viewer.edits.changes


def seen_at(live, x: float, y: float) -> np.ndarray:
    """The direction that is seen at a place of the window."""
    left, top, width, height = live.viewer.stage.view_units()
    view = View(live.viewer.edits.scene.camera, (round(width), round(height)))
    return view.directions(np.array([x - left, y - top]))


def test_what_was_grabbed_stays_under_the_cursor(live):
    left, top, width, height = live.viewer.stage.view_units()
    start, end = (left + 0.9 * width, top + 0.8 * height), (left + 0.3 * width, top + 0.5 * height)
    grabbed = seen_at(live, *start)
    live.drag(start, end)
    assert seen_at(live, *end) @ grabbed == pytest.approx(1.0, abs=1e-9)


def test_the_wheel_keeps_what_is_under_the_cursor(live):
    left, top, width, height = live.viewer.stage.view_units()
    x, y = round(left + 0.8 * width), round(top + 0.3 * height)
    live.move(x, y)
    before = seen_at(live, x, y)
    fov_deg = live.viewer.edits.scene.camera.fov_deg
    for _ in range(3):
        live.hands.button(True, 4)
        live.hands.button(False, 4)
        live.steps(2)
    assert live.viewer.edits.scene.camera.fov_deg < fov_deg
    assert seen_at(live, x, y) @ before == pytest.approx(1.0, abs=1e-9)


def test_looking_and_flying_at_once_is_undone_at_once(live):
    x, y = live.middle()
    before = live.viewer.edits.scene.camera
    live.hands.key("w", True)
    live.drag((x, y), (x + 40, y + 20), pieces=20)
    live.hands.key("w", False)
    live.steps(3)
    after = live.viewer.edits.scene.camera
    assert after.position_m != before.position_m
    assert after.azimuth_deg != before.azimuth_deg
    live.viewer.undo()
    assert live.viewer.edits.scene.camera == before
    # What follows is a gesture of its own.
    live.viewer.redo()
    live.drag((x, y), (x - 30, y))
    live.viewer.undo()
    assert live.viewer.edits.scene.camera == after


def title(live) -> str:
    return live.hands.title(glfw.get_x11_window(live.viewer.stage.window.handle))


def test_a_move_of_the_camera_marks_the_title(live):
    assert title(live) == "uniform – rtbow"
    x, y = live.middle()
    live.drag((x, y), (x + 20, y))
    assert title(live) == "uniform* – rtbow"
    live.tap("z", "Control_L")
    assert title(live) == "uniform – rtbow"


def test_keys_fly_and_shift_flies_faster(live):
    ways = []
    for modifiers in ((), ("Shift_L",)):
        before = np.array(live.viewer.edits.scene.camera.position_m)
        for name in (*modifiers, "d"):
            live.hands.key(name, True)
        begun = time.monotonic()
        while time.monotonic() - begun < 0.6:
            live.viewer.step()
        for name in ("d", *modifiers):
            live.hands.key(name, False)
        live.steps(3)
        ways.append(np.array(live.viewer.edits.scene.camera.position_m) - before)
    assert ways[0][0] > 1.0  # to the right is east for a camera that looks north
    assert np.abs(ways[0][1:]).max() < 1e-9
    assert ways[1][0] > 2.0 * ways[0][0]


def test_the_wheel_zooms(live):
    x, y = live.middle()
    live.move(x, y)
    before = live.viewer.edits.scene.camera.fov_deg
    live.hands.button(True, 4)
    live.hands.button(False, 4)
    live.steps(3)
    assert live.viewer.edits.scene.camera.fov_deg < before


def test_a_double_click_centres_the_antisolar_point(live):
    x, y = live.middle()
    live.click(x, y, times=2)
    camera = live.viewer.edits.scene.camera
    from rtbow.world.camera.perspective import camera_basis

    forward = camera_basis(camera)[0]
    assert forward @ antisolar(live.viewer.edits.scene) == pytest.approx(1.0, abs=1e-9)


def test_zooms_apart_in_time_and_a_double_click_are_steps_of_their_own(live):
    x, y = live.middle()
    live.move(x, y)

    def zoom() -> None:
        live.hands.button(True, 4)
        live.hands.button(False, 4)
        live.steps(2)

    steps = [live.viewer.edits.scene.camera]
    zoom()
    zoom()
    steps.append(live.viewer.edits.scene.camera)
    end = time.monotonic() + 0.7
    while time.monotonic() < end:
        live.viewer.step()
    zoom()
    steps.append(live.viewer.edits.scene.camera)
    live.click(x, y, times=2)
    steps.append(live.viewer.edits.scene.camera)
    live.drag((x, y), (x + 30, y))
    for camera in reversed(steps):
        live.viewer.undo()
        assert live.viewer.edits.scene.camera == camera


def test_what_is_under_the_cursor_is_read_and_marked(live):
    x, y = live.middle()
    live.viewer.state.spectrum = None
    live.right_click(x, y)
    live.until(lambda: live.viewer.state.spectrum is not None)
    _, radiance = live.viewer.state.spectrum
    seen = read_pixel(
        live.viewer.frame_rgb, live.viewer.edits.scene, SIZE, (SIZE[0] / 2, SIZE[1] / 2)
    )
    fine = changed_scene(live.viewer.edits.scene, {"render.wavelength_step_nm": 1.0})
    (expected,) = spectral_radiance_along(resolve(fine), seen.direction[None])
    np.testing.assert_allclose(radiance, expected, rtol=1e-9)
    assert expected.max() > 0.0


def test_a_spectrum_is_of_before_only_once_the_light_has_changed(live):
    viewer = live.viewer
    x, y = live.middle()
    live.right_click(x, y)
    live.until(lambda: viewer.state.spectrum is not None)
    seen: list[str] = []
    begin = implot.begin_plot

    def titled(title: str, *args: object) -> bool:
        seen.append(title)
        return begin(title, *args)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(implot, "begin_plot", titled)
        live.steps(2)
        for change in ({"camera.azimuth_deg": 2.0}, {"render.max_delta_e": 1.0}):
            viewer.change(change)
            live.settle()
        live.tap("v")
        live.settle()
        assert seen
        assert not [title for title in seen if "before the change" in title]
        viewer.change({"light.0.altitude_deg": 11.0})
        live.settle()
        live.steps(2)
        assert "before the change" in seen[-2] + seen[-1]


def test_the_split_bar_is_dragged(live):
    live.tap("v")
    assert live.viewer.edits.scene.compare is not None
    live.viewer.change({"compare.right": {"scattering.orders": [1]}})
    live.settle()
    left, top, width, height = live.viewer.stage.view_units()
    y = top + 0.9 * height
    live.drag((left + 0.5 * width, y), (left + 0.25 * width, y))
    assert live.viewer.edits.scene.compare.split == pytest.approx(0.25, abs=0.02)
    live.settle()
    live.tap("v")
    assert live.viewer.edits.scene.compare is None


def test_the_last_right_side_comes_back(live):
    live.tap("v")
    right = {"scattering.orders": [1], "droplets.radius.radius_um": 120.0}
    live.viewer.change({"compare.right": right, "compare.split": 0.3})
    compare = live.viewer.edits.scene.compare
    live.tap("v")
    assert live.viewer.edits.scene.compare is None
    live.tap("v")
    assert live.viewer.edits.scene.compare == compare
    live.tap("v")
    # Drops of many sizes have no one radius: what does not fit any more is left out.
    rain = {"distribution": "uniform", "min_um": 100.0, "max_um": 400.0, "mixing": "local"}
    assert live.viewer.change({"droplets.radius": rain}) == ""
    live.tap("v")
    assert live.viewer.edits.scene.compare.right == {}


# --- The panel ----------------------------------------------------------------------------------


def test_every_slider_in_sight_moves_with_the_mouse(live):
    viewer = live.viewer
    glfw.set_window_size(viewer.stage.window.handle, SIZE[0] + 340, SCREEN_PX[1] - 100)
    viewer.panel.rows.seen = {}
    try:
        live.steps(4)
        for section in ("Air", "Theory", "Camera"):
            left, top, right, bottom = viewer.panel.rows.seen[f"section/{section}"]
            live.click(0.5 * (left + right), 0.5 * (top + bottom))
        live.steps(4)
        first = viewer.edits.scene
        numbers = {
            f"{row.name}.{inner.name}": inner
            for row in rows_of("", type(first))
            if isinstance(getattr(first, row.name), BaseModel)
            for inner in rows_of(row.name, type(getattr(first, row.name)))
            if inner.kind == "number"
        }
        tried = 0
        for path in list(viewer.panel.rows.seen):
            if path not in numbers and not path.startswith("light.0."):
                continue
            values = viewer.edits.scene.model_dump()
            at = values
            for part in path.split("."):
                at = at[int(part)] if part.isdigit() else at.get(part)
            if not isinstance(at, float):
                continue
            live.settle()  # a bar of progress above moves all down
            live.steps(2)
            left, top, right, bottom = viewer.panel.rows.seen[path]
            y = 0.5 * (top + bottom)
            middle = 0.5 * (left + right)
            live.drag((middle, y), (left + 0.8 * (right - left), y))
            assert list(viewer.edits.changes) == [path], path
            viewer.undo()
            live.steps(2)
            assert viewer.edits.scene == first, path
            tried += 1
        assert tried >= 6
    finally:
        viewer.panel.rows.seen = None
        glfw.set_window_size(viewer.stage.window.handle, *WINDOW)
        live.steps(4)


def test_the_panel_goes_and_comes(live):
    assert live.viewer.stage.view_rect()[2] == SIZE[0]
    live.tap("Tab")
    assert not live.viewer.state.panel_open
    assert live.viewer.stage.panel_units() == 0.0
    live.tap("Tab")
    assert live.viewer.state.panel_open


def test_help_lists_the_keys(live):
    plain = live.viewer.stage.image()
    live.tap("F1")
    live.steps(3)
    assert live.viewer.state.help_open
    assert np.any(live.viewer.stage.image() != plain, axis=2).mean() > 0.05
    live.tap("F1")
    assert not live.viewer.state.help_open


def test_escape_closes_what_is_open_and_only_then_the_window(live):
    viewer = live.viewer
    x, y = live.middle()
    live.right_click(x, y)
    live.steps(2)
    live.tap("F1")
    glfw.set_window_size(viewer.stage.window.handle, SIZE[0] + 340, SCREEN_PX[1] - 100)
    viewer.panel.rows.seen = {}
    live.steps(4)
    left, top, right, bottom = viewer.panel.rows.seen["view.method"]
    viewer.panel.rows.seen = None
    live.click(0.5 * (left + right), 0.5 * (top + bottom))
    every = imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level
    assert imgui.is_popup_open("", every)
    live.tap("Escape")
    assert not imgui.is_popup_open("", every)
    assert viewer.state.help_open
    live.tap("Escape")
    assert not viewer.state.help_open
    assert not viewer.stage.window.closing
    live.tap("Escape")
    assert not viewer.hud.unmark()
    assert not viewer.stage.window.closing
    live.tap("Escape")
    assert viewer.stage.window.closing
    glfw.set_window_should_close(viewer.stage.window.handle, False)
    glfw.set_window_size(viewer.stage.window.handle, *WINDOW)
    live.steps(4)


def test_a_change_never_stops_the_window(live, no_rendering):
    """Steps of the loop while tables are built anew elsewhere; seconds would be a frozen window."""
    local = {"distribution": "normal", "mean_um": 310.0, "std_um": 40.0, "mixing": "local"}
    changes: list[dict[str, object]] = [
        {"droplets.radius.radius_um": 100.0}, {"droplets.radius.radius_um": 470.0},
        {"scattering.theory": "mie"}, {"scattering.theory": "airy", "light.0.spectrum": "FL2"},
        {"droplets.radius": local},
    ]  # fmt: skip
    live.viewer.state.overlays.add("false")
    times = []
    for change in changes:
        begun = time.perf_counter()
        assert live.viewer.change(change) == ""
        while not live.viewer.settled:
            assert sum(times) < PATIENCE_S, change
            live.viewer.step()
            now = time.perf_counter()
            times.append(now - begun)
            begun = now
    assert live.viewer.state.frame.scene.droplets.radius.distribution == "normal"
    # Tables take most of the time, and no step waits for them.
    assert max(times) < 0.25 * sum(times)


# --- Keeping ------------------------------------------------------------------------------------


def test_undo_redo_and_the_command(live):
    live.viewer.change({"light.0.altitude_deg": 12.0})
    live.tap("c", "Control_L")
    text = glfw.get_clipboard_string(None).decode()
    assert text.startswith("rtbow render uniform --set 'camera.size_px=[320, 180]'")
    assert "--set light.0.altitude_deg=12.0" in text
    live.tap("z", "Control_L")
    assert not live.viewer.edits.changes
    live.tap("z", "Control_L", "Shift_L")
    assert live.viewer.edits.changes == {"light.0.altitude_deg": 12.0}


def test_the_command_makes_the_very_file_that_is_saved(live, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    viewer = live.viewer
    viewer.state.method, viewer.state.exposure_ev = "spectral", 12.3456789
    viewer.save_frame(("saved.exr", "saved.png"))
    words = shlex.split(viewer.command("-o", "again.exr", "-o", "again.png"))
    viewer.state.method = "auto"
    assert words[:3] == ["rtbow", "render", "uniform"]
    assert "12.3456789" in words
    live.until(lambda: not viewer.jobs.saving)
    subprocess.run([sys.executable, "-m", *words], check=True, timeout=PATIENCE_S)
    np.testing.assert_array_equal(
        rtbow.frames.image.read_exr(tmp_path / "saved.exr")[0],
        rtbow.frames.image.read_exr(tmp_path / "again.exr")[0],
    )
    np.testing.assert_array_equal(
        np.array(Image.open("saved.png")), np.array(Image.open("again.png"))
    )


def test_saved_frame_and_scene_give_the_same_picture(live, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    live.viewer.change({"light.0.altitude_deg": 12.0, "camera.fov_deg": 61.0})
    live.settle()
    frame, scene = tmp_path / "found.exr", tmp_path / "found.toml"
    live.viewer.save_frame((str(frame), str(frame.with_suffix(".png"))))
    live.viewer.save_scene(str(scene))
    live.until(lambda: frame.with_suffix(".png").is_file())
    live.settle()
    saved, metadata = rtbow.frames.image.read_exr(frame)
    with rtbow.Renderer(load_scene(scene)) as renderer:
        again = renderer.render()
    np.testing.assert_array_equal(saved, again)
    assert metadata["method"] == "fast"
    assert metadata["command"].startswith("rtbow render uniform")
    assert rtbow.scene.text.file.scene_from_text(metadata["scene"]) == load_scene(scene)


def test_keys_save_under_names_that_are_free(live, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    live.tap("e", "Control_L")
    live.until(lambda: (tmp_path / "uniform-01.png").is_file())
    live.tap("e", "Control_L")
    live.until(lambda: (tmp_path / "uniform-02.png").is_file())
    live.tap("s", "Control_L")
    assert load_scene(tmp_path / "uniform-01.toml") == live.viewer.edits.scene


def test_frames_that_are_being_saved_have_their_names_already(live, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    live.viewer.change({"camera.size_px": [160, 90]})
    live.viewer.state.method = "reference"  # takes seconds: the first is not there before the last
    live.tap("e", "Control_L")
    live.tap("e", "Control_L")
    live.viewer.save_frame(("uniform-01.exr", "uniform-01.png"))
    names = ["uniform-01-01.png", "uniform-01.png", "uniform-02.png"]
    live.until(lambda: not live.viewer.jobs.saving)
    assert sorted(path.name for path in tmp_path.glob("*.png")) == names
    assert len(list(tmp_path.glob("*.exr"))) == 3


def test_pictures_go_on_while_a_frame_is_saved(live, tmp_path):
    viewer = live.viewer
    viewer.change({"render.wavelength_step_nm": 1.0, "camera.size_px": [160, 90]})
    viewer.state.method = "reference"
    viewer.save_frame((str(tmp_path / "slow.exr"),))
    viewer.state.method = "auto"
    shown = viewer.state.frames_shown
    viewer.change({"light.0.altitude_deg": 12.0})
    live.settle()
    assert viewer.state.frames_shown > shown
    live.until(lambda: not viewer.jobs.saving)
    assert (tmp_path / "slow.exr").is_file()


def test_a_frame_that_cannot_be_saved_is_told(live, tmp_path):
    live.viewer.save_frame((str(tmp_path / "nowhere" / "a.exr"),))
    live.until(lambda: not live.viewer.jobs.saving)
    assert "mkdir" in live.viewer.state.notices[-1].text


# --- What goes wrong ----------------------------------------------------------------------------


def test_each_mistake_stands_until_the_same_goes_well(live):
    viewer = live.viewer
    viewer.state.report("file", "mine.toml: wrong")
    viewer.change({"light.0.altitude_deg": 12.0})
    live.settle()
    assert viewer.state.stale == "mine.toml: wrong"
    live.fail("input", "not with these drops")
    assert viewer.state.stale == "mine.toml: wrong\nnot with these drops"
    viewer.change({"light.0.altitude_deg": 13.0})
    live.settle()
    assert viewer.state.stale == "mine.toml: wrong"
    viewer.state.report("file")
    assert viewer.state.stale == ""


def test_answers_of_one_process_are_not_taken_for_the_other_s(live):
    viewer = live.viewer
    order = Order(-1, 1.0, False)
    viewer._orders[10**6] = order, 0.0
    viewer.jobs._saving[10**6] = ("a.exr",)
    viewer.jobs.take(Failed(10**6, "input", "the disk is full"))
    assert viewer.state.notices[-1].text == "the disk is full"
    assert viewer.state.stale == ""
    assert viewer._orders.pop(10**6) == (order, 0.0)
    viewer.jobs._spectrum_asked = 10**6
    viewer.jobs.take(Failed(10**6, "input", "no light there"))
    assert viewer.state.spectrum_problem == "no light there"


def test_a_machine_that_draws_nothing_at_all_ends_the_window(live):
    live.viewer.state.frame = None
    with pytest.raises(UnavailableError, match="libegl1"):
        live.fail("machine", "install libegl1")
    live.settle()  # the picture that was drawn nevertheless


def test_a_lost_context_is_told(live, monkeypatch):
    # GL_UNKNOWN_CONTEXT_RESET
    monkeypatch.setattr(live.viewer.stage.window, "_reset_status", lambda: 0x8255)
    live.viewer.state.wake()
    with pytest.raises(UnavailableError, match="context is lost"):
        live.steps(1)


def test_a_renderer_that_is_lost_is_told_and_comes_back(live):
    viewer = live.viewer
    lost = viewer.worker.process_id
    os.kill(lost, signal.SIGKILL)
    live.until(lambda: bool(viewer.state.notices))
    assert "process ended" in viewer.state.notices[-1].text
    viewer.change({"light.0.altitude_deg": 12.0})
    live.settle()
    assert viewer.worker.process_id != lost


def test_unsaved_changes_are_kept(live, tmp_path):
    viewer = live.viewer
    viewer.change({"light.0.altitude_deg": 12.0})
    live.until(lambda: live.kept("uniform"))
    (kept,) = live.kept("uniform")
    assert load_scene(kept) == viewer.edits.scene
    viewer.change({"light.0.altitude_deg": 13.0})
    live.until(lambda: load_scene(kept) == viewer.edits.scene)
    assert live.kept("uniform") == [kept]
    viewer.save_scene(str(tmp_path / "mine.toml"))
    live.until(lambda: not kept.exists())
    viewer.change({"light.0.altitude_deg": 14.0})
    live.until(lambda: live.kept("mine"))
    viewer.undo()
    live.until(lambda: not live.kept("mine"))
    assert not live.kept("*")


def test_what_was_wrong_with_a_file_is_over_once_it_is_saved(live, tmp_path):
    viewer, mine = live.viewer, tmp_path / "mine.toml"
    viewer.save_scene(str(mine))
    viewer.state.report("file", "mine.toml: wrong")
    viewer.save_scene(str(mine))
    assert viewer.state.stale == ""


def test_dropped_files_are_opened_or_refused(live, tmp_path):
    good, bad, other = tmp_path / "a b.toml", tmp_path / "bad.toml", tmp_path / "a.txt"
    shutil.copy(rtbow.scene.text.file.builtin_scenes()["street-lamp"], good)
    bad.write_text("[camera]\nfov_deg = 200\n")
    other.write_text("")
    window = glfw.get_x11_window(live.viewer.stage.window.handle)

    def drop(path: Path) -> None:
        live.hands.drop(window, [path.as_uri()], live.viewer.step)
        live.steps(3)

    before = live.viewer.edits.scene
    drop(bad)
    assert "camera.fov_deg = 200" in live.viewer.state.stale
    assert live.viewer.edits.scene == before
    drop(other)
    assert "not a scene" in live.viewer.state.notices[-1].text
    drop(good)
    assert live.viewer.state.stale == ""
    assert live.viewer.edits.scene == load_scene(good)
    assert live.viewer.state.recent[0] == str(good)
    live.settle()
    other_toml = tmp_path / "saved.toml"
    live.viewer.save_scene(str(other_toml))
    assert live.viewer.state.recent[:2] == [str(other_toml), str(good)]


# --- The window itself --------------------------------------------------------------------------


def test_sizes_from_one_pixel_up(live):
    viewer = live.viewer
    for width, height in ((1, 1), (200, 120), (2, 400), (800, 300)):
        glfw.set_window_size(viewer.stage.window.handle, width, height)
        live.until(lambda: glfw.get_window_size(viewer.stage.window.handle) == (width, height))  # noqa: B023
        live.steps(3)
    glfw.set_window_size(viewer.stage.window.handle, *WINDOW)
    live.settle()
    assert viewer.stage.view_rect()[2:] == SIZE
    assert live.picture().mean() > 1.0


def test_minimised_and_brought_back(live):
    viewer = live.viewer
    window = glfw.get_x11_window(viewer.stage.window.handle)
    live.hands.set_state(window, ICONIC)
    live.until(lambda: not viewer.stage.window.visible)
    painted = viewer.painted
    for _ in range(20):
        viewer.step()
    assert viewer.painted == painted
    live.hands.set_state(window, NORMAL)
    live.until(lambda: viewer.stage.window.visible)
    live.settle()
    assert live.picture().mean() > 1.0


def test_full_screen_and_back(live):
    live.tap("F11")
    live.until(lambda: glfw.get_window_size(live.viewer.stage.window.handle) == SCREEN_PX)
    live.steps(3)
    live.tap("F11")
    live.until(lambda: glfw.get_window_size(live.viewer.stage.window.handle) == WINDOW)
    live.settle()


def test_hundreds_of_pictures_take_no_memory(live):
    viewer = live.viewer
    first = 0.0, 0.0
    for k in range(500):
        viewer.change({"light.0.altitude_deg": 10.0 + 5.0 * np.sin(0.05 * k)}, "turn")
        live.steps(1)
        if k == 200:
            first = PeakMemory().start_mib, resident_mib(viewer.worker.process_id)
    assert PeakMemory().start_mib - first[0] < 5.0
    assert resident_mib(viewer.worker.process_id) - first[1] < 5.0  # nor in the one that renders


def resident_mib(process: int) -> float:
    status = Path(f"/proc/{process}/status").read_text()
    return float(status.split("VmRSS:")[1].split()[0]) / 1024.0
