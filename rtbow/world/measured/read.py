"""A spectrum from a user's file: columns chosen, units converted, and doubts told or refused."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.light.spectrum import Spectrum
from rtbow.world.measured.formats import other_format
from rtbow.world.measured.points import FINE_NM, NOISE, Points
from rtbow.world.measured.source import EXPECTED, quoted
from rtbow.world.measured.table import Block, Table, UnevenError, careful_table, quick_table
from rtbow.world.measured.units import (
    ABSCISSA_NAME,
    LENGTHS_NM,
    RECIPROCALS_NM,
    UnitError,
    ValueUnit,
    abscissa_unit,
    to_nm,
    unit_in_prose,
    value_unit,
)

_VISIBLE = f"{VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm"
_NAME_THE_UNIT = "name its unit in the header, such as {},value"
_UNCERTAINTY = re.compile(r"uncert|std|dev\b|deviation|error|sigma|±", re.I)
_SUSPECTS = {"wavelength_um": "µm", "wavelength_angstrom": "Å", "wavenumber_cm-1": "cm⁻¹"}
"""Names of a column, and the unit that each of them says."""


@dataclass(frozen=True)
class Measured:
    """A spectrum from a file, and what was understood of the file.

    Attributes:
        spectrum: in nm; values as they are per nm, in W where the file says so.
        format: the file's format in words.
        column: what the column of values is called; may be empty.
        abscissa: unit of the abscissa in the file.
        stated: whether it is named with its column, or by the format.
        unit: of the values.
        count: points in the file.
        steps_nm: least and greatest distance of neighbours.
        range_nm: of the file.
        notes: what was doubtful, and what was done about it.
    """

    spectrum: Spectrum
    format: str
    column: str
    abscissa: str
    stated: bool
    unit: ValueUnit
    count: int
    steps_nm: tuple[float, float]
    range_nm: tuple[float, float]
    notes: tuple[str, ...]


class _Columns(NamedTuple):
    """Which columns are meant, and what they are.

    Attributes:
        abscissa: number of its column, from 0.
        value: number of the column of values.
        unit: of the abscissa.
        stated: whether it is named with its column, or by the format.
        value_unit: of the values.
        name: of the column of values.
    """

    abscissa: int
    value: int
    unit: str
    stated: bool
    value_unit: ValueUnit
    name: str


def read_spectrum(path: Path, column: str = "", *, shares: bool = False) -> Measured:
    """Read a spectrum from a file.

    Args:
        path: the file.
        column: name or number, from 1, of the column of values; empty where there is but one.
        shares: whether values are shares of light, as a reflectance's, not a light's power.

    Raises:
        InputError: the file holds no spectrum of a light, or it is not clear which.
    """
    table = other_format(path) or quick_table(path)
    if table is not None:
        try:
            return _read(path, table, column, shares=shares)
        except UnevenError:
            pass
    return _read(path, careful_table(path), column, shares=shares)


def _read(path: Path, table: Table, column: str, *, shares: bool) -> Measured:
    columns = _choose(path, table, column, shares=shares)
    points, counts = _gather(path, table, columns)
    if points.count < 2:
        raise InputError(f"{path}: holds no spectrum but a single point; give two or more")
    if columns.unit == "nm":
        _check_unit(path, points, counts, columns.stated)
    notes = _noise(path, points)
    if points.averaged:
        notes += (
            f"{path.name}: {points.count} points are averaged over {FINE_NM:g} nm; their integral"
            " is kept",
        )
    if columns.value_unit.quantity == "relative" and columns.unit in RECIPROCALS_NM:
        notes += (f"{path.name}: its values are taken as per {columns.unit}",)
    nm, values = points.result()
    name = f"{path.name}#{column}" if column else path.name
    return Measured(
        Spectrum(name, nm, values), table.format, columns.name, columns.unit,
        columns.stated, columns.value_unit, points.count, points.steps_nm,
        (points.lowest_nm, points.highest_nm), notes,
    )  # fmt: skip


_SHARES = ValueUnit("", "relative", None, False, "nm")
"""Of shares of light, which are what they are at whatever abscissa."""

# --- Columns -----------------------------------------------------------------------------------


def _choose(path: Path, table: Table, column: str, *, shares: bool) -> _Columns:
    names = table.names or ("",) * table.width
    units = table.units or ("",) * table.width
    abscissa = next((n for n, name in enumerate(names) if ABSCISSA_NAME.search(name)), 0)
    value = _value_column(path, table, names, abscissa, column)
    if table.fixed is not None:
        unit, given = table.fixed
        return _Columns(abscissa, value, unit, True, value_unit("", given, unit), names[value])
    try:
        named = abscissa_unit(names[abscissa], units[abscissa])
        unit = named or unit_in_prose(table.header) or "nm"
    except UnitError as error:
        raise InputError(
            f"{path}: its abscissa names {error}; must be a wavelength in nm, µm, Å or m, a"
            " wavenumber in 1/cm, a frequency in Hz or THz, or an energy in eV, named in the header"
        ) from None
    if shares:
        return _Columns(abscissa, value, unit, bool(named), _SHARES, names[value])
    try:
        of_values = value_unit(names[value], units[value], unit)
    except UnitError as error:
        raise InputError(
            f"{path}: column {value + 1} holds {error}; give values in proportion to power per"
            " wavelength, such as W m-2 nm-1"
        ) from None
    return _Columns(abscissa, value, unit, bool(named), of_values, names[value])


def _value_column(
    path: Path, table: Table, names: tuple[str, ...], abscissa: int, column: str
) -> int:
    others = [n for n in range(table.width) if n != abscissa]
    if column:
        found = _named_column(names, others, column)
        if found is None:
            raise InputError(
                f"{path}: has no single column {quoted(column)};"
                f" {_listed(path, table, names, others)}"
            )
        return found
    if len(others) > 1:
        numbers = next(table.read()).columns
        others = [n for n in others if np.isfinite(numbers[:, n]).any()]
        certain = [n for n in others if n > abscissa and not _UNCERTAINTY.search(names[n])]
        if len(certain) == 1:
            return certain[0]
        if _split_decimals(table, names, numbers):
            raise InputError(
                f"{path}: has three columns of whole numbers without a name, as a decimal comma"
                " makes of two where commas part the columns, too; write it with semicolons or"
                " points"
            )
        if not others:
            raise InputError(f"{path}: holds no column of values beside its abscissa; {EXPECTED}")
        raise InputError(
            f"{path}: has {len(others)} columns of values; {_listed(path, table, names, others)}"
        )
    return others[0]


def _split_decimals(table: Table, names: tuple[str, ...], numbers: Array) -> bool:
    """Whether columns may be one of values cut at its decimal comma."""
    if table.width != 3 or any(names) or len(numbers) < 3:
        return False
    whole = np.isfinite(numbers).all() and bool(np.all(numbers == np.round(numbers)))
    return bool(whole and np.ptp(numbers[:, 1]) <= 10.0 and numbers[:, 2].max() >= 10.0)


def _named_column(names: tuple[str, ...], others: list[int], column: str) -> int | None:
    wanted = column.strip().lower()
    if wanted.isdecimal() and len(wanted) < 6:  # as messages list them, whatever they are called
        return int(wanted) - 1 if int(wanted) - 1 in others else None
    for matches in (str.__eq__, str.startswith, str.__contains__):
        found = [n for n in others if names[n] and matches(names[n].lower(), wanted)]
        if found:
            return found[0] if len(found) == 1 else None
    return None


def _listed(path: Path, table: Table, names: tuple[str, ...], others: list[int]) -> str:
    """Say how to choose one of the columns; their names come to 40 characters at most."""
    # Two rows of numbers alone do not make a foreign file a table whose header may be shown.
    room = 40 if len(next(table.read()).lines) > 2 else 0
    shown = []
    for n in others:
        name = names[n][: max(room, 0)]
        room -= len(name)
        shown.append(f"{n + 1} {name!r}" if name else f"{n + 1}")
        if len(shown) == 8 and len(others) > 9:
            shown.append(f"... {others[-1] + 1}")
            break
    return f"choose one by number or name, as in {path.name}#{others[0] + 1}: {', '.join(shown)}"


# --- Rows --------------------------------------------------------------------------------------


def _gather(path: Path, table: Table, columns: _Columns) -> tuple[Points, dict[str, int]]:
    """Give the points, and how many are visible by each unit that their numbers may have."""
    points = Points()
    counts = dict.fromkeys(["nm", *_SUSPECTS], 0)
    last = None
    rising = True
    for block in table.read():
        numbers, values = block.columns[:, columns.abscissa], block.columns[:, columns.value]
        _check_finite(path, block, numbers, values, columns)
        if last is None and len(numbers) > 1:
            rising = bool(numbers[1] > numbers[0])
        _check_order(path, block, numbers, last, rising)
        last = float(numbers[-1])
        for name in counts:
            low, high = _visible_numbers(_SUSPECTS.get(name, name))
            counts[name] += int(np.count_nonzero((numbers >= low) & (numbers <= high)))
        nm = to_nm(numbers, columns.unit)
        with np.errstate(over="ignore"):
            power = columns.value_unit.per_nm(values, nm)
        if not (np.isfinite(power).all() and np.isfinite(nm).all()):
            raise InputError(f"{path}: has numbers beyond what can be converted to W per nm")
        points.add(nm, power, block.lines)
    return points, counts


def _visible_numbers(unit: str) -> tuple[float, float]:
    """Give the ends of the visible range as numbers of a unit."""
    low, high = VISIBLE_NM
    if unit in RECIPROCALS_NM:
        return RECIPROCALS_NM[unit] / high, RECIPROCALS_NM[unit] / low
    return low / LENGTHS_NM[unit], high / LENGTHS_NM[unit]


def _check_finite(
    path: Path, block: Block, numbers: Array, values: Array, columns: _Columns
) -> None:
    wrong = np.flatnonzero(~(np.isfinite(numbers) & np.isfinite(values)))
    if len(wrong):
        raise InputError(
            f"{path}:{block.lines[wrong[0]]}: NaN and infinity are not allowed, nor a cell without"
            " a number"
        )
    zero = columns.unit in RECIPROCALS_NM or columns.value_unit.photons
    wrong = np.flatnonzero(numbers <= 0.0 if zero else numbers < 0.0)
    if len(wrong):
        raise InputError(
            f"{path}:{block.lines[wrong[0]]}: {numbers[wrong[0]]:g} is no wavelength; must be over"
            " zero"
        )


def _check_order(
    path: Path, block: Block, numbers: Array, last: float | None, rising: bool
) -> None:
    steps = np.diff(numbers, prepend=[] if last is None else [last])
    wrong = np.flatnonzero(steps <= 0.0 if rising else steps >= 0.0)
    if not len(wrong):
        return
    at = int(wrong[0]) + (last is None)
    before = last if at == 0 else numbers[at - 1]
    raise InputError(
        f"{path}:{block.lines[at]}: {numbers[at]:g} does not follow {before:g} in"
        f" {'rising' if rising else 'falling'} order; sort the lines by wavelength, each once"
    )


# --- Doubts ------------------------------------------------------------------------------------


def _check_unit(path: Path, points: Points, counts: dict[str, int], stated: bool) -> None:
    """Refuse numbers that are taken for nm but look like something else.

    Where the column names no unit, the unit in which most of its points are visible is the likely
    one: E-490 in µm, 0.1195 to 1000, has most of its points between 0.38 and 0.78 and hardly any
    between 380 and 780. Frequencies in THz cannot be told from nm: 384 to 789 are visible, too.
    """
    suspects = list(_SUSPECTS)[: 1 if stated else None]  # a fine table in nm may go far beyond
    likely = max(suspects, key=lambda name: counts[name])
    if counts[likely] > counts["nm"]:
        raise InputError(
            f"{path}: its abscissa, {points.lowest_nm:g} to {points.highest_nm:g}, looks like"
            f" {_SUSPECTS[likely]}, not nm: {counts[likely]} of {points.count} points would be"
            f" visible, as nm {counts['nm']}; {_NAME_THE_UNIT.format(likely)}"
        )
    low, high = VISIBLE_NM
    if not stated and (points.highest_nm <= low or points.lowest_nm >= high):
        guess = "wavelength_m" if points.highest_nm < 1e-3 else "wavelength_um"
        raise InputError(
            f"{path}: its abscissa, {points.lowest_nm:g} to {points.highest_nm:g}, names no unit"
            f" and has nothing within {_VISIBLE}; {_NAME_THE_UNIT.format(guess)}"
        )


def _noise(path: Path, points: Points) -> tuple[str, ...]:
    if not points.negative:
        return ()
    share = -points.least / points.greatest if points.greatest > 0.0 else np.inf
    if share > NOISE:
        raise InputError(
            f"{path}:{points.least_line}: value {points.least:g} is negative; must be 0 or more, or"
            f" noise of at most {NOISE:g} of the greatest value"
        )
    return (
        f"{path.name}: {points.negative} of {points.count} values are below zero, by"
        f" {share:.2g} of the greatest at most, and are taken as zero",
    )
