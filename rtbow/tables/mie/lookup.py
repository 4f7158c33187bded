"""The Lorenz-Mie table: mean intensities over size, index and angle, and its look-up.

Nodes are log-normal means over a narrow spread of sizes (:mod:`rtbow.tables.mie.average`), which
leaves nothing along ln x that cubic splines with one node per spread do not follow; the light's
disc is averaged on the sphere when a scene's own angles are looked up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.base.compiled import compiled, prange
from rtbow.base.errors import InputError
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.drop.airy import PRIMARY_UNIT, bow_unit
from rtbow.physics.light.disc import disc_nodes, disc_nodes_off_poles
from rtbow.physics.sizes import Sizes, tabled_sizes
from rtbow.tables.mie.axes import (
    DEFAULT_SPREAD,
    INDEX_RANGE,
    INDEX_RANGES,
    WIDE_INDEX_RANGE,
    MieAxes,
)

_MARGIN = 6
"""Nodes beyond the range on each side: what a spline's end does falls by 0.27 per node."""


def standard_axes(spread: float, index_range: tuple[float, float] = INDEX_RANGE) -> MieAxes:
    """Give the layout of a whole table: a narrower spread leaves finer fringes."""
    finer = min(max(DEFAULT_SPREAD / spread, 0.5), 2.0)
    if index_range[0] == index_range[1]:
        # One index needs no others beside it; its bows may be narrower than those of water.
        narrower = max(PRIMARY_UNIT / bow_unit(index_range[0]), 1.0)
        return MieAxes(
            spread, 1.0, 1, index_range, 60.0 * finer * narrower, 100.0 * finer, 50.0 * finer, 0.45
        )
    return MieAxes(spread, 1.0, 5, index_range, 60.0 * finer, 100.0 * finer, 50.0 * finer, 0.45)


def index_range_of(index: Array) -> tuple[float, float]:
    """Give the range of a table that holds some indices: one of water's, or a single index.

    Raises:
        InputError: indices beyond water's that differ from wavelength to wavelength.
    """
    low, high = float(index.min()), float(index.max())
    for ends in INDEX_RANGES:
        if ends[0] <= low and high <= ends[1]:
            return ends
    if low < high:
        check_index(index, WIDE_INDEX_RANGE)
    return low, high


def node_range(axes: MieAxes, radii_um: tuple[float, float]) -> tuple[int, int]:
    """Give the first node and the end of those that radii need at all visible wavelengths."""
    low = 2.0 * np.pi * radii_um[0] * 1e3 / VISIBLE_NM[1]
    high = 2.0 * np.pi * radii_um[1] * 1e3 / VISIBLE_NM[0]
    return axes.first_node(low) - _MARGIN, axes.first_node(high) + 2 + _MARGIN


@dataclass(frozen=True)
class MieTable:
    """Mean intensities at the nodes of some axes.

    Attributes:
        axes: the layout.
        first: node of the first size.
        values: |S|²/x² (indices, sizes, 2, angles), perpendicular and parallel, float32.
        efficiency: Q_ext (indices, sizes), averaged over the spread of sizes as ``values`` are.
    """

    axes: MieAxes
    first: int
    values: NDArray[np.float32]
    efficiency: Array

    def covers(self, radii_um: tuple[float, float]) -> bool:
        """Whether it holds some radii at all visible wavelengths."""
        low, high = node_range(self.axes, radii_um)
        return low >= self.first and high <= self.first + self.values.shape[1]

    def intensities(self, x: Array, m: float, part: slice = slice(None)) -> Array:
        """Look up |S|²/x² at the table's own angles for an index (:meth:`MieAxes.angles`).

        Args:
            x: size parameters (R,).
            m: relative index.
            part: of those angles.

        Returns:
            (R, 2, T), T the angles of the part.
        """
        rows, start, weights = self._rows(x)
        held = self.values[:, rows, :, part]
        mixed = np.tensordot(self.axes.index_weights(m), held, axes=(0, 0))
        return _mix_rows(_spline(mixed), start, weights)

    def mixed(self, x: Array, weights: Array, m: Array, part: slice = slice(None)) -> Array:
        """Look up sums of |S|²/x² over sizes, for several indices at once.

        Args:
            x: size parameters (W, R).
            weights: of the sizes (R,).
            m: relative indices (W,).
            part: of the table's own angles at each index (:meth:`MieAxes.angles`).

        Returns:
            (W, 2, T), T the angles of the part.
        """
        # All of it is linear in the table: first what each of its rows counts, then one product.
        counts = np.zeros((len(m), *self.values.shape[:2]))
        for k, index_weights in enumerate(self.axes.index_weights(floats(m))):
            rows, start, shares = self._rows(x[k])
            of_row = np.zeros(rows.stop - rows.start)
            for j in range(4):
                np.add.at(of_row, start + j, weights * shares[:, j])
            of_row = of_row @ _spline(np.eye(len(of_row)))
            counts[k, :, rows] = np.outer(index_weights, of_row)
        used = np.flatnonzero(counts.any(axis=(0, 1)))
        rows = slice(int(used[0]), int(used[-1]) + 1)
        total = np.zeros((len(m), 2 * len(range(*part.indices(self.values.shape[3])))))
        for j, values in enumerate(self.values):
            held = floats(values[rows, :, part]).reshape(rows.stop - rows.start, -1)
            total += counts[:, j, rows] @ held
        return floats(total.reshape(len(m), 2, -1))

    def extinction_efficiency(self, x: Array, m: float) -> Array:
        """Look up Q_ext at sizes x (R,)."""
        rows, start, weights = self._rows(x)
        mixed = self.axes.index_weights(m) @ self.efficiency[:, rows]
        return floats(_mix_rows(_spline(mixed)[:, None, None], start, weights)[:, 0, 0])

    def _rows(self, x: Array) -> tuple[slice, NDArray[np.int64], Array]:
        """Rows that sizes need, and the first row and the weights of the spline at each size."""
        place = np.log(floats(x)) / self.axes.step - self.first
        if place.min() < 1.0 or place.max() >= self.values.shape[1] - 2:
            ends = self.axes.sizes(floats([self.first + 1, self.first + self.values.shape[1] - 2]))
            raise InputError(
                f"size parameters {np.min(x):.4g} to {np.max(x):.4g}; this table of exact theory"
                f" holds {ends[0]:.4g} to {ends[1]:.4g}; ask for radii within its range"
            )
        base = np.floor(place).astype(np.int64)
        rows = slice(
            max(int(base.min()) - 2 * _MARGIN, 0),
            min(int(base.max()) + 2 * _MARGIN, self.values.shape[1]),
        )
        f = (place - base)[:, None]
        weights = np.concatenate(
            [
                (1.0 - f) ** 3,
                4.0 - 6.0 * f**2 + 3.0 * f**3,
                1.0 + 3.0 * f + 3.0 * f**2 - 3.0 * f**3,
                f**3,
            ],
            axis=1,
        )
        return rows, base - 1 - rows.start, weights / 6.0


def _spline(rows: Array) -> Array:
    """Coefficients of the cubic spline through values along the first axis."""
    from scipy.ndimage import spline_filter1d

    return floats(spline_filter1d(rows, order=3, axis=0, mode="mirror", output=np.float64))


def _mix_rows(coefficients: Array, start: NDArray[np.int64], weights: Array) -> Array:
    mixed = np.zeros((len(start), *coefficients.shape[1:]))
    for k in range(4):
        mixed += weights[:, k, None, None] * coefficients[start + k]
    return mixed


@compiled(parallel=True)
def resample(values: Array, places: Array, weights: Array) -> Array:
    """Means over discs of a table's columns: cubic interpolation at each node of each disc.

    Args:
        values: (T, C).
        places: where the nodes lie along T, (U, n).
        weights: of the nodes (U, n).

    Returns:
        (U, C).
    """
    angles, columns = values.shape
    out = np.zeros((len(places), columns))
    for u in prange(len(places)):
        row = out[u]
        for k in range(places.shape[1]):
            base = min(max(int(places[u, k]), 1), angles - 3)
            f = places[u, k] - base
            # Lagrange's cubic through the four nodes around; at the ends through the last four.
            w0 = -weights[u, k] * f * (f - 1.0) * (f - 2.0) / 6.0
            w1 = weights[u, k] * (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0
            w2 = -weights[u, k] * (f + 1.0) * f * (f - 2.0) / 2.0
            w3 = weights[u, k] * (f + 1.0) * f * (f - 1.0) / 6.0
            a, b = values[base - 1], values[base]
            c, d = values[base + 1], values[base + 2]
            for j in range(columns):
                row[j] += (w0 * a[j] + w1 * b[j]) + (w2 * c[j] + w3 * d[j])
    return out


def disc_grid(theta: Array, disc_rad: float) -> tuple[Array, Array]:
    """Nodes and weights over a disc about each angle: (U, n) each, padded with weight 0."""
    # The finest fringes that a spread of 2 % leaves turn by 6000 rad per rad.
    count = 24 + int(4000.0 * disc_rad) if disc_rad > 0.0 else 1
    covering = np.minimum(theta, np.pi - theta) < disc_rad
    discs = {int(u): disc_nodes(float(theta[u]), disc_rad, count) for u in np.flatnonzero(covering)}
    most = max([count, *(len(angles) for angles, _ in discs.values())])
    nodes, weights = np.zeros((len(theta), most)), np.zeros((len(theta), most))
    if disc_rad > 0.0:
        off = disc_nodes_off_poles(theta[~covering], disc_rad, count)
        nodes[~covering, :count], weights[~covering, :count] = off
    else:
        nodes[:, 0], weights[:, 0] = theta, 1.0
    for u, (angles, shares) in discs.items():
        nodes[u, : len(angles)], weights[u, : len(shares)] = angles, shares
    return nodes, weights


def check_index(index: Array, index_range: tuple[float, float]) -> None:
    """Refuse refractive indices that tables over a range do not hold.

    Raises:
        InputError: one of them lies outside.
    """
    low, high = index_range
    if np.any((index < low) | (index > high)):
        raise InputError(
            f"water has a refractive index of {index.min():.4f} to {index.max():.4f} at these"
            f" wavelengths; theory mie holds {low} to {high}: 380-780 nm at -12 to 60 °C"
        )


@dataclass(frozen=True)
class MieSections:
    """Cross-sections of water drops at some wavelengths.

    Attributes:
        table: the table.
        wavelength_m: wavelengths in air (W,), m.
        index: relative index (W,).
    """

    table: MieTable
    wavelength_m: Array
    index: Array

    def __post_init__(self) -> None:
        check_index(self.index, self.table.axes.index_range)

    def sections(
        self, radius_m: Array, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give both components of the differential cross-section, averaged over the disc.

        Args:
            radius_m: drop radii (R,).
            theta_rad: scattering angles (U,).
            disc_rad: angular radius of the light's disc.

        Returns:
            |S1|²/k² and |S2|²/k² in m² sr⁻¹, (R, W, U, 2); without absorption.
        """
        radius = floats(radius_m)
        nodes, weights = disc_grid(floats(theta_rad), disc_rad)
        out = np.empty((len(radius), len(self.index), len(theta_rad), 2))
        for w, (wavelength, m) in enumerate(zip(self.wavelength_m, self.index, strict=True)):
            x = 2.0 * np.pi * radius / wavelength
            part, places = self._part(nodes, float(m))
            values = self.table.intensities(x, float(m), part) * radius[:, None, None] ** 2
            columns = np.ascontiguousarray(values.reshape(-1, values.shape[2]).T)
            means = resample(columns, places, weights)
            out[:, w] = means.reshape(len(theta_rad), len(radius), 2).transpose(1, 0, 2)
        return out

    def _part(self, theta: Array, m: float) -> tuple[slice, Array]:
        """The table's angles that some angles need, and the places of these along that part."""
        places = self.table.axes.angle_places(theta, m)
        # Two neighbours on each side, and four in all, for cubic interpolation.
        count = self.table.values.shape[3]
        low = min(max(int(places.min()) - 2, 0), count - 4)
        high = min(max(int(places.max()) + 4, low + 4), count)
        return slice(low, high), floats(places - low)

    def mixed(
        self, sizes: Sizes, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give the mean over drops of several sizes, (W, U, 2), from the arguments of
        :meth:`sections`."""
        sizes = tabled_sizes(sizes)
        nodes, weights = disc_grid(floats(theta_rad), disc_rad)
        found = [self._part(nodes, float(m)) for m in self.index]
        low, high = min(part.start for part, _ in found), max(part.stop for part, _ in found)
        x = 2.0 * np.pi * sizes.radius_m / self.wavelength_m[:, None]
        shares = sizes.share * sizes.radius_m**2
        values = self.table.mixed(x, shares, self.index, slice(low, high))
        out = np.empty((len(self.index), len(theta_rad), 2))
        for w, (part, places) in enumerate(found):
            own = values[w, :, part.start - low : part.stop - low]
            out[w] = resample(np.ascontiguousarray(own.T), places, weights)
        return out
