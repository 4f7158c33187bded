"""Method ``fast`` under a lamp: few steps at every pixel, what they miss from nodes.

A lamp's light comes under all angles along a ray, so that colours and path do not part as under a
sun. But the colours' running integral over the angle makes a step of any width exact where the
drops are even, and what a few steps miss of uneven drops varies slowly over the picture.
"""

from __future__ import annotations

import moderngl
import numpy as np

from rtbow.arrays import Array, Float32, Progress, floats
from rtbow.colour_bake import Drops, outcomes
from rtbow.colour_table import (
    NO_AIR,
    ColourTable,
    chords,
    colour_table,
    folded_chord,
    hat_fit,
    light_columns,
    unfolded,
)
from rtbow.context import GlContext
from rtbow.fast_scene import (
    bind_rain,
    blocks_of,
    flag_target,
    march_rates,
    radius_rows,
    rain_colour,
    scene_defines,
    set_march,
    set_scene,
)
from rtbow.fast_settings import FastSettings, node_step_nm
from rtbow.fast_volume import filled_box, lamp_column
from rtbow.gl_program import FrameTarget, GlProgram, Texture, added_up
from rtbow.glsl import Define
from rtbow.lights import NEAREST_M
from rtbow.parts import Parts
from rtbow.scene import Scene
from rtbow.section_table import running_integral
from rtbow.steps import lamp_steps

_AIR_STEPS = 4
"""Steps through even drops in air."""
_LEAST_TEXELS = 4.0
"""Range of the running integral that keeps its digits in float32."""
_DISC_ROWS = 64
_LEAST_BLUR = 0.05
"""Part of a fringe's width that a disc must have to blur anything."""
_MOST_RATIO = 10.0
"""Lamp's radius over the distance at which a ray passes its centre, at most: rays that come nearer
meet drops in front of and behind the lamp only, where angles are all but 0 or pi."""
_MOST_NODES = 32
"""Nodes over a disc, at most: wider discs than those suffice for are met within some radii of the
lamp only."""


class FastLamp:
    """One lamp's programs and textures.

    Args:
        gl: the context; it must be current here and in :meth:`draw`.
        scene: the scene.
        parts: its parts.
        number: which of its lamps.
        settings: how coarse.
        drops_texture: the volume's moments, shared by all lights; None for an even volume.
        building: wraps the loop over parts of an exact table that has to be built first.
    """

    def __init__(
        self, gl: GlContext, scene: Scene, parts: Parts, number: int, settings: FastSettings,
        drops_texture: moderngl.Texture3D | None, building: Progress,
    ) -> None:  # fmt: skip
        self._gl = gl
        lamp, volume, air = parts.optics.lamps[number], parts.volume, parts.optics.has_air
        eye = np.array(scene.camera.position_m)
        box = filled_box(volume)
        radii = radius_rows(volume, settings)
        column = lamp_column(lamp, box, eye) if air else NO_AIR
        drops = Drops(scene.scattering, np.exp(radii.fine), volume.sizes)
        light = light_columns(
            lamp.spectrum, node_step_nm(settings, blurred=not drops.on_device), column, settings.colour,
            rain_colour(parts, settings),
        )  # fmt: skip
        x = 2.0 * np.pi * volume.size_range_um[1] * 1e-6 / 380e-9
        fringe = 1.4 / x ** (2.0 / 3.0)
        most = min(gl.limits.texture_2d, 16_384)
        chord = chords(0.0, np.pi, fringe / settings.texels_per_fringe, most)
        found = outcomes(
            gl, drops, light, unfolded(chord), 0.0,
            components=scene.camera.polarizer_deg is not None, progress=building,
        )  # fmt: skip
        self.table = colour_table(floats(found), light, chord, hat_fit(radii.fine, radii.rows))
        even = volume.uniform and parts.rain is None
        self._block = 0 if even else settings.block
        defines: dict[str, Define] = {
            **scene_defines(scene, parts, self.table),
            "NEAREST_M": NEAREST_M,
            "LAMP_COUNT": 1,
            "LAMP_DISC": lamp.radius_m > 0.0,
            "BLOCK": self._block,
            "EVEN": even,
            "EVEN_STEPS": _AIR_STEPS if air else 1,
            "LEAST_TEXELS": _LEAST_TEXELS,
            "DISC_ROWS": _DISC_ROWS,
            "PARTS": True,
            "HAT_GROUPS": 0,
        }
        colours = self.table.values[: self.table.rows * self.table.components]
        running = running_colours(floats(colours), unfolded(chord))
        first = _LEAST_BLUR * fringe
        if lamp.radius_m > 0.0 and self.table.rows == 1:
            ratios = np.geomspace(first, _MOST_RATIO, _DISC_ROWS - 1)
            running = over_discs(self.table, chord, ratios, fringe)
        self._compose = GlProgram(gl, "fast_lamp.frag", defines)
        self._marching = [self._compose]
        if self._block:
            self._node = GlProgram(gl, "fast_lamp_node.frag", defines)
            self._flags = GlProgram(gl, "fast_flags.frag", {**defines, "SEVERAL_RADII": False})
            self._marching.append(self._node)
            self._make_nodes(scene)
            bend = settings.bend
            self._flags.set("tolerance", (1e30, bend, bend, bend))
        rates = march_rates(parts, settings)
        many = scene.render.steps or int(np.ceil(settings.lamp_scale * lamp_steps(rates, volume)))
        for program in self._marching:
            set_scene(program, scene, parts, box)
            set_march(program, scene, rates, radii, light.grey)
            program.texture("colours", self.table.values)
            program.texture("runningColours", running)
            program.set("lampSphere", (*(lamp.position_m - eye), lamp.radius_m))
            program.set("chordAxis", (self.table.first, self.table.per_chord))
            program.set("middleAir", column.middle)
            per_fold = (_DISC_ROWS - 2) / float(np.log(_MOST_RATIO / first))
            program.set("discRows", (float(np.log(first)), per_fold))
            program.set("fewSteps", settings.few_steps)
            program.set("manySteps", many)
            if drops_texture is not None:
                program.bind("dropletMoments", drops_texture)
            bind_rain(program, lamp, parts)

    def _make_nodes(self, scene: Scene) -> None:
        blocks = blocks_of(scene.camera.size_px, self._block)
        ctx = self._gl.ctx
        nodes = ctx.texture((blocks[0] + 1, blocks[1] + 1), 4, dtype="f4")
        nodes.repeat_x = nodes.repeat_y = False
        flags = flag_target(self._gl, blocks)
        self._flags.bind("nodes", nodes)
        self._compose.bind("nodes", nodes)
        self._compose.bind("flags", flags)
        self._node_frame = ctx.framebuffer([nodes])
        self._flag_frame = ctx.framebuffer([flags])

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
        with added_up(self._gl, add):
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
