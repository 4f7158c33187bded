"""How much a scene's text may hold: checked before and after it is parsed.

TOML's parser takes time that grows with the square of a dotted key's length, and its stack bounds
how deep lists may be nested. No scene comes near these bounds.
"""

import re
from collections.abc import Mapping

from rtbow.base.errors import InputError, cut

MAX_TEXT_BYTES = 1 << 20
"""The longest built-in scene has 2000."""
_MOST_NESTED = 100

_TOKEN = re.compile(
    r'''
      (?P<comment> \#[^\n]*+ )
    | (?P<long_text> """ (?: [^\\"]++ | \\. | "(?!"") )* (?: "{3,5} | \Z | \\ )
                   | \'\'\' (?: [^']++ | '(?!'') )* (?: '{3,5} | \Z ) )
    | (?P<part> "(?: [^"\\\n]++ | \\[^\n] )* "? | '[^'\n]*+ '? | [\w+-]++ )
    | (?P<dot> \. )
    | (?P<opening> [\[{] )
    | (?P<closing> [\]}] )
    | (?P<space> [ \t]++ )
    | (?P<other> . )
    ''',
    re.VERBOSE | re.DOTALL,
)
"""Every text is a row of these, valid TOML or not, found in one pass. What follows a repeated group
matches wherever the group ends, so that nothing is tried again; groups that say so, as characters
do (``++``), end wrongly in Python up to 3.11.4 (gh-106052)."""


_TOO_DEEP = f"lists or tables are nested too deeply; at most {_MOST_NESTED} levels are read"


def check_text(text: str) -> None:
    """Refuse a text that would be slow to parse.

    Raises:
        InputError: it is too long, a key has too many parts, or lists or tables are nested too
            deeply; the message follows the scene's name.
    """
    if len(text) > MAX_TEXT_BYTES:
        raise InputError(f"has {len(text):,} characters; must have up to {MAX_TEXT_BYTES:,}")
    depth = parts = start = 0
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        if kind == "part":
            if not parts:
                start = token.start()
            parts += 1
            if parts > _MOST_NESTED:
                key = cut(text[start : start + 100])
                raise InputError(
                    f"the key {key} has more than {_MOST_NESTED} parts {_line(text, start)}"
                )
        elif kind not in ("dot", "space"):
            parts = 0
        if kind == "opening":
            depth += 1
            if depth > _MOST_NESTED:
                raise InputError(f"{_TOO_DEEP} {_line(text, token.start())}")
        elif kind == "closing":
            depth = max(depth - 1, 0)


def _line(text: str, position: int) -> str:
    return f"(at line {text.count(chr(10), 0, position) + 1})"


def check_values(values: object) -> None:
    """Refuse values that are nested too deeply.

    Raises:
        InputError: the message follows the scene's name.
    """
    # Not by recursion, which is what has to be bounded.
    waiting = [(values, 0)]
    while waiting:
        value, depth = waiting.pop()
        if depth > _MOST_NESTED:
            raise InputError(_TOO_DEEP)
        if isinstance(value, Mapping):
            waiting += [(item, depth + 1) for item in value.values()]
        elif isinstance(value, list | tuple):
            waiting += [(item, depth + 1) for item in value]
