"""What a scene holds, in the terms of the field: moments of its drops, optical depth, lights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.physics.air.rayleigh import segment_column, sun_column
from rtbow.physics.constants import YELLOW_NM
from rtbow.physics.drop.fall import rain_rate_mm_h
from rtbow.physics.geometry import box_span
from rtbow.physics.light.spectrum import luminous
from rtbow.scene.lens import FULL_FRAME_MM, frame_width_mm
from rtbow.scene.lights import PointLight, SunLight
from rtbow.scene.model import Camera, Scene
from rtbow.world.camera.view import View
from rtbow.world.lights import NEAREST_M, Lamp, Sun
from rtbow.world.rain.extinction import (
    MIDDLE_NM,
    RainExtinction,
    effective_efficiencies,
    mean_extinction_along,
    rain_extinction,
)
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.visibility import horizon_notes
from rtbow.world.world import World, resolve

_WATER_G_M3 = 1e6
"""The sodium D lines, for which indices of refraction are quoted."""
_BIN = 0.005
"""Step in ln(radius) in which the radii of a grid are counted."""


@dataclass(frozen=True)
class DropMoments:
    """Drops of a scene, on average over its volume.

    Attributes:
        radius_m: sizes (n,), ascending.
        number_per_m3: drops of each size (n,).
    """

    radius_m: Array
    number_per_m3: Array

    def sum(self, power: int) -> float:
        """Give the sum of radius^power over the drops in a cubic metre, m^(power - 3)."""
        return float(self.number_per_m3 @ self.radius_m**power)

    @property
    def effective_radius_m(self) -> float:
        """Mean radius weighted by area."""
        return self.sum(3) / self.sum(2)

    @property
    def effective_variance(self) -> float:
        """Variance over mean square of the radius, weighted by area."""
        return max(self.sum(4) * self.sum(2) / self.sum(3) ** 2 - 1.0, 0.0)

    @property
    def liquid_water_g_m3(self) -> float:
        """Volume of the drops times the density of fresh water."""
        return 4.0 / 3.0 * np.pi * self.sum(3) * _WATER_G_M3

    def extinction_per_m(self, efficiency: Array) -> float:
        """Give the extinction coefficient of drops of some efficiencies (n,), 1/m."""
        return float(np.pi * (self.number_per_m3 * self.radius_m**2) @ efficiency)


def drop_moments(volume: DropletVolume) -> DropMoments | None:
    """Count the drops of a volume by size; None where there are none."""
    weights = [_ends_half(count) for count in volume.shape]
    number = volume.number_per_m3
    if not (number > 0.0).any():
        return None
    if volume.sizes is not None:
        mean = float(np.einsum("xyz,x,y,z->", number, *weights, optimize=True))
        return DropMoments(volume.sizes.radius_m, volume.sizes.share * mean)
    low, high = volume.radius_range_um
    bins = 1 + int(np.log(high / low) / _BIN)
    counts, areas = np.zeros(bins + 1), np.zeros(bins + 1)
    # A plane at a time: a grid may hold many millions of points.
    for x, share in enumerate(weights[0]):
        filled = number[x] > 0.0
        drops = (share * number[x] * np.outer(weights[1], weights[2]))[filled]
        radius = volume.radius_um[x][filled].astype(np.float64)
        place = (np.log(radius / low) / _BIN).astype(np.int64).clip(0, bins)
        counts += np.bincount(place, drops, bins + 1)
        areas += np.bincount(place, drops * radius**2, bins + 1)
    kept = counts > 0.0
    return DropMoments(floats(1e-6 * np.sqrt(areas[kept] / counts[kept])), floats(counts[kept]))


def _ends_half(count: int) -> Array:
    """Give the shares of grid points along an axis in a mean over the volume (count,)."""
    shares = np.ones(count)
    if count > 1:
        shares[0] = shares[-1] = 0.5
    return floats(shares / shares.sum())


def scene_report(scene: Scene) -> str:
    """Describe a scene: its drops, what they do to light, and what each light is.

    Returns:
        Lines ``label: text``.

    Raises:
        InputError: a spectrum, volume or file of drop sizes is not usable.
    """
    world = resolve(scene)
    lines = [
        ("scene", scene.source_name),
        ("view", _view_text(scene.camera, world.view)),
        *_drop_lines(world),
        *_extinction_lines(scene, world),
        *_air_lines(world),
        *_light_lines(scene, world),
        *(("note", note) for note in (*world.notes, *horizon_notes(scene))),
    ]
    return "\n".join(f"{label + ':':<18}{text}" for label, text in lines)


def _air_lines(world: World) -> list[tuple[str, str]]:
    """Say what air and ground there are."""
    if not world.optics.has_air:
        air = "none"
    else:
        air = f"molecules at {world.optics.pressure_hpa:g} hPa at height 0"
        if world.haze is not None:
            green = world.haze.air(floats([MIDDLE_NM]))
            if world.haze.ozone_du:
                air += f"; ozone, {world.haze.ozone_du:g} DU"
            if world.haze.aerosol is not None:
                model, depth = world.haze.aerosol.model, green.beam[-1, 0]
                air += f"; aerosol {model}, of depth {depth:.3g} at 550 nm"
        glows = world.around is not None and world.around.glows
        air += "; with its own light" if glows else "; without its own light (atmosphere.sky)"
    ground = None if world.around is None else world.around.ground
    if ground is None:
        return [("air", air)]
    if ground.albedo is None:
        what = "still water"
    else:
        short, middle, long = ground.albedo.at(floats([450.0, MIDDLE_NM, 650.0]))
        what = f"albedo {short:.3g}, {middle:.3g}, {long:.3g} at 450, 550, 650 nm"
        if short == middle == long:
            what = f"albedo {middle:.3g}"
    return [("air", air), ("ground", f"{what}, at {ground.height_m:g} m")]


def _view_text(camera: Camera, view: View) -> str:
    if camera.whole_sphere:
        size = "{} x {} px".format(*view.size_px)
        return f"all directions, {view.pixel_deg:.3g} deg a pixel, {size}"
    across, upright = view.fields_deg
    text = (
        f"{across:.4g} deg wide, {upright:.4g} deg high, {view.size_px[0]} x {view.size_px[1]} px"
    )
    if camera.focal_length_mm is not None:
        wide, high = camera.sensor_mm or FULL_FRAME_MM
        return f"{text}; {camera.focal_length_mm:g} mm lens on a sensor of {wide:g} x {high:g} mm"
    wide = frame_width_mm(FULL_FRAME_MM, view.size_px)
    focal = wide / (view.pixel_rad * view.size_px[0])
    return f"{text}; as a lens of {focal:.3g} mm on full frame"


def _drop_lines(world: World) -> list[tuple[str, str]]:
    nm = floats([YELLOW_NM])
    index = world.scatterer.medium.index(nm)
    circles = [world.scatterer.medium.bow_radius_deg(k) for k in (1, 2)]
    lines = [
        (
            "drops of",
            f"{world.scatterer.medium}, index {index[0]:.4f} at {YELLOW_NM:g} nm; Descartes' bows"
            f" of {circles[0]:.2f} and {circles[1]:.2f} deg",
        )
    ]
    drops = drop_moments(world.volume)
    if drops is None:
        return [*lines, ("number", "no drops anywhere")]
    where = "" if world.volume.uniform else ", on average over the box"
    return [
        *lines,
        ("number", f"{drops.sum(0):.4g} per m3{where}"),
        *_water_lines(world, drops),
        (
            "effective radius",
            f"{1e6 * drops.effective_radius_m:.4g} um, variance {drops.effective_variance:.3g}",
        ),
    ]


def _water_lines(world: World, drops: DropMoments) -> list[tuple[str, str]]:
    if world.scatterer.medium.refractive_index is not None:  # of what density, nobody says
        return [("drop volume", f"{drops.liquid_water_g_m3:.4g} cm3/m3")]
    rain = rain_rate_mm_h(drops.radius_m, drops.number_per_m3)
    return [
        ("liquid water", f"{drops.liquid_water_g_m3:.4g} g/m3"),
        ("rain rate", f"{rain:.4g} mm/h in still air (Beard's fall speeds, within 2 % for rain)"),
    ]


def _extinction_lines(scene: Scene, world: World) -> list[tuple[str, str]]:
    drops = drop_moments(world.volume)
    if drops is None:
        return []
    rain = world.rain or rain_extinction(scene, world.optics, world.volume)
    nm = floats([MIDDLE_NM])
    # Imported here, with the compiler of what is summed on the CPU.
    from rtbow.tables.mie.efficiency import extinction_efficiencies

    exact = drops.extinction_per_m(
        extinction_efficiencies(drops.radius_m, nm, world.scatterer.medium)[:, 0]
    )
    drawn = drops.extinction_per_m(
        effective_efficiencies(scene, world.optics, drops.radius_m, nm)[:, 0]
    )
    length, depth = _central_depth(world, rain)
    whole = depth * exact / drawn if drawn > 0.0 else 0.0
    use = "as drawn" if world.rain is not None else "as droplets.extinction = true draws it"
    return [
        (
            "extinction",
            f"{1e3 * exact:.4g} 1/km at {MIDDLE_NM:g} nm; {1e3 * drawn:.4g} 1/km {use}: without"
            " what diffraction leaves within the light's disc",
        ),
        (
            "optical depth",
            f"{whole:.4g} along the central ray, {length:.4g} m of rain; {depth:.4g} {use}",
        ),
    ]


def _central_depth(world: World, rain: RainExtinction) -> tuple[float, float]:
    """Give the way of the central ray through the box, m, and its optical depth as drawn."""
    eye, forward = world.view.eye_m, world.view.forward
    entry, leave = box_span(eye, forward[None], world.volume.box_m)
    length = max(float(leave[0] - entry[0]), 0.0)
    if length == 0.0:
        return 0.0, 0.0
    start = (eye + entry[0] * forward)[None]
    mean = mean_extinction_along(start, forward[None], floats([length]), world.volume, rain.field)
    return length, float(mean[0]) * length


def _light_lines(scene: Scene, world: World) -> list[tuple[str, str]]:
    suns, lamps = iter(world.optics.suns), iter(world.optics.lamps)
    lines = []
    for number, light in enumerate(scene.light):
        if isinstance(light, SunLight):
            text = _sun_text(light, next(suns), world)
        else:
            text = _lamp_text(light, next(lamps), world)
        lines.append((f"light {number}", text))
    return lines


def _sun_text(light: SunLight, sun: Sun, world: World) -> str:
    text = (
        f"sun, {sun.spectrum.name}, altitude {light.altitude_deg:g}, azimuth"
        f" {light.azimuth_deg:g} deg, {light.angular_diameter_deg:g} deg across;"
        f" {luminous(sun.spectrum):.4g} lx on a surface that faces it"
    )
    if not world.optics.has_air:
        return text
    column = float(sun_column(world.view.eye_m[2], sun.altitude_rad))
    number = next(k for k, other in enumerate(world.optics.suns) if other is sun)
    at_eye = _behind_air(world, number, column, world.optics.sun_weights)
    return f"{text} above the air, {at_eye:.4g} lx at the eye"


def _lamp_text(light: PointLight, lamp: Lamp, world: World) -> str:
    away = lamp.position_m - world.view.eye_m
    distance = max(float(np.linalg.norm(away)), NEAREST_M)
    column = 0.0
    if world.optics.has_air:
        column = float(segment_column(world.view.eye_m[2], away[2] / distance, distance))
    number = next(k for k, other in enumerate(world.optics.lamps) if other is lamp)
    candela = _behind_air(world, number, column, world.optics.lamp_weights)
    east, north, up = light.position_m
    return (
        f"point, {lamp.spectrum.name}, at [{east:g}, {north:g}, {up:g}] m, {light.diameter_m:g} m"
        f" across; {light.luminous_flux_lm:g} lm, {candela / distance**2:.4g} lx at the eye,"
        f" {distance:.4g} m away"
    )


def _behind_air(world: World, number: int, column: float, weights: tuple[Array, ...]) -> float:
    """Give what is left of a light's lumens behind a column of air."""
    if np.isinf(column):
        return 0.0
    return float(weights[number][:, 1] @ np.exp(-world.optics.air_depth * column))
