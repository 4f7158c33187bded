"""The phase function of rain: what share of its light goes where, and what is cut off."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.drop.medium import Medium
from rtbow.tables.mie.efficiency import extinction_efficiencies
from rtbow.tables.orders.phase import cell_edges, rain_phase
from rtbow.world.rain.extinction import disc_share

pytestmark = pytest.mark.slow

NM = np.array([450.0, 550.0, 650.0])


def share_within(phase, angle_deg):
    return np.interp(np.radians(angle_deg), phase.edges_rad, phase.running[0, 1])


@pytest.fixture(scope="module")
def whole():
    """Of drops of 300 µm, nothing cut off."""
    return rain_phase(Medium(20.0), 0.02, (300.0, 300.0), None, NM, 0.0)


@pytest.mark.parametrize(
    ("angle_deg", "share"), [(0.5, 0.49), (40.0, 0.88), (60.0, 0.96), (135.0, 0.978)]
)
def test_shares_of_large_drops(whole, angle_deg, share):
    """Diffraction half of it, within a degree; most of the rest passes through the drop."""
    assert share_within(whole, angle_deg) == pytest.approx(share, abs=0.006)


@pytest.mark.parametrize("cut_deg", [0.0, 0.27, 3.0])
def test_its_integral_is_one(cut_deg):
    phase = rain_phase(Medium(20.0), 0.02, (40.0, 200.0), None, NM, np.radians(cut_deg))
    solid = -2.0 * np.pi * np.diff(np.cos(phase.edges_rad))
    np.testing.assert_allclose(phase.density @ solid, 1.0, atol=1e-12)
    assert phase.edges_rad[0] == np.radians(cut_deg)
    assert len(phase.radius_m) > 5
    assert np.all(np.diff(np.log(phase.radius_m)) < np.log(1.25) + 1e-9)


@pytest.mark.parametrize("radius_um", [10.0, 40.0, 300.0])
def test_what_is_cut_is_what_the_extinction_leaves_out(radius_um):
    """Airy's diffraction within the disc, from which the extinction is made, and the exact sum."""
    cut = np.radians(0.2665)
    whole = rain_phase(Medium(20.0), 0.02, (radius_um, radius_um), None, NM, 0.0)
    size = 2.0 * np.pi * radius_um * 1e-6 / 550e-9
    whole_q = extinction_efficiencies(np.array([radius_um * 1e-6]), NM[1:2], Medium(20.0))[0, 0]
    left = 1.0 - disc_share(np.array([size]), cut)[0] / whole_q
    assert 1.0 - share_within(whole, 0.2665) == pytest.approx(left, abs=0.012)


def test_cells_are_fine_where_light_is_sharp():
    edges = cell_edges(np.radians(0.27))
    assert np.all(np.diff(edges) > 0.0)
    assert edges[-1] == np.pi
    assert np.max(np.diff(edges)) <= np.radians(0.05) * 1.001
    assert edges[1] - edges[0] < np.radians(0.01)
