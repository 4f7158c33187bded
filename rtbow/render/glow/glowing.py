"""A method that draws the rain's own glow over what another draws."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.base.errors import UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.program import FrameTarget, texture_bytes
from rtbow.reference.orders import Orders, counted_in
from rtbow.render.glow.map import GlowMap
from rtbow.render.glow.passes import GlowPasses, glow_defines, uploaded
from rtbow.render.method import Method, ShaderMethod
from rtbow.render.smooth import drawn_over, smooth_block
from rtbow.world.world import World


def with_glow(
    gl: GlContext, method: Method, world: World, building: Progress = no_progress
) -> Method:
    """Give a method that draws the rain's own glow, too; itself where none is asked for.

    Args:
        gl: the context, current.
        method: which draws all else.
        world: what it draws.
        building: wraps the loop over parts of tables that must be built.

    Raises:
        UnsuitedError: shaders do not draw it in this rain.
    """
    if counted_in(world) is None:
        return method
    if not world.volume.uniform:
        raise UnsuitedError(
            "droplets.scattering_orders and skylight in a grid of drops: shaders have them for even"
            " rain alone; leave them out, or use --method reference"
        )
    return Glowing(gl, method, world, building)


class Glowing:
    """A method that adds the rain's own glow (:class:`rtbow.render.method.Method`)."""

    def __init__(self, gl: GlContext, method: Method, world: World, building: Progress) -> None:
        self._gl, self._method, self._world = gl, method, world
        self._passes: dict[int, GlowPasses] = {}
        self._take(world, building)

    @property
    def name(self) -> ShaderMethod:
        """What the command line calls the method."""
        return self._method.name

    @property
    def beneath(self) -> Method:
        """The method that draws all else."""
        return self._method

    @property
    def map(self) -> GlowMap:
        """What is drawn."""
        return self._map

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        passed = [texture for passes in self._passes.values() for texture in passes.textures]
        return self._method.texture_bytes + texture_bytes([*self._textures.values(), *passed])

    def move(self, world: World) -> bool:
        """Take over another world (see :class:`rtbow.render.method.Method`)."""
        before = self._world
        if glow_defines(world) != glow_defines(before) or not self._method.move(world):
            return False
        if world.view.size_px != before.view.size_px:
            self._passes = {}
        turned = world.optics is before.optics and world.around == before.around
        if turned and bool(np.all(world.view.eye_m == before.view.eye_m)):
            self._world = world
        else:
            self._take(world, no_progress)
        return True

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take."""
        self._method.prepare_moves()

    def _take(self, world: World, building: Progress) -> None:
        counted = counted_in(world)
        assert counted is not None
        orders = Orders.of(world, building)
        self._map = GlowMap.of(orders, counted, building=building)
        self._textures = uploaded(self._gl, self._map)
        self._world = world

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done."""
        target = self._method.draw(progress, columns)
        world = self._world
        block = smooth_block(world.view)
        if block not in self._passes:
            self._passes[block] = GlowPasses(self._gl, world)
        passes = self._passes[block]
        passes.take(world, self._textures, self._map)
        passes.gather()
        with drawn_over(self._gl, target, world.view.size_px, columns):
            passes.compose()
        self._gl.ctx.finish()
        return target

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        return self.draw(progress, columns).read(columns)
