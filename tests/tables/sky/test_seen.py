"""Tables of a sky against the sums along single rays that the reference makes."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.field import FIELD_NM, sky_field
from rtbow.tables.sky.light import Path
from rtbow.tables.sky.rays import AZIMUTHS, FALLING, RISING, Eye, row_altitudes
from rtbow.tables.sky.seen import sky_table
from rtbow.tables.sky.transport import gather_ray, ray_end

pytestmark = pytest.mark.slow

AIR = make_air(rayleigh_depth(FIELD_NM), np.full(len(FIELD_NM), 0.3))
COLOURS = np.eye(len(FIELD_NM))[:, [1, 7, 15]]
"""Channels of one wavelength each: 405, 555 and 755 nm."""


@pytest.fixture(scope="module")
def field():
    return sky_field(AIR)


def direction(altitude, azimuth):
    return np.array(
        [np.cos(altitude) * np.cos(azimuth), np.cos(altitude) * np.sin(azimuth), np.sin(altitude)]
    )


def summed(field, height, sun, altitude, azimuth, until=np.inf):
    """I, Q and U (3, channels) along a ray, up to a distance or with what is at its end."""
    ray = direction(altitude, azimuth)
    level = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    upright = np.cross(ray, level)
    both = (level + upright) / np.sqrt(2.0)
    probes = np.array([np.outer(f, f) for f in (level, upright, both)])
    pieces = 400
    end = ray_end(height, ray[2])[0]
    edges = np.minimum(end * np.linspace(0.0, 1.0, pieces + 1) ** 2, until)
    waves = len(FIELD_NM)
    air = AIR if until == np.inf else AIR._replace(albedo=np.zeros(waves))
    path = Path(height, ray, edges, np.zeros(pieces + 1), np.zeros(waves))
    out, through = np.zeros((3, waves)), np.zeros(waves)
    gather_ray(path, direction(sun, 0.0), air, field, True, 1.0, probes, out, through)
    first, second, third = out @ COLOURS
    return np.array([first + second, first - second, 2.0 * third - first - second])


def table(field, height, sun_deg, distances=()):
    eye = Eye(height, np.radians(sun_deg), np.array(distances), polarised=True)
    return sky_table(AIR, field, 1.0, eye, COLOURS, AIR.albedo[:, None] * COLOURS)


@pytest.mark.parametrize(
    ("height", "sun_deg"), [(2.0, 60.0), (2.0, 5.0), (0.0, -3.0), (10_000.0, 10.0)]
)
def test_rows_and_columns_are_rays(field, height, sun_deg):
    made = table(field, height, sun_deg)
    whole = made.layers[-1] + made.ground  # (3, rows, columns, channels)
    altitudes = row_altitudes(made.horizon_rad)
    for row in (1, 6, RISING // 2, RISING - 1, RISING + 2, RISING + FALLING // 2):
        for column in (0, 5, 12, AZIMUTHS - 1):
            azimuth = np.pi * column / (AZIMUTHS - 1)
            truth = summed(field, height, np.radians(sun_deg), altitudes[row], azimuth)
            np.testing.assert_allclose(
                whole[:, row, column], truth, atol=8e-3 * truth[0].max(), rtol=0.0
            )


def test_layers_end_at_their_distances(field):
    distances = [0.0, 300.0, 2_000.0, 15_000.0]
    made = table(field, 2.0, 20.0, distances)
    altitudes = row_altitudes(made.horizon_rad)
    assert not made.layers[0].any()
    for layer, until in list(enumerate(distances))[1:]:
        for row in (1, 10, 30, RISING + 8):
            truth = summed(field, 2.0, np.radians(20.0), altitudes[row], 0.0, until)
            np.testing.assert_allclose(
                made.layers[layer, :, row, 0], truth, atol=6e-3 * truth[0].max(), rtol=0.0
            )


def test_between_its_nodes_a_table_is_as_smooth_as_the_sky(field):
    made = table(field, 2.0, 20.0)
    whole = made.layers[-1, 0] + made.ground[0]
    altitudes = row_altitudes(made.horizon_rad)
    for row in (0, 3, 12, 30, 46, RISING, RISING + 10):
        # Rows are even in this: the middle of two, as the shader finds it.
        power = 2.0 if row < RISING else 3.0
        ends = np.abs(altitudes[[row, row + 1]] - made.horizon_rad) ** (1.0 / power)
        side = 1.0 if row < RISING else -1.0
        altitude = made.horizon_rad + side * ends.mean() ** power
        for column in (0, 11, 23):
            truth = summed(
                field, 2.0, np.radians(20.0), altitude, np.pi * (column + 0.5) / (AZIMUTHS - 1)
            )[0]
            between = whole[row : row + 2, column : column + 2].mean(axis=(0, 1))
            # Just below the horizon the ground draws near by kilometres in 0.003 degrees.
            np.testing.assert_allclose(between, truth, rtol=1.5e-2 if row == RISING else 6e-3)


def test_the_sun_is_dimmed_by_the_air_before_it(field):
    made = table(field, 2.0, 20.0)
    zenith = np.exp(-rayleigh_depth(FIELD_NM) @ COLOURS)
    np.testing.assert_allclose(made.beyond[-1], zenith, rtol=1e-3)
    assert np.all(np.diff(made.beyond, axis=0) > 0.0)
