"""Scenes from Python: from dicts, keyword arguments and arrays."""

from __future__ import annotations

import atexit
import hashlib
import io
import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError, UnavailableError, cut
from rtbow.base.files import write_atomic
from rtbow.scene.model import Scene
from rtbow.scene.text.bounds import check_values
from rtbow.scene.text.overrides import plain
from rtbow.scene.text.values import resolve_paths, scene_from_values, scene_text
from rtbow.world.measured.spectra import load_spectrum, spectrum_names
from rtbow.world.rain.volume import scene_volume
from rtbow.world.rain.volume_file import checked_volume

_NAME = "scene"
"""What messages call a scene that has no file."""


@dataclass(frozen=True, eq=False)
class Volume:
    """Drops on a regular grid, from arrays, for :func:`rtbow.make_scene`.

    Point i of n along an axis lies at ``lo + i/(n-1) (hi - lo)`` of the box. What is given once
    holds at every point, as NumPy broadcasts it; one of the two has the grid's shape.

    Args:
        radius_um: radii of the drops in µm (nx, ny, nz): east, north, up.
        number_per_m3: drops per cubic metre (nx, ny, nz).
        box_m: lower and upper corner in m (2, 3): east, north, up.

    Raises:
        InputError: arrays that do not fit each other, or values out of range.

    Example:
        >>> number = np.zeros((8, 8, 4))
        >>> number[2:5, 2:5] = 300.0
        >>> box = [[-500, 200, 0], [500, 900, 800]]
        >>> rain = rtbow.Volume(radius_um=400.0, number_per_m3=number, box_m=box)
    """

    radius_um: ArrayLike = field(repr=False)
    number_per_m3: ArrayLike = field(repr=False)
    box_m: ArrayLike

    def __post_init__(self) -> None:
        """Check the arrays; copies of them are kept, so that later changes do no harm."""
        box = _numbers("Volume: box_m", self.box_m)
        radius = _numbers("Volume: radius_um", self.radius_um)
        number = _numbers("Volume: number_per_m3", self.number_per_m3)
        try:
            radius, number = np.broadcast_arrays(radius, number)
        except ValueError:
            raise InputError(
                f"Volume: radius_um {radius.shape} and number_per_m3 {number.shape} do not fit;"
                " give both one shape (nx, ny, nz), or one of them as a single number"
            ) from None
        try:
            checked = checked_volume("Volume", radius, number, box)
        except InputError as error:
            raise InputError(f"Volume: {error}") from None
        kept: tuple[NDArray[Any], ...] = checked
        for name, array in zip(("box_m", "radius_um", "number_per_m3"), kept, strict=True):
            array.flags.writeable = False
            object.__setattr__(self, name, array)


def make_scene(
    values: Mapping[str, Any] | None = None,
    /,
    *,
    volume: Volume | None = None,
    spectra: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    **tables: Any,
) -> Scene:
    """Make a scene from Python's own values, and check all of it.

    Keys and values are those of scene files. Spectra and volume files are read at once, so that
    what is wrong with them is said here and not when the scene is drawn.

    Arrays are kept in files of this process, which ends with them: a scene that is to outlive it
    names files of your own.

    Args:
        values: the scene's tables, such as ``{"light": [{"altitude_deg": 10}], ...}``; relative
            paths in them start at the current folder.
        volume: the drops, instead of ``droplets.box_m``, ``grid``, ``radius`` and ``density``.
        spectra: spectra by a name of your choice, which lights then take as their ``spectrum``:
            wavelengths in nm and values, two arrays (n,) each.
        tables: tables of the scene as keyword arguments: ``camera={"fov_deg": 90}``. A ``light``
            may be one table or a list of several.

    Returns:
        The scene.

    Raises:
        InputError: keys or values that are not allowed, files or arrays that are not usable.

    Example:
        >>> scene = rtbow.make_scene(
        ...     light={"altitude_deg": 10, "spectrum": "mine"},
        ...     spectra={"mine": (np.linspace(380, 780, 81), np.ones(81))},
        ...     droplets={"extinction": True},
        ...     volume=rain,
        ... )
    """
    data = _joined(values, tables)
    if isinstance(data.get("light"), dict):
        data["light"] = [data["light"]]
    if volume is not None:
        _put_volume(data, volume)
    files = {
        name: _spectrum_file(name, *_pair(name, pair)) for name, pair in (spectra or {}).items()
    }
    unused = {*files} - _put_spectra(data, files)
    if unused:
        name = cut(sorted(unused)[0])
        raise InputError(f'spectra: no light has spectrum = "{name}"; name it in one, or leave it')
    resolve_paths(data, Path())
    try:
        scene = scene_from_values(data, _NAME, {})
        for part in {id(part): part for part, _ in scene.parts()}.values():
            _check_files(part)
    except InputError as error:
        raise InputError(_by_name(str(error), files)) from None
    return scene.with_source(scene_text(scene), _NAME)


def _joined(values: Mapping[str, Any] | None, tables: Mapping[str, Any]) -> dict[str, Any]:
    """Give a scene's tables as TOML would, from both ways in which they may be given."""
    if values is not None and not isinstance(values, Mapping):
        raise InputError(
            f"make_scene takes a dict of tables, not a value of type {type(values).__name__}; for"
            " a file or a built-in scene use load_scene"
        )
    try:
        data: dict[str, Any] = plain(values or {})
        more: dict[str, Any] = plain(tables)
    except RecursionError:
        raise InputError(f"{_NAME}: a value holds itself, or is nested too deeply") from None
    for key in data.keys() & more.keys():
        raise InputError(f"{_NAME}: {cut(key)} is given twice, in the dict and by keyword")
    check_values(data | more)
    return data | more


def _put_volume(data: dict[str, Any], volume: Volume) -> None:
    if not isinstance(volume, Volume):
        raise InputError(
            f"volume is of type {type(volume).__name__}; must be a rtbow.Volume; a volume's file is"
            ' named in droplets, as {"file": "rain.npz"}'
        )
    droplets = data.setdefault("droplets", {})
    if isinstance(droplets, dict):
        if "file" in droplets:
            raise InputError("volume: droplets.file is given, too; leave one of the two out")
        droplets["file"] = _volume_file(volume)


def _put_spectra(values: Any, files: Mapping[str, str]) -> set[str]:
    """Put files in the place of their names, wherever a spectrum is named; give those found."""
    found: set[str] = set()
    for item in values.items() if isinstance(values, dict) else enumerate(values):
        key, value = item
        last = str(key).rpartition(".")[2]
        if last == "spectrum" and isinstance(value, str) and value in files:
            values[key] = files[value]
            found.add(value)
        elif isinstance(value, dict | list):
            found |= _put_spectra(value, files)
    return found


def _check_files(scene: Scene) -> None:
    """Read what a scene names, or raise InputError."""
    for number, light in enumerate(scene.light):
        try:
            load_spectrum(light.spectrum, light.beyond)
        except InputError as error:
            raise InputError(f"{_NAME}: light.{number}.spectrum: {error}") from None
    droplets = scene.droplets
    if droplets.file is not None or getattr(droplets.radius, "file", None) is not None:
        scene_volume(scene)


def _by_name(message: str, files: Mapping[str, str]) -> str:
    """Give a message with the names of spectra that came as arrays instead of their files'."""
    for name, path in files.items():
        message = message.replace(path, f'spectra["{cut(name)}"]')
    return message


def _pair(name: str, pair: object) -> tuple[Array, Array]:
    """Give a spectrum's wavelengths and values, checked as far as its file is not."""
    said = f'spectra["{cut(str(name))}"]'
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z][\w -]*", name):
        raise InputError(f"{said}: must be named by a word, such as lamp")
    if name in spectrum_names():
        raise InputError(f"{said}: this is the name of a built-in spectrum; choose another one")
    if not isinstance(pair, tuple | list) or len(pair) != 2:
        raise InputError(f"{said}: must be a pair of arrays, (wavelength in nm, value)")
    nm, value = (_numbers(said, part) for part in pair)
    if nm.ndim != 1 or nm.shape != value.shape or len(nm) < 2:
        raise InputError(
            f"{said}: arrays of shapes {nm.shape} and {value.shape}; must be two of one length (n,)"
        )
    if not (np.isfinite(nm).all() and np.isfinite(value).all()):
        raise InputError(f"{said}: must hold finite numbers")
    return nm, value


def _numbers(said: str, values: ArrayLike) -> Array:
    """Give an array of real numbers as float64, or raise InputError."""
    try:
        array = np.asarray(values)
        if array.dtype.kind in "fiu":
            return array.astype(np.float64)
    except (TypeError, ValueError):  # lists of unequal lengths
        pass
    raise InputError(f"{said}: must be an array of numbers")


# --- Files of this process -----------------------------------------------------------------------


@cache
def _folder(process: int) -> Path:
    """Give a folder that goes with a process; one that was forked gets its own."""
    try:
        folder = tempfile.mkdtemp(prefix="rtbow-arrays-")
    except OSError as error:
        raise UnavailableError(
            f"no folder for the arrays of a scene: {error.strerror}; set TMPDIR to a folder that"
            " can be written"
        ) from None
    atexit.register(_remove, folder, process)
    return Path(folder)


def _remove(folder: str, process: int) -> None:
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)


def _file(stem: str, suffix: str, data: bytes) -> str:
    """Give the path of a file that holds some data; the same data is written once."""
    path = _folder(os.getpid()) / f"{stem}-{hashlib.sha256(data).hexdigest()[:16]}{suffix}"
    if not path.exists():
        write_atomic(path, data)
    return str(path)


def _volume_file(volume: Volume) -> str:
    buffer = io.BytesIO()
    np.savez(
        buffer,
        radius_um=volume.radius_um,
        number_per_m3=volume.number_per_m3,
        box_m=volume.box_m,
    )
    return _file("volume", ".npz", buffer.getvalue())


def _spectrum_file(name: str, nm: Array, value: Array) -> str:
    rows = "".join(f"{x!r},{y!r}\n" for x, y in zip(nm.tolist(), value.tolist(), strict=True))
    return _file(name.replace(" ", "-"), ".csv", f"wavelength_nm,value\n{rows}".encode())
