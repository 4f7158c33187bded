"""Draw the small pictures of the built-in scenes that the live window's list shows.

    python tools/make_thumbnails.py [SCENE]...

Without arguments, all of them, to ``scenes/thumbnails``; run it again when a scene changes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import rtbow
from rtbow.frames.display import auto_exposure_ev, display
from rtbow.frames.image import write_png
from rtbow.scene.panorama import PANORAMA
from rtbow.scene.text.file import builtin_scenes

FOLDER = Path(__file__).resolve().parents[1] / "scenes" / "thumbnails"
SIZE_PX = (128, 72)
SAMPLES = 3
"""Pixels along each side of one of the picture's, whose mean it is."""


def thumbnail(name: str) -> NDArray[np.uint8]:
    """Give a scene's picture, 8 bit sRGB; the middle of a panorama's."""
    width, height = SIZE_PX
    whole = rtbow.load_scene(name).camera.projection == PANORAMA
    size = [(2 * height if whole else width) * SAMPLES, height * SAMPLES]
    with rtbow.Renderer(rtbow.load_scene(name, {"camera.size_px": size})) as renderer:
        rgb = renderer.render()
    beside = (size[0] - width * SAMPLES) // 2
    rgb = rgb[:, beside : beside + width * SAMPLES]
    small = rgb.reshape(height, SAMPLES, width, SAMPLES, 3).mean(axis=(1, 3), dtype=np.float64)
    return display(small, auto_exposure_ev(small))


def main() -> int:
    """Draw those named, or all; give the exit status."""
    for name in sys.argv[1:] or builtin_scenes():
        path = FOLDER / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_png(path, thumbnail(name), {})
        print(f"{path}: {path.stat().st_size} bytes", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
