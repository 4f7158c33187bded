"""Method ``fast`` under a lamp: few steps at every pixel, what they miss from nodes.

A lamp's light comes under all angles along a ray, so that colours and path do not part as under a
sun. But the colours' running integral over the angle makes a step of any width exact where the
drops are even, and what a few steps miss of uneven drops varies slowly over the picture.
"""

from __future__ import annotations

import math

import numpy as np

from rtbow.base.arrays import (
    Array,
    Float32,
    Progress,
    floats,
    no_progress,
)
from rtbow.base.errors import UnsuitedError
from rtbow.gl.glsl import Define
from rtbow.gl.program import (
    FrameTarget,
    GlProgram,
    Texture,
    added_up,
    row_texture,
)
from rtbow.physics.air.rayleigh import NO_AIR, Column
from rtbow.render.colours.basis import column_degree
from rtbow.render.colours.table import (
    ColourTable,
    bow_width,
    chords,
    colour_table,
    folded_chord,
    unfolded,
)
from rtbow.render.fast.columns import lamp_column
from rtbow.render.fast.light import bake_light, most_texels
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
from rtbow.tables.layout import running_integral
from rtbow.world.lights import NEAREST_M, Lamp
from rtbow.world.steps import lamp_steps, most_steps

_FEW_STEPS = 1
"""Steps at every pixel, whose error nodes make good."""
_MOST_AIR_STEPS = 16
"""Steps through even drops in air, at most."""
_LEAST_TEXELS = 4.0
"""Range of the running integral that keeps its digits in float32."""
_DISC_ROWS = 64
_LEAST_BLUR = 0.05
"""Part of a fringe's width that a disc must have to blur anything."""
_MOST_RATIO = 10.0
"""Lamp's radius over the distance at which a ray passes its centre, at most: rays that come nearer
meet drops in front of and behind the lamp only, where angles are all but 0 or pi."""
_WIDE_DISC = 4.0
"""Disc of a lamp seen from the eye, in bows' widths, up to which five nodes over it do for drops of
several radii: error 0.4 in CIEDE2000."""
_MOST_NODES = 32
"""Nodes over a disc, at most: wider discs than those suffice for are met within some radii of the
lamp only."""


class FastLamp:
    """One lamp's programs and textures.

    Args:
        here: the scene, whose GL context must be current here and in every method.
        number: which of its lamps.
        building: wraps the loop over parts of an exact table that has to be built first.
        roaming: make tables that serve other places of camera and lamp, too.
    """

    def __init__(
        self, here: FastScene, number: int, building: Progress, *, roaming: bool = False
    ) -> None:
        self._here, self._number = here, number
        gl, scene, parts, settings = here.gl, here.scene, here.parts, here.settings
        lamp, volume, air = self._lamp, parts.volume, parts.optics.has_air
        self._column = self._reach(here)
        if roaming and air:
            self._column = Column(0.0, 2.0 * self._column.high)
        fringe = bow_width(volume.size_range_um[1] * 1e-6)
        wide = lamp.radius_m / max(float(np.linalg.norm(lamp.position_m - parts.eye_m)), 1e-3)
        if len(here.radii.rows) > 1 and wide > _WIDE_DISC * settings.share * fringe:
            raise UnsuitedError(
                f"light.diameter_m = {2.0 * lamp.radius_m:g}: method fast does not follow fringes"
                " of drops of several radii under so large a lamp; use --method spectral, a smaller"
                " diameter, or a larger render.max_delta_e"
            )
        chord = chords(0.0, np.pi, fringe / settings.texels_per_fringe, most_texels(here))
        baked = bake_light(here, lamp.spectrum, self._column, chord, building)
        self._grey = baked.basis.grey(self._column.middle)
        degree = column_degree(baked.basis, self._column, settings.colour)
        self.table = colour_table(baked, self._column, degree)
        even = volume.uniform and parts.rain is None
        self._block = 0 if even else block_for(scene.camera, settings.lamp_block)
        self._size_px = scene.camera.size_px
        defines: dict[str, Define] = {
            **scene_defines(here, self.table),
            "NEAREST_M": NEAREST_M,
            "LAMP_COUNT": 1,
            "LAMP_DISC": lamp.radius_m > 0.0,
            "BLOCKS": self._block > 0,
            "EVEN": even,
            "EVEN_STEPS": self._air_steps() if air and even else 1,
            "LEAST_TEXELS": _LEAST_TEXELS,
            "DISC_ROWS": _DISC_ROWS,
            "PARTS": True,
            "HAT_GROUPS": 0,
        }
        self._compose = GlProgram(gl, "fast/lamp/pixel.frag", defines)
        self._marching = [self._compose]
        if self._block:
            self._node = GlProgram(gl, "fast/lamp/node.frag", defines)
            self._flags = GlProgram(gl, "fast/flags.frag", {**defines, "SEVERAL_RADII": False})
            self._marching.append(self._node)
            self._make_nodes()
        self._bind(chord, fringe)
        self._place()

    @property
    def _lamp(self) -> Lamp:
        return self._here.parts.optics.lamps[self._number]

    def move(self, here: FastScene) -> bool:
        """Take over a scene that differs in where camera and lamp are.

        Returns:
            Whether that could be done; if not, nothing has changed.
        """
        if self._reach(here).high > self._column.high:
            return False
        camera = here.scene.camera
        block = block_for(camera, here.settings.lamp_block) if self._block else 0
        if self._block and not block:
            return False
        before, self._here = self._lamp, here
        if (block, camera.size_px) != (self._block, self._size_px):
            self._block, self._size_px = block, camera.size_px
            if block:
                self._make_nodes()
        if np.any(before.position_m != self._lamp.position_m):
            bind_rain(self._marching, self._lamp, here)
        self._place()
        return True

    def anew(self, here: FastScene) -> FastLamp:
        """Make a lamp that could not move, for places farther away."""
        return FastLamp(here, self._number, no_progress, roaming=True)

    def _air_steps(self) -> int:
        """Steps through even drops in air, a power of two: each halves the one before."""
        wanted = most_steps(self._here.rates, self._here.parts.volume)
        return min(max(1 << math.ceil(math.log2(wanted)), 2), _MOST_AIR_STEPS)

    def _reach(self, here: FastScene) -> Column:
        if not here.parts.optics.has_air:
            return NO_AIR
        return lamp_column(here.parts.optics.lamps[self._number], here.box_m, here.parts.eye_m)

    def _bind(self, chord: Array, fringe: float) -> None:
        """Upload what stays, wherever camera and lamp are."""
        here, lamp, table = self._here, self._lamp, self.table
        colours = table.values[: table.rows * table.components]
        running = running_colours(floats(colours), unfolded(chord))
        first = _LEAST_BLUR * fringe
        if lamp.radius_m > 0.0 and table.rows == 1:
            ratios = np.geomspace(first, _MOST_RATIO, _DISC_ROWS - 1)
            running = over_discs(table, chord, ratios, fringe)
        textures = row_texture(here.gl, table.values), row_texture(here.gl, running)
        per_fold = (_DISC_ROWS - 2) / float(np.log(_MOST_RATIO / first))
        for program in self._marching:
            program.bind("colours", textures[0])
            program.bind("runningColours", textures[1])
            program.set("discRows", (float(np.log(first)), per_fold))
            program.set("chordAxis", (table.first, table.per_chord))
            if here.drops is not None:
                program.bind("dropletMoments", here.drops)
        bind_rain(self._marching, lamp, here)
        check_loops(here, 2)

    def _place(self) -> None:
        """Set all that depends on where camera and lamp are."""
        here, lamp = self._here, self._lamp
        steps = here.settings.lamp_scale * lamp_steps(here.rates, here.parts.volume)
        many = here.scene.render.steps or int(np.ceil(steps))
        for program in self._marching:
            set_scene(program, here, self._grey)
            program.set("lampSphere", (*(lamp.position_m - here.parts.eye_m), lamp.radius_m))
            program.set("columnReach", self._column.reach)
            program.set("middleAir", self._column.middle)
            program.set("fewSteps", _FEW_STEPS if self._block else many)
            program.set("manySteps", many)

    def _make_nodes(self) -> None:
        blocks = blocks_of(self._here.scene.camera.size_px, self._block)
        ctx = self._here.gl.ctx
        nodes = ctx.texture((blocks[0] + 3, blocks[1] + 3), 4, dtype="f4")
        nodes.repeat_x = nodes.repeat_y = False
        flags = flag_target(self._here.gl, blocks)
        self._flags.bind("nodes", nodes)
        self._compose.bind("nodes", nodes)
        self._compose.bind("flags", flags)
        self._node_frame = ctx.framebuffer([nodes])
        self._flag_frame = ctx.framebuffer([flags])
        bend = self._here.settings.lamp_bend
        self._flags.set("tolerance", (1e30, bend, bend, bend))
        for program in (self._compose, self._node):
            program.set("blockSize", float(self._block))

    @property
    def textures(self) -> list[Texture]:
        """All textures that its programs read."""
        return [one for program in self._marching for one in program.textures.values()]

    def draw(self, target: FrameTarget, *, add: bool) -> None:
        """Draw its light into a frame, adding to what is there or in its place."""
        if self._block:
            for frame, program in ((self._node_frame, self._node), (self._flag_frame, self._flags)):
                frame.use()
                program.use()
                program.draw()
        target.use()
        with added_up(self._here.gl, add):
            self._compose.use()
            self._compose.draw()


def running_colours(colours: Array, theta: Array) -> Float32:
    """Give the running integral of colours (rows, N, 4) over the angle (N,).

    Counted from the right angle, so that the bows, on which it has to keep its digits, are not
    counted from the forward peak.
    """
    total = running_integral(colours.transpose(0, 2, 1), theta)
    return np.asarray(total.transpose(0, 2, 1), dtype=np.float32)


def over_discs(table: ColourTable, chord: Array, ratios: Array, fringe_rad: float) -> Float32:
    """Give running integrals of colours averaged over a lamp's disc, along rays that pass it.

    A drop at the scattering angle theta sees a disc of the angular radius asin(q sin(theta)) with
    one ratio q along a ray, the lamp's radius over its distance from the ray's line. Means are
    across the disc's chords as if it were flat.

    Args:
        table: colours of one radius, under a point.
        chord: folded chords of its columns (N,).
        ratios: q (D,), ascending.
        fringe_rad: width of the finest detail.

    Returns:
        float32 (components * (D + 1), N, 4); the first row of each component is a point's.
    """
    theta = unfolded(chord)
    colours = table.values[: table.components].astype(np.float64)
    per_chord = (len(chord) - 1) / (chord[-1] - chord[0])
    rows = [colours]
    for ratio in ratios:
        disc = np.arcsin(np.minimum(ratio * np.sin(theta), 1.0))
        count = min(4 + int(2.0 * disc.max() / fringe_rad), _MOST_NODES)
        angle = np.arange(1, count + 1) * np.pi / (count + 1)
        weights = 2.0 / (count + 1) * np.sin(angle) ** 2
        mean = np.zeros(colours.shape)
        for node, weight in zip(np.cos(angle), weights, strict=True):
            at = theta + disc * node
            # Beyond a pole the angle counts back.
            at = np.abs(np.where(at > np.pi, 2.0 * np.pi - at, at))
            place = (folded_chord(at) - chord[0]) * per_chord
            left = np.clip(place.astype(np.int64), 0, len(chord) - 2)
            share = (place - left)[:, None]
            mean += weight * (colours[:, left] * (1.0 - share) + colours[:, left + 1] * share)
        rows.append(mean)
    stacked = np.stack(rows, axis=1).reshape(-1, *colours.shape[1:])
    return running_colours(stacked, theta)
