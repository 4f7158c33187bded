"""What is under the cursor: angles, luminance, colour and rain; a spectrum; a cut through the bow.

Frames are linear Rec. 709 in cd/m², (h, w, 3), first row on top, stretched over the view.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.frames.measures import chromaticity
from rtbow.physics.geometry import angle_between, box_span, direction
from rtbow.physics.light.colour import luminance, rgb_to_xyz
from rtbow.physics.light.spectrum import wavelength_bins
from rtbow.scene.lights import PointLight, SunLight
from rtbow.scene.model import Scene
from rtbow.view.picture.navigate import antisolar
from rtbow.view.picture.projection import View, azimuth_altitude_deg, part_at
from rtbow.world.rain.box import box_of
from rtbow.world.world import resolve

SPECTRUM_STEP_NM = 1.0
"""Wavelength step of a spectrum under the cursor."""

Frame = Array | Float32
Pixel = tuple[float, float]


@dataclass(frozen=True)
class LightAngle:
    """Angles between a light and a ray.

    Attributes:
        name: of the light, ``sun`` or ``lamp``, with its number where there are several.
        opposite_deg: angle of the ray from the point opposite the light, as the eye sees it: the
            antisolar point.
        scattering_deg: scattering angles of its light along the ray within the rain, at entry and
            exit, 180 backwards. A sun's is one and the same; None where the ray meets no rain.
    """

    name: str
    opposite_deg: float
    scattering_deg: tuple[float, float] | None


@dataclass(frozen=True)
class PixelReadout:
    """What is seen at a point of the picture.

    Attributes:
        scene: that is seen there; one of the two of a split picture.
        direction: unit vector (3,) of the ray.
        azimuth_deg: where it goes, -180..180 clockwise from north.
        altitude_deg: above the horizon.
        lights: the scene's lights.
        rain_m: distances at which the ray enters and leaves the rain's box; None if it misses, or
            the box is not known.
        luminance: cd/m².
        xy: CIE 1931 chromaticity; None where there is no light.
        uv: CIE 1976 u', v'; None where there is no light.
    """

    scene: Scene
    direction: Array
    azimuth_deg: float
    altitude_deg: float
    lights: tuple[LightAngle, ...]
    rain_m: tuple[float, float] | None
    luminance: float
    xy: tuple[float, float] | None
    uv: tuple[float, float] | None


def read_pixel(frame: Frame, scene: Scene, size_px: tuple[int, int], pixel: Pixel) -> PixelReadout:
    """Give what is seen at a point of the picture.

    Args:
        frame: of any size, stretched over the view.
        scene: that it shows.
        size_px: the view's width and height.
        pixel: the point, in the view's pixels.
    """
    part, view = part_at(scene, size_px, pixel)
    ray = view.directions(floats(pixel))
    box = box_of(part.droplets)
    span = None if box is None else _span(view, ray, box)
    azimuth_deg, altitude_deg = azimuth_altitude_deg(ray)
    rgb = frame_value(frame, size_px, pixel)
    xyz = rgb_to_xyz(rgb)
    xy = uv = None
    if xyz[1] > 0.0:
        total = float(xyz.sum())
        xy = (float(xyz[0]) / total, float(xyz[1]) / total)
        u, v = chromaticity(xyz)
        uv = (float(u), float(v))
    return PixelReadout(
        part, ray, azimuth_deg, altitude_deg, tuple(_light_angles(part, view, ray, span)), span,
        float(luminance(rgb)), xy, uv,
    )  # fmt: skip


def text_of(reading: PixelReadout) -> list[tuple[str, str]]:
    """Give a readout as names and values with units, in the order of display."""
    lines = [
        ("azimuth", f"{reading.azimuth_deg:z.2f}°"),
        ("altitude", f"{reading.altitude_deg:z.2f}°"),
    ]
    for light in reading.lights:
        kind, _, number = light.name.partition(" ")
        opposite = "antisolar point" if kind == "sun" else "opposite the lamp"
        lines.append((f"from {opposite} {number}".rstrip(), f"{light.opposite_deg:.2f}°"))
        if light.scattering_deg is not None:
            first, last = (f"{angle:.2f}°" for angle in light.scattering_deg)
            value = first if first == last else f"{first} to {last}"
            lines.append((f"scattering {number}".rstrip(), value))
    lines.append(("luminance", f"{number_text(reading.luminance)} cd/m²"))
    if reading.xy is not None and reading.uv is not None:
        lines.append(("x, y", "{:.4f}, {:.4f}".format(*reading.xy)))
        lines.append(("u', v'", "{:.4f}, {:.4f}".format(*reading.uv)))
    span = reading.rain_m
    lines.append(
        ("rain", f"{distance_text(span[0])} to {distance_text(span[1])}" if span else "none")
    )
    return lines


def frame_value(frame: Frame, size_px: tuple[int, int], pixel: Pixel) -> Array:
    """Give the value (3,) of the frame's pixel that is shown at a point of a view.

    Args:
        frame: of any size, stretched over the view.
        size_px: the view's width and height.
        pixel: the point, in the view's pixels; one outside of it is brought to its edge.
    """
    height, width = frame.shape[:2]
    column = min(max(int(pixel[0] / size_px[0] * width), 0), width - 1)
    row = min(max(int(pixel[1] / size_px[1] * height), 0), height - 1)
    return floats(frame[row, column])


def _span(view: View, ray: Array, box_m: Array) -> tuple[float, float] | None:
    entry, leave = (float(x[0]) for x in box_span(view.eye_m, ray[None], box_m))
    return (entry, leave) if entry < leave else None


def _light_angles(
    scene: Scene, view: View, ray: Array, span: tuple[float, float] | None
) -> list[LightAngle]:
    angles = []
    for number, light in enumerate(scene.light):
        name = "sun" if isinstance(light, SunLight) else "lamp"
        if len(scene.light) > 1:
            name = f"{name} {number}"
        from_eye = _to_light(light, view.eye_m)
        opposite_deg = float(np.degrees(angle_between(ray, -from_eye)))
        scattering_deg = None
        if span is not None:
            # From each end of the ray's way through the rain to the light: 0 is forward.
            first, last = (
                float(np.degrees(angle_between(_to_light(light, view.eye_m + t * ray), ray)))
                for t in span
            )
            scattering_deg = (first, last)
        angles.append(LightAngle(name, opposite_deg, scattering_deg))
    return angles


def _to_light(light: SunLight | PointLight, point_m: Array) -> Array:
    """Give the unit vector (3,) from a point to a light; zero in a lamp's middle."""
    if isinstance(light, SunLight):
        return direction(light.azimuth_deg, light.altitude_deg)
    towards = floats(light.position_m) - point_m
    return floats(towards / max(float(np.linalg.norm(towards)), 1e-300))


def spectrum_at(scene: Scene, ray: Array) -> tuple[Array, Array]:
    """Give the spectral radiance that the eye receives along a ray, by the float64 reference.

    Args:
        scene: the scene; one of the two of a split picture.
        ray: unit direction (3,).

    Returns:
        Wavelengths (401,) at 1 nm, and spectral radiance (401,) in W m⁻² sr⁻¹ nm⁻¹: means over a
        nanometre about each.

    Raises:
        InputError: a spectrum or volume file is not usable.
    """
    # Imported here: it brings the compiler.
    from rtbow.reference.render import spectral_radiance_along

    step = scene.render.model_copy(update={"wavelength_step_nm": SPECTRUM_STEP_NM})
    fine = scene.model_copy(update={"render": step})
    radiance = spectral_radiance_along(resolve(fine), floats(ray)[None])[0]
    return wavelength_bins(SPECTRUM_STEP_NM).wavelength_nm, radiance


@dataclass(frozen=True)
class Profile:
    """A cut through the picture, outwards from the antisolar point.

    Attributes:
        angle_deg: angle from there (n,), evenly spaced and increasing.
        pixels: where in the view (n, 2).
        rgb: linear Rec. 709, cd/m² (n, 3).
    """

    angle_deg: Array
    pixels: Array
    rgb: Array

    @property
    def luminance(self) -> Array:
        """Luminance (n,), cd/m²."""
        return luminance(self.rgb)


def profile(
    frame: Frame, scene: Scene, size_px: tuple[int, int], pixel: Pixel, count: int = 512
) -> Profile | None:
    """Take a cut along the great circle from the antisolar point through a point of the picture.

    It has what is in the picture of the half from the antisolar point to the sun. Between the
    frame's pixels values are bilinear. Without a sun it starts opposite the first lamp.

    Args:
        frame: of any size, stretched over the view.
        scene: that it shows; of a split picture the part at the point counts, and is cut alone.
        size_px: the view's width and height.
        pixel: the point, in the view's pixels.
        count: of samples.

    Returns:
        The cut; None where no more than a point of it is in the picture.
    """
    part, view = part_at(scene, size_px, pixel)
    start, ray = antisolar(part), view.directions(floats(pixel))
    aside = ray - (ray @ start) * start
    if np.linalg.norm(aside) < 1e-9:  # at the antisolar point itself: upwards from there
        ray = view.directions(floats([pixel[0], pixel[1] - 1.0]))
        aside = ray - (ray @ start) * start
    aside = aside / np.linalg.norm(aside)

    def path(angle: Array) -> Array:
        return floats(np.cos(angle)[:, None] * start + np.sin(angle)[:, None] * aside)

    # Half a great circle is seen in one piece, and as a straight line.
    lines = view.curve(path, 0.0, np.pi)
    if not lines:
        return None
    ends = view.directions(np.stack([lines[0][0], lines[-1][-1]]))
    # At the very ends rounding may put them on the other half.
    first, last = np.arctan2(np.maximum(ends @ aside, 0.0), ends @ start)
    angle = np.linspace(float(first), float(last), count)
    pixels = view.pixels(path(angle))[0]
    return Profile(floats(np.degrees(angle)), pixels, _bilinear(frame, view, pixels))


def _bilinear(frame: Frame, view: View, pixels: Array) -> Array:
    """Interpolate a frame at points of the view (n, 2), as far as its camera fills it."""
    height, width = frame.shape[:2]
    scale = np.array([width / view.size_px[0], height / view.size_px[1]])
    left, _, right, _ = view.area
    low, high = round(left * scale[0]), round(right * scale[0])
    x, y = (pixels * scale - 0.5).T
    x, y = np.clip(x, low, max(high - 1, low)), np.clip(y, 0, height - 1)
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    beside, below = np.minimum(column + 1, width - 1), np.minimum(row + 1, height - 1)
    fx, fy = (x - column)[:, None], (y - row)[:, None]
    upper = (1.0 - fx) * floats(frame[row, column]) + fx * floats(frame[row, beside])
    lower = (1.0 - fx) * floats(frame[below, column]) + fx * floats(frame[below, beside])
    return floats((1.0 - fy) * upper + fy * lower)


def distance_text(metres: float) -> str:
    """Give a distance with its unit: metres to a kilometre, then kilometres."""
    if metres < 1000.0:
        return f"{number_text(metres)} m"
    return f"{number_text(metres / 1000.0)} km"


def number_text(value: float, digits: int = 4) -> str:
    """Give a number to some digits, without an exponent where that reads well."""
    if value == 0.0:
        return "0"
    if not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    before_point = int(np.floor(np.log10(abs(value)))) + 1
    return f"{value:,.{max(digits - before_point, 0)}f}"
