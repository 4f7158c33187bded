"""A method that draws the sky, the ground and suns over what another draws of the drops."""

from __future__ import annotations

from rtbow.base.arrays import Array, Float32, Progress, no_progress
from rtbow.gl.context import GlContext
from rtbow.gl.program import FrameTarget, Texture, texture_bytes, volume_texture
from rtbow.physics.light.spectrum import Spectrum
from rtbow.render.method import Method, ShaderMethod
from rtbow.render.sky.passes import Passes, SkyOf, sky_defines, uploaded
from rtbow.render.sky.wanted import Skies, SkiesAtOnce, Wanted, colours_of, eye_of
from rtbow.render.smooth import drawn_over, smooth_block
from rtbow.world.lights import Sun
from rtbow.world.world import World

_MOST_SPECTRA = 16
"""Of suns whose skies' colours are kept."""


def with_surroundings(
    gl: GlContext,
    method: Method,
    world: World,
    building: Progress = no_progress,
    skies: Skies | None = None,
) -> Method:
    """Give a method that draws what is around a world's drops, too; itself where there is nothing.

    Args:
        gl: the context, current.
        method: which draws the drops.
        world: what it draws.
        building: wraps the loop over orders of scattering, where a sky has to be solved.
        skies: makes skies; left out: each at once, when it is drawn.
    """
    if world.around is None or not world.optics.suns:
        return method
    return Surrounded(gl, method, world, building, skies or SkiesAtOnce())


class Surrounded:
    """A method that adds sky, ground and suns (:class:`rtbow.render.method.Method`).

    Attributes:
        bare: whether it draws the drops' own light alone, for the time being.
    """

    def __init__(
        self, gl: GlContext, method: Method, world: World, building: Progress, skies: Skies
    ) -> None:
        assert world.around is not None
        self._gl, self._method, self._skies = gl, method, skies
        self.bare = False
        skies.solve(world.around, building)
        self._moments: Texture | None = None
        if world.rain is not None and not world.volume.uniform:
            self._moments = volume_texture(gl, world.moments())
        self._passes: dict[int, Passes] = {}
        self._suns: tuple[SkyOf | None, ...] = ()
        self._weighed: list[tuple[Spectrum, tuple[Array, Array]]] = []
        self._world = world
        self._take(world)

    @property
    def name(self) -> ShaderMethod:
        """What the command line calls the method."""
        return self._method.name

    @property
    def drops(self) -> Method:
        """The method that draws the drops."""
        return self._method

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        own = [texture for sun in self._suns if sun for texture in sun.textures.values()]
        passed = [texture for passes in self._passes.values() for texture in passes.textures]
        return self._method.texture_bytes + texture_bytes([*own, *passed])

    def move(self, world: World) -> bool:
        """Take over another world (see :class:`rtbow.render.method.Method`)."""
        same = world.around == self._world.around and sky_defines(world) == sky_defines(self._world)
        if not same or not self._method.move(world):
            return False
        if world.view.size_px != self._world.view.size_px:
            self._passes = {}
        self._take(world)
        return True

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take."""
        self._method.prepare_moves()

    def _take(self, world: World) -> None:
        """Take over a world, with the tables that are there for its suns."""
        assert world.around is not None
        around, suns = world.around, world.optics.suns
        wanted = [Wanted(around, eye_of(world, sun), *self._colours(sun)) for sun in suns]
        kept = {id(sky.table): sky for sky in self._suns if sky}
        made: list[SkyOf | None] = []
        for seen in self._skies.seen(wanted):
            if seen is None:
                made.append(None)
                continue
            eye, table = seen
            sky = kept.get(id(table)) or SkyOf(eye, table, uploaded(self._gl, table, world))
            kept[id(table)] = sky
            made.append(sky)
        self._suns, self._world = tuple(made), world

    def _colours(self, sun: Sun) -> tuple[Array, Array]:
        """What a sun's sky and ground count for, kept while the sun moves: its spectrum stays."""
        assert self._world.around is not None
        for spectrum, colours in self._weighed:
            if spectrum is sun.spectrum:
                return colours
        made = colours_of(self._world.around, sun)
        self._weighed = [*self._weighed[1 - _MOST_SPECTRA :], (sun.spectrum, made)]
        return made

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done."""
        target = self._method.draw(progress, columns)
        if self.bare:
            return target
        world, passes = self._world, self._passes_of(self._world)
        for sun, sky in zip(world.optics.suns, self._suns, strict=True):
            if sky is None:
                continue
            passes.take(world, sun, sky)
            passes.gather()
            with drawn_over(self._gl, target, world.view.size_px, columns):
                passes.compose()
        self._gl.ctx.finish()
        return target

    def _passes_of(self, world: World) -> Passes:
        """The passes for a view: zooming back finds those of before."""
        block = smooth_block(world.view)
        if block not in self._passes:
            self._passes[block] = Passes(self._gl, world, self._moments)
        return self._passes[block]

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        return self.draw(progress, columns).read(columns)
