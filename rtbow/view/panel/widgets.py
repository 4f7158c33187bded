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
    text = (show(value) + shown_unit(unit)).replace("%", "%%")  # it is a format
    flags = imgui.SliderFlags_.no_input
    if slide is None:
        changed, moved = imgui.drag_float(f"##{path}", 0.0, 1.0, 0.0, 0.0, text, flags)
        new: float = float(f"{value + moved * max(abs(value), 1.0) * _TURN:.4g}")
    else:
        changed, share = imgui.slider_float(f"##{path}", slide.share(value), 0.0, 1.0, text, flags)
        new = slide.value(share) if changed else value
    rows.note(path)
    if wrong:
        imgui.pop_style_color(2)
    if changed and new != value:
        rows.drafts.drag(path, value, new, set_value)


def vector(
    rows: Rows,
    path: str,
    values: Sequence[float],
    row: Row,
    set_item: Callable[[int], Set],
    lead: str = "",
) -> None:
    """Draw a slider for each component, side by side over the panel's width.

    Args:
        rows: of the frame.
        path: of the vector.
        values: its components.
        row: their names, unit and range.
        set_item: gives what takes a component by its number.
        lead: a short word in front of them.
    """
    count = len(values)
    left = rows.left
    if lead:
        left += 2.0 * rows.row_height
        imgui.align_text_to_frame_padding()
        imgui.text_disabled(lead)
        imgui.same_line(left)
    width = (rows.reset_x - rows.gap - left - (count - 1) * rows.gap) / count
    for index, (name, value) in enumerate(zip(row.names, values, strict=False)):
        if index:
            imgui.same_line(0.0, rows.gap)

        def show(number: float, name: str = name) -> str:
            return f"{name} {shown_number(number)}"

        number(rows, f"{path}.{index}", value, width, set_item(index), row.slide, show=show)


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
    from rtbow.world.spectra import spectrum_names

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
