"""Write docs/performance.md from what ``rtbow bench --json`` measured.

    python tools/performance.py FILE.json [MORE.json ...] [-o FILE.md] [--readme README.md]

With ``--readme``, the table between the marks ``<!-- speed -->`` and ``<!-- /speed -->`` of that
file is written as well. The targets and their scenes are defined here; every measured number comes
from the files. Plots go to a folder beside the document, with the document's name. Where two files
have the same row, the later one counts.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from markup import bullets, paragraph, table
from rtbow.base.errors import InputError, RtbowError
from rtbow.base.files import write_atomic
from rtbow.bench.plot import SCALING_LABELS, draw_scaling, draw_speed
from rtbow.bench.report import (
    DASH,
    axis_of,
    device_text,
    error_cells,
    grouped,
    megapixels,
    memory_cells,
    method_text,
    point_text,
    quartiles,
    scene_text,
    short,
    size_text,
    skipped_text,
)
from rtbow.bench.row import BenchRow

COMMAND = "python tools/performance.py"
OUTPUT = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
TARGET_SIZE = (640, 360)
TARGET_STEP_NM = 5.0
NOT_MEASURED = "not measured"
# Mesa's renderers on the CPU.
_CPU_RENDERERS = re.compile(r"llvmpipe|softpipe|\bSWR\b", re.IGNORECASE)
_ROWS = TypeAdapter(list[BenchRow])


@dataclass(frozen=True)
class Target:
    """What method ``fast`` is to reach on a scene at ``TARGET_SIZE``.

    Attributes:
        scene: its name with its overrides, as :func:`scene_text` writes them.
        speed_up: times as quick as ``spectral`` at ``TARGET_STEP_NM``, at least.
        floor_ratio: times the floor, at most.
        delta_e_p99: 99th percentile of ΔE2000 against the reference, at most.
    """

    scene: str
    speed_up: float
    floor_ratio: float
    delta_e_p99: float


TARGETS = (
    Target("uniform", 500.0, 1.5, 0.5),
    Target("shower", 200.0, 4.0, 0.5),
    Target("shower with droplets.extinction=true", 100.0, 8.0, 0.5),
    Target("figures/fig5f", 30.0, 25.0, 1.0),
    Target("figures/fig9a", 200.0, 3.0, 0.5),
    Target("lamp-shower", 60.0, 12.0, 0.5),
)

# --- Reading -----------------------------------------------------------------------------------


def read_rows(paths: Sequence[Path]) -> list[BenchRow]:
    """Read rows; of several alike the last counts.

    Raises:
        InputError: a file is not there or holds no rows of ``rtbow bench``.
    """
    rows = {}
    for path in paths:
        for row in _rows_of(path):
            what = (device_text(row), scene_text(row), row.size_px, method_text(row), row.scaling)
            rows[what] = row
    return list(rows.values())


def _rows_of(path: Path) -> list[BenchRow]:
    try:
        return _ROWS.validate_json(path.read_bytes())
    except OSError as error:
        problem = f"cannot be read: {error.strerror}"
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"]))
        problem = f"{place}: {first['msg']}" if place else first["msg"]
    raise InputError(f"{path}: {problem}; give a file that rtbow bench --json wrote")


def on_gpu(row: BenchRow) -> bool:
    """Whether a GPU drew a row's frames."""
    renderer = row.machine.gl_renderer
    return bool(renderer) and not _CPU_RENDERERS.search(renderer)


# --- Writing -----------------------------------------------------------------------------------


def document(rows: Sequence[BenchRow], pictures: Mapping[str, str]) -> str:
    """Write the document as Markdown.

    Args:
        rows: what was measured.
        pictures: addresses of plots by device and kind, ``"{device} speed"`` and so on.
    """
    return "\n\n".join(_document(rows, pictures)) + "\n"


def _document(rows: Sequence[BenchRow], pictures: Mapping[str, str]) -> Iterator[str]:
    yield "# Performance"
    yield paragraph(
        f"Written by `{COMMAND}` from what `rtbow bench --json` measured; edit that, not this."
    )
    yield from _how(rows)
    drawn = [row for row in rows if row.machine.gl_renderer]
    for where, gpu in (("the CPU", False), ("a GPU", True)):
        yield f"## On {where}"
        devices = grouped([row for row in drawn if on_gpu(row) is gpu], device_text)
        if not devices:
            yield f"{NOT_MEASURED.capitalize()}. No row was drawn on a {where.split()[-1]}."
        for group in devices:
            yield from _device(group, pictures)


_HOW = (
    "**Times** are medians, with quartiles, per frame, from the call until the device is done,"
    " without reading the picture back, after warm-up frames. **Floor** is a full-screen pass"
    " of the same size and format (RGBA32F) with one bilinear look-up in a float32 table per pixel."
    " Its frames alternate with the method's, so that other load on the machine affects both.",
    "**Against spectral** compares with the paper's wavelength loop in the same run, at"
    f" {TARGET_STEP_NM:g} nm (81 wavelengths).",
    "**ΔE2000** is against the float64 reference at 1 nm, at a sample of the frame's own pixels:"
    " one chosen at random, with a fixed seed, from each of as many equal cells. White is D65 at"
    " the sample's 99.5th-percentile luminance; percentiles are over pixels with light. The worst"
    " ΔE is that of the sample, not of the frame.",
    "**Memory** is the process's peak resident size while the row was measured (interpreter,"
    " libraries and, on a CPU renderer, the textures included); **textures** are those that the"
    " method keeps on the device, for tables and volume.",
)


def _how(rows: Sequence[BenchRow]) -> Iterator[str]:
    yield "## How it was measured"
    yield from map(paragraph, _HOW)
    loads = [load for row in rows if (load := row.machine.load_average) is not None]
    if loads:
        yield paragraph(
            f"The machine's load average before the rows was {min(loads):.1f} to {max(loads):.1f}."
        )
    samples = dict.fromkeys(row.error.sample for row in rows if row.error)
    if samples:
        yield paragraph(f"Pixels compared: {'; '.join(samples)}.")
    commands = dict.fromkeys(_shown(row.command) for row in rows if row.command)
    if commands:
        yield "\n".join(["```sh", *commands, "```"])


def _shown(command: str) -> str:
    """Give a command with files by their names alone: where they were does not matter."""
    return re.sub(r"(?<=\s)[^\s]*/([^/\s]+\.json)", r"\1", command)


def _device(rows: Sequence[BenchRow], pictures: Mapping[str, str]) -> Iterator[str]:
    name = device_text(rows[0])
    yield f"### {name}"
    yield " ".join(
        dict.fromkeys(
            f"By {row.machine.backend}, with rtbow {row.machine.rtbow_version}." for row in rows
        )
    )
    yield from _targets(rows)
    speed = [row for row in rows if not row.scaling]
    if speed:
        yield from _speed(speed)
        yield from _picture(pictures, f"{name} speed", f"Time per frame against error, {name}")
    scaling = [row for row in rows if row.scaling]
    yield "#### Scaling"
    if not scaling:
        yield f"{NOT_MEASURED.capitalize()}."
    for group in grouped(scaling, lambda row: (scene_text(row), axis_of(row))):
        yield from _scaling(group)
    yield from _picture(pictures, f"{name} scaling", f"Time and textures, {name}")


def _picture(pictures: Mapping[str, str], name: str, text: str) -> Iterator[str]:
    if name in pictures:
        yield f"![{text}]({pictures[name]})"


def _table(rows: Sequence[BenchRow], titles: Sequence[str], cells: Sequence[Sequence[str]]) -> str:
    """Write a table, with the device's name in every line."""
    device = rows[0].machine.gl_renderer
    return table([*titles, "device"], [[*line, device] for line in cells])


def _skipped(rows: Sequence[BenchRow]) -> Iterator[str]:
    texts = [f"{scene_text(row)}, {skipped_text(row)}" for row in rows if row.skipped]
    if texts:
        yield bullets(texts)


# --- Targets -----------------------------------------------------------------------------------


def row_for(target: Target, rows: Sequence[BenchRow]) -> BenchRow | None:
    """Choose the row of method ``fast`` that a target is about.

    That of the scene's own tolerance, if it was measured; otherwise the quickest that stays within
    the target's error; failing that, the one with the least error.
    """
    candidates = [
        row
        for row in rows
        if (scene_text(row), row.method, row.size_px) == (target.scene, "fast", TARGET_SIZE)
        and row.times
        and not row.scaling
    ]
    own = [row for row in candidates if not row.setting]
    if own:
        return own[-1]
    kept = [row for row in candidates if _delta_e_p99(row) <= target.delta_e_p99]
    if kept:
        return min(kept, key=lambda row: row.frame_ms or 0.0)
    return min(candidates, key=_delta_e_p99, default=None)


def _delta_e_p99(row: BenchRow) -> float:
    return row.difference.delta_e.p99 if row.difference else math.inf


_WHICH = (
    f"Method `fast` at {TARGET_SIZE[0]} × {TARGET_SIZE[1]}, at the scene's own tolerance; where"
    " that was not measured, the quickest setting that stays within the target's error."
)


def _targets(rows: Sequence[BenchRow]) -> Iterator[str]:
    yield "#### Targets"
    yield paragraph(_WHICH)
    cells = []
    for target in TARGETS:
        row = row_for(target, rows)
        if row is None:
            cells.append((target.scene, DASH, *[NOT_MEASURED] * 3, DASH))
            continue
        speed_up = row.speed_up if row.spectral_step_nm == TARGET_STEP_NM else None
        delta_e = row.difference.delta_e.p99 if row.difference else None
        cells.append(
            (
                target.scene,
                method_text(row),
                _verdict(speed_up, "≥", target.speed_up),
                _verdict(row.floor_ratio, "≤", target.floor_ratio),
                _verdict(delta_e, "≤", target.delta_e_p99),
                short(row.frame_ms),
            )
        )
    titles = (
        "scene", "method", "× spectral (target)", "× floor (target)", "ΔE 99 % (target)", "ms",
    )  # fmt: skip
    yield _table(rows, titles, cells)


def _verdict(value: float | None, sign: str, bound: float) -> str:
    if value is None:
        return NOT_MEASURED
    met = value >= bound if sign == "≥" else value <= bound
    return f"{short(value)} ({sign} {bound:g}): {'met' if met else '**not met**'}"


# --- Tables ------------------------------------------------------------------------------------


def _speed(rows: Sequence[BenchRow]) -> Iterator[str]:
    yield "#### Speed and error"
    titles = (
        "scene", "size", "method", "ms (quartiles)", "frames", "Mpx/s", "floor, ms", "× floor",
        "× spectral", "ΔE median", "ΔE 99 %", "ΔE worst", "L2", "memory, MiB", "textures, MiB",
    )  # fmt: skip
    cells = [
        (
            scene_text(row), size_text(row), method_text(row),
            f"{short(row.frame_ms)} ({quartiles(row.times)})", str(row.times.frame.frames),
            megapixels(row), short(row.floor_ms), short(row.floor_ratio), short(row.speed_up),
            *error_cells(row), *memory_cells(row),
        )
        for row in rows
        if row.times
    ]  # fmt: skip
    yield _table(rows, titles, cells)
    yield from _skipped(rows)


def _scaling(group: Sequence[BenchRow]) -> Iterator[str]:
    axis = axis_of(group[0])
    first = next((row for row in group if row.times), group[0])
    size = "" if axis == "pixels" else f", {size_text(first)}"
    yield f"{SCALING_LABELS.get(axis, axis).capitalize()}: {scene_text(first)}{size}."
    methods = list(dict.fromkeys(method_text(row) for row in group))
    cells = []
    for point in dict.fromkeys(row.scaling for row in group if row.scaling):
        at = {method_text(row): row for row in group if row.scaling == point}
        floors = [row.times.floor.median_ms for row in at.values() if row.times]
        cells.append([point_text(point), short(min(floors, default=None))])
        for method in methods:
            cells[-1] += _point(at.get(method))
    columns = [f"{method}: {what}" for method in methods for what in ("ms", "textures, MiB")]
    yield _table(group, [axis, "floor, ms", *columns], cells)
    yield from _skipped(group)


def _point(row: BenchRow | None) -> tuple[str, str]:
    if row is None:
        return NOT_MEASURED, DASH
    return "skipped" if row.skipped else short(row.frame_ms), memory_cells(row)[1]


# --- The README ---------------------------------------------------------------------------------

_MARKS = re.compile(r"(<!-- speed -->\n).*?(<!-- /speed -->)", re.DOTALL)


def summary(rows: Sequence[BenchRow]) -> str:
    """Write the rows of method ``fast``, each beside its ``spectral``, as a short table."""

    def place(row: BenchRow) -> tuple[str, tuple[int, int]]:
        return scene_text(row), row.size_px

    plain = [row for row in rows if row.times and not row.scaling]
    spectral = {place(row): row for row in plain if row.method == "spectral"}
    titles = (
        "scene", "`fast`, ms", "times the floor", "times as quick as `spectral`", "ΔE2000 `fast`",
        "ΔE2000 `spectral`",
    )  # fmt: skip
    cells = []
    for row in plain:
        if row.method != "fast" or row.setting or row.scene.startswith("random-"):
            continue
        name = f"`{scene_text(row)}`"
        if row.size_px != TARGET_SIZE:
            name += ", {}×{}".format(*row.size_px)
        other = spectral.get(place(row))
        cells.append(
            (
                name, short(row.frame_ms, 2), short(row.floor_ratio, 2),
                short(row.speed_up, 3) if row.speed_up else NOT_MEASURED, error_cells(row)[1],
                error_cells(other)[1] if other else DASH,
            )
        )  # fmt: skip
    return table(titles, cells) + "\n"


def write_summary(rows: Sequence[BenchRow], readme: Path) -> None:
    """Put the short table into a file, between its marks.

    Raises:
        InputError: the file cannot be read, or lacks the marks.
    """
    try:
        text = readme.read_text("utf-8")
    except OSError as error:
        raise InputError(f"{readme}: cannot be read: {error.strerror}") from error
    if not _MARKS.search(text):
        raise InputError(f"{readme}: has no <!-- speed --> … <!-- /speed -->; put them in")
    short_table = summary(rows)
    write_atomic(readme, _MARKS.sub(lambda m: m[1] + short_table + m[2], text).encode())


# --- The files ---------------------------------------------------------------------------------


def write_document(rows: Sequence[BenchRow], output: Path) -> list[Path]:
    """Write the document and its plots; give their paths.

    Raises:
        InputError: a file or the plots' folder cannot be made.
    """
    folder = output.parent / output.stem
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror}); name another") from error
    pictures: dict[str, str] = {}
    written = [output]
    for group in grouped([row for row in rows if row.machine.gl_renderer], device_text):
        name = device_text(group[0])
        stem = re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")
        for kind, draw in (("speed", draw_speed), ("scaling", draw_scaling)):
            path = folder / f"{stem}-{kind}.png"
            if draw(path, group):
                pictures[f"{name} {kind}"] = f"{folder.name}/{path.name}"
                written.append(path)
    write_atomic(output, document(rows, pictures).encode())
    return written


def main() -> int:
    """Read the command line and write the document; give the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="+", type=Path, help="what rtbow bench --json wrote")
    parser.add_argument("-o", "--output", type=Path, default=OUTPUT)
    parser.add_argument("--readme", type=Path, help="a file with a table of its own to be written")
    given = parser.parse_args()
    try:
        rows = read_rows(given.files)
        for path in write_document(rows, given.output):
            print(f"wrote {path}")
        if given.readme is not None:
            write_summary(rows, given.readme)
            print(f"wrote {given.readme}")
    except RtbowError as error:
        print(f"{COMMAND}: {error}", file=sys.stderr)
        return error.exit_code
    return 0


if __name__ == "__main__":
    sys.exit(main())
