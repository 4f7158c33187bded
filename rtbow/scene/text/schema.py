"""What a scene may hold, by key: for messages, overrides, the panel and documents."""

import json
import re
import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from rtbow.scene.model import Scene
from rtbow.scene.text.nearest import nearest

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
MOST_KEY = 80
"""Characters of a key that are shown and compared with known ones, which are shorter."""
_INDEX = re.compile(r"0|[1-9][0-9]{0,8}")


@dataclass(frozen=True)
class Node:
    """One place in the schema: a table (``models``), a list (``items``) or a single value.

    ``models`` has several entries where the table is of one of several kinds; ``items`` are the
    annotations of a list's items, of which an ``open`` list repeats the first; ``unit`` is that of
    every number in it.
    """

    annotation: Any
    metadata: tuple[Any, ...]
    models: tuple[type[BaseModel], ...] = ()
    items: tuple[Any, ...] = ()
    open: bool = False
    default: Any = None
    unit: str = ""

    @classmethod
    def of(
        cls,
        annotation: object,
        metadata: tuple[Any, ...] = (),
        default: object = None,
        unit: str = "",
    ) -> "Node":
        """Return the node of a type annotation, seen through ``Annotated`` and ``| None``."""
        while True:
            if get_origin(annotation) is Annotated:
                annotation, *extra = get_args(annotation)
                for item in extra:
                    metadata += tuple(item.metadata) if isinstance(item, FieldInfo) else (item,)
                continue
            choices = [a for a in get_args(annotation) if a is not type(None)]
            if get_origin(annotation) in (Union, types.UnionType) and len(choices) == 1:
                annotation = choices[0]
                continue
            break
        if get_origin(annotation) is tuple:
            items = get_args(annotation)
            is_open = items[-1] is Ellipsis
            items = items[:1] if is_open else items
            return cls(annotation, metadata, (), items, is_open, default, unit)
        choices = choices if get_origin(annotation) in (Union, types.UnionType) else [annotation]
        models = tuple(c for c in choices if isinstance(c, type) and issubclass(c, BaseModel))
        return cls(annotation, metadata, models, default=default, unit=unit)

    @property
    def fields(self) -> dict[str, FieldInfo]:
        """The keys this table may hold, in order; none if it is no table."""
        fields: dict[str, FieldInfo] = {}
        for model in self.models:
            for name, field in model.model_fields.items():
                fields.setdefault(name, field)
        return fields

    def child(self, part: str | int) -> "Node | None":
        """Return what lies under a key or list index; None if the schema has no such place."""
        if isinstance(part, int):
            if self.items and (self.open or part < len(self.items)):
                return Node.of(self.items[0 if self.open else part], unit=self.unit)
            return None
        field = self.fields.get(part)
        if field is None:
            return None
        if len(self.models) > 1 and get_origin(field.annotation) is Literal:
            # The key that selects the kind may have the value of any.
            tags = [
                get_args(m.model_fields[part].annotation)
                for m in self.models
                if part in m.model_fields
            ]
            return Node(Literal[tuple(dict.fromkeys(sum(tags, ())))], ())
        default = None if field.is_required() else field.default
        extra = field.json_schema_extra
        unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
        return Node.of(field.annotation, tuple(field.metadata), default, unit)

    def kind(self, tag: object) -> "Node":
        """Return the node of the one kind of table that has ``tag`` as its discriminator."""
        for model in self.models:
            if any(tag in get_args(field.annotation) for field in model.model_fields.values()):
                return Node(model, (), models=(model,))
        return self

    @property
    def range(self) -> str:
        """The allowed range of a number, such as ``1..5000``; empty if there is none."""
        limits = {
            name: _number(getattr(limit, name))
            for limit in self.metadata
            for name in ("ge", "gt", "le", "lt")
            if hasattr(limit, name)
        }
        if limits.keys() == {"ge", "le"}:
            return f"{limits['ge']}..{limits['le']}"
        words = {
            "gt": "greater than {}",
            "ge": "{} or more",
            "lt": "less than {}",
            "le": "up to {}",
        }
        return " and ".join(
            text.format(limits[name]) for name, text in words.items() if name in limits
        )

    @property
    def allowed(self) -> str:
        """The range with its unit, as messages say it, such as ``1..5000 µm``."""
        unit = re.sub("^1/", "per ", self.unit)
        return f"{self.range} {unit}".strip() if self.range else ""

    def expects(self) -> str:
        """Return in words what is allowed, to follow "must be"."""
        if self.models:
            return "a table"
        if get_origin(self.annotation) is Literal:
            return one_of(get_args(self.annotation))
        if self.items:
            return self._list_in_words()
        word = {
            float: "a number",
            int: "a whole number",
            bool: "true or false",
            str: "text in quotes",
            float | str: "a number or text in quotes",
            dict[str, Any]: "a table of scene keys and values",
        }[self.annotation]
        return f"{word}, {self.allowed}" if self.range else word

    def _list_in_words(self) -> str:
        item = Node.of(self.items[0], unit=self.unit)
        if item.models:
            return "one or more tables"
        if item.items:
            limits = Node.of(item.items[0], unit=self.unit).allowed
            return f"a list of {len(self.items)} lists of {len(item.items)} numbers, each {limits}"
        word = {float: "numbers", int: "whole numbers"}[item.annotation]
        count = "one or more" if self.open else str(len(self.items))
        limits = f", each {item.allowed}" if item.range else ""
        return f"a list of {count} {word}{limits}"


ROOT = Node.of(Scene)


def node_at(key: str) -> Node | None:
    """Return what lies under a dotted key as typed after ``--set``; None if no scene has it."""
    node: Node | None = ROOT
    for part in key.split("."):
        if node is not None and node.annotation == dict[str, Any]:
            node = ROOT  # a free table holds keys of another scene
        if node is None:
            return None
        if node.items:
            node = node.child(int(part)) if _INDEX.fullmatch(part) else None
        else:
            node = node.child(part)
    return node


def walk_fields() -> Iterator[tuple[str, str, FieldInfo]]:
    """Yield (table, key, field) of every single value or list in a scene file.

    Tables are named as in ``--set``, with ``light.0`` for the tables of a list. A key that several
    kinds of the same table share comes once.
    """
    yield from _walk("", ROOT)


def _walk(table: str, node: Node) -> Iterator[tuple[str, str, FieldInfo]]:
    inner: list[tuple[str, Node]] = []
    for name, field in node.fields.items():
        child = node.child(name)
        assert child is not None
        path = f"{table}.{name}" if table else name
        item = child.child(0)
        if child.models:
            inner.append((path, child))
        elif item is not None and item.models:
            inner.append((f"{path}.0", item))
        else:
            yield table, name, field
    for path, child in inner:
        yield from _walk(path, child)


def suggestion(table: str, node: Node, unknown: str) -> str:
    """Return the remedy for an unknown key of a table: the nearest known key, or all of them."""
    elsewhere = [f"{place}.{key}" for place, key, _ in walk_fields() if key == unknown]
    if elsewhere:
        return f"did you mean {' or '.join(elsewhere)}?"
    near = nearest(unknown[:MOST_KEY], node.fields)
    if near:
        return f"did you mean {f'{table}.' if table else ''}{near}?"
    return f"known here: {', '.join(node.fields)}"


def dotted(path: tuple[str | int, ...]) -> str:
    """Return a key path as it is typed after ``--set``; odd keys are quoted."""
    return ".".join(
        str(part) if isinstance(part, int) or _BARE_KEY.fullmatch(part) else toml_text(part)
        for part in path
    )


def toml_text(value: object) -> str:
    """Return a value as TOML on one line; None, which TOML lacks, as ``none``."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        inner = ", ".join(f"{dotted((str(k),))} = {toml_text(v)}" for k, v in value.items())
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_text, value))}]"
    try:
        return str(value)
    except ValueError:  # Python refuses to print integers of more than 4300 digits
        return "(a number of thousands of digits)"


def one_of(values: tuple[object, ...]) -> str:
    """Return ``"a"``, or ``one of "a", "b"``."""
    text = ", ".join(map(toml_text, values))
    return text if len(values) == 1 else f"one of {text}"


def _number(value: float) -> str:
    return f"{value:g}".replace("e+0", "e").replace("e+", "e")
