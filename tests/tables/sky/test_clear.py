"""Fields of clear air that come with the program, against those that are solved for."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.air.ozone import ozone_depth
from rtbow.tables.sky.clear import MOST_OZONE, clear_field
from rtbow.tables.sky.field import no_field
from skies.check import assert_all
from skies.clear import CASES, clear, fields, one_index


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_they_are_those_that_are_solved_for(case):
    assert_all(fields(case))


@pytest.mark.slow
def test_what_is_one_index_of_water_for_all_light():
    assert_all(one_index())


def test_what_is_not_known_is_left_to_the_solver():
    thick = ozone_depth(np.array([600.0]), 460.0)
    assert thick > MOST_OZONE
    assert clear_field(clear(1000.0, 460.0, (0.1, 0.1, 0.1)), no_field(3)) is None
    two = clear(1000.0, 0.0, (0.1, 0.1, 0.1))._replace(water=np.array([0.0, 1.3, 1.3]))
    assert clear_field(two, no_field(3)) is None
