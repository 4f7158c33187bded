"""Albedo spectra of the ground: by name, from a user's file, or one number."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.errors import InputError
from rtbow.base.resources import resource_dir
from rtbow.physics.constants import VISIBLE_NM
from rtbow.scene.air import ALBEDOS
from rtbow.scene.lights import spectrum_file
from rtbow.world.measured.read import read_spectrum
from rtbow.world.measured.source import file_state


@dataclass(frozen=True)
class Albedo:
    """Share of light that a ground sends back, linear between points and held beyond them.

    Attributes:
        wavelength_nm: points, increasing.
        value: 0 to 1 each.
    """

    wavelength_nm: tuple[float, ...]
    value: tuple[float, ...]

    def at(self, wavelength_nm: Array) -> Array:
        """Interpolate at wavelengths, nm, same shape."""
        return floats(np.interp(wavelength_nm, self.wavelength_nm, self.value))

    def means(self, wavelength_nm: Array, width_nm: float) -> Array:
        """Give means over intervals about wavelengths (W,), to 0.1 nm."""
        beside = width_nm * (np.arange(0.5, 10.0 * width_nm) / (10.0 * width_nm) - 0.5)
        return floats(self.at(wavelength_nm[:, None] + beside).mean(axis=1))


def load_albedo(albedo: float | str) -> Albedo:
    """Load an albedo.

    A file is read anew when its content has changed.

    Args:
        albedo: one number, a name, or a path, perhaps with the column behind it.

    Raises:
        InputError: unknown name, or a file that does not hold an albedo over 380-780 nm.
    """
    if not isinstance(albedo, str):
        return Albedo((550.0,), (float(albedo),))
    if albedo in ALBEDOS:
        return _named(albedo)
    path = spectrum_file(albedo)
    if not path:
        raise InputError(
            f"albedo {albedo[:60]!r} is not known. Allowed: a number 0..1,"
            f" {', '.join(ALBEDOS)}, or a path to a file of wavelengths and values, such as"
            " soil.csv; still water is ground.water = true"
        )
    return _measured(path, albedo[len(path) + 1 :], file_state(Path(path)))


@lru_cache(maxsize=8)
def _named(name: str) -> Albedo:
    # Opened here: given a path, NumPy asks for the current folder, which may be gone.
    with (resource_dir("data") / f"albedo-{name}.csv").open(encoding="utf-8") as file:
        nm, value = np.loadtxt(file, delimiter=",", skiprows=2, dtype=np.float64).T
    return Albedo(tuple(nm.tolist()), tuple(value.tolist()))


@lru_cache(maxsize=8)
def _measured(path: str, column: str, state: str) -> Albedo:
    """Read a file whose content has the digest ``state``."""
    measured = read_spectrum(Path(path), column, shares=True)
    nm, value = measured.spectrum.wavelength_nm, measured.spectrum.value
    (first, last), (low, high) = measured.range_nm, VISIBLE_NM
    if first > low or last < high:
        raise InputError(
            f"{path}: covers {first:g}-{last:g} nm; an albedo must reach {low:g}-{high:g} nm; add"
            " what is missing, or repeat the last value there"
        )
    most = int(value.argmax())
    if value[most] > 1.0:
        hint = "; divide percent by 100" if value[most] <= 100.0 else ""
        raise InputError(
            f"{path}: an albedo of {value[most]:g} at {nm[most]:g} nm; must be 0..1{hint}"
        )
    return Albedo(tuple(nm.tolist()), tuple(value.tolist()))
