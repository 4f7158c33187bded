"""Whole frames on both backends: against the reference, and against what a rainbow must look like.

Angles are worked out here from pixel numbers, apart from the package's own camera.
"""

from functools import lru_cache
from itertools import product

import numpy as np
import pytest

import rtbow
from rtbow.physics.drop.water import relative_index
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene
from rtbow.world.rain.volume import DropletVolume, save_volume
from textbook import LUMINANCE, cross_section, mean_on_sphere, towards

pytestmark = pytest.mark.slow

EYE = (0.0, 0.0, 1.6)
BOX = ((-1500.0, 200.0, 0.0), (1500.0, 1200.0, 1100.0))
ROUND_THE_EYE = ((-1000.0, -1000.0, -1000.0), (1000.0, 1000.0, 1000.0))


@pytest.fixture(params=["osmesa", "egl"])
def backend(request):
    return request.param


def sun(**changes):
    return {"altitude_deg": 20.0, "azimuth_deg": 180.0} | changes


def drops(box=BOX, radius_um=500.0, number=1000.0):
    return {
        "box_m": [list(corner) for corner in box],
        "radius": {"distribution": "constant", "radius_um": radius_um},
        "density": {"number_per_m3": number},
    }


def make(camera=None, lights=None, droplets=None, **changes):
    parts = {
        "camera": {"position_m": list(EYE), "size_px": [64, 36]} | (camera or {}),
        "light": lights or [sun()],
        "droplets": droplets or drops(),
        "render": {"wavelength_step_nm": 10.0},
    }
    return Scene.model_validate(parts | changes)


def render(scene, backend):
    with rtbow.Renderer(scene, backend) as renderer:
        frame = renderer.render("spectral")
    assert frame.dtype == np.float32
    assert np.all(np.isfinite(frame))
    return frame.astype(np.float64)


@lru_cache(maxsize=64)
def _reference(text):
    with rtbow.Renderer(Scene.model_validate_json(text)) as renderer:
        return renderer.render("reference").astype(np.float64)


def reference(scene):
    """The reference's frame, computed once for both backends."""
    return _reference(scene.model_dump_json(exclude_none=True))


def deviation(frame, exact):
    """Greatest deviation of R, G, B per pixel, in units of the frame's bright level."""
    bright = np.percentile(exact @ LUMINANCE, 99.5)
    return np.abs(frame - exact).max(axis=2) / bright


def from_antisolar(scene, light=0):
    """Angle in degrees of each pixel from the point opposite to the sun, (h, w)."""
    camera = scene.camera
    width, height = camera.size_px
    forward = towards(camera.azimuth_deg, camera.altitude_deg)
    right = towards(camera.azimuth_deg + 90.0, 0.0)
    up = towards(camera.azimuth_deg, camera.altitude_deg + 90.0)
    half = np.tan(np.radians(camera.fov_deg) / 2.0)
    across = ((np.arange(width) + 0.5) - width / 2.0) * (half / (width / 2.0))
    above = (height / 2.0 - (np.arange(height) + 0.5)) * (half / (width / 2.0))
    ray = forward + across[None, :, None] * right + above[:, None, None] * up
    ray /= np.linalg.norm(ray, axis=2, keepdims=True)
    away = -towards(scene.light[light].azimuth_deg, scene.light[light].altitude_deg)
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(ray, away), axis=2), ray @ away))


def profile(frame, angle, edges):
    """Mean of R, G, B over rings about the antisolar point, (len(edges) - 1, 3)."""
    ring = np.digitize(angle, edges) - 1
    return np.array([frame[ring == k].mean(axis=0) for k in range(len(edges) - 1)])


# --- Against the reference --------------------------------------------------------------------


def test_uniform_is_the_references(backend, save_failure):
    scene = load_scene("uniform", {"camera.size_px": [96, 54]})
    frame, exact = render(scene, backend), reference(scene)
    save_failure("uniform", frame, exact)
    error = deviation(frame, exact)
    # 99 % of the pixels within 6.5e-4, the worst 8.2e-4: the table's 0.05-0.2 %.
    assert np.percentile(error, 99) < 1e-3
    assert error.max() < 1.5e-3


def test_uniform_is_the_1_nm_references(backend, save_failure):
    frame = render(load_scene("uniform", {"camera.size_px": [96, 54]}), backend)
    fine = {"camera.size_px": [96, 54], "render.wavelength_step_nm": 1.0}
    exact = reference(load_scene("uniform", fine))
    save_failure("1nm", frame, exact)
    assert np.percentile(deviation(frame, exact), 99) < 1.5e-3  # measured 8e-4


def test_curtain_is_the_references(backend, save_failure):
    scene = load_scene("curtain", {"camera.size_px": [48, 27], "render.wavelength_step_nm": 10.0})
    frame, exact = render(scene, backend), reference(scene)
    save_failure("curtain", frame, exact)
    error = deviation(frame, exact)
    assert np.percentile(error, 99) < 1e-3  # measured 8e-4
    assert error.max() < 2.5e-3  # measured 1.7e-3


@pytest.fixture(scope="module")
def volume_file(tmp_path_factory):
    """A grid of smooth density and radius, with an empty corner."""
    x, y, z = np.meshgrid(*[np.linspace(0.0, 1.0, n) for n in (6, 5, 4)], indexing="ij")
    number = 900.0 * np.maximum(0.2 + x * y - 0.5 * z, 0.0)
    # Nearly one radius: where it varies more, fringes move within a cell, without a disc.
    radius = 400.0 + 4.0 * x + 2.0 * z
    path = tmp_path_factory.mktemp("volume") / "smooth.npz"
    save_volume(DropletVolume(np.array(BOX), np.float32(radius), np.float32(number)), path)
    return path


def shapes():
    """A quarter of all combinations with the backend: any three of the six meet in every way."""
    for grid, air, disc, both in product((True, False), repeat=4):
        backend = "egl" if grid ^ air ^ disc else "osmesa"
        yield backend, grid, air, disc, (1, 2) if both else (2,), 3 if air ^ disc ^ both else 1


@pytest.mark.parametrize(("backend", "grid", "air", "disc", "orders", "suns"), list(shapes()))
def test_every_shape_of_the_shader(
    backend, save_failure, volume_file, grid, air, disc, orders, suns
):
    lights = [
        sun(angular_diameter_deg=0.533 if disc else 0.0),
        # One disc switches the code on for all; a wide one and a point then share it.
        sun(altitude_deg=5.0, azimuth_deg=200.0, angular_diameter_deg=0.0, spectrum="FL2"),
        sun(altitude_deg=40.0, azimuth_deg=150.0, angular_diameter_deg=3.0 if disc else 0.0),
    ]
    scene = make(
        {"size_px": [16, 9]},
        lights[:suns],
        {"file": str(volume_file)} if grid else drops(radius_um=420.0),
        atmosphere={"rayleigh": air},
        scattering={"orders": list(orders)},
        render={"wavelength_step_nm": 40.0},
    )
    frame, exact = render(scene, backend), reference(scene)
    save_failure("shape", frame, exact)
    assert exact.max() > 0.0
    # Worst 2.6e-3, on the grid: the samples in a cell are few.
    assert deviation(frame, exact).max() < 3.5e-3


@pytest.mark.parametrize("fov_deg", [6.0, 100.0])
def test_surroundings_of_the_antisolar_point(backend, save_failure, fov_deg):
    # There a disc covers rings; small drops keep them visible.
    camera = {"altitude_deg": -20.0, "fov_deg": fov_deg, "size_px": [33, 33]}
    scene = make(camera, [sun(angular_diameter_deg=1.0)], drops(ROUND_THE_EYE, radius_um=40.0))
    frame, exact = render(scene, backend), reference(scene)
    save_failure("antisolar", frame, exact)
    # Worst 4.3e-3 of the brightest in the small field, which leaves out the bow itself.
    assert deviation(frame, exact).max() < (6e-3 if fov_deg < 10.0 else 1.5e-3)


def test_sun_below_the_horizon_lights_the_tops(backend, save_failure):
    box = ((-3000.0, 500.0, 0.0), (3000.0, 3000.0, 6000.0))
    camera = {"altitude_deg": 40.0, "fov_deg": 60.0, "size_px": [24, 40]}
    scene = make(camera, [sun(altitude_deg=-1.5)], drops(box), atmosphere={"rayleigh": True})
    frame, exact = render(scene, backend), reference(scene)
    save_failure("dusk", frame, exact)
    lit = exact @ LUMINANCE > 0.0
    # The Earth's shadow reaches up to R (1/cos 1.5° - 1) = 2184 m.
    top = np.tan(np.radians(40.0 + 38.0)) * 500.0
    assert top > 2184.0
    assert lit[0].all()
    assert not lit[-1].any()
    assert frame[..., 0].sum() == pytest.approx(exact[..., 0].sum(), rel=1e-3)  # 4e-4


# --- The bows ---------------------------------------------------------------------------------

BOW_CAMERA = {"altitude_deg": 20.0, "fov_deg": 110.0, "size_px": [192, 108]}


@lru_cache
def airy_angle_deg(nm, reflections, radius_um):
    """Angle from the antisolar point of a bow's peak under the sun's disc."""
    index = float(relative_index(np.array([nm]), 20.0)[0])
    near = np.arange(136.5, 140.0, 0.01) if reflections == 1 else np.arange(126.0, 130.0, 0.01)
    light = [
        mean_on_sphere(
            lambda t: cross_section(index, nm * 1e-9, radius_um * 1e-6, t, reflections),
            np.radians(t),
            np.radians(0.533 / 2.0),
            rings=12,
            spokes=24,
        )
        for t in near
    ]
    return 180.0 - near[int(np.argmax(light))]


@pytest.mark.parametrize("nm", [450, 550, 650])
def test_bows_stand_at_their_angles(backend, tmp_path, nm):
    spectrum = tmp_path / "line.csv"
    spectrum.write_text(f"380,0\n{nm - 2},0\n{nm},1\n{nm + 2},0\n780,0\n")
    scene = make(
        BOW_CAMERA,
        [sun(altitude_deg=5.0, spectrum=str(spectrum))],
        drops(ROUND_THE_EYE),
        render={"wavelength_step_nm": 5.0},
    )
    frame = render(scene, backend)
    width = 0.1
    for reflections, low, high in ((1, 39.0, 43.5), (2, 49.0, 55.0)):
        edges = np.arange(low, high, width)
        rings = profile(frame, from_antisolar(scene), edges) @ LUMINANCE
        at = edges[int(np.argmax(rings))] + 0.5 * width
        # Worst 0.06: half a ring, and the way through the box changes across it.
        assert at == pytest.approx(airy_angle_deg(nm, reflections, 500.0), abs=0.1)


def bright_rings(backend, **light):
    scene = make(BOW_CAMERA, [sun(altitude_deg=5.0, **light)], drops(ROUND_THE_EYE))
    frame = render(scene, backend)
    edges = np.arange(20.0, 60.1, 0.5)
    return edges[:-1] + 0.25, profile(frame, from_antisolar(scene), edges)


def test_colours_are_in_order(backend):
    angle, rings = bright_rings(backend)
    for low, high, outwards in ((38.0, 44.0, 1.0), (48.0, 56.0, -1.0)):
        part = (angle > low) & (angle < high)
        red, green, blue = (angle[part][np.argmax(rings[part, k])] for k in range(3))
        # Red is outside in the primary, inside in the secondary.
        assert outwards * (red - blue) >= 1.0
        assert outwards * (red - green) >= 0.0
        assert outwards * (green - blue) >= 0.0


def test_dark_band_between_the_bows(backend):
    angle, rings = bright_rings(backend)
    light = rings @ LUMINANCE
    band = light[(angle > 44.0) & (angle < 49.0)].max()
    inside = light[(angle > 25.0) & (angle < 38.0)].min()
    outside = light[(angle > 56.0) & (angle < 60.0)].min()
    assert band < 0.001 * outside
    assert outside < inside
    assert light[(angle > 38.0) & (angle < 43.0)].max() > 3.0 * inside


def test_sun_in_front_makes_no_bow(backend):
    behind = make(BOW_CAMERA, [sun(altitude_deg=5.0)], drops(ROUND_THE_EYE))
    before = make(BOW_CAMERA, [sun(altitude_deg=5.0, azimuth_deg=0.0)], drops(ROUND_THE_EYE))
    angle = from_antisolar(behind)
    edges = np.arange(25.0, 60.0, 1.0)
    bow, none = (profile(render(s, backend), angle, edges) @ LUMINANCE for s in (behind, before))
    assert bow.max() > 20.0 * np.median(none)
    assert none.max() < 1.5 * none.min()


def test_smaller_drops_make_a_wider_and_paler_bow(backend):
    widths = []
    for radius_um in (40.0, 500.0):
        scene = make(
            BOW_CAMERA, [sun(altitude_deg=5.0)], drops(ROUND_THE_EYE, radius_um=radius_um),
            scattering={"orders": [1]},
        )  # fmt: skip
        edges = np.arange(30.0, 46.1, 0.25)
        light = profile(render(scene, backend), from_antisolar(scene), edges) @ LUMINANCE
        widths.append(np.count_nonzero(light > 0.5 * light.max()) * 0.25)
    assert widths[0] > 1.7 * widths[1]


def test_low_sun_is_dimmer_and_redder(backend):
    passed, redness = [], []
    for altitude in (30.0, 20.0, 10.0, 3.0):
        camera = {"altitude_deg": 41.0 - altitude, "fov_deg": 12.0, "size_px": [12, 8]}
        lit = [
            render(
                make(camera, [sun(altitude_deg=altitude)], atmosphere={"rayleigh": air}), backend
            ).sum(axis=(0, 1))
            for air in (True, False)
        ]
        passed.append((lit[0] @ LUMINANCE) / (lit[1] @ LUMINANCE))
        redness.append((lit[0][0] / lit[0][2]) / (lit[1][0] / lit[1][2]))
    assert np.all(np.diff(passed) < 0.0)
    assert np.all(np.diff(redness) > 0.0)
    # A depth of 0.1 at 550 nm and two air masses, and a kilometre or so to the eye.
    assert 0.7 < passed[0] < 0.85
    assert passed[3] < 0.35
    assert redness[3] > 5.0


# --- Symmetries, sums and steps ---------------------------------------------------------------


def test_two_suns_add(backend):
    lights = [sun(), sun(altitude_deg=35.0, azimuth_deg=160.0, spectrum="FL2")]

    def frame(*suns):
        return render(
            make({"size_px": [24, 14]}, list(suns), atmosphere={"rayleigh": True}), backend
        )

    both, alone = frame(*lights), [frame(one) for one in lights]
    np.testing.assert_allclose(both, alone[0] + alone[1], rtol=0.0, atol=5e-6 * both.max())


@pytest.mark.parametrize("air", [True, False])
def test_mirrored_scene_is_a_mirrored_frame(backend, tmp_path, rng, air):
    shape = (5, 4, 3)
    number, radius = rng.uniform(100.0, 1000.0, shape), rng.uniform(400.0, 450.0, shape)
    box = np.array([[-1500.0, 200.0, 0.0], [900.0, 1200.0, 1100.0]])
    frames = []
    for side in (1, -1):
        volume = DropletVolume(
            box if side > 0 else np.array([[-900.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]),
            np.float32(radius[::side]),
            np.float32(number[::side]),
        )
        path = tmp_path / f"{side}.npz"
        save_volume(volume, path)
        scene = make(
            {"azimuth_deg": side * 10.0, "position_m": [side * 50.0, 0.0, 1.6]},
            [sun(azimuth_deg=180.0 + side * 25.0)],
            {"file": str(path)},
            atmosphere={"rayleigh": air},
        )
        frames.append(render(scene, backend))
    # Rounding alone: 3e-6 of the brightest.
    np.testing.assert_allclose(frames[1][:, ::-1], frames[0], rtol=0.0, atol=1e-5 * frames[0].max())
    assert np.abs(frames[0][:, ::-1] - frames[0]).max() > 0.1 * frames[0].max()


@pytest.mark.parametrize("turn_deg", [90.0, 217.0])
def test_turned_scene_is_the_same_frame(backend, turn_deg):
    # Round the eye, so that the box turns into itself; quarter turns only.
    if turn_deg != 90.0:
        box = ((-1e5, -1e5, 0.0), (1e5, 1e5, 0.5))
        camera = {"altitude_deg": -30.0, "position_m": [0.0, 0.0, 30.0], "fov_deg": 40.0}
    else:
        box, camera = ROUND_THE_EYE, {}
    frames = [
        render(
            make(
                camera | {"azimuth_deg": turn},
                [sun(altitude_deg=10.0, azimuth_deg=180.0 + turn)],
                drops(box),
            ),
            backend,
        )
        for turn in (0.0, turn_deg)
    ]
    assert frames[0].max() > 0.0
    # Worst 4e-5: angles round by 4e-7 rad, and the bow's flank is steep.
    np.testing.assert_allclose(frames[1], frames[0], rtol=0.0, atol=1e-4 * frames[0].max())


def half_filled(tmp_path, axis):
    """A volume with drops in the second half along one axis only."""
    box = ((-500.0, 100.0, -400.0), (500.0, 300.0, 400.0))
    number = np.zeros((5, 5, 5), np.float32)
    number[(slice(None),) * axis + (slice(3, None),)] = 1000.0
    path = tmp_path / f"half{axis}.npz"
    save_volume(DropletVolume(np.array(box), np.full((5, 5, 5), 500.0, np.float32), number), path)
    return {"file": str(path)}


# Around the antisolar point, where every pixel is lit.
INSIDE = {"position_m": [0.0, 0.0, 0.0], "altitude_deg": 0.0, "fov_deg": 40.0}


def test_east_is_right_when_looking_north(backend, tmp_path):
    scene = make(INSIDE, [sun(altitude_deg=1.0)], half_filled(tmp_path, 0))
    columns = (render(scene, backend) @ LUMINANCE).mean(axis=0)
    assert np.all(columns[:32] == 0.0)
    assert np.all(columns[36:] > 0.0)


def test_east_is_left_when_looking_south(backend, tmp_path):
    camera = INSIDE | {"position_m": [0.0, 400.0, 0.0], "azimuth_deg": 180.0}
    scene = make(camera, [sun(altitude_deg=1.0, azimuth_deg=0.0)], half_filled(tmp_path, 0))
    columns = (render(scene, backend) @ LUMINANCE).mean(axis=0)
    assert np.all(columns[32:] == 0.0)
    assert np.all(columns[:28] > 0.0)


def test_up_is_the_first_row(backend, tmp_path):
    scene = make(INSIDE, [sun(altitude_deg=1.0)], half_filled(tmp_path, 2))
    rows = (render(scene, backend) @ LUMINANCE).mean(axis=1)
    assert np.all(rows[18:] == 0.0)
    assert np.all(rows[:15] > 0.0)


def test_north_is_behind(backend, tmp_path):
    # From the west, with the drops in the northern half: on the left when looking east.
    camera = {"position_m": [-900.0, 200.0, 0.0], "azimuth_deg": 90.0, "altitude_deg": 0.0}
    scene = make(
        camera | {"fov_deg": 20.0},
        [sun(altitude_deg=1.0, azimuth_deg=270.0)],
        half_filled(tmp_path, 1),
    )
    columns = (render(scene, backend) @ LUMINANCE).mean(axis=0)
    assert columns[:28].min() > 0.0
    assert np.all(columns[32:] == 0.0)


def test_far_from_the_origin(backend):
    shift = np.array([1e6, -1e6, 0.0])
    near = render(make(), backend)
    box = (np.array(BOX) + shift).tolist()
    far = make({"position_m": list(np.array(EYE) + shift)}, droplets=drops(box))
    np.testing.assert_allclose(render(far, backend), near, rtol=0.0, atol=1e-6 * near.max())


def test_steps_converge(backend):
    # The midpoint rule in air: a quarter of the error for half the step.
    box = ((-20_000.0, 200.0, 0.0), (20_000.0, 30_000.0, 3000.0))
    frames = [
        render(
            make(
                {"size_px": [16, 9]},
                [sun(altitude_deg=5.0)],
                drops(box, number=20.0),
                atmosphere={"rayleigh": True},
                render={"wavelength_step_nm": 20.0, "steps": steps},
            ),
            backend,
        )
        for steps in (4, 8, 256)
    ]
    coarse, half = (np.abs(frame - frames[2]).max() for frame in frames[:2])
    assert 3.0 < coarse / half < 5.0


def test_steps_of_its_own_are_enough(backend, volume_file):
    changes = {"droplets": {"file": str(volume_file)}, "atmosphere": {"rayleigh": True}}
    own = render(make({"size_px": [32, 18]}, **changes), backend)
    fine = {"render": {"wavelength_step_nm": 10.0, "steps": 400}}
    many = render(make({"size_px": [32, 18]}, **changes, **fine), backend)
    assert deviation(own, many).max() < 2.5e-3  # measured 1.6e-3


def test_twice_the_drops_twice_the_light(backend):
    one, two = (render(make(droplets=drops(number=n)), backend) for n in (500.0, 1000.0))
    np.testing.assert_allclose(two, 2.0 * one, rtol=1e-6, atol=1e-6 * two.max())


def test_no_drops_no_light(backend):
    assert np.all(render(make(droplets=drops(number=0.0)), backend) == 0.0)


def test_box_out_of_view_is_dark(backend):
    assert np.all(render(make({"azimuth_deg": 180.0}), backend) == 0.0)


def test_two_renderers_side_by_side(backend):
    scenes = [make(), make(droplets=drops(radius_um=100.0), atmosphere={"rayleigh": True})]
    alone = [render(scene, backend) for scene in scenes]
    with rtbow.Renderer(scenes[0], backend) as a, rtbow.Renderer(scenes[1], backend) as b:
        for _ in range(2):
            np.testing.assert_array_equal(a.render("spectral"), alone[0])
            np.testing.assert_array_equal(b.render("spectral"), alone[1])
    assert np.any(alone[0] != alone[1])


def test_one_closed_beside_another(backend):
    scene = make()
    with rtbow.Renderer(scene, backend) as kept:
        first = kept.render()
        with rtbow.Renderer(scene, backend) as other:
            other.render()
        np.testing.assert_array_equal(kept.render(), first)


def test_both_backends_agree():
    frames = [render(make(atmosphere={"rayleigh": True}), b) for b in ("osmesa", "egl")]
    np.testing.assert_allclose(frames[1], frames[0], rtol=0.0, atol=1e-4 * frames[0].max())


@pytest.mark.parametrize("size_px", [(1, 1), (1, 7), (61, 3)])
def test_odd_sizes(backend, size_px):
    scene = make({"size_px": list(size_px)})
    frame = render(scene, backend)
    assert frame.shape == (size_px[1], size_px[0], 3)
    assert deviation(frame, reference(scene)).max() < 3e-3


def test_strips_do_not_show(backend, monkeypatch):
    whole = render(make(), backend)
    monkeypatch.setattr("rtbow.render.spectral.method._TILE_SECONDS", 0.0)
    np.testing.assert_array_equal(render(make(), backend), whole)


def test_progress_sees_every_row_once(backend):
    seen = []

    def progress(rows):
        for row in rows:
            seen.append(row)
            yield row

    with rtbow.Renderer(make(), backend) as renderer:
        renderer.render("spectral", progress)
    assert seen == list(range(36))


def test_brightness_is_that_of_the_sun_times_its_share(backend):
    # The frame's absolute level, from end to end by the textbook: one pixel on the primary.
    scene = make(
        {"size_px": [1, 1], "fov_deg": 0.1, "altitude_deg": 21.0},
        [sun(spectrum="equal-energy", irradiance_w_m2=400.0)],
        drops(ROUND_THE_EYE, radius_um=300.0),
    )
    ray = towards(0.0, 21.0)
    length = (1000.0 - 0.0) / ray[1]
    theta = np.arccos(-(ray @ towards(180.0, 20.0)) * -1.0)
    from rtbow.physics.light.colour import colour_matching

    nm, cmf = colour_matching()
    luminance = 0.0
    for at in np.arange(380.0, 781.0, 10.0):
        index = float(relative_index(np.array([at]), 20.0)[0])
        section = sum(
            mean_on_sphere(
                lambda t, k=k, at=at, index=index: cross_section(index, at * 1e-9, 300e-6, t, k),
                theta,
                np.radians(0.533 / 2.0),
                rings=30,
                spokes=60,
            )
            for k in (1, 2)
        )
        width = 5.0 if at in (380.0, 780.0) else 10.0
        luminance += 1000.0 * length * section * np.interp(at, nm, cmf[:, 1]) * width
    got = float(render(scene, backend)[0, 0] @ LUMINANCE)
    assert got == pytest.approx(luminance, rel=0.002)  # 1.2e-3: colour sampled every 10 nm here
