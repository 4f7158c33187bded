"""The live window's loop: what is asked of the renderer, what comes back, and what is drawn."""

from __future__ import annotations

import math
import os
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import glfw
import numpy as np
from imgui_bundle import imgui, implot

from rtbow.arrays import Float32
from rtbow.colour import LUMINANCE_WEIGHTS
from rtbow.display import BLACK_FRAME_EV
from rtbow.errors import InputError, RtbowError
from rtbow.resources import resource_dir
from rtbow.scene import Camera, Scene
from rtbow.scene_file import load_scene, parse_set
from rtbow.scene_values import changed_scene, differences, scene_text
from rtbow.view import look, navigate
from rtbow.view.edits import Edits, Opened
from rtbow.view.hud import Hud
from rtbow.view.imgui_input import WindowInput
from rtbow.view.imgui_render import ImguiRenderer
from rtbow.view.pace import Order, Pace
from rtbow.view.panel import Panel, draw_help
from rtbow.view.picture import Picture, Rect
from rtbow.view.state import OVERLAYS, Notice, Severity, ViewState
from rtbow.view.watch import Watch, files_of
from rtbow.view.window import Window
from rtbow.view.worker import (
    DrawFrame,
    Failed,
    FrameDrawn,
    FrameSaved,
    Progressed,
    Reload,
    Reply,
    SaveFrame,
    SpectrumTaken,
    TakeSpectrum,
    Worker,
)

if TYPE_CHECKING:
    from rtbow.context import Backend
    from rtbow.renderer import Method

PANEL_WIDTH = 340.0
"""Of the panel, in screen coordinates at an ordinary display's density."""
_LINGER = 3
"""Pictures drawn after the last event: ImGui settles what it highlights in these."""
_PATIENCE_S = 0.1
"""Between looks at the renderer and at files while nothing happens."""
_BUSY_S = 0.004
"""The same while a frame is being drawn."""
_LEAST_GAP_S = 1.0 / 60.0
_BUSY_GAP_S = 1.0 / 20.0
"""Between two pictures of the window while the renderer works: on a CPU both share the cores."""
_NOTICE_S = 6.0
_FAST_FACTOR = 4.0
"""Speed with Shift."""
_FALSE_DECADES = 4.0
"""Range of the false colours below the brightest pixels."""
_FALSE_QUANTILE = 0.999
_COLOURS = 256
_MOVES = {
    glfw.KEY_W: (0.0, 1.0, 0.0), glfw.KEY_S: (0.0, -1.0, 0.0), glfw.KEY_A: (-1.0, 0.0, 0.0),
    glfw.KEY_D: (1.0, 0.0, 0.0), glfw.KEY_Q: (0.0, 0.0, -1.0), glfw.KEY_E: (0.0, 0.0, 1.0),
}  # fmt: skip
"""Keys that fly: towards the right, ahead and up."""


class Viewer:
    """One window on one scene.

    Args:
        opened: the scene.
        method: that draws.
        backend: how the renderer's process gets its GL context.
        exposure_ev: exposure value for ISO 100; None follows the frame.
        watch: whether changed scene files and shaders are taken over.

    Raises:
        UnavailableError: there is no display, or no OpenGL 3.3.
    """

    def __init__(
        self,
        opened: Opened,
        method: Method = "auto",
        backend: Backend = "auto",
        exposure_ev: float | None = None,
        *,
        watch: bool = False,
    ) -> None:
        self.edits = Edits(opened)
        self.state = ViewState(method=method, exposure_ev=exposure_ev)
        width, height = opened.scene.camera.size_px
        self.window = Window("rtbow", (width + int(PANEL_WIDTH), height))
        self._worker = Worker(backend)
        self._analyst: Worker | None = None
        self._backend = backend
        self._watching = watch
        self._imgui = imgui.create_context()
        self._plots = implot.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.config_error_recovery_enable_assert = False  # a broken frame must not end the window
        self.input = WindowInput(
            self.window.handle, on_drop=self._dropped, on_key=self._key, on_scroll=self._scrolled
        )
        look.apply()
        with self.window.gl.current():
            self._painter = ImguiRenderer(self.window.gl)
            self._picture = Picture(self.window.gl, _colour_map())
        self.panel = Panel(self)
        self.window.share_clipboard()
        self.hud = Hud()
        self._pace = Pace(1.0 / self.state.target_fps)
        self._watch = Watch()
        self._wanted: tuple[Scene, Method, tuple[int, int], int] | None = None
        self._orders: dict[int, tuple[Order, float]] = {}
        self._generation = 0
        self._flying_since: float | None = None
        self._zoomed_s = -math.inf
        self._painted_s = -math.inf
        self._linger, self._fresh = _LINGER, False
        self.frame_rgb: Float32 | None = None
        self.painted = 0
        self._follow_files()
        self._retitle()

    # --- the loop -----------------------------------------------------------------------------

    def run(self, frames: int | None = None, screenshot: Path | None = None) -> None:
        """Show the window until it is closed.

        Args:
            frames: pictures of the window after which it closes by itself.
            screenshot: where the last picture of the window is written, once the scene's own is
                in it at full resolution; .png.

        Raises:
            UnavailableError: the GL context is lost.
        """
        while not self.window.closing:
            self.step()
            if frames is not None and self.painted >= frames and self.settled:
                break
        if screenshot is not None:
            from rtbow.image import write_png

            write_png(screenshot, self.screenshot(), {"command": self.command()})

    def step(self) -> None:
        """Go through the loop once."""
        busy = bool(self._orders) or self._analyst_busy
        quick = busy or bool(self._linger) or bool(self._held_moves())
        patience = _BUSY_S if quick else _PATIENCE_S
        due = self._pace.due_in_s(time.perf_counter())
        self.window.wait(patience if due is None else min(patience, due))
        now = time.perf_counter()
        self._hear(now)
        if self._watching:
            self._look_at_files(now)
        self._fly(now)
        self._ask(now)
        if self.input.woken:
            self.input.woken, self._linger = False, _LINGER
        waiting = busy and now - self._painted_s > _PATIENCE_S  # for the progress bar
        gap = _BUSY_GAP_S if busy else _LEAST_GAP_S
        if self._fresh or ((self._linger or waiting) and now - self._painted_s >= gap):
            self._linger, self._fresh = max(self._linger - 1, 0), False
            self._paint(now)

    @property
    def settled(self) -> bool:
        """Whether the scene's own picture is on the screen at full resolution."""
        frame = self.state.frame
        return (
            frame is not None
            and not self._orders
            and not self._linger
            and frame.scene == self._live_scene(1.0)
        )

    def screenshot(self) -> np.ndarray:
        """Give the window as it is: 8 bit sRGB (h, w, 3), first row on top."""
        with self.window.gl.current():
            self._draw_all()
            return self.window.image()

    def close(self) -> None:
        """Close the window and end the processes; a second call does nothing."""
        for worker in (self._worker, self._analyst):
            if worker is not None:
                worker.close()
        if self.window.handle is not None:
            self.panel.close()
            implot.destroy_context(self._plots)
            imgui.destroy_context(self._imgui)
            self.window.destroy()

    def recover(self) -> Path | None:
        """Write the scene's unsaved changes beside it; give the file, None if there are none."""
        if not self.edits.unsaved:
            return None
        file = self.edits.opened.file
        name = file.stem if file is not None else (self.edits.opened.name or "default")
        folder = file.parent if file is not None else Path()
        path = folder / f"{name.replace('/', '-')}-recovered.toml"
        self.edits.save(path, replace=True)
        return path

    # --- asking and hearing -------------------------------------------------------------------

    def _live_scene(self, scale: float) -> Scene:
        """The scene at the size of its place in the window, or a part of it."""
        width, height = self.view_rect()[2:]
        size = max(round(scale * width), 1), max(round(scale * height), 1)
        return _resized(self.edits.scene, size)

    def _ask(self, now: float) -> None:
        if not self.window.visible or min(self.view_rect()[2:]) < 1:
            return
        self._pace.target_s = 1.0 / self.state.target_fps
        wanted = (
            self.edits.scene, self.state.method, self.view_rect()[2:], self._generation
        )  # fmt: skip
        if wanted != self._wanted:
            self._wanted = wanted
            self._pace.change(now)
        order = self._pace.next_order(now)
        if order is None:
            return
        number = self._worker.next_number()
        # One that was under way gives way to this one.
        self._orders = {number: (order, now)}
        self.state.waiting_since_s = now
        self._worker.send(DrawFrame(number, self._live_scene(order.scale), self.state.method))

    def _hear(self, now: float) -> None:
        replies = self._worker.replies()
        if self._analyst is not None:
            replies += self._analyst.replies()
        for reply in replies:
            self._linger = _LINGER
            self._take(reply, now)

    def _take(self, reply: Reply, now: float) -> None:
        state = self.state
        if isinstance(reply, FrameDrawn):
            order, sent = self._orders.pop(reply.number, (None, now))
            if order is not None:
                self._pace.drawn(order, now - sent)
                state.scale = order.scale
            self.frame_rgb = reply.rgb.copy()  # the memory is used again
            with self.window.gl.current():
                self._picture.take(self.frame_rgb)
            state.frame, state.frames_shown = reply, state.frames_shown + 1
            self._fresh = True
            state.stale, state.progress, state.waiting_since_s = "", None, None
        elif isinstance(reply, Progressed):
            state.progress = reply.share, reply.what
        elif isinstance(reply, FrameSaved):
            state.progress = None
            self.notify(f"saved {', '.join(map(os.path.relpath, reply.paths))}")
        elif isinstance(reply, SpectrumTaken):
            state.spectrum = reply.wavelength_nm, reply.radiance
            state.spectrum_number = reply.number
        elif isinstance(reply, Failed):
            state.progress = state.waiting_since_s = None
            order, _ = self._orders.pop(reply.number, (None, now))
            if order is not None:
                self._pace.dropped(order)
                state.stale = reply.message
            else:
                self.notify(reply.message, "error")

    @property
    def _analyst_busy(self) -> bool:
        return self._analyst is not None and self._analyst.busy

    def take_spectrum(self, scene: Scene, direction: tuple[float, float, float]) -> int:
        """Have the spectrum along a direction computed by the reference; give the request's number.

        What comes of it is the state's ``spectrum``.
        """
        if self._analyst is None:
            # Of its own, so that pictures go on meanwhile.
            self._analyst = Worker(self._backend)
        self.state.spectrum = None
        number = self._analyst.next_number()
        self._analyst.send(TakeSpectrum(number, scene, direction))
        return number

    # --- files --------------------------------------------------------------------------------

    def _follow_files(self) -> None:
        if not self._watching:
            return
        file = self.edits.opened.file
        self._watch.follow("scene", [file] if file is not None else [])
        self._watch.follow("data", files_of(self.edits.scene))
        self._watch.follow("shaders", sorted(resource_dir("shaders").iterdir()))

    def _look_at_files(self, now: float) -> None:
        changed = self._watch.changed(now)
        if not changed:
            return
        self._linger = _LINGER
        if "scene" in changed:
            self._open(self.edits.opened.name, self.edits.opened.overrides)
        if changed & {"shaders", "data"}:
            self._worker.send(Reload(self._worker.next_number()))
            self._generation += 1
        if "shaders" in changed:
            try:
                with self.window.gl.current():
                    picture = Picture(self.window.gl, _colour_map())
                    if self.frame_rgb is not None:
                        picture.take(self.frame_rgb)
                    self._picture = picture
            except RtbowError as error:
                self.state.stale = str(error)

    def _open(self, name: str | None, overrides: tuple[str, ...] = ()) -> None:
        try:
            scene = load_scene(name, dict(parse_set(text) for text in overrides))
        except InputError as error:
            self.state.stale = str(error)
            return
        if self.state.stale:
            self.state.stale = ""
        self.edits.open(Opened(scene, name, overrides))
        self._follow_files()
        self._retitle()

    def _dropped(self, paths: list[str]) -> None:
        scenes = [path for path in paths if path.lower().endswith(".toml")]
        if scenes:
            self.open_scene(scenes[0])
        else:
            self.notify(f"{paths[0]}: is not a scene; drop a .toml file", "error")

    # --- what the panel asks for (rtbow.view.state.Actions) -------------------------------------

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        """Replace values of the scene; give what is wrong with them, or nothing."""
        try:
            self.edits.change(changes, gesture)
        except InputError as error:
            return str(error)
        self._retitle()
        return ""

    def undo(self) -> None:
        """Take the last change back."""
        self.edits.undo()
        self._retitle()

    def redo(self) -> None:
        """Make the last undone change again."""
        self.edits.redo()
        self._retitle()

    def open_scene(self, name_or_path: str) -> None:
        """Open a built-in scene or a file; what is wrong with it stands over the last picture."""
        self._open(name_or_path)
        if not self.state.stale:
            recent = [name_or_path, *(n for n in self.state.recent if n != name_or_path)]
            self.state.recent = recent[:10]

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML, over a file that was not opened here only if it is to."""
        try:
            self.edits.save(Path(path), replace=replace)
        except RtbowError as error:
            self.notify(str(error), "error")
            return
        self._follow_files()
        self._retitle()
        self.notify(f"saved {path}")

    def save_frame(self, paths: tuple[str, ...]) -> None:
        """Render at the scene's own size and write .exr and .png."""
        scene = self.edits.scene.with_source(scene_text(self.edits.scene), "scene")
        options = [word for path in paths for word in ("-o", path)]
        command = self.command(*options)
        number = self._worker.next_number()
        whole = tuple(os.path.abspath(path) for path in paths)
        request = SaveFrame(
            number, scene, self.state.method, whole, self.state.exposure_ev, command
        )
        self._worker.send(request)
        self.notify(f"rendering {', '.join(paths)}")

    def command(self, *options: str) -> str:
        """Give the command line that makes the picture again."""
        own = [] if self.state.method == "auto" else ["--method", self.state.method]
        if self.state.exposure_ev is not None:
            own += ["--exposure", f"{self.state.exposure_ev:g}"]
        return self.edits.command("render", *own, *(options or ("-o", "bow.exr", "-o", "bow.png")))

    def copy_command(self) -> None:
        """Put the command line that makes the picture again on the clipboard."""
        self.window.copy(self.command())
        self.notify("the command is on the clipboard")

    def split(self, on: bool) -> None:
        """Split the picture between two settings, or join it."""
        self.state.side = "right" if on else "left"
        problem = self.change({"compare": {"split": 0.5, "right": {}} if on else None})
        if problem:
            self.notify(problem, "error")

    def notify(self, text: str, severity: Severity = "info") -> None:
        """Show a line for a while."""
        until = math.inf if severity == "error" else time.perf_counter() + _NOTICE_S
        self.state.notices.append(Notice(text, severity, until))
        self._linger = _LINGER

    def wake(self) -> None:
        """Have the window drawn again, though nothing has happened."""
        self._linger = _LINGER

    def _retitle(self) -> None:
        mark = "*" if self.edits.unsaved else ""
        self.window.retitle(f"{self.edits.opened.name or 'default'}{mark} – rtbow")
        self._linger = _LINGER

    # --- moving about -------------------------------------------------------------------------

    def _held_moves(self) -> list[int]:
        return [key for key in _MOVES if key in self.input.held]

    def _fly(self, now: float) -> None:
        keys = self._held_moves()
        if not keys:
            if self._flying_since is not None:
                self.edits.end_gesture()
            self._flying_since = None
            return
        before, self._flying_since = self._flying_since, now
        if before is None:
            return
        right, ahead, up = np.sum([_MOVES[key] for key in keys], axis=0)
        speed = navigate.cruise_m_s(self.edits.scene, self.hud.box_m(self.edits.scene))
        if self.input.held & {glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT}:
            speed *= _FAST_FACTOR
        camera = navigate.fly(
            self.edits.scene.camera, right, ahead, up, min(now - before, 0.1), speed
        )
        self._aim(camera, "fly")

    def _aim(self, camera: Camera, gesture: str) -> None:
        """Take over another camera, in both parts of a split picture."""
        scene = self.edits.scene
        if camera == scene.camera:
            return
        if scene.compare is None:
            self.edits.replace(scene.model_copy(update={"camera": camera}), gesture)
        else:
            moved = differences(scene, scene.model_copy(update={"camera": camera}))
            self.change(moved, gesture)
        self._linger = _LINGER

    def _scrolled(self, clicks: float) -> None:
        now = time.perf_counter()
        if now - self._zoomed_s > 0.5:
            self.edits.end_gesture()
        self._zoomed_s = now
        self._aim(navigate.zoom(self.edits.scene.camera, clicks), "zoom")

    def _mouse(self) -> None:
        """Look around by dragging over the picture, and what else its buttons do there."""
        io = imgui.get_io()
        rect = self.view_units()
        if io.want_capture_mouse or rect is None:
            return
        inside = rect[0] <= io.mouse_pos.x < rect[0] + rect[2] and (
            rect[1] <= io.mouse_pos.y < rect[1] + rect[3]
        )
        camera = self.edits.scene.camera
        if self.hud.drag_bar(self, rect, inside):
            return
        if imgui.is_mouse_double_clicked(0) and inside:
            self._aim(navigate.towards(camera, navigate.antisolar(self.edits.scene)), "centre")
            self.edits.end_gesture()
        elif imgui.is_mouse_dragging(0, 1.0):
            moved = io.mouse_delta
            if moved.x or moved.y:
                view = (round(rect[2]), round(rect[3]))
                self._aim(navigate.look(camera, moved.x, moved.y, view), "look")
        elif imgui.is_mouse_released(0):
            self.edits.end_gesture()
        if imgui.is_mouse_clicked(1) and inside:
            self.hud.mark(self, rect)

    def _key(self, key: int, down: bool, modifiers: int) -> None:
        if not down:
            return
        control = bool(modifiers & (glfw.MOD_CONTROL | glfw.MOD_SUPER))
        shift = bool(modifiers & glfw.MOD_SHIFT)
        if control:
            self._control_key(key, shift)
            return
        if key == glfw.KEY_ESCAPE:
            if not self.panel.forget_refused():
                self.window.close()
        elif key == glfw.KEY_F1:
            self.state.help_open = not self.state.help_open
        elif key == glfw.KEY_F11:
            self.window.toggle_full_screen()
        elif key == glfw.KEY_TAB:
            self.state.panel_open = not self.state.panel_open
        elif key == glfw.KEY_V:
            self.split(self.edits.scene.compare is None)
        for name, (letter, _) in OVERLAYS.items():
            if key == ord(letter):
                self.state.overlays ^= {name}

    def _control_key(self, key: int, shift: bool) -> None:
        if key == glfw.KEY_Z:
            (self.redo if shift else self.undo)()
        elif key == glfw.KEY_Y:
            self.redo()
        elif key == glfw.KEY_C:
            self.copy_command()
        elif key == glfw.KEY_S:
            file = self.edits.opened.file
            self.save_scene(str(file) if file is not None else self._free_name(".toml"))
        elif key == glfw.KEY_E:
            name = Path(self._free_name(".exr"))
            self.save_frame((str(name), str(name.with_suffix(".png"))))

    def _free_name(self, suffix: str) -> str:
        """Give a file's name in the current folder that is not taken."""
        stem = Path(self.edits.opened.name or "default").stem
        for number in range(1, 10_000):
            name = f"{stem}-{number:02d}{suffix}"
            if not Path(name).exists() and not Path(name).with_suffix(".png").exists():
                return name
        return f"{stem}{suffix}"

    # --- drawing ------------------------------------------------------------------------------

    def panel_units(self) -> float:
        """Width of the panel, in screen coordinates."""
        width = glfw.get_window_size(self.window.handle)[0]
        wanted = PANEL_WIDTH * self.window.content_scale
        return min(wanted, 0.6 * width) if self.state.panel_open else 0.0

    def view_rect(self) -> Rect:
        """Where the picture is in the framebuffer: as large as fits, with the scene's shape."""
        width, height = self.window.size_px
        free = max(width - math.ceil(self.panel_units() * self.window.pixels_per_unit), 0)
        own_width, own_height = self.edits.scene.camera.size_px
        share = min(free / own_width, height / own_height)
        across, down = int(share * own_width + 0.5), int(share * own_height + 0.5)
        return (free - across) // 2, (height - down) // 2, across, down

    def view_units(self) -> tuple[float, float, float, float] | None:
        """The same from the window's upper left corner, in screen coordinates; None if empty."""
        left, bottom, width, height = self.view_rect()
        per = 1.0 / self.window.pixels_per_unit
        if min(width, height) < 1:
            return None
        top = self.window.size_px[1] - bottom - height
        return left * per, top * per, width * per, height * per

    def _paint(self, now: float) -> None:
        self._painted_s = now
        self.state.notices = [n for n in self.state.notices if n.until_s > now]
        if not self.window.visible:
            return
        with self.window.gl.current():
            self.input.begin_frame()
            look.scale(self.window.content_scale)
            imgui.new_frame()
            try:
                self._mouse()
                self._compose()
            finally:
                imgui.render()
            self._draw_all()
            self.window.show()
        self.painted += 1

    def _compose(self) -> None:
        """Put together what stands over the picture and beside it."""
        rect = self.view_units()
        if rect is not None:
            self.hud.draw(self, rect)
        if self.state.help_open:
            draw_help(self.state)
        if not self.state.panel_open:
            return
        size = imgui.get_io().display_size
        width = self.panel_units()
        imgui.set_next_window_pos((size.x - width, 0.0))
        imgui.set_next_window_size((width, size.y))
        fixed = (
            imgui.WindowFlags_.no_move
            | imgui.WindowFlags_.no_resize
            | imgui.WindowFlags_.no_title_bar
            | imgui.WindowFlags_.no_background
        )
        imgui.begin("rtbow", None, fixed)
        self.panel.draw(self.edits, self.state)
        imgui.end()

    def _draw_all(self) -> None:
        screen = self.window.begin(look.BACKGROUND)
        frame = self.state.frame
        shown = BLACK_FRAME_EV if frame is None else frame.exposure_ev
        exposure = shown if self.state.exposure_ev is None else self.state.exposure_ev
        self._picture.draw(screen, self.view_rect(), exposure, self.false_range())
        with suppress(RuntimeError):  # before the first frame there is nothing to draw
            self._painter.render(imgui.get_draw_data(), screen)

    def false_range(self) -> tuple[float, float] | None:
        """Give log10 of the luminances at the ends of the false colours; None if they are off."""
        if "false" not in self.state.overlays or self.frame_rgb is None:
            return None
        luminance = self.frame_rgb[::3, ::3] @ LUMINANCE_WEIGHTS.astype(np.float32)
        lit = luminance[luminance > 0.0]
        if lit.size == 0:
            return (-_FALSE_DECADES, 0.0)
        top = math.log10(float(np.quantile(lit, _FALSE_QUANTILE)))
        return top - _FALSE_DECADES, top


def _resized(scene: Scene, size_px: tuple[int, int]) -> Scene:
    if scene.camera.size_px == size_px:
        return scene
    if scene.compare is not None:
        return changed_scene(scene, {"camera.size_px": list(size_px)})
    camera = scene.camera.model_copy(update={"size_px": size_px})
    return scene.model_copy(update={"camera": camera})


def _colour_map() -> Float32:
    """Give the false colours, dark to bright (n, 3), sRGB: viridis."""
    at = np.linspace(0.0, 1.0, _COLOURS)
    colours = [implot.sample_colormap(float(t), implot.Colormap_.viridis) for t in at]
    return np.array([(c.x, c.y, c.z) for c in colours], dtype=np.float32)
