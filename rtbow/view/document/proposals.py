"""Changes that the panel proposes to the scene, on the side of a split picture that it shows."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from rtbow.scene.model import Compare, Scene
from rtbow.scene.text.overrides import flat, plain
from rtbow.scene.text.schema import toml_text
from rtbow.scene.text.values import changed_scene
from rtbow.view.document.edits import Edits
from rtbow.view.document.state import Actions, ViewState

if TYPE_CHECKING:
    from rtbow.render.renderer import MethodName

RIGHT = "compare.right"
Path = tuple[str | int, ...]


class Proposals:
    """The scene that the panel shows, what it is compared with, and how it is changed.

    Args:
        actions: what the window does.

    Attributes:
        scene: whose values are shown: the left side's, or the right's.
        origin: what they are compared with: the scene as it was opened; on the right, the left.
        right: whether the right side is shown.
        method: by which the picture is drawn.
    """

    def __init__(self, actions: Actions) -> None:
        self._actions = actions
        self._edits: Edits | None = None
        self._seen: Scene | None = None
        self._right_scene: Scene | None = None
        self.right = False
        self.method: MethodName = "auto"

    def look(self, edits: Edits, state: ViewState) -> None:
        """Begin a frame with the scene as it is now."""
        self._edits = edits
        if edits.scene is not self._seen:
            self._seen, self._right_scene = edits.scene, None
        self.right = state.side == "right" and edits.scene.compare is not None
        self.method = state.method
        self.scene = self._right_part(edits.scene) if self.right else edits.scene
        self.origin = edits.scene if self.right else edits.opened.scene

    def _right_part(self, scene: Scene) -> Scene:
        if self._right_scene is None:
            assert scene.compare is not None
            if round(scene.compare.split * scene.camera.size_px[0]) >= scene.camera.size_px[0]:
                scene = changed_scene(scene, {"compare.split": 0.0})  # the right part has no width
            self._right_scene = scene.parts()[-1][0]
        return self._right_scene

    def change(self, changes: Mapping[str, object], gesture: object = None) -> str:
        """Replace values; give what is wrong with them, or an empty string."""
        whole: dict[str, object] = dict(changes)
        if self.right and not any(key.startswith("compare") for key in changes):
            left = self._left
            # A value of the left is left out on the right by the word none.
            right = {
                key: toml_text(None)
                if value is None and value_at(left, split_path(key)) is not None
                else value
                for key, value in changes.items()
            }
            whole = {RIGHT: merged(_compare(left).right, right)}
        return self._actions.change(whole, gesture)

    def reset(self, *keys: str) -> str:
        """Reset values to what was opened, or to the left side's; give what is wrong with that."""
        if self.right and not keys[0].startswith("compare"):
            right = flat(_compare(self._left).right)
            kept = {k: v for k, v in right if not any(_touches(k, key) for key in keys)}
            return self._actions.change({RIGHT: kept}, None)
        return self.change(
            {key: plain_value(value_at(self.origin, split_path(key))) for key in keys}
        )

    @property
    def _left(self) -> Scene:
        """The scene as it is now, which may have changed since the frame began."""
        assert self._edits is not None
        return self._edits.scene

    def undo(self) -> None:
        """Take the last change back."""
        self._actions.undo()

    def set_text(self, key: str) -> str:
        """Give the command line's option that sets a key to its value."""
        value = toml_text(plain_value(value_at(self.scene, split_path(key))))
        place = f"{RIGHT}.{key}" if self.right and not key.startswith("compare") else key
        return f"--set {shlex.quote(f'{place}={value}')}"


def merged(right: Mapping[str, Any], changes: Mapping[str, object]) -> dict[str, object]:
    """Give what differs on the right after changes there.

    Args:
        right: what differed.
        changes: values by dotted key; None gives back the left side's.
    """
    differing: dict[str, object] = dict(flat(right))
    for key, value in changes.items():
        differing = {k: v for k, v in differing.items() if not f"{k}.".startswith(f"{key}.")}
        if value is not None:
            differing[key] = value
    return differing


def _compare(scene: Scene) -> Compare:
    assert scene.compare is not None
    return scene.compare


def _touches(key: str, other: str) -> bool:
    """Whether one key is the other, inside it or around it."""
    return f"{key}.".startswith(f"{other}.") or f"{other}.".startswith(f"{key}.")


def split_path(key: str) -> Path:
    """Give a dotted key's parts, numbers as such."""
    return tuple(int(part) if part.isdigit() else part for part in key.split("."))


def value_at(table: object, path: Path) -> Any:
    """Give what a scene has at a path; None where it has nothing."""
    for part in path:
        if isinstance(part, int):
            table = table[part] if isinstance(table, tuple | list) and part < len(table) else None
        else:
            table = table.get(part) if isinstance(table, dict) else getattr(table, part, None)
    return table


def plain_value(value: object) -> Any:
    """Give a value of the scene as TOML would, tables without what is left out."""
    if isinstance(value, BaseModel):
        value = value.model_dump(exclude_none=True)
    if isinstance(value, tuple):
        value = [plain_value(item) for item in value]
    return plain(value)


def shortened(message: str, path: str) -> str:
    """Give what a message says about a key, without naming it and its value again."""
    lines = []
    for line in message.splitlines():
        line = re.sub(r"^[^:;=]*?--set:? ?", "", line)
        line = line.removeprefix(f"{RIGHT}.")
        named = re.match(r"([\w.-]+)(?: = .*?;)? ", line)
        if named and f"{path}.".startswith(f"{named[1]}."):
            line = line[named.end() :]
        lines.append(line)
    return "\n".join(lines)
