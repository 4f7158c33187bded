"""Rain on a grid: interpolation, cuts and nodes, against closed forms and finer grids."""

import numpy as np
import pytest
from scipy.integrate import quad

from one_pixel import BOX, EYE, NM, Pixel, along_north, colour_of, saved, xyz_of
from rtbow.frames.difference import frame_difference
from rtbow.physics.drop.water import relative_index
from rtbow.physics.geometry import direction
from rtbow.reference import render as reference
from rtbow.reference.render import radiance_along
from rtbow.scene.model import Scene
from rtbow.world.world import resolve
from textbook import cross_section, panels

pytestmark = pytest.mark.slow


def test_linear_density_is_its_mean(tmp_path):
    pixel = Pixel(azimuth=1.0, altitude=26.0)  # leaves the box through its far or upper face
    shape = (3, 2, 4)
    near, far = pixel.span()
    number = along_north(shape, [200.0, 1400.0])
    droplets = saved(tmp_path, np.full(shape, pixel.radius_um), number)
    north = (np.array([near, far]) * pixel.ray[1] + EYE[1] - BOX[0, 1]) / 1000.0
    mean = 200.0 + 1200.0 * north.mean()
    per_nm = [mean * (far - near) * pixel.section(nm, pixel.radius_um * 1e-6) for nm in NM]
    np.testing.assert_allclose(
        xyz_of(pixel.scene(droplets=droplets)), colour_of(np.array(per_nm)), rtol=3e-6
    )


def test_radius_is_weighted_by_density(tmp_path):
    pixel = Pixel(azimuth=5.0, altitude=24.0, disc_deg=0.0)
    shape = (2, 2, 2)
    # So near to each other that the nodes of the one cell still follow the fringes.
    number, radius = np.array([300.0, 1500.0]), np.array([90e-6, 80e-6])
    droplets = saved(tmp_path, along_north(shape, radius * 1e6), along_north(shape, number))
    near, far = pixel.span()

    def integrand(t, nm):
        f = (EYE[1] + t * pixel.ray[1] - BOX[0, 1]) / 1000.0
        density = (1.0 - f) * number[0] + f * number[1]
        product = (1.0 - f) * number[0] * radius[0] + f * number[1] * radius[1]
        return density * pixel.section(nm, product / density)

    per_nm = [quad(integrand, near, far, args=(nm,), epsrel=1e-8)[0] for nm in NM]
    # Worst 1.1e-3: three nodes in a cell, over which the fringes move by a good part of a cycle.
    np.testing.assert_allclose(
        xyz_of(pixel.scene(droplets=droplets)), colour_of(np.array(per_nm)), rtol=2e-3
    )


@pytest.mark.parametrize("altitude", [24.0, 21.0, 18.0])
def test_fringes_of_large_drops_under_a_point_are_followed(tmp_path, altitude):
    """Between 400 and 800 µm they turn by up to 500 rad along a ray, 9 degrees from the bow."""
    pixel = Pixel(azimuth=5.0, altitude=altitude, disc_deg=0.0)
    shape, number = (2, 2, 2), np.array([600.0, 600.0])
    radius = np.array([400e-6, 800e-6])
    droplets = saved(tmp_path, along_north(shape, radius * 1e6), along_north(shape, number))
    t, share = panels(*pixel.span(), 2000)
    along = (EYE[1] + t * pixel.ray[1] - BOX[0, 1]) / 1000.0
    radii = (1.0 - along) * radius[0] + along * radius[1]
    per_nm = []
    for nm in NM:
        index = float(relative_index(np.array([nm]), 20.0)[0])
        section = sum(cross_section(index, nm * 1e-9, radii, pixel.theta, k) for k in (1, 2))
        per_nm.append(number[0] * (share * section).sum())
    expected = colour_of(np.array(per_nm))
    got = xyz_of(pixel.scene(droplets=droplets))
    # Worst 2.1e-4 at 18 degrees; 1e-9 nearer to the bow.
    assert np.abs(got - expected).max() < 5e-4 * expected[1]


def test_empty_half_holds_no_light(tmp_path):
    pixel = Pixel(azimuth=0.5, altitude=20.0)
    shape = (2, 3, 2)
    number = along_north(shape, [1000.0, 0.0, 0.0])
    radius = along_north(shape, [80.0, 4000.0, 1.0])
    # From full to empty over the first 500 m: half of the drops that a full half would have; an
    # empty point lends no radius.
    near, far = pixel.span()
    edge = (700.0 - EYE[1]) / pixel.ray[1]
    assert near < edge < far
    got = xyz_of(pixel.scene(droplets=saved(tmp_path, radius, number)))
    per_nm = [1000.0 * 0.5 * (edge - near) * pixel.section(nm, 80e-6) for nm in NM]
    np.testing.assert_allclose(got, colour_of(np.array(per_nm)), rtol=3e-6)


def test_pieces_do_not_matter(tmp_path, monkeypatch, rng):
    pixel = Pixel(azimuth=20.0, altitude=15.0, disc_deg=0.0)
    shape = (5, 4, 3)
    droplets = saved(tmp_path, np.full(shape, 80.0), rng.uniform(100.0, 2000.0, shape))
    scene = pixel.scene(droplets=droplets, atmosphere={"rayleigh": True})
    whole = xyz_of(scene)
    for longest in (20.0, 77.0):
        monkeypatch.setattr(reference, "_AIR_CELL_M", longest)
        np.testing.assert_allclose(xyz_of(scene), whole, rtol=1e-11)


def test_finer_grid_of_the_same_field_is_the_same(tmp_path):
    pixel = Pixel(azimuth=20.0, altitude=15.0)
    frames = []
    for points in (2, 3, 9):
        shape = (points,) * 3
        x, y, z = np.meshgrid(*[np.linspace(0.0, 1.0, points)] * 3, indexing="ij")
        number = 100.0 + 400.0 * x + 300.0 * y + 200.0 * z + 256.0 * x * y
        droplets = saved(tmp_path, np.full(shape, 80.0), number)
        frames.append(xyz_of(pixel.scene(droplets=droplets)))
    np.testing.assert_allclose(frames[1], frames[0], rtol=1e-6)
    np.testing.assert_allclose(frames[2], frames[0], rtol=1e-6)


@pytest.mark.slow
def test_drawn_radii_under_a_lamp_do_not_ask_for_a_finer_grid(tmp_path):
    """The same drops on eight times as fine a grid, whose planes cut the rays eight times as often.

    Beyond the lamp angles hardly change along a ray, while radii go to and fro between points.
    """
    coarse = np.where(np.arange(12) % 2, 160.0, 80.0)
    number = np.full(12, 2000.0)
    fine = np.linspace(0.0, 11.0, 89)
    fine_number = np.interp(fine, np.arange(12), number)
    fine_radius = np.interp(fine, np.arange(12), number * coarse) / fine_number
    box = np.array([[-40.0, 0.0, 0.0], [40.0, 60.0, 15.0]])
    rays = np.stack([direction(azimuth, 5.0) for azimuth in np.linspace(-50.0, 30.0, 40)])
    lamp = {
        "type": "point",
        "position_m": [-0.7, 4.0, 7.2],
        "luminous_flux_lm": 1e4,
        "diameter_m": 0.0,
    }
    radiance = []
    for radius, density in ((coarse, number), (fine_radius, fine_number)):
        shape = (2, len(radius), 2)
        droplets = saved(tmp_path, along_north(shape, radius), along_north(shape, density), box)
        scene = Scene.model_validate(
            {
                "camera": {"position_m": [0.0, 9.0, 1.6]},
                "light": [lamp],
                "droplets": droplets,
                "render": {"wavelength_step_nm": 10.0},
            }
        )
        radiance.append(radiance_along(resolve(scene), rays))
    # 2.6 with one piece for each cell.
    assert frame_difference(*radiance).delta_e.worst < 0.05
