"""The built-in scenes as pictures to click on, and a field for files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from imgui_bundle import imgui

from rtbow.base.resources import resource_dir
from rtbow.scene.text.file import builtin_scenes, scene_title
from rtbow.view.document.edits import Edits
from rtbow.view.document.state import Actions, ViewState
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, own_row
from rtbow.view.panel.widgets import text
from rtbow.view.window import look

FOLDER = "thumbnails"
"""Folder of the pictures within that of the scenes; each has its scene's name."""
_COLUMNS = 2
_SHAPE = 9 / 16
_LOADED_AT_ONCE = 2
"""Most pictures that are read in one frame, so that none takes long."""


class Gallery:
    """Draws the list; pictures are read when they are first seen.

    Args:
        actions: what the window does.
    """

    def __init__(self, actions: Actions) -> None:
        self._actions = actions
        self._pictures: dict[str, imgui.ImTextureData | None] = {}
        self._rows: dict[str, Row] = {}
        self._files = builtin_scenes()
        self._titles: dict[str, str] = {}
        self._groups = _groups(self._files)

    def draw(self, rows: Rows, edits: Edits, state: ViewState) -> None:
        """Draw the list and the field.

        Args:
            rows: of the frame.
            edits: which scene is open.
            state: the files opened last.
        """
        self._budget = _LOADED_AT_ONCE
        for group, names in self._groups.items():
            if not group:
                self._grid(rows, names, edits.opened.name or "default")
            elif imgui.tree_node(f"{group} ({len(names)})"):
                rows.note(f"group/{group}")
                self._grid(rows, names, edits.opened.name or "default")
                imgui.tree_pop()
            else:
                rows.note(f"group/{group}")
        width = rows.right_edge - rows.left
        row = own_row("open", "open a file", "a scene file of your own, .toml")
        if rows.begin_row(row, False):
            text(rows, row.path, "", width, self._open, hint="open a scene file: path.toml")
            rows.end_row()
        for path in state.recent:
            if imgui.selectable(rows.cut(path, start=True), path == edits.opened.name)[0]:
                self._actions.open_scene(path)

    def _open(self, value: object, gesture: object) -> str:
        self._actions.open_scene(str(value).strip())
        return ""

    def _grid(self, rows: Rows, names: list[str], chosen: str) -> None:
        left = imgui.get_cursor_pos_x()
        width = (rows.right_edge - left - (_COLUMNS - 1) * rows.gap) / _COLUMNS
        for first in range(0, len(names), _COLUMNS):
            row_names = names[first : first + _COLUMNS]
            key = row_names[0]
            row = self._rows.setdefault(key, own_row(f"scenes.{key}", "", ""))
            if not rows.begin_row(row, False):
                continue
            for column, name in enumerate(row_names):
                if column:
                    imgui.same_line(left + column * (width + rows.gap))
                self._tile(rows, name, width, chosen=name == chosen)
            rows.end_row()

    def _tile(self, rows: Rows, name: str, width: float, *, chosen: bool) -> None:
        """Draw one scene: its picture, and its name below."""
        size = (width, width * _SHAPE)
        imgui.begin_group()
        corner = imgui.get_cursor_screen_pos()
        pressed = imgui.invisible_button(f"##{name}", (width, size[1] + imgui.get_font_size()))
        hovered = imgui.is_item_hovered()
        rows.note(f"scenes/{name}")
        lines = imgui.get_window_draw_list()
        end = (corner.x + size[0], corner.y + size[1])
        picture = self._picture(name)
        if picture is None:
            lines.add_rect_filled(corner, end, imgui.get_color_u32(imgui.Col_.frame_bg))
        else:
            lines.add_image(picture.get_tex_ref(), corner, end)
        colour = look.ACCENT if chosen or hovered else look.DIM
        if chosen or hovered:
            lines.add_rect(corner, end, imgui.get_color_u32(look.ACCENT), thickness=2.0)
        short = name.rpartition("/")[2]
        lines.add_text((corner.x + 2.0, end[1] + 1.0), imgui.get_color_u32(colour), short)
        imgui.end_group()
        if pressed:
            self._actions.open_scene(name)
        if hovered:
            if name not in self._titles:
                self._titles[name] = scene_title(self._files[name])
            imgui.set_item_tooltip(f"{self._titles[name]}\nrtbow view {name}")

    def _picture(self, name: str) -> imgui.ImTextureData | None:
        if name not in self._pictures:
            if not self._budget:
                return None
            self._budget -= 1
            self._pictures[name] = _load(name)
        return self._pictures[name]

    def close(self) -> None:
        """Forget the pictures, while ImGui's context still exists."""
        for picture in self._pictures.values():
            if picture is not None:
                imgui.internal.unregister_user_texture(picture)
        self._pictures.clear()


def _groups(names: Iterable[str]) -> dict[str, list[str]]:
    """Give the scenes by folder; those without one come first."""
    groups: dict[str, list[str]] = {"": []}
    for name in names:
        groups.setdefault(name.rpartition("/")[0], []).append(name)
    return groups


def thumbnail_path(name: str) -> Path:
    """Give the path of a built-in scene's small picture."""
    return resource_dir("scenes") / FOLDER / f"{name}.png"


def _load(name: str) -> imgui.ImTextureData | None:
    """Load a scene's picture as a texture of ImGui; None if there is none."""
    from PIL import Image

    path = thumbnail_path(name)
    if not path.is_file():
        return None
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGBA"))
    height, width = pixels.shape[:2]
    texture = imgui.ImTextureData()
    texture.create(imgui.ImTextureFormat.rgba32, width, height)
    texture.get_pixels_array()[:] = pixels.reshape(-1)
    texture.set_status(imgui.ImTextureStatus.want_create)
    imgui.internal.register_user_texture(texture)
    return texture
