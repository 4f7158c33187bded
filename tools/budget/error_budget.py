"""The error budget: stages of the computation, each measured alone, and their document."""

from __future__ import annotations

import textwrap
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from rtbow.frames.difference import FrameDifference, Spread

COMMAND = "python tools/accuracy.py budget"
_COLUMNS = 100


@dataclass(frozen=True)
class Row:
    """One measurement.

    Attributes:
        what: the case.
        scene: what it was measured on.
        difference: distance of two frames, or None where no frame is drawn.
        relative: of bare numbers, where no frame is drawn.
        headline: whether the row stands for its stage in the summary.
    """

    what: str
    scene: str
    difference: FrameDifference | None = None
    relative: Spread | None = None
    headline: bool = False


@dataclass(frozen=True)
class Note:
    """A finding in words and numbers, below its stage's table."""

    text: str


Measurement = Iterator[Row | Note]


@dataclass(frozen=True)
class Stage:
    """A source of error.

    Attributes:
        title: its heading.
        about: what is compared with what.
        measure: yields rows and notes as they are ready.
    """

    title: str
    about: str
    measure: Callable[[], Measurement]


@dataclass(frozen=True)
class Outcome:
    """What a stage gave.

    Attributes:
        name: the stage's name.
        stage: the stage.
        rows: its measurements.
        notes: its findings.
        failure: why it ended early, or None.
    """

    name: str
    stage: Stage
    rows: tuple[Row, ...]
    notes: tuple[Note, ...]
    failure: str | None = None


def run_stage(name: str, stage: Stage, say: Callable[[str], None]) -> Outcome:
    """Measure a stage; what it found before a failure is kept.

    Args:
        name: its name.
        stage: the stage.
        say: shows a line of progress.
    """
    rows: list[Row] = []
    notes: list[Note] = []
    failure = None
    try:
        for found in stage.measure():
            if isinstance(found, Row):
                rows.append(found)
                say("  " + " ".join(f"{cell:<9}" for cell in _numbers(found)) + f"  {found.what}")
            else:
                notes.append(found)
                say(f"  {found.text}")
    # A stage may fail in any way: the others' results must not be lost with it.
    except Exception as error:
        failure = f"{type(error).__name__}: {error}"
        say("".join(traceback.format_exception(error)))
    return Outcome(name, stage, tuple(rows), tuple(notes), failure)


def document(outcomes: Sequence[Outcome], facts: Mapping[str, str]) -> str:
    """Write the budget as Markdown.

    Args:
        outcomes: the stages, in order.
        facts: what the numbers depend on, such as the GL renderer's name.
    """
    return "\n".join([*_head(facts), *_summary(outcomes), *_stages(outcomes)]) + "\n"


def _head(facts: Mapping[str, str]) -> Iterator[str]:
    yield "# Error budget"
    yield ""
    yield f"Written by `{COMMAND}`, from the numbers it measures; edit that, not this."
    yield ""
    for name, value in facts.items():
        yield f"- {name}: {value}"
    yield ""
    for number, paragraph in enumerate(_HOW_TO_READ):
        if number:
            yield ""
        yield _wrapped(paragraph)
    yield ""


_HOW_TO_READ = (
    "**ΔE2000** is per pixel, against a white of D65 at the 99.5th-percentile luminance of the"
    " reference: a difference of 1 is about what shows between patches side by side. **Relative**"
    " is a pixel's largest difference of X, Y or Z over that white's luminance; where no frame is"
    " drawn, over what the row says. **L2** is the root of the summed squares of the difference of"
    " X, Y, Z over that of the reference. Medians and percentiles are over pixels with light.",
    "A *strip* is a picture one pixel high: 451 rays down through a uniform layer of drops, all of"
    " the same length, with scattering angles from 90° to 180° (the antisolar point) by 0.2°; no"
    " air, sun of 0.533°, unless a row says otherwise. There is no sky behind it, so that its dark"
    " parts count in full: in a landscape they would be veiled.",
)


def _wrapped(text: str, *, bullet: bool = False) -> str:
    """Break a paragraph into lines."""
    first, others = ("- ", "  ") if bullet else ("", "")
    # A long number or code is not cut.
    return textwrap.fill(
        text,
        _COLUMNS,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )


_TITLES = ("ΔE median", "ΔE 99 %", "ΔE worst", "rel. median", "rel. 99 %", "rel. worst", "L2")


def _numbers(row: Row) -> tuple[str, ...]:
    """Give the cells of the numbers, dashes where there is none."""
    colour = ("–",) * 3
    relative, l2 = row.relative, "–"
    if row.difference is not None:
        delta = row.difference.delta_e
        colour = (_colour(delta.median), _colour(delta.p99), _colour(delta.worst))
        relative, l2 = row.difference.relative, _share(row.difference.l2)
    shares = ("–",) * 3
    if relative is not None:
        shares = (_share(relative.median), _share(relative.p99), _share(relative.worst))
    return (*colour, *shares, l2)


def _colour(value: float) -> str:
    if value >= 0.995:
        return f"{value:.1f}"
    return f"{value:.2f}" if value >= 0.0095 else f"{value:.0e}" if value > 0.0 else "0"


def _share(value: float) -> str:
    """Write a share in percent, with two digits."""
    if value == 0.0:
        return "0"
    percent = 100.0 * value
    return f"{percent:.0f} %" if percent >= 10.0 else f"{percent:.2g} %"


def _table(titles: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield "| " + " | ".join(titles) + " |"
    yield "| " + " | ".join("---" for _ in titles) + " |"
    for row in rows:
        yield "| " + " | ".join(row) + " |"


def _summary(outcomes: Sequence[Outcome]) -> Iterator[str]:
    yield "## At a glance"
    yield ""
    yield "A row or two of each stage, near the settings that a scene has by default."
    yield ""
    rows = [
        (f"[{outcome.stage.title}](#{_anchor(outcome.stage.title)})", row.what, *_numbers(row))
        for outcome in outcomes
        for row in outcome.rows
        if row.headline
    ]
    yield from _table(("stage", "case", *_TITLES), rows)
    failed = [outcome.stage.title for outcome in outcomes if outcome.failure is not None]
    if failed:
        yield ""
        yield f"**Failed, and incomplete below: {', '.join(failed)}.**"
    yield ""


def _anchor(title: str) -> str:
    """Give a heading's anchor as GitHub does."""
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def _stages(outcomes: Sequence[Outcome]) -> Iterator[str]:
    for number, outcome in enumerate(outcomes):
        if number:
            yield ""
        yield f"## {outcome.stage.title}"
        yield ""
        yield _wrapped(outcome.stage.about)
        yield ""
        yield f"`{COMMAND} --stage {outcome.name}`"
        yield ""
        if outcome.rows:
            cells = [(row.what, row.scene, *_numbers(row)) for row in outcome.rows]
            yield from _table(("case", "scene", *_TITLES), cells)
        if outcome.notes:
            yield ""
            for note in outcome.notes:
                yield _wrapped(note.text, bullet=True)
        if outcome.failure is not None:
            yield ""
            yield f"**Failed: {outcome.failure}**"
