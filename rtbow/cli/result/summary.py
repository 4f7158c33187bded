"""What ``rtbow render`` says of the frame that it made, in three lines at most, and as JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rtbow.base.errors import InputError
from rtbow.base.version import __version__

if TYPE_CHECKING:
    from rtbow.frames.bows.measured import BowMeasures, FrameMeasures

STREAM = "-"
"""The name of standard output."""


@dataclass(frozen=True)
class Made:
    """How a frame was made; the names are the keys of ``--json``.

    Attributes:
        scene: its name or path.
        command: what was typed.
        method: what drew it.
        unsuited: why ``auto`` did not take ``fast``; empty if it did, or was not asked.
        max_delta_e: CIEDE2000 that 99 of 100 pixels keep against the exact picture; None where the
            method states no such bound.
        seconds: time taken, tables and programs included.
        gl_renderer: the GL device and driver, or the CPU.
        exposure_ev100: exposure value of the picture; None where none was written or asked for.
        notes: what of the scene is not drawn as it stands, and why no bow shows.
        outputs: the files.
    """

    scene: str
    command: str
    method: str
    unsuited: str
    max_delta_e: float | None
    seconds: float
    gl_renderer: str
    exposure_ev100: float | None
    notes: tuple[str, ...]
    outputs: tuple[str, ...]

    def as_json(self, numbers: FrameMeasures) -> dict[str, Any]:
        """Give all there is to say, as JSON holds it."""
        return {"rtbow_version": __version__, **vars(self), **numbers.as_json()}


def summary_lines(made: Made, numbers: FrameMeasures) -> Iterator[str]:
    """Give the lines of a terminal: the method, the frame, its bows where there are any.

    The first has said ``method NAME``, and why, from the beginning: it stays as it is.
    """
    reason = made.unsuited.rpartition("; ")[0] or made.unsuited  # without its remedy
    yield f"method {made.method}" + (f": {reason}" if reason else "")
    parts = [f"{made.seconds:.2f} s", f"peak {numbers.peak_luminance_cd_m2:.4g} cd/m2"]
    if made.exposure_ev100 is not None:
        parts.append(f"EV {made.exposure_ev100:.2f}")
    if made.max_delta_e is not None:
        parts.append(f"CIEDE2000 at most {made.max_delta_e:.3g} (99 % of pixels)")
    yield ", ".join(parts)
    if numbers.bows:
        yield "; ".join(_bow_text(bow, numbers.bows) for bow in numbers.bows)


def _bow_text(bow: BowMeasures, others: Sequence[BowMeasures]) -> str:
    width = "" if bow.width_deg is None else f", width {bow.width_deg:.2f}"
    return f"{bow_label(bow, others)} bow: radius {bow.radius_deg:.2f}{width} deg"


def bow_label(bow: BowMeasures, others: Sequence[BowMeasures]) -> str:
    """Name a bow, by its light and part of the picture only where there are several."""
    light = f"{bow.light} " if len({other.light for other in others}) > 1 else ""
    part = f"{('left', 'right')[bow.part]} " if any(other.part for other in others) else ""
    return f"{part}{light}{bow.bow}"


def check_json(json_file: str | None, others: Sequence[str] = ()) -> None:
    """Check before long work that the JSON can be written.

    Args:
        json_file: where to; ``-`` is standard output, None nowhere.
        others: the outputs beside it.

    Raises:
        InputError: another suffix, a place that cannot be written, or standard output twice.
    """
    from rtbow.base.files import check_writable

    if json_file == STREAM:
        if STREAM in others:
            raise InputError(
                "--json -: standard output takes the picture already; name a .json file"
            )
        return
    if json_file is not None:
        check_writable(json_file, (".json",))


def write_json(json_file: str, values: Mapping[str, Any]) -> None:
    """Write an object as JSON, whole or not at all, or to standard output.

    Raises:
        InputError: the file cannot be written.
    """
    from rtbow.base.files import write_atomic

    text = json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False)
    if json_file == STREAM:
        click.echo(text)
        sys.stdout.flush()
    else:
        write_atomic(Path(json_file), f"{text}\n".encode())
