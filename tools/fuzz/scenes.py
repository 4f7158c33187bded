"""Fuzzes frames: scenes of extremes, drawn by method auto."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from fuzz.extremes import Cost, scene_text
from fuzz.harness import refusal
from fuzz.volumes import sound_volume
from rtbow import Renderer, RtbowError, load_scene

suffix = ".toml"
seconds = 300.0
mebibytes = 6144


def make(seed: int, cost: Cost = "airy") -> bytes:
    """Draw a scene."""
    return scene_text(np.random.default_rng([seed, 71]), cost).encode()


def attempt(path: Path) -> str:
    """Draw a frame, which must be finite; the volumes that the scene names are made beside it."""
    for number in re.findall(r"volume-(\d+)\.npz", path.read_text("utf-8")):
        volume = path.with_name(f"volume-{number}.npz")
        if not volume.exists():
            volume.write_bytes(sound_volume(np.random.default_rng(int(number))))
    try:
        with Renderer(load_scene(path)) as renderer:
            frame = renderer.render()
            assert np.all(np.isfinite(frame)), "the frame is not finite"
            return f"drawn by {renderer.method_used}"
    except RtbowError as error:
        return refusal(error, 12, 1200)
