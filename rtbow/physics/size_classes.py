"""Drops counted in classes of size, as disdrometers and cloud probes count them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rtbow.base.arrays import Array, floats

PARSIVEL_WIDTHS_MM = np.repeat([0.125, 0.25, 0.5, 1.0, 2.0, 3.0], [10, 5, 5, 5, 5, 2])
"""Widths of the 32 classes of diameter of an OTT Parsivel, which begin at 0: OTT Hydromet,
*Operating instructions: Present weather sensor OTT Parsivel²* (2016), appendix on classes."""
PARSIVEL_MIDDLES_MM = np.cumsum(PARSIVEL_WIDTHS_MM) - 0.5 * PARSIVEL_WIDTHS_MM
"""Middles of its classes, which OTT prints cut to three decimals: 0.062 for 0.0625."""

_LEAST_EXPONENT = 0.8
"""Two neighbouring classes of many drops ask for 0.87; of one class alone it would be 0."""


@dataclass(frozen=True)
class SizeClasses:
    """Drops in classes of radius.

    Instruments report sums over the middles of the classes. Drops all of a class's middle would
    scatter with the fringes of that one size, so each class is spread evenly over its width; the
    radii are then drawn together by one power a r^b, which keeps number, area and volume those
    sums. (Where nearly all drops are of one class, no spread keeps all three: number and area are.)

    Attributes:
        middle_um: radii in the middle of the classes (n,), ascending.
        width_um: widths in radius (n,).
        number_per_m3: drops in each class (n,).
    """

    middle_um: Array
    width_um: Array
    number_per_m3: Array

    def total(self, power: int) -> float:
        """Give the sum of radius^power over the drops of all classes, m⁻³ µm^power."""
        return float(self.number_per_m3 @ self.middle_um**power)

    @property
    def range_um(self) -> tuple[float, float]:
        """Least and greatest radius of any drop."""
        filled = self.number_per_m3 > 0.0
        low, high = self._ends
        return float(self._drawn(low[filled].min())), float(self._drawn(high[filled].max()))

    def cumulated(self, radius_um: Array, power: int) -> Array:
        """Give the sum of radius^power over drops up to some radii, same shape as ``radius_um``."""
        scale, exponent = self._together
        low, high = self._ends
        spread = power * exponent + 1.0
        total = np.zeros(np.shape(radius_um))
        at = (floats(radius_um) / scale) ** (1.0 / exponent)
        for start, end, number in zip(low, high, self.number_per_m3, strict=True):
            up_to = np.clip(at, start, end)
            total += number * (up_to**spread - start**spread) / (spread * (end - start))
        return floats(scale**power * total)

    def share_within(self, power: int, low_um: float, high_um: float) -> float:
        """Give the share of the sum of radius^power between two radii."""
        low, high = self.cumulated(np.array([low_um, high_um]), power)
        whole = float(self.cumulated(np.array([np.inf]), power)[0])
        return float(high - low) / whole

    @property
    def _ends(self) -> tuple[Array, Array]:
        half = np.minimum(0.5 * self.width_um, self.middle_um)
        return floats(self.middle_um - half), floats(self.middle_um + half)

    @cached_property
    def _together(self) -> tuple[float, float]:
        """The a and b with which a r^b keeps area and volume of the classes' middles."""
        from scipy.optimize import brentq

        low, high = self._ends

        def spread_sum(power: float) -> float:
            mean = (high ** (power + 1.0) - low ** (power + 1.0)) / ((power + 1.0) * (high - low))
            return float(self.number_per_m3 @ mean)

        def excess(exponent: float) -> float:
            ratio = spread_sum(3.0 * exponent) ** 2 / spread_sum(2.0 * exponent) ** 3
            return ratio * self.total(2) ** 3 / self.total(3) ** 2 - 1.0

        few = excess(_LEAST_EXPONENT) >= 0.0 or excess(1.0) <= 0.0
        exponent = 1.0 if few else float(brentq(excess, _LEAST_EXPONENT, 1.0))
        return (self.total(2) / spread_sum(2.0 * exponent)) ** 0.5, exponent

    def _drawn(self, radius_um: float) -> float:
        scale, exponent = self._together
        return float(scale * radius_um**exponent)
