"""Plot the look-up error of the Airy table over radius and angle: docs/table-error.png.

python tools/plot_table_error.py docs/table-error.png
"""

from __future__ import annotations

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

from rtbow.tables.airy import airy_table
from rtbow.tables.report import lookup_errors

POINTS = 30_000
DISCS_DEG = (0.0, 0.533)


def main(path: str) -> None:
    """Measure at random points and plot the worst error of each cell."""
    table = airy_table()
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), sharey=True, layout="constrained")
    for axis, disc in zip(axes, DISCS_DEG, strict=True):
        errors = lookup_errors(table, disc, POINTS, np.random.default_rng(3))
        image = axis.hexbin(
            errors.theta_deg,
            errors.radius_um,
            C=np.maximum(np.abs(errors.error), 1e-7) * 100.0,
            reduce_C_function=np.max,
            yscale="log",
            gridsize=(60, 30),
            norm=LogNorm(1e-4, 0.5),
            cmap="viridis",
        )
        worst = 100.0 * float(np.abs(errors.error).max())
        axis.set_title(f"light {disc:g}° across: worst {worst:.2f} %")
        axis.set_xlabel("scattering angle, degrees")
    axes[0].set_ylabel("drop radius, µm")
    figure.colorbar(image, ax=axes, label="largest error in a cell, % of the bow's own peak")
    figure.suptitle(
        f"Airy table against direct evaluation: {POINTS} random points, 380-780 nm, both orders"
    )
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "docs/table-error.png")
