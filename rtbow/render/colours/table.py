"""Colours of drops: cross-sections summed over a light's spectrum ahead of the march.

X, Y and Z of the light that a drop sends back are tabled over the scattering angle (and rows of
radius), behind a middle column of air. More or less air, or rain, multiplies each of X, Y and Z by
the exponential of a polynomial in the column: attenuation is exp(-tau column) at each wavelength,
so the logarithm of a mean over wavelengths is nearly straight, and bends with the variance of tau
over the light's own spectrum.

Spectra are taken at 1 nm with all their lines; cross-sections, which are smooth in wavelength once
the sun's disc has blurred them, at wider steps and linear between.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.physics.air.rayleigh import Column
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.drop.airy import SCALE_POWER, bows, fringe_phase
from rtbow.physics.drop.medium import Medium
from rtbow.render.colours.basis import _RAIN_DEPTH, LightBasis
from rtbow.render.colours.pixels import RIGHT_ANGLE_CHORD, PixelLevels
from rtbow.render.colours.pixels import over_pixels as chord_means


# Why a chord and not the angle. Between the unit vectors u towards the light and v along the ray
# lies the chord |u - v| = 2 sin(theta/2), for which a pixel needs a subtraction and a root. The
# angle itself takes an arc function, and from u · v no good one: the cosine is level at both poles,
# so that rounding u · v to float32 leaves an error of 5e-4 rad there.
#
# Why it is folded. The chord grows by cos(theta/2) per angle, which falls to nothing at the
# antisolar point. Beyond a right angle its mirror image takes its place: |u + v| = 2 cos(theta/2)
# is the chord to the opposite direction, and 2 sqrt(2) - |u + v| grows with the angle by
# sin(theta/2). Both are sqrt(2) at the right angle and grow by 1/sqrt(2) there, so that value and
# slope are continuous. The slope is 1 at the poles and nowhere less than 1/sqrt(2): an even step of
# the chord is one of the angle within a factor of sqrt(2), finest at the poles.
#
# What is left in float32. The rounding of u and v, 6e-8 each, and of the chord, 1.2e-7 beyond 2,
# amount to 3.4e-7 rad at any angle (400,000 random pairs of vectors, each component rounded), a
# five-hundredth of the finest table's texel.
def folded_chord(theta: Array) -> Array:
    """Give the table's coordinate of scattering angles, from 0 to 2 sqrt(2).

    Args:
        theta: scattering angles, rad, 0 for light that goes straight on; any shape.

    Returns:
        2 sin(theta/2) up to a right angle, 2 sqrt(2) - 2 cos(theta/2) beyond, the same shape.
    """
    half = 0.5 * floats(theta)
    back = theta > 0.5 * np.pi
    return floats(np.where(back, 2.0 * (RIGHT_ANGLE_CHORD - np.cos(half)), 2.0 * np.sin(half)))


def unfolded(chord: Array) -> Array:
    """Give the scattering angles, rad, of folded chords, the same shape."""
    chord = floats(chord)
    front = 2.0 * np.arcsin(np.clip(0.5 * chord, 0.0, 1.0))
    back = 2.0 * np.arccos(np.clip(RIGHT_ANGLE_CHORD - 0.5 * chord, 0.0, 1.0))
    return floats(np.where(chord > RIGHT_ANGLE_CHORD, back, front))


@dataclass(frozen=True)
class ColourTable:
    """The colours of one light as drops scatter it, over the scattering angle.

    Attributes:
        first: folded chord of the first column.
        per_chord: columns per unit of it.
        rows: rows of radius of each component.
        components: 1, or 2 (perpendicular, parallel) with a polariser.
        degree: of the polynomial in the column, and as many rows of its coefficients.
        rain: whether a row of the rain's colour follows.
        values: float32 (components * rows + degree + rain, columns, 4).
        fit_error: relative error that the polynomial leaves where there is light.
    """

    first: float
    per_chord: float
    rows: int
    components: int
    degree: int
    rain: bool
    values: Float32
    fit_error: float


def chords(low: float, high: float, step_rad: float, most: int) -> Array:
    """Choose a table's folded chords: evenly, ``step_rad`` of angle apart or less.

    Args:
        low: first scattering angle, rad.
        high: last.
        step_rad: distance of neighbours, at most, where ``most`` columns suffice.
        most: columns, at most.
    """
    ends = folded_chord(np.array([low, high]))
    # The chord grows by cos(theta/2) per angle up to a right one, least there, and is mirrored.
    folded = np.minimum(floats([low, high]), np.pi - floats([low, high]))
    slope = float(np.cos(0.5 * folded).min())
    if low < 0.5 * np.pi < high:
        slope = 1.0 / RIGHT_ANGLE_CHORD
    count = 2 + int((ends[1] - ends[0]) / (step_rad * slope)) if step_rad > 0.0 else most
    return floats(np.linspace(ends[0], ends[1], min(count, most)))


MOST_PHASE = 800.0
"""Phase of Airy's fringes up to which 1 nm, the step of the reference, follows them: from one
wavelength to the next it changes by 1.5 rad."""
_LEAST_SEEN_NM = 420.0
"""Shorter wavelengths have too little of any colour for bands of it."""
_PHASE_STEP = 0.3
"""Phase between columns, rad: linear interpolation errs by 1 % of the fringes."""


def fringe_step(
    orders: tuple[int, ...], radius_m: float, low: float, high: float, medium: Medium
) -> float:
    """Give the step of angles that follows the fringes of drops under a point of light.

    Args:
        orders: of the bows.
        radius_m: of the largest drop.
        low: first scattering angle, rad.
        high: last.
        medium: what the drops are made of.

    Returns:
        The step, rad; 0 where no step does, since wavelengths 1 nm apart differ too much.
    """
    ends = _greatest_arguments(orders, radius_m, low, high, medium)
    if max(fringe_phase(z) for z, _ in ends) > MOST_PHASE:
        return 0.0
    return min(_PHASE_STEP / (2.0 * math.sqrt(z) * scale) for z, scale in ends)


def greatest_phase(
    orders: tuple[int, ...], radius_m: float, low: float, high: float, medium: Medium
) -> float:
    """Give the greatest phase of the fringes of drops at the violet end, rad.

    It is inverse to the wavelength: neighbouring ones differ by the phase times their step over
    them. Arguments are those of :func:`fringe_step`.
    """
    return max(fringe_phase(z) for z, _ in _greatest_arguments(orders, radius_m, low, high, medium))


def fringes_missed(
    orders: tuple[int, ...],
    radius_m: float,
    low: float,
    high: float,
    medium: Medium,
    disc_rad: float,
    step_nm: float,
) -> float:
    """Give what a light's disc leaves of those fringes that a step of wavelengths takes for none.

    A sum over wavelengths averages fringes out, since their phase is inverse to the wavelength.
    Where it changes by a whole turn from one step to the next, all that are summed lie alike, and
    bands of colour come out that are not there.

    Args:
        orders: of the bows.
        radius_m: of the largest drop.
        low: first scattering angle, rad.
        high: last.
        medium: what the drops are made of.
        disc_rad: angular radius of the light's disc.
        step_nm: the step.

    Returns:
        The amplitude of the widest of them, a share of what it is without a disc; 0 where no
        fringes between these angles are so fine.
    """
    turn = 2.0 * math.pi * _LEAST_SEEN_NM / step_nm * (_LEAST_SEEN_NM / VISIBLE_NM[0])
    z = (0.75 * turn) ** (2.0 / 3.0)  # of the widest ones, at the violet end
    left = 0.0
    for greatest, scale in _greatest_arguments(orders, radius_m, low, high, medium):
        if greatest > z:
            across = 2.0 * math.sqrt(z) * scale * disc_rad  # phase across the disc's radius
            # The envelope of 2 J1(P)/P, the mean of a sine over a disc.
            left = max(left, min(1.0, 1.6 * across**-1.5) if across > 0.0 else 1.0)
    return left


def _greatest_arguments(
    orders: tuple[int, ...], radius_m: float, low: float, high: float, medium: Medium
) -> list[tuple[float, float]]:
    """Give Airy's argument at the far end of each bow, 1 at least, and its slope per rad."""
    ends = []
    violet_nm = floats(VISIBLE_NM[:1])
    for one in bows(orders, violet_nm * 1e-9, medium.index(violet_nm)):
        scale = float(one.scale[0]) * radius_m**SCALE_POWER
        reach = one.side * (floats([low, high]) - one.angle_rad[0])
        ends.append((max(scale * float(reach.max()), 1.0), scale))
    return ends


_FAINT = 1e-6
"""Share of the brightest colour that counts as light where exponents are averaged."""


def over_pixels(table: ColourTable, chord: Array, levels: PixelLevels) -> ColourTable:
    """Give a table of means over pixels: in place of each row a line for each of their extents.

    The exponents of the fall-off are averaged, too, weighted with the light that falls off: right
    to first order in the column.

    Args:
        table: of single angles.
        chord: folded chords of its columns (N,).
        levels: the pixels' extents.
    """
    values = table.values.astype(np.float64)
    count = table.rows * table.components
    colours = chord_means(values[:count], chord, levels)
    mean = values[:count].mean(axis=0)
    mean += _FAINT * mean.max() or 1.0  # a light so faint that it is none in float32 has no colours
    falls = chord_means(values[count:] * mean, chord, levels) / chord_means(mean, chord, levels)
    lines = np.concatenate([colours, falls]).reshape(-1, *values.shape[1:])
    return replace(table, values=lines.astype(np.float32))


def hat_fit(fine: Array, rows: Array) -> Array:
    """Give the matrix (R, F) that fits values at radii (F,) by straight lines between rows (R,).

    By least squares over all radii between the rows: along a ray drops of many radii meet, so that
    the mean error counts, which is far less than that of rows that are right at their own radius.

    Args:
        fine: logarithms of radii, at least as dense as the rows.
        rows: logarithms of the rows' radii, even.
    """
    if len(rows) == 1:
        return np.full((1, len(fine)), 1.0 / len(fine))
    step = (rows[-1] - rows[0]) / (len(rows) - 1)
    hats = np.maximum(1.0 - np.abs(fine[:, None] - rows) / step, 0.0)
    return floats(np.linalg.pinv(hats))


@dataclass(frozen=True)
class BakedLight:
    """What drops make of each spectrum of a light's basis.

    Attributes:
        basis: the light's.
        chord: folded chords of the angles (N,), even.
        outcomes: X, Y, Z (B, components, R, N, 3), of the weights of the basis, contiguous.
        mean: of these over components, and over radii as the scene has them (B, N, 3).
    """

    basis: LightBasis
    chord: Array
    outcomes: Array
    mean: Array

    @classmethod
    def of(cls, basis: LightBasis, chord: Array, outcomes: Array, shares: Array) -> BakedLight:
        """Make it from outcomes in any memory order and from each row's share of the light (R,)."""
        mean = np.einsum("bcrnx,r->bnx", outcomes, shares / outcomes.shape[1])
        return cls(basis, chord, np.ascontiguousarray(outcomes), floats(mean))


def colour_table(baked: BakedLight, column: Column, degree: int) -> ColourTable:
    """Turn what drops make of a light's basis into a table for a range of columns.

    The fall-off with the column is that of the mean over the scene's radii, unpolarised.

    Args:
        baked: what they make of it.
        column: the range; within the basis's.
        degree: of the polynomial in the column (:func:`column_degree`).
    """
    basis, chord, outcomes, mean = baked.basis, baked.chord, baked.outcomes, baked.mean
    count = len(basis.functions)
    components, radii, angles = outcomes.shape[1:4]
    # Weighed where they lie: a copy would take longer than the sum.
    middle = np.tensordot(basis.coefficients(floats([column.middle]))[0], outcomes[:count], axes=1)
    blocks = [middle.reshape(-1, angles, 3)]
    own = basis.weights.sum(axis=1)[:, None, :]
    # In the dark, where there is nothing to divide, light falls off as the source itself.
    behind = basis.coefficients(floats([column.middle]))[0]
    level = float((behind @ own[:count, :, 1]).max())
    faint = 1e-6 * float((behind @ mean[:count, :, 1]).max()) / max(level, 1e-300)
    lit = mean + faint * own

    def logarithm(offsets: Array) -> Array:
        grey = basis.grey(column.middle) * offsets
        left = np.tensordot(basis.coefficients(column.middle + offsets), lit[:count], axes=1)
        return floats(np.log(np.maximum(left, 1e-300)) + grey[:, None, None])

    at_middle = logarithm(np.zeros(1))
    error = 0.0
    if degree:
        offsets = column.nodes(degree + 2)
        powers = (offsets[:, None] / column.reach) ** np.arange(1, degree + 1)
        rise = logarithm(offsets) - at_middle
        fitted = np.tensordot(np.linalg.pinv(powers), rise, axes=1)
        luminance = np.exp(at_middle[0, :, 1])
        bright = luminance > 1e-3 * luminance.max()
        left = np.abs(np.tensordot(powers, fitted, axes=1) - rise)[:, bright]
        error = float(left.max()) if left.size else 0.0
        blocks.append(fitted / (column.reach ** np.arange(1, degree + 1))[:, None, None])
    if basis.rain:
        whole = basis.coefficients(floats([basis.column.middle]))
        dry = np.log(np.maximum(np.tensordot(whole, lit[:count], axes=1), 1e-300))
        blocks.append((np.log(np.maximum(lit[count:], 1e-300)) - dry) / _RAIN_DEPTH)
    values = np.zeros((sum(len(b) for b in blocks), angles, 4), dtype=np.float32)
    values[..., :3] = np.concatenate(blocks)
    return ColourTable(
        first=float(chord[0]),
        per_chord=(angles - 1) / float(chord[-1] - chord[0]),
        rows=radii,
        components=components,
        degree=degree,
        rain=basis.rain,
        values=values,
        fit_error=error,
    )
