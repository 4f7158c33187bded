"""A row of figures: what one method takes and misses in one scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from rtbow.base.jobs import cores
from rtbow.base.version import __version__
from rtbow.bench.memory import cpu_name, load_average
from rtbow.frames.difference import FrameDifference


@dataclass(frozen=True)
class Timing:
    """Median and quartiles of the times of some frames."""

    median_ms: float
    q25_ms: float
    q75_ms: float
    frames: int

    @classmethod
    def of(cls, times_s: Sequence[float]) -> Timing:
        """Give the median and the quartiles of times in seconds."""
        q25, median, q75 = np.percentile(np.multiply(1e3, times_s), [25.0, 50.0, 75.0])
        return cls(float(median), float(q25), float(q75), len(times_s))


@dataclass(frozen=True)
class Times:
    """How long frames take, from the call until the device is done.

    Attributes:
        frame: the method's.
        floor: the floor's, one table look-up per pixel, drawn between them.
        first_frame_ms: the method's first: context, textures, programs, drawing and reading.
    """

    frame: Timing
    floor: Timing
    first_frame_ms: float


@dataclass(frozen=True)
class Memory:
    """What a method takes up.

    Attributes:
        peak_rss_mib: the most that the process held; None where the system does not say.
        peak_rss_since: ``"row"``, or ``"process"`` where the system keeps no later peak.
        start_rss_mib: what the process held before the row.
        texture_bytes: the method's textures on the device, tables and volume.
    """

    peak_rss_mib: float | None
    peak_rss_since: str
    start_rss_mib: float | None
    texture_bytes: int


@dataclass(frozen=True)
class SampleDifference:
    """How far the frame is from the reference, on a sample of its pixels.

    Attributes:
        difference: over the pixels with light; None where the reference has none to see.
        pixels: how many were compared.
        pixels_lit: how many of them have light in the reference.
        sample: where they are.
        reference_step_nm: the reference's wavelength step.
    """

    difference: FrameDifference | None
    pixels: int
    pixels_lit: int
    sample: str
    reference_step_nm: float


@dataclass(frozen=True)
class ScalingPoint:
    """A value along an axis of a scaling run."""

    axis: str
    value: int


@dataclass(frozen=True)
class Machine:
    """What measured a row.

    Attributes:
        gl_renderer: the GL device and driver; empty where nothing was drawn.
        backend: how the context was made.
        cpu_count: CPUs that the process may use.
        load_average: over the minute before the row.
    """

    gl_renderer: str = ""
    backend: str = ""
    cpu: str = field(default_factory=cpu_name)
    cpu_count: int = field(default_factory=cores)
    load_average: float | None = field(default_factory=load_average)
    rtbow_version: str = __version__


@dataclass(frozen=True)
class BenchRow:
    """One measurement; the names are the keys of ``--json``. None is what was not measured.

    Attributes:
        scene: its name or path.
        method: of the shader's.
        setting: overrides of this row alone, by dotted key.
        common: overrides that all rows of the run share.
        size_px: width and height.
        machine: what measured it.
        command: what was typed.
        wavelength_step_nm: of methods with a wavelength loop.
        times: how long frames take.
        memory: what they take up.
        error: how far they are from the reference.
        spectral_ms: ``frame_ms`` of method ``spectral`` in the same scene and run.
        spectral_step_nm: its wavelength step.
        scaling: the row's place in a scaling run.
        skipped: why nothing was measured.
    """

    scene: str
    method: str
    setting: dict[str, Any]
    common: dict[str, Any]
    size_px: tuple[int, int]
    machine: Machine
    command: str = ""
    wavelength_step_nm: float | None = None
    times: Times | None = None
    memory: Memory | None = None
    error: SampleDifference | None = None
    spectral_ms: float | None = None
    spectral_step_nm: float | None = None
    scaling: ScalingPoint | None = None
    skipped: str | None = None

    @property
    def frame_ms(self) -> float | None:
        """Median time of a frame."""
        return self.times.frame.median_ms if self.times else None

    @property
    def floor_ms(self) -> float | None:
        """Median time of a frame of the floor."""
        return self.times.floor.median_ms if self.times else None

    @property
    def pixels_per_second(self) -> float | None:
        """Pixels that the method draws in a second."""
        return 1e3 * math.prod(self.size_px) / self.frame_ms if self.frame_ms else None

    @property
    def floor_ratio(self) -> float | None:
        """How many times as long a frame takes as one of the floor."""
        return self.frame_ms / self.floor_ms if self.frame_ms and self.floor_ms else None

    @property
    def speed_up(self) -> float | None:
        """How many times as quick as ``spectral`` the method is."""
        return self.spectral_ms / self.frame_ms if self.spectral_ms and self.frame_ms else None

    @property
    def difference(self) -> FrameDifference | None:
        """How far the pixels with light are from the reference."""
        return self.error.difference if self.error else None

    def as_json(self) -> dict[str, Any]:
        """Give the row as JSON holds it: all records, and the most wanted numbers on top."""
        difference = self.difference
        delta_e = difference.delta_e if difference else None
        return asdict(self) | {
            "frame_ms": self.frame_ms,
            "floor_ms": self.floor_ms,
            "pixels_per_second": self.pixels_per_second,
            "floor_ratio": self.floor_ratio,
            "speed_up": self.speed_up,
            "delta_e_p50": delta_e.median if delta_e else None,
            "delta_e_p99": delta_e.p99 if delta_e else None,
            "delta_e_p99_range": delta_e.p99_range if delta_e else None,
            "delta_e_max": delta_e.worst if delta_e else None,
            "relative_l2": difference.l2 if difference else None,
            "gl_renderer": self.machine.gl_renderer,
        }


def with_speed_up(rows: Sequence[BenchRow]) -> list[BenchRow]:
    """Set the rows of one scene against that of method ``spectral``, if there is one."""
    slow = next((row for row in rows if row.method == "spectral" and row.times), None)
    if slow is None:
        return list(rows)
    ms, step_nm = slow.frame_ms, slow.wavelength_step_nm
    return [
        replace(row, spectral_ms=ms, spectral_step_nm=step_nm) if row.times else row for row in rows
    ]


def with_device(rows: Sequence[BenchRow]) -> list[BenchRow]:
    """Name the run's device in rows that were skipped before anything was drawn, too."""
    drawn = next((row.machine for row in rows if row.machine.gl_renderer), Machine())
    return [
        row
        if row.machine.gl_renderer
        else replace(
            row,
            machine=replace(row.machine, gl_renderer=drawn.gl_renderer, backend=drawn.backend),
        )
        for row in rows
    ]
