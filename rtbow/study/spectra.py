"""A spectrum described: what was understood of it, its colour, its strength, and its curve."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.base.cache import cached_arrays, source_digest
from rtbow.frames.plot import COLOURS, GRID_GREY, caption, new_figure, save, style
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.light.cie import colour_rendering, illuminant_names
from rtbow.physics.light.colour import colour_matching
from rtbow.physics.light.spectrum import Spectrum, colour_weights, luminous, wavelength_bins
from rtbow.world.measured.read import Measured
from rtbow.world.measured.spectra import (
    load_measured,
    load_spectrum,
    spectrum_description,
    spectrum_names,
)

_FARTHEST_DUV = 0.05
"""A light farther from the black bodies' colours has no correlated temperature (CIE 15:2018)."""
_STRENGTHS = {
    "irradiance": ("W/m²", "lx", "illuminance"),
    "flux": ("W", "lm", "luminous flux"),
    "radiance": ("W/(m² sr)", "cd/m²", "luminance"),
    "intensity": ("W/sr", "cd", "luminous intensity"),
}
_CAPTIONED = ("chromaticity", "temperature", *_STRENGTHS, "efficacy")
_VISIBLE = f"{VISIBLE_NM[0]:g}-{VISIBLE_NM[1]:g} nm"


@dataclass(frozen=True)
class Description:
    """What is to be said of a spectrum.

    Attributes:
        lines: pairs of a label and its text.
        notes: what is doubtful.
        spectrum: the spectrum, zero where a file ends within 380-780 nm.
        unit: of its values, per nm; empty where they are relative.
    """

    lines: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    spectrum: Spectrum
    unit: str


def describe(name_or_path: str) -> Description:
    """Describe a spectrum.

    Args:
        name_or_path: as for :func:`rtbow.world.measured.spectra.load_spectrum`.

    Raises:
        InputError: as there, but a file may end within 380-780 nm.
    """
    if name_or_path in spectrum_names():
        spectrum = load_spectrum(name_or_path)
        nm = spectrum.wavelength_nm
        steps = np.diff(nm)
        quantity = "irradiance" if spectrum.absolute else "relative"
        values = "W m-2 nm-1 (irradiance)" if spectrum.absolute else "relative"
        lines = [
            ("spectrum", f"{name_or_path}, built in"),
            ("values", values),
            ("range", _range((nm[0], nm[-1]), len(nm), (steps.min(), steps.max()))),
        ]
        notes: tuple[str, ...] = ()
    else:
        measured = load_measured(name_or_path, "zero")
        spectrum, quantity, notes = measured.spectrum, measured.unit.quantity, measured.notes
        lines = _file_lines(name_or_path, measured)
    lines += _colour_lines(spectrum)
    lines.append(_strength(spectrum, quantity))
    if quantity != "relative" and not spectrum.absolute:
        lines.append(
            ("in a scene", "the light's irradiance_w_m2 or luminous_flux_lm counts instead")
        )
    unit = _STRENGTHS[quantity][0] + " per nm" if quantity in _STRENGTHS else ""
    return Description(tuple(lines), notes, spectrum, unit)


def spectrum_list() -> list[str]:
    """List the spectra known by name, a line each: what it is, colour temperature and rendering."""
    names = sorted(spectrum_names(), key=_series_and_numbers)
    width = max(map(len, names))
    return [
        f"{name:<{width}}  {spectrum_description(name)}, {kelvin:.0f} K, Ra {ra:.0f}"
        for name, kelvin, ra in zip(names, *_qualities(names), strict=True)
    ]


def _qualities(names: list[str]) -> tuple[Array, Array]:
    """Give correlated colour temperatures, K, and colour rendering indices Ra.

    Both as the CIE has them, by sums at steps of 5 nm; kept in the cache.
    """
    nm = np.arange(VISIBLE_NM[0], VISIBLE_NM[1] + 1.0, 5.0)
    spectra = [load_spectrum(name) for name in names]
    powers = np.stack([np.interp(nm, one.wavelength_nm, one.value) for one in spectra])

    def build() -> dict[str, Array]:
        observer_nm, observer = colour_matching()
        sums = powers @ observer[np.searchsorted(observer_nm, nm)]
        shares = sums / sums.sum(axis=1, keepdims=True)
        found = [colour_temperature((x, y)) for x, y, _ in shares.tolist()]
        kelvin = [np.nan if one is None else one[0] for one in found]
        return {"kelvin": floats(kelvin), "ra": colour_rendering(nm, powers)}

    code = source_digest("study.spectra", "physics.light")
    digest = hashlib.sha256(powers.tobytes()).hexdigest()
    kept = cached_arrays("colour-quality", f"{version('colour-science')} {code} {digest}", build)
    return kept["kelvin"], kept["ra"]


def _series_and_numbers(name: str) -> tuple[bool, str, list[int]]:
    """Sort rtbow's own names first, and FL2 before FL10."""
    return (
        name in illuminant_names(),
        re.split(r"\d", name)[0],
        [*map(int, re.findall(r"\d+", name))],
    )


def _range(ends: tuple[float, float], count: int, steps: tuple[float, float]) -> str:
    low, high = steps
    step = f"steps of {low:.4g}" if high - low < 1e-4 * high else f"steps of {low:.4g}-{high:.4g}"
    return f"{ends[0]:.8g}-{ends[1]:.8g} nm, {count} points, {step} nm"


def _file_lines(name_or_path: str, measured: Measured) -> list[tuple[str, str]]:
    unit = measured.unit
    kind = "" if unit.quantity == "relative" else f" ({unit.quantity})"
    column = f", column {measured.column[:40]!r}" if measured.column else ""
    lines = [
        ("spectrum", name_or_path),
        ("format", f"{measured.format}{column}"),
        (
            "abscissa",
            measured.abscissa + ("" if measured.stated else " (not named with its column)"),
        ),
        ("values", f"{unit.text[:40]}{kind}"),
        ("range", _range(measured.range_nm, measured.count, measured.steps_nm)),
    ]
    if measured.range_nm[0] > VISIBLE_NM[0] or measured.range_nm[1] < VISIBLE_NM[1]:
        lines.append(
            ("beyond", "taken as zero here; in a scene, the light's key beyond: zero or hold")
        )
    return lines


def _colour_lines(spectrum: Spectrum) -> list[tuple[str, str]]:
    xyz = colour_weights(spectrum, wavelength_bins(5.0)).sum(axis=0)
    x, y = xyz[:2] / xyz.sum()
    lines = [("chromaticity", f"x {x:.4f}, y {y:.4f} (CIE 1931)")]
    temperature = colour_temperature((float(x), float(y)))
    if temperature is None:
        text = "none: too far from the colours of black bodies"
    else:
        text = f"{temperature[0]:.0f} K, Duv {temperature[1]:+.4f} (correlated, Ohno 2013)"
    return [*lines, ("temperature", text)]


def colour_temperature(xy: tuple[float, float]) -> tuple[float, float] | None:
    """Give a chromaticity's correlated colour temperature in K, and its Duv.

    Args:
        xy: CIE 1931 x and y.

    Returns:
        Temperature and distance from the Planckian locus in CIE 1960 u, v, positive above it;
        None where it is beyond 0.05 or 1000-100,000 K.

    Source: colour-science, Ohno (2013).
    """
    from colour.models import xy_to_UCS_uv
    from colour.temperature import uv_to_CCT_Ohno2013

    kelvin, duv = uv_to_CCT_Ohno2013(xy_to_UCS_uv(np.array(xy)))
    sensible = 1000.0 < kelvin < 100_000.0 and abs(duv) <= _FARTHEST_DUV
    return (float(kelvin), float(duv)) if sensible else None


def _strength(spectrum: Spectrum, quantity: str) -> tuple[str, str]:
    efficacy = luminous(spectrum) / spectrum.visible
    if quantity not in _STRENGTHS:
        return "efficacy", f"{efficacy:.1f} lm/W over {_VISIBLE}; the values have no absolute unit"
    power, light, name = _STRENGTHS[quantity]
    return (
        quantity,
        f"{spectrum.visible:.6g} {power} over {_VISIBLE}, {name} {luminous(spectrum):.6g} {light}",
    )


def draw_spectrum(path: Path, description: Description) -> None:
    """Draw a spectrum over 380-780 nm, ``.png`` or ``.svg``.

    Raises:
        InputError: the file cannot be written.
    """
    nm, values = _drawn(description.spectrum)
    with style():
        figure = new_figure(7.0, 4.0)
        axes = figure.subplots()
        axes.plot(nm, values, color=COLOURS[2])
        axes.set(
            xlim=VISIBLE_NM, ylim=(0.0, None), xlabel="wavelength, nm",
            ylabel=description.unit or "relative, per nm", title=description.spectrum.name[-60:],
        )  # fmt: skip
        axes.grid(color=GRID_GREY, linewidth=0.6)
        caption(
            figure,
            "; ".join(
                f"{label} {text}" for label, text in description.lines if label in _CAPTIONED
            ),
        )
        save(figure, path)


def _drawn(spectrum: Spectrum) -> tuple[Array, Array]:
    """Give the points of a spectrum within 380-780 nm, and its values at these ends."""
    nm = spectrum.wavelength_nm
    inside = nm[(nm > VISIBLE_NM[0]) & (nm < VISIBLE_NM[1])]
    at = np.concatenate([[VISIBLE_NM[0]], inside, [VISIBLE_NM[1]]])
    return at, np.interp(at, nm, spectrum.value, left=0.0, right=0.0)
