"""Renders scenes: the fragment shader on a GL context, or the reference on the CPU."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from os import PathLike, fspath
from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self, get_args
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Progress, no_progress
from rtbow.base.errors import (
    InputError,
    RtbowError,
    UnavailableError,
    UnsuitedError,
    require_one_of,
)
from rtbow.frames.display import require_finite
from rtbow.gl.context import Backend
from rtbow.gl.process import Lock
from rtbow.scene.model import Scene
from rtbow.scene.text.errors import shown

if TYPE_CHECKING:
    from rtbow.frames.bows.measured import FrameMeasures
    from rtbow.gl.context import GlContext
    from rtbow.render.fast.method import FastMethod
    from rtbow.render.method import Method
    from rtbow.render.sky.wanted import Skies
    from rtbow.world.world import World

MethodName = Literal["auto", "fast", "spectral", "reference"]
METHODS: tuple[MethodName, ...] = get_args(MethodName)


@dataclass(frozen=True)
class _Last:
    """What is kept of the last frame, to say what it does not show once that is asked for."""

    worlds: tuple[World, ...]
    columns: tuple[slice, ...]
    black: tuple[bool, ...]

    @classmethod
    def of(cls, worlds: list[World], columns: list[slice], rgb: NDArray[np.float32]) -> _Last:
        from rtbow.frames.bows.reasons import is_black

        return cls(tuple(worlds), tuple(columns), tuple(is_black(rgb[:, c]) for c in columns))

    @cached_property
    def unseen(self) -> tuple[str, ...]:
        from rtbow.frames.bows.reasons import reasons

        return reasons(self.worlds, self.columns, self.black)


CPU_RENDERER = "CPU, float64"
"""The reference's name among devices."""


class Renderer:
    """Renders one scene; keeps its GL context and textures until :meth:`close`.

    Usable as a context manager. The GL context is opened when a method first needs it, so that
    ``reference`` runs where there is no GL. Several threads may share a renderer, which draws for
    one at a time, or have one each. A process forked from one that has drawn can draw with another
    backend than that one, or is told to be started otherwise.

    Args:
        scene: what to render.
        backend: ``auto``, ``egl``, ``osmesa`` or ``window``.
        skies: makes the skies, as beside the pictures of a window; left out: each when it is drawn.

    Raises:
        InputError: ``scene`` is no :class:`rtbow.Scene`, or the backend is not known.

    Attributes:
        method_used: what drew the last frame, where ``auto`` was asked for too.
        unsuited: why ``auto`` left this scene to ``spectral`` or ``reference``; empty where it
            did not.

    Example:
        >>> with rtbow.Renderer(rtbow.load_scene("uniform")) as renderer:
        ...     rgb = renderer.render()
    """

    def __init__(
        self, scene: Scene, backend: Backend = "auto", *, skies: Skies | None = None
    ) -> None:
        self.scene = _scene(scene)
        self.method_used: MethodName = "auto"
        self.unsuited = ""
        self._last: _Last | None = None
        self._skies = skies
        self._backend = require_one_of("backend", backend, get_args(Backend))
        self._lock = Lock()
        self._context: GlContext | None = None
        self._worlds: list[World] = []
        self._methods: dict[MethodName, list[Method]] = {}
        self._closed = False

    @property
    def gl_renderer(self) -> str:
        """What made the last frame: the GL device and driver, or the CPU."""
        if self._context is None or self.method_used == "reference":
            return CPU_RENDERER
        return self._context.renderer

    @property
    def backend(self) -> str:
        """The backend in use; ``none`` before a method needed one."""
        return self._context.backend if self._context else "none"

    @property
    def notes(self) -> tuple[str, ...]:
        """What of the scene is not drawn as it stands, in words, such as sizes that are left out.

        So are suns below the horizon, and bows of suns too high for them.

        Raises:
            InputError: a spectrum, volume or file of drop sizes is not usable.
        """
        from rtbow.world.visibility import horizon_notes

        notes = (note for world in self._resolved() for note in world.notes)
        return tuple(dict.fromkeys((*notes, *horizon_notes(self.scene))))

    @property
    def unseen(self) -> tuple[str, ...]:
        """Why the last frame shows no bow, or nothing at all, and what would change that.

        A line for each reason; empty where a bow is in view, before the first frame and once the
        renderer is closed.
        """
        return () if self._last is None else self._last.unseen

    def render(
        self,
        method: MethodName = "auto",
        progress: Progress = no_progress,
        building: Progress = no_progress,
    ) -> NDArray[np.float32]:
        """Render a frame.

        Args:
            method: ``fast``, ``spectral``, ``reference``, or ``auto``: ``fast`` wherever it keeps
                the scene's ``render.max_delta_e``, else ``spectral``, and ``reference`` for what no
                shader can draw.
            progress: wraps the loop over the picture's rows, to show how far it is.
            building: wraps the loop over parts of an exact table that has to be built first.

        Returns:
            Linear Rec. 709, D65, in cd/m², float32 (h, w, 3), first row on top. Negative
            components are colours outside of the gamut.

        Raises:
            InputError: unknown method, a hook that is no function, or a spectrum or volume that
                is not usable.
            UnavailableError: no GL backend works here, or the memory does not suffice.
            RtbowError: the renderer is closed.
        """
        _require_callable("progress", progress)
        _require_callable("building", building)
        with self._in_turn(), _memory_errors():
            self._check(method)
            if method == "reference":
                frame = self._render_reference(progress, building)
            elif method == "auto":
                frame = self._render_somehow(progress, building)
            else:
                frame = self._render_shader(method, progress, building)
            self._last = _Last.of(self._resolved(), self._columns, frame)
        # Before anything clamps: a maximum of NaN and 0 is 0 on some drivers.
        require_finite(frame)
        return frame

    def measured(self, rgb: NDArray[np.float32], *, fringes: bool = True) -> FrameMeasures:
        """Measure a frame of the scene: its luminance, and radius, width, contrast of each bow.

        Before a sky or a ground bows are measured in the drops' own light, which is drawn for it.

        Args:
            rgb: what :meth:`render` gave.
            fringes: whether supernumeraries are measured, which takes longer.

        Raises:
            InputError: the frame has another size than the scene's pictures, or a spectrum or
                volume is not usable.
        """
        from rtbow.frames.bows.measured import measured

        width, height = self.scene.camera.size_px
        if np.shape(rgb) != (height, width, 3):
            raise InputError(
                f"the frame's shape is {np.shape(rgb)}; must be ({height}, {width}, 3), as the"
                " scene's pictures are"
            )
        with self._in_turn():
            drops = self._drops_alone()
            return measured(self._resolved(), self._columns, rgb, drops, fringes=fringes)

    def _drops_alone(self) -> NDArray[np.float32] | None:
        """Draw the last frame without its sky and ground, where it had any; None if no shader drew
        it."""
        from rtbow.render.sky.surrounded import Surrounded
        from rtbow.render.wide_pixels import unwrapped

        for name, methods in self._methods.items():
            around = [part for part in map(unwrapped, methods) if isinstance(part, Surrounded)]
            if not around or methods[0].name != self.method_used:
                continue
            for part in around:
                part.bare = True
            try:
                return self._render_shader(name, no_progress, no_progress)
            finally:
                for part in around:
                    part.bare = False
        return None

    def _resolved(self) -> list[World]:
        """The worlds of the picture's parts, resolved when they are first needed."""
        if not self._worlds:
            from rtbow.world.world import resolve

            self._worlds = [resolve(scene) for scene, _ in self.scene.parts()]
        return self._worlds

    @property
    def _columns(self) -> list[slice]:
        """The columns of the picture that each part fills."""
        return [columns for _, columns in self.scene.parts()]

    def _render_somehow(self, progress: Progress, building: Progress) -> NDArray[np.float32]:
        """Render by a shader, or by the reference what no shader can draw."""
        try:
            return self._render_shader("auto", progress, building)
        except UnsuitedError as error:
            self.unsuited = str(error)
        return self._render_reference(progress, building)

    def _render_reference(self, progress: Progress, building: Progress) -> NDArray[np.float32]:
        from rtbow.reference.render import render_reference

        self.method_used = "reference"
        parts = [
            render_reference(world, progress, columns, building)
            for world, columns in zip(self._resolved(), self._columns, strict=True)
        ]
        return np.concatenate(parts, axis=1).astype(np.float32)

    def draw(self, method: MethodName = "auto") -> None:
        """Draw a frame on the GL device and wait until it is done, without reading it: to time it.

        Args:
            method: of the shader's; the first call makes textures and programs.

        Raises:
            InputError, UnavailableError, RtbowError: as :meth:`render`.
        """
        with self._in_turn(), _memory_errors():
            self._draw(method)

    def _draw(self, method: MethodName) -> None:
        self._check(method)
        if method == "reference":
            raise InputError("method 'reference' needs no GL device; use render()")
        with self._device(method, no_progress) as methods:
            for part, columns in zip(methods, self._columns, strict=True):
                part.draw(no_progress, columns)

    def show(self, scene: Scene, *, roughly: bool = False) -> None:
        """Render another scene from the next frame on.

        Where only camera and lights have moved, method ``fast`` keeps its tables and programs; in
        haze only ``roughly``, else it makes those anew that hold what haze leaves of the light.

        Args:
            scene: what to render.
            roughly: whether drops may be dimmed by haze as they were before the move.

        Raises:
            InputError, UnavailableError, RtbowError: as :meth:`render`; the scene stays as it was.
        """
        with self._in_turn(), _memory_errors():
            self._require_open()
            self._show(_scene(scene), roughly=roughly)

    def _show(self, scene: Scene, *, roughly: bool) -> None:
        worlds = self._moved_worlds(scene)
        if self._context is not None:
            self._keep_haze(roughly)
            with self._translated(scene), self._context.current():
                self._methods = self._moved_methods(worlds)  # the others go as the context is left
        self._worlds, self.scene = worlds, scene
        if "auto" not in self._methods:
            self.unsuited = ""

    def _fast_methods(self) -> list[FastMethod]:
        """Give the methods ``fast`` in use, whatever draws around them."""
        from rtbow.render.fast.method import FastMethod
        from rtbow.render.sky.surrounded import Surrounded
        from rtbow.render.wide_pixels import unwrapped

        parts = [unwrapped(part) for parts in self._methods.values() for part in parts]
        inner = [part.drops if isinstance(part, Surrounded) else part for part in parts]
        return [part for part in inner if isinstance(part, FastMethod)]

    def _keep_haze(self, keeps: bool) -> None:
        """Tell methods ``fast`` so; no name holds on to them where they are replaced."""
        for method in self._fast_methods():
            method.keeps_haze = keeps

    @property
    def is_rough(self) -> bool:
        """Whether the drops of the last frame are dimmed by haze as before a move."""
        return any(method.has_former_haze for method in self._fast_methods())

    def _moved_methods(self, worlds: list[World]) -> dict[MethodName, list[Method]]:
        """Give the methods that could follow to other worlds; none where there are none."""
        kept: dict[MethodName, list[Method]] = {}
        for name, methods in self._methods.items() if worlds else ():
            # A method that cannot draw them is made anew when it is next asked for, and says why.
            with suppress(UnsuitedError):
                if all(map(_move, methods, worlds)):
                    kept[name] = methods
        return kept

    def _moved_worlds(self, scene: Scene) -> list[World]:
        """Give the worlds of a scene whose camera and lights moved; none if it differs in more."""
        from rtbow.world.world import moved

        parts = [part for part, _ in scene.parts()]
        if len(parts) != len(self._worlds):
            return []
        worlds = [moved(world, part) for world, part in zip(self._worlds, parts, strict=True)]
        same_kind = [world for world in worlds if world is not None]
        return same_kind if len(same_kind) == len(worlds) else []

    def prepare_moves(self) -> None:
        """Make what :meth:`show` of other places needs, before somebody waits for it.

        Raises:
            InputError, UnavailableError, RtbowError: as :meth:`render`.
        """
        with self._in_turn(), _memory_errors():
            if self._context is None:
                return
            with self._translated(self.scene), self._context.current():
                for methods in self._methods.values():
                    for method in methods:
                        method.prepare_moves()

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures of all methods used so far."""
        return sum(part.texture_bytes for parts in self._methods.values() for part in parts)

    @contextmanager
    def _in_turn(self) -> Iterator[None]:
        """Wait until no other thread uses the renderer, and keep others waiting meanwhile."""
        with self._lock:
            if self._context is not None and self._context.inherited:
                self._methods, self._context = {}, None
            yield

    def _require_open(self) -> None:
        if self._closed:
            raise RtbowError("this Renderer is closed; make another")

    def _check(self, method: MethodName) -> None:
        self._require_open()
        require_one_of("method", method, METHODS)

    def _render_shader(
        self, method: MethodName, progress: Progress, building: Progress
    ) -> NDArray[np.float32]:
        with self._device(method, building) as methods:
            drawn = [
                part.render(progress, columns)
                for part, columns in zip(methods, self._columns, strict=True)
            ]
            return np.concatenate(drawn, axis=1)

    @contextmanager
    def _device(self, method: MethodName, building: Progress) -> Iterator[list[Method]]:
        """Make the GL context current and give a method for each part, made when first asked for.

        The device's own errors become ours.
        """
        from rtbow.gl.context import abandon, open_context

        if self._context is None:
            self._context = open_context(self._backend)
            self._abandon = finalize(self, abandon, self._context)
            self._abandon.atexit = False  # the process's end frees all there is
        with self._translated(self.scene), self._context.current():
            if method not in self._methods:
                self._methods[method] = self._make_methods(self._context, method, building)
            methods = self._methods[method]
            self.method_used = methods[0].name
            yield methods

    @contextmanager
    def _translated(self, scene: Scene) -> Iterator[None]:
        """Turn the device's own errors into ours."""
        import moderngl

        try:
            yield
        except moderngl.Error as error:
            width, height = scene.camera.size_px
            raise UnavailableError(
                f"this GL device ({self.gl_renderer}) cannot hold {width} x {height} pixels"
                f" or the volume ({error}); render smaller, use a coarser volume, or render with"
                " --method reference"
            ) from error

    def _make_methods(
        self, context: GlContext, method: MethodName, building: Progress
    ) -> list[Method]:
        worlds = self._resolved()
        # Imported when used: each brings modules that the other does not need.
        from rtbow.render.sky.surrounded import with_surroundings
        from rtbow.render.wide_pixels import in_parts, whole

        def around(made: Method, world: World) -> Method:
            drawn = with_surroundings(context, made, in_parts(world), building, self._skies)
            if world.scatters_again or world.skylight:
                from rtbow.render.glow.glowing import with_glow

                drawn = with_glow(context, drawn, in_parts(world), building)
            return whole(drawn, world)

        if method != "spectral":
            from rtbow.render.fast.method import FastMethod

            frugal = method == "auto"
            try:
                return [
                    around(FastMethod(context, in_parts(world), building, frugal=frugal), world)
                    for world in worlds
                ]
            except UnsuitedError as error:
                if method == "fast":
                    raise
                self.unsuited = str(error)
            context.collect()  # before another method takes as much memory again
            worlds = [_sharp(world) for world in worlds]
        from rtbow.render.spectral.method import SpectralMethod

        return [
            around(SpectralMethod(context, in_parts(world), building), world) for world in worlds
        ]

    def close(self) -> None:
        """Release the GL context and all that lives on it; a second call does nothing.

        From another thread it waits for the frame that is being drawn.
        """
        with self._in_turn():
            self._closed = True
            self._methods, self._worlds, self._last = {}, [], None
            if self._context is not None:
                self._abandon.detach()
                self._context.close()
                self._context = None

    def __getstate__(self) -> object:
        raise InputError(
            "a Renderer cannot be copied or sent to another process; send its scene, which can, and"
            " make a Renderer there"
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _scene(scene: object) -> Scene:
    if not isinstance(scene, Scene):
        named = shown(fspath(scene)) if isinstance(scene, str | PathLike) else "NAME_OR_PATH"
        raise InputError(
            f"scene is of type {type(scene).__name__}; must be a Scene; make one with"
            f" rtbow.load_scene({named})"
        )
    return scene


def _require_callable(name: str, hook: object) -> None:
    if not callable(hook):
        raise InputError(
            f"{name} is of type {type(hook).__name__}; must be a function that takes the rows and"
            " yields them, such as tqdm; leave it out to show nothing"
        )


@contextmanager
def _memory_errors() -> Iterator[None]:
    try:
        yield
    except MemoryError as error:
        raise UnavailableError(
            "not enough memory; render smaller or use a coarser volume"
        ) from error


def _move(method: Method, world: World) -> bool:
    return method.move(world)


def _sharp(world: World) -> World:
    """Give a world with a step of wavelengths that follows its fringes, itself if its own does."""
    from rtbow.render.fineness import sharp_step_nm
    from rtbow.world.world import with_step

    step_nm = sharp_step_nm(world)
    return world if step_nm == world.fineness.wavelength_step_nm else with_step(world, step_nm)
