"""Unsaved scenes, kept in files of their own: nothing is lost when a window ends, however it does.

A lost X display ends the process within the C library, past all that Python could do: files are
written while all is well, and removed when they are not needed.
"""

from __future__ import annotations

import os
import tempfile
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rtbow.base.files import write_atomic
from rtbow.scene.model import Scene
from rtbow.scene.text.file import DEFAULT_SCENE
from rtbow.scene.text.values import differences
from rtbow.view.document.edits import Edits, Opened, file_text
from rtbow.view.document.names import free_name

KEEP_AFTER_S = 1.5
"""How long after a change, at most, it is written."""


@dataclass
class _Kept:
    """A scene and its file, once it is written."""

    opened: Opened
    scene: Scene
    path: Path | None = None
    problem: str = ""

    @property
    def camera_alone(self) -> bool:
        """Whether nothing but the camera differs from what was opened."""
        keys = differences(self.opened.scene, self.scene)
        return all(key.startswith("camera.") for key in keys)


@dataclass(frozen=True)
class Recovered:
    """What is left of a scene that was not saved.

    Attributes:
        opened: where it came from.
        scene: as it is.
        path: of the file that holds it; None if it has none.
        problem: why not; empty if none is needed, since nothing but the camera was moved.
    """

    opened: Opened
    scene: Scene
    path: Path | None
    problem: str = ""

    @property
    def command(self) -> str:
        """The command line that shows it again."""
        edits = Edits(self.opened)
        edits.replace(self.scene)
        return edits.command("view")


def recovered_path(opened: Opened, folder: Path | None = None) -> Path:
    """Give the file that holds what was not saved of a scene, the first of such.

    Args:
        opened: where the scene came from.
        folder: where the file lies; beside the scene's own by default, else in the current one.
    """
    beside = opened.file.parent if opened.file is not None else Path()
    return (folder or beside) / f"{Path(opened.name or DEFAULT_SCENE).stem}-recovered.toml"


class Recovery:
    """Keeps unsaved scenes in files ``NAME-recovered.toml``, one for each that was opened.

    They lie beside the scene's file, else in the current folder, else among temporary files. They
    are written by a thread: a slow disk must not stop the window.
    """

    def __init__(self) -> None:
        self._kept: dict[int, _Kept] = {}
        self._thread = ThreadPoolExecutor(1, "rtbow recovery")

    def keep(self, opened: Opened, scene: Scene) -> None:
        """Take an unsaved scene, in place of an earlier one that was opened with it."""
        before = self._kept.get(id(opened))
        kept = self._kept[id(opened)] = _Kept(opened, scene)
        self._thread.submit(_write, kept, before)

    def keeps(self, path: Path) -> bool:
        """Whether a file is one of those."""
        return any(kept.path == path for kept in self._kept.values())

    def forget(self, opened: Opened) -> None:
        """Remove what was kept of a scene: it is saved, or as it was opened."""
        kept = self._kept.pop(id(opened), None)
        if kept is not None:
            self._thread.submit(_remove, kept)

    def finish(self, *, cameras: bool = False) -> list[Recovered]:
        """Write all, and tell what there is.

        Args:
            cameras: whether files stay of which nothing but the camera differs.
        """
        for kept in self._kept.values():
            if kept.camera_alone and not cameras:
                self._thread.submit(_remove, kept)
        self._thread.shutdown(wait=True)
        found = [Recovered(k.opened, k.scene, k.path, k.problem) for k in self._kept.values()]
        self._kept.clear()
        return found

    def discard(self) -> None:
        """Remove all that was kept."""
        for kept in self._kept.values():
            self._thread.submit(_remove, kept)
        self._kept.clear()
        self._thread.shutdown(wait=True)


def _write(kept: _Kept, before: _Kept | None) -> None:
    """Write a scene, to the file of the one before if there is one."""
    if before is not None:
        kept.path = before.path
    beside = kept.opened.file
    folders = [Path(), Path(tempfile.gettempdir())]
    if beside is not None:
        folders.insert(0, beside.parent)
    if kept.path is not None:
        folders.insert(0, kept.path.parent)
    for folder in folders:
        own = kept.path is not None and kept.path.parent == folder
        path = kept.path if own else None
        if path is None:
            path = recovered_path(kept.opened, folder)
            if os.path.lexists(path):
                path = folder / f"{free_name(path.stem, (path.suffix,), folder)}.toml"
        try:
            write_atomic(path, file_text(kept.opened, kept.scene, folder.absolute()).encode())
        except Exception as error:
            kept.problem = kept.problem or str(error)
            continue
        if kept.path is not None and kept.path != path:
            with suppress(OSError):
                os.unlink(kept.path)
        kept.path, kept.problem = path, ""
        return
    kept.path = None


def _remove(kept: _Kept) -> None:
    path, kept.path, kept.problem = kept.path, None, ""
    if path is not None:
        with suppress(OSError):
            path.unlink()
