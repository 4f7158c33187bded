"""Measure the time and the error of each approximation of method ``fast``, one at a time.

A scene is drawn with the settings of its ``render.max_delta_e``, and with each number made coarser
and finer. Errors are against the same method with every number as fine as is sensible. Prints a
table.

    python tools/fast_error.py shower default figures/fig5d lamp-shower [--size 640x360]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace
from unittest.mock import patch

import numpy as np

import rtbow
from rtbow.base.arrays import Array, floats
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.render.fast.tolerance import FastSettings, Kind, settings_for
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene

_FINEST = {
    "samples_per_cell": 4.0, "block": 0, "lamp_block": 0, "texels_per_disc": 24.0,
    "texels_per_fringe": 12.0, "wavelength_step_nm": 1.0, "row_step": 0.01, "rows_per_fold": 100.0,
    "colour": 1e-4, "lamp_scale": 4.0,
}  # fmt: skip
_FRAMES = 5


def drawn(scene: Scene, changes: dict[str, float]) -> tuple[Array, float]:
    """Draw a scene with some settings changed: X, Y, Z and the median time of a frame, ms."""

    def changed(delta_e: float, kind: Kind) -> FastSettings:
        return replace(settings_for(delta_e, kind), **changes)  # type: ignore[arg-type]  # by name

    with patch("rtbow.render.fast.shared.settings_for", changed), rtbow.Renderer(scene) as renderer:
        frame = rgb_to_xyz(floats(renderer.render("fast")))
        times = []
        for _ in range(_FRAMES):
            begun = time.perf_counter()
            renderer.draw("fast")
            times.append(time.perf_counter() - begun)
    return frame, 1e3 * float(np.median(times))


def variations(own: FastSettings) -> Iterator[dict[str, float]]:
    """Settings that differ from a scene's own in one number, by factors of two."""
    yield {}
    names = ["samples_per_cell", "bend", "texels_per_disc", "wavelength_step_nm", "rows_per_fold",
             "lamp_bend", "lamp_scale"]  # fmt: skip
    for name in names:
        for factor in (0.5, 2.0):
            yield {name: factor * float(getattr(own, name))}
    for block in (0, 2, 4, 8):
        yield {"block": block, "lamp_block": block}


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--size", default="640x360")
    given = parser.parse_args()
    size = [int(side) for side in given.size.split("x")]
    from rtbow.render.fast.columns import kind_of
    from rtbow.world.rain.volume import build_volume

    for name in given.scenes:
        scene = load_scene(name, {"camera.size_px": size})
        kind = kind_of(build_volume(scene.droplets))
        own = settings_for(scene.render.max_delta_e, kind)
        fine = {**_FINEST, "samples_per_log_radius": 4.0 * own.samples_per_log_radius}
        truth, _ = drawn(scene, fine)
        print(f"{name}, {given.size}, {kind}: ms, CIEDE2000 median, 99 %, worst")
        for changes in variations(own):
            frame, ms = drawn(scene, changes)
            error = frame_difference(frame, truth).delta_e
            print(f"  {ms:8.1f} {error.median:8.3f} {error.p99:8.3f} {error.worst:8.3f}  {changes}")


if __name__ == "__main__":
    main()
