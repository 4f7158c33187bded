"""Pixel statistics on pictures whose answers are known."""

import numpy as np
import pytest

from rtbow.frames import measures
from rtbow.frames.measures import MeasureError, Profile
from rtbow.physics.drop.airy import bow
from rtbow.physics.drop.water import relative_index
from rtbow.physics.geometry import direction
from rtbow.physics.light.colour import rgb_to_xyz, xyz_to_rgb
from rtbow.scene.model import Camera
from rtbow.tables.airy import airy_table
from rtbow.world.camera.resolve import pixel_directions

CAMERA = Camera(altitude_deg=20.0, fov_deg=84.0, size_px=(320, 180))
AXIS = direction(0.0, -20.0)


def rings(*gaussians, base=0.0):
    """A picture of grey Gaussian rings about AXIS: (angle, deviation, height) in degrees."""
    angle = np.degrees(measures.angle_from(CAMERA, AXIS))
    value = base + sum(h * np.exp(-0.5 * ((angle - a) / s) ** 2) for a, s, h in gaussians)
    return np.repeat(np.broadcast_to(value, angle.shape)[..., None], 3, axis=2)


def profile(picture):
    return measures.radial_profile(picture, measures.angle_from(CAMERA, AXIS), 0.25)


def made(angle, luminance):
    """A grey profile."""
    return Profile(angle, np.asarray(luminance)[:, None] * np.array([0.9505, 1.0, 1.089]))


def test_angle_is_that_between_vectors():
    rays = pixel_directions(CAMERA)
    angle = measures.angle_from(CAMERA, AXIS)
    assert np.abs(np.cos(angle) - rays @ AXIS).max() < 1e-12


def test_radius_of_a_ring():
    found = profile(rings((41.6, 0.8, 1.0), (51.3, 1.0, 0.3)))
    assert measures.bow_radius(found, 1) == pytest.approx(41.6, abs=0.02)
    assert measures.bow_radius(found, 2, "green") == pytest.approx(51.3, abs=0.02)


def test_width_of_a_gaussian():
    angle = np.arange(30.0, 50.0, 0.05)
    one = made(angle, np.exp(-0.5 * ((angle - 41.0) / 0.6) ** 2))
    assert measures.full_width(one, 1) == pytest.approx(2.3548 * 0.6, abs=0.01)
    # On a plateau inside, the inner side is measured half-way down to it.
    step = np.where(angle < 41.0, 0.2 + 0.8 * one.luminance, one.luminance)
    assert measures.full_width(made(angle, step), 1) == pytest.approx(2.3548 * 0.6, abs=0.02)


def test_contrast_is_with_the_dark_between_the_bows():
    """Both bows on a floor of 0.05; on their bright sides plateaus of 0.3 and 0.2 that do not
    count."""
    angle = np.arange(30.0, 62.0, 0.05)
    value = 0.05 + np.where(angle < 40.0, 0.3, 0.0) + np.where(angle > 53.5, 0.2, 0.0)
    value += np.exp(-0.5 * ((angle - 41.5) / 0.4) ** 2)
    value += 0.5 * np.exp(-0.5 * ((angle - 52.0) / 0.4) ** 2)
    both = made(angle, value)
    assert measures.contrast(both, 1) == pytest.approx(1.0 / 1.1, abs=2e-3)
    assert measures.contrast(both, 2) == pytest.approx(0.5 / 0.6, abs=2e-3)
    # The secondary's bright end lies half-way down to its plateau, the dark one at half its height.
    bright, dark = (np.sqrt(2.0 * np.log(0.5 / rest)) for rest in (0.35, 0.225))
    assert measures.full_width(both, 2) == pytest.approx(0.4 * (bright + dark), abs=0.02)


def test_red_width_falls_with_the_radius():
    nm = np.array([620.0])
    primary = bow(1, nm * 1e-9, relative_index(nm, 20.0))
    angle = np.arange(33.0, 46.0, 0.05)
    theta = np.pi - np.radians(angle)
    widths = []
    for radius in (300e-6, 500e-6, 700e-6):
        value = airy_table().cross_section(
            primary, primary.strength, np.array([radius]), theta, np.radians(0.2665)
        )[0, 0]
        widths.append(measures.full_width(made(angle, value / value.max()), 1))
    assert widths[0] > widths[1] > widths[2]


@pytest.mark.parametrize("amplitude", [0.0, 0.02, 0.1])
def test_contrast_of_a_sine(amplitude):
    angle = np.arange(30.0, 46.0, 0.1)
    ripple = 1.0 + amplitude * np.sin(2.0 * np.pi * angle / 0.6)
    value = np.where(angle < 41.0, 0.3 * ripple, 0.0) + np.exp(-60.0 * (angle - 41.2) ** 2)
    found, chroma = measures.supernumerary_contrast(made(angle, value))
    # A smooth curve over 1.6 degrees follows some of a ripple of 0.6.
    assert found == pytest.approx(amplitude / np.sqrt(2.0), rel=0.25, abs=0.003)
    assert chroma < 1e-12


def test_chance_is_not_contrast(rng):
    angle = np.arange(30.0, 46.0, 0.1)
    bow = np.exp(-16.0 * (angle - 41.2) ** 2) + np.where(angle < 41.2, 0.3, 0.0)
    shared = 1.0 + 0.02 * np.sin(2.0 * np.pi * angle / 0.5)
    halves = [made(angle, bow * shared * (1.0 + 0.03 * rng.normal(size=angle.size))) for _ in "ab"]
    alone = measures.supernumerary_contrast(halves[0])[0]
    both = measures.supernumerary_contrast(*halves)[0]
    assert both == pytest.approx(0.02 / np.sqrt(2.0), rel=0.5)
    assert alone > 1.5 * both
    assert measures.chance_ripple(*halves) == pytest.approx(0.03 / np.sqrt(2.0), rel=0.4)


def test_maxima_are_counted():
    angle = np.arange(30.0, 46.0, 0.05)
    tops = (40.0, 39.2, 38.6)
    value = np.exp(-8.0 * (angle - 41.0) ** 2) + 0.2
    value += sum(0.1 * np.exp(-40.0 * (angle - t) ** 2) for t in tops)
    value += 0.002 * np.sin(50.0 * angle)  # less than counts
    assert measures.supernumerary_maxima(made(angle, value)) == pytest.approx(tops[::-1], abs=0.1)


def test_chromaticity_and_temperature():
    # CIE 15: D65 has u' = 0.1978, v' = 0.4683 and 6504 K; illuminant A 2856 K.
    d65 = np.array([0.95047, 1.0, 1.08883])
    assert measures.chromaticity(d65) == pytest.approx([0.1978, 0.4683], abs=1e-4)
    assert measures.correlated_temperature_k(d65) == pytest.approx(6504.0, abs=5.0)
    a = np.array([1.09850, 1.0, 0.35585])
    assert measures.correlated_temperature_k(a) == pytest.approx(2856.0, abs=5.0)


def test_chroma_is_none_of_grey_and_grows_with_colour():
    grey = rgb_to_xyz(np.ones((4, 3)))
    assert measures.mean_chroma(grey) == pytest.approx(0.0, abs=1e-9)
    pale, vivid = (rgb_to_xyz(np.array([[1.0, g, g]])) for g in (0.8, 0.2))
    assert 0.0 < measures.mean_chroma(pale) < measures.mean_chroma(vivid)
    assert xyz_to_rgb(grey) == pytest.approx(np.ones((4, 3)))


def test_circle_on_the_sphere():
    phase = np.linspace(-1.2, 1.2, 50)
    axis = direction(10.0, -30.0)
    side = np.cross(axis, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    up = np.cross(side, axis)
    radius = np.radians(41.5)
    points = np.cos(radius) * axis + np.sin(radius) * (
        np.sin(phase)[:, None] * side + np.cos(phase)[:, None] * up
    )
    circle = measures.fit_circle(points)
    assert circle.radius == pytest.approx(41.5, abs=1e-6)
    assert circle.centre == pytest.approx(axis, abs=1e-7)
    assert circle.residual < 1e-6
    bent = points + 0.01 * np.abs(phase)[:, None] * up
    bent /= np.linalg.norm(bent, axis=1, keepdims=True)
    assert measures.fit_circle(bent).residual > 0.01


def test_peakedness_tells_a_mountain_from_a_circle():
    x = np.linspace(-0.8, 0.8, 81)
    circle = np.stack([x, np.sqrt(1.0 - x**2)], axis=1)
    mountain = np.stack([x, -np.sqrt(0.05 + x**2)], axis=1)  # a hyperbola
    assert measures.fit_circle_in_picture(circle).residual < 1e-9
    assert measures.peakedness(circle) == pytest.approx(0.0, abs=1e-9)
    assert measures.peakedness(mountain) > 0.03


def test_ridge_follows_the_edge():
    picture = rings(base=1.0)
    angle = np.degrees(measures.angle_from(CAMERA, AXIS))
    # The steepest rise of the logarithm is at 40 degrees.
    picture *= np.exp(2.0 / (1.0 + np.exp(-(angle - 40.0) / 0.3)))[..., None]
    found = measures.ridge(picture, CAMERA)
    circle = measures.fit_circle(found.directions)
    assert circle.radius == pytest.approx(40.0, abs=0.1)
    assert circle.centre == pytest.approx(AXIS, abs=0.01)


def test_what_is_not_there_is_said():
    with pytest.raises(MeasureError, match="no peak of bow 1"):
        measures.bow_radius(profile(np.zeros((180, 320, 3))), 1)
    with pytest.raises(MeasureError, match="nothing from"):
        made(np.arange(5.0), np.ones(5)).between(30.0, 40.0)
    with pytest.raises(MeasureError, match="edge shows in 0"):
        measures.ridge(np.ones((180, 320, 3)), CAMERA)
