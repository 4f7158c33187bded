"""Physics written out once more, from the textbooks' formulas, sharing no code with rtbow."""

import csv
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import mpmath
import numpy as np
from scipy.integrate import quad
from scipy.special import airy

EARTH_M = 6_371_000.0
H0_M = 7994.0
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
RGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)


@lru_cache
def stationary_ray(index, reflections):
    """b, D and D'' where the turn of the ray is least, by differences alone, to 20 digits."""
    with mpmath.workdps(40):
        m = mpmath.mpf(float(index))

        def turn(b):
            bends = 2 * mpmath.asin(b) - 2 * (reflections + 1) * mpmath.asin(b / m)
            return reflections * mpmath.pi + bends

        b = mpmath.findroot(
            lambda x: mpmath.diff(turn, x), (0.7, 0.99), solver="illinois", tol=1e-36
        )
        return float(b), float(turn(b)), float(mpmath.diff(turn, b, 2))


def cross_section(index, wavelength_m, radius_m, theta, reflections):
    """dC/dOmega of one bow in m² sr⁻¹, by the formula in x, c and the angle past the bow."""
    order = reflections + 1
    b, turn, second = stationary_ray(float(index), reflections)
    x = 2.0 * np.pi * radius_m / wavelength_m
    c = (x * second / 2.0) ** (1.0 / 3.0)
    past = theta - turn if order == 2 else (2.0 * np.pi - turn) - theta
    cos_in, cos_out = np.sqrt(1.0 - b**2), np.sqrt(1.0 - (b / index) ** 2)
    # Fresnel with the indices, not with sines and tangents of the two angles.
    normal = (cos_in - index * cos_out) / (cos_in + index * cos_out)
    in_plane = (index * cos_in - cos_out) / (index * cos_in + cos_out)
    eps2 = sum(((1.0 - r**2) * r ** (order - 1)) ** 2 for r in (normal, in_plane))
    common = x**3 * b / (2.0 * np.pi * abs(np.sin(turn))) * (2.0 * np.pi / c) ** 2
    value = airy(-x * np.asarray(past) / c)[0]
    return eps2 * common * value**2 / (2.0 * (2.0 * np.pi / wavelength_m) ** 2)


def mean_on_sphere(function, theta, radius, rings=120, spokes=512):
    """Average a function of the angle over a uniform disc, ring by ring about its own centre."""
    if radius == 0.0:
        return float(function(np.array([theta]))[0])
    nodes, gauss = np.polynomial.legendre.leggauss(rings)
    away = 0.5 * radius * (nodes + 1.0)
    spoke = (np.arange(spokes) + 0.5) * (2.0 * np.pi / spokes)
    r, phi = away[:, None], spoke[None, :]
    # Position about an axis z, with the disc's centre in the x-z plane; atan2 keeps small angles.
    x = np.sin(theta) * np.cos(r) - np.cos(theta) * np.sin(r) * np.cos(phi)
    y = np.sin(r) * np.sin(phi)
    z = np.cos(theta) * np.cos(r) + np.sin(theta) * np.sin(r) * np.cos(phi)
    angle = np.arctan2(np.hypot(x, y), z)
    weight = (gauss * np.sin(away))[:, None]
    return float((function(angle) * weight).sum() / (weight.sum() * spokes))


def density(height_m):
    """Air density relative to sea level."""
    return np.exp(-height_m / H0_M)


def column_along_ray(height_m, altitude_rad, length_m=None):
    """Integrate the density along a straight ray above a round Earth, in H0.

    Distance is counted from the ray's closest point; without a length the ray leaves the air.
    """
    closest = (EARTH_M + height_m) * np.cos(altitude_rad)
    start = (EARTH_M + height_m) * np.sin(altitude_rad)

    def at(t):
        # Height as a difference of squares, which keeps its digits.
        square = t**2 + (closest - EARTH_M) * (closest + EARTH_M)
        return density(square / (np.hypot(t, closest) + EARTH_M)) / H0_M

    if length_m is not None:
        ends = [start, start + length_m]
    else:
        ends = [start, *([0.0] if start < 0.0 else [])]
        ends += [max(start, 0.0) + s for s in (2e4, 1e5, 3e5, 1e6, 2e6)]
    return sum(quad(at, a, b, epsabs=0.0, epsrel=1e-12, limit=300)[0] for a, b in pairwise(ends))


def rayleigh_depth(wavelength_nm):
    """Vertical depth, equation 30 of Bodhaine et al. 1999 in µm."""
    um = wavelength_nm / 1000.0
    return (
        0.0021520
        * (1.0455996 - 341.29061 * um**-2 - 0.90230850 * um**2)
        / (1.0 + 0.0027059889 * um**-2 - 85.968563 * um**2)
    )


def towards(azimuth_deg, altitude_deg):
    """Unit vector east, north, up."""
    azimuth, altitude = np.radians(azimuth_deg), np.radians(altitude_deg)
    flat = np.cos(altitude)
    return np.array([flat * np.sin(azimuth), flat * np.cos(azimuth), np.sin(altitude)])


def pinhole(camera, vector, view):
    """Where vectors (..., 3) are seen in a view of some width and height; NaN behind the camera."""
    # Turned back by the azimuth about the vertical, then by the altitude about the picture's right.
    a, h = np.radians(camera.azimuth_deg), np.radians(camera.altitude_deg)
    east, north, up = np.moveaxis(np.asarray(vector, dtype=float), -1, 0)
    right = east * np.cos(a) - north * np.sin(a)
    flat = east * np.sin(a) + north * np.cos(a)
    ahead, above = flat * np.cos(h) + up * np.sin(h), up * np.cos(h) - flat * np.sin(h)
    ahead = np.where(ahead > 0.0, ahead, np.nan)
    width, height = camera.size_px
    focal = 0.5 * width / np.tan(np.radians(camera.fov_deg) / 2.0)
    x, y = 0.5 * width + focal * right / ahead, 0.5 * height - focal * above / ahead
    return np.stack([x * view[0] / width, y * view[1] / height], axis=-1)


def panels(low, high, count):
    """Give nodes and weights of Gauss and Legendre's rule on equal panels of eight nodes each."""
    nodes, gauss = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(low, high, count + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1.0 + nodes)).ravel(), (half * gauss).ravel()


def molecular_sky():
    """Places of a sky of molecules and what SASKTRAN2 has there, as dictionaries of numbers."""
    return _sky("molecules.csv")


@lru_cache
def hazy_sky():
    """Places of skies with aerosol and what SASKTRAN2 and a Monte Carlo have there, as dictionaries
    of numbers; NaN where there is none."""
    return _sky("aerosol.csv")


def _sky(name):
    path = Path(__file__).parents[1] / "tables" / "sky" / name
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = csv.DictReader(lines)
    return [{key: float(value or "nan") for key, value in row.items()} for row in rows]
