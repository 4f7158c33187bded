"""Measure the frame rate of the live window over a scripted minute, on a screen of its own.

    python tools/live_rate.py [SCENE] [--size 640x360] [--seconds 60]

The panel is open. For half of the time the mouse drags the view to and fro through the X server;
for the other half the sun goes up and down. Then, every two seconds while the mouse moves, a value
is changed for which tables are built anew, or a scene is opened or saved; this part measures the
longest time for which the window stops. Needs Xvfb. A picture counts when a newly rendered frame of
the scene has reached the screen.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "support"))

_SCREEN = (1600, 1000)
_AMPLITUDE_PX = (120.0, 40.0)
_PERIOD_S = 4.0
_SUN_DEG = (8.0, 32.0)
_GRACE_S = 120.0
_REBUILDS: tuple[dict[str, object], ...] = (
    {"scattering.theory": "mie"},
    {"light.0.spectrum": "FL2"},
    {"scattering.theory": "airy"},
    {"scattering.water_temperature_c": 5.0},
    {"droplets.extinction": True},
    {"scattering.orders": [1]},
    {"atmosphere.rayleigh": False},
    {"light.0.angular_diameter_deg": 1.0},
)
_MIXED = {"distribution": "normal", "mean_um": 300.0, "std_um": 30.0}
_REBUILD_S = 2.0
_MOUSE_S = 1.0 / 125.0
"""Between two reports of a usual mouse."""


def measure(name: str, size: tuple[int, int], seconds: float) -> None:
    """Print frame rates, render scales and the longest stop of the window."""
    from rtbow.scene.text.file import load_scene
    from rtbow.view.app import Viewer
    from rtbow.view.document.edits import Opened
    from screen import Hands, virtual_screen  # type: ignore[import-not-found]  # of the tests

    with virtual_screen(*_SCREEN) as screen:
        os.environ["DISPLAY"] = screen
        size_px = f"camera.size_px={list(size)}"
        scene = load_scene(name, {"camera.size_px": list(size)})
        viewer, hands = Viewer(Opened(scene, name, (size_px,))), Hands(screen)
        end = time.perf_counter() + _GRACE_S
        while not viewer.settled and time.perf_counter() < end:
            viewer.step()
        left, top, width, height = viewer.stage.view_units() or (0.0, 0.0, 1.0, 1.0)
        middle = left + 0.5 * width, top + 0.5 * height
        # What the first move builds is no part of the rate.
        rest = time.perf_counter() + 5.0
        while time.perf_counter() < rest:
            viewer.step()

        def look(at: float) -> None:
            turn = 2.0 * np.pi * at / _PERIOD_S
            hands.move(
                middle[0] + _AMPLITUDE_PX[0] * np.sin(turn),
                middle[1] + _AMPLITUDE_PX[1] * np.sin(0.7 * turn),
            )

        def turn_sun(at: float) -> None:
            low, high = _SUN_DEG
            level = low + (high - low) * (0.5 - 0.5 * np.cos(2.0 * np.pi * at / _PERIOD_S))
            viewer.change({"light.0.altitude_deg": float(level)}, "turn")

        hands.move(*middle)
        viewer.step()
        hands.button(True)
        _report("looking", viewer, look, 0.5 * seconds)
        hands.button(False)
        _report("turning the sun", viewer, turn_sun, 0.5 * seconds)
        folder = Path(tempfile.mkdtemp())
        waiting: list[Callable[[], object]] = [partial(viewer.change, edit) for edit in _REBUILDS]
        waiting += [
            lambda: viewer.open_scene("uniform"),
            lambda: viewer.change({"droplets.radius.radius_um": 77.0}),
            lambda: viewer.change({"droplets.grid": [32, 32, 32], "droplets.radius": _MIXED}),
            lambda: viewer.save_frame((f"{folder}/a.exr", f"{folder}/a.png")),
            lambda: viewer.save_scene(f"{folder}/a.toml"),
            lambda: viewer.split(True),
            lambda: viewer.open_scene(name),
        ]
        count = len(waiting)

        def rebuild(at: float) -> None:
            if count - len(waiting) <= at / _REBUILD_S and waiting:
                problem = waiting.pop(0)()
                assert not problem, problem
            hands.move(middle[0] + 500.0 * (at % 0.2), middle[1])  # else it waits for something

        _report("changing what needs tables", viewer, rebuild, _REBUILD_S * count)
        frame = viewer.state.frame
        print(f"{name}, {size[0]}x{size[1]}, panel open, {frame.renderer if frame else 'no frame'}")
        hands.close()
        viewer.close()


def _report(what: str, viewer: object, act: Callable[[float], None], seconds: float) -> None:
    from rtbow.view.app import Viewer

    assert isinstance(viewer, Viewer)
    before, painted, stops, scales = viewer.state.frames_shown, viewer.painted, [], []
    begun = last = time.perf_counter()
    acted = begun - _MOUSE_S
    while last - begun < seconds:
        if last - acted >= _MOUSE_S:
            acted = last
            act(last - begun)
        viewer.step()
        now = time.perf_counter()
        stops.append(now - last)
        scales.append(viewer.state.scale)
        last = now
    frames = viewer.state.frames_shown - before
    print(
        f"{what}: {frames / seconds:.1f} frames/s,"
        f" window {(viewer.painted - painted) / seconds:.0f}/s,"
        f" scale {np.median(scales):.2f} ({min(scales):.2f} to {max(scales):.2f}),"
        f" longest stop {1e3 * max(stops):.0f} ms"
    )


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", nargs="?", default="shower")
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--seconds", type=float, default=60.0)
    given = parser.parse_args()
    width, height = (int(side) for side in given.size.split("x"))
    measure(given.scene, (width, height), given.seconds)


if __name__ == "__main__":
    main()
