"""Spectra by name or from a user's file."""

from __future__ import annotations

import difflib
import os
import re
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from rtbow.base.errors import InputError
from rtbow.base.resources import resource_dir
from rtbow.physics.constants import MOON_DISTANCE_KM, VISIBLE_NM
from rtbow.physics.light.cie import illuminant_description, illuminant_names, standard_arrays
from rtbow.physics.light.moon import moonlight
from rtbow.physics.light.spectrum import Spectrum
from rtbow.scene.lights import E490, EQUAL_ENERGY, MOON, Beyond, spectrum_file
from rtbow.world.measured.read import Measured, read_spectrum
from rtbow.world.measured.source import file_state

_VISIBLE = f"{VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm"
_EDGE_NM = 1e-6
"""How soon a spectrum falls to zero beyond its last point."""
_ROUNDING_NM = 0.05
"""What a range may lack at its ends, the finest step of a scene: numbers in cm⁻¹ are rounded."""


def spectrum_names() -> list[str]:
    """List every spectrum known by name."""
    return [E490, MOON, EQUAL_ENERGY, *illuminant_names()]


_OWN = {
    E490: "sunlight above the air (ASTM E-490), with its absolute strength",
    MOON: "the full Moon: sunlight times the Moon's reflectance",
    EQUAL_ENERGY: "the same power at every wavelength",
}


def spectrum_description(name: str) -> str:
    """Say what a spectrum known by name is; nothing where that is not known."""
    return _OWN.get(name) or illuminant_description(name)


def load_spectrum(name_or_path: str, beyond: Beyond | None = None) -> Spectrum:
    """Load a spectrum by name, or from a user's file.

    A file is read anew when its content has changed.

    Args:
        name_or_path: ``E490``, ``moon``, ``equal-energy``, a CIE name such as ``FL2``, or a path,
            perhaps with the column behind it, as in ``lamp.csv#3``.
        beyond: what a file that ends within 380-780 nm has there; None refuses it.

    Raises:
        InputError: unknown name, or a file that does not hold a spectrum over 380-780 nm.
    """
    if name_or_path in spectrum_names():
        return _named(name_or_path)
    return load_measured(name_or_path, beyond).spectrum


def load_measured(name_or_path: str, beyond: Beyond | None = None) -> Measured:
    """Load a spectrum from a user's file, with what was understood of the file.

    Args:
        name_or_path: a path, perhaps with the column behind it.
        beyond: as for :func:`load_spectrum`.

    Raises:
        InputError: as for :func:`load_spectrum`.
    """
    path = spectrum_file(name_or_path)
    if not path:
        if os.path.isdir(name_or_path):
            raise InputError(f"{name_or_path}: is a folder; name a spectrum's file in it")
        raise InputError(_unknown(name_or_path))
    column = name_or_path[len(path) + 1 :]
    return _measured(path, column, beyond, file_state(Path(path)))


def spectrum_notes(name_or_path: str, beyond: Beyond | None = None) -> tuple[str, ...]:
    """Give what is doubtful about a spectrum's file, and what was done about it.

    Raises:
        InputError: as for :func:`load_spectrum`.
    """
    if name_or_path in spectrum_names():
        return ()
    return load_measured(name_or_path, beyond).notes


@lru_cache(maxsize=64)
def _named(name: str) -> Spectrum:
    if name == E490:
        # Opened here: given a path, NumPy asks for the current folder, which may be gone.
        with (resource_dir("data") / "astm_e490_00a.csv").open(encoding="utf-8") as file:
            table = np.loadtxt(file, delimiter=",", skiprows=4, dtype=np.float64)
        return Spectrum(E490, table[:, 0], table[:, 1], absolute=True)
    if name == MOON:  # full, at its mean distance
        return moonlight(_named(E490), 0.0, MOON_DISTANCE_KM)
    if name == EQUAL_ENERGY:
        return Spectrum(EQUAL_ENERGY, np.array(VISIBLE_NM), np.ones(2))
    nm, values = standard_arrays()[f"illuminant:{name}"]
    return Spectrum(name, nm, values)


@lru_cache(maxsize=16)
def _measured(path: str, column: str, beyond: Beyond | None, state: str) -> Measured:
    """Read a file whose content has the digest ``state``."""
    measured = read_spectrum(Path(path), column)
    spectrum = _over_the_visible(path, measured, beyond)
    if spectrum.visible and not 1e-30 < spectrum.visible < 1e30:
        raise InputError(
            f"{path}: integrates to {spectrum.visible:.1e} over the visible; scale the values to"
            " between 1e-30 and 1e30 (a light's strength is set in the scene)"
        )
    if not spectrum.visible > 0.0:
        raise InputError(f"{path}: is zero over {_VISIBLE}; give a light")
    return replace(measured, spectrum=spectrum)


def _over_the_visible(path: str, measured: Measured, beyond: Beyond | None) -> Spectrum:
    """Give a spectrum from 380 to 780 nm, by what it is to have beyond its ends."""
    spectrum, (low, high) = measured.spectrum, VISIBLE_NM
    first, last = measured.range_nm
    if first <= low and last >= high:
        return spectrum
    if first <= low + _ROUNDING_NM and last >= high - _ROUNDING_NM:
        return _extended(spectrum, "hold")
    unit = "" if measured.abscissa == "nm" else f" (from {measured.abscissa})"
    covers = f"{path}: covers {first:g}-{last:g} nm{unit}; must reach {_VISIBLE}; "
    if last <= low or first >= high:
        raise InputError(f"{covers}give the spectrum of a light that is visible")
    if beyond is None:
        raise InputError(
            f'{covers}set the light\'s key (or option) beyond to "zero" (no light there) or "hold"'
            " (the last value goes on), or add what is missing"
        )
    return _extended(spectrum, beyond)


def _extended(spectrum: Spectrum, beyond: Beyond) -> Spectrum:
    """Give a spectrum with points up to 380 and 780 nm where it ends short of them."""
    (low, high), nm, values = VISIBLE_NM, spectrum.wavelength_nm, spectrum.value
    before: list[tuple[float, float]] = []
    after: list[tuple[float, float]] = []
    if nm[0] > low:
        zero = [(low, 0.0), (max(nm[0] - _EDGE_NM, low + 0.5 * (nm[0] - low)), 0.0)]
        before = [(low, float(values[0]))] if beyond == "hold" else zero
    if nm[-1] < high:
        zero = [(min(nm[-1] + _EDGE_NM, high - 0.5 * (high - nm[-1])), 0.0), (high, 0.0)]
        after = [(high, float(values[-1]))] if beyond == "hold" else zero
    return Spectrum(
        spectrum.name,
        np.concatenate([[x for x, _ in before], nm, [x for x, _ in after]]),
        np.concatenate([[y for _, y in before], values, [y for _, y in after]]),
    )


# --- Names that are not known ------------------------------------------------------------------

_OTHERS = {
    r"am ?0|sun|solar|sunlight|astm.?e.?490": f"sunlight above the air (AM0) is called {E490}",
    r"am ?[\d.]+[gd]?|astm.?g.?173": (
        f"sunlight at the ground is {E490} with [atmosphere] in the scene, or a file: ASTM G-173"
        " as NREL or pvlib give it"
    ),
    r"[\d.]+ ?k|cct.*|black.?body|planck.*": (
        "black bodies and colour temperatures have no names; give a file, or a CIE illuminant: A"
        " is one of 2856 K, D65 daylight of 6504 K"
    ),
    r"candle(?:light)?|flame|fire": (
        "candles, black bodies of about 1900 K, have no name; did you mean A (tungsten filament,"
        " 2856 K)?"
    ),
    r"neon|xenon|argon|krypton": "lamps of rare gases have no names; give a file",
    r"flat|white|constant|uniform|equal.*": f"a constant spectrum is called {EQUAL_ENERGY}",
    r"laser|mono.*|[\d.]+ ?nm": "single lines have no names; give a file",
}


_WORDS = {
    r"(?:high.?pressure.?)?(?:sodium|na|hps|son|street.?(?:lamp|light))": ("HP1", "HP2"),
    r"mercury|hg|hid|discharge": ("HP3", "FL2"),
    r"(?:high.?pressure.?)?metal.?halide|halide|mh|hmi": ("HP3", "HP4", "HP5"),
    r"(?:white.?|cold.?|cool.?)?leds?|led.?(?:cold|cool|white)": ("LED-B3", "LED-B5", "LED-V2"),
    r"warm.?(?:white.?)?leds?|led.?warm(?:.?white)?": ("LED-B1", "LED-V1", "LED-BH1"),
    r"rgb.?leds?|led.?rgb": ("LED-RGB1",),
    r"(?:compact.?)?fluorescent.*|fl|cfl|tube|tl": ("FL2", "FL11", "FL12"),
    r"tungsten.*|incandescent.*|filament|halogen|(?:light.?)?bulb|lamp": ("A",),
    r"(?:day|sky).?light|day|sky|overcast|noon": ("D65", "D50"),
    r"moon.?light|lunar|full.?moon": (MOON,),
}
"""Common words for lights, as patterns, and the names of such lights."""


def _words_meaning(name: str) -> str:
    """Give the names that a common word means, each with what it is; nothing for other words."""
    word = re.sub(r"(?i)[ _-]*(?:lamps?|lights?|bulbs?|vapou?r)$", "", name.strip())
    for typed in (name.strip(), word):
        for pattern, names in _WORDS.items():
            if re.fullmatch(pattern, typed, re.I):
                return " or ".join(f"{n} ({spectrum_description(n)})" for n in names)
    return ""


def _unknown(name: str) -> str:
    """Say that a name is not known, and what may be meant.

    Letters alone mislead: AM0 is no illuminant A, and 5800K no D50. Near are names of the same
    series, the letters before the first digit.
    """
    head = f"spectrum {name[:60]!r} is not known"
    allowed = (
        f"Allowed: {E490}, {EQUAL_ENERGY}, {MOON}, a CIE illuminant's name such as FL2, HP1 or"
        " LED-B3 (rtbow spectra lists them), or a path to a file, such as lamp.csv"
    )
    for pattern, what in _OTHERS.items():
        if re.fullmatch(pattern, name.strip(), re.I):
            return f"{head}; {what}{'' if what.endswith('?') else '.'} {allowed}"
    if meant := _words_meaning(name):
        return f"{head}; did you mean {meant}? {allowed}"
    plain = re.sub(r"(?i)^(?:cie|illuminant|std|standard)[ _-]*", "", name.strip())
    if numbered := re.fullmatch(r"[Ff](\d.*)", plain):
        plain = f"FL{numbered[1]}"
    folded = {known.lower(): known for known in spectrum_names()}
    series = _series(plain)
    same = [known for known in folded if _series(known) == series]
    near = difflib.get_close_matches(plain.lower(), same, n=3, cutoff=0.4)
    for exact in (re.sub(r"(?<=\d)[A-Za-z]+$", "", plain).lower(), plain.lower()):
        near = [exact] if exact in folded else near
    hint = f"; did you mean {', '.join(folded[n] for n in near)}?" if near else "."
    return f"{head}{hint} {allowed}"


def _series(name: str) -> str:
    return re.split(r"\d", name.lower())[0].strip(" -_")
