"""What drops scatter over the whole sphere: its total, and phase functions for other programs.

A drop of 500 µm throws half of its light into a hundredth of a degree. Samples of it at even angles
miss that, and a renderer that normalises them makes all else too bright. Here every value is a mean
over the angles that it stands for, so that the total is kept however coarse the steps are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.physics.drop.airy import bows, unit_angle
from rtbow.physics.drop.medium import Medium
from rtbow.physics.drop.water import relative_index
from rtbow.tables.mie.efficiency import extinction_efficiencies
from rtbow.tables.sections import Sections, Theory

_EVEN = 2001
_FORWARD_RATIO = 1.01
"""Angles near the poles are in this ratio: rings up to the thirtieth are followed."""
_FORWARD_END = 0.5
_FRINGE_STEP = 0.15
"""Step about the bows in units of Airy's argument: twelve for the narrowest fringe that counts."""
_FRINGE_SPAN = (-6.0, 20.0)
_LEAST_DISC = math.radians(0.06)
"""Integrals are taken under at least this disc's radius. A disc moves light by no more than its own
width and keeps the total; fringes far inside the bows of large drops, finer than the even angles,
would alias without (3 % of the total at 1500 µm)."""


def following_angles(
    theory: Theory, radius_m: Array, wavelength_m: Array, index: Array, orders: tuple[int, ...]
) -> Array:
    """Give scattering angles (T,) from 0 to pi that lie close where light changes quickly.

    Args:
        theory: ``airy`` has the bows alone; ``mie`` the forward peak and the glory, too.
        radius_m: drop radii (R,).
        wavelength_m: wavelengths (W,).
        index: relative index (W,).
        orders: internal reflections whose bows are followed.
    """
    parts = [np.linspace(0.0, math.pi, _EVEN)]
    widest = 2.0 * math.pi * float(radius_m.max()) / float(wavelength_m.min())
    for bow in bows(orders, wavelength_m, index):
        unit = float(unit_angle(widest))
        low, high = (unit * z for z in _FRINGE_SPAN)
        ends = np.sort([bow.side * low, bow.side * high])
        first, last = bow.angle_rad.min() + ends[0], bow.angle_rad.max() + ends[1]
        count = min(2 + int((last - first) / (_FRINGE_STEP * unit)), 20_000)
        parts.append(np.linspace(first, last, count))
    if theory == "mie":
        least = 0.02 / widest
        count = 1 + int(math.log(_FORWARD_END / least) / math.log(_FORWARD_RATIO))
        away = np.geomspace(least, _FORWARD_END, count)
        parts += [away, math.pi - away]
    angles = np.unique(np.concatenate(parts))
    return floats(angles[(angles >= 0.0) & (angles <= math.pi)])


def over_sphere(theta_rad: Array, value: Array) -> Array:
    """Integrate a function of the scattering angle over the sphere, by straight lines.

    Args:
        theta_rad: angles (T,), 0 to pi.
        value: per steradian (..., T).

    Returns:
        The running integral from the forward direction (..., T); its last value is the total.
    """
    return _running(theta_rad, 2.0 * math.pi * value * np.sin(theta_rad))


def _running(at: Array, value: Array) -> Array:
    pieces = 0.5 * (value[..., 1:] + value[..., :-1]) * np.diff(at)
    start = np.zeros((*value.shape[:-1], 1))
    return floats(np.concatenate([start, np.cumsum(pieces, axis=-1)], axis=-1))


@dataclass(frozen=True)
class Scatterers:
    """Drops of water whose scattering is to be passed on.

    Attributes:
        theory: of the single drop.
        sections: their cross-sections.
        wavelength_nm: at which these are (W,), 380 to 780.
        temperature_c: of the water.
        orders: whose bows show.
        disc_rad: angular radius of the light's disc.
    """

    theory: Theory
    sections: Sections
    wavelength_nm: Array
    temperature_c: float
    orders: tuple[int, ...]
    disc_rad: float

    def extinction(self, radius_m: Array) -> Array:
        """Give the extinction cross-section (R, W), m²."""
        q = extinction_efficiencies(radius_m, self.wavelength_nm, Medium(self.temperature_c))
        return floats(q * math.pi * radius_m[:, None] ** 2)

    def scattering(self, radius_m: Array) -> Array:
        """Give the cross-section of all light that the theory scatters (R, W), m².

        Water hardly absorbs what is visible, so that by exact theory it is the extinction; Airy's
        has the bows alone, whose light is integrated over the sphere.
        """
        if self.theory == "mie":
            return self.extinction(radius_m)
        return floats(np.stack([self._profile(r)[2][:, -1] for r in radius_m]))

    def _profile(self, radius_m: float, also: Array | None = None) -> tuple[Array, Array, Array]:
        """Angles (T,), cross-sections of unpolarised light (W, T) and their integrals (W, T)."""
        disc_rad = max(self.disc_rad, _LEAST_DISC)
        wavelength_m = self.wavelength_nm * 1e-9
        index = relative_index(self.wavelength_nm, self.temperature_c)
        radius = np.array([radius_m])
        theta = following_angles(self.theory, radius, wavelength_m, index, self.orders)
        if also is not None:
            theta = np.unique(np.concatenate([theta, also]))
        both = self.sections.sections(radius, theta, disc_rad)[0]
        value = both.mean(axis=-1)
        return theta, value, over_sphere(theta, value)

    def phase_nodes(self, radius_m: float, count: int) -> Array:
        """Give the phase function at even steps of the cosine, for straight lines between them.

        Args:
            radius_m: of the drops.
            count: of nodes N, from the backward direction (cosine -1) to the forward one (1).

        Returns:
            (N, W), sr⁻¹: each the mean about its node, weighted with its straight lines, so that
            their integral over the sphere is 1.
        """
        node = np.linspace(-1.0, 1.0, count)
        at = np.arccos(node)  # falls from pi to 0
        theta, value, running = self._profile(radius_m, at)
        # A hat over its two steps: from the integrals of the light and of the light times cosine.
        cosine = np.cos(theta)
        moment = over_sphere(theta, value * cosine)
        places = np.searchsorted(theta, at)
        step = 2.0 / (count - 1)
        power, first = -np.diff(running[:, places]), -np.diff(moment[:, places])
        rising = (first - node[:-1] * power) / step  # towards the upper node of each step
        weights = np.zeros((len(value), count))
        weights[:, 1:] += rising
        weights[:, :-1] += power - rising
        weights = np.maximum(weights, 0.0)  # dark angles are differences of like numbers
        solid = np.full(count, 2.0 * math.pi * step)
        solid[[0, -1]] *= 0.5
        return floats((weights / (running[:, -1:] * solid)).T)

    def cell_means(self, radius_m: Array, cells: int, progress: Progress = no_progress) -> Array:
        """Give cross-sections as means over even cells of the angle.

        Args:
            radius_m: drop radii (R,).
            cells: N, from the forward direction to the backward one.
            progress: wraps the loop over radii.

        Returns:
            (R, W, N), m² sr⁻¹: times the cells' solid angles they sum to the total.
        """
        edges = np.linspace(0.0, math.pi, cells + 1)
        solid = 2.0 * math.pi * -np.diff(np.cos(edges))
        means = np.empty((len(radius_m), len(self.wavelength_nm), cells))
        for r in progress(range(len(radius_m))):
            theta, _, running = self._profile(float(radius_m[r]), edges)
            means[r] = np.diff(running[:, np.searchsorted(theta, edges)]) / solid
        return means
