"""Where the Lorenz-Mie table has its nodes: size, refractive index and scattering angle.

Intensity depends on the size parameter x and, slowly, on the index m; a table over both serves all
wavelengths at once. With m the bows move: angles are stretched piecewise so that both bows, the
forward and the backward direction keep their places along the axis, and what is left of the
dependence on m is a polynomial of low degree.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, Values, floats
from rtbow.base.resources import resource_dir
from rtbow.physics.drop.airy import bow, unit_angle

DEFAULT_SPREAD = 0.02
COMPACT_FILE = resource_dir("data") / "mie-compact.bin"
"""The table of this spread that comes with the package (:mod:`rtbow.tables.mie.store`)."""
_THINNING = 4
"""Of nodes where there is nothing but smooth parts, one in so many is computed."""
INDEX_RANGE = (1.3268, 1.3466)
"""Water in air, 380-780 nm, 0 to 30 °C."""
WIDE_INDEX_RANGE = (1.3215, 1.3470)
"""Water in air, 380-780 nm, -12 to 60 °C. Bows of high order move several times as fast with the
index as the first two, which is what limits interpolation: a fifth of the error is left in the
narrower range."""
INDEX_RANGES = (INDEX_RANGE, WIDE_INDEX_RANGE, (1.3268, 1.3510), (1.3300, 1.3550))
"""Fresh water's two, and two of salt water: up to about 20 g/kg, and up to 40."""
_MIDDLE_INDEX = 0.5 * (INDEX_RANGE[0] + INDEX_RANGE[1])


@dataclass(frozen=True)
class MieAxes:
    """The table's layout; equal layouts are equal tables.

    Attributes:
        spread: standard deviation of ln(size) that each node is averaged over.
        per_spread: nodes along ln x in that deviation.
        indices: nodes along m (Chebyshev's).
        index_range: over which they lie.
        per_fold: angles per factor e of the distance from a bow.
        per_forward_fold: angles per factor e of the distance from the forward direction, up to
            half a radian.
        per_backward_fold: angles per factor e of the distance from the backward direction.
        base_deg: widest distance between angles.
    """

    spread: float
    per_spread: float
    indices: int
    index_range: tuple[float, float]
    per_fold: float
    per_forward_fold: float
    per_backward_fold: float
    base_deg: float

    @property
    def step(self) -> float:
        """Distance of nodes along ln x."""
        return self.spread / self.per_spread

    def first_node(self, x: float) -> int:
        """Node at or below a size; node j is at x = exp(j · step)."""
        return int(np.floor(np.log(x) / self.step))

    def sizes(self, nodes: Array) -> Array:
        """Size parameters of nodes."""
        return np.exp(floats(nodes) * self.step)

    @property
    def index_nodes(self) -> Array:
        """Refractive indices of the nodes (indices,)."""
        k = np.arange(self.indices)
        unit = np.cos((k + 0.5) * np.pi / self.indices)
        low, high = self.index_range
        return floats(0.5 * (low + high) + 0.5 * (high - low) * unit)

    def index_weights(self, m: Values) -> Array:
        """Weights of Lagrange's interpolation at indices m: (..., indices)."""
        nodes = self.index_nodes
        weights = np.ones((*np.shape(m), self.indices))
        for k in range(self.indices):
            for j in range(self.indices):
                if j != k:
                    weights[..., k] *= (np.asarray(m) - nodes[j]) / (nodes[k] - nodes[j])
        return weights

    def needed_angles(self, x: float, m: float) -> NDArray[np.int64]:
        """Nodes that sizes from x on need (k,), ascending; the others lie smoothly between them.

        Rings and fringes that the standard spread of sizes leaves are within 50/x of the poles, and
        within 28 units of Airy's argument of the bows on their bright side; the primary's unit
        serves both bows, of which the secondary's is wider.
        """
        angles = self.angles(m)
        finer = DEFAULT_SPREAD / self.spread
        ring = 80.0 * finer / x
        unit = unit_angle(x)
        secondary, primary = self._bows(m)
        fine = (angles < ring) | (np.pi - angles < ring)
        for edge, side in ((secondary, -1.0), (primary, 1.0)):
            scaled = side * (angles - edge) / unit
            fine |= (scaled > -8.0) & (scaled < 28.0 * finer)
        keep = [0]
        widest = np.radians(1.01 * self.base_deg)
        # A sphere's pattern is a polynomial of degree 2x in the cosine: an eighth of its Nyquist
        # spacing resolves all of it.
        closest = 0.15 / x
        for k in range(1, len(angles) - 1):
            last = keep[-1]
            apart = angles[k] - angles[last]
            if (
                ((fine[k] or fine[k + 1]) and angles[k + 1] - angles[last] > closest)
                or (k - last >= _THINNING and apart > closest)
                or apart > widest
            ):
                keep.append(k)
        return np.array([*keep, len(angles) - 1])

    @cached_property
    def angle_nodes(self) -> Array:
        """Angles of the nodes, 0 to pi, at the index in the middle (T,)."""
        total = self._total
        # Inverted by interpolation on a line much finer than the nodes, then by Newton's steps.
        fine = _dense_angles(self._edges)
        place = self._place(fine)
        wanted = np.linspace(0.0, total, round(total) + 1)
        angles = np.interp(wanted, place, fine)
        for _ in range(3):
            slope = (self._place(angles + 1e-9) - self._place(angles - 1e-9)) / 2e-9
            angles = np.clip(angles - (self._place(angles) - wanted) / slope, 0.0, np.pi)
        angles[0], angles[-1] = 0.0, np.pi
        return floats(angles)

    def angles(self, m: float) -> Array:
        """Scattering angles of the nodes at index m (T,), rad."""
        if self._one_index:
            return self.angle_nodes
        return floats(np.interp(self.angle_nodes, _anchors(_MIDDLE_INDEX), _anchors(m)))

    def angle_places(self, theta: Array, m: float) -> Array:
        """Places of scattering angles along the nodes, 0..T-1, for index m."""
        middle = (
            theta if self._one_index else np.interp(theta, _anchors(m), _anchors(_MIDDLE_INDEX))
        )
        return floats(self._place(middle) * (round(self._total) / self._total))

    @property
    def _one_index(self) -> bool:
        """Whether the layout is that of a single index, whose bows stay where they are."""
        return self.index_range[0] == self.index_range[1]

    @cached_property
    def _edges(self) -> Array:
        """Secondary and primary bow at the index in the middle."""
        return self._bows(self.index_range[0] if self._one_index else _MIDDLE_INDEX)

    def _bows(self, m: float) -> Array:
        """Secondary and primary bow at an index."""
        if self._one_index:
            return floats([float(bow(k, np.array(1e-6), np.array(m)).angle_rad) for k in (2, 1)])
        return _anchors(m)[3:5]

    @cached_property
    def _total(self) -> float:
        """Place of the last angle before it is rounded to a node."""
        return float(self._place(np.array([np.pi]))[0])

    def _place(self, theta: Array) -> Array:
        # Densities c / sqrt(w² + d²) about each place where detail gathers have asinh for integral.
        place = np.degrees(theta) / self.base_deg
        for edge in self._edges:
            start = np.arcsinh(-edge / _BOW_WIDTH)
            place = place + self.per_fold * (np.arcsinh((theta - edge) / _BOW_WIDTH) - start)
        place = place + self.per_forward_fold * pole_place(theta)
        backward = pole_place(floats(np.pi)) - pole_place(np.pi - theta)
        return floats(place + self.per_backward_fold * backward)


def pole_place(distance: Array) -> Array:
    """Place of distances from a pole (rad) along an axis with one node per factor e of them."""
    # The difference of two such densities: the nearer one, which the farther one ends.
    return floats(np.arcsinh(distance / _POLE_WIDTH) - np.arcsinh(distance / _POLE_END))


_BOW_WIDTH = np.radians(0.15)
"""Distance from a bow within which angles are evenly dense: 1.3 units of Airy's argument at
x = 25,000, about the rise of the narrowest bow."""
_POLE_WIDTH = 1e-5
"""A quarter of 1/x there: corona and glory."""
_POLE_END = 0.6
"""Their rings are within this of the poles for all x that have any."""


_ZONE = np.radians(12.0)
"""Extent of a bow's fringes that are kept in line."""
_STILL = np.radians([25.0, 172.0])
"""Corona and glory lie before and behind these angles, and do not depend on m."""


def _anchors(m: float) -> Array:
    """Angles that the axis keeps in place; between them it is stretched evenly.

    They are the ends of corona and glory, both bows, and the ends of their fringes, which scale
    as Airy's do.
    """
    scale = []
    edges = []
    for reflections in (1, 2):
        # Any wavelength will do for a ratio of scales.
        moved, middle = (bow(reflections, np.array(1e-6), np.array(n)) for n in (m, _MIDDLE_INDEX))
        scale.append(float(middle.scale / moved.scale))
        edges.append(float(moved.angle_rad))
    primary, secondary = edges
    return np.array(
        [
            0.0, _STILL[0], secondary - _ZONE * scale[1], secondary,
            primary, primary + _ZONE * scale[0], _STILL[1], np.pi,
        ]
    )  # fmt: skip


def _dense_angles(edges: Array) -> Array:
    centres = [0.0, *edges, np.pi]
    away = np.geomspace(1e-7, np.pi, 4000)
    near = [c + s * away for c in centres for s in (-1.0, 1.0)]
    every = np.concatenate([*near, np.linspace(0.0, np.pi, 4000)])
    return floats(np.unique(np.clip(every, 0.0, np.pi)))
