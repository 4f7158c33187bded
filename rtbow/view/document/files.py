"""The scene's files: opened, saved and watched; unsaved changes are kept meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.resources import resource_dir
from rtbow.scene.text.file import DEFAULT_SCENE, builtin_scenes, load_scene, parse_set
from rtbow.scene.text.values import scene_files
from rtbow.view.document.autosave import KEEP_AFTER_S, Autosave, Unsaved, origin
from rtbow.view.document.edits import Edits, Opened, require_lens
from rtbow.view.document.watch import Watch

if TYPE_CHECKING:
    from rtbow.view.document.state import ViewState

_MOST_RECENT = 10
_NAMING = ("droplets", "light", "compare")
"""Tables of the scene that may name files."""


class SceneFiles:
    """Opens, saves and watches scenes, and keeps unsaved changes.

    Args:
        edits: the scene.
        state: shows problems with files.
        watching: whether files are read again when they change.

    Attributes:
        count: how many scenes were opened.
    """

    def __init__(self, edits: Edits, state: ViewState, *, watching: bool) -> None:
        self._edits, self._state, self._watching = edits, state, watching
        self._watch = Watch()
        self._autosave, self._recovered = Autosave(), False
        self._seen = self._kept = edits.scene
        self._changed_s: float | None = None
        self.count = 1
        self._follow(anew=True)
        self._offer_unsaved()

    def open(
        self, name: str | None, overrides: tuple[str, ...] = (), *, source: str = "open"
    ) -> bool:
        """Open a built-in scene or a file; give whether that went well.

        Args:
            name: as ``rtbow view`` takes it.
            overrides: as after ``--set``.
            source: under which a problem is shown.
        """
        if name is not None and self._autosave.holds(Path(name)):
            return self._restore(Path(name))
        try:
            scene = load_scene(name, dict(parse_set(text) for text in overrides))
            require_lens(scene)
        except InputError as error:
            self._state.report(source, str(error))
            return False
        self._state.report("file")
        self._keep_unsaved()  # undo brings it back, but only in this window
        before = self._edits.opened, self._edits.scene
        self._edits.open(Opened(scene, name, overrides))
        if self._edits.scene is before[1]:  # its file now holds the same scene
            self._autosave.forget(before[0])
        self._seen = self._kept = self._edits.scene
        self.count += 1
        self._state.report("open")
        self._follow(anew=source == "open")
        self._state.wake()
        if source == "open" and name is not None:
            self._note_recent(name)
        return True

    def _restore(self, path: Path) -> bool:
        """Open what an earlier window left, as changes to the scene that it was made from."""
        try:
            scene = load_scene(path)
            name = origin(path)
        except (InputError, OSError) as error:
            self._state.report("open", str(error))
            return False
        if not self.open(name):  # it has gone: from the default scene all can be reached
            self.open(None)
            origin_name = "the default scene" if name is None else name
            self._state.notify(f"{origin_name} cannot be opened: these are changes to the default")
        if not self._autosave.claim(path, self._edits.opened, scene):
            self._state.notify(f"{path}: another window has opened it", "error")
            return False
        self._edits.replace(scene)
        self._state.recent = [n for n in self._state.recent if n != str(path)]
        return True

    def _offer_unsaved(self) -> None:
        """List what earlier windows have left among the recent files."""
        left = [str(path) for path in self._autosave.left()]
        self._state.recent = left[:_MOST_RECENT]
        if left:
            self._state.notify("changes that were not saved are listed under Scenes")

    def _note_recent(self, name: str) -> None:
        recent = [name, *(n for n in self._state.recent if n != name)]
        self._state.recent = recent[:_MOST_RECENT]

    def save(self, path: str, *, replace: bool = False) -> None:
        """Write the scene as TOML; ``replace`` allows it over a file that was not opened here."""
        before = self._edits.opened
        self._state.replacing = ()
        try:
            self._edits.save(Path(path), replace=replace)
        except RtbowError as error:
            if self._state.panel_open and not replace and self._edits.replaces(Path(path)):
                self._state.replacing = (path,)  # the panel asks
                self._state.wake()
                return
            self._state.notify(str(error), "error")
            return
        self._autosave.forget(before)
        self._kept = self._edits.scene
        self._state.report("file")  # whatever was wrong with it has been replaced
        self._note_recent(path)
        self._follow(anew=True)
        self._state.notify(f"saved {path}")

    def look_at_scene(self, now: float) -> None:
        """Notice that the scene has changed; ``now`` in seconds of one clock."""
        scene, before = self._edits.scene, self._seen
        if scene is not before:
            self._seen = scene
            self._state.report("open")
            if any(getattr(scene, key) is not getattr(before, key) for key in _NAMING):
                self._follow()
        if scene is self._kept:
            self._changed_s = None
        elif self._changed_s is None:
            self._changed_s = now
        elif now - self._changed_s >= KEEP_AFTER_S:
            self._keep_unsaved()

    def look_at_files(self, now: float) -> set[str]:
        """Read the scene's file again if it has changed and files are watched.

        Returns:
            Which have changed: ``scene``, ``data`` that it names, ``shaders``.
        """
        if not self._watching:
            return set()
        changed = self._watch.changed(now)
        if "scene" in changed:
            self.open(self._edits.opened.name, self._edits.opened.overrides, source="file")
        return changed

    def _follow(self, *, anew: bool = False) -> None:
        if not self._watching:
            return
        opened = self._edits.opened
        file = opened.file or builtin_scenes().get(opened.name or DEFAULT_SCENE)
        self._watch.follow("scene", [file] if file is not None else [], anew=anew)
        self._watch.follow("data", map(Path, scene_files(self._edits.scene)))
        shaders = resource_dir("shaders").rglob("*")
        self._watch.follow("shaders", sorted(path for path in shaders if path.is_file()))

    def _keep_unsaved(self) -> None:
        self._kept, self._changed_s = self._edits.scene, None
        if self._edits.unsaved:
            self._autosave.keep(self._edits.opened, self._edits.scene)
        else:
            self._autosave.forget(self._edits.opened)

    def recover(self, *, cameras: bool = False) -> list[Unsaved]:
        """Write the unsaved changes of all scenes that were opened, and give their files.

        Args:
            cameras: whether scenes are written in which only the camera was moved.
        """
        self._recovered = True
        self._keep_unsaved()
        return self._autosave.finish(cameras=cameras)

    def close(self) -> None:
        """Remove the files of unsaved changes, unless :meth:`recover` was called."""
        if not self._recovered:
            self._autosave.discard()
