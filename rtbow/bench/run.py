"""Measures how quick the shader's methods are and how far their frames are from the reference.

All times are measured before any error, so that no row's memory includes what the reference takes.
A method's frames and those of the floor (:mod:`rtbow.bench.floor`) take turns, so that whatever
else the machine does slows both alike.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rtbow.base.arrays import Array, Progress, no_progress
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.bench.error import PixelSample, reference_xyz, sample_difference, sample_pixels
from rtbow.bench.floor import FloorPass
from rtbow.bench.memory import PeakMemory
from rtbow.bench.random_scenes import random_scene, random_seed
from rtbow.bench.row import (
    BenchRow,
    Machine,
    Memory,
    ScalingPoint,
    Times,
    Timing,
    with_device,
    with_speed_up,
)
from rtbow.gl.context import Backend, open_context
from rtbow.render.renderer import METHODS, MethodName, Renderer
from rtbow.scene.model import Scene
from rtbow.scene.text.file import is_scene_name, load_scene
from rtbow.scene.text.sun import SunAt

DEFAULT_SIZE = (640, 360)
DEFAULT_ERROR_PIXELS = 400
SPECTRAL_STEP_NM = 5.0
"""Wavelength step of method ``spectral`` unless it is set, in nm: 81 wavelengths, also where a
scene's own file has fewer."""
STEP_KEY = "render.wavelength_step_nm"
TOLERANCE_KEY = "render.max_delta_e"

LEAST_FRAMES = 9
MOST_FRAMES = 99
LEAST_SLOW_FRAMES = 3
SLOW_S = 5.0
"""Time of a frame above which ``LEAST_SLOW_FRAMES`` are enough."""
_TIMED_S = 1.0
"""Time for which quick frames are repeated, up to ``MOST_FRAMES``."""
_QUICK_S = 0.25
"""Time of a frame above which it does not matter what the last one left in the CPU's caches."""
_WARM_UP_S = 0.3
"""Time for which quick frames are drawn before any is timed."""

Show = Callable[[str, str], Progress]
"""Gives a progress bar, as the wrapper of a loop, for a label and a unit."""


def no_show(label: str, unit: str) -> Progress:
    """Show nothing."""
    return no_progress


def shader_methods() -> tuple[MethodName, ...]:
    """Give the methods that draw on the GL device; ``auto`` is one of them under another name."""
    return tuple(method for method in METHODS if method not in ("auto", "reference"))


@dataclass(frozen=True)
class Plan:
    """What is measured, and how.

    Attributes:
        size_px: width and height of the frames.
        methods: those to be timed.
        max_delta_e: tolerances of method ``fast``, a row each; empty for the scene's own.
        settings: overrides of every scene, by dotted key.
        backend: how to get a GL context.
        frames: timed frames of a row; None: as many as suit the time that one takes.
        error_pixels: how many pixels are compared with the reference; None is all, 0 none.
        command: what the user typed, which each row records.
        sun: a place and a time that put the first sun of every scene.
    """

    size_px: tuple[int, int] = DEFAULT_SIZE
    methods: tuple[MethodName, ...] = field(default_factory=shader_methods)
    max_delta_e: tuple[float, ...] = ()
    settings: Mapping[str, object] = field(default_factory=dict)
    backend: Backend = "auto"
    frames: int | None = None
    error_pixels: int | None = DEFAULT_ERROR_PIXELS
    command: str = ""
    sun: SunAt | None = None

    def __post_init__(self) -> None:
        known = shader_methods()
        for method in self.methods:
            if method not in known:
                raise InputError(
                    f"--method {method}: cannot be timed; must be {' or '.join(known)}"
                )
        if self.max_delta_e and "fast" not in self.methods:
            raise InputError("--max-delta-e goes with method fast; add --method fast")
        if self.max_delta_e and TOLERANCE_KEY in self.settings:
            raise InputError(f"--max-delta-e and --set {TOLERANCE_KEY}: give one of the two")

    def variants(self) -> list[tuple[MethodName, dict[str, object]]]:
        """List the methods with the overrides that they take beside ``settings``."""
        variants: list[tuple[MethodName, dict[str, object]]] = []
        for method in self.methods:
            if method == "spectral" and STEP_KEY not in self.settings:
                variants.append((method, {STEP_KEY: SPECTRAL_STEP_NM}))
            elif method == "fast" and self.max_delta_e:
                variants += [(method, {TOLERANCE_KEY: delta_e}) for delta_e in self.max_delta_e]
            else:
                variants.append((method, {}))
        return variants

    def row(
        self, scene: Scene, method: MethodName, setting: dict[str, object],
        scaling: ScalingPoint | None = None,
    ) -> BenchRow:  # fmt: skip
        """Give the row of a method in a scene, with nothing measured yet."""
        return BenchRow(
            scene.source_name, method, setting, dict(self.settings), scene.camera.size_px,
            Machine(), self.command, scaling=scaling,
        )  # fmt: skip

    def scene(self, name: str | None, changes: Mapping[str, object]) -> Scene:
        """Load a scene with the overrides of this plan, and more; ``random-N`` is drawn.

        Raises:
            InputError: see :func:`rtbow.scene.text.file.load_scene`.
        """
        size = {"camera.size_px": list(self.size_px)}
        overrides = {**size, **self.settings, **changes}
        seed = random_seed(name)
        if seed is not None:
            return random_scene(seed, overrides, self.sun)
        try:
            return load_scene(name, overrides, self.sun)
        except InputError as error:
            if name is None or is_scene_name(name):
                raise
            end = "" if str(error).endswith("?") else "."
            raise InputError(
                f"{error}{end} random-1, random-2 and so on, to random-999999, are drawn at random"
            ) from None


class TooSlowError(RtbowError):
    """A measurement would take longer than it may."""


@dataclass(frozen=True)
class Measurement:
    """What timing one method gave.

    Attributes:
        row: the times, without errors.
        rgb: the chosen pixels of its frame, float64 (n, 3), or None.
    """

    row: BenchRow
    rgb: Array | None = None


def measure(
    scene: Scene,
    row: BenchRow,
    plan: Plan,
    sample: PixelSample | None = None,
    show: Show = no_show,
    limit_s: float | None = None,
) -> Measurement:
    """Time a method on a scene.

    Args:
        scene: the scene.
        row: what is measured; the row returned has its times and memory.
        plan: how it is measured.
        sample: pixels of the frame to keep.
        show: shows progress.
        limit_s: time that all of it may take.

    Raises:
        InputError, UnavailableError: the method does not take this scene, or the device does not.
        TooSlowError: fewer than ``LEAST_SLOW_FRAMES`` frames could be timed within ``limit_s``.
    """
    begun = time.perf_counter()
    method: Any = row.method
    label = f"{row.scene} {row.method}"
    with open_context(plan.backend) as gl:
        floor = FloorPass(gl, scene.camera.size_px)
        memory = PeakMemory()
        opened = time.perf_counter()
        with Renderer(scene, plan.backend) as renderer:
            rgb = None
            if sample is None:
                renderer.draw(method)
            else:
                frame = renderer.render(
                    method, show(f"{label}: first frame", "row"), show(f"{label}: table", "part")
                )
                rgb = sample.of(frame)
                del frame
            first_s = time.perf_counter() - opened
            clock = _Clock(begun, limit_s)
            times, floors = _time_frames(
                floor.draw, lambda: renderer.draw(method), first_s, plan.frames,
                show(label, "frame"), clock,
            )  # fmt: skip
            done = replace(
                row,
                size_px=scene.camera.size_px,
                wavelength_step_nm=scene.render.wavelength_step_nm,
                machine=replace(
                    row.machine, gl_renderer=renderer.gl_renderer, backend=renderer.backend
                ),
                times=Times(Timing.of(times), Timing.of(floors), 1e3 * first_s),
                memory=Memory(memory.mib(), memory.since, memory.start_mib, renderer.texture_bytes),
            )
    return Measurement(done, rgb)


def _timed_s(draw: Callable[[], None]) -> float:
    begun = time.perf_counter()
    draw()
    return time.perf_counter() - begun


@dataclass(frozen=True)
class _Clock:
    """When a measurement began, and how long it may take."""

    begun: float
    limit_s: float | None

    def allows(self, more_s: float) -> bool:
        spent = time.perf_counter() - self.begun
        return self.limit_s is None or spent + more_s <= self.limit_s


def _time_frames(
    draw_floor: Callable[[], None],
    draw: Callable[[], None],
    first_s: float,
    frames: int | None,
    progress: Progress,
    clock: _Clock,
) -> tuple[list[float], list[float]]:
    """Time frames, and the floor before each and after the last, in seconds."""
    last_s = first_s
    if clock.allows(0.0):
        draw_floor()
        last_s = _timed_s(draw)  # the first frame's own time held the set-up
    if last_s <= SLOW_S:
        begun = time.perf_counter()
        while time.perf_counter() - begun < _WARM_UP_S:
            last_s = _timed_s(draw)
    times: list[float] = []
    floors: list[float] = []
    for index in progress(range(frames or frames_for(last_s))):
        if not clock.allows(last_s):
            if index >= LEAST_SLOW_FRAMES:
                break
            raise TooSlowError(f"a frame takes {last_s:.3g} s")
        floors.append(_steady_s(draw_floor, True))
        last_s = _steady_s(draw, last_s <= _QUICK_S)
        times.append(last_s)
    floors.append(_steady_s(draw_floor, True))
    return times, floors


def _steady_s(draw: Callable[[], None], again: bool) -> float:
    """Time a frame that follows one of its own kind, as in a window, if ``again``."""
    if again:
        draw()  # fills the CPU's caches: without this the floor looks a third slower
    return _timed_s(draw)


def frames_for(frame_s: float) -> int:
    """Choose how many frames are timed where one takes ``frame_s`` seconds."""
    if frame_s > SLOW_S:
        return LEAST_SLOW_FRAMES
    return int(np.clip(_TIMED_S / max(frame_s, 1e-6), LEAST_FRAMES, MOST_FRAMES))


def run_bench(names: Sequence[str | None], plan: Plan, show: Show = no_show) -> list[BenchRow]:
    """Measure scenes by each method and setting.

    A method that does not take a scene gives a row that says why.

    Args:
        names: built-in names or paths; None is the default scene.
        plan: what is measured, and how.
        show: shows progress.

    Raises:
        InputError, UnavailableError: a scene is not usable, or no method draws any of them.
    """
    cases = []
    # All scenes are loaded before the first measurement, so that wrong input is reported at once.
    for name in dict.fromkeys(names):
        scene = plan.scene(name, {})
        size, count = scene.camera.size_px, plan.error_pixels
        sample = None if count == 0 else sample_pixels(size, count)
        variants = [(*variant, plan.scene(name, variant[1])) for variant in plan.variants()]
        cases.append((scene, sample, variants))
    refusals: list[RtbowError] = []
    measured: list[list[Measurement]] = []
    for _, sample, variants in cases:
        measured.append([])
        for method, setting, scene in variants:
            row = plan.row(scene, method, setting)
            try:
                measured[-1].append(measure(scene, row, plan, sample, show))
            except (InputError, UnavailableError) as error:
                refusals.append(error)
                measured[-1].append(Measurement(replace(row, skipped=str(error))))
    if len(refusals) == sum(map(len, measured)):
        raise refusals[0]
    rows: list[BenchRow] = []
    for (scene, sample, _), group in zip(cases, measured, strict=True):
        rows += with_speed_up(_with_errors(group, scene, sample, show))
    return with_device(rows)


def _with_errors(
    measured: Sequence[Measurement], scene: Scene, sample: PixelSample | None, show: Show
) -> list[BenchRow]:
    rows = [measurement.row for measurement in measured]
    if sample is None or all(measurement.rgb is None for measurement in measured):
        return rows
    truth = reference_xyz(scene, sample, show(f"{scene.source_name} reference", "group"))
    return [
        row
        if measurement.rgb is None
        else replace(row, error=sample_difference(measurement.rgb, truth, sample))
        for row, measurement in zip(rows, measured, strict=True)
    ]
