"""Take the CIE's tables that come with the program from colour-science: rtbow/data/cie.npz.

Importing colour-science takes seconds, which a first frame would wait for.
"""

from __future__ import annotations

from pathlib import Path

import colour
import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.light.cie import CMF_NM, CMF_XYZ, FILE, ILLUMINANT

PATH = Path(__file__).parent.parent / "rtbow" / "data" / FILE


def tables() -> dict[str, Array]:
    """Give what the file holds."""
    functions = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    arrays = {CMF_NM: floats(functions.wavelengths), CMF_XYZ: floats(functions.values)}
    for name, sd in colour.SDS_ILLUMINANTS.items():
        nm = floats(sd.wavelengths)
        # A table that does not span the visible would need invented values at its ends.
        if nm[0] <= VISIBLE_NM[0] and nm[-1] >= VISIBLE_NM[1]:
            arrays[f"{ILLUMINANT}{name}"] = np.stack([nm, floats(sd.values)])
    return arrays


if __name__ == "__main__":
    np.savez_compressed(PATH, allow_pickle=False, **tables())
