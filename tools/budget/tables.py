"""What tables leave: look-ups against direct evaluation, for either theory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from budget.strips import reference_strip, strip_angles, strip_scene, table_strip
from rtbow.arrays import Array, floats
from rtbow.colour_difference import Spread, frame_difference
from rtbow.error_budget import Measurement, Note, Row, Stage
from rtbow.mie_average import mean_intensities
from rtbow.mie_axes import DEFAULT_SPREAD
from rtbow.mie_build import kept_table
from rtbow.mie_store import COMPACT_FILE, compact_table
from rtbow.mie_table import TABLE_RADII_UM, MieSections, MieTable, resample, standard_axes
from rtbow.optics import scene_optics
from rtbow.table import airy_table
from rtbow.table_tools import RADII_UM, lookup_errors
from rtbow.water import relative_index

_AIRY_POINTS = 1500
_MIE_DRAWS = 40
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
        looked: the same from each table, (tables, regions, angles).
        peak: of the primary bow.
    """

    radius_um: float
    direct: Array
    looked: Array
    peak: float


def look_up(table: MieTable, x: float, m: float, theta: Array) -> Array:
    """Give |S|²/x², mean of both components, at angles (n,), by a table."""
    values = table.intensities(np.array([x]), m)[0].T
    places = table.axes.angle_places(theta, m)[:, None]
    return floats(resample(np.ascontiguousarray(values), places, np.ones_like(places)).mean(axis=1))


def draw(rng: np.random.Generator, tables: list[MieTable]) -> Draw:
    """Compare tables with direct sums at a random radius and wavelength."""
    axes = standard_axes(DEFAULT_SPREAD)
    radius = float(np.exp(rng.uniform(*np.log(RADII_UM))))
    nm = rng.uniform(380.0, 780.0)
    x = 2e3 * np.pi * radius / nm
    m = float(relative_index(np.array([nm]), 20.0)[0])
    theta = np.radians([np.sort(rng.uniform(r.low, r.high, _ANGLES)) for r in _REGIONS])
    summed = mean_intensities(axes, np.array([np.log(x)]), m, theta.ravel())[0].mean(axis=0)
    found = [look_up(table, x, m, theta.ravel()).reshape(theta.shape) for table in tables]
    bow = look_up(tables[0], x, m, np.radians(np.linspace(136.0, 150.0, 1401)))
    return Draw(radius, summed.reshape(theta.shape), np.stack(found), float(bow.max()))


def measure() -> Measurement:
    """Measure Airy's table, the exact table that ships, and the whole one where it was built."""
    yield from _airy()
    tables = {"shipped": compact_table()}
    full = kept_table(standard_axes(DEFAULT_SPREAD), TABLE_RADII_UM)
    if full is not None:
        tables["full"] = full
    yield from _random_draws(tables)
    yield from _strips(tables)
    yield from _shipped_against(full)


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
        found = frame_difference(table_strip(scene, theta), reference_strip(scene, theta))
        yield Row(f"Airy, {radius:g} µm", "strip", found, headline=radius == 200.0)
    size = sum(a.nbytes for a in (table.near, table.fringe, table.pole))
    yield Note(f"Airy's table: {size / 2**20:.2f} MiB in memory, built in less than a second.")


def _random_draws(tables: dict[str, MieTable]) -> Measurement:
    rng = np.random.default_rng(7)
    draws = [draw(rng, list(tables.values())) for _ in range(_MIE_DRAWS)]
    for t, name in enumerate(tables):
        for k, region in enumerate(_REGIONS):
            error = np.array([np.abs(d.looked[t, k] - d.direct[k]) / d.peak for d in draws])
            yield Row(
                f"exact, {name} table, {region.name}",
                f"{error.size} random points, no disc; of the primary's peak",
                relative=Spread.of(error),
            )
            worst = np.unravel_index(int(error.argmax()), error.shape)[0]
            share = np.array([np.abs(d.looked[t, k] / d.direct[k] - 1.0) for d in draws])
            yield Row(
                "– of the value itself",
                f"the same; the line above is worst at {draws[worst].radius_um:.0f} µm",
                relative=Spread.of(share),
            )


def _strips(tables: dict[str, MieTable]) -> Measurement:
    theta = strip_angles()
    for radius in (10.0, 30.0, 100.0):
        scene = strip_scene(
            {
                "scattering.theory": "mie",
                "droplets.radius.radius_um": radius,
                "render.wavelength_step_nm": 20.0,
            }
        )
        truth = reference_strip(scene, theta)
        optics = scene_optics(scene)
        index = relative_index(optics.wavelength_nm, scene.scattering.water_temperature_c)
        for name, table in tables.items():
            sections = MieSections(table, optics.wavelength_nm * 1e-9, index)
            found = frame_difference(table_strip(scene, theta, sections), truth)
            headline = radius == 100.0 and name == "shipped"
            yield Row(
                f"exact, {name} table, {radius:g} µm", "strip, 20 nm", found, headline=headline
            )


def _shipped_against(full: MieTable | None) -> Measurement:
    shipped = compact_table()
    size = (
        f"the exact table that ships: {COMPACT_FILE.stat().st_size} bytes, "
        f"{shipped.values.nbytes / 2**20:.0f} MiB in memory, {shipped.values.shape[1]} sizes,"
        f" {shipped.values.shape[0]} indices, {shipped.values.shape[3]} angles"
    )
    if full is None:
        yield Note(f"{size}; the full table is not built here (`rtbow table build --theory mie`).")
        return
    yield Note(f"{size}; the full one: {full.values.nbytes / 2**20:.0f} MiB.")
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
    "Look-ups in float64 against Airy's function and Lorenz-Mie's series themselves, at "
    "random radii (10-1500 µm) and wavelengths (380-780 nm). The series' mean over the 2 "
    "% spread of sizes is in both; it is sampled, and its sampling between the orders of "
    "the series is part of the error.",
    measure,
)
