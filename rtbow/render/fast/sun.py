"""Method ``fast`` under a sun: paths at nodes, colours at every pixel.

The scattering angle of sunlight is one along a ray, so that colours and path part: what a ray
gathers (the drops' weight, their mean air column, depth of rain and radius) varies slowly over the
picture and is marched at nodes some pixels apart; the colours of its angle come from a table at
every pixel. Blocks of pixels that no straight line follows, at the edges of the rain, march
themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from rtbow.base.arrays import Progress, no_progress
from rtbow.gl.glsl import Define
from rtbow.gl.program import (
    FrameTarget,
    GlProgram,
    Texture,
    added_up,
    row_texture,
)
from rtbow.physics.air import rayleigh
from rtbow.physics.air.rayleigh import NO_AIR
from rtbow.render.fast.columns import SunColumns, is_near, sunward_columns
from rtbow.render.fast.shared import (
    FastScene,
    bind_rain,
    block_for,
    blocks_of,
    check_loops,
    flag_target,
    scene_defines,
    set_scene,
)
from rtbow.render.fast.sun_colours import SunColours, SunTable
from rtbow.world.lights import Sun
from rtbow.world.steps import most_steps

_MOST_DIRECT = 64
"""Midpoint samples of the air along a ray through an even volume, at most."""


_WINDOW = 1.0
"""Steps of air column that tables for moving suns lie apart."""
_GROUPS = 7
"""Groups of four rows of radius that a pass over the nodes keeps: draw buffers, less the path's."""


@dataclass
class _Nodes:
    """Targets at the corners of blocks of pixels."""

    paths: moderngl.Framebuffer
    hats: moderngl.Framebuffer | None
    flags: moderngl.Framebuffer


class FastSun:
    """One sun's programs and textures.

    Args:
        here: the scene, whose GL context must be current here and in every method.
        number: which of its suns.
        building: wraps the loop over parts of an exact table that has to be built first.
        roaming: make tables that serve other cameras and altitudes of the sun, too.
        colours: of the same sun elsewhere, roaming; baked if left out.
    """

    def __init__(
        self, here: FastScene, number: int, building: Progress, *, roaming: bool = False,
        colours: SunColours | None = None,
    ) -> None:  # fmt: skip
        self._here, self._number, self._roaming = here, number, roaming
        self._sunward = self._sunward_columns(here)
        columns = self._columns(here, self._sunward)
        self._colours = colours or SunColours(
            here, number, columns.column, building, roaming=roaming
        )
        tabled = self._colours.behind(columns.column)
        self.table = tabled.table
        parts, settings = here.parts, here.settings
        # Across the edge of the Earth's shadow a few samples would not do.
        even = parts.volume.uniform and parts.rain is None and columns.cubic is not None
        self._block = 0 if even else block_for(here.scene.camera, settings.block)
        self._size_px = here.scene.camera.size_px
        rows = self.table.rows
        self._groups = min(-(-rows // 4), _GROUPS) if rows > 1 and self._block else 0
        self._defines: dict[str, Define] = {
            **scene_defines(here, self.table),
            "SUN": True,
            "NODES": False,
            "PARTS": False,
            **self._air_defines(here, columns, tabled.grey),
            "BLOCKS": self._block > 0,
            "DIRECT": self._direct_samples() if even else 0,
            "HAT_GROUPS": self._groups,
        }
        self._compose = GlProgram(here.gl, "fast/sun/pixel.frag", self._defines)
        self._marching = [self._compose]
        self._nodes: _Nodes | None = None
        if self._block:
            self._path = GlProgram(here.gl, "fast/sun/node.frag", {**self._defines, "NODES": True})
            self._flags = GlProgram(here.gl, "fast/flags.frag", self._defines)
            self._marching.append(self._path)
            if self._groups:
                self._hats = GlProgram(here.gl, "fast/sun/hats.frag", self._defines)
            self._nodes = self._make_nodes()
        for program in self._marching:
            if here.drops is not None:
                program.bind("dropletMoments", here.drops)
        if self._defines["SHADOW"]:
            column_texture = row_texture(here.gl, rayleigh.column_table().log_column)
            for program in self._marching:
                program.bind("columnTable", column_texture)
        bind_rain(self._marching, self._sun, here)
        check_loops(here, 1 + self._groups)
        self._place(columns, tabled)

    @property
    def _sun(self) -> Sun:
        return self._here.parts.optics.suns[self._number]

    def move(self, here: FastScene) -> bool:
        """Take over a scene that differs in where camera and sun are.

        Returns:
            Whether that could be done; if not, nothing has changed.
        """
        turned = self._has_turned(here)
        sunward = self._sunward_columns(here) if turned else self._sunward
        columns = self._columns(here, sunward)
        tabled = self._colours.behind(columns.column)
        kept = {name: self._defines[name] for name in ("NEAR_AIR", "SHADOW")}
        if tabled.table.degree != self.table.degree:
            return False
        if self._air_defines(here, columns, tabled.grey) != kept:
            return False
        camera = here.scene.camera
        block = block_for(camera, here.settings.block) if self._block else 0
        if self._block and not block:
            return False
        self._here, self._sunward = here, sunward
        if (block, camera.size_px) != (self._block, self._size_px):
            self._block, self._size_px = block, camera.size_px
            self._nodes = self._make_nodes() if block else None
        if turned:
            bind_rain(self._marching, self._sun, here)
        self._place(columns, tabled)
        return True

    def anew(self, here: FastScene) -> FastSun:
        """Make the programs of a sun that could not move; it must be a roaming one."""
        return FastSun(here, self._number, no_progress, roaming=True, colours=self._colours)

    def _has_turned(self, here: FastScene) -> bool:
        sun = here.parts.optics.suns[self._number]
        return sun.altitude_rad != self._sun.altitude_rad or bool(
            np.any(sun.direction != self._sun.direction)
        )

    def _direct_samples(self) -> int:
        """Samples of the air along any ray through even drops: within 1e-4 of the light."""
        parts = self._here.parts
        if not parts.optics.has_air:
            return 1
        return min(max(most_steps(self._here.rates, parts.volume), 2), _MOST_DIRECT)

    def _sunward_columns(self, here: FastScene) -> SunColumns:
        """Columns from the sun to the drops."""
        if not here.parts.optics.has_air:
            return SunColumns(NO_AIR, np.zeros(4))
        return sunward_columns(here.parts.optics.suns[self._number], here.box_m)

    def _columns(self, here: FastScene, sunward: SunColumns) -> SunColumns:
        """Columns of the scene, in a range that its tables cover."""
        if not here.parts.optics.has_air:
            return sunward
        found = sunward.seen(here.box_m, here.parts.eye_m)
        if not self._roaming:
            return found
        return SunColumns(found.column.window(_WINDOW), found.cubic)

    def _air_defines(self, here: FastScene, columns: SunColumns, grey: float) -> dict[str, Define]:
        air, shadow = here.parts.optics.has_air, columns.cubic is None
        near = air and not shadow and is_near(here.box_m, here.parts.eye_m, columns.column, grey)
        return {"NEAR_AIR": near, "SHADOW": air and shadow}

    def _place(self, columns: SunColumns, tabled: SunTable) -> None:
        """Set all that depends on where camera and sun are."""
        sun = self._sun
        self.table = tabled.table
        for program in self._marching:
            program.bind("colours", tabled.texture)
            set_scene(program, self._here, tabled.grey)
            program.set("columnReach", columns.column.reach)
            program.set("sunDirection", tuple(sun.direction))
            middle = columns.column.middle
            if columns.cubic is not None:
                program.set("sunCubic", (columns.cubic[0] - middle, *columns.cubic[1:]))
            program.set("sunShadow", (sun.altitude_rad, middle))
            program.set("chordAxis", (self.table.first, self.table.per_chord))

    def _make_nodes(self) -> _Nodes:
        blocks = blocks_of(self._here.scene.camera.size_px, self._block)
        size = blocks[0] + 3, blocks[1] + 3  # a ring more than the blocks' corners
        ctx = self._here.gl.ctx
        air, rain = self._here.parts.optics.has_air, self.table.rain
        nodes = ctx.texture(size, 4 if rain else (2 if air else 1), dtype="f4")
        flags = flag_target(self._here.gl, blocks)
        weights = [ctx.texture(size, 4, dtype="f4") for _ in range(self._groups)]
        hats = None
        if self._groups:
            for g, one in enumerate(weights):
                self._hats.bind(f"hats{g}", one)
            atlas = ctx.texture((size[0], size[1] * self._groups), 4, dtype="f4")
            hats = ctx.framebuffer([atlas])
            for program in (self._compose, self._flags):
                program.bind("hats", atlas)
        nodes.repeat_x = nodes.repeat_y = False
        self._flags.bind("nodes", nodes)
        self._compose.bind("nodes", nodes)
        self._compose.bind("flags", flags)
        bend = self._here.settings.bend
        # A path's mean column and depth enter the light by far smaller shares.
        self._flags.set("tolerance", (bend, 4.0 * bend, 10.0 * bend, 1e30))
        self._flags.set("leastShare", 1e-4)
        for program in (self._compose, self._path):
            program.set("blockSize", float(self._block))
        return _Nodes(ctx.framebuffer([nodes, *weights]), hats, ctx.framebuffer([flags]))

    @property
    def textures(self) -> list[Texture]:
        """All textures that its programs read."""
        programs = [self._compose]
        if self._nodes is not None:
            programs += [self._path, self._flags]
        if self._groups:
            programs.append(self._hats)
        return self._colours.textures + [
            one for program in programs for one in program.textures.values()
        ]

    def draw(self, target: FrameTarget, *, add: bool) -> None:
        """Draw its light into a frame, adding to what is there or in its place."""
        for row in range(0, self.table.rows, 4 * self._groups or self.table.rows):
            self._prepare(row)
            target.use()
            self._compose.set("hatRow", float(row))
            self._compose.set("marching", row == 0)
            with added_up(self._here.gl, add or row > 0):
                self._compose.use()
                self._compose.draw()

    def _prepare(self, row: int) -> None:
        """Gather the paths at the nodes, with the weights of some rows of radius."""
        if self._nodes is None:
            return
        self._nodes.paths.use()
        self._path.set("firstRow", float(row))
        self._path.use()
        self._path.draw()
        if self._nodes.hats is not None:
            self._nodes.hats.use()
            self._hats.use()
            self._hats.draw()
        self._nodes.flags.use()
        self._flags.use()
        self._flags.draw()
