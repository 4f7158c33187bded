"""Size distributions against their closed forms, and mixtures against random draws."""

import numpy as np
import pytest
from scipy.stats import gamma, gengamma, kstest, lognorm

import rtbow
from rtbow.scene.droplets import Density
from rtbow.scene.model import Scene
from rtbow.scene.radius import (
    GammaRadius,
    LognormalRadius,
    MarshallPalmerRadius,
    ModifiedGammaRadius,
    NormalRadius,
    UniformRadius,
)
from rtbow.tables.sections import water_sections
from rtbow.world.rain.drops import distribution, quantiles

DROPS = Density(number_per_m3=1000.0)


def moments(sizes, *powers):
    return [float(sizes.share @ sizes.radius_m**p) for p in powers]


@pytest.mark.parametrize("variance", [0.001, 0.1, 0.4])
def test_gamma_has_its_effective_radius_and_variance(variance):
    radius = GammaRadius(
        distribution="gamma", effective_radius_um=40.0, effective_variance=variance
    )
    m2, m3, m4 = moments(distribution(radius, DROPS), 2, 3, 4)
    assert m3 / m2 == pytest.approx(40e-6, rel=2e-3)
    assert m4 * m2 / m3**2 - 1.0 == pytest.approx(variance, rel=2e-2)


@pytest.mark.parametrize("exponent", [0.7, 1.0, 3.0])
def test_modified_gamma_has_them_too(exponent):
    radius = ModifiedGammaRadius(
        distribution="modified-gamma",
        effective_radius_um=40.0,
        effective_variance=0.1,
        exponent=exponent,
    )
    m2, m3, m4 = moments(distribution(radius, DROPS), 2, 3, 4)
    assert m3 / m2 == pytest.approx(40e-6, rel=2e-3)
    assert m4 * m2 / m3**2 - 1.0 == pytest.approx(0.1, rel=1e-2)


def test_modified_gamma_with_exponent_one_is_gamma():
    same = {"effective_radius_um": 40.0, "effective_variance": 0.1}
    one = distribution(GammaRadius(distribution="gamma", **same), DROPS)
    other = distribution(
        ModifiedGammaRadius(distribution="modified-gamma", exponent=1.0, **same), DROPS
    )
    np.testing.assert_allclose(moments(one, 1, 2, 3), moments(other, 1, 2, 3), rtol=1e-6)


def test_lognormal():
    radius = LognormalRadius(distribution="lognormal", median_um=100.0, log_std=0.3)
    m1, m2, m3 = moments(distribution(radius, DROPS), 1, 2, 3)
    assert m2 == pytest.approx(1e-8 * np.exp(2.0 * 0.09), rel=1e-4)
    assert m3 == pytest.approx(1e-12 * np.exp(4.5 * 0.09), rel=1e-4)
    # Each size has the mean area of its class, and so not quite its mean radius.
    assert m1 == pytest.approx(1e-4 * np.exp(0.5 * 0.09), rel=1e-4)


def test_normal_and_uniform():
    m2, m3 = moments(
        distribution(NormalRadius(distribution="normal", mean_um=500.0, std_um=20.0), DROPS), 2, 3
    )
    assert m2 == pytest.approx((500.0**2 + 20.0**2) * 1e-12, rel=1e-5)
    assert m3 == pytest.approx((500.0**3 + 3.0 * 500.0 * 20.0**2) * 1e-18, rel=1e-5)
    even = distribution(UniformRadius(distribution="uniform", min_um=300.0, max_um=700.0), DROPS)
    assert moments(even, 2)[0] == pytest.approx((0.7**3 - 0.3**3) / (3.0 * 0.4) * 1e-6, rel=1e-5)


def test_marshall_palmer_counts_its_drops():
    whole = MarshallPalmerRadius(distribution="marshall-palmer", min_um=15.0, max_um=1500.0)
    sizes = distribution(whole, Density(rain_rate_mm_h=5.0))
    # N0 / Lambda, less the ends: 8e6 / 2924.15 (e^-0.0877 - e^-8.77) = 2506 drops per m³.
    assert sizes.number_per_m3 == pytest.approx(2506.0, rel=1e-3)
    # Third moment by parts: N0/8 times the incomplete gamma function of four.
    slope = 2924.15
    u = np.linspace(30e-6 * slope, 3e-3 * slope, 200001)
    third = np.trapezoid(u**3 * np.exp(-u), u) / slope**4 * 8e6 / 8.0
    assert sizes.number_per_m3 * moments(sizes, 3)[0] == pytest.approx(third, rel=1e-3)


def test_draws_follow_their_distributions(rng):
    share = rng.random(20_000)
    a, v = 40.0, 0.1
    cases = {
        GammaRadius(distribution="gamma", effective_radius_um=a, effective_variance=v): gamma(
            (1.0 - 2.0 * v) / v, scale=a * v
        ),
        LognormalRadius(distribution="lognormal", median_um=90.0, log_std=0.2): lognorm(
            0.2, scale=90.0
        ),
        NormalRadius(distribution="normal", mean_um=500.0, std_um=20.0): None,
    }
    for radius, expected in cases.items():
        drawn = quantiles(radius, share)
        if expected is None:
            assert kstest(drawn, "norm", (500.0, 20.0)).pvalue > 1e-3
        else:
            assert kstest(drawn, expected.cdf).pvalue > 1e-3


def test_modified_gamma_draws(rng):
    radius = ModifiedGammaRadius(
        distribution="modified-gamma",
        effective_radius_um=40.0,
        effective_variance=0.1,
        exponent=2.0,
    )
    drawn = quantiles(radius, rng.random(20_000))
    # r^alpha exp(-b r²): a generalised gamma distribution; its shape from the drawn moments.
    shape, power, _, scale = gengamma.fit(drawn, f1=2.0, floc=0.0)
    assert power == 2.0
    m = [gengamma.moment(k, shape, 2.0, scale=scale) for k in (2, 3, 4)]
    assert m[1] / m[0] == pytest.approx(40.0, rel=0.01)
    assert m[0] * m[2] / m[1] ** 2 - 1.0 == pytest.approx(0.1, rel=0.05)


def test_a_thin_tail_of_large_drops_needs_no_table_of_its_own():
    radius = GammaRadius(distribution="gamma", effective_radius_um=500.0, effective_variance=0.1)
    sizes = distribution(radius, DROPS)
    assert sizes.range_um[1] > 1500.0
    cut = sizes.within(1500.0, 0.01)
    assert cut.range_um[1] == pytest.approx(1500.0)
    area, kept = (float(s.share @ s.radius_m**2) for s in (sizes, cut))
    assert kept == pytest.approx(area, rel=1e-12)
    third, other = (float(s.share @ s.radius_m**3) for s in (sizes, cut))
    assert other == pytest.approx(third, rel=2e-3)
    # Where much is beyond, all stays.
    assert sizes.within(600.0, 0.01) is sizes
    sections = water_sections("mie", np.array([550.0]), 20.0, cut.range_um)
    assert np.isfinite(sections.mixed(sizes, np.array([2.42]), 0.00465)).all()


@pytest.mark.slow
@pytest.mark.parametrize("theory", ["airy", "mie"])
def test_draws_approach_the_mixture_as_one_over_the_root_of_their_number(rng, theory):
    """Mean cross-section of N points, each of one drawn size, against the whole distribution."""
    radius = LognormalRadius(distribution="lognormal", median_um=100.0, log_std=0.3)
    sections = water_sections(theory, np.array([550.0]), 20.0, (15.0, 600.0))
    theta = np.radians(np.array([125.0, 139.0, 141.0, 145.0, 150.0, 160.0]))
    whole = sections.mixed(distribution(radius, DROPS), theta, 0.00465)[0].mean(axis=1)
    counts = 4 ** np.arange(2, 7)
    errors = []
    for count in counts:
        trials = []
        for _ in range(24 if count < 1000 else 8):
            drawn = quantiles(radius, rng.random(count)) * 1e-6
            each = sections.sections(drawn, theta, 0.00465)[:, 0].mean(axis=2)
            trials.append(each.mean(axis=0) / whole - 1.0)
        errors.append(np.sqrt(np.mean(np.square(trials))))
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.06)
    assert errors[-1] < 0.05


def scene_of(radius, theory, **droplets):
    return Scene.model_validate(
        {
            "camera": {"size_px": [20, 12]},
            "light": [{"altitude_deg": 20.0}],
            "droplets": {
                "box_m": [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]],
                "radius": radius,
                "density": {"number_per_m3": 1000.0},
            }
            | droplets,
            "scattering": {"theory": theory},
            "render": {"wavelength_step_nm": 40.0},
        }
    )


def render(scene, method="spectral"):
    with rtbow.Renderer(scene, "egl") as renderer:
        return renderer.render(method).astype(np.float64)


@pytest.mark.slow
@pytest.mark.parametrize("theory", ["airy", "mie"])
def test_a_mixed_volume_is_the_sum_of_its_sizes(theory):
    """Without a grid, frames of single sizes add up: an even distribution from 50 to 90 µm."""
    mixed = {"distribution": "uniform", "min_um": 50.0, "max_um": 90.0, "mixing": "local"}
    frame = render(scene_of(mixed, theory))
    radii = np.linspace(50.5, 89.5, 40)
    parts = [
        render(scene_of({"distribution": "constant", "radius_um": float(a)}, theory)) for a in radii
    ]
    total = np.mean(parts, axis=0)
    assert np.abs(frame - total).max() < 3e-3 * total.max()
    exact = render(scene_of(mixed, theory), "reference")
    assert np.abs(frame - exact).max() < 2e-3 * exact.max()


@pytest.mark.parametrize("disc_rad", [0.0, 0.00465])
def test_airys_fringes_do_not_alias_between_sizes(disc_rad):
    """Far inside the bow neighbouring sizes differ by more than a fringe: thousands of them."""
    radius = UniformRadius(distribution="uniform", min_um=300.0, max_um=700.0)
    sections = water_sections("airy", np.array([550.0]), 20.0, (300.0, 700.0))
    theta = np.radians(np.array([138.5, 140.0, 145.0, 150.0, 155.0, 160.0, 165.0]))
    got = sections.mixed(distribution(radius, DROPS), theta, disc_rad)[0].mean(axis=1)
    radii = np.linspace(300.05e-6, 699.95e-6, 4000)
    each = np.concatenate(
        [
            sections.sections(part, theta, disc_rad)[:, 0].mean(axis=2)
            for part in np.split(radii, 40)
        ]
    )
    # A point light shows what the ends of the range leave, finer than the angles (6e-3).
    np.testing.assert_allclose(got, each.mean(axis=0), rtol=3e-3 if disc_rad else 1e-2)


def test_small_drops_that_are_cut_off_are_not_counted():
    whole = MarshallPalmerRadius(distribution="marshall-palmer", min_um=1.0, max_um=1500.0)
    sizes = distribution(whole, Density(rain_rate_mm_h=5.0))
    slope = 2924.15
    u = np.linspace(2e-6 * slope, 3e-3 * slope, 200001)
    second = np.trapezoid(u**2 * np.exp(-u), u) / slope**3 * 8e6 / 4.0
    assert sizes.number_per_m3 * moments(sizes, 2)[0] == pytest.approx(second, rel=1e-3)


def test_a_grid_of_mixed_drops_is_the_uniform_volume():
    mixed = {"distribution": "uniform", "min_um": 50.0, "max_um": 90.0, "mixing": "local"}
    with_grid = render(scene_of(mixed, "airy", grid=[5, 4, 3]))
    without = render(scene_of(mixed, "airy"))
    np.testing.assert_allclose(with_grid, without, rtol=1e-4, atol=1e-5 * without.max())
