"""What a sky costs: a first picture, a moved sun, a frame."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import numpy as np

import rtbow
from sky_error.frames import HAZY, SKY
from sky_error.row import Row, Rows
from steady import process_seconds, with_sun_at

_SUNS_DEG = (40.0, 30.0, 20.0, 12.0, 8.0)


def moved() -> Rows:
    """Work for one core that another sun makes: what a frame of it takes more than the next one."""
    for case, changes in (("no sky", _without()), ("sky", SKY), ("sky, haze", HAZY)):
        scene, took = rtbow.load_scene("curtain", changes), []
        with rtbow.Renderer(scene) as renderer:
            renderer.draw("fast")
            for again in range(2):  # tables for stretches of air are made in the first round
                for altitude in _SUNS_DEG:
                    there = with_sun_at(scene, altitude + 0.1 * again)
                    begun = time.process_time()
                    renderer.show(there)
                    renderer.draw("fast")
                    shown = time.process_time()
                    renderer.draw("fast")
                    took.append(2.0 * shown - begun - time.process_time())
        last = took[len(_SUNS_DEG) :]
        yield Row(f"a moved sun, {case}: least", min(last), unit="s")
        yield Row(f"a moved sun, {case}: most", max(last), unit="s")


def start() -> Rows:
    """Whole processes of ``rtbow render curtain`` without a sky and with one."""
    for case, changes in (("no sky", _without()), ("sky", SKY), ("sky, haze", HAZY)):
        own, other = _words(changes), _words({**changes, "ground.albedo": 0.2})
        runs = [("with an empty cache", own), ("warm", own)]
        if changes.keys() != _without().keys():
            runs.append(("with another ground", other))
        with tempfile.TemporaryDirectory() as folder:
            cache, output = Path(folder) / "cache", Path(folder) / "a.exr"
            for said, words in runs:
                seconds = process_seconds(cache, output, *words)
                yield Row(f"a picture of `curtain`, {case}, {said}", seconds, unit="s")


def cost(runs: int) -> Rows:
    """Frames of ``curtain`` with and without a sky, one after the other.

    Args:
        runs: how many of each; the least time counts.
    """
    dim = {"droplets.extinction": True}
    cases = {
        f"{case}{said}": {**changes, **more}
        for said, more in (("", {}), (", rain dims", dim))
        for case, changes in (("no sky", _without()), ("sky", SKY), ("sky, haze", HAZY))
    }
    took: dict[str, list[float]] = {case: [] for case in cases}
    with ExitStack() as stack:
        renderers = {
            case: stack.enter_context(rtbow.Renderer(rtbow.load_scene("curtain", changes)))
            for case, changes in cases.items()
        }
        for renderer in renderers.values():
            renderer.draw("fast")
        for _ in range(runs):
            for case, renderer in renderers.items():
                begun = time.perf_counter()
                renderer.draw("fast")
                took[case].append(time.perf_counter() - begun)
        device = next(iter(renderers.values())).gl_renderer
    for case, seconds in took.items():
        what = f"a frame of `curtain` by fast, {case}, least of {runs}, {device}"
        yield Row(what, 1e3 * float(np.min(seconds)), unit="ms")


def _without() -> Mapping[str, object]:
    """The scene without a sky, of the same size."""
    return {"camera.size_px": SKY["camera.size_px"]}


def _words(changes: Mapping[str, object]) -> list[str]:
    """Write changes as words of a command line."""
    settings = [
        f"{key}={str(value).lower() if isinstance(value, bool) else value}"
        for key, value in changes.items()
        if key != "camera.size_px"
    ]
    return ["curtain", *(word for setting in settings for word in ("--set", setting))]
