"""Types of options and the progress bar that several verbs of the command line share."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rtbow.arrays import Progress

    _NumbersType = click.ParamType[tuple[float, ...]]
else:  # generic since click 8.4 alone
    _NumbersType = click.ParamType


class Numbers(_NumbersType):
    """Numbers with commas between them."""

    name = "A,B,..."

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[float, ...]:
        """Parse ``100,500``."""
        if isinstance(value, tuple):
            return value
        try:
            return tuple(float(part) for part in str(value).split(","))
        except ValueError:
            self.fail(f"{value!r} is not a list of numbers such as 100,500,1000", param)


def progress_bar(label: str, quiet: bool, unit: str = "row") -> Progress:
    """Give a wrapper that shows a bar on a terminal and nothing in a pipe."""

    def wrap(items: Iterable[int]) -> Iterable[int]:
        from tqdm import tqdm

        # disable=None: only where stderr is a terminal.
        hidden = True if quiet else None
        bar: Iterable[int] = tqdm(items, desc=label, unit=unit, leave=False, disable=hidden)
        return bar

    return wrap
