"""The numbers of a frame: how bright it is, and of each sun's bows radius, width, contrast, colour.

They are the measures of :mod:`rtbow.frames.measures`, on means over rings about the antisolar
point; the paper's claims are judged by the same ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.frames import measures
from rtbow.frames.bows.places import orders_of
from rtbow.frames.measures import MeasureError, Profile
from rtbow.physics.drop.medium import Medium
from rtbow.physics.geometry import angle_between, box_span
from rtbow.physics.light.colour import luminance

if TYPE_CHECKING:
    from rtbow.world.camera.view import View
    from rtbow.world.world import World

BOW_NAMES = {1: "primary", 2: "secondary"}
"""Names of bows by number of internal reflections."""
MOST_PIXEL_DEG = 1.0
"""Pixels that are wider than this do not resolve a bow, which is 2 degrees wide."""

MOST_PIXELS = 2_000_000
"""Pixels that are averaged over rings; of larger frames every second row, third row and so on."""
FEW_PIXELS = 200_000
"""Pixels that do where radius and width alone are asked for, to three digits."""
_MIDDLE_NM = 550.0


Number = TypeVar("Number")


@dataclass(frozen=True)
class BowMeasures:
    """A bow of a sun in a frame; the names are the keys of ``--json``. None: cannot be measured.

    Angles are in degrees, radii from the antisolar point. The widths are full widths at half
    maximum (:func:`rtbow.frames.measures.full_width`), R, G and B are linear Rec. 709.

    Attributes:
        part: 0, or 1 for the right part of a split picture.
        light: the sun's key, such as ``light.0``.
        bow: ``primary`` or ``secondary``.
        radius_deg: of the peak of luminance.
        radius_rgb_deg: of the peaks of R, G and B.
        width_deg: of luminance.
        width_rgb_deg: of R, G and B.
        peak_luminance_cd_m2: mean along the peak, in rain of the picture's mean depth.
        contrast: of the peak with Alexander's band (:func:`rtbow.frames.measures.contrast`).
        chromaticity_uv: CIE 1976 u', v' of the mean within 1.5 degrees of the peak.
        supernumerary_maxima: how many there are; as the next two None where only radius and width
            were asked for.
        supernumerary_contrast: ripple of the logarithm of luminance (primary only).
        supernumerary_chroma: ripple of u', v' (primary only).
    """

    part: int
    light: str
    bow: str
    radius_deg: float
    radius_rgb_deg: tuple[float | None, float | None, float | None]
    width_deg: float | None
    width_rgb_deg: tuple[float | None, float | None, float | None]
    peak_luminance_cd_m2: float | None
    contrast: float | None
    chromaticity_uv: tuple[float, float] | None
    supernumerary_maxima: int | None
    supernumerary_contrast: float | None
    supernumerary_chroma: float | None


@dataclass(frozen=True)
class FrameMeasures:
    """The numbers of a frame; the names are the keys of ``--json``.

    Attributes:
        size_px: width and height.
        peak_luminance_cd_m2: of the brightest pixel.
        mean_luminance_cd_m2: over all pixels.
        bows: of each sun, as far as the frame shows them.
        left_out: bows that are not measured, and why, in words.
    """

    size_px: tuple[int, int]
    peak_luminance_cd_m2: float
    mean_luminance_cd_m2: float
    bows: tuple[BowMeasures, ...]
    left_out: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Give the numbers as JSON holds them."""
        return asdict(self)


def measured(
    worlds: Sequence[World],
    columns: Sequence[slice],
    rgb: Float32,
    drops: Float32 | None = None,
    *,
    fringes: bool = True,
) -> FrameMeasures:
    """Measure a frame.

    Args:
        worlds: of the picture's parts.
        columns: that each part fills.
        rgb: the frame (h, w, 3), linear Rec. 709 in cd/m².
        drops: the same without sky and ground, in which bows are measured; None where nobody has
            drawn it.
        fringes: whether supernumeraries are measured, which takes longer.
    """
    most = MOST_PIXELS if fringes else FEW_PIXELS
    bows: list[BowMeasures] = []
    left_out: list[str] = []
    for part, (world, place) in enumerate(zip(worlds, columns, strict=True)):
        if world.optics.lamps:
            left_out.append("bows of lamps are not circles about a point and are not measured")
        if world.around is not None and world.optics.suns and drops is None:
            left_out.append(
                "bows before a sky or a ground are measured in the rain's own light, which a frame"
                " on file and method reference do not tell apart; measure the scene by another"
                " method, or without atmosphere.sky and ground"
            )
            continue
        if world.view.pixel_deg > MOST_PIXEL_DEG and world.optics.suns:
            left_out.append(
                f"pixels of {world.view.pixel_deg:.3g} deg are too coarse to measure bows; they"
                f" must be of {MOST_PIXEL_DEG:g} deg at most: render with a greater --size"
            )
            continue
        for sun, key in zip(world.optics.suns, world.sun_keys, strict=True):
            view, box = world.view, world.volume.box_m
            own = rgb if drops is None else drops
            profile = rings_about_sun(own, view, sun.direction, box, place, most)
            for order in orders_of(world):
                found = _bow(profile, order, world.scatterer.medium, (part, key.name), fringes)
                bows += [found] if found else []
    return FrameMeasures(
        (rgb.shape[1], rgb.shape[0]), *_luminances(rgb), tuple(bows), tuple(dict.fromkeys(left_out))
    )


def rings_about_sun(
    rgb: Array | Float32,
    view: View,
    towards_sun: Array,
    box_m: Array,
    columns: slice = slice(None),
    most_pixels: int = MOST_PIXELS,
) -> Profile:
    """Average a frame over rings about the antisolar point, a pixel wide.

    Each ring is scaled to the mean depth of the rain (:func:`measures.radial_profile`).

    Args:
        rgb: the frame (h, w, 3), linear Rec. 709.
        view: its camera.
        towards_sun: unit vector (3,).
        box_m: lower and upper corner (2, 3) of the rain.
        columns: which columns count; all by default.
        most_pixels: of a frame with more, every second row counts, every third and so on.
    """
    rows = slice(None, None, -(-rgb.shape[0] * rgb.shape[1] // most_pixels))
    rays = view.pixel_directions(rows)[:, columns]
    entry, leave = box_span(view.eye_m, rays, box_m)
    return measures.radial_profile(
        floats(rgb[rows, columns]),
        angle_between(rays, -towards_sun),
        view.pixel_deg,
        depth=np.maximum(leave - entry, 0.0),
    )


def _luminances(rgb: Float32) -> tuple[float, float]:
    """Give the greatest and the mean luminance, a row at a time: a frame may be very large."""
    rows = [luminance(row) for row in rgb]
    return float(max(row.max() for row in rows)), float(np.mean([row.mean() for row in rows]))


def _bow(
    profile: Profile, order: int, medium: Medium, place: tuple[int, str], fringes: bool
) -> BowMeasures | None:
    """Measure a bow on a profile; None where the frame does not show its peak."""
    # The measures look for the bows of water; other drops' are elsewhere.
    shift = Medium().descartes_deg(order, _MIDDLE_NM) - medium.descartes_deg(order, _MIDDLE_NM)
    at_water = profile.turned(-shift)
    radius = _or_none(lambda: measures.bow_radius(at_water, order))
    if radius is None:
        return None
    mean = _or_none(lambda: measures.bow_mean(at_water, order))
    uv = None if mean is None else measures.chromaticity(mean)
    maxima, ripples = None, None
    if fringes:
        maxima = _or_none(lambda: measures.supernumerary_maxima(at_water, order))
    if fringes and order == 1:
        ripples = _or_none(lambda: measures.supernumerary_contrast(at_water))
    return BowMeasures(
        *place, BOW_NAMES[order],
        radius + shift,
        _rgb(lambda channel: measures.bow_radius(at_water, order, channel) + shift),
        _or_none(lambda: measures.full_width(at_water, order)),
        _rgb(lambda channel: measures.full_width(at_water, order, channel)),
        float(np.interp(radius, at_water.angle_deg, at_water.luminance)),
        _or_none(lambda: measures.contrast(at_water, order)),
        None if uv is None else (float(uv[0]), float(uv[1])),
        None if maxima is None else len(maxima),
        *(ripples or (None, None)),
    )  # fmt: skip


def _rgb(
    measure: Callable[[measures.Channel], float],
) -> tuple[float | None, float | None, float | None]:
    """Give a measure of R, G and B, None where the frame lacks what it needs."""
    return (
        _or_none(lambda: measure("red")),
        _or_none(lambda: measure("green")),
        _or_none(lambda: measure("blue")),
    )


def _or_none(measure: Callable[[], Number]) -> Number | None:
    """Give a measure, or None where the frame lacks what it needs."""
    try:
        return measure()
    except MeasureError:
        return None
