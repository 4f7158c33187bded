"""CIE 1931 colour-matching functions and the Rec. 709 / D65 colour space, in float64."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.constants import LUMINOUS_EFFICACY_LM_PER_W
from rtbow.physics.light.cie import standard_arrays

# IEC 61966-2-1, with its published four digits, so that the middle row *is* the luminance
# that the frame's definition promises.
RGB_TO_XYZ: Array = np.array(
    [
        [0.4124, 0.3576, 0.1805],
        [0.2126, 0.7152, 0.0722],
        [0.0193, 0.1192, 0.9505],
    ]
)
XYZ_TO_RGB: Array = floats(np.linalg.inv(RGB_TO_XYZ))
LUMINANCE_WEIGHTS: Array = RGB_TO_XYZ[1].copy()
"""Weights of R, G, B whose sum is luminance, shape (3,)."""

D65_XYZ: Array = RGB_TO_XYZ.sum(axis=1)
"""Tristimulus values of the white point at Y = 1, shape (3,)."""


@lru_cache(maxsize=1)
def colour_matching() -> tuple[Array, Array]:
    """Give the CIE 1931 2° colour-matching functions, scaled to luminance.

    Returns:
        ``wavelength_nm`` (n,) at 1 nm and ``xyz`` (n, 3) in lm/W: integrating radiance
        [W m⁻² sr⁻¹ nm⁻¹] against them gives X, Y, Z with Y in cd/m².

    Source: colour-science, ``CIE 1931 2 Degree Standard Observer``.
    """
    data = standard_arrays()
    return data["cmf_nm"], data["cmf_xyz"] * LUMINOUS_EFFICACY_LM_PER_W


def xyz_to_rgb(xyz: Array) -> Array:
    """Convert X, Y, Z (..., 3) to linear Rec. 709 R, G, B (..., 3) of the same luminance unit."""
    return np.asarray(xyz) @ XYZ_TO_RGB.T


def rgb_to_xyz(rgb: Array) -> Array:
    """Convert linear Rec. 709 R, G, B (..., 3) to X, Y, Z (..., 3)."""
    return np.asarray(rgb, dtype=np.float64) @ RGB_TO_XYZ.T


def luminance(rgb: Array) -> Array:
    """Give the luminance (...) in cd/m² of linear Rec. 709 R, G, B (..., 3)."""
    return np.asarray(rgb, dtype=np.float64) @ LUMINANCE_WEIGHTS
