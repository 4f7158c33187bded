"""Light that rain scatters more than once, by random walks: against published values, a furnace in
which nothing is lost, and the quadrature of one scattering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.frames.difference import frame_difference
from rtbow.physics.geometry import direction
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference.orders import Orders, counted_in
from rtbow.reference.paths import Counted
from rtbow.reference.render import radiance_along
from rtbow.world.world import resolve

pytestmark = pytest.mark.slow

AGAIN = Counted(several=True, skylight=False, most=10**6, single=False)
ONCE = Counted(several=True, skylight=False, most=1, single=True)
BOX = {
    "droplets.box_m": [[-2000.0, 1000.0, 0.0], [2000.0, 2000.0, 1500.0]],
    "droplets.radius.radius_um": 300.0, "camera.position_m": [0.0, 0.0, 2.0],
    "light.0.altitude_deg": 20.0, "droplets.scattering_orders": "all",
}  # fmt: skip
"""The box of the published values, but for its drops' number."""


def at_540(orders):
    """The same at 540 nm alone, per irradiance."""
    nm = orders.world.optics.wavelength_nm
    here = nm == 540.0
    chances = np.concatenate([[0.0], np.cumsum(here)]).astype(np.float64)
    weights = np.repeat(here.astype(np.float64)[None, :, None], 3, axis=2)
    return replace(
        orders, lights=orders.lights._replace(sun_weights=weights), chances=chances
    )  # fmt: skip


# Monte Carlo with next-event estimation by another program, radiance per unit irradiance at 550 nm;
# its own error is up to 1.3 %: depth over 1 km with Q = 2, angle from the antisolar point, one
# order, all orders.
PUBLISHED = [
    (0.3, 45.0, 0.00028, 0.00059), (1.0, 30.0, 0.00641, 0.00957), (1.0, 45.0, 0.00066, 0.0034),
    (3.0, 45.0, 0.00095, 0.0165), (1.0, 41.4, 0.0527, 0.0559), (3.0, 41.4, 0.0763, 0.0931),
]  # fmt: skip


@pytest.mark.parametrize(("depth", "angle_deg", "once", "all_orders"), PUBLISHED)
def test_published_light_of_all_orders_but_the_first(depth, angle_deg, once, all_orders):
    number = depth / (1000.0 * 2.0 * np.pi * 300e-6**2)
    world = resolve(rtbow.load_scene("uniform", {**BOX, "droplets.density.number_per_m3": number}))
    orders = at_540(Orders.of(world))
    found = orders.along(direction(0.0, angle_deg - 20.0)[None], AGAIN, paths=100_000)
    rounding = 0.5 * 10.0 ** -(len(f"{all_orders}") - 2)
    doubt = 0.013 * all_orders + rounding + 3.0 * found.error[0, 1]
    assert found.mean[0, 1] == pytest.approx(all_orders - once, abs=doubt)
    assert found.error[0, 1] < 0.02 * found.mean[0, 1]


# Radii are nearly alike: between grid points the extinction follows neither their squares nor them.
GRID = {
    "droplets.grid": [7, 5, 6], "droplets.radius": {
        "distribution": "normal", "mean_um": 200.0, "std_um": 6.0,
    }, "droplets.density.number_per_m3": 3000.0,
}  # fmt: skip


def without_radius(scene, volume):
    """A scene with the drops of a volume."""
    own = {key: value for key, value in scene.items() if "radius_um" not in key or not volume}
    return {**own, **volume}


@pytest.mark.parametrize("depth", [0.3, 3.0, 50.0])
@pytest.mark.parametrize("volume", [{}, GRID], ids=["even", "grid"])
def test_in_a_furnace_rain_is_not_seen(volume, depth):
    """All around is of radiance 1, and drops lose nothing: each ray brings 1."""
    scene = {**without_radius(BOX, volume), "render.wavelength_step_nm": 40.0}
    orders = Orders.of(resolve(rtbow.load_scene("uniform", scene)), step_nm=40.0)
    waves = len(orders.world.optics.wavelength_nm)
    lights = orders.lights._replace(
        sun_left=np.zeros_like(orders.lights.sun_left), sky=np.ones((1, 2, 2, waves)),
        sun_weights=np.ones((1, waves, 3)),
    )  # fmt: skip
    rays = np.array([direction(turn, up) for turn, up in ((0.0, 20.0), (30.0, 5.0), (-50.0, 35.0))])
    passed = orders.passed(rays)
    # As deep as that along the first ray.
    much = depth / -np.log(passed[0])
    rain = orders.rain._replace(
        extinction=orders.rain.extinction * much, greatest=orders.rain.greatest * much
    )
    field = orders.world.rain
    world = replace(orders.world, rain=replace(field, field=field.field * much))
    dense = replace(orders, rain=rain, lights=lights, world=world)
    light = Counted(several=True, skylight=True, most=10**6, single=False)
    found = dense.along(rays, light, paths=40_000)
    # At each wavelength as much as at 550 nm is taken, within what these differ by.
    taken = 1.0 - passed**much
    nearly = 3.0 * found.error[:, 1] / waves + 0.01
    assert np.all(np.abs(found.mean[:, 1] / waves / taken - 1.0) < nearly)


@pytest.mark.parametrize(
    "scene",
    [
        {}, {"atmosphere.rayleigh": True, "light.0.altitude_deg": 6.0}, GRID,
        {"light.0": {"type": "point", "position_m": [100.0, 1500.0, 700.0], "spectrum": "LED-B3",
                     "luminous_flux_lm": 1e6, "diameter_m": 0.5}},
    ],
    ids=["sun", "air", "grid", "lamp"],
)  # fmt: skip
def test_one_scattering_by_walks_is_the_quadratures(scene):
    if "light.0" in scene:
        scene = {**scene, "light": [scene["light.0"]]}
        del scene["light.0"]
        base = {key: value for key, value in BOX.items() if not key.startswith("light")}
    else:
        base = without_radius(BOX, scene)
    common = {"scattering.theory": "mie", "render.wavelength_step_nm": 20.0}
    world = resolve(rtbow.load_scene("uniform", {**base, **common, **scene}))
    # Not at a bow's edge, where cells of the phase function are as wide as it.
    rays = np.array([direction(turn, up) for turn, up in ((0.0, 12.0), (25.0, 5.0), (-20.0, 9.0))])
    exact = radiance_along(replace_orders(world), rays)[:, 1]
    found = Orders.of(world).along(rays, ONCE, paths=100_000)
    doubt = 3.0 * found.error[:, 1] / exact + 0.02
    assert np.all(np.abs(found.mean[:, 1] / exact - 1.0) < doubt)


def replace_orders(world):
    """The same world with one order alone."""
    droplets = world._scene.droplets.model_copy(
        update={"scattering_orders": "single", "extinction": True}
    )
    return resolve(world._scene.model_copy(update={"droplets": droplets}))


def test_the_same_seed_gives_the_same_light():
    orders = Orders.of(resolve(rtbow.load_scene("uniform", BOX)), step_nm=40.0)
    rays = direction(0.0, 20.0)[None]
    first, again, other = (orders.along(rays, AGAIN, paths=320, seed=k) for k in (1, 1, 2))
    np.testing.assert_array_equal(first.mean, again.mean)
    assert not np.array_equal(first.mean, other.mean)


def test_frames_are_the_references():
    """The map errs by 2.5 % of the glow, the reference by 1 %; in the dark band there is no other
    light."""
    changes = {
        **BOX, "camera.size_px": [4, 3], "render.wavelength_step_nm": 20.0,
        "render.samples": 100_000, "droplets.density.number_per_m3": 800.0,
    }  # fmt: skip
    frames = {}
    for method in ("fast", "spectral", "reference"):
        with rtbow.Renderer(rtbow.load_scene("uniform", changes)) as renderer:
            frames[method] = rgb_to_xyz(renderer.render(method))
    for method in ("fast", "spectral"):
        delta_e = frame_difference(frames[method], frames["reference"]).delta_e
        assert delta_e.median < 0.6
        assert delta_e.p99 < 1.6
    single = {**changes, "droplets.scattering_orders": "single", "droplets.extinction": True}
    with rtbow.Renderer(rtbow.load_scene("uniform", single)) as renderer:
        alone = rgb_to_xyz(renderer.render("fast"))
    assert frames["fast"][..., 1].sum() > 1.05 * alone[..., 1].sum()


def test_grids_are_left_to_the_reference():
    small = {"camera.size_px": [4, 3], "render.samples": 64}
    scene = rtbow.load_scene("uniform", {**without_radius(BOX, GRID), **small})
    with rtbow.Renderer(scene) as renderer:
        renderer.render()
        assert renderer.method_used == "reference"
        assert "even rain" in renderer.unsuited


def test_drops_under_a_sky_are_brighter():
    """An overcast of its own: the sky's mean radiance is not exceeded, and half of it is there."""
    sky = {
        **BOX, "droplets.scattering_orders": "single", "droplets.extinction": True,
        "droplets.skylight": True, "atmosphere.rayleigh": True, "atmosphere.sky": True,
        "ground.albedo": 0.2, "render.wavelength_step_nm": 40.0,
    }  # fmt: skip
    world = resolve(rtbow.load_scene("uniform", sky))
    orders = Orders.of(world, step_nm=40.0)
    rays = np.array([direction(0.0, 30.0)])
    counted = counted_in(world)
    assert counted is not None
    assert not counted.several
    found = orders.along(rays, counted, paths=20_000)
    taken = 1.0 - orders.passed(rays)[0]
    seen = orders.lights.sky[0] @ orders.lights.sun_weights[0, :, 1]
    assert 0.5 * seen.min() < found.mean[0, 1] / taken < seen.max()
    assert found.error[0, 1] < 0.02 * found.mean[0, 1]


@pytest.mark.parametrize(("changes", "words"), [
    ({"droplets.scattering_orders": "some"}, 'must be one of "single", "all"'),
    ({"render.samples": 1}, "render.samples = 1; must be 16"),
])  # fmt: skip
def test_what_is_refused(changes, words):
    with pytest.raises(InputError) as refused:
        rtbow.load_scene("uniform", changes)
    assert words in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(("changes", "words"), [
    ({}, "no sky or ground lights the drops"),
    ({"ground.albedo": 0.2}, "add droplets.extinction = true"),
])  # fmt: skip
def test_that_nothing_lights_the_drops_is_said(changes, words):
    world = resolve(rtbow.load_scene("uniform", {"droplets.skylight": True, **changes}))
    assert counted_in(world) is None
    assert any(words in note for note in world.notes)


@pytest.mark.parametrize("changes", [
    {"droplets.density.number_per_m3": 0.0},
    {"droplets.box_m": [[-10.0, 20_000.0, 0.0], [10.0, 20_010.0, 20.0]],
     "camera.fov_deg": 0.5, "camera.altitude_deg": 0.0},
], ids=["no-drops", "far"])  # fmt: skip
def test_rain_that_is_hardly_there(changes):
    scene = {**BOX, "camera.size_px": [16, 9], **changes}
    with rtbow.Renderer(rtbow.load_scene("uniform", scene)) as renderer:
        assert np.isfinite(renderer.render("fast")).all()
