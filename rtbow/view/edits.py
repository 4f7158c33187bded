"""The scene as a person changes it: refusals, undo and redo, and what it differs in."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rtbow.errors import InputError
from rtbow.files import write_atomic
from rtbow.scene import Scene
from rtbow.scene_schema import toml_text
from rtbow.scene_values import changed_scene, differences, scene_text

_MOST_UNDONE = 500
"""Changes that can be undone; further back they are forgotten."""


@dataclass(frozen=True)
class Opened:
    """Where a scene came from.

    Attributes:
        scene: as it was opened.
        name: the built-in scene's name, or the path that was typed; None for the default scene.
        overrides: the ``--set`` with which it was opened, as typed.
    """

    scene: Scene
    name: str | None = None
    overrides: tuple[str, ...] = ()

    @property
    def file(self) -> Path | None:
        """The scene's own file, if it is not a built-in one."""
        named = self.name is not None and self.name.lower().endswith(".toml")
        return Path(self.name) if named and self.name else None


class Edits:
    """A scene with its history.

    A change that the scene refuses raises and leaves all as it was.

    Args:
        opened: the scene to start from.
    """

    def __init__(self, opened: Opened) -> None:
        self.opened = opened
        self._past: list[tuple[Opened, Scene]] = []
        self._future: list[tuple[Opened, Scene]] = []
        self._saved = self.scene = opened.scene
        self._gesture: object = None

    def open(self, opened: Opened) -> None:
        """Start anew from another scene; the one before can be brought back by :meth:`undo`."""
        self._remember(None)
        self.opened = opened
        self._saved = self.scene = opened.scene

    def change(self, changes: Mapping[str, object], gesture: object = None) -> None:
        """Replace values of the scene.

        Args:
            changes: values by dotted key; None takes one out.
            gesture: changes of one gesture, such as a drag, are undone together; None for a change
                of its own.

        Raises:
            InputError: keys or values that are not allowed.
        """
        self.replace(changed_scene(self.scene, changes), gesture)

    def replace(self, scene: Scene, gesture: object = None) -> None:
        """Take over a changed scene, with ``gesture`` as for :meth:`change`."""
        if scene == self.scene:
            return
        self._remember(gesture)
        self.scene = scene

    def _remember(self, gesture: object) -> None:
        if gesture is None or gesture != self._gesture:
            self._past.append((self.opened, self.scene))
            del self._past[:-_MOST_UNDONE]
        self._gesture = gesture
        self._future.clear()

    def end_gesture(self) -> None:
        """Say that the next change begins a gesture of its own."""
        self._gesture = None

    @property
    def can_undo(self) -> bool:
        """Whether there is a change to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone change."""
        return bool(self._future)

    def undo(self) -> None:
        """Take the last change back, if there is one."""
        if self._past:
            self._future.append((self.opened, self.scene))
            self.opened, self.scene = self._past.pop()
            self._gesture = None

    def redo(self) -> None:
        """Make the last undone change again, if there is one."""
        if self._future:
            self._past.append((self.opened, self.scene))
            self.opened, self.scene = self._future.pop()
            self._gesture = None

    @property
    def changes(self) -> dict[str, object]:
        """Overrides that lead from the opened scene to this one."""
        return differences(self.opened.scene, self.scene)

    def reset(self, key: str) -> None:
        """Give a value, or a table's, back as it was opened.

        Raises:
            InputError: it does not go with what else was changed since.
        """
        back = differences(self.scene, self.opened.scene)
        inside = {k: v for k, v in back.items() if f"{k}.".startswith(f"{key}.")}
        around = {k: v for k, v in back.items() if f"{key}.".startswith(f"{k}.")}
        if inside or around:
            self.change(inside or around)

    @property
    def unsaved(self) -> bool:
        """Whether the scene differs from what was opened or saved last."""
        return self.scene != self._saved

    def save(self, path: Path) -> None:
        """Write the scene as TOML, which loads to the same picture.

        Raises:
            InputError: the file cannot be written, or does not end with ``.toml``.
        """
        if path.suffix.lower() != ".toml":
            raise InputError(f"{path}: is not a scene file; write a name that ends with .toml")
        write_atomic(path, scene_text(self.scene, path.absolute().parent).encode())
        self._saved = self.scene
        self.opened = Opened(self.scene, str(path))

    def command(self, verb: str = "render", *options: str) -> str:
        """Give the command line that makes the picture again.

        Args:
            verb: of ``rtbow``.
            options: further arguments, such as ``-o``, ``bow.exr``.
        """
        words = ["rtbow", verb]
        if self.opened.name is not None:
            words.append(self.opened.name)
        for text in self.opened.overrides:
            words += ["--set", text]
        for key, value in self.changes.items():
            words += ["--set", f"{key}={toml_text(value)}"]
        return shlex.join([*words, *options])
