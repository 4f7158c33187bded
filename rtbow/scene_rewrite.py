"""Writes a changed scene into the text it came from: comments and order stay as they were."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import InlineTable

from rtbow.errors import InputError
from rtbow.scene import Scene
from rtbow.scene_file import scene_from_text
from rtbow.scene_values import differences, scene_text


def rewritten(text: str, scene: Scene, folder: Path) -> str | None:
    """Give a scene file's text with the values that differ replaced.

    Args:
        text: of the file.
        scene: what it is to hold.
        folder: where the file lies: paths in it are relative to it.

    Returns:
        Text that reads as an equal scene; None where that cannot be had by replacing values.
    """
    try:
        before = scene_from_text(text, folder=folder)
        document = tomlkit.parse(text)
        wanted = tomlkit.parse(scene_text(scene, folder)).unwrap()
        for key in differences(before, scene):
            _put(document, key.split("."), wanted)
        found = tomlkit.dumps(document)
        same = scene_from_text(found, folder=folder) == scene
    except (InputError, TOMLKitError, KeyError, IndexError, TypeError, ValueError):
        return None
    return found if same else None


def _put(at: Any, path: list[str], wanted: Any) -> None:
    """Put one of the wanted values where its key says, or take it out where there is none."""
    for part in path[:-1]:
        slot = _slot(at, part)
        wanted = wanted[slot]
        if isinstance(slot, str) and slot not in at:  # its defaults were not written out
            at[slot] = tomlkit.inline_table() if isinstance(at, InlineTable) else tomlkit.table()
        at = at[slot]
    slot = _slot(at, path[-1])
    if isinstance(slot, str) and slot not in wanted:
        at.pop(slot, None)
        return
    value = wanted[slot]
    if isinstance(value, Mapping) and isinstance(at.get(slot), InlineTable):
        line = tomlkit.inline_table()
        line.update(value)
        value = line
    at[slot] = value


def _slot(at: Any, part: str) -> int | str:
    return int(part) if isinstance(at, list) else part
