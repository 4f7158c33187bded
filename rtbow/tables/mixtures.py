"""Cross-sections of drops of mixed sizes: one table for all scattering angles, kept in the cache.

What a mixture scatters depends on theory, wavelengths, sizes and the light's disc, not on where
one looks from or how many drops there are. It is summed once, over all angles from forward to
backward, and each view looks its own angles up.

Nothing here needs compiled code until a table is built: a kept one is read in some 20 ms.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, Steps, floats, no_progress
from rtbow.base.cache import (
    Arrays,
    file_digest,
    forget_oldest,
    keep_arrays,
    kept_arrays,
    source_digest,
)
from rtbow.physics.drop.airy import SCALE_POWER, Bow, bow
from rtbow.physics.drop.medium import Medium
from rtbow.physics.sizes import Sizes, tabled_sizes
from rtbow.tables.layout import ascending_inverse
from rtbow.tables.mie.axes import COMPACT_FILE, pole_place

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections, Theory

_KEPT_FILES = 32
"""Files of mixtures in the cache, at most; one at 81 wavelengths takes 5 MB."""
_MOST_HELD = 2
"""Tables that a process holds, beside those on file."""

_STEP_UNITS = 0.08
"""Distance of angles at a bow in units of Airy's argument z for the largest drop. Within z = 10 the
fringes of that drop alone turn by 0.6 rad from one angle to the next, of which cubics leave 0.3 %;
those of a mixture are weaker."""
_EVEN_UNITS = 10.0
"""Extent of the fringes over which angles stay that dense, beyond the bows of all wavelengths."""
_BASE_RAD = float(np.radians(0.45))
"""Widest distance of angles."""
_PER_FORWARD_FOLD, _PER_BACKWARD_FOLD = 100.0, 50.0
"""Angles per factor e of the distance from a pole, as in the tables of single sizes."""


@dataclass(frozen=True)
class MixtureAxis:
    """Scattering angles for all wavelengths at once: dense about both bows and at the poles.

    Attributes:
        edge_rad: middle of each bow's angles over the wavelengths (2,).
        width_rad: distance from it within which angles are evenly dense (2,).
        per_fold: angles per factor e of the distance from it, beyond (2,).
    """

    edge_rad: Array
    width_rad: Array
    per_fold: Array

    def place(self, theta: Array) -> Array:
        """Place of scattering angles along the axis, 0 at the first."""
        # Each place where detail gathers has the density c / sqrt(w² + d²), and asinh for integral.
        place = theta / _BASE_RAD
        for edge, width, per_fold in zip(self.edge_rad, self.width_rad, self.per_fold, strict=True):
            start = np.arcsinh(-edge / width)
            place = place + per_fold * (np.arcsinh((theta - edge) / width) - start)
        backward = pole_place(floats(np.pi)) - pole_place(np.pi - theta)
        poles = _PER_FORWARD_FOLD * pole_place(theta) + _PER_BACKWARD_FOLD * backward
        return floats(place + poles)

    def angles(self) -> Array:
        """Angles at the places 0, 1, 2 … (T,), from 0 to the last whole one before pi, and pi."""
        end = float(self.place(floats(np.pi)))
        return ascending_inverse(self.place, np.arange(np.ceil(end) + 1.0), 0.0, np.pi)


def mixture_axis(wavelength_nm: Array, index: Array, largest_m: float) -> MixtureAxis:
    """Choose angles that resolve the bows of drops up to a size at some wavelengths."""
    both = [bow(k, floats(wavelength_nm) * 1e-9, index) for k in (1, 2)]
    unit = floats([_unit(b, largest_m) for b in both])
    half = floats([0.5 * np.ptp(b.angle_rad) for b in both])
    middle = floats([0.5 * (b.angle_rad.min() + b.angle_rad.max()) for b in both])
    width = half + _EVEN_UNITS * unit
    return MixtureAxis(middle, width, width / (_STEP_UNITS * unit))


def _unit(the_bow: Bow, radius_m: float) -> float:
    """The angle of one unit of Airy's argument at the violet end."""
    return float(1.0 / (the_bow.scale.max() * radius_m**SCALE_POWER))


@dataclass(frozen=True)
class MixtureTable:
    """What drops of mixed sizes scatter, under one disc, over all angles.

    Attributes:
        angles: scattering angles (T,), ascending from 0 to pi.
        values: |S1|²/k² and |S2|²/k², m² sr⁻¹, mean over the drops, (T, W, 2), float32.
    """

    angles: Array
    values: Float32

    def at(self, theta_rad: Array) -> Array:
        """Look up angles (U,): (W, U, 2)."""
        theta = floats(theta_rad)
        first = np.clip(np.searchsorted(self.angles, theta) - 2, 0, len(self.angles) - 4)
        # Lagrange's cubic through four neighbours at their own distances. In NumPy: loading the
        # compiled one of the tables of single sizes takes longer than all of this.
        nodes = np.stack([self.angles[first + k] for k in range(4)])
        out = np.zeros((len(theta), *self.values.shape[1:]))
        for k in range(4):
            weight = np.ones(len(theta))
            for j in range(4):
                if j != k:
                    weight *= (theta - nodes[j]) / (nodes[k] - nodes[j])
            out += weight[:, None, None] * self.values[first + k]
        return floats(out.transpose(1, 0, 2))


_held: dict[str, MixtureTable] = {}
"""The last tables that were given."""


@dataclass(frozen=True)
class KeptMixtures:
    """Cross-sections of mixtures by either theory (see :class:`rtbow.tables.sections.Sections`).

    Attributes:
        theory: ``airy`` or ``mie``.
        orders: internal reflections (airy; mie has all).
        medium: what the drops are made of.
        spread: standard deviation of ln(radius) about each size (mie).
        wavelength_nm: wavelengths in air (W,).
        progress: wraps the work where a table must be built.
    """

    theory: Theory
    orders: tuple[int, ...]
    medium: Medium
    spread: float
    wavelength_nm: Array
    progress: Progress = field(default=no_progress, compare=False)

    def sections(
        self, radius_m: Array, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give those of single sizes, (R, W, U, 2), which are not kept."""
        range_um = float(radius_m.min() * 1e6), float(radius_m.max() * 1e6)
        return self._single(range_um).sections(radius_m, theta_rad, disc_rad, elevation_rad)

    def mixed(
        self, sizes: Sizes, theta_rad: Array, disc_rad: float, elevation_rad: Array | None = None
    ) -> Array:
        """Give the mean over drops of several sizes, (W, U, 2), from a table of all angles."""
        return self.table(sizes, disc_rad).at(theta_rad)

    def table(self, sizes: Sizes, disc_rad: float) -> MixtureTable:
        """Give the table of a mixture under a disc: held, from the cache, or built.

        Raises:
            InputError: wavelengths or a temperature beyond the tables of exact theory.
        """
        key = self._key(sizes, disc_rad)
        if key not in _held:
            kept = kept_arrays("mixture", key)
            if kept is None:
                kept = self._built(sizes, disc_rad)
                if keep_arrays("mixture", key, kept):
                    forget_oldest("mixture", _KEPT_FILES)
            while len(_held) >= _MOST_HELD:
                _held.pop(next(iter(_held)), None)
            _held[key] = MixtureTable(kept["angles"], kept["values"])
        return _held[key]

    def _key(self, sizes: Sizes, disc_rad: float) -> str:
        """All that a table depends on. Sizes count in single precision: another number of the same
        drops leaves their shares alike but for the last digits."""
        exact = self.theory == "mie"
        shape = (floats(a).astype(np.float32).tobytes() for a in (sizes.radius_m, sizes.share))
        return repr(
            (
                source_digest("base.limits", "physics", "tables"), self.theory,
                (file_digest(COMPACT_FILE), self.spread) if exact
                else self.orders,
                self.wavelength_nm.tobytes(), self.medium.index(self.wavelength_nm).tobytes(),
                *shape, disc_rad,
            )
        )  # fmt: skip

    def _built(self, sizes: Sizes, disc_rad: float) -> Arrays:
        tabled = tabled_sizes(sizes) if self.theory == "mie" else sizes
        single = self._single(tabled.range_um)
        nm = self.wavelength_nm
        axis = mixture_axis(nm, self.medium.index(nm), float(tabled.edges_m[-1]))
        angles = axis.angles()
        values = np.empty(0)
        what = f"a mixture of {len(sizes.radius_m)} sizes of drops at {len(nm)} wavelengths"
        for _ in self.progress(Steps(1, what)):
            values = single.mixed(sizes, angles, 0.0).transpose(1, 0, 2)
            if disc_rad > 0.0:
                values = _under_disc(values, axis, angles, disc_rad)
        return {"angles": angles, "values": np.ascontiguousarray(values, np.float32)}

    def _single(self, range_um: tuple[float, float]) -> Sections:
        # Imported here, with the compiler of what is summed on the CPU.
        from rtbow.tables.sections import drop_sections

        return drop_sections(
            self.theory, self.wavelength_nm, self.medium, range_um,
            orders=self.orders, spread=self.spread, progress=self.progress,
        )  # fmt: skip


def _under_disc(values: Array, axis: MixtureAxis, angles: Array, disc_rad: float) -> Array:
    """Average a table (T, W, 2) over a disc about each of its angles."""
    from rtbow.tables.mie.lookup import disc_grid, resample

    nodes, weights = disc_grid(angles, disc_rad)
    columns = np.ascontiguousarray(values.reshape(len(values), -1))
    return resample(columns, axis.place(nodes), weights).reshape(values.shape)
