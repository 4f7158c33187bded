"""Disc averages against a product quadrature in polar coordinates about the disc's centre."""

import numpy as np
import pytest

from rtbow.physics.light.disc import disc_mean, disc_nodes, disc_nodes_off_poles
from rtbow.tables.mie.lookup import disc_grid
from textbook import mean_on_sphere

RADIUS = np.radians(0.2665)


POSITIONS = {
    "forward pole": 0.0,
    "just off the pole": 0.03 * RADIUS,
    "pole inside": 0.7 * RADIUS,
    "pole on the rim": RADIUS,
    "pole just outside": 1.001 * RADIUS,
    "pole beside": 3.0 * RADIUS,
    "bow": np.radians(138.0),
    "equator": 0.5 * np.pi,
    "beside the antisolar point": np.pi - 2.0 * RADIUS,
    "antisolar point inside": np.pi - 0.4 * RADIUS,
    "antisolar point on the rim": np.pi - RADIUS,
    "antisolar point": np.pi,
}


@pytest.mark.parametrize("theta", POSITIONS.values(), ids=POSITIONS.keys())
@pytest.mark.parametrize("radius", [RADIUS, np.radians(2.5)])
def test_mean_is_that_on_the_sphere(theta, radius):
    # The positions scale with the disc, so that each stands the same way beside a larger one.
    if theta < 0.1:
        theta *= radius / RADIUS
    elif np.pi - theta < 0.1:
        theta = np.pi - (np.pi - theta) * radius / RADIUS
    # Fringes of 12 rad across the disc's radius, on a slope.
    rate = 12.0 / radius

    def fringes(angle):
        return 1.0 + angle + np.sin(rate * (angle - theta) + 0.7)

    got = disc_mean(fringes, theta, radius, 64)
    # Worst 1.6e-7, with the pole on the rim, and that is the test's own quadrature.
    assert got == pytest.approx(mean_on_sphere(fringes, theta, radius), abs=3e-7)


@pytest.mark.parametrize("share", [0.01, 0.4, 0.7, 0.95, 0.999])
def test_few_nodes_do_with_the_pole_inside(share):
    rate = 12.0 / RADIUS
    got = disc_mean(lambda a: np.sin(rate * a + 0.7), share * RADIUS, RADIUS, 24)
    expected = mean_on_sphere(lambda a: np.sin(rate * a + 0.7), share * RADIUS, RADIUS)
    # Worst 3e-7, next to the rim.
    assert got == pytest.approx(expected, abs=6e-7)


@pytest.mark.parametrize("theta", POSITIONS.values(), ids=POSITIONS.keys())
@pytest.mark.parametrize("count", [8, 64])
def test_weights_sum_to_one_within_the_disc(theta, count):
    angles, weights = disc_nodes(theta, RADIUS, count)
    assert weights.sum() == pytest.approx(1.0, abs=1e-14)
    assert np.all(weights >= 0.0)
    assert np.all((angles >= 0.0) & (angles <= np.pi))
    assert np.all(np.abs(angles - theta) <= RADIUS * (1.0 + 1e-12))


@pytest.mark.parametrize("radius", [1e-300, 1e-20, 1e-12])
def test_discs_without_extent_are_their_centres(radius):
    theta = np.array([0.3, 1.5, 2.9])
    nodes, weights = disc_nodes_off_poles(theta, radius, 24)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose((nodes * weights).sum(axis=1), theta, rtol=1e-9)
    nodes, weights = disc_grid(np.array([0.0, 0.3, np.pi]), radius)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose((nodes * weights).sum(axis=1), [0.0, 0.3, np.pi], atol=1e-9)


def test_disc_at_the_pole_is_centred_beside_it():
    # The mean distance from the centre of a flat disc is two thirds of its radius.
    assert disc_mean(lambda a: a, 0.0, RADIUS, 32) == pytest.approx(2.0 / 3.0 * RADIUS, rel=1e-5)
    got = disc_mean(lambda a: np.pi - a, np.pi, RADIUS, 32)
    assert got == pytest.approx(2.0 / 3.0 * RADIUS, rel=1e-5)


def test_flat_disc_far_from_the_poles():
    # On the equator the sphere is flat to second order: the second moment is a quarter of R².
    got = disc_mean(lambda a: (a - 0.5 * np.pi) ** 2, 0.5 * np.pi, RADIUS, 32)
    assert got == pytest.approx(RADIUS**2 / 4.0, rel=1e-5)


@pytest.mark.parametrize("theta", [0.0, 0.3, np.pi])
def test_no_disc_is_the_angle_itself(theta):
    angles, weights = disc_nodes(theta, 0.0, 16)
    np.testing.assert_array_equal(angles, [theta])
    np.testing.assert_array_equal(weights, [1.0])


def test_mean_keeps_the_functions_other_axes():
    got = disc_mean(lambda a: np.stack([np.ones_like(a), a], axis=1), 1.0, RADIUS, 16)
    np.testing.assert_allclose(got, [1.0, 1.0], atol=1e-5)
