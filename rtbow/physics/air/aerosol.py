"""Aerosol: mixtures of absorbing spheres, and a free one, over wavelength and scattering angle.

The mixtures are those of OPAC (Hess, Koepke and Schult, Bull. Am. Meteorol. Soc. 79, 831, 1998) at
a relative humidity of 70 %: components of log-normal sizes, summed by Lorenz-Mie theory. Indices
are those at 550 nm, which over the visible change by a few per cent. What OPAC has at 80 % against
this, at 550 nm: single-scattering albedo 0.97, 0.93, 0.89, 1.0 (here 0.966, 0.911, 0.873, 0.997);
Angstrom exponent 1.42 of the continental ones and 0.08 of the maritime one (1.32 to 1.35, 0.10).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import cached_arrays, source_digest
from rtbow.base.limits import TOP_M

PHASE_ANGLES_RAD = np.pi * np.linspace(0.0, 1.0, 361) ** 2
"""Scattering angles of phase functions: dense in the aureole."""
_RADII = 160
"""Of each component, even in the logarithm."""
_WIDTHS = 4.5
"""Standard deviations of ln(radius) about the radius of greatest cross-section that are summed."""
_LARGEST_UM = 60.0
_MIDDLE_NM = 550.0


@dataclass(frozen=True)
class Component:
    """Spheres of log-normal sizes.

    Attributes:
        mode_um: mode radius of the number distribution, µm.
        sigma: geometric standard deviation.
        index: refractive index, with a positive imaginary part where they absorb.
    """

    mode_um: float
    sigma: float
    index: complex


_SOLUBLE = Component(0.0285, 2.24, 1.414 + 0.00247j)
_INSOLUBLE = Component(0.471, 2.51, 1.53 + 0.008j)
_SOOT = Component(0.0118, 2.00, 1.75 + 0.44j)
# Sea salt grows by 1.81 from dry (0.209 and 1.75 µm, 1.50) at 70 %: five parts of six are water.
_SALT_FINE = Component(0.378, 2.03, 1.36 + 1e-8j)
_SALT_COARSE = Component(3.17, 2.03, 1.36 + 1e-8j)


@dataclass(frozen=True)
class Mixture:
    """A mixture of components.

    Attributes:
        parts: components and their numbers, of any common unit.
        depth: vertical optical depth at 550 nm.
        scale_height_m: of its density, m.
        top_m: height at which it ends, m; infinite where it does not.
    """

    parts: tuple[tuple[Component, float], ...]
    depth: float
    scale_height_m: float = 8_000.0
    top_m: float = 2_000.0


MIXTURES = {
    "continental-clean": Mixture(((_SOLUBLE, 2600.0), (_INSOLUBLE, 0.15)), 0.064),
    "continental-average": Mixture(((_SOLUBLE, 7000.0), (_INSOLUBLE, 0.4), (_SOOT, 8300.0)), 0.151),
    "continental-polluted": Mixture(
        ((_SOLUBLE, 15700.0), (_INSOLUBLE, 0.6), (_SOOT, 34300.0)), 0.327
    ),
    "maritime-clean": Mixture(
        ((_SOLUBLE, 1500.0), (_SALT_FINE, 20.0), (_SALT_COARSE, 3.2e-3)), 0.096
    ),
}


def layer_density(height_m: Array, scale_height_m: float, top_m: float) -> Array:
    """Give the share of an exponential layer's column that a metre of height holds, 1/m.

    Args:
        height_m: heights, m.
        scale_height_m: of the layer.
        top_m: height at which it ends; infinite where it does not.
    """
    whole = scale_height_m * -np.expm1(-min(top_m, TOP_M) / scale_height_m)
    return np.where(height_m <= top_m, np.exp(-height_m / scale_height_m) / whole, 0.0)


@dataclass(frozen=True)
class AerosolOptics:
    """What an aerosol does at wavelengths.

    Attributes:
        depth: vertical optical depth (W,).
        scattering: share of it that is scattering (W,).
        phase: phase function at ``PHASE_ANGLES_RAD`` (angles, W), 1/sr, 1 over the sphere.
    """

    depth: Array
    scattering: Array
    phase: Array


def mixture_optics(mixture: Mixture, wavelength_nm: Array, depth_550: float) -> AerosolOptics:
    """Sum a mixture by Lorenz-Mie theory, or take it from the cache.

    Args:
        mixture: what it is of.
        wavelength_nm: wavelengths (W,).
        depth_550: its vertical optical depth at 550 nm.
    """
    nm = np.append(floats(wavelength_nm), _MIDDLE_NM)

    def build() -> dict[str, Array]:
        # Imported here, with the compiler of the sums.
        from rtbow.physics.air.aerosol_compiled import summed_spheres

        extinction, scattering = np.zeros(len(nm)), np.zeros(len(nm))
        phase = np.zeros((len(nm), len(PHASE_ANGLES_RAD)))
        for part, number in mixture.parts:
            radius, weight = _sizes(part)
            each = summed_spheres(radius, weight, part.index, nm * 1e-3, PHASE_ANGLES_RAD)
            extinction += number * each[0]
            scattering += number * each[1]
            phase += number * each[2]
        return {"extinction": extinction, "scattering": scattering, "phase": phase}

    key = f"{source_digest('physics')} {mixture} {nm.tobytes()!r}"
    kept = cached_arrays("aerosol", key, build)
    extinction, scattering = floats(kept["extinction"]), floats(kept["scattering"])
    shape = extinction[:-1] / extinction[-1]
    phase = floats(kept["phase"])[:-1].T
    return AerosolOptics(
        depth_550 * shape, scattering[:-1] / extinction[:-1], phase / moments_of(phase, 0)
    )


def free_optics(
    wavelength_nm: Array, depth_550: float, angstrom: float, scattering: float, asymmetry: float
) -> AerosolOptics:
    """Give an aerosol by a few numbers.

    Its phase function is that of Cornette and Shanks (Applied Optics 31, 3152, 1992), which lacks
    the rise towards backscattering that spheres have.

    Args:
        wavelength_nm: wavelengths (W,).
        depth_550: vertical optical depth at 550 nm.
        angstrom: exponent of the depth's fall with the wavelength.
        scattering: share of the depth that is scattering.
        asymmetry: the phase function's parameter g.
    """
    nm, g, mu = floats(wavelength_nm), asymmetry, np.cos(PHASE_ANGLES_RAD)
    phase = 3.0 / (8.0 * np.pi) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + mu * mu)
    phase /= (1.0 + g * g - 2.0 * g * mu) ** 1.5
    phase = np.repeat(phase[:, None], len(nm), axis=1)
    depth = depth_550 * (nm / _MIDDLE_NM) ** -angstrom
    return AerosolOptics(depth, np.full(len(nm), scattering), phase / moments_of(phase, 0))


def _sizes(part: Component) -> tuple[Array, Array]:
    """Radii, µm, and shares of number that each stands for."""
    width, mode = np.log(part.sigma), np.log(part.mode_um)
    middle = mode + 2.0 * width**2  # of the area
    log = np.linspace(middle - _WIDTHS * width, middle + _WIDTHS * width, _RADII)
    log = log[log < np.log(_LARGEST_UM)]
    weight = np.exp(-0.5 * ((log - mode) / width) ** 2) / (np.sqrt(2.0 * np.pi) * width)
    return np.exp(log), weight * (log[1] - log[0])


def moments_of(phase: Array, degree: int) -> Array:
    """Give the Legendre moments up to a degree (degree + 1, W) of phase functions (angles, W): 2 pi
    times the integral with P_l over the cosine. Pieces between angles are taken as straight."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    low, high = PHASE_ANGLES_RAD[:-1, None], PHASE_ANGLES_RAD[1:, None]
    theta = 0.5 * (high + low) + 0.5 * (high - low) * nodes  # (pieces, nodes)
    share = 0.5 * (1.0 + nodes)
    legendre = np.polynomial.legendre.legvander(np.cos(theta), degree)
    solid = 2.0 * np.pi * np.sin(theta) * weights * 0.5 * (high - low)
    upper = np.einsum("pn,pnl,n->pl", solid, legendre, share)
    lower = np.einsum("pn,pnl,n->pl", solid, legendre, 1.0 - share)
    return floats(lower.T @ phase[:-1] + upper.T @ phase[1:])
