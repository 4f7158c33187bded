"""The rain's own extinction against Beer and Lambert's closed forms, worked apart from the code."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j1

import rtbow
from rtbow.scene.model import Scene
from rtbow.world.lights import Lamp, Sun
from rtbow.world.measured.spectra import load_spectrum
from rtbow.world.optics import scene_optics
from rtbow.world.rain.extinction import (
    disc_share,
    effective_efficiencies,
    mean_extinction_towards,
    paths_to,
    rain_extinction,
)
from rtbow.world.rain.volume import build_volume

RADIUS_M = 3e-4
AREA_M2 = np.pi * RADIUS_M**2
THICKNESS_M = 100.0
SLAB = [[-1e5, 200.0, -1e5], [1e5, 200.0 + THICKNESS_M, 1e5]]
BOX = [[-60.0, 100.0, -20.0], [50.0, 180.0, 70.0]]
WHITE = {"type": "sun", "altitude_deg": 20.0, "spectrum": "equal-energy"}


def make(box, depth, extinction=True, **changes):
    """A scene of even rain that takes a vertical beam of the slab's thickness to ``depth``."""
    number = depth / (AREA_M2 * THICKNESS_M)
    droplets = {
        "box_m": box,
        "radius": {"distribution": "constant", "radius_um": RADIUS_M * 1e6},
        "density": {"number_per_m3": number},
        "extinction": extinction,
        "extinction_efficiency": 1.0,
    } | changes.pop("droplets", {})
    camera = {"size_px": [24, 14], "altitude_deg": 20.0, "fov_deg": 75.0}
    camera |= changes.pop("camera", {})
    parts = {
        "camera": camera,
        "light": [WHITE],
        "droplets": droplets,
        "render": {"wavelength_step_nm": 40.0},
    }
    return Scene.model_validate(parts | changes)


def render(scene, method):
    with rtbow.Renderer(scene, "egl") as renderer:
        frame = renderer.render(method).astype(np.float64)
    assert np.all(np.isfinite(frame))
    return frame


def rays(scene):
    """Directions of the pixels' centres (h, w, 3), from the definition of the camera alone."""
    width, height = scene.camera.size_px
    half = np.tan(np.radians(0.5 * scene.camera.fov_deg))
    u = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * half
    v = -((np.arange(height) + 0.5) / height * 2.0 - 1.0) * half * height / width
    a = np.radians(scene.camera.altitude_deg)
    forward, up = np.array([0.0, np.cos(a), np.sin(a)]), np.array([0.0, -np.sin(a), np.cos(a)])
    d = forward + u[None, :, None] * np.array([1.0, 0.0, 0.0]) + v[:, None, None] * up
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def sun_direction(azimuth_deg=180.0):
    a, z = np.radians(20.0), np.radians(azimuth_deg)
    return np.array([np.sin(z) * np.cos(a), np.cos(z) * np.cos(a), np.sin(a)])


# --- How much a drop takes


@pytest.mark.parametrize("v", [0.1, 1.0, 3.8317, 12.0, 60.0])
def test_share_of_diffraction_within_the_disc(v):
    # Airy's pattern integrated: (1/2) the integral of (2 J1(t)/t)² t over 0..v.
    expected, _ = quad(lambda t: 2.0 * j1(t) ** 2 / t, 0.0, v, limit=400)
    assert disc_share(np.array([v / np.sin(0.01)]), 0.01)[0] == pytest.approx(expected, rel=1e-7)


def test_efficiency_by_drop_size():
    scene = make(SLAB, 1.0, droplets={"extinction_efficiency": None})
    optics = scene_optics(scene)
    radii = np.array([2e-6, 10e-6, 100e-6, 500e-6, 1400e-6])
    q = effective_efficiencies(scene, optics, radii, np.array([550.0]))[:, 0]
    # From the forms for large x: 2 + 1.9924 x^(-2/3) less 1 - 2/(pi v), v = x sin(disc).
    x = 2.0 * np.pi * radii / 550e-9
    v = x * np.sin(np.radians(0.2665))
    large = 1.0 + 1.9924 * x ** (-2.0 / 3.0) + 2.0 / (np.pi * v)
    np.testing.assert_allclose(q[3:], large[3:], rtol=2e-3)
    assert 1.9 < q[1] < 2.1
    assert np.all(np.diff(q[1:]) < 0.0)
    fixed = make(SLAB, 1.0, droplets={"extinction_efficiency": 1.7})
    assert np.all(effective_efficiencies(fixed, optics, radii, np.array([550.0])) == 1.7)


@pytest.mark.parametrize("radius_m", [1e-3, 2e-3, 5e-3])
def test_light_that_grazes_the_edge_of_a_drop(radius_m):
    """Q is 1 for the drop itself, what diffraction takes beyond the disc, and the edge's term."""
    scene = make(SLAB, 1.0, droplets={"extinction_efficiency": None})
    x = 2.0 * np.pi * radius_m / 550e-9
    v = x * np.sin(np.radians(0.2665))
    q = effective_efficiencies(scene, scene_optics(scene), np.array([radius_m]), np.array([550.0]))
    edge = (q[0, 0] - 1.0 - 2.0 / (np.pi * v)) * x ** (2.0 / 3.0)
    # 2.4 % for 1 mm, where the disc is narrow for its share by large v; 0.3 % for 5 mm.
    assert edge == pytest.approx(1.9924, rel=0.05)


@pytest.mark.parametrize("kind", ["sun", "lamp inside", "lamp outside"])
def test_ways_to_a_light_end_with_the_box_or_at_the_light(rng, kind):
    """By bisection on whether a place is inside, from random places in a box."""
    low, high = np.array(BOX, dtype=float)
    points = low + (high - low) * rng.random((200, 3))
    place = {
        "sun": 1e9 * sun_direction(200.0), "lamp inside": np.array([3.0, 120.0, 11.0]),
        "lamp outside": np.array([200.0, 90.0, -60.0]),
    }[kind]  # fmt: skip
    spectrum = load_spectrum("equal-energy")
    light = Lamp(place, 0.0, spectrum)
    if kind == "sun":
        light = Sun(sun_direction(200.0), np.radians(20.0), 0.0, spectrum)
    directions, lengths = paths_to(light, points, np.array([low, high]))
    for point, got, length in zip(points, directions, lengths, strict=True):
        # The sun is as far off as float64 allows, so that all ways to it are parallel to 1e-7.
        towards = (place - point) / np.sqrt(np.sum((place - point) ** 2))
        np.testing.assert_allclose(got, towards, atol=5e-7 if kind == "sun" else 1e-12)
        assert np.sum(got**2) == pytest.approx(1.0, abs=1e-12)
        inside, outside = 0.0, 1e4
        for _ in range(60):
            middle = 0.5 * (inside + outside)
            at = point + middle * got
            reached = kind != "sun" and middle > np.sqrt(np.sum((place - point) ** 2))
            if reached or np.any(at < low) or np.any(at > high):
                outside = middle
            else:
                inside = middle
        assert length == pytest.approx(inside, abs=1e-8)


def test_extinction_of_a_mixture_is_the_sum_of_its_sizes():
    mixed = {"distribution": "gamma", "effective_radius_um": 20.0, "effective_variance": 0.1}
    scene = make(SLAB, 1.0, droplets={"radius": mixed | {"mixing": "local"}})
    volume = build_volume(scene.droplets)
    rain = rain_extinction(scene, scene_optics(scene), volume)
    # Mean area of Hansen's gamma: n(r) r² has the mean square a² (1 - v)(1 - 2v).
    area = np.pi * 20e-6**2 * 0.9 * 0.8
    number = float(volume.number_per_m3[0, 0, 0])
    assert rain.greatest == pytest.approx(number * area, rel=1e-3)


# --- Beer and Lambert


@pytest.mark.slow
@pytest.mark.parametrize("method", ["spectral", "reference"])
@pytest.mark.parametrize("depth", [0.01, 0.5, 3.0, 50.0])
def test_even_slab(method, depth):
    """Both ways through a slab without end: (1 - exp(-k D)) / (k D), k = beta (1/mu + 1/mu')."""
    dimmed = render(make(SLAB, depth), method)
    clear = render(make(SLAB, depth, extinction=False), method)
    directions = rays(make(SLAB, depth))
    to_eye, to_sun = 1.0 / directions[..., 1], 1.0 / np.cos(np.radians(20.0))
    u = depth * (to_eye + to_sun)
    expected = -np.expm1(-u) / u
    bright = clear[..., 1] > 1e-3 * clear.max()
    assert np.count_nonzero(bright) > 20
    passed = dimmed[bright] / clear[bright]
    np.testing.assert_allclose(
        passed, np.broadcast_to(expected[bright, None], passed.shape), rtol=1e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_small_drops_dim_colours_by_their_own_efficiency(method, tmp_path):
    """Two narrow lines through 2 µm drops: Beer and Lambert with Q summed here."""
    from rtbow.physics.drop.mie import efficiency
    from rtbow.physics.drop.water import relative_index

    radius_m = 2e-6
    passed = {}
    for nm in (420.0, 700.0):
        line = tmp_path / f"line{nm:.0f}.csv"
        rows = [(300, 0), (nm - 20, 0), (nm, 1), (nm + 20, 0), (800, 0)]
        line.write_text("".join(f"{at},{value}\n" for at, value in rows), "utf-8")
        change = {"light": [WHITE | {"spectrum": str(line), "angular_diameter_deg": 0.0}]}
        drops = {
            "radius": {"distribution": "constant", "radius_um": 2.0},
            "density": {"number_per_m3": 1e9},
            "extinction_efficiency": None,
        }
        scattering = {"theory": "mie"}
        clear, dimmed = (
            render(
                make(SLAB, 1.0, on, droplets=dict(drops), scattering=scattering, **change), method
            )
            for on in (False, True)
        )
        passed[nm] = (dimmed @ [0.2126, 0.7152, 0.0722]) / (clear @ [0.2126, 0.7152, 0.0722])
        m = float(relative_index(np.array([nm]), 20.0)[0])
        sizes = 2.0 * np.pi * radius_m / (nm * 1e-9) * np.exp(0.02 * np.linspace(-3.5, 3.5, 141))
        weight = np.exp(-0.5 * np.linspace(-3.5, 3.5, 141) ** 2)
        q = weight @ [efficiency(float(x), m) for x in sizes] / weight.sum()
        depth = 1e9 * np.pi * radius_m**2 * q * THICKNESS_M
        to_eye = 1.0 / rays(make(SLAB, 1.0))[..., 1]
        u = depth * (to_eye + 1.0 / np.cos(np.radians(20.0)))
        expected = -np.expm1(-u) / u
        # The line is 20 nm wide, over which Q changes by a percent.
        assert np.abs(passed[nm] / expected - 1.0).max() < 0.012
    assert np.abs(passed[420.0] / passed[700.0] - 1.0).min() > 0.03


def box_expected(scene, beta, azimuth_deg):
    """Share that passes on the way to and fro in a box, by adaptive quadrature along each ray."""
    low, high = np.array(BOX, dtype=float)
    eye, sun = np.array(scene.camera.position_m), sun_direction(azimuth_deg)

    def leave(point, direction):
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.where(direction > 0.0, high - point, low - point) / direction
        return np.nanmin(np.where(np.abs(direction) < 1e-12, np.inf, ends))

    shares = np.full(rays(scene).shape[:2], np.nan)
    for place in np.ndindex(shares.shape):
        ray = rays(scene)[place]
        t = np.sort(np.stack([(low - eye) / ray, (high - eye) / ray]), axis=0)
        first, last = t[0].max(), t[1].min()
        if last - first < 1e-3:
            continue

        def passed(at, ray=ray, first=first):
            way = leave(eye + at * ray, sun)
            return np.exp(-beta * (at - first + way))

        total, _ = quad(passed, first, last, limit=200, epsrel=1e-7)
        shares[place] = total / (last - first)
    return shares


@pytest.mark.slow
@pytest.mark.parametrize(
    ("grid", "azimuth_deg"),
    [(None, 180.0), (None, 180.5), (None, 215.0), ([9, 14, 5], 180.0), ([2, 2, 2], 160.0)],
)
@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_even_box(method, grid, azimuth_deg):
    """The way to the sun ends at whichever face comes first: the box's edges show in it."""
    camera = {"size_px": [16, 12], "altitude_deg": 10.0, "fov_deg": 60.0}
    lights = [WHITE | {"azimuth_deg": azimuth_deg}]
    change = {"camera": camera, "light": lights, "droplets": {"grid": grid}}
    scene = make(BOX, 2.0, **change)
    dimmed, clear = (
        render(scene, method),
        render(make(BOX, 2.0, extinction=False, **change), method),
    )
    expected = box_expected(scene, 2.0 / THICKNESS_M, azimuth_deg)
    bright = np.isfinite(expected) & (clear[..., 1] > 1e-2 * clear.max())
    assert np.count_nonzero(bright) > 20
    passed = dimmed[bright].mean(axis=1) / clear[bright].mean(axis=1)
    np.testing.assert_allclose(passed, expected[bright], rtol=1e-3)


@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_a_far_lamp_is_dimmed_as_a_sun_is(method):
    far = {
        "type": "point", "position_m": list(1e6 * sun_direction()), "spectrum": "equal-energy",
        "luminous_flux_lm": 1e12, "diameter_m": 0.0,
    }  # fmt: skip
    point = WHITE | {"angular_diameter_deg": 0.0}
    camera = {"size_px": [16, 12], "altitude_deg": 10.0, "fov_deg": 60.0}
    shares = []
    for light in (far, point):
        change = {"camera": camera, "light": [light]}
        clear = render(make(BOX, 2.0, extinction=False, **change), method).sum(axis=2)
        shares.append(
            render(make(BOX, 2.0, **change), method).sum(axis=2)[clear > 1e-2 * clear.max()]
        )
        shares[-1] = shares[-1] / clear[clear > 1e-2 * clear.max()]
    assert shares[0].mean() == pytest.approx(shares[1].mean(), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("place", [(0.0, 20.0, 5.0), (0.0, -3.0, 4.0), (5.0, 8.0, 3.0)])
def test_lamps_in_and_beside_even_rain(place):
    lamp = {
        "type": "point", "position_m": list(place), "spectrum": "equal-energy",
        "luminous_flux_lm": 1000.0,
    }  # fmt: skip
    camera = {"position_m": [0.0, -5.0, 2.0], "altitude_deg": 10.0, "size_px": [32, 18]}
    box = [[-20.0, 0.0, 0.0], [20.0, 40.0, 20.0]]
    scene = make(box, 5.0, light=[lamp], camera=camera)
    frame, exact = render(scene, "spectral"), render(scene, "reference")
    # 8e-4 at worst.
    assert np.abs(frame - exact).max() < 1.2e-3 * exact.max()


@pytest.mark.slow
def test_shader_and_reference_agree_in_uneven_rain(tmp_path):
    rng = np.random.default_rng(5)
    shape = (7, 6, 5)
    np.savez(
        tmp_path / "rain.npz",
        radius_um=rng.uniform(250.0, 350.0, shape).astype(np.float32),
        number_per_m3=rng.uniform(0.0, 5e4, shape).astype(np.float32),
        box_m=np.array(BOX),
    )
    scene = make(BOX, 2.0)
    parts = scene.model_dump(exclude_none=True)
    parts["droplets"] = {
        "file": str(tmp_path / "rain.npz"), "extinction": True, "extinction_efficiency": 1.2
    }  # fmt: skip
    parts["camera"] |= {"size_px": [32, 24], "altitude_deg": 10.0, "fov_deg": 60.0}
    scene = Scene.model_validate(parts)
    frame, exact = render(scene, "spectral"), render(scene, "reference")
    assert exact.max() > 0.0
    # 7e-3 in the worst pixel: means towards the sun on 24 points a side.
    error = np.abs(frame - exact).max(axis=2) / exact.max()
    assert np.quantile(error, 0.99) < 3e-3
    assert error.max() < 1e-2


def test_mean_extinction_is_exact_in_even_rain():
    scene = make(BOX, 2.0, droplets={"grid": [3, 3, 3]})
    volume = build_volume(scene.droplets)
    optics = scene_optics(scene)
    field = rain_extinction(scene, optics, volume).field
    means = mean_extinction_towards(optics.suns[0], volume, field)
    np.testing.assert_allclose(means, 2.0 / THICKNESS_M, rtol=1e-6)


@pytest.mark.slow
def test_several_lights_have_depths_of_their_own():
    """Light of each sun alone adds up to that of both together."""
    other = WHITE | {"altitude_deg": 50.0, "azimuth_deg": 140.0}
    change = {"droplets": {"grid": [6, 6, 6]}, "camera": {"size_px": [16, 12]}}
    frames = [
        render(make(BOX, 2.0, light=lights, **{k: dict(v) for k, v in change.items()}), "spectral")
        for lights in ([WHITE], [other], [WHITE, other])
    ]
    assert frames[1].max() > 0.0
    np.testing.assert_allclose(
        frames[0] + frames[1], frames[2], rtol=1e-4, atol=1e-6 * frames[2].max()
    )


def test_long_marches_keep_their_depth_from_pass_to_pass(monkeypatch):
    import rtbow.render.spectral.method

    scene = make(BOX, 5.0, droplets={"grid": [6, 6, 6]}, camera={"size_px": [16, 12]})
    whole = render(scene, "spectral")
    monkeypatch.setattr(rtbow.render.spectral.method, "_LOOP_BUDGET", 200)
    np.testing.assert_allclose(render(scene, "spectral"), whole, rtol=1e-5, atol=1e-6 * whole.max())
