"""Keys of a window: shortcuts go by what is written on a key, flying by where it lies."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator

import glfw
import pytest
from imgui_bundle import imgui

from checkout import ROOT
from rtbow.view.window.input import WindowInput
from screen import virtual_screen

QWERTZ = {glfw.KEY_Z: "y", glfw.KEY_Y: "z", glfw.KEY_MINUS: "ß", glfw.KEY_SLASH: "-"}
AZERTY = {
    glfw.KEY_Q: "a", glfw.KEY_A: "q", glfw.KEY_W: "z", glfw.KEY_Z: "w", glfw.KEY_SEMICOLON: "m",
    glfw.KEY_M: ",", glfw.KEY_1: "&",
}  # fmt: skip
GREEK = {glfw.KEY_Z: "ζ", glfw.KEY_C: "ψ"}


class Typist:
    """Somebody's hands on a keyboard of some layout."""

    def __init__(self) -> None:
        self.layout: dict[int, str] = {}
        self.heard: list[tuple[int, bool, int]] = []
        self.input = WindowInput(
            None, lambda paths: None, lambda *key: self.heard.append(key), lambda clicks: None
        )

    def name(self, key: int, scancode: int) -> str | None:
        assert scancode == key + 1000
        assert glfw.KEY_APOSTROPHE <= key <= glfw.KEY_WORLD_2
        return self.layout.get(key, chr(key).lower())

    def press(self, key: int, modifiers: int = 0, *, down: bool = True) -> None:
        action = glfw.PRESS if down else glfw.RELEASE
        self.input._key(None, key, key + 1000, action, modifiers)
        imgui.new_frame()
        imgui.render()


@pytest.fixture
def typist(monkeypatch: pytest.MonkeyPatch) -> Iterator[Typist]:
    context = imgui.create_context()
    io = imgui.get_io()
    io.set_ini_filename("")
    io.display_size = imgui.ImVec2(100.0, 100.0)
    io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
    io.config_input_trickle_event_queue = False
    for name in dir(glfw):
        if name.startswith("set_") and name.endswith("_callback"):
            monkeypatch.setattr(glfw, name, lambda window, callback: None)
    made = Typist()
    monkeypatch.setattr(glfw, "get_key_name", made.name)
    yield made
    imgui.destroy_context(context)


@pytest.mark.parametrize(
    ("layout", "place", "written"),
    [
        ({}, glfw.KEY_Z, glfw.KEY_Z), (QWERTZ, glfw.KEY_Y, glfw.KEY_Z),
        (QWERTZ, glfw.KEY_Z, glfw.KEY_Y), (QWERTZ, glfw.KEY_SLASH, glfw.KEY_MINUS),
        (AZERTY, glfw.KEY_W, glfw.KEY_Z), (AZERTY, glfw.KEY_SEMICOLON, glfw.KEY_M),
        (AZERTY, glfw.KEY_M, glfw.KEY_COMMA), (AZERTY, glfw.KEY_1, glfw.KEY_1),
        (QWERTZ, glfw.KEY_MINUS, glfw.KEY_MINUS), (GREEK, glfw.KEY_Z, glfw.KEY_Z),
    ],
)  # fmt: skip
def test_shortcuts_go_by_what_is_written_on_the_key(typist, layout, place, written):
    typist.layout = layout
    typist.press(glfw.KEY_LEFT_CONTROL)
    typist.press(place, glfw.MOD_CONTROL)
    assert typist.heard[-1] == (written, True, glfw.MOD_CONTROL)
    name = glfw_name(written)
    assert imgui.is_key_down(name)
    assert imgui.get_io().key_ctrl
    typist.press(place, glfw.MOD_CONTROL, down=False)
    assert typist.heard[-1] == (written, False, glfw.MOD_CONTROL)
    assert not imgui.is_key_down(name)


def glfw_name(key: int) -> imgui.Key:
    named = {glfw.KEY_MINUS: "minus", glfw.KEY_COMMA: "comma", glfw.KEY_1: "_1"}
    return getattr(imgui.Key, named.get(key, chr(key).lower()))


@pytest.mark.parametrize("layout", [{}, QWERTZ, AZERTY, GREEK])
def test_flying_goes_by_where_the_key_lies(typist, layout):
    typist.layout = layout
    keys = {getattr(glfw, f"KEY_{letter}") for letter in "WASDQE"}
    for key in keys:
        typist.press(key)
    assert typist.input.held == keys
    for key in keys:
        typist.press(key, down=False)
    assert not typist.input.held


def test_a_shortcut_does_not_fly(typist):
    typist.layout = AZERTY
    typist.press(glfw.KEY_LEFT_CONTROL)
    typist.press(glfw.KEY_W, glfw.MOD_CONTROL)  # Ctrl+Z
    assert glfw.KEY_W not in typist.input.held


def test_a_key_comes_up_as_it_went_down(typist):
    typist.layout = QWERTZ
    typist.press(glfw.KEY_Y)
    typist.layout = {}
    typist.press(glfw.KEY_Y, down=False)
    assert not imgui.is_key_down(imgui.Key.z)
    assert typist.heard == [(glfw.KEY_Z, True, 0), (glfw.KEY_Z, False, 0)]


def test_keys_without_letters_stay_what_they_are(typist):
    keys = (glfw.KEY_ESCAPE, glfw.KEY_TAB, glfw.KEY_F1, glfw.KEY_LEFT, glfw.KEY_KP_7)
    for key in (*keys, glfw.KEY_SPACE):
        typist.press(key)
        assert typist.heard[-1][0] == key


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
heard, hands = [], Hands(sys.argv[1])
given = WindowInput(window, None, lambda key, down, _: heard.append((key, down)), None)
for name in ("z", "odiaeresis", "minus"):
    end, count = time.monotonic() + 10.0, len(heard)
    while len(heard) == count and time.monotonic() < end:
        glfw.focus_window(window)  # nobody else gives it the keyboard here
        hands.key(name, True)
        glfw.wait_events_timeout(0.1)
    print(chr(heard[-1][0]), *map(chr, given.held))
    hands.key(name, False)
    while given.held and time.monotonic() < end:
        glfw.wait_events_timeout(0.1)
"""


def test_a_real_keyboard_of_another_layout():
    with virtual_screen(300, 200) as name:
        env = {**os.environ, "DISPLAY": name, "PYTHONPATH": str(ROOT / "tests" / "support")}
        subprocess.run(["setxkbmap", "de"], check=True, env=env)
        result = subprocess.run(
            [sys.executable, "-c", TYPED, name], capture_output=True, text=True, env=env, timeout=60
        )
    assert result.returncode == 0, result.stderr
    assert result.stdout.split("\n")[:3] == ["Z Y", "; ;", "- /"]
