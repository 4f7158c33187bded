"""What rtbow raises: every error a caller can meet is a subclass of :class:`RtbowError`."""

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


def require_one_of(what: str, value: object, allowed: Sequence[Word]) -> Word:
    """Give a value that is one of some words, or raise InputError."""
    for word in allowed:
        if isinstance(value, str) and value == word:
            return word
    raise InputError(f"{what} = {value!r}; must be one of {', '.join(allowed)}")
