"""Drop sizes against equation 1 worked in its own units, and against their distributions."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import kstest, norm

from rtbow.physics.sizes import marshall_palmer, marshall_palmer_slope
from rtbow.scene.droplets import Density
from rtbow.scene.radius import ConstantRadius, MarshallPalmerRadius, NormalRadius, UniformRadius
from rtbow.world.rain.drops import draw_drops

DROPS = Density(number_per_m3=1000.0)
RAIN = Density(rain_rate_mm_h=5.0)
WHOLE = MarshallPalmerRadius(distribution="marshall-palmer", min_um=15.0, max_um=1500.0)


def equation_1(diameter_cm, rain_rate):
    """Drops per cm³ and per cm of diameter, as the paper prints it."""
    return 0.08 * np.exp(-41.0 * rain_rate**-0.21 * diameter_cm)


def test_slope_of_ordinary_rain():
    # By hand: 41 · 5^-0.21 = 41 · 0.713209 = 29.2415 per cm.
    assert marshall_palmer_slope(5.0) == pytest.approx(2924.15, abs=0.02)
    assert marshall_palmer_slope(1.0) == pytest.approx(4100.0)
    assert marshall_palmer_slope(10.0) < marshall_palmer_slope(3.0)


def test_density_of_ordinary_rain():
    # 0.08 per cm³ and cm is 8e6 per m³ and m, or 8000 per m³ and mm.
    assert marshall_palmer(np.array(0.0), 5.0) == pytest.approx(8e6)
    # 2 mm across: 0.08 exp(-5.84831) per cm⁴, by hand.
    assert marshall_palmer(np.array(2e-3), 5.0) == pytest.approx(8e6 * 2.88478e-3, rel=1e-4)
    for diameter_cm in (0.003, 0.1, 0.3):
        per_m4 = equation_1(diameter_cm, 7.0) * 1e6 * 1e2  # from cm⁻³ and cm⁻¹
        assert marshall_palmer(np.array(diameter_cm * 1e-2), 7.0) == pytest.approx(per_m4)


@pytest.mark.parametrize("power", [0, 2, 3, 4])
def test_mean_over_the_grid_is_the_distribution(rng, power):
    count = 400_000
    radius, number = draw_drops(WHOLE, RAIN, count, rng)
    value = number * radius**power
    expected, _ = quad(
        lambda d: equation_1(d * 100.0, 5.0) * 1e8 * (d / 2.0) ** power, 30e-6, 3e-3, epsrel=1e-10
    )
    error = value.std() / np.sqrt(count)  # of the mean
    assert error < 0.01 * expected
    assert value.mean() == pytest.approx(expected, abs=4.0 * error)


def test_total_number_of_ordinary_rain(rng):
    # N0 / Lambda, less the ends: 8e6 / 2924.15 (e^-0.0877 - e^-8.77) = 2506 drops per m³.
    _, number = draw_drops(WHOLE, RAIN, 400_000, rng)
    assert number.mean() == pytest.approx(2506.0, rel=0.01)


def test_marshall_palmer_draws_radii_evenly(rng):
    radius, number = draw_drops(WHOLE, RAIN, 20_000, rng)
    assert kstest(radius * 1e6, "uniform", (15.0, 1485.0)).pvalue > 1e-3
    # Each point carries the density of its own size.
    order = np.argsort(radius)
    assert np.all(np.diff(number[order]) <= 0.0)


def test_constant(rng):
    radius, number = draw_drops(
        ConstantRadius(distribution="constant", radius_um=300.0), DROPS, 7, rng
    )
    np.testing.assert_allclose(radius, 300e-6)
    np.testing.assert_array_equal(number, 1000.0)


def test_uniform(rng):
    shape = UniformRadius(distribution="uniform", min_um=300.0, max_um=700.0)
    radius, number = draw_drops(shape, DROPS, 20_000, rng)
    assert kstest(radius * 1e6, "uniform", (300.0, 400.0)).pvalue > 1e-3
    np.testing.assert_array_equal(number, 1000.0)


def test_normal(rng):
    shape = NormalRadius(distribution="normal", mean_um=500.0, std_um=102.0)
    radius, _ = draw_drops(shape, DROPS, 50_000, rng)
    assert kstest(radius * 1e6, "norm", (500.0, 102.0)).pvalue > 1e-3
    # The paper's figure 5 (e): about 95 % in 0.3-0.7 mm.
    assert np.mean((radius > 300e-6) & (radius < 700e-6)) == pytest.approx(0.95, abs=0.005)


@pytest.mark.parametrize(("mean_um", "std_um"), [(20.0, 100.0), (4900.0, 400.0), (1.0, 5000.0)])
def test_normal_is_cut_to_the_allowed_radii(rng, mean_um, std_um):
    shape = NormalRadius(distribution="normal", mean_um=mean_um, std_um=std_um)
    radius_um = draw_drops(shape, DROPS, 20_000, rng)[0] * 1e6
    assert radius_um.min() >= 1.0 - 1e-9
    assert radius_um.max() <= 5000.0 + 1e-6
    # Cut, not clamped: the rest keeps the bell's shape, and nothing gathers at the ends.
    low, high = norm.cdf(1.0, mean_um, std_um), norm.cdf(5000.0, mean_um, std_um)
    kept = kstest(radius_um, lambda r: (norm.cdf(r, mean_um, std_um) - low) / (high - low))
    assert kept.pvalue > 1e-3


def test_no_drops(rng):
    radius = ConstantRadius(distribution="constant", radius_um=300.0)
    _, number = draw_drops(radius, Density(number_per_m3=0.0), 5, rng)
    np.testing.assert_array_equal(number, 0.0)


@pytest.mark.parametrize(
    "radius",
    [
        UniformRadius(distribution="uniform", min_um=300.0, max_um=700.0),
        NormalRadius(distribution="normal", mean_um=500.0, std_um=100.0),
        WHOLE,
    ],
)
def test_seed_decides(radius):
    density = RAIN if radius is WHOLE else DROPS
    first, again, other = (
        draw_drops(radius, density, 100, np.random.default_rng(seed)) for seed in (3, 3, 4)
    )
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_array_equal(first[1], again[1])
    assert np.all(first[0] != other[0])
