"""What storing in fewer bits leaves: half floats in the section table, 8 bits in pictures."""

from __future__ import annotations

import numpy as np

import rtbow
from budget.error_budget import Measurement, Row, Stage
from budget.frames import SIZE, SIZE_NAME, frame
from budget.strips import DISC_RAD
from rtbow.base.arrays import Array, floats
from rtbow.frames.difference import frame_difference
from rtbow.frames.display import auto_exposure_ev, display, gamut_map, max_luminance, srgb_encode
from rtbow.physics.light.colour import rgb_to_xyz, xyz_to_rgb
from rtbow.tables.layout import _HALF_MAX, RadiusAxis, angle_axis, row_sections
from rtbow.tables.sections import water_sections
from rtbow.world.optics import scene_optics

_RADII_UM = (10.0, 100.0, 300.0, 700.0, 1500.0)


def measure() -> Measurement:
    """Measure rounding in textures and in pictures."""
    yield from _half_floats()
    yield from _pictures()


def _half_floats() -> Measurement:
    scene = rtbow.load_scene("uniform", {"render.wavelength_step_nm": 20.0})
    optics = scene_optics(scene)
    sections = water_sections("mie", optics.wavelength_nm, 20.0, (_RADII_UM[0], _RADII_UM[-1]))
    rows = RadiusAxis(floats(_RADII_UM) * 1e-6, None)
    for disc, disc_name in ((DISC_RAD, "sun's disc"), (0.0, "no disc")):
        for low, sight in ((90.0, "bows in view"), (0.0, "the sun in view as well")):
            axis = angle_axis(np.radians(low), np.pi, disc, _RADII_UM[-1] * 1e-6)
            theta = axis.angles()
            # Every eighth angle: rounding is the same everywhere.
            kept = np.unique(np.concatenate([[0], np.arange(len(theta) - 1, 0, -8)]))
            both = row_sections(sections, rows, theta[kept], disc).mean(axis=3)
            rounded = as_halves(both)
            behind = theta[kept] >= 0.5 * np.pi
            for k, radius in enumerate(_RADII_UM):
                frames = [v[k][:, behind].T @ optics.sun_weights[0] for v in (rounded, both)]
                headline = disc > 0.0 and low == 90.0 and radius == 300.0
                yield Row(
                    f"half floats, {disc_name}, {sight}, {radius:g} µm",
                    "table's nodes, 90-180°, 20 nm", frame_difference(*frames), headline=headline,
                )  # fmt: skip


def as_halves(values: Array) -> Array:
    """Round values as a section table in half floats does: after scaling the greatest down."""
    scale = max(float(values.max()) / _HALF_MAX, 1.0)
    return floats((values.astype(np.float32) / scale).astype(np.float16)) * scale


def decoded(codes: Array) -> Array:
    """Give linear Rec. 709 of sRGB code values in 0..1 (IEC 61966-2-1)."""
    return floats(np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4))


def _pictures() -> Measurement:
    for name in ("uniform", "default"):
        scene = rtbow.load_scene(name, {"camera.size_px": SIZE})
        rgb = xyz_to_rgb(frame(scene, "spectral"))
        exposure = auto_exposure_ev(rgb)
        shown = gamut_map(rgb / max_luminance(exposure))
        where = f"`{name}`, {SIZE_NAME}, automatic exposure"
        dithered = decoded(display(rgb, exposure).astype(np.float64) / 255.0)
        plain = decoded(np.round(255.0 * srgb_encode(shown)) / 255.0)
        truth = rgb_to_xyz(shown)
        yield Row(
            "8 bits, rounded", where, frame_difference(rgb_to_xyz(plain), truth)
        )  # fmt: skip
        yield Row(
            "8 bits, dithered as `.png` is", where, frame_difference(rgb_to_xyz(dithered), truth),
            headline=name == "default",
        )  # fmt: skip
        radiance = rgb_to_xyz(rgb / max_luminance(exposure))
        yield Row(
            "colours brought into sRGB, no rounding", where, frame_difference(truth, radiance)
        )
    yield (
        "Against the picture before rounding. The last kind of row is no error of the radiance but"
        " what a display of sRGB cannot show; `.exr` keeps it."
    )


STORAGE = Stage(
    "Storage",
    "Rounding of the exact theory's section table to half floats, as large tables are "
    "stored, at its nodes; and of pictures to 8 bits.",
    measure,
)
