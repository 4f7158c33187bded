"""Lamps and a sky: they light the drops alone, and nothing is solved for where there is no sun."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
import rtbow.world.sky
from rtbow.world.sky import Surroundings, surroundings_notes

AROUND = {"camera.size_px": [16, 9], "atmosphere.sky": True, "ground.albedo": 0.3,
          "render.wavelength_step_nm": 20.0}  # fmt: skip


@pytest.fixture
def no_field(monkeypatch):
    def fail(*_):
        raise AssertionError("a sky was solved for")

    monkeypatch.setattr(Surroundings, "field", fail)
    monkeypatch.setattr(rtbow.world.sky, "sky_field", fail)


@pytest.mark.parametrize("method", ["fast", "spectral", "reference"])
@pytest.mark.usefixtures("no_field")
def test_lamps_alone_solve_for_no_sky(method):
    with rtbow.Renderer(rtbow.load_scene("street-lamp", AROUND)) as renderer:
        frame = renderer.render(method)
    assert frame.max() > 0.0
    assert np.all(np.isfinite(frame))


def test_that_lamps_light_neither_air_nor_ground_is_said_once():
    said = ("lamps light the drops alone, not the air that glows nor the ground",)
    assert surroundings_notes(rtbow.load_scene("two-lamps", AROUND)) == said
    assert surroundings_notes(rtbow.load_scene("two-lamps", {"ground.albedo": 0.3})) == said
    assert surroundings_notes(rtbow.load_scene("two-lamps")) == ()
    assert surroundings_notes(rtbow.load_scene("uniform", AROUND)) == ()
    with rtbow.Renderer(rtbow.load_scene("two-lamps", AROUND)) as renderer:
        assert renderer.notes.count(said[0]) == 1
