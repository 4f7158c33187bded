"""Compiled sums over the sizes of an aerosol's spheres."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.compiled import compiled, prange
from rtbow.physics.drop.mie import absorbed_and_scattered


@compiled(parallel=True)
def summed_spheres(
    radius_um: Array, weight: Array, index: complex, wavelength_um: Array, theta: Array
) -> tuple[Array, Array, Array]:
    """Mean cross-sections of extinction and scattering (W,), and differential ones (W, T)."""
    waves = len(wavelength_um)
    extinction, scattering = np.zeros(waves), np.zeros(waves)
    phase = np.zeros((waves, len(theta)))
    for w in prange(waves):
        k = 2.0 * np.pi / wavelength_um[w]
        for n in range(len(radius_um)):
            efficiencies, both = absorbed_and_scattered(k * radius_um[n], index, theta)
            area = np.pi * radius_um[n] ** 2 * weight[n]
            extinction[w] += area * efficiencies[0]
            scattering[w] += area * efficiencies[1]
            for t in range(len(theta)):
                phase[w, t] += 0.5 * weight[n] / (k * k) * (both[0, t] + both[1, t])
    return extinction, scattering, phase
