"""Extinction efficiencies of drops by exact theory: from tables, and large drops' limit."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.limits import MIN_RADIUS_UM
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.drop.medium import Medium
from rtbow.tables.mie.axes import DEFAULT_SPREAD

_EDGE_TERM = 1.9924
"""Q_ext of a large drop is 2, its shadow and the light diffracted by it, and this times x^(-2/3),
what grazes its edge: Nussenzveig and Wiscombe, Phys. Rev. Lett. 45, 1490 (1980)."""
_EDGE_SIZE = 3000.0
"""Size x from which on Q_ext is taken as that, within 5e-4."""


def extinction_efficiencies(radius_m: Array, wavelength_nm: Array, medium: Medium) -> Array:
    """Give the exact extinction efficiency Q_ext (R, W), for either theory: Airy's has none.

    From a table whose spread of sizes averages the ripple, and its limit for large drops: for fresh
    water the one that ships, within whose range the index is taken, on which Q hardly depends.
    """
    nm, radii = floats(wavelength_nm), floats(radius_m)
    x = 2.0 * np.pi * radii[:, None] / (nm * 1e-9)
    large = 2.0 + _EDGE_TERM * x ** (-2.0 / 3.0)
    if x.min() >= _EDGE_SIZE:
        return floats(large)
    # Imported here, with the compiler of tables' sums.
    from rtbow.tables.mie.lookup import index_range_of, standard_axes
    from rtbow.tables.mie.store import compact_table, efficiency_table

    index = medium.index(nm)
    if medium.fresh:
        table = compact_table()
        index = np.clip(index, *table.axes.index_range)
    else:
        axes = standard_axes(DEFAULT_SPREAD, index_range_of(index))
        table = efficiency_table(axes, (MIN_RADIUS_UM, _EDGE_SIZE * VISIBLE_NM[1] * 1e-3 / np.pi))
    held = np.minimum(x, _EDGE_SIZE)
    columns = [table.extinction_efficiency(held[:, w], float(m)) for w, m in enumerate(index)]
    return floats(np.where(x < _EDGE_SIZE, np.stack(columns, axis=1), large))
