"""Differences between two frames, as colour differences and in tristimulus values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.light.colour import D65_XYZ

WHITE_PERCENTILE = 99.5
"""White has the luminance of the reference's pixels at this percentile."""


def delta_e_2000(xyz: Array, reference_xyz: Array, white_xyz: Array) -> Array:
    """Give the CIEDE2000 colour difference.

    Args:
        xyz: X, Y, Z (..., 3).
        reference_xyz: the same shape and unit.
        white_xyz: X, Y, Z of the white that both are seen against (3,).

    Returns:
        ΔE2000 (...); about 1 is just noticeable side by side.
    """
    # Imported late: it is slow, and nothing that draws needs it.
    from colour import XYZ_to_Lab, XYZ_to_xy, delta_E

    white = floats(white_xyz)
    chromaticity = XYZ_to_xy(white)
    lab, reference = (XYZ_to_Lab(floats(v) / white[1], chromaticity) for v in (xyz, reference_xyz))
    return floats(delta_E(lab, reference, method="CIE 2000"))


@dataclass(frozen=True)
class Spread:
    """How some numbers, none negative, are distributed.

    Attributes:
        median: half are below.
        p99: 99 % are below.
        worst: the greatest.
        p99_range: where 99 % of all lie below, with 95 % confidence, if these are a sample of them;
            without an upper end where the sample is too small for one (below 368 numbers).
    """

    median: float
    p99: float
    worst: float
    p99_range: tuple[float, float | None] | None = None

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Give the spread of values of any shape; zeros if there are none."""
        if np.size(values) == 0:
            return cls(0.0, 0.0, 0.0)
        median, p99 = np.percentile(values, [50.0, 99.0])
        return cls(float(median), float(p99), float(np.max(values)), _p99_range(values))


def _p99_range(values: Array) -> tuple[float, float | None]:
    """Give order statistics between which the 99th percentile lies: how many of n numbers are
    below it is binomial, whatever their distribution."""
    from scipy.stats import binom  # late: few that compare frames need it

    ranked, count = np.sort(np.ravel(values)), np.size(values)
    low = int(binom.ppf(0.025, count, 0.99))
    high = int(binom.ppf(0.975, count, 0.99)) + 1
    upper = float(ranked[high - 1]) if high <= count else None
    return float(ranked[max(low - 1, 0)]), upper


@dataclass(frozen=True)
class FrameDifference:
    """Distance of a frame from a reference, over the pixels with light.

    Attributes:
        delta_e: ΔE2000 per pixel.
        relative: largest difference of X, Y, Z per pixel, over the reference's white level.
        l2: root of the summed squares of the difference of X, Y, Z, over that of the reference.
    """

    delta_e: Spread
    relative: Spread
    l2: float


def frame_difference(xyz: Array, reference_xyz: Array) -> FrameDifference:
    """Measure how far a frame is from a reference.

    The white is D65 with the reference's 99.5th-percentile luminance. Pixels that are black in both
    frames count for the white alone: they would make any median look good.

    Args:
        xyz: X, Y, Z (..., 3).
        reference_xyz: the same shape and unit.

    Raises:
        ValueError: the shapes differ, the reference has no light, or a number is not finite.
    """
    frame, reference = floats(xyz), floats(reference_xyz)
    if frame.shape != reference.shape:
        raise ValueError(f"frames of shapes {frame.shape} and {reference.shape}; must be alike")
    # Before percentiles and maxima, which ignore a NaN or hide its origin.
    if not (np.all(np.isfinite(frame)) and np.all(np.isfinite(reference))):
        raise ValueError("a frame holds a NaN or an infinity")
    level = float(np.percentile(reference[..., 1], WHITE_PERCENTILE))
    if level <= 0.0:
        raise ValueError("the reference has no light; there is no white to compare against")
    lit = np.any(frame != 0.0, axis=-1) | np.any(reference != 0.0, axis=-1)
    test, truth = frame[lit], reference[lit]
    difference = np.abs(test - truth)
    return FrameDifference(
        Spread.of(delta_e_2000(test, truth, D65_XYZ * level)),
        Spread.of(difference.max(axis=-1) / level),
        float(np.sqrt(np.sum(difference**2) / np.sum(truth**2))),
    )
