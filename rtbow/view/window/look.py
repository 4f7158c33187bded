"""How the panel looks: font, colours and distances."""

from __future__ import annotations

from pathlib import Path

import imgui_bundle
from imgui_bundle import ImVec4, imgui

FONT_PX = 15.0
_FONT = Path("assets", "fonts", "Roboto", "Roboto-Regular.ttf")
"""A font in Dear ImGui Bundle's folder with µ, °, ² and Δ, which ImGui's own lacks."""


def _rgb(code: int, alpha: float = 1.0) -> ImVec4:
    return ImVec4((code >> 16) / 255, (code >> 8 & 255) / 255, (code & 255) / 255, alpha)


TEXT = _rgb(0xE6E9EE)
DIM = _rgb(0x929AA8)
ACCENT = _rgb(0x6CB2F5)
WARNING = _rgb(0xF2C14E)
ERROR = _rgb(0xFF8A80)
ERROR_FRAME = _rgb(0x5A2226)
RIGHT = _rgb(0xF0A35E)
"""Colour of the right side of a split picture."""
RIGHT_GRAB = _rgb(0xC9824A)
RIGHT_HEADER = _rgb(0x5A3D22)

BACKGROUND = (0x14 / 255, 0x17 / 255, 0x1C / 255, 1.0)
"""The panel's colour. Clearing the screen to it is free; filling a window with it takes a
millisecond on a CPU."""
_WINDOW = 0x14171C
_FRAME = 0x262C36
_COLOURS = {
    imgui.Col_.text: TEXT,
    imgui.Col_.text_disabled: DIM,
    imgui.Col_.window_bg: _rgb(_WINDOW),
    imgui.Col_.popup_bg: _rgb(0x1C2129),
    imgui.Col_.border: _rgb(0x3A424F),
    imgui.Col_.frame_bg: _rgb(_FRAME),
    imgui.Col_.frame_bg_hovered: _rgb(0x2F3744),
    imgui.Col_.frame_bg_active: _rgb(0x364152),
    imgui.Col_.title_bg: _rgb(_WINDOW),
    imgui.Col_.title_bg_active: _rgb(_WINDOW),
    imgui.Col_.scrollbar_bg: _rgb(_WINDOW),
    imgui.Col_.scrollbar_grab: _rgb(0x353D4A),
    imgui.Col_.check_mark: ACCENT,
    imgui.Col_.slider_grab: _rgb(0x5490CC),
    imgui.Col_.slider_grab_active: ACCENT,
    imgui.Col_.button: _rgb(0x303947),
    imgui.Col_.button_hovered: _rgb(0x3D4A5E),
    imgui.Col_.button_active: _rgb(0x47617F),
    imgui.Col_.header: _rgb(0x2A3442),
    imgui.Col_.header_hovered: _rgb(0x354357),
    imgui.Col_.header_active: _rgb(0x3D5068),
    imgui.Col_.separator: _rgb(0x343C49),
    imgui.Col_.plot_histogram: _rgb(0x4F86BD),
    imgui.Col_.text_selected_bg: _rgb(0x3A6EA5),
}


def apply() -> None:
    """Style the current ImGui context, once, before its first frame."""
    style = imgui.get_style()
    for index, colour in _COLOURS.items():
        style.set_color_(index, colour)
    _space(style, 1.0)
    style.window_rounding = 0.0
    style.window_border_size = 0.0
    style.font_size_base = FONT_PX
    font = Path(imgui_bundle.__file__).parent / _FONT
    if font.is_file():
        imgui.get_io().fonts.add_font_from_file_ttf(str(font), FONT_PX)


def scale(content_scale: float) -> None:
    """Scale letters and distances to the display's density.

    Args:
        content_scale: 1 on an ordinary display; it may change before each frame.
    """
    style = imgui.get_style()
    if style.font_scale_dpi != content_scale:
        style.font_scale_dpi = content_scale
        _space(style, content_scale)


def _space(style: imgui.Style, by: float) -> None:
    style.window_padding = imgui.ImVec2(8.0 * by, 8.0 * by)
    style.frame_padding = imgui.ImVec2(6.0 * by, 3.0 * by)
    style.item_spacing = imgui.ImVec2(6.0 * by, 4.0 * by)
    style.item_inner_spacing = imgui.ImVec2(5.0 * by, 4.0 * by)
    style.indent_spacing = 21.0 * by
    style.cell_padding = imgui.ImVec2(4.0 * by, 2.0 * by)
    style.scrollbar_size = 10.0 * by
    style.grab_min_size = 11.0 * by
    style.frame_rounding = style.popup_rounding = 3.0 * by
    style.grab_rounding = 2.0 * by
