"""Numbers of nature and of the standards, each typed once (SI unless the name says otherwise)."""

VISIBLE_NM = (380.0, 780.0)
"""Wavelength range of every spectral integral, nm (CIE 15 abridged range)."""


YELLOW_NM = 589.3
"""The sodium lines, nm in air: where a bow's radius is stated, unless it is of another colour."""


LUMINOUS_EFFICACY_LM_PER_W = 683.0
"""K_m of the CIE photometric system, lm/W (683.002 for the 2019 cd; CIE 15 rounds)."""


AIR_REFRACTIVE_INDEX = 1.000277
"""Index of air near the ground, 15 °C, 101325 Pa, mid-visible."""


EARTH_RADIUS_M = 6_371_000.0


SEA_LEVEL_HPA = 1013.25
"""Pressure of the standard atmosphere at sea level."""


SCALE_HEIGHT_M = 7994.0
"""Scale height H0 of the exponential atmosphere (Fujiwara et al., section 5.2.1)."""


SUN_DIAMETER_DEG = 0.533
"""The sun's disc across, at its mean distance."""


# Exact, as the SI defines them (9th brochure, 2019).
SPEED_OF_LIGHT_M_PER_S = 299_792_458.0
PLANCK_J_S = 6.62607015e-34
ELEMENTARY_CHARGE_C = 1.602176634e-19
AVOGADRO_PER_MOL = 6.02214076e23
MOON_RADIUS_KM = 1_737.4
"""Mean radius (IAU 2015 working group on cartographic coordinates)."""
MOON_DISTANCE_KM = 384_400.0
"""Mean distance from the Earth's centre."""
MOON_DISTANCES_KM = (350_000.0, 410_000.0)
"""Range of it, and of the distance from places on the ground."""
MOON_PHASES_DEG = (0.0, 120.0)
"""Angles at the Moon between sun and eye for which its brightness is known."""
