"""What the paper says of its figures, as measurements on frames.

A claim that physics contradicts is worded as in the paper, with a note that says why.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.frames import measures
from rtbow.frames.bows.measured import rings_about_sun
from rtbow.frames.measures import MeasureError, Profile, Ridge
from rtbow.physics.light.colour import luminance, rgb_to_xyz
from rtbow.physics.light.spectrum import Spectrum, colour_weights, wavelength_bins
from rtbow.reference.render import radiance_along
from rtbow.scene.model import Scene
from rtbow.world.camera.resolve import pixel_directions, view_of
from rtbow.world.lights import lamps, suns
from rtbow.world.rain.volume import scene_volume
from rtbow.world.world import resolve

ARC = 0.7
"""The shape of a lamp's bow is judged on an arc of this half width, in focal lengths."""

SUN_ALTITUDES = (30, 20, 10)
LAMP_SCENES = ("fig9a", "fig9b", "fig9c", "fig9d")


@dataclass(frozen=True)
class Frame:
    """A rendered scene: linear Rec. 709 (h, w, 3) in cd/m²."""

    scene: Scene
    rgb: Array


Frames = Mapping[str, Frame]
Numbers = dict[str, float]


@dataclass(frozen=True)
class Claim:
    """A statement of the paper.

    Attributes:
        figure: the figure that it is about.
        text: the statement, in other words.
        needs: the scenes on whose frames it is measured.
        measure: gives the numbers, and whether the claim holds.
        note: what the numbers mean, or why physics says otherwise.
    """

    figure: str
    text: str
    needs: tuple[str, ...]
    measure: Callable[[Frames], tuple[Numbers, bool]]
    note: str = ""


@dataclass(frozen=True)
class Verdict:
    """A measured claim; ``holds`` is None where a frame is missing."""

    claim: Claim
    numbers: Numbers
    holds: bool | None


def sun_profile(frame: Frame, columns: slice = slice(None)) -> Profile:
    """Average a frame over rings about the antisolar point of its first sun."""
    scene = frame.scene
    towards, box = suns(scene)[0].direction, scene_volume(scene).box_m
    return rings_about_sun(frame.rgb, view_of(scene.camera), towards, box, columns)


def _falling(values: list[float]) -> bool:
    """Whether each value is less than the one before it."""
    return all(b < a for a, b in pairwise(values))


def _profiles(frames: Frames, *names: str) -> dict[str, Profile]:
    return {name: sun_profile(frames[name]) for name in names}


def _kinds(frames: Frames) -> tuple[Numbers, bool]:
    profile = sun_profile(frames["fig1"])
    radii = {
        f"{bow}_{channel}_deg": measures.bow_radius(profile, k, channel)
        for k, bow in ((1, "primary"), (2, "secondary"))
        for channel in ("red", "green", "blue")
    }
    inside = len(measures.supernumerary_maxima(profile, 1))
    outside = len(measures.supernumerary_maxima(profile, 2))
    red_outside = radii["primary_red_deg"] > radii["primary_green_deg"] > radii["primary_blue_deg"]
    red_inside = (
        radii["secondary_red_deg"] < radii["secondary_green_deg"] < radii["secondary_blue_deg"]
    )
    numbers = {**radii, "supernumeraries_inside": inside, "supernumeraries_outside": outside}
    return numbers, red_outside and red_inside and inside >= 2 and outside >= 1


def _widths(frames: Frames) -> tuple[Numbers, bool]:
    profiles = _profiles(frames, "fig5a", "fig5b", "fig5c")
    red = {f"red_width_{n[3:]}_deg": measures.full_width(p, 1, "red") for n, p in profiles.items()}
    white = {f"luminance_width_{n[3:]}_deg": measures.full_width(p, 1) for n, p in profiles.items()}
    return red | white, _falling(list(red.values()))


def _half_profiles(frame: Frame) -> tuple[Profile, Profile]:
    middle = frame.rgb.shape[1] // 2
    return sun_profile(frame, slice(0, middle)), sun_profile(frame, slice(middle, None))


def _contrasts(frames: Frames) -> tuple[Numbers, bool]:
    names = ("fig5a", "fig5b", "fig5c", "fig5e", "fig5d", "fig5f")
    halves = {n: _half_profiles(frames[n]) for n in names}
    contrasts = {n: measures.supernumerary_contrast(*pair) for n, pair in halves.items()}
    numbers = {f"luminance_contrast_{n[3:]}": v[0] for n, v in contrasts.items()}
    numbers |= {f"chroma_contrast_{n[3:]}": v[1] for n, v in contrasts.items()}
    a, b, c, e, d, f = (contrasts[n][0] for n in names)
    numbers["chance_5f"] = measures.chance_ripple(*halves["fig5f"])
    return numbers, min(a, b, c) > e > d and f < numbers["chance_5f"]


def _no_maxima(frames: Frames) -> tuple[Numbers, bool]:
    maxima = measures.supernumerary_maxima(sun_profile(frames["fig5f"]))
    return {"supernumerary_maxima": len(maxima)}, not maxima


def _whiter(frames: Frames) -> tuple[Numbers, bool]:
    profiles = _profiles(frames, "fig7a", "fig7b", "fig7c")
    numbers = {f"chroma_{n[3:]}": measures.primary_chroma(p) for n, p in profiles.items()}
    return numbers, _falling(list(numbers.values()))


def _bluer(frames: Frames) -> tuple[Numbers, bool]:
    numbers = {}
    for name, profile in _profiles(frames, "fig7b", "fig7c").items():
        mean = measures.bow_mean(profile)
        numbers[f"v_{name[3:]}"] = float(measures.chromaticity(mean)[1])
        numbers[f"z_{name[3:]}"] = float(mean[2] / mean.sum())
        numbers[f"temperature_{name[3:]}_k"] = measures.correlated_temperature_k(mean)
    bluer = numbers["z_7c"] > numbers["z_7b"]
    return numbers, bluer and numbers["temperature_7c_k"] > numbers["temperature_7b_k"]


def direct_ratio(frame: Frame, count: int = 40) -> tuple[float, float, float]:
    """Compute in float64 what figure 8 shows, along some of its rays.

    Args:
        frame: a frame of a scene that compares a left half without air to a right half with it.
        count: number of rays in each half, spread evenly over the primary's band.

    Returns:
        Ratios of luminance, summed over these rays: right half to left half in the picture; the
        same in float64; and, in float64, right half with air to right half without: the air's
        transmittance.
    """
    (without, _), (with_air, _) = frame.scene.parts()
    camera = frame.scene.camera
    angle = np.degrees(measures.angle_from(camera, -suns(frame.scene)[0].direction))
    centre = measures.bow_radius(sun_profile(frame), 1)
    middle = angle.shape[1] // 2
    shown = luminance(frame.rgb)
    band = (np.abs(angle - centre) < 1.5) & (shown > 0.0)
    rays, seen = [], []
    for columns in (slice(0, middle), slice(middle, None)):
        half = np.zeros_like(band)
        half[:, columns] = band[:, columns]
        rows, places = np.nonzero(half)
        pick = np.linspace(0, len(rows) - 1, min(count, len(rows))).astype(np.int64)
        rays.append(pixel_directions(camera)[rows[pick], places[pick]])
        seen.append(float(shown[rows[pick], places[pick]].sum()))
    left = radiance_along(resolve(without), rays[0])[:, 1].sum()
    right = radiance_along(resolve(with_air), rays[1])[:, 1].sum()
    bare = radiance_along(resolve(without), rays[1])[:, 1].sum()
    return seen[1] / seen[0], float(right / left), float(right / bare)


def _darker(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    for altitude in SUN_ALTITUDES:
        left, right = map(measures.bow_mean, _half_profiles(frames[f"fig8-{altitude}"]))
        numbers[f"ratio_{altitude}"] = float(right[1] / left[1])
    return numbers, _falling(list(numbers.values()))


def _redder(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    for altitude in SUN_ALTITUDES:
        _, right = _half_profiles(frames[f"fig8-{altitude}"])
        numbers[f"u_{altitude}"] = float(measures.chromaticity(measures.bow_mean(right))[0])
    return numbers, _falling([-u for u in numbers.values()])


def _as_computed(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    worst = 0.0
    for altitude in SUN_ALTITUDES:
        seen, direct, transmittance = direct_ratio(frames[f"fig8-{altitude}"])
        numbers[f"ratio_on_rays_{altitude}"] = seen
        numbers[f"direct_{altitude}"] = direct
        numbers[f"transmittance_{altitude}"] = transmittance
        worst = max(worst, abs(seen / direct - 1.0))
    return numbers, worst < 0.02


def lamp_ridge(frame: Frame) -> tuple[Ridge, Array]:
    """Trace the edge of a lamp's bow within ``ARC``; give its points in the picture plane, too."""
    ridge = measures.ridge(frame.rgb, frame.scene.camera)
    points = measures.picture_points(ridge.directions, frame.scene.camera)
    inside = np.abs(points[:, 0]) < ARC
    return Ridge(ridge.directions[inside], ridge.xyz[inside]), points[inside]


def _white_of(spectrum: Spectrum) -> Array:
    """Give X, Y, Z (3,) of a light itself."""
    return floats(colour_weights(spectrum, wavelength_bins(5.0)).sum(axis=0))


def _lamp_whiter(frames: Frames) -> tuple[Numbers, bool]:
    sun = frames["fig5a"]
    # Against the white of each light, so that the drops count and not the light's own colour.
    chroma_sun = measures.primary_chroma(sun_profile(sun), _white_of(suns(sun.scene)[0].spectrum))
    numbers = {"chroma_sun_5a": chroma_sun}
    for name in LAMP_SCENES:
        frame = frames[name]
        white = _white_of(lamps(frame.scene)[0].spectrum)
        numbers[f"chroma_{name[3:]}"] = measures.mean_chroma(lamp_ridge(frame)[0].xyz, white)
    return numbers, all(numbers[f"chroma_{n[3:]}"] < chroma_sun for n in LAMP_SCENES)


def _lamp_bluish(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    holds = True
    for name in LAMP_SCENES:
        frame = frames[name]
        xyz = rgb_to_xyz(frame.rgb)
        # The rim: the colour at the edge itself against that of the whole picture.
        rim = measures.ridge(frame.rgb, frame.scene.camera, reach_deg=1.0).xyz.mean(axis=0)
        shift = measures.chromaticity(rim) - measures.chromaticity(xyz.mean(axis=(0, 1)))
        numbers[f"v_rim_less_picture_{name[3:]}"] = float(shift[1])
        holds = holds and shift[1] < 0.0
    return numbers, holds


def _rounder(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    for name in LAMP_SCENES:
        circle = measures.fit_circle_in_picture(lamp_ridge(frames[name])[1])
        numbers[f"residual_per_radius_{name[3:]}"] = circle.residual / circle.radius
    return numbers, _falling(list(numbers.values()))


def _mountain(frames: Frames) -> tuple[Numbers, bool]:
    numbers = {
        f"peakedness_{n[3:]}": measures.peakedness(lamp_ridge(frames[n])[1]) for n in LAMP_SCENES
    }
    values = list(numbers.values())
    return numbers, values[0] > 0.0 and _falling(values)


def _circle_in_space(frames: Frames) -> tuple[Numbers, bool]:
    numbers: Numbers = {}
    residuals = []
    for name in LAMP_SCENES:
        circle = measures.fit_circle(lamp_ridge(frames[name])[0].directions)
        residuals.append(circle.residual)
        numbers[f"radius_{name[3:]}_deg"] = circle.radius
        numbers[f"residual_{name[3:]}_deg"] = circle.residual
    return numbers, _falling(residuals)


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "1",
        "A primary; a secondary with its colours reversed; supernumeraries inside the primary and"
        " outside the secondary.",
        ("fig1",),
        _kinds,
    ),
    Claim(
        "5",
        "With drops of one size the bow becomes narrower as the radius grows.",
        ("fig5a", "fig5b", "fig5c"),
        _widths,
        "Judged in the red component, the bow's outer colour. In luminance the width does not fall:"
        " the bows of all wavelengths lie side by side over 2 degrees whatever the drops, and the"
        " sun's half degree is added; with drops of 0.3 mm a dark gap before the first"
        " supernumerary cuts the bow short, with larger ones nothing does.",
    ),
    Claim(
        "5",
        "Supernumeraries are crisp with drops of one size (a, b, c), blurrier with radii drawn from"
        " a normal (e) and from a uniform distribution (d), and without colours in Marshall-Palmer"
        " rain (f).",
        ("fig5a", "fig5b", "fig5c", "fig5d", "fig5e", "fig5f"),
        _contrasts,
        "Judged by luminance, by what both halves of a picture share, so that the chance of random"
        " drops does not count; what is left of (f) is below that chance. The sun's disc, which"
        " the paper leaves out, blurs the supernumeraries of 0.5 and 0.7 mm drops (b, c) too; in"
        " chroma the slope of the bow's own colours, which all share, is what is left of c to f.",
    ),
    Claim("5", "In Marshall-Palmer rain no supernumerary is left.", ("fig5f",), _no_maxima),
    Claim(
        "7",
        "Under the sun's spectrum (b) the bow is a little whiter than under equal energy (a), and"
        " whiter still under a fluorescent lamp (c).",
        ("fig7a", "fig7b", "fig7c"),
        _whiter,
        "Chroma is the distance from D65 in u', v', weighted by luminance over the primary.",
    ),
    Claim(
        "7",
        "Under the fluorescent lamp (c) the bow is bluish.",
        ("fig7b", "fig7c"),
        _bluer,
        "By the share z of the blue primary and by colour temperature; v' is a little higher, too,"
        " since such lamps are greenish. The paper does not name its lamp; CIE FL1, a daylight"
        " tube, has lines and much blue.",
    ),
    Claim(
        "8",
        "The lower the sun, the darker the bow is seen through the air.",
        tuple(f"fig8-{a}" for a in SUN_ALTITUDES),
        _darker,
        "Ratio of the primary's luminance in the right half, with air, to that in the left half.",
    ),
    Claim(
        "8",
        "The lower the sun, the redder the bow is seen through the air.",
        tuple(f"fig8-{a}" for a in SUN_ALTITUDES),
        _redder,
        "u' of the primary in the right half: towards red it grows.",
    ),
    Claim(
        "8",
        "Both follow from the attenuation of the light: the ratio is the air's transmittance.",
        tuple(f"fig8-{a}" for a in SUN_ALTITUDES),
        _as_computed,
        "Along forty rays of each half, against float64 quadrature, within 2 %. The transmittance"
        " is that of the right half's rays; the ratio differs from it by chance, since the halves"
        " hold different random drops.",
    ),
    Claim(
        "9",
        "A street lamp's bow is whiter than the sun's in the same drops.",
        ("fig5a", *LAMP_SCENES),
        _lamp_whiter,
        "Chroma against the white of each light itself.",
    ),
    Claim(
        "9",
        "A street lamp's bow is bluish.",
        LAMP_SCENES,
        _lamp_bluish,
        "v' at the rim less that of the whole picture: towards blue it falls.",
    ),
    Claim(
        "9",
        "At 2 m the bow is shaped like a mountain, and less so as the lamp recedes.",
        LAMP_SCENES,
        _mountain,
        "How far the top stands out of the best circle in the picture plane, in radii.",
    ),
    Claim(
        "9",
        "As the lamp recedes the bow comes nearer to a circle.",
        LAMP_SCENES,
        _rounder,
        "Residual of the best circle in the picture plane, per radius, over the arc within 0.7"
        " focal lengths of the middle.",
    ),
    Claim(
        "9",
        "The same on the sphere of directions, without the camera.",
        LAMP_SCENES,
        _circle_in_space,
        "Here the physics says otherwise. A ray sees scattering angles from its angle to the lamp's"
        " shadow point up to 180 degrees, so the edge of the bow is where it meets 138 degrees at"
        " the eye: at every distance a circle of 42 degrees about the point opposite to the lamp,"
        " with what residual the pixels leave. The mountain is a level camera's view of a circle"
        " that lies 51 degrees below it at 2 m, and 17 at 8 m.",
    ),
)


def judge(frames: Frames) -> list[Verdict]:
    """Measure the claims, as far as their frames are there.

    Args:
        frames: rendered scenes by name, such as ``fig5a``.
    """
    return [_verdict(claim, frames) for claim in CLAIMS]


def _verdict(claim: Claim, frames: Frames) -> Verdict:
    if not all(name in frames for name in claim.needs):
        return Verdict(claim, {}, None)
    try:
        numbers, holds = claim.measure(frames)
    except MeasureError:  # the picture lacks what the claim is about
        return Verdict(claim, {}, False)
    return Verdict(claim, numbers, bool(holds))
