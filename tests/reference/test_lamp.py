"""Pieces of rays at a lamp, and a ray that all but meets it, against closed forms."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from lamp_samples import BOX, EYE, FLUX_LM, INSIDE, NM, NUMBER, lamp, make
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.colour import colour_matching
from rtbow.reference.lamp import Ball, lamp_pieces
from rtbow.reference.rays import Grid, Rays
from rtbow.reference.render import spectral_radiance_along
from rtbow.world.world import resolve
from textbook import cross_section, panels

pytestmark = pytest.mark.slow

GRID = Grid(np.array(BOX), moments=np.full((2, 3, 4, 2), 2.0), extinction=np.zeros((1, 1, 1, 2)))


def ray_past(side_m):
    """A direction from the eye that passes beside the lamp, and the distance to its foot."""
    towards = np.array(INSIDE) - EYE
    distance = np.linalg.norm(towards)
    across = np.cross(towards, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    turn = np.arcsin(side_m / distance)
    return np.cos(turn) * towards / distance + np.sin(turn) * across, distance * np.cos(turn)


def span(ray):
    """Distances at which a ray to the north enters and leaves the box."""
    return -EYE[1] / ray[1], (BOX[1][1] - EYE[1]) / ray[1]


@pytest.mark.parametrize("side_m", [2.0, 0.05, 0.003])
@pytest.mark.parametrize("radius_m", [0.0, 0.2])
def test_pieces_sum_to_the_integral_outside_the_lamp(side_m, radius_m):
    ray, foot = ray_past(side_m)
    near, far = span(ray)
    rays = Rays(
        np.array(EYE), ray[None], np.array([near]), np.array([far]), longest=np.array([np.inf])
    )
    ball = Ball(np.array(INSIDE), radius_m, nearest=1e-3)
    pieces = lamp_pieces(rays, GRID, ball, finest=0.01, thickest=np.inf)
    chord = np.sqrt(max(radius_m**2 - side_m**2, 0.0))
    stretches = [(near, foot - chord), (foot + chord, far)]
    angles = [np.arctan((b - foot) / side_m) - np.arctan((a - foot) / side_m) for a, b in stretches]
    assert pieces.weight.sum() == pytest.approx(2.0 * sum(angles) / side_m, rel=1e-12)
    assert pieces.radius == pytest.approx(1.0)
    assert np.all(np.diff(pieces.distance) > 0.0)
    assert np.all(np.abs(pieces.distance - foot) >= chord)
    # Drops before the lamp send its light onwards to the eye, those behind it send it back.
    assert np.all(pieces.first < pieces.last)
    ends = np.arctan2(side_m, foot - np.array([near, far]))
    assert [pieces.first[0], pieces.last[-1]] == pytest.approx(ends, rel=1e-9)


def test_ray_that_all_but_meets_a_point():
    """Five centimetres from a point, far outside of where its light is capped."""
    side_m, radius_m = 0.05, 300e-6
    ray, foot = ray_past(side_m)
    ends = [np.arctan2(side_m, foot - t) for t in span(ray)]
    nm, cmf = colour_matching()
    fine = np.linspace(380.0, 780.0, 40001)
    intensity = FLUX_LM / trapezoid(np.interp(fine, nm, cmf[:, 1]), fine) / (4.0 * np.pi)

    theta, share = panels(*ends, 2000)
    expected = []
    for wavelength in NM:
        index = float(relative_index(np.array([wavelength]), 20.0)[0])
        section = sum(cross_section(index, wavelength * 1e-9, radius_m, theta, k) for k in (1, 2))
        expected.append(intensity * NUMBER / side_m * (share * section).sum())
    got = spectral_radiance_along(resolve(make(lights=[lamp(diameter_m=0.0)])), ray[None])[0]
    # Worst 9e-9.
    np.testing.assert_allclose(got, expected, rtol=3e-8)
