"""Measure what a first frame costs, and whether time and memory stay constant over many frames.

    python tools/steady.py start [--runs 5]
    python tools/steady.py moving [SCENE] [--frames 2000] [--size 640x360]

``start`` times whole processes of ``rtbow render`` of the default scene at 640x360 to EXR, with an
empty cache and with a filled one. ``moving`` draws frames with the sun going up and down, one
move each, and reports their times and the memory that the process holds.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import rtbow
from rtbow.base.arrays import Array, floats
from rtbow.base.cache import FOLDER_VARIABLE
from rtbow.bench.memory import PeakMemory
from rtbow.scene.model import Scene

_PERIODS = 3
"""Ups and downs of the sun in the frames that count. One more goes before: tables for every stretch
of air are made in it, and the last few are kept."""
_ALTITUDES = (5.0, 45.0)
"""Degrees between which the sun goes."""
_STALL = 3.0
"""Times the median from which a frame counts as a stall."""


def process_seconds(cache: Path, output: Path, *words: str) -> float:
    """Time one ``rtbow render`` with a cache folder of its own, and more words on its command
    line."""
    options = ["-q", "--size", "640x360", "-o", str(output)]
    command = [sys.executable, "-m", "rtbow", "render", *words, *options]
    begun = time.perf_counter()
    subprocess.run(command, check=True, env={**os.environ, FOLDER_VARIABLE: str(cache)})
    return time.perf_counter() - begun


def start(runs: int) -> None:
    """Print the times of cold and warm starts."""
    cold, warm = [], []
    for _ in range(runs):
        with tempfile.TemporaryDirectory() as folder:
            cache, output = Path(folder) / "cache", Path(folder) / "a.exr"
            cold.append(process_seconds(cache, output))
            warm.append(process_seconds(cache, output))
    for name, seconds in (("cold", cold), ("warm", warm)):
        print(f"{name}: median {np.median(seconds):.2f} s of {runs}, worst {max(seconds):.2f} s")


def with_sun_at(scene: Scene, altitude_deg: float) -> Scene:
    """Give the scene with its first light at another altitude."""
    sun = scene.light[0].model_copy(update={"altitude_deg": altitude_deg})
    return scene.model_copy(update={"light": (sun, *scene.light[1:])})


def altitudes(frames: int, period: float) -> Array:
    """Give altitudes that go up and down once in each period of frames (frames,)."""
    low, high = _ALTITUDES
    phase = 2.0 * np.pi * np.arange(frames) / period
    return floats(low + (high - low) * (0.5 - 0.5 * np.cos(phase)))


def moving(name: str, frames: int, size_px: list[int]) -> None:
    """Print times and memory of frames under a moving sun."""
    scene = rtbow.load_scene(name, {"camera.size_px": size_px})
    times, moves, held = [], [], []
    warm_up = frames // _PERIODS
    with rtbow.Renderer(scene) as renderer:
        renderer.draw("fast")
        for altitude in altitudes(warm_up + frames, warm_up):
            moved = with_sun_at(scene, float(altitude))
            begun = time.perf_counter()
            renderer.show(moved)
            shown = time.perf_counter()
            renderer.draw("fast")
            times.append(1e3 * (time.perf_counter() - begun))
            moves.append(1e3 * (shown - begun))
            held.append(PeakMemory().start_mib or float("nan"))
        device = renderer.gl_renderer
    frame, move = floats(np.array(times[warm_up:])), floats(np.array(moves[warm_up:]))
    median = float(np.median(frame))
    print(f"{name}, {size_px[0]}x{size_px[1]}, {frames} frames, {device}")
    print(f"frame: median {median:.1f} ms, worst {frame.max():.1f} ms")
    print(f"frames over {_STALL:g} times the median: {int(np.sum(frame > _STALL * median))}")
    print(f"of which the move: median {np.median(move):.1f} ms, worst {move.max():.1f} ms")
    at = [warm_up, *(warm_up + frames * part // 4 - 1 for part in range(1, 5))]
    print("memory:", ", ".join(f"{held[k]:.1f} MiB after {k + 1} frames" for k in at))


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    first = verbs.add_parser("start")
    first.add_argument("--runs", type=int, default=5)
    second = verbs.add_parser("moving")
    second.add_argument("scene", nargs="?", default="curtain")
    second.add_argument("--frames", type=int, default=2000)
    second.add_argument("--size", default="640x360")
    given = parser.parse_args()
    if given.verb == "start":
        start(given.runs)
    else:
        moving(given.scene, given.frames, [int(side) for side in given.size.split("x")])


if __name__ == "__main__":
    main()
