"""The phase function of rain, as light that is scattered more than once meets it.

Exact theory whatever the single scattering's is: most of what a drop scatters passes through it,
and Airy's theory has the bows alone. The diffraction peak is cut off where the rain's extinction
cuts it (:mod:`rtbow.world.rain.extinction`): at the edge of the light's disc. What is left is
divided by its own integral, for drops of water absorb nothing that is visible.

Values are means over cells of the scattering angle: 0.05 degrees wide, and near the cut a fortieth
of the angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.physics.drop.medium import Medium
from rtbow.physics.sizes import Sizes
from rtbow.tables.mixtures import KeptMixtures
from rtbow.tables.phase import following_angles, over_sphere
from rtbow.tables.sections import drop_sections

_CELL_RAD = float(np.radians(0.05))
_RATIO = 1.025
_LEAST_RAD = 1e-4
"""End of the first cell where nothing is cut off."""
_ROW_RATIO = 1.25
"""Most between the radii of two rows: what drops scatter besides bows hardly changes with them."""
_DISC_RAD = float(np.radians(0.06))
"""Under which sections are summed: it moves light by less than a cell's width and a half."""


@dataclass(frozen=True)
class RainPhase:
    """Phase functions of drops of some radii.

    Attributes:
        radius_m: the radii (R,), ascending; one of mixed sizes.
        edges_rad: ends of the cells (N + 1,), ascending, from the cut to pi.
        density: per steradian (R, W, N); their integral over the sphere is 1.
        running: that from the cut to the ends of the cells (R, W, N + 1).
    """

    radius_m: Array
    edges_rad: Array
    density: Array
    running: Array

    @property
    def per_fold(self) -> float:
        """Rows per factor e of the radius."""
        rows = len(self.radius_m)
        return (rows - 1) / float(np.log(self.radius_m[-1] / self.radius_m[0])) if rows > 1 else 0.0


def cell_edges(cut_rad: float) -> Array:
    """Give the ends of the cells beyond a cut, rad."""
    start = max(cut_rad, _LEAST_RAD)
    grown = _CELL_RAD / (_RATIO - 1.0)
    count = 1 + max(int(np.ceil(np.log(grown / start) / np.log(_RATIO))), 0)
    near = start * _RATIO ** np.arange(count)
    even = np.linspace(near[-1], np.pi, 1 + int(np.ceil((np.pi - near[-1]) / _CELL_RAD)))
    first = [] if start == cut_rad else [cut_rad]
    return floats(np.concatenate([first, near, even[1:]]))


def rain_phase(
    medium: Medium,
    spread: float,
    range_um: tuple[float, float],
    sizes: Sizes | None,
    wavelength_nm: Array,
    cut_rad: float,
    progress: Progress = no_progress,
) -> RainPhase:
    """Sum the phase functions of a volume's drops.

    Args:
        medium: what they are made of.
        spread: standard deviation of ln(radius) about each size.
        range_um: least and greatest radius, µm.
        sizes: their distribution at every point, if they are mixed there.
        wavelength_nm: wavelengths in air (W,).
        cut_rad: scattering angle below which light is taken as not scattered.
        progress: wraps the loop over parts of an exact table that must be built.
    """
    nm, edges = floats(wavelength_nm), cell_edges(cut_rad)
    index = medium.index(nm)
    if sizes is not None:
        mixtures = KeptMixtures("mie", (1, 2), medium, spread, nm, progress)
        radius = floats([sizes.effective_radius_m])
        theta = _angles(edges, sizes.radius_m[-1:], nm, index)
        values = mixtures.mixed(sizes, theta, _DISC_RAD).mean(axis=-1)[None]
        return _of(radius, edges, theta, values)
    low, high = (1e-6 * end for end in range_um)
    rows = 1 if high == low else 2 + int(np.log(high / low) / np.log(_ROW_RATIO))
    radius = np.geomspace(low, high, rows)
    sections = drop_sections("mie", nm, medium, range_um, spread=spread, progress=progress)
    parts = []
    for one in radius:
        theta = _angles(edges, floats([one]), nm, index)
        values = sections.sections(floats([one]), theta, _DISC_RAD).mean(axis=-1)
        parts.append(_of(floats([one]), edges, theta, values))
    return RainPhase(
        radius, edges,
        np.concatenate([part.density for part in parts]),
        np.concatenate([part.running for part in parts]),
    )  # fmt: skip


def _angles(edges: Array, radius_m: Array, nm: Array, index: Array) -> Array:
    followed = following_angles("mie", radius_m, nm * 1e-9, index, (1, 2))
    return np.union1d(edges, followed[followed > edges[0]])


def _of(radius_m: Array, edges: Array, theta: Array, values: Array) -> RainPhase:
    """Of sections (R, W, T) at angles (T,), of which the edges are some."""
    running = over_sphere(theta, values)[..., np.searchsorted(theta, edges)]
    running /= running[..., -1:]
    solid = -2.0 * np.pi * np.diff(np.cos(edges))
    return RainPhase(radius_m, edges, floats(np.diff(running) / solid), floats(running))
