"""A row of figures: what one method takes and misses in one scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from rtbow.base.version import __version__
from rtbow.bench.memory import (
    cpu_count,
    cpu_name,
    load_average,
)
from rtbow.scene.model import Scene


@dataclass(frozen=True)
class Timing:
    """Median and quartiles of some times, ms."""

    median: float
    q25: float
    q75: float
    count: int

    @classmethod
    def of(cls, times_ms: Sequence[float]) -> Timing:
        """Give the median and the quartiles of times."""
        q25, median, q75 = np.percentile(times_ms, [25.0, 50.0, 75.0])
        return cls(float(median), float(q25), float(q75), len(times_ms))


@dataclass(frozen=True)
class BenchRow:
    """One measurement; the names are the keys of ``--json``. None is what was not measured.

    Attributes:
        scene: its name or path.
        method: of the shader's.
        setting: overrides of this row alone, by dotted key.
        common: overrides that all rows of the run share.
        size_px: width and height.
        frames: how many were timed.
        frame_ms: median time of a frame, from the call until the device is done.
        frame_ms_q25: first quartile.
        frame_ms_q75: third quartile.
        first_frame_ms: the first frame: context, textures, programs, drawing and reading.
        pixels_per_second: by the median.
        floor_ms: median time of the floor, one table look-up per pixel, between those frames.
        floor_ms_q25: first quartile.
        floor_ms_q75: third quartile.
        floor_frames: how many of the floor's frames were timed.
        floor_ratio: ``frame_ms`` over ``floor_ms``.
        wavelength_step_nm: of methods with a wavelength loop.
        spectral_ms: ``frame_ms`` of method ``spectral`` in the same run.
        spectral_step_nm: its wavelength step.
        speed_up: ``spectral_ms`` over ``frame_ms``.
        delta_e_p50: ΔE2000 against the reference, median over the compared pixels with light.
        delta_e_p99: its 99th percentile.
        delta_e_max: its greatest.
        relative_l2: root of the summed squares of the differences of X, Y, Z over that of the
            reference.
        error_pixels: how many pixels were compared.
        error_pixels_lit: how many of them have light in the reference.
        error_sample: where they are.
        reference_step_nm: the reference's wavelength step.
        peak_rss_mib: the most memory that the process held.
        peak_rss_since: ``"row"``, or ``"process"`` where the system keeps no later peak.
        start_rss_mib: what the process held before the row.
        texture_bytes: the method's textures on the device, tables and volume.
        gl_renderer: the GL device and driver.
        backend: how the context was made.
        cpu: the CPU's name.
        cpu_count: CPUs that the process may use.
        load_average: of the machine before the row, over a minute.
        rtbow_version: the version.
        command: what was typed.
        scaling: ``{"axis": name, "value": number}`` of a scaling run.
        skipped: why nothing was measured.
    """

    scene: str
    method: str
    setting: dict[str, object]
    common: dict[str, object]
    size_px: tuple[int, int]
    frames: int = 0
    frame_ms: float | None = None
    frame_ms_q25: float | None = None
    frame_ms_q75: float | None = None
    first_frame_ms: float | None = None
    pixels_per_second: float | None = None
    floor_ms: float | None = None
    floor_ms_q25: float | None = None
    floor_ms_q75: float | None = None
    floor_frames: int = 0
    floor_ratio: float | None = None
    wavelength_step_nm: float | None = None
    spectral_ms: float | None = None
    spectral_step_nm: float | None = None
    speed_up: float | None = None
    delta_e_p50: float | None = None
    delta_e_p99: float | None = None
    delta_e_max: float | None = None
    relative_l2: float | None = None
    error_pixels: int = 0
    error_pixels_lit: int | None = None
    error_sample: str = "none"
    reference_step_nm: float | None = None
    peak_rss_mib: float | None = None
    peak_rss_since: str = "row"
    start_rss_mib: float | None = None
    texture_bytes: int | None = None
    gl_renderer: str = ""
    backend: str = ""
    cpu: str = field(default_factory=cpu_name)
    cpu_count: int = field(default_factory=cpu_count)
    load_average: float | None = field(default_factory=load_average)
    rtbow_version: str = __version__
    command: str = ""
    scaling: dict[str, Any] | None = None
    skipped: str | None = None

    def as_json(self) -> dict[str, Any]:
        """Give the row as JSON holds it."""
        return {**asdict(self), "size_px": list(self.size_px)}


def _with_times(
    row: BenchRow, scene: Scene, times_s: Sequence[float], floors_s: Sequence[float]
) -> BenchRow:
    frame = Timing.of([1e3 * one for one in times_s])
    floor = Timing.of([1e3 * one for one in floors_s])
    width, height = scene.camera.size_px
    return replace(
        row,
        size_px=(width, height),
        frames=frame.count,
        frame_ms=frame.median,
        frame_ms_q25=frame.q25,
        frame_ms_q75=frame.q75,
        pixels_per_second=1e3 * width * height / frame.median,
        floor_ms=floor.median,
        floor_ms_q25=floor.q25,
        floor_ms_q75=floor.q75,
        floor_frames=floor.count,
        floor_ratio=frame.median / floor.median,
    )


def with_speed_up(rows: Sequence[BenchRow]) -> list[BenchRow]:
    """Set the rows of one scene against that of method ``spectral``, if there is one."""
    slow = next((r for r in rows if r.method == "spectral" and r.frame_ms is not None), None)
    if slow is None or slow.frame_ms is None:
        return list(rows)
    return [
        replace(
            row,
            spectral_ms=slow.frame_ms,
            spectral_step_nm=slow.wavelength_step_nm,
            speed_up=slow.frame_ms / row.frame_ms,
        )
        if row.frame_ms is not None
        else row
        for row in rows
    ]


def with_device(rows: Sequence[BenchRow]) -> list[BenchRow]:
    """Name the run's device in rows that were skipped before anything was drawn, too."""
    drawn = next((row for row in rows if row.gl_renderer), None)
    if drawn is None:
        return list(rows)
    return [
        row
        if row.gl_renderer
        else replace(row, gl_renderer=drawn.gl_renderer, backend=drawn.backend)
        for row in rows
    ]
