"""OpenGL contexts by hidden GLFW windows, on a display."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtbow.gl.driver import GL_VERSION_CODE, BackendError, Driver, SymbolLoader, create
from rtbow.gl.process import Lock, after_fork

# glfw is imported where it is used: a verb without pictures must not wait.
if TYPE_CHECKING:
    import moderngl

_WINDOW_SIZE_PX = (64, 64)
_WINDOW_HELP = (
    "needs a display (DISPLAY or WAYLAND_DISPLAY) with OpenGL 3.3: install libgl1 libgl1-mesa-dri, "
    "and xvfb where there is no screen (xvfb-run rtbow …)"
)


class _Glfw:
    """GLFW is one per process: it is terminated when the last of our windows goes, if it is ours.

    Code that runs GLFW itself and wants it kept calls ``glfw.init`` before our first window.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._users = 0
        self._ours = False

    def acquire(self) -> None:
        import glfw

        with self._lock, _glfw_errors() as errors:
            if self._users == 0:
                platform = glfw.get_platform()
                running = glfw.NOT_INITIALIZED not in (code for code, _ in errors)
                if running and platform == glfw.PLATFORM_NULL:
                    raise BackendError(
                        "GLFW already runs without a display (null platform) in this process",
                        "terminate GLFW, or open the window first; " + _WINDOW_HELP,
                    )
                if not running:
                    errors.clear()
                    if not glfw.init():
                        raise BackendError(_glfw_reason(errors, "glfwInit failed"), _WINDOW_HELP)
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
_callback = Lock()
_forked_with_glfw = False


def _leave_to_parent() -> None:
    global _forked_with_glfw
    _forked_with_glfw = _forked_with_glfw or "glfw" in sys.modules


after_fork(_leave_to_parent)


@contextmanager
def _glfw_errors() -> Iterator[list[tuple[int, str]]]:
    """Collect GLFW's errors, which its wrapper would print as warnings."""
    import glfw

    errors: list[tuple[int, str]] = []

    def collect(code: int, text: Any) -> None:
        errors.append((code, text.decode("utf-8", "replace")))

    with _callback:  # all threads share one
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
            raise BackendError(_glfw_reason(errors, ""), _WINDOW_HELP)

    def destroy(self) -> None:
        import glfw

        if self.closed or not self._owned:
            return
        self.closed = True
        with _glfw_errors():
            glfw.destroy_window(self.window)
        _glfw_process.release()


def foreign_window() -> _WindowDriver | None:
    """Return the GLFW window whose context other code has made current, if there is one."""
    glfw = sys.modules.get("glfw")
    if glfw is None or _forked_with_glfw:  # the parent's window, if any
        return None
    with _glfw_errors():  # it is an error to ask while GLFW is not initialised
        window = glfw.get_current_context()
    return _WindowDriver(window, owned=False) if window else None


def open_window(*, robust: bool = False) -> tuple[Driver, moderngl.Context]:
    """Open a hidden window with a context.

    Args:
        robust: ask for a context that reports a reset of the device, if the driver can.

    Raises:
        BackendError: there is no display, or no OpenGL 3.3.
    """
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise BackendError("no display: DISPLAY and WAYLAND_DISPLAY are not set", _WINDOW_HELP)
    try:
        import glfw
    except ImportError as error:
        raise BackendError(f"GLFW does not load: {error}", "pip install glfw") from error
    _glfw_process.acquire()
    with _glfw_errors() as errors:
        glfw.default_window_hints()
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, GL_VERSION_CODE // 100)
        glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, GL_VERSION_CODE // 10 % 10)
        glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
        if sys.platform == "darwin":  # the only core profile there is a forward-compatible one
            glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, glfw.TRUE)
        window = None
        for strategy in (glfw.LOSE_CONTEXT_ON_RESET, glfw.NO_ROBUSTNESS) if robust else (None,):
            if strategy is not None:
                glfw.window_hint(glfw.CONTEXT_ROBUSTNESS, strategy)
            errors.clear()
            window = glfw.create_window(*_WINDOW_SIZE_PX, "rtbow", None, None)
            if window:
                break
        glfw.default_window_hints()  # the next window may be another's
    if not window:
        _glfw_process.release()
        raise BackendError(_glfw_reason(errors, "glfwCreateWindow failed"), _WINDOW_HELP)
    driver = _WindowDriver(window)
    return create(driver, SymbolLoader(driver), _WINDOW_HELP)
