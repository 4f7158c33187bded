"""The sun's place against published digits, and its way along a day."""

from __future__ import annotations

import contextlib
import itertools
from datetime import UTC, date, datetime, timedelta, timezone

import numpy as np
import pytest

from rtbow.base.errors import InputError
from rtbow.physics.light.sun_position import (
    daylight,
    standard_pressure_hpa,
    sun_hours,
    sun_path,
    sun_position,
)

GOLDEN = (39.742476, -105.1786)
GOLDEN_AIR = {"elevation_m": 1830.14, "pressure_hpa": 820.0, "temperature_c": 11.0}
GOLDEN_TIME = datetime(2003, 10, 17, 12, 30, 30, tzinfo=timezone(timedelta(hours=-7)))
MUNICH = (48.137, 11.575)
TROMSO = (69.65, 18.96)

# Against NREL's Solar Position Algorithm, whose own uncertainty is 0.0003 degrees.
DIRECTION_DEG = 0.0003
# What formulas of refraction differ by: 0.05 arcminutes at 40 degrees of altitude.
REFRACTED_DEG = 0.001


class TestPublished:
    def test_worked_example_of_nrel(self):
        """Reda and Andreas, NREL/TP-560-34302 (2008), tables A5.1 and after.

        Measured: 0.0000069 degrees in azimuth, 0.0007 in zenith.
        """
        sun = sun_position(GOLDEN_TIME, *GOLDEN, **GOLDEN_AIR)
        assert 90.0 - sun.altitude_deg == pytest.approx(50.11162, abs=REFRACTED_DEG)
        assert sun.azimuth_deg == pytest.approx(194.34024, abs=DIRECTION_DEG)

    def test_worked_example_of_nrel_without_refraction(self):
        """Its e0. Measured: 0.0000029 degrees."""
        sun = sun_position(GOLDEN_TIME, *GOLDEN, **(GOLDEN_AIR | {"pressure_hpa": 0.0}))
        assert sun.altitude_deg == pytest.approx(39.872046, abs=DIRECTION_DEG)

    def test_subsolar_point_of_meeus(self):
        """Astronomical Algorithms, examples 25.b (declination) and 28.a (equation of time).

        The sun is in the zenith where the local apparent time is noon. Measured: 0.0008 degrees.
        """
        declination = -(7.0 + 47.0 / 60.0 + 1.74 / 3600.0)
        equation_of_time_min = 13.70940
        longitude = 180.0 - equation_of_time_min / 4.0
        sun = sun_position(datetime(1992, 10, 13, tzinfo=UTC), declination, longitude)
        assert sun.altitude_deg > 90.0 - 0.001

    def test_sunrise_and_sunset_of_nrel(self):
        """spa_tester.c, October 17, 2003. Its sunset is the UTC day's: that of the evening before.

        Measured: 1 s.
        """
        rise, _ = sun_hours(*GOLDEN, date(2003, 10, 17))
        _, sunset = sun_hours(*GOLDEN, date(2003, 10, 16))
        assert_near(rise, datetime(2003, 10, 17, 6, 12, 43, tzinfo=GOLDEN_TIME.tzinfo), 5.0)
        assert_near(sunset, datetime(2003, 10, 16, 17, 20, 19, tzinfo=GOLDEN_TIME.tzinfo), 5.0)

    def test_sunrise_and_sunset_of_the_naval_observatory(self):
        """Atlanta, September 6, 2009, as its page showed them, in whole minutes."""
        eastern = timezone(timedelta(hours=-4))
        rise, sunset = sun_hours(33.8, -84.4, date(2009, 9, 6))
        assert_near(rise, datetime(2009, 9, 6, 7, 15, tzinfo=eastern), 31.0)
        assert_near(sunset, datetime(2009, 9, 6, 19, 56, tzinfo=eastern), 31.0)

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("apparent_deg", "arcmin"),
        [(0, 34.5), (2, 18.3), (5, 9.9), (10, 5.3), (20, 2.6), (30, 1.7), (45, 1.0), (60, 0.6)],
    )
    def test_refraction_of_the_nautical_almanac(self, apparent_deg, arcmin):
        """Its altitude corrections, 10 °C, 1010 hPa. Measured: 0.4' at the horizon, 0.2' above."""
        start = datetime(2024, 3, 20, 4, tzinfo=UTC)  # the sun goes up straight, at the equator
        hours = np.linspace(0.8, 8.0, 20_000)
        times = [start + timedelta(hours=hour) for hour in hours]
        air = {"pressure_hpa": 1010.0, "temperature_c": 10.0}
        at = int(np.searchsorted([sun_position(t, 0, 11, **air).altitude_deg for t in times],
                                 apparent_deg))  # fmt: skip
        seen, true = (sun_position(times[at], 0, 11, **one) for one in (air, {"pressure_hpa": 0.0}))
        assert 60.0 * (seen.altitude_deg - true.altitude_deg) == pytest.approx(arcmin, abs=0.5)


def assert_near(one: datetime, other: datetime, seconds: float) -> None:
    assert abs((one - other).total_seconds()) <= seconds, (one, other)


class TestDirections:
    """Signs that a swap would flip."""

    def test_the_sun_goes_from_east_over_south_to_west(self):
        morning, noon, evening = sun_path(*MUNICH, date(2024, 3, 20), 3)
        assert morning.azimuth_deg == pytest.approx(90.0, abs=2.0)
        assert noon.azimuth_deg == pytest.approx(180.0, abs=1.0)
        assert evening.azimuth_deg == pytest.approx(270.0, abs=2.0)
        assert noon.altitude_deg == pytest.approx(90.0 - MUNICH[0], abs=0.5)

    def test_south_of_the_tropics_over_north(self):
        noon = sun_path(-33.87, 151.21, date(2024, 6, 21), 3)[1]
        assert min(noon.azimuth_deg, 360.0 - noon.azimuth_deg) < 1.0
        assert noon.altitude_deg == pytest.approx(90.0 - 33.87 - 23.44, abs=0.1)

    def test_east_is_earlier(self):
        east, west = (
            sun_hours(48.0, longitude, date(2024, 6, 1))[0] for longitude in (15.0, -15.0)
        )
        assert_near(east + timedelta(hours=2), west, 30.0)

    def test_one_moment_in_any_offset(self):
        other = GOLDEN_TIME.astimezone(timezone(timedelta(hours=5, minutes=30)))
        assert sun_position(other, *GOLDEN) == sun_position(GOLDEN_TIME, *GOLDEN)
        assert sun_position(GOLDEN_TIME, *GOLDEN).time == datetime(
            2003, 10, 17, 19, 30, 30, tzinfo=UTC
        )

    def test_parts_of_a_second_count(self):
        later = GOLDEN_TIME + timedelta(milliseconds=500)
        moved = (
            sun_position(later, *GOLDEN).azimuth_deg
            - sun_position(GOLDEN_TIME, *GOLDEN).azimuth_deg
        )
        assert moved == pytest.approx(0.5 * 15.0 / 3600.0, rel=0.5)

    def test_thin_air_refracts_less(self):
        assert standard_pressure_hpa(0.0) == 1013.25
        # U.S. Standard Atmosphere 1976: 701.2 hPa at 3 km.
        assert standard_pressure_hpa(3000.0) == pytest.approx(701.1, abs=0.3)
        low, high = (sun_position(GOLDEN_TIME, *GOLDEN, elevation_m=h) for h in (0.0, 3000.0))
        assert low.altitude_deg - high.altitude_deg == pytest.approx(0.3 * 1.15 / 60.0, rel=0.2)

    def test_no_refraction_of_a_sun_that_nobody_sees(self):
        dawn = datetime(2024, 3, 20, 5, 8, tzinfo=UTC)
        seen, true = (sun_position(dawn, 0.0, 11.0, **air) for air in ({}, {"pressure_hpa": 0.0}))
        assert -4.0 < true.altitude_deg < -2.0
        assert seen == true


class TestPath:
    def test_even_times_from_sunrise_to_sunset(self):
        path = sun_path(*MUNICH, date(2024, 12, 21), 9)
        rise, sunset = sun_hours(*MUNICH, date(2024, 12, 21))
        assert (path[0].time, path[-1].time) == (rise, sunset)
        steps = {later.time - sooner.time for sooner, later in itertools.pairwise(path)}
        assert max(steps) - min(steps) <= timedelta(microseconds=2)

    def test_the_upper_edge_is_on_the_horizon_at_both_ends(self):
        """The centre is the sun's radius below it, where the air's refraction is the almanac's."""
        for one in (path := sun_path(*MUNICH, date(2024, 7, 1), 5))[0], path[-1]:
            assert one.altitude_deg == pytest.approx(-16.0 / 60.0, abs=0.05)
        assert min(one.altitude_deg for one in path[1:-1]) > 5.0

    def test_the_first_and_the_last_day(self):
        """In UTC they begin the day before or end the day after."""
        for longitude in (-180.0, 180.0):
            for day in (date(1900, 1, 1), date(2100, 12, 31)):
                assert len(sun_path(10.0, longitude, day, 2)) == 2

    def test_one_is_sunrise(self):
        assert sun_path(*MUNICH, date(2024, 7, 1), 1) == sun_path(*MUNICH, date(2024, 7, 1), 7)[:1]

    @pytest.mark.parametrize("longitude", [-179.9, -90.0, 0.0, 90.0, 179.9])
    def test_noon_is_that_of_the_date_at_the_longitude(self, longitude):
        noon = sun_path(10.0, longitude, date(2024, 2, 29), 3)[1].time
        mean_solar = noon + timedelta(hours=longitude / 15.0)
        assert mean_solar.date() == date(2024, 2, 29)
        assert mean_solar.hour in (11, 12)

    @pytest.mark.parametrize(
        ("place", "day", "what"),
        [
            ((78.2, 15.6), date(2024, 6, 21), "polar day"),
            ((78.2, 15.6), date(2024, 12, 21), "polar night"),
            ((-90.0, 0.0), date(2024, 12, 21), "polar day"),
            ((90.0, 0.0), date(2024, 12, 21), "polar night"),
        ],
    )
    def test_days_without_sunrise(self, place, day, what):
        with pytest.raises(
            InputError, match=rf"on {day}: .*\({what}\).*choose another date or place"
        ):
            sun_hours(*place, day)

    def test_the_midnight_sun(self):
        """At solstice the sun stands at latitude + 23.44 - 90 degrees at midnight, without
        refraction, and at 113.44 - latitude at noon; in the north in either case."""
        first, noon, last = sun_path(*TROMSO, date(2024, 6, 21), 3)
        for midnight in (first, last):
            assert midnight.altitude_deg == pytest.approx(TROMSO[0] + 23.44 - 90.0 + 0.22, abs=0.02)
            assert min(midnight.azimuth_deg, 360.0 - midnight.azimuth_deg) < 0.01
        assert noon.altitude_deg == pytest.approx(113.44 - TROMSO[0] + 0.02, abs=0.02)
        assert noon.azimuth_deg == pytest.approx(180.0, abs=0.1)
        day = last.time - first.time
        assert timedelta(hours=23, minutes=59) < day < timedelta(hours=24, minutes=1)

    def test_from_the_last_sunrise_to_the_first_sunset(self):
        """One day has a sunrise alone, a later one a sunset alone, the days between neither; the
        midnight sun of Tromso lasts from about 18 May to 25 July."""
        found = {}
        for number in range(366):
            day = date(2024, 1, 1) + timedelta(days=number)
            with contextlib.suppress(InputError):  # polar night
                light = daylight(*TROMSO, day)
                assert (
                    timedelta() < light.hours[1] - light.hours[0] < timedelta(hours=24, minutes=5)
                )
                assert min(p.altitude_deg for p in sun_path(*TROMSO, day, 5)) > -0.3
                found.setdefault((light.rises, light.sets), []).append(day)
        (rises,), (sets,) = found[True, False], found[False, True]
        assert date(2024, 5, 15) < rises < date(2024, 5, 20)
        assert date(2024, 7, 23) < sets < date(2024, 7, 28)
        assert found[False, False][0] == rises + timedelta(days=1)
        assert found[False, False][-1] == sets - timedelta(days=1)

    def test_a_polar_night_in_numbers(self):
        """At solstice the centre reaches 66.56 degrees less the latitude; noon at 18.96 E is 76
        minutes before Greenwich's, less the equation of time (2 minutes)."""
        with pytest.raises(InputError, match=r"noon, 10:4[23] UTC.* at -3\.09 degrees.*-0\.83"):
            sun_path(*TROMSO, date(2024, 12, 21), 5)

    def test_the_year_at_the_polar_circle_has_a_path_or_says_why_not(self):
        found = set()
        for number in range(0, 366, 3):
            day = date(2024, 1, 1) + timedelta(days=number)
            try:
                rise, sunset = sun_hours(67.5, 20.0, day)
            except InputError:
                found.add("none")
            else:
                assert timedelta() < sunset - rise < timedelta(hours=24)
                found.add("path")
        assert found == {"none", "path"}


class TestRefusals:
    @pytest.mark.parametrize(
        ("latitude", "longitude", "words"),
        [
            (90.1, 0.0, "latitude = 90.1; must be -90..90"),
            (float("nan"), 0.0, "latitude = nan; must be"),
            (0.0, 180.5, "longitude = 180.5; must be -180..180"),
            (0.0, float("inf"), "longitude = inf; must be"),
        ],
    )
    def test_places(self, latitude, longitude, words):
        for ask in (
            lambda: sun_position(GOLDEN_TIME, latitude, longitude),
            lambda: sun_hours(latitude, longitude, date(2024, 1, 1)),
        ):
            with pytest.raises(InputError, match=words):
                ask()

    def test_times(self):
        with pytest.raises(InputError, match="has no offset from UTC; add one"):
            sun_position(datetime(2024, 1, 1), *MUNICH)
        for year in (1899, 2101):
            with pytest.raises(InputError, match=f"year {year}: must be 1900..2100"):
                sun_position(datetime(year, 1, 1, tzinfo=UTC), *MUNICH)
            with pytest.raises(InputError, match=f"year {year}: must be 1900..2100"):
                sun_hours(*MUNICH, date(year, 1, 1))

    @pytest.mark.parametrize(
        "air", [{"pressure_hpa": -1.0}, {"temperature_c": 200.0}, {"elevation_m": 1e5}]
    )
    def test_air(self, air):
        with pytest.raises(InputError, match="must be"):
            sun_position(GOLDEN_TIME, *MUNICH, **air)

    def test_count(self):
        with pytest.raises(InputError, match="count = 0; must be 1 or more"):
            sun_path(*MUNICH, date(2024, 1, 1), 0)
