"""How far Airy's theory is from exact theory, as bows that are seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from budget.error_budget import Measurement, Row, Stage
from budget.strips import reference_strip, strip_angles, strip_scene, table_strip
from rtbow.base.arrays import Array
from rtbow.frames.difference import frame_difference

RADII_UM = (10, 20, 50, 100, 200, 300, 500, 700, 1000, 1500)
BAND_DEG = (130.0, 145.0)
_LEVELS = (5.0, 2.0, 1.0)
_BRIGHT = 0.1
_STEP_NM = 10.0
"""Both theories are sampled alike."""
SPREAD = 0.02

Drops = dict[str, Any]
Mask = NDArray[np.bool_]


def one_size(radius_um: float) -> Drops:
    """Give the overrides for drops of one radius."""
    return {"droplets.radius": {"distribution": "constant", "radius_um": float(radius_um)}}


def narrow(radius_um: float) -> Drops:
    """Give those for the spread of sizes that exact theory has about its one radius."""
    radius = {"distribution": "lognormal", "median_um": float(radius_um), "log_std": SPREAD}
    return {"droplets.radius": {**radius, "mixing": "local"}}


def gamma(radius_um: float, variance: float = 0.1) -> Drops:
    """Give those for a gamma distribution of some effective variance."""
    radius = {"distribution": "gamma", "effective_radius_um": float(radius_um)}
    return {"droplets.radius": {**radius, "effective_variance": variance, "mixing": "local"}}


def narrow_gamma(radius_um: float) -> Drops:
    """Give those for a gamma distribution that ends sooner."""
    return gamma(radius_um, 0.02)


def strip(theory: str, drops: Drops, theta: Array) -> Array:
    """Render a strip at 10 nm by a theory: X, Y, Z (n, 3)."""
    common = {"scattering.theory": theory, "render.wavelength_step_nm": _STEP_NM}
    scene = strip_scene({**common, **drops})
    if theory == "airy":
        return reference_strip(scene, theta)
    # The series itself takes minutes per radius; the stage `table` says what its table adds.
    return table_strip(scene, theta)


def parts(theta: Array, exact: Array) -> list[tuple[str, Mask]]:
    """Give the parts of a strip that are compared on their own."""
    degrees = np.degrees(theta)
    near = (degrees >= BAND_DEG[0]) & (degrees <= BAND_DEG[1])
    band = f"{BAND_DEG[0]:g}-{BAND_DEG[1]:g}°"
    bright = near & (exact[:, 1] > _BRIGHT * exact[near, 1].max())
    whole = np.ones(len(theta), dtype=bool)
    return [
        ("whole strip", whole),
        (band, near),
        (f"{band}, over {_BRIGHT:.0%} of its peak".replace("%", " %"), bright),
    ]


def measure() -> Measurement:
    """Compare both theories over the radius, for one size and for mixtures."""
    theta = strip_angles()
    kinds = (
        ("one radius", one_size, one_size, RADII_UM),
        ("one radius, Airy with 2 % spread", narrow, one_size, (20, 100, 300, 1000)),
        # Larger ones have drops beyond the table's 1500 µm, which would be built for each.
        ("gamma, effective variance 0.1", gamma, gamma, (10, 20, 50, 100, 200, 300)),
        ("gamma, effective variance 0.02", narrow_gamma, narrow_gamma, (100, 300, 500, 700)),
    )
    exact_of: dict[str, Array] = {}
    for label, airy_drops, exact_drops, radii in kinds:
        p99: dict[str, list[tuple[int, float]]] = {}
        for radius in radii:
            drops = exact_drops(radius)
            key = repr(drops)
            if key not in exact_of:
                exact_of[key] = strip("mie", drops, theta)
            exact = exact_of[key]
            airy = strip("airy", airy_drops(radius), theta)
            for name, mask in parts(theta, exact):
                difference = frame_difference(airy[mask], exact[mask])
                headline = radius == 300 and airy_drops is one_size and bool(mask.all())
                yield Row(f"{label}, {radius} µm", name, difference, headline=headline)
                p99.setdefault(name, []).append((radius, difference.delta_e.p99))
        for name, values in p99.items():
            yield f"{label[0].upper()}{label[1:]}, {name}: {_falls_under(values)}."
    yield (
        "Mixtures end where the exact table does: drops up to 1500 µm, which are 3.3 times the"
        " effective radius at a variance of 0.1."
    )
    yield _why(theta, exact_of[repr(one_size(1000))])


def _falls_under(p99: list[tuple[int, float]]) -> str:
    """Say from which radius on the 99th percentile stays under each level."""
    parts = []
    for level in _LEVELS:
        held = None
        for radius, value in reversed(p99):
            if value >= level:
                break
            held = radius
        parts.append(f"under {level:g} " + (f"from {held} µm on" if held else "nowhere"))
    radius, value = min(p99, key=lambda pair: pair[1])
    stays = ", ".join(parts)
    return f"the 99th percentile of ΔE stays {stays}; least {value:.1f} at {radius} µm"


def _why(theta: Array, exact: Array) -> str:
    """Say what Airy's theory lacks outside of the bows, in numbers."""
    degrees = np.degrees(theta)
    peak = float(exact[(degrees > 136.0) & (degrees < 142.0), 1].max())
    airy = strip("airy", one_size(1000), theta)
    shares = []
    for name, low, high in (
        ("90-120°", 90.0, 120.0), ("Alexander's band, 131-136°", 131.0, 136.0),
        ("139-145°", 139.0, 145.0),
        ("145-165°", 145.0, 165.0), ("165-180°", 165.0, 180.0),
    ):  # fmt: skip
        part = (degrees >= low) & (degrees <= high)
        exact_share, airy_share = (float(np.median(v[part, 1])) / peak for v in (exact, airy))
        shares.append(f"{name}: {100 * exact_share:.2f} % against {100 * airy_share:.2f} %")
    return (
        "What is missing: median luminance at 1000 µm over the primary's peak, exact against Airy:"
        f" {'; '.join(shares)}. Light reflected from the drops' surface, and that of higher"
        " orders, is no bow and not in Airy's theory; and away from a bow's edge its formula is"
        " used beyond where it was derived."
    )


THEORY = Stage(
    "Theory: Airy against exact",
    "Strips at 10 nm by Airy's theory, evaluated itself, and by exact Lorenz-Mie theory, "
    "from its table. Exact theory has 2 % of spread about its one radius; Airy's one "
    "radius is one.",
    measure,
)
