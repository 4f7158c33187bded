"""A GLFW window on a display: its size, full screen, clipboard, and what it shows as an image."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import glfw
import moderngl
import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import UnavailableError
from rtbow.gl.context import GlContext, open_context
from rtbow.view.window.image import Rect

_LEAST_SIZE_PX = (1, 1)
_NO_ERROR = 0
_LOST = ("GL_CONTEXT_LOST", "GL_UNKNOWN_ERROR")
"""moderngl's names for errors that OpenGL 3.3 does not have: since 4.5, a lost context."""
_GONE = "the window's GL context is lost: the graphics driver was reset, or the display has gone"


class Window:
    """A window with an OpenGL 3.3 core context.

    Args:
        title: on its frame.
        size: width and height, in screen coordinates; no larger than the screen.

    Raises:
        UnavailableError: there is no display, or no OpenGL 3.3.

    Attributes:
        handle: GLFW's; None once the window is closed.
        size: width and height in screen coordinates, when events were last taken.
        size_px: those of the framebuffer.
    """

    def __init__(self, title: str, size: tuple[int, int]) -> None:
        try:
            self.gl: GlContext = open_context("window", robust=True)
        except UnavailableError as error:
            raise UnavailableError(
                f"{error}\nrtbow view needs a display; rtbow render -o bow.png draws without one"
            ) from error
        self.handle: Any = self.gl.window
        self._before: tuple[int, int, int, int] | None = None
        area = self._screen_area()
        width, height = min(size[0], area[2]), min(size[1], area[3])
        glfw.set_window_title(self.handle, title)
        glfw.set_window_size_limits(self.handle, *_LEAST_SIZE_PX, glfw.DONT_CARE, glfw.DONT_CARE)
        glfw.set_window_size(self.handle, width, height)
        glfw.show_window(self.handle)
        with self.gl.current():
            glfw.swap_interval(1)
            self._screen = self.gl.ctx.detect_framebuffer(0)
            self._reset_status = self._reset_query()
        self._title = title
        self._measure()

    def _reset_query(self) -> Callable[[], int]:
        """Give GL's query of the device's state, which returns 0 unless the device was reset."""
        extensions = self.gl.ctx.extensions
        for extension, suffix in (("GL_ARB_robustness", "ARB"), ("GL_KHR_robustness", "")):
            if extension in extensions:
                address: Any = glfw.get_proc_address(f"glGetGraphicsResetStatus{suffix}")
                if isinstance(address, int) and address:
                    return ctypes.CFUNCTYPE(ctypes.c_uint)(address)
        return lambda: 0

    def _measure(self) -> None:
        """Ask for sizes, once per batch of events: the X server may take milliseconds."""
        self.size: tuple[int, int] = glfw.get_window_size(self.handle)
        self.size_px: tuple[int, int] = glfw.get_framebuffer_size(self.handle)
        self._iconified = bool(glfw.get_window_attrib(self.handle, glfw.ICONIFIED))
        self._scale = float(glfw.get_window_content_scale(self.handle)[0])

    def _screen_area(self) -> tuple[int, int, int, int]:
        """Left, top, width and height of the screen's free area."""
        monitor = glfw.get_primary_monitor()
        if not monitor:
            return 0, 0, 1280, 720
        left, top, width, height = glfw.get_monitor_workarea(monitor)
        return left, top, width, height

    @property
    def closing(self) -> bool:
        """Whether the window was asked to close."""
        return bool(glfw.window_should_close(self.handle))

    @property
    def visible(self) -> bool:
        """Whether there is anything to draw into: the window is not minimised and has a size."""
        return min(self.size_px) > 0 and not self._iconified

    @property
    def pixels_per_unit(self) -> float:
        """Framebuffer pixels per screen coordinate: 2 on some dense displays."""
        return self.size_px[0] / self.size[0] if self.size[0] else 1.0

    @property
    def content_scale(self) -> float:
        """Size of letters, in screen coordinates, relative to an ordinary screen."""
        return max(self._scale / self.pixels_per_unit, 0.5)

    @property
    def cursor(self) -> tuple[float, float]:
        """Position of the mouse, in screen coordinates from the upper left corner."""
        x, y = glfw.get_cursor_pos(self.handle)
        return float(x), float(y)

    def close(self) -> None:
        """Ask the window to close."""
        glfw.set_window_should_close(self.handle, True)

    def wait(self, seconds: float) -> None:
        """Wait for events, at most for a number of seconds, and handle them."""
        if seconds > 0.0:
            glfw.wait_events_timeout(seconds)
        else:
            glfw.poll_events()
        self._measure()

    def toggle_full_screen(self) -> None:
        """Fill the screen, or return to the previous size."""
        if self._before is not None:
            left, top, width, height = self._before
            nowhere: Any = None
            glfw.set_window_monitor(self.handle, nowhere, left, top, width, height, glfw.DONT_CARE)
            self._before = None
            return
        monitor = glfw.get_primary_monitor()
        if not monitor:
            return
        self._before = (
            *glfw.get_window_pos(self.handle),
            *glfw.get_window_size(self.handle),
        )
        mode = glfw.get_video_mode(monitor)
        size = mode.size
        glfw.set_window_monitor(
            self.handle, monitor, 0, 0, size.width, size.height, mode.refresh_rate
        )

    def copy(self, text: str) -> None:
        """Put a text on the clipboard."""
        nowhere: Any = None  # since GLFW 3.3 the clipboard belongs to no window
        glfw.set_clipboard_string(nowhere, text)

    def retitle(self, title: str) -> None:
        """Change the title."""
        if title != self._title:
            self._title = title
            glfw.set_window_title(self.handle, title)

    def begin(self, colour: tuple[float, float, float, float]) -> moderngl.Framebuffer:
        """Give the window's framebuffer, cleared to a colour."""
        screen = self._screen
        screen.use()
        screen.viewport = screen.scissor = (0, 0, *self.size_px)
        screen.clear(*colour)
        return screen

    def show(self) -> None:
        """Show what was drawn.

        Raises:
            UnavailableError: the context is lost.
        """
        self.check()
        glfw.swap_buffers(self.handle)

    def check(self) -> None:
        """Check that the context, which must be current, is still there.

        Raises:
            UnavailableError: the context is lost.
        """
        if self._reset_status() != _NO_ERROR or self.gl.ctx.error in _LOST:
            raise UnavailableError(_GONE)

    def image(self, rect: Rect | None = None) -> NDArray[np.uint8]:
        """Read what was drawn: 8 bit sRGB (h, w, 3), first row on top."""
        left, bottom, width, height = rect or (0, 0, *self.size_px)
        data = self._screen.read((left, bottom, width, height), components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1].copy()

    def destroy(self) -> None:
        """Close the window and its context; a second call does nothing."""
        self.gl.close()
        self.handle = None
