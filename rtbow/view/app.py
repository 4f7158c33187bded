"""The live window's loop: what is asked of the renderer, what comes back, and what is drawn."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import glfw
import numpy as np
from imgui_bundle import imgui, implot

from rtbow.arrays import Array, Float32, floats
from rtbow.colour import LUMINANCE_WEIGHTS
from rtbow.display import BLACK_FRAME_EV
from rtbow.errors import InputError, RtbowError, UnavailableError
from rtbow.image import FRAME_SUFFIXES
from rtbow.resources import resource_dir
from rtbow.scene import Camera, Scene
from rtbow.scene_file import DEFAULT_SCENE, builtin_scenes, load_scene, parse_set
from rtbow.scene_values import changed_scene, differences, scene_files, scene_text, values_of
from rtbow.view import look, navigate
from rtbow.view.edits import Edits, Opened
from rtbow.view.hud import Hud
from rtbow.view.imgui_input import WindowInput
from rtbow.view.imgui_render import ImguiRenderer
from rtbow.view.messages import (
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
)
from rtbow.view.names import free_name
from rtbow.view.pace import Order, Pace
from rtbow.view.panel import Panel, draw_help
from rtbow.view.picture import Picture, Rect
from rtbow.view.projection import View
from rtbow.view.recovery import KEEP_AFTER_S, Recovered, Recovery
from rtbow.view.state import OVERLAYS, Notice, Severity, ViewState
from rtbow.view.watch import Watch
from rtbow.view.window import Window
from rtbow.view.worker import Worker

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
_CAMERA = "camera"
"""The gesture of looking around and flying, which go on together."""
_FAILURES = {"input": InputError, "machine": UnavailableError, "defect": RtbowError}
_FIRST_SPLIT: dict[str, object] = {"split": 0.5, "right": {}}


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
        self._recovery, self._recovered = Recovery(), False
        self._problems: dict[str, str] = {}
        self._progress: dict[str, tuple[float, str]] = {}
        self._failure: RtbowError | None = None
        self._saving: dict[int, tuple[str, ...]] = {}
        self._spectrum_asked = 0
        self._seen = self._kept = opened.scene
        self._changed_s: float | None = None
        self._split: dict[str, object] | None = None
        self._false: tuple[Float32 | None, tuple[float, float] | None] = (None, None)
        self._wanted: tuple[Scene, Method, tuple[int, int], int] | None = None
        self._orders: dict[int, tuple[Order, float]] = {}
        self._generation = 0
        self._flying_since: float | None = None
        self._aiming = self._closing_popups = False
        self._grabbed: Array | None = None
        self._zoomed_s = -math.inf
        self._painted_s = -math.inf
        self._linger, self._fresh = _LINGER, False
        self.frame_rgb: Float32 | None = None
        self.painted = 0
        self._follow_files(anew=True)
        self._retitle()

    # --- the loop -----------------------------------------------------------------------------

    def run(self, frames: int | None = None, screenshot: Path | None = None) -> None:
        """Show the window until it is closed.

        Args:
            frames: pictures of the window after which it closes by itself, once the scene's own
                is in it at full resolution.
            screenshot: where the last picture of the window is written; .png.

        Raises:
            UnavailableError: the GL context is lost, or no picture can be drawn on this machine.
            RtbowError: a script asked for pictures, and the scene's own cannot be drawn.
        """
        while not self.window.closing:
            if frames is not None and self.painted < frames:
                self.wake()
            self.step()
            if frames is not None:
                if self._failure is not None:
                    break
                if self.painted >= frames and self.settled:
                    break
        if self._failure is not None and (frames is not None or screenshot is not None):
            raise self._failure
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
        if self._aiming and not self._held_moves() and not imgui.is_mouse_down(0):
            self._aiming = False
            self.edits.end_gesture()
        self._look_at_scene(now)
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

    def close(self, say: Callable[[str], object] = lambda _: None) -> None:
        """Close the window, wait for what is being saved, and end the processes.

        A second call does nothing.

        Args:
            say: told what is waited for, and what came of it.

        Raises:
            RtbowError: what was being saved could not be.
        """
        if self.window.handle is not None:
            self.panel.close()
            implot.destroy_context(self._plots)
            imgui.destroy_context(self._imgui)
            self.window.destroy()
        if not self._recovered:
            self._recovery.discard()
        try:
            self._finish_saving(say)
        finally:
            for worker in (self._worker, self._analyst):
                if worker is not None:
                    worker.close()

    def _finish_saving(self, say: Callable[[str], object]) -> None:
        if self._analyst is None or not self._saving:
            return
        names = _names(chain.from_iterable(self._saving.values()))
        say(f"saving {names}; Ctrl-C gives it up")
        failure: RtbowError | None = None
        while self._saving:
            self._analyst.wait(_PATIENCE_S)
            for reply in self._analyst.replies():
                if isinstance(reply, FrameSaved):
                    say(f"saved {_names(self._saving.pop(reply.number, ()))}")
                elif isinstance(reply, Failed) and self._saving.pop(reply.number, ()):
                    failure = _FAILURES[reply.kind](reply.message)
        if failure is not None:
            raise failure

    def recover(self, *, cameras: bool = False) -> list[Recovered]:
        """Write the unsaved changes of all scenes that were opened, and tell where they are.

        A window that is closed without it leaves no files.

        Args:
            cameras: also those of the camera alone.
        """
        self._recovered = True
        if self.edits.unsaved:
            self._keep_unsaved()
        return self._recovery.finish(cameras=cameras)

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
        for reply in self._worker.replies():
            self._linger = _LINGER
            self._take(reply, now)
        if self._worker.revive():
            self._show_progress("frame", None)
        for reply in self._analyst.replies() if self._analyst is not None else ():
            self._linger = _LINGER
            self._take_other(reply)

    def _take(self, reply: Reply, now: float) -> None:
        """Take over what the renderer of pictures says."""
        state = self.state
        if isinstance(reply, FrameDrawn):
            order, sent = self._orders.pop(reply.number, (None, now))
            if order is not None:
                self._pace.drawn(order, now - sent)
                state.scale = order.scale
            self.frame_rgb = reply.rgb
            with self.window.gl.current():
                self._picture.take(self.frame_rgb)
            state.frame, state.frames_shown = reply, state.frames_shown + 1
            self._fresh = True
            state.waiting_since_s = self._failure = None
            self._show_progress("frame", None)
            self._tell("frame")
        elif isinstance(reply, Progressed):
            self._show_progress("frame", (reply.share, reply.what))
        elif isinstance(reply, Failed):
            order, _ = self._orders.pop(reply.number, (None, now))
            if order is not None:
                state.waiting_since_s = None
                self._show_progress("frame", None)
                self._pace.dropped(order)
                self._failure = _FAILURES[reply.kind](reply.message)
                if reply.kind == "machine" and state.frame is None:
                    raise self._failure
                self._tell("frame", reply.message)
            elif reply.number == 0:
                self.notify(reply.message, "error")
            # Else it was superseded, and nobody waits for it.

    def _take_other(self, reply: Reply) -> None:
        """Take over what the second process says, which saves frames and takes spectra."""
        state = self.state
        if isinstance(reply, Progressed):
            self._show_progress("other", (reply.share, reply.what))
            return
        self._show_progress("other", None)
        if isinstance(reply, FrameSaved):
            self._saving.pop(reply.number, None)
            self.notify(f"saved {_names(reply.paths)}")
        elif isinstance(reply, SpectrumTaken):
            state.spectrum = reply.wavelength_nm, reply.radiance
            state.spectrum_number = reply.number
        elif isinstance(reply, Failed):
            saving = self._saving.pop(reply.number, None)
            if saving is None and reply.number == self._spectrum_asked:
                state.spectrum_problem = reply.message
            elif saving is not None or reply.number == 0:
                self.notify(reply.message, "error")

    def _show_progress(self, of: str, progress: tuple[float, str] | None) -> None:
        """Show how far something is; None where it has ended. That of the picture comes first."""
        if progress is None:
            self._progress.pop(of, None)
        else:
            self._progress[of] = progress
        self.state.progress = self._progress.get("frame", self._progress.get("other"))

    def _tell(self, of: str, problem: str = "") -> None:
        """Show what is wrong with a file, a shader or the frame until the same goes well."""
        if problem:
            self._problems[of] = problem
        else:
            self._problems.pop(of, None)
        self.state.stale = "\n".join(self._problems.values())
        self._linger = _LINGER

    @property
    def _analyst_busy(self) -> bool:
        return self._analyst is not None and self._analyst.busy

    def _second(self) -> Worker:
        """Give the process for what must not keep pictures waiting."""
        if self._analyst is None:
            self._analyst = Worker(self._backend)
        return self._analyst

    def take_spectrum(self, scene: Scene, direction: tuple[float, float, float]) -> int:
        """Have the spectrum along a direction computed by the reference; give the request's number.

        What comes of it is the state's ``spectrum``, or its ``spectrum_problem``.
        """
        analyst = self._second()
        self.state.spectrum, self.state.spectrum_problem = None, ""
        number = self._spectrum_asked = analyst.next_number()
        analyst.send(TakeSpectrum(number, scene, direction))
        return number

    # --- the scene and its files --------------------------------------------------------------

    def _look_at_scene(self, now: float) -> None:
        """Take over that the scene is another: in the title, the files watched and those kept."""
        scene, before = self.edits.scene, self._seen
        if scene is not before:
            self._seen = scene
            self._tell("open")
            self._retitle()
            if any(
                getattr(scene, key) is not getattr(before, key)
                for key in ("droplets", "light", "compare")
            ):
                self._follow_files()
        if scene is self._kept:
            self._changed_s = None
        elif self._changed_s is None:
            self._changed_s = now
        elif now - self._changed_s >= KEEP_AFTER_S:
            self._keep_unsaved()

    def _keep_unsaved(self) -> None:
        self._kept, self._changed_s = self.edits.scene, None
        if self.edits.unsaved:
            self._recovery.keep(self.edits.opened, self.edits.scene)
        else:
            self._recovery.forget(self.edits.opened)

    def _follow_files(self, *, anew: bool = False) -> None:
        if not self._watching:
            return
        opened = self.edits.opened
        file = opened.file or builtin_scenes().get(opened.name or DEFAULT_SCENE)
        self._watch.follow("scene", [file] if file is not None else [], anew=anew)
        self._watch.follow("data", map(Path, scene_files(self.edits.scene)))
        self._watch.follow("shaders", sorted(resource_dir("shaders").iterdir()))

    def _look_at_files(self, now: float) -> None:
        changed = self._watch.changed(now)
        if not changed:
            return
        self._linger = _LINGER
        if "scene" in changed:
            self._open(self.edits.opened.name, self.edits.opened.overrides, of="file")
        if changed & {"shaders", "data"}:
            for worker in (self._worker, self._analyst):
                if worker is not None:
                    worker.send(Reload(worker.next_number()))
            self._generation += 1
        if "shaders" in changed:
            self._recompile()

    def _recompile(self) -> None:
        """Make the window's own programs anew; with a mistake in one the old ones stay."""
        try:
            with self.window.gl.current():
                picture = Picture(self.window.gl, _colour_map())
                if self.frame_rgb is not None:
                    picture.take(self.frame_rgb)
                self._painter.recompile()
        except RtbowError as error:
            self._tell("shader", str(error))
            return
        self._picture = picture
        self._tell("shader")

    def _open(self, name: str | None, overrides: tuple[str, ...] = (), *, of: str = "open") -> bool:
        """Open a scene; give whether that went well."""
        try:
            scene = load_scene(name, dict(parse_set(text) for text in overrides))
        except InputError as error:
            self._tell(of, str(error))
            return False
        self._tell("file")
        self._keep_unsaved()  # undo brings it back, but only while the window is open
        before = self.edits.opened, self.edits.scene
        self.edits.open(Opened(scene, name, overrides))
        if self.edits.scene is before[1]:  # its file has come to be the same
            self._recovery.forget(before[0])
        self._seen = self._kept = self.edits.scene
        self._split = None
        self._tell("open")
        self._follow_files(anew=of == "open")
        self._retitle()
        return True

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
        if self._open(name_or_path):
            recent = [name_or_path, *(n for n in self.state.recent if n != name_or_path)]
            self.state.recent = recent[:10]

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML, over a file that was not opened here only if it is to."""
        before = self.edits.opened
        try:
            self.edits.save(Path(path), replace=replace)
        except RtbowError as error:
            self.notify(str(error), "error")
            return
        self._recovery.forget(before)
        self._kept = self.edits.scene
        self._follow_files(anew=True)
        self._retitle()
        self.notify(f"saved {path}")

    def save_frame(self, paths: tuple[str, ...]) -> None:
        """Render at the scene's own size and write .exr and .png.

        Files that are being written are not written again meanwhile: others are named beside them.
        """
        taken = self._being_saved()
        if any(os.path.abspath(path) in taken for path in paths):
            first, suffixes = Path(paths[0]), [Path(path).suffix for path in paths]
            free = free_name(first.stem, suffixes, first.parent, taken)
            paths = tuple(str(first.with_name(free + suffix)) for suffix in suffixes)
        scene = self.edits.scene.with_source(scene_text(self.edits.scene), "scene")
        options = [word for path in paths for word in ("-o", path)]
        command = self.command(*options)
        # The first process goes on with pictures.
        analyst = self._second()
        number = analyst.next_number()
        whole = self._saving[number] = tuple(os.path.abspath(path) for path in paths)
        request = SaveFrame(
            number, scene, self.state.method, whole, self.state.exposure_ev, command
        )
        analyst.send(request)
        self.notify(f"rendering {', '.join(paths)}")

    def _being_saved(self) -> set[str]:
        return set(chain.from_iterable(self._saving.values()))

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
        """Split the picture between two settings, or join it; the last right side comes back."""
        self.state.side = "right" if on else "left"
        self._split = values_of(self.edits.scene).get("compare", self._split)
        wanted = (self._split or _FIRST_SPLIT) if on else None
        problem = self.change({"compare": wanted})
        if problem and on:  # what was on the right does not go with what the left is now
            problem = self.change({"compare": _FIRST_SPLIT})
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
        self._aim(camera, _CAMERA)

    def _aim(self, camera: Camera, gesture: str) -> None:
        """Take over another camera, in both parts of a split picture."""
        scene = self.edits.scene
        if camera == scene.camera:
            return
        self._aiming = self._aiming or gesture == _CAMERA
        if scene.compare is None:
            self.edits.replace(scene.model_copy(update={"camera": camera}), gesture)
        else:
            moved = differences(scene, scene.model_copy(update={"camera": camera}))
            self.change(moved, gesture)
        self._linger = _LINGER

    def _scrolled(self, clicks: float) -> None:
        now = time.perf_counter()
        if now - self._zoomed_s > 0.5 and not self._aiming:
            self.edits.end_gesture()
        self._zoomed_s = now
        camera, rect = self.edits.scene.camera, self.view_units()
        view_px = at_px = None
        if rect is not None:
            x, y = self.window.cursor
            view_px, at_px = _whole(rect), (x - rect[0], y - rect[1])
        zoomed = navigate.zoom(camera, clicks, view_px, at_px)
        self._aim(zoomed, _CAMERA if self._aiming else "zoom")

    def _mouse(self) -> None:
        """Look around by dragging over the picture, and what else its buttons do there."""
        io = imgui.get_io()
        rect = self.view_units()
        if not imgui.is_mouse_down(0):
            self._grabbed = None
        if io.want_capture_mouse or rect is None:
            return
        inside = rect[0] <= io.mouse_pos.x < rect[0] + rect[2] and (
            rect[1] <= io.mouse_pos.y < rect[1] + rect[3]
        )
        camera = self.edits.scene.camera
        if self.hud.drag_bar(self, rect, inside):
            self._grabbed = None
            return
        view_px, at_px = _whole(rect), (io.mouse_pos.x - rect[0], io.mouse_pos.y - rect[1])
        if imgui.is_mouse_double_clicked(0) and inside:
            self._aim(navigate.towards(camera, navigate.antisolar(self.edits.scene)), "centre")
            self.edits.end_gesture()
        elif imgui.is_mouse_clicked(0):
            self._grabbed = View(camera, view_px).directions(floats(at_px))
        elif imgui.is_mouse_dragging(0, 1.0) and self._grabbed is not None and any(io.mouse_delta):
            self._aim(navigate.hold(camera, self._grabbed, at_px, view_px), _CAMERA)
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
            if not self._step_back():
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

    def _step_back(self) -> bool:
        """Close what is open over the window, one after the other; give whether there was any."""
        every = imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level
        if imgui.is_popup_open("", every):
            self._closing_popups = True  # in the next picture: ImGui takes it inside of one
            return True
        if self.panel.forget_refused():
            return True
        if self.state.help_open:
            self.state.help_open = False
            return True
        return self.hud.unmark()

    def _control_key(self, key: int, shift: bool) -> None:
        if key == glfw.KEY_Z:
            (self.redo if shift else self.undo)()
        elif key == glfw.KEY_Y:
            self.redo()
        elif key == glfw.KEY_C:
            self.copy_command()
        elif key == glfw.KEY_S:
            file = self.edits.opened.file
            self.save_scene(str(file) if file is not None else f"{self._free_name('.toml')}.toml")
        elif key == glfw.KEY_E:
            name = self._free_name(*FRAME_SUFFIXES)
            self.save_frame(tuple(f"{name}{suffix}" for suffix in FRAME_SUFFIXES))

    def _free_name(self, *suffixes: str) -> str:
        """Give a name in the current folder, without its ending, that no file has."""
        stem = Path(self.edits.opened.name or DEFAULT_SCENE).stem
        return free_name(stem, suffixes, taken=self._being_saved())

    # --- drawing ------------------------------------------------------------------------------

    def panel_units(self) -> float:
        """Width of the panel, in screen coordinates."""
        width = self.window.size[0]
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
                if self._closing_popups:
                    self._closing_popups = False
                    imgui.internal.close_popups_except_modals()
                self._mouse()
                self._compose()
            finally:
                imgui.render()
            try:
                self._draw_all()
            except Exception:
                self.window.check()  # a lost context breaks whatever comes first
                raise
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
        if self._false[0] is not self.frame_rgb:
            self._false = self.frame_rgb, self._find_false_range(self.frame_rgb)
        return self._false[1]

    def _find_false_range(self, rgb: Float32) -> tuple[float, float]:
        luminance = rgb[::3, ::3] @ LUMINANCE_WEIGHTS.astype(np.float32)
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


def _whole(rect: tuple[float, float, float, float]) -> tuple[int, int]:
    """Give a rectangle's width and height in whole units."""
    return round(rect[2]), round(rect[3])


def _names(paths: Iterable[str]) -> str:
    """Give paths as they are seen from the current folder."""
    return ", ".join(os.path.relpath(path) for path in paths)


def _colour_map() -> Float32:
    """Give the false colours, dark to bright (n, 3), sRGB: viridis."""
    at = np.linspace(0.0, 1.0, _COLOURS)
    colours = [implot.sample_colormap(float(t), implot.Colormap_.viridis) for t in at]
    return np.array([(c.x, c.y, c.z) for c in colours], dtype=np.float32)
