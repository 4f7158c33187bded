"""Which known key was meant by one that is not known: the same word misspelt, or another word.

Letters alone mislead: latitude is nearer to altitude than elevation is, and endings such as
``_deg`` make any two angles look alike. So names are compared without their units, and a name in a
unit of another kind is another thing.
"""

import difflib
import re
from collections.abc import Iterable

_UNITS = (
    {"deg", "rad", "degrees"},
    {"m", "km", "cm", "mm", "um", "nm"},
    {"px", "pix"},
    {"per_m3", "per_cm3", "per_l"},
    {"mm_h", "mm"},
    {"w_m2", "w"},
    {"lm", "klm"},
    {"c", "k", "f"},
)
"""Units as names end with them, by what they measure."""
_ENDING = re.compile(rf"(.+?)_({'|'.join(sorted(set.union(*_UNITS), key=len, reverse=True))})")
_SAME = {
    "air": "atmosphere",
    "bearing": "azimuth",
    "drops": "droplets",
    "elevation": "altitude",
    "heading": "azimuth",
    "lamp": "light",
    "location": "position",
    "pitch": "altitude",
    "polariser": "polarizer",
    "rain": "droplets",
    "raindrops": "droplets",
    "resolution": "size",
    "sun": "light",
    "tilt": "altitude",
    "yaw": "azimuth",
}
"""Other words for the same."""
_OTHER = {"date", "height", "latitude", "longitude", "roll", "time", "width"}
"""Words for what no key is about that is spelt alike."""
_LEAST_LIKENESS = 0.8
"""Of two spellings of one word, as difflib measures it: one letter in five may be wrong."""

_OF_A_PART = 0.85
"""Likeness of a part of a word to it, such as ``rate`` to ``rain_rate``."""


def nearest(unknown: str, known: Iterable[str]) -> str | None:
    """Give the known key that an unknown one means; None if none does."""
    word, unit = _parts(unknown)
    word = _SAME.get(word, word)
    found: tuple[float, str] = (0.0, "")
    for key in known:
        other, other_unit = _parts(key)
        if unit and other_unit and not any({unit, other_unit} <= kind for kind in _UNITS):
            continue
        likeness = _likeness(word, other)
        if not unit:  # it may be the unit that is misspelt
            likeness = max(likeness, _likeness(word, key))
        found = max(found, (likeness, key), key=lambda pair: pair[0])
    likeness, key = found
    return key if likeness >= _LEAST_LIKENESS else None


def _likeness(word: str, known: str) -> float:
    """Say how surely a word means a known one, 0 to 1."""
    if word == known:
        return 1.0
    if word in _OTHER:
        return 0.0
    likeness = difflib.SequenceMatcher(None, word, known).ratio()
    part = len(word) >= 3 and (known.startswith(word) or word in _ends(known))
    return max(likeness, _OF_A_PART) if part else likeness


def _ends(word: str) -> list[str]:
    """Give a word's ends: ``rate_max`` and ``max`` of ``rain_rate_max``."""
    parts = word.split("_")
    return ["_".join(parts[start:]) for start in range(1, len(parts))]


def _parts(key: str) -> tuple[str, str]:
    """Split a key into word and unit, which may be empty."""
    match = _ENDING.fullmatch(key.lower())
    return (match[1], match[2]) if match else (key.lower(), "")
