"""Sequences: frames of one scene while some of its keys move, as files that stay and as a film.

A file of an earlier run stays where its own texts say that it was made from the same scene, files,
method and version; so an interrupted run goes on where it was. Other frames of earlier runs are
replaced, files of any other origin only if that is asked for. A film is made anew from its first
picture to its last, of files where they are there: without them all of it is drawn again.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.base.cache import file_digest
from rtbow.base.errors import InputError, UnsuitedError
from rtbow.base.version import __version__
from rtbow.frames.display import (
    BLACK_FRAME_EV,
    EV_LIMIT,
    auto_exposure_ev,
    display,
)
from rtbow.frames.film import (
    DEFAULT_FPS,
    Film,
    check_fps,
    film_at,
)
from rtbow.frames.image import (
    frame_metadata,
    png_texts,
    read_exr,
    read_png,
    write_exr,
    write_png,
)
from rtbow.render.renderer import Method, Renderer
from rtbow.scene.model import Scene
from rtbow.scene.text.values import scene_files
from rtbow.sequence.animation import Animation
from rtbow.sequence.outputs import (
    SEQUENCE_TEXT,
    Outputs,
    Pattern,
    check_places,
)

if TYPE_CHECKING:
    from rtbow.gl.context import Backend

Show = Callable[[str, str], Progress]
"""Gives, for a label and a unit, the wrapper of a loop that shows how far it is."""


# --- Drawing -----------------------------------------------------------------------------------


class _Frame(NamedTuple):
    """Radiance, and what drew it."""

    rgb: Float32
    method: str
    renderer: str


@dataclass
class Report:
    """What a run did.

    Attributes:
        drawn: frames that were drawn.
        kept: frames whose files stayed, or were made from others that stayed.
        methods: that drew, in order.
    """

    drawn: int = 0
    kept: int = 0
    methods: list[str] = field(default_factory=list)


def no_show(label: str, unit: str) -> Progress:
    """Show nothing."""
    return no_progress


def animate(
    animation: Animation,
    outputs: Outputs,
    *,
    method: Method = "auto",
    backend: Backend = "auto",
    exposure_ev: float | None = None,
    fps: float = DEFAULT_FPS,
    overwrite: bool = False,
    command: str = "rtbow animate",
    show: Show = no_show,
) -> Report:
    """Draw a sequence.

    Args:
        animation: what is drawn.
        outputs: where to.
        method: see :meth:`rtbow.Renderer.render`.
        backend: how to get a GL context.
        exposure_ev: exposure value (ISO 100) of all pictures; None chooses one for all of them:
            that of the brightest of the first, the middle and the last frame.
        fps: pictures a second of films.
        overwrite: whether files of those names that no sequence left there are replaced.
        command: what the user typed, to be told in each file.
        show: shows how far it is.

    Raises:
        InputError: something cannot be drawn or written; what is finished stays.
        UnavailableError: no GL backend works here, or no encoder.
    """
    check_fps(fps)
    check_places(outputs, animation.count, overwrite=overwrite)
    with _Drawing(animation, method, backend, show) as drawing:
        run = _Run(animation, outputs, drawing, command)
        if outputs.shown:
            run.choose_exposure(exposure_ev, show("choosing an exposure", "frame"))
        with ExitStack() as stack:
            size_px = animation.scene.camera.size_px
            films = [
                stack.enter_context(film_at(path, size_px, fps, run.film_metadata()))
                for path in outputs.films
            ]
            for number in show("animating", "frame")(range(animation.count)):
                run.make(number, films)
    run.report.methods = drawing.methods
    return run.report


class _Drawing:
    """Draws frames of an animation on one renderer, opened when the first is asked for."""

    def __init__(self, animation: Animation, method: Method, backend: Backend, show: Show) -> None:
        self.method: Method = method
        self.methods: list[str] = []
        self._animation, self._backend, self._show = animation, backend, show
        self._renderer: Renderer | None = None
        self._settled = animation.count == 1 or not animation.only_places

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._renderer is not None:
            self._renderer.close()

    def draw(self, number: int) -> _Frame:
        """Draw a frame."""
        scene = self._animation.at(number)
        if self._renderer is None:
            self._renderer = Renderer(scene, self._backend)
        else:
            self._renderer.show(scene)
        rgb = self._render(self._renderer)
        if not self._settled and self._renderer.method_used == "fast":
            # Tables for all places differ from those for one by the method's error: without this
            # the first frame of each run would differ from the others by as much.
            with suppress(UnsuitedError):  # of places that no frame may have
                self._renderer.prepare_moves()
            rgb = self._render(self._renderer)
            self._settled = True
        used = self._renderer.method_used
        if used not in self.methods:
            self.methods.append(used)
        return _Frame(rgb, used, self._renderer.gl_renderer)

    def _render(self, renderer: Renderer) -> Float32:
        slow = self.method in ("spectral", "reference")
        rows = self._show("rendering", "row") if slow else no_progress
        return renderer.render(self.method, rows, self._show("building the table", "part"))


class _Run:
    """What one run keeps, draws and writes."""

    def __init__(
        self, animation: Animation, outputs: Outputs, drawing: _Drawing, command: str
    ) -> None:
        self.report = Report()
        self._animation, self._drawing, self._command = animation, drawing, command
        self._frames = [one for one in outputs.frames if one.suffix == ".exr"]
        self._pictures = [one for one in outputs.frames if one.suffix == ".png"]
        self._ahead: dict[int, _Frame] = {}
        self._inputs = _digest_of_files(animation.scene)
        self._ev: float | None = None
        self._exposed_by = ""

    # --- Exposure

    def choose_exposure(self, asked: float | None, progress: Progress) -> None:
        """Choose one exposure for all pictures: with one each, a film would flicker."""
        self._ev = asked
        if asked is not None:
            return
        last = self._animation.count - 1
        judged = sorted({0, (last + 1) // 2, last})
        texts = [self._animation.at(number).source_text for number in judged]
        self._exposed_by = _digest(*texts, self._drawing.method, __version__, self._inputs)
        self._ev = self._exposure_of_earlier_run()
        if self._ev is None:
            for number in progress(judged):
                self._ahead[number] = self._stored_frame(number) or self._drawing.draw(number)
            self._ev = sequence_exposure_ev([self._ahead[number].rgb for number in judged])

    def _exposure_of_earlier_run(self) -> float | None:
        """Give what the same frames led to before, as a picture tells."""
        for pattern in self._pictures:
            for number in range(self._animation.count):
                said = png_texts(pattern.path(number))
                if said.get("exposedBy") == self._exposed_by:
                    return _number_in(said.get("exposureEV100", ""))
        return None

    # --- Frames

    def make(self, number: int, films: Sequence[Film]) -> None:
        """Write a frame's files that are not there, and add it to the films."""
        frames = {one: self._stored_rgb(one.path(number), number) for one in self._frames}
        pictures = {one: self._stored_picture(one.path(number), number) for one in self._pictures}
        missing = [one for one, stored in {**frames, **pictures}.items() if stored is None]
        frame = next((one for one in frames.values() if one is not None), None)
        picture = next((one for one in pictures.values() if one is not None), None)
        ahead = self._ahead.pop(number, None)
        if frame is None and (missing or (films and picture is None)):
            frame = ahead or self._drawing.draw(number)
            self.report.drawn += 1
        else:
            self.report.kept += 1
        if picture is None and frame is not None and self._ev is not None:
            picture = display(frame.rgb, self._ev)
        for pattern in missing:
            assert frame is not None
            self._write(pattern, number, frame, picture)
        for film in films:
            assert picture is not None
            film.add(picture)

    def _write(
        self, pattern: Pattern, number: int, frame: _Frame, picture: NDArray[np.uint8] | None
    ) -> None:
        path, shown = pattern.path(number), pattern.suffix == ".png"
        again = self._animation.render_command(
            number, frame.method, path, self._ev if shown else None
        )
        scene = self._animation.at(number)
        said = {
            **frame_metadata(scene, again, frame.method, frame.renderer),
            **self._wanted(number, shown=shown),
            SEQUENCE_TEXT: self._command,
        }
        if shown:
            assert picture is not None
            if self._exposed_by:
                said["exposedBy"] = self._exposed_by
            write_png(path, picture, said)
        else:
            write_exr(path, frame.rgb, said)

    def film_metadata(self) -> dict[str, str]:
        """Give what a film says of itself."""
        assert self._ev is not None
        said = frame_metadata(self._animation.scene, self._command, self._drawing.method, "")
        del said["renderer"]  # none is open yet
        return {**said, "exposureEV100": f"{self._ev:.6g}"}

    # --- What is there

    def _wanted(self, number: int, *, shown: bool) -> dict[str, str]:
        """Give what a file of a frame must say of itself to be kept."""
        wanted = {
            "scene": self._animation.at(number).source_text,
            "rtbowVersion": __version__,
            "methodAsked": self._drawing.method,
        }
        if self._inputs:
            wanted["inputs"] = self._inputs
        if shown:
            assert self._ev is not None
            wanted["exposureEV100"] = f"{self._ev:.6g}"
        return wanted

    def _stored_frame(self, number: int) -> _Frame | None:
        found = (self._stored_rgb(one.path(number), number) for one in self._frames)
        return next((one for one in found if one is not None), None)

    def _stored_rgb(self, path: str, number: int) -> _Frame | None:
        """Give a frame's radiance from an earlier run; None if there is none that is whole."""
        try:
            rgb, said = read_exr(path)
        except InputError:
            return None
        if not self._fits(rgb.shape, said, self._wanted(number, shown=False)):
            return None
        return _Frame(rgb, said.get("method", ""), said.get("renderer", ""))

    def _stored_picture(self, path: str, number: int) -> NDArray[np.uint8] | None:
        """Give a frame's picture from an earlier run; None if there is none that is whole."""
        try:
            picture, said = read_png(path)
        except InputError:
            return None
        wanted = self._wanted(number, shown=True)
        return picture if self._fits(picture.shape, said, wanted) else None

    def _fits(
        self, shape: tuple[int, ...], said: Mapping[str, str], wanted: Mapping[str, str]
    ) -> bool:
        width, height = self._animation.scene.camera.size_px
        return shape[:2] == (height, width) and wanted.items() <= said.items()


def sequence_exposure_ev(frames: Iterable[Float32]) -> float:
    """Give one exposure for several frames: that of the brightest, so that none is overexposed.

    Args:
        frames: linear Rec. 709 in cd/m², each (h, w, 3); black ones do not count.

    Returns:
        Exposure value for ISO 100, with the six digits that pictures tell.
    """
    lit = [auto_exposure_ev(rgb) for rgb in frames if np.any(rgb > 0.0)]
    return float(f"{max(lit, default=BLACK_FRAME_EV):.6g}")


def _digest_of_files(scene: Scene) -> str:
    """Give a hash of what the files hold that a scene names; empty where it names none."""
    digests = []
    for path in scene_files(scene):
        try:
            digests.append(file_digest(Path(path)))
        except OSError:
            digests.append("")  # drawing says what is wrong with it
    return _digest(*digests) if digests else ""


def _digest(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode("utf-8", "surrogatepass")).hexdigest()[:16]


def _number_in(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) <= EV_LIMIT else None
