"""What drops make of a light, summed over wavelengths: on the GL device, or from exact tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import moderngl
import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, floats, no_progress
from rtbow.base.cache import file_digest, forget_oldest, keep_arrays, kept_arrays, source_digest
from rtbow.base.limits import MIN_RADIUS_UM
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import GlProgram
from rtbow.physics.drop import airy
from rtbow.physics.sizes import Sizes
from rtbow.render.colours.basis import LightBasis
from rtbow.render.uniforms import bow_defines, bow_rows, dark_edges
from rtbow.tables.airy import airy_table, shader_constants
from rtbow.tables.layout import RadiusAxis, row_sections
from rtbow.world.world import Scatterer

_ROWS_AT_A_TIME = 32
"""Rows of radius are summed in blocks of this many, which bounds the memory that they take."""
_KEPT_FILES = 32
"""Files of colours in the cache, at most: each camera and height of the sun makes one."""


@dataclass(frozen=True)
class Drops:
    """Drops whose colours are wanted.

    Attributes:
        scatterer: theory, orders, what the drops are made of.
        radius_m: rows (R,); one for a mixture.
        mixture: sizes that the one row stands for, if it is one.
    """

    scatterer: Scatterer
    radius_m: Array
    mixture: Sizes | None

    @property
    def on_device(self) -> bool:
        """Whether the shader evaluates them: Airy's bows of single sizes."""
        return self.scatterer.theory == "airy" and self.mixture is None


def outcomes(
    gl: GlContext,
    drops: Drops,
    light: LightBasis,
    theta: Array,
    disc_rad: float,
    *,
    components: bool,
    progress: Progress = no_progress,
) -> Float32:
    """Sum what drops send back, for each spectrum of a light's basis.

    Args:
        gl: the context; it must be current.
        drops: the drops.
        light: weights of its wavelengths.
        theta: scattering angles (N,).
        disc_rad: angular radius of the light's disc.
        components: both components apart.
        progress: wraps the loop over parts of an exact table that has to be built first.

    Returns:
        X, Y, Z per drop, float32 (B, components, R, N, 3). Of several rows each is divided
        by (radius / geometric mean of the first and the last)^(7/3).
    """
    if drops.on_device:
        return _bake(gl, drops, light, theta, disc_rad, components=components)
    if drops.mixture is not None:
        # Its cross-sections are kept, for every view and sun; the sum over wavelengths is short.
        return _from_sections(
            drops, light, theta, disc_rad, components=components, progress=progress
        )
    # Imported here, with the compiler of what is summed on the CPU.
    from rtbow.tables.mie.axes import COMPACT_FILE

    key = repr(
        (
            source_digest("base.limits", "physics", "tables", "render.colours"),
            file_digest(COMPACT_FILE),
            drops.scatterer, drops.radius_m.tobytes(),
            light.wavelength_nm.tobytes(), light.weights.tobytes(), theta.tobytes(), disc_rad,
            components,
        )
    )  # fmt: skip
    kept = kept_arrays("colours", key)
    if kept is not None:
        return np.asarray(kept["outcomes"], dtype=np.float32)
    summed = _from_sections(drops, light, theta, disc_rad, components=components, progress=progress)
    if keep_arrays("colours", key, {"outcomes": summed}):
        forget_oldest("colours", _KEPT_FILES)
    return summed


def middle_radius(radius_m: Array) -> float:
    """Give the radius that rows are scaled to, m."""
    return float(np.sqrt(radius_m[0] * radius_m[-1]))


def _from_sections(
    drops: Drops, light: LightBasis, theta: Array, disc_rad: float, *,
    components: bool, progress: Progress,
) -> Float32:  # fmt: skip
    """Sum tabled cross-sections on the CPU, some rows of radius at a time."""
    scatterer, radii = drops.scatterer, drops.radius_m
    if drops.mixture is None:
        range_um = float(radii[0] * 1e6), float(radii[-1] * 1e6)
        sections = scatterer.sections(light.wavelength_nm, range_um, progress)
    else:
        sections = scatterer.mixtures(light.wavelength_nm, progress)
    parts = []
    for start in range(0, len(radii), _ROWS_AT_A_TIME):
        block = radii[start : start + _ROWS_AT_A_TIME]
        rows = row_sections(sections, RadiusAxis(block, drops.mixture), theta, disc_rad)
        rows *= (block**2 * _scale(radii, block))[:, None, None, None]
        kept = rows if components else rows.mean(axis=3, keepdims=True)
        parts.append(
            np.einsum("rwuc,owx->ocrux", kept, light.weights, optimize=True).astype(np.float32)
        )
    return np.concatenate(parts, axis=2)


def _scale(radii: Array, block: Array) -> Array:
    return floats((middle_radius(radii) / block) ** airy.RADIUS_POWER)


def _bake(
    gl: GlContext, drops: Drops, light: LightBasis, theta: Array, disc_rad: float, *,
    components: bool,
) -> Float32:  # fmt: skip
    """Sum Airy's bows on the GL device, some rows of radius in each pass."""
    index = drops.scatterer.medium.index(light.wavelength_nm)
    bows = airy.bows(drops.scatterer.orders, light.wavelength_nm * 1e-9, index)
    defines = _bake_defines(bows, light, disc_rad, components=components)
    program = GlProgram(gl, "fast/bake.frag", defines)
    _upload(program, bows, drops, light, theta, disc_rad, components=components)
    gl.ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
    rows = len(drops.radius_m)
    blocks = [
        _draw_rows(
            gl, program, slice(start, min(start + _ROWS_AT_A_TIME, rows)), len(theta),
            len(light.weights), components=components,
        )
        for start in range(0, rows, _ROWS_AT_A_TIME)
    ]  # fmt: skip
    outcome = np.concatenate(blocks, axis=2)
    if components:
        outcome *= 2.0  # of a component whose share is one the shader gives half
    return outcome


def _bake_defines(
    bows: Sequence[airy.Bow], light: LightBasis, disc_rad: float, *, components: bool
) -> dict[str, Define]:
    """Give the constants and switches of the shader that sums bows over wavelengths."""
    return {
        **shader_constants(),
        **bow_defines(bows),
        "RADIUS_POWER": airy.RADIUS_POWER,
        "WAVELENGTH_COUNT": len(light.wavelength_nm),
        "OUTCOMES": len(light.weights),
        "SUN_COUNT": 1,  # a lamp's colours, too, are those under a point at infinity
        "LAMP_COUNT": 0,
        "PANORAMA": False,
        "PIXEL_AREA": False,
        "PIXEL_POINTS": 0,
        "POLARIZER": components,
        **dict.fromkeys(("DISC", "POLE", "WIDE"), disc_rad > 0.0),
    }


def _upload(
    program: GlProgram, bows: Sequence[airy.Bow], drops: Drops, light: LightBasis, theta: Array,
    disc_rad: float, *, components: bool,
) -> None:  # fmt: skip
    """Upload bows, weights, angles, radii and Airy's function."""
    program.texture("spectral", bow_rows(bows, components=components), linear=False)
    program.texture("light", np.pad(light.weights, ((0, 0), (0, 0), (0, 1))), linear=False)
    program.texture("angles", theta[None], linear=False)
    program.texture("radii", drops.radius_m[None], linear=False)
    table = airy_table()
    program.texture("theory.near", table.near[..., :1])
    if disc_rad > 0.0:
        program.texture("theory.fringe", table.fringe[None])
        program.texture("theory.pole", table.pole)
    smallest = max(float(drops.radius_m[0]), MIN_RADIUS_UM * 1e-6)
    program.set_array("theory.edge", dark_edges(bows, smallest, disc_rad))
    program.set("discRadius", disc_rad)
    program.set("perRadius", middle_radius(drops.radius_m))


def _draw_rows(
    gl: GlContext, program: GlProgram, rows: slice, columns: int, count: int, *, components: bool
) -> Float32:
    """Draw a block of rows of radius and read it: (count, components, rows, columns, 3)."""
    size = columns, rows.stop - rows.start
    targets = [gl.ctx.texture(size, 4, dtype="f4") for _ in range(count)]
    frame = gl.ctx.framebuffer(targets)
    frame.use()
    program.set("firstRow", rows.start)
    drawn = []
    for share in (1.0, 0.0) if components else (0.5,):
        program.set("component", share)
        program.use()
        program.draw()
        pixels = [np.frombuffer(target.read(), dtype=np.float32) for target in targets]
        drawn.append(np.reshape(pixels, (count, *size[::-1], 4))[..., :3])
    return np.stack(drawn, axis=1)
