"""Tables of another kind than the scene's: valid, and with what can be carried over."""

from __future__ import annotations

import math
import re
import zipfile
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydantic import BaseModel

from rtbow.base.errors import InputError
from rtbow.base.resources import resource_dir
from rtbow.physics.geometry import direction
from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.droplets import Droplets
from rtbow.scene.lights import MOON, SunLight
from rtbow.scene.model import Scene
from rtbow.scene.radius import density_key
from rtbow.scene.text.schema import Node
from rtbow.view.panel.rows import Row, rounded, rows_of, shown_number
from rtbow.view.picture.projection import azimuth_altitude_deg
from rtbow.world.lights import irradiance_w_m2
from rtbow.world.measured.spectra import load_spectrum
from rtbow.world.rain.box import box_of
from rtbow.world.rain.size_file import read_size_file

Values = dict[str, object]

DEFAULT_BOX_M = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]
"""A curtain of rain north of the eye."""
GRID = [32, 32, 32]
_RADIUS_UM = 500.0
_SPREAD = 0.2
"""Relative standard deviation where all drops were alike."""
_DENSITIES: Values = {"number_per_m3": 1000.0, "rain_rate_mm_h": 5.0}
_EXPONENT = 2.0
_LAMP_AWAY_M, _LAMP_UP_M = 5.0, 4.0
"""Distance and height above the eye of a lamp that takes a sun's place."""
_LAMP_LM = 8000.0
_MEANS = ("radius_um", "mean_um", "median_um", "effective_radius_um")
_OTHER_PARAMETERS = ("n0", "mu", "lambda_per_mm")
"""Parameters of a distribution that has others, with which it begins."""
_FILE = "shower.npz"
_SIZE_FILE = "shower-sizes.csv"
_IN_VOLUME = ("radius_um", "number_per_m3", "box_m")


def radius_table(droplets: Droplets, kind: str, kinds: Node) -> Values:
    """Give what the droplets need for drops of another distribution.

    Args:
        droplets: as they are.
        kind: the new distribution.
        kinds: the schema's node of all distributions.

    Returns:
        Changes by key inside ``droplets``.
    """
    before = droplets.radius
    old: Values = {} if before is None else before.model_dump(exclude_none=True)
    mean, spread = _mean(old), _spread(old)
    table: Values = {"distribution": kind}
    for row in _rows(kinds.kind(kind)):
        if row.name == "distribution":
            continue
        if row.name == "mixing" and row.name not in old:
            table[row.name] = "local" if droplets.grid is None else "per-point"
        elif row.name in old:
            table[row.name] = old[row.name]
        elif row.kind == "path":
            table[row.name] = str(resource_dir("scenes") / _SIZE_FILE)
        elif row.name not in _OTHER_PARAMETERS:
            table[row.name] = _within(row, _of_sizes(row.name, kind, mean, spread))
    changes: Values = {"radius": {key: value for key, value in table.items() if value is not None}}
    key = density_key(kind)
    if key is None:
        changes["density"] = None
    elif droplets.density is None or getattr(droplets.density, key) is None:
        changes["density"] = {key: _DENSITIES[key]}
    return changes


def _mean(old: Values) -> float:
    for name in _MEANS:
        if name in old:
            return _number(old[name])
    if "min_um" in old:
        return 0.5 * (_number(old["min_um"]) + _number(old["max_um"]))
    if "mu" in old:
        return 500.0 * (_number(old["mu"]) + 3.0) / _number(old["lambda_per_mm"])
    return _RADIUS_UM


def _spread(old: Values) -> float:
    if "std_um" in old:
        return _number(old["std_um"]) / _mean(old)
    if "log_std" in old:
        return _number(old["log_std"])
    if "effective_variance" in old:
        return math.sqrt(_number(old["effective_variance"]))
    if "mu" in old:
        return 1.0 / math.sqrt(_number(old["mu"]) + 3.0)
    if "min_um" in old:
        width = _number(old["max_um"]) - _number(old["min_um"])
        return width / (math.sqrt(12.0) * _mean(old))
    return _SPREAD


def _number(value: object) -> float:
    assert isinstance(value, int | float)
    return float(value)


def _of_sizes(name: str, kind: str, mean: float, spread: float) -> float | None:
    """Give a new distribution's parameter for drops of a mean radius and relative spread."""
    half = min(math.sqrt(3.0) * spread, 0.9)
    # In rain, larger drops are ever rarer: its range is wide.
    ends = (0.2, 3.0) if kind == "marshall-palmer" else (1.0 - half, 1.0 + half)
    parameters = {
        **dict.fromkeys(_MEANS, mean),
        "min_um": mean * ends[0],
        "max_um": mean * ends[1],
        "std_um": mean * spread,
        "log_std": spread,
        "effective_variance": spread**2,
        "exponent": _EXPONENT,
    }
    return parameters.get(name)


def _within(row: Row, value: float | None) -> object:
    """Give a number in few digits inside a key's range; without one what the schema suggests."""
    if value is None:
        return start_of(row)
    low, high = -math.inf, math.inf
    for limit in row.node.metadata:
        low, high = getattr(limit, "ge", low), getattr(limit, "le", high)
    return min(max(rounded(value, 3), low), high)


def start_of(row: Row) -> object:
    """Give a value for a key that has none so far: its default, or one amid its usual range."""
    if row.node.default is not None:
        return row.node.default
    if row.kind in ("choice", "tag", "boxes"):
        return row.choices[0] if row.choices else [1]
    if row.kind == "flag":
        return True
    if row.kind == "table":
        return {} if len(row.node.models) == 1 else fresh(Node.of(row.node.models[0]))
    item = row.node
    shape: list[int] = []
    while item.items:
        shape.append(len(item.items))
        item = Node.of(item.items[0])
    if shape and (listed := re.search(r"\[([-\d., ]+)\]", row.absent)):
        return [float(number) for number in listed[1].split(",")]
    number = row.start
    if len(shape) == 2 and row.kind == "corners":
        half = abs(row.slide.high) / 4 if row.slide else 1.0
        return [[number - half] * shape[1], [number + half] * shape[1]]
    return [number] * shape[0] if shape else number if row.kind == "number" else row.name


def left_out_of(row: Row, table: BaseModel) -> Row:
    """Give a row with what holds in a table that leaves its value out, where that varies.

    The Moon's irradiance goes with its phase and distance.
    """
    if row.name != "irradiance_w_m2" or not isinstance(table, SunLight):
        return row
    if table.spectrum != MOON or table.irradiance_w_m2 is not None:
        return row
    return replace(row, absent=shown_number(_moonlight_w_m2(table)))


@lru_cache(maxsize=8)
def _moonlight_w_m2(moon: SunLight) -> float:
    return rounded(irradiance_w_m2(moon), 4)


def fresh(node: Node, **given: object) -> Values:
    """Give a table of one kind with all that it requires.

    Args:
        node: of the one kind.
        **given: values that are known.
    """
    table: Values = {}
    for row in _rows(node):
        if row.name in given:
            table[row.name] = given[row.name]
        elif row.kind == "choice" and len(row.choices) == 1:
            table[row.name] = row.choices[0]
        elif node.models[0].model_fields[row.name].is_required():
            table[row.name] = start_of(row)
    return table


def other_kind(table: BaseModel, kind: str, kinds: Node) -> Values:
    """Give a table of another kind, with what it has in common with the one before.

    Args:
        table: as it is.
        kind: the new one's.
        kinds: the schema's node of all kinds.
    """
    node = kinds.kind(kind)
    old = table.model_dump(exclude_none=True)
    common = [row.name for row in _rows(node) if row.kind != "choice" or len(row.choices) > 1]
    return fresh(node, **{name: old[name] for name in common if name in old})


def _rows(node: Node) -> tuple[Row, ...]:
    return rows_of("", node.models[0])


def light_table(scene: Scene, light: BaseModel | None, kind: str, kinds: Node) -> Values:
    """Give a light of a kind, in place of another or beside the scene's.

    A lamp hangs where the sun was seen, near the eye; a sun stands where the lamp was seen.

    Args:
        scene: the scene.
        light: the light whose place it takes; None if it is one more.
        kind: the new light's.
        kinds: the schema's node of all lights.
    """
    node = kinds.kind(kind)
    eye = np.array(scene.camera.position_m)
    old: Values = {} if light is None else light.model_dump()
    given = {row.name: old[row.name] for row in _rows(node) if row.name in old}
    given["type"] = kind
    if "position_m" in old:
        azimuth_deg, altitude_deg = azimuth_altitude_deg(np.array(old["position_m"]) - eye)
        given["azimuth_deg"] = round(azimuth_deg % 360.0, 1)
        given["altitude_deg"] = round(altitude_deg, 1)
    else:
        azimuth = old.get("azimuth_deg", scene.camera.azimuth_deg + 180.0)
        away = direction(_number(azimuth), 0.0) * _LAMP_AWAY_M
        given["position_m"] = [round(float(x), 2) for x in eye + away + [0.0, 0.0, _LAMP_UP_M]]
    given["luminous_flux_lm"] = _LAMP_LM
    return fresh(node, **given)


def droplets_of_box(droplets: Droplets, kinds: Node) -> Values:
    """Give what the droplets need to be described instead of read from a file.

    The box is the file's. It may hold many millions of drops, so none of them is read.

    Args:
        droplets: as they are.
        kinds: the schema's node of all distributions.

    Returns:
        Changes by key inside ``droplets``.
    """
    box = box_of(droplets)
    return {
        "file": None,
        "box_m": DEFAULT_BOX_M if box is None else box.tolist(),
        "radius": fresh(kinds.kind("constant"), radius_um=_RADIUS_UM),
        "density": {"number_per_m3": _DENSITIES["number_per_m3"]},
    }


def problem_of_file(key: str, value: object, scene: Scene) -> str:
    """Say what is wrong with a file of rain, drop sizes or a spectrum that a key is to name.

    Only a volume's list of arrays is read, since these may be large. Empty if nothing is wrong.

    Args:
        key: the key.
        value: the file's name.
        scene: the scene as it stands.
    """
    if not isinstance(value, str):
        return ""
    if key == "droplets.file":
        return _problem_of_volume(Path(value))
    if key == "droplets.radius.file":
        try:
            read_size_file(Path(value))
        except InputError as error:
            return str(error)
    if named := re.fullmatch(r"light\.(\d+)\.spectrum", key):
        number = int(named[1])
        try:
            load_spectrum(value, scene.light[number].beyond if number < len(scene.light) else None)
        except InputError as error:
            return str(error)
    return ""


def _problem_of_volume(path: Path) -> str:
    try:
        with zipfile.ZipFile(path) as archive:
            names = {name.removesuffix(".npy") for name in archive.namelist()}
    except FileNotFoundError:
        return f"{path}: volume file not found"
    except (OSError, ValueError, zipfile.BadZipFile):
        return f"{path}: not a volume file; tools/build_droplets.py makes one"
    missing = [name for name in _IN_VOLUME if name not in names]
    return f"{path}: lacks {', '.join(missing)}, which a volume file holds" if missing else ""


def droplets_of_file() -> Values:
    """Give what the droplets need to be read from a file: one of the volumes that are shipped."""
    files = shipped_volumes()
    first = files.get(_FILE) or next(iter(files.values()))
    return {"file": str(first)}


def shipped_volumes() -> dict[str, Path]:
    """Give the volume files shipped with the built-in scenes, by name."""
    return {path.name: path for path in sorted(resource_dir("scenes").glob("*.npz"))}


def kept_in_place(scene: Scene, key: str) -> Values:
    """Give what keeps view and rain where they are once a key that they follow is left out."""
    camera = scene.camera
    if key == "camera.look":
        return {f"camera.{name}": getattr(camera, name) for name in LOOKED_AT}
    if key == "droplets.around_m" and scene.droplets.box_m is not None:
        return {"droplets.box_m": [list(corner) for corner in scene.droplets.box_m]}
    return {}
