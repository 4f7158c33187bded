"""Frames about sunset, where the edge of the Earth's shadow crosses the rain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

import rtbow
from dusk import Case, lit_lengths
from rtbow.frames.difference import frame_difference
from rtbow.physics.air.earth_shadow import shadow_span
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.reference.render import spectral_radiance_along
from rtbow.render.spectral.layout import pieces
from rtbow.scene.model import Scene
from rtbow.world.world import resolve
from textbook import column_along_ray, rayleigh_depth

SIZE = (32, 18)
NEAR_EDGE_M = 1.0


def scene(
    altitudes: Sequence[float], box: Any = ((-3000.0, 500.0, 0.0), (3000.0, 3000.0, 1200.0)),
    camera: Any = (), drops: Any = (), air: bool = True, step_nm: float = 5.0,
) -> Scene:  # fmt: skip
    view = {"position_m": [0.0, 0.0, 1.6], "altitude_deg": 25.0, "fov_deg": 90.0, "size_px": SIZE}
    return Scene.model_validate(
        {
            "camera": view | dict(camera),
            "light": [{"altitude_deg": a, "azimuth_deg": 180.0 + 15.0 * k}
                      for k, a in enumerate(altitudes)],
            "droplets": {"box_m": [list(corner) for corner in box],
                         "radius": {"distribution": "constant", "radius_um": 400.0},
                         "density": {"number_per_m3": 300.0}} | dict(drops),
            "atmosphere": {"rayleigh": air},
            "render": {"wavelength_step_nm": step_nm},
        }
    )  # fmt: skip


# --- Who is lit --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("altitude_deg", "low_m", "shaded"),
    [
        (20.0, 0.0, False),
        # Nothing on a plane that touches the sphere hides a sun above it.
        (0.01, 0.0, False),
        (-0.01, 0.0, True),
        (0.01, -5.0, True),
        (-0.5, 0.0, True),
        (-1.0, 900.0, True),  # the edge is 970 m up
        (-1.0, 1050.0, False),  # and 1023 m at the far end of the box
    ],
)
def test_shadow_reaches_the_rain(altitude_deg, low_m, shaded):
    box = ((-3000.0, 500.0, low_m), (3000.0, 3000.0, 1200.0))
    world = resolve(scene([altitude_deg], box))
    assert world.shades(world.optics.suns[0]) == shaded
    assert pieces(world) == (3 if shaded else 1)
    clear = resolve(scene([altitude_deg], box, air=False))
    assert not clear.shades(clear.optics.suns[0])  # nothing dims such a sun at all


def test_far_from_the_origin_the_shadow_is_that_of_the_eye():
    # A scene in a country's grid coordinates.
    near = scene([-1.0], step_nm=40.0)
    there = np.array([4.5e5, 5.6e6, 0.0])
    box = (np.array(near.droplets.box_m) + there).tolist()
    eye = (np.array([0.0, 0.0, 1.6]) + there).tolist()
    far = scene([-1.0], box, {"position_m": eye}, step_nm=40.0)
    frames = [rtbow.Renderer(s).render("reference") for s in (near, far)]
    assert frames[0].max() > 0.0
    np.testing.assert_allclose(frames[1], frames[0], rtol=1e-3, atol=1e-4)


def test_reference_is_the_integral_over_the_lit_length():
    # Even drops, rays at one scattering angle: radiance is in proportion to the integral of what
    # the air leaves, here by the trapezoidal rule over places each of which is looked at by itself.
    world = resolve(scene([-1.0], step_nm=40.0))
    sun, eye, box = world.optics.suns[0].direction, world.view.eye_m, world.volume.box_m
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(up, sun) / np.linalg.norm(np.cross(up, sun))
    top = np.cross(sun, side)
    turn, cone = np.radians([0.0, 15.0, -25.0, 35.0]), np.radians(41.0)
    rays = -np.cos(cone) * sun + np.sin(cone) * (
        np.cos(turn)[:, None] * top + np.sin(turn)[:, None] * side
    )
    got = spectral_radiance_along(world, rays)
    nm = world.optics.wavelength_nm
    wave = int(np.argmin(np.abs(nm - 620.0)))
    exact = np.zeros(len(rays))
    for k, ray in enumerate(rays):
        begin, end = box[0, 1] / ray[1], min(box[1, 1] / ray[1], (box[1, 2] - eye[2]) / ray[2])
        t = np.linspace(begin, end, 2001)
        q = eye + t[:, None] * ray + [0.0, 0.0, 6_371_000.0]
        along, radius = q @ sun, np.linalg.norm(q, axis=1)
        lit = np.linalg.norm(q - along[:, None] * sun, axis=1) > 6_371_000.0
        left = np.zeros(len(t))
        for i in np.flatnonzero(lit)[::25]:
            towards = column_along_ray(radius[i] - 6_371_000.0, np.arcsin(along[i] / radius[i]))
            back = column_along_ray(eye[2], np.arcsin(ray[2]), t[i])
            left[i] = np.exp(-rayleigh_depth(nm[wave]) * (towards + back))
        known = np.flatnonzero(left > 0.0)
        # Up to the very edges of the lit part, half a place beyond the last ones seen.
        inside = np.flatnonzero(lit)
        left[inside] = np.exp(np.interp(t[inside], t[known], np.log(left[known])))
        half = 0.5 * (t[1] - t[0]) * (left[inside[0]] + left[inside[-1]])
        exact[k] = trapezoid(left[inside], t[inside]) + half
        assert 100.0 < t[inside[-1]] - t[inside[0]] < end - begin
    ratio = got[:, wave] / exact
    # Worst 2e-3: of the flat shells between drops and eye, and of the edges' last metres.
    np.testing.assert_allclose(ratio / ratio[0], 1.0, atol=5e-3)


# --- Every method ------------------------------------------------------------------------------

NEAR_HORIZON = {"position_m": [0.0, 0.0, 972.0], "azimuth_deg": 90.0, "altitude_deg": -0.05,
                "fov_deg": 1.0}  # fmt: skip
DENSE = {"extinction": True}


def frames_of(made: Scene, *methods: str) -> dict[str, Any]:
    with rtbow.Renderer(made) as renderer:
        return {m: np.float64(renderer.render(m)) for m in methods}  # type: ignore[arg-type]


def check(made: Scene, bounds: dict[str, float]) -> None:
    """Hold frames against the reference, and their lit pixels against plain geometry."""
    frames = frames_of(made, "reference", *bounds)
    exact = rgb_to_xyz(frames["reference"])
    if len(made.light) == 1:
        length = lit_lengths(resolve(made), 4001)
        sure = (length == 0.0) | (length > NEAR_EDGE_M)
        assert np.count_nonzero(sure & (length > 0.0)) > 50
        for name, frame in frames.items():
            lit = (frame != 0.0).any(axis=-1)
            np.testing.assert_array_equal(lit[sure], (length > 0.0)[sure], err_msg=name)
    for name, bound in bounds.items():
        error = frame_difference(rgb_to_xyz(frames[name]), exact).delta_e
        assert error.p99 < bound, (name, error)
        # The sum is that of many pixels' lit lengths: worst 5e-4, of the finer wavelengths.
        assert frames[name].sum() == pytest.approx(frames["reference"].sum(), rel=2e-3)


# Measured at the 99th percentile: fast 0.05 to 0.25, spectral 0.02 to 0.03.
BOUNDS = {"fast": 0.4, "spectral": 0.1}


@pytest.mark.slow
@pytest.mark.parametrize("altitude_deg", [-0.1, -0.5, -1.0, -1.1])
def test_edge_within_the_rain(altitude_deg):
    check(scene([altitude_deg]), BOUNDS)


@pytest.mark.slow
@pytest.mark.parametrize(
    "made",
    [
        pytest.param(scene([-0.9], camera={"position_m": [0.0, 900.0, 850.0]}), id="in it"),
        pytest.param(scene([-0.9], camera={"position_m": [0.0, 0.0, 1500.0],
                                           "altitude_deg": -20.0}), id="above it"),
        pytest.param(scene([-0.9], drops=DENSE), id="extinction"),
        pytest.param(scene([-1.0], ((-25e3, -3e3, 0.0), (25e3, 3e3, 1500.0)), NEAR_HORIZON),
                     id="two lit parts"),
        pytest.param(scene([-1.0], ((-25e3, -3e3, 0.0), (25e3, 3e3, 1500.0)), NEAR_HORIZON,
                           dict(DENSE) | {"density": {"number_per_m3": 30.0}}),
                     id="two lit parts, extinction"),
        pytest.param(scene([-0.8, -0.5, 30.0]), id="three suns"),
        pytest.param(scene([-1.0], camera={"fov_deg": 35.0, "altitude_deg": 27.0,
                                           "size_px": [96, 54]}), id="nodes"),
    ],
)  # fmt: skip
def test_other_views_of_the_edge(made):
    check(made, BOUNDS)


@pytest.mark.slow
@pytest.mark.parametrize("altitude_deg", [-0.3, -0.9])
def test_edge_within_a_grid(tmp_path, altitude_deg):
    made = Case(altitude_deg, rain="curtain", size_px=SIZE).scene()
    check(made, BOUNDS)


def test_rays_may_be_lit_twice():
    # The cylinder is round: a ray that dips into the shadow to the side of the sun comes out again.
    world = resolve(scene([-1.0], camera=NEAR_HORIZON))
    rays = world.view.pixel_directions(slice(0, SIZE[1]))
    eye = world.view.eye_m
    begin, end = shadow_span(eye, rays, eye, world.optics.suns[0].direction)
    twice = (begin > 0.0) & (begin < end) & (end < 25e3)
    assert np.count_nonzero(twice) > 10


@pytest.mark.slow
def test_deep_rain_falls_back():
    # From the edge up to 12 km colours differ too much for one table: 12 to 50 airs.
    deep = scene([-1.0], ((-12e3, 4e3, 0.0), (12e3, 12e3, 12e3)), camera={"size_px": [24, 14]})
    frames = frames_of(deep, "reference", "auto")
    error = frame_difference(rgb_to_xyz(frames["auto"]), rgb_to_xyz(frames["reference"])).delta_e
    assert error.p99 < 0.5


@pytest.mark.slow
def test_a_sun_that_sets():
    with rtbow.Renderer(scene([1.0])) as renderer:
        renderer.render("fast")
        for altitude in (0.1, -0.4, -0.9, 2.0):
            there = scene([altitude])
            renderer.show(there)
            moved = renderer.render("fast")
            fresh = frames_of(there, "fast")["fast"]
            # Tables that serve all altitudes differ a little from those of one.
            np.testing.assert_allclose(moved, fresh, atol=6e-3 * fresh.max())


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fast", "spectral"])
def test_samples_that_a_user_sets_lie_in_the_light(method):
    made = scene([-1.0])
    render = made.render.model_copy(update={"steps": 64})
    few = frames_of(made.model_copy(update={"render": render}), method)[method]
    exact = frames_of(made, "reference")["reference"]
    assert few.sum() == pytest.approx(exact.sum(), rel=3e-3)
