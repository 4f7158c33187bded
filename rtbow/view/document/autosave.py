"""Unsaved scenes, kept in the user's data folder: nothing is lost when a window ends, however.

A lost X display ends the process within the C library, past all that Python could do: files are
written while all is well, and removed when they are not needed. The next window offers what is
left.
"""

from __future__ import annotations

import os
import re
import secrets
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from rtbow.base.files import write_atomic
from rtbow.scene.model import Scene
from rtbow.scene.text.file import DEFAULT_SCENE
from rtbow.scene.text.values import differences
from rtbow.view.document.edits import Edits, Opened, file_text

KEEP_AFTER_S = 1.5
"""How long after a change, at most, it is written."""
_MOST_LEFT = 20
"""Files of earlier windows that stay; older ones are removed."""
_ORIGIN = "# unsaved changes to "
"""What a file begins with, before the name of the scene that was opened."""


@dataclass
class Unsaved:
    """A scene that has not been saved.

    Attributes:
        opened: where it came from.
        scene: as it is.
        path: of its file; None if there is none.
        problem: why the file could not be written; empty if it could, or none is needed.
    """

    opened: Opened
    scene: Scene
    path: Path | None
    problem: str = ""

    @property
    def camera_alone(self) -> bool:
        """Whether nothing but the camera differs from what was opened."""
        keys = differences(self.opened.scene, self.scene)
        return all(key.startswith("camera.") for key in keys)

    @property
    def command(self) -> str:
        """The command line that shows it again."""
        edits = Edits(self.opened)
        edits.replace(self.scene)
        return edits.command("view")


class Autosave:
    """Keeps what one window has not saved: a file for each scene that was opened and changed.

    No two windows have a file in common. A thread writes them: a slow disk must not stop the
    window.
    """

    def __init__(self) -> None:
        self._folder = platformdirs.user_data_path("rtbow", appauthor=False) / "unsaved"
        self._kept: dict[int, Unsaved] = {}
        self._thread = ThreadPoolExecutor(1, "rtbow autosave")

    def keep(self, opened: Opened, scene: Scene) -> None:
        """Write an unsaved scene, in place of an earlier one that was opened with it."""
        kept = self._kept.get(id(opened))
        if kept is None:
            kept = self._kept[id(opened)] = Unsaved(opened, scene, self._new_path(opened))
        kept.scene = scene
        self._thread.submit(_write, kept, scene)

    def forget(self, opened: Opened) -> None:
        """Remove what was kept of a scene: it is saved, or as it was opened."""
        kept = self._kept.pop(id(opened), None)
        if kept is not None:
            self._thread.submit(_remove, kept)

    def finish(self, *, cameras: bool = False) -> list[Unsaved]:
        """Wait for all files, and give the scenes that have not been saved.

        Args:
            cameras: whether files stay whose scenes differ in nothing but the camera.
        """
        for kept in self._kept.values():
            if kept.camera_alone and not cameras:
                self._thread.submit(_remove, kept)
        self._thread.shutdown(wait=True)
        unsaved = list(self._kept.values())
        for kept in unsaved:
            kept.path = None if kept.problem else kept.path
        self._kept.clear()
        return unsaved

    def discard(self) -> None:
        """Remove all files of this window."""
        for kept in self._kept.values():
            self._thread.submit(_remove, kept)
        self._kept.clear()
        self._thread.shutdown(wait=True)

    # --- earlier windows ----------------------------------------------------------------------

    def left(self) -> list[Path]:
        """Give the files that windows of before have left, the newest first."""
        dated = []
        for path in self._folder.glob("*.toml"):
            with suppress(OSError):  # another window may take or remove it meanwhile
                if not _owner_runs(path):
                    dated.append((path.stat().st_mtime_ns, path))
        files = [path for _, path in sorted(dated, reverse=True)]
        for path in files[_MOST_LEFT:]:
            with suppress(OSError):
                path.unlink(missing_ok=True)
        return files[:_MOST_LEFT]

    def holds(self, path: Path) -> bool:
        """Whether a file is an unsaved scene, of whichever window."""
        return path.parent == self._folder

    def claim(self, path: Path, opened: Opened, scene: Scene) -> bool:
        """Make a file that was left this window's own; give whether no other window was first.

        Args:
            path: of the file.
            opened: what its scene was changed from.
            scene: that it holds.
        """
        own = self._new_path(opened)
        try:
            path.rename(own)
        except OSError:
            return False
        self._kept[id(opened)] = Unsaved(opened, scene, own)
        return True

    def _new_path(self, opened: Opened) -> Path:
        stem = Path(opened.name or DEFAULT_SCENE).stem
        return self._folder / f"{stem}-{os.getpid()}-{secrets.token_hex(4)}.toml"


def origin(path: Path) -> str | None:
    """Give the name of the scene that a file holds changes to; None for the default scene."""
    with path.open(encoding="utf-8") as file:
        return file.readline().removeprefix(_ORIGIN).strip() or None


def _owner_runs(path: Path) -> bool:
    """Whether the window that writes a file is still open, as far as can be known."""
    number = re.search(r"-(\d+)-[0-9a-f]+\.toml$", path.name)
    if number is None:
        return False
    process = int(number[1])
    if process == os.getpid() or os.name != "posix":  # elsewhere a signal would end the process
        return process == os.getpid()
    try:
        os.kill(process, 0)
    except OSError:
        return False
    return True


def _write(kept: Unsaved, scene: Scene) -> None:
    assert kept.path is not None
    file = kept.opened.file
    name = os.path.abspath(file) if file is not None else kept.opened.name or ""
    try:
        text = f"{_ORIGIN}{name}\n{file_text(kept.opened, scene, kept.path.parent)}"
        kept.path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(kept.path, text.encode())
        kept.problem = ""
    except Exception as error:
        kept.problem = str(error)


def _remove(kept: Unsaved) -> None:
    path, kept.path, kept.problem = kept.path, None, ""
    if path is not None:
        with suppress(OSError):
            path.unlink(missing_ok=True)
