"""What rtbow raises: every error a caller can meet is a subclass of :class:`RtbowError`."""

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
