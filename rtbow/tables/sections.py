"""Cross-sections of drops by either theory, behind one interface.

What lies downstream (exports, charts, the shader's section texture, the reference) asks for
differential cross-sections and does not know which theory gives them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.base.compiled import compiled, prange
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER, bows
from rtbow.physics.drop.airy_compiled import (
    AIRY_LOW,
    airy_grid,
    airy_squared_at,
    running_at,
    running_grid,
)
from rtbow.physics.drop.medium import Medium
from rtbow.physics.sizes import Sizes
from rtbow.tables.airy import AiryTable, airy_table
from rtbow.tables.mie.axes import DEFAULT_SPREAD
from rtbow.tables.mie.lookup import (
    MieSections,
    disc_grid,
    index_range_of,
    resample,
)
from rtbow.tables.mie.store import mie_table

Theory = Literal["airy", "mie"]


class Sections(Protocol):
    """Differential cross-sections of water drops at some wavelengths."""

    def sections(
        self, radius_m: Array, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give both components, averaged over the light's disc.

        Args:
            radius_m: drop radii (R,).
            theta_rad: scattering angles (U,).
            disc_rad: angular radius of the light's disc.
            elevation_rad: elevation of each scattering plane above the horizon (U,), for drops
                that are no spheres; spheres do not depend on it.

        Returns:
            |S1|²/k² (perpendicular) and |S2|²/k² (parallel) in m² sr⁻¹, (R, W, U, 2). Their mean
            is what unpolarised light meets.
        """
        ...

    def mixed(
        self, sizes: Sizes, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give the mean over drops of several sizes, (W, U, 2), from the arguments of
        :meth:`sections`."""
        ...


@dataclass(frozen=True)
class AirySections:
    """Cross-sections by Airy's theory: the bows of some orders, and nothing else.

    Attributes:
        table: disc means of Airy's function.
        orders: internal reflections, 1 and 2.
        wavelength_m: wavelengths in air (W,).
        index: relative index (W,).
    """

    table: AiryTable
    orders: tuple[int, ...]
    wavelength_m: Array
    index: Array

    def sections(
        self, radius_m: Array, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give both components, averaged over the light's disc (see :class:`Sections`)."""
        theta = floats(theta_rad)
        ones = np.ones(len(self.index))
        out = np.zeros((len(radius_m), len(self.index), len(theta), 2))
        for the_bow in bows(self.orders, self.wavelength_m, self.index):
            # Both components share the bow's shape and differ in its strength alone.
            shape = self.table.cross_section(the_bow, ones, radius_m, theta, disc_rad)
            for component, strength in enumerate((the_bow.perpendicular, the_bow.parallel)):
                out[..., component] += strength[None, :, None] * shape
        return out

    def mixed(
        self, sizes: Sizes, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give the mean over drops of several sizes, (W, U, 2).

        Airy's function depends on size, wavelength, bow and angle through z alone, and z is a
        product of what the size gives and of what the others do. So its mean over sizes is one
        function for all wavelengths and both bows, tabled first; the disc is averaged by
        quadrature.
        """
        nodes, weights = disc_grid(floats(theta_rad), disc_rad)
        out = np.zeros((len(self.index), len(theta_rad), 2))
        the_bows = bows(self.orders, self.wavelength_m, self.index)
        mixture = _AiryMixture.of(sizes, max(float(b.scale.max()) for b in the_bows))
        for b in the_bows:
            for w, scale in enumerate(b.scale):
                reach = scale * b.side * (nodes - b.angle_rad[w])
                shape = resample(mixture.values, mixture.place(reach), weights)
                out[w] += shape * floats([b.perpendicular[w], b.parallel[w]])
        return out


_MIXTURE_STEP = 0.03
"""Distance in z of the largest drop at which the mean over sizes is tabled, up to..."""
_MIXTURE_EVEN = 60.0
"""...this z, and in proportion to z beyond, where a mixture's fringes have averaged out."""


@dataclass(frozen=True)
class _AiryMixture:
    """Airy's function averaged over sizes.

    Attributes:
        largest: z of the largest drop over the reach that :meth:`place` takes.
        ends: z of the first and the last value, of the largest drop.
        values: sum of share · radius^(7/3) · Ai²(-z) (n, 1), even along the places.
    """

    largest: float
    ends: tuple[float, float]
    values: Array

    @classmethod
    def of(cls, sizes: Sizes, greatest_scale: float) -> _AiryMixture:
        """Sum over sizes, for bows up to a scale (:attr:`Bow.scale`)."""
        edges = sizes.edges_m**SCALE_POWER
        # On the dark side the smallest drops reach farthest.
        ends = AIRY_LOW * float(edges[-1] / edges[0]), greatest_scale * np.pi * float(edges[-1])
        first, last = (_mixture_place(floats(z)) for z in ends)
        count = int(np.ceil(last - first)) + 4
        z = _MIXTURE_EVEN * np.sinh((first + np.arange(count)) * _MIXTURE_STEP / _MIXTURE_EVEN)
        weight = sizes.share * sizes.radius_m**RADIUS_POWER
        summed = airy_mixture(1.0, z / edges[-1], edges, weight, running_grid(), airy_grid())
        return cls(float(edges[-1]), ends, summed[:, None])

    def place(self, reach: Array) -> Array:
        """Place along the values of what z is per radius^(2/3), any shape."""
        z = np.clip(self.largest * reach, *self.ends)
        return floats(_mixture_place(z) - _mixture_place(floats(self.ends[0])))


def _mixture_place(z: Array) -> Array:
    return floats(_MIXTURE_EVEN / _MIXTURE_STEP * np.arcsinh(z / _MIXTURE_EVEN))


@compiled(parallel=True)
def airy_mixture(
    scale: float, excess: Array, edge_scale: Array, weight: Array, running: Array, grid: Array
) -> Array:
    """Sum Ai² over sizes with weights (R,), each its mean over a cell of sizes, at angles (T,).

    A single size for each cell would alias: fringes far inside the bow turn by more than pi from
    one to the next.

    Args:
        scale: z per rad and per ``edge_scale``.
        excess: angles into the bright side (T,), rad.
        edge_scale: radius^(2/3) at the cells' ends (R + 1,).
        weight: (R,).
        running: integrals of Ai² (:func:`running_grid`).
        grid: Ai² (:func:`airy_grid`).
    """
    total = np.zeros(len(excess))
    for k in prange(len(excess)):
        low = scale * edge_scale[0] * excess[k]
        before = running_at(low, running)
        for r in range(len(weight)):
            high = scale * edge_scale[r + 1] * excess[k]
            after = running_at(high, running)
            # Integrals are good to 1e-7, which a narrow cell would magnify.
            if abs(high - low) > 0.02:
                total[k] += weight[r] * (after - before) / (high - low)
            else:
                total[k] += weight[r] * airy_squared_at(0.5 * (low + high), grid)
            low, before = high, after
    return total


def drop_sections(
    theory: Theory,
    wavelength_nm: Array,
    medium: Medium,
    radii_um: tuple[float, float],
    *,
    orders: tuple[int, ...] = (1, 2),
    spread: float = DEFAULT_SPREAD,
    progress: Progress = no_progress,
) -> Sections:
    """Give the cross-sections of drops in air.

    Args:
        theory: ``airy`` or ``mie``.
        wavelength_nm: wavelengths in air (W,).
        medium: what the drops are made of.
        radii_um: least and greatest radius that will be asked for.
        orders: internal reflections (airy; mie has all).
        spread: standard deviation of ln(radius) about each size (mie).
        progress: wraps the loop over parts of a table that must be built.

    Raises:
        InputError: wavelengths or a temperature beyond the table.
    """
    nm = floats(wavelength_nm)
    index = medium.index(nm)
    if theory == "airy":
        return AirySections(airy_table(), orders, nm * 1e-9, index)
    # Refused here: a table may have to be built, which takes a minute or more.
    range_ = index_range_of(index)
    return MieSections(mie_table(spread, radii_um, progress, range_), nm * 1e-9, index)


def water_sections(
    theory: Theory,
    wavelength_nm: Array,
    temperature_c: float,
    radii_um: tuple[float, float],
    *,
    orders: tuple[int, ...] = (1, 2),
    spread: float = DEFAULT_SPREAD,
    progress: Progress = no_progress,
) -> Sections:
    """Give the cross-sections of drops of fresh water in air (see :func:`drop_sections`)."""
    return drop_sections(
        theory, wavelength_nm, Medium(temperature_c), radii_um,
        orders=orders, spread=spread, progress=progress,
    )  # fmt: skip
