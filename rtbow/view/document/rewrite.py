"""Writes a changed scene into the text it came from: comments and order stay as they were."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeGuard

import tomlkit
from tomlkit.items import InlineTable

from rtbow.scene.model import Scene
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.values import values_of


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
        # Again where a value that the text leaves out follows from one that was replaced.
        for _ in range(2):
            before = scene_from_text(text, folder=folder)
            document = tomlkit.parse(text)
            _merge(document, values_of(before, folder), values_of(scene, folder))
            text = tomlkit.dumps(document)
            if scene_from_text(text, folder=folder) == scene:
                return text
    except Exception:  # whatever it is: the scene can still be written out whole
        return None
    return None


def _merge(at: Any, before: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Put what differs between two tables' values into a table's text.

    Args:
        at: the table in the document; it may lack values that are defaults.
        before: all of its values.
        wanted: what it shall have.
    """
    for key in {**before, **wanted}:
        old, new = before.get(key), wanted.get(key)
        if old == new:
            continue
        if key not in wanted:
            at.pop(key, None)
        elif _are_tables(old) and _are_tables(new) and key in at:
            _merge_list(at[key], list(old), list(new))
        elif isinstance(old, Mapping) and isinstance(new, Mapping):
            if key not in at:
                at[key] = tomlkit.inline_table() if isinstance(at, InlineTable) else tomlkit.table()
            _merge(at[key], old, new)
        else:
            at[key] = new


def _merge_list(at: Any, before: list[Any], wanted: list[Any]) -> None:
    """Put what differs into the text of a list of tables; tables that remain keep their text."""
    for number in reversed(range(len(before))):
        if len(before) > len(wanted) and before[number] not in wanted:
            del at[number], before[number]
    del at[len(wanted) :], before[len(wanted) :]
    for number, (old, new) in enumerate(zip(before, wanted, strict=False)):
        _merge(at[number], old, new)
    for new in wanted[len(before) :]:
        inline = len(at) > 0 and isinstance(at[0], InlineTable)
        at.append(_as_line(new) if inline else tomlkit.item(new))


def _are_tables(value: object) -> TypeGuard[list[Any]]:
    return isinstance(value, list) and all(isinstance(item, Mapping) for item in value)


def _as_line(values: Any) -> InlineTable:
    line = tomlkit.inline_table()
    line.update(values)
    return line
