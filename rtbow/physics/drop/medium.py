"""What drops are made of: fresh water, sea water, or anything of one index of refraction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.constants import YELLOW_NM
from rtbow.physics.drop.airy import PRIMARY_UNIT, bow, bow_unit
from rtbow.physics.drop.water import relative_index, salt_index


@dataclass(frozen=True)
class Medium:
    """What drops are made of.

    Attributes:
        temperature_c: of the water.
        salinity_g_kg: of sea water; 0 is fresh.
        refractive_index: relative to air at every wavelength, instead of water's.
    """

    temperature_c: float = 20.0
    salinity_g_kg: float = 0.0
    refractive_index: float | None = None

    @property
    def fresh(self) -> bool:
        """Whether it is water without salt."""
        return self.refractive_index is None and self.salinity_g_kg == 0.0

    def index(self, wavelength_nm: Array) -> Array:
        """Give the refractive index relative to air at wavelengths in air, same shape."""
        if self.refractive_index is not None:
            return np.full(np.shape(wavelength_nm), self.refractive_index)
        index = relative_index(wavelength_nm, self.temperature_c)
        if self.fresh:
            return index
        return floats(index + salt_index(wavelength_nm, self.temperature_c, self.salinity_g_kg))

    @property
    def bow_unit(self) -> float:
        """One unit of Airy's argument at the primary bow, rad x^(-2/3); all water's is alike."""
        if self.refractive_index is None:
            return PRIMARY_UNIT
        return bow_unit(self.refractive_index)

    def descartes_deg(self, reflections: int, wavelength_nm: float) -> float:
        """Give the scattering angle of the ray of least deviation, degrees, 180 backwards.

        A bow's light is brightest some tenths of a degree on its bright side, the more so the
        smaller the drops: this is the limit of large ones and of a light without a disc.

        Args:
            reflections: internal reflections, 1 primary, 2 secondary.
            wavelength_nm: in air.
        """
        return _descartes_deg(self, reflections, wavelength_nm)

    def bow_radius_deg(self, reflections: int, wavelength_nm: float = YELLOW_NM) -> float:
        """Give the radius of Descartes' bow about the antisolar point, degrees.

        Args:
            reflections: internal reflections: 1 primary, 2 secondary.
            wavelength_nm: in air.
        """
        return 180.0 - self.descartes_deg(reflections, wavelength_nm)

    def __str__(self) -> str:
        if self.refractive_index is not None:
            return f"drops of refractive index {self.refractive_index:g}"
        if self.fresh:
            return f"water at {self.temperature_c:g} °C"
        return f"sea water of {self.salinity_g_kg:g} g/kg at {self.temperature_c:g} °C"


@lru_cache(maxsize=64)  # a window asks for each of its pictures
def _descartes_deg(medium: Medium, reflections: int, wavelength_nm: float) -> float:
    nm = floats([wavelength_nm])
    return float(np.degrees(bow(reflections, nm * 1e-9, medium.index(nm)).angle_rad[0]))
