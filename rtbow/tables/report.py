"""What `rtbow table build` and `rtbow table info` report: time, size and measured error."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Progress, no_progress
from rtbow.base.cache import FOLDER_VARIABLE, cache_dir
from rtbow.base.errors import InputError
from rtbow.base.limits import MAX_RADIUS_UM, SIZE_SPREADS, TABLE_RADII_UM
from rtbow.physics.constants import SUN_DIAMETER_DEG
from rtbow.physics.drop.airy import RADIUS_POWER, SCALE_POWER, Bow, airy_squared, bow
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.disc import disc_mean
from rtbow.tables.airy import AiryTable, airy_table, build_airy_table, near_z_high
from rtbow.tables.mie.build import build_mie_table, kept_table
from rtbow.tables.mie.lookup import standard_axes
from rtbow.tables.mie.store import range_candidates

RADII_UM = (10.0, 1500.0)


@dataclass(frozen=True)
class LookupErrors:
    """Errors of look-ups against direct evaluation, relative to each bow's own peak.

    Attributes:
        radius_um: (n,).
        theta_deg: (n,).
        error: (n,), signed.
    """

    radius_um: Array
    theta_deg: Array
    error: Array


def describe_build() -> str:
    """Build the table anew, then once through the cache, and say how long it took."""
    begun = time.perf_counter()
    build_airy_table()
    built = time.perf_counter() - begun
    airy_table()  # keeps it in the cache, where that can be
    begun = time.perf_counter()
    table = airy_table()
    loaded = time.perf_counter() - begun
    size = sum(a.nbytes for a in (table.near, table.fringe, table.pole))
    return f"airy: built in {built:.2f} s, ready in {loaded:.3f} s, {size / 1024:.0f} KiB"


def describe_mie_build(
    spread_percent: float,
    max_radius_um: float,
    progress: Progress = no_progress,
    workers: int | None = None,
    scheduler: str | None = None,
) -> str:
    """Build a table of exact theory, and say how long it took (see :func:`build_mie_table`).

    Raises:
        InputError: a spread or radius out of range.
    """
    least, most = (100.0 * spread for spread in SIZE_SPREADS)
    if not least <= spread_percent <= most:  # NaN too
        raise InputError(
            f"--spread: {spread_percent:g} is not allowed; must be {least:g}..{most:g} percent"
        )
    low = TABLE_RADII_UM[0]
    if not 10.0 <= max_radius_um <= MAX_RADIUS_UM:
        raise InputError(
            f"--max-radius-um: {max_radius_um:g} is not allowed; must be 10..{MAX_RADIUS_UM:g} µm"
        )
    begun = time.perf_counter()
    axes = standard_axes(round(spread_percent / 100.0, 9))
    # One of the ranges that scenes look for.
    ends = range_candidates((low, max_radius_um))[0]
    table = build_mie_table(axes, ends, progress, workers, scheduler)
    took = time.perf_counter() - begun
    if kept_table(axes, ends) is None:
        raise InputError(
            f"{cache_dir()}: the table was built and cannot be kept there; free some space, or set"
            f" {FOLDER_VARIABLE} to another folder"
        )
    return (
        f"mie: {ends[0]:g}-{ends[1]:g} um, spread {spread_percent:g} %, ready in {took:.1f} s,"
        f" {'x'.join(map(str, table.values.shape))} values, {table.values.nbytes / 2**20:.0f} MiB"
    )


def direct_cross_section(the_bow: Bow, radius_m: float, theta_rad: float, disc_rad: float) -> float:
    """Evaluate one bow at one wavelength directly: Airy's function and the disc on the sphere.

    Args:
        the_bow: a bow of one wavelength.
        radius_m: drop radius.
        theta_rad: scattering angle.
        disc_rad: angular radius of the light's disc.

    Returns:
        |S|²/k² in m² sr⁻¹, mean of both components.
    """
    scale = float(the_bow.scale[0]) * radius_m**SCALE_POWER
    # The phase across the disc grows with the angle into the bright side; pi bounds it.
    count = 24 + int(1.2 * scale**1.5 * disc_rad * np.sqrt(np.pi))

    def section(angles: Array) -> Array:
        return airy_squared(scale * the_bow.side * (angles - the_bow.angle_rad[0]))

    mean = float(disc_mean(section, theta_rad, disc_rad, count))
    return float(the_bow.strength[0] * radius_m**RADIUS_POWER * mean)


def lookup_errors(
    table: AiryTable, disc_deg: float, count: int, rng: np.random.Generator
) -> LookupErrors:
    """Compare look-ups with direct evaluation at random radii, wavelengths, angles and orders.

    A third of the angles lies around the bows, a sixth where the table's two forms meet, a tenth
    within ten disc radii of the poles: where the table works hardest.
    """
    disc_rad = np.radians(0.5 * disc_deg)
    radius = np.exp(rng.uniform(np.log(RADII_UM[0]), np.log(RADII_UM[1]), count))
    nm = rng.uniform(380.0, 780.0, count)
    theta = rng.uniform(0.0, np.pi, count)
    kind = rng.random(count)
    theta = np.where(kind < 0.33, np.radians(rng.uniform(118.0, 150.0, count)), theta)
    theta = np.where(kind > 0.9, 10.0 * disc_rad * rng.random(count) ** 2, theta)
    theta = np.where(kind > 0.95, np.pi - theta, theta)
    error = np.empty(count)
    for n in range(count):
        index = relative_index(nm[n : n + 1], 20.0)
        the_bow = bow(1 + n % 2, nm[n : n + 1] * 1e-9, index)
        a = radius[n : n + 1] * 1e-6
        if 0.33 <= kind[n] < 0.5:
            # Where the table's two forms meet.
            scale = float(the_bow.scale[0] * a[0] ** SCALE_POWER)
            seam = near_z_high(scale * disc_rad) * rng.uniform(0.95, 1.05)
            there = the_bow.angle_rad[0] + the_bow.side * seam / scale
            theta[n] = there if 0.0 < there < np.pi else theta[n]
        # The bow's peak with this disc: a few z into the bright side, more for a wide disc.
        spread = float(the_bow.scale[0] * a[0] ** SCALE_POWER * disc_rad)
        z = np.linspace(-1.0, 3.0 + 1.5 * spread, 161)
        near = the_bow.angle_rad + the_bow.side * z / (the_bow.scale * a**SCALE_POWER)
        peak = table.cross_section(the_bow, the_bow.strength, a, near, disc_rad).max()
        looked = table.cross_section(the_bow, the_bow.strength, a, theta[n : n + 1], disc_rad)
        direct = direct_cross_section(the_bow, float(a[0]), float(theta[n]), float(disc_rad))
        error[n] = (looked[0, 0, 0] - direct) / peak
    return LookupErrors(radius, np.degrees(theta), error)


def describe_table(samples: int) -> Iterator[str]:
    """Yield lines about the table's arrays, its build time and its measured errors."""
    table = airy_table()
    for name in ("near", "fringe", "pole"):
        array = getattr(table, name)
        yield f"{name:<8}{'x'.join(map(str, array.shape)):<14}{array.nbytes / 1024:8.0f} KiB"
    yield describe_build()
    yield (
        f"look-up against direct evaluation, {RADII_UM[0]:g}-{RADII_UM[1]:g} um, 380-780 nm,"
        f" 0-180 deg, share of the bow's own peak, {samples} random points:"
    )
    for disc_deg in (0.0, SUN_DIAMETER_DEG, 2.0, 5.0):
        errors = lookup_errors(table, disc_deg, samples, np.random.default_rng(7))
        size = np.abs(errors.error)
        worst = int(size.argmax())
        yield (
            f"  disc {disc_deg:5.3f} deg: median {np.median(size):.1e}, 99 %"
            f" {np.quantile(size, 0.99):.1e}, worst {size[worst]:.1e}"
            f" (at {errors.radius_um[worst]:.0f} um, {errors.theta_deg[worst]:.2f} deg)"
        )
