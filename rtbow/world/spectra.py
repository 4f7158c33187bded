"""Spectra by name or from a user's file."""

from __future__ import annotations

import csv
import difflib
import math
from functools import lru_cache
from pathlib import Path

import numpy as np

from rtbow.base.errors import CHECK_PATH, InputError
from rtbow.base.resources import resource_dir
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.light.cie import illuminant_names, standard_arrays
from rtbow.physics.light.spectrum import Spectrum

E490 = "E490"
EQUAL_ENERGY = "equal-energy"
_EXPECTED = f"two or more lines wavelength_nm,value over {VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm"


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
