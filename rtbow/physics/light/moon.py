"""Moonlight: how much of the sun's light the Moon sends to the Earth, by phase and wavelength.

The disk-equivalent reflectance of the Moon is the ROLO model's (Kieffer and Stone, Astron. J. 129,
2887 (2005), eq. 10 and table 4), without libration and as the mean of the waxing and the waning
Moon, which differ from it by up to 6 % at the quarters. Its bands scatter by some per cent about
the smooth colour of the Moon's soil; a parabola in the wavelength is fitted through their
logarithms.
The model holds for phase angles of 1.55 to 97 degrees, nearer ones being eclipses, and is within
about 5 to 10 % of measured irradiance; from 10 to 120 degrees it is within 5 % of
Krisciunas and Schaefer's illuminance (Publ. Astron. Soc. Pac. 103, 1033 (1991)).
"""

from __future__ import annotations

import math

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.constants import MOON_RADIUS_KM
from rtbow.physics.light.spectrum import Spectrum

_LEAST_PHASE_DEG = 1.55
"""Nearer to full the Earth's shadow lies on the Moon."""

# Wavelength in nm; polynomial in the phase angle in rad (a0 to a3); weights of the two exponentials
# and of the cosine in the phase angle in degrees (d1 to d3).
_BANDS: Array = np.array(
    [
        (350.0, -2.67511, -1.78539, 0.50612, -0.25578, 0.34185, 0.01441, -0.01602),
        (355.1, -2.71924, -1.74298, 0.44523, -0.23315, 0.33875, 0.01612, -0.00996),
        (405.0, -2.35754, -1.72134, 0.40337, -0.21105, 0.35235, -0.03818, -0.00006),
        (412.3, -2.34185, -1.74337, 0.42156, -0.21512, 0.36591, -0.05902, 0.00080),
        (414.4, -2.43367, -1.72184, 0.43600, -0.22675, 0.35558, -0.03247, -0.00503),
        (441.6, -2.31964, -1.72114, 0.37286, -0.19304, 0.37935, -0.09562, 0.00970),
        (465.8, -2.35085, -1.66538, 0.41802, -0.22541, 0.33450, -0.02546, -0.00484),
        (475.0, -2.28999, -1.63180, 0.36193, -0.20381, 0.33024, -0.03131, 0.00222),
        (486.9, -2.23351, -1.68573, 0.37632, -0.19877, 0.36590, -0.08945, 0.00678),
        (544.0, -2.13864, -1.60613, 0.27886, -0.16426, 0.37190, -0.10629, 0.01428),
        (549.1, -2.10782, -1.66736, 0.41697, -0.22026, 0.36814, -0.09815, 0.00000),
        (553.8, -2.12504, -1.65970, 0.38409, -0.20655, 0.37206, -0.10745, 0.00347),
        (665.1, -1.88914, -1.58096, 0.30477, -0.17908, 0.37141, -0.13514, 0.01248),
        (693.1, -1.89410, -1.58509, 0.28080, -0.16427, 0.39109, -0.17048, 0.01754),
        (703.6, -1.92103, -1.60151, 0.36924, -0.20567, 0.37155, -0.13989, 0.00412),
        (745.3, -1.86896, -1.57522, 0.33712, -0.19415, 0.36888, -0.14828, 0.00958),
        (763.7, -1.85258, -1.47181, 0.14377, -0.11589, 0.39126, -0.16957, 0.03053),
        (774.8, -1.80271, -1.59357, 0.36351, -0.20326, 0.36908, -0.16182, 0.00830),
        (865.3, -1.74561, -1.58482, 0.35009, -0.19569, 0.39200, -0.18837, 0.00978),
    ]
)
_DECAY_DEG = (4.06054, 12.8802)
_COSINE_DEG = (-30.5858, 16.7498)


def reflectance(wavelength_nm: Array, phase_deg: float) -> Array:
    """Give the Moon's disk-equivalent reflectance.

    Args:
        wavelength_nm: (n,), 350 to 865.
        phase_deg: angle at the Moon between sun and eye: 0 is full, 90 half, 120 a crescent of a
            quarter.

    Returns:
        (n,): 1 for a flat white disk that faces both.
    """
    g = max(abs(phase_deg), _LEAST_PHASE_DEG)
    nm, radians = _BANDS[:, 0], math.radians(g)
    logarithm = sum(_BANDS[:, 1 + k] * radians**k for k in range(4))
    for k, decay in enumerate(_DECAY_DEG):
        logarithm = logarithm + _BANDS[:, 5 + k] * math.exp(-g / decay)
    logarithm = logarithm + _BANDS[:, 7] * math.cos((g - _COSINE_DEG[0]) / _COSINE_DEG[1])
    smooth = np.polynomial.Polynomial.fit(nm, logarithm, 2)
    return floats(np.exp(smooth(floats(wavelength_nm))))


def moonlight(sunlight: Spectrum, phase_deg: float, distance_km: float) -> Spectrum:
    """Give the irradiance of the Moon above the air.

    Args:
        sunlight: irradiance of the sun at its mean distance, W m⁻² nm⁻¹.
        phase_deg: see :func:`reflectance`.
        distance_km: from the eye.
    """
    within = (sunlight.wavelength_nm >= _BANDS[0, 0]) & (sunlight.wavelength_nm <= _BANDS[-1, 0])
    nm = sunlight.wavelength_nm[within]
    solid_angle = math.pi * (MOON_RADIUS_KM / distance_km) ** 2
    share = reflectance(nm, phase_deg) * solid_angle / math.pi
    return Spectrum("moon", nm, sunlight.value[within] * share, absolute=True)


def diameter_deg(distance_km: float) -> float:
    """Give the Moon's angular diameter."""
    return math.degrees(2.0 * math.asin(MOON_RADIUS_KM / distance_km))
