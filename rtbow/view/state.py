"""What the window shows and how, beside the scene itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol

if TYPE_CHECKING:
    from rtbow.arrays import Array
    from rtbow.renderer import Method
    from rtbow.view.messages import FrameDrawn

Side = Literal["left", "right"]
Severity = Literal["info", "error"]

OVERLAYS = {
    "circles": ("C", "Descartes circles: where geometric optics puts the bows"),
    "grid": ("G", "horizon, with a grid of azimuth and altitude"),
    "box": ("B", "edges of the volume of drops"),
    "false": ("L", "luminance in false colours, with its legend"),
}
"""Overlays by name: the key that turns each on and off, and what it is."""


@dataclass
class Notice:
    """A line for the person, which goes after a while; an error stays until it is closed."""

    text: str
    severity: Severity
    until_s: float


@dataclass
class ViewState:
    """How the window shows the scene.

    Attributes:
        method: that draws.
        exposure_ev: exposure value for ISO 100; None follows the frame.
        overlays: those that are on.
        side: which side of a split picture the panel changes.
        panel_open, help_open, readout_open: what is on the screen beside the picture.
        target_fps: frame rate that the render scale keeps while things move.
        frame: the last frame; None before the first.
        frames_shown: how many there were.
        waiting_since_s: since when a picture is being waited for; None if none is.
        progress: share done and what is being done; None if nothing takes long.
        scale: of the frame's width to the view's.
        stale: why the last good picture is still shown; empty if it is the scene's.
        notices: lines for the person.
        spectrum: wavelengths (nm) and spectral radiance at the chosen pixel, once computed.
        spectrum_number: of the request that it answers.
        spectrum_problem: why there is none; empty unless it could not be computed.
        circle_orders: internal reflections of the bows whose Descartes circles are drawn.
        recent: scene files opened or saved last.
    """

    method: Method = "auto"
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
    progress: tuple[float, str] | None = None
    scale: float = 1.0
    stale: str = ""
    notices: list[Notice] = field(default_factory=list)
    spectrum: tuple[Array, Array] | None = None
    spectrum_number: int = 0
    spectrum_problem: str = ""
    circle_orders: tuple[int, ...] = (1, 2)
    recent: list[str] = field(default_factory=list)


class Actions(Protocol):
    """What the panel asks the window to do; none of these raises."""

    def change(self, changes: dict[str, object], gesture: object = None) -> str:
        """Replace values of the scene; give what is wrong with them, or nothing."""

    def undo(self) -> None:
        """Take the last change back."""

    def redo(self) -> None:
        """Make the last undone change again."""

    def open_scene(self, name_or_path: str) -> None:
        """Open a built-in scene or a file."""

    def save_scene(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML, over a file that was not opened here only if it is to."""

    def save_frame(self, paths: tuple[str, ...]) -> None:
        """Render at the scene's own size and write .exr and .png."""

    def copy_command(self) -> None:
        """Put the command line that makes the picture again on the clipboard."""

    def split(self, on: bool) -> None:
        """Split the picture between two settings, or join it."""
