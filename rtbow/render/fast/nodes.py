"""Method ``fast``: nodes at the corners of blocks of pixels, at which paths are gathered."""

from __future__ import annotations

import moderngl

from rtbow.gl.context import GlContext
from rtbow.gl.program import GlProgram
from rtbow.world.camera.view import View

_WIDEST_DEG = 1.1
"""Nodes lie no farther apart than this angle: what they gather bends over several degrees."""
_WIDEST_ROWS_DEG = 0.45
"""The same where nodes keep the weights of rows of radius: the light of each row has fringes of its
own, so that errors in their mixture show as colour (ΔE2000 99 % of ``shower``: 0.86 where they are
0.79 degrees apart, 0.52 at 0.53 degrees, 0.33 at 0.39)."""


def block_for(view: View, most: int, *, rows: bool = False) -> int:
    """Give the pixels between nodes, fewer than ``most`` where they are wide; 0 for no nodes.

    Args:
        view: whose pixels.
        most: pixels that nodes may be apart.
        rows: whether nodes keep the weights of rows of radius.
    """
    widest = _WIDEST_ROWS_DEG if rows else _WIDEST_DEG
    block = min(most, int(widest / view.pixel_deg))
    return block if block > 1 else 0


class Nodes:
    """Targets at the corners of a picture's blocks, and one flag for each block.

    Args:
        gl: the context; it must be current.
        size_px: of the picture.
        block: pixels between nodes.
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


def draw_into(frame: moderngl.Framebuffer, program: GlProgram) -> None:
    """Draw a program's one triangle over a target of nodes or flags."""
    frame.use()
    program.use()
    program.draw()
