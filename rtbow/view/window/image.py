"""Shows a frame of radiance in a part of a window."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np

from rtbow.base.arrays import Float32
from rtbow.frames.display import max_luminance
from rtbow.gl.program import GlProgram, row_texture
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS

if TYPE_CHECKING:
    from rtbow.gl.context import GlContext

_MOST_PER_WHITE = 1e30
"""Most that a luminance is multiplied by: all is white long before, and products stay within
float32."""
Rect = tuple[int, int, int, int]
"""Left, bottom, width and height in a framebuffer's pixels."""


class Picture:
    """A frame's texture and the program that shows it.

    Args:
        gl: the window's context; it must be current here and in every method.
        colour_map: of false colours, float32 (n, 3), sRGB.
    """

    def __init__(self, gl: GlContext, colour_map: Float32) -> None:
        self._gl = gl
        self._program = GlProgram(gl, "display/picture.frag", {})
        opaque = np.concatenate([colour_map, np.ones((len(colour_map), 1))], axis=1)
        self._program.bind("colourMap", row_texture(gl, opaque[None].astype(np.float32)))
        self._frame: moderngl.Texture | None = None

    def take(self, rgb: Float32) -> None:
        """Upload a frame: cd/m², float32 (h, w, 3), first row on top."""
        height, width = rgb.shape[:2]
        if self._frame is None or self._frame.size != (width, height):
            self._frame = self._gl.ctx.texture((width, height), 3, dtype="f4", alignment=4)
            self._frame.repeat_x = self._frame.repeat_y = False
            self._program.bind("frame", self._frame)
        self._frame.write(np.ascontiguousarray(rgb))

    def draw(
        self,
        target: moderngl.Framebuffer,
        rect: Rect,
        exposure_ev: float,
        false_range: tuple[float, float] | None = None,
    ) -> None:
        """Show the frame, stretched over a rectangle.

        Args:
            target: the window's framebuffer.
            rect: where in the framebuffer.
            exposure_ev: exposure value for ISO 100.
            false_range: log10 of the luminances at the ends of the false colours; None shows the
                frame's own.
        """
        if self._frame is None or min(rect[2:]) < 1:
            return
        # A frame of the same size as its place is shown without interpolation.
        same = self._frame.size == rect[2:]
        mode = moderngl.NEAREST if same else moderngl.LINEAR
        self._frame.filter = (mode, mode)
        target.use()
        target.viewport = rect
        target.scissor = rect
        self._gl.ctx.disable(moderngl.BLEND | moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._program.set("viewRect", tuple(float(n) for n in rect))
        self._program.set("perWhite", min(1.0 / max_luminance(exposure_ev), _MOST_PER_WHITE))
        self._program.set("luminanceWeights", tuple(LUMINANCE_WEIGHTS))
        self._program.set("falseColour", false_range is not None)
        self._program.set("logRange", false_range or (0.0, 1.0))
        self._program.use()
        self._program.draw()
        target.scissor = (0, 0, *target.size)
