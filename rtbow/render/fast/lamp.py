"""Method ``fast`` under a lamp: few steps at every pixel, what they miss from nodes.

A lamp's light comes under all angles along a ray, so that colours and path do not part as under a
sun. But the colours' running integral over the angle makes a step of any width exact where the
drops are even, and what a few steps miss of uneven drops varies slowly over the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, floats, no_progress
from rtbow.base.errors import UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import FrameTarget, GlProgram, Texture, added_up, row_texture
from rtbow.physics.air.rayleigh import NO_AIR, Column
from rtbow.render.colours.table import (
    ColourTable,
    chords,
    colour_table,
    folded_chord,
    unfolded,
)
from rtbow.render.edges import PixelPass
from rtbow.render.fast import limits
from rtbow.render.fast.columns import lamp_column
from rtbow.render.fast.light import LightPlan, most_texels, plan_light
from rtbow.render.fast.nodes import Nodes, block_for, draw_into
from rtbow.render.fast.shared import Plan, bind_rain, light_defines, set_scene
from rtbow.render.uniforms import lamp_pixels_wide, lamp_points
from rtbow.tables.layout import running_integral
from rtbow.world.lights import NEAREST_M, Lamp
from rtbow.world.steps import lamp_steps, most_steps

_FEW_STEPS = 1
"""Every pixel takes this many steps, whose error the nodes make good."""
_MOST_AIR_STEPS = 16
"""Even drops in air take no more steps than this."""
_MOST_DEPTH = 30.0
"""Optical depth of rain across the box, at most (35: 0.5 in CIEDE2000 from a lamp outside; 350:
3)."""
_NEAR_SHARE = 6.0
"""Drops nearer to a lamp than this part of its distance from the eye fill too little of a picture
for their disc to count."""
_FLAT_RAD = 0.35
"""Largest disc of a lamp that its mean, as if it were flat and ended at the poles, follows where
bows are wide (0.5 rad, drops of 5 µm: 6 in CIEDE2000; 0.24 rad: 0.2)."""
_FLAT_FRINGES = 0.02
"""For bows as narrow as this, of drops of 100 µm, it follows discs of 0.7 rad, and in between in
inverse proportion."""
_LEAST_TEXELS = 4.0
"""Differences of the running integral keep their digits in float32 over so many texels or more."""
_DISC_ROWS = 64
"""Rows of the running integral: one for a point, the others for ratios of a disc."""
_LEAST_BLUR = 0.05
"""A disc blurs nothing that is less wide than this part of a fringe."""
_MOST_RATIO = 10.0
"""Greatest ratio of the lamp's radius to the distance at which a ray passes its centre: rays that
come nearer meet drops in front of and behind the lamp only, where angles are all but 0 or pi."""
_WIDE_DISC = 4.0
"""Five nodes over a lamp's disc suffice for drops of several radii up to this size of the disc,
seen from the eye, in widths of the bow: the error is 0.4 in CIEDE2000."""
_MOST_NODES = 32
"""Most nodes over a disc: rays meet wider discs than these suffice for within some radii of the
lamp only."""


@dataclass(frozen=True)
class LampPlan:
    """How one lamp is drawn, decided before the device is touched.

    Attributes:
        plan: the world's.
        lamp: the lamp.
        column: range of air columns that its table covers.
        fringe_rad: width of the finest detail.
        light: what its colours are tabled for.
        degree: of the table's polynomial in the column.
        block: pixels between nodes; 0 for none.
    """

    plan: Plan
    lamp: Lamp
    column: Column
    fringe_rad: float
    light: LightPlan
    degree: int
    block: int

    @property
    def defines(self) -> dict[str, Define]:
        """The switches and constants of all its programs."""
        world = self.plan.world
        even = world.volume.uniform and world.rain is None
        return {
            **light_defines(self.plan, degree=self.degree, rain=self.light.basis.rain),
            "NEAREST_M": NEAREST_M,
            "SUN": False,
            "NEAR_AIR": False,
            "SHADOW": False,
            "LAMP_COUNT": 1,
            "LAMP_DISC": self.lamp.radius_m > 0.0,
            "BLOCKS": self.block > 0,
            "EVEN": even,
            "EVEN_STEPS": _air_steps(self.plan) if world.optics.has_air and even else 1,
            "LEAST_TEXELS": _LEAST_TEXELS,
            "DISC_ROWS": _DISC_ROWS,
            "PARTS": True,
            "SIDES": False,
            "HAT_GROUPS": 0,
            "PIXEL_LEVELS": 0,
            "PIXEL_POINTS": 0,
        }


def plan_lamp(plan: Plan, lamp: Lamp, most_texels: int, *, roaming: bool = False) -> LampPlan:
    """Decide how a lamp is drawn.

    Args:
        plan: the world's.
        lamp: the lamp.
        most_texels: along a table, that the device takes.
        roaming: with tables that serve other places of camera and lamp, too.

    Raises:
        UnsuitedError: the method cannot draw it within the world's error.
    """
    world, settings = plan.world, plan.settings
    column = _reach(plan, lamp)
    if roaming and world.optics.has_air:
        column = Column(0.0, 2.0 * column.high)
    fringe = world.narrowest_bow_rad
    _check_disc(plan, lamp, fringe)
    limits.check_depth(plan, _MOST_DEPTH)
    limits.check_loops(plan, 2 * lamp_points(world))
    chord = chords(0.0, np.pi, fringe / settings.texels_per_fringe, most_texels)
    light = plan_light(plan, lamp.spectrum, column, chord)
    if not roaming:  # those serve many frames
        limits.check_cost(plan, light.evaluations)
    even = world.volume.uniform and world.rain is None
    block = 0 if even else block_for(world.view, settings.lamp_block)
    return LampPlan(plan, lamp, column, fringe, light, light.degree(column), block)


def _check_disc(plan: Plan, lamp: Lamp, fringe_rad: float) -> None:
    """Refuse a lamp whose disc, as the eye sees it, blurs fringes more than its nodes follow, or
    is too wide, as the drops see it, to be flat."""
    eye_m = plan.world.view.eye_m
    wide = lamp.radius_m / max(float(np.linalg.norm(lamp.position_m - eye_m)), 1e-3)
    if len(plan.radii.rows) > 1 and wide > _WIDE_DISC * plan.settings.share * fringe_rad:
        raise UnsuitedError(
            f"light.diameter_m = {2.0 * lamp.radius_m:g}: method fast does not follow fringes"
            " of drops of several radii under so large a lamp; use --method spectral, a smaller"
            " diameter, or a larger render.max_delta_e"
        )
    away = float(np.linalg.norm(np.maximum(
        np.maximum(plan.box_m[0] - lamp.position_m, lamp.position_m - plan.box_m[1]), 0.0
    )))  # fmt: skip
    away = max(away, float(np.linalg.norm(lamp.position_m - eye_m)) / _NEAR_SHARE)
    disc = math.asin(min(lamp.radius_m / max(away, 1e-3), 1.0))
    flat = _FLAT_RAD * min(max(_FLAT_FRINGES / fringe_rad, 1.0), 2.0)
    if disc > flat:
        raise UnsuitedError(
            f"light.diameter_m = {2.0 * lamp.radius_m:g}: drops see a disc of"
            f" {math.degrees(2.0 * disc):.0f} degrees, of which method fast follows"
            f" {math.degrees(2.0 * flat):.0f}; use --method spectral or a smaller diameter"
        )


def _reach(plan: Plan, lamp: Lamp) -> Column:
    """Range of air columns from a lamp to the eye by way of the drops."""
    if not plan.world.optics.has_air:
        return NO_AIR
    return lamp_column(lamp, plan.box_m, plan.world.view.eye_m)


def _air_steps(plan: Plan) -> int:
    """Steps through even drops in air, a power of two: the shader halves the angle at the lamp."""
    wanted = most_steps(plan.rates, plan.world.volume)
    return min(max(1 << math.ceil(math.log2(wanted)), 2), _MOST_AIR_STEPS)


class FastLamp:
    """One lamp's programs and textures.

    Args:
        gl: the context; it must be current here and in every method.
        plan: the world's.
        number: which of its lamps.
        drops: the volume's moments on the device; None for an even one.
        building: wraps the loop over parts of an exact table that has to be built first.
        roaming: make tables that serve other places of camera and lamp, too.

    Raises:
        UnsuitedError: the method cannot draw it within the world's error.
    """

    def __init__(
        self, gl: GlContext, plan: Plan, number: int, drops: moderngl.Texture3D | None,
        building: Progress, *, roaming: bool = False,
    ) -> None:  # fmt: skip
        self._gl, self._number, self._drops = gl, number, drops
        lamp = plan.world.optics.lamps[number]
        self.plan = plan_lamp(plan, lamp, most_texels(gl), roaming=roaming)
        light, defines = self.plan.light, self.plan.defines
        self._grey = light.basis.grey(self.plan.column.middle)
        self.table = colour_table(light.bake(gl, building), self.plan.column, self.plan.degree)
        self._compose = PixelPass(
            gl, "fast/lamp/pixel.frag", defines, whole=lamp_pixels_wide(plan.world)
        )
        self.marching = [*self._compose.programs]
        self._nodes: Nodes | None = None
        if self.plan.block:
            self._node = GlProgram(gl, "fast/lamp/node.frag", defines)
            self._flags = GlProgram(gl, "fast/flags.frag", {**defines, "SEVERAL_RADII": False})
            self.marching.append(self._node)
            self._make_nodes()
        self._bind()
        self._place()

    def move(self, plan: Plan) -> bool:
        """Take over a world that differs in where camera and lamp are.

        Returns:
            Whether that could be done; if not, nothing has changed.

        Raises:
            UnsuitedError: the method cannot draw it there; nothing has changed.
        """
        before, lamp = self.plan, plan.world.optics.lamps[self._number]
        if _reach(plan, lamp).high > before.column.high:
            return False
        _check_disc(plan, lamp, before.fringe_rad)
        view = plan.world.view
        block = block_for(view, plan.settings.lamp_block) if before.block else 0
        if before.block and not block:
            return False
        if lamp_pixels_wide(plan.world) != lamp_pixels_wide(before.plan.world):
            return False
        self.plan = replace(before, plan=plan, lamp=lamp, block=block)
        if block and (block, view.size_px) != (before.block, before.plan.world.view.size_px):
            self._make_nodes()
        if np.any(before.lamp.position_m != lamp.position_m):
            bind_rain(self._gl, self.marching, lamp, plan.world)
        self._place()
        return True

    def anew(self, plan: Plan) -> FastLamp:
        """Make this lamp anew, for a plan that it cannot move to."""
        return FastLamp(self._gl, plan, self._number, self._drops, no_progress, roaming=True)

    def _bind(self) -> None:
        """Upload what stays, wherever camera and lamp are."""
        lamp, table, chord = self.plan.lamp, self.table, self.plan.light.chord
        colours = table.values[: table.rows * table.components]
        running = running_colours(floats(colours), unfolded(chord))
        first = _LEAST_BLUR * self.plan.fringe_rad
        if lamp.radius_m > 0.0 and table.rows == 1:
            ratios = np.geomspace(first, _MOST_RATIO, _DISC_ROWS - 1)
            running = over_discs(table, chord, ratios, self.plan.fringe_rad)
        textures = row_texture(self._gl, table.values), row_texture(self._gl, running)
        per_fold = (_DISC_ROWS - 2) / float(np.log(_MOST_RATIO / first))
        for program in self.marching:
            program.bind("scene.table.values", textures[0])
            program.bind("scene.running", textures[1])
            program.set("scene.discs.first", float(np.log(first)))
            program.set("scene.discs.perFold", per_fold)
            program.set("scene.table.first", table.first)
            program.set("scene.table.perChord", table.per_chord)
            if self._drops is not None:
                program.bind("volume.moments", self._drops)
        bind_rain(self._gl, self.marching, lamp, self.plan.plan.world)

    def _place(self) -> None:
        """Set all that depends on where camera and lamp are."""
        plan, lamp, column = self.plan.plan, self.plan.lamp, self.plan.column
        world = plan.world
        steps = plan.settings.lamp_scale * lamp_steps(plan.rates, world.volume)
        self._compose.place(world.view, plan.box_m, lamp.position_m)
        many = world.fineness.steps or int(np.ceil(steps))
        for program in self.marching:
            set_scene(program, plan, self._grey)
            program.set("scene.lamp.centre", tuple(lamp.position_m - world.view.eye_m))
            program.set("scene.lamp.radius", lamp.radius_m)
            program.set("air.reach", column.reach)
            program.set("air.middle", column.middle)
            program.set("fewSteps", _FEW_STEPS if self.plan.block else many)
            program.set("manySteps", many)

    def _make_nodes(self) -> None:
        plan = self.plan.plan
        self._nodes = Nodes(self._gl, plan.world.view.size_px, self.plan.block, channels=4)
        for program in (self._compose, self._flags):
            program.bind("nodes", self._nodes.values)
        self._compose.bind("flags", self._nodes.flags)
        bend = plan.settings.lamp_bend
        self._flags.set("tolerance.first", 1e30)
        self._flags.set("tolerance.others", (bend, bend, bend))
        for program in (self._compose, self._node):
            program.set("blockSize", float(self._nodes.block))

    @property
    def textures(self) -> list[Texture]:
        """All textures that its programs read."""
        return [texture for program in self.marching for texture in program.textures.values()]

    def draw(self, target: FrameTarget, *, add: bool) -> None:
        """Draw its light into a frame, adding to what is there or in its place."""
        if self._nodes is not None:
            draw_into(self._nodes.gathered, self._node)
            draw_into(self._nodes.flagged, self._flags)
        target.use()
        with added_up(self._gl, add):
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
