"""What a GLFW window's events mean beside what Dear ImGui makes of them: shortcuts and flying.

ImGui's own GLFW backend hands it all events; its callbacks pass each one on to those here.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import glfw
from imgui_bundle import imgui

_CONTROL = glfw.MOD_CONTROL | glfw.MOD_SUPER
_NAMED = {
    glfw.KEY_ESCAPE: "Esc",
    glfw.KEY_TAB: "Tab",
    glfw.KEY_F1: "F1",
    glfw.KEY_F11: "F11",
}


def shortcut(key: int, scancode: int, modifiers: int = 0) -> str:
    """Name a key by what is written on it, such as ``Ctrl+Shift+Z``; a few others by their use.

    GLFW's own keys are places on a US keyboard. Where a layout has letters of another alphabet, the
    place is all there is. A key without a name gives an empty string.

    Args:
        key: GLFW's.
        scancode: of the same key.
        modifiers: GLFW's bits of those that are down.
    """
    name = _NAMED.get(key, "")
    if glfw.KEY_APOSTROPHE <= key <= glfw.KEY_WORLD_2:  # neither arrows nor the keypad
        written = (glfw.get_key_name(key, scancode) or "").upper()
        plain = len(written) == 1 and written.isascii()
        name = written if plain else chr(key)
    shift = "Shift+" if modifiers & glfw.MOD_SHIFT else ""
    control = "Ctrl+" if modifiers & _CONTROL else ""
    return f"{control}{shift}{name}" if name else ""


class WindowInput:
    """Connects a window to the current ImGui context, and remembers that something happened.

    Args:
        window: GLFW's handle.
        on_drop: called with the paths of files dropped on the window.
        on_key: called with the :func:`shortcut` that was pressed while no text is being typed.
        on_scroll: called with the wheel's clicks over the scene.

    Attributes:
        woken: whether an event has come since it was last set to False.
        held: letters and signs of keys that are down without Ctrl, by their places on a US
            keyboard.
    """

    def __init__(
        self,
        window: Any,
        on_drop: Callable[[list[str]], None],
        on_key: Callable[[str], None],
        on_scroll: Callable[[float], None],
    ) -> None:
        self._io = imgui.get_io()
        self._on_drop, self._on_key, self._on_scroll = on_drop, on_key, on_scroll
        self.woken = True
        self.held: set[str] = set()
        glfw.set_scroll_callback(window, self._scroll)
        glfw.set_key_callback(window, self._key)
        glfw.set_drop_callback(window, self._drop)  # type: ignore[arg-type]  # gives a list
        for watch in (
            glfw.set_cursor_pos_callback, glfw.set_cursor_enter_callback,
            glfw.set_mouse_button_callback, glfw.set_char_callback,
            glfw.set_window_focus_callback, glfw.set_window_iconify_callback,
            glfw.set_framebuffer_size_callback, glfw.set_window_size_callback,
            glfw.set_window_content_scale_callback, glfw.set_window_refresh_callback,
            glfw.set_window_close_callback,
        ):  # fmt: skip
            watch(window, self._wake)
        # Last: ImGui's callbacks call those that were there before.
        address = ctypes.cast(window, ctypes.c_void_p).value
        assert address is not None
        imgui.backends.glfw_init_for_opengl(address, True)

    def close(self) -> None:
        """Part ImGui from the window, before either of them goes."""
        imgui.backends.glfw_shutdown()

    def begin_frame(self) -> None:
        """Tell ImGui the window's size, the time since the last frame, and where the mouse is."""
        imgui.backends.glfw_new_frame()

    def _wake(self, *_: Any) -> None:
        self.woken = True

    def _scroll(self, _: Any, x: float, y: float) -> None:
        self.woken = True
        if not self._io.want_capture_mouse:
            self._on_scroll(y)

    def _key(self, _: Any, key: int, scancode: int, action: int, modifiers: int) -> None:
        self.woken = True
        place = chr(key) if glfw.KEY_APOSTROPHE <= key <= glfw.KEY_GRAVE_ACCENT else ""
        if action == glfw.RELEASE:  # GLFW releases all keys when another window gets the keyboard
            self.held.discard(place)
        elif action == glfw.PRESS and not self._io.want_text_input:
            if place and not modifiers & _CONTROL:
                self.held.add(place)
            name = shortcut(key, scancode, modifiers)
            if name:
                self._on_key(name)

    def _drop(self, _: Any, paths: list[str]) -> None:
        self.woken = True
        self._on_drop(list(paths))
