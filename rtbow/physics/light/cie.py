"""Tabulated CIE standards, taken from colour-science once and kept in the cache.

Importing colour-science takes one to two seconds, so it is imported only when the cache does
not hold what this module needs.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from importlib.metadata import version

import numpy as np

from rtbow.base.arrays import Array, floats
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


_DESCRIPTIONS = {
    "A": "incandescent lamp, tungsten filament",
    "B": "direct sunlight at noon (withdrawn)",
    "C": "average daylight (withdrawn)",
    "E": "equal energy at every wavelength",
    **dict.fromkeys(("D50", "D55", "D60", "D65", "D75"), "daylight"),
    **dict.fromkeys(("ID50", "ID65"), "daylight indoors, behind window glass"),
    **{
        f"FL{number}": f"fluorescent lamp, {kind}"
        for number, kind in {
            "1": "daylight", "2": "cool white", "3": "white", "4": "warm white", "5": "daylight",
            "6": "light white", "7": "broad-band, like D65", "8": "broad-band, like D50",
            "9": "broad-band, cool white", "10": "three-band, like D50", "11": "three-band",
            "12": "three-band, warm white", "3.15": "like D65",
            **dict.fromkeys(("3.1", "3.2", "3.3"), "standard halophosphate"),
            **dict.fromkeys(("3.4", "3.5", "3.6"), "deluxe"),
            **dict.fromkeys(("3.7", "3.8", "3.9", "3.10", "3.11"), "three-band"),
            **dict.fromkeys(("3.12", "3.13", "3.14"), "multi-band"),
        }.items()
    },
    "HP1": "standard high-pressure sodium lamp",
    "HP2": "colour-enhanced high-pressure sodium lamp",
    **dict.fromkeys(("HP3", "HP4", "HP5"), "high-pressure metal halide lamp"),
    **{f"LED-B{number}": "white LED, blue with phosphor" for number in range(1, 6)},
    "LED-BH1": "white LED, blue with phosphor and red",
    "LED-RGB1": "white LED, red, green and blue",
    **dict.fromkeys(("LED-V1", "LED-V2"), "white LED, violet with phosphor"),
}  # fmt: skip
"""What the illuminants are. Source: CIE 15:2018, tables 5 to 12 and their captions."""


def illuminant_description(name: str) -> str:
    """Say what a CIE illuminant is; nothing of one that is not known here."""
    return _DESCRIPTIONS.get(name, "")


def colour_rendering(wavelength_nm: Array, powers: Array) -> Array:
    """Give general colour rendering indices Ra, by colour-science (CIE 13.3-1995).

    Args:
        wavelength_nm: even steps over the visible (W,).
        powers: relative, per wavelength (n, W).

    Returns:
        Ra (n,).
    """
    with quiet_matplotlib():  # which it imports
        import colour

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it tells of each alignment of wavelengths
        lights = [colour.SpectralDistribution(power, wavelength_nm) for power in powers]
        return floats([colour.colour_rendering_index(light) for light in lights])


def illuminant_names() -> list[str]:
    """List the CIE illuminants and lamps known by name."""
    prefix = "illuminant:"
    return sorted(k.removeprefix(prefix) for k in standard_arrays() if k.startswith(prefix))
