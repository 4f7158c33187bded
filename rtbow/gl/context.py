"""OpenGL 3.3 core contexts without a visible window, and what to do where none opens.

Three ways lead to a context: ``egl`` (no display needed, a GPU where there is one), ``window``
(a hidden GLFW window on a display) and ``osmesa`` (Mesa's off-screen library, CPU only). Contexts
of all three kinds live side by side in one process; :meth:`GlContext.current` switches between
them.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal, get_args
from weakref import WeakSet

from rtbow.base.errors import InputError, RtbowError, UnavailableError, require_one_of
from rtbow.gl.driver import BackendError, Driver, quiet_mesa
from rtbow.gl.egl import EGL_DEVICE_VARIABLE, open_egl
from rtbow.gl.osmesa import open_osmesa
from rtbow.gl.process import FORK_HELP, Lock, after_fork, left_a_gpu, note_opened, unusable
from rtbow.gl.window import foreign_window, open_window

# moderngl and glfw are imported where they are used: a verb without pictures must not wait.
if TYPE_CHECKING:
    from types import TracebackType

    import moderngl

Backend = Literal["auto", "egl", "osmesa", "window"]
BACKENDS = ("egl", "window", "osmesa")  # in the order in which "auto" tries them


@dataclass(frozen=True)
class Limits:
    """Largest sizes that a context takes, in texels or pixels along each axis."""

    texture_2d: int
    layers: int
    texture_3d: int
    viewport: tuple[int, int]


@dataclass(frozen=True)
class BackendReport:
    """What one backend offers here: renderer and version if ``ok``, else reason and help."""

    backend: str
    ok: bool
    renderer: str = ""
    version: str = ""
    reason: str = ""
    help: str = ""


class GlContext:
    """An OpenGL 3.3 core context; current on the calling thread only inside :meth:`current`.

    ``ctx`` is the moderngl context. Objects made with it are freed when the last reference to
    them is gone and the next :meth:`current` ends, so they need no release of their own. (Do not
    release a framebuffer that is bound: moderngl would bind it again, which is a GL error.)
    ``window`` is the GLFW handle of a ``window`` context, else None. ``inherited`` says that the
    context belongs to a process that this one was forked from, and is of no use here.
    """

    def __init__(self, backend: str, ctx: moderngl.Context, driver: Driver) -> None:
        self.backend = backend
        self.ctx = ctx
        self.inherited = False
        self.window: Any = getattr(driver, "window", None)
        self._driver = driver
        if ctx.fbo is None:
            # EGL brings no framebuffer, and moderngl rebinds the last one even if it is gone, which
            # is a GL error; with one that stays there is always one to go back to.
            ctx.framebuffer([ctx.renderbuffer((1, 1))]).use()
        self._resting_framebuffer = ctx.fbo
        info = ctx.info
        self.renderer = str(info["GL_RENDERER"])
        self.version = str(info["GL_VERSION"])
        width, height = info["GL_MAX_VIEWPORT_DIMS"]
        self.limits = Limits(
            texture_2d=int(info["GL_MAX_TEXTURE_SIZE"]),
            layers=int(info["GL_MAX_ARRAY_TEXTURE_LAYERS"]),
            texture_3d=int(info["GL_MAX_3D_TEXTURE_SIZE"]),
            viewport=(int(width), int(height)),
        )
        _contexts.add(self)

    @property
    def closed(self) -> bool:
        """Whether :meth:`close` has run."""
        return self._driver.closed

    @contextmanager
    def current(self) -> Iterator[moderngl.Context]:
        """Make this context current on this thread; afterwards the earlier one is current again.

        Nests, with the same or other contexts, and binds again the framebuffer bound before. An
        earlier context is one entered with this method or a GLFW window's; one that other code
        made current by other means is not seen. One thread at a time may use a context.

        Yields:
            The moderngl context.

        Raises:
            RtbowError: the context is closed.
            UnavailableError: it belongs to the process that this one was forked from.
        """
        if self.inherited:
            raise UnavailableError(f"this {self.backend} context {_FORKED}; {FORK_HELP}")
        if self.closed:
            raise RtbowError(f"the {self.backend} context is closed; open another")
        with _switched_to(self._driver):
            bound = self.ctx.fbo
            try:
                yield self.ctx
            finally:
                if not self.closed:
                    self._bind(bound)
                    _collect_garbage(self.ctx)

    def collect(self) -> None:
        """Free what nobody holds any more now, and not when :meth:`current` ends."""
        _collect_garbage(self.ctx)

    def _bind(self, framebuffer: moderngl.Framebuffer) -> None:
        if not hasattr(framebuffer.mglo, "use"):  # released by hand meanwhile
            framebuffer = self._resting_framebuffer
        if self.ctx.fbo is not framebuffer:
            framebuffer.use()

    def close(self) -> None:
        """Destroy the context and its window; a second call does nothing.

        Nor does it in a process forked from the one that opened it, which goes on using it.
        """
        if self.closed or self.inherited:
            return
        with _switched_to(None):
            self.ctx.objects.clear()  # they go with the context
            self.ctx.release()
            self._driver.destroy()
        self.window = None  # GLFW crashes on the handle of a window that is gone

    def __enter__(self) -> GlContext:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()


def open_context(backend: Backend = "auto", *, robust: bool = False) -> GlContext:
    """Open a context, which is not current yet.

    Args:
        backend: ``egl``, ``osmesa`` or ``window``; ``auto`` takes the first that opens of EGL, a
            window if there is a display, and OSMesa. For EGL the environment variable
            ``RTBOW_EGL_DEVICE`` chooses a device by index; else the first that works is taken.
        robust: ask for a window's context that reports a reset of the device, if the driver can.

    Raises:
        InputError: an unknown backend, or a wrong ``RTBOW_EGL_DEVICE``.
        UnavailableError: no context opens; says why and what helps. In a process forked from one
            that had opened a backend this one does not open, nor does ``auto`` draw on the CPU
            where that one was a GPU.
    """
    require_one_of("backend", backend, get_args(Backend))
    if backend == "auto" and left_a_gpu():
        raise UnavailableError(f"the GPU {_FORKED}; {FORK_HELP}")
    names = BACKENDS if backend == "auto" else (backend,)
    failures: list[BackendReport] = []
    for name in names:
        try:
            return _open(name, robust=robust)
        except BackendError as error:
            report = BackendReport(name, ok=False, reason=str(error), help=error.help)
            failures.append(report)
    if any(unusable(name) for name in names):  # that the others do not open is beside the point
        raise UnavailableError(f"the GL device {_FORKED}; {FORK_HELP}")
    raise UnavailableError(
        f"no OpenGL 3.3 core context here (backend {backend}):\n"
        + "\n".join(
            f"  {report.backend}: {report.reason}\n    {report.help}" for report in failures
        )
    )


def probe_backends() -> list[BackendReport]:
    """Try every backend, in the order of ``auto``; never raises for one that fails."""
    reports = []
    for name in BACKENDS:
        try:
            with _open(name) as gl:
                report = BackendReport(name, True, gl.renderer, gl.version)
        except BackendError as error:
            report = BackendReport(name, ok=False, reason=str(error), help=error.help)
        except InputError as error:
            help_text = f"correct or unset {EGL_DEVICE_VARIABLE}"
            report = BackendReport(name, ok=False, reason=str(error), help=help_text)
        reports.append(report)
    return reports


def _open(backend: str, *, robust: bool = False) -> GlContext:
    openers: dict[str, Callable[[], tuple[Driver, moderngl.Context]]] = {
        "egl": open_egl,
        "window": partial(open_window, robust=robust),
        "osmesa": open_osmesa,
    }
    if reason := unusable(backend):
        raise BackendError(reason, FORK_HELP)
    # Nothing else may be current meanwhile: a new context is made current by its maker. One at a
    # time, since opening changes what all threads share: environment, error callback, GLFW.
    with _opening, quiet_mesa(), _switched_to(None):
        _close_abandoned()
        driver, ctx = openers[backend]()
        try:
            ctx.gc_mode = "context_gc"  # "auto" would delete names in whatever context is current
            gl = GlContext(backend, ctx, driver)
            _clear_errors(ctx)  # asking for the limits asks for some that 3.3 does not know
        except BaseException:
            driver.detach()
            ctx.release()
            driver.destroy()
            raise
        driver.detach()
        note_opened(backend, gl.renderer)
    return gl


def abandon(context: GlContext) -> None:
    """Have a context closed when the next one opens: its owner is gone, in whatever thread and
    amid whatever call of GL Python collected it."""
    _abandoned.append(context)


def _close_abandoned() -> None:
    while _abandoned:
        _abandoned.popleft().close()


def _clear_errors(ctx: moderngl.Context) -> None:
    for _ in range(16):  # GL keeps one flag per kind of error, and a dead context never runs dry
        if ctx.error == "GL_NO_ERROR":
            return


def _collect_garbage(ctx: moderngl.Context) -> None:
    """Free dropped objects; ``ctx.gc`` stumbles over those that were released by hand."""
    while ctx.objects:
        release = getattr(ctx.objects.popleft(), "release", None)
        if release is not None:
            release()


_FORKED = "belongs to the process that this one was forked from and does not work here"
_opening = Lock()
_abandoned: deque[GlContext] = deque()
_contexts: WeakSet[GlContext] = WeakSet()
_left: list[GlContext] = []
"""Contexts of the parent: kept, since to free them would call a driver whose threads are gone."""


def _leave_to_parent() -> None:
    """In a forked process, touch nothing that the parent had opened or made current."""
    for context in _contexts:
        context.inherited = True
        _left.append(context)
    _thread.stack = []


after_fork(_leave_to_parent)


# --- what is current --------------------------------------------------------------------------


class _Thread(threading.local):
    def __init__(self) -> None:
        self.stack: list[Driver | None] = []


_thread = _Thread()


@contextmanager
def _switched_to(driver: Driver | None) -> Iterator[None]:
    """Make ``driver`` the current one (None: none), and then again what was current before.

    The earlier one is always detached first. EGL, GLX and OSMesa each keep their own record of
    what is current and skip a call that would change nothing in it, while Mesa's dispatch table
    underneath is common to all: without the detaching, a second EGL call after an OSMesa one
    would leave OSMesa current.
    """
    stack = _thread.stack
    previous = stack[-1] if stack else foreign_window()
    if driver is previous:
        stack.append(driver)
        try:
            yield
        finally:
            stack.pop()
        return
    if previous is not None:
        previous.detach()
    try:
        if driver is not None:
            driver.attach()
        stack.append(driver)
        try:
            yield
        finally:
            stack.pop()
            if driver is not None:
                driver.detach()
    finally:
        if previous is not None:
            previous.attach()
