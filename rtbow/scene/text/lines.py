"""Finds the line of a scene's text in which a key stands."""

from __future__ import annotations

import functools
import re
import tomllib
from collections.abc import Sequence
from typing import Any

Key = Sequence[str | int]
"""Tables' keys and lists' indices, from the outermost on."""

_START = re.compile(r"\s*(\[\[?[^\[\],]+\]\]?\s*(#.*)?$|[\w\"'][^=\[\]{},]*=)")
"""Lines with a table's head or a key begin like this; lines inside a long text may, too."""
_MOST_TRIES = 200
"""Limits the search for the end of a statement whose own lines look like statements."""
_MOST_CHARACTERS = 300_000
"""In longer texts the lines of keys are not known: the search parses the text again and again."""


class Lines:
    """The lines of a text in TOML.

    Args:
        text: valid TOML.
    """

    def __init__(self, text: str) -> None:
        self._too_long = len(text) > _MOST_CHARACTERS
        self._lines = text.replace("\r\n", "\n").split("\n")
        self._before = functools.cache(self._parsed_before)

    def of(self, key: Key) -> int | None:
        """Return the line, from 1, of a key; if the text lacks it, of the table around it.

        Args:
            key: of a value or a table.

        Returns:
            None if the text lacks the key's outermost table, too, its statements cannot be told
            apart, or it is very long.
        """
        if self._too_long:
            return None
        starts = self._starts
        whole = self._before(len(self._lines)) or {}
        known = next((n for n in range(len(key), 0, -1) if _has(whole, key[:n])), 0)
        if known == 0:
            return None
        # A text cut off before a statement is still valid: bisection finds the first statement
        # after which the key is there.
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

    @functools.cached_property
    def _starts(self) -> list[int]:
        """Return the lines, from 0, in which statements begin."""
        marks = [n for n, line in enumerate(self._lines) if _START.match(line)]
        starts: list[int] = []
        tries = 0
        for mark, end in zip(marks, [*marks[1:], len(self._lines)], strict=False):
            first = starts[-1] if tries else mark
            if not tries:
                starts.append(mark)
            tries += 1
            if tries > _MOST_TRIES or _parsed("\n".join(self._lines[first:end])) is not None:
                tries = 0
        return starts

    def _parsed_before(self, line: int) -> dict[str, Any] | None:
        """Parse the lines before ``line``; None if they end inside a statement."""
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
