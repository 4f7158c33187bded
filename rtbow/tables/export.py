"""The plain scattering table, radius x wavelength x angle, for other programs."""

from __future__ import annotations

import io
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, Progress, no_progress
from rtbow.base.errors import InputError
from rtbow.base.exr import write_exr_channels
from rtbow.base.files import write_atomic
from rtbow.base.limits import MAX_DISC_DEG, MAX_RADIUS_UM, MIN_RADIUS_UM, SIZE_SPREADS
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.drop.water import relative_index
from rtbow.tables.mie.axes import DEFAULT_SPREAD
from rtbow.tables.phase import Scatterers, following_angles
from rtbow.tables.sections import Theory, water_sections

ORDERS = (1, 2)
TEMPERATURE_C = 20.0
MAX_VALUES = 100_000_000
"""Values of one component, at most: 400 MB, of which writing holds a few copies."""


def default_radii_um() -> tuple[float, ...]:
    """Give 64 radii from 10 to 1500 µm in equal ratios."""
    return tuple(np.geomspace(10.0, 1500.0, 64))


def default_wavelengths_nm() -> tuple[float, ...]:
    """Give 380 to 780 nm by 5 nm."""
    return tuple(np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1.0, 5.0))


def _check(name: str, values: Sequence[float], low: float, high: float, unit: str) -> Array:
    array = np.array(values, dtype=np.float64)
    wrong = [v for v in values if not low <= v <= high]  # NaN too
    if wrong:
        raise InputError(f"{name}: {wrong[0]:g} is not allowed; must be {low:g}..{high:g} {unit}")
    if array.size == 0:
        raise InputError(f"{name}: is empty; give at least one number, {low:g}..{high:g} {unit}")
    for before, after in itertools.pairwise(values):
        if after <= before:
            raise InputError(
                f"{name}: {after:g} follows {before:g}; sort the numbers by increasing size, each"
                " once"
            )
    return array


def _digits(number: float) -> str:
    """Write a number so that it reads back as itself, 500 and not 500.0."""
    return np.format_float_positional(number, trim="-")


@dataclass(frozen=True)
class PlainTable:
    """What a plain table is to hold.

    Attributes:
        theory: ``airy`` or ``mie``.
        radius_um: drop radii (R,).
        wavelength_nm: wavelengths in air (W,).
        angles: number T of scattering angles, evenly from 0 to pi; None for angles that follow the
            forward peak and the bows, so that sums over the sphere keep the total.
        disc_deg: angular diameter of the light's disc.
        spread: standard deviation of ln(radius) about each radius (mie).
    """

    theory: Theory
    radius_um: Sequence[float]
    wavelength_nm: Sequence[float]
    angles: int | None
    disc_deg: float
    spread: float = DEFAULT_SPREAD

    def check(self) -> tuple[Array, Array, float]:
        """Give radii (µm), wavelengths (nm) and the disc's angular radius (rad).

        Raises:
            InputError: a value outside of its range.
        """
        radii = _check("--radius-um", self.radius_um, MIN_RADIUS_UM, MAX_RADIUS_UM, "µm")
        # IAPWS R9-97 holds beyond the visible, too; tables of exact theory do not.
        low, high = VISIBLE_NM if self.theory == "mie" else (200.0, 1100.0)
        nm = _check("--wavelength-nm", self.wavelength_nm, low, high, "nm")
        least, most = (100.0 * end for end in SIZE_SPREADS)
        _check("--spread", [100.0 * self.spread], least, most, "percent")
        disc_deg = float(_check("--disc", [self.disc_deg], 0.0, MAX_DISC_DEG, "degrees")[0])
        shape = (len(radii), len(nm), len(self.theta(radii, nm)))
        if math.prod(shape) > MAX_VALUES:
            counts = " x ".join(map(str, shape))
            raise InputError(
                f"{counts} radii, wavelengths and angles are {math.prod(shape):.2g} values; must be"
                f" at most {MAX_VALUES:.2g}; give fewer of them"
            )
        return radii, nm, math.radians(0.5 * disc_deg)

    def theta(self, radius_um: Array, wavelength_nm: Array) -> Array:
        """Give the scattering angles (T,), rad."""
        if self.angles is not None:
            return np.linspace(0.0, math.pi, self.angles)
        index = relative_index(wavelength_nm, TEMPERATURE_C)
        return following_angles(self.theory, radius_um * 1e-6, wavelength_nm * 1e-9, index, ORDERS)

    def scatterers(self, progress: Progress = no_progress) -> Scatterers:
        """Give the drops; ``progress`` wraps the loop over parts of a table that must be built.

        Raises:
            InputError: a value outside of its range.
        """
        radii, nm, disc_rad = self.check()
        sections = water_sections(
            self.theory, nm, TEMPERATURE_C, (radii[0], radii[-1]), orders=ORDERS,
            spread=self.spread, progress=progress,
        )  # fmt: skip
        return Scatterers(self.theory, sections, nm, TEMPERATURE_C, ORDERS, disc_rad)


def plain_table(
    wanted: PlainTable, progress: Progress = no_progress, building: Progress = no_progress
) -> dict[str, Array]:
    """Evaluate the scattering table on a plain grid.

    Args:
        wanted: its content.
        progress: wraps the loop over radii.
        building: wraps the loop over parts of an exact table that has to be built first.

    Returns:
        ``radius_um`` (R,), ``wavelength_nm`` (W,), ``theta_rad`` (T,), ``perpendicular``,
        ``parallel`` float32 (R, W, T): |S1|²/k² and |S2|²/k² in m² sr⁻¹, water at 20 °C in air; of
        the primary and the secondary bow together (airy), or of all that a sphere does (mie); and
        ``scattering_m2`` (R, W): the mean of both components over the sphere.

    Raises:
        InputError: a value outside of its range.
    """
    radii, nm, disc_rad = wanted.check()
    theta = wanted.theta(radii, nm)
    scatterers = wanted.scatterers(building)
    shape = (len(radii), len(nm), len(theta))
    components = {"perpendicular": np.empty(shape, "f4"), "parallel": np.empty(shape, "f4")}
    for r in progress(range(len(radii))):
        both = scatterers.sections.sections(radii[r : r + 1] * 1e-6, theta, disc_rad)[0]
        for c, component in enumerate(components.values()):
            component[r] = both[..., c]
    total = scatterers.scattering(radii * 1e-6)
    return {
        "radius_um": radii, "wavelength_nm": nm, "theta_rad": theta, **components,
        "scattering_m2": total,
    }  # fmt: skip


def export_table(
    path: Path,
    wanted: PlainTable,
    progress: Progress = no_progress,
    building: Progress = no_progress,
) -> None:
    """Write the plain table, whole or not at all (see :func:`plain_table` for the arguments).

    ``.npz`` holds the arrays; ``.exr`` holds a row per radius and a column per angle, with
    channels ``perpendicular.450nm``, ``parallel.450nm`` and so on, and the radii in an attribute.

    Raises:
        InputError: a value outside of its range, or the file cannot be written.
    """
    table = plain_table(wanted, progress, building)
    if path.suffix.lower() == ".npz":
        buffer = io.BytesIO()
        np.savez(buffer, **table)  # type: ignore[arg-type]
        write_atomic(path, buffer.getvalue())
        return
    channels = {
        f"{name}.{_digits(nm)}nm": table[name][:, w].astype(np.float32)
        for name in ("perpendicular", "parallel")
        for w, nm in enumerate(table["wavelength_nm"])
    }
    metadata = {
        "content": "columns: scattering angle 0 to pi, evenly; rows: radius; values: m2 sr-1",
        "radius_um": ",".join(map(_digits, table["radius_um"])),
        "discDeg": _digits(wanted.disc_deg),
        "theory": wanted.theory,
        "sizeSpread": _digits(wanted.spread) if wanted.theory == "mie" else "",
        "wavelength_nm": ",".join(map(_digits, table["wavelength_nm"])),
        # Rows of radii, as the picture's; columns of wavelengths.
        "scattering_m2": ";".join(
            ",".join(f"{total:.6g}" for total in row) for row in table["scattering_m2"]
        ),
    }
    write_exr_channels(path, channels, metadata)
