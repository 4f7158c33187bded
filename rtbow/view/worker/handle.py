"""The process that renders for the window, so that no rebuild ever stops the window.

Compiling a shader or building tables takes a second and holds Python's lock meanwhile: in a thread
that would freeze the window. Frames come back through shared memory.
"""

from __future__ import annotations

import atexit
import threading
import time
from contextlib import suppress
from dataclasses import replace
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from typing import TYPE_CHECKING

from rtbow.view.document.messages import (
    Begun,
    DrawFrame,
    Failed,
    Placed,
    Progressed,
    Reload,
    Reply,
    Request,
    SkyWaits,
)
from rtbow.view.worker.frame_memory import FrameReader
from rtbow.view.worker.server import LAST_WORDS_S, serve

if TYPE_CHECKING:
    from rtbow.gl.context import Backend

_STUCK_S = (5.0, 60.0)
"""How long a frame may wait while the process does something else, at first and at most."""


class Worker:
    """The window's side of the process.

    Args:
        backend: how the process gets a GL context.

    Usable as a context manager. A process that ends by itself is started again by the next request.

    Attributes:
        pending: numbers of requests that are not yet done.
    """

    def __init__(self, backend: Backend = "auto") -> None:
        self._backend = backend
        self._number = 0
        self._frames = FrameReader()
        self.pending: set[int] = set()
        self._frame: DrawFrame | None = None
        self._stuck_s = _STUCK_S[0]
        self._start()
        # At exit, Python waits for its processes, and this one waits for its pipe.
        atexit.register(self.close)

    def _start(self) -> None:
        self._has_begun = False
        self._waits_since_s: float | None = None
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        # No daemon: it has processes of its own, which build Lorenz-Mie tables.
        self._process = context.Process(
            target=serve, args=(theirs, self._backend), name="rtbow renderer"
        )
        self._process.start()
        theirs.close()

    @property
    def busy(self) -> bool:
        """Whether a request is not yet done."""
        return bool(self.pending)

    @property
    def process_id(self) -> int | None:
        """The process's id."""
        return self._process.pid

    def next_number(self) -> int:
        """Give a number for a request."""
        self._number += 1
        return self._number

    def send(self, request: Request) -> None:
        """Send a request; its replies come from :meth:`replies`."""
        if self._pipe.closed:
            self._start()
        if not isinstance(request, Reload):
            self.pending.add(request.number)
        if isinstance(request, DrawFrame):
            self._frame = request
            if self._has_begun and self._waits_since_s is None:
                self._waits_since_s = time.monotonic()
        # A process that has gone is noticed by replies().
        with suppress(BrokenPipeError, ConnectionError):
            self._pipe.send(request)

    def replies(self) -> list[Reply]:
        """Give all replies that have come since the last call."""
        replies: list[Reply] = []
        try:
            while not self._pipe.closed and self._pipe.poll():
                reply = self._pipe.recv()
                if isinstance(reply, Begun):
                    self._has_begun = True
                    newest = self._frame is None or self._frame.number <= reply.number
                    self._waits_since_s = None if newest else time.monotonic()
                    continue
                if not isinstance(reply, Progressed | SkyWaits):
                    # Frames before it were superseded.
                    number = reply.frame.number if isinstance(reply, Placed) else reply.number
                    self.pending = {n for n in self.pending if n > number}
                if isinstance(reply, Placed):
                    self._stuck_s = _STUCK_S[0]
                    try:
                        rgb = self._frames.take(reply.slot, reply.memory, reply.size_px)
                    except FileNotFoundError:
                        continue  # a later frame has taken its place, and comes
                    reply = replace(reply.frame, rgb=rgb)
                replies.append(reply)
        except (EOFError, ConnectionError):
            lost = sorted(self.pending) or [0]
            self._end()
            message = "the renderer's process ended; the next change starts it again"
            replies += [Failed(number, "defect", message) for number in lost]
        return replies

    def revive(self) -> bool:
        """Replace the process if the last frame has waited too long; give whether it was.

        Some work takes minutes without looking at requests. Each process that is given up doubles
        the time that the next one has, until a frame is drawn.
        """
        since, frame = self._waits_since_s, self._frame
        if since is None or frame is None or time.monotonic() - since < self._stuck_s:
            return False
        self._stuck_s = min(2.0 * self._stuck_s, _STUCK_S[1])
        self._let_go()
        # The window must not wait for its end.
        threading.Thread(target=_see_off, args=(self._process,)).start()
        self._start()
        self.send(frame)
        return True

    def wait(self, seconds: float) -> bool:
        """Wait for a reply; give whether one came."""
        return not self._pipe.closed and self._pipe.poll(seconds)

    def _end(self) -> None:
        self._let_go()
        _see_off(self._process)

    def _let_go(self) -> None:
        self.pending.clear()
        self._pipe.close()
        self._frames.close()

    def close(self) -> None:
        """End the process; a second call does nothing."""
        atexit.unregister(self.close)
        if not self._pipe.closed:
            self._end()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _see_off(process: BaseProcess) -> None:
    """Wait until a process whose pipe is closed ends, and stop it if it does not."""
    # It ends by itself, and releases the memory.
    process.join(2.0 * LAST_WORDS_S)
    for stop in (process.terminate, process.kill):
        if process.is_alive():
            stop()
            process.join(LAST_WORDS_S)
