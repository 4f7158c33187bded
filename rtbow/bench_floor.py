"""The floor that frame times are compared with: a full-screen pass with one table look-up."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import moderngl
import numpy as np

from rtbow.context import Backend, open_context
from rtbow.errors import UnavailableError
from rtbow.gl_program import GlProgram

TABLE_SIDE = 256
"""Texels a side of the table, of four float32 each: 1 MiB."""


class FloorPass:
    """One bilinear fetch per pixel from a float32 table, into a frame of RGBA32F.

    No blending and no clearing: no method that fills such a frame from a table can be quicker.
    It has a GL context of its own, as each method's renderer has.

    Args:
        size_px: width and height.
        backend: as of the method's renderer.

    Raises:
        UnavailableError: no GL backend works here, or the frame does not fit on the device.
    """

    def __init__(self, size_px: tuple[int, int], backend: Backend = "auto") -> None:
        self._gl = open_context(backend)
        self.gl_renderer = self._gl.renderer
        try:
            with self._gl.current() as ctx:
                # Kept here: the framebuffer alone would not keep it from being freed.
                self._texture = ctx.texture(size_px, 4, dtype="f4")
                self._frame = ctx.framebuffer([self._texture])
                self._program = GlProgram(self._gl, "floor.frag", {})
                self._program.texture("floorTable", _table())
                self._program.set("frameSize", tuple(float(n) for n in size_px))
        except moderngl.Error as error:
            self._gl.close()
            raise UnavailableError(
                f"this GL device ({self.gl_renderer}) cannot hold {size_px[0]} x {size_px[1]}"
                f" pixels ({error}); bench at a smaller size"
            ) from error

    def draw(self) -> None:
        """Draw the frame and wait until it is done."""
        with self._gl.current() as ctx:
            self._frame.use()
            ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
            self._program.use()
            self._program.draw()
            ctx.finish()

    def read(self) -> np.ndarray:
        """Read the frame: float32 (h, w, 4), first row on top."""
        with self._gl.current():
            width, height = self._texture.size
            pixels = np.frombuffer(self._texture.read(), dtype=np.float32)
            return pixels.reshape(height, width, 4)[::-1].copy()

    def close(self) -> None:
        """Release the context."""
        self._gl.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _table() -> np.ndarray:
    """Give numbers that vary over the table, so that no driver can do without the fetches."""
    place = np.linspace(0.0, 1.0, TABLE_SIDE, dtype=np.float32)
    x, y = np.meshgrid(place, place)
    return np.stack([x, y, x * y, np.ones_like(x)], axis=-1)
