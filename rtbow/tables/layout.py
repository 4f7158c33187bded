"""Cross-sections laid out for a scene: what the shader's section texture and the reference read."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, Float32, floats
from rtbow.base.errors import InputError
from rtbow.physics.drop.airy import PRIMARY_UNIT, unit_angle
from rtbow.physics.sizes import Sizes

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections

_LARGEST_BYTES = 1024 * 2**20
"""A table that would take more as float32 is refused."""
_LARGEST_FLOAT32_BYTES = 128 * 2**20
"""A larger table is stored in half floats, whose 11 bits round by 2.4e-4."""
_HALF_MAX = 30_000.0
"""Greatest value that is stored as a half float, which ends at 65,504; larger ones are scaled."""
_ROW_STEP = 0.01
"""Distance of rows in ln(radius): with the 2 % spread, linear interpolation errs by 0.4 % of the
bow's peak at most without a disc, less with one."""
_COARSE_ROW_STEP = 0.015
"""Distance of rows where the table would grow too large: linear interpolation errs by 0.6 %."""
_ROWS_AT_ONCE = 32
"""Rows that are computed together: in float64 the whole table is four times as large."""
_MOST_EVEN = 12_000.0
"""Even texels across the angles, at most: GL devices take rows of 16,384. A point light's fringes
on drops of a millimetre are finer."""
_PER_FOLD = 60.0
"""Texels per factor e of the distance from a pole: 4 for the finest rings that a spread of 2 %
leaves (see :class:`AngleAxis`)."""
_EVEN_UNITS = 0.12 / PRIMARY_UNIT
"""Distance of even texels in units of Airy's argument z: a fourteenth. There f = Ai²(-z) has
f'' = -2 z f at its maximum, z = 1.02, and fringes of f'' = 2 sqrt(z)/pi beyond: a straight line
errs by an eighth of f'' times the distance squared, 0.13 % of the maximum there and 0.14 % sqrt(z)
at the fringes, which a spread of sizes of 2 % blurs beyond z = 28."""
_RING_UNITS = 0.25
"""Distance of the first texels at a pole, over 1/x: 12 across a ring, whose width is pi/x."""
_PER_DISC = 8.0
"""Texels across the radius of a light's disc, which leaves nothing finer than itself."""


@dataclass(frozen=True)
class AngleAxis:
    """Places of scattering angles: evenly, and denser towards both poles where detail is finer.

    Of drops of the size x, a bow's fringes are some x^(-2/3) wide, and even texels follow them. The
    rings of corona and glory are pi/x wide however near the pole, but a spread of sizes of 2 %
    blurs them beyond a distance of d = 50/x, and leaves only what changes with d itself. So the
    distance of texels may grow in proportion to d, from a least one at the pole: it is
    ``sqrt(d² + width²) / pole``. The places that this gives are the integral of its inverse,
    ``pole · arsinh(d / width)``, which a shader evaluates without a table. At d = 50/x there are
    3.6 texels to a ring.

    Straight lines between texels are within 0.5 % of the primary bow's peak between 20 and 179
    degrees, and within 1 % about the antisolar point: measured against exact theory of 100, 500 and
    1500 µm at 380, 550 and 780 nm, without a disc and with the sun's. Of 1500 µm without a disc,
    where even texels are at their most, it is 1.1 %. Within 2 degrees of the light they fill up the
    dark rings of the corona, under the sun's disc by a third of what light these have.

    Attributes:
        low: first angle, rad.
        high: last angle, rad.
        linear: even texels per rad.
        pole: texels per factor e of the distance from a pole.
        width: distance from a pole at which that begins, rad.
    """

    low: float
    high: float
    linear: float
    pole: float
    width: float

    def place(self, theta: Array) -> Array:
        """Place in texels, from an arbitrary start."""
        poles = np.arcsinh(theta / self.width) - np.arcsinh((np.pi - theta) / self.width)
        return floats(self.linear * theta + self.pole * poles)

    @property
    def ends(self) -> tuple[float, float]:
        """Places of the first and the last angle."""
        low, high = self.place(np.array([self.low, self.high]))
        return float(low), float(high)

    def angles(self) -> Array:
        """Angles of the texels, ascending."""
        low, high = self.ends
        wanted = np.linspace(low, high, max(2, math.ceil(high - low) + 1))
        return ascending_inverse(self.place, wanted, self.low, self.high)


def ascending_inverse(
    place: Callable[[Array], Array], wanted: Array, low: float, high: float
) -> Array:
    """Give the angles (n,) between two ends at which places (n,) that only grow are reached; the
    first and the last are the ends themselves."""
    lower, upper = np.full(len(wanted), low), np.full(len(wanted), high)
    for _ in range(60):
        middle = 0.5 * (lower + upper)
        below = place(middle) < wanted
        lower, upper = np.where(below, middle, lower), np.where(below, upper, middle)
    angles = 0.5 * (lower + upper)
    angles[0], angles[-1] = low, high
    return floats(angles)


def angle_axis(
    low: float, high: float, disc_rad: float, largest_m: float, unit: float = PRIMARY_UNIT
) -> AngleAxis:
    """Choose angles that resolve what drops up to a size show under a disc.

    Args:
        low: first scattering angle, rad.
        high: last scattering angle, rad.
        disc_rad: angular radius of the smallest disc, rad.
        largest_m: greatest drop radius, m.
        unit: of Airy's argument, of drops that are not of water.
    """
    # At the violet end, where detail is finest.
    x = 2.0 * np.pi * largest_m / 380e-9
    finest = disc_rad / _PER_DISC
    even = max(math.hypot(finest, unit_angle(x, _EVEN_UNITS, unit)), (high - low) / _MOST_EVEN)
    ring = min(math.hypot(finest, _RING_UNITS / x), even)
    return AngleAxis(max(low, 0.0), min(high, np.pi), 1.0 / even, _PER_FOLD, _PER_FOLD * ring)


@dataclass(frozen=True)
class RadiusAxis:
    """Rows of radius, evenly in the logarithm; one row for one radius or one mixture.

    Attributes:
        radius_m: (R,).
        mixture: sizes that the single row stands for, if it is a mixture.
    """

    radius_m: Array
    mixture: Sizes | None

    @property
    def per_fold(self) -> float:
        """Rows per factor e."""
        if len(self.radius_m) == 1:
            return 0.0
        return float((len(self.radius_m) - 1) / np.log(self.radius_m[-1] / self.radius_m[0]))


def radius_axis(
    radii_um: tuple[float, float], mixture: Sizes | None, step: float = _ROW_STEP
) -> RadiusAxis:
    """Choose rows for drops between two radii, or for one mixture."""
    low, high = radii_um[0] * 1e-6, radii_um[1] * 1e-6
    if mixture is not None:
        return RadiusAxis(np.array([mixture.effective_radius_m]), mixture)
    if high <= low:
        return RadiusAxis(np.array([low]), None)
    return RadiusAxis(floats(np.geomspace(low, high, 2 + int(np.log(high / low) / step))), None)


def row_sections(sections: Sections, rows: RadiusAxis, theta: Array, disc_rad: float) -> Array:
    """Give the cross-sections of rows of radius at angles (U,), over the radius squared:
    perpendicular and parallel, sr⁻¹, (R, W, U, 2)."""
    if rows.mixture is not None:
        area = sections.mixed(rows.mixture, theta, disc_rad)[None]
    else:
        area = sections.sections(rows.radius_m, theta, disc_rad)
    return floats(area / rows.radius_m[:, None, None, None] ** 2)


@dataclass(frozen=True)
class SectionTable:
    """A scene's cross-sections.

    Attributes:
        angles: the axis of the columns.
        radii: the rows.
        scale: what stored values are to be multiplied with, besides the radius squared.
        values: float32 or float16 (layers, R, U, channels): a layer per disc and wavelength, in
            this order; channels are the mean of both components, or perpendicular and parallel,
            and then their running integrals over the angle, if any.
    """

    angles: AngleAxis
    radii: RadiusAxis
    scale: float
    values: NDArray[np.float32] | NDArray[np.float16]


def section_table(
    sections: Sections,
    wavelengths: int,
    angles: AngleAxis,
    radii_um: tuple[float, float],
    mixture: Sizes | None,
    discs_rad: tuple[float, ...],
    *,
    components: bool,
    running: bool,
) -> SectionTable:
    """Compute the table of a scene's cross-sections.

    Args:
        sections: the theory's cross-sections at W wavelengths.
        wavelengths: W.
        angles: the columns.
        radii_um: least and greatest radius.
        mixture: the sizes of drops that are mixed everywhere.
        discs_rad: angular radii of the lights' discs.
        components: both components apart, for a polariser.
        running: with running integrals over the angle, counted from the right angle.

    Raises:
        InputError: the table would not fit in memory.
    """
    theta = angles.angles()
    channels = (2 if components else 1) * (2 if running else 1)
    per_row = len(discs_rad) * wavelengths * len(theta) * channels
    radii = _rows_that_fit(radii_um, mixture, wavelengths, 4 * per_row)
    layers = np.empty(
        (len(discs_rad), wavelengths, len(radii.radius_m), len(theta), channels), np.float32
    )
    _fill(layers, sections, radii, theta, discs_rad, components=components, running=running)
    return _packed(angles, radii, layers.reshape(-1, *layers.shape[2:]), running=running)


def _rows_that_fit(
    radii_um: tuple[float, float], mixture: Sizes | None, wavelengths: int, row_bytes: int
) -> RadiusAxis:
    """Choose rows of radius, farther apart where memory asks for it.

    Raises:
        InputError: even then the table would take too much.
    """
    size = 0
    for step in (_ROW_STEP, _COARSE_ROW_STEP):
        radii = radius_axis(radii_um, mixture, step)
        size = row_bytes * len(radii.radius_m)
        if size <= _LARGEST_BYTES:
            return radii
    raise InputError(
        f"cross-sections of drops from {radii_um[0]:g} to {radii_um[1]:g} um at {wavelengths}"
        f" wavelengths would take {size / 2**20:.0f} MiB; must be at most"
        f" {_LARGEST_BYTES / 2**20:.0f}; use a larger render.wavelength_step_nm, a narrower"
        ' range of radii, or droplets.radius.mixing = "local"'
    )


def _fill(
    layers: Float32,
    sections: Sections,
    radii: RadiusAxis,
    theta: Array,
    discs_rad: tuple[float, ...],
    *,
    components: bool,
    running: bool,
) -> None:
    """Compute the values of a table in place: (discs, W, R, U, channels)."""
    for number, disc in enumerate(discs_rad):
        for start in range(0, len(radii.radius_m), _ROWS_AT_ONCE):
            part = slice(start, start + _ROWS_AT_ONCE)
            some = RadiusAxis(radii.radius_m[part], radii.mixture)
            both = row_sections(sections, some, theta, disc).transpose(1, 0, 2, 3)
            chosen = both if components else both.mean(axis=3, keepdims=True)
            if running:
                chosen = np.concatenate([chosen, _running(chosen, theta)], axis=3)
            layers[number, :, part] = chosen


def _packed(
    angles: AngleAxis, radii: RadiusAxis, layers: Float32, *, running: bool
) -> SectionTable:
    """Give the table of some layers, in half floats if it is large and holds no integrals."""
    if running or layers.nbytes <= _LARGEST_FLOAT32_BYTES:
        return SectionTable(angles, radii, 1.0, layers)
    scale = max(float(layers.max()) / _HALF_MAX, 1.0)
    return SectionTable(angles, radii, scale, (layers / scale).astype(np.float16))


def _running(values: Array, theta: Array) -> Array:
    """Running integrals over the last axis but one."""
    return floats(np.moveaxis(running_integral(np.moveaxis(values, 2, 3), theta), 3, 2))


def running_integral(values: Array, theta: Array) -> Array:
    """Give the integral over the angle, the last axis: from the right angle, so that the bows, on
    which it has to keep its digits, are not counted from the forward peak."""
    rise = 0.5 * (values[..., 1:] + values[..., :-1]) * np.diff(theta)
    running = np.concatenate([np.zeros_like(values[..., :1]), np.cumsum(rise, axis=-1)], axis=-1)
    middle = min(int(np.searchsorted(theta, 0.5 * np.pi)), len(theta) - 1)
    return floats(running - running[..., middle : middle + 1])
