"""The scene being edited: its changes, undo and redo, saving, and the command that makes it."""

from __future__ import annotations

import os
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from rtbow.base.errors import InputError
from rtbow.base.files import write_atomic
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene, typed_override
from rtbow.scene.text.values import changed_scene, differences, scene_text
from rtbow.view.document.rewrite import rewritten

_NO_PANORAMA = (
    'camera.projection = "panorama"; the window shows pictures of a lens: use rtbow render, or'
    " --set camera.projection=perspective"
)
_MOST_UNDONE = 500
"""Number of changes that can be undone."""


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
        if self.name is None or self.name in builtin_scenes():
            return None
        named = self.name.lower().endswith(".toml")
        return Path(self.name if named else f"{self.name}.toml")


class Edits:
    """A scene with its history.

    A change that the scene refuses raises an error and changes nothing.

    Args:
        opened: the scene to start from.

    Raises:
        InputError: it is a panorama.
    """

    def __init__(self, opened: Opened) -> None:
        require_lens(opened.scene)
        self.opened = opened
        self.scene = opened.scene
        self._past: list[tuple[Opened, Scene]] = []
        self._future: list[tuple[Opened, Scene]] = []
        self._gesture: object = None
        self._own: dict[str, bytes | None] = {}
        self._know(opened.file)

    def open(self, opened: Opened) -> None:
        """Start anew from another scene; the one before can be brought back by :meth:`undo`."""
        self._know(opened.file)
        if (opened.name, opened.scene) == (self.opened.name, self.scene):
            self._now_from(opened)  # a file as it was just saved
            return
        self._remember(None)
        self.opened, self.scene = opened, opened.scene

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
        """Replace the whole scene, with ``gesture`` as for :meth:`change`.

        Raises:
            InputError: it is a panorama.
        """
        if scene == self.scene:
            return
        require_lens(scene)
        self._remember(gesture)
        self.scene = scene

    def _remember(self, gesture: object) -> None:
        if gesture is None or gesture != self._gesture:
            self._past.append((self.opened, self.scene))
            del self._past[:-_MOST_UNDONE]
        self._gesture = gesture
        self._future.clear()

    def end_gesture(self) -> None:
        """End the gesture: the next change is undone by itself."""
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
        """Undo the last change, if there is one."""
        if self._past:
            self._future.append((self.opened, self.scene))
            self.opened, self.scene = self._past.pop()
            self._gesture = None

    def redo(self) -> None:
        """Redo the last undone change, if there is one."""
        if self._future:
            self._past.append((self.opened, self.scene))
            self.opened, self.scene = self._future.pop()
            self._gesture = None

    @property
    def changes(self) -> dict[str, object]:
        """Overrides that lead from the opened scene to this one."""
        return differences(self.opened.scene, self.scene)

    @property
    def unsaved(self) -> bool:
        """Whether the scene differs from what was opened or saved last."""
        return self.scene != self.opened.scene

    def _know(self, file: Path | None) -> None:
        if file is not None:
            self._own[os.path.realpath(file)] = _content(file)

    def _now_from(self, opened: Opened) -> None:
        """Change where the scene and its undone versions come from."""
        before, self.opened = self.opened, opened
        for steps in (self._past, self._future):
            steps[:] = [(opened if one is before else one, scene) for one, scene in steps]

    def replaces(self, path: Path) -> bool:
        """Whether saving to a path would replace content that was neither opened nor saved here.

        That is another file, or the scene's own after another program has changed it.
        """
        if not os.path.lexists(path):
            return False
        own = self._own.get(os.path.realpath(path))
        return own is None or own != _content(path)

    def question(self, path: Path) -> str:
        """Say what saving to a path would replace, for which :meth:`replaces` is true."""
        if os.path.realpath(path) in self._own:
            return f"{path}: has been changed by another program since it was read here"
        return f"{path}: this file exists and was not opened here"

    def save(self, path: Path, *, replace: bool = False) -> None:
        """Write the scene as TOML, which loads to the same picture.

        Where the scene came from a file, that file's comments and order are kept, and only values
        that have changed are replaced; otherwise all values are written out. Earlier changes can
        still be undone; from now on the scene comes from the saved file.

        Args:
            path: of the file.
            replace: whether it may replace a file that was neither opened nor saved here.

        Raises:
            InputError: the file cannot be written, does not end with ``.toml``, or is another one
                that would be replaced.
        """
        if path.suffix.lower() != ".toml":
            raise InputError(f"{path}: not a scene file; choose a name that ends with .toml")
        if self.replaces(path) and not replace:
            raise InputError(f"{self.question(path)}; choose another name, or replace it")
        text = file_text(self.opened, self.scene, path.absolute().parent)
        write_atomic(path, text.encode())
        self._know(path)
        self._now_from(Opened(self.scene, str(path)))

    def command(self, verb: str = "render", *options: str) -> str:
        """Give the command line that makes the picture again.

        Args:
            verb: of ``rtbow``.
            options: further arguments, such as ``-o``, ``bow.exr``.
        """
        name = self.opened.name
        try:
            file = load_scene(name)  # as it is now; --set options are among the differences
        except InputError:
            # The file has gone, or needs its --set: any scene can be reached from the default one.
            name, file = None, load_scene()
        words = ["rtbow", verb, *([name] if name is not None else [])]
        for change in differences(file, self.scene).items():
            words += ["--set", typed_override(*change)]
        return shlex.join([*words, *options])


def require_lens(scene: Scene) -> None:
    """Refuse a scene that the window does not show.

    Raises:
        InputError: it is a panorama.
    """
    if scene.camera.whole_sphere:
        raise InputError(_NO_PANORAMA)


def file_text(opened: Opened, scene: Scene, folder: Path) -> str:
    """Give a scene as TOML for a file.

    Args:
        opened: where the scene came from; a file's comments, order and line ends are kept.
        scene: as it is now.
        folder: where the file will lie: paths in it are written relative to it.
    """
    before = _content(opened.file) if opened.file is not None else None
    try:
        text = before.decode("utf-8-sig") if before else ""
    except UnicodeDecodeError:
        text = ""
    lines = text.replace("\r\n", "\n")
    written = rewritten(lines, scene, folder) if lines else None
    if written is None:
        written = _first_comments(lines) + scene_text(scene, folder)
    return written.replace("\n", "\r\n") if "\r\n" in text else written


def _content(file: Path) -> bytes | None:
    """Give what a file holds; None if it cannot be read."""
    try:
        return file.read_bytes()
    except OSError:
        return None


def _first_comments(text: str) -> str:
    """Give the lines of comments with which a scene's text begins, such as its title."""
    lines = text.splitlines()
    own = takewhile(lambda line: not line.strip() or line.lstrip().startswith("#"), lines)
    text = "\n".join(own).strip("\n")
    return f"{text}\n\n" if text else ""
