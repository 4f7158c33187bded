"""Where the panel's rows stand: columns, labels, and what of it is in sight."""

from __future__ import annotations

from imgui_bundle import imgui

from rtbow.view.document.proposals import shortened
from rtbow.view.panel.drafts import Drafts
from rtbow.view.panel.rows import Row
from rtbow.view.panel.tips import Tips
from rtbow.view.window import look

Rect = tuple[float, float, float, float]
"""Left, top, right and bottom on the screen."""

_LABEL_SHARE = 0.42
"""Of a row's width, for its label."""


class Rows:
    """The rows of one frame, and how high they were in the last.

    Args:
        drafts: changes of values.
        tips: help.

    Attributes:
        drafts, tips: as given.
        seen: where each widget was drawn, by path; None unless somebody wants to know.
        left, right_edge, label_width, value_x, value_width, reset_x: columns of the panel, in
            the window's units.
        row_height, gap: of a line, and between two widgets on it.
    """

    def __init__(self, drafts: Drafts, tips: Tips) -> None:
        self.drafts, self.tips = drafts, tips
        self.seen: dict[str, Rect] | None = None
        self._heights: dict[str, float] = {}
        self._widths: dict[str, float] = {}
        self._font_px = 0.0
        self._row: tuple[Row, float, bool] | None = None

    def begin(self) -> None:
        """Begin a frame: take the measures of the window that is being drawn."""
        style = imgui.get_style()
        font_px = imgui.get_font_size()
        if font_px != self._font_px:
            self._font_px = font_px
            self._heights.clear()
            self._widths.clear()
        self.gap = style.item_inner_spacing.x
        self._spacing_y = style.item_spacing.y
        self.row_height = imgui.get_frame_height()
        self.left = imgui.get_cursor_pos_x()
        self.right_edge = self.left + imgui.get_content_region_avail().x
        self.label_width = _LABEL_SHARE * (self.right_edge - self.left)
        self.value_x = self.left + self.label_width + self.gap
        self.reset_x = self.right_edge - self.row_height
        self.value_width = self.reset_x - self.gap - self.value_x
        self._top = imgui.get_window_pos().y
        self._bottom = self._top + imgui.get_window_height()
        self._hovered, self._mouse_y = imgui.is_window_hovered(), imgui.get_io().mouse_pos.y
        self.drafts.begin()
        self.tips.begin()

    def end(self) -> None:
        """End a frame: help and menus come over it."""
        self.tips.end(self)

    def begin_row(self, row: Row, differs: bool) -> bool:
        """Begin a row; False if it is out of sight, and nothing needs to be drawn."""
        y = imgui.get_cursor_screen_pos().y
        height = self._heights.get(row.path)
        if (
            height is not None
            and not self._top - height < y < self._bottom
            and not self.drafts.busy(row.path)
        ):
            imgui.dummy((1.0, height))
            return False
        self._row = (row, y, differs)
        return True

    def end_row(self) -> None:
        """End a row: what was refused stands below it, and its help comes with the mouse."""
        assert self._row is not None
        row, y, differs = self._row
        for path, message in self.drafts.messages(row.path):
            self.wrapped(shortened(message, path), look.ERROR)
        bottom = imgui.get_cursor_screen_pos().y
        self._heights[row.path] = bottom - y - self._spacing_y
        if self._hovered and y <= self._mouse_y < bottom - self._spacing_y:
            self.tips.hover(row, differs)

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

    def reset_button(self, row: Row, *, first: bool = False) -> bool:
        """Draw the arrow that gives a value back, at the end of the line.

        Args:
            row: of the value.
            first: whether the arrow is drawn before the rest of its line.
        """
        if first:
            imgui.set_cursor_pos_x(self.reset_x)
        else:
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
        if first:
            imgui.same_line(self.left)
        return pressed

    def note(self, path: str) -> None:
        """Remember where the last item was drawn, if somebody wants to know."""
        if self.seen is not None:
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            self.seen[path] = (low.x, low.y, high.x, high.y)
