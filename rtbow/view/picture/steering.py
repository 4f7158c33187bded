"""Steering the camera by hand: looking around, flying, zooming, clicks on the picture."""

from __future__ import annotations

import math
import time
from typing import Protocol

import numpy as np
from imgui_bundle import imgui

from rtbow.base.arrays import Array, floats
from rtbow.scene.model import Camera
from rtbow.scene.text.values import differences
from rtbow.view.picture import hud, navigate
from rtbow.view.picture.projection import View, whole_size
from rtbow.view.window.stage import Stage

_FAST_FACTOR = 4.0
"""Speed with Shift."""
_MOVES = {
    "W": (0.0, 1.0, 0.0), "S": (0.0, -1.0, 0.0), "A": (-1.0, 0.0, 0.0),
    "D": (1.0, 0.0, 0.0), "Q": (0.0, 0.0, -1.0), "E": (0.0, 0.0, 1.0),
}  # fmt: skip
"""Keys that fly: how far to the right, ahead and up."""
_LOOKING = "camera"
"""Gesture of looking around and flying, which may be done together."""
_LONGEST_STEP_S = 0.1
"""A flight that had to wait for longer does not jump."""
_ONE_ZOOM_S = 0.5
"""Clicks of the wheel within this time belong to one gesture."""


class Host(hud.Host, Protocol):
    """What is needed of the window."""

    stage: Stage
    hud: hud.Hud


class Steering:
    """Turns input into another camera.

    Args:
        host: the window.
    """

    def __init__(self, host: Host) -> None:
        self._host = host
        self._flying_since: float | None = None
        self._looking = False
        self._grabbed: Array | None = None
        self._zoomed_s = -math.inf

    @property
    def moving(self) -> bool:
        """Whether a key that flies is down."""
        return bool(self._held_moves())

    def _held_moves(self) -> list[str]:
        return [key for key in _MOVES if key in self._host.stage.input.held]

    def fly(self, now: float) -> None:
        """Fly on by the keys that are down; ``now`` in seconds of one clock."""
        keys = self._held_moves()
        if self._looking and not keys and not imgui.is_mouse_down(0):
            self._looking = False
            self._host.edits.end_gesture()
        before, self._flying_since = self._flying_since, now if keys else None
        if before is None or not keys:
            return
        right, ahead, up = np.sum([_MOVES[key] for key in keys], axis=0)
        scene = self._host.edits.scene
        speed = navigate.cruise_m_s(scene, self._host.hud.box_m(scene))
        if imgui.get_io().key_shift:
            speed *= _FAST_FACTOR
        seconds = min(now - before, _LONGEST_STEP_S)
        self.aim(navigate.fly(scene.camera, right, ahead, up, seconds, speed))

    def aim(self, camera: Camera, gesture: str = _LOOKING) -> None:
        """Set another camera, in both parts of a split picture."""
        edits = self._host.edits
        scene = edits.scene
        if camera == scene.camera:
            return
        self._looking = self._looking or gesture == _LOOKING
        moved = scene.with_camera(camera)
        if scene.compare is None:
            edits.replace(moved, gesture)
        else:
            self._host.change(differences(scene, moved), gesture)
        self._host.state.wake()

    def scroll(self, clicks: float) -> None:
        """Zoom by clicks of the wheel, about what is under the mouse."""
        now = time.perf_counter()
        if now - self._zoomed_s > _ONE_ZOOM_S and not self._looking:
            self._host.edits.end_gesture()
        self._zoomed_s = now
        camera, rect = self._host.edits.scene.camera, self._host.stage.view_units()
        view_px = at_px = None
        if rect is not None:
            x, y = self._host.stage.window.cursor
            view_px, at_px = whole_size(rect), (x - rect[0], y - rect[1])
        zoomed = navigate.zoom(camera, clicks, view_px, at_px)
        self.aim(zoomed, _LOOKING if self._looking else "zoom")

    def mouse(self) -> None:
        """Handle the mouse over the picture: drags, clicks and double-clicks.

        To be called within a frame of ImGui.
        """
        io = imgui.get_io()
        rect = self._host.stage.view_units()
        if not imgui.is_mouse_down(0):
            self._grabbed = None
        if io.want_capture_mouse or rect is None:
            return
        inside = rect[0] <= io.mouse_pos.x < rect[0] + rect[2] and (
            rect[1] <= io.mouse_pos.y < rect[1] + rect[3]
        )
        scene = self._host.edits.scene
        if self._host.hud.drag_bar(self._host, rect, inside):
            self._grabbed = None
            return
        view_px, at_px = whole_size(rect), (io.mouse_pos.x - rect[0], io.mouse_pos.y - rect[1])
        if imgui.is_mouse_double_clicked(0) and inside:
            self.aim(navigate.towards(scene.camera, navigate.antisolar(scene)), "centre")
            self._host.edits.end_gesture()
        elif imgui.is_mouse_clicked(0):
            self._grabbed = View(scene.camera, view_px).directions(floats(at_px))
        elif imgui.is_mouse_dragging(0, 1.0) and self._grabbed is not None and any(io.mouse_delta):
            self.aim(navigate.hold(scene.camera, self._grabbed, at_px, view_px))
        if imgui.is_mouse_clicked(1) and inside:
            self._host.hud.mark(self._host, rect)
