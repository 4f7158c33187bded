"""Refractive index of liquid water, fresh and salt, relative to air."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array
from rtbow.physics.constants import AIR_REFRACTIVE_INDEX

_KELVIN = 273.15

# IAPWS R9-97, table 1: coefficients a0..a7 and the two resonances, in its reduced units.
_A = (
    0.244257733,
    9.74634476e-3,
    -3.73234996e-3,
    2.68678472e-4,
    1.58920570e-3,
    2.45934259e-3,
    0.900704920,
    -1.66626219e-2,
)
_UV, _IR = 0.2292020, 5.432937
_RHO_REF, _T_REF, _LAMBDA_REF_UM = 1000.0, 273.15, 0.589


def iapws_index(wavelength_um: Array, temperature_k: float, density_kg_m3: float) -> Array:
    """Give the refractive index of water in vacuum.

    Args:
        wavelength_um: vacuum wavelengths, µm, any shape; 0.2 to 1.1 by the release.
        temperature_k: temperature, K.
        density_kg_m3: density, kg/m³.

    Returns:
        The index, same shape as the wavelengths.

    Source: IAPWS R9-97, equation 1.
    """
    rho = density_kg_m3 / _RHO_REF
    t = temperature_k / _T_REF
    lam2 = (np.asarray(wavelength_um, dtype=np.float64) / _LAMBDA_REF_UM) ** 2
    a0, a1, a2, a3, a4, a5, a6, a7 = _A
    series = (
        a0
        + a1 * rho
        + a2 * t
        + a3 * lam2 * t
        + a4 / lam2
        + a5 / (lam2 - _UV**2)
        + a6 / (lam2 - _IR**2)
        + a7 * rho**2
    )
    lorentz = rho * series
    return np.sqrt((1.0 + 2.0 * lorentz) / (1.0 - lorentz))


def water_density(temperature_c: float) -> float:
    """Give the density of air-free water at 101325 Pa, kg/m³, from -30 to 100 °C.

    Source: Kell, J. Chem. Eng. Data 20, 97 (1975), equation 16; 998.2 at 20 °C.
    """
    t = temperature_c
    series = (
        999.83952
        + 16.945176 * t
        - 7.9870401e-3 * t**2
        - 46.170461e-6 * t**3
        + 105.56302e-9 * t**4
        - 280.54253e-12 * t**5
    )
    return series / (1.0 + 16.879850e-3 * t)


def relative_index(wavelength_nm: Array, temperature_c: float) -> Array:
    """Give the index of water relative to air, same shape as ``wavelength_nm``."""
    index = iapws_index(
        np.asarray(wavelength_nm, dtype=np.float64) * 1e-3,
        temperature_c + _KELVIN,
        water_density(temperature_c),
    )
    return index / AIR_REFRACTIVE_INDEX


# Quan and Fry's n1, n2, n3 and n6, the terms of their equation 3 with the salinity.
_SALT = (1.779e-4, -1.05e-6, 1.6e-8, 0.01155)


def salt_index(wavelength_nm: Array, temperature_c: float, salinity_g_kg: float) -> Array:
    """Give what salt adds to the index of water relative to air, same shape as ``wavelength_nm``.

    The formula is one of water in air over 400-700 nm, 0-30 °C and 0-35 g/kg, where it reproduces
    the measurements that Austin and Halikas (1976) collected within their errors; it is linear in
    the salinity. Of it the terms with the salinity are taken, so that water without salt has the
    index of the release.

    Source: Quan and Fry, Applied Optics 34, 3477 (1995), equation 3 and table 1.
    """
    n1, n2, n3, n6 = _SALT
    t = temperature_c
    per_salinity = n1 + n2 * t + n3 * t**2 + n6 / np.asarray(wavelength_nm, dtype=np.float64)
    return per_salinity * salinity_g_kg
