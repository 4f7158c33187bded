"""Numbers as people write them, and TOML does not: what to write instead."""

import re

_FORMS: tuple[tuple[str, str], ...] = (
    (r"(?P<sign>[-+]?)(?P<whole>\d+),(?P<part>\d+)", "write {} with a point"),
    (r"(?P<sign>[−–])(?P<whole>\d+)(?:\.(?P<part>\d+))?", "write {} with a plain minus sign (-)"),
    (r"(?P<sign>[-+]?)\.(?P<part>\d+)", "write {} with a digit before the point"),
    (r"(?P<sign>[-+]?)(?P<whole>\d+)\.", "write {} with a digit behind the point"),
    (
        r"(?P<sign>[-+]?)0+(?P<whole>[1-9]\d*)(?:\.(?P<part>\d+))?",
        "write {} without zeros in front",
    ),
    (
        r"(?P<sign>[-+]?)(?P<whole>\d{1,3}(?:[ '’]\d{3})+)(?:\.(?P<part>\d+))?",
        "write {} without marks between thousands",
    ),
)
"""Patterns of whole texts, and what to do about each, with the number as TOML has it."""
_UNIT = re.compile(
    r"(?P<number>[-+]?(?:\d+(?:[.,]\d*)?|\.\d+)(?:[eE][-+]?\d+)?)\s*"
    r"(?P<unit>°C|°|º|%|′|″|deg(?:rees?)?|[kcmµun]?m|[µu]m|px|K|EV|s|lm|W/m²|mm/h)"
)
_VALUE = re.compile(r"=\s*(?P<value>[^#\"'\[{]*?)\s*(?:#.*)?$")


def remedy(text: str) -> str:
    """Say how a number is written in TOML; nothing where a text is no number at all.

    Args:
        text: as it was typed, such as ``5,0`` or ``5°``.

    Returns:
        Such as ``write 5.0 with a point``.
    """
    typed = text.strip()[:60]
    if with_unit := _UNIT.fullmatch(typed):
        number, unit = with_unit["number"], with_unit["unit"]
        plain = _plain(number)
        if unit in ("°", "º", "%", "′", "″"):
            return f"write {plain} without the sign {unit}"
        return f"write {plain} without {unit}: the key's name has its unit"
    for pattern, what in _FORMS:
        if re.fullmatch(pattern, typed):
            return what.format(_plain(typed))
    return ""


def remedy_in_line(line: str) -> str:
    """Say the same of the value in a line of a scene's text; nothing where it is another."""
    found = _VALUE.search(line)
    return remedy(found["value"]) if found else ""


def _plain(typed: str) -> str:
    """Give a number as TOML has it."""
    number = re.sub(r"[ '’_]", "", typed).replace(",", ".").replace("−", "-").replace("–", "-")
    sign, digits = ("-", number[1:]) if number[0] == "-" else ("", number.lstrip("+"))
    whole, point, part = digits.partition(".")
    whole = whole.lstrip("0") or "0"
    return f"{sign}{whole}{point}{part or '0'}" if point else f"{sign}{whole}"
