"""What a panel knows about each key of the scene, taken from its model alone.

A new key of the scene appears with label, unit, range and help of its own, without code here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rtbow.base.arrays import AXES
from rtbow.scene.text.schema import Node

Kind = Literal[
    "number", "flag", "choice", "tag", "spectrum", "path", "text", "vector", "corners", "boxes",
    "table", "tables", "overrides", "other",
]  # fmt: skip
"""How a value is shown; a ``tag`` chooses the kind of the table that it stands in."""

_STEPS = 400
"""Least number of steps of a linear slider."""
_LOG_DIGITS = 3
"""Digits of a logarithmic slider's numbers."""
_DEFAULT_MIDDLE = 1.0
_LABELS = {"max_delta_e": "error bound, ΔE"}
"""Labels of keys whose own names read badly."""
_MOST_DIGITS = 16
_NUMBER = r"-?\d+(\.\d+)?(e-?\d+)?"


@dataclass(frozen=True)
class Slide:
    """The range of a slider; typed numbers may be far beyond it.

    Attributes:
        low, high: its ends.
        log: whether it moves by factors.
        whole: whether it gives whole numbers only.
    """

    low: float
    high: float
    log: bool = False
    whole: bool = False

    def value(self, share: float) -> float:
        """Give the number at a share of the way, in few digits."""
        share = min(max(share, 0.0), 1.0)
        if share in (0.0, 1.0):
            return self._typed((self.low, self.high)[int(share)])
        if self.log:
            number = self.low * (self.high / self.low) ** share
            return self._typed(rounded(number, _LOG_DIGITS))
        number = self.low + share * (self.high - self.low)
        return self._typed(round(number, self.decimals))

    @property
    def decimals(self) -> int:
        """Decimal places of a linear slider's numbers."""
        return max(0, -math.floor(math.log10((self.high - self.low) / _STEPS)))

    def _typed(self, number: float) -> float:
        number = min(max(number, self.low), self.high)
        return round(number) if self.whole else number + 0.0

    def share(self, value: float) -> float:
        """Give how far along a number stands, from 0 to 1; those beyond are at the end."""
        if value <= self.low:
            return 0.0
        if value >= self.high:  # a whole number may be beyond all floats
            return 1.0
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    @property
    def middle(self) -> float:
        """A number to begin with."""
        return self.value(0.5)


@dataclass(frozen=True)
class Row:
    """A key of the scene as the panel shows it.

    Attributes:
        path: dotted, as after ``--set``.
        name: the last of its parts.
        label: in words, without the unit.
        unit: as shown behind numbers; empty if there is none.
        description, effect: what it is, and what it does to the bow.
        kind: which widget shows it.
        node: its place in the schema.
        optional: whether it may be left out.
        absent: what holds where it is left out.
        slide: what its slider, or that of each component, runs over; None if it has no ends.
        names: of a vector's components, of the items that a list may have.
        choices: of those that have choices.
        option: of the command line, for a value that is not the scene's; None for ``--set``.
    """

    path: str
    name: str
    label: str
    unit: str
    description: str
    effect: str
    kind: Kind
    node: Node
    optional: bool = False
    absent: str = ""
    slide: Slide | None = None
    names: tuple[str, ...] = ()
    choices: tuple[Any, ...] = ()
    option: str | None = None

    @property
    def range(self) -> str:
        """What may be typed, in words; empty if the kind of value says it."""
        if self.kind in ("flag", "tag", "table", "tables", "overrides", "spectrum", "path", "text"):
            return ""
        if self.option is not None:  # of the panel's own
            return ""
        if self.kind == "number":
            return self.node.range
        return replace(self.node, unit="").expects()  # which is said beside it

    @property
    def absent_text(self) -> str:
        """What holds where the value is left out, in few words; a number has its unit."""
        text = self.absent.split(",")[0]
        return text + shown_unit(self.unit) if re.fullmatch(_NUMBER, text) else text

    @property
    def start(self) -> float:
        """A first number for a value that was left out: the one that held then, if documented."""
        default = re.search(_NUMBER, self.absent)
        number = (
            float(default[0]) if default else self.slide.middle if self.slide else _DEFAULT_MIDDLE
        )
        return round(number) if self.node.annotation is int else number

    def inside(self, index: int) -> str:
        """The path of an item."""
        return f"{self.path}.{index}"


def own_row(
    path: str,
    label: str,
    description: str,
    effect: str = "",
    kind: Kind = "flag",
    *,
    unit: str = "",
    slide: Slide | None = None,
    choices: tuple[Any, ...] = (),
    names: tuple[str, ...] = (),
    option: str = "",
) -> Row:
    """Give a row of the panel's own, for what is not in the scene.

    Args:
        path: which identifies it.
        label, description, effect, kind, unit, slide, choices, names: as a row has them.
        option: of the command line; empty if there is none.
    """
    return Row(
        path, path, label, unit, description, effect, kind, Node(float, ()),
        slide=slide, names=names, choices=choices, option=option,
    )  # fmt: skip


def rounded(number: float, digits: int) -> float:
    """Give a number of few decimal digits."""
    return float(f"{number:.{digits - 1}e}")


def shown_number(number: float) -> str:
    """Write a number in up to six digits, a whole one in more."""
    if isinstance(number, int):
        text = str(number)
        return text if len(text) <= _MOST_DIGITS else f"{text[:6]}…{text[-4:]}"
    return f"{number:.6g}".replace("e+0", "e").replace("e+", "e").replace("e-0", "e-")


def shown_unit(unit: str) -> str:
    """Write a unit as it stands behind a number, with its space."""
    words = unit.replace("1/", "per ")
    return "°" if unit == "deg" else f" {words}" if unit else ""


def label_of(name: str, unit: str) -> str:
    """Write a key in words, without the unit that it ends with."""
    if name in _LABELS:
        return _LABELS[name]
    ending = unit.replace("1/", "per_").replace("/", "_").replace("µ", "u").replace("°", "")
    ending = "_" + ending.replace("²", "2").replace("³", "3").lower()
    return (name.removesuffix(ending) or name).replace("_", " ")


@lru_cache(maxsize=512)
def rows_of(
    table: str, model: type[BaseModel], kinds: tuple[type[BaseModel], ...] = ()
) -> tuple[Row, ...]:
    """Give the rows of a table, in the model's order.

    Args:
        table: its path; empty for the scene.
        model: its class.
        kinds: all that it might be instead, if there are several.
    """
    node = Node(model, (), models=(model,))
    union = Node(model, (), models=kinds or (model,))
    rows = []
    for name, field in model.model_fields.items():
        child = node.child(name)
        assert child is not None
        path = f"{table}.{name}" if table else name
        row = _row(path, name, field, child)
        if len(kinds) > 1 and row.kind == "choice" and len(row.choices) == 1:
            tags = union.child(name)
            assert tags is not None
            row = replace(row, kind="tag", choices=get_args(tags.annotation), node=tags)
        rows.append(row)
    return tuple(rows)


def _row(path: str, name: str, field: FieldInfo, node: Node) -> Row:
    extra = field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    description = field.description or ""
    optional = type(None) in get_args(field.annotation)
    kind = _kind(name, node)
    inner = node
    while inner.items:
        inner = Node.of(inner.items[0])
    left_out = description.partition("left out: ")[2]
    usual = extra.get("usual")
    return Row(
        path=path,
        name=name,
        label=label_of(name, unit),
        unit=unit,
        description=description,
        effect=str(extra.get("effect", "")),
        kind=kind,
        node=node,
        optional=optional,
        absent=left_out,
        slide=_slide(inner, usual if isinstance(usual, list) else None, bool(extra.get("log"))),
        names=_names(kind, node, unit, description, inner),
        choices=get_args(node.annotation) if kind == "choice" else (),
    )


def _kind(name: str, node: Node) -> Kind:
    if node.models:
        return "table"
    if get_origin(node.annotation) is Literal:
        return "choice"
    if node.items:
        return _kind_of_list(node)
    if node.annotation is str:
        named: dict[str, Kind] = {"spectrum": "spectrum", "file": "path"}
        return named.get(name, "text")
    kinds: dict[Any, Kind] = {
        float: "number", int: "number", bool: "flag", dict[str, Any]: "overrides",
    }  # fmt: skip
    return kinds.get(node.annotation, "other")


def _kind_of_list(node: Node) -> Kind:
    items = [Node.of(item) for item in node.items]
    if items[0].models:
        return "tables"
    if node.open:
        low, high = _limits(items[0])
        few = items[0].annotation is int and low is not None and high is not None
        return "boxes" if few else "other"
    if all(item.annotation in (float, int) for item in items):
        return "vector"
    inside = [Node.of(part) for item in items for part in item.items]
    return "corners" if inside and all(p.annotation in (float, int) for p in inside) else "other"


_PAIRS = {
    "px": ("width", "height"), "mm": ("width", "height"), "m": ("reach", "height"),
    "": ("right", "up"),
}  # fmt: skip
"""Names of two numbers by their unit."""


def _limits(node: Node) -> tuple[float | None, float | None]:
    low: float | None = None
    high: float | None = None
    for limit in node.metadata:
        low = getattr(limit, "ge", getattr(limit, "gt", low))
        high = getattr(limit, "le", getattr(limit, "lt", high))
    return low, high


def _slide(node: Node, usual: Sequence[Any] | None, log: bool) -> Slide | None:
    if node.annotation not in (float, int):
        return None
    low, high = usual or _limits(node)
    if low is None or high is None or not low < high:
        return None
    if log and low <= 0:
        low = high * 1e-6
    return Slide(float(low), float(high), log, node.annotation is int)


def _names(kind: Kind, node: Node, unit: str, description: str, inner: Node) -> tuple[str, ...]:
    """Name components: directions in space, width and height, or what the description says."""
    if kind == "boxes":
        low, high = _limits(inner)
        assert low is not None
        assert high is not None
        named = {
            item: re.search(rf"\b{item} (?:for the )?(\w+)", description)
            for item in range(int(low), int(high) + 1)
        }
        return tuple(f"{item} {match[1]}" if match else str(item) for item, match in named.items())
    if kind not in ("vector", "corners"):
        return ()
    count = len(node.items if kind == "vector" else Node.of(node.items[0]).items)
    if count == len(AXES):
        return AXES
    if count == 2 and unit in _PAIRS:
        return _PAIRS[unit]
    return tuple(str(number) for number in range(count))
