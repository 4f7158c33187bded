"""Renders scenes: the fragment shader on a GL context, or the reference on the CPU."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from rtbow.arrays import Progress, no_progress
from rtbow.display import require_finite
from rtbow.errors import InputError, RtbowError, UnavailableError
from rtbow.scene import Scene

if TYPE_CHECKING:
    from rtbow.context import Backend, GlContext
    from rtbow.spectral import SpectralPass

Method = Literal["auto", "spectral", "reference"]
METHODS: tuple[Method, ...] = get_args(Method)


CPU_RENDERER = "CPU, float64"


class Renderer:
    """Renders one scene; keeps its GL context and textures until :meth:`close`.

    Usable as a context manager. The GL context is opened when a method first needs it, so that
    ``reference`` runs where there is no GL.

    Args:
        scene: what to render.
        backend: ``auto``, ``egl``, ``osmesa`` or ``window``.

    Example:
        >>> with rtbow.Renderer(rtbow.load_scene("uniform")) as renderer:
        ...     rgb = renderer.render()
    """

    def __init__(self, scene: Scene, backend: Backend = "auto") -> None:
        self.scene = scene
        self.method_used: Method = "auto"
        self._backend = backend
        self._context: GlContext | None = None
        self._passes: list[SpectralPass] = []
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

    def render(
        self,
        method: Method = "auto",
        progress: Progress = no_progress,
        building: Progress = no_progress,
    ) -> NDArray[np.float32]:
        """Render a frame.

        Args:
            method: ``auto`` (``spectral``), ``spectral`` or ``reference``.
            progress: wraps the loop over the picture's rows, to show how far it is.
            building: wraps the loop over parts of an exact table that has to be built first.

        Returns:
            Linear Rec. 709, D65, in cd/m², float32 (h, w, 3), first row on top. Negative
            components are colours outside of the gamut.

        Raises:
            InputError: unknown method, or a spectrum or volume that is not usable.
            UnavailableError: no GL backend works here, or the memory does not suffice.
            RtbowError: the renderer is closed.
        """
        if self._closed:
            raise RtbowError("this Renderer is closed; make another")
        if method not in METHODS:
            raise InputError(f"method {method!r} is not known; must be one of {', '.join(METHODS)}")
        if method == "auto":
            method = "spectral"
        self.method_used = method
        try:
            if method == "reference":
                frame = self._render_reference(progress, building)
            else:
                frame = self._render_spectral(progress, building)
        except MemoryError as error:
            raise UnavailableError(
                "not enough memory; render smaller or use a coarser volume"
            ) from error
        # Before anything clamps: a maximum of NaN and 0 is 0 on some drivers.
        require_finite(frame)
        return frame

    def _render_reference(self, progress: Progress, building: Progress) -> NDArray[np.float32]:
        from rtbow.reference import render_reference

        parts = [
            render_reference(scene, progress, columns, building)
            for scene, columns in self.scene.parts()
        ]
        return np.concatenate(parts, axis=1).astype(np.float32)

    def _render_spectral(self, progress: Progress, building: Progress) -> NDArray[np.float32]:
        import moderngl

        from rtbow.context import open_context
        from rtbow.spectral import SpectralPass

        if self._context is None:
            self._context = open_context(self._backend)
        try:
            with self._context.current():
                parts = self.scene.parts()
                if not self._passes:
                    self._passes = [
                        SpectralPass(self._context, scene, building) for scene, _ in parts
                    ]
                drawn = [
                    one.render(progress, columns)
                    for one, (_, columns) in zip(self._passes, parts, strict=True)
                ]
                return np.concatenate(drawn, axis=1)
        except moderngl.Error as error:
            width, height = self.scene.camera.size_px
            raise UnavailableError(
                f"this GL device ({self._context.renderer}) cannot hold {width} x {height} pixels"
                f" or the volume ({error}); render smaller, use a coarser volume, or render with"
                " --method reference"
            ) from error

    def close(self) -> None:
        """Release the GL context and all that lives on it; a second call does nothing."""
        self._closed = True
        self._passes = []
        if self._context is not None:
            self._context.close()
            self._context = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
