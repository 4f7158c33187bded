"""Hard cases: scenes at the ends of what is accepted, shader and reference side by side.

Each row of the table is a scene and the reason why it is hard in float32. The raw frame must be
finite before anything clamps it, its numbers zero or normal, and near the float64 reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import rtbow.tables.layout
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference.render import render_reference
from rtbow.render.renderer import Renderer
from rtbow.render.spectral.method import SpectralMethod
from rtbow.scene.model import Scene
from rtbow.world.rain.volume import DropletVolume, save_volume
from rtbow.world.world import resolve
from textbook import LUMINANCE

pytestmark = pytest.mark.slow

EYE = (0.0, 0.0, 1.6)
BOX = ((-1500.0, 200.0, 0.0), (1500.0, 1200.0, 1100.0))
ROUND_THE_EYE = ((-1000.0, -1000.0, -1000.0), (1000.0, 1000.0, 1000.0))
CUBE = ((0.0, 0.0, 0.0), (1000.0, 1000.0, 1000.0))
HIGH_BOX = ((-3000.0, 500.0, 0.0), (3000.0, 3000.0, 9000.0))
WIDE_BOX = ((-250e3, -250e3, 0.0), (250e3, 250e3, 500e3))
YARD = ((-20.0, -10.0, 0.0), (20.0, 30.0, 10.0))
SMALLEST_NORMAL = float(np.finfo(np.float32).tiny)

Keys = Mapping[str, Any]

AIR: Keys = {"atmosphere": {"rayleigh": True}}
MIE: Keys = {"scattering": {"theory": "mie"}}
ONE_STEP: Keys = {"render": {"wavelength_step_nm": 40.0, "steps": 1}}


def sun(**changes: Any) -> Keys:
    return {"type": "sun", "altitude_deg": 20.0, "azimuth_deg": 180.0} | changes


def lamp(**changes: Any) -> Keys:
    near = {"type": "point", "position_m": [0.0, -2.0, 4.0], "luminous_flux_lm": 5000.0}
    return near | changes


def drops(box: Any = BOX, radius_um: float = 500.0, number: float = 1000.0, **more: Any) -> Keys:
    return {
        "box_m": [list(corner) for corner in box],
        "radius": {"distribution": "constant", "radius_um": radius_um},
        "density": {"number_per_m3": number},
    } | more


def gamma(effective_um: float) -> Keys:
    size = {"effective_radius_um": effective_um, "effective_variance": 0.1}
    return dict(drops()) | {"radius": {"distribution": "gamma", "mixing": "local", **size}}


def fog(depth: float, box: Any = BOX, radius_um: float = 500.0, q: float | None = 1.0) -> Keys:
    """Drops with an optical depth over 1000 m, were their efficiency 1."""
    number = depth / 1000.0 / (np.pi * (radius_um * 1e-6) ** 2)
    own = {} if q is None else {"extinction_efficiency": q}
    return drops(box, radius_um, number, extinction=True, **own)


def view(position: Sequence[float] = EYE, altitude: float = 20.0, fov: float = 90.0) -> Keys:
    return {"position_m": list(position), "altitude_deg": altitude, "fov_deg": fov}


def pixel(azimuth: float, altitude: float, fov: float = 10.0, **more: Any) -> Keys:
    """One pixel that looks exactly in a direction."""
    at = {"azimuth_deg": azimuth, "altitude_deg": altitude, "fov_deg": fov, "size_px": [1, 1]}
    return at | more


FAR_LAMP = lamp(position_m=[0.0, -150.0, -90.0], luminous_flux_lm=1000.0, diameter_m=0.0)
FAR_LAMP_VIEW: Keys = {"position_m": [-12.0, -64.0, 3.0], "fov_deg": 30.0, "size_px": [8, 6]}
ALIKE: Keys = {
    "grid": [6, 5, 4],
    "radius": {"distribution": "uniform", "min_um": 1990.0, "max_um": 2010.0},
}


def far_rain(number: float, **more: Any) -> Keys:
    """Rain of 2 mm, with neither lamp nor eye in it."""
    box = ((-1000.0, 380.0, 0.0), (1000.0, 2250.0, 195.0))
    return drops(box, 2000.0, number, extinction=True) | more


def shifted(box: Any) -> Any:
    return (np.array(box) + FAR).tolist()


FAR = np.array([707e3, -707e3, 0.0])
FAR_EYE = (EYE + FAR).tolist()


# --- Volumes that a scene cannot describe -----------------------------------------------------


def one_point() -> DropletVolume:
    number = np.zeros((5, 4, 5), np.float32)
    number[2, 1, 2] = 1000.0
    return DropletVolume(np.array(BOX), np.full(number.shape, 500.0, np.float32), number)


def half_empty(full_um: float, empty_um: float, other_um: float) -> DropletVolume:
    """Every other grid point empty, with a radius that means nothing; the rest of two sizes."""
    at = np.indices((6, 5, 4)).sum(axis=0)
    number = np.where(at % 2 == 0, 1000.0, 0.0)
    radius = np.where(at % 2 == 0, np.where(at % 4 == 0, other_um, full_um), empty_um)
    return DropletVolume(np.array(BOX), np.float32(radius), np.float32(number))


def ends_side_by_side() -> DropletVolume:
    """1 µm next to 5000 µm, in numbers that scatter alike."""
    radius = np.where(np.indices((4, 4, 4)).sum(axis=0) % 2 == 0, 1.0, 5000.0)
    number = 1000.0 * (5000.0 / radius) ** 2
    return DropletVolume(np.array(BOX), np.float32(radius), np.float32(number))


def drawn(shape: tuple[int, int, int], box: Any = BOX) -> DropletVolume:
    rng = np.random.default_rng(7)
    radius, number = rng.uniform(450.0, 550.0, shape), rng.uniform(0.0, 2000.0, shape)
    return DropletVolume(np.array(box), np.float32(radius), np.float32(number))


# --- The table --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A row: a scene, why it is hard, and the bound on its error.

    Attributes:
        name: of the test.
        why: the reason why it is here.
        bound: greatest deviation of R, G, B of any pixel, in units of the level; just above the
            worst that was measured, in thousandths.
        camera, lights, droplets, more: what differs from the plain scene.
        volume: makes a volume file, in place of droplets.
        spectrum: lines of a CSV file for the first light.
        level: percentile of the reference's luminance that is the unit.
        every: one column in so many is compared.
        dark: whether every pixel is exactly 0.
    """

    name: str
    why: str
    bound: float
    camera: Keys = field(default_factory=dict)
    lights: Sequence[Keys] = (sun(),)
    droplets: Keys = field(default_factory=drops)
    more: Keys = field(default_factory=dict)
    volume: Callable[[], DropletVolume] | None = None
    spectrum: str | None = None
    level: float = 99.5
    every: int = 1
    dark: bool = False

    def scene(self, folder: Path) -> Scene:
        lights = [dict(light) for light in self.lights]
        droplets = dict(self.droplets)
        if self.volume is not None:
            path = folder / "volume.npz"
            save_volume(self.volume(), path)
            for key in ("box_m", "radius", "density"):
                droplets.pop(key, None)
            droplets["file"] = str(path)
        if self.spectrum is not None:
            table = folder / "spectrum.csv"
            table.write_text(self.spectrum)
            lights[0]["spectrum"] = str(table)
        return make(self.camera, lights, droplets, self.more)


def make(camera: Keys, lights: Sequence[Keys], droplets: Keys, more: Keys) -> Scene:
    plain = {"position_m": list(EYE), "fov_deg": 90.0, "size_px": [24, 14]}
    parts = {
        "camera": plain | dict(camera),
        "light": [dict(light) for light in lights],
        "droplets": dict(droplets),
        "render": {"wavelength_step_nm": 40.0},
    }
    return Scene.model_validate(parts | dict(more))


def altitude_cases() -> list[Case]:
    # Measured: 0.8, 1.1, 1.5; below the horizon 1.6 and 0.4.
    above = view((0.0, 0.0, 1500.0), -50.0)
    below = drops(((-3000.0, -3000.0, 0.0), (3000.0, 3000.0, 1000.0)))
    return [
        Case("sun-90", "it has no azimuth, the bow is on the ground", 1.5e-3, above,
             [sun(altitude_deg=90.0)], below, AIR),
        Case("sun-10", "its way through the air is six times as long", 1.5e-3, {},
             [sun(altitude_deg=10.0)], more=AIR),
        Case("sun-0", "the air column changes by a third per degree", 2e-3, {},
             [sun(altitude_deg=0.0)], more=AIR),
        Case("sun-0.5-below", "the Earth's shadow ends 242 m up", 2.5e-3, view(altitude=35.0),
             [sun(altitude_deg=-0.5)], drops(HIGH_BOX), AIR),
        Case("sun-2-below", "what light there is grazes the ground", 1e-3,
             view(altitude=60.0, fov=60.0), [sun(altitude_deg=-2.0)], drops(HIGH_BOX), AIR),
    ]  # fmt: skip


def eye_cases() -> list[Case]:
    # Measured: 0.8 to 1.3; the grid's 5.7 are those of its few cells.
    low = drops(((-9000.0, 500.0, 0.0), (9000.0, 20_000.0, 4000.0)))
    corner = dict(view(BOX[0])) | {"azimuth_deg": 45.0}
    return [
        Case("eye-0", "the root of the height, in the column's texture", 1.5e-3,
             view((0.0, 0.0, 0.0)), [sun(altitude_deg=5.0)], more=AIR),
        Case("eye-10-km", "air that is denser at the drops than at the eye", 2e-3,
             view((0.0, 0.0, 10_000.0), -35.0), droplets=low, more=AIR),
        Case("eye-inside", "the box is entered at 0", 1.5e-3, view((10.0, 600.0, 500.0)), more=AIR),
        Case("eye-on-face", "a face at distance 0", 1.5e-3, view((0.0, 200.0, 500.0))),
        Case("eye-on-corner", "three faces at distance 0", 2e-3, corner),
        Case("eye-far", "at 1000 km float32 keeps 6 cm", 2e-3, view(FAR_EYE),
             droplets=drops(shifted(BOX)), more=AIR),
        Case("eye-far-grid", "the same with grid points", 8e-3, view(FAR_EYE),
             volume=lambda: drawn((4, 4, 4), shifted(BOX))),
    ]  # fmt: skip


def ray_cases() -> list[Case]:
    # Measured: 0.5 to 1.2.
    cases = []
    for name, azimuth, altitude in (
        ("north", 0.0, 0.0), ("east", 90.0, 0.0), ("south", 180.0, 0.0), ("west", 270.0, 0.0),
        ("up", 0.0, 90.0), ("down", 0.0, -90.0),
    ):  # fmt: skip
        camera = pixel(azimuth, altitude, position_m=[500.0, 500.0, 500.0])
        light = sun(azimuth_deg=azimuth + 180.0, altitude_deg=40.0)
        why = "the slabs of the box are divided by a direction's zeros"
        cases.append(Case(f"ray-{name}", why, 1.5e-3, camera, [light], drops(CUBE)))
    for name, azimuth, altitude, eye in (
        ("west", 0.0, 0.0, (0.0, 0.0, 500.0)), ("east", 0.0, 0.0, (1000.0, 0.0, 500.0)),
        ("bottom", 0.0, 0.0, (500.0, 0.0, 0.0)), ("top", 0.0, 0.0, (500.0, 0.0, 1000.0)),
        ("south", 90.0, 0.0, (0.0, 0.0, 500.0)), ("north", 90.0, 0.0, (0.0, 1000.0, 500.0)),
        ("south-up", 0.0, 90.0, (500.0, 0.0, 0.0)), ("north-up", 0.0, 90.0, (500.0, 1000.0, 0.0)),
        ("edge", 0.0, 0.0, (0.0, 0.0, 0.0)), ("edge-outside", 0.0, 0.0, (1000.0, -5.0, 1000.0)),
    ):  # fmt: skip
        camera = pixel(azimuth, altitude, position_m=list(eye))
        light = sun(azimuth_deg=azimuth + 180.0, altitude_deg=40.0)
        why = "a face at distance 0 along the whole ray: 0 divided by 0"
        cases.append(Case(f"in-face-{name}", why, 1.5e-3, camera, [light], drops(CUBE)))
    corner = pixel(0.0, 0.0, position_m=list(BOX[0]))
    why = "the way out towards the sun begins on two faces"
    return [
        *cases,
        Case("in-face-grid-fog", why, 1.5e-3, corner, [sun(altitude_deg=40.0)],
             {"extinction": True}, AIR, lambda: drawn((3, 4, 5))),
    ]  # fmt: skip


def pole_cases() -> list[Case]:
    # Measured, in units of the pixel itself, which is far darker than the bow: with Airy 2.7, 4.3
    # and 19, 2.6; with Mie 3.0, 1.3 and 0.1; without a disc 0.2, 0.1, 3.1, 1.7; polarised 3.0, 3.0
    # and 3.9.
    antisolar, solar = pixel(0.0, -20.0, 0.1), pixel(180.0, 20.0, 0.1)
    point = [sun(angular_diameter_deg=0.0)]
    filtered = dict(pixel(13.3, -23.7, 0.1)) | {"polarizer_deg": 30.0}
    askew = [sun(altitude_deg=23.7, azimuth_deg=193.3)]
    small, large = drops(ROUND_THE_EYE, 10.0), drops(ROUND_THE_EYE)
    ring = "the disc covers rings about the pole, and the angle's sine is 0"
    plane = "there is no scattering plane: what a rounding makes of one must not show"
    # Between 0 and pi of the scattering angle, 10 powers of ten in a frame.
    all_round = dict(view(altitude=-20.0, fov=90.0)) | {"size_px": [25, 15]}
    glory = "exact rings of large drops about the frame's middle"
    return [
        Case("antisolar-airy-10-um", ring, 4e-3, antisolar, droplets=small),
        Case("antisolar-airy-500-um", ring, 6e-3, antisolar, droplets=large),
        # A dark ring: 0.2 % of the bow's peak.
        Case("solar-airy-10-um", ring, 2.5e-2, solar, droplets=small),
        Case("solar-airy-500-um", ring, 4e-3, solar, droplets=large),
        Case("antisolar-mie-10-um", ring, 4.5e-3, antisolar, droplets=small, more=MIE),
        Case("solar-mie-10-um", ring, 3e-3, solar, droplets=small, more=MIE),
        Case("solar-mie-500-um", ring, 1e-3, solar, droplets=large, more=MIE),
        # 14: bows of high order, which move across it as the index changes.
        Case("antisolar-mie-500-um", glory, 2e-2, all_round, droplets=large, more=MIE),
        Case("antisolar-airy-point", ring, 1e-3, antisolar, point, small),
        Case("solar-airy-point", ring, 1e-3, solar, point, small),
        Case("antisolar-mie-point", ring, 4.5e-3, antisolar, point, small, MIE),
        Case("solar-mie-point", ring, 4e-3, solar, point, small, MIE),
        Case("polarizer-airy", plane, 4e-3, filtered, askew, small),
        Case("polarizer-mie", plane, 4.5e-3, filtered, askew, small, MIE),
        Case("polarizer-around", "the plane turns once about the middle", 6e-3,
             dict(filtered) | {"fov_deg": 3.0, "size_px": [15, 15]}, askew, small, MIE),
    ]  # fmt: skip


def size_cases() -> list[Case]:
    # Measured: 0.1 and 2.8; 7.2 of the widest disc in the bow's own scale, and 1.2 without;
    # exact theory 2.0 and 20, mixtures 2.4 and 0.2; in the shadow 3.7.
    band = view(altitude=26.0, fov=3.0)
    small = dict(view(fov=40.0)) | {"size_px": [12, 7]}
    return [
        Case("radius-1-um", "a bow wider than the sky", 5e-4, {}, droplets=drops(radius_um=1.0)),
        Case("radius-1-um-mie", "the table's first row", 4e-3, {},
             droplets=drops(radius_um=1.0, number=1e9), more=MIE),
        Case("radius-5-mm", "fringe phases of 10,000 rad, brought near 0 in float32", 1e-2, {},
             droplets=drops(radius_um=5000.0)),
        Case("radius-5-mm-point", "the same, all of them seen", 2e-3, {},
             [sun(angular_diameter_deg=0.0)], drops(radius_um=5000.0)),
        Case("mie-10-um", "texels that follow both poles", 3e-3, {},
             droplets=drops(radius_um=10.0), more=MIE),
        Case("mie-500-um", "thousands of texels, fringes in between", 2.5e-2, {}, more=MIE),
        Case("gamma-airy", "one row stands for hundreds of sizes", 4e-3, small,
             droplets=gamma(300.0)),
        Case("gamma-mie", "the same by exact theory", 1e-3, small, droplets=gamma(10.0),
             more=MIE),
        Case("alexanders-band", "1e-12 of the bow, by a texture's steep end", 6e-3, band),
        Case("alexanders-band-5-mm", "beyond the texture's end", 0.0, band,
             droplets=drops(radius_um=5000.0), dark=True),
    ]  # fmt: skip


def volume_cases() -> list[Case]:
    # Measured: grids of few or uneven cells 2.5 to 6.3, where samples in a cell are few;
    # else 0.1 to 1.5.
    sheet = ((-1500.0, 200.0, 0.0), (1500.0, 200.01, 1100.0))
    speck = ((-0.005, 0.02, 0.0), (0.005, 0.03, 0.01))
    pebble = ((-0.01, 0.01, 0.0), (0.01, 0.02, 0.01))
    slab = (WIDE_BOX[0], (250e3, 250e3, 10e3))
    nothing = "a radius that means nothing must not spread"
    rain = {"extinction": True}
    ground = view((0.0, 0.0, 0.0))
    return [
        Case("two-points", "one cell in all", 8e-3, volume=lambda: drawn((2, 2, 2))),
        Case("two-points-thin", "1 cm thick", 8e-3, volume=lambda: drawn((5, 2, 5), sheet)),
        Case("thin-box", "entry and exit are alike to five digits", 2e-3, droplets=drops(sheet)),
        Case("one-point", "density is a tent between empty points", 8e-3, volume=one_point),
        Case("one-point-fog", "the same, seen through itself", 8e-3, droplets=rain,
             volume=one_point),
        Case("empty-points-huge", nothing, 4e-3, volume=lambda: half_empty(500.0, 3e38, 510.0)),
        Case("empty-points-0", nothing, 4e-3, volume=lambda: half_empty(500.0, 0.0, 500.0)),
        Case("empty-points-negative", nothing, 4e-3,
             volume=lambda: half_empty(500.0, -3e38, 510.0)),
        Case("empty-points-fog", nothing, 4e-3, droplets=rain,
             volume=lambda: half_empty(500.0, 3e38, 510.0)),
        Case("ends-side-by-side", "13 powers of ten between neighbours' light", 5e-4,
             volume=ends_side_by_side),
        Case("ends-between-empty", "the same between empty points", 8e-3,
             volume=lambda: half_empty(1.0, 5000.0, 5000.0)),
        Case("grid-512-east", "the finest cells, across the view", 7e-3,
             volume=lambda: drawn((512, 2, 2))),
        Case("grid-512-north", "the finest cells, along the view", 3e-3,
             volume=lambda: drawn((2, 512, 2))),
        Case("density-1e-6", "a drop in a million cubic metres", 2e-3, {},
             droplets=drops(number=1e-6)),
        Case("density-1e12", "all that is accepted", 2e-3, {}, droplets=drops(number=1e12)),
        Case("speck", "light of 1e-21 cd/m², by factors down to 1e-15", 5e-4, ground,
             droplets=drops(speck, 1.0, 1e-6)),
        Case("box-1-cm", "lengths of millimetres", 2e-3, ground, droplets=drops(pebble)),
        Case("box-500-km", "lengths of 700 km", 2e-3, droplets=drops(slab)),
        Case("box-500-km-air", "the same in air, which is gone in the upper part", 2.5e-3,
             {"size_px": [12, 7]}, droplets=drops(WIDE_BOX), more=AIR),
        Case("one-step", "a step larger than the box", 2e-3, more=ONE_STEP),
        Case("one-step-air", "the same in air", 2e-3, more=dict(ONE_STEP) | AIR),
        # 19: one step takes the way towards the sun as linear between its ends.
        Case("one-step-fog", "the same in fog", 2.5e-2, droplets=fog(1.0), more=ONE_STEP),
    ]  # fmt: skip


def light_cases() -> list[Case]:
    # Measured: 1.1; the red line 4.6 of its luminance, which is a tenth of its R.
    huge = drops(WIDE_BOX, 5000.0, 1e12)
    faint = sun(altitude_deg=5.0, azimuth_deg=150.0, irradiance_w_m2=1.0)
    line = "380,0\n632.80,0\n632.81,1\n632.82,0\n780,0\n"
    return [
        Case("one-line", "narrower than a bin by a thousand", 6e-3, spectrum=line),
        Case("units-1e-12", "a shape of tiny numbers", 2e-3, spectrum="380,1e-12\n780,1e-12\n"),
        Case("units-1e12", "a shape of huge numbers", 2e-3, spectrum="380,1e12\n780,1e12\n"),
        Case("irradiance-1e12", "targets and weights far beyond 65504", 2e-3, {},
             [sun(irradiance_w_m2=1e12)]),
        Case("irradiance-1e12-most", "1e27 cd/m² with the most drops", 1e-2, {},
             [sun(irradiance_w_m2=1e12)], huge),
        Case("irradiance-1e-12", "weights of 1e-10 on sections of 1e-14", 2e-3, {},
             [sun(irradiance_w_m2=1e-12)]),
        Case("irradiance-1e12-mie", "the forward peak on top of it", 1e-3,
             {"azimuth_deg": 180.0, "size_px": [25, 15]}, [sun(irradiance_w_m2=1e12)],
             drops(ROUND_THE_EYE), MIE, level=100.0),
        Case("two-suns-1e9", "one is lost in the other", 2e-3, {},
             [sun(irradiance_w_m2=1e9), faint]),
        Case("sun-and-lamp", "one is lost in the other", 2e-3, {},
             [sun(irradiance_w_m2=1e6), lamp()]),
    ]  # fmt: skip


def camera_cases() -> list[Case]:
    # Measured: 0.5 to 0.9.
    return [
        Case("fov-0.1", "rays alike to four digits", 1.5e-3, view(altitude=21.9, fov=0.1)),
        Case("fov-0.1-5-mm", "the same across a bow's steep edge", 1.5e-3,
             view(altitude=22.0, fov=0.1), droplets=drops(radius_um=5000.0)),
        Case("fov-179", "a picture plane 115 times as wide as far", 1e-3, view(fov=179.0),
             droplets=drops(ROUND_THE_EYE)),
        Case("fov-179-mie", "both poles in one frame", 1.5e-3, view(fov=179.0),
             droplets=drops(ROUND_THE_EYE, 10.0), more=MIE),
        Case("frame-1x1", "one pixel", 1e-3, {"size_px": [1, 1]}),
        Case("frame-8192x16", "many strips of the widest frame", 1.5e-3,
             {"size_px": [8192, 16]}, every=700),
    ]  # fmt: skip


def fog_cases() -> list[Case]:
    # Measured: 0.3 to 2.5; the grid 3.6; 13 are what the table errs by near the sun.
    behind = sun(azimuth_deg=0.0, altitude_deg=0.0)
    inside = view((0.0, 700.0, 500.0))
    beside = dict(view((0.0, 5.0, 1.6), 0.0)) | {"size_px": [12, 7]}
    far_yard = ((-20.0, 10.0, 0.0), (20.0, 30.0, 10.0))
    skin = "all light is from the first millimetres, where float32 knows a face to 0.1 mm"
    colours = "extinction of such drops doubles from blue to red"
    return [
        Case("fog-50", "steps of half an optical depth", 1.5e-3, droplets=fog(50.0)),
        Case("fog-50-own-q", "the same with drops' own efficiency", 1.5e-3,
             droplets=fog(50.0, q=None)),
        Case("fog-grid-air", "uneven fog in air", 5e-3, droplets={"extinction": True}, more=AIR,
             volume=lambda: drawn((4, 4, 4))),
        Case("fog-1-um", colours, 4e-3, droplets=fog(50.0, radius_um=1.0, q=None), more=MIE),
        Case("fog-1e6", skin, 1.5e-3, droplets=fog(1e6)),
        Case("fog-density-1e12", skin, 1.5e-3, droplets=drops(number=1e12, extinction=True)),
        Case("fog-behind", "a depth of a million is no light, not a little", 0.0, {}, [behind],
             fog(1e6), dark=True),
        Case("fog-behind-50", "exp(-50), which float32 still holds", 1.5e-2, {}, [behind],
             fog(50.0, radius_um=10.0), MIE),
        Case("fog-inside", "depth from the eye on, to all sides", 1.5e-3, inside,
             droplets=fog(50.0)),
        Case("fog-inside-1e6", "no light gets in", 0.0, inside, droplets=fog(1e6), dark=True),
        Case("fog-lamp", "long steps in angle through fog", 1e-3, beside, [lamp()],
             fog(50.0, YARD)),
        Case("fog-lamp-dense", "the same at a depth of 30", 1.5e-3, beside, [lamp()],
             fog(2000.0, YARD)),
        Case("fog-lamp-outside", "lamp and eye outside of it", 1e-3, beside, [lamp()],
             fog(2000.0, far_yard)),
        # Measured: 1.6 and 19, of places that float32 knows to 0.1 mm; the grid 2.3 and 16.
        Case("rain-lamp-1e6", "10 optical depths a metre, of which light leaves the first", 3e-3,
             FAR_LAMP_VIEW, [FAR_LAMP], far_rain(1e6)),
        Case("rain-lamp-1e12", "the first 0.1 µm", 2.5e-2, FAR_LAMP_VIEW, [FAR_LAMP],
             far_rain(1e12)),
        Case("rain-lamp-grid-1e6", "the same with grid points", 4e-3, FAR_LAMP_VIEW, [FAR_LAMP],
             far_rain(1e6, **ALIKE)),
        Case("rain-lamp-grid-1e12", "the same with grid points", 2.5e-2, FAR_LAMP_VIEW, [FAR_LAMP],
             far_rain(1e12, **ALIKE)),
    ]  # fmt: skip


def lamp_cases() -> list[Case]:
    # Measured: 0.001 but for 0.2 from far and 21 where the lamp's disc is averaged as if flat.
    ahead = pixel(0.0, 0.0, 5.0, position_m=[0.0, 0.0, 0.0])
    at = {"position_m": [0.0, 500.0, 0.0]}
    sky = drops(ROUND_THE_EYE)
    return [
        Case("lamp-in-line", "a half turn within a millimetre, half a kilometre away", 1e-4, ahead,
             [lamp(**at, diameter_m=0.0)], sky),
        Case("lamp-in-line-disc", "its disc fills half of the sky beside it", 2.5e-2, ahead,
             [lamp(**at)], sky),
        Case("lamp-at-eye", "every ray begins in it", 1e-4, view((0.0, 0.0, 0.0)),
             [lamp(position_m=[0.0, 0.0, 0.0], diameter_m=0.0)], sky),
        # Of a rounding, without it, any share of both components.
        Case("lamp-at-eye-polarizer", "no way to it, and no scattering plane", 1e-3,
             dict(view((0.01, -1.2, 0.1))) | {"polarizer_deg": 70.0},
             [lamp(position_m=[0.01, -1.2, 0.1], diameter_m=0.0)], drops(ROUND_THE_EYE, 1.3)),
        Case("lamp-far", "a lamp like a sun, 10,000 km away", 1e-3, view((0.0, 0.0, 0.0)),
             [lamp(position_m=[0.0, -1e7, 1e6], luminous_flux_lm=1e12)], sky),
    ]  # fmt: skip


CASES = [
    *altitude_cases(), *eye_cases(), *ray_cases(), *pole_cases(), *size_cases(), *volume_cases(),
    *light_cases(), *camera_cases(), *fog_cases(), *lamp_cases(),
]  # fmt: skip


def raw_frame(contexts: Any, scene: Scene) -> np.ndarray:
    """Draw the shader's frame, before anything looks at it."""
    context = contexts("egl")
    with context.current():
        return SpectralMethod(context, resolve(scene)).render()


def errors_of(frame: np.ndarray, exact: np.ndarray, percentile: float) -> np.ndarray:
    level = float(np.percentile(exact @ LUMINANCE, percentile))
    return np.abs(frame.astype(np.float64) - exact).max(axis=2) / (level or 1.0)


SLOW = {"in-face-grid-fog"}


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.slow] * (case.name in SLOW))
        for case in CASES
    ],
)
def test_hard_case(gl_contexts, tmp_path, save_failure, case):
    scene = case.scene(tmp_path)
    columns = slice(None, None, case.every)
    frame = raw_frame(gl_contexts, scene)
    assert np.isfinite(frame).all(), case.why
    assert not np.any((frame != 0.0) & (np.abs(frame) < SMALLEST_NORMAL)), "denormal numbers"
    exact = render_reference(resolve(scene), columns=columns)
    save_failure("hard", frame[:, columns], exact)
    assert np.isfinite(exact).all()
    if case.dark:
        np.testing.assert_array_equal(frame, 0.0)
        # Airy's function itself is 1e-40 there.
        assert np.abs(exact).max() < SMALLEST_NORMAL
        return
    assert exact.max() > 0.0
    assert errors_of(frame[:, columns], exact, case.level).max() < case.bound, case.why


def test_names_are_unique():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)


# --- What fog must look like ------------------------------------------------------------------


@pytest.fixture(scope="module")
def fogs(gl_contexts):
    """Frames of clear drops and of fogs with ever more of them, per drop."""
    frames = []
    for depth in (0.0, 0.5, 5.0, 50.0, 5e3, 5e5):
        droplets = dict(fog(max(depth, 1.0)))
        number = droplets["density"]["number_per_m3"]
        scene = make(view(fov=60.0), [sun()], droplets | {"extinction": depth > 0.0}, {})
        frames.append(raw_frame(gl_contexts, scene).astype(np.float64) / number)
    return frames


def test_more_fog_is_darker(fogs):
    # Per drop, in every pixel, since all of them dim each other; by a hair where it is all gone.
    luminance = [frame @ LUMINANCE for frame in fogs]
    for thinner, thicker in pairwise(luminance):
        assert np.all(thicker <= thinner * (1.0 + 1e-5))
    # At a depth of 50 light comes from the outermost twentieth or so.
    lit = luminance[0] > 0.01 * luminance[0].max()
    assert np.median(luminance[3][lit] / luminance[0][lit]) < 0.05


def test_dense_fog_saturates(fogs):
    # Twice the drops dim twice as much: only the outermost layer is seen, of whatever density.
    dense = [frame * depth for frame, depth in zip(fogs[4:], (5e3, 5e5), strict=True)]
    np.testing.assert_allclose(dense[1], dense[0], rtol=0.0, atol=1e-3 * dense[0].max())


@pytest.mark.parametrize("radius_um", [1.0, 500.0])
def test_no_bands_in_fog(gl_contexts, radius_um):
    # A sun before and above, so that what is seen is deep inside; over the same without dimming.
    camera = view((0.0, 0.0, 500.0), 0.0, 20.0) | {"size_px": [96, 8]}
    lights = [sun(altitude_deg=50.0, azimuth_deg=100.0)]
    droplets = fog(50.0, radius_um=radius_um, q=None)
    shares = []
    for each in (droplets, droplets | {"extinction": False}):
        scene = make(camera, lights, each, {})
        frame, exact = raw_frame(gl_contexts, scene), render_reference(resolve(scene))
        shares.append((frame @ LUMINANCE, exact @ LUMINANCE))
    ratio = (shares[0][0] / shares[1][0]) / (shares[0][1] / shares[1][1])
    # Steps that came and went from pixel to pixel would show here: 1 and 3 parts in 10,000.
    for axis in (0, 1):
        assert np.abs(np.diff(ratio, axis=axis)).max() < 1e-3


def test_half_floats_hold_the_faint_and_the_bright(gl_contexts, monkeypatch):
    # A table of them, the sun in the middle: 3000 times as bright as the corners.
    camera = {"azimuth_deg": 180.0, "fov_deg": 60.0, "size_px": [25, 15]}
    scene = make(camera, [sun()], drops(ROUND_THE_EYE, 10.0), MIE)
    whole = raw_frame(gl_contexts, scene)
    monkeypatch.setattr(rtbow.tables.layout, "_LARGEST_FLOAT32_BYTES", 0)
    half = raw_frame(gl_contexts, scene)
    assert np.any(half != whole)
    assert whole.max() > 1000.0 * whole[..., 1].min()
    # 5.5e-4: 11 bits.
    np.testing.assert_allclose(half @ LUMINANCE, whole @ LUMINANCE, rtol=1e-3)


# --- What auto makes of the ends ---------------------------------------------------------------


@dataclass(frozen=True)
class End:
    """A scene for method ``auto``.

    Attributes:
        name: of the test.
        method: that has to draw it.
        unsuited: of the reason why it is not ``fast``.
        camera, lights, droplets, render: what differs from the plain scene.
    """

    name: str
    method: str
    unsuited: str
    camera: Keys = field(default_factory=dict)
    lights: Sequence[Keys] = (sun(),)
    droplets: Keys = field(default_factory=drops)
    render: Keys = field(default_factory=dict)
    atmosphere: Keys | None = None


def ends() -> list[End]:
    point = sun(angular_diameter_deg=0.0)
    two_sizes = {
        "grid": [2, 2, 2],
        "radius": {"distribution": "uniform", "min_um": 400.0, "max_um": 500.0},
    }
    yard = ((-20.0, 2.0, 0.0), (20.0, 40.0, 20.0))
    thin = ((0.0, 9_999_999.0, -1000.0), (1.0, 1e7, 1000.0))
    world_end = ((-1e7, -1e7, 0.0), (1e7, 1e7, 2e4))
    wide = {
        "grid": [3, 3, 3],
        "radius": {"distribution": "uniform", "min_um": 9.0, "max_um": 1141.0},
    }
    few = {"wavelength_step_nm": 2.0}
    small: Keys = {"size_px": [8, 6]}
    return [
        End("rain-lamp", "spectral", "optical depth", FAR_LAMP_VIEW, [FAR_LAMP], far_rain(2e5)),
        End("rain-lamp-1e8", "spectral", "optical depth", FAR_LAMP_VIEW, [FAR_LAMP],
            far_rain(1e8)),
        End("rain-sun-1e12", "spectral", "optical depth", FAR_LAMP_VIEW, [sun()], far_rain(1e12)),
        End("lamp-6-m", "spectral", "disc", small, [lamp(position_m=[0.0, -4.0, 4.0],
            diameter_m=6.0)], drops(yard, 2.0)),
        End("lamp-2-m-inside", "spectral", "disc", small,
            [lamp(position_m=[0.0, 15.0, 8.0], diameter_m=3.0)], drops(yard, 1.0)),
        End("point-500-um", "spectral", "angular_diameter", {}, [point]),
        End("point-two-sizes", "spectral", "angular_diameter", {}, [point], drops() | two_sizes),
        End("many-lights", "reference", "20 lights", small,
            [sun(angular_diameter_deg=0.0, altitude_deg=20.0 + k) for k in range(20)],
            drops() | two_sizes, {"wavelength_step_nm": 0.5}),
        End("thin-and-far", "reference", "1 m thick", pixel(0.0, 0.0, 1e-1,
            position_m=[0.5, 0.0, 0.0]), [sun(altitude_deg=41.0)], drops(thin)),
        End("far-end-in-air", "spectral", "", dict(small) | {"position_m": [-1e7, -1e7, 0.0],
            "azimuth_deg": 82.3, "altitude_deg": 23.0}, [sun(altitude_deg=5.0)],
            drops(world_end), few, AIR["atmosphere"]),
        End("tiny-frame-of-many-radii", "spectral", "radii", {}, [sun()], drops() | wide),
    ]  # fmt: skip


@pytest.mark.parametrize("end", ends(), ids=lambda end: end.name)
def test_auto_keeps_the_bound_at_the_ends(end):
    more: dict[str, Any] = {"render": dict(end.render)}
    if end.atmosphere:
        more["atmosphere"] = end.atmosphere
    with Renderer(make(end.camera, end.lights, end.droplets, more), backend="egl") as renderer:
        frame = renderer.render()
        assert renderer.method_used == end.method
        assert end.unsuited in renderer.unsuited
    more["render"] = {"wavelength_step_nm": 1.0} | dict(end.render)
    exact = render_reference(resolve(make(end.camera, end.lights, end.droplets, more)))
    assert exact.max() > 0.0
    found = frame_difference(rgb_to_xyz(frame), rgb_to_xyz(exact))
    assert found.delta_e.p99 < 0.5


def test_a_bow_of_many_radii_at_full_size_stays_fast():
    # The frame costs as much as the tables: they serve the next frames as well.
    droplets = drops() | {
        "grid": [16, 16, 16],
        "radius": {"distribution": "uniform", "min_um": 300.0, "max_um": 700.0},
    }
    scene = make({"size_px": [160, 90]}, [sun()], droplets, {"render": {}})
    with Renderer(scene, backend="egl") as renderer:
        renderer.render()
        assert renderer.method_used == "fast"


def test_method_spectral_takes_the_scenes_own_step():
    lights = [sun(angular_diameter_deg=0.0)]
    frames = []
    for step in (5.0, 1.0):
        scene = make({}, lights, drops(), {"render": {"wavelength_step_nm": step}})
        with Renderer(scene, backend="egl") as renderer:
            frames.append((renderer.render("spectral"), renderer.render()))
    assert np.any(frames[0][0] != frames[1][0])
    np.testing.assert_array_equal(frames[0][1], frames[1][0])


# --- Random scenes ----------------------------------------------------------------------------


def between(low: float, high: float) -> st.SearchStrategy[float]:
    # Few digits: places that differ in float64 alone are not beside a face, but on it.
    return st.floats(low, high).map(lambda x: round(x * 1024.0) / 1024.0)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    return between(math.log10(low), math.log10(high)).map(
        lambda e: float(min(max(10.0**e, low), high))
    )


def places(reach: float, top: float) -> st.SearchStrategy[list[float]]:
    return st.tuples(between(-reach, reach), between(-reach, reach), between(0.0, top)).map(list)


A_SUN = st.fixed_dictionaries(
    {
        "type": st.just("sun"),
        "altitude_deg": between(-3.0, 90.0),
        "azimuth_deg": between(0.0, 360.0),
        "angular_diameter_deg": st.sampled_from([0.0, 0.533, 5.0]),
        "irradiance_w_m2": decades(1e-3, 1e6),
    }
)
A_LAMP = st.fixed_dictionaries(
    {
        "type": st.just("point"),
        "position_m": places(100.0, 50.0),
        "luminous_flux_lm": decades(1.0, 1e6),
        "diameter_m": st.sampled_from([0.0, 0.1]),
    }
)


@st.composite
def boxes(draw: st.DrawFn) -> list[list[float]]:
    size = draw(decades(1.0, 10_000.0))
    low = [draw(between(-size, size)) for _ in range(2)] + [draw(between(0.0, size))]
    return [low, [at + draw(decades(0.01 * size, 2.0 * size)) for at in low]]


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    mie = draw(st.integers(0, 7)) == 0
    droplets: dict[str, Any] = {
        "box_m": draw(boxes()),
        "density": {"number_per_m3": draw(decades(1e-3, 1e9))},
    }
    if mie:
        # The one that the reference sums at a glance.
        droplets["radius"] = {"distribution": "constant", "radius_um": 10.0}
    elif draw(st.booleans()):
        droplets["radius"] = {"distribution": "constant", "radius_um": draw(decades(1.0, 5000.0))}
    else:
        # Small and nearly alike: a light without a disc shows hundreds of fringes of large drops,
        # which random radii sweep across a pixel, and both methods only sample them.
        low = draw(decades(1.0, 20.0))
        ends = {"min_um": low, "max_um": low * draw(between(1.001, 1.01))}
        droplets["radius"] = {"distribution": "uniform", **ends}
        droplets["grid"] = [draw(st.integers(2, 6)) for _ in range(3)]
    if draw(st.booleans()):
        # A given efficiency: that of large drops would need a table of its own.
        droplets |= {"extinction": True, "extinction_efficiency": draw(between(0.5, 2.0))}
    corners = np.array(droplets["box_m"])
    size = float(np.abs(corners).max())
    eye = np.array(draw(places(size, size)))
    # Towards some point of the box, so that most frames have drops in them.
    share = np.array([draw(between(0.0, 1.0)) for _ in range(3)])
    away = corners[0] + share * (corners[1] - corners[0]) - eye
    camera = {
        "position_m": eye.tolist(),
        "azimuth_deg": math.degrees(math.atan2(away[0], away[1])),
        "altitude_deg": math.degrees(math.atan2(away[2], math.hypot(away[0], away[1]))),
        "fov_deg": draw(between(1.0, 150.0)),
        "size_px": [8, 5],
        "polarizer_deg": draw(st.none() | between(-360.0, 360.0)),
    }
    more: dict[str, Any] = {"scattering": {"theory": "mie" if mie else "airy"}}
    if draw(st.booleans()):
        more |= AIR
    lights = draw(st.lists(A_SUN | A_LAMP, min_size=1, max_size=3))
    if mie:
        # A lamp's disc is averaged as if flat, which a glory beside the lamp is not.
        lights = [one | ({"diameter_m": 0.0} if one["type"] == "point" else {}) for one in lights]
    return make(camera, lights, droplets, more)


@settings(
    max_examples=20,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(scene=scenes())
def test_any_scene_is_the_references(gl_contexts, scene):
    frame, exact = raw_frame(gl_contexts, scene), render_reference(resolve(scene))
    assert np.isfinite(frame).all()
    assert np.isfinite(exact).all()
    # Colours outside of Rec. 709 have negative components, but no negative light.
    luminance = frame.astype(np.float64) @ LUMINANCE
    assert luminance.min() >= -1e-6 * np.abs(frame).max()
    # The brightest number, since a red pixel may be the only one with light.
    level = np.abs(exact).max()
    if level < 1e-30:  # so deep in fog or shadow that float32 ends
        assert np.abs(frame).max() < 1e-25
        return
    # 8 in a thousand scenes, of wide discs; by exact theory 18, of its table near the sun.
    bound = 2.5e-2 if scene.scattering.theory == "mie" else 1.2e-2
    assert np.abs(frame - exact).max() < bound * level
