"""Keys of a window: shortcuts go by what is written on a key, flying by where it lies."""

from __future__ import annotations

import os
import subprocess
import sys

import glfw
import pytest

from checkout import ROOT
from rtbow.view.window.input import shortcut
from screen import virtual_screen

QWERTZ = {glfw.KEY_Z: "y", glfw.KEY_Y: "z", glfw.KEY_MINUS: "ß", glfw.KEY_SLASH: "-"}
AZERTY = {
    glfw.KEY_Q: "a", glfw.KEY_A: "q", glfw.KEY_W: "z", glfw.KEY_Z: "w", glfw.KEY_SEMICOLON: "m",
    glfw.KEY_M: ",",
}  # fmt: skip
GREEK = {glfw.KEY_Z: "ζ", glfw.KEY_C: "ψ"}


@pytest.mark.parametrize(
    ("layout", "place", "written"),
    [
        ({}, glfw.KEY_Z, "Z"), (QWERTZ, glfw.KEY_Y, "Z"), (QWERTZ, glfw.KEY_Z, "Y"),
        (QWERTZ, glfw.KEY_SLASH, "-"), (QWERTZ, glfw.KEY_MINUS, "-"), (AZERTY, glfw.KEY_W, "Z"),
        (AZERTY, glfw.KEY_SEMICOLON, "M"), (AZERTY, glfw.KEY_M, ","), (GREEK, glfw.KEY_Z, "Z"),
    ],
)  # fmt: skip
def test_shortcuts_go_by_what_is_written_on_the_key(monkeypatch, layout, place, written):
    def name(key: int, scancode: int) -> str:
        assert scancode == key + 1000
        return layout.get(key, chr(key).lower())

    monkeypatch.setattr(glfw, "get_key_name", name)
    assert shortcut(place, place + 1000) == written
    assert shortcut(place, place + 1000, glfw.MOD_CONTROL) == f"Ctrl+{written}"
    both = glfw.MOD_SUPER | glfw.MOD_SHIFT
    assert shortcut(place, place + 1000, both) == f"Ctrl+Shift+{written}"


def test_keys_without_letters_have_names_or_none(monkeypatch):
    monkeypatch.setattr(glfw, "get_key_name", lambda key, scancode: "7")  # as the keypad's has
    names = {glfw.KEY_ESCAPE: "Esc", glfw.KEY_TAB: "Tab", glfw.KEY_F1: "F1", glfw.KEY_F11: "F11"}
    for key, name in names.items():
        assert shortcut(key, 0) == name
    for key in (glfw.KEY_LEFT, glfw.KEY_KP_7, glfw.KEY_SPACE, glfw.KEY_LEFT_CONTROL):
        assert shortcut(key, 0, glfw.MOD_CONTROL) == ""


TYPED = """
import sys, time
import glfw
from imgui_bundle import imgui
from screen import Hands
from rtbow.view.window.input import WindowInput

assert glfw.init()
glfw.window_hint(glfw.CLIENT_API, glfw.NO_API)
window = glfw.create_window(200, 100, "keys", None, None)
imgui.create_context()
io = imgui.get_io()
io.set_ini_filename("")
io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
io.config_input_trickle_event_queue = False
heard, hands = [], Hands(sys.argv[1])
given = WindowInput(window, None, heard.append, None)
names = {getattr(imgui.Key, name): name for name in ("z", "y", "minus", "semicolon", "a", "q")}

def frame():
    glfw.focus_window(window)  # nobody else gives it the keyboard here
    glfw.wait_events_timeout(0.05)
    given.begin_frame()
    imgui.new_frame()
    imgui.render()
    return [name for key, name in names.items() if imgui.is_key_down(key)]

def until(condition):
    end = time.monotonic() + 10.0
    while not condition() and time.monotonic() < end:
        frame()

for control in (False, True):
    for name in sys.argv[2:]:
        heard.clear()
        if control:
            hands.key("Control_L", True)
            until(lambda: io.key_ctrl)
        while not heard:
            hands.key(name, True)
            until(lambda: heard)
        print(heard[-1], *given.held, *frame())
        for key in (name, "Control_L"):
            hands.key(key, False)
        until(lambda: not given.held and not io.key_ctrl and not frame())
        assert not given.held and not io.key_ctrl and not frame()
given.close()
imgui.destroy_context()
"""


@pytest.mark.parametrize(
    ("layout", "names", "expected"),
    [
        ("de", ("z", "minus"), ["Z Y z", "- / minus", "Ctrl+Z z", "Ctrl+- minus"]),
        ("fr", ("z", "a"), ["Z W z", "A Q a", "Ctrl+Z z", "Ctrl+A a"]),
    ],
)
def test_a_real_keyboard_of_another_layout(layout, names, expected):
    """What shortcuts hear, which keys fly, and what ImGui takes the key for."""
    with virtual_screen(300, 200) as name:
        env = {**os.environ, "DISPLAY": name, "PYTHONPATH": str(ROOT / "tests" / "support")}
        subprocess.run(["setxkbmap", layout], check=True, env=env)
        result = subprocess.run(
            [sys.executable, "-c", TYPED, name, *names],
            capture_output=True, text=True, env=env, timeout=60,
        )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines() == expected
