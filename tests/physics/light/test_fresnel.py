"""Reflection by a smooth surface, against Fresnel's formulas in angles and a published mean."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.physics.light.fresnel import diffuse_reflectance, reflectance, reflected_amplitudes


@pytest.mark.parametrize("index", [1.2, 1.34, 1.9])
def test_amplitudes_are_those_of_the_angles(index):
    angle = np.radians([5.0, 30.0, 60.0, 85.0])
    refracted = np.arcsin(np.sin(angle) / index)
    across, within = reflected_amplitudes(index, np.cos(angle))
    np.testing.assert_allclose(across, -np.sin(angle - refracted) / np.sin(angle + refracted))
    np.testing.assert_allclose(
        within, np.tan(angle - refracted) / np.tan(angle + refracted), atol=1e-15
    )


def test_a_mirror_when_grazed_and_the_known_share_at_a_right_angle():
    assert reflectance(1.5, 0.0) == 1.0
    assert reflectance(1.5, 1.0) == pytest.approx(0.04)
    assert reflected_amplitudes(1.34, np.cos(np.arctan(1.34)))[1] == pytest.approx(0.0, abs=1e-12)


def test_light_from_all_sides():
    """Walsh's closed form for indices above 1: 0.0664 of 1.333, 0.0918 of 1.5."""
    found = diffuse_reflectance(np.array([1.333, 1.5]))
    np.testing.assert_allclose(found, [0.0664, 0.0918], atol=1e-4)
