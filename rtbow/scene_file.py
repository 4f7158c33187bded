"""Finds and reads scene files, applies overrides, and reports what is wrong in them."""

import difflib
import os
import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from rtbow.errors import InputError
from rtbow.resources import resource_dir
from rtbow.scene import Density, Light, Scene, density_key
from rtbow.scene_errors import explain
from rtbow.scene_schema import ROOT, Node, suggestion, toml_text

DEFAULT_SCENE = "default"


def load_scene(
    name_or_path: str | Path | None = None, overrides: Mapping[str, object] | None = None
) -> Scene:
    """Read a scene file or a built-in scene, with some of its values replaced.

    Args:
        name_or_path: a path that ends with ``.toml``, or the name of a built-in scene; None is
            the default scene.
        overrides: values by dotted key, such as ``{"light.0.altitude_deg": 5}``. Paths among them
            are relative to the current folder, those in the file to the file.

    Raises:
        InputError: no such scene, no valid TOML, or values that are not allowed.
    """
    name = DEFAULT_SCENE if name_or_path is None else str(name_or_path)
    path = _find_scene(name)
    return scene_from_text(_read_text(path, name), name, path.parent, overrides)


def scene_from_text(
    text: str,
    name: str = "scene",
    folder: Path | None = None,
    overrides: Mapping[str, object] | None = None,
) -> Scene:
    """Make a scene from TOML text.

    Args:
        text: the scene.
        name: what messages call it.
        folder: where relative paths in the text start; None is the current folder.
        overrides: as in :func:`load_scene`.

    Raises:
        InputError: no valid TOML, or values that are not allowed.
    """
    data = _parse_toml(text, name)
    _resolve_paths(data, folder or Path())
    changes = {str(key): _plain(value) for key, value in (overrides or {}).items()}
    _apply_overrides(data, changes)
    _resolve_paths(data, Path())  # paths of the file are absolute by now
    scene = _validated(data, name, changes)
    if scene.compare is not None:
        scene = scene.with_right(_right_part(scene, data, name, changes))
    if changes:
        text = text if text.endswith("\n") or not text else f"{text}\n"
        text += "".join(f"# --set {key}={toml_text(value)}\n" for key, value in changes.items())
    return scene.with_source(text, name)


def _validated(data: dict[str, Any], name: str, changes: Collection[str]) -> Scene:
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise InputError(explain(error, name, changes)) from None


def _right_part(scene: Scene, data: dict[str, Any], name: str, overrides: Collection[str]) -> Scene:
    """Make the scene of the right part of ``compare``: its keys are overrides of the left.

    Args:
        scene: the scene as it stands.
        data: its values.
        name: what messages call it.
        overrides: dotted keys that came from ``--set``.

    Raises:
        InputError: a key that no scene has, one that both parts must share, or a wrong value.
    """
    assert scene.compare is not None
    changes = dict(_flat(scene.compare.right))

    def typed(key: str) -> str:
        """Name a key as it was typed: after ``--set``, or in the file."""
        key = f"compare.right.{key}"
        by_override = any(f"{key}.".startswith(f"{o}.") for o in overrides)
        return f"--set {key}" if by_override else f"{name}: {key}"

    for key in changes:
        if f"{key}.".startswith(("compare.", "camera.size_px.")):
            raise InputError(f"{typed(key)}: both parts share it; leave it out of compare.right")
    rest = _plain({key: value for key, value in data.items() if key != "compare"})
    try:
        _apply_overrides(rest, changes)
        right = _validated(rest, name, changes)
    except InputError as error:
        text = re.sub(r"(?m)^--set: ", f"{name}: compare.right: ", str(error))
        text = re.sub(r"(?m)^--set ([^ :;=]+)", lambda found: typed(found[1]), text)
        raise InputError(text) from None
    if right.camera.size_px != scene.camera.size_px:  # a whole camera that leaves it out
        raise InputError(
            f"{name}: compare.right.camera: both parts share camera.size_px; change single keys,"
            " such as camera.fov_deg"
        )
    return right.with_source("", f"{name}, right part")


def _flat(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values of nested tables."""
    # A stack of our own: tables may be nested more deeply than Python's.
    waiting = list(reversed(list(table.items())))
    while waiting:
        key, value = waiting.pop()
        if isinstance(value, dict) and value:
            waiting += [(f"{key}.{inner}", item) for inner, item in reversed(list(value.items()))]
        else:
            yield key, value


def builtin_scenes() -> dict[str, Path]:
    """Return the built-in scenes' files by name, sorted; names in subfolders hold a slash."""
    folder = resource_dir("scenes")
    found = {p.relative_to(folder).with_suffix("").as_posix(): p for p in folder.rglob("*.toml")}
    return dict(sorted(found.items()))


def scene_title(path: Path) -> str:
    """Return a scene file's one-line description: its first comment line, or nothing.

    Raises:
        InputError: the file cannot be read.
    """
    for line in _read_text(path, path.name).splitlines():
        stripped = line.strip()
        if stripped.startswith("#"):
            return stripped.lstrip("# \t")
        if stripped:
            break
    return ""


def parse_set(text: str) -> tuple[str, object]:
    """Split ``key.path=value`` into key and value.

    The value is TOML (``5``, ``[640, 360]``, ``true``, ``"E490"``); what is not, such as ``FL2``
    or ``rain/shower.npz``, is taken as text.

    Raises:
        InputError: no key, no value, or a list, table or quoted text that does not end.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value):
        raise InputError(f"--set {text}: write key.path=value, such as light.0.altitude_deg=5")
    try:
        parsed = tomllib.loads(f"value = {value}")
    except (ValueError, RecursionError) as error:
        if value[0] in "[{\"'":
            raise InputError(f"--set {key}: {value} is not a TOML value: {error}") from None
        return key, value
    if parsed.keys() != {"value"}:  # a line break let a second key in
        raise InputError(f"--set {key}: give one value, on one line")
    return key, parsed["value"]


def _find_scene(name: str) -> Path:
    """Return the file of a scene, which exists if the scene is a built-in one."""
    if name.lower().endswith(".toml"):
        return Path(name)
    scenes = builtin_scenes()
    if name in scenes:
        return scenes[name]
    if os.path.isdir(name):
        raise InputError(f"{name} is a folder; name a .toml file in it, or a built-in scene")
    near = difflib.get_close_matches(name, scenes, n=3, cutoff=0.5)
    message = f"there is no built-in scene named {toml_text(name)}; "
    if near:
        message += f"did you mean {' or '.join(near)}?"
    else:
        message += f"the built-in scenes are {', '.join(scenes)}"
    if os.path.isfile(f"{name}.toml"):
        message += f". To read your own file, write {name}.toml"
    elif os.path.isfile(name):
        message += f". The file {name} can be read once its name ends with .toml"
    raise InputError(message)


def _read_text(path: Path, name: str) -> str:
    try:
        return path.read_bytes().decode("utf-8-sig")
    except FileNotFoundError:
        message = "there is no such file; check the path"
        if path.stem in builtin_scenes():
            message += f" (the built-in scene is called {path.stem}, without .toml)"
    except IsADirectoryError:
        message = "is a folder; name a scene file in it"
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        message = f"line {line}: is not UTF-8 text; save the file as UTF-8"
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = error.strerror if isinstance(error, OSError) else error
        message = f"cannot be read: {reason}"
    raise InputError(f"{name}: {message}") from None


def _parse_toml(text: str, name: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except RecursionError:
        reason, line, column = "lists or tables are nested too deeply", 0, 0
    except ValueError as error:
        known = isinstance(error, tomllib.TOMLDecodeError)
        reason, line, column = str(error) if known else "a number has too many digits", 0, 0
        place = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)$", reason)
        if place:
            reason = reason[: place.start()]
            if place[1]:
                line, column = int(place[1]), int(place[2])
            else:
                line, column = text.count("\n") + 1, len(text) - text.rfind("\n")
    where = f"line {line}, column {column}: " if line else ""
    raise InputError(f"{name}: {where}not valid TOML: {reason}") from None


def _plain(value: object) -> Any:
    """Return a Python value as TOML would give it: paths as text, tuples and arrays as lists."""
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    tolist = getattr(value, "tolist", None)  # NumPy scalars and arrays, without importing NumPy
    return tolist() if callable(tolist) else value


def _resolve_paths(data: dict[str, Any], folder: Path) -> None:
    """Make the relative paths among a scene's values absolute, in place."""
    _resolve_in(data, folder, "")
    compare = data.get("compare")
    right = compare.get("right") if isinstance(compare, dict) else None
    if isinstance(right, dict):
        _resolve_in(right, folder, "")


def _resolve_in(table: dict[str, Any], folder: Path, place: str) -> None:
    """Do so in one table and those inside it; keys may be dotted, as in ``compare.right``."""
    for key, value in table.items():
        here = f"{place}.{key}" if place else key
        if isinstance(value, dict) and re.fullmatch(r"droplets|light(\.[0-9]+)?", here):
            _resolve_in(value, folder, here)
        elif isinstance(value, list) and here == "light":
            for light in value:
                if isinstance(light, dict):
                    _resolve_in(light, folder, "light.0")
        elif isinstance(value, str) and value:
            spectrum = re.fullmatch(r"light\.[0-9]+\.spectrum", here)
            if here == "droplets.file" or (spectrum and value.lower().endswith(".csv")):
                table[key] = os.path.abspath(folder / value)


def _apply_overrides(data: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Put all overrides into a scene's values, in place; whole tables before keys inside them.

    Raises:
        InputError: keys that no scene has, or list items that this one lacks.
    """
    _drop_replaced(data, changes)
    problems = []
    for key in sorted(changes, key=lambda key: key.count(".")):
        try:
            _apply(data, key, _plain(changes[key]))  # a copy: later keys may go inside it
        except InputError as error:
            problems.append(str(error))
    if problems:
        raise InputError("\n".join(problems))


def _drop_replaced(data: dict[str, Any], changes: Mapping[str, Any]) -> None:
    """Take out what a newly chosen kind of light, distribution or volume file replaces."""
    _drop_other_lights_keys(data.get("light"), changes)
    droplets = data.get("droplets")
    if not isinstance(droplets, dict):
        return
    if changes.get("droplets.file") is not None:
        for key in ("box_m", "grid", "radius", "density"):
            if not any(f"{change}.".startswith(f"droplets.{key}.") for change in changes):
                droplets.pop(key, None)  # one that is itself overridden is left for validation
    whole = changes.get("droplets.radius")
    chosen = changes.get(
        "droplets.radius.distribution",
        whole.get("distribution") if isinstance(whole, dict) else None,
    )
    droplets_node = ROOT.child("droplets")
    kinds = droplets_node and droplets_node.child("radius")
    kind = kinds and kinds.kind(chosen)
    radius, density = droplets.get("radius"), droplets.get("density")
    if not kinds or not kind or kind is kinds or not isinstance(radius, dict):
        return  # no distribution chosen, or one that validation will refuse
    if chosen == radius.get("distribution"):
        return
    for key in kinds.fields.keys() - kind.fields.keys():
        radius.pop(key, None)
    if isinstance(density, dict):
        for key in Density.model_fields.keys() - {density_key(str(chosen))}:
            density.pop(key, None)


def _drop_other_lights_keys(lights: object, changes: Mapping[str, Any]) -> None:
    kinds = Node.of(Light)
    for number, light in enumerate(lights if isinstance(lights, list) else ()):
        chosen = changes.get(f"light.{number}.type")
        kind = kinds.kind(chosen)
        if kind is kinds or not isinstance(light, dict) or light.get("type", "sun") == chosen:
            continue  # no kind chosen, or one that validation will refuse
        for key in kinds.fields.keys() - kind.fields.keys():
            light.pop(key, None)


def _apply(data: dict[str, Any], key: str, value: object) -> None:
    """Put one override into a scene's values, in place, making the tables it needs."""
    node: Node = ROOT
    at: Any = data
    parts = key.split(".")
    if not all(parts):
        raise InputError(f"--set {key}: write a key such as light.0.altitude_deg")
    for depth, part in enumerate(parts):
        here = ".".join(parts[:depth])
        if node.annotation == dict[str, Any]:
            at[".".join(parts[depth:])] = value  # a free table: keys of another scene
            return
        if node.models:
            slot: str | int = part
            child = node.child(part)
            if child is None:
                unknown = f"{here}.{part}" if here else part
                raise InputError(
                    f"--set {key}: unknown key {unknown}; {suggestion(here, node, part)}"
                )
            if not isinstance(at, dict):
                return  # the file has no table here; validation says so
            if depth < len(parts) - 1 and at.get(part) is None:
                is_table = child.models or child.annotation == dict[str, Any]
                at[part] = {} if is_table else _plain(child.default or ())
        elif node.items:
            if not isinstance(at, list):
                return
            slot = _list_index(key, here, part, len(at))
            child = node.child(slot) or node
        else:
            raise InputError(
                f"--set {key}: {here} is a single value and has nothing inside it; write {here}=…"
            )
        if depth == len(parts) - 1:
            at[slot] = value
        else:
            node, at = child, at[slot]


def _list_index(key: str, here: str, part: str, count: int) -> int:
    items = f"{count} item{'' if count == 1 else 's'}"
    if not count:
        raise InputError(f"--set {key}: {here} is not given; set it as a whole")
    if not re.fullmatch(r"0|[1-9][0-9]{0,8}", part):
        raise InputError(
            f"--set {key}: {here} is a list of {items}; name one by its number, such as {here}.0"
        )
    if int(part) >= count:
        raise InputError(f"--set {key}: {here} has {items}; the last is {here}.{count - 1}")
    return int(part)
