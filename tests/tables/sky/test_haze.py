"""Skies with aerosol and ozone against other programs', conservation, and parts of the sums."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.air.aerosol import AerosolOptics, free_optics
from rtbow.tables.sky.air import Haze, make_air
from rtbow.tables.sky.field import no_field
from rtbow.tables.sky.light import HARMONICS, harmonics
from skies import aerosol
from skies.aerosol import setting
from skies.check import assert_all
from skies.gathered import stokes

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("number", aerosol.SETTINGS)
def test_the_sky_is_that_of_other_programs(number):
    assert_all(aerosol.published(number))


@pytest.mark.parametrize("number", aerosol.SINGLE_SETTINGS)
def test_one_scattering_is_that_of_another_program(number):
    assert_all(aerosol.single(number))


def test_haze_that_scatters_all_keeps_all_light():
    assert_all(aerosol.conserved())


def test_harmonics_are_orthonormal():
    mu, weight = np.polynomial.legendre.leggauss(12)
    azimuth = 2.0 * np.pi * (np.arange(24) + 0.5) / 24.0
    out = np.zeros((HARMONICS, 12, 24))
    harmonics(mu[:, None], np.sqrt(1.0 - mu**2)[:, None], np.cos(azimuth)[None], out)
    products = np.einsum("aij,bij,i->ab", out, out, weight * 2.0 * np.pi / 24.0)
    np.testing.assert_allclose(products, np.eye(HARMONICS), atol=1e-12)


def test_a_field_of_nothing_needs_no_harmonics():
    """Read beyond its end it would be whatever the memory holds."""
    rows, air = setting(2)
    sun_deg = rows[0]["sun_altitude_deg"]
    none = no_field(1)
    held = np.full((*none.mean.shape[:2], 5, 1), np.nan)
    held[:, :, :4] = 0.0
    tight = none._replace(mean=held[:, :, :4])
    expected = stokes(air, no_field(1, hazy=True), sun_deg, 20.0, 60.0)
    np.testing.assert_array_equal(stokes(air, tight, sun_deg, 20.0, 60.0), expected)


def test_a_mixture_by_hand():
    """Half of each of two aerosols in one layer is their mean."""
    nm = np.array([550.0])
    both = [free_optics(nm, 0.2, 0.0, albedo, g) for albedo, g in ((1.0, 0.6), (0.8, 0.75))]
    scattered = [one.depth * one.scattering for one in both]
    phase = sum(s * one.phase for s, one in zip(scattered, both, strict=True)) / sum(scattered)
    mean = AerosolOptics(0.5 * sum(one.depth for one in both), sum(scattered) / 0.4, phase)

    def once(optics):
        air = make_air(np.zeros(1), np.zeros(1), None, Haze(optics, 1200.0, np.inf))
        thin = air._replace(depth=1e-6 * air.beam, scattering=optics.scattering, phase=optics.phase)
        return stokes(thin, no_field(1, hazy=True), 30.0, 20.0, 90.0)[0, 0]

    assert once(mean) == pytest.approx(0.5 * sum(map(once, both)), rel=1e-9)
