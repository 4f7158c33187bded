"""What method ``fast`` does not draw within its error or its time, told before tables are made."""

from __future__ import annotations

from rtbow.base.errors import UnsuitedError
from rtbow.render.fast.shared import LEAST_STEPS, Plan
from rtbow.render.haze import SunHaze, hazy
from rtbow.render.uniforms import MOST_LOOPS
from rtbow.world.lights import Sun
from rtbow.world.steps import LEAST_RAIN_SAMPLES, lamp_steps, most_steps

_MOST_FRAMES = 10
"""A frugal plan makes tables where they cost no more than so many frames by ``spectral``."""
_FEW_EVALUATIONS = 50_000_000
"""Tables of no more evaluations are made in any case: a few seconds on a CPU."""


def check_loops(plan: Plan, per_step: int, pieces: int = 1) -> None:
    """Check that a ray's march fits in one pass of a driver that counts loops.

    Args:
        plan: the world's.
        per_step: iterations of loops within a step, itself included.
        pieces: that a ray is marched in, each with its own least steps.

    Raises:
        UnsuitedError: it does not.
    """
    world = plan.world
    fixed, volume = world.fineness.steps, world.volume
    steps = fixed * pieces if fixed else most_steps(plan.rates, volume)
    if pieces > 1 and not fixed:
        steps += pieces * (LEAST_RAIN_SAMPLES if world.rain is not None else LEAST_STEPS)
    if world.optics.lamps and fixed is None:
        steps = max(steps, 2 * lamp_steps(plan.rates, volume))
    if steps * per_step > MOST_LOOPS:
        raise UnsuitedError(
            f"{steps} steps along a ray are more than a shader's loops hold in one pass; use a"
            " smaller render.steps, a coarser volume, or --method spectral, which takes several"
        )


def check_depth(plan: Plan, most: float) -> None:
    """Check that steps through rain that attenuates are not too many optical depths long.

    Args:
        plan: the world's.
        most: depth along the box's diagonal, of its densest rain, that the default error allows.

    Raises:
        UnsuitedError: they are.
    """
    depth = plan.world.rain_depth
    if depth > most * plan.settings.share:
        raise UnsuitedError(
            f"droplets.extinction: rain of an optical depth up to {depth:.3g} across its box,"
            f" of which method fast follows {most * plan.settings.share:g} under these lights; use"
            " --method spectral, fewer drops, or a larger render.max_delta_e"
        )


def check_cost(plan: Plan, evaluations: int) -> None:
    """Check, where the plan is frugal, that a light's tables do not cost far more than the frame.

    Both are counts of a bow at one angle, radius and wavelength, of which a device makes about as
    many a second in either shader.

    Args:
        plan: the world's.
        evaluations: that the light's tables take.

    Raises:
        UnsuitedError: they do.
    """
    world = plan.world
    width, height = world.view.size_px
    steps = world.fineness.steps or most_steps(plan.rates, world.volume)
    frame = width * height * steps * len(world.optics.wavelength_nm)
    if plan.frugal and evaluations > max(_MOST_FRAMES * frame, _FEW_EVALUATIONS):
        raise UnsuitedError(
            f"colours of {len(plan.radii.fine)} radii take more than {_MOST_FRAMES} such frames by"
            " method spectral; use --method fast for many frames of them"
        )


_HAZE_COLOUR = 0.15
"""Half of the greatest difference between drops of the haze's depth at 450 nm less that at 650 nm,
at the default bound: 0.3 (CIEDE2000, 99th percentile) is left by one colour of haze for each of X,
Y and Z, 0.8 by 0.27."""


def check_haze(plan: Plan, sun: Sun) -> None:
    """Check that haze colours the light of all drops nearly alike.

    Raises:
        UnsuitedError: it does not.
    """
    if not hazy(plan.world):
        return
    spread, most = SunHaze(plan.world, sun).colour_spread, _HAZE_COLOUR * plan.settings.share
    if spread > most:
        raise UnsuitedError(
            f"atmosphere.aerosol: haze takes {spread:.2f} more of optical depth at 450 nm than at"
            f" 650 nm from some drops' light than from others'; method fast follows {most:.2f};"
            " use a higher sun, less aerosol, a larger render.max_delta_e, or --method spectral"
        )
