"""Formats that are no plain tables: IES TM-27, Sekonic, UPRtek, CGATS, and pairs with colons."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from rtbow.base.errors import InputError
from rtbow.world.measured.dialect import Dialect, is_comment
from rtbow.world.measured.source import EXPECTED, HEAD_BYTES, decoded, open_text, whole_text
from rtbow.world.measured.table import Table, numbers_table

_PLAIN = Dialect(" ", ".")
_NO_LIGHT = ("reflectance", "transmittance", "absorptance", "R-Factor", "T-Factor")


def other_format(path: Path) -> Table | None:
    """Read a file of a format with a reader of its own; None if it is of none of them.

    Raises:
        InputError: the file is not text, or is broken.
    """
    with open_text(path) as stream:
        head = decoded(stream.read(HEAD_BYTES))
    for format_, belongs, read in _FORMATS:
        if belongs(head):
            return read(path, format_)
    return None


def _is_xml(head: str) -> bool:
    return head.lstrip().startswith("<")


def _is_tm27(head: str) -> bool:
    return _is_xml(head) and "IESTM2714" in head.upper()


def _is_sekonic(head: str) -> bool:
    return re.search(r"(?m)^Spectral Data \d{3}\[nm\],", head) is not None


def _is_uprtek(head: str) -> bool:
    return re.search(r"(?m)^\d{3}nm\t", head) is not None


def _is_cgats(head: str) -> bool:
    return "BEGIN_DATA" in head and ("SPECTRAL_" in head or "BEGIN_DATA_FORMAT" in head)


_FIRST_PAIR = re.compile(
    r"[ \t]*[+-]?[\d.]+(?:[eE][+-]?\d+)?[ \t]*:[ \t]*[+-]?[\d.]+(?:[eE][+-]?\d+)?[ \t]*(?:[,;]|$)"
)


def _is_pairs(head: str) -> bool:
    lines = (line for line in head.splitlines() if line.strip() and not is_comment(line))
    return _FIRST_PAIR.match(next(lines, "")) is not None


def _library_table(path: Path, format_: str, reader: str, unit: str = "") -> Table:
    """Read a file with one of colour-science's readers.

    They raise what their parsers do on a damaged file: hence every exception is caught.

    Args:
        path: the file.
        format_: its format in words.
        reader: name of the library's class.
        unit: of the values; empty where the file names their quantity.
    """
    whole_text(path, f"is {format_}")  # its size, and that it is text
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import colour

            table: Any = getattr(colour, reader)(str(path)).read()
            nm = np.asarray(table.wavelengths, dtype=np.float64)
            values = np.asarray(table.values, dtype=np.float64)
            quantity = str(table.spectral_quantity or "relative")
    except Exception as error:
        raise InputError(
            f"{path}: cannot be read as {format_} ({type(error).__name__}); export it again, or"
            " as CSV with lines wavelength_nm,value"
        ) from None
    if quantity in _NO_LIGHT:
        raise InputError(f"{path}: holds a {quantity}, no light; give the spectrum of a light")
    unit = unit or _UNITS.get(quantity, "")
    return numbers_table(format_, nm, values[:, None], (quantity,), fixed=("nm", unit))


_UNITS = {
    "flux": "W nm-1",
    "irradiance": "W m-2 nm-1",
    "radiance": "W m-2 sr-1 nm-1",
    "intensity": "W sr-1 nm-1",
}


def _tm27(path: Path, format_: str) -> Table:
    return _library_table(path, format_, "SpectralDistribution_IESTM2714")


def _sekonic(path: Path, format_: str) -> Table:
    return _library_table(path, format_, "SpectralDistribution_Sekonic")


def _uprtek(path: Path, format_: str) -> Table:
    return _library_table(path, format_, "SpectralDistribution_UPRTek", "mW m-2 nm-1")


def _xml(path: Path, _: str) -> Table:
    raise InputError(f"{path}: is XML or HTML, but not IES TM-27 (.spdx); {EXPECTED}")


def _cgats(path: Path, format_: str) -> Table:
    """Read CGATS text as Argyll (.sp) and X-Rite write it: a set of values is a row."""
    text = whole_text(path, f"is {format_}")
    keys = dict(re.findall(r'(?m)^[ \t]*([A-Z][A-Z0-9_]+)[ \t]+"?([^"\s]+)"?[ \t]*$', text))
    kind = keys.get("MEAS_TYPE", "")
    if kind in ("REFLECTIVE", "TRANSMISSIVE", "REFLECTANCE", "TRANSMITTANCE"):
        raise InputError(
            f"{path}: holds a measurement of type {kind}, no light; give the spectrum of a light"
        )
    fields = _section(text, "DATA_FORMAT").split()
    sets = [line.split() for line in _section(text, "DATA").splitlines() if line.strip()]
    try:
        places, nm = _cgats_wavelengths(fields, keys)
        norm = float(keys.get("SPECTRAL_NORM", 1.0))
        values = np.array([[float(row[n]) for n in places] for row in sets], np.float64) / norm
    except (ValueError, IndexError, KeyError, OverflowError):
        raise InputError(
            f"{path}: is {format_} but lacks SPECTRAL_BANDS, SPECTRAL_START_NM, SPECTRAL_END_NM"
            " or values for each band; export it again, or as CSV"
        ) from None
    if not len(values):
        raise InputError(f"{path}: is {format_} without data; export it again, or as CSV")
    names = tuple(f"set {n}" for n in range(1, len(values) + 1))
    return numbers_table(format_, nm, values.T, names, fixed=("nm", _CGATS_UNITS.get(kind, "")))


_CGATS_UNITS = {"EMISSION": "mW m-2 nm-1", "AMBIENT": "mW m-2 nm-1"}


def _section(text: str, name: str) -> str:
    """Return what stands between the lines BEGIN_name and END_name; nothing without them."""
    begin = re.search(rf"(?m)^[ \t]*BEGIN_{name}[ \t]*$", text)
    if begin is None:
        return ""
    end = re.compile(rf"(?m)^[ \t]*END_{name}[ \t]*$").search(text, begin.end())
    return text[begin.end() : end.start()] if end else ""


def _cgats_wavelengths(
    fields: list[str], keys: dict[str, str]
) -> tuple[list[int], np.ndarray[Any, np.dtype[np.float64]]]:
    """Give the places of spectral values in a row, and their wavelengths."""
    named = [
        (n, float(found[1]))
        for n, field in enumerate(fields)
        if (found := re.fullmatch(r"(?i)(?:SPEC(?:TRAL)?_?)?(?:NM_?)?(\d{3,4}(?:\.\d+)?)", field))
    ]
    bands = int(float(keys["SPECTRAL_BANDS"])) if "SPECTRAL_BANDS" in keys else len(named)
    if not 2 <= bands <= 100_000:
        raise ValueError
    if "SPECTRAL_START_NM" in keys:
        nm = np.linspace(float(keys["SPECTRAL_START_NM"]), float(keys["SPECTRAL_END_NM"]), bands)
        # Argyll rounds the names of bands to whole nm, so that its range counts.
        return [n for n, _ in named] if len(named) == bands else list(range(bands)), nm
    return [n for n, _ in named], np.array([nm for _, nm in named])


def _pairs(path: Path, format_: str) -> Table:
    """Read pairs ``400:0.1, 410:0.2`` as Mitsuba takes them."""
    text = whole_text(path, f"is {format_}")
    nm: list[float | None] = []
    values: list[float | None] = []
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip() or is_comment(line):
            continue
        parts = line.replace(",", " ").replace(";", " ").replace(":", " : ").split()
        numbers = [_PLAIN.number(part) for part in (*parts[::3], *parts[2::3])]
        paired = len(parts) % 3 == 0 and all(colon == ":" for colon in parts[1::3])
        if not paired or None in numbers:
            raise InputError(f"{path}:{number}: expected pairs of numbers such as 400:0.1, 410:0.2")
        nm += numbers[: len(numbers) // 2]
        values += numbers[len(numbers) // 2 :]
    columns = np.array([nm, values], dtype=np.float64).T
    return numbers_table(format_, columns[:, 0], columns[:, 1:], ("value",))


_Format = tuple[str, Callable[[str], bool], Callable[[Path, str], Table]]
_FORMATS: tuple[_Format, ...] = (
    ("IES TM-27", _is_tm27, _tm27),
    ("XML", _is_xml, _xml),
    ("a Sekonic export", _is_sekonic, _sekonic),
    ("a UPRtek export", _is_uprtek, _uprtek),
    ("CGATS (Argyll, X-Rite)", _is_cgats, _cgats),
    ("pairs wavelength:value (Mitsuba)", _is_pairs, _pairs),
)
