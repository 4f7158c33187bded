"""A light's spectrum behind any column of air, as a sum of a few spectra."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.air.rayleigh import Column, rayleigh_depth
from rtbow.physics.constants import SEA_LEVEL_HPA
from rtbow.physics.light.spectrum import Spectrum, colour_weights, wavelength_bins

MOST_OUTCOMES = 8
"""A table is made from no more spectra than every OpenGL 3.3 has draw buffers."""
MOST_DEGREE = 5
"""The polynomial in the column has no greater degree."""
_RAIN_DEPTH = 1.0
"""The rain's colour is taken at this depth."""
_FINE_NM = 1.0
"""Spectra are integrated at this step of wavelengths, or a finer one of cross-sections."""
_PINNED = 1.6
"""A polynomial that has to be right at the middle errs by up to this factor more; 1.5 was the most
that was found."""
_BASIS_ERROR = 3e-6
"""A basis leaves out functions whose size is a smaller part than this of the first one's."""


@dataclass(frozen=True)
class LightBasis:
    """A light's spectrum behind any column of air within a range, as a sum of a few spectra.

    exp(-tau column) over the visible is, for all columns together, a sum of a few functions of the
    wavelength. What drops make of each of these is computed once; a column's colours are then a sum
    with a few coefficients.

    Attributes:
        wavelength_nm: of cross-sections (W,).
        weights: to X, Y, Z (B, W, 3), and one more where rain has a colour: the light behind the
            range's middle and the rain.
        column: the range.
        tau: vertical depth of the air at fine wavelengths (F,).
        functions: of the basis, orthonormal in the light's weight (B, F).
        measure: that weight (F,).
        luminance: of the light at fine wavelengths (F,).
        rain: whether the last weights are the rain's.
        pressure_hpa: of the air at height 0.
    """

    wavelength_nm: Array
    weights: Array
    column: Column
    tau: Array
    functions: Array
    measure: Array
    luminance: Array
    rain: bool
    pressure_hpa: float

    def coefficients(self, columns: Array) -> Array:
        """Give the coefficients (K, B) of columns (K,)."""
        left = np.exp(-np.outer(columns, self.tau))
        return floats((left * self.measure) @ self.functions.T)

    def grey(self, column: float) -> float:
        """Give the mean depth per column of what is left of the light behind a column."""
        left = self.luminance * np.exp(-self.tau * column)
        return float(left @ self.tau / max(float(left.sum()), 1e-300))


def mean_column_error(basis: LightBasis, column: Column) -> float:
    """Bound the relative error of taking a path's light to be behind its mean column.

    Of second order: half the column's variance along the path, that of even spread over the whole
    range at most, times the variance of the depth per column over the spectrum of X, Y or Z.
    """
    coefficients = basis.coefficients(floats([column.middle]))[0]
    tau = rayleigh_depth(basis.wavelength_nm, basis.pressure_hpa)
    weights = np.tensordot(coefficients, basis.weights[: len(coefficients)], axes=1)  # (W, 3)
    total = weights.sum(axis=0)
    share = weights / np.where(total > 0.0, total, 1.0)
    variance = tau**2 @ share - (tau @ share) ** 2
    return float(variance.max()) * (2.0 * column.reach) ** 2 / 24.0


def light_basis(
    spectrum: Spectrum,
    step_nm: float,
    column: Column,
    rain_ratio: Callable[[Array], Array] | None = None,
    pressure_hpa: float = SEA_LEVEL_HPA,
) -> LightBasis:
    """Choose a basis and weigh the spectrum with it.

    Args:
        spectrum: of the light, before the air.
        step_nm: between the wavelengths of cross-sections.
        column: the columns that will be asked for; ``NO_AIR`` without air.
        rain_ratio: gives the rain's extinction at wavelengths (nm) over that of the weights.
        pressure_hpa: of the air at height 0.
    """
    nodes = wavelength_bins(step_nm).wavelength_nm
    fine = wavelength_bins(min(_FINE_NM, step_nm))
    weights = colour_weights(spectrum, fine)  # (F, 3)
    tau = np.zeros(len(weights))
    if column.high > 0.0:
        tau = rayleigh_depth(fine.wavelength_nm, pressure_hpa)
    # Each wavelength counts by its greatest share in X, Y or Z, and none is lost altogether.
    total = weights.sum(axis=0)
    measure = (weights / np.where(total > 0.0, total, 1.0)).max(axis=1) + 1e-6
    measure /= measure.sum()
    at = np.linspace(column.low, column.high, 129 if column.reach > 0.0 else 1)
    left = np.exp(-np.outer(at, tau))
    left /= (left @ measure)[:, None]  # alike in all columns, however little they leave
    weighted = left * np.sqrt(measure)
    # Singular vectors by way of the small matrix of products of columns.
    powers, mixes = np.linalg.eigh(weighted @ weighted.T)
    sizes = np.sqrt(np.maximum(powers[::-1], 0.0))
    count = min(int(np.sum(sizes > _BASIS_ERROR * sizes[0])), MOST_OUTCOMES - 1)
    functions = (mixes[:, ::-1].T[:count] @ weighted) / sizes[:count, None] / np.sqrt(measure)
    spectra = [weights * function[:, None] for function in functions]
    if rain_ratio is not None:
        excess = rain_ratio(fine.wavelength_nm) - 1.0
        behind = np.exp(-tau * column.middle - excess * _RAIN_DEPTH)
        spectra.append(weights * behind[:, None])
    # Each fine wavelength counts at its two neighbours among the nodes, by its distance.
    hats = np.maximum(1.0 - np.abs(nodes[:, None] - fine.wavelength_nm) / step_nm, 0.0)
    return LightBasis(
        nodes, floats(np.stack([hats @ weighed for weighed in spectra])), column, tau, functions,
        measure, weights[:, 1], rain_ratio is not None, pressure_hpa,
    )  # fmt: skip


def column_degree(basis: LightBasis, column: Column, tolerance: float) -> int:
    """Give the least degree of a polynomial in the column that follows the light itself.

    Drops colour the light, which narrows its spectrum and makes the fit better, not worse.

    Args:
        basis: the light's.
        column: the range.
        tolerance: relative error allowed.
    """
    if column.reach <= 0.0:
        return 0
    at = np.linspace(-column.reach, column.reach, 65)
    logarithm = _source_logarithm(basis, column, at)
    for degree in range(1, MOST_DEGREE):
        nodes = column.nodes(degree + 2)
        sample = _source_logarithm(basis, column, nodes)
        fitted = np.stack([_line(nodes, sample[:, c], degree, at) for c in range(3)], axis=1)
        if np.abs(np.expm1(fitted - logarithm)).max() < tolerance / _PINNED:
            return degree
    return MOST_DEGREE


def _source_logarithm(basis: LightBasis, column: Column, offsets: Array) -> Array:
    """Logarithms (K, 3) of the light's own X, Y, Z behind columns, the grey part left out."""
    coefficients = basis.coefficients(column.middle + offsets)
    source = coefficients @ basis.weights[: coefficients.shape[1]].sum(axis=1)
    grey = basis.grey(column.middle) * offsets
    return floats(np.log(np.maximum(source, 1e-300)) + grey[:, None])


def _line(nodes: Array, values: Array, degree: int, at: Array) -> Array:
    return floats(np.polynomial.chebyshev.Chebyshev.fit(nodes, values, degree)(at))
