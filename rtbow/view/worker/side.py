"""Work that must not delay the picture: frames to save and spectra, in a second process."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from rtbow.base.errors import RtbowError
from rtbow.scene.text.values import scene_text
from rtbow.view.document.messages import (
    Failed,
    FrameSaved,
    Progressed,
    Reload,
    Reply,
    SaveFrame,
    SpectrumTaken,
    TakeSpectrum,
    failure_of,
)
from rtbow.view.document.names import free_name
from rtbow.view.worker.handle import Worker

if TYPE_CHECKING:
    from rtbow.gl.context import Backend
    from rtbow.scene.model import Scene
    from rtbow.view.document.state import ViewState

_PROGRESS = "aside"
_PATIENCE_S = 0.1


class SideJobs:
    """The second process, which the first request starts.

    Args:
        state: shows the results.
        backend: how the process gets a GL context.
    """

    def __init__(self, state: ViewState, backend: Backend = "auto") -> None:
        self._state, self._backend = state, backend
        self._worker: Worker | None = None
        self._saving: dict[int, tuple[str, ...]] = {}
        self._spectrum_asked = 0

    @property
    def busy(self) -> bool:
        """Whether any request is not yet done."""
        return self._worker is not None and self._worker.busy

    @property
    def saving(self) -> set[str]:
        """Absolute paths of the files that are being written."""
        return set(chain.from_iterable(self._saving.values()))

    def _process(self) -> Worker:
        if self._worker is None:
            self._worker = Worker(self._backend)
        return self._worker

    def take_spectrum(self, scene: Scene, direction: tuple[float, float, float]) -> int:
        """Have the spectrum along a direction computed by the reference; give the request's number.

        The result becomes the state's ``spectrum``, or its ``spectrum_problem``.
        """
        worker = self._process()
        self._state.spectrum, self._state.spectrum_problem = None, ""
        number = self._spectrum_asked = worker.next_number()
        worker.send(TakeSpectrum(number, scene, direction))
        return number

    def save_frame(
        self,
        scene: Scene,
        paths: tuple[str, ...],
        command: Callable[[tuple[str, ...]], str],
    ) -> None:
        """Render at the scene's own size and write .exr and .png.

        Where one of the files is still being written, the frame gets another name beside it.

        Args:
            scene: to render.
            paths: of the files, one for each format.
            command: gives the command line that makes these files, which is stored in them.
        """
        taken = self.saving
        if any(os.path.abspath(path) in taken for path in paths):
            first, suffixes = Path(paths[0]), [Path(path).suffix for path in paths]
            free = free_name(first.stem, suffixes, first.parent, taken)
            paths = tuple(str(first.with_name(free + suffix)) for suffix in suffixes)
        worker = self._process()
        number = worker.next_number()
        whole = self._saving[number] = tuple(os.path.abspath(path) for path in paths)
        state, own = self._state, scene.with_source(scene_text(scene), "scene")
        worker.send(SaveFrame(number, own, state.method, whole, state.exposure_ev, command(paths)))
        state.notify(f"rendering {', '.join(paths)}")

    def reload(self) -> None:
        """Have shaders and tables made anew after files have changed."""
        if self._worker is not None:
            self._worker.send(Reload(self._worker.next_number()))

    def hear(self) -> None:
        """Handle all replies that have come since the last call."""
        for reply in self._worker.replies() if self._worker is not None else ():
            self.take(reply)
            self._state.wake()

    def take(self, reply: Reply) -> None:
        """Handle one reply of the process."""
        state = self._state
        if isinstance(reply, Progressed):
            state.show_progress(_PROGRESS, (reply.share, reply.what))
            return
        state.show_progress(_PROGRESS, None)
        if isinstance(reply, FrameSaved):
            self._saving.pop(reply.number, None)
            state.notify(f"saved {_names(reply.paths)}")
        elif isinstance(reply, SpectrumTaken):
            state.spectrum = reply.wavelength_nm, reply.radiance
            state.spectrum_number = reply.number
        elif isinstance(reply, Failed):
            saving = self._saving.pop(reply.number, None)
            if saving is None and reply.number == self._spectrum_asked:
                state.spectrum_problem = reply.message
            elif saving is not None or reply.number == 0:
                state.notify(reply.message, "error")

    def finish(self, say: Callable[[str], object]) -> None:
        """Wait for what is being saved.

        Args:
            say: shows the user a line: what is being waited for, and how that ended.

        Raises:
            RtbowError: it could not be saved.
        """
        if self._worker is None or not self._saving:
            return
        say(f"saving {_names(sorted(self.saving))}; Ctrl-C gives it up")
        failure: RtbowError | None = None
        while self._saving:
            self._worker.wait(_PATIENCE_S)
            for reply in self._worker.replies():
                if isinstance(reply, FrameSaved):
                    say(f"saved {_names(self._saving.pop(reply.number, ()))}")
                elif isinstance(reply, Failed) and self._saving.pop(reply.number, ()):
                    failure = failure_of(reply)
        if failure is not None:
            raise failure

    def close(self) -> None:
        """End the process; unfinished work is given up."""
        if self._worker is not None:
            self._worker.close()


def _names(paths: Iterable[str]) -> str:
    """Give paths as they are seen from the current folder."""
    return ", ".join(os.path.relpath(path) for path in paths)
