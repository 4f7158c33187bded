"""What rtbow raises: every error a caller can meet is a subclass of :class:`RtbowError`.

Also what it says where nothing is wrong enough for an error, and how messages quote what others
wrote.
"""

import functools
import logging
import os
from collections.abc import Sequence
from typing import TypeVar

Word = TypeVar("Word", bound=str)

CHECK_PATH = (
    "check the path: in a scene file it starts at that file's folder, elsewhere at the current one"
)
"""The remedy for an input file that is not there."""


class RtbowError(Exception):
    """Base class; ``exit_code`` is what the command line returns for it."""

    exit_code = 1


class InputError(RtbowError):
    """The user's input is wrong: says where, what, what is allowed and what to do."""

    exit_code = 2


class UnavailableError(RtbowError):
    """This machine lacks something (a GL backend, a display); says what to install."""

    exit_code = 3


class UnsuitedError(InputError):
    """A scene that a method cannot draw within the error asked for, while another one can."""


_MOST_QUOTED = 40
_MOST_PATH = 500


def cut(text: str, most: int = _MOST_QUOTED) -> str:
    """Return the beginning of a text that others wrote, fit for a message, on one line.

    Every message that quotes a value, a key or a line of a file passes it through here.

    Args:
        text: of any length, with any characters.
        most: characters that are shown.
    """
    shown = text if len(text) <= most else f"{text[: most - 1]}…"
    return printable(shown)


def shown_path(path: str | os.PathLike[str]) -> str:
    """Return a path fit for a message: longer ones than systems have are cut."""
    return cut(os.fspath(path), _MOST_PATH)


def printable(text: str) -> str:
    """Return a text with escapes for what would not show or would break the line."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


@functools.cache
def notice(text: str) -> None:
    """Say something that is no error, once in a process.

    It goes to the logger ``rtbow``; without a handler, Python writes it to stderr.
    """
    logging.getLogger("rtbow").warning("rtbow: %s", text)


def require_one_of(what: str, value: object, allowed: Sequence[Word]) -> Word:
    """Give a value that is one of some words, or raise InputError."""
    for word in allowed:
        if isinstance(value, str) and value == word:
            return word
    raise InputError(f"{what} = {cut(repr(value))}; must be one of {', '.join(allowed)}")
