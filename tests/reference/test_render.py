"""The float64 reference against single pixels worked out with loops and textbook formulas."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import quad, trapezoid

from rtbow.frames.difference import frame_difference
from rtbow.physics.drop.airy_compiled import airy_grid, airy_squared_at
from rtbow.physics.drop.water import relative_index
from rtbow.physics.geometry import direction
from rtbow.physics.light.colour import colour_matching
from rtbow.reference.rays import sample_rays
from rtbow.reference.render import radiance_along, render_reference, spectral_radiance_along
from rtbow.reference.render import render as reference
from rtbow.scene.model import Scene
from rtbow.world.rain.volume import DropletVolume, save_volume
from textbook import (
    LUMINANCE,
    RGB_TO_XYZ,
    column_along_ray,
    cross_section,
    mean_on_sphere,
    rayleigh_depth,
    towards,
)

STEP_NM = 40.0
NM = np.arange(380.0, 781.0, STEP_NM)
IRRADIANCE = 650.0  # W/m² over 380-780 nm, the same at each wavelength
BOX = np.array([[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]])
EYE = np.array([0.0, 0.0, 1.6])


def colour_of(per_nm):
    """X, Y, Z of radiance per irradiance (len(NM),), each value standing for its bin."""
    nm, cmf = colour_matching()
    edges = np.concatenate([[380.0], 0.5 * (NM[:-1] + NM[1:]), [780.0]])
    xyz = np.zeros(3)
    for value, low, high in zip(per_nm, edges[:-1], edges[1:], strict=True):
        fine = np.linspace(low, high, 4001)
        for k in range(3):
            xyz[k] += value * trapezoid(np.interp(fine, nm, cmf[:, k]), fine)
    return xyz * IRRADIANCE / 400.0


@dataclass(frozen=True)
class Pixel:
    """One pixel's ray: it looks where it is told, with the sun in the south."""

    azimuth: float = 30.0
    altitude: float = 12.0
    sun_altitude: float = 15.0
    disc_deg: float = 0.533
    radius_um: float = 80.0
    orders: tuple[int, ...] = (1, 2)

    @property
    def ray(self):
        return towards(self.azimuth, self.altitude)

    @property
    def theta(self):
        # Light travels away from the sun, then against the ray, into the eye.
        return np.arccos(-towards(180.0, self.sun_altitude) @ -self.ray)

    def span(self, box=BOX):
        """Distances at which the ray crosses the box, face by face."""
        found = []
        for axis in range(3):
            for face in box[:, axis]:
                t = (face - EYE[axis]) / self.ray[axis]
                at = EYE + t * self.ray
                others = [a for a in range(3) if a != axis]
                if t > 0.0 and all(box[0, a] <= at[a] <= box[1, a] for a in others):
                    found.append(t)
        assert len(found) == 2
        return sorted(found)

    def section(self, nm, radius_m):
        """Cross-section of a drop at this pixel's angle, averaged over the sun's disc."""
        index = float(relative_index(np.array([nm]), 20.0)[0])
        # The shader and the reference take the wavelength in air as that in vacuum: 3e-4.
        return sum(
            mean_on_sphere(
                lambda t, k=order: cross_section(index, nm * 1e-9, radius_m, t, k),
                self.theta,
                np.radians(0.5 * self.disc_deg),
                rings=40,
                spokes=96,
            )
            for order in self.orders
        )

    def scene(self, **changes):
        parts = {
            "camera": {
                "position_m": list(EYE),
                "azimuth_deg": self.azimuth,
                "altitude_deg": self.altitude,
                "fov_deg": 1.0,
                "size_px": [1, 1],
            },
            "light": [
                {
                    "altitude_deg": self.sun_altitude,
                    "spectrum": "equal-energy",
                    "irradiance_w_m2": IRRADIANCE,
                    "angular_diameter_deg": self.disc_deg,
                }
            ],
            "droplets": {
                "box_m": BOX.tolist(),
                "radius": {"distribution": "constant", "radius_um": self.radius_um},
                "density": {"number_per_m3": 1000.0},
            },
            "scattering": {"orders": list(self.orders)},
            "render": {"wavelength_step_nm": STEP_NM},
        }
        return Scene.model_validate(parts | changes)


def xyz_of(scene):
    frame = render_reference(scene)
    assert frame.shape == (1, 1, 3)
    assert frame.dtype == np.float64
    return RGB_TO_XYZ @ frame[0, 0]


PIXELS = {
    "primary": Pixel(),
    "secondary": Pixel(azimuth=50.0, altitude=8.0),
    "between the bows": Pixel(azimuth=45.0, altitude=8.0),
    "inside": Pixel(azimuth=10.0, altitude=2.0),
    "steep": Pixel(azimuth=2.0, altitude=28.0),
    "large drops": Pixel(radius_um=700.0),
    "a point": Pixel(disc_deg=0.0),
    "wide disc": Pixel(disc_deg=4.0),
    "primary alone": Pixel(orders=(1,)),
    "secondary alone": Pixel(azimuth=50.0, altitude=8.0, orders=(2,)),
    "antisolar point": Pixel(azimuth=0.2, altitude=-14.9, radius_um=30.0, sun_altitude=15.0),
}


def box_for(pixel):
    """A box in the ray's way, for rays below the horizon too."""
    return BOX - [0.0, 0.0, 1000.0] if pixel.altitude < 0.0 else BOX


@pytest.mark.parametrize("pixel", PIXELS.values(), ids=PIXELS.keys())
def test_uniform_volume(pixel):
    box = box_for(pixel)
    scene = pixel.scene()
    parts = scene.droplets.model_dump() | {"box_m": box.tolist()}
    scene = pixel.scene(droplets={k: v for k, v in parts.items() if v is not None})
    near, far = pixel.span(box)
    per_nm = [1000.0 * (far - near) * pixel.section(nm, pixel.radius_um * 1e-6) for nm in NM]
    expected = colour_of(np.array(per_nm))
    # Worst 4e-8 (density and radius are kept in float32), in the dark between the bows 1e-6.
    np.testing.assert_allclose(xyz_of(scene), expected, rtol=3e-6)


@pytest.mark.parametrize("sun_altitude", [2.0, 15.0])
def test_air(sun_altitude):
    pixel = Pixel(sun_altitude=sun_altitude, altitude=20.0)
    near, far = pixel.span()
    nodes, gauss = np.polynomial.legendre.leggauss(12)
    at = near + 0.5 * (far - near) * (nodes + 1.0)
    share = 0.5 * (far - near) * gauss
    column = np.array(
        [
            column_along_ray(EYE[2] + t * pixel.ray[2], np.radians(sun_altitude))
            + column_along_ray(EYE[2], np.radians(pixel.altitude), t)
            for t in at
        ]
    )
    per_nm = [
        1000.0
        * pixel.section(nm, pixel.radius_um * 1e-6)
        * (share * np.exp(-rayleigh_depth(nm) * column)).sum()
        for nm in NM
    ]
    got = xyz_of(pixel.scene(atmosphere={"rayleigh": True}))
    # Worst 4e-6: the eye's column is that of flat shells.
    np.testing.assert_allclose(got, colour_of(np.array(per_nm)), rtol=1e-5)
    assert got[1] < 0.8 * xyz_of(pixel.scene())[1]


def saved(tmp_path, radius_um, number, box=BOX):
    path = tmp_path / "volume.npz"
    save_volume(DropletVolume(box, np.float32(radius_um), np.float32(number)), path)
    return {"file": str(path)}


def along_north(shape, values):
    """A field that depends on the distance north alone."""
    return np.broadcast_to(np.asarray(values)[None, :, None], shape)


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
        here = (1.0 - f) * number[0] + f * number[1]
        product = (1.0 - f) * number[0] * radius[0] + f * number[1] * radius[1]
        return here * pixel.section(nm, product / here)

    per_nm = [quad(integrand, near, far, args=(nm,), epsrel=1e-8)[0] for nm in NM]
    # Worst 1.1e-3: three nodes in a cell, over which the fringes move by a good part of a cycle.
    np.testing.assert_allclose(
        xyz_of(pixel.scene(droplets=droplets)), colour_of(np.array(per_nm)), rtol=2e-3
    )


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


@pytest.mark.parametrize("air", [False, True])
def test_no_drops_no_light(air):
    droplets = {
        "box_m": BOX.tolist(),
        "radius": {"distribution": "constant", "radius_um": 300.0},
        "density": {"number_per_m3": 0.0},
    }
    scene = Pixel().scene(droplets=droplets, atmosphere={"rayleigh": air})
    np.testing.assert_array_equal(render_reference(scene), 0.0)


@pytest.mark.parametrize(("azimuth", "altitude"), [(180.0, 12.0), (30.0, 80.0), (90.0, 0.0)])
def test_missed_box_is_dark(azimuth, altitude):
    scene = Pixel(azimuth=azimuth, altitude=altitude).scene()
    np.testing.assert_array_equal(render_reference(scene), 0.0)


def test_twice_the_drops_twice_the_light():
    droplets = {
        "box_m": BOX.tolist(),
        "radius": {"distribution": "constant", "radius_um": 80.0},
        "density": {"number_per_m3": 2000.0},
    }
    np.testing.assert_allclose(
        xyz_of(Pixel().scene(droplets=droplets)), 2.0 * xyz_of(Pixel().scene()), rtol=1e-12
    )


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


def test_samples_cover_the_ray():
    moments = np.ones((3, 4, 5, 2))
    rays = np.stack([towards(a, h) for a, h in ((0.0, 10.0), (35.0, 25.0), (180.0, 0.0))])
    pixel_spans = [(200.0 / rays[0, 1], 1200.0 / rays[0, 1]), (300.0, 900.0), (5.0, 5.0)]
    entry, leave = np.array(pixel_spans).T
    start, distance, weight, radius = sample_rays(
        EYE, rays, entry, leave, BOX, moments, np.full(3, np.inf), reference._gauss_rules()
    )
    assert start[0] == 0
    assert start[-1] == len(distance) == len(weight) == len(radius)
    assert start[3] == start[2]  # nothing in an empty span
    for k in range(2):
        part = slice(start[k], start[k + 1])
        assert weight[part].sum() == pytest.approx(leave[k] - entry[k], rel=1e-12)
        assert (weight * distance)[part].sum() == pytest.approx(
            0.5 * (leave[k] ** 2 - entry[k] ** 2), rel=1e-12
        )
        assert np.all(np.diff(distance[part]) > 0.0)


def test_kernels_own_airy():
    from scipy.special import airy

    z = np.concatenate([np.linspace(-16.0, 40.0, 5001), np.geomspace(40.0, 900.0, 500)])
    got = np.array([airy_squared_at(float(at), airy_grid()) for at in z])
    # Worst 4e-8 of the peak.
    np.testing.assert_allclose(got, airy(-z)[0] ** 2, rtol=0.0, atol=1e-7 * 0.287)


def test_two_suns_add():
    pixel = Pixel()
    first = {"altitude_deg": 15.0, "spectrum": "FL2"}
    second = {"altitude_deg": 25.0, "azimuth_deg": 160.0, "angular_diameter_deg": 0.0}
    both, one, other = (
        xyz_of(pixel.scene(light=list(lights))) for lights in ((first, second), (first,), (second,))
    )
    np.testing.assert_allclose(both, one + other, rtol=1e-12)


def test_rows_are_from_the_top():
    # A tall narrow picture across the top of the primary: dark above, bright below.
    camera = {"position_m": list(EYE), "altitude_deg": 28.0, "fov_deg": 4.0, "size_px": [2, 24]}
    frame = render_reference(Pixel(disc_deg=0.0).scene(camera=camera))
    luminance = (frame @ LUMINANCE).mean(axis=1)
    assert luminance[:6].mean() < 0.3 * luminance[12:].max()


def test_progress_sees_every_row():
    seen = []

    def progress(rows):
        for row in rows:
            seen.append(row)
            yield row

    camera = {"size_px": [2, 5]}
    render_reference(Pixel().scene(camera=camera), progress)
    assert seen == list(range(5))


def test_spectral_radiance_of_a_uniform_volume():
    pixel = Pixel()
    near, far = pixel.span()
    per_nm = [1000.0 * (far - near) * pixel.section(nm, pixel.radius_um * 1e-6) for nm in NM]
    got = spectral_radiance_along(pixel.scene(), pixel.ray[None])
    # The irradiance is the same at each of 400 wavelengths. Worst 3e-10.
    np.testing.assert_allclose(got, IRRADIANCE / 400.0 * np.array([per_nm]), rtol=1e-8)


LAMP = {
    "type": "point",
    "position_m": [40.0, -50.0, 30.0],
    "spectrum": "equal-energy",
    "luminous_flux_lm": 1e9,
}
FILTERED = {"position_m": list(EYE), "azimuth_deg": 10.0, "polarizer_deg": 30.0}


@pytest.mark.parametrize("theory", ["airy", "mie"])
def test_spectral_radiance_sums_to_the_radiance(theory):
    pixel = Pixel(radius_um=20.0)
    scene = pixel.scene(
        light=[*pixel.scene().model_dump()["light"], LAMP],
        camera=FILTERED,
        droplets=pixel.scene().droplets.model_dump(exclude_none=True) | {"extinction": True},
        atmosphere={"rayleigh": True},
        scattering={"theory": theory},
    )
    rays = np.stack([towards(a, h) for a, h in ((0.0, 10.0), (30.0, 12.0), (180.0, 5.0))])
    got = spectral_radiance_along(scene, rays)
    # Both lights are the same at each wavelength: a bin's colour is that of its functions alone.
    expected = [colour_of(values) * 400.0 / IRRADIANCE for values in got]
    assert np.all(got[:2] > 0.0)
    assert np.all(got[2] == 0.0)  # misses the box
    np.testing.assert_allclose(radiance_along(scene, rays), expected, rtol=1e-12)


def test_spectral_radiance_has_the_suns_lines():
    pixel = Pixel()
    lights = [{"altitude_deg": 15.0, "spectrum": "E490"}]
    scene = pixel.scene(light=lights, render={"wavelength_step_nm": 1.0})
    got = spectral_radiance_along(scene, pixel.ray[None])[0]
    nm, cmf = colour_matching()
    assert len(got) == 401
    widths = np.r_[0.5, np.ones(399), 0.5]
    at_nodes = np.stack([np.interp(np.arange(380.0, 781.0), nm, f) for f in cmf.T], axis=1)
    # Worst 1.7e-5: the spectrum's slope within a nanometre.
    np.testing.assert_allclose(
        (got * widths) @ at_nodes, radiance_along(scene, pixel.ray[None])[0], rtol=5e-5
    )


def test_drawn_radii_under_a_lamp_do_not_ask_for_a_finer_grid(tmp_path):
    """The same drops on eight times as fine a grid, whose planes cut the rays eight times as often.

    Beyond the lamp angles hardly change along a ray, while radii go to and fro between points.
    """
    coarse = np.where(np.arange(12) % 2, 160.0, 80.0)
    number = np.full(12, 2000.0)
    fine = np.linspace(0.0, 11.0, 89)
    fine_number = np.interp(fine, np.arange(12), number)
    fine_radius = np.interp(fine, np.arange(12), number * coarse) / fine_number
    found = []
    for radius, density in ((coarse, number), (fine_radius, fine_number)):
        shape = (2, len(radius), 2)
        volume = DropletVolume(
            np.array([[-40.0, 0.0, 0.0], [40.0, 60.0, 15.0]]),
            np.broadcast_to(radius[None, :, None], shape).astype(np.float32).copy(),
            np.broadcast_to(density[None, :, None], shape).astype(np.float32).copy(),
        )
        path = tmp_path / f"{len(radius)}.npz"
        save_volume(volume, path)
        scene = Scene.model_validate(
            {
                "camera": {"position_m": [0.0, 9.0, 1.6]},
                "light": [
                    {"type": "point", "position_m": [-0.7, 4.0, 7.2], "luminous_flux_lm": 1e4,
                     "diameter_m": 0.0}
                ],
                "droplets": {"file": str(path)},
                "render": {"wavelength_step_nm": 10.0},
            }
        )  # fmt: skip
        rays = np.stack([direction(azimuth, 5.0) for azimuth in np.linspace(-50.0, 30.0, 40)])
        found.append(radiance_along(scene, rays))
    # 2.6 with one piece for each cell.
    assert frame_difference(found[0], found[1]).delta_e.worst < 0.05
