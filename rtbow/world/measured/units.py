"""Units of spectra as files write them, and what they are in nm and W per nm.

An abscissa is a wavelength, or one over it (wavenumber, frequency, energy). Values are densities:
of power or photons, per interval of wavelength, wavenumber, frequency or energy. A density per
interval of x = K/λ is one per nm by |dx/dλ| = K/λ². Wavelengths in vacuum and in air are not told
apart: they differ by 0.03 %.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from rtbow.base.arrays import Array
from rtbow.physics.constants import (
    AVOGADRO_PER_MOL,
    ELEMENTARY_CHARGE_C,
    PLANCK_J_S,
    SPEED_OF_LIGHT_M_PER_S,
)

_HC_J_NM = PLANCK_J_S * SPEED_OF_LIGHT_M_PER_S * 1e9

LENGTHS_NM = {"nm": 1.0, "µm": 1e3, "Å": 0.1, "pm": 1e-3, "mm": 1e6, "cm": 1e7, "m": 1e9}
RECIPROCALS_NM = {
    "cm⁻¹": 1e7,
    "m⁻¹": 1e9,
    "Hz": SPEED_OF_LIGHT_M_PER_S * 1e9,
    "MHz": SPEED_OF_LIGHT_M_PER_S * 1e3,
    "GHz": SPEED_OF_LIGHT_M_PER_S,
    "THz": SPEED_OF_LIGHT_M_PER_S * 1e-3,
    "eV": _HC_J_NM / ELEMENTARY_CHARGE_C,
}
"""K of each unit: the wavelength in nm is K over the number."""

ABSCISSA_UNITS = (*LENGTHS_NM, *RECIPROCALS_NM)

_SPELLINGS = {
    r"nm|nanomet(?:er|re)s?": "nm",
    r"um|mum|microns?|micromet(?:er|re)s?": "µm",
    r"å|ang|angstroe?ms?|ångströms?": "Å",
    r"pm|picomet(?:er|re)s?": "pm",
    r"mm|millimet(?:er|re)s?": "mm",
    r"cm-1|1/cm|cm\^-1|kaysers?": "cm⁻¹",
    r"m-1|1/m": "m⁻¹",
    r"m|met(?:er|re)s?": "m",
    r"cm|centimet(?:er|re)s?": "cm",
    r"hz|hertz": "Hz",
    r"mhz": "MHz",
    r"ghz": "GHz",
    r"thz|terahertz": "THz",
    r"ev|electron[ -]?volts?": "eV",
}
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−–·×∙*⋅", "-0123456789--     ")
_KINDS = re.compile(
    r"wave[ _-]?len|wave[ _-]?num|wvlg|lambda|λ|wellenl|longitud d|longueur d", re.I
)
ABSCISSA_NAME = re.compile(r"wave|wvl|lambda|λ|wellenl|^\W*nm\W*$|^wl\b", re.I)
"""What columns of wavelengths are called."""
_NEUTRAL = {"air", "vac", "vacuum", "lambda", "λ", "x", "in air", "in vacuum", "w", "wl", "l"}
_NOT_SPECTRAL = re.compile(r"\b(pixels?|channels?|time|index|angle)\b", re.I)
_FREQUENCY = re.compile(r"frequen|wave ?number|wellenzahl|photon energy|\benergy\b", re.I)
_BRACKETED = re.compile(r"[\[(]\s*(.*?)\s*[\])]\s*$")


_LONGEST_PROSE = 500


class UnitError(ValueError):
    """A unit that cannot be converted; the message says which."""


def _plain(text: str) -> str:
    """Return a unit's text in plain signs: micro as u, superscripts as digits."""
    text = text.translate(_SUPERSCRIPTS).replace("µ", "u").replace("μ", "u")
    return text.replace("\\mu", "u").replace("Å", "Å").replace("$", "").strip()


def length_or_reciprocal(text: str) -> str:
    """Return the abscissa's unit that a text is, or nothing."""
    plain = re.sub(r"\s+", " ", _plain(text)).strip()
    if plain == "A":
        return "Å"
    plain = plain.lower().replace("^", "").strip("()[]")
    plain = re.sub(r"\s*-\s*1$", "-1", plain)
    for spelling, unit in _SPELLINGS.items():
        if re.fullmatch(spelling, plain):
            return unit
    return ""


def abscissa_unit(name: str, unit: str = "") -> str:
    """Find the unit that a column of the abscissa is named with; empty if it names none.

    Args:
        name: of the column.
        unit: from a row of units, or empty.

    Raises:
        UnitError: a unit that cannot be converted, or a quantity that is no wavelength.
    """
    if unit.strip():
        text = (_BRACKETED.sub(r"\1", unit)).strip()
        return _known(text)
    if bracket := _BRACKETED.search(name):
        return "" if bracket[1].lower() in _NEUTRAL | {""} else _known(bracket[1])
    if whole := length_or_reciprocal(name):
        return whole
    plain = _plain(name)
    if re.search(r"[^\W\d_]\s*/", plain):  # λ / nm
        return _known(plain.rpartition("/")[2])
    words = re.split(r"[\s,_]+", plain)
    if len(words) > 1 and (
        found := next((u for w in words[1:] if (u := length_or_reciprocal(w))), "")
    ):
        return found
    if stuck := re.fullmatch(r"(?:wavelength|lambda|wl)(nm|um|microns?|angstroms?)", plain.lower()):
        return length_or_reciprocal(stuck[1])
    if _NOT_SPECTRAL.search(name):
        raise UnitError(f"{_NOT_SPECTRAL.search(name)[0].lower()}, no wavelength")  # type: ignore[index]
    if _FREQUENCY.search(name):
        if "number" in name.lower() or "zahl" in name.lower():
            return "cm⁻¹"
        raise UnitError("a frequency or energy without its unit")
    return ""


def _known(text: str) -> str:
    unit = length_or_reciprocal(text)
    if not unit:
        raise UnitError("a unit that is not known")
    return unit


def unit_in_prose(lines: tuple[str, ...]) -> str:
    """Find the abscissa's unit where a header speaks of wavelengths; empty if it names none.

    Raises:
        UnitError: several units.
    """
    found: set[str] = set()
    for line in lines:
        plain = _plain(line[:_LONGEST_PROSE])
        if not _KINDS.search(plain):
            continue
        # Not what values are per: W/m2/um, um-1, per um.
        plain = re.sub(r"(?:/|per )\s*\w+|\b(?!c?m-1)[a-zA-Z]+\s*\^?-\s*\d", " ", plain)
        for word in re.split(r"[\s,;:=()\[\]_\"]+|\d(?=[nµu]m\b)", plain):
            unit = length_or_reciprocal(word) if len(word) > 1 else ""
            if unit and unit not in ("m", "cm"):
                found.add(unit)
    if len(found) > 1:
        raise UnitError(f"several units ({', '.join(sorted(found))})")
    return next(iter(found), "")


def to_nm(numbers: Array, unit: str) -> Array:
    """Convert an abscissa (n,) to nm; numbers over zero."""
    if unit in LENGTHS_NM:
        return numbers * LENGTHS_NM[unit]
    return RECIPROCALS_NM[unit] / numbers


# --- Values ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ValueUnit:
    """What values are.

    Attributes:
        text: their unit in words.
        quantity: ``irradiance``, ``flux``, ``radiance``, ``intensity`` or ``relative``.
        scale: of the unit without its spectral interval, in W, W/m², W/(m² sr) or W/sr, of photons
            in those per J; None where it is relative.
        photons: whether photons are counted.
        per: the interval of the density, a unit of an abscissa.
    """

    text: str
    quantity: str
    scale: float | None
    photons: bool
    per: str

    def per_nm(self, values: Array, nm: Array) -> Array:
        """Convert values (n,) at wavelengths (n,) to a density of power per nm."""
        result = values * (self.scale or 1.0)
        if self.photons:
            result = result * (_HC_J_NM / nm)
        if self.per in LENGTHS_NM:
            return result / LENGTHS_NM[self.per]
        return result * (RECIPROCALS_NM[self.per] / nm**2)


_PREFIXES = {"": 1.0, "k": 1e3, "d": 0.1, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12}
_POWER = re.compile(r"(k|m|u|n|p)?(?:W|w|[Ww]atts?)")
_AREAS = {"m": 1.0, "cm": 1e4, "mm": 1e6, "um": 1e12, "ft": 1.0 / 0.3048**2}
_FACTOR = re.compile(r"([a-zA-ZÅåΩ%]+)\^?\{?([+-]?\d+)?\}?")
_RELATIVE = re.compile(
    r"^(?:a\.?\s?u\.?|arb\.?.*|rel\.?.*|%|counts?.*|norm.*|1|-|none|dimensionless|v|volts?)?$", re.I
)
_LOGARITHM = re.compile(r"\b(?:db[mw]?|log(?:10)?|ln)\b", re.I)
_NO_LIGHT = re.compile(r"absorba|absorptan|transmi|reflecta|optical.?density", re.I)
_QUANTITIES = {(2, 0): "irradiance", (2, 1): "radiance", (0, 1): "intensity", (0, 0): "flux"}


_OF_POWER = re.compile(r"\b[munkµ]?W\b|\bwatts?\b|\bphotons?\b|/\s*(?:nm|[µu]m|Hz|eV|cm)\b", re.I)
"""Names of power, or of an interval that it is per: a text with one of them is meant as a unit."""


def value_unit(name: str, unit: str, abscissa: str) -> ValueUnit:
    """Find what a column of values is.

    A density without an interval of its own is one per unit of the abscissa.

    Args:
        name: of the column.
        unit: from a row of units, or empty.
        abscissa: its unit.

    Raises:
        UnitError: values that cannot be converted to power per wavelength.
    """
    if _LOGARITHM.search(f"{name} {unit}"):
        raise UnitError("logarithms or decibels")
    if _NO_LIGHT.search(name):
        raise UnitError("a property of matter, no light")
    default = abscissa if abscissa in RECIPROCALS_NM else "nm"
    marked, loose = _candidates(name, unit)
    for text in (*marked, *loose):
        factors = _factors(text)
        if factors is None and text in marked and _OF_POWER.search(text):
            raise UnitError("a unit that is not understood")
        try:
            found = _understood(text, factors or {}, abscissa)
        except UnitError:
            if text in marked:
                raise
            continue  # a name that happens to look like a unit
        if found:
            return found
    bracket = _BRACKETED.search(name)
    text = unit or (bracket[1] if bracket else "")
    known = "relative" if _RELATIVE.match(text.strip("[]() ")) else "unit not known, as relative"
    return ValueUnit(known, "relative", None, False, default)


def _candidates(name: str, unit: str) -> tuple[list[str], list[str]]:
    """Give texts that are to be a unit, and parts of a name that may be one."""
    if unit:
        return [_BRACKETED.sub(r"\1", unit)], []
    words = name.split()
    if len(words) == 1 and "/" in name and "(" not in name and "[" not in name:
        return [name], [_snake(name)]
    loose = [*(" ".join(words[n:]) for n in range(len(words))), _snake(name)]
    opening = [name.find(sign) for sign in "[(" if sign in name]
    if not opening or not name.rstrip().endswith(("]", ")")):
        return [], loose
    # Of "Power [W m-2 (cm-1)-1]" what the first bracket opens, the last one closes.
    return [name.rstrip()[min(opening) + 1 : -1]], loose


def _snake(name: str) -> str:
    """Return the unit at the end of a name such as ``irradiance_w_m2_nm``."""
    found = re.search(
        r"(?:^|_)([kmun]?w)((?:_(?:per_)?(?:m2|cm2|sr|nm|um|thz|hz|cm))*)$", name.lower()
    )
    if not found:
        return ""
    return found[1] + "".join(
        f"/{part}" for part in found[2].replace("_per", "").split("_") if part
    )


def _factors(text: str) -> dict[str, int] | None:
    """Read a product of units with exponents, such as ``mW/(m2 nm)``; None if it is none."""
    text = re.sub(r"\bper\b", "/", _plain(text.replace("**", "^")))
    text = re.sub(r"\s*\^\s*", "^", text)
    if not re.fullmatch(r"[\w\s/^().{}+\-Å%\[\]]+", text) or len(text) > 60:
        return None
    factors: dict[str, int] = {}
    try:
        rest = _product(text.replace("[", "(").replace("]", ")"), 1, factors)
    except (ValueError, RecursionError):
        return None
    return None if rest.strip() else factors


def _product(text: str, sign: int, factors: dict[str, int]) -> str:
    """Take factors off a text up to a closing bracket, and give what follows."""
    following = sign
    while text := text.lstrip(" ."):
        if text.startswith(")"):
            return text
        if text.startswith("/"):
            following, text = -sign, text[1:]
            continue
        if text.startswith("("):
            inner: dict[str, int] = {}
            text = _product(text[1:], 1, inner)
            if not text.startswith(")"):
                raise ValueError
            power = re.match(r"\^?\{?([+-]?\d+)\}?", text[1:])
            text = text[1 + (power.end() if power else 0) :]
            times = following * (int(power[1]) if power else 1)
            for unit, exponent in inner.items():
                factors[unit] = factors.get(unit, 0) + times * exponent
        elif text.startswith("1") and not text[1:2].isdigit():
            text = text[1:]
        else:
            found = _FACTOR.match(text)
            if not found:
                raise ValueError
            unit = "cm⁻¹" if found[0] in ("cm-1", "cm^-1") and following < 0 else found[1]
            exponent = 1 if unit == "cm⁻¹" else int(found[2] or 1)
            factors[unit] = factors.get(unit, 0) + following * exponent
            text = text[found.end() :]
        following = sign
    return text


def _understood(text: str, factors: dict[str, int], abscissa: str) -> ValueUnit | None:
    """Make sense of factors; None if there is no power or count of photons among them."""
    scale, photons = 0.0, False
    left = dict(factors)
    for unit, exponent in factors.items():
        if exponent == 1 and (power := _POWER.fullmatch(unit)):
            scale = _PREFIXES[power[1] or ""]
        elif exponent == 1 and (kind := re.fullmatch(r"(k|m|u|n)?(mol|einsteins?)", unit)):
            scale, photons = _PREFIXES[kind[1] or ""] * AVOGADRO_PER_MOL, True
        elif exponent == 1 and re.fullmatch(r"(?:photons?|quanta|ph|phot)", unit, re.I):
            scale, photons = 1.0, True
        elif exponent == 1 and unit in ("erg", "ergs", "J", "mJ") and len(factors) > 1:
            scale = {"J": 1.0, "mJ": 1e-3}.get(unit, 1e-7)
        elif exponent == 1 and unit.lower() in ("jy", "jansky"):
            return ValueUnit(text.strip(), "irradiance", 1e-26, False, "Hz")
        elif exponent == 1 and unit.lower() in ("lm", "lux", "lx", "cd"):
            raise UnitError("light weighted for the eye, not power")
        else:
            continue
        del left[unit]
        break
    if not scale:
        return None
    return _density(text, left, scale, photons, abscissa)


def _density(
    text: str, left: dict[str, int], scale: float, photons: bool, abscissa: str
) -> ValueUnit:
    """Sort area, solid angle and spectral interval out of the factors of a density."""
    area, angle = 0, 0
    per = ""
    for unit, exponent in sorted(left.items(), key=lambda item: item[1]):
        spectral = "cm⁻¹" if unit == "cm⁻¹" else length_or_reciprocal(unit)
        if exponent == 0 or (unit in ("s", "sec") and exponent == -1):
            continue
        if exponent == -2 and unit.lower() in _AREAS:
            area, scale = 2, scale * _AREAS[unit.lower()]
        elif unit.lower() in ("sr", "ster", "steradian") and exponent == -1:
            angle = 1
        elif exponent == -3 and unit in ("m", "cm"):
            area, scale, per = 2, scale * _AREAS[unit], unit
        elif exponent == -1 and spectral and not per:
            per = spectral
        elif exponent == 1 and unit in ("cm", "m") and not per:
            per = f"{unit}⁻¹"
        else:
            raise UnitError("a unit that cannot be converted to power per wavelength")
    if per == "cm" and abscissa == "cm⁻¹":
        raise UnitError("a density of which it is unclear whether it is per cm or per cm⁻¹")
    quantity = _QUANTITIES[area, angle]
    own = abscissa if abscissa in ABSCISSA_UNITS else "nm"
    return ValueUnit(text.strip(), quantity, scale, photons, per or own)
