"""One widget for each kind of value that a scene may hold."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path

from imgui_bundle import imgui

from rtbow.scene.lights import E490, EQUAL_ENERGY, spectrum_file
from rtbow.scene.text.overrides import plain
from rtbow.scene.text.schema import toml_text
from rtbow.view.panel.drafts import Set
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, Slide, shown_number, shown_unit
from rtbow.view.window import look

_TURN = 0.005
"""Share by which a pixel of dragging changes a number that has no range."""
_HANDLE_SHARE = 0.18
"""Height of a slider's handle, of its field's."""
_RAISED = 0.05
"""By how much a number stands above the middle of its field, of the field's height."""
_GRAB_MARGIN = 2.0
"""Pixels that ImGui leaves between a slider's handle and the ends of its field, at any density."""
_NO_COLOUR = imgui.ImVec4(0.0, 0.0, 0.0, 0.0)


def read_number(text: str) -> object:
    """Read a typed number; other text stays text, which the scene refuses."""
    text = text.strip().replace("−", "-")
    try:
        return int(text)
    except ValueError:
        pass
    try:
        return float(text)
    except ValueError:
        return text


def read_toml(text: str) -> object:
    """Read a typed TOML value; other text stays text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def number(
    rows: Rows,
    path: str,
    value: float,
    width: float,
    set_value: Set,
    slide: Slide | None,
    *,
    show: Callable[[float], str] = shown_number,
    unit: str = "",
    lead: str = "",
    write: Callable[[float], str] = repr,
    read: Callable[[str], object] = read_number,
    put_back: Callable[[float], None] | None = None,
) -> None:
    """Draw a slider; after a double-click or Ctrl+click the number is typed instead.

    Args:
        rows: of the frame.
        path: of the number.
        value: as it is.
        width: of the slider.
        set_value: takes another.
        slide: what the slider runs over; None for a number without ends, which is dragged.
        show: writes it on the slider.
        unit: behind it.
        lead: a word before it.
        write: writes it as it is typed.
        read: reads what was typed.
        put_back: restores the value from before a click; by default the scene's last change is
            undone.
    """
    draft = rows.drafts.text(path, value)
    if draft is None and rows.drafts.starts_typing(width):
        before = rows.drafts.value_before(path, value)
        assert isinstance(before, int | float)
        if before != value and put_back is None:
            rows.drafts.undo()
        elif before != value and put_back is not None:
            put_back(before)
        draft = rows.drafts.type(path, before, write(before))
    if draft is not None:
        rows.drafts.draw(path, draft, width, read, set_value)
        rows.note(path)
        return
    wrong = path in rows.drafts.refusals
    if wrong:
        imgui.push_style_color(imgui.Col_.frame_bg, look.ERROR_FRAME)
        imgui.push_style_color(imgui.Col_.frame_bg_active, look.ERROR_FRAME)
    imgui.set_next_item_width(width)
    new = _turned(path, value) if slide is None else _slid(path, value, slide)
    rows.note(path)
    _write_on_field(lead, show(value) + shown_unit(unit))
    if wrong:
        imgui.pop_style_color(2)
    if new != value:
        rows.drafts.drag(path, value, new, set_value)


def _turned(path: str, value: float) -> float:
    """Draw a field for a number without ends; give the number that it was dragged to."""
    flags = imgui.SliderFlags_.no_input
    changed, moved = imgui.drag_float(f"##{path}", 0.0, 1.0, 0.0, 0.0, " ", flags)
    return float(f"{value + moved * max(abs(value), 1.0) * _TURN:.4g}") if changed else value


def _slid(path: str, value: float, slide: Slide) -> float:
    """Draw a slider, with a handle of its own; give the number that it was dragged to."""
    for colour in (imgui.Col_.slider_grab, imgui.Col_.slider_grab_active):
        imgui.push_style_color(colour, _NO_COLOUR)
    share, flags = slide.share(value), imgui.SliderFlags_.no_input
    changed, share = imgui.slider_float(f"##{path}", share, 0.0, 1.0, " ", flags)
    imgui.pop_style_color(2)
    _draw_handle(share)
    return slide.value(share) if changed else value


def _draw_handle(share: float) -> None:
    """Draw the last slider's handle along the field's lower edge, below its number.

    So it covers no number, however narrow the field, and the number stands still.
    """
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    style, draw = imgui.get_style(), imgui.get_window_draw_list()
    wide, thick = style.grab_min_size, _HANDLE_SHARE * (high.y - low.y)
    # Where ImGui takes the handle to be: the whole of it, and a margin, is inside the field.
    edge = _GRAB_MARGIN + 0.5 * wide
    x = low.x + edge + share * (high.x - low.x - 2.0 * edge)
    rail = high.y - 0.5 * thick
    groove = imgui.get_color_u32(imgui.Col_.border)
    draw.add_line((low.x + edge, rail), (high.x - edge, rail), groove)
    held = imgui.is_item_active()
    colour = imgui.Col_.slider_grab_active if held else imgui.Col_.slider_grab
    corners = (x - 0.5 * wide, high.y - thick), (x + 0.5 * wide, high.y)
    draw.add_rect_filled(*corners, imgui.get_color_u32(colour), style.grab_rounding)


def _write_on_field(lead: str, text: str) -> None:
    """Write a dim word and a number on the last field, from its left edge."""
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    draw, padding = imgui.get_window_draw_list(), imgui.get_style().frame_padding
    x, y = low.x + padding.x, round(low.y + padding.y - _RAISED * (high.y - low.y))
    draw.push_clip_rect(low, high, True)
    if lead:
        draw.add_text((x, y), imgui.get_color_u32(imgui.Col_.text_disabled), lead)
        x += imgui.calc_text_size(f"{lead} ").x
    draw.add_text((x, y), imgui.get_color_u32(imgui.Col_.text), text)
    draw.pop_clip_rect()


def vector(
    rows: Rows,
    path: str,
    values: Sequence[float],
    row: Row,
    set_item: Callable[[int], Set],
) -> None:
    """Draw a slider for each component, one below the other from where the cursor is.

    Args:
        rows: of the frame.
        path: of the vector.
        values: its components.
        row: their names, unit and range.
        set_item: gives what takes a component by its number.
    """
    x = imgui.get_cursor_pos_x()
    width = rows.reset_x - rows.gap - x
    for index, (name, value) in enumerate(zip(row.names, values, strict=False)):
        imgui.set_cursor_pos_x(x)
        number(
            rows, f"{path}.{index}", value, width, set_item(index), row.slide, unit=row.unit,
            lead=name,
        )  # fmt: skip


def flag(rows: Rows, path: str, value: bool, set_value: Set, text: str = "") -> None:
    """Draw a box that is on or off, with text beside it."""
    changed, new = imgui.checkbox(f"{text}##{path}", value)
    rows.note(path)
    if changed:
        rows.drafts.choose(path, new, set_value)


def choice(
    rows: Rows,
    path: str,
    value: object,
    choices: Sequence[object],
    width: float,
    set_value: Set,
) -> None:
    """Draw a list to choose from."""
    wrong = path in rows.drafts.refusals
    if wrong:
        imgui.push_style_color(imgui.Col_.frame_bg, look.ERROR_FRAME)
    imgui.set_next_item_width(width)
    is_open = imgui.begin_combo(f"##{path}", str(value))
    rows.note(path)
    if wrong:
        imgui.pop_style_color()
    if not is_open:
        return
    for item in choices:
        if imgui.selectable(str(item), item == value)[0] and item != value:
            rows.drafts.choose(path, item, set_value)
        rows.note(f"{path}={item}")
    imgui.end_combo()


def boxes(rows: Rows, row: Row, values: Sequence[int], set_value: Set) -> None:
    """Draw a box for each item that a list may have, one below the other."""
    for index, name in enumerate(row.names):
        item = int(name.split()[0])
        if index:
            imgui.set_cursor_pos_x(rows.value_x)
        changed, on = imgui.checkbox(f"{name}##{row.path}", item in values)
        rows.note(row.inside(item))
        if changed:
            new = sorted({*values, item} if on else {*values} - {item})
            rows.drafts.choose(row.path, new, set_value)


def text(
    rows: Rows,
    path: str,
    value: str,
    width: float,
    set_value: Set,
    *,
    read: Callable[[str], object] = str,
    hint: str = "",
) -> None:
    """Draw a field of text; one that is too long shows its end."""
    draft = rows.drafts.text(path, value)
    if draft is not None:
        flags = imgui.InputTextFlags_.elide_left
        rows.drafts.draw(path, draft, width, read, set_value, hint=hint, flags=flags)
        rows.note(path)
        return
    imgui.set_next_item_width(width)
    flags = imgui.InputTextFlags_.elide_left | imgui.InputTextFlags_.read_only
    imgui.input_text_with_hint(f"##{path}", hint, value, flags)
    rows.note(path)
    if imgui.is_item_activated():
        rows.drafts.type(path, value, value)


def spectrum(rows: Rows, row: Row, value: str, width: float, set_value: Set) -> None:
    """Draw a list of all spectra by groups, with a field for a file of one's own."""
    path = row.path
    draft = rows.drafts.text(path, value)
    if draft is not None:
        hint = "path to a file of wavelengths and values"
        rows.drafts.draw(path, draft, width, str, set_value, hint=hint)
        rows.note(path)
        return
    imgui.set_next_item_width(width)
    own = bool(spectrum_file(value))
    flags = imgui.ComboFlags_.height_large
    is_open = imgui.begin_combo(f"##{path}", Path(value).name if own else value, flags)
    rows.note(path)
    if not is_open:
        return
    if imgui.selectable("a file of your own …", own)[0]:
        rows.drafts.type(path, value, value if own else "")
    rows.note(f"{path}=file")
    for group, names in spectrum_groups():
        imgui.separator_text(group)
        for name in names:
            if imgui.selectable(name, name == value)[0] and name != value:
                rows.drafts.choose(path, name, set_value)
            if name == value and imgui.is_window_appearing():
                imgui.set_scroll_here_y()
            rows.note(f"{path}={name}")
    imgui.end_combo()


@lru_cache(maxsize=1)
def spectrum_groups() -> tuple[tuple[str, tuple[str, ...]], ...]:
    """Give the names of all spectra by groups, in an order that a person expects."""
    from rtbow.world.measured.spectra import spectrum_names

    beginnings: dict[str, str | tuple[str, ...]] = {
        "daylight": ("D", "ID"),
        "LEDs": "LED",
        "fluorescent lamps": "FL",
        "high-pressure lamps": "HP",
        "other CIE illuminants": "",
    }
    groups = {"sunlight above the air; equal energy": [E490, EQUAL_ENERGY]}
    groups |= {group: [] for group in beginnings}
    for name in sorted(spectrum_names(), key=_natural):
        if name not in (E490, EQUAL_ENERGY):
            group = next(g for g, start in beginnings.items() if name.startswith(start))
            groups[group].append(name)
    return tuple((group, tuple(names)) for group, names in groups.items())


def _natural(name: str) -> list[tuple[int, str]]:
    """Give a key that sorts FL2 before FL10."""
    parts = re.findall(r"\d+|\D+", name)
    return [(int(part), "") if part.isdigit() else (-1, part) for part in parts]


def toml(rows: Rows, path: str, value: object, width: float, set_value: Set) -> None:
    """Draw a field for a value of any other kind, as TOML."""
    text(rows, path, toml_text(plain(value)), width, set_value, read=read_toml)
