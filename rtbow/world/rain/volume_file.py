"""Volume files: their arrays read and checked."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array
from rtbow.base.errors import CHECK_PATH, InputError, UnavailableError, cut, notice, shown_path
from rtbow.base.files import open_regular
from rtbow.base.limits import (
    LEAST_EXTENT_M,
    MAX_COORDINATE_M,
    MAX_DENSITY_PER_M3,
    MAX_GRID_POINTS,
    MAX_RADIUS_UM,
    MIN_RADIUS_UM,
)
from rtbow.world.rain.npz import Header, Npz

Field = NDArray[np.float32]

MAX_GRID = 1024
"""Most grid points along an axis."""
_TRACE = 1e-6
"""Densities up to this share of the largest are what interpolation and packing leave behind."""

_FIELDS = ("radius_um", "number_per_m3")
_NAMES = (*_FIELDS, "box_m")

_EXPECTED = (
    "expected an .npz with radius_um and number_per_m3 of one shape (nx, ny, nz), 2 to"
    f" {MAX_GRID} points along each axis, and box_m (2, 3), as Python writes it with"
    ' numpy.savez_compressed("rain.npz", radius_um=radius, number_per_m3=number,'
    " box_m=[[east, north, up], [east, north, up]])"
)

_OTHER_FORMATS = {
    b"\x89HDF\r\n\x1a\n": "a NetCDF or HDF5 file",
    b"CDF": "a NetCDF file",
    b" BDV": "an OpenVDB file",
    b"GRIB": "a GRIB file",
    b"\x1f\x8b": "a gzip file",
}
"""First bytes of what volumes are also kept in."""


def read_volume_file(path: Path) -> tuple[Array, Field, Field]:
    """Read and check a volume file.

    Where there are no drops a file may say anything about their radius, which is 0 then. Densities
    of no more than a millionth of the largest one are taken as none where they are negative or
    have no radius that drops could have, which is said once.

    Memory: 8 bytes for each point, and a few MiB. None is taken before the file is known to have
    up to 512³ points.

    Args:
        path: the ``.npz``.

    Returns:
        The box, float64 (2, 3), and radius (µm) and number (1/m³), float32 (nx, ny, nz).

    Raises:
        InputError: not there, not an ``.npz``, arrays missing, of unequal shape, out of range.
        UnavailableError: not enough memory.
    """
    try:
        with open_regular(path) as file:
            box, radius, number = _arrays(file)
        return _checked_box(box), *_checked_fields(path, radius, number)
    except FileNotFoundError:
        raise InputError(
            f"{shown_path(path)}: volume file not found; {CHECK_PATH}; {_EXPECTED}"
        ) from None
    except OSError as error:
        raise InputError(
            f"{shown_path(path)}: not a readable volume ({error.strerror}); {_EXPECTED}"
        ) from None
    except (InputError, UnavailableError) as error:
        raise type(error)(f"{shown_path(path)}: {error}") from None


def checked_volume(
    name: str, radius: Array, number: Array, box: Array
) -> tuple[Array, Field, Field]:
    """Check arrays in memory as those of a file; the results are copies.

    Args:
        name: what notices call them.
        radius: radii (µm), of one shape with the numbers.
        number: drops (1/m³).
        box: lower and upper corner (m).

    Returns:
        As :func:`read_volume_file`.

    Raises:
        InputError: as there.
    """
    arrays = dict(zip(_NAMES, (radius, number, box), strict=True))
    _check_shapes({key: Header(a.dtype, a.shape, False, 0) for key, a in arrays.items()})
    fields = (np.array(part, dtype=np.float32, order="C") for part in (radius, number))
    return _checked_box(box.copy()), *_checked_fields(Path(name), *fields)


def _arrays(file: BinaryIO) -> tuple[Array, Field, Field]:
    start = file.read(8)
    for magic, what in _OTHER_FORMATS.items():
        if start.startswith(magic):
            raise InputError(
                f"is {what}, which rtbow does not read; read it in Python (with xarray, pyopenvdb"
                f" or the program that wrote it) and save its arrays; {_EXPECTED}"
            )
    if start.startswith(b"\x93NUMPY"):
        raise InputError(f"is a single array; {_EXPECTED}")
    if not start.startswith(b"PK"):
        raise InputError(f"is not an .npz file; {_EXPECTED}")
    try:
        archive = Npz(file)
        missing = [name for name in _NAMES if name not in archive.names]
        if missing:
            raise InputError(f"lacks {', '.join(missing)}")
        headers = {name: archive.header(name) for name in _NAMES}
        _check_shapes(headers)
        radius, number = (archive.read(name, headers[name], np.float32) for name in _FIELDS)
        return archive.read("box_m", headers["box_m"], np.float64), radius, number
    except InputError as error:
        raise InputError(f"{error}; {_EXPECTED}") from None


def _check_shapes(headers: dict[str, Header]) -> None:
    radius, number, box = (headers[name].shape for name in _NAMES)
    if len(radius) != 3 or radius != number:
        raise InputError(f"radius_um {cut(str(radius))} and number_per_m3 {cut(str(number))}")
    if not all(2 <= length <= MAX_GRID for length in radius):
        raise InputError(f"grid of {cut(str(radius))} points")
    points = headers["radius_um"].count
    if points > MAX_GRID_POINTS:
        raise InputError(
            f"{points:,} points; must have up to {MAX_GRID_POINTS:,}: use a coarser volume"
        )
    if box != (2, 3):
        raise InputError(f"box_m has shape {cut(str(box))}")


def _checked_box(box: Array) -> Array:
    # NaN fails each comparison.
    inside = np.all(np.abs(box) <= MAX_COORDINATE_M)
    if not inside or not np.all(box[1] - box[0] >= LEAST_EXTENT_M):
        corners = ", ".join(f"[{', '.join(f'{value:g}' for value in corner)}]" for corner in box)
        raise InputError(
            f"box_m = [{corners}]; must be two finite corners within ±{MAX_COORDINATE_M:g} m, the"
            f" second greater along east, north and up, by {LEAST_EXTENT_M:g} m at least"
        )
    return box


def _checked_fields(path: Path, radius: Field, number: Field) -> tuple[Field, Field]:
    """Check both fields, and change them in place where there are no drops."""
    # A slab at a time, so that what is worked out about each point takes no memory to speak of.
    _refuse_numbers(number, (~(part <= MAX_DENSITY_PER_M3) for part in number))  # NaN, too
    trace = np.float32(_TRACE * max(float(number.max()), 0.0))
    _refuse_numbers(number, (part < -trace for part in number))
    dropped = 0
    for sizes, numbers in zip(radius, number, strict=True):
        odd = _odd(sizes)
        none = (np.abs(numbers) <= trace) & (odd | (numbers < 0.0))
        dropped += int(np.count_nonzero(none & (numbers != 0.0)))
        numbers[none] = 0.0
        sizes[odd & (numbers == 0.0)] = 0.0
    wrong = (_odd(s) & (n > 0.0) for s, n in zip(radius, number, strict=True))
    if found := _first(wrong):
        place, count = found
        raise InputError(
            f"radius_um{list(place)} = {radius[place]:g} where number_per_m3 is"
            f" {number[place]:g}{_and_more(count)}; must be {MIN_RADIUS_UM:g}-{MAX_RADIUS_UM:g} µm"
            " where there are drops; give radii in µm, and set number_per_m3 to 0 where there are"
            " no drops"
        )
    if dropped:
        notice(
            f"{shown_path(path)}: {dropped:,} point{'s' if dropped > 1 else ''} with densities"
            f" within {_TRACE:g} of the largest one, negative or without a radius of"
            f" {MIN_RADIUS_UM:g}-{MAX_RADIUS_UM:g} µm, taken as empty"
        )
    return radius, number


def _odd(sizes: Field) -> NDArray[np.bool_]:
    """Whether no drop has such a radius; NaN fails each comparison."""
    return ~((sizes >= MIN_RADIUS_UM) & (sizes <= MAX_RADIUS_UM))


def _refuse_numbers(number: Field, wrong: Iterator[NDArray[np.bool_]]) -> None:
    if found := _first(wrong):
        place, count = found
        raise InputError(
            f"number_per_m3{list(place)} = {number[place]:g}{_and_more(count)}; must be"
            f" 0..{MAX_DENSITY_PER_M3:g} 1/m³; set it to 0 where there are no drops"
        )


def _first(wrong: Iterator[NDArray[np.bool_]]) -> tuple[tuple[int, int, int], int] | None:
    """Return the first place that is marked, east slab by east slab, and how many there are."""
    place, count = None, 0
    for i, marks in enumerate(wrong):
        if place is None and marks.any():
            j, k = np.argwhere(marks)[0]
            place = (i, int(j), int(k))
        count += int(np.count_nonzero(marks))
    return None if place is None else (place, count)


def _and_more(count: int) -> str:
    return "" if count == 1 else f" (the first of {count:,} such points)"
