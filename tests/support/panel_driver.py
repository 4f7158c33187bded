"""A panel without a window: drawn on EGL, driven by events as a person's hands make them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from imgui_bundle import imgui
from pydantic import BaseModel

from rtbow.base.errors import InputError
from rtbow.gl.context import GlContext
from rtbow.scene.air import FREE_AEROSOL
from rtbow.scene.lights import LIT, TIME_AND_PLACE
from rtbow.scene.model import Scene
from rtbow.scene.radius import GammaRadius
from rtbow.scene.text.file import load_scene
from rtbow.scene.text.schema import ROOT, Node
from rtbow.view.document.edits import Edits, Opened
from rtbow.view.document.proposals import split_path, value_at
from rtbow.view.document.state import ViewState
from rtbow.view.panel.rows import Row, rows_of
from rtbow.view.panel.whole import Panel
from rtbow.view.window import look
from rtbow.view.window.help import draw_help

FRAME_S = 1.0 / 60.0
WIDTH = 340
KEY = imgui.Key
SECTIONS = ("Scenes", "Sun", "Drops", "Air", "Theory", "Camera", "Picture", "Keep")


@dataclass
class Recorded:
    """Does what the window does with the scene, and remembers what else was asked for."""

    edits: Edits
    state: ViewState
    asked: list[tuple[str, object]] = field(default_factory=list)

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        try:
            self.edits.change(changes, gesture)
        except InputError as error:
            return str(error)
        return ""

    def undo(self) -> None:
        self.edits.undo()

    def redo(self) -> None:
        self.edits.redo()

    def open_scene(self, name_or_path: str) -> None:
        self.asked.append(("open", name_or_path))

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        self.asked.append(("replace" if replace else "scene", path))

    def save_frame(self, paths: tuple[str, ...]) -> None:
        self.asked.append(("frame", paths))

    def copy_command(self) -> None:
        self.asked.append(("command", self.edits.command()))

    def split(self, on: bool) -> None:
        self.asked.append(("split", on))
        if on:
            self.edits.change({"compare": {"right": {}}})
        else:
            self.edits.change({"compare": None})
            self.state.side = "left"


class Stage:
    """A panel of a scene on a screen of its own.

    Args:
        gl: a current context.
        edits: the scene.
        height: of the screen, which the panel fills.
        width: of the screen.
        scale: of letters and distances.
        state: how the picture is shown at first.
    """

    def __init__(
        self,
        gl: GlContext,
        edits: Edits,
        height: int = 4000,
        width: int = WIDTH,
        scale: float = 1.0,
        state: ViewState | None = None,
    ) -> None:
        imgui.create_context()
        look.apply()
        self.scale = scale
        self.size = (width, height)
        self.io = imgui.get_io()
        self.io.set_ini_filename("")
        self.io.display_size = imgui.ImVec2(*self.size)
        self.io.delta_time = FRAME_S
        assert imgui.backends.opengl3_init("#version 330")
        self.target = gl.ctx.framebuffer([gl.ctx.texture(self.size, 4)])
        self.state = state or ViewState()
        self.actions = Recorded(edits, self.state)
        self.panel = Panel(self.actions)
        self.panel.rows.seen = {}
        self.mouse(-100.0, -100.0)
        self.frames(3)

    @property
    def edits(self) -> Edits:
        return self.actions.edits

    @property
    def seen(self) -> dict[str, tuple[float, float, float, float]]:
        """Rectangles of the widgets of the last frame."""
        assert self.panel.rows.seen is not None
        return self.panel.rows.seen

    def frames(self, count: int = 1) -> None:
        """Draw."""
        for _ in range(count):
            self.panel.rows.seen = {}
            look.scale(self.scale)
            imgui.backends.opengl3_new_frame()
            imgui.new_frame()
            if self.state.help_open:
                draw_help(self.state)
            imgui.set_next_window_pos(imgui.ImVec2(0.0, 0.0))
            imgui.set_next_window_size(imgui.ImVec2(*self.size))
            flags = imgui.WindowFlags_.no_move | imgui.WindowFlags_.no_resize
            flags |= imgui.WindowFlags_.no_title_bar | imgui.WindowFlags_.no_background
            imgui.begin("rtbow", None, flags)
            self.panel.draw(self.edits, self.state)
            self.scroll = imgui.get_scroll_y(), imgui.get_scroll_max_y()
            imgui.end()
            imgui.render()

    def paint(self) -> np.ndarray:
        """Give the picture of the last frame, (h, w, 3)."""
        self.target.use()
        self.target.clear(*look.BACKGROUND)
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        data = self.target.read(components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(self.size[1], self.size[0], 3)[::-1]

    def screenshot(self, path: Path) -> None:
        """Write the picture of the last frame."""
        from PIL import Image

        Image.fromarray(np.ascontiguousarray(self.paint())).save(path)

    # --- hands --------------------------------------------------------------------------------

    def mouse(self, x: float, y: float) -> None:
        self.io.add_mouse_pos_event(x, y)

    def button(self, down: bool, number: int = 0) -> None:
        self.io.add_mouse_button_event(number, down)

    def at(self, path: str, share: float = 0.5) -> tuple[float, float]:
        """A point in a widget, a share of its width from the left."""
        left, top, right, bottom = self.seen[path]
        return left + share * (right - left), 0.5 * (top + bottom)

    def hover(self, path: str, share: float = 0.5) -> None:
        self.mouse(*self.at(path, share))
        self.frames(2)

    def click(self, path: str, share: float = 0.5, number: int = 0) -> None:
        """Click once, long after any click before."""
        self.frames(30)
        self.hover(path, share)
        self.press(number)

    def press(self, number: int = 0) -> None:
        self.button(True, number)
        self.frames()
        self.button(False, number)
        self.frames(2)

    def double_click(self, path: str, share: float = 0.5) -> None:
        self.click(path, share)
        self.press()

    def drag(self, path: str, start: float, end: float, steps: int = 6) -> None:
        """Drag over a widget, from and to a share of its width."""
        self.frames(30)
        self.hover(path, start)
        (x0, y), (x1, _) = self.at(path, start), self.at(path, end)
        self.button(True)
        self.frames()
        for step in range(1, steps + 1):
            self.mouse(x0 + (x1 - x0) * step / steps, y)
            self.frames()
        self.button(False)
        self.frames(2)

    def key(self, key: imgui.Key, *, control: bool = False) -> None:
        self.frames(3)  # a field that has just got the keyboard hears it then
        if control:
            self.io.add_key_event(KEY.mod_ctrl, True)
        self.io.add_key_event(key, True)
        self.frames()
        self.io.add_key_event(key, False)
        self.io.add_key_event(KEY.mod_ctrl, False)
        self.frames(2)

    def type(self, text: str) -> None:
        """Type over what is selected."""
        self.frames(3)
        self.io.add_input_characters_utf8(text)
        self.frames(2)

    def enter(self, path: str, text: str) -> None:
        """Double-click on a number, and type another."""
        self.double_click(path)
        self.frames(2)
        self.type(text)
        self.key(KEY.enter)

    def tip(self, path: str) -> list[str]:
        """The help that comes when the mouse rests on a widget."""
        self.hover(path)
        self.frames(40)
        hot = self.panel.rows.tips.shown
        return hot

    def open_all(self) -> None:
        """Open every section."""
        for name in [key for key in self.seen if key.startswith("section/")]:
            before = len(self.seen)
            self.click(name)
            if len(self.seen) < before:
                self.click(name)


@contextmanager
def staged(
    gl: GlContext, name: str = "uniform", height: int = 4000, changes: dict | None = None, **options
) -> Iterator[Stage]:
    """Put a scene's panel on a stage."""
    scene = load_scene(name, changes)
    stage = Stage(gl, Edits(Opened(scene, name)), height, **options)
    try:
        yield stage
    finally:
        stage.panel.close()
        imgui.backends.opengl3_shutdown()
        imgui.destroy_context()


def timed(stage: Stage, count: int = 100) -> tuple[float, float]:
    """Give the median milliseconds of putting a frame together, and of drawing it."""
    build, draw = [], []
    for _ in range(count):
        begun = time.perf_counter()
        stage.frames()
        between = time.perf_counter()
        stage.target.use()
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())
        stage.target.ctx.finish()
        build.append(between - begun)
        draw.append(time.perf_counter() - between)
    return 1e3 * float(np.median(build)), 1e3 * float(np.median(draw))


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
    without = {"light", "compare", "camera.projection"}  # the window has a lens
    haze = scene.atmosphere and scene.atmosphere.aerosol
    if haze and haze.model != "custom":
        without |= {f"atmosphere.aerosol.{key}" for key in FREE_AEROSOL}
    if scene.camera.focal_length_mm is None:
        without.add("camera.sensor_mm")
    if scene.camera.look is not None:
        without |= {"camera.azimuth_deg", "camera.altitude_deg"}
    if drops.around_m is not None:
        without.add("droplets.box_m")
    if not drops.extinction:
        without.add("droplets.extinction_efficiency")
    if getattr(drops.radius, "mixing", "local") == "local":  # as in a file, nothing is random
        without |= {"droplets.seed", "droplets.grid"}
    mie = scene.scattering.theory == "mie"
    without.add("scattering.orders" if mie else "scattering.size_spread")
    if drops.file is not None:
        without |= {"droplets.box_m", "droplets.around_m", "droplets.grid"}
        without |= {"droplets.radius", "droplets.density"}
    else:
        rain = drops.density is not None and drops.density.rain_rate_mm_h is not None
        other = "number_per_m3" if rain else "rain_rate_mm_h"
        without |= {"droplets.file", f"droplets.density.{other}"}
        if isinstance(drops.radius, GammaRadius):  # by one of two sets of parameters
            every = drops.radius.model_dump()
            without |= {f"droplets.radius.{key}" for key, value in every.items() if value is None}
    for number, light in enumerate(scene.light):
        without.add(f"light.{number}.beyond")  # spectra that have names are whole
        if light.type == "sun":  # by hand, and no Moon
            for key in (*TIME_AND_PLACE, *LIT):
                without.add(f"light.{number}.{key}")
    return [row for row in scene_rows(scene) if row.path not in without]


def value(stage: Stage, path: str) -> Any:
    """Give what the scene on a stage has at a key."""
    return value_at(stage.edits.scene, split_path(path))


def is_red(stage: Stage, path: str) -> bool:
    """Whether a widget's field is of the colour of what is refused."""
    left, top, right, bottom = (round(x) for x in stage.seen[path])
    image = stage.paint()[top + 2 : bottom - 2, left + 2 : right - 2].reshape(-1, 3)
    wanted = np.array([look.ERROR_FRAME.x, look.ERROR_FRAME.y, look.ERROR_FRAME.z]) * 255
    return bool((np.abs(image - wanted).max(axis=1) < 3).mean() > 0.3)
