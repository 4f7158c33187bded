"""The shaders that draw the rain's own glow over a frame, and its map as their textures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rtbow.base.arrays import Array, Float32
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import Texture, row_texture
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS
from rtbow.render.glow.map import GlowMap
from rtbow.render.smooth import SmoothPasses
from rtbow.render.uniforms import common_defines, common_uniforms
from rtbow.world.steps import StepRates
from rtbow.world.world import World

_AXIS_TEXELS = 1024
"""Of the tables by which angles become places in the map."""


class GlowPasses(SmoothPasses):
    """The programs that draw the rain's own glow."""

    def __init__(self, gl: GlContext, world: World) -> None:
        super().__init__(gl, world.view, "glow", glow_defines(world), None)

    def take(self, world: World, textures: Mapping[str, Texture], seen: GlowMap) -> None:
        """Take over a world and its map."""
        west, east = seen.azimuth_rad[[0, -1]]
        low, high = seen.altitude_rad[[0, -1]]
        uniforms = common_uniforms(world, world.volume.box_m, StepRates(np.zeros(3), 0.0))
        self.read(
            textures,
            {**uniforms, "glow.first": (west, low), "glow.range": (east - west, high - low)},
        )


def glow_defines(world: World) -> dict[str, Define]:
    """Give the constants and switches of a world's glow; others need other programs."""
    return {
        **common_defines(world),
        "LUMINANCE": f"vec3({', '.join(f'{weight:.9f}' for weight in LUMINANCE_WEIGHTS)})",
        "PARTS": True,
        "SEVERAL_RADII": False,
        "SIDES": False,
    }


def uploaded(gl: GlContext, seen: GlowMap) -> dict[str, Texture]:
    """Upload a map."""
    return {
        "glow.brightness": row_texture(gl, seen.rgb),
        "glow.columns": row_texture(gl, _places(seen.azimuth_rad)),
        "glow.rows": row_texture(gl, _places(seen.altitude_rad)),
    }


def _places(nodes: Array) -> Float32:
    """Texture coordinates of even shares of a range between its nodes (1, N)."""
    share = (np.arange(_AXIS_TEXELS) + 0.5) / _AXIS_TEXELS
    at = nodes[0] + share * (nodes[-1] - nodes[0])
    place = np.interp(at, nodes, np.arange(len(nodes)))
    return np.asarray((place + 0.5) / len(nodes), dtype=np.float32)[None]
