"""The process that renders for the window, so that no rebuild ever stops the window.

Compiling a shader and building tables take a second and hold Python's lock meanwhile: a thread
would freeze the window, a process of its own does not. Frames come back through shared memory.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.shared_memory import SharedMemory
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from rtbow.arrays import Array, Float32, Progress
from rtbow.errors import RtbowError

if TYPE_CHECKING:
    from rtbow.context import Backend
    from rtbow.renderer import Method, Renderer
    from rtbow.scene import Scene

_NICE = 10
"""So that the window comes first where cores are few: with 5, llvmpipe's threads still kept it, and
the X server, waiting for some tenths of a second."""
_BUFFERS = 3
"""Frames in shared memory: one shown, one on its way, one being written."""
_LEAST_BYTES = 1 << 16
"""Of a frame's memory."""
_LAST_WORDS_S = 2.0
"""In which a process may end by itself."""
_STUCK_S = (5.0, 60.0)
"""How long a frame may wait for what the process is at, at first and at most."""
_REST_S = 0.3
"""Without requests, after which the renderer prepares for moves."""
_GAP_S = 0.05
"""Between two reports of progress."""
_EXPOSURE_STRIDE = 3
"""Of the pixels whose brightness sets the automatic exposure of a live frame."""


@dataclass(frozen=True)
class DrawFrame:
    """Draw a frame to look at; of several that wait the last alone is drawn."""

    number: int
    scene: Scene
    method: Method


@dataclass(frozen=True)
class SaveFrame:
    """Render a frame and write it to files."""

    number: int
    scene: Scene
    method: Method
    paths: tuple[str, ...]
    exposure_ev: float | None
    command: str


@dataclass(frozen=True)
class TakeSpectrum:
    """Compute the spectral radiance along one direction by the reference; the last that waits."""

    number: int
    scene: Scene
    direction: tuple[float, float, float]


@dataclass(frozen=True)
class Reload:
    """Forget programs and tables: shaders or files have changed. It has no reply."""

    number: int


Request = DrawFrame | SaveFrame | TakeSpectrum | Reload


@dataclass(frozen=True)
class FrameDrawn:
    """A frame is done.

    Attributes:
        number: of its request.
        scene: what it shows.
        rgb: linear Rec. 709 in cd/m², float32 (h, w, 3), first row on top.
        seconds: that it took, with all rebuilding.
        exposure_ev: automatic exposure.
        method: that drew it.
        unsuited: why ``auto`` did not take ``fast``; empty where it did.
        renderer: the device.
    """

    number: int
    scene: Scene
    rgb: Float32
    seconds: float
    exposure_ev: float
    method: str
    unsuited: str
    renderer: str


@dataclass(frozen=True)
class FrameSaved:
    """Files are written."""

    number: int
    paths: tuple[str, ...]


@dataclass(frozen=True)
class SpectrumTaken:
    """Spectral radiance (W), W/(m² sr nm), at wavelengths (W), nm."""

    number: int
    wavelength_nm: Array
    radiance: Array


@dataclass(frozen=True)
class Progressed:
    """How far a request is, 0 to 1, and what is being done."""

    number: int
    share: float
    what: str


@dataclass(frozen=True)
class Failed:
    """A request could not be done; ``kind`` says whose fault that is. Number 0 is of no request."""

    number: int
    kind: Literal["input", "machine", "defect"]
    message: str


Reply = FrameDrawn | FrameSaved | SpectrumTaken | Progressed | Failed


@dataclass(frozen=True)
class _Placed:
    """A frame in shared memory, as it travels; its slot holds no other memory any more."""

    frame: FrameDrawn
    slot: int
    memory: str
    size_px: tuple[int, int]


@dataclass(frozen=True)
class _Begun:
    """A frame is being drawn now."""

    number: int


class SupersededError(Exception):
    """A newer frame was asked for while one was being drawn."""


class _GoneError(Exception):
    """The window has gone."""


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
        self._memories: dict[int, SharedMemory] = {}
        self.pending: set[int] = set()
        self._frame: DrawFrame | None = None
        self._stuck_s = _STUCK_S[0]
        self._start()
        # Python waits for processes when it ends, and this one for its pipe.
        atexit.register(self.close)

    def _start(self) -> None:
        self._has_begun = False
        self._waits_since_s: float | None = None
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        # No daemon: those may not have processes of their own, which build Lorenz-Mie tables.
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
        """The process's number."""
        return self._process.pid

    def next_number(self) -> int:
        """Give a number for a request."""
        self._number += 1
        return self._number

    def send(self, request: Request) -> None:
        """Hand a request over; replies come by :meth:`replies`."""
        if self._pipe.closed:
            self._start()
        if not isinstance(request, Reload):
            self.pending.add(request.number)
        if isinstance(request, DrawFrame):
            self._frame = request
            if self._has_begun and self._waits_since_s is None:
                self._waits_since_s = time.monotonic()
        # If the process has gone, replies() tells.
        with suppress(BrokenPipeError, ConnectionError):
            self._pipe.send(request)

    def replies(self) -> list[Reply]:
        """Give all replies that have come since."""
        found: list[Reply] = []
        try:
            while not self._pipe.closed and self._pipe.poll():
                reply = self._pipe.recv()
                if isinstance(reply, _Begun):
                    self._has_begun = True
                    newest = self._frame is None or self._frame.number <= reply.number
                    self._waits_since_s = None if newest else time.monotonic()
                    continue
                if not isinstance(reply, Progressed):
                    # Frames before it were superseded.
                    number = reply.frame.number if isinstance(reply, _Placed) else reply.number
                    self.pending = {n for n in self.pending if n > number}
                if isinstance(reply, _Placed):
                    self._stuck_s = _STUCK_S[0]
                    try:
                        reply = self._placed(reply)
                    except FileNotFoundError:
                        continue  # its memory is used by a later frame, which comes
                found.append(reply)
        except (EOFError, ConnectionError):
            lost = sorted(self.pending) or [0]
            self._end()
            message = "the renderer's process ended; the next change starts it again"
            found += [Failed(number, "defect", message) for number in lost]
        return found

    def revive(self) -> bool:
        """Start the process anew if the last frame has waited for long; give whether it had to.

        Not all that takes minutes looks at requests meanwhile. Each process that is given up leaves
        the next one twice the time, until a frame is drawn.
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
        """Wait for a reply, and tell whether one came."""
        return not self._pipe.closed and self._pipe.poll(seconds)

    def _placed(self, reply: _Placed) -> FrameDrawn:
        memory = self._memories.get(reply.slot)
        if memory is None or memory.name != reply.memory:
            if memory is not None:
                self._memories.pop(reply.slot).close()
            memory = self._memories[reply.slot] = SharedMemory(reply.memory)
        width, height = reply.size_px
        # A copy: later frames are written there, and NumPy does not keep the memory mapped.
        rgb = np.ndarray((height, width, 3), np.float32, memory.buf).copy()
        return replace(reply.frame, rgb=rgb)

    def _end(self) -> None:
        self._let_go()
        _see_off(self._process)

    def _let_go(self) -> None:
        self.pending.clear()
        self._pipe.close()
        for memory in self._memories.values():
            memory.close()
        self._memories.clear()

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
    """Wait for the end of a process whose pipe is closed, and see to it."""
    # It ends by itself, and releases the memory.
    process.join(2.0 * _LAST_WORDS_S)
    for stop in (process.terminate, process.kill):
        if process.is_alive():
            stop()
            process.join(_LAST_WORDS_S)


@dataclass
class _Ring:
    """Frames in shared memory, written in turn; a slot's memory grows by powers of two."""

    memories: list[SharedMemory | None] = field(default_factory=lambda: [None] * _BUFFERS)
    turn: int = 0

    def put(self, rgb: Float32) -> tuple[int, str]:
        """Copy a frame; give its slot and the name of its memory."""
        self.turn = (self.turn + 1) % _BUFFERS
        memory = self.memories[self.turn]
        if memory is None or memory.size < rgb.nbytes:
            self._free(self.turn)
            size = 1 << max(rgb.nbytes - 1, _LEAST_BYTES - 1).bit_length()
            memory = self.memories[self.turn] = SharedMemory(create=True, size=size)
        np.ndarray(rgb.shape, np.float32, memory.buf)[:] = rgb
        return self.turn, memory.name

    def free(self) -> None:
        """Release all."""
        for slot in range(_BUFFERS):
            self._free(slot)

    def _free(self, slot: int) -> None:
        memory, self.memories[slot] = self.memories[slot], None
        if memory is not None:
            memory.close()
            memory.unlink()


class _Server:
    """The process's side."""

    def __init__(self, pipe: Connection, backend: Backend) -> None:
        self._pipe, self._backend = pipe, backend
        self._coming: SimpleQueue[Request | None] = SimpleQueue()
        self._waiting: list[Request] = []
        self._ring = _Ring()
        self._renderer: Renderer | None = None
        self._reported = 0.0
        self._resting = False

    def listen(self) -> None:
        """Take requests out of the pipe, so that the window never waits, and see the window go."""
        try:
            while True:
                self._coming.put(self._pipe.recv())
        except (EOFError, OSError):
            self._coming.put(None)
        # What is being done may not look at requests for minutes.
        time.sleep(_LAST_WORDS_S)
        with suppress(Exception):
            self._ring.free()
        os._exit(1)

    def serve(self) -> None:
        """Do what is asked for until the window goes."""
        try:
            while True:
                if not self._waiting:
                    self._rest()
                self._receive()
                request = self._waiting.pop(0)
                try:
                    self._do(request)
                except SupersededError:
                    continue
                except _GoneError:
                    break
                except RtbowError as error:
                    kind = {2: "input", 3: "machine"}.get(error.exit_code, "defect")
                    self._pipe.send(Failed(request.number, kind, str(error)))  # type: ignore[arg-type]
                except Exception:
                    self._pipe.send(Failed(request.number, "defect", traceback.format_exc()))
        except (_GoneError, BrokenPipeError, ConnectionError):
            pass
        finally:
            self._close()

    def _rest(self) -> None:
        """Wait for a request, and prepare for moves if none comes at once."""
        try:
            self._take(self._coming.get(timeout=_REST_S))
        except Empty:
            self._prepare_moves()
            self._take(self._coming.get())

    def _prepare_moves(self) -> None:
        """Make the tables that moves of camera and light take, before somebody waits for them."""
        if self._renderer is None or not self._resting:
            return
        self._resting = False
        try:
            self._renderer.prepare_moves()
        except RtbowError:
            pass  # it will be said when it is asked for
        except Exception:
            self._pipe.send(Failed(0, "defect", traceback.format_exc()))

    def _receive(self) -> None:
        """Take over what has come."""
        with suppress(Empty):
            while True:
                self._take(self._coming.get_nowait())

    def _take(self, request: Request | None) -> None:
        """Take over a request; a newer frame or spectrum replaces one that waits."""
        if request is None:
            raise _GoneError
        if isinstance(request, DrawFrame | TakeSpectrum):
            self._waiting = [r for r in self._waiting if type(r) is not type(request)]
        self._waiting.append(request)

    def _do(self, request: Request) -> None:
        if isinstance(request, DrawFrame):
            self._draw(request)
        elif isinstance(request, SaveFrame):
            self._save(request)
        elif isinstance(request, TakeSpectrum):
            self._take_spectrum(request)
        else:
            self._close_renderer()

    def _draw(self, request: DrawFrame) -> None:
        from rtbow.display import auto_exposure_ev

        self._pipe.send(_Begun(request.number))
        begun = time.perf_counter()
        renderer = self._shown(request.scene)
        rgb = renderer.render(
            request.method,
            self._progress(request, "rendering"),
            self._progress(request, "building the table"),
        )
        frame = FrameDrawn(
            request.number, request.scene, np.empty((0, 0, 3), np.float32),
            time.perf_counter() - begun,
            auto_exposure_ev(rgb[::_EXPOSURE_STRIDE, ::_EXPOSURE_STRIDE]),
            renderer.method_used, renderer.unsuited, renderer.gl_renderer,
        )  # fmt: skip
        size_px = rgb.shape[1], rgb.shape[0]
        self._pipe.send(_Placed(frame, *self._ring.put(rgb), size_px))
        self._resting = True

    def _shown(self, scene: Scene) -> Renderer:
        from rtbow.renderer import Renderer  # slow to import: the process answers before

        if self._renderer is None:
            self._renderer = Renderer(scene, self._backend)
        else:
            self._renderer.show(scene)
        return self._renderer

    def _save(self, request: SaveFrame) -> None:
        from rtbow.files import check_writable
        from rtbow.image import FRAME_SUFFIXES, frame_metadata, write_frame
        from rtbow.renderer import Renderer

        for path in request.paths:
            check_writable(path, FRAME_SUFFIXES)
        # A new one, as of a command: tables for moves differ in their last digits.
        with Renderer(request.scene, self._backend) as renderer:
            rgb = renderer.render(
                request.method,
                self._progress(request, "rendering", until_newer=False),
                self._progress(request, "building the table", until_newer=False),
            )
            metadata = frame_metadata(
                request.scene, request.command, renderer.method_used, renderer.gl_renderer
            )
        for path in request.paths:
            write_frame(path, rgb, metadata, request.exposure_ev)
        self._pipe.send(FrameSaved(request.number, request.paths))

    def _take_spectrum(self, request: TakeSpectrum) -> None:
        from rtbow.view.readout import spectrum_at

        wavelength_nm, radiance = spectrum_at(request.scene, np.array(request.direction))
        self._pipe.send(SpectrumTaken(request.number, wavelength_nm, radiance))

    def _progress(self, request: Request, what: str, *, until_newer: bool = True) -> Progress:
        """Give a wrapper of loops that reports how far they are, and ends them if superseded."""

        def wrap(items: Any) -> Iterator[Any]:
            listed = list(items)
            for done, item in enumerate(listed):
                yield item
                now = time.perf_counter()
                if now - self._reported < _GAP_S:
                    continue
                self._reported = now
                self._receive()
                if until_newer and any(isinstance(r, DrawFrame) for r in self._waiting):
                    raise SupersededError
                self._pipe.send(Progressed(request.number, (done + 1) / len(listed), what))

        return wrap

    def _close_renderer(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None
        from rtbow.spectrum import load_spectrum

        load_spectrum.cache_clear()

    def _close(self) -> None:
        self._close_renderer()
        self._ring.free()


def serve(pipe: Connection, backend: Backend) -> None:
    """Run the process until the other end of the pipe goes."""
    # Ctrl-C on the terminal reaches both processes; the window decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Asked to end, it releases its memory first.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    if hasattr(os, "nice"):
        os.nice(_NICE)
    server = _Server(pipe, backend)
    threading.Thread(target=server.listen, daemon=True).start()
    server.serve()
