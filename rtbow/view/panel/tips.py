"""Help of the row under the mouse, and the menu of the one that was right-clicked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from imgui_bundle import imgui

from rtbow.view.panel.rows import Row
from rtbow.view.window import look

_DELAY_S = 0.4
_WIDTH = 22.0
"""In letters' heights."""
_MENU = "what to do with a value"
_TYPED = ("number", "vector", "corners")
"""Kinds of value that are typed after a double-click."""


def _write(lines: Sequence[tuple[str, imgui.ImVec4]]) -> None:
    """Write lines of help, each in its colour and over as many lines as it needs."""
    imgui.push_text_wrap_pos(_WIDTH * imgui.get_font_size())
    for text, colour in lines:
        imgui.push_style_color(imgui.Col_.text, colour)
        imgui.text(text)
        imgui.pop_style_color()
    imgui.pop_text_wrap_pos()


class Values(Protocol):
    """What help and menu ask about the scene."""

    right: bool

    def set_text(self, key: str) -> str:
        """Give the command line's option for a value."""


class Lines(Protocol):
    """What the menu asks of the panel's rows."""

    def note(self, path: str) -> None:
        """Remember where the last item was drawn."""

    def cut(self, text: str) -> str:
        """Cut a text's end so that it fits into what is left of the line."""


class Tips:
    """Remembers over which row the mouse rests, and since when.

    Args:
        values: where the rows' values come from.

    Attributes:
        on_reset: gives a row's value back.
        shown: lines of the help on the screen.
    """

    def __init__(self, values: Values) -> None:
        self._values = values
        self.on_reset: Callable[[Row], None] = lambda row: None
        self.shown: list[str] = []
        self._hot: tuple[Row, bool] | None = None
        self._hot_since: tuple[str, float] = ("", 0.0)
        self._menu: tuple[Row, bool] | None = None

    def begin(self) -> None:
        """Begin a frame: no row is under the mouse yet."""
        self._hot = None
        self._idle = not imgui.is_any_item_active()
        self._right_clicked = imgui.is_window_hovered() and imgui.is_mouse_clicked(1)

    def hover(self, row: Row, differs: bool) -> None:
        """Take the row that is under the mouse, and whether its value can be given back."""
        self._hot = row, differs

    def end(self, lines: Lines) -> None:
        """Show the help of the row under the mouse, and the menu of the one that was clicked."""
        self.shown = []
        if self._hot is not None:
            row, differs = self._hot
            if self._right_clicked and row.option is None:
                self._menu = self._hot
                imgui.open_popup(_MENU)
            now, moved = imgui.get_time(), imgui.get_io().mouse_delta
            if row.path != self._hot_since[0] or moved.x or moved.y:
                self._hot_since = (row.path, now)
            if self._idle and now - self._hot_since[1] >= _DELAY_S:
                self._show(row, differs)
        else:
            self._hot_since = ("", 0.0)
        if self._menu is not None and imgui.begin_popup(_MENU):
            self._show_menu(lines, *self._menu)
            imgui.end_popup()

    def _show(self, row: Row, differs: bool) -> None:
        help_lines = self.help_of(row, differs)
        self.shown = [text for text, _ in help_lines]
        if help_lines:
            imgui.begin_tooltip()
            _write(help_lines)
            imgui.end_tooltip()

    def explain(self, text: str) -> None:
        """Show a text while the mouse rests on the last item, which is no row."""
        if imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip):
            imgui.begin_tooltip()
            _write([(text, look.TEXT)])
            imgui.end_tooltip()

    def help_of(self, row: Row, differs: bool) -> list[tuple[str, imgui.ImVec4]]:
        """Give the lines of a row's help, with their colours."""
        lines: list[tuple[str, imgui.ImVec4]] = []
        if row.description:
            lines.append((row.description[0].upper() + row.description[1:], look.TEXT))
        if row.effect:
            lines.append((row.effect, look.ACCENT))
        allowed = [row.range] if row.range else []
        if row.unit:
            allowed.append(f"in {row.unit}")
        if row.kind in _TYPED and row.slide is not None:
            allowed.append("double-click to type")
        if allowed:
            lines.append((", ".join(allowed), look.DIM))
        option = self._values.set_text(row.path) if row.option is None else row.option
        if option:
            lines.append((option, look.DIM))
        if differs:
            lines.append((f"The arrow gives back {self._before(row)}", look.DIM))
        return lines

    def _before(self, row: Row) -> str:
        of_left = self._values.right and row.option is None
        return "the left side's value" if of_left else "the value that was opened"

    def _show_menu(self, lines: Lines, row: Row, differs: bool) -> None:
        if imgui.menu_item(f"Reset to {self._before(row)}", "", False, differs)[0]:
            self.on_reset(row)
        lines.note("menu/reset")
        text = self._values.set_text(row.path)
        if imgui.menu_item(f"Copy {lines.cut(text)}", "", False)[0]:
            imgui.set_clipboard_text(text)
        lines.note("menu/copy")
        if row.kind in _TYPED:
            imgui.text_disabled("double-click or Ctrl+click to type")
