"""Frames of method ``fast`` against the float64 reference at 1 nm, in colour difference.

Each row of the table is a scene and the reason why it is there. A frame is whole, the reference is
computed at pixels spread over it; 99 in 100 of these must be within the scene's own bound.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rtbow
import rtbow.render.fast.lamp
import rtbow.render.fast.light
import rtbow.render.fast.method
import rtbow.render.fast.nodes
import rtbow.render.fast.shared
import rtbow.render.fast.sun
import rtbow.render.fast.sun_colours
from rtbow.base.arrays import Array
from rtbow.base.errors import UnsuitedError
from rtbow.bench.error import PixelSample, colour_error, sample_pixels
from rtbow.frames.difference import frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference.render import radiance_along
from rtbow.render.fast.shared import plan_world
from rtbow.render.fast.sun import plan_sun
from rtbow.scene.model import Scene
from rtbow.scene.text.file import scene_from_text
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.rain.volume import DropletVolume, save_volume
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

Keys = Mapping[str, Any]

BOX = ((-1500.0, 200.0, 0.0), (1500.0, 1200.0, 1100.0))
ROUND_THE_EYE = ((-800.0, -700.0, -600.0), (900.0, 1000.0, 800.0))
YARD = ((-20.0, 1.0, 0.0), (20.0, 30.0, 12.0))
AIR: Keys = {"atmosphere": {"rayleigh": True}}
FOG: Keys = {"extinction": True}


def sun(**changes: Any) -> Keys:
    return {"type": "sun", "altitude_deg": 20.0, "azimuth_deg": 180.0} | changes


def lamp(*position: float, **changes: Any) -> Keys:
    place = list(position or (0.0, -4.0, 5.0))
    return {"type": "point", "position_m": place, "luminous_flux_lm": 5000.0} | changes


POINT: Keys = {"diameter_m": 0.0}


def drops(box: Any = BOX, radius_um: float = 300.0, number: float = 1000.0, **more: Any) -> Keys:
    return {
        "box_m": [list(corner) for corner in box],
        "radius": {"distribution": "constant", "radius_um": radius_um},
        "density": {"number_per_m3": number},
    } | more


def fog(depth: float, box: Any = BOX, radius_um: float = 300.0, **more: Any) -> Keys:
    """Drops with an optical depth over the box's length, were their efficiency 1."""
    length = box[1][1] - box[0][1]
    number = depth / length / (np.pi * (radius_um * 1e-6) ** 2)
    return drops(box, radius_um, number, **(dict(FOG) | more))


def mixture(effective_um: float, **more: Any) -> Keys:
    size = {"effective_radius_um": effective_um, "effective_variance": 0.02}
    radius = {"distribution": "gamma", "mixing": "local", **size}
    return dict(drops()) | {"radius": radius, **more}


def marshall_palmer(**more: Any) -> Keys:
    radius = {"distribution": "marshall-palmer", "min_um": 150.0, "max_um": 900.0}
    return {
        "box_m": [list(corner) for corner in BOX], "grid": [12, 10, 8], "radius": radius,
        "density": {"rain_rate_mm_h": 10.0},
    } | more  # fmt: skip


def per_point(low_um: float, high_um: float) -> Keys:
    radius = {"distribution": "uniform", "min_um": low_um, "max_um": high_um}
    return dict(drops()) | {"radius": radius, "grid": [20, 16, 12]}


# --- Volumes ----------------------------------------------------------------------------------


def shafts(
    radius_um: Callable[[Array, Array, Array], Any],
    box: Any = BOX,
    number: float = 1000.0,
    shape: tuple[int, int, int] = (33, 14, 18),
) -> DropletVolume:
    """Leaning shafts with soft edges and nothing between; radii from places of 0 to 1."""
    x, y, z = np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in shape), indexing="ij")
    wave = np.sin(2.0 * np.pi * (2.3 * x + 0.5 * z) + 3.0 * y)
    density = number * np.clip(0.6 + wave, 0.0, 1.0) * (1.0 - 0.5 * z)
    radius = radius_um(x, y, z) + 0.0 * x
    return DropletVolume(np.array(box), np.float32(radius), np.float32(density))


def one_size(box: Any = BOX, number: float = 1000.0) -> DropletVolume:
    return shafts(lambda x, y, z: 400.0, box, number, (65, 33, 33))


def few_cells() -> DropletVolume:
    return shafts(lambda x, y, z: 400.0)


def cloud() -> DropletVolume:
    return shafts(lambda x, y, z: 10.0 - 2.0 * z + x, number=1e6)


def growing() -> DropletVolume:
    """Drops that grow downwards and to one side, by a half."""
    return shafts(lambda x, y, z: 450.0 - 120.0 * z + 80.0 * x)


def yard_of_sizes() -> DropletVolume:
    return shafts(lambda x, y, z: 250.0 - 60.0 * z + 40.0 * x, YARD)


def corner_of_rain() -> DropletVolume:
    """Rain in a part of its grid only, all around empty."""
    density = np.zeros((12, 12, 12), np.float32)
    density[4:9, 3:7, 2:8] = 1000.0
    radius = np.where(density > 0.0, 400.0, 7.0)
    return DropletVolume(np.array(BOX), np.float32(radius), density)


# --- The table --------------------------------------------------------------------------------


def view(altitude: float = 22.0, fov: float = 75.0, **more: Any) -> Keys:
    return {"altitude_deg": altitude, "fov_deg": fov} | more


@dataclass(frozen=True)
class Case:
    """A row: a scene, and why it is there.

    Attributes:
        name: of the test.
        why: the reason why it is there.
        camera, lights, droplets, more: what differs from the plain scene.
        volume: makes a volume file, in place of droplets.
        delta_e: the scene's own bound.
        pixels: at which the reference is computed.
        step_nm: of the reference.
    """

    name: str
    why: str
    camera: Keys = field(default_factory=dict)
    lights: Sequence[Keys] = (sun(),)
    droplets: Keys = field(default_factory=drops)
    more: Keys = field(default_factory=dict)
    volume: Callable[[], DropletVolume] | None = None
    delta_e: float = 0.5
    pixels: int = 200
    step_nm: float = 1.0

    def scene(self, folder: Path) -> Scene:
        droplets = dict(self.droplets)
        if self.volume is not None:
            path = folder / "volume.npz"
            save_volume(self.volume(), path)
            for key in ("box_m", "radius", "density"):
                droplets.pop(key, None)
            droplets["file"] = str(path)
        parts = {
            "camera": {"altitude_deg": 22.0, "size_px": [96, 54]} | dict(self.camera),
            "light": [dict(light) for light in self.lights],
            "droplets": droplets,
            "render": {"max_delta_e": self.delta_e},
        }
        return Scene.model_validate(parts | dict(self.more))


def volume_cases() -> list[Case]:
    inside = view(position_m=[50.0, 500.0, 300.0])
    askew = {"azimuth_deg": 25.0, "position_m": [-900.0, -600.0, 1.6]}
    return [
        Case("even", "colours alone: a table in the angle"),
        Case("even-fine", "the same, twice as near", delta_e=0.25),
        Case("even-coarse", "the same, half as near", delta_e=1.0),
        Case("zoom", "the bow over the whole picture", view(18.0, 15.0)),
        Case("even-air", "a few samples of air along the ray", more=AIR),
        Case("even-inside", "the box is entered at 0", inside, more=AIR),
        Case("even-corners", "edges and corners of the box in view", view(20.0, 100.0, **askew)),
        Case("shafts", "paths at nodes, one radius", volume=one_size),
        Case("shafts-fine", "nodes nearer each other", volume=one_size, delta_e=0.25),
        Case("shafts-coarse", "nodes farther apart", volume=one_size, delta_e=1.0),
        Case("shafts-air", "mean column from nodes, too", more=AIR, volume=one_size),
        Case("shafts-inside", "rays of all lengths down to none", inside, more=AIR,
             volume=one_size),
        Case("shafts-corners", "blocks that the rain's edge cuts", view(20.0, 100.0, **askew),
             volume=one_size),
        Case("few-cells", "the same rain on a coarser grid", volume=few_cells),
        Case("few-cells-inside", "the same, seen from within", inside, volume=few_cells),
        Case("part-of-grid", "the box is drawn in about what has drops", view(25.0, 90.0),
             volume=corner_of_rain),
        Case("sizes", "rows of radius from nodes", volume=growing),
        Case("sizes-fine", "more rows of them", volume=growing, delta_e=0.25),
        Case("sizes-coarse", "fewer", volume=growing, delta_e=1.0),
        Case("sizes-air", "the air's fall-off is that of the mean radius", more=AIR,
             volume=growing),
        Case("sizes-inside", "drops of many sizes beside the eye", inside, volume=growing),
        Case("per-point", "a radius at every grid point: no nodes",
             droplets=per_point(300.0, 700.0), pixels=60),
        Case("per-point-fine", "the same, twice as near", droplets=per_point(300.0, 700.0),
             delta_e=0.25, pixels=60),
        Case("per-point-air", "the same in air", droplets=per_point(300.0, 700.0), more=AIR,
             pixels=60),
        Case("marshall-palmer", "radii of 1.8 factors e", droplets=marshall_palmer(), more=AIR,
             pixels=40),
        Case("mixture", "all sizes everywhere: one row", droplets=mixture(60.0), pixels=16,
             step_nm=5.0),
        Case("mixture-grid", "the same between nodes", droplets=mixture(60.0, grid=[8, 8, 8]),
             pixels=16, step_nm=5.0),
    ]  # fmt: skip


def extinction_cases() -> list[Case]:
    return [
        Case("fog-thin", "even rain, whose ways out have kinks", droplets=fog(0.3)),
        Case("fog-dense", "light from the outermost part alone", droplets=fog(20.0)),
        Case("fog-air", "air and rain at once", droplets=fog(2.0), more=AIR),
        # The nodes of a small picture of 75 degrees are 6 degrees apart: too far for the kink that
        # the box's upper edge makes in the way out (1.0, at its own edge 5 %).
        Case("fog-small-drops", "blue and red are dimmed differently", view(22.0, 35.0),
             droplets=fog(2.0, radius_um=5.0)),
        Case("fog-grid-thin", "means towards the sun from a texture", droplets=FOG,
             volume=one_size),
        Case("fog-grid-dense", "the same, dense", droplets=FOG,
             volume=lambda: one_size(number=4e4)),
        Case("fog-grid-sizes", "rows of radius, dimmed", droplets=FOG, volume=growing,
             pixels=60),
    ]  # fmt: skip


def camera_cases() -> list[Case]:
    cases = [
        Case("polarizer-air", "both components, each with its share", {"polarizer_deg": 35.0},
             more=AIR),
        Case("polarizer-shafts", "the same between nodes", {"polarizer_deg": 0.0}, more=AIR,
             volume=one_size),
        Case("polarizer-sizes", "rows of both components", {"polarizer_deg": 90.0},
             volume=growing),
    ]  # fmt: skip
    for width, height in ((50, 27), (1, 1), (3, 200), (61, 3)):
        # Nodes lie 8 pixels apart, also beyond the only one that there is.
        camera = view(21.0, {1: 0.2, 3: 2.0}.get(width, 60.0), size_px=[width, height])
        why = "blocks that reach beyond the frame"
        cases.append(Case(f"frame-{width}x{height}", why, camera, volume=one_size))
    return cases


def light_cases() -> list[Case]:
    low = view(30.0, 90.0)
    small = drops(radius_um=20.0)
    aside = view(9.0, 60.0, azimuth_deg=236.0)  # far within the secondary bow
    return [
        Case("sun-below", "the Earth's shadow: no cubic follows the column", low,
             [sun(altitude_deg=-0.5)], more=AIR),
        Case("sun-0.5", "35 airs, all of them red", low, [sun(altitude_deg=0.5)], more=AIR),
        Case("sun-3", "15 airs", low, [sun(altitude_deg=3.0)], more=AIR, volume=one_size),
        Case("sun-60", "the bow is below the horizon", view(-20.0, 75.0,
             position_m=[0.0, 0.0, 800.0]), [sun(altitude_deg=60.0)], more=AIR),
        Case("no-disc", "all fringes of one radius", view(22.0, 40.0),
             [sun(angular_diameter_deg=0.0)], small),
        Case("narrow-disc", "fringes that it does not blur", aside,
             [sun(angular_diameter_deg=0.06)], drops(ROUND_THE_EYE, 430.0)),
        Case("narrow-disc-sizes", "the same of several radii", aside,
             [sun(angular_diameter_deg=0.3)],
             per_point(140.0, 270.0) | {"box_m": [list(corner) for corner in ROUND_THE_EYE]},
             {"scattering": {"orders": [2]}}, pixels=60),
        Case("wide-disc", "ten discs across", {}, [sun(angular_diameter_deg=5.0)]),
        Case("lines", "a spectrum with lines between its wavelengths", {}, [sun(spectrum="FL2")]),
        Case("primary", "one bow", more={"scattering": {"orders": [1]}}),
        Case("secondary", "the other", more={"scattering": {"orders": [2]}}),
        Case("two-suns", "two tables, one frame", {},
             [sun(), sun(altitude_deg=8.0, azimuth_deg=150.0, spectrum="FL2")], volume=one_size),
        Case("mie", "exact theory, from the same table as the reference's", {}, volume=cloud,
             more={"scattering": {"theory": "mie"}}, pixels=8, step_nm=5.0),
    ]  # fmt: skip


def lamp_cases() -> list[Case]:
    yard = drops(YARD, 200.0)
    near = view(10.0, 80.0)
    rows = dict(near) | {"position_m": [0.0, -2.0, 1.6]}
    cases = [
        Case("lamp-point", "a step is exact", rows, [lamp(**POINT)], yard),
        Case("lamp-disc", "the disc by rows of its ratio", rows, [lamp(diameter_m=0.3)], yard),
        Case("lamp-large", "a disc of many degrees", rows,
             [lamp(0.0, -1.5, 5.0, diameter_m=2.0)], yard, pixels=8),
        Case("lamp-in-view", "inside the rain: no drops in it", rows,
             [lamp(2.0, 12.0, 4.0, diameter_m=0.5)], yard, pixels=10),
        Case("lamp-point-in-view", "rays that all but meet it", rows,
             [lamp(2.0, 12.0, 4.0, **POINT)], yard),
        Case("lamp-air", "a few steps", rows, [lamp(diameter_m=0.3)], yard, AIR),
        Case("lamp-polarizer", "both components", dict(rows) | {"polarizer_deg": 20.0},
             [lamp(diameter_m=0.3)], yard),
        Case("lamp-grid", "few steps, and nodes for the rest", rows, [lamp(**POINT)],
             volume=lambda: one_size(YARD)),
        Case("lamp-grid-air", "the same in air", rows, [lamp(diameter_m=0.3)], more=AIR,
             volume=lambda: one_size(YARD)),
        Case("lamp-fog", "long steps in angle through fog", rows, [lamp(**POINT)],
             fog(1.0, YARD, 200.0)),
        Case("lamp-fog-grid", "the same, uneven", rows, [lamp(**POINT)], FOG,
             volume=lambda: one_size(YARD, 1e5)),
        Case("lamp-sizes", "several radii", rows, [lamp(**POINT)], volume=yard_of_sizes),
        Case("lamp-sizes-disc", "several radii, five chords of the disc", rows,
             [lamp(diameter_m=0.1)], volume=yard_of_sizes),
        Case("sun-and-lamp", "one adds to the other", rows, [sun(irradiance_w_m2=0.02), lamp()],
             yard),
    ]  # fmt: skip
    return [replace(case, pixels=min(case.pixels, 24)) for case in cases]


CASES = [
    *volume_cases(), *extinction_cases(), *camera_cases(), *light_cases(), *lamp_cases(),
]  # fmt: skip


# --- Frames and their errors ------------------------------------------------------------------


def truth(scene: Scene, sample: PixelSample, step_nm: float = 1.0) -> Array:
    """The reference's X, Y, Z (n, 3); of each half its own."""
    xyz = np.zeros((len(sample), 3))
    for part, columns in scene.parts():
        inside = (sample.columns >= columns.start) & (sample.columns < columns.stop)
        fine = part.render.model_copy(update={"wavelength_step_nm": step_nm})
        rays = pixel_directions(part.camera)[sample.rows[inside], sample.columns[inside]]
        xyz[inside] = radiance_along(resolve(part.model_copy(update={"render": fine})), rays)
    return xyz


def render(scene: Scene, backend: Any = "egl") -> np.ndarray:
    with rtbow.Renderer(scene, backend) as renderer:
        frame = renderer.render("fast")
        assert renderer.method_used == "fast"
    assert frame.shape == (*scene.camera.size_px[::-1], 3)
    assert np.isfinite(frame).all()
    return frame


def error_of(scene: Scene, exact: Array, sample: PixelSample) -> float:
    found = colour_error(sample.of(render(scene)), exact)
    assert found is not None, "the reference has no light"
    return found.delta_e.p99


SLOW = {"sizes-inside", "per-point-fine", "per-point-air", "marshall-palmer"}


def named(case: Case) -> Any:
    return pytest.param(case, id=case.name, marks=[pytest.mark.slow] * (case.name in SLOW))


@pytest.mark.parametrize("case", [named(case) for case in CASES])
def test_frame(tmp_path, save_failure, case):
    scene = case.scene(tmp_path)
    sample = sample_pixels(scene.camera.size_px, case.pixels)
    exact = truth(scene, sample, case.step_nm)
    frame = render(scene)
    save_failure("pixels", sample.of(frame), exact)
    found = colour_error(sample.of(frame), exact)
    assert found is not None, "the reference has no light"
    assert found.delta_e.p99 <= case.delta_e, case.why


def test_names_are_unique():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)


def case_of(name: str) -> Case:
    return next(case for case in CASES if case.name == name)


@pytest.mark.parametrize("name", ["shafts-air", "sizes", "lamp-disc"])
def test_backends_agree(tmp_path, name):
    scene = case_of(name).scene(tmp_path)
    frames = [render(scene, backend) for backend in ("egl", "osmesa")]
    np.testing.assert_allclose(frames[0], frames[1], rtol=0.0, atol=1e-4 * frames[0].max())


COMPARE = """\
[camera]
size_px = [50, 28]
altitude_deg = 22.0
[[light]]
altitude_deg = 15.0
[droplets]
box_m = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]
radius = { distribution = "constant", radius_um = 300.0 }
density = { number_per_m3 = 1000.0 }
[compare]
split = 0.37
right = { "atmosphere.rayleigh" = true, "droplets.radius.radius_um" = 60.0 }
"""


def test_each_half_of_a_comparison_is_its_own_scenes():
    scene = scene_from_text(COMPARE, "halves.toml")
    sample = sample_pixels(scene.camera.size_px, 200)
    frame, exact = render(scene), truth(scene, sample)
    for half in (sample.columns < 18, sample.columns >= 18):  # 0.37 of 50 columns
        found = colour_error(sample.of(frame)[half], exact[half])
        assert found is not None
        assert found.delta_e.p99 <= 0.5


@pytest.mark.parametrize("kind", ["even", "grid", "sizes"])
@pytest.mark.parametrize("light", [sun(), lamp(diameter_m=0.3)], ids=["sun", "lamp"])
def test_no_drops_no_light(tmp_path, kind, light):
    def empty() -> DropletVolume:
        full = few_cells() if kind == "grid" else growing()
        return replace(full, number_per_m3=np.zeros_like(full.number_per_m3))

    case = Case("empty", "", {"size_px": [20, 12]}, [light], drops(number=0.0), AIR,
                None if kind == "even" else empty)  # fmt: skip
    np.testing.assert_array_equal(render(case.scene(tmp_path)), 0.0)


@pytest.mark.parametrize("name", ["sun-3", "lamp-grid-air", "fog-grid-sizes"])
def test_moved_lights_and_cameras_are_drawn_as_new_ones(tmp_path, name):
    """Tables for scenes that move cover more air, and so err a little differently."""
    scene = case_of(name).scene(tmp_path)
    camera = scene.camera.model_copy(
        update={"azimuth_deg": 8.0, "altitude_deg": 17.0, "position_m": (3.0, -4.0, 2.0)}
    )
    light = scene.light[0]
    changes = {"altitude_deg": 12.0, "azimuth_deg": 170.0}
    if light.type == "point":
        changes = {"position_m": (1.0, -6.0, 4.0)}
    there = scene.model_copy(
        update={"camera": camera, "light": (light.model_copy(update=changes),)}
    )
    with rtbow.Renderer(scene, "egl") as renderer:
        before = renderer.render("fast")
        for one in (there, scene, there):
            renderer.show(one)
            moved = renderer.render("fast")
    fresh = render(there)
    assert np.abs(fresh - before).max() > 0.1 * fresh.max()
    found = frame_difference(rgb_to_xyz(moved), rgb_to_xyz(fresh))
    assert found.delta_e.p99 < 0.25


# --- What the frames would not forgive --------------------------------------------------------


def shift_chords(monkeypatch):
    real = rtbow.render.fast.sun_colours.colour_table

    def shifted(*args: Any, **more: Any) -> Any:
        table = real(*args, **more)
        return replace(table, first=table.first + 4.0 / table.per_chord)

    monkeypatch.setattr(rtbow.render.fast.sun_colours, "colour_table", shifted)


def mix_up_rows(monkeypatch):
    real = rtbow.render.fast.light.hat_fit
    monkeypatch.setattr(
        rtbow.render.fast.light, "hat_fit", lambda fine, rows: np.roll(real(fine, rows), 1, axis=0)
    )


def halve_the_grey_part(monkeypatch):
    real = rtbow.render.fast.sun.set_scene
    monkeypatch.setattr(
        rtbow.render.fast.sun,
        "set_scene",
        lambda program, here, grey: real(program, here, 0.5 * grey),
    )


def leave_the_air_one_colour(monkeypatch):
    monkeypatch.setattr(rtbow.render.fast.light, "column_degree", lambda *_: 0)


def swap_components(monkeypatch):
    real = rtbow.render.fast.light.outcomes
    monkeypatch.setattr(rtbow.render.fast.light, "outcomes", lambda *a, **m: real(*a, **m)[:, ::-1])


def see_no_disc(monkeypatch):
    real = rtbow.render.fast.lamp.over_discs

    def point(table: Any, chord: Array, ratios: Array, fringe: float) -> Any:
        return real(table, chord, np.full(len(ratios), 1e-6), fringe)

    monkeypatch.setattr(rtbow.render.fast.lamp, "over_discs", point)


def coarser(**changes: Any) -> Callable[[Any], None]:
    def patch(monkeypatch: Any) -> None:
        monkeypatch.setattr(rtbow.render.fast.shared, "LEAST_STEPS", 1)
        monkeypatch.setattr(rtbow.render.fast.nodes, "_WIDEST_DEG", 90.0)
        monkeypatch.setattr(rtbow.render.fast.nodes, "_WIDEST_ROWS_DEG", 90.0)
        real = rtbow.render.fast.shared.settings_for
        monkeypatch.setattr(
            rtbow.render.fast.shared,
            "settings_for",
            lambda *a, **m: replace(real(*a, **m), **changes),
        )

    return patch


BROKEN = {
    "chords": ("even", shift_chords),
    "rows": ("sizes", mix_up_rows),
    "grey": ("sun-3", halve_the_grey_part),
    "components": ("polarizer-air", swap_components),
    "disc": ("lamp-disc", see_no_disc),
    "samples": ("shafts-inside", coarser(samples_per_cell=0.05)),
    "bend": ("shafts-corners", coarser(block=16, bend=1e3)),
    "wavelengths": ("even", coarser(wavelength_step_nm=25.0, fringes_missed=1.0)),
    "fringes": ("narrow-disc", coarser(fringes_missed=1.0)),
    "radii": ("sizes", coarser(rows_per_fold=2.0)),
    "air": ("sun-0.5", leave_the_air_one_colour),
    "lamp": ("lamp-sizes", coarser(lamp_scale=0.1)),
}


@pytest.mark.parametrize("what", BROKEN)
def test_broken_methods_are_seen(tmp_path, monkeypatch, what):
    name, spoil = BROKEN[what]
    case = case_of(name)
    scene = case.scene(tmp_path)
    sample = sample_pixels(scene.camera.size_px, case.pixels)
    exact = truth(scene, sample)
    spoil(monkeypatch)
    assert error_of(scene, exact, sample) > case.delta_e


# --- Memory -----------------------------------------------------------------------------------


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text("ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="no /proc/self/statm")
@pytest.mark.parametrize("name", ["shafts-air", "sizes", "lamp-grid"])
def test_frames_leave_no_memory_behind(tmp_path, name):
    case = case_of(name)
    case = replace(case, camera=dict(case.camera) | {"size_px": [24, 14]})
    with rtbow.Renderer(case.scene(tmp_path), "egl") as renderer:
        for _ in range(20):
            renderer.draw("fast")
        before = resident_bytes()
        for _ in range(200):
            renderer.draw("fast")
        assert resident_bytes() - before < 5 * 2**20


def test_a_large_lamp_over_drops_of_many_radii_is_left_to_the_other_method(tmp_path):
    """Five chords of a disc of 1.7 degrees do not blur fringes of 0.3."""
    case = replace(case_of("lamp-sizes-disc"), lights=[lamp(diameter_m=0.3)])
    with rtbow.Renderer(case.scene(tmp_path)) as renderer:
        with pytest.raises(UnsuitedError, match=r"diameter_m = 0\.3"):
            renderer.render("fast")
        renderer.draw("auto")
        assert renderer.method_used == "spectral"


@pytest.mark.parametrize(("width", "block"), [(1280, 3), (640, 3), (480, 2), (320, 0), (64, 0)])
def test_nodes_with_rows_lie_no_farther_apart_than_their_mixture_bends(width, block):
    scene = rtbow.load_scene("shower", {"camera.size_px": [width, width * 9 // 16]})
    plan = plan_world(resolve(scene))
    assert plan_sun(plan, plan.world.optics.suns[0], 16384).block == block
