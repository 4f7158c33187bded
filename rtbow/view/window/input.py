"""Hands a GLFW window's events to Dear ImGui, and those that it does not want to the scene."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import glfw
from imgui_bundle import imgui

_FAR = -3.4e38
"""Where ImGui takes the mouse to be outside of the window."""
_NAMED = {
    "TAB": "tab", "BACKSPACE": "backspace", "ENTER": "enter", "ESCAPE": "escape",
    "INSERT": "insert", "DELETE": "delete", "SPACE": "space", "LEFT": "left_arrow",
    "RIGHT": "right_arrow", "UP": "up_arrow", "DOWN": "down_arrow", "PAGE_UP": "page_up",
    "PAGE_DOWN": "page_down", "HOME": "home", "END": "end", "KP_ENTER": "keypad_enter",
    "KP_DECIMAL": "keypad_decimal", "KP_DIVIDE": "keypad_divide",
    "KP_MULTIPLY": "keypad_multiply", "KP_SUBTRACT": "keypad_subtract", "KP_ADD": "keypad_add",
    "LEFT_CONTROL": "left_ctrl", "RIGHT_CONTROL": "right_ctrl", "LEFT_SHIFT": "left_shift",
    "RIGHT_SHIFT": "right_shift", "LEFT_ALT": "left_alt", "RIGHT_ALT": "right_alt",
    "LEFT_SUPER": "left_super", "RIGHT_SUPER": "right_super", "APOSTROPHE": "apostrophe",
    "COMMA": "comma", "MINUS": "minus", "PERIOD": "period", "SLASH": "slash",
    "SEMICOLON": "semicolon", "EQUAL": "equal", "LEFT_BRACKET": "left_bracket",
    "BACKSLASH": "backslash", "RIGHT_BRACKET": "right_bracket", "GRAVE_ACCENT": "grave_accent",
}  # fmt: skip
_SIGNS = {
    "'": glfw.KEY_APOSTROPHE, ",": glfw.KEY_COMMA, "-": glfw.KEY_MINUS, ".": glfw.KEY_PERIOD,
    "/": glfw.KEY_SLASH, ";": glfw.KEY_SEMICOLON, "=": glfw.KEY_EQUAL,
    "[": glfw.KEY_LEFT_BRACKET, "\\": glfw.KEY_BACKSLASH, "]": glfw.KEY_RIGHT_BRACKET,
    "`": glfw.KEY_GRAVE_ACCENT,
}  # fmt: skip
_CONTROL = glfw.MOD_CONTROL | glfw.MOD_SUPER
_MODIFIERS = (
    (glfw.MOD_CONTROL, imgui.Key.mod_ctrl, (glfw.KEY_LEFT_CONTROL, glfw.KEY_RIGHT_CONTROL)),
    (glfw.MOD_SHIFT, imgui.Key.mod_shift, (glfw.KEY_LEFT_SHIFT, glfw.KEY_RIGHT_SHIFT)),
    (glfw.MOD_ALT, imgui.Key.mod_alt, (glfw.KEY_LEFT_ALT, glfw.KEY_RIGHT_ALT)),
    (glfw.MOD_SUPER, imgui.Key.mod_super, (glfw.KEY_LEFT_SUPER, glfw.KEY_RIGHT_SUPER)),
)


def _keys() -> dict[int, imgui.Key]:
    found = {getattr(glfw, f"KEY_{g}"): getattr(imgui.Key, name) for g, name in _NAMED.items()}
    for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ":
        found[getattr(glfw, f"KEY_{letter}")] = getattr(imgui.Key, letter.lower())
    for digit in "0123456789":
        found[getattr(glfw, f"KEY_{digit}")] = getattr(imgui.Key, f"_{digit}")
        found[getattr(glfw, f"KEY_KP_{digit}")] = getattr(imgui.Key, f"keypad{digit}")
    for number in range(1, 13):
        found[getattr(glfw, f"KEY_F{number}")] = getattr(imgui.Key, f"f{number}")
    return found


def lettered(key: int, scancode: int) -> int:
    """Give GLFW's key for what is written on a key: its own keys are places on a US keyboard.

    Where a layout has letters of another alphabet, the place is all there is.
    """
    if not glfw.KEY_APOSTROPHE <= key <= glfw.KEY_WORLD_2:  # arrows, keypad and such
        return key
    name = (glfw.get_key_name(key, scancode) or "").upper()
    if len(name) == 1 and name.isascii() and name.isalnum():
        return ord(name)
    return _SIGNS.get(name, key)


class WindowInput:
    """Listens to a window, and remembers that something happened.

    Args:
        window: GLFW's handle.
        on_drop: called with the paths of files dropped on the window.
        on_key: called with GLFW's key for what is written on it, whether it goes down, and its
            modifiers, for keys that ImGui has no use for.
        on_scroll: called with the wheel's clicks over the scene.

    Attributes:
        woken: whether an event has come since it was last set to False.
        held: keys that are down without Ctrl, by their places on a US keyboard.
    """

    def __init__(
        self,
        window: Any,
        on_drop: Callable[[list[str]], None],
        on_key: Callable[[int, bool, int], None],
        on_scroll: Callable[[float], None],
    ) -> None:
        self._window, self._io = window, imgui.get_io()
        self._on_drop, self._on_key, self._on_scroll = on_drop, on_key, on_scroll
        self._keys = _keys()
        self._time: float | None = None
        self.woken = True
        self.held: set[int] = set()
        self._lettered: dict[int, int] = {}
        glfw.set_cursor_pos_callback(window, self._cursor)
        glfw.set_mouse_button_callback(window, self._button)
        glfw.set_scroll_callback(window, self._scroll)
        glfw.set_key_callback(window, self._key)
        glfw.set_char_callback(window, self._character)
        glfw.set_cursor_enter_callback(window, self._enter)
        glfw.set_window_focus_callback(window, self._focus)
        glfw.set_drop_callback(window, self._drop)  # type: ignore[arg-type]  # gives a list
        for watch in (
            glfw.set_framebuffer_size_callback, glfw.set_window_size_callback,
            glfw.set_window_iconify_callback, glfw.set_window_refresh_callback,
            glfw.set_window_content_scale_callback, glfw.set_window_close_callback,
        ):  # fmt: skip
            watch(window, self._wake)

    def _wake(self, *_: Any) -> None:
        self.woken = True

    def _cursor(self, _: Any, x: float, y: float) -> None:
        self.woken = True
        self._io.add_mouse_pos_event(x, y)

    def _button(self, _: Any, button: int, action: int, modifiers: int) -> None:
        self.woken = True
        self._modify(modifiers)
        if button < 5:
            self._io.add_mouse_button_event(button, action == glfw.PRESS)

    def _scroll(self, _: Any, x: float, y: float) -> None:
        self.woken = True
        self._io.add_mouse_wheel_event(x, y)
        if not self._io.want_capture_mouse:
            self._on_scroll(y)

    def _key(self, _: Any, key: int, scancode: int, action: int, modifiers: int) -> None:
        self.woken = True
        if action == glfw.REPEAT:  # ImGui repeats by itself
            return
        down = action == glfw.PRESS
        self._modify(modifiers, key, down=down)
        if down:
            self._lettered[key] = lettered(key, scancode)
        # The layout may have changed while it was down.
        written = self._lettered.get(key, key) if down else self._lettered.pop(key, key)
        name = self._keys.get(written)
        if name is not None:
            self._io.add_key_event(name, down)
        if not down:
            self.held.discard(key)
        elif not self._io.want_text_input and not modifiers & _CONTROL:
            self.held.add(key)
        if not (down and self._io.want_text_input):
            self._on_key(written, down, modifiers)

    def _modify(self, modifiers: int, key: int | None = None, *, down: bool = False) -> None:
        for bit, name, keys in _MODIFIERS:
            # X11 tells the state before the event.
            self._io.add_key_event(name, down if key in keys else bool(modifiers & bit))

    def _character(self, _: Any, code: int) -> None:
        self.woken = True
        self._io.add_input_character(code)

    def _enter(self, _: Any, entered: int) -> None:
        self.woken = True
        if not entered:
            self._io.add_mouse_pos_event(_FAR, _FAR)

    def _focus(self, _: Any, focused: int) -> None:
        self.woken = True
        self._io.add_focus_event(bool(focused))
        if not focused:
            self.held.clear()  # their release goes to another window
            self._lettered.clear()

    def _drop(self, _: Any, paths: list[str]) -> None:
        self.woken = True
        self._on_drop(list(paths))

    def begin_frame(self) -> None:
        """Tell ImGui the window's size and the time since the last frame."""
        width, height = glfw.get_window_size(self._window)
        pixels = glfw.get_framebuffer_size(self._window)
        self._io.display_size = imgui.ImVec2(width, height)
        if width > 0 and height > 0:
            scale = imgui.ImVec2(pixels[0] / width, pixels[1] / height)
            self._io.display_framebuffer_scale = scale
        now = time.perf_counter()
        self._io.delta_time = 1.0 / 60.0 if self._time is None else max(now - self._time, 1e-4)
        self._time = now
