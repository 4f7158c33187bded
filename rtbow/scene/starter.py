"""Writes a scene to begin with: a bow around the camera, each key with a comment."""

from __future__ import annotations

import numpy as np

from rtbow.physics.drop.fall import rain_rate_mm_h
from rtbow.scene.text.schema import toml_text
from rtbow.scene.text.sun import SunAt

RAIN_MM_H = 5.0
"""Moderate rain."""
_DRIZZLE_MM_H = 1.0
"""Rain of less than this is written as drizzle, whose drops are much alike."""
_DRIZZLE_UM = 150.0

_SUN_VIEW = """\
[camera]
look = "bow-top"                   # or "antisolar", "sun", [azimuth, altitude]; it follows the sun
fov_deg = 95.0                     # horizontal; the primary bow is 84 degrees across
size_px = [1280, 720]
"""
_LAMP_VIEW = """\
[camera]
position_m = [0.0, 7.0, 1.6]       # east, north, up: 7 m north of the lamp
look = "bow-top"                   # or "lamp", "antisolar" (away from it), [azimuth, altitude]
fov_deg = 100.0                    # horizontal
size_px = [1280, 720]
"""
_LOW_SUN = """\
[[light]]
type = "sun"
altitude_deg = 15.0                # the lower the sun, the higher the bow; above 42 there is none
azimuth_deg = 260.0                # clockwise from north
"""
_MIXTURE = """\
[droplets.radius]
distribution = "marshall-palmer"   # the sizes of steady rain, all of them everywhere
min_um = 100.0
max_um = 2500.0
mixing = "local"

[droplets.density]
rain_rate_mm_h = {rate}
"""
_DRIZZLE = """\
[droplets.radius]
distribution = "constant"          # drizzle: small drops, a broad and pale bow
radius_um = {radius}

[droplets.density]
number_per_m3 = {number}           # which is {rate} mm/h
"""
_AIR = """\
[atmosphere]
rayleigh = true                    # air takes blue light away: distant rain and low suns redden
"""


def starter_text(rain_mm_h: float, sun: SunAt | None, lamp: str | None) -> str:
    """Write a scene as TOML with comments.

    Args:
        rain_mm_h: rain rate, greater than 0.
        sun: where and when the sun is seen; None for one that stands low in the west.
        lamp: spectrum of a lamp behind the camera, instead of the sun: a name, or a path relative
            to the scene's file. None for the sun.
    """
    if lamp is not None:
        title = f"A lamp's bow in rain of {rain_mm_h:g} mm/h around the camera."
        parts = [_LAMP_VIEW, _lamp(lamp), _droplets((60.0, 30.0))]
    else:
        when = f", the sun of {sun.time:%Y-%m-%d %H:%M}" if sun is not None else ""
        title = f"A bow in rain of {rain_mm_h:g} mm/h around the camera{when}."
        light = _LOW_SUN if sun is None else _sun(sun)
        parts = [_SUN_VIEW, light, _droplets((1500.0, 1000.0))]
    return "\n".join([f"# {title}", *parts, _drops(rain_mm_h), _AIR])


def _sun(sun: SunAt) -> str:
    return f"""\
[[light]]
type = "sun"                       # where it stands at this time, seen from this place
time = {sun.time.isoformat()}
latitude_deg = {sun.latitude_deg}
longitude_deg = {sun.longitude_deg}
"""


def _lamp(spectrum: str) -> str:
    return f"""\
[[light]]
type = "point"                     # a street lamp behind the camera
position_m = [0.0, 0.0, 6.0]       # east, north, up
spectrum = {toml_text(spectrum)}
luminous_flux_lm = 8000.0
diameter_m = 0.3
"""


def _droplets(around_m: tuple[float, float]) -> str:
    return f"""\
[droplets]
around_m = {toml_text(around_m)}       # rain so far to each side of the camera, and so high
extinction = true                  # rain dims what lies behind it
"""


def _drops(rain_mm_h: float) -> str:
    if rain_mm_h >= _DRIZZLE_MM_H:
        return _MIXTURE.format(rate=rain_mm_h)
    one = rain_rate_mm_h(np.array([1e-6 * _DRIZZLE_UM]), np.array([1.0]))
    return _DRIZZLE.format(
        radius=_DRIZZLE_UM, number=float(f"{rain_mm_h / one:.3g}"), rate=f"{rain_mm_h:g}"
    )
