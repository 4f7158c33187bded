"""Where the sun and the Moon stand in the sky of a place: by date and time, and along a day.

Astronomy is PyEphem's, the libastro of XEphem (VSOP87 and nutation in C, no files, no network, no
other packages; MIT licence). Worst error of the direction without refraction, over 3000 random
times and places each, against the IAU's own routines (ERFA: Earth's place by ``epv00``, precession
and nutation of 2006/2000A): 0.0006 degrees in 1900-2050, 0.002 in 2050-2100, for times in UT1. A
clock shows UTC, which keeps within 0.9 s of UT1: 0.004 degrees more at most.

Refraction is that of the Almanac for Computers, by pressure and temperature at the eye, good to 0.2
arcminutes (0.003 degrees) in its even air. Real air differs from it by as much at 10 degrees above
the horizon, and by several tenths of a degree at the horizon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta
from typing import cast

import ephem

from rtbow.base.errors import InputError
from rtbow.physics.constants import MOON_RADIUS_KM, SEA_LEVEL_HPA

YEARS = (1900, 2100)
"""Between these the error above holds."""
SEA_LEVEL_C = 15.0

_LEAST_REFRACTED_DEG = -1.0
"""True altitude below which no refraction is added: at sunrise the sun stands higher."""
_HORIZON = "-0:34"
"""Degrees and minutes: refraction at the horizon by which almanacs compute sunrise and sunset."""
_SUNRISE_DEG = -0.83
"""True altitude of the sun's centre at sunrise: refraction and half of the disc's 32 arcminutes."""
_HIGHEST_M = 9000.0
_LOWEST_M = -500.0


@dataclass(frozen=True)
class SunPosition:
    """The direction in which the sun's centre is seen.

    Attributes:
        time: in UTC.
        altitude_deg: above the horizon, refraction included.
        azimuth_deg: clockwise from north, 0 to 360.
    """

    time: datetime
    altitude_deg: float
    azimuth_deg: float


def sun_position(
    when: datetime,
    latitude_deg: float,
    longitude_deg: float,
    *,
    elevation_m: float = 0.0,
    pressure_hpa: float | None = None,
    temperature_c: float = SEA_LEVEL_C,
) -> SunPosition:
    """Give the direction in which the sun is seen.

    Args:
        when: date and time with its offset from UTC, in the years 1900 to 2100.
        latitude_deg: geodetic, north is positive.
        longitude_deg: east is positive.
        elevation_m: of the eye above sea level; it sets the pressure where that is left out.
        pressure_hpa: of the air at the eye, 0 for no refraction; None is the standard atmosphere's.
        temperature_c: of the air at the eye.

    Returns:
        Altitude and azimuth. A sun more than a degree below the horizon is given without
        refraction, since nobody sees it.

    Raises:
        InputError: a time without offset, or a value out of range.
    """
    _check_moment(when, latitude_deg, longitude_deg)
    _check_range("elevation_m", elevation_m, _LOWEST_M, _HIGHEST_M)
    if pressure_hpa is None:
        pressure_hpa = standard_pressure_hpa(elevation_m)
    _check_range("pressure_hpa", pressure_hpa, 0.0, 1200.0)
    _check_range("temperature_c", temperature_c, -90.0, 60.0)
    return _position(when, latitude_deg, longitude_deg, pressure_hpa, temperature_c)


@dataclass(frozen=True)
class MoonPosition:
    """The direction in which the Moon's centre is seen, and how it is lit.

    Attributes:
        altitude_deg: above the horizon, parallax and refraction included.
        azimuth_deg: clockwise from north, 0 to 360.
        phase_deg: angle at the Moon between sun and eye: 0 is full, 180 new.
        distance_km: from the place.
    """

    altitude_deg: float
    azimuth_deg: float
    phase_deg: float
    distance_km: float


def moon_position(when: datetime, latitude_deg: float, longitude_deg: float) -> MoonPosition:
    """Give the direction in which the Moon is seen from sea level; see :func:`sun_position`."""
    _check_moment(when, latitude_deg, longitude_deg)
    moon = _seen(ephem.Moon(), when, latitude_deg, longitude_deg, SEA_LEVEL_HPA, SEA_LEVEL_C)
    # PyEphem's phase is the lit share of the disc in per cent.
    phase = math.degrees(math.acos(min(max(2.0 * moon.phase / 100.0 - 1.0, -1.0), 1.0)))
    radius = math.radians(0.5 * moon.size / 3600.0)  # arcseconds, as seen from the place
    return MoonPosition(
        math.degrees(moon.alt),
        math.degrees(moon.az) % 360.0,
        phase,
        MOON_RADIUS_KM / math.sin(radius),
    )


def sun_path(
    latitude_deg: float, longitude_deg: float, day: date, count: int
) -> tuple[SunPosition, ...]:
    """Give the sun's way over the sky of a place from sunrise to sunset, at even intervals of time.

    A sun that does not rise on that day since it has not set (polar day) has its way from the
    midnight before, one that does not set until the midnight after: the times when it is lowest.

    Sunrise and sunset are those of almanacs: the disc's upper edge on a flat horizon at sea level,
    under 34 arcminutes of refraction; the centre is then a quarter of a degree below it. The day is
    that of mean solar time at the longitude, which needs no time zone.

    Args:
        latitude_deg: geodetic, north is positive.
        longitude_deg: east is positive.
        day: the date, in the years 1900 to 2100.
        count: of positions, 1 or more; 1 is the first alone.

    Raises:
        InputError: the sun stays below the horizon there on that day, or a value out of range.
    """
    if count < 1:
        raise InputError(f"count = {count}; must be 1 or more")
    start, end = daylight(latitude_deg, longitude_deg, day).hours
    return tuple(_position(when, latitude_deg, longitude_deg) for when in _even(start, end, count))


def sun_between(
    latitude_deg: float, longitude_deg: float, start: datetime, end: datetime, count: int
) -> tuple[SunPosition, ...]:
    """Give the sun's way over the sky of a place between two times, at even intervals.

    Args:
        latitude_deg: geodetic, north is positive.
        longitude_deg: east is positive.
        start: the first time, with its offset from UTC, in the years 1900 to 2100.
        end: the last one, likewise.
        count: of positions, 1 or more; 1 is the first alone.

    Raises:
        InputError: a time without offset, or a value out of range.
    """
    if count < 1:
        raise InputError(f"count = {count}; must be 1 or more")
    for when in (start, end):
        _check_moment(when, latitude_deg, longitude_deg)
    return tuple(_position(when, latitude_deg, longitude_deg) for when in _even(start, end, count))


def _even(start: datetime, end: datetime, count: int) -> list[datetime]:
    return [start + (end - start) * k / max(count - 1, 1) for k in range(count)]


@dataclass(frozen=True)
class Daylight:
    """When the sun is up about the noon of a day.

    Attributes:
        hours: the first and the last time, in UTC.
        rises: whether the first is sunrise; otherwise it is the midnight before.
        sets: whether the last is sunset; otherwise it is the midnight after.
    """

    hours: tuple[datetime, datetime]
    rises: bool
    sets: bool


def daylight(latitude_deg: float, longitude_deg: float, day: date) -> Daylight:
    """Give the times when the sun is up about the noon of a day; see :func:`sun_path`.

    Raises:
        InputError: as :func:`sun_path`.
    """
    _check_place(latitude_deg, longitude_deg)
    _check_year(day.year)
    observer, sun = _observer(latitude_deg, longitude_deg), ephem.Sun()
    observer.horizon = _HORIZON
    observer.date = datetime.combine(day, time()) - timedelta(hours=longitude_deg / 15.0)
    noon = observer.next_transit(sun)
    times, crosses = [], []
    for event, lowest in (
        ("previous_rising", "previous_antitransit"),
        ("next_setting", "next_antitransit"),
    ):
        observer.date = noon
        try:
            when, crossed = getattr(observer, event)(sun), True
        except ephem.AlwaysUpError:
            observer.date = noon
            when, crossed = getattr(observer, lowest)(sun), False
        except ephem.NeverUpError:
            raise _polar_night(latitude_deg, longitude_deg, day, _utc(noon)) from None
        times.append(_utc(when))
        crosses.append(crossed)
    return Daylight((times[0], times[1]), crosses[0], crosses[1])


def sun_hours(latitude_deg: float, longitude_deg: float, day: date) -> tuple[datetime, datetime]:
    """Give the times (UTC) of sunrise and sunset about the noon of a day; see :func:`sun_path`.

    Raises:
        InputError: as :func:`sun_path`, or the sun does not rise or does not set there that day.
    """
    found = daylight(latitude_deg, longitude_deg, day)
    if not (found.rises and found.sets):
        raise InputError(
            f"sun at {latitude_deg:g}, {longitude_deg:g} on {day}: the sun stays above the horizon"
            " (polar day), without sunrise and sunset; choose another date or place"
        )
    return found.hours


def _utc(when: ephem.Date) -> datetime:
    return cast(datetime, when.datetime()).replace(tzinfo=UTC)


def standard_pressure_hpa(elevation_m: float) -> float:
    """Give the pressure at a height above sea level (ICAO standard atmosphere, below 11 km)."""
    return float(SEA_LEVEL_HPA * (1.0 - 2.25577e-5 * elevation_m) ** 5.25588)


def _position(
    when: datetime,
    latitude_deg: float,
    longitude_deg: float,
    pressure_hpa: float = SEA_LEVEL_HPA,
    temperature_c: float = SEA_LEVEL_C,
) -> SunPosition:
    sun = _seen(ephem.Sun(), when, latitude_deg, longitude_deg, pressure_hpa, temperature_c)
    return SunPosition(when.astimezone(UTC), math.degrees(sun.alt), math.degrees(sun.az) % 360.0)


def _seen(
    body: ephem.Body,
    when: datetime,
    latitude_deg: float,
    longitude_deg: float,
    pressure_hpa: float,
    temperature_c: float,
) -> ephem.Body:
    """Compute a body as it is seen from a place, with refraction where it is up."""
    observer = _observer(latitude_deg, longitude_deg)
    observer.temp = temperature_c
    observer.date = when.astimezone(UTC).replace(tzinfo=None)
    body.compute(observer)
    if pressure_hpa and math.degrees(body.alt) >= _LEAST_REFRACTED_DEG:
        observer.pressure = pressure_hpa
        body.compute(observer)
    return body


def _observer(latitude_deg: float, longitude_deg: float) -> ephem.Observer:
    observer = ephem.Observer()
    # Floats are radians to it, text is degrees.
    observer.lat, observer.lon = math.radians(latitude_deg), math.radians(longitude_deg)
    observer.pressure = 0.0
    return observer


def _polar_night(
    latitude_deg: float, longitude_deg: float, day: date, noon: datetime
) -> InputError:
    highest = _position(noon, latitude_deg, longitude_deg, pressure_hpa=0.0)
    return InputError(
        f"sun at {latitude_deg:g}, {longitude_deg:g} on {day}: the sun stays below the horizon"
        f" (polar night): at noon, {noon:%H:%M} UTC, its centre stands at"
        f" {highest.altitude_deg:.2f} degrees, without refraction, and at sunrise it would at"
        f" {_SUNRISE_DEG:g}; choose another date or place"
    )


def _check_moment(when: datetime, latitude_deg: float, longitude_deg: float) -> None:
    _check_place(latitude_deg, longitude_deg)
    _check_year(when.year)
    if when.utcoffset() is None:
        raise InputError(
            f"time {when.isoformat()}: has no offset from UTC; add one, such as +01:00 or Z"
        )


def _check_place(latitude_deg: float, longitude_deg: float) -> None:
    _check_range("latitude", latitude_deg, -90.0, 90.0)
    _check_range("longitude", longitude_deg, -180.0, 180.0)


def _check_year(year: int) -> None:
    low, high = YEARS
    if not low <= year <= high:
        raise InputError(f"year {year}: must be {low}..{high}, where the sun's position is sure")


def _check_range(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:  # NaN too
        raise InputError(f"{name} = {value:g}; must be {low:g}..{high:g} degrees")
