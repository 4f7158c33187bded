"""Pixel statistics of frames: a bow's place, width, fringes, colour and shape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, floats
from rtbow.base.errors import RtbowError
from rtbow.physics.geometry import angle_between
from rtbow.physics.light.colour import D65_XYZ, rgb_to_xyz, xyz_to_rgb
from rtbow.scene.model import Camera
from rtbow.world.camera.perspective import camera_basis
from rtbow.world.camera.resolve import pixel_directions

Channel = Literal["red", "green", "blue", "luminance"]

PRIMARY_DEG = (36.0, 44.0)
"""With drops of 20 µm and more, the primary peaks between these angles from the antisolar point."""
SECONDARY_DEG = (48.5, 60.0)
"""The secondary peaks between these angles."""
SUPERNUMERARIES_DEG = 8.0
"""Supernumeraries are looked for up to this angle inside the primary or outside the secondary."""


class MeasureError(RtbowError):
    """A frame lacks what is to be measured."""


def angle_from(camera: Camera, axis: Array) -> Array:
    """Give the angle between each pixel's ray and a direction, rad, (h, w).

    Args:
        camera: the camera.
        axis: unit vector (3,), such as the antisolar point's: minus the direction to the sun.
    """
    return angle_between(pixel_directions(camera), axis)


@dataclass(frozen=True)
class Profile:
    """Means over rings about an axis.

    Attributes:
        angle_deg: middle of each ring (n,), increasing.
        xyz: mean X, Y, Z (n, 3), Y in cd/m².
    """

    angle_deg: Array
    xyz: Array

    @property
    def luminance(self) -> Array:
        """Luminance (n,), cd/m²."""
        return self.xyz[:, 1]

    def channel(self, name: Channel) -> Array:
        """Give luminance or a linear Rec. 709 component (n,)."""
        if name == "luminance":
            return self.luminance
        return xyz_to_rgb(self.xyz)[:, ("red", "green", "blue").index(name)]

    def turned(self, by_deg: float) -> Profile:
        """Give the rings with an angle added to each."""
        return replace(self, angle_deg=self.angle_deg + by_deg)

    def between(self, low_deg: float, high_deg: float) -> Profile:
        """Give the rings between two angles.

        Raises:
            MeasureError: there are fewer than five.
        """
        inside = (self.angle_deg >= low_deg) & (self.angle_deg <= high_deg)
        if np.count_nonzero(inside) < 5:
            raise MeasureError(f"the frame shows nothing from {low_deg:g} to {high_deg:g} degrees")
        return Profile(self.angle_deg[inside], self.xyz[inside])


def radial_profile(
    rgb: Array,
    angle_rad: Array,
    step_deg: float,
    mask: NDArray[np.bool_] | None = None,
    depth: Array | None = None,
) -> Profile:
    """Average a frame over rings of equal angle.

    Args:
        rgb: linear Rec. 709, (h, w, 3).
        angle_rad: angle of each pixel, (h, w).
        step_deg: width of a ring; about a pixel.
        mask: the pixels that count (h, w); all by default.
        depth: length of each ray in the rain (h, w). If given, each ring is scaled to the mean
            depth: neighbouring rings hold pixels in different directions, where the rain is of
            different depth, and would differ for that alone.

    Returns:
        The rings that hold at least four pixels.
    """
    chosen = np.ones(angle_rad.shape, dtype=bool) if mask is None else mask
    ring = np.floor(np.degrees(angle_rad[chosen]) / step_deg).astype(np.int64)
    pixels = rgb_to_xyz(rgb)[chosen]
    count = np.bincount(ring)
    sums = floats(np.stack([np.bincount(ring, weights=p) for p in pixels.T], axis=1))
    if depth is not None:
        depths = depth[chosen]
        mean_depth = np.bincount(ring, weights=depths) / np.maximum(count, 1)
        typical = depths[depths > 0.0].mean() if np.any(depths > 0.0) else 1.0
        sums = floats(sums * (typical / np.maximum(mean_depth, 1e-6 * typical))[:, None])
    full = np.flatnonzero(count >= 4)
    # The mean angle of a ring's few pixels is not its middle: means are interpolated to the middle.
    angle = np.bincount(ring, weights=np.degrees(angle_rad[chosen]))[full] / count[full]
    mean = sums[full] / count[full, None]
    middle = (full + 0.5) * step_deg
    xyz = np.stack([np.interp(middle, angle, m) for m in mean.T], axis=1)
    return Profile(floats(middle), floats(xyz))


def _top(angle: Array, value: Array) -> tuple[float, float]:
    """Give the angle and height of the greatest value, by a parabola through three samples."""
    k = int(np.clip(np.argmax(value), 1, len(value) - 2))
    parabola = np.polyfit(angle[k - 1 : k + 2] - angle[k], value[k - 1 : k + 2], 2)
    shift = -0.5 * parabola[1] / parabola[0] if parabola[0] < 0.0 else 0.0
    return float(angle[k] + shift), float(np.polyval(parabola, shift))


def bow_radius(profile: Profile, reflections: int, channel: Channel = "luminance") -> float:
    """Give the angle of a bow's peak in a channel, degrees from the antisolar point.

    Raises:
        MeasureError: the frame does not show the bow's angles, or they hold no peak.
    """
    span = PRIMARY_DEG if reflections == 1 else SECONDARY_DEG
    part = profile.between(*span)
    value = part.channel(channel)
    if not value.max() > 0.0 or int(np.argmax(value)) in (0, len(value) - 1):
        raise MeasureError(f"no peak of bow {reflections} from {span[0]:g} to {span[1]:g} degrees")
    return _top(part.angle_deg, value)[0]


def full_width(profile: Profile, reflections: int, channel: Channel = "luminance") -> float:
    """Give the full width at half maximum of a bow in a channel, degrees.

    The dark side's end (outside of the primary, inside of the secondary) is at half of the peak.
    The bright side's is half-way between the peak and the plateau: the mean from 3 to 6 degrees
    beside it, over which supernumeraries average out.

    Raises:
        MeasureError: the frame shows no such bow, or not all of it.
    """
    centre = bow_radius(profile, reflections, channel)
    # As an angle that grows towards the dark side.
    dark = _dark_side(reflections)
    plateau = float(_beside(profile, centre, -6.0 * dark, -3.0 * dark).channel(channel).mean())
    part = _beside(profile, centre, -6.0 * dark, 4.0 * dark)
    angle, value = dark * part.angle_deg[::dark], part.channel(channel)[::dark]
    peak = int(np.argmin(np.abs(angle - dark * centre)))
    top = float(value[max(peak - 1, 0) : peak + 2].max())
    outside = _crossing(angle[peak:], value[peak:], 0.5 * top)
    inside = _crossing(angle[peak::-1], value[peak::-1], 0.5 * (top + plateau))
    return outside - inside


def contrast(profile: Profile, reflections: int) -> float:
    """Give the contrast of a bow's peak with the dark beside it, (peak - dark) / (peak + dark).

    The dark is the mean luminance from 2.5 to 5.5 degrees beside the peak, in Alexander's band:
    outside of the primary and inside of the secondary.

    Raises:
        MeasureError: the frame does not show the bow, or not that much beside it.
    """
    centre = bow_radius(profile, reflections)
    near = _beside(profile, centre, -1.0, 1.0)
    peak = _top(near.angle_deg, near.luminance)[1]
    side = _dark_side(reflections)
    dark = float(_beside(profile, centre, 2.5 * side, 5.5 * side).luminance.mean())
    return (peak - dark) / (peak + dark)


def _dark_side(reflections: int) -> int:
    """Give the sign of the direction from a bow towards its dark side."""
    return 1 if reflections == 1 else -1


def _beside(profile: Profile, centre: float, one: float, other: float) -> Profile:
    """Give the rings between two angles from a bow's peak."""
    return profile.between(centre + min(one, other), centre + max(one, other))


def _crossing(angle: Array, value: Array, level: float) -> float:
    """Give the angle at which values first fall below a level."""
    below = np.flatnonzero(value < level)
    if not below.size or below[0] == 0:
        raise MeasureError("the bow does not fall to half its height within the frame")
    k = int(below[0])
    share = (value[k - 1] - level) / (value[k - 1] - value[k])
    return float(angle[k - 1] + share * (angle[k] - angle[k - 1]))


def supernumerary_maxima(profile: Profile, reflections: int = 1) -> list[float]:
    """Give the angles of the maxima of luminance beside a bow, on its bright side.

    A maximum counts if its prominence is at least 1 % of the bow's peak.
    """
    from scipy.signal import find_peaks

    centre = bow_radius(profile, reflections)
    if reflections == 1:
        part = profile.between(centre - SUPERNUMERARIES_DEG, centre + 1.0)
    else:
        part = profile.between(centre - 1.0, centre + SUPERNUMERARIES_DEG)
    top = float(part.luminance.max())
    peaks, _ = find_peaks(part.luminance, prominence=0.01 * top)
    maxima = [float(part.angle_deg[k]) for k in peaks]
    return [a for a in maxima if (centre - a if reflections == 1 else a - centre) > 0.2]


def supernumerary_contrast(profile: Profile, other: Profile | None = None) -> tuple[float, float]:
    """Give the contrast of the supernumeraries inside the primary, of luminance and of chroma.

    The ripple of a quantity is its deviation from a smooth curve (Savitzky-Golay, third order over
    1.6 degrees) over the angles from 1 to 6 degrees inside the peak, where supernumeraries lie. The
    contrast of luminance is the root mean square of its logarithm's ripple, the contrast of chroma
    that of u' and v' together.

    Args:
        profile: the profile of the picture, or of one half of it.
        other: the profile of the other half, in the same rings. If given, only the ripple that both
            halves share counts: supernumeraries are the same in both, random drops are not.
    """
    centre = bow_radius(profile, 1)
    first = _ripples(profile, centre)
    second = first if other is None else _ripples(other, centre)
    rings = min(len(first), len(second))
    shared = np.mean(first[:rings] * second[:rings], axis=0)
    luminance, u, v = np.maximum(shared, 0.0)
    return float(np.sqrt(luminance)), float(np.sqrt(u + v))


def chance_ripple(profile: Profile, other: Profile) -> float:
    """Give the luminance ripple that random drops cause in one half of a picture.

    The halves do not share it: it is the root mean square of half the difference of their ripples.
    """
    centre = bow_radius(profile, 1)
    first, second = _ripples(profile, centre)[:, 0], _ripples(other, centre)[:, 0]
    rings = min(len(first), len(second))
    return float(np.sqrt(np.mean((0.5 * (first[:rings] - second[:rings])) ** 2)))


def _ripples(profile: Profile, centre: float) -> Array:
    """Give the ripples (n, 3) of log luminance, u' and v' inside a bow, about their mean."""
    from scipy.signal import savgol_filter

    part = profile.between(centre - 8.0, centre)
    step = float(np.median(np.diff(part.angle_deg)))
    window = max(2 * round(0.8 / step) + 1, 5)
    counted = (part.angle_deg > centre - 6.0) & (part.angle_deg < centre - 1.0)
    values = np.column_stack([np.log(np.maximum(part.luminance, 1e-30)), chromaticity(part.xyz)])
    ripple = (values - savgol_filter(values, window, 3, axis=0))[counted]
    return floats(ripple - ripple.mean(axis=0))


def chromaticity(xyz: Array) -> Array:
    """Give CIE 1976 u', v' (..., 2) of X, Y, Z (..., 3)."""
    xyz = floats(xyz)
    total = xyz[..., 0] + 15.0 * xyz[..., 1] + 3.0 * xyz[..., 2]
    safe = np.where(total == 0.0, 1.0, total)
    return np.stack([4.0 * xyz[..., 0] / safe, 9.0 * xyz[..., 1] / safe], axis=-1)


def correlated_temperature_k(xyz: Array) -> float:
    """Give the correlated colour temperature of X, Y, Z (3,), by McCamy's cubic (1992)."""
    x, y = floats(xyz)[:2] / floats(xyz).sum()
    n = (x - 0.3320) / (0.1858 - y)
    return float(449.0 * n**3 + 3525.0 * n**2 + 6823.3 * n + 5520.33)


def bow_mean(profile: Profile, reflections: int = 1, half_width_deg: float = 1.5) -> Array:
    """Give the mean X, Y, Z (3,) of a bow, over angles about its peak."""
    centre = bow_radius(profile, reflections)
    return floats(
        profile.between(centre - half_width_deg, centre + half_width_deg).xyz.mean(axis=0)
    )


def mean_chroma(xyz: Array, white: Array = D65_XYZ) -> float:
    """Give the mean distance from a white in u', v', weighted by luminance.

    Args:
        xyz: X, Y, Z (n, 3).
        white: X, Y, Z of the white (3,), of any luminance.
    """
    xyz = floats(xyz)
    weight = np.maximum(xyz[:, 1], 0.0)
    distance = np.linalg.norm(chromaticity(xyz) - chromaticity(white), axis=1)
    return float(np.sum(weight * distance) / np.sum(weight))


def primary_chroma(profile: Profile, white: Array = D65_XYZ, half_width_deg: float = 1.5) -> float:
    """Give the mean chroma of the primary (see :func:`mean_chroma`)."""
    centre = bow_radius(profile, 1)
    return mean_chroma(profile.between(centre - half_width_deg, centre + half_width_deg).xyz, white)


@dataclass(frozen=True)
class Ridge:
    """The inner edge of a bow: the steepest rise of luminance in each pixel column.

    Attributes:
        directions: unit vectors (n, 3) to the edge.
        xyz: X, Y, Z of the bow just outside the edge (n, 3).
    """

    directions: Array
    xyz: Array


def ridge(rgb: Array, camera: Camera, reach_deg: float = 3.0) -> Ridge:
    """Trace the inner edge of a bow that arches over the middle of the picture.

    The edge moves little from column to column, unlike other edges: it is followed from the middle
    column outwards, and ends where it leaves the picture.

    Args:
        rgb: linear Rec. 709 (h, w, 3).
        camera: the camera.
        reach_deg: angle above the edge over which the bow's colour is averaged.

    Raises:
        MeasureError: there is no edge in the middle, or in too few columns.
    """
    xyz, rays = rgb_to_xyz(rgb)[::-1], pixel_directions(camera)[::-1]
    width = xyz.shape[1]
    edge: dict[int, tuple[Array, Array]] = {}
    for columns in (range(width // 2, width), range(width // 2 - 1, -1, -1)):
        last: float | None = None
        for column in columns:
            row = _edge_row(np.log(np.maximum(xyz[:, column, 1], 1e-30)), last)
            if row is None:
                break
            k, share = int(row), row - int(row)
            ray = (1.0 - share) * rays[k, column] + share * rays[k + 1, column]
            height = np.degrees(np.arcsin(rays[:, column, 2]) - np.arcsin(ray[2]))
            above = (height > 0.0) & (height < reach_deg)
            if not above.any():
                break
            edge[column] = ray / np.linalg.norm(ray), xyz[above, column].mean(axis=0)
            last = row
    if len(edge) < max(width // 4, 4):
        raise MeasureError(f"a bow's edge shows in {len(edge)} of {width} columns")
    directions, colours = zip(*(edge[column] for column in sorted(edge)), strict=True)
    return Ridge(np.array(directions), np.array(colours))


def _edge_row(level: Array, near: float | None) -> float | None:
    """Give the row of a column's steepest rise, near another row if given; None without a rise."""
    rise = np.diff(level)
    reach = max(3.0, 0.03 * len(rise))
    rows = np.arange(len(rise)) + 0.5
    if near is not None:
        rise = np.where(np.abs(rows - near) <= reach, rise, -np.inf)
    k = int(np.argmax(rise))
    if not 2 <= k <= len(rise) - 3 or rise[k] < 0.01:
        return None
    a, b, c = np.diff(level)[k - 1 : k + 2]
    bend = a - 2.0 * b + c
    return float(rows[k] + (0.5 * (a - c) / bend if bend < 0.0 else 0.0))


@dataclass(frozen=True)
class Circle:
    """A circle that was fitted to points.

    Attributes:
        centre: unit vector (3,) to its centre, or the centre in the picture plane (2,).
        radius: angular radius in degrees, or radius in the picture plane.
        residual: root mean square distance of the points from it, in the radius's unit.
    """

    centre: Array
    radius: float
    residual: float


def fit_circle(directions: Array) -> Circle:
    """Fit a small circle on the sphere by least squares of the angular distance, in degrees.

    Args:
        directions: unit vectors (n, 3), at least four.
    """
    from scipy.optimize import least_squares

    # The plane through the points is a good start: a small circle lies in one.
    normal = np.linalg.svd(directions - directions.mean(axis=0))[2][2]
    normal = normal if normal @ directions.mean(axis=0) > 0.0 else -normal

    def miss(parameters: Array) -> Array:
        axis = parameters[:3] / np.linalg.norm(parameters[:3])
        return floats(np.arccos(np.clip(directions @ axis, -1.0, 1.0)) - parameters[3])

    start = np.append(normal, np.arccos(np.clip(directions @ normal, -1.0, 1.0)).mean())
    best = least_squares(miss, start).x
    residual = float(np.degrees(np.sqrt(np.mean(miss(best) ** 2))))
    return Circle(best[:3] / np.linalg.norm(best[:3]), float(np.degrees(best[3])), residual)


def picture_points(directions: Array, camera: Camera) -> Array:
    """Give the points (n, 2), right and up in focal lengths, where rays meet the picture plane."""
    forward, right, up = camera_basis(camera)
    depth = directions @ forward
    return np.stack(
        [
            directions @ right / np.linalg.norm(right) / depth,
            directions @ up / np.linalg.norm(up) / depth,
        ],
        axis=1,
    )


def fit_circle_in_picture(points: Array) -> Circle:
    """Fit a circle to points of the picture plane (n, 2) by least squares of the distance."""
    from scipy.optimize import least_squares

    def miss(parameters: Array) -> Array:
        return floats(np.linalg.norm(points - parameters[:2], axis=1) - parameters[2])

    # The algebraic fit: x² + y² = 2 a x + 2 b y + c.
    system = np.column_stack([2.0 * points, np.ones(len(points))])
    a, b, c = np.linalg.lstsq(system, np.sum(points**2, axis=1), rcond=None)[0]
    best = least_squares(miss, [a, b, np.sqrt(max(c + a * a + b * b, 1e-12))]).x
    return Circle(best[:2], float(best[2]), float(np.sqrt(np.mean(miss(best) ** 2))))


def peakedness(points: Array) -> float:
    """Give the height of a ridge's top above its best circle, in radii; positive if it is peaked.

    It is the mean distance from the circle of the top tenth of the points (n, 2) less that of the
    second quarter from below: a mountain is outside the circle at its top, inside at its flanks.
    """
    circle = fit_circle_in_picture(points)
    miss = np.linalg.norm(points - circle.centre, axis=1) - circle.radius
    order = np.argsort(points[:, 1])
    top = miss[order[-max(len(order) // 10, 1) :]].mean()
    flank = miss[order[len(order) // 4 : len(order) // 2]].mean()
    return float((top - flank) / circle.radius)
