"""The constants, uniforms and rows of bows that the shaders of every method read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, Float32
from rtbow.base.limits import NO_PLANE
from rtbow.gl.glsl import Define, glsl_literal
from rtbow.gl.program import GlProgram
from rtbow.physics.air import earth_shadow, rayleigh
from rtbow.physics.constants import EARTH_RADIUS_M, SCALE_HEIGHT_M
from rtbow.physics.drop.airy import SCALE_POWER, Bow
from rtbow.physics.light.colour import XYZ_TO_RGB
from rtbow.tables.airy import NEAR_Z_LOW
from rtbow.world.camera.panorama import Panorama
from rtbow.world.camera.perspective import Perspective
from rtbow.world.lights import Sun
from rtbow.world.steps import LEAST_SEEN, UNSEEN_DEPTH, StepRates
from rtbow.world.world import World

MAX_STEPS = 1 << 20
"""A ray is marched in no more than this many steps."""
MOST_LOOPS = 65_000
"""A pixel's loops must not iterate more often than this in one pass: Mesa's CPU driver ends all of
a shader's loops after 65,535 in sum, silently."""

MOST_BEND = 0.25
"""Where a pixel is a mean over its area, a box's faces count as edges whose distance changes by
more than this share from the pixel's centre to its corner."""
MOST_KINK = 0.1
"""Where two of a box's faces meet within a pixel, that is an edge if their distances change by more
than this share of the length inside from the pixel's centre to its corner, together."""
NEAR_LAMP = 4.0
"""Where a pixel is a mean over its area, it takes several rays up to so many pixels from a lamp."""
LAMP_POINTS = 8
"""Rays that such a pixel takes."""
_LAMP_WIDE = 2.0
"""Pixels up to so many widths of the bow show a lamp's fringes as their centres do: within ΔE2000
1.4, 0.2 at the 99th percentile (scenes ``street-lamp`` and ``two-lamps``)."""


def matrix_literal(matrix: NDArray[np.float64]) -> str:
    """Write a matrix as GLSL, which lists columns first."""
    values = ", ".join(glsl_literal(float(v)) for v in matrix.T.ravel())
    return f"mat3({values})"


def common_defines(world: World) -> dict[str, Define]:
    """Give the constants and switches that mean the same in every method."""
    return {
        "EARTH_RADIUS_M": EARTH_RADIUS_M,
        "SCALE_HEIGHT_M": SCALE_HEIGHT_M,
        "MAX_HEIGHT_M": rayleigh.MAX_HEIGHT_M,
        "ALTITUDE_CURVE": rayleigh.ALTITUDE_CURVE,
        "XYZ_TO_RGB": matrix_literal(XYZ_TO_RGB),
        "NO_PLANE": NO_PLANE,
        "MAX_STEPS": MAX_STEPS,
        "GRID": not world.volume.uniform,
        "AIR": world.optics.has_air,
        "EXTINCTION": world.rain is not None,
        "HAZE": world.haze is not None and world.haze.aerosol is not None,
        "UNSEEN_DEPTH": UNSEEN_DEPTH,
        "LEAST_SEEN": LEAST_SEEN,
        "POLARIZER": world.view.polarizer is not None,
        "PANORAMA": isinstance(world.view, Panorama),
        "PIXEL_AREA": world.view.area,
        "MOST_BEND": MOST_BEND,
        "MOST_KINK": MOST_KINK,
        "NEAR_LAMP": NEAR_LAMP,
        "LAMP_POINTS": LAMP_POINTS,
        "LAMP_WIDE": "true" if lamp_pixels_wide(world) else "false",
        "PIECES": 1,
    }


def lamp_points(world: World) -> int:
    """Give the rays that a pixel takes under a lamp, at most."""
    return LAMP_POINTS if world.view.area else 1


def lamp_pixels_wide(world: World) -> bool:
    """Whether pixels that are means over their area are wider than a lamp's fringes."""
    view = world.view
    return view.area and view.pixel_rad > _LAMP_WIDE * world.narrowest_bow_rad


def common_uniforms(world: World, box_m: Array, rates: StepRates) -> dict[str, Any]:
    """Give the uniforms that mean the same in every method.

    Args:
        world: the world.
        box_m: where its drops are (2, 3).
        rates: samples per metre of ray.
    """
    view, volume, eye = world.view, world.volume, world.view.eye_m
    uniforms: dict[str, Any] = {
        "camera.size": tuple(float(n) for n in view.size_px),
        "camera.basis": tuple(view.basis.ravel()),
        "air.eyeHeight": float(eye[2]),
        # Relative to the eye in float64, so that float32 keeps its digits far from the origin.
        "volume.low": tuple(box_m[0] - eye),
        "volume.high": tuple(box_m[1] - eye),
        "march.cellsPerMetre": tuple(rates.cells_per_metre),
        "march.airPerMetre": rates.air_per_metre,
        "march.fixedSteps": world.fineness.steps or 0,
    }
    if view.area and isinstance(view, Perspective):
        uniforms["camera.axis"] = tuple(view.axis)
    if view.polarizer is not None:
        uniforms["camera.pass"] = tuple(view.polarizer)
    if volume.uniform:
        uniforms["volume.density"] = float(volume.number_per_m3[0, 0, 0])
        uniforms["volume.extinction"] = world.rain_per_m
    return uniforms


def shadow_uniforms(sun: Sun, eye_m: Array) -> dict[str, Any]:
    """Give the numbers of a sun's shadow (``EarthShadow`` in the shader), as the eye (3,) is in it.

    In float64, from which float32 keeps millimetres: the Earth's radius is taken out.
    """
    clear, outward, sunward = earth_shadow.cylinder(eye_m, eye_m, sun.direction)
    return {
        "towards": tuple(sun.direction),
        "clear": float(clear),
        "outward": tuple(outward),
        "sunward": float(sunward),
    }


def set_uniforms(program: GlProgram, values: Mapping[str, Any]) -> None:
    """Set those uniforms that a program has."""
    for name, value in values.items():
        program.set(name, value)


def dark_edges(bows: Sequence[Bow], smallest_m: float, disc_rad: float) -> list[float]:
    """Give, per bow, the scattering angle beyond which it is dark.

    The table's first column is dark for the drop that reaches furthest, the smallest; each
    wavelength's own angle and the widest disc are allowed for.
    """
    edges = []
    for bow in bows:
        reach = -NEAR_Z_LOW / (bow.scale * smallest_m**SCALE_POWER) + disc_rad
        limits = bow.angle_rad - bow.side * reach
        edges.append(float(limits.min() if bow.side > 0 else limits.max()))
    return edges


def bow_defines(bows: Sequence[Bow]) -> dict[str, Define]:
    """Give the number of bows and their bright sides as ``drop/airy_theory.glsl`` reads them."""
    sides = ", ".join(glsl_literal(bow.side) for bow in bows)
    return {"BOW_COUNT": len(bows), "BOW_SIDE": f"float[]({sides})"}


def bow_rows(bows: Sequence[Bow], *, components: bool) -> Float32:
    """Lay out bows as the shader reads them.

    Args:
        bows: the bows.
        components: the strength of both components, for a polariser.

    Returns:
        float32 (bows, W, 4): angle, scale, and strength (or perpendicular and parallel strength).
    """
    rows = []
    for bow in bows:
        strength = (
            (bow.perpendicular, bow.parallel) if components else (bow.strength, 0.0 * bow.strength)
        )
        rows.append(np.stack([bow.angle_rad, bow.scale, *strength], axis=1))
    return np.array(rows, dtype=np.float32).reshape(len(rows), -1, 4)
