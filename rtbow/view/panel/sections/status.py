"""The head of the panel: how the picture is drawn, how long it takes, and what is wrong."""

from __future__ import annotations

import time
from collections import deque

from imgui_bundle import imgui

from rtbow.view.document.state import ViewState
from rtbow.view.panel.layout import Rows
from rtbow.view.window import look
from rtbow.world.camera.resolve import view_of

_WINDOW_S = 1.0
"""Time over which frames are counted."""
_ERROR = (
    "At 99 of 100 pixels or more the colour differs from the exact picture's by {:.3g} at most, as"
    " CIEDE2000 counts differences: below 1 they are hardly seen. The error bound under Picture"
    " sets it."
)
_PATIENCE_S = 0.25
"""Time that a picture may take before the panel shows that it is being rendered."""


class Status:
    """Draws the head of the panel; remembers when frames came."""

    def __init__(self) -> None:
        self._frames: deque[tuple[float, int]] = deque()

    def draw(self, rows: Rows, state: ViewState) -> None:
        """Draw the head.

        Args:
            rows: of the frame.
            state: of the window.
        """
        self._numbers(rows, state)
        if not self._work(state):
            self._error(rows, state)
        frame = state.frame
        if frame is not None and state.method == "auto" and frame.unsuited:
            rows.wrapped(f"auto took {frame.method}: {frame.unsuited}", look.WARNING)
        for note in frame.notes if frame is not None else ():
            rows.wrapped(note, look.WARNING)
        if state.stale:
            rows.wrapped(f"The last good picture: {state.stale}", look.WARNING)
        for number, notice in enumerate(list(state.notices)):
            if notice.severity != "error":
                continue  # for a while over the picture, where it moves nothing
            if imgui.button(f"x##notice {number}", (rows.row_height, rows.row_height)):
                state.notices.remove(notice)
            rows.note(f"notice/{number}/close")
            imgui.same_line()
            rows.wrapped(notice.text, look.ERROR)

    def _numbers(self, rows: Rows, state: ViewState) -> None:
        frame = state.frame
        if frame is None:
            imgui.text_disabled("no picture yet")
            return
        imgui.push_style_color(imgui.Col_.text, look.ACCENT)
        imgui.text(frame.method)
        imgui.pop_style_color()
        imgui.same_line()
        parts = [f"{1e3 * frame.seconds:.3g} ms"]
        fps = self._fps(state)
        if fps is not None:
            parts.append(f"{fps:.0f} fps")
        parts.append(f"scale {100 * state.scale:.0f} %")
        imgui.text(" · ".join(parts))
        across, upright = view_of(frame.scene.camera).fields_deg
        imgui.text_disabled(rows.cut(f"view {across:.4g}° wide, {upright:.4g}° high"))

    def _error(self, rows: Rows, state: ViewState) -> None:
        """Draw the line of the error and the device."""
        if state.frame is None:
            imgui.text("")
            return
        if state.frame.behind:
            imgui.text_disabled(rows.cut(state.frame.behind))
            return
        error, holds = error_text(state)
        if error:
            imgui.push_style_color(imgui.Col_.text, look.TEXT if holds else look.DIM)
            imgui.text(error)
            imgui.pop_style_color()
            rows.note("status/error")
            rows.tips.explain(_ERROR.format(state.frame.scene.render.max_delta_e))
            imgui.same_line(0.0, 0.0)
        imgui.text_disabled(rows.cut(f"{' · ' if error else ''}{state.frame.renderer}"))

    def _fps(self, state: ViewState) -> float | None:
        """Frames in the last second; None while the picture stands still."""
        now = imgui.get_time()
        frames = self._frames
        frames.append((now, state.frames_shown))
        while len(frames) > 1 and now - frames[0][0] > _WINDOW_S:
            frames.popleft()
        begun, first = frames[0]
        moving = state.frames_shown - first >= 2
        return (state.frames_shown - first) / (now - begun) if moving and now > begun else None

    def _work(self, state: ViewState) -> bool:
        """Draw a progress bar if something takes long; give whether there is one."""
        size = (-1.0, imgui.get_text_line_height())
        if state.progress is not None:
            share, what = state.progress
            imgui.progress_bar(share, size, f"{what} {100 * share:.0f} %")
            return True
        if state.waiting_since_s is None:
            return False
        waited = time.perf_counter() - state.waiting_since_s
        if waited > _PATIENCE_S:
            imgui.progress_bar(-waited, size, f"rendering, {waited:.1f} s")
        return waited > _PATIENCE_S


def error_text(state: ViewState) -> tuple[str, bool]:
    """Give the frame's error bound as text, and whether the picture on the screen keeps it.

    A picture that was drawn smaller and enlarged differs by more.

    Returns:
        The text, empty where there is no bound to keep, and whether it holds as shown.
    """
    frame = state.frame
    if frame is None or frame.method != "fast":
        return "", True
    bound = f"ΔE 99 % ≤ {frame.scene.render.max_delta_e:.3g}"
    return (bound, True) if state.scale >= 1.0 else (f"{bound} at full size", False)
