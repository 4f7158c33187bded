"""Cross-sections laid out for a scene: where the angles lie, what lies between them, and memory."""

from dataclasses import dataclass

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.tables import layout
from rtbow.tables.layout import (
    RadiusAxis,
    angle_axis,
    row_sections,
    running_integral,
    section_table,
)
from rtbow.tables.sections import water_sections

NM = np.array([550.0])
DISC = np.radians(0.2665)


@pytest.mark.parametrize("disc", [0.0, DISC])
@pytest.mark.parametrize("ends", [(0.0, np.pi), (0.3, 2.9), (2.0, np.pi)])
def test_angles_lie_evenly_by_place(ends, disc):
    axis = angle_axis(*ends, disc, 5e-4)
    angles = axis.angles()
    assert angles[0] == ends[0]
    assert angles[-1] == ends[1]
    steps = np.diff(axis.place(angles))
    np.testing.assert_allclose(steps, steps[0], rtol=1e-6)
    assert 0.99 < steps[0] <= 1.0


def test_density_is_that_of_the_derivation():
    """A density of 1/even and of pole / sqrt(d² + width²) about both poles."""
    axis = angle_axis(0.0, np.pi, 0.0, 1e-4)
    angles = axis.angles()
    middle, apart = 0.5 * (angles[1:] + angles[:-1]), np.diff(angles)
    poles = [axis.pole / np.hypot(d, axis.width) for d in (middle, np.pi - middle)]
    np.testing.assert_allclose(1.0 / apart, axis.linear + sum(poles), rtol=2e-3)
    # At 50/x from a pole, where the last rings are, 3.6 texels to one of pi/x, even ones besides.
    x = 2.0 * np.pi * 1e-4 / 380e-9
    at = int(np.searchsorted(angles, 50.0 / x))
    assert np.pi / x / apart[at] == pytest.approx(3.6 + np.pi / x * axis.linear, rel=0.02)


# Measured at 550 nm: 1.4e-3, 5e-4, 2.6e-3, 3.0e-3 of the primary's peak.
@pytest.mark.parametrize("disc", [0.0, DISC])
@pytest.mark.parametrize("radius_um", [100.0, 500.0])
def test_straight_lines_between_angles(radius_um, disc):
    sections = water_sections("mie", NM, 20.0, (radius_um, radius_um))
    rows = RadiusAxis(np.array([radius_um * 1e-6]), None)
    axis = angle_axis(0.0, np.pi, disc, radius_um * 1e-6)
    theta = axis.angles()
    theta = theta[(theta > np.radians(20.0)) & (theta < np.radians(179.0))]
    middle = 0.5 * (theta[1:] + theta[:-1])
    at, between = (
        row_sections(sections, rows, angles, disc)[0, 0].mean(axis=1) for angles in (theta, middle)
    )
    peak = at[(theta > np.radians(136.0)) & (theta < np.radians(145.0))].max()
    assert np.abs(0.5 * (at[1:] + at[:-1]) - between).max() < 5e-3 * peak


@dataclass(frozen=True)
class Even:
    """Cross-sections of pi a² (1 + the angle) and twice that, at two wavelengths."""

    level: float = 1.0

    def sections(self, radius_m, theta_rad, disc_rad):
        area = self.level * np.pi * radius_m[:, None, None] ** 2 * (1.0 + theta_rad)
        return np.stack([area, 2.0 * area], axis=-1) * np.ones((1, 2, 1, 1))


def table(sections=Even(), radii=(100.0, 200.0), **changes):
    axis = angle_axis(0.0, np.pi, DISC, 2e-4)
    flags = {"components": False, "running": False} | changes
    return section_table(sections, 2, axis, radii, None, (DISC, 2.0 * DISC), **flags)


@pytest.mark.parametrize("components", [False, True])
@pytest.mark.parametrize("running", [False, True])
def test_channels_of_a_table(components, running):
    got = table(components=components, running=running)
    theta = got.angles.angles()
    shape = np.pi * (1.0 + theta)
    # From the right angle on.
    integral = np.pi * (theta - 0.5 * np.pi + 0.5 * (theta**2 - 0.25 * np.pi**2))
    kinds = [shape, integral] if running else [shape]
    factors = (1.0, 2.0) if components else (1.5,)
    wanted = np.stack([factor * kind for kind in kinds for factor in factors], axis=-1)
    assert got.values.shape == (4, len(got.radii.radius_m), *wanted.shape)
    assert got.values.dtype == np.float32
    # The integral starts at the next angle of the table.
    step = float(np.diff(theta).max())
    assert np.abs(got.values - wanted).max() < 20.0 * step * running + 1e-5


def test_large_tables_are_stored_in_half_floats(monkeypatch):
    whole = table(Even(1e5))
    monkeypatch.setattr(layout, "_LARGEST_FLOAT32_BYTES", whole.values.nbytes - 1)
    half = table(Even(1e5))
    assert half.values.dtype == np.float16
    assert np.all(np.isfinite(half.values))
    np.testing.assert_allclose(
        half.values.astype(np.float64) * half.scale, whole.values, rtol=2.0**-11
    )
    # Integrals keep all their digits, for differences between them are asked for.
    assert table(Even(1e5), running=True).values.dtype == np.float32


def test_rows_move_apart_before_a_table_is_refused(monkeypatch):
    whole = table()
    monkeypatch.setattr(layout, "_LARGEST_BYTES", whole.values.nbytes - 1)
    coarse = table()
    assert 0.6 < len(coarse.radii.radius_m) / len(whole.radii.radius_m) < 0.75
    monkeypatch.setattr(layout, "_LARGEST_BYTES", coarse.values.nbytes - 1)
    with pytest.raises(InputError, match=r"100 to 200 um at 2 wavelengths would take .* MiB"):
        table()


def test_running_integral_counts_from_the_right_angle():
    theta = np.linspace(0.0, np.pi, 2001)
    got = running_integral(np.sin(theta), theta)
    assert np.abs(got + np.cos(theta)).max() < 1e-3
    assert got[1000] == 0.0
