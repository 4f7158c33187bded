"""The air's own light against other programs, measured skies, and itself."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import FOLDER_VARIABLE
from rtbow.tables.sky import field

# Of the tests, whose folder the command line puts on the path.
from skies import aerosol, clear, measured, molecules, tables  # type: ignore[import-not-found]
from skies.check import rms, worst  # type: ignore[import-not-found]
from sky_error.row import Row, Rows, rows_of


def molecular() -> Rows:
    """All orders of molecules."""
    yield from rows_of(molecules.published())
    yield from rows_of(molecules.published_at_the_horizon())
    yield from rows_of(molecules.published_of_a_low_sun())
    yield from rows_of(molecules.published_below())


def polarised() -> Rows:
    """The degree of polarisation of molecules' light."""
    yield from rows_of(molecules.published_polarisation(), "")


def single() -> Rows:
    """One scattering."""
    yield from rows_of(molecules.published_single())
    for ray in molecules.RAYS:
        yield from rows_of(molecules.single_along(ray))
    for number in aerosol.SINGLE_SETTINGS:
        yield from rows_of(aerosol.single(number))


def haze() -> Rows:
    """Ten settings with aerosol, ozone and ground."""
    for check in aerosol.published(*aerosol.SETTINGS):
        yield from rows_of([check], "" if "absolute" in check.what else "%")


def sky_measured(fitted: str | None) -> Rows:
    """Skies that were measured.

    Args:
        fitted: the aerosol to fit anew, beside that which is kept; None fits none.
    """
    for day in measured.DAYS:
        yield from rows_of(measured.checks(day))
        yield from _left(f"{day.name}, one scattering", measured.deviations(day, single=True))
        yield from _numbers(f"{day.name}, as kept", day.aerosol)
    if fitted is None:
        return
    for alone in (False, True):
        orders = "one scattering" if alone else "all orders"
        for day, deviations in measured.fitted(fitted, single=alone):
            what = f"{day.name}, {fitted} fitted, {orders}"
            yield from _left(what, deviations)
            yield from _numbers(what, day.aerosol)


def _left(what: str, deviations: Array) -> Rows:
    yield Row(f"{what}: rms", rms(deviations))
    yield Row(f"{what}: mean", float(np.mean(deviations)))


def _numbers(what: str, found: measured.Aerosol) -> Rows:
    yield Row(f"{what}: depth at 1 µm", found.beta, unit="")
    yield Row(f"{what}: Angstrom's exponent", found.alpha, unit="")
    yield Row(f"{what}: azimuths are turned by", found.turned_deg, unit="°")


def energy() -> Rows:
    """Light that comes in and neither arrives at the ground nor leaves."""
    for sun in (90.0, 40.0, 20.0, 15.0):
        yield from rows_of(molecules.conserved(sun))
    yield from rows_of(aerosol.conserved())


def clear_fields() -> Rows:
    """Fields of clear air that come with the program."""
    for case in clear.CASES:
        yield from rows_of(clear.fields(case))
    yield from rows_of(clear.one_index())


def single_rays() -> Rows:
    """The shader's tables, ray by ray."""
    for seen in (tables.NEAR, tables.HIGH):
        yield from rows_of(tables.along_rays(seen))


_RAYS = tuple(
    (altitude, azimuth) for altitude in (3.0, 20.0, 60.0) for azimuth in (0.0, 80.0, 180.0)
)
_DAY_DEG, _DUSK_DEG = (60.0, 20.0, 10.0, 5.0, 3.0), (1.0, 0.0, -1.0, -2.0, -3.0, -4.0)


def nodes() -> Rows:
    """A molecular sky solved with twice as many of everything, one after the other."""
    own = _skies(_DAY_DEG)
    finer: dict[str, dict[str, object]] = {
        "heights": {"_HEIGHTS_M": _halved(field._HEIGHTS_M)},
        "rays": {"_RISING": 2 * field._RISING, "_FALLING": 2 * field._FALLING},
        "azimuths": {"_AZIMUTHS": 2 * field._AZIMUTHS},
        "pieces": {"_PIECES": 2 * field._PIECES},
    }
    for what, numbers in finer.items():
        with _solved_anew(numbers):
            changed = worst(_skies(_DAY_DEG) / own - 1.0)
        yield Row(f"twice as many {what}, suns of 60° to 3°: worst", changed)
    suns = (*_DAY_DEG, *_DUSK_DEG, -5.0)
    own = _skies(suns)
    dense = np.unique(np.concatenate([field._ZENITHS_DEG, np.arange(84.0, 97.1, 0.25)]))
    for what, angles in (
        ("twice as many nodes", _halved(floats(field._ZENITHS_DEG))),
        ("nodes 0.25° apart", dense),
    ):
        with _solved_anew({"_ZENITHS_DEG": tuple(angles)}):
            changed = np.abs(_skies(suns) / own - 1.0).max(axis=(1, 2))
        day, dusk = changed[: len(_DAY_DEG)], changed[len(_DAY_DEG) : -1]
        yield Row(f"{what} of the sun's altitude, suns of 60° to 3°: worst", float(day.max()))
        yield Row(f"{what} of the sun's altitude, down to -4°: worst", float(dusk.max()))
        yield Row(f"{what} of the sun's altitude, at -5°: worst", float(changed[-1]))


def _halved(values: Array) -> Array:
    """Put a node in the middle of each two."""
    return np.sort(np.concatenate([values, 0.5 * (values[1:] + values[:-1])]))


@contextmanager
def _solved_anew(numbers: dict[str, object]) -> Iterator[None]:
    """Change numbers of the solver, whose skies the cache must neither give nor keep."""
    with (
        tempfile.TemporaryDirectory() as folder,
        patch.dict(os.environ, {FOLDER_VARIABLE: folder}),
        patch.multiple(field, **numbers),  # type: ignore[call-overload]  # by name
    ):
        yield


def _skies(suns_deg: tuple[float, ...]) -> Array:
    """Radiance under suns along some rays (suns, rays, W)."""
    light = field.solved_field(molecules.air(0.0))
    return floats([[molecules.seen(light, 0.0, sun, *ray)[0] for ray in _RAYS] for sun in suns_deg])
