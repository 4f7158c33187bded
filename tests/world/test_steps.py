"""How many steps a scene asks for: they follow the grid, the change of radius, and the air."""

import numpy as np
import pytest

from rtbow.scene.model import Scene
from rtbow.world.optics import scene_optics
from rtbow.world.rain.volume import DropletVolume, build_volume
from rtbow.world.steps import (
    LAMP_STEPS,
    SAMPLES_PER_CELL,
    SAMPLES_PER_LOG_RADIUS,
    StepRates,
    lamp_steps,
    most_steps,
    roughness,
    step_rates,
)

BOX = np.array([[-100.0, 50.0, 0.0], [300.0, 250.0, 50.0]])  # 400 by 200 by 50 m
SHAPE = (9, 6, 5)


def volume(radius_um, number=1000.0, shape=SHAPE):
    radius = np.float32(np.broadcast_to(radius_um, shape))
    return DropletVolume(BOX, radius, np.float32(np.broadcast_to(number, shape)))


def optics(air=False, altitude_deg=20.0):
    scene = {
        "light": [{"altitude_deg": altitude_deg}],
        "droplets": {
            "box_m": BOX.tolist(),
            "radius": {"distribution": "constant", "radius_um": 500.0},
            "density": {"number_per_m3": 1.0},
        },
        "atmosphere": {"rayleigh": air},
    }
    return scene_optics(Scene.model_validate(scene))


def drawn(low_um, high_um):
    """Radii drawn evenly at each grid point."""
    return volume(np.random.default_rng(1).uniform(low_um, high_um, SHAPE))


class TestRoughness:
    def test_none_in_a_uniform_volume(self):
        assert roughness(volume(500.0, shape=(1, 1, 1))) == 0.0

    def test_none_for_drops_of_one_radius(self, rng):
        assert roughness(volume(500.0)) == 0.0
        assert roughness(volume(500.0, rng.uniform(0.0, 1000.0, SHAPE))) == 0.0

    def test_none_without_drops(self):
        assert roughness(volume([100.0, 200.0, 300.0, 400.0, 500.0], 0.0)) == 0.0

    def test_grows_with_contrast(self):
        found = [roughness(drawn(500.0 - d, 500.0 + d)) for d in (1.0, 10.0, 50.0, 200.0, 400.0)]
        assert found[0] > 0.0
        assert np.all(np.diff(found) > 0.0)

    def test_is_the_change_of_the_logarithm(self):
        # Twice the radius from one to the next along one of three axes, none along the others.
        up = volume(100.0 * 2.0 ** np.arange(5))
        counts = [8 * 6 * 5, 9 * 5 * 5, 9 * 6 * 4]
        weight = (100.0 * 2.0 ** np.arange(5)) ** (7.0 / 3.0)
        pairs = np.sqrt(weight[1:] * weight[:-1]).sum()
        share = counts[2] / 4 * pairs
        others = (counts[0] / 5 + counts[1] / 5) * weight.sum()
        assert roughness(up) == pytest.approx(np.log(2.0) * share / (share + others), rel=1e-5)

    def test_does_not_depend_on_the_scale(self):
        radius = np.random.default_rng(1).uniform(100.0, 200.0, SHAPE)
        assert roughness(volume(5.0 * radius)) == pytest.approx(roughness(volume(radius)))

    def test_empty_points_do_not_count(self):
        number = np.full(SHAPE, 1000.0)
        number[4:] = 0.0
        radius = np.full(SHAPE, 500.0)
        radius[4:] = np.random.default_rng(1).uniform(1.0, 5000.0, radius[4:].shape)
        radius[0, 0, 0] = 501.0  # so that there is something to weigh
        assert roughness(volume(radius, number)) < 1e-4


class TestRates:
    def test_follow_the_grid_along_each_axis(self):
        got = step_rates(volume(500.0), optics())
        np.testing.assert_allclose(
            got.cells_per_metre, SAMPLES_PER_CELL * np.array([8 / 400, 5 / 200, 4 / 50])
        )
        assert got.air_per_metre == 0.0

    def test_follow_the_change_of_radius(self):
        rough = drawn(300.0, 700.0)
        factor = step_rates(rough, optics()).cells_per_metre / (
            step_rates(volume(500.0), optics()).cells_per_metre
        )
        expected = 1.0 + SAMPLES_PER_LOG_RADIUS / SAMPLES_PER_CELL * roughness(rough)
        np.testing.assert_allclose(factor, expected)
        assert expected > 3.0

    def test_a_uniform_volume_asks_for_none(self):
        got = step_rates(volume(500.0, shape=(1, 1, 1)), optics())
        np.testing.assert_array_equal(got.cells_per_metre, 0.0)
        assert most_steps(got, volume(500.0, shape=(1, 1, 1))) == 1

    def test_air_and_a_low_sun_ask_for_more(self):
        one = volume(500.0, shape=(1, 1, 1))
        rates = [step_rates(one, optics(True, h)).air_per_metre for h in (60.0, 20.0, 2.0)]
        assert rates[0] > 0.0
        assert np.all(np.diff(rates) > 0.0)


class TestMostSteps:
    def test_bounds_every_ray(self, rng):
        one = drawn(300.0, 700.0)
        rates = step_rates(one, optics(True, 2.0))
        most = most_steps(rates, one)
        for _ in range(300):
            ends = rng.uniform(BOX[0], BOX[1], (2, 3))
            span = np.linalg.norm(ends[1] - ends[0])
            ray = np.abs(ends[1] - ends[0]) / span
            asked = span * max(np.max(ray * rates.cells_per_metre), rates.air_per_metre)
            assert np.ceil(asked) <= most

    def test_takes_the_finest(self):
        rates = StepRates(np.array([0.1, 0.0, 0.5]), 0.0)
        assert most_steps(rates, volume(500.0)) == 41  # 400 m at 0.1 per metre, and one
        assert most_steps(StepRates(np.zeros(3), 1.0), volume(500.0)) == 451  # the diagonal


class TestLampSteps:
    def test_at_least_32(self):
        assert LAMP_STEPS == 32
        one = volume(500.0, shape=(1, 1, 1))
        assert lamp_steps(step_rates(one, optics()), one) == 32

    def test_even_and_no_fewer_than_the_grid_asks_for(self):
        for rate in np.linspace(0.0, 0.9, 91):
            got = lamp_steps(StepRates(np.array([rate, 0.0, 0.0]), 0.0), volume(500.0))
            assert got % 2 == 0
            assert got >= max(32.0, 400.0 * rate)
            assert got < max(32.0, 400.0 * rate) + 2.0 + 1e-9

    def test_a_rough_volume_asks_for_more(self):
        scene = {
            "box_m": BOX.tolist(),
            "grid": [16, 16, 16],
            "radius": {"distribution": "uniform", "min_um": 200.0, "max_um": 400.0},
            "density": {"number_per_m3": 1.0},
        }
        rough = build_volume(Scene.model_validate({"light": [{}], "droplets": scene}).droplets)
        assert lamp_steps(step_rates(rough, optics()), rough) > 64
