"""How fast drops of water fall through still air, and the rain that they make."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats

# Air at 20 °C and 1013.25 hPa, as Gunn and Kinzer's, and water in it.
_AIR_KG_M3 = 1.204
_VISCOSITY_PA_S = 1.818e-5
_FREE_PATH_M = 6.62e-8
_WATER_KG_M3 = 998.2
_TENSION_N_M = 0.0728
_GRAVITY_M_S2 = 9.80665

_STOKES_UM, _LARGE_UM, _LARGEST_UM = 9.5, 535.0, 3500.0
"""Radii between which Beard's three regimes hold."""
# Beard's polynomials of ln(Reynolds' number), table 1, constant first.
_SMALL = (-3.18657, 0.992696, -1.53193e-3, -9.87059e-4, -5.78878e-4, 8.55176e-5, -3.27815e-6)
_LARGE = (-5.00015, 5.23778, -2.04914, 0.475294, -0.0542819, 2.38449e-3)


def fall_speed(radius_m: Array) -> Array:
    """Give the terminal speed of drops of water in still air at 20 °C and 1013 hPa, m/s.

    Within 2.2 % of the speeds that Gunn and Kinzer measured (J. Meteor. 6, 243 (1949)) from 0.3 to
    5.8 mm across, and 4 to 8 % slower at 0.2 and 0.1 mm, where later measurements (Beard and
    Pruppacher, J. Atmos. Sci. 26, 1066 (1969)) are, too. Drops beyond 7 mm, which break up, fall as
    those do.

    Args:
        radius_m: radii of spheres of the same volume, any shape.

    Source: Beard, J. Atmos. Sci. 33, 851 (1976), equations 5 to 7 and table 1.
    """
    radius = np.minimum(floats(radius_m), _LARGEST_UM * 1e-6)
    excess = (_WATER_KG_M3 - _AIR_KG_M3) * _GRAVITY_M_S2
    # Cunningham's correction: to the smallest drops the air is no continuum.
    slip = 1.0 + 1.26 * _FREE_PATH_M / radius
    stokes = 2.0 / 9.0 * excess * radius**2 / _VISCOSITY_PA_S * slip
    per_reynolds = _VISCOSITY_PA_S / (2.0 * radius * _AIR_KG_M3)
    davies = 32.0 / 3.0 * radius**3 * _AIR_KG_M3 * excess / _VISCOSITY_PA_S**2
    middle = np.exp(_polynomial(_SMALL, np.log(davies))) * slip
    # Large drops are flattened: the number of Bond and a property of water in air decide.
    bond = 16.0 / 3.0 * radius**2 * excess / _TENSION_N_M
    matter = (_TENSION_N_M**3 * _AIR_KG_M3**2 / (_VISCOSITY_PA_S**4 * excess)) ** (1.0 / 6.0)
    large = matter * np.exp(_polynomial(_LARGE, np.log(bond * matter)))
    rising = np.where(radius < _LARGE_UM * 1e-6, middle, large) * per_reynolds
    return floats(np.where(radius < _STOKES_UM * 1e-6, stokes, rising))


def _polynomial(coefficients: tuple[float, ...], at: Array) -> Array:
    return floats(np.polynomial.polynomial.polyval(at, coefficients))


def rain_rate_mm_h(radius_m: Array, number_per_m3: Array) -> float:
    """Give the rain rate of drops of water in still air, mm/h.

    Args:
        radius_m: radii (n,).
        number_per_m3: drops of each radius (n,).
    """
    flux_m_s = number_per_m3 * 4.0 / 3.0 * np.pi * floats(radius_m) ** 3 * fall_speed(radius_m)
    return float(3.6e6 * np.sum(flux_m_s))
