"""OpenGL 3.3 core contexts without a visible window, and what to do where none opens.

Three ways lead to a context: ``egl`` (no display needed, a GPU where there is one), ``window``
(a hidden GLFW window on a display) and ``osmesa`` (Mesa's off-screen library, CPU only). Contexts
of all three kinds live side by side in one process; :meth:`GlContext.current` switches between
them.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_args

from rtbow.errors import InputError, RtbowError, UnavailableError

# moderngl and glfw are imported where they are used: a verb without pictures must not wait.
if TYPE_CHECKING:
    from types import TracebackType

    import moderngl

Backend = Literal["auto", "egl", "osmesa", "window"]
BACKENDS = ("egl", "window", "osmesa")  # in the order in which "auto" tries them
EGL_DEVICE_VARIABLE = "RTBOW_EGL_DEVICE"
GL_VERSION_CODE = 330

# Mesa prints its EGL warnings to stderr; the reasons stand in our own message instead.
_EGL_LOG_VARIABLE = "EGL_LOG_LEVEL"
# glcontext lets this variable win over the index it is called with.
_GLCONTEXT_DEVICE_VARIABLE = "GLCONTEXT_DEVICE_INDEX"
_OSMESA_LIBRARIES = ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
_WINDOW_SIZE_PX = (64, 64)


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


class _BackendError(UnavailableError):
    """Why a backend gives no context; ``help`` names the package or variable that would."""

    def __init__(self, reason: str, help_text: str) -> None:
        super().__init__(reason)
        self.help = help_text


class GlContext:
    """An OpenGL 3.3 core context; current on the calling thread only inside :meth:`current`.

    ``ctx`` is the moderngl context. Objects made with it are freed when the last reference to
    them is gone and the next :meth:`current` ends, so they need no release of their own. (Do not
    release a framebuffer that is bound: moderngl would bind it again, which is a GL error.)
    ``window`` is the GLFW handle of a ``window`` context, else None.
    """

    def __init__(self, backend: str, ctx: moderngl.Context, driver: _Driver) -> None:
        self.backend = backend
        self.ctx = ctx
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
        """
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

    def _bind(self, framebuffer: moderngl.Framebuffer) -> None:
        if not hasattr(framebuffer.mglo, "use"):  # released by hand meanwhile
            framebuffer = self._resting_framebuffer
        if self.ctx.fbo is not framebuffer:
            framebuffer.use()

    def close(self) -> None:
        """Destroy the context and its window; a second call does nothing."""
        if self.closed:
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


def open_context(backend: Backend = "auto") -> GlContext:
    """Open a context, which is not current yet.

    Args:
        backend: ``egl``, ``osmesa`` or ``window``; ``auto`` takes the first that opens of EGL, a
            window if there is a display, and OSMesa. For EGL the environment variable
            ``RTBOW_EGL_DEVICE`` chooses a device by index; else the first that works is taken.

    Raises:
        InputError: an unknown backend, or a wrong ``RTBOW_EGL_DEVICE``.
        UnavailableError: no context opens; says why and what helps.
    """
    if backend not in get_args(Backend):
        raise InputError(f"backend = {backend!r}; must be one of {', '.join(get_args(Backend))}")
    names = BACKENDS if backend == "auto" else (backend,)
    failures: list[BackendReport] = []
    for name in names:
        try:
            return _open(name)
        except _BackendError as error:
            report = BackendReport(name, ok=False, reason=str(error), help=error.help)
            failures.append(report)
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
        except _BackendError as error:
            report = BackendReport(name, ok=False, reason=str(error), help=error.help)
        except InputError as error:
            help_text = f"correct or unset {EGL_DEVICE_VARIABLE}"
            report = BackendReport(name, ok=False, reason=str(error), help=help_text)
        reports.append(report)
    return reports


def _open(backend: str) -> GlContext:
    opener = {"egl": _open_egl, "window": _open_window, "osmesa": _open_osmesa}[backend]
    # Nothing else may be current meanwhile: a new context is made current by its maker.
    with _switched_to(None):
        driver, ctx = opener()
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
    return gl


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


# --- what is current --------------------------------------------------------------------------


class _Driver(Protocol):
    """How a context becomes current; on a closed one, attach and detach do nothing."""

    closed: bool

    def attach(self) -> None: ...
    def detach(self) -> None: ...
    def destroy(self) -> None: ...


class _Thread(threading.local):
    def __init__(self) -> None:
        self.stack: list[_Driver | None] = []


_thread = _Thread()


@contextmanager
def _switched_to(driver: _Driver | None) -> Iterator[None]:
    """Make ``driver`` the current one (None: none), and then again what was current before.

    The earlier one is always detached first. EGL, GLX and OSMesa each keep their own record of
    what is current and skip a call that would change nothing in it, while Mesa's dispatch table
    underneath is common to all: without the detaching, a second EGL call after an OSMesa one
    would leave OSMesa current.
    """
    stack = _thread.stack
    previous = stack[-1] if stack else _foreign_window()
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


def _create(
    driver: _Driver, symbols: _SymbolLoader, failure_help: str
) -> tuple[_Driver, moderngl.Context]:
    """Hand a context that can be attached to moderngl."""
    try:
        driver.attach()
        return driver, _create_moderngl(context=symbols)
    except Exception as error:
        driver.detach()
        driver.destroy()
        if isinstance(error, _BackendError):
            raise
        raise _BackendError(str(error), failure_help) from error


def _create_moderngl(**settings: Any) -> moderngl.Context:
    import moderngl

    # moderngl hands its newest context to code that asks for "the" context; ours are not for that.
    store = getattr(moderngl, "_store", None)
    default = getattr(store, "default_context", None)
    try:
        return moderngl.create_context(require=GL_VERSION_CODE, **settings)
    finally:
        if store is not None:
            store.default_context = default


class _SymbolLoader:
    """What moderngl wants of a context that it did not make itself."""

    def __init__(self, driver: _OsmesaDriver | _WindowDriver) -> None:
        self._driver = driver

    def load_opengl_function(self, name: str) -> int:
        return self._driver.symbol(name)

    load = load_opengl_function

    def __enter__(self) -> None:
        self._driver.attach()

    def __exit__(self, *exc_info: object) -> None:
        self._driver.detach()

    def release(self) -> None:
        self._driver.destroy()


# --- EGL --------------------------------------------------------------------------------------

_EGL_PACKAGES = (
    "install libegl1 libgl1 libgl1-mesa-dri (Debian, Ubuntu) or the EGL of the GPU's vendor"
)
_EGL_NO_DEVICE = (
    "no EGL device can be used, as in a container without one: install libgl1-mesa-dri to draw on "
    "the CPU, or hand the GPU and its vendor's EGL into the container; "
    f"{_EGL_LOG_VARIABLE}=debug shows more"
)


class _EglDriver:
    def __init__(self, ctx: moderngl.Context) -> None:
        self.closed = False
        self._ctx = ctx

    def attach(self) -> None:
        if not self.closed:
            self._ctx.__enter__()  # type: ignore[no-untyped-call]

    def detach(self) -> None:
        if not self.closed:
            self._ctx.__exit__(None, None, None)  # type: ignore[no-untyped-call]

    def destroy(self) -> None:
        if not self.closed:
            self.closed = True
            self._ctx.release()


def _open_egl() -> tuple[_Driver, moderngl.Context]:
    chosen = _chosen_egl_device()
    reasons: list[str] = []
    index = 0 if chosen is None else chosen
    while True:
        try:
            ctx = _create_egl(index)
            return _EglDriver(ctx), ctx
        except Exception as error:  # moderngl raises bare Exception here
            reason = str(error)
        beyond = re.search(r"found (\d+) devices?", reason)
        if beyond is None:
            reasons.append(f"device {index}: {reason}")
            if chosen is not None or not reason.startswith("egl"):
                break  # what does not come from EGL fails alike on every device
            index += 1
            continue
        count = int(beyond.group(1))
        if chosen is not None and count > 0:
            raise InputError(
                f"{EGL_DEVICE_VARIABLE} = {chosen}; must be 0..{count - 1}, the EGL devices here; "
                "unset it to take the first that works"
            )
        if not reasons:
            raise _BackendError("EGL finds no device", f"{_EGL_PACKAGES}; {_EGL_NO_DEVICE}")
        break
    help_text = _EGL_NO_DEVICE if "0x3001" in reasons[0] else _EGL_PACKAGES
    if len(reasons) > 1 or chosen is not None:
        help_text += f"; {EGL_DEVICE_VARIABLE} chooses one of several devices by index"
    raise _BackendError("; ".join(reasons), help_text)


def _chosen_egl_device() -> int | None:
    text = os.environ.get(EGL_DEVICE_VARIABLE, "").strip()
    if not text:
        return None
    # ASCII digits alone: glcontext indexes an array with the number and checks no lower bound.
    if not re.fullmatch(r"[0-9]{1,4}", text):
        raise InputError(
            f"{EGL_DEVICE_VARIABLE} = {text!r}; must be the index of an EGL device: 0, 1, …; "
            "unset it to take the first that works"
        )
    return int(text)


def _create_egl(index: int) -> moderngl.Context:
    settings: dict[str, Any] = {"backend": "egl", "device_index": index}
    if sys.platform.startswith("linux"):
        # By soname: glcontext's own search runs a compiler or ldconfig for every context.
        settings |= {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
    index_override = os.environ.pop(_GLCONTEXT_DEVICE_VARIABLE, None)
    quiet = _EGL_LOG_VARIABLE not in os.environ
    if quiet:
        os.environ[_EGL_LOG_VARIABLE] = "fatal"
    try:
        return _create_moderngl(standalone=True, **settings)
    finally:
        if quiet:
            del os.environ[_EGL_LOG_VARIABLE]
        if index_override is not None:
            os.environ[_GLCONTEXT_DEVICE_VARIABLE] = index_override


# --- OSMesa -----------------------------------------------------------------------------------

_OSMESA_HELP = "install libosmesa6 (Debian, Ubuntu); Mesa from 25.1 on has no OSMesa: use egl there"

# GL/osmesa.h and GL/gl.h
_OSMESA_FORMAT, _OSMESA_DEPTH_BITS = 0x22, 0x30
_OSMESA_PROFILE, _OSMESA_CORE_PROFILE = 0x33, 0x34
_OSMESA_MAJOR_VERSION, _OSMESA_MINOR_VERSION = 0x36, 0x37
_GL_RGBA, _GL_UNSIGNED_BYTE = 0x1908, 0x1401


class _OsmesaDriver:
    """OSMesa called directly.

    GLFW makes OSMesa contexts too, but only one platform at a time, the null one or a display's,
    and it leaves OSMesa current when told to detach it.
    """

    def __init__(self, library: ctypes.CDLL) -> None:
        self.closed = False
        self._library = library
        handle, integer = ctypes.c_void_p, ctypes.c_int
        library.OSMesaCreateContextAttribs.argtypes = [ctypes.POINTER(integer), handle]
        library.OSMesaCreateContextAttribs.restype = handle
        library.OSMesaMakeCurrent.argtypes = [handle, handle, ctypes.c_uint, integer, integer]
        library.OSMesaMakeCurrent.restype = ctypes.c_ubyte
        library.OSMesaDestroyContext.argtypes = [handle]
        library.OSMesaDestroyContext.restype = None
        library.OSMesaGetProcAddress.argtypes = [ctypes.c_char_p]
        library.OSMesaGetProcAddress.restype = handle
        attributes = (
            (_OSMESA_FORMAT, _GL_RGBA),
            (_OSMESA_DEPTH_BITS, 24),
            (_OSMESA_PROFILE, _OSMESA_CORE_PROFILE),
            (_OSMESA_MAJOR_VERSION, GL_VERSION_CODE // 100),
            (_OSMESA_MINOR_VERSION, GL_VERSION_CODE // 10 % 10),
        )
        numbers = [number for pair in attributes for number in pair] + [0]
        self._handle = library.OSMesaCreateContextAttribs((integer * len(numbers))(*numbers), None)
        if not self._handle:
            raise _BackendError("OSMesa makes no OpenGL 3.3 core context", _OSMESA_HELP)
        # OSMesa wants a picture of its own, though all that counts is drawn to framebuffers.
        self._size = _WINDOW_SIZE_PX
        self._pixels = ctypes.create_string_buffer(4 * self._size[0] * self._size[1])

    def symbol(self, name: str) -> int:
        return self._library.OSMesaGetProcAddress(name.encode()) or 0

    def attach(self) -> None:
        if self.closed:
            return
        width, height = self._size
        if not self._library.OSMesaMakeCurrent(
            self._handle, self._pixels, _GL_UNSIGNED_BYTE, width, height
        ):
            raise _BackendError("OSMesaMakeCurrent failed", _OSMESA_HELP)

    def detach(self) -> None:
        if not self.closed:
            self._library.OSMesaMakeCurrent(None, None, 0, 0, 0)

    def destroy(self) -> None:
        if not self.closed:
            self.closed = True
            self._library.OSMesaDestroyContext(self._handle)


def _open_osmesa() -> tuple[_Driver, moderngl.Context]:
    missing = ""
    for name in _OSMESA_LIBRARIES:
        try:
            library = ctypes.CDLL(name)
            driver = _OsmesaDriver(library)
        except OSError as error:
            missing = missing or str(error)
        except AttributeError as error:  # a function that this library lacks
            missing = missing or f"{name}: {error}"
        else:
            return _create(driver, _SymbolLoader(driver), _OSMESA_HELP)
    raise _BackendError(missing, _OSMESA_HELP)


# --- window -----------------------------------------------------------------------------------

_WINDOW_HELP = (
    "needs a display (DISPLAY or WAYLAND_DISPLAY) with OpenGL 3.3: install libgl1 libgl1-mesa-dri, "
    "and xvfb where there is no screen (xvfb-run rtbow …)"
)


class _Glfw:
    """GLFW is one per process: it is terminated when the last of our windows goes, if it is ours.

    Code that runs GLFW itself and wants it kept calls ``glfw.init`` before our first window.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._users = 0
        self._ours = False

    def acquire(self) -> None:
        import glfw

        with self._lock, _glfw_errors() as errors:
            if self._users == 0:
                platform = glfw.get_platform()
                running = glfw.NOT_INITIALIZED not in (code for code, _ in errors)
                if running and platform == glfw.PLATFORM_NULL:
                    raise _BackendError(
                        "GLFW already runs without a display (null platform) in this process",
                        "terminate GLFW, or open the window first; " + _WINDOW_HELP,
                    )
                if not running:
                    errors.clear()
                    if not glfw.init():
                        raise _BackendError(_glfw_reason(errors, "glfwInit failed"), _WINDOW_HELP)
                self._ours = not running
            self._users += 1

    def release(self) -> None:
        import glfw

        with self._lock:
            self._users -= 1
            if self._users == 0 and self._ours:
                with _glfw_errors():
                    glfw.terminate()


_glfw_process = _Glfw()


@contextmanager
def _glfw_errors() -> Iterator[list[tuple[int, str]]]:
    """Collect GLFW's errors, which its wrapper would print as warnings."""
    import glfw

    errors: list[tuple[int, str]] = []

    def collect(code: int, text: Any) -> None:
        errors.append((code, text.decode("utf-8", "replace")))

    previous = glfw.set_error_callback(collect)
    try:
        yield errors
    finally:
        glfw.set_error_callback(previous)  # type: ignore[arg-type]  # None: the wrapper's own


def _glfw_reason(errors: list[tuple[int, str]], otherwise: str) -> str:
    return "; ".join(dict.fromkeys(text for _, text in errors)) or otherwise


class _WindowDriver:
    """A GLFW window of ours, or of other code (``owned`` False), which is only handed back."""

    def __init__(self, window: Any, owned: bool = True) -> None:
        self.closed = False
        self.window = window
        self._owned = owned

    def symbol(self, name: str) -> int:
        import glfw

        address = glfw.get_proc_address(name)
        return address if isinstance(address, int) else 0  # None: there is no such function

    def attach(self) -> None:
        self._make_current(self.window)

    def detach(self) -> None:
        self._make_current(None)

    def _make_current(self, window: Any) -> None:
        import glfw

        if self.closed:
            return
        with _glfw_errors() as errors:
            glfw.make_context_current(window)
        # A window of other code may have gone meanwhile; there is nothing to hand back then.
        if errors and self._owned:
            raise _BackendError(_glfw_reason(errors, ""), _WINDOW_HELP)

    def destroy(self) -> None:
        import glfw

        if self.closed or not self._owned:
            return
        self.closed = True
        with _glfw_errors():
            glfw.destroy_window(self.window)
        _glfw_process.release()


def _foreign_window() -> _WindowDriver | None:
    """Return the GLFW window whose context other code has made current, if there is one."""
    glfw = sys.modules.get("glfw")
    if glfw is None:
        return None
    with _glfw_errors():  # it is an error to ask while GLFW is not initialised
        window = glfw.get_current_context()
    return _WindowDriver(window, owned=False) if window else None


def _open_window() -> tuple[_Driver, moderngl.Context]:
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise _BackendError("no display: DISPLAY and WAYLAND_DISPLAY are not set", _WINDOW_HELP)
    try:
        import glfw
    except ImportError as error:
        raise _BackendError(f"GLFW does not load: {error}", "pip install glfw") from error
    _glfw_process.acquire()
    with _glfw_errors() as errors:
        glfw.default_window_hints()
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, GL_VERSION_CODE // 100)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, GL_VERSION_CODE // 10 % 10)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        if sys.platform == "darwin":  # the only core profile there is a forward-compatible one
            glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, glfw.TRUE)
        window = glfw.create_window(*_WINDOW_SIZE_PX, "rtbow", None, None)
        glfw.default_window_hints()  # the next window may be another's
    if not window:
        _glfw_process.release()
        raise _BackendError(_glfw_reason(errors, "glfwCreateWindow failed"), _WINDOW_HELP)
    driver = _WindowDriver(window)
    return _create(driver, _SymbolLoader(driver), _WINDOW_HELP)
