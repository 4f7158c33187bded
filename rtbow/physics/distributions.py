"""Formulas of drop size distributions: their density over the radius, and moments in closed form.

A formula counts drops of every radius above 0, also of those that are too small or too large to be
drawn; :meth:`Formula.share_within` says how much of a moment lies between two radii.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rtbow.base.arrays import Array, floats

LEAST_POWER = -0.9
"""The least alpha of :class:`GeneralGamma` that a scene may ask for by its effective variance: from
-1 on downwards the number of drops is infinite."""


class Formula(Protocol):
    """A size distribution over all radii."""

    def log_density(self, radius_um: Array) -> Array:
        """Give the logarithm of the number of drops per µm of radius, up to a constant."""
        ...

    def share_within(self, power: int, low_um: float, high_um: float) -> float:
        """Give the share of the sum of radius^power over all drops that lies between two radii.

        Args:
            power: 0 for the number of drops, 2 for their area, 3 for their volume.
            low_um: least radius.
            high_um: greatest radius.

        Returns:
            0..1; 0 where the whole moment is infinite.
        """
        ...


@dataclass(frozen=True)
class GeneralGamma:
    """Drops in proportion to r^alpha exp(-(r / scale)^exponent).

    Source: Deirmendjian, *Electromagnetic Scattering on Spherical Polydispersions* (1969); with
    exponent 1 Hansen and Travis, Space Sci. Rev. 16, 527 (1974), equation 2.56, and Ulbrich, J.
    Climate Appl. Meteor. 22, 1764 (1983), equation 2.

    Attributes:
        alpha: power of the radius; the moment of power k is finite where alpha + k > -1.
        scale_um: the radius at which the exponential is 1/e.
        exponent: of the radius in the exponential.
    """

    alpha: float
    scale_um: float
    exponent: float = 1.0

    def log_density(self, radius_um: Array) -> Array:
        """Give the logarithm of the number of drops per µm of radius, up to a constant."""
        scaled = radius_um / self.scale_um
        return floats(self.alpha * np.log(radius_um) - scaled**self.exponent)

    def share_within(self, power: int, low_um: float, high_um: float) -> float:
        """Give the share of a moment between two radii (see :class:`Formula`)."""
        from scipy.special import gammainc, gammaincc

        order = (self.alpha + power + 1.0) / self.exponent
        if order <= 0.0:
            return 0.0
        below, above = ((end / self.scale_um) ** self.exponent for end in (low_um, high_um))
        return float(1.0 - gammainc(order, below) - gammaincc(order, above))


def effective_variance(alpha: float, exponent: float) -> float:
    """Give the effective variance M2 M4 / M3² - 1 of a :class:`GeneralGamma`, which falls with
    alpha: its moments are Gamma((alpha + k + 1) / exponent), up to powers of the scale."""
    second, third, fourth = (math.lgamma((alpha + k + 1.0) / exponent) for k in (2, 3, 4))
    return math.expm1(second + fourth - 2.0 * third)


def modified_gamma(effective_radius_um: float, variance: float, exponent: float) -> GeneralGamma:
    """Give the modified gamma distribution of an effective radius and variance.

    Args:
        effective_radius_um: third moment over the second.
        variance: effective variance, at most that of alpha = :data:`LEAST_POWER`.
        exponent: of the radius in the exponential.
    """
    from scipy.optimize import brentq

    g = exponent

    def excess(alpha: float) -> float:
        return effective_variance(alpha, g) - variance

    # From the widest on, to all but a line.
    low, high = LEAST_POWER - 1e-6, 4.0 / (g * variance) + 10.0
    while excess(high) > 0.0:
        high *= 2.0
    alpha = float(brentq(excess, low, high))
    ratio = math.exp(math.lgamma((alpha + 4.0) / g) - math.lgamma((alpha + 3.0) / g))
    return GeneralGamma(alpha, effective_radius_um / ratio, g)


def ulbrich_moment(n0: float, mu: float, lambda_per_mm: float, power: int) -> float:
    """Give the sum of D^power over N(D) = N0 D^mu exp(-Lambda D), D in mm.

    Args:
        n0: N0, m⁻³ mm^(-1-mu).
        mu: power of the diameter, greater than -1 - power.
        lambda_per_mm: Lambda, mm⁻¹.
        power: 0 for the number of drops, 2 for their area.

    Returns:
        N0 Gamma(mu + power + 1) / Lambda^(mu + power + 1), m⁻³ mm^power; infinite where it is
        beyond all numbers.
    """
    order = mu + power + 1.0
    log = math.log(n0) + math.lgamma(order) - order * math.log(lambda_per_mm)
    return math.exp(log) if log < 700.0 else math.inf


@dataclass(frozen=True)
class Lognormal:
    """Drops whose ln(radius) is normally distributed."""

    median_um: float
    log_std: float

    def log_density(self, radius_um: Array) -> Array:
        """Give the logarithm of the number of drops per µm of radius, up to a constant."""
        away = np.log(radius_um / self.median_um) / self.log_std
        return floats(-np.log(radius_um) - 0.5 * away**2)

    def share_within(self, power: int, low_um: float, high_um: float) -> float:
        """Give the share of a moment between two radii: it is log-normal, too, about a median
        that is exp(power · log_std²) as large (Hatch and Choate, 1929)."""
        below, above = (
            math.log(end / self.median_um) / self.log_std - power * self.log_std
            for end in (low_um, high_um)
        )
        return 1.0 - _normal_beyond(-below) - _normal_beyond(above)


@dataclass(frozen=True)
class Normal:
    """Drops whose radius is normally distributed; the curve counts from radius 0 on."""

    mean_um: float
    std_um: float

    def log_density(self, radius_um: Array) -> Array:
        """Give the logarithm of the number of drops per µm of radius, up to a constant."""
        return floats(-0.5 * ((radius_um - self.mean_um) / self.std_um) ** 2)

    def share_within(self, power: int, low_um: float, high_um: float) -> float:
        """Give the share of a moment between two radii (see :class:`Formula`)."""
        outside = self._integral(power, 0.0, low_um) + self._integral(power, high_um, math.inf)
        return 1.0 - outside / self._integral(power, 0.0, math.inf)

    def _integral(self, power: int, low_um: float, high_um: float) -> float:
        """Integrate r^power over the curve: the curve is a polynomial's weight within 12 standard
        deviations, beyond which nothing is left."""
        far = 12.0 * self.std_um
        low = max(low_um, self.mean_um - far)
        high = min(high_um, self.mean_um + far)
        if high <= low:
            return 0.0
        nodes, weights = np.polynomial.legendre.leggauss(20)
        pieces = np.linspace(low, high, 25)
        half = 0.5 * np.diff(pieces)[:, None]
        r = 0.5 * (pieces[1:] + pieces[:-1])[:, None] + half * nodes
        return float(np.sum(weights * half * r**power * np.exp(self.log_density(r))))


def _normal_beyond(z: float) -> float:
    """Give the share of a normal distribution beyond z standard deviations."""
    return 0.5 * math.erfc(z / math.sqrt(2.0))
