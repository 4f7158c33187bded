"""The floor that frame times are compared with: a full-screen pass with one table look-up."""

from __future__ import annotations

import moderngl
import numpy as np

from rtbow.base.arrays import Float32
from rtbow.base.errors import UnavailableError
from rtbow.gl.context import GlContext
from rtbow.gl.program import FrameTarget, GlProgram

TABLE_SIDE = 256
"""Texels a side of the table, of four float32 each: 1 MiB."""


class FloorPass:
    """One bilinear fetch per pixel from a float32 table, into a frame of RGBA32F.

    No blending and no clearing: no method that fills such a frame from a table can be quicker.

    Args:
        gl: a context of its own, as each method's renderer has.
        size_px: width and height.

    Raises:
        UnavailableError: the frame does not fit on the device.
    """

    def __init__(self, gl: GlContext, size_px: tuple[int, int]) -> None:
        self._gl = gl
        try:
            with gl.current():
                self._target = FrameTarget(gl, size_px)
                self._program = GlProgram(gl, "display/floor.frag", {})
                self._program.texture("floorTable", _table())
                self._program.set("frameSize", tuple(float(n) for n in size_px))
        except (moderngl.Error, UnavailableError) as error:
            raise UnavailableError(
                f"this GL device ({gl.renderer}) holds no frame of {size_px[0]} x {size_px[1]}"
                " pixels; bench at a smaller size"
            ) from error

    def draw(self) -> None:
        """Draw the frame and wait until it is done."""
        with self._gl.current() as ctx:
            self._target.begin(clear=False)
            self._program.use()
            self._program.draw()
            ctx.finish()

    def read(self) -> Float32:
        """Read the table's first three channels: (h, w, 3), first row on top."""
        with self._gl.current():
            return self._target.read()


def _table() -> np.ndarray:
    """Give numbers that vary over the table, so that no driver can do without the fetches."""
    place = np.linspace(0.0, 1.0, TABLE_SIDE, dtype=np.float32)
    x, y = np.meshgrid(place, place)
    return np.stack([x, y, x * y, np.ones_like(x)], axis=-1)
