"""Messages about wrong scenes, made from the errors of pydantic."""

from collections.abc import Callable, Collection
from typing import get_args

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from rtbow.base.errors import cut
from rtbow.scene.text.lines import Key, Lines
from rtbow.scene.text.numbers import remedy
from rtbow.scene.text.schema import MOST_KEY, ROOT, Node, dotted, one_of, suggestion, toml_text

Problem = tuple[tuple[int | str, ...], str]
"""Where something is wrong, and of which kind."""
_MOST_PROBLEMS = 10
"""More are counted: who mends these sees the next."""
_OUT_OF_RANGE = (
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
)


def explain(
    error: ValidationError,
    name: str,
    overrides: Collection[str],
    lines: Lines | None = None,
    blame: Callable[[Problem], str] | None = None,
) -> str:
    """Return one line per problem: where, what, what is allowed, what to do.

    Args:
        error: of the whole scene.
        name: the scene's file or name, which begins the lines about its text.
        overrides: dotted keys from ``--set``, which begins the lines about them.
        lines: of the scene's text, if there is one.
        blame: gives how the message begins about a problem at a key without an override that an
            override has caused; nothing if the text has it.
    """
    messages: dict[str, None] = {}  # a set that keeps its order
    meant: set[str] = set()  # keys that are there, but misspelt
    problems = error.errors(include_url=False)
    for problem in problems[:_MOST_PROBLEMS]:
        path, node = _place(problem["loc"])
        if problem["type"] == "extra_forbidden":
            meant.add(_misspelt(path, node))
    for problem in problems[:_MOST_PROBLEMS]:
        path, node = _place(problem["loc"])
        kind = problem["type"]
        if kind == "too_short" and len(problem["input"]) >= problem["ctx"]["min_length"]:
            continue  # items with problems of their own are not counted
        if kind == "missing" and dotted(path) in meant:
            continue
        if kind == "missing" and isinstance(path[-1], int):  # a list that is too short
            path, node = _place(problem["loc"][:-1])
            kind = "too_short"
        text, by_override = _text(problem, kind, path, node, overrides)
        if not by_override and blame and (cause := blame(problem_of(problem))):
            messages[f"{cause}: {text}"] = None
        elif by_override:
            set_key = text.startswith(shown_key(path))
            messages[f"--set {text}" if set_key else f"--set: {text}"] = None
        else:
            tag = problem["ctx"]["discriminator"].strip("'") if kind == "union_tag_invalid" else ""
            place = line_text(lines, (*path, tag) if tag else path)
            messages[f"{name}: {place}{text}"] = None
    if len(problems) > _MOST_PROBLEMS:
        messages[f"{name}: and {len(problems) - _MOST_PROBLEMS} more"] = None
    return "\n".join(messages)


def problem_of(problem: ErrorDetails) -> Problem:
    """Return where a problem is and of which kind."""
    return _place(problem["loc"])[0], problem["type"]


def line_text(lines: Lines | None, path: Key) -> str:
    """Return the line of a key, as messages begin; empty if it is not known."""
    line = lines.of(path) if lines is not None else None
    return "" if line is None else f"line {line}: "


def _text(
    problem: ErrorDetails,
    kind: str,
    path: tuple[str | int, ...],
    node: Node,
    overrides: Collection[str],
) -> tuple[str, bool]:
    """Return what is wrong and what to do, and whether it came from ``--set``."""
    key, said, value = dotted(path), shown_key(path), problem["input"]
    by_override = any(key == o or key.startswith(f"{o}.") for o in overrides)
    if kind == "extra_forbidden":
        text = _unknown_key(path, problem["loc"])
    elif kind == "misplaced":
        text = f"{said} {problem['msg']}"
    elif kind == "missing_here":
        text = f"{said} is missing; {problem['msg']}"
    elif kind == "missing":
        text = f"{said} is missing; {_remedy_if_missing(path, node)}"
    elif kind == "union_tag_not_found":
        tag, kinds = _tag_and_kinds(problem, node)
        text = f"{said}.{tag} is missing; must be {kinds}"
    elif kind == "union_tag_invalid":
        tag, kinds = _tag_and_kinds(problem, node)
        by_override = by_override or f"{key}.{tag}" in overrides
        text = f"{said}.{tag} = {shown(value[tag])}; must be {kinds}"
    else:
        text = f"{said} = {shown(value)}; {_remedy(kind, path, node, problem)}"
    # A list or table may be wrong as a whole because of an item set inside it.
    if isinstance(value, list) or kind == "misplaced":
        by_override = by_override or any(o.startswith(f"{key}.") for o in overrides)
    return text, by_override


def _place(loc: tuple[str | int, ...]) -> tuple[tuple[str | int, ...], Node]:
    """Return an error's key path, without the tags of pydantic's unions, and its schema node.

    A path that the schema does not know has the node of its last known table.
    """
    path: list[str | int] = []
    node = ROOT
    for part in loc:
        if len(node.models) > 1:
            node = node.kind(part)
            continue
        path.append(part)
        node = node.child(part) or node
    return tuple(path), node


def _misspelt(path: tuple[str | int, ...], table: Node) -> str:
    hint = suggestion(dotted(path[:-1]), table, str(path[-1]))
    return hint.removeprefix("did you mean ").removesuffix("?")


def _unknown_key(path: tuple[str | int, ...], loc: tuple[str | int, ...]) -> str:
    """Return what to do about an unknown key, or one of another kind of light or distribution."""
    key, table = shown_key(path), dotted(path[:-1])
    _, chosen = _place(loc)
    whole = ROOT
    for part in path[:-1]:
        whole = whole.child(part) or whole
    if len(whole.models) > 1 and path[-1] in whole.fields:
        tag, *keys = chosen.fields
        taken = chosen.child(tag)
        assert taken is not None
        others = one_of(_kinds_with(whole, tag, str(path[-1])))
        return (
            f"{key} does not belong to {tag} = {taken.expects()}, "
            f"which takes {', '.join(keys)}; leave it out or change the {tag} to {others}"
        )
    return f"unknown key {key}; {suggestion(table, chosen, str(path[-1]))}"


def _kinds_with(table: Node, tag: str, key: str) -> tuple[object, ...]:
    """Return the values of a tag with which a table may have a key."""
    return tuple(
        name
        for model in table.models
        if key in model.model_fields
        for name in get_args(model.model_fields[tag].annotation)
    )


def _remedy_if_missing(path: tuple[str | int, ...], node: Node) -> str:
    if path == ("light",):
        return 'a scene needs at least one light: add [[light]] with type = "sun"'
    if path == ("droplets",):
        return "add [droplets] with box_m, radius and density, or with file"
    return f"give {node.expects()}"


def _remedy(kind: str, path: tuple[str | int, ...], node: Node, problem: ErrorDetails) -> str:
    if kind == "refused":
        return problem["msg"]
    if kind == "finite_number":
        return f"must be a finite number{', ' if node.range else ''}{node.allowed}"
    if kind in _OUT_OF_RANGE:
        return f"must be {node.allowed}"
    if kind == "string_too_short":
        return "must not be empty"
    key = dotted(path)
    item = node.child(0)
    if item is not None and item.models:
        return f"must be one or more tables: write [[{key}]], in double brackets"
    if node.models:
        return f"must be a table: write [{key}]"
    example = f", such as {toml_text(node.default)}" if node.items and node.default else ""
    number = remedy(problem["input"]) if isinstance(problem["input"], str) else ""
    return f"must be {node.expects()}{example}{'; ' if number else ''}{number}"


def _tag_and_kinds(problem: ErrorDetails, node: Node) -> tuple[str, str]:
    """Return the key that selects a table's kind, and its allowed values in words."""
    tag = str(problem["ctx"]["discriminator"]).strip("'")
    choice = node.child(tag)
    assert choice is not None
    return tag, choice.expects()


def shown(value: object) -> str:
    """Return a wrong value as TOML, cut to a readable length."""
    return cut(toml_text(value))


def shown_key(path: tuple[str | int, ...]) -> str:
    """Return a key as it is typed, cut where no scene has one as long."""
    return cut(dotted(path), MOST_KEY)
