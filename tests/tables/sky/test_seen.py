"""Tables of a sky against the sums along single rays that the reference makes."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.air.rayleigh import rayleigh_depth
from rtbow.tables.sky.field import FIELD_NM
from rtbow.tables.sky.rays import AZIMUTHS, FALLING, RISING, row_altitudes
from skies.tables import COLOURS, summed, table

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("height", "sun_deg"), [(2.0, 90.0), (2.0, 60.0), (2.0, 5.0), (0.0, -3.0), (10_000.0, 10.0)]
)
def test_rows_and_columns_are_rays(height, sun_deg):
    made = table(height, sun_deg)
    whole = made.layers[-1] + made.ground  # (3, rows, columns, channels)
    altitudes = np.degrees(row_altitudes(made.horizon_rad))
    for row in (1, 6, RISING // 2, RISING - 1, RISING + 2, RISING + FALLING // 2):
        for column in (0, 5, 12, AZIMUTHS - 1):
            azimuth = 180.0 * column / (AZIMUTHS - 1)
            truth = summed(height, sun_deg, altitudes[row], azimuth)
            np.testing.assert_allclose(
                whole[:, row, column], truth, atol=8e-3 * truth[0].max(), rtol=0.0
            )


def test_layers_end_at_their_distances():
    distances = [0.0, 300.0, 2_000.0, 15_000.0]
    made = table(2.0, 20.0, distances)
    altitudes = np.degrees(row_altitudes(made.horizon_rad))
    assert not made.layers[0].any()
    for layer, until in list(enumerate(distances))[1:]:
        for row in (1, 10, 30, RISING + 8):
            truth = summed(2.0, 20.0, altitudes[row], 0.0, until)
            np.testing.assert_allclose(
                made.layers[layer, :, row, 0], truth, atol=6e-3 * truth[0].max(), rtol=0.0
            )


def test_between_its_nodes_a_table_is_as_smooth_as_the_sky():
    made = table(2.0, 20.0)
    whole = made.layers[-1, 0] + made.ground[0]
    altitudes = row_altitudes(made.horizon_rad)
    for row in (0, 3, 12, 30, 46, RISING, RISING + 10):
        # Rows are even in this: the middle of two, as the shader finds it.
        power = 2.0 if row < RISING else 3.0
        ends = np.abs(altitudes[[row, row + 1]] - made.horizon_rad) ** (1.0 / power)
        side = 1.0 if row < RISING else -1.0
        altitude = made.horizon_rad + side * ends.mean() ** power
        for column in (0, 11, 23):
            azimuth = 180.0 * (column + 0.5) / (AZIMUTHS - 1)
            truth = summed(2.0, 20.0, np.degrees(altitude), azimuth)[0]
            between = whole[row : row + 2, column : column + 2].mean(axis=(0, 1))
            # Just below the horizon the ground draws near by kilometres in 0.003 degrees.
            np.testing.assert_allclose(between, truth, rtol=1.5e-2 if row == RISING else 6e-3)


def test_the_sun_is_dimmed_by_the_air_before_it():
    made = table(2.0, 20.0)
    zenith = np.exp(-rayleigh_depth(FIELD_NM) @ COLOURS)
    np.testing.assert_allclose(made.beyond[-1], zenith, rtol=1e-3)
    assert np.all(np.diff(made.beyond, axis=0) > 0.0)
