"""The renderer's process: requests in, frames out, the newest first."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

import numpy as np

from rtbow.base.arrays import Progress, labelled
from rtbow.base.errors import RtbowError
from rtbow.view.document.messages import (
    Begun,
    DrawFrame,
    Failed,
    FrameDrawn,
    FrameSaved,
    Placed,
    Progressed,
    Request,
    SaveFrame,
    SkyWaits,
    SpectrumTaken,
    TakeSpectrum,
)
from rtbow.view.worker.frame_memory import FrameRing

if TYPE_CHECKING:
    from rtbow.gl.context import Backend
    from rtbow.render.renderer import Renderer
    from rtbow.scene.model import Scene
    from rtbow.view.document.messages import Reply
    from rtbow.view.worker.skies import BesideSkies, Waiting

LAST_WORDS_S = 2.0
"""Time that a process has to end by itself."""
_NICE = 10
"""Puts the window first where cores are few: at 5, llvmpipe's threads still delayed it and the X
server by some tenths of a second."""
_REST_S = 0.3
"""Time without requests after which the renderer prepares for moves."""
_FORMER_HAZE = "haze before the drops as under the former sun for now"
_GAP_S = 0.05
"""Shortest time between two reports of progress."""
_EXPOSURE_STRIDE = 3
"""The automatic exposure of a live frame counts every third pixel of every third row."""


class SupersededError(Exception):
    """A newer frame was asked for while one was being drawn."""


class _GoneError(Exception):
    """The window has gone."""


class Server:
    """The process's side."""

    def __init__(self, pipe: Connection, backend: Backend) -> None:
        self._pipe, self._backend = pipe, backend
        self._coming: SimpleQueue[Request | None] = SimpleQueue()
        self._waiting: list[Request] = []
        self._ring = FrameRing()
        self._renderer: Renderer | None = None
        self._skies: BesideSkies | None = None
        self._sending = threading.Lock()
        self._reported = 0.0
        self._places: object = None
        self._resting = False

    def listen(self) -> None:
        """Receive requests so that the window never waits; end the process when the window goes."""
        try:
            while True:
                self._coming.put(self._pipe.recv())
        except (EOFError, OSError):
            self._coming.put(None)
        # The work under way may not look at requests for minutes.
        time.sleep(LAST_WORDS_S)
        with suppress(Exception):
            self._ring.free()
        os._exit(1)

    def serve(self) -> None:
        """Handle requests until the window goes."""
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
                    self._send(Failed(request.number, kind, str(error)))  # type: ignore[arg-type]
                except Exception:
                    self._send(Failed(request.number, "defect", traceback.format_exc()))
        except (_GoneError, BrokenPipeError, ConnectionError):
            pass
        finally:
            self._close()

    def _send(self, reply: Reply | Begun | Placed) -> None:
        """Send a reply; the thread that makes skies sends some, too."""
        with self._sending:
            self._pipe.send(reply)

    def _rest(self) -> None:
        """Wait for a request, and prepare for moves if none comes at once."""
        try:
            self._take(self._coming.get(timeout=_REST_S))
        except Empty:
            self._prepare_moves()
            self._take(self._coming.get())

    def _prepare_moves(self) -> None:
        """Make the tables that moves of camera and light need, before anybody waits for them."""
        if self._renderer is None or not self._resting:
            return
        self._resting = False
        if self._skies is not None:
            self._skies.ahead()
        if self._renderer.is_rough:
            self._send(SkyWaits(0, None, "", True))
            return
        try:
            self._renderer.prepare_moves()
        except RtbowError:
            pass  # reported once such a frame is asked for
        except Exception:
            self._send(Failed(0, "defect", traceback.format_exc()))

    def _receive(self) -> None:
        """Queue all requests that have come."""
        with suppress(Empty):
            while True:
                self._take(self._coming.get_nowait())

    def _take(self, request: Request | None) -> None:
        """Queue a request; a newer frame or spectrum replaces one that waits."""
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
        from rtbow.frames.display import auto_exposure_ev

        self._send(Begun(request.number))
        begun = time.perf_counter()
        # The next picture of the same places, once they rest, is exact.
        places = request.scene.light, request.scene.camera.position_m
        renderer = self._shown(request.scene, roughly=places != self._places)
        self._places = places
        rgb = renderer.render(
            request.method,
            self._progress(request, "rendering"),
            self._progress(request, "building the table"),
        )
        if self._skies is not None:
            self._skies.end()
        behind = "" if self._skies is None else self._skies.behind
        if renderer.method_used == "reference":
            behind = ""
        elif renderer.is_rough:
            behind = behind or _FORMER_HAZE
        frame = FrameDrawn(
            request.number, request.scene, np.empty((0, 0, 3), np.float32),
            time.perf_counter() - begun,
            auto_exposure_ev(rgb[::_EXPOSURE_STRIDE, ::_EXPOSURE_STRIDE]),
            renderer.method_used, renderer.unsuited, renderer.gl_renderer,
            (*renderer.notes, *renderer.unseen),
            behind,
        )  # fmt: skip
        size_px = rgb.shape[1], rgb.shape[0]
        self._send(Placed(frame, *self._ring.put(rgb), size_px))
        self._resting = True

    def _shown(self, scene: Scene, *, roughly: bool) -> Renderer:
        from rtbow.render.renderer import Renderer  # slow to import: the process answers before

        if self._skies is None and any(part.has_surroundings for part, _ in scene.parts()):
            from rtbow.view.worker.skies import BesideSkies

            self._skies = BesideSkies(self._tell_of_sky)
            self._close_renderer()  # it makes its skies itself
        if self._skies is not None:
            self._skies.begin()
        if self._renderer is None:
            self._renderer = Renderer(scene, self._backend, skies=self._skies)
        else:
            self._renderer.show(scene, roughly=roughly)
        return self._renderer

    def _tell_of_sky(self, waiting: Waiting | None) -> None:
        """Tell the window how far a sky is, or that it is there."""
        done = waiting is None
        share, what = (None, "") if waiting is None else (waiting.share, waiting.what)
        with suppress(OSError):  # the window has gone
            self._send(SkyWaits(0, share, what, done))

    def _save(self, request: SaveFrame) -> None:
        from rtbow.base.files import check_writable
        from rtbow.frames.image import FRAME_SUFFIXES, frame_metadata, write_frame
        from rtbow.render.renderer import Renderer

        for path in request.paths:
            check_writable(path, FRAME_SUFFIXES)
        # A renderer of its own, as rtbow render has: tables for moves differ in the last digits.
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
        self._send(FrameSaved(request.number, request.paths))

    def _take_spectrum(self, request: TakeSpectrum) -> None:
        from rtbow.view.picture.readout import spectrum_at

        wavelength_nm, radiance = spectrum_at(request.scene, np.array(request.direction))
        self._send(SpectrumTaken(request.number, wavelength_nm, radiance))

    def _progress(self, request: Request, what: str, *, until_newer: bool = True) -> Progress:
        """Wrap loops so that they report progress, and end once they are superseded."""

        def wrap(items: Any) -> Iterator[Any]:
            listed, label = list(items), labelled(what, items)
            for done, item in enumerate(listed):
                yield item
                now = time.perf_counter()
                if now - self._reported < _GAP_S:
                    continue
                self._reported = now
                self._receive()
                if until_newer and any(isinstance(r, DrawFrame) for r in self._waiting):
                    raise SupersededError
                self._send(Progressed(request.number, (done + 1) / len(listed), label))

        return wrap

    def _close_renderer(self) -> None:
        if self._renderer is not None:
            self._renderer.close()
        self._renderer = None

    def _close(self) -> None:
        if self._skies is not None:
            self._skies.close()
        self._close_renderer()
        self._ring.free()


def serve(pipe: Connection, backend: Backend) -> None:
    """Run the process until the other end of the pipe goes."""
    # Ctrl-C in the terminal reaches both processes; the window decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # On SIGTERM it releases its memory before it ends.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    if hasattr(os, "nice"):
        os.nice(_NICE)
    server = Server(pipe, backend)
    threading.Thread(target=server.listen, daemon=True).start()
    server.serve()
