"""What the panel's widgets share: columns, gestures, texts being typed, refusals and help."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from imgui_bundle import imgui

from rtbow.view.document.proposals import shortened
from rtbow.view.panel.rows import Row, rounded, shown_unit
from rtbow.view.window import look

Set = Callable[[object, object], str]
"""Takes a new value and its gesture, and gives what is wrong with it, or nothing."""
Rect = tuple[float, float, float, float]
"""Left, top, right and bottom on the screen."""

_LABEL_SHARE = 0.42
"""Of a row's width, for its label."""
_TIP_DELAY_S = 0.4
_TIP_WIDTH = 22.0
_CLICK = 0
_MENU = "what to do with a value"


class Values(Protocol):
    """What a widget's context menu asks about the scene."""

    right: bool

    def undo(self) -> None:
        """Take the last change back."""

    def set_text(self, key: str) -> str:
        """Give the command line's option for a value."""


@dataclass
class Draft:
    """A text that is being typed, or was refused.

    Attributes:
        text: as typed.
        value: in whose place.
        message: what is wrong with it; empty if that is not known yet.
        focus: whether it asks for the keyboard.
        active: whether it has had it.
    """

    text: str
    value: object
    message: str = ""
    focus: bool = True
    active: bool = False


@dataclass
class _Gesture:
    """A drag: its path, its identity, the value before, and whether it changed anything."""

    path: str
    value: object
    name: tuple[str, int]
    changed: bool = False


@dataclass
class Refusal:
    """What the scene refused that was not typed; of a drag until its end."""

    message: str
    dragged: bool


@dataclass
class Ui:
    """One frame's places and what lasts from frame to frame.

    Args:
        values: where the widgets' values come from.
        on_reset: gives a row's value back.

    Attributes:
        drafts: texts being typed or refused, by path.
        refusals: other refused values, by path.
        seen: where each widget was drawn, by path; None unless somebody wants to know.
        tip_shown: lines of the help that is on the screen.
        right_edge, label_width, value_x, value_width, row_height: of the panel, from its left edge.
    """

    values: Values
    on_reset: Callable[[Row], None] = lambda row: None
    drafts: dict[str, Draft] = field(default_factory=dict)
    refusals: dict[str, Refusal] = field(default_factory=dict)
    seen: dict[str, Rect] | None = None
    tip_shown: list[str] = field(default_factory=list)
    left: float = 0.0
    right_edge: float = 0.0
    label_width: float = 0.0
    value_x: float = 0.0
    value_width: float = 0.0
    row_height: float = 0.0
    gap: float = 0.0
    _gesture: _Gesture | None = None
    _gestures: int = 0
    _heights: dict[str, float] = field(default_factory=dict)
    _widths: dict[str, float] = field(default_factory=dict)
    _font_px: float = 0.0
    _hot: tuple[Row, bool] | None = None
    _hot_since: tuple[str, float] = ("", 0.0)
    _menu: tuple[Row, bool] | None = None
    _row: tuple[Row, float, bool] | None = None

    # --- a frame ------------------------------------------------------------------------------

    @property
    def _kept(self) -> tuple[Mapping[str, Draft | Refusal], ...]:
        return self.drafts, self.refusals

    def begin(self) -> None:
        """Take the measures of the window that is being drawn, and of the mouse."""
        io = imgui.get_io()
        style = imgui.get_style()
        font_px = imgui.get_font_size()
        if font_px != self._font_px:
            self._font_px = font_px
            self._heights.clear()
            self._widths.clear()
        self.gap = style.item_inner_spacing.x
        self.row_height = imgui.get_frame_height()
        self.left = imgui.get_cursor_pos_x()
        self.right_edge = self.left + imgui.get_content_region_avail().x
        width = self.right_edge - self.left
        self.label_width = _LABEL_SHARE * width
        self.value_x = self.left + self.label_width + self.gap
        self.reset_x = self.right_edge - self.row_height
        self.value_width = self.reset_x - self.gap - self.value_x
        top = imgui.get_window_pos().y
        self._clip = (top, top + imgui.get_window_height())
        self.spacing_y = style.item_spacing.y
        self._mouse = (io.mouse_pos.x, io.mouse_pos.y)
        self._still = not (io.mouse_delta.x or io.mouse_delta.y)
        self._idle = not imgui.is_any_item_active()
        if imgui.get_mouse_clicked_count(_CLICK) == 1:
            self._gesture = None  # a second click may still have to take back what it did
        self.hovered = imgui.is_window_hovered()
        clicked = self.hovered and imgui.is_mouse_clicked(_CLICK)
        self._types = clicked and (imgui.is_mouse_double_clicked(_CLICK) or io.key_ctrl)
        self._right_clicked = self.hovered and imgui.is_mouse_clicked(1)
        self._time = imgui.get_time()
        self._hot = None
        if not imgui.is_mouse_down(_CLICK):
            self.refusals = {k: r for k, r in self.refusals.items() if not r.dragged}
        if self._idle and imgui.is_key_pressed(imgui.Key.escape, repeat=False):
            self.forget()

    def forget_refused(self) -> bool:
        """Drop all that was refused; give whether there was anything."""
        wrong = any(item.message for kept in self._kept for item in kept.values())
        if wrong:
            self.forget()
        return wrong

    def forget(self, path: str = "") -> None:
        """Drop what was refused, of one value and what is inside it or of all."""
        if not path:
            self.drafts.clear()
            self.refusals.clear()
        inside = f"{path}."
        self.drafts = {k: d for k, d in self.drafts.items() if not f"{k}.".startswith(inside)}
        self.refusals = {k: r for k, r in self.refusals.items() if not f"{k}.".startswith(inside)}

    def end(self) -> None:
        """Show the help of the row under the mouse, and the menu of the one that was clicked."""
        self.tip_shown = []
        if self._hot is not None:
            row, differs = self._hot
            if self._right_clicked and row.option is None:
                self._menu = self._hot
                imgui.open_popup(_MENU)
            if row.path != self._hot_since[0] or not self._still:
                self._hot_since = (row.path, self._time)
            if self._idle and self._time - self._hot_since[1] >= _TIP_DELAY_S:
                self._tip(row, differs)
        else:
            self._hot_since = ("", 0.0)
        if self._menu is not None and imgui.begin_popup(_MENU):
            self._show_menu(*self._menu)
            imgui.end_popup()

    # --- a row --------------------------------------------------------------------------------

    def begin_row(self, row: Row, differs: bool) -> bool:
        """Begin a row; False if it is out of sight, and nothing needs to be drawn."""
        y = imgui.get_cursor_screen_pos().y
        height = self._heights.get(row.path)
        if height is not None and not self._clip[0] - height < y < self._clip[1]:
            busy = self._gesture is not None and self._gesture.path.startswith(row.path)
            if not busy and not self.drafts:
                imgui.dummy((1.0, height))
                return False
        self._row = (row, y, differs)
        return True

    def end_row(self) -> None:
        """End a row: what was refused stands below it, and its help comes with the mouse."""
        assert self._row is not None
        row, y, differs = self._row
        if self.drafts or self.refusals:
            self._show_messages(row)
        bottom = imgui.get_cursor_screen_pos().y
        self._heights[row.path] = bottom - y - self.spacing_y
        if self.hovered and y <= self._mouse[1] < bottom - self.spacing_y:
            self._hot = (row, differs)

    def _show_messages(self, row: Row) -> None:
        inside = f"{row.path}."
        for kept in self._kept:
            for path, item in kept.items():
                if item.message and (path == row.path or path.startswith(inside)):
                    self.wrapped(shortened(item.message, path), look.ERROR)

    def label(self, text: str) -> None:
        """Write a row's label, and go to where its value stands: beside it, or below if long."""
        width = self._widths.get(text)
        if width is None:
            width = self._widths[text] = imgui.calc_text_size(text).x
        imgui.align_text_to_frame_padding()
        imgui.text(text)
        if width <= self.label_width:
            imgui.same_line(self.value_x)
        else:
            imgui.set_cursor_pos_x(self.value_x)

    def fitting(self, text: str, shorter: str) -> str:
        """Give a text if it has room beside a box in the column of values, else a shorter one."""
        room = self.value_width - self.row_height - self.gap
        return text if text and imgui.calc_text_size(text).x <= room else shorter

    def cut(self, text: str, *, start: bool = False) -> str:
        """Cut a text's end, or its start, so that it fits into what is left of the line."""
        room = self.right_edge - imgui.get_cursor_pos_x()
        width = imgui.calc_text_size(text).x
        if width <= room:
            return text
        count = int(len(text) * room / width) - 2
        return f"…{text[-count:]}" if start else f"{text[:count].rstrip()}…"

    def wrapped(self, text: str, colour: imgui.ImVec4) -> None:
        """Write a text over as many lines as it needs."""
        imgui.push_style_color(imgui.Col_.text, colour)
        imgui.push_text_wrap_pos(self.right_edge)
        imgui.text(text)
        imgui.pop_text_wrap_pos()
        imgui.pop_style_color()

    def reset_button(self, row: Row) -> bool:
        """Draw the arrow that gives a value back, at the end of the line."""
        imgui.same_line(self.reset_x)
        size = self.row_height
        corner = imgui.get_cursor_screen_pos()
        pressed = imgui.invisible_button(f"##reset {row.path}", (size, size))
        self.note(f"{row.path}/reset")
        colour = look.ACCENT if imgui.is_item_hovered() else look.DIM
        code = imgui.get_color_u32(colour)
        x, y, radius = corner.x + 0.5 * size, corner.y + 0.52 * size, 0.24 * size
        lines = imgui.get_window_draw_list()
        lines.path_arc_to((x, y), radius, -2.6, 2.0, 12)
        lines.path_stroke(code, 0.09 * size)
        tip_x, tip_y, wing = x - 0.86 * radius, y - 0.55 * radius, 0.17 * size
        lines.add_triangle_filled(
            (tip_x - 0.9 * wing, tip_y + 0.7 * wing),
            (tip_x - 0.5 * wing, tip_y - 1.2 * wing),
            (tip_x + 1.1 * wing, tip_y + 0.4 * wing),
            code,
        )
        return pressed

    def note(self, path: str) -> None:
        """Remember where the last item was drawn, if somebody wants to know."""
        if self.seen is not None:
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            self.seen[path] = (low.x, low.y, high.x, high.y)

    # --- changes ------------------------------------------------------------------------------

    def drag(self, path: str, before: object, value: float, set_value: Set) -> None:
        """Hand over what a slider has come to; one that is refused is tried in fewer digits."""
        gesture = self._gesture
        if gesture is None or gesture.path != path:
            self._gestures += 1
            gesture = self._gesture = _Gesture(path, before, (path, self._gestures))
        if value == before:
            return
        message = set_value(value, gesture.name)
        for digits in (2, 1):
            if not message or isinstance(value, int):
                break
            simpler = rounded(value, digits)
            if simpler == before or not set_value(simpler, gesture.name):
                message = ""
        gesture.changed = gesture.changed or not message
        if message:
            self.refusals[path] = Refusal(message, dragged=True)
        else:
            self.refusals.pop(path, None)

    def choose(self, path: str, value: object, set_value: Set) -> None:
        """Hand over what was clicked."""
        self.told(path, set_value(value, None))

    def told(self, path: str, message: str) -> None:
        """Take what is wrong with a value that was clicked, or nothing."""
        if message:
            self.refusals[path] = Refusal(message, dragged=False)
        else:
            self.refusals.pop(path, None)

    def scene_changed(self) -> None:
        """Drop what was refused by a scene that is another now."""
        self.refusals = {k: r for k, r in self.refusals.items() if r.dragged}

    def starts_typing(self, width: float) -> bool:
        """Whether the widget that comes next, of a width, was clicked in order to type."""
        if not self._types:
            return False
        corner = imgui.get_cursor_screen_pos()
        x, y = self._mouse
        across = corner.x <= x < corner.x + width
        return across and corner.y <= y < corner.y + self.row_height

    def moved_from(self, path: str, value: object) -> object:
        """Give the value before the first of two clicks, which moved a slider; else the value."""
        gesture = self._gesture
        if gesture is None or gesture.path != path or not gesture.changed:
            return value
        gesture.changed = False
        return gesture.value

    def type(self, path: str, value: object, text: str) -> None:
        """Begin a text in place of a value."""
        self.refusals.pop(path, None)
        self.drafts[path] = Draft(text, value)

    def draft(self, path: str, value: object) -> Draft | None:
        """Give a value's text; one in whose place another value has come is dropped."""
        draft = self.drafts.get(path)
        if draft is None:
            return None
        ended = draft.active and not draft.message and not draft.focus
        if draft.value != value or (ended and self._idle):
            del self.drafts[path]
            return None
        return draft

    def type_in(
        self,
        path: str,
        draft: Draft,
        width: float,
        read: Callable[[str], object],
        set_value: Set,
        *,
        hint: str = "",
        flags: int = 0,
    ) -> None:
        """Draw a text that is being typed; hand it over once it is done.

        Args:
            path: of the value.
            draft: the text.
            width: of the field.
            read: makes the value of the text.
            set_value: takes the value.
            hint: what an empty field shows.
            flags: of ImGui's text fields.
        """
        if draft.focus:
            imgui.set_keyboard_focus_here()
            draft.focus = False
        wrong = bool(draft.message)
        if wrong:
            imgui.push_style_color(imgui.Col_.frame_bg, look.ERROR_FRAME)
        imgui.set_next_item_width(width)
        flags |= imgui.InputTextFlags_.auto_select_all
        _, text = imgui.input_text_with_hint(f"##text {path}", hint, draft.text, flags)
        self.note(path)
        if wrong:
            imgui.pop_style_color()
        draft.text = text
        draft.active = draft.active or imgui.is_item_active()
        if not imgui.is_item_deactivated():
            return
        if imgui.is_key_pressed(imgui.Key.escape, repeat=False) or not text.strip():
            self.drafts.pop(path, None)
            return
        value = read(text)
        message = "" if value == draft.value else set_value(value, None)
        if message:
            draft.message = message
            draft.focus = any(
                imgui.is_key_pressed(key, repeat=False)
                for key in (imgui.Key.enter, imgui.Key.keypad_enter)
            )
        else:
            self.drafts.pop(path, None)

    # --- help ---------------------------------------------------------------------------------

    def _tip(self, row: Row, differs: bool) -> None:
        help_lines = self.help_of(row, differs)
        self.tip_shown = [text for text, _ in help_lines]
        if not help_lines:
            return
        imgui.begin_tooltip()
        imgui.push_text_wrap_pos(_TIP_WIDTH * self._font_px)
        for text, colour in help_lines:
            imgui.push_style_color(imgui.Col_.text, colour)
            imgui.text(text)
            imgui.pop_style_color()
        imgui.pop_text_wrap_pos()
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
        if row.kind in ("number", "vector", "corners") and row.slide is not None:
            allowed.append("double-click to type")
        if allowed:
            lines.append((", ".join(allowed), look.DIM))
        if row.option is not None:
            lines.extend([(row.option, look.DIM)] if row.option else [])
        else:
            lines.append((self.values.set_text(row.path), look.DIM))
        if differs:
            lines.append((f"The arrow gives back {self._before(row)}", look.DIM))
        return lines

    def _before(self, row: Row) -> str:
        of_left = self.values.right and row.option is None
        return "the left side's value" if of_left else "the value that was opened"

    def _show_menu(self, row: Row, differs: bool) -> None:
        if imgui.menu_item(f"Reset to {self._before(row)}", "", False, differs)[0]:
            self.on_reset(row)
        self.note("menu/reset")
        text = self.values.set_text(row.path)
        if imgui.menu_item(f"Copy {self.cut(text)}", "", False)[0]:
            imgui.set_clipboard_text(text)
        self.note("menu/copy")
        if row.kind in ("number", "vector", "corners"):
            imgui.text_disabled("double-click or Ctrl+click to type")


def value_text(text: str, unit: str) -> str:
    """Give what a slider shows of a value, as a format that holds no directives."""
    return (text + shown_unit(unit)).replace("%", "%%")
