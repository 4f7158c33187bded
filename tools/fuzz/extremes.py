"""Scenes drawn from the schema, each key over all that it allows, its ends above all.

Keys that are added to the schema are drawn by their type and range. One that is a text, or that is
tied to others, needs a line here; tests say so.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, get_args, get_origin

import numpy as np
import tomlkit

from rtbow.base.limits import DEEPEST_AIR_M, INDICES, TOP_M
from rtbow.base.resources import resource_dir
from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.air import ALBEDOS, FREE_AEROSOL
from rtbow.scene.droplets import BY_PARTS
from rtbow.scene.lights import FROM_TIME, LIT, MOON, TIME_AND_PLACE
from rtbow.scene.panorama import LENS_ALONE, PANORAMA, make_whole
from rtbow.scene.radius import density_key
from rtbow.scene.text.schema import ROOT, Node, walk_fields

Rng = np.random.Generator

VOLUMES = 12
"""Volume files that scenes may name: ``volume-0.npz`` and so on (see :func:`volume_seed`)."""

_WIDEST = 1e300
"""Of numbers without bounds."""
_TIMES = ("1900-01-01T00:00Z", "2013-05-27T15:46:00+02:00", "2100-12-31T23:59:59Z")
_SPECTRA = ("E490", "equal-energy", "FL2", "FL11", "HP1", "LED-B3", "D65", "A")


Cost = Literal["quick", "airy", "any"]
"""Which scenes are drawn: those whose frames take seconds; all but exact theory's, whose tables
may take minutes to build; all."""


def scene_values(rng: Rng, cost: Cost = "airy") -> dict[str, Any]:
    """Draw a scene's values; the same source of chance draws the same scene."""
    values = _table(rng, ROOT, "")
    if cost != "any":
        values.get("scattering", {}).pop("theory", None)
    camera = values.setdefault("camera", {})
    camera.setdefault("size_px", _size(rng))  # the default is of a picture, and takes minutes
    _fit_lens(camera, values.get("compare", {}).get("right", {}))
    _fit_droplets(rng, values["droplets"])
    _fit_medium(rng, values.get("scattering", {}))
    for light in values["light"]:
        _fit_light(rng, light)
    _fit_camera(rng, camera, values["light"])
    _fit_air(rng, values, camera)
    _fit_pixels(values, camera)
    if cost == "quick":
        _make_quick(rng, values)
    return values


def _fit_lens(camera: dict[str, Any], right: dict[str, Any]) -> None:
    """Leave out what does not go with a lens, a sensor without one, and either of a panorama."""
    camera.pop("fov_deg" if "focal_length_mm" in camera else "sensor_mm", None)
    if camera.get("projection") == PANORAMA:
        make_whole(camera, set())
        if camera.get("pixel") == "area":
            # The reference follows light over a whole quarter of the sky for an hour.
            camera["size_px"] = [24, 12]
        for key in LENS_ALONE:
            right.pop(f"camera.{key}", None)


def scene_text(rng: Rng, cost: Cost = "airy") -> str:
    """Draw a scene as TOML (see :func:`scene_values`)."""
    return tomlkit.dumps(scene_values(rng, cost))


def draw(rng: Rng, node: Node, key: str) -> Any:
    """Draw the value of a key.

    Args:
        rng: the source of chance.
        node: the key's place in the schema.
        key: its dotted name, with 0 for the tables of a list.

    Raises:
        KeyError: a text that nothing here says how to draw.
    """
    if key in _SPECIAL:
        return _SPECIAL[key](rng)
    if node.models:
        return _table(rng, node, key)
    if node.items:
        count = int(rng.integers(1, 4)) if node.open else len(node.items)
        children = [(n, node.child(n)) for n in range(count)]
        items = [draw(rng, child, f"{key}.0") for _, child in children if child is not None]
        if key.endswith("position_m"):  # air ends there
            items[2] = max(items[2], DEEPEST_AIR_M)
        return items
    if get_origin(node.annotation) is Literal:
        return _choice(rng, get_args(node.annotation))
    if node.annotation is bool:
        return bool(rng.integers(2))
    if node.annotation is int:
        return round(_number(rng, node, whole=True))
    if node.annotation is float:
        return float(_number(rng, node, whole=False))
    raise KeyError(f"{key}: a {node.annotation}, which has no line in tools/fuzz/extremes.py")


def _choice(rng: Rng, items: tuple[Any, ...]) -> Any:
    return items[int(rng.integers(len(items)))]


def _table(rng: Rng, node: Node, key: str) -> dict[str, Any]:
    if len(node.models) > 1:
        model = _choice(rng, node.models)
        node = Node(model, (), models=(model,))
    values: dict[str, Any] = {}
    for name, field in node.fields.items():
        child = node.child(name)
        assert child is not None
        tag = get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1
        if field.is_required() or tag or rng.random() < 0.6:
            values[name] = draw(rng, child, f"{key}.{name}" if key else name)
    return values


def bounds(node: Node) -> tuple[float, float]:
    """Return the least and the greatest number that a key allows; infinite where there is none."""
    low, high = -math.inf, math.inf
    for limit in node.metadata:
        low = max(low, getattr(limit, "ge", low))
        high = min(high, getattr(limit, "le", high))
        if getattr(limit, "gt", None) is not None:
            low = max(low, math.nextafter(limit.gt, math.inf))
        if getattr(limit, "lt", None) is not None:
            high = min(high, math.nextafter(limit.lt, -math.inf))
    return low, high


def _number(rng: Rng, node: Node, *, whole: bool) -> float:
    """Draw a number: an end, a usual value, something between, near zero or far away."""
    low, high = bounds(node)
    low, high = (math.ceil(low), math.floor(high)) if whole and high < math.inf else (low, high)
    limit = 2.0**62 if whole else _WIDEST
    low, high = max(low, -limit), min(high, limit)
    if isinstance(node.default, int | float) and rng.random() < 0.3:
        return float(node.default)
    kind = rng.random()
    if kind < 0.15:
        return low
    if kind < 0.3:
        return high
    if kind < 0.4:
        return min(max(float(_choice(rng, (0.0, 1e-300, -1e-9, 1e-9, 1e-3, 1.0))), low), high)
    if kind < 0.7:
        least, most = max(low, -1e3), min(high, 1e3)
        return float(rng.uniform(least, most) if least < most else rng.uniform(low, high))
    # Every order of magnitude alike.
    sign = -1.0 if low < 0.0 and rng.random() < 0.5 else 1.0
    size = 10.0 ** float(rng.uniform(-6.0, math.log10(max(abs(low), abs(high), 1e-6))))
    return float(min(max(sign * size, low), high))


def _box(rng: Rng) -> list[list[float]]:
    """Draw a box: as people make them, thin, tiny, huge, far away or around the eye."""
    centre = rng.uniform(-1.0, 1.0, 3) * 10.0 ** rng.uniform(-2.0, 4.0, 3)
    extent = 10.0 ** rng.uniform(-2.0, 4.0, 3)
    kind = rng.random()
    if kind < 0.1:
        extent[rng.integers(3)] = 10.0 ** rng.uniform(-2.99, -1.0)
    elif kind < 0.2:
        extent = np.full(3, 9e6)
        centre = np.zeros(3)
    elif kind < 0.3:
        centre = rng.choice([-1.0, 1.0], 3) * (9.9e6, 9.9e6, 9e4)  # air ends 100 km down
        extent = 10.0 ** rng.uniform(-1.0, 5.0, 3)
    low = np.clip(centre - 0.5 * extent, [-1e7, -1e7, DEEPEST_AIR_M], 9.999999e6)
    high = np.clip(np.maximum(low + extent, np.nextafter(low, np.inf)), -1e7, 1e7)
    return [low.tolist(), high.tolist()]


def _size(rng: Rng) -> list[int]:
    return [int(rng.choice([1, 2, 8, 13, 24])), int(rng.choice([1, 2, 6, 14]))]


def _grid(rng: Rng) -> list[int]:
    """Draw a grid of few points, with a long side at times."""
    grid = rng.integers(2, 7, 3)
    if rng.random() < 0.2:
        grid[rng.integers(3)] = rng.choice([64, 1024])
    return [int(n) for n in grid]


def _wavelength_step(rng: Rng) -> float:
    """Draw a step that divides 400 nm; the finest ones take minutes, and are rare."""
    count = int(_choice(rng, (10, 16, 20, 40, 80, 80, 80, 160, 400)))
    return 400.0 / (8000 if rng.random() < 0.02 else count)


def _steps(rng: Rng) -> int:
    return int(_choice(rng, (1, 2, 3, 64, 1000, 5000)))


def _right(rng: Rng) -> dict[str, Any]:
    """Draw one or two keys of the picture's right part."""
    # Of a light only what every kind has; of the drops what goes with all others.
    fields = [
        (table, key)
        for table, key, _ in walk_fields()
        if (
            table.startswith(("camera", "atmosphere", "scattering", "render"))
            and table != "atmosphere.aerosol"  # whose sky would take minutes
            and key not in ("look", "projection")
        )
        or key in ("spectrum", "extinction", "seed")
    ]
    values = {}
    for index in rng.choice(len(fields), int(rng.integers(1, 3)), replace=False):
        table, key = fields[index]
        node: Node | None = ROOT
        for part in (*table.split("."), key):
            node = node and node.child(0 if part == "0" else part)
        if node is not None and key not in ("size_px", "theory"):
            values[f"{table}.{key}"] = draw(rng, node, f"{table}.{key}")
    return values


_SPECIAL: dict[str, Callable[[Rng], Any]] = {
    "camera.size_px": _size,
    "compare.right": _right,
    "droplets.box_m": _box,
    "droplets.radius.file": lambda rng: str(resource_dir("scenes") / "shower-sizes.csv"),
    "droplets.scattering_orders": lambda rng: "all" if rng.uniform() < 0.05 else "single",
    "droplets.skylight": lambda rng: bool(rng.uniform() < 0.05),
    "droplets.file": lambda rng: f"volume-{rng.integers(VOLUMES)}.npz",
    "droplets.grid": _grid,
    "ground.albedo": lambda rng: _choice(rng, (0.0, 1.0, float(rng.uniform()), *ALBEDOS)),
    "light.0.time": lambda rng: str(_choice(rng, _TIMES)),
    "light.0.spectrum": lambda rng: str(_choice(rng, _SPECTRA)),
    "render.samples": lambda rng: int(_choice(rng, (16, 100))),
    "render.steps": _steps,
    "render.wavelength_step_nm": _wavelength_step,
    "scattering.refractive_index": lambda rng: float(
        _choice(rng, (*INDICES, rng.uniform(*INDICES)))
    ),
    "scattering.orders": lambda rng: list(_choice(rng, ((1,), (2,), (1, 2)))),
}
"""Keys that are texts, are tied to others, or decide how long a frame takes."""


def _make_quick(rng: Rng, values: dict[str, Any]) -> None:
    """Leave what takes long: tables of many radii, second pictures and lights, fine steps, and
    pixels of a thousand rays each under a lamp, which has no disc to say that fewer do."""
    values.pop("compare", None)
    values.get("atmosphere", {}).pop("sky", None)
    values.get("atmosphere", {}).pop("aerosol", None)
    del values["light"][1:]
    if values["light"][0]["type"] == "point":
        values["camera"].pop("pixel", None)
    values.setdefault("render", {}).pop("steps", None)
    values["render"]["wavelength_step_nm"] = 40.0
    droplets = values["droplets"]
    droplets.pop("file", None)
    if "around_m" not in droplets:
        droplets.setdefault("box_m", _box(rng))
    droplets["radius"] = {"distribution": "constant", "radius_um": float(rng.uniform(1.0, 5000.0))}
    number = droplets.get("density", {}).get("number_per_m3", 1000.0)
    droplets["density"] = {"number_per_m3": number}


def _fit_droplets(rng: Rng, droplets: dict[str, Any]) -> None:
    """Make what was drawn key by key a whole: from a file, or with all that it needs."""
    if rng.random() < 0.8:
        droplets.pop("file", None)
    if "file" in droplets:
        for key in BY_PARTS:
            droplets.pop(key, None)
        return
    droplets.pop(str(_choice(rng, ("box_m", "around_m"))), None)
    node = ROOT.child("droplets")
    assert node is not None
    for key in ("radius", "density") if "around_m" in droplets else ("box_m", "radius", "density"):
        child = node.child(key)
        assert child is not None
        droplets.setdefault(key, draw(rng, child, f"droplets.{key}"))
    radius = droplets["radius"]
    if radius.get("min_um", 0.0) >= radius.get("max_um", math.inf):
        radius["min_um"], radius["max_um"] = 0.5 * (1.0 + radius["max_um"]), radius["min_um"] + 1.0
        radius["max_um"] = min(radius["max_um"], 5000.0)
    one_kind = radius["distribution"] == "constant" or radius.get("mixing") == "local"
    if not one_kind:
        droplets.setdefault("grid", _grid(rng))
    if radius["distribution"] == "gamma":
        _one_set_of_parameters(rng, radius)
    wanted = density_key(radius["distribution"], radius)
    if wanted is None:
        droplets.pop("density")
        return
    density = node.child("density")
    assert density is not None
    child = density.child(wanted)
    assert child is not None
    value = droplets["density"].get(wanted)
    droplets["density"] = {
        wanted: draw(rng, child, f"droplets.density.{wanted}") if value is None else value
    }


def _fit_light(rng: Rng, light: dict[str, Any]) -> None:
    """Place a light either by hand or by time and place, and leave the Moon's keys to the Moon."""
    if light["type"] != "sun":
        return
    if rng.random() < 0.2:
        light["spectrum"] = MOON
    if light.get("spectrum") != MOON:
        for key in LIT:
            light.pop(key, None)
    if rng.random() < 0.7 or light.get("spectrum") == MOON:  # by time it may be new
        for key in TIME_AND_PLACE:
            light.pop(key, None)
        return
    for key in FROM_TIME:
        light.pop(key, None)
    light.setdefault("time", str(_choice(rng, _TIMES)))
    light.setdefault("latitude_deg", float(_choice(rng, (-90.0, 0.0, 48.0, 90.0))))
    light.setdefault("longitude_deg", float(_choice(rng, (-180.0, 11.0, 180.0))))


def _fit_camera(rng: Rng, camera: dict[str, Any], lights: list[dict[str, Any]]) -> None:
    """Look at a light that there is, or by two angles."""
    kinds = {light["type"] for light in lights}
    lacking = {"sun": "sun", "lamp": "point"}.get(camera.get("look", ""))
    if rng.random() < 0.5 or (lacking is not None and lacking not in kinds):
        camera.pop("look", None)
    if "look" in camera:
        for key in LOOKED_AT:
            camera.pop(key, None)


def _fit_air(rng: Rng, values: dict[str, Any], camera: dict[str, Any]) -> None:
    """Have the air glow where there is air, haze in it, and the eye above the ground."""
    air = values.get("atmosphere", {})
    if not air.get("rayleigh", True):
        for key in ("sky", "ozone_du", "aerosol"):
            air.pop(key, None)
    haze = air.get("aerosol", {})
    if haze and rng.random() < 0.5:
        haze["model"] = "custom"
    if haze.get("model") != "custom":
        for key in FREE_AEROSOL:
            haze.pop(key, None)
    if air.get("sky") and "aerosol" in air:
        # A field of hazy air takes minutes: one, which is kept, stands for all.
        values["atmosphere"] = {"sky": True, "aerosol": {"model": "continental-clean"}}
        if "ground" in values:
            values["ground"] = {"albedo": 0.2}
    if "ground" in values:
        ground = values["ground"]
        if "position_m" not in camera:
            ground.pop("height_m", None)
        else:
            height = ground.get("height_m", 0.0)
            above = min(abs(camera["position_m"][2] - height), TOP_M)
            camera["position_m"][2] = height + (above if rng.random() < 0.9 else 1.1 * TOP_M)


def _fit_pixels(values: dict[str, Any], camera: dict[str, Any]) -> None:
    """Have pixels that are areas only where shaders draw them: for the reference each is thousands
    of rays, and a picture of them takes many minutes."""
    right = values.get("compare", {}).get("right", {})
    air = values.get("atmosphere", {})
    keys = {*air, *(key.rpartition(".")[2] for key in right)}
    lamps = any(light["type"] == "point" for light in values["light"])
    hazy = lamps and not keys.isdisjoint(("ozone_du", "aerosol"))
    box = values["droplets"].get("box_m")
    ground_m = values.get("ground", {}).get("height_m", 0.0)
    buried = ("ground" in values or "sky" in keys) and box is not None and box[0][2] < ground_m
    if hazy or buried:
        camera["pixel"] = "centre"
        right.update({key: "centre" for key in right if key == "camera.pixel"})


def _fit_medium(rng: Rng, scattering: dict[str, Any]) -> None:
    """Keep either sea water, at temperatures where its index is known, or an index; often neither,
    since exact theory then needs tables of its own."""
    dropped = ("salinity_g_kg", "refractive_index")
    for key in dropped if rng.random() < 0.5 else (_choice(rng, dropped),):
        scattering.pop(key, None)
    if scattering.get("salinity_g_kg"):
        scattering["water_temperature_c"] = _choice(rng, (0.0, 20.0, 30.0))


def _one_set_of_parameters(rng: Rng, radius: dict[str, Any]) -> None:
    """Keep either the moments of a gamma distribution or its formula's parameters."""
    moments = ("effective_radius_um", "effective_variance")
    formula = {"n0": 8000.0, "mu": 2.0, "lambda_per_mm": 4.0}
    if rng.random() < 0.5:
        for key in moments:
            radius.pop(key, None)
        for key, value in formula.items():
            radius.setdefault(key, value)
    else:
        for key in formula:
            radius.pop(key, None)
        for key, value in zip(moments, (200.0, 0.1), strict=True):
            radius.setdefault(key, value)
