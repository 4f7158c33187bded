"""What tables leave: look-ups against direct evaluation, for either theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from budget.error_budget import Measurement, Row, Stage
from budget.strips import reference_strip, strip_angles, strip_scene, table_strip
from rtbow.base.arrays import Array, floats
from rtbow.base.errors import UnavailableError
from rtbow.base.limits import TABLE_RADII_UM
from rtbow.frames.difference import Spread, frame_difference
from rtbow.physics.drop.water import relative_index
from rtbow.tables.airy import airy_table
from rtbow.tables.mie.average import mean_intensities
from rtbow.tables.mie.axes import COMPACT_FILE, DEFAULT_SPREAD
from rtbow.tables.mie.build import kept_table
from rtbow.tables.mie.lookup import MieSections, MieTable, resample, standard_axes
from rtbow.tables.mie.store import compact_table
from rtbow.tables.report import RADII_UM, lookup_errors
from rtbow.world.optics import scene_optics

_AIRY_POINTS = 1500
_MIE_DRAWS = 30
_ANGLES = 24
"""Per draw and region."""


@dataclass(frozen=True)
class Region:
    """Scattering angles among which errors are counted, degrees."""

    name: str
    low: float
    high: float


_REGIONS = (
    Region("around the bows, 120-150°", 120.0, 150.0),
    Region("everywhere beyond 20°, to 179°", 20.0, 179.0),
    Region("within 1° of the antisolar point", 179.0, 180.0),
)


@dataclass(frozen=True)
class Draw:
    """Intensities at one radius and wavelength, summed and looked up.

    Attributes:
        radius_um: the radius.
        direct: |S|²/x², mean of both components, (regions, angles).
        again: the same as direct, but for the sizes at which its mean over sizes is sampled.
        looked: the same from the table.
        peak: of the primary bow.
    """

    radius_um: float
    direct: Array
    again: Array
    looked: Array
    peak: float


def look_up(table: MieTable, x: float, m: float, theta: Array) -> Array:
    """Give |S|²/x², mean of both components, at angles (n,), by a table."""
    values = table.intensities(np.array([x]), m)[0].T
    places = table.axes.angle_places(theta, m)[:, None]
    return floats(resample(np.ascontiguousarray(values), places, np.ones_like(places)).mean(axis=1))


def draw(rng: np.random.Generator, table: MieTable) -> Draw:
    """Compare a table with direct sums at a random radius and wavelength."""
    axes = standard_axes(DEFAULT_SPREAD)
    radius = float(np.exp(rng.uniform(*np.log(RADII_UM))))
    nm = rng.uniform(380.0, 780.0)
    x = 2e3 * np.pi * radius / nm
    m = float(relative_index(np.array([nm]), 20.0)[0])
    theta = np.radians([np.sort(rng.uniform(r.low, r.high, _ANGLES)) for r in _REGIONS])
    # A second node, a part of a step below, moves the first sample and all that follow.
    both = [np.log(x) - 1e-4, np.log(x)]
    summed, again = (
        mean_intensities(axes, np.array(nodes), m, theta.ravel())[-1].mean(axis=0)
        for nodes in (both[1:], both)
    )
    looked = look_up(table, x, m, theta.ravel()).reshape(theta.shape)
    bow = look_up(table, x, m, np.radians(np.linspace(136.0, 150.0, 1401)))
    return Draw(
        radius, summed.reshape(theta.shape), again.reshape(theta.shape), looked, float(bow.max())
    )


def measure() -> Measurement:
    """Measure Airy's table, the exact one that ships, and what packing it lost."""
    yield from _airy()
    yield from _random_draws()
    yield from _strips()
    yield from _shipped_against(kept_table(standard_axes(DEFAULT_SPREAD), TABLE_RADII_UM))


def _airy() -> Measurement:
    table = airy_table()
    for disc in (0.0, 0.533):
        errors = lookup_errors(table, disc, _AIRY_POINTS, np.random.default_rng(7))
        spread = Spread.of(np.abs(errors.error))
        where = f"{_AIRY_POINTS} random points; of the bow's peak"
        yield Row(f"Airy, disc {disc:g}°", where, relative=spread)
    for radius in (10.0, 50.0, 200.0, 1000.0):
        theta = strip_angles()
        scene = strip_scene({"droplets.radius.radius_um": radius})
        difference = frame_difference(table_strip(scene, theta), reference_strip(scene, theta))
        yield Row(f"Airy, {radius:g} µm", "strip", difference, headline=radius == 200.0)
    size = sum(a.nbytes for a in (table.near, table.fringe, table.pole))
    yield f"Airy's table: {size / 2**20:.2f} MiB in memory, built in less than a second."


def _random_draws() -> Measurement:
    rng = np.random.default_rng(7)
    draws = [draw(rng, compact_table()) for _ in range(_MIE_DRAWS)]
    for k, region in enumerate(_REGIONS):
        error = np.array([np.abs(d.looked[k] - d.direct[k]) / d.peak for d in draws])
        where = f"{error.size} random points, no disc"
        yield Row(
            f"exact, {region.name}", f"{where}; of the primary's peak", relative=Spread.of(error)
        )
        again = np.array([np.abs(d.again[k] - d.direct[k]) / d.peak for d in draws])
        yield Row("– the direct sum again, at other sizes", where, relative=Spread.of(again))
        share = np.array([np.abs(d.looked[k] / d.direct[k] - 1.0) for d in draws])
        yield Row("– of the value itself", where, relative=Spread.of(share))
        worst = int(error.max(axis=1).argmax())
        yield f"Exact, {region.name}: worst at {draws[worst].radius_um:.0f} µm."


def _strips() -> Measurement:
    theta = strip_angles()
    for radius in (10.0, 30.0, 100.0):
        drops = {"scattering.theory": "mie", "droplets.radius.radius_um": radius}
        scene = strip_scene({**drops, "render.wavelength_step_nm": 20.0})
        truth = reference_strip(scene, theta)
        optics = scene_optics(scene)
        index = scene.scattering.medium.index(optics.wavelength_nm)
        sections = MieSections(compact_table(), optics.wavelength_nm * 1e-9, index)
        looked = table_strip(scene, theta, sections)
        for name, low, high in (("", 90.0, 180.0), (", 90-178°", 90.0, 178.0)):
            part = (np.degrees(theta) >= low) & (np.degrees(theta) <= high)
            difference = frame_difference(looked[part], truth[part])
            headline = radius == 100.0 and not name
            yield Row(f"exact, {radius:g} µm{name}", "strip, 20 nm", difference, headline=headline)


def _shipped_against(full: MieTable | None) -> Measurement:
    shipped = compact_table()
    size = (
        f"The exact table that ships: {COMPACT_FILE.stat().st_size} bytes, "
        f"{shipped.values.nbytes / 2**20:.0f} MiB in memory, {shipped.values.shape[1]} sizes,"
        f" {shipped.values.shape[0]} indices, {shipped.values.shape[3]} angles"
    )
    if full is None:  # rows that the document has had must not go without a word
        raise UnavailableError("build the full table first: rtbow table build --theory mie")
    yield f"{size}; the full one: {full.values.nbytes / 2**20:.0f} MiB."
    share = np.abs(shipped.values / full.values[:, : shipped.values.shape[1]] - 1.0)
    yield Row("exact, shipped against full table", "nodes; of the value", relative=Spread.of(share))
    theta = strip_angles()
    for radius in (20.0, 200.0, 1000.0):
        scene = strip_scene({"scattering.theory": "mie", "droplets.radius.radius_um": radius})
        optics = scene_optics(scene)
        wavelength, index = optics.wavelength_nm * 1e-9, relative_index(optics.wavelength_nm, 20.0)
        strips = [
            table_strip(scene, theta, MieSections(table, wavelength, index))
            for table in (shipped, full)
        ]
        yield Row(f"exact, shipped against full, {radius:g} µm", "strip", frame_difference(*strips))


TABLE = Stage(
    "Table interpolation",
    "Look-ups in float64 against direct evaluation of Airy's function and the Lorenz-Mie "
    "series, at random radii (10-1500 µm) and wavelengths (380-780 nm). In both, the series is "
    "averaged over 2 % of spread in size. That mean is sampled, and high orders have random "
    "phases: a direct sum at other samples shows how much of the error is due to the sums.",
    measure,
)
