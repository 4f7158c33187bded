"""Light along single rays through the air, as the reference sums it, and what becomes of all."""

from __future__ import annotations

import numpy as np

from rtbow.physics.constants import EARTH_RADIUS_M
from rtbow.tables.sky.light import Path
from rtbow.tables.sky.transport import gather_ray, ray_end


def direction(altitude_deg, azimuth_deg=0.0):
    """A unit vector whose azimuth counts from the sun's."""
    a, b = np.radians([altitude_deg, azimuth_deg])
    return np.array([np.cos(a) * np.cos(b), np.cos(a) * np.sin(b), np.sin(a)])


def stokes(
    air, field, sun_deg, altitude_deg, azimuth_deg, *,
    height_m=0.0, until_m=np.inf, pieces=300, direct=True,
):  # fmt: skip
    """I, Q and U along a ray (3, W), per irradiance above the air: Q is along the horizontal less
    across it, U at 45 degrees from it towards the zenith.

    Args:
        air: the air and the ground.
        field: what was scattered before.
        sun_deg: the sun's altitude at the eye.
        altitude_deg: of the ray.
        azimuth_deg: of the ray, from the sun's.
        height_m: of the eye.
        until_m: as far as the air's light counts; with an end, that of the ground does not.
        pieces: of the ray.
        direct: with the light that comes from the sun itself.
    """
    waves, ray = air.depth.shape[1], direction(altitude_deg, azimuth_deg)
    level = direction(0.0, azimuth_deg + 90.0)
    upright = np.cross(ray, level)
    both = (level + upright) / np.sqrt(2.0)
    probes = np.array([np.outer(f, f) for f in (level, upright, both)])
    edges = ray_end(height_m, ray[2])[0] * np.linspace(0.0, 1.0, pieces + 1) ** 2
    if until_m < np.inf:
        edges, air = np.minimum(edges, until_m), air._replace(albedo=np.zeros(waves))
    path = Path(height_m, ray, edges, np.zeros(pieces + 1), np.zeros(waves))
    out, through = np.zeros((3, waves)), np.zeros(waves)
    gather_ray(path, direction(sun_deg), air, field, direct, 1.0, probes, out, through)
    return np.array([out[0] + out[1], out[0] - out[1], 2.0 * out[2] - out[0] - out[1]])


def polarisation(light):
    """Degree of polarisation (W,) of I, Q and U (3, W)."""
    return np.hypot(light[1], light[2]) / light[0]


def light_kept(air, field, sun_deg, passed):
    """What goes to a black ground and what leaves at the top, over what comes in (W,).

    Args:
        air: over black ground.
        field: what was scattered before.
        sun_deg: the sun's altitude.
        passed: share of the sun's own light that arrives at the ground (W,).
    """
    waves, sine_of_sun = air.depth.shape[1], np.sin(np.radians(sun_deg))
    zenith = np.radians(90.0 - sun_deg)
    diffuse = [np.interp(zenith, field.zeniths_rad, field.ground[:, w]) for w in range(waves)]
    up, top_m, azimuths = np.zeros(waves), 60_000.0, 12
    x, weight = np.polynomial.legendre.leggauss(24)
    for t, w in zip(0.5 * (x + 1.0), 0.5 * weight, strict=True):
        for azimuth in (np.arange(azimuths) + 0.5) * 180.0 / azimuths:
            altitude = -np.degrees(np.arcsin(t))
            light = stokes(air, field, sun_deg, altitude, azimuth, height_m=top_m, pieces=200)[0]
            up += w * t * light * 2.0 * np.pi / azimuths
    # Through a sphere 1 % wider than the ground's.
    wider = ((EARTH_RADIUS_M + top_m) / EARTH_RADIUS_M) ** 2
    return (sine_of_sun * passed + diffuse + wider * up) / sine_of_sun
