"""What chooses steps and refuses worlds, by its numbers alone."""

import numpy as np
import pytest

from rtbow.base.errors import UnsuitedError
from rtbow.base.limits import LEAST_SHARE_OF_DISTANCE
from rtbow.physics.air.rayleigh import Column
from rtbow.render.checks import check_box
from rtbow.render.fast.lamp import plan_lamp
from rtbow.render.fast.shared import plan_world
from rtbow.render.fast.sun_colours import plan_sunlight
from rtbow.render.fineness import sharp_step_nm
from rtbow.render.uniforms import LAMP_POINTS, lamp_points
from rtbow.scene.text.file import load_scene
from rtbow.world.steps import fringe_crowding
from rtbow.world.world import resolve


def world(name="uniform", **keys):
    return resolve(load_scene(name, {key.replace("__", "."): v for key, v in keys.items()}))


@pytest.mark.parametrize(("disc", "radius_um", "step"), [
    (0.533, 500.0, 5.0), (0.0, 20.0, 5.0), (0.0, 500.0, 1.0), (0.0, 2000.0, 1.0),
])  # fmt: skip
def test_fringes_that_nothing_blurs_take_finer_wavelengths(disc, radius_um, step):
    keys = {"light__0__angular_diameter_deg": disc, "droplets__radius__radius_um": radius_um}
    assert sharp_step_nm(world(**keys)) == step


def test_the_scenes_own_step_stays_where_it_is_finer():
    keys = {"light__0__angular_diameter_deg": 0.0, "render__wavelength_step_nm": 0.5}
    assert sharp_step_nm(world(**keys)) == 0.5


@pytest.mark.parametrize(("disc", "radius_um", "azimuth", "step"), [
    (0.533, 700.0, 0.0, 2.0),  # the disc blurs what two nanometres do not follow
    (0.533, 400.0, 180.0, 1.0),  # towards the sun fringes are wider, and less so
    (0.064, 400.0, 180.0, 1.0),
    (0.064, 50.0, 180.0, 2.0),  # there are none so fine
])  # fmt: skip
def test_tables_follow_the_fringes_that_a_disc_leaves(disc, radius_um, azimuth, step):
    keys = {"light__0__angular_diameter_deg": disc, "droplets__radius__radius_um": radius_um}
    towards = world(**keys, light__0__azimuth_deg=180.0, camera__azimuth_deg=azimuth)
    light = plan_sunlight(
        plan_world(towards), towards.optics.suns[0], Column(0.0, 8.0), 16_384, roaming=False
    )
    np.testing.assert_allclose(np.diff(light.basis.wavelength_nm), step)


@pytest.mark.parametrize(("share", "refused"), [(0.99, True), (1.01, False)])
def test_thin_boxes_far_away_are_left_to_float64(share, refused):
    far = 1e6
    thick = share * LEAST_SHARE_OF_DISTANCE * far
    box = [[-100.0, far - thick, 0.0], [100.0, far, 100.0]]
    thin = world(droplets__box_m=box, camera__position_m=[0.0, 0.0, 0.0])
    if refused:
        with pytest.raises(UnsuitedError, match="m thick along north"):
            check_box(thin)
    else:
        check_box(thin)


def test_depth_of_the_rain_across_its_box():
    """Beer's law by hand: number x pi r² x 2 (geometric optics) x diagonal."""
    box = [[0.0, 100.0, 0.0], [30.0, 140.0, 120.0]]
    rain = world(
        droplets__box_m=box, droplets__extinction=True, droplets__density__number_per_m3=1000.0,
        droplets__radius__radius_um=1000.0, droplets__extinction_efficiency=2.0,
    )  # fmt: skip
    np.testing.assert_allclose(rain.rain_depth, 1000.0 * np.pi * 1e-6 * 2.0 * 130.0, rtol=1e-6)
    assert world(droplets__box_m=box).rain_depth == 0.0


@pytest.mark.parametrize(
    ("disc", "most_um", "crowding"),
    [
        (0.533, 787.0, 1.0),
        (0.533, 100.0, 1.0),
        (0.026, 787.0, 2.2),
        (1e-300, 2000.0, 5.0),
        (0.0, 2000.0, 5.0),
    ],
)
def test_fringes_of_small_suns_crowd_along_rays(disc, most_um, crowding):
    radius = {"distribution": "uniform", "min_um": 0.5 * most_um, "max_um": most_um}
    rough = world(
        light__0__angular_diameter_deg=disc, droplets__grid=[4, 4, 4], droplets__radius=radius
    )
    assert fringe_crowding(rough.volume, rough.optics) == pytest.approx(crowding, abs=0.9)


def test_areas_take_several_rays_under_lamps():
    assert lamp_points(world("two-lamps")) == 1
    assert lamp_points(world("two-lamps", camera__pixel="area")) == LAMP_POINTS


@pytest.mark.parametrize(("pixel", "refused"), [("centre", False), ("area", True)])
def test_loops_of_all_rays_of_a_pixel_count(pixel, refused):
    """8 rays of 5,000 steps of 2 loops are more than the 65,535 that Mesa's CPU driver runs."""
    lit = world("two-lamps", render__steps=5000, camera__pixel=pixel)
    plan = plan_world(lit)
    if refused:
        with pytest.raises(UnsuitedError, match="5000 steps"):
            plan_lamp(plan, lit.optics.lamps[0], 8192)
    else:
        plan_lamp(plan, lit.optics.lamps[0], 8192)


@pytest.mark.parametrize(("depth", "refused"), [(29.0, False), (31.0, True)])
def test_dense_rain_under_a_lamp_is_left_to_the_other_method(depth, refused):
    box = [[-15.0, 5.0, 0.0], [15.0, 45.0, 120.0]]  # 130 m across
    number = depth / (130.0 * np.pi * 1e-6 * 2.0)
    lit = world(
        "two-lamps", droplets__box_m=box, droplets__extinction=True,
        droplets__density__number_per_m3=number, droplets__radius__radius_um=1000.0,
        droplets__extinction_efficiency=2.0, light__0__diameter_m=0.0, light__1__diameter_m=0.0,
    )  # fmt: skip
    assert lit.rain_depth == pytest.approx(depth, rel=1e-6)
    plan = plan_world(lit)
    if refused:
        with pytest.raises(UnsuitedError, match="optical depth"):
            plan_lamp(plan, lit.optics.lamps[0], 8192)
    else:
        plan_lamp(plan, lit.optics.lamps[0], 8192)
