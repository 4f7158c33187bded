"""Whole frames with a sky against the reference's."""

from __future__ import annotations

from collections.abc import Mapping

import rtbow
from rtbow.bench.error import colour_error, reference_xyz, sample_pixels
from skies import frames  # type: ignore[import-not-found]  # of the tests
from sky_error.row import Row, Rows

SIZE_PX = (640, 360)
SKY: Mapping[str, object] = {
    "camera.size_px": list(SIZE_PX), "atmosphere.sky": True, "ground.albedo": 0.1,
}  # fmt: skip
HAZY: Mapping[str, object] = {
    **SKY, "atmosphere.ozone_du": 300.0, "atmosphere.aerosol.model": "continental-clean",
    "render.max_delta_e": 2.0,
}  # fmt: skip
"""At the 0.5 that scenes have by themselves it is left to ``spectral``."""
_BOUND = 0.5


def small() -> Rows:
    """Frames of ``uniform`` that tests draw, all their pixels."""
    for said, cases in (("", frames.CLEAR_CASES), (" in haze", frames.HAZY_CASES)):
        for method in frames.METHODS:
            for case, changes in cases.items():
                found = frames.difference(method, changes)
                yield Row(f"`uniform`{said}, {case}, {method}: 99 %", found.p99, _BOUND, "ΔE2000")


def large(pixels: int) -> Rows:
    """Frames of ``curtain``, some of their pixels, against the reference at 1 nm.

    Args:
        pixels: how many are compared.
    """
    size = "x".join(map(str, SIZE_PX))
    cases = {"sky": SKY, "sky, haze": HAZY, "sky, rain dims": {**SKY, "droplets.extinction": True}}
    sample = sample_pixels(SIZE_PX, pixels)
    for case, changes in cases.items():
        scene = rtbow.load_scene("curtain", changes)
        with rtbow.Renderer(scene) as renderer:
            frame = renderer.render("fast")
        found = colour_error(sample.of(frame), reference_xyz(scene, sample))
        assert found is not None
        what = f"`curtain` {size}, {case}, fast, {len(sample)} pixels"
        yield Row(f"{what}: median", found.delta_e.median, None, "ΔE2000")
        yield Row(f"{what}: 99 %", found.delta_e.p99, _BOUND, "ΔE2000")
