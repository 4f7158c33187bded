"""A screen without a monitor, and hands on its mouse and keyboard: what windows are tested with."""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from Xlib import XK, X, display
from Xlib.ext import xtest
from Xlib.protocol import event

PROCESSES: dict[str, int] = {}
"""Of the screens that run, by name."""
SCREEN_PX = (1000, 2600)
"""Of the screen that tests of the window share."""
WITHDRAWN, NORMAL, ICONIC = 0, 1, 3  # WM_STATE (ICCCM 4.1.3.1)


@contextmanager
def virtual_screen(width: int = 640, height: int = 480) -> Iterator[str]:
    """Run an X server of our own; its name. xvfb is needed, and a missing one is an error."""
    server = shutil.which("Xvfb")
    assert server, "install xvfb (Debian, Ubuntu)"
    reader, writer = os.pipe()
    process = subprocess.Popen(
        [server, "-displayfd", str(writer), "-screen", "0", f"{width}x{height}x24",
         "-nolisten", "tcp", "-noreset"],
        pass_fds=[writer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(writer)
    with os.fdopen(reader) as pipe:
        number = pipe.readline().strip()
    assert number, "Xvfb did not start"
    PROCESSES[f":{number}"] = process.pid
    try:
        yield f":{number}"
    finally:
        process.terminate()
        process.wait()


class Hands:
    """Moves the mouse and types, as a person would: the events pass through the X server."""

    def __init__(self, name: str) -> None:
        self._display = display.Display(name)
        self._root = self._display.screen().root

    def close(self) -> None:
        self._display.close()

    def move(self, x: float, y: float) -> None:
        xtest.fake_input(self._display, X.MotionNotify, x=round(x), y=round(y))
        self._display.sync()

    def button(self, down: bool, number: int = 1) -> None:
        kind = X.ButtonPress if down else X.ButtonRelease
        xtest.fake_input(self._display, kind, number)
        self._display.sync()

    def key(self, name: str, down: bool) -> None:
        code = self._display.keysym_to_keycode(XK.string_to_keysym(name))
        xtest.fake_input(self._display, X.KeyPress if down else X.KeyRelease, code)
        self._display.sync()

    def title(self, window: int) -> str:
        """What stands on a window's frame."""
        handle = self._display.create_resource_object("window", window)
        kind = self._display.intern_atom("UTF8_STRING")
        found = handle.get_full_property(self._display.intern_atom("_NET_WM_NAME"), kind)
        return found.value.decode() if found is not None else ""

    def set_state(self, window: int, state: int) -> None:
        """Minimise a window or bring it back, as a window manager does."""
        handle = self._display.create_resource_object("window", window)
        atom = self._display.intern_atom("WM_STATE")
        handle.change_property(atom, atom, 32, [state, 0])
        if state == ICONIC:
            handle.unmap()
        else:
            handle.map()
        self._display.sync()

    def drop(self, window: int, uris: list[str], pump: Callable[[], Any]) -> None:
        """Drop files on a window, as another program does (XDND version 5).

        Args:
            window: on which.
            uris: of the files.
            pump: lets the window take its events.
        """
        atom = self._display.intern_atom
        source = self._root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
        self._display.sync()
        kind = atom("text/uri-list")
        target = self._display.create_resource_object("window", window)
        source.set_selection_owner(atom("XdndSelection"), X.CurrentTime)

        def send(name: str, data: list[int]) -> None:
            message = event.ClientMessage(window=target, client_type=atom(name), data=(32, data))
            target.send_event(message, event_mask=0)
            self._display.sync()

        send("XdndEnter", [source.id, 5 << 24, kind, 0, 0])
        send("XdndPosition", [source.id, 0, 10 << 16 | 10, X.CurrentTime, atom("XdndActionCopy")])
        pump()
        send("XdndDrop", [source.id, 0, X.CurrentTime, 0, 0])
        done = threading.Event()

        def answer() -> None:
            # GLFW waits for the files while it takes its events: they come from another thread.
            end = time.monotonic() + 10.0
            while not done.is_set() and time.monotonic() < end:
                if not self._display.pending_events():
                    time.sleep(0.002)
                    continue
                asked = self._display.next_event()
                if asked.type == X.SelectionRequest:
                    text = ("\r\n".join(uris) + "\r\n").encode()
                    asked.requestor.change_property(asked.property, asked.target, 8, text)
                    asked.requestor.send_event(
                        event.SelectionNotify(
                            time=asked.time, requestor=asked.requestor,
                            selection=asked.selection, target=asked.target,
                            property=asked.property,
                        ),
                        event_mask=0,
                    )  # fmt: skip
                    self._display.flush()

        thread = threading.Thread(target=answer)
        thread.start()
        for _ in range(30):
            pump()
            time.sleep(0.005)
        done.set()
        thread.join()
