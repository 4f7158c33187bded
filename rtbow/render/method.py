"""The interface that the shader's methods share."""

from __future__ import annotations

from typing import Literal, Protocol

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.gl.program import FrameTarget
from rtbow.world.world import World

ShaderMethod = Literal["fast", "spectral"]


class Method(Protocol):
    """The textures and programs with which one method draws one world on one GL context.

    It is made from a context, a world and a wrapper of the loop over parts of an exact table that
    has to be built first; the context must be current then and in every method.
    """

    @property
    def name(self) -> ShaderMethod:
        """What the command line calls the method."""
        ...

    def move(self, world: World) -> bool:
        """Take over another world, if it differs no more than this method follows.

        Returns:
            Whether that could be done; if not, nothing has changed.

        Raises:
            UnavailableError: the picture is beyond what this GL device takes; nothing has changed.
            UnsuitedError: the method cannot draw it there; nothing has changed.
        """
        ...

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take, if there are none yet.

        Raises:
            UnsuitedError: the method cannot draw the world from everywhere.
        """
        ...

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        ...

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done.

        Args:
            progress: wraps the loop over the picture's rows.
            columns: which columns of the picture, a slice of step 1; all by default.
        """
        ...

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        ...
