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

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rtbow.arrays import Array, Float32, floats
from rtbow.atmosphere import rayleigh_depth
from rtbow.spectrum import Spectrum, colour_weights, wavelength_bins

MOST_OUTCOMES = 8
"""Columns and depths that a table is made from: draw buffers that every OpenGL 3.3 has."""
MOST_DEGREE = 5
_RIGHT_CHORD = float(np.sqrt(2.0))
_RAIN_DEPTH = 1.0
"""Depth of rain at which its colour is taken."""
_FINE_NM = 1.0


def folded_chord(theta: Array) -> Array:
    """Give the table's coordinate of scattering angles, 0 to 2 sqrt(2): chords of the unit circle,
    2 sin(theta/2) up to a right angle, mirrored beyond."""
    half = 0.5 * floats(theta)
    back = theta > 0.5 * np.pi
    return floats(np.where(back, 2.0 * (_RIGHT_CHORD - np.cos(half)), 2.0 * np.sin(half)))


def unfolded(chord: Array) -> Array:
    """Give the angles of folded chords."""
    at = floats(chord)
    front = 2.0 * np.arcsin(np.clip(0.5 * at, 0.0, 1.0))
    back = 2.0 * np.arccos(np.clip(_RIGHT_CHORD - 0.5 * at, 0.0, 1.0))
    return floats(np.where(at > _RIGHT_CHORD, back, front))


@dataclass(frozen=True)
class Column:
    """The air between light, drops and eye, as far as a table covers it.

    Attributes:
        low: least column, of sun and eye path together.
        high: greatest.
    """

    low: float
    high: float

    @property
    def middle(self) -> float:
        """The column whose colours are stored."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> float:
        """Largest distance from it."""
        return 0.5 * (self.high - self.low)

    def nodes(self, count: int) -> Array:
        """Chebyshev points about the middle, ascending, relative to it."""
        return floats(-np.cos((np.arange(count) + 0.5) * np.pi / count) * self.reach)

    def window(self, step: float) -> Column:
        """Give a range about it whose ends are multiples of a step, so that it serves others too."""
        return Column(max(np.floor(self.low / step) * step, 0.0), np.ceil(self.high / step) * step)


NO_AIR = Column(0.0, 0.0)


@dataclass(frozen=True)
class LightColumns:
    """A light's spectrum behind some columns of air, for cross-sections at some wavelengths.

    Attributes:
        wavelength_nm: (W,).
        offsets: columns relative to the middle (K,).
        grey: depth per column that the weights along a ray carry; the outcomes lack it.
        weights: (outcomes, W, 3): to X, Y, Z. K columns, and the rain's outcome if there is one.
        degree: of the polynomial in the column.
        rain: whether the last outcome is the rain's.
    """

    wavelength_nm: Array
    offsets: Array
    grey: float
    weights: Array
    degree: int
    rain: bool


def light_columns(
    spectrum: Spectrum,
    step_nm: float,
    column: Column,
    tolerance: float,
    rain_ratio: Callable[[Array], Array] | None = None,
    degree: int | None = None,
) -> LightColumns:
    """Choose columns and the degree that follows them, and weigh the spectrum.

    Args:
        spectrum: of the light, before the air.
        step_nm: between the wavelengths of cross-sections.
        column: the columns in the scene; ``NO_AIR`` without.
        tolerance: relative error allowed to the fit.
        rain_ratio: gives the rain's extinction at wavelengths (nm) over that of the weights.
        degree: of the polynomial; left out: the least that keeps the tolerance.
    """
    nodes = wavelength_bins(step_nm).wavelength_nm
    fine = wavelength_bins(min(_FINE_NM, step_nm))
    weights = colour_weights(spectrum, fine)  # (F, 3)
    tau = rayleigh_depth(fine.wavelength_nm)
    middle = weights * np.exp(-tau * column.middle)[:, None]
    total = float(middle[:, 1].sum())
    grey = float(middle[:, 1] @ tau / total) if total > 0.0 else 0.0
    if degree is None:
        degree = _degree(middle, tau - grey, column, tolerance) if column.reach > 0.0 else 0
    offsets = column.nodes(degree + 2) if degree else np.zeros(1)
    outcomes = [middle * np.exp(-(tau - grey) * x)[:, None] for x in offsets]
    if rain_ratio is not None:
        excess = rain_ratio(fine.wavelength_nm) - 1.0
        outcomes.append(middle * np.exp(-excess * _RAIN_DEPTH)[:, None])
    # Each fine wavelength counts at its two neighbours among the nodes, by its distance.
    hats = np.maximum(1.0 - np.abs(nodes[:, None] - fine.wavelength_nm) / step_nm, 0.0)
    return LightColumns(
        nodes, offsets, grey, floats(np.stack([hats @ one for one in outcomes])), degree,
        rain_ratio is not None,
    )  # fmt: skip


def _degree(weights: Array, tau: Array, column: Column, tolerance: float) -> int:
    """Least degree that follows the light itself through all columns.

    Drops colour the light, which narrows its spectrum and makes the fit better, not worse.
    """
    at = np.linspace(-column.reach, column.reach, 65)
    left = np.exp(-np.outer(at, tau)) @ weights  # (65, 3)
    logarithm = np.log(np.maximum(left, 1e-300))
    for degree in range(1, MOST_DEGREE):
        nodes = column.nodes(degree + 2)
        sample = np.log(np.maximum(np.exp(-np.outer(nodes, tau)) @ weights, 1e-300))
        fitted = np.stack([_line(nodes, sample[:, c], degree, at) for c in range(3)], axis=1)
        if np.abs(np.expm1(fitted - logarithm)).max() < tolerance:
            return degree
    return MOST_DEGREE


def _line(nodes: Array, values: Array, degree: int, at: Array) -> Array:
    return floats(np.polynomial.chebyshev.Chebyshev.fit(nodes, values, degree)(at))


@dataclass(frozen=True)
class ColourTable:
    """Colours of one light's scattered light.

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
    # The chord grows by cos(theta/2) per angle, at least by 1/sqrt(2) at the right angle.
    slope = 1.0 if low > 0.6 * np.pi else 1.0 / _RIGHT_CHORD
    count = 2 + int((ends[1] - ends[0]) / (step_rad * slope))
    return floats(np.linspace(ends[0], ends[1], min(count, most)))


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


def colour_table(outcomes: Array, light: LightColumns, chord: Array, fit: Array) -> ColourTable:
    """Turn what drops make of each column's light into a table.

    The fall-off with the column is that of the mean over all radii, unpolarised.

    Args:
        outcomes: X, Y, Z (outcomes, components, F, N, 3), of the weights of ``light``.
        light: whose weights they were made with.
        chord: folded chords of the columns (N,), even.
        fit: (R, F), as :func:`hat_fit` gives it.
    """
    columns = len(light.offsets)
    # At the middle column: exact for polynomials through all columns.
    powers = np.vander(light.offsets / max(float(np.abs(light.offsets).max()), 1e-12),
                       increasing=True)  # fmt: skip
    middle = np.tensordot(np.linalg.inv(powers)[0], outcomes[:columns], axes=1)  # (C, F, N, 3)
    rows = np.einsum("rf,cfnx->crnx", fit, middle)
    components, count = rows.shape[0], rows.shape[2]
    blocks = [rows.reshape(-1, count, 3)]
    # In the dark, where there is nothing to divide, light falls off as the source itself.
    source = light.weights.sum(axis=1)[:, None, :]
    mean = outcomes.mean(axis=(1, 2))  # (outcomes, N, 3)
    level = 1e-6 * mean[:columns, :, 1].max() / source[:columns, :, 1].max()
    logarithm = np.log(np.maximum(mean + level * source, 1e-300))
    at_middle = np.tensordot(np.linalg.inv(powers)[0], logarithm[:columns], axes=1)
    error = 0.0
    if light.degree:
        reach = float(np.abs(light.offsets).max())
        some = powers[:, 1 : light.degree + 1]
        rise = logarithm[:columns] - at_middle
        fitted = np.tensordot(np.linalg.pinv(some), rise, axes=1)
        left = np.abs(np.tensordot(some, fitted, axes=1) - rise)
        lit = mean[:columns, :, 1] > 1e-3 * mean[:columns, :, 1].max()
        error = float(left[lit].max()) if lit.any() else 0.0
        blocks.append(fitted / (reach ** np.arange(1, light.degree + 1))[:, None, None])
    if light.rain:
        blocks.append(((logarithm[columns] - at_middle) / _RAIN_DEPTH)[None])
    values = np.zeros((sum(len(b) for b in blocks), count, 4), dtype=np.float32)
    values[..., :3] = np.concatenate(blocks)
    return ColourTable(
        first=float(chord[0]),
        per_chord=(count - 1) / float(chord[-1] - chord[0]),
        rows=rows.shape[1],
        components=components,
        degree=light.degree,
        rain=light.rain,
        values=values,
        fit_error=error,
    )
