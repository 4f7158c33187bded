"""The sky of molecules against another program's, a quadrature of its own, and conservation."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.base.limits import TOP_M
from rtbow.tables.sky.field import (
    _AZIMUTHS,
    _PIECES,
    FIELD_NM,
    PROBES,
    _cut_phase,
    _rays,
    field_at,
    kept_field,
    no_field,
    solved_field,
)
from rtbow.tables.sky.transport import gather_nodes, ray_end
from skies import molecules
from skies.check import assert_all
from skies.molecules import air, field, seen

pytestmark = pytest.mark.slow


def test_the_published_sky():
    assert_all(molecules.published())


def test_the_published_sky_at_the_horizon():
    assert_all(molecules.published_at_the_horizon())


def test_the_published_sky_of_a_low_sun():
    assert_all(molecules.published_of_a_low_sun())


def test_the_published_polarisation():
    assert_all(molecules.published_polarisation())


def test_one_scattering_is_the_published_one():
    assert_all(molecules.published_single())


@pytest.mark.parametrize("ray", molecules.RAYS)
def test_one_scattering_is_its_quadrature(ray):
    assert_all(molecules.single_along(ray))


@pytest.mark.parametrize("altitude", [90.0, 40.0, 20.0])
def test_no_light_is_lost(altitude):
    assert_all(molecules.conserved(altitude))


def test_a_sun_in_the_zenith_is_no_other_than_one_beside_it():
    up, beside = (seen(field(0.3), 0.3, sun, 90.0, 0.0) for sun in (90.0, 89.9))
    np.testing.assert_allclose(up[0], beside[0], rtol=1e-3)


def test_rays_end_at_the_ground_or_where_air_does():
    assert ray_end(0.0, 1.0) == (pytest.approx(TOP_M), False)
    assert ray_end(2.0, -1.0) == (pytest.approx(2.0), True)
    distance, ground = ray_end(2.0, -1e-4)
    assert not ground  # 0.045 degrees: the horizon of 2 m is lower
    assert distance > 1e6


def test_fields_between_wavelengths():
    between = np.array([392.0, 467.0, 642.0])
    solved = kept_field(air(0.3, between))
    found = field_at(kept_field(air(0.3, FIELD_NM)), between)
    level = solved.mean.max(axis=(0, 1, 2), keepdims=True)
    assert (np.abs(found.mean - solved.mean) / level).max() < 1e-3


def test_the_first_orders_give_the_sum_of_all():
    """Over snow in violet light, where they fall off the most slowly, one by one."""
    bright = air(1.0, np.array([400.0]))
    found = solved_field(bright)
    empty = no_field(1, hazy=False)
    cut = bright._replace(phase=_cut_phase(bright))
    last, mean = empty, 0.0
    for order in range(45):
        rays = (*_rays(), _AZIMUTHS, _PIECES, PROBES)
        light, ground = gather_nodes(cut, last, order == 0, *rays)
        last = empty._replace(mean=light, ground=ground)
        mean = mean + light
    lit = empty.zeniths_rad < np.radians(92.0)
    shares = found.mean[:, lit, :3].sum(axis=2) / mean[:, lit, :3].sum(axis=2)
    np.testing.assert_allclose(shares, 1.0, atol=1e-3)
