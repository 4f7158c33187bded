"""Print the project's measured numbers: check values, table, frames against the reference, times.

    python tools/accuracy.py [physics] [table] [frames] [figures] [volume] [startup]
    python tools/accuracy.py budget [--stage NAME]... [-o FILE]

Without arguments, all but the figures and the budget. Times depend on the machine and are never
part of a test. ``budget`` measures each source of error alone and writes docs/accuracy.md; with
``--stage`` it prints those stages and writes only to ``--output``.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

import rtbow
from budget import STAGES
from budget.error_budget import document, run_stage, section_of, with_section
from budget.frames import facts
from rtbow.base.arrays import Array, floats
from rtbow.base.files import write_atomic
from rtbow.physics.air.rayleigh import rayleigh_depth, sun_column
from rtbow.physics.drop.airy import airy_squared, bow
from rtbow.physics.drop.water import iapws_index
from rtbow.physics.light.colour import luminance
from rtbow.scene.model import Scene
from rtbow.study.figures import PREFIX, figure_names
from rtbow.tables.report import describe_table
from rtbow.world.rain.volume import DropletVolume, save_volume

SIZE = [96, 54]
BACKENDS = ("egl", "osmesa")
# IAPWS-95 density of water at 20 °C and 101325 Pa, kg/m³.
DENSITY_20C = 998.2063


def peak(reflections: int, nm: float, index: float, radius_um: float) -> tuple[float, float]:
    """Give the angle [deg] and height [m² sr⁻¹] of a bow's peak, without a disc."""
    the_bow = bow(reflections, np.array([nm * 1e-9]), np.array([index]))
    radius = radius_um * 1e-6
    z = np.linspace(0.5, 1.5, 20001)
    value = the_bow.strength[0] * radius ** (7 / 3) * airy_squared(z)
    best = int(value.argmax())
    scale = the_bow.scale[0] * radius ** (2 / 3)
    angle = the_bow.angle_rad[0] + the_bow.side * z[best] / scale
    return float(np.degrees(angle)), float(value[best])


def physics() -> None:
    """Print the check values."""
    print("IAPWS R9-97:", end=" ")
    for um, kelvin, density in ((0.2265, 298.15, 997.047435), (0.5893, 773.15, 30.4758534)):
        print(f"n({um} um, {kelvin} K) = {iapws_index(floats(um), kelvin, density):.8f}", end="  ")
    print("\nDescartes angles from the antisolar point, water in vacuum at 20 C:")
    for line in (400.0, 500.0, 589.3, 700.0):
        index = iapws_index(np.array([line * 1e-3]), 293.15, DENSITY_20C)
        angles = [180 - np.degrees(bow(k, np.array([line]), index).angle_rad[0]) for k in (1, 2)]
        print(f"  {line:5.1f} nm  primary {angles[0]:.3f}  secondary {angles[1]:.3f}")
    print("Airy peaks at 550 nm, n = 1.33468, degrees (primary, secondary):")
    for radius in (10, 50, 100, 250, 500, 1000):
        angles = [peak(k, 550.0, 1.33468, radius)[0] for k in (1, 2)]
        print(f"  {radius:5d} um  {angles[0]:.2f}  {angles[1]:.2f}")
    heights = [
        peak(1, nm, float(iapws_index(floats(nm / 1000), 293.15, 998.2)) / 1.000277, 100.0)[1]
        for nm in (450.0, 550.0, 650.0)
    ]
    print("Primary peak at 100 um, 450/550/650 nm:", [f"{h:.3g}" for h in heights], "m2/sr")
    nm = np.arange(400.0, 701.0, 50.0)
    print("Rayleigh depth 400..700 nm:", [f"{d:.5f}" for d in rayleigh_depth(nm)])
    altitudes = np.array([0.0, 1, 2, 3, 5, 10, 20, 30, 90])
    columns = sun_column(0.0, np.radians(altitudes))
    print("Sun columns:", [f"{a:g} deg {c:.3f}" for a, c in zip(altitudes, columns, strict=True)])


def table() -> None:
    """Print the table's build time and look-up error."""
    for line in describe_table(4000):
        print(line)


def difference(frame: Array, reference: Array) -> tuple[float, float, float]:
    """Give median, 99th percentile and maximum over pixels of the largest channel difference.

    Relative to the reference's 99.5th-percentile luminance.
    """
    level = np.percentile(luminance(reference), 99.5)
    error = np.abs(floats(frame) - reference).max(axis=-1) / level
    return float(np.median(error)), float(np.percentile(error, 99)), float(error.max())


def render(scene: Scene, method: str, backend: str = "auto") -> tuple[Array, float, str]:
    """Render once; give the frame, the seconds it took and the renderer."""
    with rtbow.Renderer(scene, backend) as renderer:  # type: ignore[arg-type]
        begun = time.perf_counter()
        frame = renderer.render(method)  # type: ignore[arg-type]
        return floats(frame), time.perf_counter() - begun, renderer.gl_renderer


def frames() -> None:
    """Print the shader's distance from the reference on the first scenes, on each backend."""
    compare("curtain", "uniform", "shower")


def figures() -> None:
    """Print the same for the scenes of the paper's figures; takes some twenty minutes."""
    compare(*(PREFIX + name for name in figure_names()))


def compare(*names: str) -> None:
    """Print the shader's distance from the reference, on the same wavelengths and on 1 nm."""
    for name in names:
        size = {"camera.size_px": SIZE}
        scene = rtbow.load_scene(name, size)
        same, seconds, _ = render(scene, "reference")
        truth, truth_s, _ = render(
            rtbow.load_scene(name, {**size, "render.wavelength_step_nm": 1.0}), "reference"
        )
        print(f"{name} {SIZE[0]}x{SIZE[1]}: reference {seconds:.1f} s, at 1 nm {truth_s:.1f} s")
        for backend in BACKENDS:
            frame, took, renderer = render(scene, "spectral", backend)
            for label, other in (("same wavelengths", same), ("1 nm reference", truth)):
                p50, p99, worst = difference(frame, other)
                print(
                    f"  {backend:<7}against {label:<17} p50 {p50:.1e}  p99 {p99:.1e}"
                    f"  max {worst:.1e}  ({took:.2f} s, {renderer})"
                )


def volume() -> None:
    """Print the time and memory that a 256³ volume takes to load and upload."""
    shape = (256, 256, 256)
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.npz"
        drops = DropletVolume(
            np.array([[-1000.0, 200.0, 0.0], [1000.0, 1200.0, 1000.0]]),
            rng.uniform(300.0, 700.0, shape).astype(np.float32),
            np.full(shape, 1000.0, dtype=np.float32),
        )
        save_volume(drops, path)
        code = (
            "import time, resource, rtbow\n"
            "from rtbow.gl.context import open_context\n"
            "from rtbow.render.spectral.method import SpectralMethod\n"
            "from rtbow.world.world import resolve\n"
            "s = rtbow.load_scene('uniform', {'droplets.file': " + repr(str(path)) + "})\n"
            "gl = open_context()\n"
            "t = time.perf_counter()\n"
            "with gl.current(): p = SpectralMethod(gl, resolve(s))\n"
            "peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10\n"
            "print(f'256^3 volume: {time.perf_counter() - t:.2f} s to load and upload, '\n"
            "      f'{peak:.0f} MiB peak of the whole process')\n"
        )
        subprocess.run([sys.executable, "-c", code], check=True)


def startup() -> None:
    """Print what the help and the default picture cost, as whole processes."""
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/default"
        for label, arguments in (
            ("rtbow --help", ["--help"]),
            ("make demo's render", ["render", "-q", "-o", f"{out}.exr", "-o", f"{out}.png"]),
        ):
            best = min(timed([sys.executable, "-m", "rtbow", *arguments]) for _ in range(2))
            print(f"{label}: {best:.2f} s")
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 2**10
    print(f"largest process: {peak:.0f} MiB")


def timed(command: list[str]) -> float:
    """Run a command; give its seconds."""
    begun = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - begun


def budget(stages: list[str], output: Path | None) -> int:
    """Measure the error budget; give the number of stages that failed.

    Args:
        stages: names of the stages to measure; all if there is none.
        output: where the document goes; left out: docs/accuracy.md for a whole budget.
    """
    chosen = {name: STAGES[name] for name in stages or STAGES}
    outcomes = []
    for name, stage in chosen.items():
        print(f"== {name}: {stage.title}", flush=True)
        begun = time.perf_counter()
        outcomes.append(run_stage(name, stage, partial(print, flush=True)))
        print(f"  {time.perf_counter() - begun:.0f} s", flush=True)
    if output is None and not stages:
        output = Path(__file__).resolve().parents[1] / "docs" / "accuracy.md"
    if output is not None:
        text = document(outcomes, facts())
        if output.exists():
            # The section that tools/dusk.py writes is none of the budget's.
            kept = section_of(output.read_text("utf-8"))
            text = with_section(text, kept) if kept else text
        write_atomic(output, text.encode())
        print(f"wrote {output}")
    return sum(bool(outcome.failure) for outcome in outcomes)


SECTIONS: dict[str, Callable[[], None]] = {
    "physics": physics,
    "table": table,
    "frames": frames,
    "figures": figures,
    "volume": volume,
    "startup": startup,
}


def main() -> int:
    """Read the command line and print what it asks for; give the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [*SECTIONS, "budget"]
    parser.add_argument("section", nargs="*", help=f"one of {', '.join(names)}")
    parser.add_argument("--stage", action="append", default=[], choices=list(STAGES))
    parser.add_argument("-o", "--output", type=Path, help="where the budget's document goes")
    given = parser.parse_args()
    for section in given.section:
        if section not in names:
            parser.error(f"{section}: no such section; must be one of {', '.join(names)}")
    if (given.stage or given.output) and given.section != ["budget"]:
        parser.error("--stage and --output go with the section budget")
    failed = 0
    for section in given.section or [name for name in SECTIONS if name != "figures"]:
        if section == "budget":
            failed += budget(given.stage, given.output)
            continue
        print(f"== {section}")
        SECTIONS[section]()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
