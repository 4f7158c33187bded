"""How far Airy's theory is from exact theory, as bows that are seen."""

from __future__ import annotations

from typing import Any

import numpy as np

from budget.strips import reference_strip, strip_angles, strip_scene, table_strip
from rtbow.arrays import Array
from rtbow.colour_difference import FrameDifference, frame_difference
from rtbow.error_budget import Measurement, Note, Row, Stage

RADII_UM = (10, 20, 50, 100, 200, 300, 500, 700, 1000, 1500)
BAND_DEG = (130.0, 145.0)
_LEVELS = (5.0, 2.0, 1.0)
SPREAD = 0.02

Drops = dict[str, Any]


def one_size(radius_um: float) -> Drops:
    """Give the overrides for drops of one radius."""
    return {"droplets.radius": {"distribution": "constant", "radius_um": float(radius_um)}}


def narrow(radius_um: float) -> Drops:
    """Give those for the spread of sizes that exact theory has about its one radius."""
    radius = {"distribution": "lognormal", "median_um": float(radius_um), "log_std": SPREAD}
    return {"droplets.radius": {**radius, "mixing": "local"}}


def gamma(radius_um: float) -> Drops:
    """Give those for a gamma distribution of effective variance 0.1."""
    radius = {"distribution": "gamma", "effective_radius_um": float(radius_um)}
    return {"droplets.radius": {**radius, "effective_variance": 0.1, "mixing": "local"}}


def strip(theory: str, drops: Drops, theta: Array) -> Array:
    """Render a strip at 5 nm by a theory: X, Y, Z (n, 3)."""
    scene = strip_scene({"scattering.theory": theory, **drops})
    if theory == "airy":
        return reference_strip(scene, theta)
    # The series itself takes minutes per radius; the stage `table` says what its table adds.
    return table_strip(scene, theta)


def without_background(xyz: Array, exact: Array, theta: Array) -> FrameDifference:
    """Give the difference over the band of the primary alone."""
    degrees = np.degrees(theta)
    band = (degrees >= BAND_DEG[0]) & (degrees <= BAND_DEG[1])
    return frame_difference(xyz[band], exact[band])


def measure() -> Measurement:
    """Compare both theories over the radius, for one size and for mixtures."""
    theta = strip_angles()
    kinds = (
        ("one radius", one_size, one_size),
        ("one radius, Airy with exact theory's 2 % spread", narrow, one_size),
        ("gamma, effective variance 0.1", gamma, gamma),
    )
    band = f"{BAND_DEG[0]:g}-{BAND_DEG[1]:g}°"
    exact_of: dict[str, Array] = {}
    for label, airy_drops, exact_drops in kinds:
        whole: list[tuple[int, float]] = []
        near: list[tuple[int, float]] = []
        for radius in RADII_UM:
            drops = exact_drops(radius)
            key = repr(drops)
            if key not in exact_of:
                exact_of[key] = strip("mie", drops, theta)
            exact = exact_of[key]
            airy = strip("airy", airy_drops(radius), theta)
            everywhere = frame_difference(airy, exact)
            headline = radius == 500 and airy_drops is one_size
            yield Row(f"{label}, {radius} µm", "strip", everywhere, headline=headline)
            part = without_background(airy, exact, theta)
            yield Row(f"– {band} only", f"strip, {band}", part)
            whole.append((radius, everywhere.delta_e.p99))
            near.append((radius, part.delta_e.p99))
        yield Note(f"{label}, whole strip: {_falls_under(whole)}.")
        yield Note(f"{label}, {band}: {_falls_under(near)}.")
    yield _why(theta, exact_of[repr(one_size(1000))])


def _falls_under(found: list[tuple[int, float]]) -> str:
    """Say from which radius on the 99th percentile stays under each level."""
    parts = []
    for level in _LEVELS:
        held = None
        for radius, value in reversed(found):
            if value >= level:
                break
            held = radius
        parts.append(f"under {level:g} " + (f"from {held} µm on" if held else "nowhere"))
    least = min(found, key=lambda pair: pair[1])
    return f"the 99th percentile of ΔE is {', '.join(parts)}; least {least[1]:.1f} at {least[0]} µm"


def _why(theta: Array, exact: Array) -> Note:
    """Say what Airy's theory lacks outside of the bows, in numbers."""
    degrees = np.degrees(theta)
    peak = float(exact[(degrees > 136.0) & (degrees < 142.0), 1].max())
    airy = strip("airy", one_size(1000), theta)
    shares = []
    for name, low, high in (
        ("90-120°", 90.0, 120.0), ("Alexander's band, 131-136°", 131.0, 136.0),
        ("145-165°", 145.0, 165.0), ("165-180°", 165.0, 180.0),
    ):  # fmt: skip
        part = (degrees >= low) & (degrees <= high)
        both = (float(np.median(v[part, 1])) / peak for v in (exact, airy))
        exact_share, airy_share = both
        shares.append(f"{name}: {100 * exact_share:.2f} % against {100 * airy_share:.2f} %")
    return Note(
        "What is missing: median luminance at 1000 µm over the primary's peak, exact against Airy:"
        f" {'; '.join(shares)}. Light reflected from the drops' surface and that of higher orders"
        " is no bow and not in Airy's theory; and far inside the primary Airy's formula is used"
        " beyond where it was derived."
    )


THEORY = Stage(
    "Theory: Airy against exact",
    "Strips at 5 nm by Airy's theory, evaluated itself, and by exact Lorenz-Mie theory, "
    "from its table. Exact theory has 2 % of spread about its one radius; Airy's one "
    "radius is one.",
    measure,
)
