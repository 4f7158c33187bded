"""Sequences: frames of one scene while some of its keys move, as numbered files and as films.

A frame that an earlier run made from the same scene, files, method and version is kept, so that an
interrupted run goes on where it stopped (:mod:`rtbow.sequence.record`). A film is always written
anew, from the frames where they are kept; what is missing is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.base.errors import UnsuitedError
from rtbow.base.version import __version__
from rtbow.frames.display import BLACK_FRAME_EV, auto_exposure_ev, display
from rtbow.frames.film import DEFAULT_FPS, Film, check_fps, film_at
from rtbow.frames.image import frame_metadata, read_exr, read_png, write_exr, write_png
from rtbow.render.renderer import MethodName, Renderer
from rtbow.scene.text.values import scene_files
from rtbow.sequence.animation import Animation
from rtbow.sequence.outputs import SEQUENCE_TEXT, Outputs, Pattern, check_places
from rtbow.sequence.record import Record, content_digest, digest, open_records
from rtbow.world.visibility import horizon_notes

if TYPE_CHECKING:
    from rtbow.gl.context import Backend

Show = Callable[[str, str], Progress]
"""Gives, for a label and a unit, the wrapper of a loop that shows its progress."""


# --- Drawing -----------------------------------------------------------------------------------


class _Frame(NamedTuple):
    """Radiance (h, w, 3) in cd/m², and the method and the device that drew it."""

    rgb: Float32
    method: str
    renderer: str


@dataclass
class Report:
    """What a run did.

    Attributes:
        drawn: how many frames were drawn.
        kept: how many had files that were kept, or were made from such files.
        methods: the methods that drew, in the order of their first frames.
        notes: what of the scene is not drawn as it stands.
    """

    drawn: int = 0
    kept: int = 0
    methods: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def no_show(label: str, unit: str) -> Progress:
    """Show nothing."""
    return no_progress


def animate(
    animation: Animation,
    outputs: Outputs,
    *,
    method: MethodName = "auto",
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
        overwrite: whether files of these names are replaced that no sequence made.
        command: what the user typed, to be stored in each file.
        show: shows the progress.

    Raises:
        InputError: something cannot be drawn or written; what is finished stays.
        UnavailableError: no GL backend works here, or no encoder.
    """
    check_fps(fps)
    check_places(outputs, animation.count, overwrite=overwrite)
    with (
        open_records(outputs.records) as records,
        _Drawing(animation, method, backend, show) as drawing,
    ):
        run = _Run(animation, outputs, records, drawing, command)
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
    run.report.methods, run.report.notes = drawing.methods, drawing.notes
    return run.report


class _Drawing:
    """Draws frames of an animation on one renderer, opened for the first of them."""

    def __init__(
        self, animation: Animation, method: MethodName, backend: Backend, show: Show
    ) -> None:
        self.method: MethodName = method
        self.methods: list[str] = []
        self.notes: list[str] = []
        self._animation, self._backend, self._show = animation, backend, show
        self._renderer: Renderer | None = None
        self._serves_all = animation.count > 1 and animation.keeps_tables

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._renderer is not None:
            self._renderer.close()

    def draw(self, number: int) -> _Frame:
        """Draw a frame."""
        scene = self._animation.at(number)
        if self._renderer is None:
            widest = self._animation.widest if self._serves_all else None
            first = scene if widest is None else self._animation.at(widest)
            self._renderer = Renderer(first, self._backend)
            rgb = self._render(self._renderer)
            if self._prepared(self._renderer) or first is not scene:
                self._renderer.show(scene)
                rgb = self._render(self._renderer)
        else:
            self._renderer.show(scene)
            rgb = self._render(self._renderer)
        used = self._renderer.method_used
        if used not in self.methods:
            self.methods.append(used)
        known = (
            *self.notes,
            *horizon_notes(scene),
        )  # the latter by Animation.notes, for all frames
        self.notes += [note for note in self._renderer.notes if note not in known]
        return _Frame(rgb, used, self._renderer.gl_renderer)

    def _prepared(self, renderer: Renderer) -> bool:
        """Whether tables for all places were made, where frames are drawn by them.

        They differ from those for one place by the method's error: without this the first frame of
        each run would differ from the others by as much.
        """
        if not self._serves_all or renderer.method_used != "fast":
            return False
        with suppress(UnsuitedError):  # perhaps of places that no frame has
            renderer.prepare_moves()
        return True

    def _render(self, renderer: Renderer) -> Float32:
        slow = self.method in ("spectral", "reference")
        rows = self._show("rendering", "row") if slow else no_progress
        return renderer.render(self.method, rows, self._show("building the table", "part"))


class _Run:
    """Makes the files of one run: keeps what its records list, draws and writes the rest."""

    def __init__(
        self,
        animation: Animation,
        outputs: Outputs,
        records: Mapping[str, Record],
        drawing: _Drawing,
        command: str,
    ) -> None:
        self.report = Report()
        self._animation, self._drawing, self._command = animation, drawing, command
        self._patterns, self._records = outputs.frames, records
        self._judged: dict[int, _Frame] = {}
        # Drawing says what is wrong with a file that cannot be read.
        self._inputs = digest(*map(content_digest, scene_files(animation.scene)))
        self._ev: float | None = None

    # --- Exposure

    def choose_exposure(self, asked: float | None, progress: Progress) -> None:
        """Choose one exposure for all pictures: with one each, a film would flicker."""
        self._ev = asked
        if asked is not None:
            return
        last = self._animation.count - 1
        judged = sorted({0, (last + 1) // 2, last})
        made_of = self._made_of(*judged)
        known = (record.exposure_ev(made_of) for record in self._records.values())
        self._ev = next((ev for ev in known if ev is not None), None)
        if self._ev is None:
            for number in progress(judged):
                self._judged[number] = self._frame(number, self._kept(number, ".exr"))
            self._ev = sequence_exposure_ev([frame.rgb for frame in self._judged.values()])
        for record in self._records.values():
            record.set_exposure(made_of, self._ev)

    # --- Frames

    def make(self, number: int, films: Sequence[Film]) -> None:
        """Write the files of a frame that are missing, and add it to the films."""
        frames, pictures = self._kept(number, ".exr"), self._kept(number, ".png")
        missing = [one for one in self._patterns if one not in frames + pictures]
        frame, picture = self._judged.pop(number, None), None
        if not missing and (pictures or not films):
            frame = None  # is not needed
        elif frame is None:
            frame = self._frame(number, frames)
        if frame is None or frames:
            self.report.kept += 1
        else:
            self.report.drawn += 1
        if pictures:
            picture = read_png(pictures[0].path(number))[0]
        elif frame is not None and self._ev is not None:
            picture = display(frame.rgb, self._ev)
        for pattern in missing:
            assert frame is not None
            self._write(pattern, number, frame, picture)
        for film in films:
            assert picture is not None
            film.add(picture)

    def _frame(self, number: int, kept: Sequence[Pattern]) -> _Frame:
        """Read a frame from the first of its files that are kept, or draw it."""
        if not kept:
            return self._drawing.draw(number)
        rgb, texts = read_exr(kept[0].path(number))
        return _Frame(rgb, texts["method"], texts["renderer"])

    def _write(
        self, pattern: Pattern, number: int, frame: _Frame, picture: NDArray[np.uint8] | None
    ) -> None:
        path, shown = pattern.path(number), pattern.suffix == ".png"
        ev = self._ev if shown else None
        again = self._animation.render_command(number, frame.method, path, ev)
        scene = self._animation.at(number)
        texts = frame_metadata(scene, again, frame.method, frame.renderer)
        texts[SEQUENCE_TEXT] = self._command
        if shown:
            assert picture is not None
            write_png(path, picture, {**texts, "exposureEV100": f"{ev:.6g}"})
        else:
            write_exr(path, frame.rgb, texts, whole_sphere=scene.camera.whole_sphere)
        self._records[pattern.record].add(path, self._made_of(number, ev=ev))

    def film_metadata(self) -> dict[str, str]:
        """Give the strings that say how a film was made."""
        texts = frame_metadata(self._animation.scene, self._command, self._drawing.method, "")
        del texts["renderer"]  # none is open yet
        return {**texts, "exposureEV100": f"{self._ev:.6g}"}

    # --- Earlier runs

    def _kept(self, number: int, suffix: str) -> list[Pattern]:
        """List the patterns of which an earlier run has left this frame."""
        made_of = self._made_of(number, ev=self._ev if suffix == ".png" else None)
        return [
            one
            for one in self._patterns
            if one.suffix == suffix and self._records[one.record].has(one.path(number), made_of)
        ]

    def _made_of(self, *numbers: int, ev: float | None = None) -> str:
        """Give a digest of all that frames depend on, or pictures at an exposure."""
        scenes = [self._animation.at(number).source_text for number in numbers]
        exposure = "" if ev is None else f"{ev:.6g}"
        return digest(*scenes, self._drawing.method, __version__, self._inputs, exposure)


def sequence_exposure_ev(frames: Iterable[Float32]) -> float:
    """Give one exposure for several frames: that of the brightest, so that none is overexposed.

    Args:
        frames: linear Rec. 709 in cd/m², each (h, w, 3); black ones do not count.

    Returns:
        Exposure value for ISO 100, rounded to the six digits that pictures state.
    """
    lit = [auto_exposure_ev(rgb) for rgb in frames if np.any(rgb > 0.0)]
    return float(f"{max(lit, default=BLACK_FRAME_EV):.6g}")
