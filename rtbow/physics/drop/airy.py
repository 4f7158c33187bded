"""Airy's theory of the rainbow: everything about a bow that depends on wavelength.

A bow of ``k`` internal reflections is described per wavelength by five numbers (:class:`Bow`);
with them the differential scattering cross-section of a drop of radius ``a`` is

    C_j(theta) = strength_j · a^(7/3) · Ai²(-z),    z = scale · a^(2/3) · excess(theta)

so radius and angle enter through one variable only. This is the split of the paper's section
5.2.2 (wavelength-dependent and independent parts) taken to its end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Values
from rtbow.physics.constants import VISIBLE_NM

RADIUS_POWER = 7.0 / 3.0
"""C grows as a^(7/3): a² for the drop's area, a^(1/3) for the focusing at the caustic."""
SCALE_POWER = 2.0 / 3.0
"""z grows as a^(2/3)."""
PRIMARY_UNIT = 1.7
"""One unit of z at the primary bow of water, in rad x^(-2/3) (see :func:`unit_angle`). At 20 °C it
is 1.66 at 380 nm and 1.71 at 780 nm, in hot water up to 1.73; the secondary bow's is 3.0."""


@dataclass(frozen=True)
class Bow:
    """One bow, per wavelength; every array has the shape (W,) of the wavelengths.

    Attributes:
        reflections: internal reflections, 1 primary, 2 secondary.
        angle_rad: Descartes' scattering angle, rad, within 0..pi.
        side: +1 where the bright side lies at larger scattering angles (primary), -1 else.
        scale: z per rad of excess angle and per m^(2/3) of radius.
        perpendicular: strength of |S1|²/k², m² sr⁻¹ per m^(7/3).
        parallel: strength of |S2|²/k², m² sr⁻¹ per m^(7/3).
    """

    reflections: int
    angle_rad: Array
    side: float
    scale: Array
    perpendicular: Array
    parallel: Array

    @property
    def strength(self) -> Array:
        """Strength for unpolarised light, the mean of the two components, shape (W,)."""
        return 0.5 * (self.perpendicular + self.parallel)

    @property
    def pole_rad(self) -> float:
        """Scattering angle at the end of the bright side: pi for the primary, 0 for the secondary.

        There the sun's disc covers whole fringes about the axis, not strips across them.
        """
        return np.pi if self.side > 0 else 0.0


def descartes_ray(reflections: int, index: Array) -> tuple[Array, Array, Array]:
    """Give the ray of least deviation.

    Args:
        reflections: internal reflections k, at least 1.
        index: refractive index relative to air, any shape.

    Returns:
        ``i``, ``r`` (angles of incidence and refraction) and ``D0`` (total deviation), rad.
    """
    p = reflections + 1
    m = np.asarray(index, dtype=np.float64)
    i = np.arccos(np.sqrt((m**2 - 1.0) / (p**2 - 1.0)))
    r = np.arcsin(np.sin(i) / m)
    return i, r, 2.0 * i - 2.0 * p * r + (p - 1.0) * np.pi


def bow(reflections: int, wavelength_m: Array, index: Array) -> Bow:
    """Compute a bow's five numbers.

    Args:
        reflections: internal reflections, 1 or 2.
        wavelength_m: wavelengths in air, m, shape (W,).
        index: refractive index relative to air, shape (W,).

    Source: van de Hulst, *Light Scattering by Small Particles* (1957), section 13.2; Wang and
    van de Hulst, Applied Optics 30, 106 (1991).
    """
    p = reflections + 1
    m = np.asarray(index, dtype=np.float64)
    i, r, deviation = descartes_ray(reflections, m)
    b = np.sin(i)
    # d²D/db² at the stationary ray: the cubic wavefront's curvature.
    curvature = 2.0 * b / (1.0 - b**2) ** 1.5 - 2.0 * p * b / (m**2 - b**2) ** 1.5
    wavenumber = 2.0 * np.pi / np.asarray(wavelength_m, dtype=np.float64)

    # Fresnel amplitudes: two refractions (1 - r²) and k internal reflections.
    r_perp = np.sin(i - r) / np.sin(i + r)
    r_par = np.tan(i - r) / np.tan(i + r)
    eps2_perp = ((1.0 - r_perp**2) * r_perp**reflections) ** 2
    eps2_par = ((1.0 - r_par**2) * r_par**reflections) ** 2

    common = (
        2.0 * np.pi * b / np.abs(np.sin(deviation))
        * wavenumber ** (1.0 / 3.0)
        * (curvature / 2.0) ** (-2.0 / 3.0)
    )  # fmt: skip
    turned = np.mod(deviation, 2.0 * np.pi)
    side = 1.0 if reflections == 1 else -1.0
    return Bow(
        reflections=reflections,
        angle_rad=np.where(turned > np.pi, 2.0 * np.pi - turned, turned),
        side=side,
        scale=wavenumber**SCALE_POWER * (curvature / 2.0) ** (-1.0 / 3.0),
        perpendicular=common * eps2_perp,
        parallel=common * eps2_par,
    )


def bow_unit(index: float) -> float:
    """Give one unit of z at the primary bow of drops of an index, rad x^(-2/3).

    It falls from 2.3 at an index of 1.2 to 1.3 at 1.5 and 0.7 at 1.9.
    """
    wavelength_m = 1e-6  # any one will do
    scale = bow(1, np.array([wavelength_m]), np.array([index])).scale[0]
    return float((2.0 * np.pi / wavelength_m) ** SCALE_POWER / scale)


def unit_angle(size: Values, units: float = 1.0, unit: float = PRIMARY_UNIT) -> Values:
    """Give the angle over which z grows by some units at the primary bow.

    The bow's scale depends on drop and wavelength through the size parameter x alone: with the
    curvature h of its wavefront, 1 / (scale · a^(2/3)) = (h/2)^(1/3) x^(-2/3). That of water is
    taken as :data:`PRIMARY_UNIT`, within 3 % over 380-780 nm and -12 to 60 °C. This serves to
    choose steps and extents; cross-sections take the scale itself.

    Args:
        size: size parameter x = 2 pi a / wavelength, any shape.
        units: how many; the main maximum is at z = 1.02 and the first dark ring at z = 2.34.
        unit: of drops that are not of water (:func:`bow_unit`).

    Returns:
        The angle, rad, same shape as ``size``.
    """
    return units * unit / size**SCALE_POWER


_WIDTH_UNITS = 1.4 / PRIMARY_UNIT
"""Units of Airy's argument z that count as the width of a bow: 0.82, half of what the
main maximum has at half its height, from z = 0.09 to z = 1.72."""


def fringe_phase(z: float) -> float:
    """Give the phase of the fringes of Ai²(-z), rad: they repeat with 2 pi (from z = 1 on)."""
    return 4.0 / 3.0 * z * math.sqrt(z)


def bow_width(radius_m: float, unit: float) -> float:
    """Give the width of the main bow at the violet end, rad.

    Args:
        radius_m: of the drops.
        unit: of Airy's argument (:attr:`rtbow.physics.drop.medium.Medium.bow_unit`).
    """
    x = 2.0 * np.pi * radius_m / (VISIBLE_NM[0] * 1e-9)
    return float(unit_angle(x, _WIDTH_UNITS, unit))


def bows(orders: Sequence[int], wavelength_m: Array, index: Array) -> tuple[Bow, ...]:
    """Compute the bows of several orders (see :func:`bow`)."""
    return tuple(bow(k, wavelength_m, index) for k in orders)


def airy_squared(z: Array) -> Array:
    """Give Ai²(-z), any shape."""
    return airy_squared_and_integral(z)[0]


def airy_squared_and_integral(z: Array) -> tuple[Array, Array]:
    """Give Ai²(-z) and its integral from the shadow up to z, each of the shape of ``z``.

    The integral is z Ai²(-z) + Ai'²(-z) (Abramowitz and Stegun, 10.4.54 ff.: differentiate it and
    use Ai'' = t Ai).
    """
    # Imported here: scipy.special costs 0.2 s that a cached table saves.
    from scipy.special import airy

    at = np.asarray(z, dtype=np.float64)
    value, slope = (np.asarray(f, dtype=np.float64) for f in airy(-at)[:2])
    return value**2, at * value**2 + slope**2
