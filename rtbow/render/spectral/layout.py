"""Method ``spectral``: the defines, numbers and rows of numbers that its shader reads."""

from __future__ import annotations

import math

import numpy as np

from rtbow.base.arrays import Array, Float32
from rtbow.base.limits import MIN_RADIUS_UM
from rtbow.gl.glsl import Define
from rtbow.physics.drop.airy import SCALE_POWER
from rtbow.render.haze import SunHaze, hazy
from rtbow.render.uniforms import bow_defines, bow_rows, common_defines, dark_edges
from rtbow.tables.airy import NEAR_S_FIXED, POLE_DISTANCE, shader_constants
from rtbow.world.camera.view import View
from rtbow.world.lights import NEAREST_M
from rtbow.world.optics import Optics
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import LEAST_RAIN_SAMPLES
from rtbow.world.world import World

LAMP_DEPTH_SAMPLES = 4
"""The rain's extinction is sampled so often within a step at a lamp, which may be long in
distance."""
SEEN_ROUNDS = 8
SEEN_SAMPLES = 64
"""What is seen of a ray through dense rain is found in rounds, by so many samples of the rain in
each but the first, which takes as many as there are steps."""
_MAX_SECTIONS = 128
"""A pixel keeps no more cross-sections than this in an array, over wavelengths and suns. Mesa's CPU
driver takes 0.4 s to compile an array of 81 and minutes for one of 401."""


def shader_defines(world: World) -> dict[str, Define]:
    """Give the shader's constants, and the switches that change its shape for a world.

    ``shaders/README.md`` lists the switches.
    """
    optics, volume = world.optics, world.volume
    table, rain = not world.bows_in_place, world.rain is not None
    first_light = 0 if table else len(optics.bows)
    return {
        **shader_constants(),
        **common_defines(world),
        "NEAREST_M": NEAREST_M,
        "LEAST_STEPS": LEAST_RAIN_SAMPLES if rain else 1,
        "LAMP_DEPTH_SAMPLES": LAMP_DEPTH_SAMPLES,
        "SEEN_ROUNDS": SEEN_ROUNDS,
        "SEEN_SAMPLES": SEEN_SAMPLES,
        "WAVELENGTH_COUNT": len(optics.wavelength_nm),
        **({} if table else bow_defines(optics.bows)),
        "FIRST_LIGHT_ROW": first_light,
        "RAIN_ROW": first_light + len(optics.lights),
        "HAZE_ROW": first_light + len(optics.lights) + rain,
        "SUN_COUNT": len(optics.suns),
        "LAMP_COUNT": len(optics.lamps),
        "ATTENUATION": optics.has_air or rain,
        "DISC": not table
        and (
            world.view.area
            or any(sun.disc_rad > 0.0 for sun in optics.suns)
            or any(lamp.radius_m > 0.0 for lamp in optics.lamps)
        ),
        "WIDE": not table and _widest_disc(optics, volume, _widening(world)) > NEAR_S_FIXED,
        "ONE_RADIUS": _one_radius(world),
        "PIXEL_POINTS": pixel_points(world),
        "POLE": not table and _pole_in_view(world.view, optics),
        "PIECES": pieces(world),
    }


_POINTS_PER_BLUR = 4.0
"""Points of a pixel whose angles are averaged, for each width of what is blurred anyway."""


def pixel_points(world: World) -> int:
    """Give the angles that are averaged over a pixel: 0 where its centre counts.

    One where a pixel is narrow beside what the light's disc and the drops' own size blur: a wider
    disc of the same variance stands for both. So it does for what several angles leave.
    """
    if not world.view.area or not world.optics.suns:
        return 0
    disc = min(sun.disc_rad for sun in world.optics.suns)
    blur = math.hypot(disc, world.narrowest_bow_rad)
    return math.ceil(_POINTS_PER_BLUR * world.view.pixel_rad / blur)


def pixel_disc(world: World, disc_rad: float) -> float:
    """Give the disc that blurs as much as a light's own and what a pixel's points leave of it.

    A table has one for the whole picture, of a typical pixel.
    """
    points = pixel_points(world)
    if not points:
        return disc_rad
    return math.sqrt(disc_rad**2 + world.view.mean_pixel_squared / (3.0 * points**2))


def pieces(world: World) -> int:
    """Pieces that a ray is marched in: cut where it enters and leaves the Earth's shadow of each
    sun, where there is any."""
    suns = world.optics.suns
    return 1 + 2 * len(suns) if any(world.shades(sun) for sun in suns) else 1


def _widest_disc(optics: Optics, volume: DropletVolume, widening: float) -> float:
    """Largest scaled disc of any sun, bow, wavelength and drop; infinite for lamps with a size."""
    if any(lamp.radius_m > 0.0 for lamp in optics.lamps):
        return np.inf  # a drop may be next to the lamp
    disc = max((sun.disc_rad for sun in optics.suns), default=0.0) + widening
    scale = max(float(bow.scale.max()) for bow in optics.bows)
    return float(scale * (volume.radius_range_um[1] * 1e-6) ** SCALE_POWER * disc)


def _widening(world: World) -> float:
    """By how much a pixel widens discs, at most, rad; 0 where its centre counts."""
    return world.view.pixel_rad if world.view.area else 0.0


def _one_radius(world: World) -> bool:
    """Whether all drops are alike, so that cross-sections need computing once per pixel."""
    optics = world.optics
    smallest, largest = world.volume.radius_range_um
    # With attenuation the shader keeps an array of them; very fine wavelength steps would
    # outgrow it.
    dims = optics.has_air or world.rain is not None
    held = len(optics.wavelength_nm) * len(optics.suns) if dims else 0
    return smallest == largest and held <= _MAX_SECTIONS


def _pole_in_view(view: View, optics: Optics) -> bool:
    """Whether any pixel lies where a disc covers rings about a bow's pole.

    That is about the antisolar point for the primary, about the sun for the secondary.
    """
    axis, cone = view.cone
    for sun in optics.suns:
        reach = cone + POLE_DISTANCE * sun.disc_rad
        for bow in optics.bows:
            towards_pole = -bow.side * sun.direction
            angle = np.arccos(np.clip(towards_pole @ axis, -1.0, 1.0))
            if sun.disc_rad > 0.0 and angle < reach:
                return True
    return False


def bow_edges(world: World) -> list[float]:
    """Give, per bow, the scattering angle beyond which it is dark (see :func:`dark_edges`)."""
    optics, volume = world.optics, world.volume
    smallest = max(volume.radius_range_um[0], MIN_RADIUS_UM) * 1e-6
    disc = max((sun.disc_rad for sun in optics.suns), default=0.0) + 1.5 * _widening(world)
    return dark_edges(optics.bows, smallest, disc)


def spectral_rows(world: World, *, components: bool) -> Float32:
    """Lay out the per-wavelength numbers as the shader reads them.

    Args:
        world: the world.
        components: the bows' strength of both components, for a polariser.

    Returns:
        float32 (bows + suns + lamps + rain + haze, W, 4): per bow angle, scale, and strength (or
        perpendicular and parallel strength); per light the weights to X, Y, Z and the air depth;
        for rain the extinction relative to the middle of the visible; for haze the same.
    """
    optics = world.optics
    zeros = np.zeros(len(optics.wavelength_nm))
    rows: list[Array | Float32] = []
    if world.bows_in_place:
        rows.extend(bow_rows(optics.bows, components=components))
    for weights in (*_dimmed_weights(world), *optics.lamp_weights):
        rows.append(np.column_stack([weights, optics.air_depth]))
    if world.rain is not None:
        rows.append(np.stack([world.rain.ratio, zeros, zeros, zeros], axis=1))
    if hazy(world):
        ratio = SunHaze(world, optics.suns[0]).ratio(optics.wavelength_nm)
        rows.append(np.stack([ratio, zeros, zeros, zeros], axis=1))
    return np.stack(rows).astype(np.float32)


def _dimmed_weights(world: World) -> tuple[Array, ...]:
    """The suns' weights behind the ozone."""
    optics = world.optics
    if world.haze is None:
        return optics.sun_weights
    return tuple(
        weights * SunHaze(world, sun).left(optics.wavelength_nm, 0.0)[:, None]
        for sun, weights in zip(optics.suns, optics.sun_weights, strict=True)
    )
