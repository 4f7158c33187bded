"""Pieces of the Markdown documents that tools write."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

COLUMNS = 100
"""Characters of a line, at most; a table's row is a line of any length."""


def paragraph(text: str, *, bullet: bool = False) -> str:
    """Break a paragraph into lines, between words alone: long numbers and code are not cut."""
    first, others = ("- ", "  ") if bullet else ("", "")
    return textwrap.fill(
        text, COLUMNS, initial_indent=first, subsequent_indent=others, break_long_words=False,
        break_on_hyphens=False,
    )  # fmt: skip


def bullets(texts: Iterable[str]) -> str:
    """Write a list, an item each."""
    return "\n".join(paragraph(text, bullet=True) for text in texts)


def table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a table. Cells are not padded: a number that changes would change every line."""
    return "\n".join(f"| {' | '.join(line)} |" for line in (titles, ["---"] * len(titles), *rows))
