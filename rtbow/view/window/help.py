"""The window that lists the keys."""

from __future__ import annotations

from imgui_bundle import imgui

from rtbow.view.document.state import OVERLAYS, ViewState
from rtbow.view.window import look

_KEYS = (
    ("drag", "look around"),
    ("W A S D Q E", "fly ahead, left, back, right, down, up; with Shift faster"),
    ("wheel", "zoom"),
    ("double-click", "centre the antisolar point"),
    ("right-click", "spectrum at a point"),
    ("Tab", "panel on and off"),
    ("V", "split the picture; drag the white bar to move it"),
    ("Ctrl+Z, Ctrl+Shift+Z", "undo, redo"),
    ("Ctrl+S", "save the scene"),
    ("Ctrl+E", "save a frame"),
    ("Ctrl+C", "copy the command"),
    ("drop a file", "open a scene (.toml)"),
    ("F1, F11", "these keys, full screen"),
    ("Esc", "close what is open, then quit"),
)


def draw_help(state: ViewState) -> None:
    """Draw the list of keys; its cross closes it.

    Args:
        state: of the window.
    """
    display = imgui.get_io().display_size
    middle = imgui.ImVec2(0.5 * display.x, 0.5 * display.y)
    imgui.set_next_window_pos(middle, imgui.Cond_.appearing, imgui.ImVec2(0.5, 0.5))
    flags = imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_collapse
    shown, is_open = imgui.begin("Keys", True, flags)
    state.help_open = bool(is_open)
    if shown and imgui.begin_table("keys", 2):
        for key, what in (*_KEYS, *OVERLAYS.values()):
            imgui.table_next_row()
            imgui.table_next_column()
            imgui.push_style_color(imgui.Col_.text, look.ACCENT)
            imgui.text(key)
            imgui.pop_style_color()
            imgui.table_next_column()
            imgui.text(what)
        imgui.end_table()
    imgui.end()
