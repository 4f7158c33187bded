"""Scenes drawn at random: valid, the same for a seed, and within method fast's error.

``rtbow bench random-1 random-2 …`` measures many of them; here a few that are quick.
"""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.bench.random_scenes import random_scene, random_seed, random_text
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference.render import radiance_along
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

SIZE = [64, 36]


def test_a_seed_draws_one_scene():
    assert random_text(7) == random_text(7)
    assert len({random_text(seed) for seed in range(60)}) == 60


def test_every_seed_is_a_scene():
    for seed in range(200):
        scene = random_scene(seed, {"camera.size_px": SIZE})
        assert scene.source_name == f"random-{seed}"


@pytest.mark.parametrize(
    ("name", "seed"),
    [("random-1", 1), ("random-123456", 123456), ("random-0", None), ("random-01", None),
     ("random-", None), ("random-1234567", None), ("random-1.toml", None), ("uniform", None),
     (None, None)],
)  # fmt: skip
def test_names(name, seed):
    assert random_seed(name) == seed


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 6, 13])
def test_fast_keeps_its_error(seed):
    scene = random_scene(
        seed,
        {"camera.size_px": SIZE, "camera.pixel": "centre", "render.wavelength_step_nm": 1.0},
    )
    rays = pixel_directions(scene.camera).reshape(-1, 3)
    picked = np.random.default_rng(seed).choice(len(rays), 200, replace=False)
    truth = radiance_along(resolve(scene), rays[picked])
    with rtbow.Renderer(scene) as renderer:
        frame = rgb_to_xyz(renderer.render("fast")).reshape(-1, 3)[picked]
    assert truth[:, 1].max() > 0.0
    assert frame_difference(frame, truth).delta_e.p99 <= scene.render.max_delta_e
