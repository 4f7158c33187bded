"""Hard cases: scenes at the ends of what is accepted, shader and reference side by side.

Each row of the table is a scene and the reason why it is hard on float32. The raw frame must be
finite before anything clamps it, its numbers zero or normal, and near the float64 reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from textbook import LUMINANCE

from rtbow.scene import Scene
from rtbow.spectral import SpectralPass
from rtbow.volume import DropletVolume, save_volume

EYE = (0.0, 0.0, 1.6)
BOX = ((-1500.0, 200.0, 0.0), (1500.0, 1200.0, 1100.0))
ROUND_THE_EYE = ((-1000.0, -1000.0, -1000.0), (1000.0, 1000.0, 1000.0))
AIR = {"rayleigh": True}
SMALLEST_NORMAL = float(np.finfo(np.float32).tiny)

Keys = Mapping[str, Any]


def sun(**changes: Any) -> dict[str, Any]:
    return {"type": "sun", "altitude_deg": 20.0, "azimuth_deg": 180.0} | changes


def lamp(**changes: Any) -> dict[str, Any]:
    near = {"type": "point", "position_m": [0.0, -2.0, 4.0], "luminous_flux_lm": 5000.0}
    return near | changes


def drops(box: Any = BOX, radius_um: float = 500.0, number: float = 1000.0, **more: Any) -> Keys:
    return {
        "box_m": [list(corner) for corner in box],
        "radius": {"distribution": "constant", "radius_um": radius_um},
        "density": {"number_per_m3": number},
    } | more


def looking(azimuth: float, altitude: float, fov: float = 10.0, **more: Any) -> Keys:
    """One pixel that looks exactly in a direction."""
    at = {"azimuth_deg": azimuth, "altitude_deg": altitude, "fov_deg": fov, "size_px": [1, 1]}
    return at | more


def shifted(box: Any, by: Sequence[float]) -> Any:
    return (np.array(box) + np.array(by)).tolist()


# --- Volumes that a scene cannot describe -----------------------------------------------------


def one_point() -> DropletVolume:
    number = np.zeros((5, 4, 5), np.float32)
    number[2, 1, 2] = 1000.0
    return DropletVolume(np.array(BOX), np.full(number.shape, 500.0, np.float32), number)


def checkered(
    full: float, empty: float, other: float | None = None, box: Any = BOX
) -> DropletVolume:
    """Every other grid point empty, with a radius that means nothing there."""
    at = np.indices((6, 5, 4)).sum(axis=0)
    number = np.where(at % 2 == 0, 1000.0, 0.0)
    radius = np.where(at % 2 == 0, full, empty)
    if other is not None:
        radius = np.where(at % 4 == 0, other, radius)
    return DropletVolume(np.array(box), np.float32(radius), np.float32(number))


def mixed_neighbours(shape: tuple[int, int, int], low: float, high: float) -> DropletVolume:
    """Radii at both ends side by side, all of them with drops, as many as give like light."""
    at = np.indices(shape).sum(axis=0) % 2 == 0
    radius = np.where(at, low, high)
    number = 1000.0 * (high / radius) ** 2
    return DropletVolume(np.array(BOX), np.float32(radius), np.float32(number))


def random_volume(shape: tuple[int, int, int], box: Any = BOX) -> DropletVolume:
    rng = np.random.default_rng(7)
    radius = rng.uniform(450.0, 550.0, shape)
    number = rng.uniform(0.0, 2000.0, shape)
    return DropletVolume(np.array(box), np.float32(radius), np.float32(number))


# --- The table --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A row: a scene, why it is hard, and the bound on its error.

    Attributes:
        name: of the test.
        why: the reason why it is here.
        bound: greatest deviation of R, G, B of any pixel, in units of the level.
        camera, lights, droplets, more: what differs from the plain scene.
        volume: makes a volume file, in place of droplets.
        spectrum: lines of a CSV file for the first light.
        level: percentile of the reference's luminance that is the unit.
        every: one column in so many is compared.
        dark: whether every pixel is 0.
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
        "light": list(lights),
        "droplets": dict(droplets),
        "render": {"wavelength_step_nm": 40.0},
    }
    return Scene.model_validate(parts | dict(more))


def thick(tau: float, box: Any = BOX, radius_um: float = 500.0, **more: Any) -> Keys:
    """Drops with an optical depth through the box's 1000 m, at an efficiency of 1."""
    number = tau / 1000.0 / (np.pi * (radius_um * 1e-6) ** 2)
    each = {"extinction": True, "extinction_efficiency": 1.0}
    return drops(box, radius_um, number, **(each | more))


HIGH_BOX = ((-3000.0, 500.0, 0.0), (3000.0, 3000.0, 9000.0))
FAR = (707_000.0, -707_000.0, 0.0)
UP_TO_FACE = ((0.0, 0.0, 0.0), (1000.0, 1000.0, 1000.0))
MIE = {"scattering": {"theory": "mie"}}
STEPS_1 = {"render": {"wavelength_step_nm": 40.0, "steps": 1}}
RED_LINE = "380,0\n632.8,0\n632.81,1\n632.82,0\n780,0\n"
FLAT_TINY = "380,1e-12\n780,1e-12\n"
FLAT_HUGE = "380,1e12\n780,1e12\n"

CASES = [
    # --- The sun's altitude, with air
    Case("sun-90", "no azimuth; the bow lies below", 1.0,
         {"position_m": [0.0, 0.0, 1500.0], "altitude_deg": -50.0}, [sun(altitude_deg=90.0)],
         drops(((-3000.0, -3000.0, 0.0), (3000.0, 3000.0, 1000.0))), {"atmosphere": AIR}),
    Case("sun-10", "two kilometres of air", 1.0, {}, [sun(altitude_deg=10.0)], drops(), {"atmosphere": AIR}),
    Case("sun-0", "the column's steepest change", 1.0, {}, [sun(altitude_deg=0.0)], drops(), {"atmosphere": AIR}),
    Case("sun-0.5-below", "the Earth's shadow within the box", 1.0, {"altitude_deg": 35.0}, [sun(altitude_deg=-0.5)], drops(HIGH_BOX), {"atmosphere": AIR}),
    Case("sun-2-below", "lit from 3884 m up only", 1.0, {"altitude_deg": 60.0, "fov_deg": 60.0}, [sun(altitude_deg=-2.0)], drops(HIGH_BOX), {"atmosphere": AIR}),
    # --- The eye
    Case("eye-0", "height 0: the root of the height in the column texture", 1.0, {"position_m": [0.0, 0.0, 0.0]}, [sun(altitude_deg=5.0)], drops(), {"atmosphere": AIR}),
    Case("eye-10-km", "a column that falls by e^-1.25 towards the drops", 1.0, {"position_m": [0.0, 0.0, 10_000.0], "altitude_deg": -35.0}, [sun(altitude_deg=20.0)],
         drops(((-9000.0, 500.0, 0.0), (9000.0, 20_000.0, 4000.0))), {"atmosphere": AIR}),
    Case("eye-inside", "no entry: spans begin at 0", 1.0, {"position_m": [10.0, 600.0, 500.0]}, [sun()], drops(), {"atmosphere": AIR}),
    Case("eye-on-face", "a face at distance 0", 1.0, {"position_m": [0.0, 200.0, 500.0]}),
    Case("eye-on-corner", "three faces at distance 0", 1.0, {"position_m": [-1500.0, 200.0, 0.0], "azimuth_deg": 45.0}),
    Case("far-from-origin", "1000 km of offset: float32 keeps 6 cm of it", 1.0, {"position_m": [EYE[0] + FAR[0], EYE[1] + FAR[1], EYE[2]]}, [sun()], drops(shifted(BOX, FAR)), {"atmosphere": AIR}),
    Case("far-from-origin-grid", "the same with grid points", 1.0, {"position_m": [EYE[0] + FAR[0], EYE[1] + FAR[1], EYE[2]]}, volume=lambda: random_volume((4, 4, 4), shifted(BOX, FAR))),
    # --- Rays along axes and in faces
    *[Case(f"along-{name}", "a direction with zeros or 6e-17: divided by", 1.0, looking(azimuth, altitude, position_m=[500.0, 500.0, 500.0]),
           [sun(azimuth_deg=azimuth + 180.0, altitude_deg=40.0 - altitude if abs(altitude) < 1 else 40.0)], drops(UP_TO_FACE))
      for name, azimuth, altitude in (("north", 0.0, 0.0), ("east", 90.0, 0.0), ("south", 180.0, 0.0), ("west", 270.0, 0.0), ("up", 0.0, 90.0), ("down", 0.0, -90.0))],
    *[Case(f"in-face-{name}", "a ray in the plane of a face, from an edge", 1.0, looking(azimuth, altitude, position_m=list(eye)),
           [sun(azimuth_deg=azimuth + 180.0, altitude_deg=40.0)], drops(UP_TO_FACE))
      for name, azimuth, altitude, eye in (("west", 0.0, 0.0, (0.0, 0.0, 500.0)), ("bottom", 0.0, 0.0, (500.0, 0.0, 0.0)), ("top", 0.0, 0.0, (500.0, 0.0, 1000.0)), ("east", 0.0, 0.0, (1000.0, 0.0, 500.0)),
        ("south", 90.0, 0.0, (0.0, 0.0, 500.0)), ("north", 90.0, 0.0, (0.0, 1000.0, 500.0)),  ("up-south", 0.0, 90.0, (500.0, 0.0, 0.0)), ("up-north", 0.0, 90.0, (500.0, 1000.0, 0.0)),
        ("edge", 0.0, 0.0, (0.0, 0.0, 0.0)), ("edge-1", 0.0, 0.0, (1000.0, -5.0, 1000.0)))],
    Case("in-face-grid", "a ray in the plane of a face of a grid with air and extinction", 1.0, looking(0.0, 0.0, position_m=[-1500.0, 200.0, 0.0]), [sun(altitude_deg=40.0)], {"extinction": True},
         {"atmosphere": AIR}, volume=lambda: random_volume((3, 4, 5))),
    # --- Poles
    *[Case(f"{pole}-pixel-{theory}-{radius}", "the scattering angle's own end, where its sine is 0", 1.0, looking(0.0 if pole == "antisolar" else 180.0, -20.0 if pole == "antisolar" else 20.0, 0.1), [sun()], drops(ROUND_THE_EYE, float(radius)), {"scattering": {"theory": theory}})
      for pole in ("antisolar", "solar") for theory in ("airy", "mie") for radius in (10, 500)],
    *[Case(f"{pole}-pixel-point-{theory}", "the scattering angle's own end, no disc", 1.0, looking(0.0 if pole == "antisolar" else 180.0, -20.0 if pole == "antisolar" else 20.0, 0.1), [sun(angular_diameter_deg=0.0)], drops(ROUND_THE_EYE, 10.0), {"scattering": {"theory": theory}})
      for pole in ("antisolar", "solar") for theory in ("airy", "mie")],
    # --- Radii
    Case("radius-1-um", "Airy far from where it holds", 1.0, {}, [sun()], drops(radius_um=1.0, number=1e9)),
    Case("radius-1-um-mie", "the table's first radius", 1.0, {}, [sun()], drops(radius_um=1.0, number=1e9), MIE),
    Case("radius-5-mm", "the narrowest bow: z in the thousands", 1.0, {}, [sun()], drops(radius_um=5000.0)),
    Case("radius-5-mm-point", "the same without a disc", 1.0, {}, [sun(angular_diameter_deg=0.0)], drops(radius_um=5000.0)),
    Case("mie-10-um", "", 1.0, {}, [sun()], drops(radius_um=10.0), MIE),
    Case("mie-500-um", "", 1.0, {}, [sun()], drops(radius_um=500.0), MIE),
    Case("gamma-local", "", 1.0, {}, [sun()], drops() | {"radius": {"distribution": "gamma", "effective_radius_um": 300.0, "effective_variance": 0.1, "mixing": "local"}}),
    Case("gamma-local-mie", "", 1.0, {}, [sun()], drops() | {"radius": {"distribution": "gamma", "effective_radius_um": 10.0, "effective_variance": 0.1, "mixing": "local"}}, MIE),
    Case("alexander", "Airy's function underflows in the deep shadow", 1.0, {"altitude_deg": 26.0, "fov_deg": 3.0}, [sun()], drops(radius_um=5000.0), dark=True),
    Case("alexander-500", "Airy's function underflows in the deep shadow", 1.0, {"altitude_deg": 26.0, "fov_deg": 3.0}, [sun()], drops(radius_um=500.0)),
    # --- Volumes
    Case("two-points-thin", "one voxel thin", 1.0, volume=lambda: random_volume((5, 2, 5), ((-1500.0, 200.0, 0.0), (1500.0, 200.01, 1100.0)))),
    Case("two-points", "2 points along each axis", 1.0, volume=lambda: random_volume((2, 2, 2))),
    Case("thin-box", "1 cm", 1.0, {}, [sun()], drops(((-1500.0, 200.0, 0.0), (1500.0, 200.01, 1100.0)))),
    Case("one-point", "density in a single point", 1.0, volume=one_point),
    Case("one-point-extinction", "density in a single point", 1.0, droplets={"extinction": True}, volume=one_point),
    Case("empty-points-huge", "", 1.0, volume=lambda: checkered(500.0, 3e38)),
    Case("empty-points-zero", "", 1.0, volume=lambda: checkered(500.0, 0.0)),
    Case("empty-points-huge-2", "", 1.0, volume=lambda: checkered(500.0, 3e38, 510.0)),
    Case("empty-points-negative", "", 1.0, volume=lambda: checkered(500.0, -3e38, 510.0)),
    Case("empty-points-huge-ext", "", 1.0, droplets={"extinction": True}, volume=lambda: checkered(500.0, 3e38, 510.0)),
    Case("wild-neighbours", "", 1.0, volume=lambda: mixed_neighbours((4, 4, 4), 1.0, 5000.0)),
    Case("wild-neighbours-empty", "", 1.0, volume=lambda: checkered(1.0, 5000.0, 5000.0)),
    Case("grid-512", "", 1.0, volume=lambda: random_volume((512, 2, 2))),
    Case("grid-512-y", "", 1.0, volume=lambda: random_volume((2, 512, 2))),
    Case("density-1e-6", "", 1.0, {}, [sun()], drops(number=1e-6)),
    Case("density-1e12", "", 1.0, {}, [sun()], drops(number=1e12)),
    Case("density-1e-6-1um", "", 1.0, {}, [sun()], drops(number=1e-6, radius_um=1.0, box=((-.005, .2, 0.0), (.005, .21, .01)))),
    Case("box-1-cm", "", 1.0, {"position_m": [0.0, 0.0, 0.0]}, [sun()], drops(((-0.01, 0.01, 0.0), (0.01, 0.02, 0.01)))),
    Case("box-500-km", "", 1.0, {}, [sun()], drops(((-250e3, -250e3, 0.0), (250e3, 250e3, 10e3)))),
    Case("box-500-km-air", "", 1.0, {}, [sun()], drops(((-250e3, -250e3, 0.0), (250e3, 250e3, 10e3))), {"atmosphere": AIR}),
    Case("box-500-km-cube-air", "", 1.0, {}, [sun()], drops(((-250e3, -250e3, 0.0), (250e3, 250e3, 500e3))), {"atmosphere": AIR}),
    Case("one-step", "", 1.0, {}, [sun()], drops(), STEPS_1),
    Case("one-step-air", "", 1.0, {}, [sun()], drops(), STEPS_1 | {"atmosphere": AIR}),
    Case("one-step-ext", "", 1.0, {}, [sun()], thick(1.0), STEPS_1),
    # --- spectra
    Case("one-line", "", 1.0, spectrum=RED_LINE),
    Case("tiny-units", "", 1.0, spectrum=FLAT_TINY),
    Case("huge-units", "", 1.0, spectrum=FLAT_HUGE),
    Case("irradiance-1e12", "", 1.0, {}, [sun(irradiance_w_m2=1e12)]),
    Case("irradiance-1e-30", "", 1.0, {}, [sun(irradiance_w_m2=1e-30)]),
    Case("irradiance-1e12-max", "", 1.0, {}, [sun(irradiance_w_m2=1e12)], drops(((-250e3, -250e3, 0.0), (250e3, 250e3, 500e3)), 5000.0, 1e12)),
    Case("irradiance-1e12-mie", "", 1.0, {"azimuth_deg": 180.0}, [sun(irradiance_w_m2=1e12)], drops(ROUND_THE_EYE, 500.0), MIE),
    Case("lights-1e9", "", 1.0, {}, [sun(irradiance_w_m2=1e9), sun(altitude_deg=5.0, azimuth_deg=150.0, irradiance_w_m2=1.0)]),
    Case("lights-1e9-lamp", "", 1.0, {}, [sun(irradiance_w_m2=1e6), lamp(luminous_flux_lm=1000.0)]),
    # camera
    Case("fov-0.1", "", 1.0, {"altitude_deg": 21.9, "fov_deg": 0.1}),
    Case("fov-0.1-5mm", "", 1.0, {"altitude_deg": 22.0, "fov_deg": 0.1}, [sun()], drops(radius_um=5000.0)),
    Case("fov-179", "", 1.0, {"fov_deg": 179.0}, [sun()], drops(ROUND_THE_EYE)),
    Case("fov-179-mie", "", 1.0, {"fov_deg": 179.0}, [sun()], drops(ROUND_THE_EYE, 10.0), MIE),
    Case("fov-179.99", "", 1.0, {"fov_deg": 179.999}, [sun()], drops(ROUND_THE_EYE)),
    Case("frame-1x1", "", 1.0, {"size_px": [1, 1]}),
    Case("frame-8192x16", "", 1.0, {"size_px": [8192, 16]}, every=700),
    # --- extinction
    Case("fog-50", "", 1.0, {}, [sun()], thick(50.0)),
    Case("fog-50-q", "", 1.0, {}, [sun()], thick(50.0, extinction_efficiency=None)),
    Case("fog-50-air-grid", "", 1.0, {}, [sun()], {"extinction": True}, {"atmosphere": AIR}, volume=lambda: random_volume((4, 4, 4))),
    Case("fog-1-um-50", "", 1.0, {}, [sun()], thick(50.0, radius_um=1.0, extinction_efficiency=None), MIE),
    Case("fog-1e6", "", 1.0, {}, [sun()], thick(1e6)),
    Case("fog-1e6-1um-q", "", 1.0, {}, [sun()], thick(1e6, radius_um=1.0, extinction_efficiency=None)),
    Case("fog-1e12-density", "", 1.0, {}, [sun()], drops(number=1e12, extinction=True)),
    Case("fog-behind", "", 1.0, {}, [sun(azimuth_deg=0.0, altitude_deg=0.0)], thick(1e6), dark=True),
    Case("fog-behind-mie", "", 1.0, {}, [sun(azimuth_deg=0.0, altitude_deg=0.0)], thick(1e6, radius_um=10.0), MIE, dark=True),
    Case("fog-behind-50-mie", "", 1.0, {}, [sun(azimuth_deg=0.0, altitude_deg=0.0)], thick(50, radius_um=10.0), MIE),
    Case("fog-inside", "", 1.0, {"position_m": [0.0, 700.0, 500.0]}, [sun()], thick(50.0)),
    Case("fog-inside-1e6", "", 1.0, {"position_m": [0.0, 700.0, 500.0]}, [sun()], thick(1e6)),
    Case("fog-inside-mie", "", 1.0, {"position_m": [0.0, 700.0, 500.0]}, [sun()], thick(50.0, radius_um=10.0), MIE),
    Case("fog-lamp", "", 1.0, {"position_m": [0.0, 5.0, 1.6], "altitude_deg": 0.0}, [lamp()], thick(50.0, ((-20.0, -10.0, 0.0), (20.0, 30.0, 10.0)))),
    Case("fog-lamp-dense", "", 1.0, {"position_m": [0.0, 5.0, 1.6], "altitude_deg": 0.0}, [lamp()], thick(2000.0, ((-20.0, -10.0, 0.0), (20.0, 30.0, 10.0)))),
    Case("fog-lamp-outside", "", 1.0, {"position_m": [0.0, 5.0, 1.6], "altitude_deg": 0.0}, [lamp()], thick(2000.0, ((-20.0, 10.0, 0.0), (20.0, 30.0, 10.0)))),
    # --- polariser
    *[Case(f"polarizer-antisolar-{theory}", "", 1.0, looking(0.0, -20.0, 0.1, polarizer_deg=0.0), [sun()], drops(ROUND_THE_EYE, 10.0), {"scattering": {"theory": theory}}) for theory in ("airy", "mie")],
    *[Case(f"polarizer-around-{theory}", "", 1.0, looking(0.0, -20.0, 3.0, polarizer_deg=30.0, size_px=[15, 15]), [sun()], drops(ROUND_THE_EYE, 10.0), {"scattering": {"theory": theory}}) for theory in ("airy", "mie")],
    # --- lamps
    Case("lamp-in-line", "", 1.0, looking(0.0, 0.0, 5.0, position_m=[0.0, 0.0, 0.0]), [lamp(position_m=[0.0, 500.0, 0.0], diameter_m=0.0)], drops(ROUND_THE_EYE)),
    Case("lamp-in-line-disc", "", 1.0, looking(0.0, 0.0, 5.0, position_m=[0.0, 0.0, 0.0]), [lamp(position_m=[0.0, 500.0, 0.0])], drops(ROUND_THE_EYE)),
    Case("lamp-at-eye", "", 1.0, {"position_m": [0.0, 0.0, 0.0]}, [lamp(position_m=[0.0, 0.0, 0.0], diameter_m=0.0)], drops(ROUND_THE_EYE)),
    Case("lamp-far", "", 1.0, {"position_m": [0.0, 0.0, 0.0]}, [lamp(position_m=[0.0, -1e7, 1e6], luminous_flux_lm=1e12)], drops(ROUND_THE_EYE)),
]  # fmt: skip


def raw_frame(contexts: Any, scene: Scene) -> np.ndarray:
    """Draw the shader's frame, before anything looks at it."""
    context = contexts("egl")
    with context.current():
        return SpectralPass(context, scene).render()


def errors_of(frame: np.ndarray, exact: np.ndarray, percentile: float) -> np.ndarray:
    level = float(np.percentile(exact @ LUMINANCE, percentile))
    return np.abs(frame.astype(np.float64) - exact).max(axis=2) / (level or 1.0)


# --- Random scenes ----------------------------------------------------------------------------


def between(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high)


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
        more["atmosphere"] = AIR
    lights = draw(st.lists(A_SUN | A_LAMP, min_size=1, max_size=3))
    if mie:
        # A lamp's disc is averaged as if flat, which a glory beside the lamp is not.
        lights = [one | ({"diameter_m": 0.0} if one["type"] == "point" else {}) for one in lights]
    return make(camera, lights, droplets, more)
