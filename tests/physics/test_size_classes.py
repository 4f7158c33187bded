"""Drops counted in classes: their sums are those over the classes' middles."""

import numpy as np
import pytest

from rtbow.physics.size_classes import PARSIVEL_MIDDLES_MM, PARSIVEL_WIDTHS_MM, SizeClasses

# Of a shower, drops per m³ in Parsivel's classes 3 to 19: invented.
SHOWER = np.array([80.0, 95, 110, 100, 90, 80, 65, 50, 70, 45, 24, 13, 7, 6, 1.5, 0.3, 0.1])
MIDDLE_UM = 500.0 * PARSIVEL_MIDDLES_MM[2:19]
WIDTH_UM = 500.0 * PARSIVEL_WIDTHS_MM[2:19]


def test_parsivels_classes():
    assert len(PARSIVEL_MIDDLES_MM) == 32
    # As OTT prints them: 1.375 is the 11th, 24.5 the last, which ends at 26 mm.
    assert PARSIVEL_MIDDLES_MM[[0, 9, 10, 15, 31]] == pytest.approx(
        [0.0625, 1.1875, 1.375, 2.75, 24.5]
    )
    assert PARSIVEL_WIDTHS_MM.sum() == 26.0


def test_number_area_and_volume_are_the_sums():
    classes = SizeClasses(MIDDLE_UM, WIDTH_UM, SHOWER)
    for power in (0, 2, 3):
        expected = float(np.sum(SHOWER * MIDDLE_UM**power))
        at_end = classes.cumulated(np.array([1e5]), power)[0]
        assert at_end == pytest.approx(expected, rel=1e-9)
        assert classes.total(power) == pytest.approx(expected, rel=1e-12)
    # All are within their classes but for what draws them together.
    low, high = classes.range_um
    assert low == pytest.approx(MIDDLE_UM[0] - 0.5 * WIDTH_UM[0], rel=0.02)
    assert high == pytest.approx(MIDDLE_UM[-1] + 0.5 * WIDTH_UM[-1], rel=0.02)


def test_drops_are_spread_over_their_classes():
    classes = SizeClasses(MIDDLE_UM, WIDTH_UM, SHOWER)
    edges = np.append(MIDDLE_UM - 0.5 * WIDTH_UM, MIDDLE_UM[-1] + 0.5 * WIDTH_UM[-1])
    np.testing.assert_allclose(np.diff(classes.cumulated(edges, 0)), SHOWER, atol=0.03 * 110)
    fine = np.linspace(*classes.range_um, 400)
    assert np.all(np.diff(classes.cumulated(fine, 0)) > 0.0)


def test_one_class_keeps_number_and_area():
    alone = SizeClasses(np.array([100.0]), np.array([20.0]), np.array([7.0]))
    assert alone.cumulated(np.array([200.0]), 0)[0] == pytest.approx(7.0)
    assert alone.cumulated(np.array([200.0]), 2)[0] == pytest.approx(7e4)
    assert alone.cumulated(np.array([200.0]), 3)[0] == pytest.approx(7e6, rel=0.01)
    assert alone.share_within(0, 1.0, 100.0) == pytest.approx(0.5, abs=0.02)
