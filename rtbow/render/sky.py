"""What is around the drops, drawn over a frame of what they scatter: sky, ground and suns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, floats, no_progress
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import (
    FrameTarget,
    GlProgram,
    Texture,
    added_up,
    row_texture,
    texture_bytes,
    volume_texture,
)
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS, xyz_to_rgb
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.render.fast.nodes import Nodes, block_for
from rtbow.render.method import Method, ShaderMethod
from rtbow.render.uniforms import common_defines, common_uniforms, set_uniforms
from rtbow.tables.sky.field import FIELD_NM, between_field_nm
from rtbow.tables.sky.light import Scattered
from rtbow.tables.sky.rays import FALLING, RISING, Eye
from rtbow.tables.sky.seen import SkyTable, sky_table
from rtbow.world.lights import Sun
from rtbow.world.sky import Surroundings
from rtbow.world.steps import StepRates
from rtbow.world.world import World

_LAYERS = 20
"""Distances up to which the air's light is told apart, where rain dims it: their roots are even up
to the box's far end."""
_STEPS = 8
"""Of a ray through rain that dims, at whose ends the air's light is looked up."""
_GRID_SAMPLES = 3
"""Of the rain within each, in a grid: 24 in all leave CIEDE2000 0.14 at the 99th percentile of
``shower``, 48 leave 0.03."""
_MOST_PIXELS = 8
"""Between nodes."""
_ROUGH = 1e-2
"""Of a block's luminance: where straight lines between its nodes seem to miss by more, its pixels
are drawn one by one."""


@dataclass(frozen=True, eq=False)
class Wanted:
    """A sky that is asked for.

    Attributes:
        around: the air and the ground.
        eye: where from, and under what sun.
        colours: see :func:`rtbow.tables.sky.seen.sky_table`.
        ground: see there.
    """

    around: Surroundings
    eye: Eye
    colours: Array
    ground: Array

    @property
    def place(self) -> tuple[object, ...]:
        """All that tells it from other skies of its air."""
        eye = self.eye
        return (
            eye.height_m, eye.sun_altitude_rad, eye.polarised, eye.distances_m.tobytes(),
            self.colours.tobytes(),
        )  # fmt: skip

    def same_as(self, other: Wanted) -> bool:
        """Whether another one asks for the same sky."""
        return self.place == other.place and self.around == other.around

    def made(self, field: Scattered) -> SkyTable:
        """Sum the sky from what its air has scattered: some tenths of a second."""
        air, glow = self.around.air(FIELD_NM), float(self.around.glows)
        return sky_table(air, field, glow, self.eye, self.colours, self.ground)


Seen = tuple[Eye, SkyTable]
"""A sky, and the eye that sees it."""


class Skies(Protocol):
    """Makes the skies that are drawn, at once or beside the pictures."""

    def solve(self, around: Surroundings, building: Progress) -> None:
        """See to it that what air has scattered is known, or will be.

        Args:
            around: the air and the ground.
            building: wraps the loop over orders of scattering, where they are not kept.
        """

    def seen(self, wanted: Sequence[Wanted]) -> list[Seen | None]:
        """Give skies, or what stands in for them; None where nothing can.

        A sky that was given before is the same object.
        """


class SkiesAtOnce:
    """Makes the skies of one air when they are asked for (:class:`Skies`)."""

    def __init__(self) -> None:
        self._made: dict[tuple[object, ...], Seen] = {}

    def solve(self, around: Surroundings, building: Progress) -> None:
        """Solve for what air has scattered, or take it from the cache."""
        self._field = around.field(building)

    def seen(self, wanted: Sequence[Wanted]) -> list[Seen | None]:
        """Give skies; those of before that are asked for again are kept."""
        before, self._made = self._made, {}
        for one in wanted:
            self._made[one.place] = before.get(one.place) or (one.eye, one.made(self._field))
        return [self._made[one.place] for one in wanted]


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
        self._passes = _Passes(gl, world, self._moments)
        self._suns: tuple[_SkyOf | None, ...] = ()
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
        return self._method.texture_bytes + texture_bytes([*own, *self._passes.textures])

    def move(self, world: World) -> bool:
        """Take over another world (see :class:`rtbow.render.method.Method`)."""
        same = world.around == self._world.around and _defines(world) == _defines(self._world)
        if not same or not self._method.move(world):
            return False
        if world.view.size_px != self._world.view.size_px:
            self._passes = _Passes(self._gl, world, self._moments)
        self._take(world)
        return True

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take."""
        self._method.prepare_moves()

    def _take(self, world: World) -> None:
        """Take over a world, with the tables that are there for its suns."""
        assert world.around is not None
        around, suns = world.around, world.optics.suns
        wanted = [Wanted(around, _eye(world, sun), *_colours(around, sun)) for sun in suns]
        kept = {id(sky.table): sky for sky in self._suns if sky}
        made: list[_SkyOf | None] = []
        for seen in self._skies.seen(wanted):
            if seen is None:
                made.append(None)
                continue
            eye, table = seen
            sky = kept.get(id(table)) or _SkyOf(eye, table, _textures(self._gl, table, world))
            kept[id(table)] = sky
            made.append(sky)
        self._suns, self._world = tuple(made), world

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done."""
        target = self._method.draw(progress, columns)
        if self.bare:
            return target
        world, passes = self._world, self._passes
        width, height = world.view.size_px
        left, right, _ = columns.indices(width)
        for sun, sky in zip(world.optics.suns, self._suns, strict=True):
            if sky is None:
                continue
            passes.take(world, sun, sky)
            passes.gather()
            frame = target.begin(clear=False)
            frame.scissor = (left, 0, right - left, height)
            with added_up(self._gl):
                passes.compose()
        self._gl.ctx.finish()
        frame = target.begin(clear=False)
        frame.scissor = (0, 0, width, height)
        return target

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        return self.draw(progress, columns).read(columns)


class _Passes:
    """The programs that draw the sky of one sun after another: at nodes some pixels apart, between
    them where that is smooth, and pixel by pixel in the other blocks.

    Attributes:
        textures: that are read, but those of a sun.
    """

    def __init__(self, gl: GlContext, world: World, moments: Texture | None) -> None:
        block = block_for(world.view, _MOST_PIXELS)
        defines = {**_defines(world), "BLOCKS": block > 0}
        vertex = "fast/rough.vert" if block else "common/fullscreen.vert"
        self._pixel = GlProgram(gl, "sky/pixel.frag", defines, vertex)
        self._along = [self._pixel]
        self.textures: list[Texture] = []
        self._nodes: Nodes | None = None
        if block:
            self._nodes = nodes = Nodes(gl, world.view.size_px, block, channels=4)
            self._node = GlProgram(gl, "sky/node.frag", defines)
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
            self._pixel.set("pictureSize", tuple(map(float, world.view.size_px)))
            self.textures += [nodes.values, nodes.flags]
        if moments is not None:
            for program in self._along:
                program.bind("volume.moments", moments)
            self.textures.append(moments)

    def take(self, world: World, sun: Sun, sky: _SkyOf) -> None:
        """Take over a world and one of its suns."""
        no_rates = StepRates(np.zeros(3), 0.0)
        uniforms = {
            **common_uniforms(world, world.volume.box_m, no_rates),
            **_sun_uniforms(world, sun, sky),
        }
        for program in self._along:
            for name, texture in sky.textures.items():
                program.bind(name, texture)
            set_uniforms(program, uniforms)
        if self._nodes is not None:
            beside = 2.0 * self._nodes.block * world.view.pixel_rad
            near = 2.0 * np.sin(0.5 * sun.disc_rad) + beside if sun.disc_radiance > 0.0 else 0.0
            self._node.set("nearSun", near)

    def gather(self) -> None:
        """Draw the nodes."""
        if self._nodes is None:
            return
        for frame, program in (
            (self._nodes.gathered, self._node), (self._nodes.flagged, self._flags),
        ):  # fmt: skip
            frame.use()
            program.use()
            program.draw()

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


@dataclass(frozen=True)
class _SkyOf:
    """The sky under one sun on the device.

    Attributes:
        eye: which sees it.
        table: its numbers.
        textures: by the names of their samplers.
    """

    eye: Eye
    table: SkyTable
    textures: Mapping[str, Texture]


def _eye(world: World, sun: Sun) -> Eye:
    """Where from and under what a sun's sky is seen."""
    eye, distances = world.view.eye_m, np.zeros(0)
    if world.rain is not None:
        corners = np.maximum(np.abs(world.volume.box_m - eye).max(axis=0), 1.0)
        farthest = float(np.linalg.norm(corners))
        distances = farthest * np.linspace(0.0, 1.0, _LAYERS) ** 2
    polarised = world.view.polarizer is not None
    assert world.around is not None
    height = float(world.around.above_ground(eye)[2])
    return Eye(height, sun.altitude_rad, distances, polarised)


def _colours(around: Surroundings, sun: Sun) -> tuple[Array, Array]:
    """What a radiance per irradiance at each of ``FIELD_NM`` counts for in R, G and B (W, 3): that
    of cubics through them, under the sun's spectrum at 1 nm; and what one that the ground sends
    back does, whose albedo may have edges between them."""
    bins = wavelength_bins(1.0)
    xyz = colour_weights(sun.spectrum, bins)
    shares = between_field_nm(bins.wavelength_nm).T
    sent = around.ground_light(bins.wavelength_nm)[:, None] * xyz
    return xyz_to_rgb(shares @ xyz), xyz_to_rgb(shares @ sent)


def _textures(gl: GlContext, table: SkyTable, world: World) -> dict[str, Texture]:
    """Upload a sky."""
    textures: dict[str, Texture] = {
        "sky.whole": row_texture(gl, _stacked(table.layers[-1] + table.ground)),
        "sky.beyond": row_texture(gl, table.beyond[None]),
    }
    if table.glare is not None and table.phase is not None:
        textures["sky.glare"] = row_texture(gl, _stacked(table.glare[-1]))
        textures["sky.phase"] = row_texture(gl, table.phase.T[None])
    if table.mirror is not None:
        mirror = table.mirror
        blocks = [mirror.sky] if mirror.glare is None else [mirror.sky, mirror.glare]
        textures["sky.mirror"] = row_texture(gl, _stacked(np.concatenate(blocks)))
        textures["sky.beyondMirror"] = row_texture(gl, mirror.beyond)
    if world.rain is not None:
        for name, part in (("sky.layers", table.layers), ("sky.glareLayers", table.glare)):
            if part is not None:
                textures[name] = volume_texture(gl, np.stack([_stacked(one) for one in part[:-1]]))
    return textures


def _stacked(blocks: Float32) -> Float32:
    """Lay blocks of rows (B, rows, columns, 3) above each other."""
    return blocks.reshape(-1, *blocks.shape[2:])


def _defines(world: World) -> dict[str, Define]:
    assert world.around is not None
    ground = world.around.ground
    return {
        **common_defines(world),
        "WATER": ground is not None and ground.water,
        "LUMINANCE": f"vec3({', '.join(f'{weight:.9f}' for weight in LUMINANCE_WEIGHTS)})",
        "PARTS": True,
        "SEVERAL_RADII": False,
        "SIDES": True,
        "SKY_RISING": RISING,
        "SKY_FALLING": FALLING,
        "SKY_STEPS": _STEPS,
        "SKY_SAMPLES": 1 if world.volume.uniform else _GRID_SAMPLES,
    }


def _sun_uniforms(world: World, sun: Sun, sky: _SkyOf) -> dict[str, Any]:
    level = float(np.hypot(*sun.direction[:2]))
    azimuth = sun.direction[:2] / level if level > 0.0 else floats([0.0, 1.0])
    uniforms: dict[str, Any] = {
        "sky.horizon": sky.table.horizon_rad,
        "sky.azimuth": tuple(azimuth),
        "sky.towards": tuple(sun.direction),
        "sky.disc": 2.0 * np.sin(0.5 * sun.disc_rad),
        "sky.brightness": sun.disc_radiance,
    }
    if world.rain is not None:
        uniforms["sky.farthest"] = float(sky.eye.distances_m[-1])
    if sky.table.mirror is not None:
        uniforms["sky.height"] = sky.eye.height_m
    return uniforms
