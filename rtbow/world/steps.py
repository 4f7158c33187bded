"""How finely the shader marches: steps follow the grid and the air."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.physics.air.earth_shadow import edge_height_m
from rtbow.physics.air.rayleigh import sun_column
from rtbow.physics.constants import SCALE_HEIGHT_M
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER, fringe_phase
from rtbow.world.optics import Optics
from rtbow.world.rain.volume import DropletVolume

SAMPLES_PER_CELL = 1.5
"""Midpoint samples per grid cell crossed, where neighbouring grid points hold like drops. Between
them density is linear along an axis, so what is left is an error in the grid's second differences:
2e-4 of the frame's peak at the 99th percentile in a smooth shower (1 sample: 8e-4; 2: 9e-5)."""
SAMPLES_PER_LOG_RADIUS = 16.0
"""Further samples per cell and per unit of the logarithm of the radius between neighbours, whose
fringes a ray crosses on its way. Radii drawn at each point, 0.3-0.7 mm: 1e-3; Marshall-Palmer:
2e-3."""
SAMPLES_PER_UNEVENNESS = 8.0
"""Samples per cell where every other grid point is empty, and in proportion where less uneven: a
smooth volume has too little unevenness for this to count."""
LEAST_SAMPLES = 6.0
"""Least samples across a grid: where there are few cells their errors do not average out. As many
as within a cell come on top for the range of the radius's logarithm: 3 x 3 x 3 points of 9 to
1141 µm err by 0.3 in CIEDE2000 (by the mean change between neighbours alone: 1.3)."""
RAIN_SAMPLES = 48.0
"""Least samples across a box whose rain attenuates."""
LEAST_RAIN_SAMPLES = 48
"""Least samples along a ray through rain that attenuates, even the shortest one through a corner of
the box, where ways to a light have kinks, too: within 2e-3 of the closed form there (24: 5e-3), for
a sun that stands all but along a face."""
RAIN_DEPTH = 0.5
"""Optical depth of the densest rain per sample. Within a sample the depth is taken as even, so that
this bounds what changes of density within it do."""
MOST_RAIN_SAMPLES = 512.0
"""Most samples along the box's diagonal that the rain's depth asks for: light that has passed a
depth of 20 is gone, wherever exactly."""
UNSEEN_DEPTH = 50.0
"""Optical depth of rain behind which nothing is seen: e⁻⁵⁰ is 2e-22."""
LEAST_SEEN = 6e-3
"""Least part of a ray's distance to the rain that counts as seen however dense the rain is: a step
of the least number under a lamp is then 600 roundings of the distance, known to 0.2 %."""
_AIR_ERROR = 1e-4
"""Relative error that the midpoint rule may leave in the air's attenuation."""
_HIGHEST_EDGE_M = 1e6
"""Above this no air is left that a sun could graze, nor any rain."""
_UNSEEN_AIR_DEPTH = 20.0
"""Where such a depth of air lies between sun and drop nothing arrives: no need to resolve it."""


@dataclass(frozen=True)
class StepRates:
    """Samples per metre of ray that each part of the scene asks for; the greatest wins.

    Attributes:
        cells_per_metre: along east, north and up (3,); times |direction| per axis.
        air_per_metre: for the attenuation by air and rain.
        rain_per_metre: for the attenuation by rain alone.
    """

    cells_per_metre: Array
    air_per_metre: float
    rain_per_metre: float = 0.0


def most_steps(rates: StepRates, volume: DropletVolume) -> int:
    """Bound the steps of any ray through the volume, for an unset ``render.steps``."""
    extent = volume.box_m[1] - volume.box_m[0]
    # A ray inside the box covers no more of an axis than its extent, and no more than the diagonal.
    across = float(np.max(rates.cells_per_metre * extent))
    return int(np.ceil(max(across, rates.air_per_metre * float(np.linalg.norm(extent))))) + 1


LAMP_STEPS = 32
"""Least steps in angle along a ray that a lamp lights: within 1 % of the limit in a smooth volume,
exact in a uniform one but for the lamp's apparent size, which changes along the ray."""


LAMP_RAIN_STEPS = 160
"""Least such steps in rain that attenuates, whose depth changes with distance, not with the angle:
within 1e-3 of the brightest light in even rain about a lamp (96: 2e-3; 32: 1.6e-2)."""


def lamp_steps(rates: StepRates, volume: DropletVolume) -> int:
    """Give the steps in angle for a lamp's light, even, for an unset ``render.steps``."""
    extent = volume.box_m[1] - volume.box_m[0]
    across = float(np.max(rates.cells_per_metre * extent))
    # In fog what lies near the eye counts most, wherever the lamp.
    across = max(across, rates.rain_per_metre * float(np.linalg.norm(extent)))
    least = LAMP_RAIN_STEPS if rates.rain_per_metre > 0.0 else LAMP_STEPS
    return max(least, 2 * int(np.ceil(0.5 * across)))


_FAR_RAD = 0.7
"""Distance from a bow up to which fringes count: half the width of a usual picture."""
_BLURRED = 6.0
"""Radii of a sun's disc, as phase of the fringes, over which they are gone: 5 % are left."""
_FINE_PHASE = 2100.0
"""Phase of the fringes up to which samples need not follow it: their colours add up to white."""
_MOST_CROWDED = 5.0


def fringe_crowding(volume: DropletVolume, optics: Optics) -> float:
    """Give how many times as many samples per ln(radius) a small sun's fringes ask for.

    The phase of a bow's fringes grows with the radius, so that where it differs between grid points
    a ray crosses them. 1 where a disc blurs those that are too fine, as the sun's own does.

    Drops of 393-787 µm drawn at each point under a sun of 0.026 degrees, 99 % of pixels: the
    reference within 0.2 in CIEDE2000 (without: 1.2), the shader within 0.5 (without: 2.8).

    Args:
        volume: the drops.
        optics: the suns and the bows.
    """
    if not optics.suns or not optics.bows or volume.radius_range_um[1] <= 0.0:
        return 1.0
    disc = min(sun.disc_rad for sun in optics.suns)
    power = (volume.radius_range_um[1] * 1e-6) ** SCALE_POWER
    scale = max(float(bow.scale.max()) for bow in optics.bows) * power
    z = _FAR_RAD * scale
    if disc > 0.0:
        blurred = _BLURRED / (scale * disc)
        z = min(z, blurred * blurred)  # may be infinite, which a power may not
    return min(max(fringe_phase(z) / _FINE_PHASE, 1.0), _MOST_CROWDED)


def step_rates(volume: DropletVolume, optics: Optics, rain_per_m: float = 0.0) -> StepRates:
    """Compute the rates.

    Args:
        volume: the drops.
        optics: the air and the suns.
        rain_per_m: greatest extinction by the rain.
    """
    crowding = fringe_crowding(volume, optics)
    cells = grid_cells(volume, per_log_radius=crowding * SAMPLES_PER_LOG_RADIUS)
    return rates_on_grid(cells, volume, optics, rain_per_m)


def grid_cells(
    volume: DropletVolume,
    per_cell: float = SAMPLES_PER_CELL,
    per_log_radius: float = SAMPLES_PER_LOG_RADIUS,
) -> Array:
    """Give the samples per metre along each axis (3,) that the grid of drops asks for.

    Args:
        volume: the drops.
        per_cell: samples per cell where neighbouring points hold like drops.
        per_log_radius: further ones per cell and per change of ln(radius) between neighbours.
    """
    points = np.array(volume.shape)
    extent = volume.box_m[1] - volume.box_m[0]
    samples = per_cell + (per_log_radius * roughness(volume) if per_log_radius else 0.0)
    uneven = floats(np.maximum(samples, SAMPLES_PER_UNEVENNESS * _unevenness(volume)))
    cells = uneven * (points - 1) / extent
    if volume.uniform:
        return floats(cells)
    smallest, largest = volume.radius_range_um
    least = LEAST_SAMPLES  # of no drops, too
    if smallest > 0.0:
        least += per_log_radius * math.log(largest / smallest)
    return floats(np.maximum(cells, least / extent))


def rates_on_grid(
    cells_per_metre: Array, volume: DropletVolume, optics: Optics, rain_per_m: float
) -> StepRates:
    """Compute the rates where those of the grid alone are known.

    Args:
        cells_per_metre: the grid's own (:func:`grid_cells`).
        volume: the drops, of which only the box counts here.
        optics: the air and the suns.
        rain_per_m: greatest extinction by the rain.
    """
    extent = volume.box_m[1] - volume.box_m[0]
    cells = cells_per_metre
    if rain_per_m > 0.0:
        # The path towards a light has kinks where its way out of the box changes faces, which
        # the rain's depth shows: even rain needs steps, too.
        cells = np.maximum(cells, RAIN_SAMPLES / extent)
    rain = min(rain_per_m / RAIN_DEPTH, MOST_RAIN_SAMPLES / float(np.linalg.norm(extent)))
    return StepRates(cells, max(_air_rate(volume, optics), rain), rain)


def roughness(volume: DropletVolume) -> float:
    """Mean change of the logarithm of the radius between neighbouring grid points.

    Weighted by the light of both points: drops that scatter nothing need no samples.
    """
    if volume.uniform or volume.radius_range_um[0] == volume.radius_range_um[1]:
        return 0.0
    log_radius = np.log(_radius_of_drops(volume))
    light = np.sqrt(_light(volume))
    change, total = 0.0, 0.0
    for axis in range(3):
        ahead = (slice(None),) * axis + (slice(1, None),)
        behind = (slice(None),) * axis + (slice(None, -1),)
        weight = light[ahead] * light[behind]
        change += float(np.sum(weight * np.abs(log_radius[ahead] - log_radius[behind])))
        total += float(np.sum(weight))
    return change / total if total > 0.0 else 0.0


def _radius_of_drops(volume: DropletVolume) -> Float32:
    """Radii in µm, 1 where there are no drops: there a file may say anything."""
    return np.where(volume.number_per_m3 > 0.0, volume.radius_um, np.float32(1.0))


def _light(volume: DropletVolume) -> Float32:
    """Light that the drops at each grid point scatter, in no particular unit."""
    least, most = volume.radius_range_um
    if least == most:
        return volume.number_per_m3
    power = np.float32(RADIUS_POWER)
    return np.asarray(volume.number_per_m3 * _radius_of_drops(volume) ** power, dtype=np.float32)


def _unevenness(volume: DropletVolume) -> Array:
    """Second differences of the light along each axis (3,), over those that single points have.

    0 where it varies linearly, 1 where every other grid point is empty.
    """
    light = _light(volume)
    unevenness = np.zeros(3)
    for axis in range(3):
        if light.shape[axis] > 2:
            middle = np.moveaxis(light, axis, 0)
            bend = np.abs(middle[2:] - 2.0 * middle[1:-1] + middle[:-2])
            total = 4.0 * float(np.sum(middle, dtype=np.float64))
            if total > 0.0:
                unevenness[axis] = float(np.sum(bend, dtype=np.float64)) / total
    return unevenness


def _air_rate(volume: DropletVolume, optics: Optics) -> float:
    """Samples per metre so that the midpoint rule keeps ``_AIR_ERROR`` for exp(-rate · length).

    The midpoint rule over a step h of exp(-k t) errs by (k h)²/24; k is the largest relative
    change per metre that the air can make: along the eye ray, and by the column towards the sun
    growing thinner with height.
    """
    if not optics.has_air:
        return 0.0
    depth = float(optics.air_depth.max())
    heights = np.linspace(volume.box_m[0, 2], volume.box_m[1, 2], 17)
    steepest, grazing = 0.0, 0.0
    for sun in optics.suns:
        column = sun_column(np.maximum(heights, 0.0), sun.altitude_rad)
        if np.all(np.isfinite(column)):
            slope = np.abs(np.gradient(column, heights))
            visible = depth * column < _UNSEEN_AIR_DEPTH
            if np.any(visible):
                steepest = max(steepest, float(slope[visible].max()))
        else:
            grazing = max(grazing, _grazing_rate(volume, optics, sun.altitude_rad))
    eye = np.exp(-max(volume.box_m[0, 2], 0.0) / SCALE_HEIGHT_M) / SCALE_HEIGHT_M
    rate = max(depth * (eye + steepest), depth * eye + grazing)
    return float(rate / np.sqrt(24.0 * _AIR_ERROR))


def _grazing_rate(volume: DropletVolume, optics: Optics, altitude_rad: float) -> float:
    """Largest change per metre of the depth towards a sun whose shadow ends within the box.

    Just above the edge light passes the densest air, and only the wavelengths that the air
    attenuates least are left of it.
    """
    edge = float(edge_height_m(altitude_rad))
    if edge > _HIGHEST_EDGE_M:
        return 0.0
    heights = edge + np.linspace(1e-3, max(float(volume.box_m[1, 2]) - edge, 1e3), 33)
    column = sun_column(heights, altitude_rad)
    depth = np.multiply.outer(optics.air_depth, column)
    slope = np.multiply.outer(optics.air_depth, np.abs(np.gradient(column, heights)))
    return float(np.max(slope, initial=0.0, where=depth < _UNSEEN_AIR_DEPTH))
