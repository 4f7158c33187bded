"""Tabulated CIE standards, taken from colour-science once and kept in the cache.

Importing colour-science takes one to two seconds, so it is imported only when the cache does
not hold what this module needs.
"""

from __future__ import annotations

from functools import lru_cache
from importlib.metadata import version

import numpy as np

from rtbow.base.arrays import Array
from rtbow.base.cache import cached_arrays, quiet_matplotlib, source_digest
from rtbow.physics.constants import VISIBLE_NM


def _extract() -> dict[str, Array]:
    with quiet_matplotlib():  # which it imports
        import colour

    cmf = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    arrays = {
        "cmf_nm": np.asarray(cmf.wavelengths, dtype=np.float64),
        "cmf_xyz": np.asarray(cmf.values, dtype=np.float64),
    }
    for name, sd in colour.SDS_ILLUMINANTS.items():
        nm = np.asarray(sd.wavelengths, dtype=np.float64)
        # A table that does not span the visible would need invented values at its ends.
        if nm[0] <= VISIBLE_NM[0] and nm[-1] >= VISIBLE_NM[1]:
            arrays[f"illuminant:{name}"] = np.stack([nm, np.asarray(sd.values, dtype=np.float64)])
    return arrays


@lru_cache(maxsize=1)
def standard_arrays() -> dict[str, Array]:
    """Give the CIE tables.

    Returns:
        ``cmf_nm`` (n,), ``cmf_xyz`` (n, 3), and for each illuminant an array
        ``illuminant:NAME`` (2, n) of wavelength in nm and relative power.
    """
    code = source_digest("physics.light.cie", "physics.constants")
    key = f"colour-science {version('colour-science')} {code}"
    return cached_arrays("cie-standards", key, _extract)


def illuminant_names() -> list[str]:
    """List the CIE illuminants and lamps known by name."""
    prefix = "illuminant:"
    return sorted(k.removeprefix(prefix) for k in standard_arrays() if k.startswith(prefix))
