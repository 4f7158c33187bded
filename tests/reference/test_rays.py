"""Samples along rays, and the functions that are summed over them."""

import numpy as np
import pytest
from scipy.special import airy

from one_pixel import BOX, EYE
from rtbow.physics.drop.airy_compiled import airy_grid, airy_squared_at
from rtbow.reference.rays import Grid, Rays, sample_rays
from textbook import towards


def test_samples_cover_the_ray():
    grid = Grid(BOX, moments=np.ones((3, 4, 5, 2)), extinction=np.zeros((1, 1, 1, 2)))
    directions = np.stack([towards(a, h) for a, h in ((0.0, 10.0), (35.0, 25.0), (180.0, 0.0))])
    spans = [(200.0 / directions[0, 1], 1200.0 / directions[0, 1]), (300.0, 900.0), (5.0, 5.0)]
    entry, leave = np.array(spans).T.copy()
    rays = Rays(EYE, directions, entry, leave, longest=np.full(3, np.inf))
    start, distance, weight, radius = sample_rays(rays, grid, np.zeros((3, 0)), thickest=np.inf)
    assert start[0] == 0
    assert start[-1] == len(distance) == len(weight) == len(radius)
    assert start[3] == start[2]  # nothing in an empty span
    for k in range(2):
        part = slice(start[k], start[k + 1])
        assert weight[part].sum() == pytest.approx(leave[k] - entry[k], rel=1e-12)
        assert (weight * distance)[part].sum() == pytest.approx(
            0.5 * (leave[k] ** 2 - entry[k] ** 2), rel=1e-12
        )
        assert np.all(np.diff(distance[part]) > 0.0)


def test_airy_squared_on_its_grid():
    z = np.concatenate([np.linspace(-16.0, 40.0, 5001), np.geomspace(40.0, 900.0, 500)])
    got = np.array([airy_squared_at(float(at), airy_grid()) for at in z])
    # Worst 4e-8 of the peak.
    np.testing.assert_allclose(got, airy(-z)[0] ** 2, rtol=0.0, atol=1e-7 * 0.287)
