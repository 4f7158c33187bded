"""Spectral radiance along rays, against single pixels and the radiance itself."""

import numpy as np
import pytest

from one_pixel import EYE, IRRADIANCE, NM, Pixel, colour_of
from rtbow.physics.light.colour import colour_matching
from rtbow.reference.render import radiance_along, spectral_radiance_along
from rtbow.world.world import resolve
from textbook import towards

pytestmark = pytest.mark.slow


def test_spectral_radiance_of_a_uniform_volume():
    pixel = Pixel()
    near, far = pixel.span()
    per_nm = [1000.0 * (far - near) * pixel.section(nm, pixel.radius_um * 1e-6) for nm in NM]
    got = spectral_radiance_along(resolve(pixel.scene()), pixel.ray[None])
    # The irradiance is the same at each of 400 wavelengths. Worst 3e-10.
    np.testing.assert_allclose(got, IRRADIANCE / 400.0 * np.array([per_nm]), rtol=1e-8)


LAMP = {
    "type": "point",
    "position_m": [40.0, -50.0, 30.0],
    "spectrum": "equal-energy",
    "luminous_flux_lm": 1e9,
}
FILTERED = {"position_m": list(EYE), "azimuth_deg": 10.0, "polarizer_deg": 30.0}


@pytest.mark.parametrize("theory", ["airy", pytest.param("mie", marks=pytest.mark.slow)])
def test_spectral_radiance_sums_to_the_radiance(theory):
    pixel = Pixel(radius_um=20.0 if theory == "airy" else 4.0)
    scene = pixel.scene(
        light=[*pixel.scene().model_dump()["light"], LAMP],
        camera=FILTERED,
        droplets=pixel.scene().droplets.model_dump(exclude_none=True) | {"extinction": True},
        atmosphere={"rayleigh": True},
        scattering={"theory": theory},
    )
    rays = np.stack([towards(a, h) for a, h in ((0.0, 10.0), (30.0, 12.0), (180.0, 5.0))])
    got = spectral_radiance_along(resolve(scene), rays)
    # Both lights are the same at each wavelength: a bin's colour is that of its functions alone.
    expected = [colour_of(values) * 400.0 / IRRADIANCE for values in got]
    assert np.all(got[:2] > 0.0)
    assert np.all(got[2] == 0.0)  # misses the box
    np.testing.assert_allclose(radiance_along(resolve(scene), rays), expected, rtol=1e-12)


def test_spectral_radiance_has_the_suns_lines():
    pixel = Pixel()
    lights = [{"altitude_deg": 15.0, "spectrum": "E490"}]
    scene = pixel.scene(light=lights, render={"wavelength_step_nm": 1.0})
    got = spectral_radiance_along(resolve(scene), pixel.ray[None])[0]
    nm, cmf = colour_matching()
    assert len(got) == 401
    widths = np.r_[0.5, np.ones(399), 0.5]
    at_nodes = np.stack([np.interp(np.arange(380.0, 781.0), nm, f) for f in cmf.T], axis=1)
    # Worst 1.7e-5: the spectrum's slope within a nanometre.
    np.testing.assert_allclose(
        (got * widths) @ at_nodes, radiance_along(resolve(scene), pixel.ray[None])[0], rtol=5e-5
    )
