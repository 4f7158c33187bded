"""Plots: the look that they share, and their files."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rtbow.base.cache import quiet_matplotlib
from rtbow.base.files import write_atomic
from rtbow.base.version import __version__

PLOT_SUFFIXES = (".png", ".svg")

# Okabe and Ito, Color Universal Design (2008), without its yellow, which white paper swallows.
COLOURS = ("#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
GREY = "#555555"
GRID_GREY = "#dddddd"
_DPI = 150
_LEAST_RATIO = 10.0
"""Least ratio of a logarithmic axis's ends: noise would fill a shorter one."""
_FEW = 200.0
"""Below this ratio of its ends, a logarithmic axis is labelled at 2 and 5, too."""
_STYLE = {
    "font.family": ["DejaVu Sans"],  # comes with matplotlib: the same picture everywhere
    "font.size": 10.0,
    "axes.linewidth": 0.8,
    "axes.grid": False,
    "lines.linewidth": 1.4,
    "svg.fonttype": "none",  # text stays text, for search and for editing
    "svg.hashsalt": "rtbow",
    "path.simplify": True,
}


@contextmanager
def style() -> Iterator[None]:
    """Draw with the shared fonts and lines within the block."""
    with quiet_matplotlib():
        import matplotlib

        with matplotlib.rc_context(_STYLE):  # type: ignore[arg-type]
            yield


def new_figure(width: float, height: float) -> Any:
    """Make an empty figure, in inches."""
    # No pyplot: its figures are global state, and its backend the user's.
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def caption(figure: Any, text: str) -> None:
    """Write a text, such as what a figure assumes, into a margin below it."""
    width, height = figure.get_size_inches()
    lines = textwrap.wrap(f"{text}. rtbow {__version__}", int(width * 18.0))
    room = (0.14 * len(lines) + 0.12) / height
    # Panels side by side stay far enough apart for the numbers at their corners.
    figure.get_layout_engine().set(rect=(0.0, room, 1.0, 1.0 - room), wspace=0.05)
    figure.text(
        0.08 / width, 0.07 / height, "\n".join(lines), fontsize=7.5, color=GREY, va="bottom"
    )


def legend(axis: Any, columns: int) -> None:
    """Name an axis's curves."""
    # On white, so that no grid line strikes through the words.
    axis.legend(
        fontsize=8.5, ncols=columns, frameon=True, framealpha=0.9, edgecolor="none", fancybox=False
    )


def log_scale(axes: Any, name: str) -> None:
    """Make the x or y axis logarithmic and a decade long at least, with plain numbers along it.

    Args:
        axes: the axes, with all their curves.
        name: ``"x"`` or ``"y"``.
    """
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set(**{f"{name}scale": "log"})
    low, high = getattr(axes, f"get_{name}lim")()
    wider = max(1.0, (_LEAST_RATIO * low / high) ** 0.5)
    low, high = low / wider, high * wider
    axes.set(**{f"{name}lim": (low, high)})
    axis = getattr(axes, f"{name}axis")
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < _FEW * low else (1.0,)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def save(figure: Any, path: Path, dpi: float = _DPI) -> None:
    """Write a figure, ``.png`` or ``.svg``, whole or not at all."""
    buffer = io.BytesIO()
    kind = path.suffix.lower().removeprefix(".")
    # Without a date and the library's version: the same numbers give the same file.
    metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": "rtbow"}
    figure.savefig(buffer, format=kind, dpi=dpi, metadata=metadata)
    write_atomic(path, buffer.getvalue())
