"""Lines over the picture: where geometric optics puts the bows, horizon and grid, the rain's box.

Only geometry, in the view's pixels; whoever draws them chooses colours and letters.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.frames.bows.places import EXTREMES_NM
from rtbow.physics.geometry import angle_between, box_span, direction
from rtbow.scene.lights import PointLight, SunLight
from rtbow.scene.model import Scene
from rtbow.view.picture.projection import Lines, View, part_views
from rtbow.world.rain.box import box_of

Kind = Literal["bow", "horizon", "grid", "box", "light", "antisolar"]

ORDERS = {1: "primary", 2: "secondary", 3: "tertiary", 4: "quaternary"}
"""Names of bows by number of internal reflections."""

_GRID_DEG = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0)
_GRID_LINES = 8
"""Approximate number of grid lines across the picture."""
_CROSS_PX = 7.0
_CELL_PX = 10.0
"""Size of the cells in which a lamp's bows are searched for."""


@dataclass(frozen=True)
class Overlay:
    """A thing to draw over the picture.

    Attributes:
        kind: what it is.
        label: its name, short.
        lines: its lines in the view's pixels, cut at the picture's sides.
        at: where the label goes, a point of the picture; None if nothing is seen.
        wavelength_nm: of a bow's light, which gives its colour.
    """

    kind: Kind
    label: str
    lines: tuple[Array, ...]
    at: tuple[float, float] | None
    wavelength_nm: float | None = None


def overlays(
    scene: Scene,
    size_px: tuple[int, int],
    names: Collection[str],
    boxes: Sequence[Array | None] | None = None,
    orders: Sequence[int] | None = None,
) -> list[Overlay]:
    """Give what is to be drawn over a scene's picture, both parts of a split one included.

    Args:
        scene: the scene.
        size_px: width and height in which its picture is shown.
        names: of ``circles`` (the bows, the lights and the points opposite them), ``grid`` (and
            horizon) and ``box``.
        boxes: the rain's corners (2, 3) of each part, as :func:`box_of` gives them; without one
            neither box nor lamps' bows are drawn. By default they are asked for.
        orders: internal reflections of the bows; those of the scene by default.
    """
    drawn: list[Overlay] = []
    for number, (part, view) in enumerate(part_views(scene, size_px)):
        box = boxes[number] if boxes is not None else box_of(part.droplets)
        if "grid" in names:
            drawn += [*grid(view), horizon(view)]
        if "box" in names and box is not None:
            drawn.append(box_edges(view, box))
        if "circles" in names:
            drawn += bow_circles(part, view, orders)
            if box is not None:
                drawn += lamp_bows(part, view, box, orders)
            drawn += marks(part, view)
    return [overlay for overlay in drawn if overlay.lines]


def descartes_deg(scene: Scene, reflections: int, wavelength_nm: float) -> float:
    """Give the scattering angle of the ray of least deviation, degrees, 180 backwards.

    See :meth:`rtbow.physics.drop.medium.Medium.descartes_deg`.
    """
    return scene.scattering.medium.descartes_deg(reflections, wavelength_nm)


def bow_circles(
    scene: Scene,
    view: View,
    orders: Sequence[int] | None = None,
    wavelengths_nm: Sequence[float] = EXTREMES_NM,
) -> list[Overlay]:
    """Give the Descartes circles of each sun's bows about its antisolar point.

    Args:
        scene: the scene; what its drops are made of counts.
        view: its view.
        orders: internal reflections; those of the scene by default.
        wavelengths_nm: of the light.
    """
    circles = []
    for number, light in enumerate(scene.light):
        if not isinstance(light, SunLight):
            continue
        axis = -direction(light.azimuth_deg, light.altitude_deg)
        for order, nm, place in _bows(scene, orders, wavelengths_nm):
            radius_deg = 180.0 - descartes_deg(scene, order, nm)
            label = f"{_order_name(order)} {radius_deg:.1f}° {_colour(nm)}{_which(scene, number)}"
            lines = view.circle(axis, np.radians(radius_deg))
            circles.append(Overlay("bow", label, tuple(lines), _along(lines, place), nm))
    return circles


def lamp_bows(
    scene: Scene,
    view: View,
    box_m: Array,
    orders: Sequence[int] | None = None,
    wavelengths_nm: Sequence[float] = EXTREMES_NM,
) -> list[Overlay]:
    """Give where the surface of each lamp's bow enters and leaves the rain.

    The drops that show a lamp's bow lie on a surface, the outer part of a spindle torus whose tips
    are eye and lamp: from each of its points the two are seen 42 degrees apart (primary). Each
    direction meets it at a distance of its own, so that no one line in the picture is the bow. It
    is seen between two: where the surface meets the near side of the rain (for an eye in the rain,
    at the eye itself: Descartes' circle about the point opposite the lamp) and where it meets the
    far side. The primary's light lies inside the line of the far side, seen from the point opposite
    the lamp, and the secondary's outside the line of the near side.

    Args:
        scene: the scene; what its drops are made of counts.
        view: its view.
        box_m: the rain's lower and upper corner (2, 3).
        orders: internal reflections; those of the scene by default.
        wavelengths_nm: of the light.
    """
    bows = []
    for number, light in enumerate(scene.light):
        if not isinstance(light, PointLight):
            continue
        crossings = _Crossings(view, floats(light.position_m), floats(box_m))
        for order, nm, place in _bows(scene, orders, wavelengths_nm):
            angle = np.radians(descartes_deg(scene, order, nm))
            for side in ("near", "far"):
                lines = crossings.lines(angle, side)
                name = f"{_order_name(order)} {_colour(nm)}, {side} rain{_which(scene, number)}"
                bows.append(Overlay("bow", name, tuple(lines), _along(lines, place), nm))
    return bows


class _Crossings:
    """Scattering angles of a lamp's light where the rays of a view enter and leave the rain."""

    def __init__(self, view: View, lamp_m: Array, box_m: Array) -> None:
        self._view, self._lamp, self._box = view, lamp_m, box_m
        left, top, right, bottom = view.area
        self._x, self._y = (
            np.linspace(low, high, max(int(np.ceil((high - low) / _CELL_PX)) + 1, 2))
            for low, high in ((left, right), (top, bottom))
        )
        grid = np.stack(np.meshgrid(self._x, self._y), axis=-1)
        self._angles = {side: self._at(grid, side) for side in ("near", "far")}

    def _at(self, pixels: Array, side: str) -> Array:
        """Scattering angles (...) at points of the picture (..., 2); NaN beside the rain."""
        rays = self._view.directions(pixels)
        entry, leave = box_span(self._view.eye_m, rays, self._box)
        distance = entry if side == "near" else leave
        distance = np.where(entry < leave, distance, np.nan)
        to_lamp = self._lamp - self._view.eye_m - distance[..., None] * rays
        length = np.linalg.norm(to_lamp, axis=-1, keepdims=True)
        return angle_between(to_lamp / np.where(length > 0.0, length, np.nan), rays)

    def lines(self, angle_rad: float, side: str) -> Lines:
        """Give the lines of the picture on which the scattering angle is the given one."""
        from contourpy import contour_generator

        values = self._angles[side] - angle_rad
        if np.isnan(values).all():
            return []
        masked = np.ma.masked_invalid(values)
        generator = contour_generator(self._x, self._y, masked, corner_mask=True)
        return [self._polished(floats(line), angle_rad, side) for line in generator.lines(0.0)]

    def _polished(self, line: Array, angle_rad: float, side: str) -> Array:
        """Move the points of a line (n, 2), found between cells, to where they belong."""
        step = 0.25
        shifts = np.array([[0.0, 0.0], [step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]])
        best = line
        for _ in range(2):
            middle, right, left, below, above = np.moveaxis(
                self._at(best[:, None] + shifts, side) - angle_rad, 1, 0
            )
            slope = np.stack([right - left, below - above], axis=1) / (2.0 * step)
            steep = np.maximum(np.sum(slope**2, axis=1), 1e-300)
            moved = best - (middle / steep)[:, None] * slope
            # Across an edge of the box a slope says nothing, and beside it there is none.
            better = np.abs(self._at(moved, side) - angle_rad) < np.abs(middle)
            best = np.where(better[:, None], moved, best)
        left_px, top, right_px, bottom = self._view.area
        return np.clip(best, (left_px, top), (right_px, bottom))


def horizon(view: View) -> Overlay:
    """Give the horizon: where rays are level."""
    lines = view.circle(np.array([0.0, 0.0, 1.0]), 0.5 * np.pi)
    return Overlay("horizon", "horizon", tuple(lines), _along(lines, 0.9))


def grid(view: View) -> list[Overlay]:
    """Give a grid of altitudes and azimuths, as fine as goes with the field of view.

    The horizon is not among them; azimuths other than those of the compass end before the zenith.
    """
    camera = view.camera
    step = _grid_step(camera.fov_deg / _GRID_LINES)
    # Towards the zenith meridians come together.
    narrowing = max(np.cos(np.radians(camera.altitude_deg)), 1e-3)
    turn = _grid_step(camera.fov_deg / _GRID_LINES / narrowing)
    altitudes, azimuths = _seen_angles(view)
    drawn = []
    for k in range(*_multiples(altitudes, step, 90.0)):
        altitude = k * step
        if k and abs(altitude) < 90.0 - 1e-9:
            lines = view.circle(np.array([0.0, 0.0, 1.0]), np.radians(90.0 - altitude))
            at = _extreme(lines, 0, -1.0)
            drawn.append(Overlay("grid", f"{altitude:+.4g}°", tuple(lines), at))
    for k in range(*_multiples(azimuths, turn, None)):
        azimuth = k * turn % 360.0
        quarter = round(azimuth / 90.0)
        compass = abs(azimuth - 90.0 * quarter) < 1e-9
        lines = _meridian(view, azimuth, 90.0 if compass else 90.0 - step)
        label = "NESW"[quarter % 4] if compass else f"{azimuth:.4g}°"
        drawn.append(Overlay("grid", label, tuple(lines), _extreme(lines, 1, 1.0)))
    return [overlay for overlay in drawn if overlay.lines]


def _grid_step(least: float) -> float:
    return next((step for step in _GRID_DEG if step >= 0.8 * least), _GRID_DEG[-1])


def _multiples(ends: tuple[float, float], step: float, most: float | None) -> tuple[int, int]:
    """First and last but one multiple of a step about a range of angles, none of them twice."""
    first, last = int(np.floor(ends[0] / step)), int(np.ceil(ends[1] / step))
    if most is not None:
        whole = round(most / step)
        return max(first, -whole), min(last, whole) + 1
    return first, min(last + 1, first + round(360.0 / step))


def _seen_angles(view: View) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ranges of altitude and azimuth that a view shows, degrees; azimuths from the camera's on."""
    left, top, right, bottom = view.area
    x, y = np.meshgrid(np.linspace(left, right, 33), np.linspace(top, bottom, 33))
    rays = view.directions(np.stack([x, y], axis=-1).reshape(-1, 2))
    altitude = np.degrees(np.arcsin(np.clip(rays[:, 2], -1.0, 1.0)))
    centre = view.camera.azimuth_deg
    off = (np.degrees(np.arctan2(rays[:, 0], rays[:, 1])) - centre + 180.0) % 360.0 - 180.0
    return (
        (float(altitude.min()), float(altitude.max())),
        (centre + float(off.min()), centre + float(off.max())),
    )


def _meridian(view: View, azimuth_deg: float, top_deg: float) -> Lines:
    level = direction(azimuth_deg, 0.0)

    def path(altitude: Array) -> Array:
        up = np.array([0.0, 0.0, 1.0])
        return floats(np.cos(altitude)[:, None] * level + np.sin(altitude)[:, None] * up)

    return view.curve(path, -np.radians(top_deg), np.radians(top_deg))


def box_edges(view: View, box_m: Array) -> Overlay:
    """Give the twelve edges of the rain's box.

    Args:
        view: the view.
        box_m: lower and upper corner (2, 3).
    """
    lines: Lines = []
    for axis in range(3):
        for side in (0, 1):
            for other_side in (0, 1):
                ends = np.array(box_m, dtype=np.float64)
                ends[:, (axis + 1) % 3] = box_m[side][(axis + 1) % 3]
                ends[:, (axis + 2) % 3] = box_m[other_side][(axis + 2) % 3]
                lines += view.chain(ends)
    return Overlay("box", "rain", tuple(lines), _extreme(lines, 1, -1.0))


def marks(scene: Scene, view: View) -> list[Overlay]:
    """Give crosses at each light and at the point opposite it."""
    crosses: list[Overlay] = []
    for number, light in enumerate(scene.light):
        which = _which(scene, number)
        if isinstance(light, SunLight):
            to_light, opposite = direction(light.azimuth_deg, light.altitude_deg), "antisolar point"
        else:
            to_light, opposite = floats(light.position_m) - view.eye_m, "opposite the lamp"
        name = "sun" if isinstance(light, SunLight) else "lamp"
        crosses += _cross(view, "light", name + which, to_light)
        crosses += _cross(view, "antisolar", opposite + which, -to_light)
    return crosses


def _cross(view: View, kind: Kind, label: str, vector: Array) -> Iterator[Overlay]:
    (x, y), seen = view.pixels(vector)
    if seen:
        strokes = np.array([[[-1.0, 0.0], [1.0, 0.0]], [[0.0, -1.0], [0.0, 1.0]]]) * _CROSS_PX
        lines = tuple(np.array([x, y]) + stroke for stroke in strokes)
        yield Overlay(kind, label, lines, (float(x), float(y)))


def _bows(
    scene: Scene, orders: Sequence[int] | None, wavelengths_nm: Sequence[float]
) -> Iterator[tuple[int, float, float]]:
    """Give orders and wavelengths, and where along its line each label goes."""
    if orders is None:
        # Exact theory has all bows, of which two are seen.
        orders = scene.scattering.orders if scene.scattering.theory == "airy" else (1, 2)
    for order in orders:
        for number, nm in enumerate(wavelengths_nm):
            # Neighbours' labels lie beside each other.
            yield order, nm, 0.5 + (0.15 * number if len(wavelengths_nm) > 1 else 0.0)


def _order_name(order: int) -> str:
    return ORDERS.get(order, f"order {order}")


def _colour(wavelength_nm: float) -> str:
    """Name a wavelength's colour in a word, after the usual division of the spectrum."""
    ends = ((450.0, "violet"), (485.0, "blue"), (500.0, "cyan"), (565.0, "green"),
            (590.0, "yellow"), (625.0, "orange"))  # fmt: skip
    return next((name for end, name in ends if wavelength_nm < end), "red")


def _which(scene: Scene, number: int) -> str:
    return f" ({number})" if len(scene.light) > 1 else ""


def _along(lines: Lines, share: float) -> tuple[float, float] | None:
    """Give the point a share of the way along the longest line."""
    lengths = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines]
    if not lengths:
        return None
    line = lines[int(np.argmax(lengths))]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    x, y = (np.interp(share * way[-1], way, line[:, k]) for k in (0, 1))
    return float(x), float(y)


def _extreme(lines: Lines, coordinate: int, sign: float) -> tuple[float, float] | None:
    """Give the point that lies farthest along a coordinate."""
    if not lines:
        return None
    points = np.concatenate(lines)
    x, y = points[np.argmax(sign * points[:, coordinate])]
    return float(x), float(y)
