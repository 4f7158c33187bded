"""Lee diagrams: the colours of the bow over drop radius and scattering angle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.base.errors import InputError
from rtbow.base.limits import MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.frames.display import auto_exposure_ev, display
from rtbow.frames.plot import caption, new_figure, save, style
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.scene.lights import E490
from rtbow.study.charts import THEORY_NAMES, Setup, check_angles, check_range, opposite
from rtbow.tables.sections import Theory
from rtbow.world.measured.spectra import load_spectrum

Normalise = Literal["column", "none"]

_MAX_SIDE = 4000
_STEP_NM = 5.0


@dataclass(frozen=True)
class LeeRaster:
    """The colours of light from drops, over radius and scattering angle.

    Attributes:
        setup: drops and light.
        radius_um: ends of the range of radii, whose logarithms are evenly spaced.
        theta_deg: ends of the range of scattering angles, which are evenly spaced.
        xyz: by theory, X, Y, Z of the light that one drop sends in a direction, in lm/sr under
            sunlight of E490 (R, U, 3), by increasing radius and scattering angle, each at the
            middle of its cell.
    """

    setup: Setup
    radius_um: tuple[float, float]
    theta_deg: tuple[float, float]
    xyz: dict[Theory, Array]

    def relative(self, normalise: Normalise) -> dict[Theory, Array]:
        """Give X, Y, Z weighted for display, of the shape of ``xyz``.

        With ``column`` the greatest Y of each radius in this range of angles is 1, as Lee has it.
        With ``none`` the values are per area of the drop, a², as from the same area of drops of
        each size, and the greatest Y of all theories is 1.
        """
        if normalise == "column":
            return {
                t: floats(xyz / xyz[..., 1].max(axis=1)[:, None, None])
                for t, xyz in self.xyz.items()
            }
        radius = _cells_log(*self.radius_um, len(next(iter(self.xyz.values()))))
        per_area = {t: xyz / (radius**2)[:, None, None] for t, xyz in self.xyz.items()}
        greatest = max(float(each[..., 1].max()) for each in per_area.values())
        return {t: floats(each / greatest) for t, each in per_area.items()}

    def pictures(self, normalise: Normalise) -> dict[Theory, NDArray[np.uint8]]:
        """Give sRGB pictures (U, R, 3) of one exposure, small scattering angles on top."""
        rgb = {t: xyz_to_rgb(xyz).transpose(1, 0, 2) for t, xyz in self.relative(normalise).items()}
        exposure = auto_exposure_ev(np.concatenate(list(rgb.values()), axis=1))
        return {t: display(frame, exposure) for t, frame in rgb.items()}


def _cells(low: float, high: float, count: int) -> Array:
    """Give the middles of equal cells between two numbers (count,)."""
    return floats(low + (np.arange(count) + 0.5) * ((high - low) / count))


def _cells_log(low: float, high: float, count: int) -> Array:
    return floats(np.exp(_cells(math.log(low), math.log(high), count)))


def lee_raster(
    setup: Setup,
    radius_um: tuple[float, float],
    theta_deg: tuple[float, float],
    size: tuple[int, int],
    progress: Progress = no_progress,
) -> LeeRaster:
    """Compute the colours of sunlight from drops, over radius and scattering angle.

    Args:
        setup: drops and light.
        radius_um: least and greatest radius.
        theta_deg: least and greatest scattering angle.
        size: number of radii and of angles.
        progress: wraps the loops over radii and over the parts of a table that must be built.

    Raises:
        InputError: a value is out of its range.

    Source: R. L. Lee, Applied Optics 37, 1506 (1998).
    """
    limits = (MIN_RADIUS_UM, MAX_RADIUS_UM)
    check_range(("--radius-from", "--radius-to"), radius_um, *limits, "um")
    check_angles(theta_deg)
    for side in size:
        if not 2 <= side <= _MAX_SIDE:
            raise InputError(
                f"--size {size[0]}x{size[1]}: must be 2..{_MAX_SIDE} radii and as many angles"
            )
    bins = wavelength_bins(_STEP_NM)
    weights = colour_weights(load_spectrum(E490), bins)
    radius_m = _cells_log(*radius_um, size[0]) * 1e-6
    theta = np.radians(_cells(*theta_deg, size[1]))
    xyz: dict[Theory, Array] = {}
    # Some radii at a time: their spectra are many times the size of their colours.
    block = max(1, 16_384 // size[1])
    for theory in setup.theories:
        sections = setup.sections(theory, bins.wavelength_nm, radius_um, progress)
        xyz[theory] = np.empty((*size, 3))
        for start in progress(range(0, size[0], block)):
            part = slice(start, start + block)
            mean = sections.sections(radius_m[part], theta, setup.disc_rad).mean(axis=-1)
            xyz[theory][part] = np.einsum("rwu,wc->ruc", mean, weights)
    return LeeRaster(setup, radius_um, theta_deg, xyz)


def draw_lee(path: Path, data: LeeRaster, normalise: Normalise) -> None:
    """Draw a Lee diagram for each theory, side by side: ``.png`` or ``.svg``, whole or not at all.

    Args:
        path: the file.
        data: the colours.
        normalise: see :meth:`LeeRaster.relative`.
    """
    pictures = data.pictures(normalise)
    low, high = data.theta_deg
    with style():
        figure = new_figure(1.2 + 4.4 * len(pictures), 5.6)
        grid = figure.subplots(1, len(pictures), sharey=True, squeeze=False)[0]
        for axis, (theory, picture) in zip(grid, pictures.items(), strict=True):
            # In the axes' own coordinates: images do not follow a logarithmic axis, and the
            # columns of this one are even in the logarithm already.
            axis.imshow(
                picture,
                extent=(0.0, 1.0, 0.0, 1.0),
                transform=axis.transAxes,
                aspect="auto",
                interpolation="bilinear",
            )
            _log_radius_axis(axis, data.radius_um)
            axis.set_ylim(180.0 - high, 180.0 - low)
            axis.set_title(THEORY_NAMES[theory], fontsize=11)
            axis.tick_params(direction="out")
        grid[0].set_ylabel("angle from the antisolar point, degrees")
        right = grid[-1].secondary_yaxis("right", functions=(opposite, opposite))
        right.set_ylabel("scattering angle, degrees")
        weight = {
            "column": "each radius to its own greatest luminance",
            "none": "luminance per area of drop",
        }[normalise]
        caption(
            figure,
            "Lee diagram: colour of sunlight (ASTM E-490) from drops of one radius, CIE 1931 2°,"
            f" sRGB, {weight}. {data.setup.caption}",
        )
        save(figure, path)


def _log_radius_axis(axis: Any, radius_um: tuple[float, float]) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_xscale("log")
    axis.set_xlim(*radius_um)
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(LogLocator(subs=tuple(range(1, 10))))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set_xlabel("drop radius, µm")
