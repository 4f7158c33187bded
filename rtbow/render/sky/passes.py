"""The shaders that draw a sky over a frame, and its tables as their textures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rtbow.base.arrays import Float32, floats
from rtbow.base.limits import STANDS_M
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import Texture, row_texture, volume_texture
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS
from rtbow.render.smooth import SmoothPasses
from rtbow.render.uniforms import common_defines, common_uniforms
from rtbow.tables.sky.rays import FALLING, RISING, Eye
from rtbow.tables.sky.seen import SkyTable
from rtbow.world.lights import Sun
from rtbow.world.steps import StepRates
from rtbow.world.world import World

_STEPS = 8
"""Of a ray through rain that dims, at whose ends the air's light is looked up."""
_GRID_SAMPLES = 3
"""Of the rain within each, in a grid: 24 in all leave CIEDE2000 0.14 at the 99th percentile of
``shower``, 48 leave 0.03."""


class Passes(SmoothPasses):
    """The programs that draw the sky of one sun after another."""

    def __init__(self, gl: GlContext, world: World, moments: Texture | None) -> None:
        super().__init__(gl, world.view, "sky", sky_defines(world), moments)

    def take(self, world: World, sun: Sun, sky: SkyOf) -> None:
        """Take over a world and one of its suns."""
        no_rates = StepRates(np.zeros(3), 0.0)
        uniforms = {
            **common_uniforms(world, world.volume.box_m, no_rates),
            **_sun_uniforms(world, sun, sky),
        }
        self.read(sky.textures, uniforms)
        if self._nodes is not None:
            beside = 2.0 * self._nodes.block * world.view.pixel_rad
            near = 2.0 * np.sin(0.5 * sun.disc_rad) + beside if sun.disc_radiance > 0.0 else 0.0
            self._node.set("nearSun", near)


@dataclass(frozen=True)
class SkyOf:
    """The sky under one sun on the device.

    Attributes:
        eye: which sees it.
        table: its numbers.
        textures: by the names of their samplers.
    """

    eye: Eye
    table: SkyTable
    textures: Mapping[str, Texture]


def uploaded(gl: GlContext, table: SkyTable, world: World) -> dict[str, Texture]:
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


def sky_defines(world: World) -> dict[str, Define]:
    """Give the constants and switches of a world's sky; others need other programs."""
    assert world.around is not None
    ground = world.around.ground
    return {
        **common_defines(world),
        "WATER": ground is not None and ground.water,
        "LUMINANCE": f"vec3({', '.join(f'{weight:.9f}' for weight in LUMINANCE_WEIGHTS)})",
        "PARTS": True,
        "SEVERAL_RADII": False,
        "SIDES": True,
        "STANDS_M": STANDS_M,
        "SKY_RISING": RISING,
        "SKY_FALLING": FALLING,
        "SKY_STEPS": _STEPS,
        "SKY_SAMPLES": 1 if world.volume.uniform else _GRID_SAMPLES,
    }


def _sun_uniforms(world: World, sun: Sun, sky: SkyOf) -> dict[str, Any]:
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
