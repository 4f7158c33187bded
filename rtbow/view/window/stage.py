"""The window with what is drawn into it: the picture, and ImGui's panel and lines over it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from imgui_bundle import imgui, implot

from rtbow.base.arrays import Float32
from rtbow.base.errors import UnavailableError
from rtbow.frames.display import BLACK_FRAME_EV
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS
from rtbow.view.window import look
from rtbow.view.window.image import Picture, Rect
from rtbow.view.window.input import WindowInput
from rtbow.view.window.system import Window

if TYPE_CHECKING:
    from rtbow.view.document.edits import Edits
    from rtbow.view.document.state import ViewState

PANEL_WIDTH = 340
"""Width of the panel, in screen coordinates at an ordinary display's density."""
LEAST_SIZE = (640, 600)
"""Least size at which a window opens, without its panel, in screen coordinates: small pictures are
enlarged so that overlays fit."""
_FALSE_DECADES = 4.0
"""Decades that the false colours span below the brightest pixels."""
_FALSE_QUANTILE = 0.999
_COLOURS = 256
_GLSL = "#version 330"
"""What ImGui's own shaders begin with."""


class Stage:
    """A window on the screen, sized for a scene's picture with the panel beside it.

    Args:
        edits: the scene.
        state: how it is shown.
        on_drop, on_key, on_scroll: as :class:`WindowInput` takes them.

    Raises:
        UnavailableError: there is no display, or no OpenGL 3.3.

    Attributes:
        window: GLFW's.
        input: its events.
        frame_rgb: the picture, cd/m², float32 (h, w, 3); None before the first.
    """

    def __init__(
        self,
        edits: Edits,
        state: ViewState,
        on_drop: Callable[[list[str]], None],
        on_key: Callable[[str], None],
        on_scroll: Callable[[float], None],
    ) -> None:
        self._edits, self._state = edits, state
        size = zip(edits.scene.camera.size_px, LEAST_SIZE, strict=True)
        width, height = (max(own, least) for own, least in size)
        self.window = Window("rtbow", (width + PANEL_WIDTH, height))
        self._imgui = imgui.create_context()
        self._plots = implot.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.config_error_recovery_enable_assert = False  # a broken frame must not end the window
        self.input = WindowInput(
            self.window.handle, on_drop=on_drop, on_key=on_key, on_scroll=on_scroll
        )
        look.apply()
        with self.window.gl.current():
            if not imgui.backends.opengl3_init(_GLSL):
                raise UnavailableError("the panel cannot be drawn with this OpenGL driver")
            self._picture = Picture(self.window.gl, _colour_map())
        self.frame_rgb: Float32 | None = None
        self._composed = self._closing_popups = False
        self._false: tuple[Float32 | None, tuple[float, float] | None] = (None, None)

    def close(self) -> None:
        """Close the window; a second call does nothing."""
        if self.window.handle is not None:
            with self.window.gl.current():
                imgui.backends.opengl3_shutdown()
            self.input.close()
            implot.destroy_context(self._plots)
            imgui.destroy_context(self._imgui)
            self.window.destroy()

    def take(self, rgb: Float32) -> None:
        """Show another frame: cd/m², float32 (h, w, 3), first row on top."""
        self.frame_rgb = rgb
        with self.window.gl.current():
            self._picture.take(rgb)

    def recompile(self) -> None:
        """Compile the window's own program anew.

        Raises:
            RtbowError: it has a mistake; the old one stays.
        """
        with self.window.gl.current():
            picture = Picture(self.window.gl, _colour_map())
            if self.frame_rgb is not None:
                picture.take(self.frame_rgb)
        self._picture = picture

    # --- where things are ---------------------------------------------------------------------

    def panel_units(self) -> float:
        """Width of the panel, in screen coordinates."""
        wanted = PANEL_WIDTH * self.window.content_scale
        return min(wanted, 0.6 * self.window.size[0]) if self._state.panel_open else 0.0

    def view_rect(self) -> Rect:
        """Where the picture is in the framebuffer: as large as fits, with the scene's shape."""
        width, height = self.window.size_px
        free = max(width - math.ceil(self.panel_units() * self.window.pixels_per_unit), 0)
        own_width, own_height = self._edits.scene.camera.size_px
        share = min(free / own_width, height / own_height)
        across, down = int(share * own_width + 0.5), int(share * own_height + 0.5)
        return (free - across) // 2, (height - down) // 2, across, down

    def view_units(self) -> tuple[float, float, float, float] | None:
        """The same from the window's upper left corner, in screen coordinates; None if empty."""
        left, bottom, width, height = self.view_rect()
        per = 1.0 / self.window.pixels_per_unit
        if min(width, height) < 1:
            return None
        top = self.window.size_px[1] - bottom - height
        return left * per, top * per, width * per, height * per

    # --- drawing ------------------------------------------------------------------------------

    def close_popups(self) -> bool:
        """Close menus and lists in the next picture; give whether any is open."""
        every = imgui.PopupFlags_.any_popup_id | imgui.PopupFlags_.any_popup_level
        self._closing_popups = imgui.is_popup_open("", every)  # ImGui allows it within a frame only
        return self._closing_popups

    def paint(self, compose: Callable[[], None], panel: Callable[[], None]) -> None:
        """Draw the window and show it.

        Args:
            compose: draws over the picture, by ImGui.
            panel: draws the panel beside it, if that is open.
        """
        with self.window.gl.current():
            imgui.backends.opengl3_new_frame()
            self.input.begin_frame()
            look.scale(self.window.content_scale)
            imgui.new_frame()
            try:
                if self._closing_popups:
                    self._closing_popups = False
                    imgui.internal.close_popups_except_modals()
                compose()
                if self._state.panel_open:
                    self._beside(panel)
            finally:
                imgui.render()
            self._composed = True
            try:
                self._draw()
            except Exception:
                self.window.check()  # a lost context breaks whatever comes first
                raise
            self.window.show()

    def image(self) -> np.ndarray:
        """Give the window's content: 8 bit sRGB (h, w, 3), first row on top."""
        with self.window.gl.current():
            self._draw()
            return self.window.image()

    def _beside(self, panel: Callable[[], None]) -> None:
        size = imgui.get_io().display_size
        width = self.panel_units()
        imgui.set_next_window_pos((size.x - width, 0.0))
        imgui.set_next_window_size((width, size.y))
        fixed = (
            imgui.WindowFlags_.no_move
            | imgui.WindowFlags_.no_resize
            | imgui.WindowFlags_.no_title_bar
            | imgui.WindowFlags_.no_background
        )
        imgui.begin("rtbow", None, fixed)
        panel()
        imgui.end()

    def _draw(self) -> None:
        screen = self.window.begin(look.BACKGROUND)
        frame = self._state.frame
        shown = BLACK_FRAME_EV if frame is None else frame.exposure_ev
        exposure = shown if self._state.exposure_ev is None else self._state.exposure_ev
        self._picture.draw(screen, self.view_rect(), exposure, self.false_range())
        if self._composed:
            imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())

    # --- false colours ------------------------------------------------------------------------

    def false_range(self) -> tuple[float, float] | None:
        """Give log10 of the luminances at the ends of the false colours; None if they are off."""
        if "false" not in self._state.overlays or self.frame_rgb is None:
            return None
        if self._false[0] is not self.frame_rgb:
            self._false = self.frame_rgb, _false_range(self.frame_rgb)
        return self._false[1]


def _false_range(rgb: Float32) -> tuple[float, float]:
    luminance = rgb[::3, ::3] @ LUMINANCE_WEIGHTS.astype(np.float32)
    lit = luminance[luminance > 0.0]
    if lit.size == 0:
        return (-_FALSE_DECADES, 0.0)
    top = math.log10(float(np.quantile(lit, _FALSE_QUANTILE)))
    return top - _FALSE_DECADES, top


def _colour_map() -> Float32:
    """Give the false colours, dark to bright (n, 3), sRGB: viridis."""
    at = np.linspace(0.0, 1.0, _COLOURS)
    colours = [implot.sample_colormap(float(t), implot.Colormap_.viridis) for t in at]
    return np.array([(c.x, c.y, c.z) for c in colours], dtype=np.float32)
