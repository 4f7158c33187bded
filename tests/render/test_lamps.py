"""Lamps near by: the running integral, rays in the angle at the lamp, and frames against both."""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
import pytest
from scipy.special import airy

import rtbow
from glsl_probe import probe, upload
from lamp_samples import BOX, EYE, FLUX_LM, INSIDE, NM, NUMBER, STEP_NM, lamp, make
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.colour import colour_matching
from rtbow.physics.light.disc import disc_nodes
from rtbow.reference.render import render_reference
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene
from rtbow.tables.airy import (
    MAX_DISC,
    NEAR_S_FIXED,
    build_airy_table,
    near_z_high,
    shader_constants,
)
from rtbow.world.lights import lamps
from rtbow.world.world import resolve
from textbook import LUMINANCE, RGB_TO_XYZ, cross_section, panels, stationary_ray

pytestmark = pytest.mark.slow


@pytest.fixture(params=["osmesa", "egl"])
def backend(request):
    return request.param


def render(scene, backend="osmesa"):
    with rtbow.Renderer(scene, backend) as renderer:
        frame = renderer.render("spectral").astype(np.float64)
    assert np.all(np.isfinite(frame))
    return frame


@cache
def _reference(text):
    frame = render_reference(resolve(Scene.model_validate_json(text)))
    assert np.all(np.isfinite(frame))
    return frame


def reference(scene):
    """The reference's frame, computed once for both backends."""
    return _reference(scene.model_dump_json(exclude_none=True))


def deviation(frame, exact):
    """Greatest deviation of R, G, B per pixel, in units of the frame's bright level."""
    bright = np.percentile(exact @ LUMINANCE, 99.5)
    return np.abs(frame - exact).max(axis=2) / bright


def relative(frame, exact):
    """Greatest deviation of R, G, B per pixel, in units of its own greatest component."""
    return np.abs(frame - exact).max(axis=2) / np.abs(exact).max(axis=2)


# --- The running integral ---------------------------------------------------------------------


@lru_cache
def running_cases(s):
    """z around the bow and far inside it, and the flat disc's mean of z Ai² + Ai'² there."""
    rng = np.random.default_rng(5)
    seam = near_z_high(s)
    z = np.concatenate(
        [
            rng.uniform(-14.0 - s, seam, 500),
            seam + np.array([-0.1, -1e-3, 1e-3, 0.1]),
            rng.uniform(seam, 4.0 * seam, 300),
            rng.uniform(4.0 * seam, 900.0, 100),
            [-400.0],
        ]
    )
    z = np.float64(np.float32(z))
    # Chords of the disc, and nodes for the phase across it.
    count = 32 + int(1.5 * s * np.sqrt(900.0 + s))
    angle = (np.arange(count) + 0.5) * np.pi / count
    share = 2.0 / count * np.sin(angle) ** 2
    at = z[:, None] + s * np.cos(angle)
    value, slope = airy(-at)[:2]
    return z, (at * value**2 + slope**2) @ share


@pytest.fixture(scope="module")
def built():
    return build_airy_table()


# Scaled discs, and bounds just above the worst measured: 1.0e-5, 1.2e-5, 3.5e-5, 5.1e-5 on both
# sides of where the rows widen, 6e-5, 1.1e-4, 1.2e-4, 1.4e-4, and 2.3e-4 for the widest row. Wider
# discs scale.
RUNNING = [
    (0.0, 2e-5),
    (0.05, 2e-5),
    (0.7, 5e-5),
    (NEAR_S_FIXED - 0.01, 8e-5),
    (NEAR_S_FIXED + 0.02, 8e-5),
    (3.0, 1e-4),
    (5.0, 1.5e-4),
    (8.0, 1.5e-4),
    (12.0, 2e-4),
    (MAX_DISC, 3e-4),
]
by_running_disc = pytest.mark.parametrize(("s", "bound"), RUNNING, ids=lambda v: f"{v:.3g}")


@by_running_disc
def test_running_integral(built, s, bound):
    z, exact = running_cases(s)
    got = built.running_airy_squared(z, np.full_like(z, s))
    assert np.abs(got - exact).max() < bound
    assert np.abs(got[z < -12.0 - s]).max() < 1e-9


# Wide discs never come without their code.
SHAPES = [(*case, wide) for case in RUNNING for wide in (False, True) if wide or case[0] < 2.0]


@pytest.mark.parametrize(("s", "bound", "wide"), SHAPES, ids=lambda v: f"{v:.3g}")
def test_glsl_running_integral(gl, built, s, bound, wide):
    assert wide or s <= NEAR_S_FIXED
    z, exact = running_cases(s)
    got = probe(
        gl,
        ["drop/airy.glsl"],
        "airyRunning(nearTable, fringeTable, z, disc)",
        {"z": z, "disc": np.full_like(z, s)},
        {**shader_constants(), "DISC": s > 0.0, "POLE": False, "WIDE": wide, "LAMP_COUNT": 1},
        textures={
            "nearTable": upload(gl, built.near),
            "fringeTable": upload(gl, built.fringe[None]),
        },
    )[:, 0]
    assert np.all(np.isfinite(got))
    # Float32 adds 2e-6 of the integral itself, which is 10 at z = 900.
    assert (np.abs(got - exact) - 2e-6 * np.abs(exact)).max() < bound


def test_running_integral_of_discs_beyond_the_table(built):
    # Only the caustic is left, sqrt(z)/pi: the error scales with it.
    s = np.array([60.0])
    z = np.linspace(-70.0, 200.0, 271)
    angle = (np.arange(3000) + 0.5) * np.pi / 3000
    at = z[:, None] + s * np.cos(angle)
    value, slope = airy(-at)[:2]
    exact = (at * value**2 + slope**2) @ (2.0 / 3000 * np.sin(angle) ** 2)
    got = built.running_airy_squared(z, s)
    assert np.abs(got - exact).max() < 2.5e-3  # measured 1.7e-3, where it is 3


# --- The reference, pixel by pixel ------------------------------------------------------------


def colour_of(per_nm, flux_lm=FLUX_LM):
    """X, Y, Z of a radiance per radiant intensity (len(NM),), under a lamp of equal energy."""
    nm, cmf = colour_matching()
    edges = np.concatenate([[380.0], 0.5 * (NM[:-1] + NM[1:]), [780.0]])
    xyz = np.zeros(3)
    for value, low, high in zip(per_nm, edges[:-1], edges[1:], strict=True):
        fine = np.linspace(low, high, 2001)
        for k in range(3):
            xyz[k] += value * np.trapezoid(np.interp(fine, nm, cmf[:, k]), fine)
    fine = np.linspace(380.0, 780.0, 40_001)
    lumen = np.trapezoid(np.interp(fine, nm, cmf[:, 1]), fine)  # 683 lm/W is in the functions
    return xyz * flux_lm / (4.0 * np.pi * lumen)


@dataclass(frozen=True)
class Ray:
    """One pixel's ray from the eye, and where the lamp is beside it."""

    azimuth: float
    altitude: float
    lamp: tuple[float, float, float]
    radius_um: float = 60.0
    eye: tuple[float, float, float] = EYE
    box: tuple[tuple[float, float, float], ...] = BOX

    @property
    def direction(self):
        azimuth, altitude = np.radians(self.azimuth), np.radians(self.altitude)
        flat = np.cos(altitude)
        return np.array([flat * np.sin(azimuth), flat * np.cos(azimuth), np.sin(altitude)])

    @property
    def span(self):
        """Where the ray is in the box: on all three axes at once."""
        t = (np.array(self.box) - self.eye) / self.direction
        near, far = max(t.min(axis=0).max(), 0.0), t.max(axis=0).min()
        assert near < far
        return near, far

    def at(self, t):
        """Squared distance from the lamp and scattering angle at distances from the eye."""
        place = np.array(self.eye) + np.asarray(t)[..., None] * self.direction
        away = place - np.array(self.lamp)  # the way the light goes
        distance = np.linalg.norm(away, axis=-1)
        cosine = -(away @ self.direction) / distance
        return distance**2, np.arccos(np.clip(cosine, -1.0, 1.0))

    def scene(self, diameter_m=0.0, **changes):
        camera = {
            "position_m": list(self.eye),
            "azimuth_deg": self.azimuth,
            "altitude_deg": self.altitude,
            "fov_deg": 1.0,
            "size_px": [1, 1],
        }
        droplets = {
            "box_m": [list(corner) for corner in self.box],
            "radius": {"distribution": "constant", "radius_um": self.radius_um},
        }
        return make(camera, [lamp(self.lamp, diameter_m=diameter_m)], droplets, **changes)


RAYS = {
    "beside a lamp among the drops": Ray(7.0, 12.0, INSIDE),
    "lamp behind the eye": Ray(20.0, 15.0, (1.0, -8.0, 4.0)),
    "through both bows": Ray(-12.0, 5.0, (5.0, 10.0, 3.0), radius_um=40.0),
    "eye among the drops": Ray(-30.0, 8.0, (-3.0, 12.0, 6.0), eye=(4.0, 5.0, 2.0)),
}
by_ray = pytest.mark.parametrize("ray", RAYS.values(), ids=RAYS.keys())


def index_of(nm):
    return float(relative_index(np.array([nm]), 20.0)[0])


@by_ray
def test_reference_by_quadrature_over_distance(ray):
    t, share = panels(*ray.span, 1500)
    squared, theta = ray.at(t)
    per_nm = []
    for nm in NM:
        section = sum(
            cross_section(index_of(nm), nm * 1e-9, ray.radius_um * 1e-6, theta, k) for k in (1, 2)
        )
        per_nm.append(NUMBER * (share * section / squared).sum())
    got = RGB_TO_XYZ @ render_reference(resolve(ray.scene()))[0, 0]
    np.testing.assert_allclose(got, colour_of(per_nm), rtol=1e-5)  # worst 1e-6


# A curtain of drops, in which the angle at the lamp hardly changes: no fringes are averaged out
# along the ray, and a lamp of another size, or none, is another colour.
CURTAIN = ((-20.0, 12.0, 0.0), (20.0, 12.1, 20.0))


def curtain_ray(theta_deg, radius_um):
    """A ray to the north, and a lamp 20 m from the drops there, under one scattering angle."""
    turn = np.radians(180.0 - theta_deg)
    position = (float(-20.0 * np.sin(turn)), float(12.0 - 20.0 * np.cos(turn)), 2.0)
    return Ray(0.1, 1.0, position, radius_um, box=CURTAIN)


DISC_RAYS = {
    **RAYS,
    "primary": curtain_ray(138.3, 300.0),
    "supernumeraries": curtain_ray(140.5, 300.0),
    "secondary": curtain_ray(128.5, 300.0),
    "far inside": curtain_ray(160.0, 60.0),
}


@pytest.mark.parametrize("diameter_m", [0.1, 0.8])
@pytest.mark.parametrize("ray", DISC_RAYS.values(), ids=DISC_RAYS.keys())
def test_reference_by_quadrature_with_the_lamps_disc(ray, diameter_m):
    t, share = panels(*ray.span, 200 if ray.box is BOX else 10)
    squared, theta = ray.at(t)
    angles, weights, counts = [], [], []
    for angle, distance in zip(theta, np.sqrt(squared), strict=True):
        nodes, part = disc_nodes(angle, np.arcsin(0.5 * diameter_m / distance), 40)
        angles.append(nodes)
        weights.append(part)
        counts.append(len(nodes))
    weight = np.concatenate(weights) * np.repeat(NUMBER * share / squared, counts)
    angle = np.concatenate(angles)
    per_nm = [
        sum(
            (weight * cross_section(index_of(nm), nm * 1e-9, ray.radius_um * 1e-6, angle, k)).sum()
            for k in (1, 2)
        )
        for nm in NM
    ]
    got = RGB_TO_XYZ @ render_reference(resolve(ray.scene(diameter_m)))[0, 0]
    # The reference takes the lamp's disc as flat, this one as part of the sphere: 7e-4 and 5e-3.
    # In the curtain a lamp of twice the size differs by 0.03 to 1.2, a point by 0.02 to 0.9.
    bound = 1e-3 if diameter_m == 0.1 else 1e-2
    np.testing.assert_allclose(got, colour_of(per_nm), rtol=bound)


def closed_form(nm, radius_m, first, last):
    """Integral of the cross-section from one scattering angle to another, (n,), m²."""
    total = 0.0
    for reflections in (1, 2):
        index = index_of(nm)
        _, turn, second = stationary_ray(index, reflections)
        order = reflections + 1
        x = 2.0 * np.pi * radius_m / (nm * 1e-9)
        per_rad = x / (x * second / 2.0) ** (1.0 / 3.0)
        side, bow = (1.0, turn) if order == 2 else (-1.0, 2.0 * np.pi - turn)

        def running(theta, side=side, per_rad=per_rad, bow=bow):
            z = per_rad * side * (theta - bow)
            value, slope = airy(-z)[:2]
            return side / per_rad * (z * value**2 + slope**2)

        strength = cross_section(index, nm * 1e-9, radius_m, bow, reflections) / airy(0.0)[0] ** 2
        total = total + strength * (running(last) - running(first))
    return total


def closed_xyz(ray):
    """rho / D (F(theta_2) - F(theta_1)): all of the ray at once."""
    near, far = ray.span
    beside = np.array(ray.lamp) - ray.eye
    side = np.linalg.norm(np.cross(beside, ray.direction))
    _, (first, last) = ray.at(np.array([near, far]))
    per_nm = [NUMBER / side * closed_form(nm, ray.radius_um * 1e-6, first, last) for nm in NM]
    return colour_of(per_nm)


@by_ray
def test_reference_is_the_closed_form(ray):
    got = RGB_TO_XYZ @ render_reference(resolve(ray.scene()))[0, 0]
    np.testing.assert_allclose(got, closed_xyz(ray), rtol=2e-7)  # worst 5e-8


@pytest.mark.parametrize("radius_um", [60.0, 300.0])
def test_spectral_is_the_closed_form(backend, radius_um):
    camera = {"size_px": [12, 7], "fov_deg": 75.0}
    radius = {"distribution": "constant", "radius_um": radius_um}
    scene = make(camera, [lamp(diameter_m=0.0)], {"radius": radius})
    frame = render(scene, backend)
    exact = np.zeros_like(frame)
    half = np.tan(np.radians(75.0) / 2.0)
    for row in range(7):
        for column in range(12):
            across, above = (column - 5.5) / 6.0 * half, (3.0 - row) / 6.0 * half
            # Looking north, raised by 10 degrees.
            up = np.radians(10.0)
            north, rise = np.cos(up) - above * np.sin(up), np.sin(up) + above * np.cos(up)
            azimuth = np.degrees(np.arctan2(across, north))
            altitude = np.degrees(np.arctan2(rise, np.hypot(across, north)))
            ray = Ray(azimuth, altitude, INSIDE, radius_um)
            t = (np.array(BOX) - EYE) / ray.direction
            if max(t.min(axis=0).max(), 0.0) < t.max(axis=0).min():
                exact[row, column] = np.linalg.solve(RGB_TO_XYZ, closed_xyz(ray))
    brightest = exact.max()
    assert brightest > 0.0
    # Worst 3.6e-5 and 8e-6.
    assert np.abs(frame - exact).max() < 1e-4 * brightest


# --- Steps ------------------------------------------------------------------------------------


def with_steps(scene, steps):
    parts = scene.model_dump(exclude_none=True)
    return Scene.model_validate(parts | {"render": parts["render"] | {"steps": steps}})


@pytest.mark.parametrize("figure", "abcd")
def test_few_steps_do_in_figure_9(backend, save_failure, figure):
    small = {"camera.size_px": [32, 18], "render.wavelength_step_nm": STEP_NM}
    scene = load_scene(f"figures/fig9{figure}", small)
    few, many = (render(with_steps(scene, n), backend) for n in (32, 512))
    save_failure("steps", few, many)
    assert deviation(few, many).max() < 5e-3  # worst 1.3e-3, in (a)


def rough(seed=3, **changes):
    """A lamp among drops of another random radius at every grid point."""
    radius = {"distribution": "uniform", "min_um": 200.0, "max_um": 400.0}
    return make(droplets={"grid": [16, 16, 16], "seed": seed, "radius": radius}, **changes)


@pytest.mark.parametrize("seed", [3, 4])
def test_few_steps_do_in_a_rough_volume(backend, save_failure, seed):
    few, own, many = (
        render(with_steps(rough(seed), n) if n else rough(seed), backend) for n in (32, None, 512)
    )
    save_failure("steps", few, many)
    # The random radii of 15 cells under 32 samples: 9e-3 at the 99th percentile, 1.7e-2 at worst.
    assert np.percentile(deviation(few, many), 99) < 1e-2
    assert np.linalg.norm(few - many) < 1e-2 * np.linalg.norm(many)
    # As many as the scene asks for by itself: 2.7e-3 and 1.2e-2.
    assert np.percentile(deviation(own, many), 99) < 5e-3
    assert deviation(own, many).max() < 1.5e-2


def test_rough_volume_is_the_references(backend, save_failure):
    frame, exact = render(with_steps(rough(), 512), backend), reference(rough())
    save_failure("rough", frame, exact)
    assert np.percentile(deviation(frame, exact), 99) < 1.5e-3  # measured 9e-4
    assert deviation(frame, exact).max() < 3e-3


def test_steps_of_a_pierced_lamp_are_halved_between_both_sides(backend):
    # An odd number of steps: neither the part before nor that behind a lamp may lose one.
    camera = aimed(EYE, INSIDE) | {"size_px": [3, 3], "fov_deg": 1.0}
    scene = make(camera, [lamp(diameter_m=1.0)])
    odd, many = (render(with_steps(scene, n), backend) for n in (65, 800))
    assert relative(odd, many).max() < 1e-2


# --- Limits -----------------------------------------------------------------------------------


def aimed(eye, target):
    """A camera at a place, looking at another."""
    way = np.subtract(target, eye)
    return {
        "position_m": [float(x) for x in eye],
        "azimuth_deg": float(np.degrees(np.arctan2(way[0], way[1]))),
        "altitude_deg": float(np.degrees(np.arctan2(way[2], np.hypot(way[0], way[1])))),
    }


AMONG = (3.0, 10.0, 2.0)
LIMITS = {
    "through the lamp": (aimed(EYE, INSIDE), INSIDE),
    "from among the drops": (aimed(AMONG, INSIDE), INSIDE),
    "lamp right behind the eye": (aimed(EYE, INSIDE), (0.0, -12.5, 1.1)),
    "on the near face": (aimed(EYE, (0.0, 0.0, 5.0)), (0.0, 0.0, 5.0)),
    "on the far face": (aimed(EYE, (0.0, 40.0, 5.0)), (0.0, 40.0, 5.0)),
    "in the near corner": (aimed(EYE, BOX[0]), BOX[0]),
    "in the far corner": (aimed(EYE, BOX[1]), BOX[1]),
}


@pytest.mark.parametrize(
    ("diameter_m", "air"), [(0.0, False), (0.1, False), (0.1, True), (2.0, False)]
)
@pytest.mark.parametrize("name", LIMITS)
def test_rays_through_the_lamp(backend, save_failure, name, diameter_m, air):
    camera, position = LIMITS[name]
    for fov_deg in (20.0, 0.6):  # pixels of 7 and of 0.2 degrees
        scene = make(
            camera | {"size_px": [3, 3], "fov_deg": fov_deg},
            [lamp(position, diameter_m=diameter_m)],
            atmosphere={"rayleigh": air},
        )
        frame, exact = render(scene, backend), reference(scene)
        save_failure(f"fov{fov_deg:g}", frame, exact)
        for row, column in ((1, 0), (1, 2), (0, 1), (2, 1)):
            largest = np.abs(exact[row, column]).max()
            # Worst 2e-3 beside lamps up to 0.1 m; 1.2e-2 on rays that end on a lamp of 2 m, where
            # a flat disc of up to 90 degrees stands for it in both, and fringes pass across.
            bound = 1.5e-2 if diameter_m > 0.1 else 1e-2
            np.testing.assert_allclose(
                frame[row, column], exact[row, column], rtol=0.0, atol=bound * largest
            )
        # The centre itself, where rounding decides how near a ray passes to a point: 1.5e-2.
        np.testing.assert_allclose(
            frame[1, 1], exact[1, 1], rtol=0.0, atol=0.03 * np.abs(exact[1, 1]).max()
        )


@pytest.mark.parametrize("diameter_m", [0.0, 0.1, 2.0])
def test_eye_at_the_lamp(backend, save_failure, diameter_m):
    # Every ray passes the lamp's centre: all light comes straight back.
    scene = make({"position_m": list(INSIDE), "size_px": [9, 5]}, [lamp(diameter_m=diameter_m)])
    frame, exact = render(scene, backend), reference(scene)
    save_failure("eye", frame, exact)
    assert frame.min() >= 0.0
    assert frame.max() > 0.0
    # Worst 8e-7, then 6e-3 and 1.5e-2 with a disc that reaches from 90 to 0.1 degrees on each ray.
    assert relative(frame, exact).max() < {0.0: 2e-6, 0.1: 1e-2, 2.0: 2e-2}[diameter_m]


def test_small_lamps_tend_to_a_point(backend):
    camera = {"size_px": [9, 5]}
    point, small = (render(make(camera, [lamp(diameter_m=d)]), backend) for d in (0.0, 1e-4))
    assert relative(small, point)[point.max(axis=2) > 0.0].max() < 1e-5  # measured 9e-7


# --- Sums and scales --------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_light_falls_off_with_the_square_of_the_distance(method):
    def frame(scale):
        # rho ∫ dt / d²: twice all lengths and the same density is half the light.
        box = [[scale * x for x in corner] for corner in BOX]
        scene = make(
            {"position_m": [scale * x for x in EYE], "size_px": [16, 9]},
            [lamp([scale * x for x in INSIDE], diameter_m=0.0)],
            {"box_m": box},
        )
        return render(scene) if method == "spectral" else reference(scene)

    one, two = frame(1.0), frame(2.0)
    assert one.max() > 0.0
    np.testing.assert_allclose(2.0 * two, one, rtol=0.0, atol=2e-6 * one.max())


@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_lights_add(method):
    first = lamp(spectrum="HP1")
    second = lamp((-8.0, -2.0, 6.0), spectrum="LED-B3", luminous_flux_lm=4000.0, diameter_m=0.0)
    sun = {"altitude_deg": 20.0, "irradiance_w_m2": 0.05}

    def frame(*lights):
        scene = make({"size_px": [16, 9]}, list(lights), atmosphere={"rayleigh": True})
        return render(scene) if method == "spectral" else reference(scene)

    alone = [frame(light) for light in (first, second, sun)]
    assert all(one.max() > 0.0 for one in alone)
    for lights, parts in (
        ((first, second), alone[:2]),
        ((sun, first), [alone[2], alone[0]]),
        ((first, sun, second), alone),
    ):
        together = frame(*lights)
        # One disc among the lights switches the code on for all: 1e-6.
        np.testing.assert_allclose(together, sum(parts), rtol=0.0, atol=1e-5 * together.max())


def test_twice_the_flux_twice_the_light(backend):
    one, two = (render(make({"size_px": [16, 9]}, [lamp(luminous_flux_lm=f)]), backend)
                for f in (500.0, 1000.0))  # fmt: skip
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-6)


def test_a_far_lamp_is_a_sun(backend):
    distance, altitude = 10_000.0, np.radians(20.0)
    position = (0.0, -distance * np.cos(altitude), distance * np.sin(altitude))
    irradiance = 1.0
    # Lumens per watt of equal energy, then the flux that gives this irradiance at the eye.
    nm, cmf = colour_matching()
    fine = np.linspace(380.0, 780.0, 40_001)
    efficacy = np.trapezoid(np.interp(fine, nm, cmf[:, 1]), fine) / 400.0
    flux = irradiance * efficacy * 4.0 * np.pi * distance**2
    camera = {"position_m": [0.0, 0.0, 0.0], "altitude_deg": 20.0, "fov_deg": 90.0}
    # 0.4 m of drops, seen under 4e-5 rad from there: angles of light that differ by as much.
    few = {"box_m": [[-0.2, 0.05, -0.1], [0.2, 0.4, 0.3]]}
    position = tuple(float(x) for x in position)
    far = make(camera, [lamp(position, luminous_flux_lm=float(flux), diameter_m=0.0)], few)
    sun = make(
        camera,
        [
            {
                "altitude_deg": 20.0,
                "spectrum": "equal-energy",
                "irradiance_w_m2": irradiance,
                "angular_diameter_deg": 0.0,
            }
        ],
        few,
    )
    near, exact = render(far, backend), render(sun, backend)
    assert exact.max() > 0.0
    # Fringes without a disc move by these angles: worst 6e-3, and 3e-4 of the whole.
    assert deviation(near, exact).max() < 1e-2
    assert near.sum() == pytest.approx(exact.sum(), rel=1e-3)


# --- Frames -----------------------------------------------------------------------------------


@pytest.mark.parametrize("air", [False, True])
@pytest.mark.parametrize("figure", "ad")
def test_figure_9_is_the_references(backend, save_failure, figure, air):
    changes = {"camera.size_px": [32, 18], "render.wavelength_step_nm": 20.0}
    scene = load_scene(f"figures/fig9{figure}", changes | {"atmosphere.rayleigh": air})
    frame, exact = render(scene, backend), reference(scene)
    save_failure("figure9", frame, exact)
    error = deviation(frame, exact)
    assert np.percentile(error, 99) < 2e-3  # measured 1.1e-3 in (a), 6e-4 in (d)
    assert error.max() < 3e-3


def test_air_dims_the_way_from_the_lamp_and_to_the_eye(backend):
    # Kilometres of air, so that it tells: both ways in every pixel, blue more than red.
    def frames(air):
        box = [[1000.0 * x for x in corner] for corner in BOX]
        scene = make(
            {"position_m": [0.0, -5000.0, 2.0], "size_px": [12, 7], "altitude_deg": 20.0},
            [lamp((0.0, -8000.0, 100.0), luminous_flux_lm=1e10)],
            {"box_m": box},
            atmosphere={"rayleigh": air},
        )
        return render(scene, backend), reference(scene)

    (clear, _), (dimmed, exact) = frames(False), frames(True)
    lit = clear.min(axis=2) > 1e-2 * clear.max()
    assert lit.any()
    passed = dimmed[lit] / clear[lit]
    assert np.all(passed < 0.98)
    assert np.all(passed[:, 2] < passed[:, 0])
    assert deviation(dimmed, exact).max() < 1e-3  # measured 4e-4


@pytest.mark.parametrize("spectrum", ["E490", "equal-energy", "FL1", "HP1", "LED-B3"])
def test_lumens_are_those_that_were_asked_for(spectrum):
    (one,) = lamps(make(lights=[lamp(spectrum=spectrum, luminous_flux_lm=1234.0)]))
    nm, cmf = colour_matching()
    fine = np.linspace(380.0, 780.0, 400_001)
    intensity = np.interp(fine, one.spectrum.wavelength_nm, one.spectrum.value)
    luminosity = np.interp(fine, nm, cmf[:, 1])
    assert luminosity.max() == pytest.approx(683.0, rel=1e-3)  # lm/W
    flux = 4.0 * np.pi * np.trapezoid(intensity * luminosity, fine)
    assert flux == pytest.approx(1234.0, rel=1e-6)


def test_the_side_of_the_lamp_is_the_bright_one(backend):
    # Seen from afar, lamps among the drops to the east, to the west, and above.
    def frame(position, **camera):
        looks = {"position_m": [0.0, -30.0, 10.0], "altitude_deg": 0.0, "fov_deg": 60.0}
        return render(make(looks | camera, [lamp(position)]), backend) @ LUMINANCE

    east = frame((8.0, 20.0, 10.0))
    assert east[:, 16:].sum() > 1.5 * east[:, :16].sum()
    np.testing.assert_allclose(
        frame((-8.0, 20.0, 10.0)), east[:, ::-1], rtol=0.0, atol=1e-5 * east.max()
    )
    south = {"position_m": [0.0, 70.0, 10.0], "azimuth_deg": 180.0}
    west_of_view = frame((8.0, 20.0, 10.0), **south)
    assert west_of_view[:, :16].sum() > 1.5 * west_of_view[:, 16:].sum()
    above = frame((0.0, 20.0, 16.0))
    assert above[:9].sum() > 1.3 * above[9:].sum()


def test_the_lamps_light_comes_back_as_a_bow(backend):
    # A lamp behind the eye, far away for its drops: brightest 42 degrees from the point opposite.
    camera = {"position_m": [0.0, -1.0, 10.0], "altitude_deg": 0.0, "fov_deg": 110.0,
              "size_px": [121, 1]}  # fmt: skip
    scene = make(camera, [lamp((0.0, -4000.0, 10.0), luminous_flux_lm=1e9)])
    light = (render(scene, backend) @ LUMINANCE)[0]
    half = np.tan(np.radians(55.0))
    angle = np.degrees(np.abs(np.arctan((np.arange(121) + 0.5 - 60.5) / 60.5 * half)))
    inside = (angle > 30.0) & (angle < 60.0)
    assert angle[inside][np.argmax(light[inside])] == pytest.approx(41.0, abs=1.0)
    dark = (angle > 44.0) & (angle < 47.0)
    assert dark.any()
    assert light[dark].max() < 0.2 * light[inside].max()
