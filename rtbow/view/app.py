"""The live window's loop: what is asked of the renderer, what comes back, and what is drawn."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import rtbow.view.window  # noqa: F401  first: it chooses the GLFW library

# isort: split
from rtbow.base.arrays import Float32
from rtbow.base.errors import InputError, RtbowError
from rtbow.frames.image import FRAME_SUFFIXES
from rtbow.scene.model import Scene
from rtbow.scene.text.file import DEFAULT_SCENE
from rtbow.scene.text.values import changed_scene, values_of
from rtbow.view.document.autosave import Unsaved
from rtbow.view.document.edits import Edits, Opened
from rtbow.view.document.files import SceneFiles
from rtbow.view.document.messages import (
    DrawFrame,
    Failed,
    FrameDrawn,
    Progressed,
    Reload,
    Reply,
    SkyWaits,
    failure_of,
)
from rtbow.view.document.names import free_name
from rtbow.view.document.state import OVERLAYS, ViewState
from rtbow.view.panel.whole import Panel
from rtbow.view.picture.hud import Hud
from rtbow.view.picture.steering import Steering
from rtbow.view.window.help import draw_help
from rtbow.view.window.stage import Stage
from rtbow.view.worker.handle import Worker
from rtbow.view.worker.pace import Order, Pace
from rtbow.view.worker.side import SideJobs

if TYPE_CHECKING:
    from rtbow.gl.context import Backend
    from rtbow.render.renderer import MethodName

_PATIENCE_S = 0.1
"""Longest wait in one pass of the loop while nothing happens."""
_BUSY_S = 0.004
"""Longest wait while a frame is being drawn."""
_LEAST_STEP_S = 0.002
"""Shortest pass of the loop: a mouse may report a thousand times a second."""
_HEADROOM = 0.9
"""Pictures aim at this share of the time between two at the target rate."""
_LEAST_GAP_S = 1.0 / 60.0
_BUSY_GAP_S = 1.0 / 20.0
"""Shortest time between two pictures of the window while the renderer works: on a CPU both share
the cores."""
_FRAME, _SKY = "frame", "sky"
"""Names of the progress and problems of the picture, and of its sky."""
_FIRST_SPLIT: dict[str, object] = {"split": 0.5, "right": {}}


class Viewer:
    """One window on one scene.

    Args:
        opened: the scene.
        method: by which the picture is drawn.
        backend: how the renderer's process gets its GL context.
        exposure_ev: exposure value for ISO 100; None follows the frame.
        watch: whether scene files and shaders are read again when they change.

    Raises:
        UnavailableError: there is no display, or no OpenGL 3.3.
    """

    def __init__(
        self,
        opened: Opened,
        method: MethodName = "auto",
        backend: Backend = "auto",
        exposure_ev: float | None = None,
        *,
        watch: bool = False,
    ) -> None:
        self.edits = Edits(opened)
        self.state = ViewState(method=method, exposure_ev=exposure_ev)
        self.hud = Hud()
        self._shortcuts = self._make_shortcuts()
        self.steering = Steering(self)
        self.stage = Stage(self.edits, self.state, self._dropped, self._key, self.steering.scroll)
        self.files = SceneFiles(self.edits, self.state, watching=watch)
        self.jobs = SideJobs(self.state, backend)
        self.panel = Panel(self)
        self.worker = Worker(backend)
        self._pace = Pace(_HEADROOM / self.state.target_fps)
        self._failure: RtbowError | None = None
        self._split: tuple[int, object] = (0, None)
        self._wanted: tuple[Scene, MethodName, tuple[int, int], int] | None = None
        self._orders: dict[int, tuple[Order, float]] = {}
        self._generation = 0
        self._titled: tuple[Opened, Scene] | None = None
        self._stepped_s = self._painted_s = -math.inf
        self._fresh = False
        self.painted = 0

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
        while not self.stage.window.closing:
            if frames is not None and self.painted < frames:
                self.state.wake()
            self.step()
            if frames is not None:
                if self._failure is not None:
                    break
                if self.painted >= frames and self.settled:
                    break
        if self._failure is not None and (frames is not None or screenshot is not None):
            raise self._failure
        if screenshot is not None:
            from rtbow.frames.image import write_png

            write_png(screenshot, self.stage.image(), {"command": self.command()})

    def step(self) -> None:
        """Run one pass of the loop."""
        state = self.state
        busy = bool(self._orders) or self.jobs.busy
        quick = busy or bool(state.linger) or self.steering.moving
        patience = _BUSY_S if quick else _PATIENCE_S
        time.sleep(max(self._stepped_s + _LEAST_STEP_S - time.perf_counter(), 0.0))
        self._stepped_s = time.perf_counter()
        due = self._pace.due_in_s(self._stepped_s)
        self.stage.window.wait(patience if due is None else min(patience, due))
        now = time.perf_counter()
        self._hear(now)
        self._look_at_files(now)
        self.steering.fly(now)
        self.files.look_at_scene(now)
        self._retitle()
        self._ask(now)
        if self.stage.input.woken:
            self.stage.input.woken = False
            state.wake()
        waiting = busy and now - self._painted_s > _PATIENCE_S  # for the progress bar
        gap = _BUSY_GAP_S if busy else _LEAST_GAP_S
        if self._fresh or ((state.linger or waiting) and now - self._painted_s >= gap):
            state.linger, self._fresh = max(state.linger - 1, 0), False
            self._paint(now)

    @property
    def settled(self) -> bool:
        """Whether the scene's own picture is on the screen at full resolution."""
        frame = self.state.frame
        return (
            frame is not None
            and not self._orders
            and not self.state.linger
            and not frame.behind
            and frame.scene == self._live_scene(1.0)
        )

    @property
    def frame_rgb(self) -> Float32 | None:
        """The picture, cd/m², float32 (h, w, 3); None before the first."""
        return self.stage.frame_rgb

    def false_range(self) -> tuple[float, float] | None:
        """Give log10 of the luminances at the ends of the false colours; None if they are off."""
        return self.stage.false_range()

    def close(self, say: Callable[[str], object] = lambda _: None) -> None:
        """Close the window, wait for what is being saved, and end the processes.

        A second call does nothing.

        Args:
            say: shows the user a line: what is being waited for, and how that ended.

        Raises:
            RtbowError: what was being saved could not be.
        """
        if self.stage.window.handle is not None:
            self.panel.close()
            self.stage.close()
        self.files.close()
        try:
            self.jobs.finish(say)
        finally:
            self.worker.close()
            self.jobs.close()

    def recover(self, *, cameras: bool = False) -> list[Unsaved]:
        """Write the unsaved changes of all scenes that were opened, and give their files.

        A window that is closed without this call leaves no files.

        Args:
            cameras: whether scenes are written in which only the camera was moved.
        """
        return self.files.recover(cameras=cameras)

    def _paint(self, now: float) -> None:
        self._painted_s = now
        self.state.notices = [n for n in self.state.notices if n.until_s > now]
        if not self.stage.window.visible:
            return
        self.stage.paint(self._compose, lambda: self.panel.draw(self.edits, self.state))
        self.painted += 1

    def _compose(self) -> None:
        """Compose what stands over the picture."""
        self.steering.mouse()
        rect = self.stage.view_units()
        if rect is not None:
            self.hud.draw(self, rect)
        if self.state.help_open:
            draw_help(self.state)

    def _retitle(self) -> None:
        now = self.edits.opened, self.edits.scene
        if self._titled is not None and all(a is b for a, b in zip(now, self._titled, strict=True)):
            return
        self._titled = now
        mark = "*" if self.edits.unsaved else ""
        self.stage.window.retitle(f"{self.edits.opened.name or DEFAULT_SCENE}{mark} – rtbow")
        self.state.wake()

    # --- asking and hearing -------------------------------------------------------------------

    def _live_scene(self, scale: float) -> Scene:
        """The scene at the size of its place in the window, or a part of it."""
        width, height = self.stage.view_rect()[2:]
        size = max(round(scale * width), 1), max(round(scale * height), 1)
        scene = _resized(self.edits.scene, size)
        return scene if self.state.method == "reference" else _with_means(scene)

    def _ask(self, now: float) -> None:
        size = self.stage.view_rect()[2:]
        if not self.stage.window.visible or min(size) < 1:
            return
        self._pace.target_s = _HEADROOM / self.state.target_fps
        wanted = self.edits.scene, self.state.method, size, self._generation
        if wanted != self._wanted:
            self._wanted = wanted
            self._pace.change(now)
        order = self._pace.next_order(now)
        if order is None:
            return
        number = self.worker.next_number()
        # The frame under way, if any, gives way to this one.
        self._orders = {number: (order, now)}
        self.state.waiting_since_s = now
        self.worker.send(DrawFrame(number, self._live_scene(order.scale), self.state.method))

    def _hear(self, now: float) -> None:
        for reply in self.worker.replies():
            self.state.wake()
            self._take(reply, now)
        if self.worker.revive():
            self.state.show_progress(_FRAME, None)
        self.jobs.hear()

    def _take(self, reply: Reply, now: float) -> None:
        """Handle a reply of the process that draws the picture."""
        state = self.state
        if isinstance(reply, FrameDrawn):
            order, sent = self._orders.pop(reply.number, (None, now))
            if order is not None:
                self._pace.drawn(order, now - sent)
                state.scale = order.scale
            self.stage.take(reply.rgb)
            state.frame, state.frames_shown = reply, state.frames_shown + 1
            self._fresh = True
            state.waiting_since_s = self._failure = None
            state.show_progress(_FRAME, None)
            state.report(_FRAME)
        elif isinstance(reply, Progressed):
            state.show_progress(_FRAME, (reply.share, reply.what))
        elif isinstance(reply, SkyWaits):
            share = reply.share
            state.show_progress(_SKY, None if share is None else (share, reply.what))
            self._generation += reply.there
        elif isinstance(reply, Failed):
            order, _ = self._orders.pop(reply.number, (None, now))
            if order is not None:
                state.waiting_since_s = None
                state.show_progress(_FRAME, None)
                self._pace.dropped(order)
                self._failure = failure_of(reply)
                if reply.kind == "machine" and state.frame is None:
                    raise self._failure
                state.report(_FRAME, reply.message)
            elif reply.number == 0:
                state.notify(reply.message, "error")
            # Otherwise a newer frame has superseded it.

    def _look_at_files(self, now: float) -> None:
        changed = self.files.look_at_files(now)
        if changed & {"shaders", "data"}:
            self.worker.send(Reload(self.worker.next_number()))
            self.jobs.reload()
            self._generation += 1
        if "shaders" in changed:
            try:
                self.stage.recompile()
                self.state.report("shader")
            except RtbowError as error:
                self.state.report("shader", str(error))
        if changed:
            self.state.wake()

    # --- what the panel (document.state.Actions) and the picture (picture.hud.Host) ask for ------

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        """Replace values of the scene; give what is wrong with them, or an empty string."""
        try:
            self.edits.change(changes, gesture)
        except InputError as error:
            return str(error)
        self.state.wake()
        return ""

    def undo(self) -> None:
        """Take the last change back."""
        self.edits.undo()
        self.state.wake()

    def redo(self) -> None:
        """Make the last undone change again."""
        self.edits.redo()
        self.state.wake()

    def open_scene(self, name_or_path: str) -> None:
        """Open a built-in scene or a file; a mistake in it is shown over the last picture."""
        self.files.open(name_or_path)

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML; ``replace`` allows it over a file that was not opened here."""
        self.files.save(path, replace=replace)

    def save_frame(self, paths: tuple[str, ...]) -> None:
        """Render at the scene's own size and write .exr and .png."""

        def command(names: tuple[str, ...]) -> str:
            return self.command(*(word for name in names for word in ("-o", name)))

        self.jobs.save_frame(self.edits.scene, paths, command)

    def take_spectrum(self, scene: Scene, direction: tuple[float, float, float]) -> int:
        """Have the spectrum along a direction computed; give the request's number."""
        return self.jobs.take_spectrum(scene, direction)

    def command(self, *options: str) -> str:
        """Give the command line that makes the picture again."""
        own = [] if self.state.method == "auto" else ["--method", self.state.method]
        if self.state.exposure_ev is not None:
            own += ["--exposure", repr(self.state.exposure_ev)]
        if not options:
            name = self._free_name(*FRAME_SUFFIXES)
            options = tuple(word for end in FRAME_SUFFIXES for word in ("-o", f"{name}{end}"))
        return self.edits.command("render", *own, *options)

    def copy_command(self) -> None:
        """Put the command line that makes the picture again on the clipboard."""
        self.stage.window.copy(self.command())
        self.state.notify("the command is on the clipboard")

    def split(self, on: bool) -> None:
        """Split the picture between two settings, or join it; the last right side comes back."""
        self.state.side = "right" if on else "left"
        count, last = self._split
        before = last if count == self.files.count else None  # another scene's does not apply
        kept = values_of(self.edits.scene).get("compare", before)
        self._split = self.files.count, kept
        problem = self.change({"compare": (kept or _FIRST_SPLIT) if on else None})
        if problem and on:  # the last right side no longer goes with the left
            problem = self.change({"compare": _FIRST_SPLIT})
        if problem:
            self.state.notify(problem, "error")

    # --- keys and drops -----------------------------------------------------------------------

    def _dropped(self, paths: list[str]) -> None:
        scenes = [path for path in paths if path.lower().endswith(".toml")]
        if scenes:
            self.open_scene(scenes[0])
        else:
            self.state.notify(f"{paths[0]}: not a scene; drop a .toml file", "error")

    def _key(self, name: str) -> None:
        action = self._shortcuts.get(name) or self._shortcuts.get(name.replace("Shift+", ""))
        if action is not None:
            action()

    def _make_shortcuts(self) -> dict[str, Callable[[], object]]:
        state = self.state
        return {
            "Esc": self._step_back,
            "Tab": lambda: setattr(state, "panel_open", not state.panel_open),
            "F1": lambda: setattr(state, "help_open", not state.help_open),
            "F11": lambda: self.stage.window.toggle_full_screen(),
            "V": lambda: self.split(self.edits.scene.compare is None),
            "Ctrl+Z": self.undo,
            "Ctrl+Shift+Z": self.redo,
            "Ctrl+Y": self.redo,
            "Ctrl+C": self.copy_command,
            "Ctrl+S": self._save_scene,
            "Ctrl+E": self._save_frame,
            **{key: partial(self._toggle, name) for name, (key, _) in OVERLAYS.items()},
        }

    def _toggle(self, overlay: str) -> None:
        self.state.overlays ^= {overlay}

    def _step_back(self) -> None:
        """Close what is open over the window, one after the other; then the window itself."""
        if self.stage.close_popups() or self.panel.forget_refused():
            return
        if self.state.help_open:
            self.state.help_open = False
        elif not self.hud.unmark():
            self.stage.window.close()

    def _save_scene(self) -> None:
        file = self.edits.opened.file
        self.save_scene(str(file) if file is not None else f"{self._free_name('.toml')}.toml")

    def _save_frame(self) -> None:
        name = self._free_name(*FRAME_SUFFIXES)
        self.save_frame(tuple(f"{name}{suffix}" for suffix in FRAME_SUFFIXES))

    def _free_name(self, *suffixes: str) -> str:
        """Give a name in the current folder, without its ending, that no file has."""
        stem = Path(self.edits.opened.name or DEFAULT_SCENE).stem
        return free_name(stem, suffixes, taken=self.jobs.saving)


def _with_means(scene: Scene) -> Scene:
    """Take pixels as areas where all drops are alike, unless the scene says how it takes them.

    At pixels' centres small frames of fine fringes show false rings. Drops of many sizes blur their
    fringes themselves, and their tables of means take long.
    """
    radius = scene.droplets.radius
    alike = scene.droplets.file is None and radius is not None and radius.distribution == "constant"
    if "pixel" in scene.camera.model_fields_set or not alike:
        return scene
    if scene.compare is not None:
        return changed_scene(scene, {"camera.pixel": "area"})
    camera = scene.camera.model_copy(update={"pixel": "area"})
    return scene.model_copy(update={"camera": camera})


def _resized(scene: Scene, size_px: tuple[int, int]) -> Scene:
    if scene.camera.size_px == size_px:
        return scene
    if scene.compare is not None:
        return changed_scene(scene, {"camera.size_px": list(size_px)})
    camera = scene.camera.model_copy(update={"size_px": size_px})
    return scene.model_copy(update={"camera": camera})
