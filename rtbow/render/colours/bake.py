"""What drops make of a light, summed over wavelengths: on the GL device, or from exact tables."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl
import numpy as np

from rtbow.base.arrays import (
    Array,
    Float32,
    Progress,
    floats,
    no_progress,
)
from rtbow.base.cache import (
    file_digest,
    forget_oldest,
    keep_arrays,
    kept_arrays,
    source_digest,
)
from rtbow.base.limits import MIN_RADIUS_UM
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define, glsl_literal
from rtbow.gl.program import GlProgram
from rtbow.physics.drop.airy import RADIUS_POWER, bows
from rtbow.physics.drop.water import relative_index
from rtbow.physics.sizes import Sizes, tabled_sizes
from rtbow.render.colours.basis import LightBasis
from rtbow.render.uniforms import bow_rows, dark_edges
from rtbow.tables.airy import airy_table, shader_constants
from rtbow.tables.layout import RadiusAxis, row_sections
from rtbow.world.world import Scatterer

_ROWS_AT_A_TIME = 32
_KEPT_FILES = 32
"""Files of colours in the cache: each camera and height of the sun makes one of its own."""


@dataclass(frozen=True)
class Drops:
    """Drops whose colours are wanted.

    Attributes:
        scatterer: theory, orders, water.
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
    # Imported here, with the compiler of what is summed on the CPU.
    from rtbow.tables.mie.store import COMPACT_FILE

    key = repr(
        (
            source_digest("physics", "tables", "render.colours"), file_digest(COMPACT_FILE),
            drops.scatterer, drops.radius_m.tobytes(),
            None if drops.mixture is None else
            (drops.mixture.radius_m.tobytes(), drops.mixture.share.tobytes()),
            light.wavelength_nm.tobytes(), light.weights.tobytes(), theta.tobytes(), disc_rad,
            components,
        )
    )  # fmt: skip
    kept = kept_arrays("colours", key)
    if kept is not None:
        return np.asarray(kept["outcomes"], dtype=np.float32)
    found = _from_sections(drops, light, theta, disc_rad, components=components, progress=progress)
    if keep_arrays("colours", key, {"outcomes": found}):
        forget_oldest("colours", _KEPT_FILES)
    return found


def middle_radius(radius_m: Array) -> float:
    """Give the radius that rows are scaled to, m."""
    return float(np.sqrt(radius_m[0] * radius_m[-1]))


def _from_sections(
    drops: Drops, light: LightBasis, theta: Array, disc_rad: float, *,
    components: bool, progress: Progress,
) -> Float32:  # fmt: skip
    scatterer, radii = drops.scatterer, drops.radius_m
    range_um = float(radii[0] * 1e6), float(radii[-1] * 1e6)
    if drops.mixture is not None:
        mixed = tabled_sizes(drops.mixture) if scatterer.theory == "mie" else drops.mixture
        range_um = mixed.range_um
    sections = scatterer.sections(light.wavelength_nm, range_um, progress)
    parts = []
    for start in range(0, len(radii), _ROWS_AT_A_TIME):
        some = radii[start : start + _ROWS_AT_A_TIME]
        both = row_sections(sections, RadiusAxis(some, drops.mixture), theta, disc_rad)
        both *= (some**2 * _scale(radii, some))[:, None, None, None]
        chosen = both if components else both.mean(axis=3, keepdims=True)
        parts.append(
            np.einsum("rwuc,owx->ocrux", chosen, light.weights, optimize=True).astype(np.float32)
        )
    return np.concatenate(parts, axis=2)


def _scale(radii: Array, some: Array) -> Array:
    return floats((middle_radius(radii) / some) ** RADIUS_POWER)


def _bake(
    gl: GlContext, drops: Drops, light: LightBasis, theta: Array, disc_rad: float, *,
    components: bool,
) -> Float32:  # fmt: skip
    nm = light.wavelength_nm
    index = relative_index(nm, drops.scatterer.temperature_c)
    the_bows = bows(drops.scatterer.orders, nm * 1e-9, index)
    sides = ", ".join(glsl_literal(b.side) for b in the_bows)
    count = len(light.weights)
    defines: dict[str, Define] = {
        **shader_constants(),
        "RADIUS_POWER": RADIUS_POWER,
        "WAVELENGTH_COUNT": len(nm),
        "BOW_COUNT": len(the_bows),
        "BOW_SIDE": f"float[]({sides})",
        "SUN_COUNT": 1,
        "LAMP_COUNT": 0,
        "FIRST_LIGHT_ROW": len(the_bows),
        "ONE_RADIUS": False,
        "ATTENUATION": False,
        "EXTINCTION": False,
        "POLARIZER": components,
        "DISC": disc_rad > 0.0,
        "POLE": disc_rad > 0.0,
        "WIDE": disc_rad > 0.0,
        "OUTCOMES": count,
    }
    program = GlProgram(gl, "fast/bake.frag", defines)
    program.texture("spectral", bow_rows(the_bows, components=components), linear=False)
    lights = np.concatenate([light.weights, np.zeros((count, len(nm), 1))], axis=2)
    program.texture("light", lights, linear=False)
    program.texture("angles", theta[None], linear=False)
    program.texture("radii", drops.radius_m[None], linear=False)
    table = airy_table()
    program.texture("theory.near", table.near[..., :1])
    if disc_rad > 0.0:
        program.texture("theory.fringe", table.fringe[None])
        program.texture("theory.pole", table.pole)
    smallest = max(float(drops.radius_m[0]), MIN_RADIUS_UM * 1e-6)
    program.set_array("theory.edge", dark_edges(the_bows, smallest, disc_rad))
    program.set("discRadius", disc_rad)
    program.set("perRadius", middle_radius(drops.radius_m))
    gl.ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
    rows, columns = len(drops.radius_m), len(theta)
    shares = (1.0, 0.0) if components else (0.5,)
    found = np.empty((count, len(shares), rows, columns, 3), dtype=np.float32)
    for start in range(0, rows, _ROWS_AT_A_TIME):
        size = (columns, min(_ROWS_AT_A_TIME, rows - start))
        targets = [gl.ctx.texture(size, 4, dtype="f4") for _ in range(count)]
        frame = gl.ctx.framebuffer(targets)
        frame.use()
        program.set("firstRow", start)
        for part, share in enumerate(shares):
            program.set("component", share)
            program.use()
            program.draw()
            for k, target in enumerate(targets):
                pixels = np.frombuffer(target.read(), dtype=np.float32).reshape(*size[::-1], 4)
                found[k, part, start : start + size[1]] = pixels[..., :3]
    # The polariser's halves: the shader gives half of a component, its own share being one.
    return found * (2.0 if components else 1.0)
