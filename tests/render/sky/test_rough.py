"""Moves in haze: roughly, by the tables of before, or exactly, by others."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow

pytestmark = pytest.mark.slow

HAZE = {
    "camera.size_px": [32, 18], "camera.fov_deg": 100.0, "atmosphere.rayleigh": True,
    "atmosphere.aerosol.model": "custom", "atmosphere.aerosol.optical_depth_550": 0.2,
}  # fmt: skip


def hazy(altitude_deg: float):
    return rtbow.load_scene("uniform", {**HAZE, "light.0.altitude_deg": altitude_deg})


def test_a_rough_move_keeps_the_haze_and_the_next_call_mends_it():
    with rtbow.Renderer(hazy(35.0)) as renderer:
        renderer.render("fast")
        assert not renderer.is_rough
        for altitude in (30.0, 22.0):  # the first move makes tables for all places, of its sun
            renderer.show(hazy(altitude), roughly=True)
        rough = renderer.render("fast")
        assert renderer.is_rough
        renderer.show(hazy(22.0))
        exact = renderer.render("fast")
        assert not renderer.is_rough
    with rtbow.Renderer(hazy(22.0)) as renderer:
        fresh = renderer.render("fast")
    np.testing.assert_array_equal(exact, fresh)
    # The lower sun's light has a longer way through the haze: 2 and 2.67 times its depth of 0.2.
    assert rough.sum() / exact.sum() == pytest.approx(np.exp(0.2 * (2.67 - 2.0)), abs=0.03)


def test_without_haze_no_move_is_rough():
    changes = {"camera.size_px": [32, 18], "atmosphere.rayleigh": True}
    with rtbow.Renderer(rtbow.load_scene("uniform", changes)) as renderer:
        renderer.render("fast")
        moved = rtbow.load_scene("uniform", {**changes, "light.0.altitude_deg": 30.0})
        renderer.show(moved, roughly=True)
        renderer.render("fast")
        assert not renderer.is_rough
