"""What the window shows and how, beside the scene itself."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from rtbow.base.arrays import Array
    from rtbow.render.renderer import MethodName
    from rtbow.view.document.messages import FrameDrawn

Side = Literal["left", "right"]
Severity = Literal["info", "error"]

OVERLAYS = {
    "circles": ("C", "Descartes circles: where geometric optics puts the bows"),
    "grid": ("G", "horizon, with a grid of azimuth and altitude"),
    "box": ("B", "edges of the volume of drops"),
    "false": ("L", "luminance in false colours, with its legend"),
}
"""Overlays by name: the key that turns each on and off, and what it is."""
_NOTICE_S = 6.0
_LINGER = 3
"""Pictures drawn after the last event, in which ImGui settles its highlights."""


@dataclass
class Notice:
    """A line shown to the user for a while; an error stays until it is closed."""

    text: str
    severity: Severity
    until_s: float


@dataclass
class ViewState:
    """How the window shows the scene.

    Attributes:
        method: by which the picture is drawn.
        exposure_ev: exposure value for ISO 100; None follows the frame.
        overlays: those that are on.
        side: which side of a split picture the panel changes.
        panel_open, help_open, readout_open: what is on the screen beside the picture.
        target_fps: frame rate that the render scale keeps while things move.
        frame: the last frame; None before the first.
        frames_shown: number of frames so far.
        waiting_since_s: since when a picture is being waited for; None if none is.
        progresses: share done and what is being done, by task.
        scale: ratio of the frame's width to the view's.
        problems: why the last good picture is still shown, by source.
        notices: lines shown to the user.
        replacing: existing files of a scene or a frame that the panel asks whether to replace;
            empty if there is no such question.
        spectrum: wavelengths (nm) and spectral radiance at the chosen pixel, once computed.
        spectrum_number: of the request that it answers.
        spectrum_problem: why there is none; empty unless it could not be computed.
        circle_orders: internal reflections of the bows whose Descartes circles are drawn.
        recent: scene files opened or saved last.
        linger: pictures of the window still to be drawn although nothing happens.
    """

    method: MethodName = "auto"
    exposure_ev: float | None = None
    overlays: set[str] = field(default_factory=set)
    side: Side = "left"
    panel_open: bool = True
    help_open: bool = False
    readout_open: bool = True
    target_fps: float = 30.0
    frame: FrameDrawn | None = None
    frames_shown: int = 0
    waiting_since_s: float | None = None
    progresses: dict[str, tuple[float, str]] = field(default_factory=dict)
    scale: float = 1.0
    problems: dict[str, str] = field(default_factory=dict)
    notices: list[Notice] = field(default_factory=list)
    replacing: tuple[str, ...] = ()
    spectrum: tuple[Array, Array] | None = None
    spectrum_number: int = 0
    spectrum_problem: str = ""
    circle_orders: tuple[int, ...] = (1, 2)
    recent: list[str] = field(default_factory=list)
    linger: int = _LINGER

    @property
    def progress(self) -> tuple[float, str] | None:
        """Share done and what is being done, the picture's first; None if nothing takes long."""
        return self.progresses.get("frame", next(iter(self.progresses.values()), None))

    @property
    def stale(self) -> str:
        """Why the picture is not the scene's; empty if it is."""
        return "\n".join(self.problems.values())

    def wake(self) -> None:
        """Have the window drawn again although nothing has happened."""
        self.linger = _LINGER

    def notify(self, text: str, severity: Severity = "info") -> None:
        """Show a line for a while."""
        until = math.inf if severity == "error" else time.perf_counter() + _NOTICE_S
        self.notices.append(Notice(text, severity, until))
        self.wake()

    def report(self, source: str, problem: str = "") -> None:
        """Show a problem of a file, a shader or the frame; an empty one ends it."""
        if problem == self.problems.get(source, ""):
            return
        self.problems.pop(source, None)
        if problem:
            self.problems[source] = problem
        self.wake()

    def show_progress(self, task: str, progress: tuple[float, str] | None) -> None:
        """Show how far a task is; None once it has ended."""
        self.progresses.pop(task, None)
        if progress is not None:
            self.progresses[task] = progress


class Actions(Protocol):
    """What the panel asks the window to do; none of these raises."""

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        """Replace values of the scene; give what is wrong with them, or an empty string."""

    def undo(self) -> None:
        """Take the last change back."""

    def redo(self) -> None:
        """Make the last undone change again."""

    def open_scene(self, name_or_path: str) -> None:
        """Open a built-in scene or a file."""

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML; ``replace`` allows it over a file that was not opened here."""

    def save_frame(self, paths: tuple[str, ...]) -> None:
        """Render at the scene's own size and write .exr and .png."""

    def copy_command(self) -> None:
        """Put the command line that makes the picture again on the clipboard."""

    def split(self, on: bool) -> None:
        """Split the picture between two settings, or join it."""
