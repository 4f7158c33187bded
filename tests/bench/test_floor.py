"""The floor's pass."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.base.errors import UnavailableError
from rtbow.bench.floor import TABLE_SIDE, FloorPass
from rtbow.gl.context import open_context


def test_the_floor_is_one_look_up_per_pixel():
    with open_context() as gl:
        floor = FloorPass(gl, (8, 4))
        floor.draw()
        frame = floor.read()
    assert frame.shape == (4, 8, 3)
    # The table rises from 0 in the first texel's middle to 1 in the last's.
    x = (np.arange(8) + 0.5) / 8 * TABLE_SIDE - 0.5
    np.testing.assert_allclose(frame[0, :, 0], x / (TABLE_SIDE - 1), atol=2e-3)
    assert np.all(np.diff(frame[:, 0, 1]) < 0.0)  # up the picture


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_a_frame_too_large_for_the_floor(backend):
    with (
        open_context(backend) as gl,
        pytest.raises(UnavailableError, match="1000000 x 1 pixels; bench at a smaller size"),
    ):
        FloorPass(gl, (1_000_000, 1))
