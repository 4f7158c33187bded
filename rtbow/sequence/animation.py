"""What an animation is: one scene, and some of its keys on their way through a number of frames."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.errors import InputError
from rtbow.scene.lights import SunLight
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene, typed_override, with_overrides_noted
from rtbow.scene.text.numbers import remedy
from rtbow.scene.text.schema import node_at
from rtbow.scene.text.values import changed_scene
from rtbow.world.camera.resolve import view_of
from rtbow.world.sky import dimming_air
from rtbow.world.visibility import Hidden, hidden

if TYPE_CHECKING:
    from rtbow.physics.light.sun_position import SunPosition

SUN_KEYS = ("light.0.altitude_deg", "light.0.azimuth_deg")
"""A path of the sun moves these keys."""
_PLACES = re.compile(
    r"(camera|light\.[0-9]+)\.(position_m(\.[0-2])?|azimuth_deg|altitude_deg)|camera\.(fov_deg|focal_length_mm|roll_deg|lens_shift(\.[01])?)"
)
"""These keys say where camera and lights are: method ``fast`` keeps its tables as they change."""


@dataclass(frozen=True)
class Move:
    """A numeric key of the scene on its way from one value to another, in even steps.

    Attributes:
        key: the key, as typed after ``--set``.
        start: its value in the first frame.
        end: its value in the last frame. Between whole numbers all values are whole.
    """

    key: str
    start: float | int
    end: float | int

    def at(self, number: int, count: int) -> float | int:
        """Give the value in a frame, counted from 0."""
        if number == 0:  # the last, too, if there is one frame
            return self.start
        if number == count - 1:  # exactly, where the sum below is rounded
            return self.end
        if isinstance(self.start, int) and isinstance(self.end, int):
            # To the nearest one, in integers alone: a seed may have more digits than a float holds.
            steps = count - 1
            return self.start + (2 * (self.end - self.start) * number + steps) // (2 * steps)
        return self.start + (self.end - self.start) * number / (count - 1)


def parse_move(text: str) -> Move:
    """Read ``key.path=from:to``.

    Raises:
        InputError: the text is not of this form, the key is not a number's, or an end is none.
    """
    key, _, ends = (part.strip() for part in text.partition("="))
    start, _, end = (part.strip() for part in ends.partition(":"))
    if not (key and start and end):
        raise InputError(f"--key {text}: write key.path=from:to, such as light.0.altitude_deg=2:40")
    node = node_at(key)
    if f"{key}.".startswith("camera.size_px."):
        raise InputError(f"--key {key}: all frames have one size; give it with --size")
    if node is not None and node.items:
        raise InputError(
            f"--key {key}: only numbers move; name an item of this list, such as {key}.0=0:10"
        )
    if node is not None and node.annotation not in (float, int):
        raise InputError(
            f"--key {key}: only numbers move, and this must be {node.expects()}; use --set"
        )
    # An unknown key is left to the scene, whose message proposes the nearest one.
    whole = node is not None and node.annotation is int
    return Move(key, _end(key, start, whole), _end(key, end, whole))


def _end(key: str, text: str, whole: bool) -> float | int:
    try:
        value = int(text) if whole else float(text)
    except ValueError:
        kind = "a whole number" if whole else "a number"
        what = remedy(text) or "write from:to, such as 2:40"
        raise InputError(f"--key {key}: {text} is not {kind}; {what}") from None
    if not math.isfinite(value):
        raise InputError(f"--key {key}: {text}; both ends must be finite numbers")
    return value


@dataclass(frozen=True)
class Animation:
    """A scene, and how its keys move over a number of frames; made by :func:`plan_animation`.

    Attributes:
        name: the scene's name as it was typed; None is the default scene.
        overrides: values that replaced the scene's own when it was loaded, by dotted key.
        scene: the scene with these values.
        count: number of frames.
        moves: the keys that move, each once.
        sun: where light 0 stands in each frame; empty if it follows no path of the sun.
    """

    name: str | None
    overrides: Mapping[str, object]
    scene: Scene
    count: int
    moves: tuple[Move, ...] = ()
    sun: tuple[SunPosition, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """All keys that move."""
        return tuple(move.key for move in self.moves) + (SUN_KEYS if self.sun else ())

    @property
    def only_places(self) -> bool:
        """Whether nothing moves but camera and lights: no rain around the camera either."""
        around = self.scene.droplets.around_m is not None
        if around and any(key.startswith("camera.position_m") for key in self.keys):
            return False
        return all(_PLACES.fullmatch(key) for key in self.keys)

    @property
    def keeps_tables(self) -> bool:
        """Whether frames are drawn by tables for all places: those of ozone and aerosol are of one
        place of the sun and the eye."""
        elsewhere = any(key.startswith(("light.", "camera.position_m")) for key in self.keys)
        return self.only_places and not (elsewhere and dimming_air(self.scene) is not None)

    @property
    def widest(self) -> int | None:
        """The frame of the widest pixels, where they change; one of both ends, as all moves are
        even."""
        ends = 0, self.count - 1
        wide = [view_of(self.at(number).camera).pixel_rad for number in ends]
        return None if wide[0] == wide[1] else ends[int(np.argmax(wide))]

    def changes(self, number: int) -> dict[str, float | int]:
        """Give the values of the moving keys in a frame, counted from 0."""
        values: dict[str, float | int] = {
            move.key: move.at(number, self.count) for move in self.moves
        }
        if self.sun:
            sun = self.sun[number]
            # To a millionth of a degree: it is not known better, and reads better.
            angles = (round(sun.altitude_deg, 6), round(sun.azimuth_deg, 6))
            values |= dict(zip(SUN_KEYS, angles, strict=True))
        return values

    def at(self, number: int) -> Scene:
        """Give the scene of a frame, counted from 0, with the source text that ``render`` stores.

        Raises:
            InputError: a value that is not allowed.
        """
        return self.changed(self.changes(number))

    def changed(self, values: Mapping[str, float | int]) -> Scene:
        """Give the scene with some values of moving keys.

        Raises:
            InputError: keys or values that are not allowed.
        """
        try:
            made = changed_scene(self.scene, values)
        except InputError as error:
            # The scene itself was loaded without an error: this one is of a moving key.
            raise InputError(re.sub(r"(?m)^--set\b", "--key", str(error))) from None
        text = with_overrides_noted(self.scene.source_text, values)
        return made.with_source(text, self.scene.source_name)

    def notes(self) -> tuple[str, ...]:
        """Say in which frames a sun, or a bow, is wholly below the horizon."""
        frames: dict[tuple[int, int], list[int]] = {}
        worst: dict[tuple[int, int], Hidden] = {}
        for number in range(self.count):
            for part, _ in self.at(number).parts():
                for found in hidden(part):
                    what = found.light, found.bow
                    if number not in frames.setdefault(what, []):
                        frames[what].append(number)
                    most = worst.setdefault(what, found)
                    if found.below_deg > most.below_deg:
                        worst[what] = found
        return tuple(
            f"{_frames_text(numbers)}: {'' if len(numbers) == 1 else 'at most, '}{worst[what]}"
            for what, numbers in frames.items()
        )

    def render_command(self, number: int, method: str, output: str, ev: float | None) -> str:
        """Give the command that renders a frame again."""
        words = ["rtbow", "render", *([] if self.name is None else [self.name])]
        words += ["--method", method]
        for key, value in {**self.overrides, **self.changes(number)}.items():
            words += ["--set", typed_override(key, value)]
        if ev is not None:
            words.append(f"--exposure={ev!r}")
        return shlex.join([*words, "-o", output])


def _frames_text(numbers: Sequence[int]) -> str:
    """Name frames by their numbers, ascending, those that follow each other by the ends."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1][1:] = [number]
        else:
            runs.append([number])
    said = ", ".join(" to ".join(map(str, run)) for run in runs)
    return f"frame{'' if len(numbers) == 1 else 's'} {said}"


def plan_animation(
    name: str | None,
    overrides: Mapping[str, object],
    count: int,
    moves: Sequence[Move] = (),
    sun: Sequence[SunPosition] = (),
) -> Animation:
    """Load a scene and check all frames of its animation.

    Args:
        name: as for :func:`rtbow.load_scene`.
        overrides: as for :func:`rtbow.load_scene`.
        count: number of frames, 1 or more.
        moves: the keys that move.
        sun: where light 0, a sun, stands in each frame; if empty, it stays where the scene has it.

    Raises:
        InputError: keys or values that are not allowed, in any frame.
    """
    planned = Animation(
        name, overrides, load_scene(name, overrides), count, tuple(moves), tuple(sun)
    )
    _check_keys(planned)
    for end in ("start", "end"):  # first, since these were typed
        planned.changed({move.key: getattr(move, end) for move in moves})
    for number in range(count):
        try:
            planned.at(number)
        except InputError as error:
            raise InputError(f"frame {number}: {error}") from None
    return planned


def _check_keys(planned: Animation) -> None:
    keys = [move.key for move in planned.moves]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--key {key}: is given twice; give it once")
        if key in planned.overrides:
            raise InputError(f"--key {key}: has one value by --set, too; give one of the two")
    if not planned.sun:
        return
    for key in SUN_KEYS:
        if key in keys or key in planned.overrides:
            raise InputError(f"--sun-path moves {key}, which is given, too; leave one of them out")
    if not isinstance(planned.scene.light[0], SunLight):
        raise InputError(
            f"--sun-path moves light 0, which is a lamp in {planned.scene.source_name}; choose a"
            " scene whose first light is a sun, or add --set light.0.type=sun"
        )
