"""Drops of several sizes, and Marshall and Palmer's raindrops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import TABLE_RADII_UM

MARSHALL_PALMER_N0_M4 = 8e6
"""N0 of equation 1: 0.08 cm⁻⁴ = 8e6 drops per m³ and per m of diameter."""


def marshall_palmer_slope(rain_rate_mm_h: float) -> float:
    """Give Lambda of equation 1 in m⁻¹: 41 R^-0.21 per cm of diameter."""
    return float(4100.0 * rain_rate_mm_h**-0.21)


def marshall_palmer(diameter_m: Array, rain_rate_mm_h: float) -> Array:
    """Give N_D, drops per m³ and per m of diameter, same shape as ``diameter_m``.

    Source: Marshall and Palmer, J. Meteorol. 5, 165 (1948); equation 1 of Fujiwara et al.
    """
    d = np.asarray(diameter_m, dtype=np.float64)
    return MARSHALL_PALMER_N0_M4 * np.exp(-marshall_palmer_slope(rain_rate_mm_h) * d)


@dataclass(frozen=True)
class Sizes:
    """Drops of several sizes in one place.

    Attributes:
        radius_m: (n,), ascending.
        share: of the number of drops (n,), summing to 1.
        number_per_m3: drops of all sizes.
    """

    radius_m: Array
    share: Array
    number_per_m3: float

    @property
    def edges_m(self) -> Array:
        """Ends of the cells that the radii stand for (n + 1,): half-way in the logarithm."""
        log = np.log(self.radius_m)
        if len(log) == 1:
            return floats(np.exp(np.array([log[0] - 1e-9, log[0] + 1e-9])))
        inner = 0.5 * (log[1:] + log[:-1])
        ends = 2.0 * log[0] - inner[0], 2.0 * log[-1] - inner[-1]
        return floats(np.exp(np.concatenate([ends[:1], inner, ends[1:]])))

    @property
    def effective_radius_m(self) -> float:
        """Mean radius weighted by area: the third moment over the second."""
        return float(self.share @ self.radius_m**3 / (self.share @ self.radius_m**2))

    @property
    def range_um(self) -> tuple[float, float]:
        """Least and greatest radius, µm."""
        return float(self.radius_m[0] * 1e6), float(self.radius_m[-1] * 1e6)

    def within(self, largest_um: float, area_share: float) -> Sizes:
        """Give the distribution cut off at a largest radius, if hardly any area is beyond.

        Args:
            largest_um: the radius, which larger drops take.
            area_share: greatest share of the drops' area that may be beyond; the cut keeps that
                area. With more beyond, nothing changes.
        """
        area = self.share * self.radius_m**2
        beyond = self.radius_m > largest_um * 1e-6
        if not beyond.any() or area[beyond].sum() > area_share * area.sum():
            return self
        radius = np.append(self.radius_m[~beyond], largest_um * 1e-6)
        share = np.append(self.share[~beyond], area[beyond].sum() / radius[-1] ** 2)
        return Sizes(radius, share, self.number_per_m3)


_TAIL = 0.01
"""Share of a mixture's area that may be beyond the whole table's radii, and counts at its end."""


def tabled_sizes(sizes: Sizes) -> Sizes:
    """Give a mixture whose thin tail of large drops, if it has one, ends with the whole table.

    Without that a tail of a millionth of the drops would ask for a table of its own. Angles of the
    bows hardly depend on such sizes, and their area is kept.
    """
    return sizes.within(TABLE_RADII_UM[1], _TAIL)
