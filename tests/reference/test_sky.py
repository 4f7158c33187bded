"""The world around the drops as a frame has it: sky, ground, the sun, and rain before them."""

from __future__ import annotations

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.physics.geometry import direction
from rtbow.reference.render import radiance_along, spectral_radiance_along
from rtbow.world.world import resolve
from textbook import molecular_sky

pytestmark = pytest.mark.slow

FAR = {"droplets.box_m": [[-10.0, 90_000.0, 0.0], [10.0, 90_010.0, 10.0]]}
"""Drops where nobody looks."""
STEP = {"render.wavelength_step_nm": 40.0}


def along(changes, *angles):
    """X, Y, Z along rays of azimuth and altitude."""
    world = resolve(rtbow.load_scene("uniform", {**STEP, **changes}))
    return radiance_along(world, np.array([direction(*pair) for pair in angles]))


def test_a_ground_without_air_is_lamberts():
    changes = {**FAR, "ground.albedo": 0.3, "light.0.altitude_deg": 30.0}
    found = along(changes, (0.0, -30.0), (90.0, -80.0))
    white = {**FAR, "ground.albedo": 1.0, "light.0.altitude_deg": 90.0}
    lux = np.pi * along(white, (0.0, -30.0))[0]
    np.testing.assert_allclose(found, [0.3 / np.pi * 0.5 * lux] * 2, rtol=2e-4)
    assert lux[1] == pytest.approx(133_000.0, rel=0.05)  # sunlight above the air


def test_the_suns_disc_is_its_irradiance():
    changes = {**FAR, "ground.albedo": 0.0, "light.0.angular_diameter_deg": 1.0}
    on, beside = along(changes, (180.0, 20.4), (180.0, 20.6))
    assert not beside.any()
    solid_angle = np.pi * np.radians(0.5) ** 2
    assert on[1] * solid_angle == pytest.approx(133_000.0, rel=0.05)
    hidden = along({**changes, "light.0.altitude_deg": -0.2}, (180.0, -0.2))
    assert not hidden.any()


SKY = {"atmosphere.rayleigh": True, "atmosphere.sky": True, "light.0.altitude_deg": 20.0}


@pytest.mark.parametrize(("sun", "albedo"), [(40.0, 0.0), (10.0, 0.3)])
def test_the_sky_of_a_scene_is_that_of_another_program(sun, albedo):
    """Through the scene's own wavelengths, weights and pieces: spectral radiance by irradiance."""
    changes = {
        **FAR, **SKY, "ground.albedo": albedo, "light.0.altitude_deg": sun,
        "light.0.spectrum": "equal-energy", "light.0.irradiance_w_m2": 400.0,
        "camera.position_m": [0.0, 0.0, 0.0], "render.wavelength_step_nm": 10.0,
    }  # fmt: skip
    rows = [
        row for row in molecular_sky()
        if (row["sun_altitude_deg"], row["ground_albedo"]) == (sun, albedo)
        and row["elevation_deg"] >= 3.0
    ]  # fmt: skip
    rays = np.array(
        [direction(180.0 + row["azimuth_from_sun_deg"], row["elevation_deg"]) for row in rows]
    )
    world = resolve(rtbow.load_scene("uniform", changes))
    found = spectral_radiance_along(world, rays)  # over 1 W/(m² nm)
    at = [int(np.argmin(np.abs(world.optics.wavelength_nm - row["wavelength_nm"]))) for row in rows]
    deviation = found[np.arange(len(rows)), at] / [row["radiance_per_sr"] for row in rows] - 1.0
    assert np.sqrt(np.mean(deviation**2)) < 0.015
    assert np.abs(deviation).max() < 0.03


def test_rain_dims_what_is_behind_it_and_not_what_is_before():
    """A thin curtain 5 km away: the air before it, and the air behind it as seen through it."""
    ray, distance = (0.0, 26.0), 5_000.0
    far = distance * np.cos(np.radians(26.0))
    high = distance * np.sin(np.radians(26.0))
    box = [[-50.0, far, high - 50.0], [50.0, far + 5.0, high + 50.0]]
    density = 1.0 / (2.0 * np.pi * 500e-6**2 * 5.0 / np.cos(np.radians(26.0)))
    slab = {
        "droplets.box_m": box, "droplets.extinction_efficiency": 2.0,
        "droplets.radius.radius_um": 500.0,
    }  # fmt: skip
    clear = {**SKY, **slab, "droplets.density.number_per_m3": 0.0}
    dimmed = {
        **SKY, **slab, "droplets.density.number_per_m3": density, "droplets.extinction": True
    }  # fmt: skip
    wall = {**clear, "droplets.density.number_per_m3": 1e3 * density, "droplets.extinction": True}
    behind = along(clear, ray) - along(wall, ray)
    assert 0.0 < along(wall, ray)[0, 1] < 0.3 * along(clear, ray)[0, 1]
    expected = along(wall, ray) + np.exp(-1.0) * behind
    np.testing.assert_allclose(along(dimmed, ray), expected, rtol=2e-3)


def test_drops_below_the_ground_are_hidden():
    below = {
        "droplets.box_m": [[-200.0, 50.0, -300.0], [200.0, 400.0, -100.0]], "ground.albedo": 0.0,
    }  # fmt: skip
    assert not along({**below, "light.0.altitude_deg": 5.0}, (0.0, -40.0), (20.0, -38.0)).any()


def test_rain_dims_what_is_behind_it():
    """A slab close to the eye, seen in Alexander's band, where it has no light of its own."""
    slab = {
        "droplets.box_m": [[-50.0, 10.0, 0.0], [50.0, 12.0, 50.0]],
        "droplets.extinction_efficiency": 2.0,
        "droplets.radius.radius_um": 500.0,
    }
    ray = (0.0, 26.0)  # 46 degrees from the antisolar point
    depth = 1.0
    density = depth / (2.0 * np.pi * 500e-6**2 * 2.0 / np.cos(np.radians(26.0)))
    clear = along({**SKY, **slab, "droplets.density.number_per_m3": 0.0}, ray)
    dimmed = along(
        {**SKY, **slab, "droplets.density.number_per_m3": density, "droplets.extinction": True}, ray
    )
    np.testing.assert_allclose(dimmed / clear, np.exp(-depth), rtol=2e-3)


def test_a_polariser_takes_half_of_the_suns_own_surroundings_and_more_across():
    """Towards the sun the sky is unpolarised; at a right angle to it, most of it is across."""
    high = {**FAR, **SKY, "light.0.altitude_deg": 60.0, "camera.azimuth_deg": 180.0}
    towards = along(high, (180.0, 61.0))
    half = along({**high, "camera.polarizer_deg": 0.0}, (180.0, 61.0))
    np.testing.assert_allclose(half / towards, 0.5, atol=0.02)
    level = {**FAR, **SKY, "light.0.altitude_deg": 0.5}
    up = {**level, "camera.azimuth_deg": 180.0, "camera.altitude_deg": 89.9}
    both = [along({**up, "camera.polarizer_deg": angle}, (180.0, 89.9)) for angle in (0.0, 90.0)]
    np.testing.assert_allclose(sum(both), along(up, (180.0, 89.9)), rtol=1e-9)
    assert both[0][0, 1] > 8.0 * both[1][0, 1]


def test_a_sun_that_is_not_visible_still_lights():
    shown = {**FAR, **SKY, "ground.albedo": 0.2}
    hidden = {**shown, "light.0.visible": False}
    np.testing.assert_array_equal(along(hidden, (90.0, 30.0)), along(shown, (90.0, 30.0)))
    assert along(hidden, (180.0, 20.0))[0, 1] < 1e-3 * along(shown, (180.0, 20.0))[0, 1]


def test_haze_dims_the_bow_as_its_column_says():
    """Grey haze, in closed form: a thin box of rain at one height, through flat exponential layers
    of which a high sun's way differs by 1e-3."""
    depth, scale, high, far = 0.3, 1500.0, 1200.0, 3000.0
    ray = (180.0 - 180.0, np.degrees(np.arctan2(high, far)))
    box = {"droplets.box_m": [[-20.0, far, high - 20.0], [20.0, far + 1.0, high + 20.0]]}
    sun = np.degrees(np.arctan2(high, far))  # straight behind: scattering angle of 138 degrees
    changes = {**box, "light.0.altitude_deg": 41.0 - sun, "atmosphere.rayleigh": True}
    grey = {
        "atmosphere.aerosol.model": "custom", "atmosphere.aerosol.optical_depth_550": depth,
        "atmosphere.aerosol.angstrom_exponent": 0.0, "atmosphere.aerosol.scale_height_m": scale,
    }  # fmt: skip
    clear, hazy = along(changes, ray), along({**changes, **grey}, ray)
    above = np.exp(-high / scale) / np.sin(np.radians(41.0 - sun))
    below = (1.0 - np.exp(-high / scale)) / np.sin(np.radians(ray[1]))
    assert clear[0, 1] > 0.0
    np.testing.assert_allclose(hazy / clear, np.exp(-depth * (above + below)), rtol=3e-3)


def test_ozone_takes_what_is_published():
    """300 DU straight above: of light at 600 nm 0.0405 of optical depth (Serdyuchenko et al.)."""
    changes = {
        "light.0.altitude_deg": 41.0, "droplets.box_m": [[-20.0, 300.0, 0.0], [20.0, 301.0, 20.0]],
        "render.wavelength_step_nm": 20.0, "atmosphere.rayleigh": True,
    }  # fmt: skip
    rays = np.array([direction(0.0, 0.5)])

    def spectrum(more):
        world = resolve(rtbow.load_scene("uniform", {**changes, **more}))
        return spectral_radiance_along(world, rays)[0], world.optics.wavelength_nm

    clear, nm = spectrum({})
    dim, _ = spectrum({"atmosphere.ozone_du": 300.0})
    at = int(np.argmin(np.abs(nm - 600.0)))
    depth = -np.log(dim[at] / clear[at]) * np.sin(np.radians(41.0))
    assert depth == pytest.approx(0.0405, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"atmosphere.rayleigh": False, "atmosphere.sky": True}, "needs rayleigh = true"),
        ({"ground.albedo": 1.2}, r"0\.\.1"),
        ({"atmosphere.ozone_du": -1.0}, r"0\.\.1000"),
        ({"atmosphere.rayleigh": False, "atmosphere.ozone_du": 300.0}, "needs rayleigh = true"),
        ({"atmosphere.aerosol.optical_depth_550": -0.1}, r"0\.\.2"),
        ({"atmosphere.aerosol.optical_depth_550": 9.0}, r"0\.\.2"),
        ({"atmosphere.aerosol": {"model": "custom", "single_scattering_albedo": 1.01}}, r"0\.\.1"),
        ({"atmosphere.aerosol": {"model": "custom", "asymmetry": 1.0}}, r"-0\.9\.\.0\.9"),
        ({"atmosphere.aerosol": {"model": "custom", "scale_height_m": 2e5}}, r"100\.\.20000"),
        ({"atmosphere.aerosol": {"model": "maritime-clean", "asymmetry": 0.5}}, "custom"),
        ({"atmosphere.aerosol.model": "desert"}, "continental-clean"),
        ({"ground.albedo": 0.5, "camera.position_m": [0.0, 0.0, -1.0]}, r"0\.\.100000"),
        ({"ground.albedo": 0.5, "camera.position_m": [0.0, 0.0, 2e5]}, r"0\.\.100000"),
    ],
)
def test_what_cannot_be_is_refused(changes, words):
    with pytest.raises(InputError, match=words):
        rtbow.load_scene("uniform", changes)
