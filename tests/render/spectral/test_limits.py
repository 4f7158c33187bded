"""What method ``spectral`` says of scenes that are beyond the GL device: the device is to blame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import pytest

from rtbow.base.errors import UnavailableError
from rtbow.gl.context import GlContext, open_context
from rtbow.render.spectral.method import SpectralMethod
from rtbow.scene.model import Scene
from rtbow.world.world import resolve

SUN = {"type": "sun", "altitude_deg": 20.0}
MIXTURE = {"distribution": "gamma", "mixing": "local", "effective_radius_um": 10.0,
           "effective_variance": 0.02}  # fmt: skip


@pytest.fixture
def context() -> Iterator[GlContext]:
    context = open_context("osmesa")
    yield context
    context.close()


def make(lights: int = 1, step_nm: float = 40.0, **droplets: Any) -> Scene:
    drops: Mapping[str, Any] = {
        "box_m": [[-50.0, 10.0, 0.0], [50.0, 90.0, 60.0]],
        "grid": [4, 4, 4],
        "radius": {"distribution": "constant", "radius_um": 10.0},
        "density": {"number_per_m3": 1e4},
    }
    parts = {
        "camera": {"size_px": [8, 6], "fov_deg": 20.0, "altitude_deg": 20.0},
        "light": [SUN] * lights,
        "droplets": {**drops, **droplets},
        "render": {"wavelength_step_nm": step_nm},
    }
    return Scene.model_validate(parts)


@pytest.mark.parametrize(
    ("scene", "limits", "message"),
    [
        pytest.param(
            make(), {"texture_2d": 7}, r"size_px = \[8, 6\]; this GL device .* up to 7 ",
            id="frame",
        ),
        pytest.param(
            make(), {"texture_3d": 3}, r"grid \(4, 4, 4\); this GL device .* up to 3 ", id="grid"
        ),
        pytest.param(
            make(), {"texture_2d": 10}, r"= 40; gives 11 wavelengths, .* up to 10; .*larger step",
            id="wavelengths",
        ),
        pytest.param(
            make(radius=MIXTURE), {"layers": 10}, r"11 wavelengths, .* up to 10 layers",
            id="sections",
        ),
        pytest.param(
            make(lights=3, extinction=True), {"texture_3d": 50}, r"3 lights .* up to 2; use fewer",
            id="depths",
        ),
    ],
)  # fmt: skip
def test_a_device_that_takes_less(context, scene, limits, message):
    with context.current():
        SpectralMethod(context, resolve(scene))  # and so it is the limit alone
        context.limits = replace(context.limits, **limits)
        with pytest.raises(UnavailableError, match=message) as caught:
            SpectralMethod(context, resolve(scene))
    assert "--method reference" in str(caught.value)
