"""Scenes from plain values, and plain values and TOML from scenes."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from rtbow.base.errors import InputError, cut
from rtbow.base.files import absolute
from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.air import ALBEDOS
from rtbow.scene.lights import FROM_TIME, spectrum_file
from rtbow.scene.model import Scene
from rtbow.scene.panorama import LENS_ALONE
from rtbow.scene.text.errors import Problem, explain, line_text, problem_of
from rtbow.scene.text.lines import Lines
from rtbow.scene.text.overrides import apply_overrides, flat, plain
from rtbow.scene.text.schema import MOST_KEY, toml_text


def scene_from_values(
    data: dict[str, Any], name: str, changes: Mapping[str, Any], lines: Lines | None = None
) -> Scene:
    """Check values, with some replaced, and make their scene.

    Args:
        data: as TOML gives them, paths absolute; changed in place.
        name: what messages call the scene.
        changes: plain values by dotted key; relative paths start at the current folder.
        lines: of the text that the values come from, for messages.

    Raises:
        InputError: keys or values that are not allowed.
    """
    before = plain(data) if changes else None
    apply_overrides(data, changes)
    resolve_paths(data, Path())
    scene = _validated(data, name, changes, lines, _Blame(before, changes) if before else None)
    if scene.compare is not None:
        scene = scene.with_right(_right_part(scene, data, name, changes, lines))
    return scene


def changed_scene(scene: Scene, changes: Mapping[str, object]) -> Scene:
    """Return a scene with some of its values replaced; None removes one.

    Args:
        scene: the scene; the new one keeps its source.
        changes: values by dotted key, as for :func:`rtbow.load_scene`.

    Raises:
        InputError: keys or values that are not allowed.
    """
    values = {str(key): plain(value) for key, value in changes.items()}
    made = scene_from_values(values_of(scene), scene.source_name, values)
    return made.with_source(scene.source_text, scene.source_name)


def values_of(scene: Scene, folder: Path | None = None) -> dict[str, Any]:
    """Return all values of a scene as TOML would give them.

    Defaults are filled in; what is None is left out.

    Args:
        scene: the scene.
        folder: paths of files inside it become relative to it; None leaves all absolute.
    """
    values: dict[str, Any] = plain(scene.model_dump(exclude_none=True))
    for light in values["light"]:
        if "time" in light:  # what follows from it is no value of its own
            for key in FROM_TIME:
                light.pop(key, None)
    if "look" in values["camera"]:
        for key in LOOKED_AT:
            values["camera"].pop(key)
    if scene.camera.whole_sphere:
        for key in LENS_ALONE:
            values["camera"].pop(key, None)
    if "around_m" in values["droplets"]:
        values["droplets"].pop("box_m")
    if "focal_length_mm" in values["camera"]:
        del values["camera"]["fov_deg"]
    if scene.compare is not None:
        values["compare"]["right"] = {
            key: toml_text(None) if value is None else value
            for key, value in values["compare"]["right"].items()
        }
    if folder is not None:
        root = folder.resolve()

        def relative(path: str) -> str:
            return Path(path).relative_to(root).as_posix() if root in Path(path).parents else path

        _with_paths(values, relative)
    return values


def scene_text(scene: Scene, folder: Path | None = None) -> str:
    """Write a scene as TOML that reads as an equal scene.

    Args:
        scene: the scene.
        folder: of the file; paths inside it are written relative to it.
    """
    import tomlkit  # drawing a scene needs no writer, which takes long to import

    return tomlkit.dumps(values_of(scene, folder))


def differences(origin: Scene, scene: Scene) -> dict[str, Any]:
    """Return overrides that turn a scene into another; None removes a value."""
    return dict(_differing(values_of(origin), values_of(scene), ""))


_KINDS = ("type", "distribution")
"""These keys decide which others a table may have."""


def _differing(before: Any, after: Any, place: str) -> Iterator[tuple[str, Any]]:
    if isinstance(before, dict) and isinstance(after, dict) and place != "compare.right":
        if any(before.get(key) != after.get(key) for key in _KINDS):
            yield place, after
            return
        for key in {**before, **after}:
            inner = f"{place}.{key}" if place else key
            yield from _differing(before.get(key), after.get(key), inner)
    elif place == "light" and len(before) == len(after):
        for number, (old, new) in enumerate(zip(before, after, strict=True)):
            yield from _differing(old, new, f"light.{number}")
    elif before != after:
        yield place, after


def resolve_paths(values: dict[str, Any], folder: Path) -> None:
    """Make the relative paths among a scene's values absolute, in place."""
    _with_paths(values, lambda path: absolute(folder / path), folder)


def scene_files(scene: Scene) -> tuple[str, ...]:
    """Return the paths of volumes, drop sizes and spectra that a scene names, in both its parts."""
    paths: list[str] = []

    def note(path: str) -> str:
        paths.append(spectrum_file(path) or path)
        return path

    _with_paths(values_of(scene), note)
    return tuple(paths)


def place_of(scene: Scene, key: str) -> str:
    """Say where a scene's value was given, for messages about what it names.

    Args:
        scene: the scene; its text ends with what was typed after ``--set``.
        key: the value's, dotted.
    """
    parts = key.split(".")
    typed = _TYPED.findall(scene.source_text)
    for near in (".".join(parts[:count]) for count in range(len(parts), 0, -1)):
        if near in typed:
            return f"--set {near}"
    line = line_text(Lines(scene.source_text), parts)
    if line == line_text(Lines(scene.source_text), parts[:-1]):
        line = ""  # the table's own, which may lack the key
    return f"{scene.source_name}: {line}{key}"


_TYPED = re.compile(r"(?m)^# --set ([^=\s]+)=")


def _with_paths(
    values: dict[str, Any], change: Callable[[str], str], folder: Path | None = None
) -> None:
    """Change the paths of files among a scene's values, in place.

    Args:
        values: the scene's.
        change: gives another path; a column may follow it, as in ``lamp.csv#3``.
        folder: where paths start that are relative; the current folder if None.
    """
    _paths_in(values, change, "", folder)
    compare = values.get("compare")
    right = compare.get("right") if isinstance(compare, dict) else None
    if isinstance(right, dict):
        _paths_in(right, change, "", folder)


_HOLDS_PATHS = r"droplets(\.radius)?|light(\.[0-9]+)?|ground"
"""Tables that name files."""


def _paths_in(
    table: dict[str, Any], change: Callable[[str], str], place: str, folder: Path | None
) -> None:
    """Change paths in a table and those inside it; keys may be dotted, as in ``compare.right``."""
    for key, value in table.items():
        inner = f"{place}.{key}" if place else key
        if isinstance(value, dict) and re.fullmatch(_HOLDS_PATHS, inner):
            _paths_in(value, change, inner, folder)
        elif isinstance(value, list) and inner == "light":
            for light in value:
                if isinstance(light, dict):
                    _paths_in(light, change, "light.0", folder)
        elif isinstance(value, str) and value:
            spectrum = re.fullmatch(r"light\.[0-9]+\.spectrum|ground\.albedo", inner)
            if inner in ("droplets.file", "droplets.radius.file") or (
                spectrum and value not in ALBEDOS and spectrum_file(value, folder)
            ):
                table[key] = change(value)


def _validated(
    data: dict[str, Any],
    name: str,
    changes: Collection[str],
    lines: Lines | None = None,
    blame: Callable[[Problem], str] | None = None,
) -> Scene:
    try:
        return Scene.model_validate(data)
    except ValidationError as error:
        raise InputError(explain(error, name, changes, lines, blame)) from None


class _Blame:
    """Tells problems of a scene's text from those that overrides of other keys cause.

    Args:
        data: values of the text alone.
        changes: the overrides.
    """

    def __init__(self, data: dict[str, Any], changes: Mapping[str, Any]) -> None:
        self._data, self._changes = data, changes
        self._without = cache(self._problems_without)

    def __call__(self, problem: Problem) -> str:
        """Return how the message begins, such as ``--set light.0.type``."""
        if problem in self._without(*self._changes):
            return ""
        causes = [key for key in self._changes if problem not in self._without(key)]
        return f"--set {cut(causes[0], MOST_KEY)}" if len(causes) == 1 else "--set"

    def _problems_without(self, *keys: str) -> set[Problem]:
        data = plain(self._data)
        apply_overrides(data, {k: v for k, v in self._changes.items() if k not in keys})
        try:
            Scene.model_validate(data)
        except ValidationError as error:
            return {problem_of(one) for one in error.errors(include_url=False)}
        return set()


def _right_part(
    scene: Scene,
    data: dict[str, Any],
    name: str,
    overrides: Collection[str],
    lines: Lines | None,
) -> Scene:
    """Return the scene of the right part of ``compare``, whose keys are overrides of the left.

    Args:
        scene: the scene as it stands.
        data: its values.
        name: what messages call it.
        overrides: dotted keys that came from ``--set``.
        lines: of the scene's text.

    Raises:
        InputError: a key that no scene has, one that both parts must share, or a wrong value.
    """
    assert scene.compare is not None
    # TOML has no null; a value that is left out is written as --set writes it.
    changes = {
        key: None if value == toml_text(None) else value for key, value in flat(scene.compare.right)
    }

    def typed(key: str) -> str:
        """Return a key as it was typed: after ``--set``, or in the file."""
        whole = f"compare.right.{key}"
        if any(f"{whole}.".startswith(f"{o}.") for o in overrides):
            return f"--set {whole}"
        return f"{name}: {line_text(lines, ('compare', 'right', key))}{whole}"

    for key in changes:
        if f"{key}.".startswith(("compare.", "camera.size_px.", "camera.projection.")):
            raise InputError(f"{typed(key)}: both parts share it; leave it out of compare.right")
    rest = plain({key: value for key, value in data.items() if key != "compare"})
    try:
        apply_overrides(rest, changes)
        right = _validated(rest, name, changes)
    except InputError as error:
        right_table = line_text(lines, ("compare", "right"))
        text = re.sub(r"(?m)^--set: ", f"{name}: {right_table}compare.right: ", str(error))
        text = re.sub(r"(?m)^--set ([^ :;=]+)", lambda found: typed(found[1]), text)
        raise InputError(text) from None
    if right.camera.size_px != scene.camera.size_px:  # a whole camera table may lack it
        raise InputError(
            f"{name}: compare.right.camera: both parts share camera.size_px; change single keys,"
            " such as camera.fov_deg"
        )
    return right.with_source("", f"{name}, right part")
