"""The CIE's tables that come with the program, against colour-science's."""

from __future__ import annotations

import colour
import numpy as np

from rtbow.physics.light.cie import illuminant_names, standard_arrays


def test_the_tables_are_those_of_colour_science():
    arrays = standard_arrays()
    functions = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    np.testing.assert_array_equal(arrays["cmf_nm"], functions.wavelengths)
    np.testing.assert_array_equal(arrays["cmf_xyz"], functions.values)
    for name in illuminant_names():
        sd = colour.SDS_ILLUMINANTS[name]
        expected = np.stack([sd.wavelengths, sd.values])
        np.testing.assert_array_equal(arrays[f"illuminant:{name}"], expected)
    assert {"A", "D65", "FL2", "HP1", "LED-B3"} <= set(illuminant_names())
