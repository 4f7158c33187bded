"""Charts of the scattering table: angle profiles, and Lee diagrams of the colours of drops.

What is drawn is computed apart from the drawing (:func:`profiles`, :func:`lee_raster`), by the
look-ups that everything else uses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import (
    Array,
    Progress,
    floats,
    no_progress,
)
from rtbow.base.errors import InputError
from rtbow.base.limits import (
    MAX_DISC_DEG,
    MAX_RADIUS_UM,
    MIN_RADIUS_UM,
    SIZE_SPREADS,
    WATER_C,
)
from rtbow.frames.display import auto_exposure_ev, display
from rtbow.frames.plot import (
    COLOURS,
    GREY,
    GRID_GREY,
    PLOT_SUFFIXES,
    caption,
    legend,
    new_figure,
    save,
    style,
)
from rtbow.physics.constants import SUN_DIAMETER_DEG, VISIBLE_NM
from rtbow.physics.drop.airy import SCALE_POWER, bow
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.tables.sections import Sections, Theory, water_sections
from rtbow.world.spectra import E490, load_spectrum

Component = Literal["mean", "perpendicular", "parallel"]
Scale = Literal["linear", "log"]
Normalise = Literal["column", "none"]

CHART_SUFFIXES = PLOT_SUFFIXES
PROFILE_FROM_DEG: dict[Scale, float] = {"linear": 115.0, "log": 0.0}
"""Where profiles start: at the secondary bow, or, where its light still shows, at the sun."""
LEE_DEG = (135.0, 147.0)
"""Scattering angles of a Lee diagram: the primary bow of all drops from 10 µm."""
LEE_SIZE = (300, 400)
"""Radii and angles of a Lee diagram's raster."""
MAX_LEE_SIDE = 4000
LEE_STEP_NM = 5.0

_SPREAD_PERCENT = (100.0 * SIZE_SPREADS[0], 100.0 * SIZE_SPREADS[1])
_AIRY_FIRST_DARK = 2.338107
"""First zero of Ai(-z): the dark fringe behind the bow."""
_NAMES: dict[Theory, str] = {"airy": "Airy", "mie": "Mie"}

# --- What is charted ---------------------------------------------------------------------------


def _require(option: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:  # NaN too
        raise InputError(f"{option}: {value:g} is not allowed; must be {low:g}..{high:g} {unit}")


def _require_range(
    options: tuple[str, str], ends: tuple[float, float], low: float, high: float, unit: str
) -> None:
    for option, end in zip(options, ends, strict=True):
        _require(option, end, low, high, unit)
    if not ends[0] < ends[1]:
        raise InputError(
            f"{options[0]} {ends[0]:g} is not below {options[1]} {ends[1]:g} {unit}: the range is"
            f" empty; give {options[0]} a smaller number, or {options[1]} a greater one"
        )


def _require_angles(theta_deg: tuple[float, float]) -> None:
    _require_range(("--from-deg", "--to-deg"), theta_deg, 0.0, 180.0, "deg")


@dataclass(frozen=True)
class Setup:
    """What a chart assumes about drops and light.

    Attributes:
        theories: which are charted, in the order of drawing.
        disc_deg: angular diameter of the light's disc, 0..5.
        spread_percent: standard deviation of ln(radius) times 100 (mie), 1..20.
        temperature_c: of the water, -12..60.
    """

    theories: tuple[Theory, ...] = ("airy",)
    disc_deg: float = SUN_DIAMETER_DEG
    spread_percent: float = 2.0
    temperature_c: float = 20.0

    def __post_init__(self) -> None:
        _require("--disc", self.disc_deg, 0.0, MAX_DISC_DEG, "deg")
        _require("--spread", self.spread_percent, *_SPREAD_PERCENT, "percent")
        _require("--temperature", self.temperature_c, *WATER_C, "°C")

    @property
    def disc_rad(self) -> float:
        """Angular radius of the light's disc."""
        return math.radians(0.5 * self.disc_deg)

    def sections(
        self, theory: Theory, nm: Array, radii_um: tuple[float, float], progress: Progress
    ) -> Sections:
        """Give the cross-sections by one theory (:func:`rtbow.tables.sections.water_sections`)."""
        spread = round(self.spread_percent * 0.01, 9)  # 2 % is 0.02 to the last digit
        return water_sections(
            theory, nm, self.temperature_c, radii_um, spread=spread, progress=progress
        )

    @property
    def caption(self) -> str:
        """What stands below a chart."""
        parts = []
        if "airy" in self.theories:
            parts.append("Airy: primary and secondary bow, drops of one size")
        if "mie" in self.theories:
            parts.append(f"Mie: all light, sizes spread by {self.spread_percent:g} % (σ of ln a)")
        disc = f"light {self.disc_deg:g}° across" if self.disc_deg else "light from a point"
        return "; ".join([*parts, f"water at {self.temperature_c:g} °C in air", disc])


@dataclass(frozen=True)
class Profiles:
    """Cross-sections against the scattering angle.

    Attributes:
        setup: drops and light.
        component: which polarisation; ``mean`` is what unpolarised light meets.
        radius_um: drop radii (R,).
        wavelength_nm: wavelengths in air (W,).
        theta_deg: scattering angles (U,).
        values: for each theory, m² sr⁻¹, (R, W, U).
        mie_peak: greatest value of Mie's primary bow, m² sr⁻¹, (R, W); None without Mie.
    """

    setup: Setup
    component: Component
    radius_um: tuple[float, ...]
    wavelength_nm: tuple[float, ...]
    theta_deg: Array
    values: dict[Theory, Array]
    mie_peak: Array | None

    @property
    def difference(self) -> Array:
        """Airy minus Mie as a share of Mie's primary peak, (R, W, U)."""
        assert self.mie_peak is not None
        return floats((self.values["airy"] - self.values["mie"]) / self.mie_peak[..., None])


def _component(values: Array, component: Component) -> Array:
    if component == "mean":
        return floats(values.mean(axis=-1))
    return floats(values[..., ("perpendicular", "parallel").index(component)])


def profiles(
    setup: Setup,
    radius_um: Sequence[float],
    wavelength_nm: Sequence[float],
    theta_deg: tuple[float, float],
    component: Component = "mean",
    progress: Progress = no_progress,
) -> Profiles:
    """Look up cross-sections over a range of scattering angles.

    Args:
        setup: drops and light.
        radius_um: drop radii (R,).
        wavelength_nm: wavelengths in air (W,).
        theta_deg: first and last scattering angle.
        component: which polarisation.
        progress: wraps the parts of a table that must be built.

    Raises:
        InputError: a value outside of its range.
    """
    radii, nm = tuple(dict.fromkeys(radius_um)), tuple(dict.fromkeys(wavelength_nm))
    for option, numbers, low, high, unit in (
        ("--radius-um", radii, MIN_RADIUS_UM, MAX_RADIUS_UM, "um"),
        ("--wavelength-nm", nm, *VISIBLE_NM, "nm"),
    ):
        for number in numbers:
            _require(option, number, low, high, unit)
    if not 0 < len(radii) * len(nm) <= len(COLOURS):
        raise InputError(
            f"--radius-um, --wavelength-nm: {len(radii)} x {len(nm)} are {len(radii) * len(nm)}"
            f" curves; must be 1..{len(COLOURS)}, so that each has a colour of its own"
        )
    _require_angles(theta_deg)
    # Finer than the fringes, and in a narrow range finer than a picture's pixels.
    steps = max(2000, round((theta_deg[1] - theta_deg[0]) / 0.01))
    angles = np.linspace(*theta_deg, steps + 1)
    radius_m = floats(radii) * 1e-6
    values: dict[Theory, Array] = {}
    peak = None
    for theory in setup.theories:
        sections = setup.sections(theory, floats(nm), (min(radii), max(radii)), progress)
        both = sections.sections(radius_m, np.radians(angles), setup.disc_rad)
        values[theory] = _component(both, component)
        if theory == "mie":
            peak = _primary_peak(setup, sections, radius_m, floats(nm), component)
    return Profiles(setup, component, radii, nm, floats(angles), values, peak)


def _primary_peak(
    setup: Setup, sections: Sections, radius_m: Array, nm: Array, component: Component
) -> Array:
    """Greatest value from Descartes' angle to Airy's first dark fringe, (R, W)."""
    primary = bow(1, nm * 1e-9, relative_index(nm, setup.temperature_c))
    peak = np.empty((len(radius_m), len(nm)))
    for r, radius in enumerate(radius_m):
        width = _AIRY_FIRST_DARK / (primary.scale * radius**SCALE_POWER)
        for w in range(len(nm)):
            start = float(primary.angle_rad[w])
            end = min(start + float(width[w]) + setup.disc_rad, np.pi)
            theta = np.linspace(start - setup.disc_rad, end, 801)
            both = sections.sections(radius_m[r : r + 1], theta, setup.disc_rad)
            peak[r, w] = _component(both, component)[0, w].max()
    return peak


@dataclass(frozen=True)
class LeeRaster:
    """The colours of light from drops, over radius and scattering angle.

    Attributes:
        setup: drops and light.
        radius_um: ends of the range; columns lie evenly in its logarithm.
        theta_deg: ends of the range; rows lie evenly in it.
        xyz: for each theory, X, Y, Z of the light that one drop sends in a direction, in lm/sr
            under sunlight of E490 (R, U, 3): columns by increasing radius, rows by increasing
            scattering angle, each at the middle of its cell.
    """

    setup: Setup
    radius_um: tuple[float, float]
    theta_deg: tuple[float, float]
    xyz: dict[Theory, Array]

    def relative(self, normalise: Normalise) -> dict[Theory, Array]:
        """Give X, Y, Z weighted for display, of the shape of ``xyz``.

        ``column``: every radius to a greatest Y of 1 in this range of angles, as Lee does.
        ``none``: per area of the drop, a², to a greatest Y of 1 over all theories: what the same
        area of drops of each size sends.
        """
        if normalise == "column":
            return {
                t: floats(xyz / xyz[..., 1].max(axis=1)[:, None, None])
                for t, xyz in self.xyz.items()
            }
        radius = _cells_log(*self.radius_um, len(next(iter(self.xyz.values()))))
        per_area = {t: xyz / (radius**2)[:, None, None] for t, xyz in self.xyz.items()}
        greatest = max(float(each[..., 1].max()) for each in per_area.values())
        return {t: floats(each / greatest) for t, each in per_area.items()}

    def pictures(self, normalise: Normalise) -> dict[Theory, NDArray[np.uint8]]:
        """Give sRGB pictures (U, R, 3), small scattering angles on top, all exposed alike."""
        rgb = {t: xyz_to_rgb(xyz).transpose(1, 0, 2) for t, xyz in self.relative(normalise).items()}
        exposure = auto_exposure_ev(np.concatenate(list(rgb.values()), axis=1))
        return {t: display(frame, exposure) for t, frame in rgb.items()}


def _cells(low: float, high: float, count: int) -> Array:
    """Middles of equal cells between two numbers (count,)."""
    return floats(low + (np.arange(count) + 0.5) * ((high - low) / count))


def _cells_log(low: float, high: float, count: int) -> Array:
    return floats(np.exp(_cells(math.log(low), math.log(high), count)))


def lee_raster(
    setup: Setup,
    radius_um: tuple[float, float],
    theta_deg: tuple[float, float],
    size: tuple[int, int] = LEE_SIZE,
    progress: Progress = no_progress,
) -> LeeRaster:
    """Compute the colours of sunlight from drops, over radius and scattering angle.

    Args:
        setup: drops and light.
        radius_um: least and greatest radius.
        theta_deg: least and greatest scattering angle.
        size: radii and angles of the raster.
        progress: wraps the loop over radii, and one over parts of a table that must be built.

    Raises:
        InputError: a value outside of its range.

    Source: R. L. Lee, Applied Optics 37, 1506 (1998).
    """
    limits = (MIN_RADIUS_UM, MAX_RADIUS_UM)
    _require_range(("--radius-from", "--radius-to"), radius_um, *limits, "um")
    _require_angles(theta_deg)
    for side in size:
        if not 2 <= side <= MAX_LEE_SIDE:
            raise InputError(
                f"--size {size[0]}x{size[1]}: must be 2..{MAX_LEE_SIDE} radii and as many angles"
            )
    bins = wavelength_bins(LEE_STEP_NM)
    weights = colour_weights(load_spectrum(E490), bins)
    radius_m = _cells_log(*radius_um, size[0]) * 1e-6
    theta = np.radians(_cells(*theta_deg, size[1]))
    xyz: dict[Theory, Array] = {}
    # Some radii at a time: their spectra are many times the size of their colours.
    block = max(1, 16_384 // size[1])
    for theory in setup.theories:
        sections = setup.sections(theory, bins.wavelength_nm, radius_um, progress)
        xyz[theory] = np.empty((*size, 3))
        for start in progress(range(0, size[0], block)):
            part = slice(start, start + block)
            mean = _component(sections.sections(radius_m[part], theta, setup.disc_rad), "mean")
            xyz[theory][part] = np.einsum("rwu,wc->ruc", mean, weights)
    return LeeRaster(setup, radius_um, theta_deg, xyz)


# --- Drawing -----------------------------------------------------------------------------------


def _opposite(angle_deg: Any) -> Any:
    """From the scattering angle to the angle from the antisolar point, and back."""
    return 180.0 - angle_deg


def _in_powers(values: Array) -> tuple[float, str]:
    """Give a power of ten for an axis that starts at 0, and the unit with it."""
    power = math.floor(math.log10(values.max())) if values.max() > 0.0 else 0
    digits = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return 10.0**power, f"10{digits} m² sr⁻¹"


def _curves(data: Profiles) -> list[tuple[int, int, str]]:
    """Every radius and wavelength, and the colour of its curve."""
    pairs = [(r, w) for r in range(len(data.radius_um)) for w in range(len(data.wavelength_nm))]
    return [(r, w, colour) for (r, w), colour in zip(pairs, COLOURS, strict=False)]


def _line(data: Profiles, theory: Theory, colour: str, scale: Scale) -> dict[str, Any]:
    """Give a curve's line: colour tells which curve, dashes which theory."""
    # Thin where fringes stand close: from the sun to the antisolar point in one panel.
    width = 1.4 if scale == "linear" else 1.0
    if theory == "mie" or len(data.values) == 1:
        return {"color": colour, "lw": width}
    alone = len(data.radius_um) * len(data.wavelength_nm) == 1
    return {"color": COLOURS[1] if alone else colour, "lw": width, "ls": (0, (4.0, 1.6))}


def _draw_panel(axis: Any, data: Profiles, radii: Sequence[int], scale: Scale) -> None:
    shown = floats(np.stack([v[list(radii)] for v in data.values.values()]))
    factor, unit = _in_powers(shown) if scale == "linear" else (1.0, "m² sr⁻¹")
    # Mie below Airy: dashes on a line can be seen, a line on dashes hides them.
    for theory in sorted(data.values, reverse=True):
        for r, w, colour in _curves(data):
            if r in radii:
                values = data.values[theory][r, w] / factor
                label = _name(data, r, w, theory)
                axis.plot(data.theta_deg, values, label=label, **_line(data, theory, colour, scale))
    if scale == "linear":
        axis.set_ylim(0.0, 1.05 * shown.max() / factor)
    else:
        axis.set_yscale("log")
        # Airy's shadow falls without end; what Mie has there does not.
        least = data.values["mie"].min() if "mie" in data.values else 1e-5 * shown.max()
        axis.set_ylim(0.5 * least, 2.0 * shown.max())
    axis.set_ylabel(f"cross-section, {unit}")


def _name(data: Profiles, r: int, w: int, theory: Theory | None) -> str:
    """Name a curve in a legend."""
    parts = [_NAMES[theory]] if theory else []
    return ", ".join([*parts, f"{data.radius_um[r]:g} µm", f"{data.wavelength_nm[w]:g} nm"])


def draw_profiles(path: Path, data: Profiles, scale: Scale, difference: bool) -> None:
    """Draw cross-sections against the angle: ``.png`` or ``.svg``, whole or not at all.

    Args:
        path: where to.
        data: what to draw.
        scale: of the cross-section. Linear draws a panel for each radius, since sizes differ by
            orders of magnitude.
        difference: whether to add a panel of Airy minus Mie.
    """
    every = range(len(data.radius_um))
    panels = [[r] for r in every] if scale == "linear" else [list(every)]
    heights = [1.0 if len(panels) > 1 else 1.4] * len(panels) + [0.8] * difference
    with style():
        figure = new_figure(9.0, 1.3 + 2.6 * sum(heights))
        grid = figure.subplots(
            len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
        )[:, 0]
        for axis, radii in zip(grid, panels, strict=False):
            _draw_panel(axis, data, radii, scale)
            legend(axis, 2 if len(axis.lines) > 6 else 1)
        if difference:
            _draw_difference(grid[-1], data)
        for axis in grid:
            axis.grid(color=GRID_GREY, lw=0.6)
            axis.set_axisbelow(True)
        grid[-1].set_xlim(data.theta_deg[0], data.theta_deg[-1])
        grid[-1].set_xlabel("scattering angle, degrees")
        top = grid[0].secondary_xaxis("top", functions=(_opposite, _opposite))
        top.set_xlabel("angle from the antisolar point, degrees")
        light = {
            "mean": "unpolarised light (mean of both components)",
            "perpendicular": "component perpendicular to the scattering plane",
            "parallel": "component parallel to the scattering plane",
        }[data.component]
        caption(figure, f"Differential cross-section of one drop, {light}. {data.setup.caption}")
        save(figure, path)


def _draw_difference(axis: Any, data: Profiles) -> None:
    for r, w, colour in _curves(data):
        percent = 100.0 * data.difference[r, w]
        axis.plot(data.theta_deg, percent, color=colour, lw=1.1, label=_name(data, r, w, None))
    axis.axhline(0.0, color=GREY, lw=0.6)
    axis.set_ylabel("Airy − Mie,\n% of Mie's primary peak")
    if len(axis.lines) > 2:
        legend(axis, 2)


def draw_lee(path: Path, data: LeeRaster, normalise: Normalise) -> None:
    """Draw a Lee diagram for each theory, side by side: ``.png`` or ``.svg``, whole or not at all.

    Args:
        path: where to.
        data: the colours.
        normalise: see :meth:`LeeRaster.relative`.
    """
    pictures = data.pictures(normalise)
    low, high = data.theta_deg
    with style():
        figure = new_figure(1.2 + 4.4 * len(pictures), 5.6)
        grid = figure.subplots(1, len(pictures), sharey=True, squeeze=False)[0]
        for axis, (theory, picture) in zip(grid, pictures.items(), strict=True):
            # In the axes' own coordinates: data coordinates would be logarithmic, which images
            # do not follow, while columns of this one are even in the logarithm already.
            axis.imshow(
                picture,
                extent=(0.0, 1.0, 0.0, 1.0),
                transform=axis.transAxes,
                aspect="auto",
                interpolation="bilinear",
            )
            _log_radius_axis(axis, data.radius_um)
            axis.set_ylim(180.0 - high, 180.0 - low)
            axis.set_title(_NAMES[theory], fontsize=11)
            axis.tick_params(direction="out")
        grid[0].set_ylabel("angle from the antisolar point, degrees")
        right = grid[-1].secondary_yaxis("right", functions=(_opposite, _opposite))
        right.set_ylabel("scattering angle, degrees")
        weight = {
            "column": "each radius to its own greatest luminance",
            "none": "luminance per area of drop",
        }[normalise]
        caption(
            figure,
            "Lee diagram: colour of sunlight (ASTM E-490) from drops of one radius, CIE 1931 2°,"
            f" sRGB, {weight}. {data.setup.caption}",
        )
        save(figure, path)


def _log_radius_axis(axis: Any, radius_um: tuple[float, float]) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_xscale("log")
    axis.set_xlim(*radius_um)
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(LogLocator(subs=tuple(range(1, 10))))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.set_xlabel("drop radius, µm")
