"""Which step of wavelengths ``auto`` takes where it leaves a world to ``spectral``."""

from __future__ import annotations

import math

from rtbow.render.colours.table import MOST_PHASE, greatest_phase
from rtbow.world.world import World

_DENSE = 30.0
"""Optical depth of rain across its box beyond which a ray under a lamp counts as a single place."""
_STEPS_NM = (4.0, 2.5, 2.0, 1.0)
"""Steps that ``auto`` takes instead of a scene's, which divide the visible range."""


def sharp_step_nm(world: World) -> float:
    """Give the step of wavelengths that follows the fringes of a world, nm.

    The scene's own one, or a finer one where nothing blurs the fringes of single drops: under a sun
    without a disc, and under a lamp without one in rain so dense that each pixel sees a single
    place, at one angle.

    Args:
        world: the world.
    """
    step = world.fineness.wavelength_step_nm
    if not world.bows_in_place:
        return step
    ends = [
        world.view.angles_from(sun.direction) for sun in world.optics.suns if sun.disc_rad == 0.0
    ]
    if world.rain_depth > _DENSE and any(lamp.radius_m == 0.0 for lamp in world.optics.lamps):
        ends.append((0.0, math.pi))
    radius_m = world.volume.size_range_um[1] * 1e-6
    scatterer = world.scatterer
    phase = 0.0
    for low, high in ends:
        reach = greatest_phase(scatterer.orders, radius_m, low, high, scatterer.medium)
        phase = max(phase, reach)
    wanted = MOST_PHASE / phase if phase > 0.0 else math.inf  # of neighbours, a step of 1 nm apart
    finer = [least for least in _STEPS_NM if least <= wanted] or [_STEPS_NM[-1]]
    return min(step, finer[0]) if wanted < step else step
