"""Tabulated CIE standards, as colour-science has them.

Importing it takes seconds: the tables come with the program (``tools/make_cie.py`` takes them from
there, of CIE 15:2004 and CIE 15:2018), and it is imported for colour rendering alone.
"""

from __future__ import annotations

import warnings
from functools import lru_cache

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import quiet_matplotlib
from rtbow.base.resources import resource_dir

FILE = "cie.npz"
CMF_NM, CMF_XYZ, ILLUMINANT = "cmf_nm", "cmf_xyz", "illuminant:"
"""Names in the file; that of an illuminant follows the last one."""


@lru_cache(maxsize=1)
def standard_arrays() -> dict[str, Array]:
    """Give the CIE tables.

    Returns:
        ``cmf_nm`` (n,), ``cmf_xyz`` (n, 3), and for each illuminant an array
        ``illuminant:NAME`` (2, n) of wavelength in nm and relative power.
    """
    with (resource_dir("data") / FILE).open("rb") as file, np.load(file) as arrays:
        return {name: arrays[name] for name in arrays.files}


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
    names = standard_arrays()
    return sorted(k.removeprefix(ILLUMINANT) for k in names if k.startswith(ILLUMINANT))
