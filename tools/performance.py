"""Write docs/performance.md from what ``rtbow bench --json`` measured.

    python tools/performance.py FILE.json [MORE.json ...] [-o FILE.md] [--readme README.md]

With ``--readme``, the table between the marks ``<!-- speed -->`` and ``<!-- /speed -->`` of that
file is written, too. The targets and their scenes stand here; every number comes from the files.
Plots go to a folder beside the document, with the document's name. Where two files have the same
row, the later counts.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rtbow.base.errors import InputError, RtbowError
from rtbow.base.files import write_atomic
from rtbow.bench.report import (
    SCALING_LABELS,
    axis_value,
    draw_scaling,
    draw_speed,
    grouped,
    method_text,
    scene_text,
    share,
    short,
)
from rtbow.bench.row import BenchRow

Row = Mapping[str, Any]

COMMAND = "python tools/performance.py"
OUTPUT = Path(__file__).resolve().parents[1] / "docs" / "performance.md"
TARGET_SIZE = [640, 360]
TARGET_STEP_NM = 5.0
NOT_MEASURED = "not measured"
_DASH = "–"
_COLUMNS = 100
# Mesa's renderers on the CPU.
_CPU_RENDERERS = re.compile(r"llvmpipe|softpipe|\bSWR\b", re.IGNORECASE)


@dataclass(frozen=True)
class Target:
    """What method ``fast`` is to reach on a scene at ``TARGET_SIZE``.

    Attributes:
        scene: its name.
        speed_up: times as quick as ``spectral`` at ``TARGET_STEP_NM``, at least.
        floor_ratio: times the floor, at most.
        delta_e_p99: 99th percentile of ΔE2000 against the reference, at most.
        settings: overrides of the scene.
    """

    scene: str
    speed_up: float
    floor_ratio: float
    delta_e_p99: float
    settings: Mapping[str, object] = field(default_factory=dict)


TARGETS = (
    Target("uniform", 500.0, 1.5, 0.5),
    Target("shower", 200.0, 4.0, 0.5),
    Target("shower", 100.0, 8.0, 0.5, {"droplets.extinction": True}),
    Target("figures/fig5f", 30.0, 25.0, 1.0),
    Target("figures/fig9a", 200.0, 3.0, 0.5),
    Target("lamp-shower", 60.0, 12.0, 0.5),
)

# --- Reading -----------------------------------------------------------------------------------


def read_rows(paths: Sequence[Path]) -> list[Row]:
    """Read rows; of several alike the last counts.

    Raises:
        InputError: a file is not there or holds no rows of ``rtbow bench``.
    """
    rows: dict[str, Row] = {}
    for path in paths:
        for row in _rows_of(path):
            what = [device_of(row), scene_text(row), row["size_px"], method_text(row)]
            rows[json.dumps([*what, row["scaling"]])] = row
    return list(rows.values())


def _rows_of(path: Path) -> list[Row]:
    remedy = "give a file that rtbow bench --json wrote"
    try:
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else f"not JSON: {error}"
        raise InputError(f"{path}: cannot be read: {reason}; {remedy}") from None
    if not isinstance(data, list) or not all(isinstance(row, dict) for row in data):
        raise InputError(f"{path}: is not a list of rows; {remedy}")
    wanted = BenchRow.__dataclass_fields__.keys()
    for number, row in enumerate(data):
        missing = [key for key in wanted if key not in row]
        if missing:
            raise InputError(f"{path}: row {number} lacks {', '.join(missing)}; {remedy}")
    return data


def device_of(row: Row) -> str:
    """Name what drew a row's frames: many CPUs go by one renderer's name."""
    return f"{row['gl_renderer']}, {row['cpu_count']} × {row['cpu']}"


def on_gpu(row: Row) -> bool:
    """Tell whether a GPU drew a row's frames."""
    return bool(row["gl_renderer"]) and not _CPU_RENDERERS.search(row["gl_renderer"])


# --- Writing -----------------------------------------------------------------------------------


def document(rows: Sequence[Row], pictures: Mapping[str, str]) -> str:
    """Write the document as Markdown.

    Args:
        rows: what was measured.
        pictures: addresses of plots by device and kind, ``"{device} speed"`` and so on.
    """
    return "\n".join(_document(rows, pictures)) + "\n"


def _document(rows: Sequence[Row], pictures: Mapping[str, str]) -> Iterator[str]:
    yield "# Performance"
    yield ""
    yield _wrapped(
        f"Written by `{COMMAND}` from what `rtbow bench --json` measured; edit that, not this."
    )
    yield ""
    yield from _how(rows)
    cpu = [row for row in rows if row["gl_renderer"] and not on_gpu(row)]
    gpu = [row for row in rows if on_gpu(row)]
    yield "## On the CPU"
    yield ""
    yield from _devices(cpu, pictures, "No row was drawn on a CPU.")
    yield "## On a GPU"
    yield ""
    yield from _devices(gpu, pictures, "No row was drawn on a GPU.")


_HOW = (
    "**Times** are medians, with quartiles, of frames from the call until the device is done,"
    " without reading the picture back; frames before them warm up. **Floor** is a full-screen pass"
    " of the same size and format (RGBA32F) with one bilinear look-up in a float32 table per pixel."
    " Its frames and the method's take turns, so that whatever else the machine does meets both.",
    "**Against spectral** compares with the paper's wavelength loop in the same run, at"
    f" {TARGET_STEP_NM:g} nm (81 wavelengths).",
    "**ΔE2000** is against the float64 reference at 1 nm, at a sample of the frame's own pixels:"
    " one at random, with a fixed seed, in each of as many equal cells. White is D65 at the"
    " sample's 99.5th-percentile luminance; percentiles are over pixels with light. The greatest ΔE"
    " is that of the sample, not of the frame.",
    "**Memory** is the process's peak resident size while the row was measured (interpreter,"
    " libraries and, on a CPU renderer, the textures included); **textures** are what the method"
    " keeps on the device, tables and volume.",
)


def _how(rows: Sequence[Row]) -> Iterator[str]:
    yield "## How it was measured"
    yield ""
    for paragraph in _HOW:
        yield _wrapped(paragraph)
        yield ""
    loads = [row["load_average"] for row in rows if row["load_average"] is not None]
    if loads:
        yield _wrapped(
            f"The machine's load average before the rows was {min(loads):.1f} to {max(loads):.1f}."
        )
        yield ""
    samples = dict.fromkeys(row["error_sample"] for row in rows if row["error_pixels"])
    if samples:
        yield _wrapped(f"Pixels compared: {'; '.join(samples)}.")
        yield ""
    commands = dict.fromkeys(_shown(row["command"]) for row in rows if row["command"])
    if commands:
        yield from ("```sh", *commands, "```", "")


def _shown(command: str) -> str:
    """Give a command with files by their names alone: where they lay is nobody's business."""
    return re.sub(r"(?<=\s)[^\s]*/([^/\s]+\.json)", r"\1", command)


def _devices(rows: Sequence[Row], pictures: Mapping[str, str], none: str) -> Iterator[str]:
    if not rows:
        yield f"{NOT_MEASURED.capitalize()}. {none}"
        yield ""
    for group in grouped(rows, device_of):
        yield from _device(group, pictures)


def _device(rows: Sequence[Row], pictures: Mapping[str, str]) -> Iterator[str]:
    name = device_of(rows[0])
    yield f"### {name}"
    yield ""
    facts = (f"By {row['backend']}, with rtbow {row['rtbow_version']}." for row in rows)
    yield " ".join(dict.fromkeys(facts))
    yield ""
    yield from _targets(rows)
    speed = [row for row in rows if row["scaling"] is None]
    if speed:
        yield from _speed(speed)
        yield from _picture(pictures, f"{name} speed", f"Time per frame against error, {name}")
    scaling = [row for row in rows if row["scaling"] is not None]
    yield "#### Scaling"
    yield ""
    if not scaling:
        yield f"{NOT_MEASURED.capitalize()}."
        yield ""
        return
    yield from _scaling(scaling)
    yield from _picture(pictures, f"{name} scaling", f"Time and textures, {name}")


def _picture(pictures: Mapping[str, str], name: str, text: str) -> Iterator[str]:
    if name in pictures:
        yield f"![{text}]({pictures[name]})"
        yield ""


# --- Targets -----------------------------------------------------------------------------------


def row_for(target: Target, rows: Sequence[Row]) -> Row | None:
    """Choose the row of method ``fast`` that a target is about.

    That of the scene's own tolerance, if it was measured; else the quickest that keeps the target's
    error; else the one with the least error.
    """
    found = [
        row
        for row in rows
        if row["scene"] == target.scene
        and row["method"] == "fast"
        and row["common"] == target.settings
        and row["size_px"] == TARGET_SIZE
        and row["scaling"] is None
        and row["frame_ms"] is not None
    ]
    own = [row for row in found if not row["setting"]]
    if own:
        return own[-1]
    kept = [row for row in found if _met(row["delta_e_p99"], most=target.delta_e_p99)]
    if kept:
        return min(kept, key=lambda row: float(row["frame_ms"]))
    return min(found, key=lambda row: float(row["delta_e_p99"] or 1e9), default=None)


def _met(value: float | None, least: float = 0.0, most: float = float("inf")) -> bool | None:
    """Tell whether a number is within bounds; None if there is no number."""
    return None if value is None else least <= value <= most


_WHICH = (
    f"Method `fast` at {TARGET_SIZE[0]} × {TARGET_SIZE[1]}, at the scene's own tolerance; where"
    " that was not measured, the quickest setting that keeps the target's error."
)


def _targets(rows: Sequence[Row]) -> Iterator[str]:
    yield "#### Targets"
    yield ""
    yield _wrapped(_WHICH)
    yield ""
    cells = []
    for target in TARGETS:
        about = {"scene": target.scene, "common": dict(target.settings)}
        row = row_for(target, rows)
        if row is None:
            cells.append((scene_text(about), _DASH, *[NOT_MEASURED] * 3, _DASH))
            continue
        honest = row["spectral_step_nm"] == TARGET_STEP_NM
        cells.append(
            (
                scene_text(about),
                method_text(row),
                _verdict(row["speed_up"] if honest else None, "≥", target.speed_up),
                _verdict(row["floor_ratio"], "≤", target.floor_ratio),
                _verdict(row["delta_e_p99"], "≤", target.delta_e_p99),
                short(row["frame_ms"]),
            )
        )
    yield from _table(
        ("scene", "method", "× spectral (target)", "× floor (target)", "ΔE 99 % (target)", "ms"),
        cells, rows,
    )  # fmt: skip
    yield ""


def _verdict(value: float | None, sign: str, bound: float) -> str:
    if value is None:
        return NOT_MEASURED
    met = value >= bound if sign == "≥" else value <= bound
    return f"{short(value)} ({sign} {bound:g}): {'met' if met else '**not met**'}"


# --- Tables ------------------------------------------------------------------------------------


def _speed(rows: Sequence[Row]) -> Iterator[str]:
    yield "#### Speed and error"
    yield ""
    cells = [
        (
            scene_text(row), "{} × {}".format(*row["size_px"]), method_text(row),
            f"{short(row['frame_ms'])} ({short(row['frame_ms_q25'])}–{short(row['frame_ms_q75'])})",
            str(row["frames"]), short(row["pixels_per_second"] * 1e-6), short(row["floor_ms"]),
            short(row["floor_ratio"]), short(row["speed_up"]), short(row["delta_e_p50"], 2),
            short(row["delta_e_p99"], 2), short(row["delta_e_max"], 2), share(row["relative_l2"]),
            short(row["peak_rss_mib"]), short(row["texture_bytes"] / 2**20, 2),
        )
        for row in rows
        if not row["skipped"]
    ]  # fmt: skip
    titles = (
        "scene", "size", "method", "ms (quartiles)", "frames", "Mpx/s", "floor, ms", "× floor",
        "× spectral", "ΔE median", "ΔE 99 %", "ΔE worst", "L2", "memory, MiB", "textures, MiB",
    )  # fmt: skip
    yield from _table(titles, cells, rows)
    yield ""
    yield from _skipped([row for row in rows if row["skipped"]])


def _skipped(rows: Sequence[Row]) -> Iterator[str]:
    for row in rows:
        where = f"{scene_text(row)}, {method_text(row)}"
        if row["scaling"]:
            where += ", {}".format(axis_value(row["scaling"]["axis"], row["scaling"]["value"]))
        yield _wrapped(f"{where}: skipped: {' '.join(row['skipped'].split())}", bullet=True)
    if rows:
        yield ""


def _scaling(rows: Sequence[Row]) -> Iterator[str]:
    for group in grouped(rows, lambda row: (scene_text(row), row["scaling"]["axis"])):
        axis = group[0]["scaling"]["axis"]
        first = next((row for row in group if not row["skipped"]), group[0])
        size = "" if axis == "pixels" else ", {} × {}".format(*first["size_px"])
        yield f"{SCALING_LABELS.get(axis, axis).capitalize()}: {scene_text(group[0])}{size}."
        yield ""
        methods = list(dict.fromkeys(method_text(row) for row in group))
        cells = []
        for value in dict.fromkeys(row["scaling"]["value"] for row in group):
            at = {method_text(r): r for r in group if r["scaling"]["value"] == value}
            floors = [r["floor_ms"] for r in at.values() if r["floor_ms"] is not None]
            line = [axis_value(axis, value), short(min(floors, default=None))]
            for method in methods:
                line += _point(at.get(method))
            cells.append(line)
        columns = [f"{method}: {what}" for method in methods for what in ("ms", "textures, MiB")]
        yield from _table([axis, "floor, ms", *columns], cells, group)
        yield ""
        yield from _skipped([row for row in group if row["skipped"]])


def _point(row: Row | None) -> tuple[str, str]:
    if row is None:
        return NOT_MEASURED, _DASH
    if row["skipped"]:
        return "skipped", _DASH
    return short(row["frame_ms"]), short(row["texture_bytes"] / 2**20, 2)


def _table(
    titles: Sequence[str], cells: Sequence[Sequence[str]], rows: Sequence[Row]
) -> Iterator[str]:
    """Write a table, with the device's name in every line."""
    device = str(rows[0]["gl_renderer"])
    for line in (titles, ["---"] * len(titles), *cells):
        last = "device" if line is titles else "---" if line[0] == "---" else device
        yield "| " + " | ".join([*line, last]) + " |"


def _wrapped(text: str, *, bullet: bool = False) -> str:
    return textwrap.fill(
        text, _COLUMNS, initial_indent="- " if bullet else "",
        subsequent_indent="  " if bullet else "", break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


# --- The README ---------------------------------------------------------------------------------

_MARKS = re.compile(r"(<!-- speed -->\n).*?(<!-- /speed -->)", re.DOTALL)


def summary(rows: Sequence[Row]) -> str:
    """Write the rows of method ``fast``, each beside its ``spectral``, as a short table."""
    spectral = {
        json.dumps([scene_text(row), row["size_px"]]): row
        for row in rows
        if row["method"] == "spectral" and row["scaling"] is None
    }
    lines = [
        "| scene | `fast`, ms | times the floor | times as quick as `spectral`"
        " | ΔE2000 `fast` | ΔE2000 `spectral` |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        if row["method"] != "fast" or row["scaling"] is not None or row["skipped"]:
            continue
        if row["setting"] or row["scene"].startswith("random-"):
            continue
        name = f"`{scene_text(row)}`"
        if row["size_px"] != TARGET_SIZE:
            name += ", {}×{}".format(*row["size_px"])
        other = spectral.get(json.dumps([scene_text(row), row["size_px"]]))
        cells = (
            name, short(row["frame_ms"], 2), short(row["floor_ratio"], 2),
            short(row["speed_up"], 3) if row["speed_up"] else NOT_MEASURED,
            short(row["delta_e_p99"], 2),
            short(other["delta_e_p99"], 2) if other else _DASH,
        )  # fmt: skip
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def write_summary(rows: Sequence[Row], readme: Path) -> None:
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
    table = summary(rows)
    write_atomic(readme, _MARKS.sub(lambda m: m[1] + table + m[2], text).encode())


# --- The files ---------------------------------------------------------------------------------


def write_document(rows: Sequence[Row], output: Path) -> list[Path]:
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
    for group in grouped([row for row in rows if row["gl_renderer"]], device_of):
        name = device_of(group[0])
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
