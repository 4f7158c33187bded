"""Options, their types and the progress bar that verbs of the command line share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import click

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.limits import DEFAULT_DELTA_E, LEAST_DELTA_E, MOST_DELTA_E

if TYPE_CHECKING:
    from rtbow.base.arrays import Progress

    _SizeType = click.ParamType[tuple[int, int]]
    _ExposureType = click.ParamType[float | None]
    _NumberType = click.ParamType[float]
    _NumbersType = click.ParamType[tuple[float, ...]]
    _SceneType = click.ParamType[str]
else:  # generic since click 8.4 alone
    _SizeType = _ExposureType = _NumberType = _NumbersType = _SceneType = click.ParamType

Verb = TypeVar("Verb", bound=Callable[..., Any])


class Option(Protocol):
    """Adds an option to a verb."""

    def __call__(self, verb: Verb, /) -> Verb:
        """Give the verb with the option."""
        ...


# --- Types -------------------------------------------------------------------------------------


def two_sides(value: Any) -> tuple[int, int] | None:
    """Read two whole numbers with an x between them, such as ``640x360``; None if it is not.

    A pair of numbers, such as a default, stays as it is.
    """
    if isinstance(value, tuple):
        return int(value[0]), int(value[1])
    sides = str(value).lower().split("x")
    if len(sides) != 2 or not all(side.isascii() and side.isdigit() for side in sides):
        return None
    # Twenty digits tell enough; Python refuses to read thousands.
    return int(sides[0][:20]), int(sides[1][:20])


class Size(_SizeType):
    """WIDTHxHEIGHT in pixels."""

    name = "WxH"

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[int, int]:
        """Parse ``640x360``."""
        sides = two_sides(value)
        if sides is None:
            self.fail(f"{value!r} is not a size; write width and height such as 640x360", param)
        from pydantic import ValidationError

        from rtbow.scene.model import Camera, Pixels
        from rtbow.scene.text.schema import Node

        try:
            return Camera(size_px=sides).size_px
        except ValidationError:
            allowed = Node.of(Pixels).range
            self.fail(f"{value!r} is not a size; each side must be {allowed} pixels", param)


class Exposure(_ExposureType):
    """``auto`` or an exposure value."""

    name = "auto|EV"

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> float | None:
        """Parse ``auto`` (None) or a number."""
        if value is None or str(value).lower() == "auto":
            return None
        from rtbow.frames.display import EV_LIMIT, max_luminance

        try:
            exposure = float(value)
            max_luminance(exposure)
        except (ValueError, RtbowError):
            self.fail(
                f"{value!r} is not an exposure; write auto, or an EV at ISO 100,"
                f" {-EV_LIMIT:g}..{EV_LIMIT:g}, such as 13",
                param,
            )
        return exposure


class MaxDeltaE(_NumberType):
    """An error that method ``fast`` can keep."""

    name = "DE"

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> float:
        """Parse ``0.5``."""
        try:
            error = float(value)
        except ValueError:
            error = 0.0
        if not LEAST_DELTA_E <= error <= MOST_DELTA_E:  # NaN too
            self.fail(
                f"{value!r} is no error that method fast can keep; write a number,"
                f" {LEAST_DELTA_E:g}..{MOST_DELTA_E:g}, such as {DEFAULT_DELTA_E:g}, or leave it"
                " out for the scene's render.max_delta_e",
                param,
            )
        return error


class SceneName(_SceneType):
    """A scene's file or name; what reads like an output is told from one."""

    name = "scene"

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> str:
        """Take the name as it is, but for that of a picture."""
        from rtbow.frames.film import FILM_SUFFIXES
        from rtbow.frames.image import FRAME_SUFFIXES

        if str(value).lower().endswith(FRAME_SUFFIXES + FILM_SUFFIXES):
            writes = ctx is not None and any("-o" in one.opts for one in ctx.command.params)
            remedy = (
                f"did you mean -o {value}?"
                if writes
                else "name a .toml file or a built-in scene (rtbow scenes lists them)"
            )
            self.fail(f"{value!r} is a picture's name, not a scene's; {remedy}", param)
        return str(value)


class WholeNumber(click.IntRange):
    """A whole number within a range."""

    name = "whole number"


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


# --- Options -----------------------------------------------------------------------------------

scene_argument: Option = click.argument("scene", required=False, type=SceneName())
backend_option: Option = click.option(
    "--backend",
    type=click.Choice(["auto", "egl", "osmesa", "window"]),
    default="auto",
    show_default=True,
    help="How to get a GL context.",
)
quiet_option: Option = click.option(
    "-q", "--quiet", is_flag=True, help="Show no progress and print nothing."
)


def size_option(text: str) -> Option:
    """Give ``--size`` with its help."""
    return click.option("--size", type=Size(), metavar="WxH", help=text)


def max_delta_e_option(
    text: str = "Error that method fast may make, CIEDE2000 at the 99th percentile of pixels:"
    f" {LEAST_DELTA_E:g} to {MOST_DELTA_E:g}; left out: the scene's, {DEFAULT_DELTA_E:g} by"
    " default.",
    *,
    multiple: bool = False,
) -> Option:
    """Give ``--max-delta-e`` with its help."""
    return click.option(
        "--max-delta-e", type=MaxDeltaE(), multiple=multiple, metavar="DE", help=text
    )


method_option: Option = click.option(
    "--method",
    type=click.Choice(["auto", "fast", "spectral", "reference"]),
    default="auto",
    show_default=True,
    help="fast: colours integrated ahead; spectral: wavelength loop in the shader; reference:"
    " float64 on the CPU; auto: fast where it keeps its error, else spectral.",
)


def exposure_option(text: str) -> Option:
    """Give ``--exposure`` with its help."""
    return click.option(
        "--exposure",
        type=Exposure(),
        default="auto",
        show_default=True,
        metavar="auto|EV",
        help=text,
    )


def set_option(example: str) -> Option:
    """Give ``--set``, which the verb takes as ``settings``, with an example in its help."""
    return click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="KEY.PATH=VALUE",
        help=f"Replace any scene key, such as {example}. May be repeated.",
    )


def typed_overrides(
    settings: tuple[str, ...],
    size: tuple[int, int] | None,
    max_delta_e: float | None,
    method: str,
) -> dict[str, object]:
    """Give the overrides of a scene that ``--set``, ``--size`` and ``--max-delta-e`` ask for.

    Raises:
        InputError: no such ``--set``, or a method that does not take ``--max-delta-e``.
    """
    if max_delta_e is not None and method not in ("auto", "fast"):
        raise InputError(
            f"--max-delta-e {max_delta_e:g}: methods auto and fast alone take it, not --method"
            f" {method}; leave one of the two out"
        )
    from rtbow.scene.text.file import parse_set

    overrides = dict(parse_set(text) for text in settings)
    if size is not None:
        overrides["camera.size_px"] = list(size)
    if max_delta_e is not None:
        overrides["render.max_delta_e"] = max_delta_e
    return overrides


# --- Progress ----------------------------------------------------------------------------------


def progress_bar(label: str, quiet: bool, unit: str = "row") -> Progress:
    """Give a wrapper that shows a bar on a terminal and nothing in a pipe."""

    def wrap(items: Iterable[int]) -> Iterable[int]:
        from tqdm import tqdm

        # disable=None: only where stderr is a terminal.
        hidden = True if quiet else None
        bar: Iterable[int] = tqdm(items, desc=label, unit=unit, leave=False, disable=hidden)
        return bar

    return wrap
