"""What rtbow raises: every error a caller can meet is a subclass of :class:`RtbowError`.

Also what it says where nothing is wrong enough for an error, and how messages quote what others
wrote.
"""

import functools
import logging

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


def cut(text: str) -> str:
    """Return the beginning of a text that others wrote, short enough for a message: 40 characters.

    Every message that quotes a value, a key or a line of a file passes it through here.
    """
    return text if len(text) <= _MOST_QUOTED else f"{text[: _MOST_QUOTED - 1]}…"


@functools.cache
def notice(text: str) -> None:
    """Say something that is no error, once in a process.

    It goes to the logger ``rtbow``; without a handler, Python writes it to stderr.
    """
    logging.getLogger("rtbow").warning("rtbow: %s", text)
