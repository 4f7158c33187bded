"""Saving frames, scenes and the command, in the panel."""

from __future__ import annotations

import os
from pathlib import Path

from imgui_bundle import imgui

from rtbow.frames.image import FRAME_SUFFIXES
from rtbow.view.document.edits import Edits
from rtbow.view.document.names import free_name
from rtbow.view.document.state import Actions, ViewState
from rtbow.view.panel import widgets
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, own_row
from rtbow.view.window import look

_FRAME = own_row(
    "keep.frame",
    "frame",
    "where the picture is written, without the ending: radiance as .exr, what the screen shows as "
    ".png; at the scene's own size (Ctrl+E)",
    option="-o FILE",
)
_SCENE = own_row("keep.scene", "scene", "where the scene is written, as .toml (Ctrl+S)")
_LOOK_S = 1.0
"""Time for which a free name is remembered."""


class Keep:
    """Fields and buttons that save frames and scenes.

    Args:
        actions: what the window does.
    """

    def __init__(self, actions: Actions) -> None:
        self._actions = actions
        self._typed: dict[str, str] = {}
        self._scene: str | None = None
        self._free: dict[tuple[str, ...], tuple[float, str]] = {}
        self._suffixes = dict.fromkeys(FRAME_SUFFIXES, True)

    def draw(self, rows: Rows, edits: Edits, state: ViewState) -> None:
        """Draw the fields and buttons."""
        if edits.opened.name != self._scene:
            self._scene = edits.opened.name
            self._typed.clear()
            state.replacing = ()
        stem = Path(self._scene or "default").stem
        file = edits.opened.file
        self._draw_frame(rows, state, stem)
        free = f"{self._free_name(stem, ('.toml',))}.toml"
        name = self._field(rows, state, _SCENE, str(file) if file else free)
        imgui.set_cursor_pos_x(rows.value_x)
        if imgui.button("Save scene", imgui.ImVec2(rows.value_width, 0.0)):
            path = name if name.lower().endswith(".toml") else f"{name}.toml"
            if edits.replaces(Path(path)):
                state.replacing = (path,)
            else:
                self._actions.save_scene(path)
        rows.note("keep/save scene")
        if imgui.button("Copy command", imgui.ImVec2(rows.right_edge - rows.left, 0.0)):
            self._actions.copy_command()
        rows.note("keep/copy command")
        imgui.set_item_tooltip("The command line that makes this picture again (Ctrl+C)")

    def _draw_frame(self, rows: Rows, state: ViewState, stem: str) -> None:
        name = self._field(rows, state, _FRAME, self._free_name(stem, FRAME_SUFFIXES))
        for suffix, on in self._suffixes.items():
            self._suffixes[suffix] = imgui.checkbox(f"{suffix}##keep", on)[1]
            rows.note(f"keep/{suffix}")
            imgui.same_line()
        imgui.set_cursor_pos_x(rows.value_x)
        chosen = tuple(suffix for suffix, on in self._suffixes.items() if on)
        imgui.begin_disabled(not chosen)
        if imgui.button("Save frame", imgui.ImVec2(rows.value_width, 0.0)):
            base = name[:-4] if name.lower().endswith(FRAME_SUFFIXES) else name
            paths = tuple(f"{base}{suffix}" for suffix in chosen)
            if any(map(os.path.lexists, paths)):
                state.replacing = paths
            else:
                self._actions.save_frame(paths)
                self._free.clear()  # its name is taken now
        imgui.end_disabled()
        rows.note("keep/save frame")

    def draw_question(self, rows: Rows, edits: Edits, state: ViewState) -> None:
        """Ask whether to replace existing files, if that is the question."""
        paths = state.replacing
        if not paths:
            return
        scene = paths[0].lower().endswith(".toml")
        there = ", ".join(path for path in paths if os.path.lexists(path))
        question = edits.question(Path(paths[0])) if scene else f"{there}: already there"
        rows.wrapped(f"{question}.", look.WARNING)
        width = (rows.right_edge - rows.left - rows.gap) / 2
        for name in ("Replace it", "Leave it"):
            if imgui.button(name, imgui.ImVec2(width, 0.0)):
                state.replacing = ()
                if name == "Replace it" and scene:
                    self._actions.save_scene(paths[0], replace=True)
                elif name == "Replace it":
                    self._actions.save_frame(paths)
            rows.note(f"keep/{name.lower()}")
            imgui.same_line(0.0, rows.gap)
        imgui.new_line()

    def _field(self, rows: Rows, state: ViewState, row: Row, default: str) -> str:
        """Draw a field for a name; give the name."""

        def take(value: object, gesture: object) -> str:
            self._typed[row.path] = str(value).strip()
            state.replacing = ()
            return ""

        name = self._typed.get(row.path, default)
        if rows.begin_row(row, False):
            rows.label(row.label)
            widgets.text(rows, row.path, name, rows.value_width, take)
            rows.end_row()
        return name

    def _free_name(self, stem: str, suffixes: tuple[str, ...]) -> str:
        """Give a name in the current folder that no file has, without an ending."""
        now = imgui.get_time()
        looked_s, name = self._free.get((stem, *suffixes), (-_LOOK_S, ""))
        if now - looked_s >= _LOOK_S:
            name = free_name(stem, suffixes)
            self._free[(stem, *suffixes)] = now, name
        return name
