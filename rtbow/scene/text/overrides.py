"""Values of a scene replaced by dotted key, for ``--set``, ``compare`` and the panel."""

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

from rtbow.base.errors import InputError, cut
from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.droplets import BY_PARTS, Density
from rtbow.scene.lens import LENS_KEYS
from rtbow.scene.lights import AT, TIME_AND_PLACE, Light
from rtbow.scene.panorama import PANORAMA, make_whole
from rtbow.scene.radius import density_key, replaced_keys
from rtbow.scene.text.schema import MOST_KEY, ROOT, Node, suggestion


def plain(value: object) -> Any:
    """Return a Python value as TOML would give it: paths as text, tuples and arrays as lists."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    tolist = getattr(value, "tolist", None)  # NumPy scalars and arrays, without importing NumPy
    return tolist() if callable(tolist) else value


def flat(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values of nested tables."""
    # Not by recursion: tables may be nested more deeply than Python's stack allows.
    waiting = list(reversed(list(table.items())))
    while waiting:
        key, value = waiting.pop()
        if isinstance(value, dict) and value:
            waiting += [(f"{key}.{inner}", item) for inner, item in reversed(list(value.items()))]
        else:
            yield key, value


def apply_overrides(data: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Put overrides into a scene's values, in place: whole tables before keys inside them.

    Raises:
        InputError: keys that no scene has, or list items that this one lacks.
    """
    _drop_replaced(data, changes)
    problems = []
    for key in sorted(changes, key=lambda key: key.count(".")):
        try:
            _apply(data, key, plain(changes[key]))  # a copy: later keys may go inside it
        except InputError as error:
            problems.append(str(error))
    if problems:
        raise InputError("\n".join(problems))


def _drop_replaced(data: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Remove what a newly chosen kind of light, distribution or volume file replaces."""
    _drop_other_lights_keys(data.get("light"), changes)
    _drop_times(data.get("light"), changes)
    _drop_either(data.get("camera"), changes, "camera", ("look",), LOOKED_AT)
    _drop_lens(data.get("camera"), changes)
    _drop_projection(data.get("camera"), changes)
    droplets = data.get("droplets")
    if not isinstance(droplets, dict):
        return
    _drop_either(droplets, changes, "droplets", ("around_m",), ("box_m",))
    if changes.get("droplets.file") is not None:
        for key in BY_PARTS:
            if not any(f"{change}.".startswith(f"droplets.{key}.") for change in changes):
                droplets.pop(key, None)  # validation refuses one that is overridden
    if isinstance(droplets.get("radius"), dict):
        _drop_other_distributions_keys(droplets, droplets["radius"], changes)


def _drop_other_distributions_keys(
    droplets: dict[str, Any], radius: dict[str, Any], changes: Mapping[str, Any]
) -> None:
    """Remove what a newly chosen distribution, or other parameters of the same one, replace."""
    whole = changes.get("droplets.radius")
    given = dict(whole) if isinstance(whole, dict) else {}
    given |= {
        key.removeprefix("droplets.radius."): value
        for key, value in changes.items()
        if key.startswith("droplets.radius.") and value is not None
    }
    kinds = ROOT.child("droplets")
    kinds = kinds and kinds.child("radius")
    chosen = given.get("distribution", radius.get("distribution"))
    kind = kinds and kinds.kind(chosen)
    if not kinds or not kind or kind is kinds:
        return  # no distribution chosen, or one that validation refuses
    replaced = replaced_keys(str(chosen), given)
    if chosen == radius.get("distribution") and not replaced:
        return
    for key in (kinds.fields.keys() - kind.fields.keys()) | {*replaced}:
        radius.pop(key, None)
    density = droplets.get("density")
    if isinstance(density, dict):
        for key in Density.model_fields.keys() - {density_key(str(chosen), given)}:
            density.pop(key, None)


def _drop_other_lights_keys(lights: object, changes: Mapping[str, Any]) -> None:
    kinds = Node.of(Light)
    for number, light in enumerate(lights if isinstance(lights, list) else ()):
        chosen = changes.get(f"light.{number}.type")
        kind = kinds.kind(chosen)
        if kind is kinds or not isinstance(light, dict) or light.get("type", "sun") == chosen:
            continue  # no kind chosen, or one that validation refuses
        for key in kinds.fields.keys() - kind.fields.keys():
            light.pop(key, None)


def _drop_lens(camera: object, changes: Mapping[str, Any]) -> None:
    """Remove the lens of a camera that gets a field of view, and the other way round."""
    if not isinstance(camera, dict):
        return
    given = {key: changes[f"camera.{key}"] for key in ("fov_deg", *LENS_KEYS)
             if f"camera.{key}" in changes}  # fmt: skip
    if given.get("fov_deg") is not None:
        gone: tuple[str, ...] = LENS_KEYS
    elif given.get("focal_length_mm") is not None:
        gone = ("fov_deg",)
    else:
        gone = ("sensor_mm",) if "focal_length_mm" in given else ()
    for key in gone:
        if key not in given:
            camera.pop(key, None)


def _drop_projection(camera: object, changes: Mapping[str, Any]) -> None:
    """Remove what a panorama has no use for from a camera that newly is one."""
    chosen = changes.get("camera.projection") == PANORAMA
    if chosen and isinstance(camera, dict) and camera.get("projection") != PANORAMA:
        keys = {*camera, *LOOKED_AT, "look", "size_px"}
        make_whole(camera, {key for key in keys if _is_set(f"camera.{key}", changes)})


def _drop_times(lights: object, changes: Mapping[str, Any]) -> None:
    """Remove the time of lights that are placed by hand, and the place of those that get a time."""
    for number, light in enumerate(lights if isinstance(lights, list) else ()):
        if not isinstance(light, dict):
            continue
        given = {key for key in (*AT, "time") if changes.get(f"light.{number}.{key}") is not None}
        if "time" in given:
            for key in set(AT) - given:
                light.pop(key, None)
        elif given:
            for key in TIME_AND_PLACE:
                light.pop(key, None)


def _drop_either(
    table: object,
    changes: Mapping[str, Any],
    path: str,
    one: tuple[str, ...],
    other: tuple[str, ...],
) -> None:
    """Remove the one of two ways to say something where the other is newly chosen."""
    if not isinstance(table, dict):
        return
    given = {key for key in (*one, *other) if _is_set(f"{path}.{key}", changes)}
    for chosen, replaced in ((one, other), (other, one)):
        if given.intersection(chosen):
            for key in set(replaced) - given:
                table.pop(key, None)


def _is_set(key: str, changes: Mapping[str, Any]) -> bool:
    """Whether a key, or an item of its list, is given a value."""
    return any(f"{name}.".startswith(f"{key}.") and changes[name] is not None for name in changes)


def _apply(data: dict[str, Any], key: str, value: object) -> None:
    """Put an override into a scene's values, in place; missing tables are added."""
    node: Node = ROOT
    at: Any = data
    parts, said = key.split("."), cut(key, MOST_KEY)
    if not all(parts):
        raise InputError(f"--set {said}: write a key such as light.0.altitude_deg")
    for depth, part in enumerate(parts):
        here = ".".join(parts[:depth])
        if node.annotation == dict[str, Any]:
            at[".".join(parts[depth:])] = value  # a free table: keys of another scene
            return
        if node.models:
            slot: str | int = part
            child = node.child(part)
            if child is None:
                unknown = cut(f"{here}.{part}" if here else part, MOST_KEY)
                raise InputError(
                    f"--set {said}: unknown key {unknown}; {suggestion(here, node, part)}"
                )
            if not isinstance(at, dict):
                return  # the file has no table here; validation says so
            if depth < len(parts) - 1 and at.get(part) is None:
                is_table = child.models or child.annotation == dict[str, Any]
                at[part] = {} if is_table else plain(child.default or ())
        elif node.items:
            if not isinstance(at, list):
                return
            slot = _list_index(key, here, part, len(at))
            child = node.child(slot) or node
        else:
            raise InputError(
                f"--set {said}: {here} is a single value and has nothing inside it; write {here}=…"
            )
        if depth == len(parts) - 1:
            at[slot] = value
        else:
            node, at = child, at[slot]


def _list_index(key: str, here: str, part: str, count: int) -> int:
    said = cut(key, MOST_KEY)
    items = f"{count} item{'' if count == 1 else 's'}"
    if not count:
        raise InputError(f"--set {said}: {here} is not given; set it as a whole")
    if not re.fullmatch(r"0|[1-9][0-9]{0,8}", part):
        raise InputError(
            f"--set {said}: {here} is a list of {items}; name one by its number, such as {here}.0"
        )
    if int(part) >= count:
        raise InputError(f"--set {said}: {here} has {items}; the last is {here}.{count - 1}")
    return int(part)
