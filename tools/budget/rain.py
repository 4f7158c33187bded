"""What the model of the rain's own extinction leaves."""

from __future__ import annotations

from typing import Any

import numpy as np

import rtbow
from budget.error_budget import Measurement, Row, Stage
from budget.frames import SIZE, SIZE_NAME, frame
from rtbow.base.arrays import Array, floats
from rtbow.frames.difference import Spread, frame_difference
from rtbow.physics.geometry import box_span
from rtbow.render.renderer import MethodName
from rtbow.scene.model import Scene
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.lights import suns
from rtbow.world.optics import scene_optics
from rtbow.world.rain.extinction import MIDDLE_NM, effective_efficiencies
from rtbow.world.rain.volume import build_volume

_RANGES_UM = ((10.0, 50.0), (50.0, 200.0), (100.0, 1000.0), (300.0, 700.0))
_DEPTHS = (1.0, 3.0)
_EFFICIENCY = 2.0
_POINTS = 8000
_METHODS: tuple[MethodName, ...] = ("reference", "spectral")


def measure() -> Measurement:
    """Measure the one spectrum for all radii, and marches through even rain."""
    yield from _one_spectrum()
    yield from _even_rain()


def _one_spectrum() -> Measurement:
    scene = rtbow.load_scene("uniform")
    optics = scene_optics(scene)
    nm = np.concatenate([[MIDDLE_NM], optics.wavelength_nm])
    light = optics.sun_weights[0]
    for low, high in _RANGES_UM:
        radii = np.geomspace(low, high, 40) * 1e-6
        # As many drops of each radius per unit of its logarithm; the mean is weighted by area.
        mean = float(np.sum(radii**3) / np.sum(radii**2))
        exact = effective_efficiencies(scene, optics, radii, nm)
        one = effective_efficiencies(scene, optics, np.array([mean]), nm)[0]
        exact_ratio, ratio = exact[:, 1:] / exact[:, :1], one[1:] / one[0]
        label = f"radii {low:g}-{high:g} µm"
        error = np.abs(ratio / exact_ratio - 1.0)
        yield Row(
            f"{label}, Q", "40 radii, 380-780 nm; of Q at the radius", relative=Spread.of(error)
        )
        for depth in _DEPTHS:
            seen = [np.exp(-depth * r) @ light for r in (np.tile(ratio, (40, 1)), exact_ratio)]
            # Each radius is seen against a white of its own brightness: a patch beside a patch.
            headline = (low, depth) == (300.0, 1.0)
            yield Row(
                f"{label}, sunlight through rain of depth {depth:g}", "a patch per radius",
                frame_difference(*seen), headline=headline,
            )  # fmt: skip
    yield (
        "Q at 550 nm follows each drop's radius; its course over the wavelength is that of the"
        " effective radius for all. The rows take each radius as the only one in sight; the mean"
        " over radii along a ray is nearer."
    )


def share_of_light(scene: Scene, points: int) -> Array:
    """Give the share of each pixel's light that even rain lets pass, by Beer and Lambert's law.

    Midpoints along each ray, with the way to the sun from each: NumPy alone, no part of either
    method's march.

    Args:
        scene: a uniform box of drops of one radius, one sun, an efficiency of its own.
        points: midpoints along a ray.

    Returns:
        (h, w), 0 where there is no rain.
    """
    volume, sun = build_volume(scene.droplets), suns(scene)[0]
    efficiency = scene.droplets.extinction_efficiency
    assert efficiency is not None
    radius = volume.radius_range_um[0] * 1e-6
    extinction = float(volume.number_per_m3.flat[0]) * efficiency * np.pi * radius**2
    eye = np.array(scene.camera.position_m)
    rays = pixel_directions(scene.camera).reshape(-1, 3)
    entry, leave = box_span(eye, rays, volume.box_m)
    hit = leave > entry
    entry, length = np.where(hit, entry, 0.0), np.where(hit, leave - entry, 0.0)
    passed = np.zeros(len(rays))
    for k in range(points):
        t = (k + 0.5) / points * length
        at = eye + (entry + t)[:, None] * rays
        # Where the box ends towards the sun.
        with np.errstate(divide="ignore", invalid="ignore"):
            faces = np.where(sun.direction > 0.0, volume.box_m[1] - at, volume.box_m[0] - at)
            ends = np.where(sun.direction == 0.0, np.inf, faces / sun.direction)
        way = np.maximum(ends.min(axis=1), 0.0)
        passed += np.exp(-extinction * (t + way)) / points
    width, height = scene.camera.size_px
    return floats(np.where(hit, passed, 0.0).reshape(height, width))


def _even_rain() -> Measurement:
    boxes: tuple[tuple[str, dict[str, Any]], ...] = (
        ("box", {}),
        (
            "slab seen from within",
            {
                "camera.position_m": [0.0, 0.0, 400.0],
                "droplets.box_m": [[-2e5, -2e5, 0.0], [2e5, 2e5, 1000.0]],
            },
        ),
    )
    for label, box in boxes:
        for number in (500.0, 5000.0):
            common = {"camera.size_px": SIZE, "render.wavelength_step_nm": 20.0, **box}
            common["droplets.density.number_per_m3"] = number
            rain = {"droplets.extinction": True, "droplets.extinction_efficiency": _EFFICIENCY}
            scene = rtbow.load_scene("uniform", {**common, **rain})
            clear = frame(rtbow.load_scene("uniform", common), "reference")
            truth = clear * share_of_light(scene, _POINTS)[..., None]
            per_km = 1e3 * number * _EFFICIENCY * np.pi * 300e-6**2
            for method in _METHODS:
                difference = frame_difference(frame(scene, method), truth)
                yield Row(
                    f"{label}, {per_km:.1f} per km: `{method}`",
                    f"`uniform` with Q = 2, {SIZE_NAME}, 20 nm", difference,
                )  # fmt: skip
    yield (
        "Against the reference without extinction times the share of light that passes, by"
        f" {_POINTS} midpoints of Beer and Lambert's law along each ray in NumPy; those of"
        " `spectral` include the table's error."
    )


RAIN = Stage(
    "Rain extinction",
    "The rain's extinction over the wavelength, one course for all radii, against Q at "
    "every radius; and frames of even rain against a plain integral.",
    measure,
)
