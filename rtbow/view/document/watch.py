"""Notices files that change: scenes, what they name, and shaders."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

_PERIOD_S = 0.25
_REPLACED_WITHIN_S = 1.0
"""A file that an editor replaces may be gone for this long."""


class Watch:
    """Looks at the times and sizes of files, four times a second.

    Polling works on every system and network drive, and finds files that editors replace.
    """

    def __init__(self) -> None:
        self._groups: dict[str, dict[Path, tuple[float, int]]] = {}
        self._gone_since: dict[Path, float] = {}
        self._due_s = 0.0

    def follow(self, group: str, paths: Iterable[Path], *, anew: bool = False) -> None:
        """Watch files under a name, in place of the group's before.

        Args:
            group: the name.
            paths: of the files.
            anew: whether changes count from now; otherwise files of the group that were watched
                before keep their last state, and changes since then are still found.
        """
        known = {} if anew else self._groups.get(group, {})
        self._groups[group] = {path: known.get(path) or _stamp(path) for path in paths}

    def changed(self, now_s: float) -> set[str]:
        """Name the groups in which a file has changed, gone or come back since the last call."""
        if now_s < self._due_s:
            return set()
        self._due_s = now_s + _PERIOD_S
        gone_before, self._gone_since = self._gone_since, {}
        groups = set()
        for name, stamps in self._groups.items():
            for path, before in stamps.items():
                stamp = _stamp(path)
                if stamp == _GONE:  # it may be being replaced
                    since = self._gone_since[path] = gone_before.get(path, now_s)
                    if now_s - since < _REPLACED_WITHIN_S:
                        continue
                if stamp != before:
                    stamps[path] = stamp
                    groups.add(name)
        return groups


_GONE = (0.0, -1)


def _stamp(path: Path) -> tuple[float, int]:
    try:
        status = path.stat()
    except OSError:
        return _GONE
    return status.st_mtime_ns * 1e-9, status.st_size
