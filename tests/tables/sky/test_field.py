"""The sky of molecules against another program's, a quadrature of its own, and conservation."""

from __future__ import annotations

import numpy as np
import pytest

from rtbow.base.limits import TOP_M
from rtbow.physics.air.rayleigh import rayleigh_depth, sun_column
from rtbow.physics.constants import EARTH_RADIUS_M, SCALE_HEIGHT_M
from rtbow.tables.sky.air import make_air
from rtbow.tables.sky.field import FIELD_NM, field_at, no_field, sky_field
from rtbow.tables.sky.light import Path
from rtbow.tables.sky.transport import gather_ray, ray_end
from textbook import molecular_sky

pytestmark = pytest.mark.slow

WAVES_NM = np.array([400.0, 550.0, 750.0])
DEPTH = rayleigh_depth(WAVES_NM)


def air(albedo, waves_nm=WAVES_NM):
    """Air of molecules over a ground."""
    return make_air(rayleigh_depth(waves_nm), np.full(len(waves_nm), albedo))


@pytest.fixture(scope="module")
def fields():
    """Fields over black and grey ground, solved once."""
    return {albedo: sky_field(air(albedo)) for albedo in (0.0, 0.3)}


def direction(altitude_deg, azimuth_deg=0.0):
    """A unit vector whose azimuth counts from the sun's."""
    a, b = np.radians([altitude_deg, azimuth_deg])
    return np.array([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)])


def seen(field, albedo, sun, ray, probes, height=0.0, pieces=200):
    """What probes (K, 3, 3) get along a ray, (W, K)."""
    edges = ray_end(height, ray[2])[0] * np.linspace(0.0, 1.0, pieces + 1) ** 2
    waves = len(DEPTH)
    path = Path(height, ray, edges, np.zeros(pieces + 1), np.zeros(waves))
    out, through = np.zeros((len(probes), waves)), np.zeros(waves)
    gather_ray(path, sun, air(albedo), field, True, 1.0, probes, out, through)
    return out.T


def sky(field, albedo, sun, ray, **more):
    """Radiance (W,) per irradiance, and the degree of polarisation (W,)."""
    level = np.cross(ray, [0.0, 0.0, 1.0])
    level = direction(0.0, 90.0) if np.allclose(level, 0.0) else level / np.linalg.norm(level)
    upright = np.cross(level, ray)
    both = (level + upright) / np.sqrt(2.0)
    probes = np.array([np.outer(f, f) for f in (level, upright, both)])
    out = seen(field, albedo, sun, ray, probes, **more)
    total = out[:, 0] + out[:, 1]
    q, u = out[:, 0] - out[:, 1], 2.0 * out[:, 2] - total
    return total, np.hypot(q, u) / total


@pytest.fixture(scope="module")
def compared(fields):
    """Each published place: sun and elevation, and deviations of all, of one scattering, of
    polarisation."""
    none, known, found = no_field(len(WAVES_NM)), {}, []
    for row in molecular_sky():
        sun, albedo = row["sun_altitude_deg"], row["ground_albedo"]
        place = (sun, albedo, row["elevation_deg"], row["azimuth_from_sun_deg"])
        if place not in known:
            towards, ray = direction(sun), direction(*place[2:])
            known[place] = (
                *sky(fields[albedo], albedo, towards, ray),
                sky(none, 0.0, towards, ray)[0],
            )
        w = int(np.argmin(np.abs(WAVES_NM - row["wavelength_nm"])))
        total, polarised, once = (values[w] for values in known[place])
        found.append((
            sun, row["elevation_deg"], total / row["radiance_per_sr"] - 1.0,
            once / row["single_scattering_per_sr"] - 1.0,
            polarised - row["degree_of_polarisation"],
        ))  # fmt: skip
    return np.array(found)


def test_the_published_sky(compared):
    """SASKTRAN2's own error is 1 %: its orders beyond the first go through flat layers, and are a
    few per cent brighter for it. With such layers this field comes within 0.1 % of it."""
    far = (compared[:, 0] >= 10.0) & (compared[:, 1] >= 3.0)
    deviation = compared[far, 2]
    assert np.sqrt(np.mean(deviation**2)) < 0.01
    assert np.abs(deviation).max() < 0.03


def test_the_published_sky_at_the_horizon(compared):
    deviation = compared[(compared[:, 0] >= 10.0) & (compared[:, 1] < 3.0), 2]
    assert np.sqrt(np.mean(deviation**2)) < 0.02
    assert np.abs(deviation).max() < 0.06


def test_the_published_sky_of_a_low_sun(compared):
    """From 8 degrees up. Below, its source is that of the sun's altitude at the eye, but rays of
    hundreds of kilometres see the sun 1 degree higher or lower: 7 % at 400 nm."""
    deviation = compared[(compared[:, 0] < 10.0) & (compared[:, 1] >= 8.0), 2]
    assert np.sqrt(np.mean(deviation**2)) < 0.02
    assert np.abs(deviation).max() < 0.06


def test_the_published_polarisation(compared):
    assert np.abs(compared[:, 4]).max() < 0.02


def test_one_scattering_is_the_published_one(compared):
    high = compared[:, 0] >= 10.0
    assert np.abs(compared[high, 3]).max() < 2e-3


@pytest.mark.parametrize(("sun", "elevation", "azimuth", "height"), [
    (40.0, 42.0, 60.0, 0.0), (10.0, 3.0, 180.0, 0.0), (3.0, 1.0, 120.0, 0.0),
    (0.0, 10.0, 30.0, 0.0), (-3.0, 12.0, 20.0, 0.0), (10.0, -1.0, 90.0, 10_000.0),
])  # fmt: skip
def test_one_scattering_is_its_quadrature(sun, elevation, azimuth, height):
    """By Gauss's rule over the ray, in parts, with columns by another quadrature."""
    towards, ray = direction(sun), direction(elevation, azimuth)
    end, _ = ray_end(height, ray[2])
    x, weight = np.polynomial.legendre.leggauss(40)
    edges = end * np.linspace(0.0, 1.0, 81) ** 2
    half = 0.5 * np.diff(edges)
    s = (0.5 * (edges[1:] + edges[:-1])[:, None] + half[:, None] * x).ravel()
    ds = (half[:, None] * weight).ravel()
    places = np.array([0.0, 0.0, EARTH_RADIUS_M + height]) + s[:, None] * ray
    radius = np.linalg.norm(places, axis=1)
    level = np.maximum(radius - EARTH_RADIUS_M, 0.0)
    column = sun_column(level, np.arcsin(np.clip(places @ towards / radius, -1.0, 1.0)))
    density = np.exp(-level / SCALE_HEIGHT_M) / SCALE_HEIGHT_M
    # Of the way to the eye: what lies before each place.
    before = np.cumsum(density * ds) - 0.5 * density * ds
    cosine = ray @ towards
    phase = 3.0 / (16.0 * np.pi) * (1.0 + cosine**2)
    with np.errstate(over="ignore"):
        passed = np.exp(-DEPTH[:, None] * (column + before))
    expected = phase * DEPTH * (passed @ (density * ds))
    once = sky(no_field(len(DEPTH)), 0.0, towards, ray, height=height, pieces=400)[0]
    np.testing.assert_allclose(once, expected, rtol=2e-3 if sun < 0.0 else 1e-3)


@pytest.mark.parametrize("altitude", [90.0, 40.0, 20.0])
def test_no_light_is_lost(fields, altitude):
    """Black ground and air that absorbs nothing: what comes in goes to the ground or out."""
    field, towards = fields[0.0], direction(altitude)
    down = towards[2] * np.exp(-DEPTH * float(sun_column(0.0, np.radians(altitude))))
    zenith = np.radians(90.0 - altitude)
    diffuse = [np.interp(zenith, field.zeniths_rad, field.ground[:, w]) for w in range(len(DEPTH))]
    up = np.zeros(len(DEPTH))
    x, weight = np.polynomial.legendre.leggauss(24)
    top = 60_000.0
    for t, w in zip(0.5 * (x + 1.0), 0.5 * weight, strict=True):
        for azimuth in (np.arange(12) + 0.5) * 15.0:
            ray = direction(-np.degrees(np.arcsin(t)), azimuth)
            light = sky(field, 0.0, towards, ray, height=top)[0]
            up += w * t * light * 2.0 * np.pi / 12.0
    # Through a sphere 1 % wider than the ground's.
    wider = ((EARTH_RADIUS_M + top) / EARTH_RADIUS_M) ** 2
    total = (down + diffuse + wider * up) / towards[2]
    np.testing.assert_allclose(total, 1.0, atol=0.01)


def test_a_sun_in_the_zenith_is_no_other_than_one_beside_it(fields):
    up, beside = (sky(fields[0.3], 0.3, direction(sun), direction(90.0)) for sun in (90.0, 89.9))
    np.testing.assert_allclose(up[0], beside[0], rtol=1e-3)


def test_rays_end_at_the_ground_or_where_air_does():
    assert ray_end(0.0, 1.0) == (pytest.approx(TOP_M), False)
    assert ray_end(2.0, -1.0) == (pytest.approx(2.0), True)
    distance, ground = ray_end(2.0, -1e-4)
    assert not ground  # 0.045 degrees: the horizon of 2 m is lower
    assert distance > 1e6


def test_fields_between_wavelengths():
    between = np.array([392.0, 467.0, 642.0])
    solved = sky_field(air(0.3, between))
    found = field_at(sky_field(air(0.3, FIELD_NM)), between)
    level = solved.mean.max(axis=(0, 1, 2), keepdims=True)
    assert (np.abs(found.mean - solved.mean) / level).max() < 1e-3
