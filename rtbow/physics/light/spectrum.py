"""A spectrum, and its exact integrals over wavelength bins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.light.colour import colour_matching


@dataclass(frozen=True)
class Spectrum:
    """A spectrum, linear between its points and zero beyond them.

    Attributes:
        name: what the user calls it.
        wavelength_nm: points (n,), increasing.
        value: W m⁻² nm⁻¹ where absolute, else in any unit, (n,).
        absolute: whether ``value`` is the irradiance that the light gives.
    """

    name: str
    wavelength_nm: Array
    value: Array
    absolute: bool = False

    def integral(self, low_nm: float, high_nm: float) -> float:
        """Integrate exactly between two wavelengths."""
        return float(_product_integrals(self, np.array([low_nm, high_nm]), None)[0, 0])

    @property
    def visible(self) -> float:
        """Integral over 380-780 nm."""
        return self.integral(*VISIBLE_NM)

    def scaled(self, irradiance_w_m2: float) -> Spectrum:
        """Give the spectrum scaled to an integral over 380-780 nm, W/m²."""
        factor = irradiance_w_m2 / self.visible
        return Spectrum(self.name, self.wavelength_nm, self.value * factor, absolute=True)


@dataclass(frozen=True)
class Bins:
    """Wavelengths of a spectral integral and the bins around them.

    Attributes:
        wavelength_nm: bin positions (n,), from 380 to 780 inclusive.
        edges_nm: bin edges (n + 1,); the first and last bins are half bins.
    """

    wavelength_nm: Array
    edges_nm: Array


def wavelength_bins(step_nm: float) -> Bins:
    """Lay bins of ``step_nm`` over 380-780 nm; the step divides the range evenly."""
    low, high = VISIBLE_NM
    count = round((high - low) / step_nm)
    nodes = np.linspace(low, high, count + 1)
    edges = np.concatenate([[low], 0.5 * (nodes[:-1] + nodes[1:]), [high]])
    return Bins(nodes, edges)


def _product_integrals(spectrum: Spectrum, edges_nm: Array, factors: Array | None) -> Array:
    """Integrate spectrum × factor over bins, exactly for piecewise linear tables.

    Args:
        spectrum: the spectrum.
        edges_nm: bin edges (n + 1,).
        factors: table (m, 1 + c) of wavelength and c factors, or None for a factor of 1.

    Returns:
        Integrals (n, c).
    """
    points = [edges_nm, spectrum.wavelength_nm]
    if factors is not None:
        points.append(factors[:, 0])
    cuts = np.unique(np.concatenate(points))
    cuts = cuts[(cuts >= edges_nm[0]) & (cuts <= edges_nm[-1])]
    middle = 0.5 * (cuts[:-1] + cuts[1:])

    def product(at: Array) -> Array:
        value = np.interp(at, spectrum.wavelength_nm, spectrum.value, left=0.0, right=0.0)
        if factors is None:
            return value[:, None]
        columns = [np.interp(at, factors[:, 0], factors[:, k]) for k in range(1, factors.shape[1])]
        return value[:, None] * np.stack(columns, axis=1)

    # The product of two linear pieces is a parabola: Simpson's rule is exact.
    ends = product(cuts)
    pieces = (ends[:-1] + 4.0 * product(middle) + ends[1:]) * (np.diff(cuts) / 6.0)[:, None]
    first = np.searchsorted(cuts, edges_nm[:-1])
    return np.add.reduceat(pieces, first, axis=0)


def colour_weights(spectrum: Spectrum, bins: Bins) -> Array:
    """Integrate spectrum × colour-matching functions over each bin.

    The product is integrated, not sampled: E-490 has structure at 1-2 nm and lamps have lines, and
    a quantity that is smooth over a bin then needs one sample there.

    Args:
        spectrum: irradiance, W m⁻² nm⁻¹.
        bins: the bins (n).

    Returns:
        Weights (n, 3) in lm/m²: times a radiance per irradiance [sr⁻¹], summed, they give X, Y, Z
        with Y in cd/m².
    """
    nm, xyz = colour_matching()
    return _product_integrals(spectrum, bins.edges_nm, np.column_stack([nm, xyz]))


def bin_means(spectrum: Spectrum, bins: Bins) -> Array:
    """Give the mean of a spectrum over each bin (n,), in the spectrum's own unit."""
    return floats(_product_integrals(spectrum, bins.edges_nm, None)[:, 0] / np.diff(bins.edges_nm))


def luminous(spectrum: Spectrum) -> float:
    """Integrate a spectrum with the luminosity function: lumen (per area, per sr …) from watts."""
    return float(colour_weights(spectrum, Bins(np.array([580.0]), np.array(VISIBLE_NM)))[0, 1])
