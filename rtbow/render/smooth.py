"""Light that is smooth over most of a picture: drawn at nodes, between them, and where that will
not do, pixel by pixel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import FrameTarget, GlProgram, Texture, added_up
from rtbow.render.fast.nodes import Nodes, block_for, draw_into
from rtbow.render.uniforms import set_uniforms
from rtbow.world.camera.view import View

_MOST_PIXELS = 8
"""Between nodes."""
_ROUGH = 1e-2
"""Of a block's luminance: where straight lines between its nodes seem to miss by more, its pixels
are drawn one by one."""


def smooth_block(view: View) -> int:
    """Give the pixels between a view's nodes; 0 for no nodes."""
    return block_for(view, _MOST_PIXELS)


@contextmanager
def drawn_over(
    gl: GlContext, target: FrameTarget, size_px: tuple[int, int], columns: slice
) -> Iterator[None]:
    """Let what is drawn meanwhile add to some columns of a frame; the whole is bound after."""
    width, height = size_px
    left, right, _ = columns.indices(width)
    frame = target.begin(clear=False)
    frame.scissor = (left, 0, right - left, height)
    with added_up(gl):
        yield
    frame = target.begin(clear=False)
    frame.scissor = (0, 0, width, height)


class SmoothPasses:
    """The programs of one kind of light, added to a frame.

    Args:
        gl: the context; it must be current here and in every method.
        view: the picture.
        folder: of its shaders, ``node.frag`` and ``pixel.frag``.
        defines: of all programs.
        moments: of the rain in a grid, if it is read.

    Attributes:
        textures: that are read, but those that are bound to it.
    """

    def __init__(
        self, gl: GlContext, view: View, folder: str, defines: Mapping[str, Define],
        moments: Texture | None,
    ) -> None:  # fmt: skip
        block = smooth_block(view)
        defines = {**defines, "BLOCKS": block > 0}
        vertex = "fast/rough.vert" if block else "common/fullscreen.vert"
        self._pixel = GlProgram(gl, f"{folder}/pixel.frag", defines, vertex)
        self._along = [self._pixel]
        self.textures: list[Texture] = []
        self._nodes: Nodes | None = None
        if block:
            self._nodes = nodes = Nodes(gl, view.size_px, block, channels=4)
            self._node = GlProgram(gl, f"{folder}/node.frag", defines)
            self._flags = GlProgram(gl, "fast/flags.frag", defines)
            self._smooth = GlProgram(gl, "sky/smooth.frag", defines)
            self._along.append(self._node)
            for program in (self._flags, self._smooth):
                program.bind("nodes", nodes.values)
            for program in (self._smooth, self._pixel):
                program.bind("flags", nodes.flags)
            self._flags.set("tolerance.first", _ROUGH)
            self._flags.set("tolerance.others", (_ROUGH, _ROUGH, _ROUGH))
            for program in (self._node, self._smooth, self._pixel):
                program.set("blockSize", float(block))
            self._pixel.set("pictureSize", tuple(map(float, view.size_px)))
            self.textures += [nodes.values, nodes.flags]
        if moments is not None:
            for program in self._along:
                program.bind("volume.moments", moments)
            self.textures.append(moments)

    def read(self, textures: Mapping[str, Texture], uniforms: Mapping[str, Any]) -> None:
        """Take over what rays are followed through."""
        for program in self._along:
            for name, texture in textures.items():
                program.bind(name, texture)
            set_uniforms(program, uniforms)

    def gather(self) -> None:
        """Draw the nodes."""
        if self._nodes is None:
            return
        draw_into(self._nodes.gathered, self._node)
        draw_into(self._nodes.flagged, self._flags)

    def compose(self) -> None:
        """Draw the pixels into the frame that is bound."""
        if self._nodes is None:
            self._pixel.use()
            self._pixel.draw()
            return
        self._smooth.use()
        self._smooth.draw()
        self._pixel.use()
        self._pixel.draw(6 * self._nodes.flags.width * self._nodes.flags.height)
