"""Few of many combinations that still hold every meeting of a few values."""

from collections.abc import Hashable, Iterable, Iterator, Mapping
from itertools import combinations
from typing import TypeVar

Value = TypeVar("Value", bound=Hashable)


def pairwise(shapes: Iterable[Mapping[str, Value]]) -> Iterator[dict[str, Value]]:
    """Choose few shapes in which any two values meet that meet in some shape.

    Args:
        shapes: values of the same switches.
    """
    parts = {
        tuple(shape.items()): set(combinations(sorted(shape.items(), key=str), 2))
        for shape in shapes
    }
    missing = set().union(*parts.values())
    while missing:
        chosen = max(parts, key=lambda shape: len(parts[shape] & missing))
        missing -= parts[chosen]
        yield dict(chosen)
