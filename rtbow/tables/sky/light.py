"""What a sky is computed from, and what it leaves: air in constituents, scattered light, rays.

Light is a coherency tensor: of the field's components across its direction, whose trace is the
radiance and of which a polariser passes ``f·C·f``. Molecules that are small against the wavelength
scatter into a direction v what of the mean field is across it,

    S(v) = 3/(8 pi) P A P,   P = 1 - v v,   A = integral of C over all directions,

so that all orders of scattering, polarised, follow from the six numbers of A at each place. Over a
sphere under a sun A depends on height and the sun's zenith angle alone, and has four components in
the frame of the local vertical and the sun: A = a xx + b yy + c uu + d (xu + ux), with u up and x
towards the sun's azimuth.

Aerosol scatters radiance I, unpolarised, by a phase function whose Legendre moments are chi_l:

    S(v) = sum over l, m of chi_l Y_lm(v) I_lm,   I_lm = integral of I Y_lm over all directions,

with real spherical harmonics, of which those even in the azimuth from the sun are not zero. Its
phase function is cut after a few moments, the forward peak beyond them counted as not scattered
(delta-M: Wiscombe, J. Atmos. Sci. 34, 1408, 1977), but for what it makes of the sun's own light,
whose whole phase function counts (Nakajima and Tanaka, J. Quant. Spectrosc. Radiat. Transfer 40,
51, 1988).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from rtbow.base.arrays import Array

SCATTERED = 3.0 / (8.0 * np.pi)
COMPONENTS = 4
"""Of the molecules' mean field A."""
DEGREE = 7
"""Of the harmonics that aerosol's scattering is cut after."""
HARMONICS = (DEGREE + 1) * (DEGREE + 2) // 2


class Air(NamedTuple):
    """Air over a ground.

    Attributes:
        density: of its constituents over height, as in :class:`rtbow.physics.air.shells.Shells`:
            molecules first, which scatter; aerosol last, if the air is hazy; the others absorb.
        below: shares of their vertical columns below these heights, as there.
        log_column: their columns towards a sun, as there.
        depth: their vertical depths (C, W); of aerosol that of what is not in its forward peak.
        beam: their whole depths, which dim what is seen sharply (C, W).
        albedo: of the ground (W,): of what it sends back evenly to all sides. Of water, what it
            mirrors of light from all sides.
        water: refractive index of a ground that is water (W,), relative to air; else 0. What it
            mirrors of the sun's own light follows from that.
        hazy: whether there is aerosol.
        scattering: share of the aerosol's depth that is scattering (W,).
        moments: chi_l of its phase function for light that was scattered before (DEGREE + 1, W).
        phase: what it makes of the sun's own light, 1/sr, at scattering angles that are even in
            their square root from 0 to pi (angles, W).
    """

    density: Array
    below: Array
    log_column: Array
    depth: Array
    beam: Array
    albedo: Array
    water: Array
    hazy: bool
    scattering: Array
    moments: Array
    phase: Array


class Scattered(NamedTuple):
    """What has been scattered at least once, per irradiance above the air.

    Attributes:
        heights_m: of the nodes (H,).
        zeniths_rad: of the sun at the nodes (Z,).
        mean: the four components of A and, where the air is hazy, all chi_l I_lm, by l then m
            (H, Z, 4 or 4 + HARMONICS, W).
        ground: diffuse irradiance of the ground (Z, W).
    """

    heights_m: Array
    zeniths_rad: Array
    mean: Array
    ground: Array


class Path(NamedTuple):
    """A ray in pieces, and the rain along it.

    Attributes:
        height_m: of its start; the frame's up is there.
        ray: unit direction (3,).
        edges: distances of the pieces' ends, m, ascending from 0 (S + 1,).
        rain: optical depth of rain from the start to the middle of each piece, and to the end of
            the last one (S + 1,).
        rain_ratio: of the rain's depth at each wavelength over that (W,).
    """

    height_m: float
    ray: Array
    edges: Array
    rain: Array
    rain_ratio: Array


_l, _m = np.arange(DEGREE + 1.0)[:, None], np.arange(DEGREE + 1.0)
with np.errstate(divide="ignore", invalid="ignore"):
    _RISE = np.sqrt((4.0 * _l**2 - 1.0) / (_l**2 - _m**2))
    _FALL = np.sqrt(((_l - 1.0) ** 2 - _m**2) / (4.0 * (_l - 1.0) ** 2 - 1.0))
_DIAGONAL = np.sqrt((2.0 * _m + 3.0) / (2.0 * _m + 2.0))
_FACTOR = np.where(_m == 0.0, 1.0, np.sqrt(2.0))


def harmonics(cosine: Any, sine: Any, azimuth_cosine: Any, out: Array) -> None:
    """Fill in the real spherical harmonics of a direction that are even in its azimuth.

    Orthonormal over the sphere, by l then m. Source: Press et al., Numerical Recipes, 3rd edition
    (2007), section 6.7, for the recurrences.

    Args:
        cosine: of the angle from the pole.
        sine: of it.
        azimuth_cosine: cosine of the azimuth.
        out: (HARMONICS, ...); the rest of the shape is that of the arguments.
    """
    diagonal = np.sqrt(0.25 / np.pi) + 0.0 * cosine
    now, before = 1.0 + 0.0 * azimuth_cosine, azimuth_cosine
    for m in range(DEGREE + 1):
        factor = _FACTOR[m] * now
        out[m * (m + 1) // 2 + m] = factor * diagonal
        last, last_but_one = diagonal, 0.0 * diagonal
        for degree in range(m + 1, DEGREE + 1):
            fall = _FALL[degree, m] * last_but_one
            next_one = _RISE[degree, m] * (cosine * last - fall)
            out[degree * (degree + 1) // 2 + m] = factor * next_one
            last, last_but_one = next_one, last
        diagonal = _DIAGONAL[m] * sine * diagonal
        # cos((m + 1) a) from cos(m a) and cos((m - 1) a).
        now, before = 2.0 * azimuth_cosine * now - before, now
