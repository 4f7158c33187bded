"""A polarising filter before the lens, against Malus' law and exact theory."""

import numpy as np
import pytest

import rtbow
from glsl_probe import probe
from rtbow.base.limits import NO_PLANE
from rtbow.physics.drop.mie import intensities
from rtbow.physics.drop.water import relative_index
from rtbow.physics.geometry import direction
from rtbow.physics.light.disc import disc_nodes
from rtbow.physics.light.spectrum import colour_weights, wavelength_bins
from rtbow.scene.model import Camera, Scene
from rtbow.world.camera.resolve import view_of
from rtbow.world.measured.spectra import load_spectrum

RADIUS_UM = 120.0
STEP_NM = 40.0
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def make(polarizer_deg, theta_deg=139.5, tilt_deg=0.0, **changes):
    """A few pixels about a scattering angle; ``tilt_deg`` turns the scattering plane.

    The sun stands in the south at the horizon; the camera looks at the sky so that the line from
    the antisolar point makes the angle ``tilt_deg`` with the vertical.
    """
    away = np.radians(180.0 - theta_deg)
    tilt = np.radians(tilt_deg)
    ray = np.array([np.sin(away) * np.sin(tilt), np.cos(away), np.sin(away) * np.cos(tilt)])
    camera = {
        "azimuth_deg": float(np.degrees(np.arctan2(ray[0], ray[1]))),
        "altitude_deg": float(np.degrees(np.arcsin(ray[2]))),
        "fov_deg": 0.3,
        "size_px": [3, 3],
    }
    if polarizer_deg is not None:
        camera["polarizer_deg"] = polarizer_deg
    parts = {
        "camera": camera,
        "light": [{"altitude_deg": 0.0, "azimuth_deg": 180.0}],
        "droplets": {
            "box_m": [[-1e5, 1.0, -1e5], [1e5, 100.0, 1e5]],
            "radius": {"distribution": "constant", "radius_um": RADIUS_UM},
            "density": {"number_per_m3": 1000.0},
        },
        "scattering": {"theory": "mie"},
        "render": {"wavelength_step_nm": STEP_NM},
    }
    return Scene.model_validate(parts | changes)


def luminance(scene, method="spectral"):
    with rtbow.Renderer(scene, "egl") as renderer:
        return float(renderer.render(method).astype(np.float64)[1, 1] @ LUMINANCE)


def exact_components(theta_deg):
    """Luminance of both components per drop, summed over sizes and the disc at each wavelength."""
    bins = wavelength_bins(STEP_NM)
    weights = colour_weights(load_spectrum("E490"), bins)[:, 1]
    index = relative_index(bins.wavelength_nm, 20.0)
    theta, shares = disc_nodes(np.radians(theta_deg), np.radians(0.2665), 24)
    total = np.zeros(2)
    spread = np.linspace(-3.5, 3.5, 161)
    share = np.exp(-0.5 * spread**2)
    for nm, m, weight in zip(bins.wavelength_nm, index, weights, strict=True):
        x = 2.0 * np.pi * RADIUS_UM * 1e3 / nm * np.exp(0.02 * spread)
        # Whole amplitudes; ripple between orders is left to the mean over sizes and the disc.
        means = [intensities(size, m, theta, False) @ shares / size**2 for size in x]
        total += weight * (share @ np.array(means)) / share.sum()
    return total


@pytest.mark.slow
@pytest.mark.parametrize("method", ["spectral", "reference"])
def test_degree_of_polarisation_of_the_primary(method):
    """Perpendicular to the vertical scattering plane is horizontal: 0 degrees."""
    passed = [luminance(make(angle), method) for angle in (0.0, 90.0)]
    perpendicular, parallel = exact_components(139.5)
    found = (passed[0] - passed[1]) / (passed[0] + passed[1])
    exact = (perpendicular - parallel) / (perpendicular + parallel)
    assert exact > 0.7  # rainbows are strongly polarised
    assert found == pytest.approx(exact, abs=0.01)


@pytest.mark.parametrize("theory", ["airy", "mie"])
def test_malus(theory):
    whole = luminance(make(None, scattering={"theory": theory}))
    at = {a: luminance(make(a, scattering={"theory": theory})) for a in (0.0, 30.0, 45.0, 90.0)}
    # In the middle of the picture two crossed filters pass all there is between them.
    assert at[0.0] + at[90.0] == pytest.approx(whole, rel=1e-5)
    assert at[45.0] == pytest.approx(0.5 * whole, rel=1e-5)
    expected = at[0.0] * np.cos(np.pi / 6) ** 2 + at[90.0] * np.sin(np.pi / 6) ** 2
    assert at[30.0] == pytest.approx(expected, rel=1e-5)


def test_the_filter_follows_the_bow_round():
    """Left and right of the top the perpendicular field leans: it lies along the bow."""
    # Seen to the upper right, 60 degrees from the top, the bow runs down to the right: the angle
    # in the picture follows from the directions themselves.
    scene = make(None, tilt_deg=60.0)
    angles = np.arange(0.0, 180.0, 7.5)
    passed = [luminance(make(float(a), tilt_deg=60.0)) for a in angles]
    best = angles[int(np.argmax(passed))]
    camera = scene.camera
    a, h = np.radians(camera.azimuth_deg), np.radians(camera.altitude_deg)
    ray = np.array([np.sin(a) * np.cos(h), np.cos(a) * np.cos(h), np.sin(h)])
    right = np.array([np.cos(a), -np.sin(a), 0.0])
    up = np.cross(right, ray)
    across = np.cross(np.array([0.0, -1.0, 0.0]), ray)
    expected = np.degrees(np.arctan2(across @ up, across @ right)) % 180.0
    assert abs((best - expected + 90.0) % 180.0 - 90.0) < 4.0
    # It leans to the right, and neither horizontal nor vertical passes most.
    assert 100.0 < expected < 170.0


def turned(camera, towards):
    """Angle of a direction in the picture, counterclockwise from the right as the eye sees it."""
    a, h = np.radians(camera.azimuth_deg), np.radians(camera.altitude_deg)
    east, north, up = towards
    # Turned back by the azimuth about the vertical, then by the altitude about the right.
    right = east * np.cos(a) - north * np.sin(a)
    flat = east * np.sin(a) + north * np.cos(a)
    return np.arctan2(up * np.cos(h) - flat * np.sin(h), right)


@pytest.mark.parametrize("polarizer_deg", [0.0, 25.0, 90.0, 140.0])
def test_share_of_the_perpendicular_field(rng, polarizer_deg):
    """In the middle of the picture: Malus' law of the angles in the picture alone."""
    for azimuth, altitude in ((0.0, 0.0), (70.0, 35.0), (200.0, -50.0)):
        camera = Camera(azimuth_deg=azimuth, altitude_deg=altitude, polarizer_deg=polarizer_deg)
        ray = direction(azimuth, altitude)
        for light in rng.normal(size=(20, 3)):
            # The plane of light and ray is seen as a line; the field across it stands on that.
            across = turned(camera, light) + 0.5 * np.pi
            expected = np.cos(across - np.radians(polarizer_deg)) ** 2
            got = view_of(camera).perpendicular_share(7.0 * light, ray[None])[0]
            assert got == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("polarizer_deg", [0.0, 30.0])
def test_share_near_the_line_through_the_light(gl, polarizer_deg):
    """Minutes of arc beside it the plane counts in full, within a second of arc not at all.

    Between them by s² / (s² + 1e-9), s the sine of the angle. The shader agrees.
    """
    camera = Camera(altitude_deg=0.0, polarizer_deg=polarizer_deg)
    # East of the line: the plane is level, and the field across it upright.
    angles = np.array([1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 1e-3, 3e-3, 1e-2])
    rays = np.stack([np.sin(angles), np.cos(angles), 0.0 * angles], axis=1)
    light = np.array([0.0, -1.0, 0.0])
    in_full = np.sin(np.radians(polarizer_deg)) ** 2
    expected = 0.5 + (in_full - 0.5) * angles**2 / (angles**2 + 1e-9)
    assert abs(expected[0] - 0.5) < 1e-3
    assert abs(expected[-3] - in_full) < 1e-3
    np.testing.assert_allclose(
        view_of(camera).perpendicular_share(light, rays), expected, atol=1e-4
    )
    passing = [np.cos(np.radians(polarizer_deg)), 0.0, np.sin(np.radians(polarizer_deg))]
    lights, filters = (np.broadcast_to(v, rays.shape) for v in (light, passing))
    shader = probe(
        gl, ["common/polarizer.glsl"], "perpendicularShare(light, ray, passing)",
        {"light": lights, "ray": rays, "passing": filters},
        {"POLARIZER": True, "NO_PLANE": NO_PLANE},
    )[:, 0]  # fmt: skip
    np.testing.assert_allclose(shader, expected, atol=1e-4)


def test_fresnels_share_of_the_primary():
    """Airy's primary: two refractions and one reflection inside, near Brewster's angle there."""
    m = 1.3343
    cos_in = np.sqrt((m**2 - 1.0) / 3.0)
    cos_out = np.sqrt(1.0 - (1.0 - cos_in**2) / m**2)
    normal = (cos_in - m * cos_out) / (cos_in + m * cos_out)
    in_plane = (m * cos_in - cos_out) / (m * cos_in + cos_out)
    light = [((1.0 - r**2) * r) ** 2 for r in (normal, in_plane)]
    expected = (light[0] - light[1]) / (light[0] + light[1])
    assert expected == pytest.approx(0.92, abs=0.01)
    changes = {"scattering": {"theory": "airy", "orders": [1]}}
    # Across the vertical plane through the light is level.
    passed = [luminance(make(a, **changes), "reference") for a in (0.0, 90.0)]
    got = (passed[0] - passed[1]) / (passed[0] + passed[1])
    assert got == pytest.approx(expected, abs=2e-3)


def test_a_lamps_light_is_polarised_too():
    lamp = {
        "type": "point", "position_m": [0.0, -1000.0, 1.6], "luminous_flux_lm": 1e6,
        "spectrum": "equal-energy", "diameter_m": 0.1,
    }  # fmt: skip
    for theory in ("airy", "mie"):
        change = {"light": [lamp], "scattering": {"theory": theory}}
        across, along = (luminance(make(a, **change)) for a in (0.0, 90.0))
        whole = luminance(make(None, **change))
        assert across > 3.0 * along
        assert across + along == pytest.approx(whole, rel=1e-4)
