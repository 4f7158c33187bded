"""Array types and the progress hook that signatures share."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Float32 = NDArray[np.float32]
Complexes = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]
Values = Array | float
"""A number or an array of them, where NumPy broadcasts."""

AXES = ("east", "north", "up")
"""Of places in the world."""

Progress = Callable[[Iterable[int]], Iterable[int]]
"""Wraps a loop, to show how far it is."""


@dataclass(frozen=True)
class Steps:
    """The numbers of a job's steps, for :data:`Progress`, with what the job makes.

    Attributes:
        count: how many steps.
        what: what is made, in words that follow a colon.
    """

    count: int
    what: str

    def __iter__(self) -> Iterator[int]:
        return iter(range(self.count))

    def __len__(self) -> int:
        return self.count


def floats(value: Any) -> Array:
    """Give ``value`` as a float64 array."""
    return np.asarray(value, dtype=np.float64)


def no_progress(items: Iterable[int]) -> Iterable[int]:
    """Show nothing."""
    return items


def labelled(label: str, items: Iterable[int]) -> str:
    """Give the label of a loop, with what it makes where that is known (:class:`Steps`)."""
    return f"{label}: {items.what}" if isinstance(items, Steps) else label
