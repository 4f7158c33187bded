"""Names for files that are not taken."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path

_MOST = 10_000


def free_name(
    stem: str, suffixes: Sequence[str], folder: Path | None = None, taken: Collection[str] = ()
) -> str:
    """Give a name that no file has, without its ending: ``shower-01``.

    Args:
        stem: what it begins with.
        suffixes: endings, with none of which there is such a file.
        folder: where; None is the current one.
        taken: absolute paths that are as good as taken, such as of files being written.
    """
    place = os.path.abspath(folder or "")
    for number in range(1, _MOST):
        name = f"{stem}-{number:02d}"
        paths = [os.path.join(place, f"{name}{suffix}") for suffix in suffixes]
        if not any(path in taken or os.path.lexists(path) for path in paths):
            return name
    return f"{stem}-{_MOST}"
