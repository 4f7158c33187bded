"""Tables of mixed sizes: against sums over sizes written out here, and that they are kept."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import rtbow
from rtbow.physics.drop.medium import Medium
from rtbow.physics.drop.mie import intensities
from rtbow.physics.drop.water import relative_index
from rtbow.physics.sizes import Sizes
from rtbow.render.colours import bake
from rtbow.scene.droplets import Density
from rtbow.scene.model import Scene
from rtbow.scene.radius import LognormalRadius, MarshallPalmerRadius
from rtbow.tables import mixtures
from rtbow.tables.mixtures import KeptMixtures, MixtureTable
from rtbow.world.rain.drops import distribution
from textbook import cross_section, mean_on_sphere

DISC = 0.00465


@pytest.fixture
def built(monkeypatch):
    """What is built while a test runs, with a cache of its own."""
    kept = {}
    monkeypatch.setattr(mixtures, "_held", {})
    monkeypatch.setattr(mixtures, "kept_arrays", lambda *key: kept.get(key))
    monkeypatch.setattr(
        mixtures, "keep_arrays", lambda name, key, arrays: kept.setdefault((name, key), arrays)
    )
    monkeypatch.setattr(mixtures, "forget_oldest", lambda *_: None)
    found = []
    build = KeptMixtures._built

    def counted(self, sizes, disc_rad):
        found.append((self.theory, disc_rad))
        return build(self, sizes, disc_rad)

    monkeypatch.setattr(KeptMixtures, "_built", counted)
    return found


def mixed(theory, nm):
    return KeptMixtures(theory, (1, 2), Medium(20.0), 0.02, np.array(nm))


def rain(rate_mm_h):
    radius = MarshallPalmerRadius(distribution="marshall-palmer", min_um=100.0, max_um=2500.0)
    return distribution(radius, Density(rain_rate_mm_h=rate_mm_h))


def clouds(number_per_m3):
    radius = LognormalRadius(distribution="lognormal", median_um=12.0, log_std=0.2)
    return distribution(radius, Density(number_per_m3=number_per_m3))


def airy_rain(nm, theta):
    """Mean cross-section of Marshall and Palmer's drops at 4 mm/h from 100 to 2500 µm."""
    radius = np.geomspace(100e-6, 2500e-6, 3001)
    share = np.exp(-4100.0 * 4.0**-0.21 * 2.0 * radius) * radius
    share[[0, -1]] *= 0.5
    index = float(relative_index(np.array([nm]), 20.0)[0])
    total = np.zeros(np.shape(theta))
    for a, s in zip(radius, share / share.sum(), strict=True):
        total += s * sum(cross_section(index, nm * 1e-9, a, theta, k) for k in (1, 2))
    return total


@pytest.mark.parametrize("nm", [400.0, 700.0])
def test_raindrops_are_the_sum_over_their_sizes(built, nm):
    theta = np.radians([60.0, 124.0, 127.0, 128.5, 129.2, 134.0, 137.4, 138.4, 139.3, 142.0, 165.0])
    table = mixed("airy", [400.0, 550.0, 700.0]).table(rain(4.0), 0.0)
    got = table.at(theta)[int(nm / 150.0) - 2].mean(axis=1)
    expected = airy_rain(nm, theta)
    # Worst 9e-5 of the peak: the sizes that stand for each hundredth of ln(radius).
    assert np.abs(got - expected).max() < 3e-4 * expected.max()


def test_the_disc_is_averaged_on_the_sphere(built):
    table = mixed("airy", [550.0]).table(rain(4.0), DISC)
    fine = np.radians(np.linspace(136.6, 141.4, 121))
    curve = CubicSpline(fine, airy_rain(550.0, fine))
    theta = np.radians(np.linspace(137.0, 141.0, 9))
    expected = np.array([mean_on_sphere(curve, t, DISC, 12, 32) for t in theta])
    got = table.at(theta)[0].mean(axis=1)
    assert np.abs(got - expected).max() < 3e-4 * expected.max()


def test_exact_theory_is_the_sum_over_its_sizes(built):
    table = mixed("mie", [450.0, 600.0]).table(clouds(1.0), 0.0)
    theta = np.radians([20.0, 90.0, 139.0, 150.0, 172.0])
    log_radius = np.log(12e-6) + np.linspace(-0.9, 0.9, 1501)
    # The table's own spread of 2 % adds to that of the sizes.
    share = np.exp(-0.5 * ((log_radius - np.log(12e-6)) ** 2) / (0.2**2 + 0.02**2))
    share /= share.sum()
    for w, nm in enumerate((450.0, 600.0)):
        index = float(relative_index(np.array([nm]), 20.0)[0])
        wavenumber = 2.0 * np.pi / (nm * 1e-9)
        each = np.array(
            [intensities(wavenumber * a, index, theta, False) for a in np.exp(log_radius)]
        )
        expected = np.tensordot(share, each, axes=(0, 0)).T / wavenumber**2
        # Worst 2.2 %, at the faint component of the glory: that of the table that ships.
        np.testing.assert_allclose(table.at(theta)[w], expected, rtol=3e-2)


def test_between_its_angles_a_table_is_cubic():
    angles = np.pi * np.linspace(0.0, 1.0, 40) ** 1.3
    powers = np.array([[1.0, -2.0, 0.5, 0.3], [0.2, 1.0, -1.0, 0.1]])

    def cubics(theta):
        return theta[:, None] ** np.arange(4) @ powers.T

    table = MixtureTable(angles, cubics(angles)[:, None, :])
    theta = np.concatenate([angles, np.linspace(0.0, np.pi, 97)])
    np.testing.assert_allclose(table.at(theta)[0], cubics(theta), rtol=1e-9, atol=1e-9)


def test_a_table_does_not_depend_on_the_number_of_drops(built):
    first = mixed("airy", [550.0]).table(clouds(100.0), DISC)
    mixtures._held.clear()
    again = mixed("airy", [550.0]).table(clouds(330.0), DISC)
    assert len(built) == 1
    np.testing.assert_array_equal(first.values, again.values)
    # Counts of a file may differ in the last digits of their shares.
    sizes = clouds(100.0)
    rounded = Sizes(sizes.radius_m * (1.0 + 3e-16), sizes.share * (1.0 - 3e-16), 5.0)
    mixed("airy", [550.0]).table(rounded, DISC)
    assert len(built) == 1


@pytest.mark.parametrize(
    "other",
    [
        lambda: mixed("airy", [551.0]).table(clouds(1.0), DISC),
        lambda: mixed("airy", [550.0]).table(clouds(1.0), 0.5 * DISC),
        lambda: mixed("airy", [550.0]).table(rain(4.0), DISC),
        lambda: KeptMixtures("airy", (1,), Medium(20.0), 0.02, np.array([550.0])).table(
            clouds(1.0), DISC
        ),
        lambda: KeptMixtures("airy", (1, 2), Medium(5.0), 0.02, np.array([550.0])).table(
            clouds(1.0), DISC
        ),
    ],
)
def test_whatever_changes_the_light_has_a_table_of_its_own(built, other):
    mixed("airy", [550.0]).table(clouds(1.0), DISC)
    other()
    assert len(built) == 2


def scene_with(**keys):
    made = {
        "camera": {"size_px": [8, 5], "altitude_deg": 15.0},
        "light": [{"altitude_deg": 29.0}],
        "droplets": {
            "box_m": [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]],
            "radius": {
                "distribution": "lognormal", "median_um": 12.0, "log_std": 0.2, "mixing": "local",
            },
            "density": {"number_per_m3": 1000.0},
        },
        "atmosphere": {"rayleigh": True},
    }  # fmt: skip
    for path, value in keys.items():
        *tables, key = path.split("__")
        place = made
        for name in tables:
            place = place[int(name) if name.isdigit() else name]
        place[key] = value
    return Scene.model_validate(made)


@pytest.mark.slow
def test_no_view_sun_or_density_builds_a_mixture_again(built, monkeypatch):
    # Colours depend on the view: of a mixture they are not kept.
    monkeypatch.setattr(bake, "keep_arrays", lambda *_: pytest.fail("colours are kept"))
    with rtbow.Renderer(scene_with(), "egl") as renderer:
        renderer.render("fast")
    assert len(built) == 1
    moved = [
        scene_with(camera__azimuth_deg=1.0),
        scene_with(camera__azimuth_deg=-100.0, camera__fov_deg=50.0),
        scene_with(light__0__altitude_deg=12.0),
        scene_with(droplets__density={"number_per_m3": 333.0}),
    ]
    for scene in moved:
        mixtures._held.clear()
        with rtbow.Renderer(scene, "egl") as renderer:
            renderer.render("fast")
    assert len(built) == 1
    # The other methods take the same table.
    mixtures._held.clear()
    for method in ("spectral", "reference"):
        with rtbow.Renderer(scene_with(camera__azimuth_deg=2.0), "egl") as renderer:
            renderer.render(method)
    assert len(built) == 1
