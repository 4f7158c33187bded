"""Method ``fast``: nodes at the corners of blocks of pixels, at which paths are gathered."""

from __future__ import annotations

import moderngl

from rtbow.gl.context import GlContext
from rtbow.gl.program import GlProgram
from rtbow.world.camera import View

_WIDEST_DEG = 1.1
"""Nodes lie no farther apart than this angle: what they gather bends over several degrees."""
_WIDEST_ROWS_DEG = 0.4
"""The same where nodes keep the weights of rows of radius: the light of each row has fringes of its
own, so that errors in their mixture show as colour."""


def block_for(view: View, most: int, *, rows: bool = False) -> int:
    """Give the pixels between nodes.

    Args:
        view: whose pixels.
        most: that they may be apart; fewer where pixels are wide.
        rows: whether nodes keep the weights of rows of radius. Then even a node at every pixel (1)
            saves work: counting a sample of the march at its row costs less than its colour.

    Returns:
        0 for no nodes.
    """
    if rows:
        return min(most, max(int(_WIDEST_ROWS_DEG / view.pixel_deg), 1))
    block = min(most, int(_WIDEST_DEG / view.pixel_deg))
    return block if block > 1 else 0


class Nodes:
    """Targets at the corners of a picture's blocks, and one flag for each block.

    Args:
        gl: the context; it must be current.
        size_px: of the picture.
        block: pixels between nodes; with 1 they lie on the pixels' centres, else on the corners of
            blocks.
        channels: that a node keeps.
        groups: of four rows of radius, whose weights nodes keep, too.

    Attributes:
        block: pixels between nodes.
        values: what nodes keep.
        weights: the weights of each group of rows.
        atlas: all groups side by side; None without groups.
        flags: how each block is drawn.
    """

    def __init__(
        self, gl: GlContext, size_px: tuple[int, int], block: int, channels: int, groups: int = 0
    ) -> None:
        ctx, self.block = gl.ctx, block
        blocks = -(-size_px[0] // block), -(-size_px[1] // block)
        size = blocks[0] + 3, blocks[1] + 3  # a ring more than the blocks' corners
        self.values = ctx.texture(size, channels, dtype="f4")
        self.values.repeat_x = self.values.repeat_y = False
        self.weights = [ctx.texture(size, 4, dtype="f4") for _ in range(groups)]
        self.atlas = ctx.texture((size[0], size[1] * groups), 4, dtype="f4") if groups else None
        self.flags = ctx.texture(blocks, 4, dtype="f1")
        self.flags.filter = (moderngl.NEAREST, moderngl.NEAREST)
        self.flags.repeat_x = self.flags.repeat_y = False
        self.gathered = ctx.framebuffer([self.values, *self.weights])
        self.side_by_side = ctx.framebuffer([self.atlas]) if self.atlas else None
        self.flagged = ctx.framebuffer([self.flags])

    def place(self, program: GlProgram) -> None:
        """Tell a program where the nodes lie."""
        program.set("blocks.size", float(self.block))
        program.set("blocks.inset", 0.5 if self.block == 1 else 0.0)
