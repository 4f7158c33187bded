"""Lorenz-Mie cross-sections of one radius, summed at its own wavelengths: no table in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import cached_arrays, source_digest
from rtbow.physics.drop.medium import Medium
from rtbow.physics.sizes import Sizes
from rtbow.tables.mie.average import node_intensities
from rtbow.tables.mie.axes import MieAxes
from rtbow.tables.mie.lookup import disc_grid, index_range_of, resample, standard_axes


@dataclass(frozen=True)
class DirectMieSections:
    """Cross-sections of drops of one radius (see :class:`rtbow.tables.sections.Sections`).

    The same mean over a narrow spread of sizes as in the table, but at this very radius and these
    very indices; only along the angle is there interpolation, of nodes denser than the table's.

    Attributes:
        axes: where the angles lie.
        radius_m: the radius.
        index: relative index (W,).
        values: |S|²/x² (W, T, 2).
    """

    axes: MieAxes
    radius_m: float
    index: Array
    values: Array

    @classmethod
    def of(
        cls, radius_m: float, wavelength_nm: Array, medium: Medium, spread: float
    ) -> DirectMieSections:
        """Sum the series: seconds to minutes, kept in the cache.

        Args:
            radius_m: drop radius.
            wavelength_nm: wavelengths in air (W,).
            medium: what the drop is made of.
            spread: standard deviation of ln(radius).
        """
        nm = floats(wavelength_nm)
        index = medium.index(nm)
        axes = standard_axes(spread, index_range_of(index))

        def build() -> dict[str, Array]:
            x = 2.0 * np.pi * radius_m / (nm * 1e-9)
            each = [
                node_intensities(axes, np.array([np.log(size)]), float(m))[0].T
                for size, m in zip(x, index, strict=True)
            ]
            return {"values": np.stack(each)}

        code = source_digest("physics.drop", "tables.mie")
        key = f"{code} {axes} {radius_m!r} {nm.tobytes()!r} {index.tobytes()!r}"
        values = floats(cached_arrays("mie-direct", key, build)["values"])
        return cls(axes, radius_m, index, values)

    def sections(
        self, radius_m: Array, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give both components, averaged over the disc, (1, W, U, 2), at the one radius."""
        nodes, weights = disc_grid(floats(theta_rad), disc_rad)
        out = np.empty((1, len(self.index), len(theta_rad), 2))
        for w, m in enumerate(self.index):
            places = self.axes.angle_places(nodes, float(m))
            out[0, w] = self.radius_m**2 * resample(self.values[w], places, weights)
        return out

    def mixed(
        self, sizes: Sizes, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give both components at the one radius, (W, U, 2): there is no other size to mix."""
        return floats(self.sections(sizes.radius_m, theta_rad, disc_rad)[0])
