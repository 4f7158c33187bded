"""Reads scene files, and overrides as they are typed after ``--set``."""

import difflib
import os
import re
import tomllib
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO

from rtbow.base.errors import InputError, cut, notice, shown_path
from rtbow.base.files import read_limited
from rtbow.base.resources import resource_dir
from rtbow.scene.model import Scene
from rtbow.scene.text.bounds import MAX_TEXT_BYTES, check_text, check_values
from rtbow.scene.text.lines import Lines
from rtbow.scene.text.numbers import remedy_in_line
from rtbow.scene.text.overrides import plain
from rtbow.scene.text.schema import MOST_KEY, toml_text
from rtbow.scene.text.sun import SunAt, placed_sun
from rtbow.scene.text.values import resolve_paths, scene_from_values

DEFAULT_SCENE = "default"
_NOTED = "# --set "
"""What stands before an override at the end of a scene's text."""
_MOST_REASON = 120
"""Characters of the parser's message, which may quote a whole key."""


def load_scene(
    name_or_path: str | os.PathLike[str] | None = None,
    overrides: Mapping[str, object] | None = None,
    sun: SunAt | str | tuple[float, float, str | datetime] | None = None,
) -> Scene:
    """Read a scene file or a built-in scene, with some of its values replaced.

    Args:
        name_or_path: the name of a built-in scene, or a path, whose ``.toml`` may be left out;
            the default scene if None.
        overrides: values by dotted key, such as ``{"light.0.altitude_deg": 5}``. Paths among them
            are relative to the current folder, those in the file to the file.
        sun: a place and a time that put the first sun where it is seen from there then, instead of
            its altitude and azimuth: ``"59.9,10.7,2026-07-01T19:30+02:00"``, latitude and longitude
            in degrees, north and east positive; or a tuple of the two and a text or datetime. A
            time without an offset is in UTC.

    Raises:
        InputError: no such scene, no valid TOML, values that are not allowed, or arguments of
            another type.
    """
    if not isinstance(name_or_path, str | os.PathLike | None):
        raise InputError(
            f"load_scene takes a scene's name or path, not a value of type"
            f" {type(name_or_path).__name__}; pass text or a Path, such as"
            f' load_scene("{DEFAULT_SCENE}")'
        )
    name, path = _find_scene(DEFAULT_SCENE if name_or_path is None else str(name_or_path))
    return scene_from_text(_read_text(path, name), name, path.parent, overrides, sun)


def sun_overrides(
    name: str | None, overrides: Mapping[str, object], sun: SunAt
) -> dict[str, object]:
    """Give the overrides that place a scene's first sun by place and time.

    Args:
        name: as for :func:`load_scene`.
        overrides: the others.
        sun: a place and a time.

    Raises:
        InputError: no such scene, no valid TOML, no sun, or one that others of the overrides place.
    """
    called, path = _find_scene(DEFAULT_SCENE if name is None else name)
    data = _parse_toml(_read_text(path, called), called)
    return placed_sun(data, overrides, sun, called)


def scene_from_text(
    text: str,
    name: str = "scene",
    folder: Path | None = None,
    overrides: Mapping[str, object] | None = None,
    sun: object = None,
) -> Scene:
    """Make a scene from TOML text.

    Args:
        text: the scene.
        name: what messages call it.
        folder: where relative paths in the text start; the current folder if None.
        overrides: as in :func:`load_scene`.
        sun: as in :func:`load_scene`.

    Raises:
        InputError: no valid TOML, or values that are not allowed.
    """
    data = _parse_toml(text, name)
    resolve_paths(data, folder or Path())
    changes = _plain_overrides(overrides)
    if sun is not None:
        changes |= placed_sun(data, changes, SunAt.of(sun), name)
    scene = scene_from_values(data, name, changes, Lines(text))
    return scene.with_source(with_overrides_noted(text, changes), name)


def check_overrides(overrides: Mapping[str, object]) -> None:
    """Raise InputError for values that no TOML text could hold."""
    for key, value in overrides.items():
        try:
            check_values(value)
        except InputError as error:
            raise InputError(f"--set {cut(str(key), MOST_KEY)}: {error}") from None


def scene_from_stream(
    stream: BinaryIO, name: str, overrides: Mapping[str, object], sun: object = None
) -> Scene:
    """Make a scene from what a stream holds, such as standard input.

    Args:
        stream: its bytes; relative paths in the scene start at the current folder.
        name: what messages call it.
        overrides: as in :func:`load_scene`.
        sun: as in :func:`load_scene`.

    Raises:
        InputError: no UTF-8 text, no valid TOML, or values that are not allowed.
    """
    try:
        data = stream.read(MAX_TEXT_BYTES + 1)
        if len(data) > MAX_TEXT_BYTES:
            raise InputError(f"{name}: longer than {MAX_TEXT_BYTES >> 20} MiB: this is no scene")
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: {_not_text(error)}") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read: {error.strerror}") from None
    return scene_from_text(text, name, None, overrides, sun)


def _plain_overrides(overrides: Mapping[str, object] | None) -> dict[str, Any]:
    if overrides is None:
        return {}
    if not isinstance(overrides, Mapping):
        raise InputError(
            f"overrides are of type {type(overrides).__name__}; must be a dict of dotted keys and"
            ' values, such as {"light.0.altitude_deg": 5}'
        )
    check_overrides(overrides)
    try:
        return {str(key): plain(value) for key, value in overrides.items()}
    except RecursionError:
        raise InputError("overrides: a value holds itself, or is nested too deeply") from None


def with_overrides_noted(text: str, overrides: Mapping[str, object]) -> str:
    """Return a scene's text with overrides as comments ``# --set key=value`` at its end."""
    if overrides and text and not text.endswith("\n"):
        text += "\n"
    typed = (typed_override(key, value) for key, value in overrides.items())
    return text + "".join(f"{_NOTED}{override}\n" for override in typed)


def noted_overrides(text: str) -> dict[str, object]:
    """Return the overrides that :func:`with_overrides_noted` left at the end of a scene's text.

    Raises:
        InputError: what stands there was changed, and is no override any more.
    """
    noted: list[str] = []
    for line in reversed(text.splitlines()):
        if not line.startswith(_NOTED):
            break
        noted.insert(0, line.removeprefix(_NOTED))
    return dict(parse_set(override) for override in noted)


def scene_of_frame(text: str, name: str, frame: str | os.PathLike[str]) -> Scene:
    """Make the scene of a frame from what the frame's metadata hold.

    Args:
        text: the scene's text, with overrides at its end.
        name: of the scene: a built-in scene's, a path, or nothing where it is not known. Relative
            paths in the text start at that scene's folder, else at the frame's.
        frame: path of the frame, for messages.

    Raises:
        InputError: no valid scene any more, or a file that it names is not where it was.
    """
    builtin = builtin_scenes().get(name)
    folder = Path(frame).parent
    if builtin is not None:
        folder = builtin.parent
    elif name.lower().endswith(".toml"):
        folder = Path(name).parent
    return scene_from_text(text, f"{shown_path(frame)} (its scene)", folder, noted_overrides(text))


def typed_override(key: str, value: object) -> str:
    """Return an override as it is typed after ``--set``: :func:`parse_set` reads it back."""
    return f"{key}={toml_text(value)}"


def builtin_scenes() -> dict[str, Path]:
    """Return the files of the built-in scenes by name, sorted; a subfolder is part of the name."""
    folder = resource_dir("scenes")
    paths = {p.relative_to(folder).with_suffix("").as_posix(): p for p in folder.rglob("*.toml")}
    return dict(sorted(paths.items()))


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
    or ``rain/shower.npz``, is text. ``none`` is None, which removes the value.

    Raises:
        InputError: no key, no value, or a list, table or quoted text that does not end.
    """
    key, equals, value = (part.strip() for part in text.partition("="))
    if not (key and equals and value):
        raise InputError(f"--set {cut(text)}: write key.path=value, such as light.0.altitude_deg=5")
    if value == toml_text(None):
        return key, None
    said = cut(key, MOST_KEY)
    try:
        parsed = _values(f"value = {value}")
    except InputError as error:
        if value[0] in "[{\"'":
            raise InputError(f"--set {said}: {cut(value)} is not a TOML value: {error}") from None
        return key, value
    if parsed.keys() != {"value"}:  # a line break let a second key in
        raise InputError(f"--set {said}: give one value, on one line")
    return key, parsed["value"]


def is_scene_name(name: str) -> bool:
    """Whether a name is a scene's: a built-in one, or a file's, with or without its suffix."""
    ends = name.lower().endswith(".toml")
    return ends or name in builtin_scenes() or os.path.isfile(f"{name}.toml")


def _find_scene(name: str) -> tuple[str, Path]:
    """Return the name and the file of a scene; one with a path may not exist."""
    if name.lower().endswith(".toml"):
        return name, Path(name)
    scenes = builtin_scenes()
    own = f"{name}.toml"
    if name in scenes:
        if os.path.isfile(own):
            notice(f"{name} is the built-in scene; to read the file, write {shown_path(own)}")
        return name, scenes[name]
    if os.path.isfile(own):
        return own, Path(own)
    if os.path.isdir(name):
        raise InputError(
            f"{shown_path(name)} is a folder; name a .toml file in it, or a built-in scene"
        )
    near = difflib.get_close_matches(name, scenes, n=3, cutoff=0.6)
    message = f"there is no built-in scene named {cut(toml_text(name))}; "
    if near:
        message += f"did you mean {' or '.join(near)}?"
    else:
        message += f"the built-in scenes are {', '.join(scenes)}"
    if os.path.isfile(name) and _is_toml(Path(name)):
        message += f". The file {name} can be read once its name ends with .toml"
    raise InputError(message)


def _is_toml(path: Path) -> bool:
    """Whether a file holds TOML, and not a picture, a volume or a spectrum."""
    try:
        return bool(_parse_toml(_read_text(path, ""), ""))
    except InputError:
        return False


def _read_text(path: Path, name: str) -> str:
    try:
        return read_limited(path, MAX_TEXT_BYTES).decode("utf-8-sig")
    except FileNotFoundError:
        message = "there is no such file; check the path"
        if path.stem in builtin_scenes():
            message += f" (the built-in scene is called {path.stem}, without .toml)"
    except IsADirectoryError:
        message = "is a folder; name a scene file in it"
    except UnicodeDecodeError as error:
        message = _not_text(error)
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        reason = error.strerror if isinstance(error, OSError) else error
        message = f"cannot be read: {reason}"
    raise InputError(f"{shown_path(name)}: {message}") from None


def _not_text(error: UnicodeDecodeError) -> str:
    line = error.object.count(b"\n", 0, error.start) + 1
    return f"line {line}: is not UTF-8 text; save the file as UTF-8"


def _parse_toml(text: str, name: str) -> dict[str, Any]:
    try:
        return _values(text)
    except InputError as error:
        raise InputError(f"{name}: not valid TOML: {error}{_remedy(text, str(error))}") from None


def _values(text: str) -> dict[str, Any]:
    """Parse TOML.

    Raises:
        InputError: it is not valid, or more than a scene can be; the reason alone.
    """
    check_text(text)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        what, at, place = str(error).rpartition(" (at ")
        reason = f"{cut(what, _MOST_REASON)}{at}{place}"
    except ValueError:  # Python's, who reads no more than 4300 digits
        reason = "a number has too many digits"
    else:
        check_values(values)
        return values
    raise InputError(reason)


def _remedy(text: str, reason: str) -> str:
    """Give the remedy for what TOML refuses; nothing where it is not known.

    That is several lights in single brackets, and numbers as people write them.
    """
    place = re.search(r"\(at line (\d+), column \d+\)$", reason)
    line = text.splitlines()[int(place[1]) - 1 :][:1] if place else []
    if line and (number := remedy_in_line(line[0])):
        return f"; {number}"
    heads = re.findall(r"(?m)^\s*(\[\[?light\]\]?)", text)
    if len(heads) > 1 and "[light]" in heads:
        return "; write [[light]], in double brackets, for each light"
    return ""
