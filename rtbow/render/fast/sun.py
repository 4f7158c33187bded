"""Method ``fast`` under a sun: paths at nodes, colours at every pixel.

The scattering angle of sunlight is one along a ray, so that colours and path part: what a ray
gathers (the drops' weight, their mean air column, depth of rain and radius) varies slowly over the
picture and is marched at nodes some pixels apart; the colours of its angle come from a table at
every pixel. Blocks of pixels that no straight line follows, at the edges of the rain, march
themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import moderngl
import numpy as np

from rtbow.base.arrays import Progress, no_progress
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import FrameTarget, GlProgram, Texture, added_up, row_texture
from rtbow.physics.air import rayleigh
from rtbow.physics.air.rayleigh import NO_AIR
from rtbow.render.colours.table import ColourTable
from rtbow.render.edges import PixelPass
from rtbow.render.fast import limits
from rtbow.render.fast.columns import SunColumns, is_near, shaded_columns, sunward_columns
from rtbow.render.fast.light import LightPlan, most_texels
from rtbow.render.fast.nodes import Nodes, block_for, draw_into
from rtbow.render.fast.shared import Plan, bind_rain, light_defines, set_scene
from rtbow.render.fast.sun_colours import SunColours, plan_sunlight, sunlight_degree
from rtbow.render.haze import SunHaze, hazy
from rtbow.render.uniforms import set_uniforms, shadow_uniforms
from rtbow.world.lights import Sun
from rtbow.world.steps import most_steps
from rtbow.world.world import World

_MOST_DIRECT = 64
"""The air along a ray through an even volume takes no more midpoint samples than this."""
_MOST_DEPTH = 2000.0
"""Optical depth of rain across the box, at most: 512 steps lie along its diagonal, and from three
times this depth on rounding shows (1300: 0.3 in CIEDE2000; 35,000: 4)."""
_WINDOW = 1.0
"""Tables for moving suns cover ranges of air columns about multiples of this one."""
_PIECES = 3
"""A ray lies before, in and behind the Earth's shadow, if in all of them."""
_GROUPS = 7
"""A pass over the nodes keeps this many groups of four rows of radius: OpenGL 3.3 has eight draw
buffers, of which the path takes one."""


@dataclass(frozen=True)
class SunPlan:
    """How one sun is drawn, decided before the device is touched.

    Attributes:
        plan: the world's.
        sun: the sun.
        sunward: columns of air from it to the drops.
        columns: columns of air from it to the eye by way of the drops, in the tables' range.
        light: what its colours are tabled for.
        degree: of the table's polynomial in the column.
        grey: depth per column that weights carry, which the table leaves out.
        direct: samples of the air along a ray through even drops; 0 for a march.
        block: pixels between nodes; 0 for none.
        groups: of four rows of radius that a pass over the nodes keeps.
        roaming: whether its tables serve other cameras and altitudes of the sun, too.
        shaded: whether the Earth keeps the sun from some of the drops.
    """

    plan: Plan
    sun: Sun
    sunward: SunColumns
    columns: SunColumns
    light: LightPlan
    degree: int
    grey: float
    direct: int
    block: int
    groups: int
    roaming: bool
    shaded: bool

    @property
    def defines(self) -> dict[str, Define]:
        """The switches and constants of all its programs."""
        plan, air, shadow = self.plan, self.plan.world.optics.has_air, self.columns.cubic is None
        levels = self.light.levels
        eye = plan.world.view.eye_m
        near = air and not shadow and is_near(plan.box_m, eye, self.columns.column, self.grey)
        return {
            **light_defines(plan, degree=self.degree, rain=self.light.basis.rain),
            "SUN": True,
            "PARTS": False,
            "SIDES": False,
            "NEAR_AIR": near,
            "SHADOW": air and shadow,
            "PIECES": _PIECES if self.shaded else 1,
            "BLOCKS": self.block > 0,
            "DIRECT": self.direct,
            "LAMP_COUNT": 0,
            "PIXEL_POINTS": 0,
            "PIXEL_LEVELS": 0 if levels is None else len(levels.squared),
            "PIXEL_SHAPES": 0 if levels is None else levels.shapes,
            "HAT_GROUPS": self.groups,
        }

    def moved(self, plan: Plan, sun: Sun) -> SunPlan:
        """Give the plan for the sun and a camera elsewhere, with the same tables."""
        shaded = plan.world.shades(sun)
        still = not (_turned(self.sun, sun) or shaded or self.shaded)
        sunward = self.sunward if still else _sunward(plan, sun)
        columns = _columns(plan, sunward, roaming=self.roaming)
        return replace(
            self, plan=plan, shaded=shaded, sun=sun, sunward=sunward, columns=columns,
            degree=sunlight_degree(self.light, columns.column, roaming=self.roaming),
            grey=self.light.basis.grey(columns.column.middle),
            block=_block(plan) if self.block else 0,
        )  # fmt: skip


def plan_sun(
    plan: Plan, sun: Sun, most_texels: int, *, roaming: bool = False, light: LightPlan | None = None
) -> SunPlan:
    """Decide how a sun is drawn.

    Args:
        plan: the world's.
        sun: the sun.
        most_texels: along a table, that the device takes.
        roaming: with tables that serve other cameras and altitudes of the sun, too.
        light: what its colours are tabled for, where that is decided already.

    Raises:
        UnsuitedError: the method cannot draw it within the world's error.
    """
    world = plan.world
    sunward = _sunward(plan, sun)
    columns = _columns(plan, sunward, roaming=roaming)
    limits.check_depth(plan, _MOST_DEPTH)
    limits.check_haze(plan, sun)
    if light is None:
        light = plan_sunlight(plan, sun, columns.column, most_texels, roaming=roaming)
        if not roaming:  # those serve many frames
            limits.check_cost(plan, light.evaluations)
    # Across the edge of the Earth's shadow a few samples would not do.
    even = world.volume.uniform and world.rain is None and columns.cubic is not None
    block = 0 if even else _block(plan)
    rows = len(plan.radii.rows)
    groups = min(-(-rows // 4), _GROUPS) if rows > 1 and block else 0
    shaded = world.shades(sun)
    limits.check_loops(plan, 1 + groups, _PIECES if shaded else 1)
    return SunPlan(
        plan, sun, sunward, columns, light,
        sunlight_degree(light, columns.column, roaming=roaming),
        light.basis.grey(columns.column.middle),
        direct=_direct_samples(plan) if even else 0,
        block=block,
        groups=groups,
        roaming=roaming,
        shaded=shaded,
    )  # fmt: skip


def _block(plan: Plan) -> int:
    return block_for(plan.world.view, plan.settings.block, rows=len(plan.radii.rows) > 1)


def _sunward(plan: Plan, sun: Sun) -> SunColumns:
    """Columns from a sun to the drops."""
    if not plan.world.optics.has_air:
        return SunColumns(NO_AIR, np.zeros(4))
    if plan.world.shades(sun):
        return shaded_columns(sun, plan.box_m, plan.world.view.eye_m)
    return sunward_columns(sun, plan.box_m)


def _columns(plan: Plan, sunward: SunColumns, *, roaming: bool) -> SunColumns:
    """Columns from a sun to the eye by way of the drops, in a range that tables cover."""
    if not plan.world.optics.has_air:
        return sunward
    seen = sunward.seen(plan.box_m, plan.world.view.eye_m)
    return SunColumns(seen.column.window(_WINDOW), seen.cubic) if roaming else seen


def _direct_samples(plan: Plan) -> int:
    """Samples of the air along any ray through even drops: within 1e-4 of the light."""
    if not plan.world.optics.has_air:
        return 1
    return min(max(most_steps(plan.rates, plan.world.volume), 2), _MOST_DIRECT)


def _turned(before: Sun, sun: Sun) -> bool:
    return sun.altitude_rad != before.altitude_rad or bool(
        np.any(sun.direction != before.direction)
    )


class FastSun:
    """One sun's programs and textures.

    Args:
        gl: the context; it must be current here and in every method.
        plan: the world's.
        number: which of its suns.
        drops: the volume's moments on the device; None for an even one.
        building: wraps the loop over parts of an exact table that has to be built first.
        roaming: make tables that serve other cameras and altitudes of the sun, too.
        colours: of the same sun elsewhere, roaming; baked if left out.

    Raises:
        UnsuitedError: the method cannot draw it within the world's error.
    """

    def __init__(
        self, gl: GlContext, plan: Plan, number: int, drops: moderngl.Texture3D | None,
        building: Progress, *, roaming: bool = False, colours: SunColours | None = None,
    ) -> None:  # fmt: skip
        self._gl, self._number, self._drops = gl, number, drops
        sun = plan.world.optics.suns[number]
        self.plan = plan_sun(
            plan, sun, most_texels(gl), roaming=roaming, light=colours.light if colours else None
        )
        self._colours = colours or SunColours(gl, self.plan.light, building)
        table = self._table()
        self._defines = self.plan.defines
        self._compose = PixelPass(gl, "fast/sun/pixel.frag", self._defines)
        self.marching = [*self._compose.programs]
        self._nodes: Nodes | None = None
        if self.plan.block:
            self._path = GlProgram(gl, "fast/sun/node.frag", self._defines)
            self._flags = GlProgram(gl, "fast/flags.frag", self._defines)
            self.marching.append(self._path)
            if self.plan.groups:
                self._hats = GlProgram(gl, "fast/sun/hats.frag", self._defines)
            self._make_nodes()
        for program in self.marching:
            if drops is not None:
                program.bind("volume.moments", drops)
        if self._defines["SHADOW"]:
            column_texture = row_texture(gl, rayleigh.column_table().log_column)
            for program in self.marching:
                program.bind("air.table", column_texture)
        bind_rain(gl, self.marching, sun, plan.world)
        if hazy(plan.world):
            self._bind_haze(plan.world, sun)
        self._place(*table)

    def _bind_haze(self, world: World, sun: Sun) -> None:
        """Upload what aerosol takes on the way of this sun's light."""
        haze = SunHaze(world, sun)
        depths = row_texture(self._gl, haze.depths[None].astype(np.float32))
        for program in self.marching:
            program.bind("haze.depths", depths)
            set_uniforms(program, haze.uniforms())
            program.set("hazeMiddle", haze.middle)
            program.set("hazeExcess", tuple(haze.excess))

    def _table(self) -> tuple[ColourTable, moderngl.Texture]:
        return self._colours.behind(self.plan.columns.column, self.plan.degree)

    def move(self, plan: Plan) -> bool:
        """Take over a world that differs in where camera and sun are.

        Returns:
            Whether that could be done; if not, nothing has changed.
        """
        before, levels = self.plan, self.plan.light.levels
        if levels is not None and not levels.hold(plan.world.view):
            return False
        after = before.moved(plan, plan.world.optics.suns[self._number])
        if after.defines != self._defines:
            return False
        table = self._colours.behind(after.columns.column, after.degree)
        self.plan = after
        size_px = before.plan.world.view.size_px
        if (after.block, plan.world.view.size_px) != (before.block, size_px) and after.block:
            self._make_nodes()
        if _turned(before.sun, after.sun):
            bind_rain(self._gl, self.marching, after.sun, plan.world)
        self._place(*table)
        return True

    def anew(self, plan: Plan) -> FastSun:
        """Make this sun anew, for a plan that it cannot move to; it must be a roaming one."""
        levels = self.plan.light.levels
        same = levels is None or levels.hold(plan.world.view)
        return FastSun(
            self._gl, plan, self._number, self._drops, no_progress,
            roaming=True, colours=self._colours if same else None,
        )  # fmt: skip

    def _place(self, table: ColourTable, texture: moderngl.Texture) -> None:
        """Set all that depends on where camera and sun are."""
        sun, columns = self.plan.sun, self.plan.columns
        self.table = table
        shadow = shadow_uniforms(sun, self.plan.plan.world.view.eye_m)
        self._compose.place(self.plan.plan.world.view, self.plan.plan.box_m)
        for program in self.marching:
            program.bind("table.values", texture)
            set_scene(program, self.plan.plan, self.plan.grey)
            program.set("air.reach", columns.column.reach)
            program.set("sunDirection", tuple(sun.direction))
            middle = columns.column.middle
            if columns.cubic is not None:
                program.set("air.sunward", (columns.cubic[0] - middle, *columns.cubic[1:]))
            program.set("air.sunAltitude", sun.altitude_rad)
            program.set("air.middle", middle)
            for name, value in shadow.items():
                program.set(f"air.shadow.{name}", value)
            program.set("table.first", table.first)
            program.set("table.perChord", table.per_chord)
            levels = self.plan.light.levels
            if levels is not None:
                program.set("table.leastExtent", levels.first)
                program.set("table.blur", levels.blur)
                program.set("table.perLevel", levels.per_level)

    def _make_nodes(self) -> None:
        world, settings = self.plan.plan.world, self.plan.plan.settings
        # Weight, column and depth, as far as the scene has them.
        channels = 4 if self.plan.light.basis.rain else (2 if world.optics.has_air else 1)
        channels = 4 if hazy(world) else channels
        nodes = Nodes(self._gl, world.view.size_px, self.plan.block, channels, self.plan.groups)
        for group, weights in enumerate(nodes.weights):
            self._hats.bind(f"hats{group}", weights)
        for program in (self._compose, self._flags):
            program.bind("nodes", nodes.values)
            if nodes.atlas is not None:
                program.bind("hats", nodes.atlas)
        self._compose.bind("flags", nodes.flags)
        # Errors of the mean column and depth enter the colours alone, since the weight carries a
        # grey air's attenuation and the rain's at 550 nm. Per column, X, Y and Z change by their
        # own depth less the grey one: up to 0.12 for Z and 0.013 for X and Y, so that four times
        # the tolerance makes half of it in Z. Per depth of rain they change by its ratio to that at
        # 550 nm less 1: up to 0.03 for drops from 5 µm and 0.1 from 2 µm, so that ten times makes
        # all of it at most; only drops of 1 µm reach 3.5 times, in Z.
        bend = settings.bend
        self._flags.set("tolerance.first", bend)
        # Per depth of haze they change by its excess over that at 550 nm: up to 0.3.
        self._flags.set("tolerance.others", (4.0 * bend, 10.0 * bend, 3.0 * bend))
        self._flags.set("leastShare", 1e-4)
        for program in (self._compose, self._path):
            program.set("blockSize", float(nodes.block))
        self._nodes = nodes

    @property
    def textures(self) -> list[Texture]:
        """All textures that its programs read."""
        programs = [*self._compose.programs]
        if self._nodes is not None:
            programs += [self._path, self._flags]
        if self.plan.groups:
            programs.append(self._hats)
        return self._colours.textures + [
            texture for program in programs for texture in program.textures.values()
        ]

    def draw(self, target: FrameTarget, *, add: bool) -> None:
        """Draw its light into a frame, adding to what is there or in its place."""
        rows = len(self.plan.plan.radii.rows)
        for row in range(0, rows, 4 * self.plan.groups or rows):
            self._prepare(row)
            target.use()
            self._compose.set("hatRow", float(row))
            self._compose.set("marching", row == 0)
            with added_up(self._gl, add or row > 0):
                self._compose.draw()

    def _prepare(self, row: int) -> None:
        """Gather the paths at the nodes, with the weights of some rows of radius."""
        nodes = self._nodes
        if nodes is None:
            return
        self._path.set("firstRow", float(row))
        draw_into(nodes.gathered, self._path)
        if nodes.side_by_side is not None:
            draw_into(nodes.side_by_side, self._hats)
        draw_into(nodes.flagged, self._flags)
