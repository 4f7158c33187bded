"""The error budget: stages of the computation, each measured alone, and their document."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from markup import bullets, paragraph, table
from rtbow.frames.difference import FrameDifference, Spread

COMMAND = "python tools/accuracy.py budget"


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


Measurement = Iterator[Row | str]
"""Rows, and findings in words and numbers that stand below the stage's table."""


@dataclass(frozen=True)
class Stage:
    """A source of error.

    Attributes:
        title: its heading.
        about: what is compared with what.
        measure: yields rows and findings as they are ready.
    """

    title: str
    about: str
    measure: Callable[[], Measurement]


@dataclass
class Outcome:
    """What a stage gave.

    Attributes:
        name: the stage's name.
        stage: the stage.
        rows: its measurements.
        notes: its findings.
        failure: why it ended early; empty if it did not.
    """

    name: str
    stage: Stage
    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    failure: str = ""


def run_stage(name: str, stage: Stage, say: Callable[[str], None]) -> Outcome:
    """Measure a stage; what it measured before a failure is kept.

    Args:
        name: its name.
        stage: the stage.
        say: shows a line of progress.
    """
    outcome = Outcome(name, stage)
    try:
        for item in stage.measure():
            if isinstance(item, Row):
                outcome.rows.append(item)
                say("  " + " ".join(f"{cell:<9}" for cell in _numbers(item)) + f"  {item.what}")
            else:
                outcome.notes.append(item)
                say(f"  {item}")
    # A stage may fail in any way: the others' results must not be lost with it.
    except Exception as error:
        outcome.failure = f"{type(error).__name__}: {error}"
        say("".join(traceback.format_exception(error)))
    return outcome


DUSK_BEGIN = "<!-- tools/dusk.py: begin -->"
DUSK_END = "<!-- tools/dusk.py: end -->"


def section_of(text: str) -> str:
    """Give the section of a document that ``tools/dusk.py`` wrote; empty where it has none."""
    begin, end = text.find(DUSK_BEGIN), text.find(DUSK_END)
    return text[begin : end + len(DUSK_END)] if 0 <= begin < end else ""


def with_section(text: str, section: str) -> str:
    """Put that section into a document, in the place of the one that it has, or at its end."""
    before = section_of(text)
    return text.replace(before, section) if before else f"{text.rstrip()}\n\n{section}\n"


def document(outcomes: Sequence[Outcome], facts: Mapping[str, str]) -> str:
    """Write the budget as Markdown.

    Args:
        outcomes: the stages, in order.
        facts: what the numbers depend on, such as the GL renderer's name.
    """
    return "\n\n".join(_document(outcomes, facts)) + "\n"


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
_TITLES = ("ΔE median", "ΔE 99 %", "ΔE worst", "rel. median", "rel. 99 %", "rel. worst", "L2")


def _document(outcomes: Sequence[Outcome], facts: Mapping[str, str]) -> Iterator[str]:
    yield "# Error budget"
    yield f"Written by `{COMMAND}`, from the numbers it measures; edit that, not this."
    yield "\n".join(f"- {name}: {value}" for name, value in facts.items())
    yield from map(paragraph, _HOW_TO_READ)
    yield "## At a glance"
    yield "A row or two of each stage, near the settings that a scene has by default."
    headlines = [
        (f"[{stage.title}](#{_anchor(stage.title)})", row.what, *_numbers(row))
        for stage, rows in ((outcome.stage, outcome.rows) for outcome in outcomes)
        for row in rows
        if row.headline
    ]
    yield table(("stage", "case", *_TITLES), headlines)
    failed = [outcome.stage.title for outcome in outcomes if outcome.failure]
    if failed:
        yield f"**Failed, and incomplete below: {', '.join(failed)}.**"
    for outcome in outcomes:
        yield f"## {outcome.stage.title}"
        yield paragraph(outcome.stage.about)
        yield f"`{COMMAND} --stage {outcome.name}`"
        if outcome.rows:
            cells = [(row.what, row.scene, *_numbers(row)) for row in outcome.rows]
            yield table(("case", "scene", *_TITLES), cells)
        if outcome.notes:
            yield bullets(outcome.notes)
        if outcome.failure:
            yield f"**Failed: {outcome.failure}**"


def _anchor(title: str) -> str:
    """Give a heading's anchor as GitHub does."""
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -_")
    return kept.replace(" ", "-")


def _numbers(row: Row) -> tuple[str, ...]:
    """Give the cells of the numbers, dashes where there is none."""
    colour: tuple[str, ...] = ("–",) * 3
    relative, l2 = row.relative, "–"
    if row.difference:
        relative, l2 = row.difference.relative, _share(row.difference.l2)
        colour = tuple(map(_colour, _ends(row.difference.delta_e)))
    shares = tuple(map(_share, _ends(relative))) if relative else ("–",) * 3
    return (*colour, *shares, l2)


def _ends(spread: Spread) -> tuple[float, float, float]:
    return spread.median, spread.p99, spread.worst


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
