"""Charts of the scattering tables: what they assume, and profiles over the scattering angle.

The numbers come from the look-ups that all methods use, and are computed (:func:`profiles`) apart
from their drawing (:func:`draw_profiles`). Lee diagrams have a module of their own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from rtbow.base.arrays import Array, Progress, floats, no_progress
from rtbow.base.errors import InputError
from rtbow.base.limits import MAX_DISC_DEG, MAX_RADIUS_UM, MIN_RADIUS_UM, SIZE_SPREADS, WATER_C
from rtbow.frames.plot import COLOURS, GREY, GRID_GREY, caption, legend, new_figure, save, style
from rtbow.physics.constants import SUN_DIAMETER_DEG, VISIBLE_NM
from rtbow.physics.drop.airy import SCALE_POWER, bow
from rtbow.physics.drop.water import relative_index
from rtbow.tables.sections import Sections, Theory, water_sections

Component = Literal["mean", "perpendicular", "parallel"]
Scale = Literal["linear", "log"]

THEORY_NAMES: dict[Theory, str] = {"airy": "Airy", "mie": "Mie"}
PROFILE_FROM_DEG: dict[Scale, float] = {"linear": 115.0, "log": 0.0}
"""Profiles start here: short of the secondary bow, or at the sun where faint light shows, too."""

_SPREAD_PERCENT = (100.0 * SIZE_SPREADS[0], 100.0 * SIZE_SPREADS[1])
_AIRY_FIRST_DARK = 2.338107
"""The first zero of Ai(-z): the dark fringe behind the bow."""

# --- What is charted ---------------------------------------------------------------------------


def _check(option: str, value: float, low: float, high: float, unit: str) -> None:
    """Raise InputError unless an option's value is within its range."""
    if not low <= value <= high:  # NaN too
        raise InputError(f"{option}: {value:g} is not allowed; must be {low:g}..{high:g} {unit}")


def check_range(
    options: tuple[str, str], ends: tuple[float, float], low: float, high: float, unit: str
) -> None:
    """Raise InputError unless two options, typed as ``ends``, make a range from low to high."""
    for option, end in zip(options, ends, strict=True):
        _check(option, end, low, high, unit)
    if not ends[0] < ends[1]:
        raise InputError(
            f"{options[0]} {ends[0]:g} is not below {options[1]} {ends[1]:g} {unit}: the range is"
            f" empty; give {options[0]} a smaller number, or {options[1]} a greater one"
        )


def check_angles(theta_deg: tuple[float, float]) -> None:
    """Raise InputError unless scattering angles make a range."""
    check_range(("--from-deg", "--to-deg"), theta_deg, 0.0, 180.0, "deg")


@dataclass(frozen=True)
class Setup:
    """What a chart assumes about drops and light.

    Attributes:
        theories: the theories that are charted, in the order of drawing.
        disc_deg: angular diameter of the light's disc, 0..5.
        spread_percent: standard deviation of ln(radius) times 100 (mie), 1..20.
        temperature_c: of the water, -12..60.
    """

    theories: tuple[Theory, ...] = ("airy",)
    disc_deg: float = SUN_DIAMETER_DEG
    spread_percent: float = 2.0
    temperature_c: float = 20.0

    def __post_init__(self) -> None:
        _check("--disc", self.disc_deg, 0.0, MAX_DISC_DEG, "deg")
        _check("--spread", self.spread_percent, *_SPREAD_PERCENT, "percent")
        _check("--temperature", self.temperature_c, *WATER_C, "°C")

    @property
    def disc_rad(self) -> float:
        """Angular radius of the light's disc."""
        return math.radians(0.5 * self.disc_deg)

    def sections(
        self, theory: Theory, nm: Array, radii_um: tuple[float, float], progress: Progress
    ) -> Sections:
        """Give the cross-sections of one theory (:func:`rtbow.tables.sections.water_sections`)."""
        spread = round(self.spread_percent * 0.01, 9)  # 2 % is 0.02 to the last digit
        return water_sections(
            theory, nm, self.temperature_c, radii_um, spread=spread, progress=progress
        )

    @property
    def caption(self) -> str:
        """The words below a chart."""
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
        component: the polarisation; ``mean`` is that of unpolarised light.
        radius_um: drop radii (R,).
        wavelength_nm: wavelengths in air (W,).
        theta_deg: scattering angles (U,).
        values: cross-sections by theory, m² sr⁻¹, (R, W, U).
        mie_peak: the greatest value of Mie's primary bow, m² sr⁻¹, (R, W); None without Mie.
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
        component: the polarisation.
        progress: wraps the loop over the parts of a table that must be built.

    Raises:
        InputError: a value is out of its range.
    """
    radii, nm = tuple(dict.fromkeys(radius_um)), tuple(dict.fromkeys(wavelength_nm))
    for option, numbers, low, high, unit in (
        ("--radius-um", radii, MIN_RADIUS_UM, MAX_RADIUS_UM, "um"),
        ("--wavelength-nm", nm, *VISIBLE_NM, "nm"),
    ):
        for number in numbers:
            _check(option, number, low, high, unit)
    if not 0 < len(radii) * len(nm) <= len(COLOURS):
        raise InputError(
            f"--radius-um, --wavelength-nm: {len(radii)} x {len(nm)} are {len(radii) * len(nm)}"
            f" curves; must be 1..{len(COLOURS)}, so that each has a colour of its own"
        )
    check_angles(theta_deg)
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
    """Give the greatest value from Descartes' angle to Airy's first dark fringe, (R, W)."""
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


# --- Drawing -----------------------------------------------------------------------------------


def opposite(angle_deg: Any) -> Any:
    """Turn a scattering angle into one from the antisolar point, or back, degrees."""
    return 180.0 - angle_deg


def _in_powers(values: Array) -> tuple[float, str]:
    """Give a power of ten for an axis that starts at 0, and the unit with it."""
    power = math.floor(math.log10(values.max())) if values.max() > 0.0 else 0
    digits = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return 10.0**power, f"10{digits} m² sr⁻¹"


def _curves(data: Profiles) -> list[tuple[int, int, str]]:
    """List every radius's and wavelength's index, with the colour of their curve."""
    pairs = [(r, w) for r in range(len(data.radius_um)) for w in range(len(data.wavelength_nm))]
    return [(r, w, colour) for (r, w), colour in zip(pairs, COLOURS, strict=False)]


def _line(data: Profiles, theory: Theory, colour: str, scale: Scale) -> dict[str, Any]:
    """Give a curve's line: its colour stands for radius and wavelength, dashes for Airy."""
    # Thin where fringes stand close: from the sun to the antisolar point in one panel.
    width = 1.4 if scale == "linear" else 1.0
    if theory == "mie" or len(data.values) == 1:
        return {"color": colour, "lw": width}
    alone = len(data.radius_um) * len(data.wavelength_nm) == 1
    return {"color": COLOURS[1] if alone else colour, "lw": width, "ls": (0, (4.0, 1.6))}


def _draw_panel(axis: Any, data: Profiles, radii: Sequence[int], scale: Scale) -> None:
    shown = floats(np.stack([v[list(radii)] for v in data.values.values()]))
    factor, unit = _in_powers(shown) if scale == "linear" else (1.0, "m² sr⁻¹")
    # Mie first: a line hides the dashes below it, dashes do not hide the line.
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
        # In the shadow, Airy's light falls off without end, Mie's does not.
        least = data.values["mie"].min() if "mie" in data.values else 1e-5 * shown.max()
        axis.set_ylim(0.5 * least, 2.0 * shown.max())
    axis.set_ylabel(f"cross-section, {unit}")


def _name(data: Profiles, r: int, w: int, theory: Theory | None) -> str:
    """Name a curve in a legend."""
    parts = [THEORY_NAMES[theory]] if theory else []
    return ", ".join([*parts, f"{data.radius_um[r]:g} µm", f"{data.wavelength_nm[w]:g} nm"])


def draw_profiles(path: Path, data: Profiles, scale: Scale, difference: bool) -> None:
    """Draw cross-sections against the angle: ``.png`` or ``.svg``, whole or not at all.

    Args:
        path: the file.
        data: what to draw.
        scale: the scale of the cross-section. A linear one has a panel for each radius, since the
            cross-sections of different radii differ by orders of magnitude.
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
        top = grid[0].secondary_xaxis("top", functions=(opposite, opposite))
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
