"""Finds the line of a scene's text in which a key stands."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from typing import Any

Key = Sequence[str | int]
"""Tables' keys and lists' indices, from the outermost on."""

_START = re.compile(r"\s*(\[\[?[^\[\],]+\]\]?\s*(#.*)?$|[\w\"'][^=\[\]{},]*=)")
"""What a line with a table's head or a key begins with; lines of long texts may, too."""
_MOST_TRIES = 200
"""At most, to find the end of a statement that holds lines which look like others."""


class Lines:
    """The lines of a text in TOML.

    Args:
        text: valid TOML.
    """

    def __init__(self, text: str) -> None:
        self._lines = text.replace("\r\n", "\n").split("\n")

    def of(self, key: Key) -> int | None:
        """Give the line, from 1, of a key or of the innermost table around it that is there.

        Args:
            key: of a value or table; one that the text lacks may end with keys that are not there.

        Returns:
            None if not even its outermost table is there, or the text has a form that is too odd.
        """
        starts = self._starts()
        whole = self._before(len(self._lines)) or {}
        known = next((n for n in range(len(key), 0, -1) if _has(whole, key[:n])), 0)
        if known == 0:
            return None
        # A text that ends before a statement is valid, too: the first one behind which the key is
        # there holds it, and is found by halves.
        low, high = 0, len(starts)
        while high - low > 1:
            middle = (low + high) // 2
            before = self._before(starts[middle])
            if before is None:
                return None
            if _has(before, key[:known]):
                high = middle
            else:
                low = middle
        return starts[low] + 1

    def _starts(self) -> list[int]:
        """Give the lines, from 0, in which statements begin."""
        marks = [n for n, line in enumerate(self._lines) if _START.match(line)]
        found: list[int] = []
        tries = 0
        for mark, end in zip(marks, [*marks[1:], len(self._lines)], strict=False):
            first = found[-1] if tries else mark
            if not tries:
                found.append(mark)
            tries += 1
            if tries > _MOST_TRIES or _parsed("\n".join(self._lines[first:end])) is not None:
                tries = 0
        return found

    def _before(self, line: int) -> dict[str, Any] | None:
        """Read the lines before one; None where they are no whole statements."""
        return _parsed("\n".join(self._lines[:line]))


def _parsed(text: str) -> dict[str, Any] | None:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError):
        return None


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
