"""Options, their types and the progress bar that verbs of the command line share."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

import click
from click.shell_completion import CompletionItem

from rtbow.base.errors import InputError, RtbowError, cut
from rtbow.base.limits import DEFAULT_DELTA_E, LEAST_DELTA_E, MAX_DISC_DEG, MOST_DELTA_E
from rtbow.physics.constants import SUN_DIAMETER_DEG

if TYPE_CHECKING:
    from rtbow.base.arrays import Progress
    from rtbow.gl.context import Backend
    from rtbow.render.renderer import MethodName
    from rtbow.scene.model import Scene
    from rtbow.scene.text.sun import SunAt

Verb = TypeVar("Verb", bound=Callable[..., Any])


class Option(Protocol):
    """Adds an option, or several, to a verb."""

    def __call__(self, verb: Verb, /) -> Verb:
        """Return the verb with the option."""
        ...


# --- Types: functions that read what was typed, or raise click.BadParameter ---------------------


def two_sides(value: Any) -> tuple[int, int] | None:
    """Read two whole numbers with an x between them, such as ``640x360``; None if they are not.

    A pair of numbers, such as a default, stays as it is.
    """
    if isinstance(value, tuple):
        return int(value[0]), int(value[1])
    sides = str(value).lower().split("x")
    if len(sides) != 2 or not all(side.isascii() and side.isdigit() for side in sides):
        return None
    # Twenty digits exceed every limit; Python refuses to read thousands.
    return int(sides[0][:20]), int(sides[1][:20])


def picture_size(value: Any) -> tuple[int, int]:
    """Read a width and a height in pixels, such as ``640x360``."""
    sides = two_sides(value)
    if sides is None:
        raise click.BadParameter(f"{value!r} is not a size; write width and height such as 640x360")
    from pydantic import ValidationError

    from rtbow.scene.model import Camera, Pixels
    from rtbow.scene.text.schema import Node

    try:
        return Camera(size_px=sides).size_px
    except ValidationError:
        allowed = Node.of(Pixels).range
        raise click.BadParameter(
            f"{value!r} is not a size; each side must be {allowed} pixels"
        ) from None


def exposure_value(value: Any) -> float | None:
    """Read ``auto``, which is None, or an exposure value."""
    if str(value).lower() == "auto":
        return None
    from rtbow.frames.display import EV_LIMIT, max_luminance

    try:
        exposure = float(value)
        max_luminance(exposure)
    except (ValueError, RtbowError):
        raise click.BadParameter(
            f"{value!r} is not an exposure; write auto, or an EV at ISO 100,"
            f" {-EV_LIMIT:g}..{EV_LIMIT:g}, such as 13"
        ) from None
    return exposure


def tolerable_error(value: Any) -> float:
    """Read an error that method ``fast`` can keep, such as ``0.5``."""
    try:
        error = float(value)
    except ValueError:
        error = 0.0
    if not LEAST_DELTA_E <= error <= MOST_DELTA_E:  # NaN too
        raise click.BadParameter(
            f"{value!r} is no error that method fast can keep; write a number,"
            f" {LEAST_DELTA_E:g}..{MOST_DELTA_E:g}, such as {DEFAULT_DELTA_E:g}, or leave it"
            " out for the scene's render.max_delta_e"
        )
    return error


def sun_at(value: Any) -> SunAt:
    """Read a place and a time, such as ``59.9,10.7,2026-07-01T19:30+02:00``."""
    from rtbow.scene.text.sun import SunAt

    try:
        return SunAt.of(value)
    except InputError as error:
        raise click.BadParameter(str(error)) from None


def scene_name(value: Any) -> str:
    """Take a scene's file or name as it is, but refuse the name of a picture."""
    from rtbow.frames.film import FILM_SUFFIXES
    from rtbow.frames.image import FRAME_SUFFIXES

    if str(value).lower().endswith(FRAME_SUFFIXES + FILM_SUFFIXES):
        context = click.get_current_context(silent=True)
        writes = context is not None and any("-o" in param.opts for param in context.command.params)
        remedy = (
            f"did you mean -o {value}?"
            if writes
            else "name a .toml file or a built-in scene (rtbow scenes lists them)"
        )
        raise click.BadParameter(f"{value!r} is a picture's name, not a scene's; {remedy}")
    return str(value)


def scene_completions(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a scene on the shell's Tab: built-in scenes, .toml files, folders on the way."""
    return _completions(incomplete, (".toml",))


def _completions(incomplete: str, suffixes: tuple[str, ...]) -> list[CompletionItem]:
    from rtbow.scene.text.file import builtin_scenes, scene_title

    items = [
        CompletionItem(name, help=scene_title(path))
        for name, path in builtin_scenes().items()
        if name.startswith(incomplete)
    ]
    folder, begun = os.path.split(incomplete)
    try:
        entries = sorted(os.scandir(folder or "."), key=lambda entry: entry.name)
    except OSError:
        return items
    for entry in entries:
        hidden = entry.name.startswith(".") and not begun.startswith(".")
        if entry.name.startswith(begun) and not hidden:
            place = os.path.join(folder, entry.name)
            if entry.is_dir():
                items.append(CompletionItem(f"{place}{os.sep}"))
            elif entry.name.lower().endswith(suffixes):
                items.append(CompletionItem(place))
    return items


def frame_or_scene_completions(
    context: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a frame or a scene on the shell's Tab."""
    return _completions(incomplete, (".toml", ".exr"))


def number(value: Any) -> float:
    """Read a number, such as ``2.5``."""
    try:
        return float(value)
    except ValueError:
        from rtbow.scene.text.numbers import remedy

        what = remedy(str(value)) or "write one such as 2.5"
        raise click.BadParameter(f"{cut(repr(value))} is not a number; {what}") from None


def number_list(value: Any) -> tuple[float, ...]:
    """Read numbers with commas between them, such as ``100,500``."""
    if isinstance(value, tuple):
        return value
    try:
        return tuple(float(part) for part in str(value).split(","))
    except ValueError:
        raise click.BadParameter(
            f"{value!r} is not a list of numbers such as 100,500,1000"
        ) from None


class WholeNumber(click.IntRange):
    """A whole number within a range."""

    name = "whole number"


# --- Options -----------------------------------------------------------------------------------


def grouped(*options: Option) -> Option:
    """Join options into one; help shows them in this order."""

    def add(verb: Verb) -> Verb:
        for option in reversed(options):
            verb = option(verb)
        return verb

    return add


def number_option(name: str, default: float | None, metavar: str, text: str) -> Option:
    """Add an option that takes a number; without a default, the help says what is taken."""
    return click.option(
        name,
        type=number,
        default=default,
        show_default=default is not None,
        metavar=metavar,
        help=text,
    )


def numbers_option(name: str, default: tuple[float, ...] | None, text: str) -> Option:
    """Add an option that takes numbers with commas between them; the help names the default."""
    return click.option(name, type=number_list, default=default, metavar="A,B,...", help=text)


def choice_option(name: str, choices: Sequence[str], text: str, default: str = "") -> Option:
    """Add an option that takes one of several words, by default the first."""
    return click.option(
        name,
        type=click.Choice(choices),
        default=default or choices[0],
        show_default=True,
        help=text,
    )


scene_argument: Option = click.argument(
    "scene", required=False, type=scene_name, shell_complete=scene_completions
)
backend_option = choice_option(
    "--backend", ("auto", "egl", "osmesa", "window"), "How to get a GL context."
)
quiet_option: Option = click.option(
    "-q", "--quiet", is_flag=True, help="Show no progress and print nothing."
)

sun_option: Option = click.option(
    "--sun",
    type=sun_at,
    metavar="LAT,LON,TIME",
    help="Put the first sun where it is seen from a place at a time (degrees, north and east"
    " positive), such as 59.9,10.7,2026-07-01T19:30+02:00; without +02:00 the time is UTC.",
)
method_option = choice_option(
    "--method",
    ("auto", "fast", "spectral", "reference"),
    "fast: colours integrated ahead; spectral: wavelength loop in the shader; reference:"
    " float64 on the CPU; auto: fast where it keeps its error, else spectral, or reference"
    " for what no shader draws.",
)
json_option: Option = click.option(
    "--json",
    "json_file",
    metavar="FILE",
    help="Write all numbers: .json, - standard output.",
)

SPREAD_PERCENT = 2.0
spread_option = number_option(
    "--spread",
    SPREAD_PERCENT,
    "PERCENT",
    "Spread of sizes about each radius, 1..20: standard deviation of ln(radius) (mie).",
)
disc_option = number_option(
    "--disc",
    SUN_DIAMETER_DEG,
    "DEG",
    f"Angular diameter of the light's disc, 0..{MAX_DISC_DEG:g}; 0 for a point.",
)


def size_option(text: str) -> Option:
    """Add ``--size`` with its help."""
    return click.option("--size", type=picture_size, metavar="WxH", help=text)


def max_delta_e_option(text: str, *, multiple: bool = False) -> Option:
    """Add ``--max-delta-e`` with its help."""
    return click.option(
        "--max-delta-e", type=tolerable_error, multiple=multiple, metavar="DE", help=text
    )


def set_option(example: str) -> Option:
    """Add ``--set``, which the verb takes as ``settings``, with an example in its help."""
    return click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="KEY.PATH=VALUE",
        help=f"Replace any scene key, such as {example}. May be repeated.",
    )


# --- Drawing -----------------------------------------------------------------------------------


class Drawing(NamedTuple):
    """What was typed in the options of :func:`drawing_options`."""

    size: tuple[int, int] | None
    backend: Backend
    method: MethodName
    max_delta_e: float | None
    settings: tuple[str, ...]
    sun: SunAt | None
    exposure: float | None

    def placed(self, scene: str | None) -> dict[str, object]:
        """Return the overrides of a scene by name, with what places its sun by ``--sun``.

        Raises:
            InputError: as :meth:`overrides`, or ``--sun`` does not go with the scene.
        """
        overrides = self.overrides()
        if self.sun is None:
            return overrides
        from rtbow.scene.text.file import sun_overrides

        return overrides | sun_overrides(scene, overrides, self.sun)

    def notes(self, scene: Scene) -> tuple[str, ...]:
        """Say where ``--sun`` has put the sun, and whether its bow is in the picture."""
        if self.sun is None:
            return ()
        from rtbow.world.visibility import sun_notes

        return sun_notes(scene)

    def overrides(self) -> dict[str, object]:
        """Return the overrides of the scene that ``--set``, ``--size`` and ``--max-delta-e`` give.

        Raises:
            InputError: no such ``--set``, or a method that does not take ``--max-delta-e``.
        """
        if self.max_delta_e is not None and self.method not in ("auto", "fast"):
            raise InputError(
                f"--max-delta-e {self.max_delta_e:g}: methods auto and fast alone take it, not"
                f" --method {self.method}; leave one of the two out"
            )
        from rtbow.scene.text.file import parse_set

        overrides = dict(parse_set(text) for text in self.settings)
        if self.size is not None:
            overrides["camera.size_px"] = list(self.size)
        if self.max_delta_e is not None:
            overrides["render.max_delta_e"] = self.max_delta_e
        return overrides


def drawing_options(size: str, example: str, exposure: str) -> Option:
    """Add the options of a verb that draws one scene, which takes them as its ``drawing``.

    Args:
        size: help of ``--size``.
        example: of ``--set``.
        exposure: help of ``--exposure``.
    """
    options = grouped(
        size_option(size),
        backend_option,
        method_option,
        max_delta_e_option(
            "Error that method fast may make, CIEDE2000 at the 99th percentile of pixels:"
            f" {LEAST_DELTA_E:g} to {MOST_DELTA_E:g}; left out: the scene's,"
            f" {DEFAULT_DELTA_E:g} by default."
        ),
        set_option(example),
        sun_option,
        click.option(
            "--exposure",
            type=exposure_value,
            default="auto",
            show_default=True,
            metavar="auto|EV",
            help=exposure,
        ),
    )

    def add(verb: Verb) -> Verb:
        @wraps(verb)
        def run(**values: Any) -> Any:
            shared = {name: values.pop(name) for name in Drawing._fields}
            return verb(drawing=Drawing(**shared), **values)

        return options(run)  # type: ignore[return-value]  # the same verb, its options gathered

    return add


# --- Progress ----------------------------------------------------------------------------------


_SLOW_S = 2.0
"""Seconds after which a pipe, too, is told what is being built."""


def progress_bar(label: str, quiet: bool, unit: str = "row") -> Progress:
    """Give a wrapper that shows a bar on a terminal.

    A pipe sees one line where something is built (:class:`rtbow.base.arrays.Steps`) and that takes
    longer than two seconds, and nothing else.
    """

    def wrap(items: Iterable[int]) -> Iterable[int]:
        from tqdm import tqdm

        from rtbow.base.arrays import Steps, labelled

        text = labelled(label, items)
        if isinstance(items, Steps) and not quiet and not _on_terminal():
            return _told_when_slow(text, items)
        # disable=None: only where stderr is a terminal.
        hidden = True if quiet else None
        bar: Iterable[int] = tqdm(items, desc=text, unit=unit, leave=False, disable=hidden)
        return bar

    return wrap


def _on_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _told_when_slow(text: str, items: Iterable[int]) -> Iterator[int]:
    """Go through a loop, and write a line on stderr if it is not done after a while."""
    timer = threading.Timer(_SLOW_S, click.echo, (text,), {"err": True})
    timer.daemon = True
    timer.start()
    try:
        yield from items
    finally:
        timer.cancel()
