"""Finds the line of a scene's text in which a key stands."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

Key = Sequence[str | int]
"""Tables' keys and lists' indices, from the outermost on."""


class Lines:
    """The lines of a text in TOML.

    A text that is cut behind a statement is valid TOML, too: the line is sought behind which the
    key is first there, by halves.

    Args:
        text: valid TOML.
    """

    def __init__(self, text: str) -> None:
        self._lines = text.replace("\r\n", "\n").split("\n")
        self._cut: dict[int, tuple[int, dict[str, Any]]] = {0: (0, {})}

    def of(self, key: Key) -> int | None:
        """Give the line, from 1, of a key or of the innermost table around it that is there.

        Args:
            key: of a value or table; one that the text lacks may end with keys that are not there.

        Returns:
            None if not even its outermost table is there.
        """
        whole = self._read(len(self._lines))[1]
        known = next((n for n in range(len(key), 0, -1) if _has(whole, key[:n])), 0)
        if known == 0:
            return None
        low, high = 0, len(self._lines)
        while high - low > 1:
            middle = (low + high) // 2
            if _has(self._read(middle)[1], key[:known]):
                high = middle
            else:
                low = middle
        # A statement of several lines is there with its last one: it begins behind the one before.
        first = self._read(high - 1)[0]
        while first < high - 1 and not _is_statement(self._lines[first]):
            first += 1
        return first + 1

    def _read(self, count: int) -> tuple[int, dict[str, Any]]:
        """Read the first lines, without a last statement that they cut; tell how many those are."""
        found = self._cut.get(count)
        if found is None:
            try:
                found = count, tomllib.loads("\n".join(self._lines[:count]))
            except (ValueError, RecursionError):
                found = self._read(count - 1)
            self._cut[count] = found
        return found


def _is_statement(line: str) -> bool:
    stripped = line.strip()
    return bool(stripped) and not stripped.startswith("#")


def _has(values: Any, key: Key) -> bool:
    at = values
    for part in key:
        if not isinstance(at, dict | list):
            return False
        try:
            at = at[part]  # type: ignore[index]  # a list's key is refused below
        except (KeyError, IndexError, TypeError):
            return False
    return True
