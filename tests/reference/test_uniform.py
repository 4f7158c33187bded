"""Uniform rain under suns: single pixels worked out with loops and textbook formulas."""

import numpy as np
import pytest

from one_pixel import BOX, EYE, NM, Pixel, colour_of, xyz_of
from rtbow.reference.render import render_reference
from rtbow.world.world import resolve
from textbook import column_along_ray, rayleigh_depth

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


@pytest.mark.parametrize("air", [False, True])
def test_no_drops_no_light(air):
    droplets = {
        "box_m": BOX.tolist(),
        "radius": {"distribution": "constant", "radius_um": 300.0},
        "density": {"number_per_m3": 0.0},
    }
    scene = Pixel().scene(droplets=droplets, atmosphere={"rayleigh": air})
    np.testing.assert_array_equal(render_reference(resolve(scene)), 0.0)


@pytest.mark.parametrize(("azimuth", "altitude"), [(180.0, 12.0), (30.0, 80.0), (90.0, 0.0)])
def test_missed_box_is_dark(azimuth, altitude):
    scene = Pixel(azimuth=azimuth, altitude=altitude).scene()
    np.testing.assert_array_equal(render_reference(resolve(scene)), 0.0)


def test_twice_the_drops_twice_the_light():
    droplets = {
        "box_m": BOX.tolist(),
        "radius": {"distribution": "constant", "radius_um": 80.0},
        "density": {"number_per_m3": 2000.0},
    }
    np.testing.assert_allclose(
        xyz_of(Pixel().scene(droplets=droplets)), 2.0 * xyz_of(Pixel().scene()), rtol=1e-12
    )


def test_two_suns_add():
    pixel = Pixel()
    first = {"altitude_deg": 15.0, "spectrum": "FL2"}
    second = {"altitude_deg": 25.0, "azimuth_deg": 160.0, "angular_diameter_deg": 0.0}
    both, one, other = (
        xyz_of(pixel.scene(light=list(lights))) for lights in ((first, second), (first,), (second,))
    )
    np.testing.assert_allclose(both, one + other, rtol=1e-12)
