"""Phase functions of drops in the forms that other renderers read: Mitsuba's, and a texture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Progress, no_progress
from rtbow.base.errors import InputError
from rtbow.base.exr import write_exr_channels
from rtbow.base.files import write_atomic
from rtbow.base.version import __version__
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.physics.light.spectrum import Spectrum, colour_weights, wavelength_bins
from rtbow.tables.export import PlainTable

MITSUBA_NODES = 20_001
"""Even steps of the cosine of 1e-4 are 0.01 degrees at the bows."""
TEXTURE_CELLS = 4_000
"""Cells of 0.045 degrees: a twelfth of the sun."""

_MITSUBA = """\
<?xml version="1.0" encoding="utf-8"?>
<!--
    Water drops of {radius:g} um at {nm:g} nm, theory {theory}, light's disc {disc:g} deg; rtbow {version}.
    Per drop: extinction {extinction:.6g} m2, scattered by what this phase function holds
    {scattering:.6g} m2. A medium of n drops per cubic metre has
        sigma_t = n * {extinction:.6g} 1/m, albedo = {albedo:.6g}.
    Include this file, then refer to it inside the medium: <ref id="drops"/>
-->
<scene version="3.0.0">
    <phase type="tabphase" id="drops">
        <string name="values" value="{values}"/>
    </phase>
</scene>
"""  # noqa: E501


def _one(name: str, values: tuple[float, ...]) -> float:
    if len(values) != 1:
        raise InputError(
            f"{name}: gives {len(values)} numbers; Mitsuba's phase function has no colour and one"
            " size: give one number, and write a file for each"
        )
    return values[0]


def write_mitsuba(path: Path, wanted: PlainTable, building: Progress = no_progress) -> None:
    """Write a phase function for Mitsuba 3 (``tabphase``), whole or not at all.

    ``.xml`` is a fragment to include; ``.txt`` holds the values alone, from the backward direction
    (cosine -1) to the forward one at even steps of the cosine, separated by commas. Each is the
    mean about its node, so that the forward peak keeps its share: it fills the last step, 0.8
    degrees wide, and is flat within.

    Args:
        path: the file.
        wanted: one radius and one wavelength; ``angles`` is the number of values.
        building: wraps the loop over parts of an exact table that has to be built first.

    Raises:
        InputError: several radii or wavelengths, or the file cannot be written.
    """
    radius, nm = (
        _one("--radius-um", (*wanted.radius_um,)),
        _one("--wavelength-nm", (*wanted.wavelength_nm,)),
    )
    scatterers = wanted.scatterers(building)
    radius_m = np.array([radius * 1e-6])
    nodes = scatterers.phase_nodes(float(radius_m[0]), wanted.angles or MITSUBA_NODES)[:, 0]
    values = ",".join(f"{value:.7g}" for value in nodes)
    if path.suffix.lower() == ".txt":
        write_atomic(path, f"{values}\n".encode())
        return
    extinction = float(scatterers.extinction(radius_m)[0, 0])
    scattering = float(scatterers.scattering(radius_m)[0, 0])
    text = _MITSUBA.format(
        radius=radius, nm=nm, theory=wanted.theory, disc=wanted.disc_deg, version=__version__,
        extinction=extinction, scattering=scattering, albedo=scattering / extinction, values=values,
    )  # fmt: skip
    write_atomic(path, text.encode())


def write_texture(
    path: Path,
    wanted: PlainTable,
    light: Spectrum,
    progress: Progress = no_progress,
    building: Progress = no_progress,
) -> None:
    """Write the phase function in colour as a texture, whole or not at all.

    Columns are even cells of the scattering angle, forward first, each the mean over its solid
    angle; rows are radii. Times the light's illuminance (lx) and the drops' optical depth by
    extinction, R, G, B are radiance scattered once, linear Rec. 709, with luminance in cd/m².

    Args:
        path: an ``.exr`` file.
        wanted: radii and wavelengths, evenly spaced ones over 380-780 nm; ``angles`` is the number
            of columns.
        light: that colours it.
        progress: wraps the loop over radii.
        building: wraps the loop over parts of an exact table that has to be built first.

    Raises:
        InputError: wavelengths that do not span the visible evenly, or the file cannot be written.
    """
    scatterers = wanted.scatterers(building)
    nm = scatterers.wavelength_nm
    bins = wavelength_bins(float(nm[1] - nm[0])) if len(nm) > 1 else None
    if (
        bins is None
        or len(bins.wavelength_nm) != len(nm)
        or np.abs(bins.wavelength_nm - nm).max() > 1e-6
    ):
        raise InputError(
            "--wavelength-nm: a texture sums over all that is visible; leave it out, or give 380"
            " to 780 at even steps"
        )
    radii_m = np.array(wanted.radius_um) * 1e-6
    cells = wanted.angles or TEXTURE_CELLS
    means = scatterers.cell_means(radii_m, cells, progress)
    weights = colour_weights(light, bins)
    extinction = scatterers.extinction(radii_m) @ weights[:, 1]  # of the light's luminance
    xyz = np.einsum("rwt,wk->rtk", means, weights) / extinction[:, None, None]
    rgb = xyz_to_rgb(xyz)
    total = 2.0 * math.pi * -np.diff(np.cos(np.linspace(0.0, math.pi, cells + 1))) @ xyz[..., 1].T
    write_exr_channels(
        path,
        {name: rgb[..., k].astype(np.float32) for k, name in enumerate("RGB")},
        {
            "content": "columns: even cells of the scattering angle, 0 to pi; rows: radius; values:"
            " phase function times albedo, sr-1",
            "radius_um": ",".join(f"{radius:g}" for radius in wanted.radius_um),
            "albedo": ",".join(f"{share:.6g}" for share in total),
            "light": light.name,
            "discDeg": f"{wanted.disc_deg:g}",
            "theory": wanted.theory,
            "extinction_m2": ",".join(f"{e / weights[:, 1].sum():.6g}" for e in extinction),
        },
    )
