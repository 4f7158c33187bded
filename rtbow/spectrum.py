"""Spectra of lights, and their exact integrals over wavelength bins."""

from __future__ import annotations

import csv
import difflib
import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.errors import CHECK_PATH, InputError
from rtbow.base.resources import resource_dir
from rtbow.colour import colour_matching
from rtbow.physics.constants import VISIBLE_NM
from rtbow.standards import illuminant_names, standard_arrays

E490 = "E490"
EQUAL_ENERGY = "equal-energy"
_EXPECTED = f"two or more lines wavelength_nm,value over {VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm"


@dataclass(frozen=True)
class Spectrum:
    """A spectrum, linear between its points and zero beyond them.

    Attributes:
        name: what the user calls it.
        wavelength_nm: points (n,), increasing.
        value: W m⁻² nm⁻¹ where absolute, else in any unit, (n,).
        absolute: whether ``value`` is the irradiance that the light gives.
    """

    name: str
    wavelength_nm: Array
    value: Array
    absolute: bool = False

    def integral(self, low_nm: float, high_nm: float) -> float:
        """Integrate exactly between two wavelengths."""
        return float(_product_integrals(self, np.array([low_nm, high_nm]), None)[0, 0])

    @property
    def visible(self) -> float:
        """Integral over 380-780 nm."""
        return self.integral(*VISIBLE_NM)

    def scaled(self, irradiance_w_m2: float) -> Spectrum:
        """Give the same shape with this integral over 380-780 nm."""
        factor = irradiance_w_m2 / self.visible
        return Spectrum(self.name, self.wavelength_nm, self.value * factor, absolute=True)


@dataclass(frozen=True)
class Bins:
    """Wavelengths of a spectral integral and the bins around them.

    Attributes:
        wavelength_nm: bin positions (n,), from 380 to 780 inclusive.
        edges_nm: bin edges (n + 1,); the first and last bins are half bins.
    """

    wavelength_nm: Array
    edges_nm: Array


def wavelength_bins(step_nm: float) -> Bins:
    """Lay bins of ``step_nm`` over 380-780 nm; the step divides the range evenly."""
    low, high = VISIBLE_NM
    count = round((high - low) / step_nm)
    nodes = np.linspace(low, high, count + 1)
    edges = np.concatenate([[low], 0.5 * (nodes[:-1] + nodes[1:]), [high]])
    return Bins(nodes, edges)


def _product_integrals(spectrum: Spectrum, edges_nm: Array, factors: Array | None) -> Array:
    """Integrate spectrum × factor over bins, exactly for piecewise linear tables.

    Args:
        spectrum: the spectrum.
        edges_nm: bin edges (n + 1,).
        factors: table (m, 1 + c) of wavelength and c factors, or None for a factor of 1.

    Returns:
        Integrals (n, c).
    """
    points = [edges_nm, spectrum.wavelength_nm]
    if factors is not None:
        points.append(factors[:, 0])
    cuts = np.unique(np.concatenate(points))
    cuts = cuts[(cuts >= edges_nm[0]) & (cuts <= edges_nm[-1])]
    middle = 0.5 * (cuts[:-1] + cuts[1:])

    def product(at: Array) -> Array:
        value = np.interp(at, spectrum.wavelength_nm, spectrum.value, left=0.0, right=0.0)
        if factors is None:
            return value[:, None]
        columns = [np.interp(at, factors[:, 0], factors[:, k]) for k in range(1, factors.shape[1])]
        return value[:, None] * np.stack(columns, axis=1)

    # The product of two linear pieces is a parabola: Simpson's rule is exact.
    ends = product(cuts)
    pieces = (ends[:-1] + 4.0 * product(middle) + ends[1:]) * (np.diff(cuts) / 6.0)[:, None]
    first = np.searchsorted(cuts, edges_nm[:-1])
    return np.add.reduceat(pieces, first, axis=0)


def colour_weights(spectrum: Spectrum, bins: Bins) -> Array:
    """Integrate spectrum × colour-matching functions over each bin.

    The product is integrated, not sampled: E-490 has structure at 1-2 nm and lamps have lines, and
    a quantity that is smooth over a bin then needs one sample there.

    Args:
        spectrum: irradiance, W m⁻² nm⁻¹.
        bins: the bins (n).

    Returns:
        Weights (n, 3) in lm/m²: times a radiance per irradiance [sr⁻¹], summed, they give X, Y, Z
        with Y in cd/m².
    """
    nm, xyz = colour_matching()
    return _product_integrals(spectrum, bins.edges_nm, np.column_stack([nm, xyz]))


def bin_means(spectrum: Spectrum, bins: Bins) -> Array:
    """Give the mean of a spectrum over each bin (n,), in the spectrum's own unit."""
    return floats(_product_integrals(spectrum, bins.edges_nm, None)[:, 0] / np.diff(bins.edges_nm))


def luminous(spectrum: Spectrum) -> float:
    """Integrate a spectrum with the luminosity function: lumen (per area, per sr …) from watts."""
    return float(colour_weights(spectrum, Bins(np.array([580.0]), np.array(VISIBLE_NM)))[0, 1])


def spectrum_names() -> list[str]:
    """List every spectrum known by name."""
    return [E490, EQUAL_ENERGY, *illuminant_names()]


@lru_cache(maxsize=64)
def load_spectrum(name_or_path: str) -> Spectrum:
    """Load a spectrum by name, or from a user's CSV file.

    Args:
        name_or_path: ``E490``, ``equal-energy``, a CIE name such as ``FL2``, or a path that ends
            in ``.csv``.

    Raises:
        InputError: unknown name (nearest named), or a file that does not hold a spectrum over
            380-780 nm.
    """
    if name_or_path == E490:
        table = np.loadtxt(
            resource_dir("data") / "astm_e490_00a.csv", delimiter=",", skiprows=4, dtype=np.float64
        )
        return Spectrum(E490, table[:, 0], table[:, 1], absolute=True)
    if name_or_path == EQUAL_ENERGY:
        return Spectrum(EQUAL_ENERGY, np.array(VISIBLE_NM), np.ones(2))
    if name_or_path.lower().endswith(".csv"):
        return _read_csv(Path(name_or_path))
    table_or_none = standard_arrays().get(f"illuminant:{name_or_path}")
    if table_or_none is None:
        names = spectrum_names()
        folded = {n.lower(): n for n in names}
        near = difflib.get_close_matches(name_or_path.lower(), list(folded), n=3, cutoff=0.4)
        hint = ", ".join(folded[n] for n in near) or f"{E490}, {EQUAL_ENERGY}, FL2, HP1, LED-B3"
        raise InputError(
            f"spectrum {name_or_path!r} is not known; did you mean {hint}? Allowed: {E490}, "
            f"{EQUAL_ENERGY}, a CIE illuminant's name, or a path to a .csv file"
        )
    return Spectrum(name_or_path, table_or_none[0], table_or_none[1])


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _read_csv(path: Path) -> Spectrum:
    """Read ``wavelength_nm,value`` lines; one header line and ``#`` comments are allowed."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [(n, row) for n, row in enumerate(csv.reader(file), 1)]
    except FileNotFoundError:
        raise InputError(
            f"{path}: spectrum file not found; {CHECK_PATH}; must hold {_EXPECTED}; or name"
            f" {E490}, {EQUAL_ENERGY} or a CIE illuminant such as FL2"
        ) from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            f"{path}: cannot be read as a CSV spectrum ({error}); must hold {_EXPECTED}"
        ) from None

    points: list[tuple[float, float]] = []
    header_allowed = True
    for line, row in rows:
        if not row or not "".join(row).strip() or row[0].lstrip().startswith("#"):
            continue
        numbers = [_number(cell) for cell in row]
        if header_allowed and not points and numbers[0] is None:
            header_allowed = False
            continue
        if len(row) != 2 or numbers[0] is None or numbers[1] is None:
            raise InputError(
                f"{path}:{line}: expected two numbers wavelength_nm,value; got {','.join(row)!r}"
            )
        wavelength, value = numbers[0], numbers[1]
        if not (math.isfinite(wavelength) and math.isfinite(value)):
            raise InputError(f"{path}:{line}: NaN and infinity are not allowed")
        if value < 0.0:
            raise InputError(f"{path}:{line}: value {value:g} is negative; must be 0 or more")
        if points and wavelength <= points[-1][0]:
            raise InputError(
                f"{path}:{line}: wavelength {wavelength:g} nm does not follow {points[-1][0]:g} nm;"
                " sort the lines by increasing wavelength"
            )
        points.append((wavelength, value))
    if len(points) < 2:
        raise InputError(f"{path}: holds no spectrum; must hold {_EXPECTED}")
    if points[0][0] > VISIBLE_NM[0] or points[-1][0] < VISIBLE_NM[1]:
        raise InputError(
            f"{path}: covers {points[0][0]:g}-{points[-1][0]:g} nm; must reach"
            f" {VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm (add zeros where the light has nothing)"
        )
    table = np.array(points)
    spectrum = Spectrum(path.name, table[:, 0], table[:, 1])
    if spectrum.visible and not 1e-30 < spectrum.visible < 1e30:
        raise InputError(
            f"{path}: integrates to {spectrum.visible:.1e} over the visible; scale the values to"
            " between 1e-30 and 1e30 (a light's strength is set in the scene)"
        )
    if not spectrum.visible > 0.0:
        raise InputError(
            f"{path}: is zero over {VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm; give a light"
        )
    return spectrum
