"""How frame time and memory grow with pixels, steps, grid points and lights."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.bench.memory import free_mib
from rtbow.bench.row import BenchRow, ScalingPoint, Times, with_device
from rtbow.bench.run import LEAST_SLOW_FRAMES, Plan, Show, TooSlowError, measure, no_show
from rtbow.scene.lights import PointLight
from rtbow.scene.model import Scene
from rtbow.world.rain.volume import scene_volume

DEFAULT_SCENE = "shower"
DEFAULT_LIMIT_S = 60.0

AXES: dict[str, tuple[int, ...]] = {
    "pixels": tuple(side * side for side in (64, 128, 256, 512, 1024, 2048, 4096)),
    "steps": (8, 16, 32, 64, 128, 256, 512),
    "grid": (16, 32, 64, 128, 256, 512),
    "lights": (1, 2, 4, 8, 16),
}
"""Values along each axis: pixels of a square frame, ``render.steps``, grid points along a side of a
cube, lights."""

_LIGHTS_APART_DEG = 3.0
_LAMPS_APART_M = 0.5
_BYTES_PER_POINT = 60.0
"""Memory that a grid point takes at most while a scene is set up; spectral takes 35 at 256³."""


def run_scaling(
    name: str | None,
    plan: Plan,
    limit_s: float = DEFAULT_LIMIT_S,
    show: Show = no_show,
    axes: dict[str, tuple[int, ...]] | None = None,
) -> list[BenchRow]:
    """Measure one scene along each axis, by each method and setting.

    A point that would take longer than ``limit_s``, judged by the point before it, is not measured;
    its row says so.

    Args:
        name: a built-in name or a path; None is ``DEFAULT_SCENE``.
        plan: what is measured, and how; its size is that of all axes but ``pixels``.
        limit_s: time that a point may take.
        show: shows progress.
        axes: values along each axis, increasing; left out: ``AXES``.

    Raises:
        InputError, UnavailableError: the scene is not usable, or no method draws it.
    """
    name = DEFAULT_SCENE if name is None else name
    base = plan.scene(name, {})
    rows: list[BenchRow] = []
    refusals: list[RtbowError] = []
    for axis, values in (AXES if axes is None else axes).items():
        for method, setting in plan.variants():
            done: dict[int, Times] = {}
            beyond = ""  # why all further values take too long
            for value in values:
                row = plan.row(base, method, setting, ScalingPoint(axis, value))
                expected = _expected_s(done, axis, value)
                if expected > limit_s or beyond:
                    seconds = beyond or f"about {expected:.0f} s by the point before"
                    rows.append(replace(row, skipped=f"{seconds}; may take {limit_s:g} s"))
                    continue
                try:
                    with _scene_at(plan, name, base, setting, axis, value) as scene:
                        row = measure(scene, row, plan, None, show, limit_s).row
                    assert row.times is not None
                    done[value] = row.times
                    rows.append(row)
                except TooSlowError as error:
                    rows.append(replace(row, skipped=f"{error}; a point may take {limit_s:g} s"))
                    beyond = "more than the point before"
                except (InputError, UnavailableError) as error:
                    refusals.append(error)
                    rows.append(replace(row, skipped=str(error)))
    if len(refusals) == len(rows):
        raise refusals[0]
    return with_device(rows)


def _expected_s(done: Mapping[int, Times], axis: str, value: int) -> float:
    """Estimate the seconds that a point takes, by those before it; 0 without any."""
    if not done:
        return 0.0
    last, times = list(done.items())[-1]
    growth = value / last
    least, set_up = min(map(_set_up_ms, done.values())), _set_up_ms(times)
    # A grid is set up point by point, beside what any scene needs; a ray crosses a row of them.
    grows = (set_up - least) * growth**3 if axis == "grid" else set_up - least
    # The first frame and another that is not timed go before.
    frames_ms = times.frame.median_ms * growth * (LEAST_SLOW_FRAMES + 2)
    return 1e-3 * (least + grows + frames_ms)


def _set_up_ms(times: Times) -> float:
    return max(times.first_frame_ms - times.frame.median_ms, 0.0)


@contextmanager
def _scene_at(
    plan: Plan, name: str, base: Scene, setting: dict[str, object], axis: str, value: int
) -> Iterator[Scene]:
    """Give the scene at a point of an axis."""
    if axis == "grid":
        _check_memory(value)
        with tempfile.TemporaryDirectory(prefix="rtbow-bench-") as folder:
            path = Path(folder) / "smooth.npz"
            write_smooth_volume(path, value, scene_volume(base).box_m)
            yield plan.scene(name, {**setting, "droplets.file": str(path)})
        return
    changes: dict[str, Callable[[], dict[str, object]]] = {
        "pixels": lambda: {"camera.size_px": [round(value**0.5)] * 2},
        "steps": lambda: {"render.steps": value},
        "lights": lambda: {"light": lights_like(base, value)},
    }
    yield plan.scene(name, {**setting, **changes[axis]()})


def _check_memory(side: int) -> None:
    free, needed = free_mib(), side**3 * _BYTES_PER_POINT / 2**20
    if free is not None and needed > free:
        raise UnavailableError(
            f"a grid of {side}³ points takes about {needed:.0f} MiB, {free:.0f} are free"
        )


def write_smooth_volume(path: Path, side: int, box_m: Array) -> None:
    """Write a volume of smooth waves of drops, 300 to 700 µm, of use for measuring alone.

    Args:
        path: where to.
        side: grid points along each axis.
        box_m: lower and upper corner (2, 3).
    """
    place = np.linspace(0.0, 2.0 * np.pi, side, dtype=np.float32)
    wave = np.sin(place)[:, None, None] * np.cos(place)[:, None] * np.sin(place + 1.0)
    # Uncompressed, as compression would take longer than everything else.
    np.savez(path, radius_um=500.0 + 200.0 * wave, number_per_m3=100.0 + 50.0 * wave, box_m=box_m)


def lights_like(scene: Scene, count: int) -> list[dict[str, Any]]:
    """Give copies of the scene's first light, side by side around it."""
    first = scene.light[0]
    lights = []
    for number in range(count):
        light = first.model_dump(exclude_none=True)
        # 0, 1, -1, 2, -2, …
        aside = (number + 1) // 2 * (1 if number % 2 else -1)
        if isinstance(first, PointLight):
            east, north, up = first.position_m
            light["position_m"] = [east + aside * _LAMPS_APART_M, north, up]
        else:
            light["azimuth_deg"] = first.azimuth_deg + aside * _LIGHTS_APART_DEG
        lights.append(light)
    return lights
