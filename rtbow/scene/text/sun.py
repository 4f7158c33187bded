"""The sun by place and time, in one text: ``59.9,10.7,2026-07-01T19:30+02:00``."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, date, datetime
from typing import Any, NamedTuple

from rtbow.base.errors import InputError, cut
from rtbow.scene.lights import AT, TIME_AND_PLACE

EXAMPLE = "59.9,10.7,2026-07-01T19:30+02:00"


class SunAt(NamedTuple):
    """A place, and a moment there.

    Attributes:
        latitude_deg: north is positive.
        longitude_deg: east is positive.
        time: with its offset from UTC.
    """

    latitude_deg: float
    longitude_deg: float
    time: datetime

    @classmethod
    def of(cls, value: object) -> SunAt:
        """Read ``LATITUDE,LONGITUDE,TIME``, or a tuple of two numbers and a time.

        A time without an offset from UTC is in UTC.

        Raises:
            InputError: it is neither, or out of range.
        """
        if isinstance(value, SunAt):
            return value
        parts: Any = value.split(",") if isinstance(value, str) else value  # whatever it is
        try:
            latitude, longitude, when = parts
            place = float(latitude), float(longitude)
        except (TypeError, ValueError, OverflowError):
            raise InputError(
                f"sun {cut(str(value))}: must be latitude, longitude (degrees, north and east"
                f" positive) and time, such as {EXAMPLE}"
            ) from None
        from rtbow.physics.light.sun_position import sun_position

        try:
            found = cls(*place, moment(when))
            sun_position(found.time, *place)  # refuses what is out of range
        except InputError as error:
            raise InputError(f"sun {cut(str(value))}: {error}") from None
        return found

    def overrides(self, number: int) -> dict[str, object]:
        """Give the overrides that place a scene's light here."""
        values = (self.time.isoformat(), self.latitude_deg, self.longitude_deg)
        return {
            f"light.{number}.{key}": value
            for key, value in zip(TIME_AND_PLACE, values, strict=True)
        }

    def __str__(self) -> str:
        return (
            f"{self.latitude_deg:g}, {self.longitude_deg:g} at"
            f" {self.time.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
        )


def moment(value: object) -> datetime:
    """Read a date and time; without an offset from UTC it is in UTC.

    Args:
        value: a datetime, or text such as ``2026-07-01T19:30+02:00``.

    Raises:
        InputError: it is no date with a time.
    """
    wrong = "is no date and time"
    try:
        when = value if isinstance(value, datetime) else datetime.fromisoformat(str(value).strip())
        if value is not when and _is_date(str(value).strip()):
            wrong = "is a date without a time"
            raise ValueError
    except ValueError:
        raise InputError(
            f"{cut(str(value))} {wrong}; write for example 2026-07-01T19:30+02:00"
        ) from None
    return when if when.tzinfo is not None else when.replace(tzinfo=UTC)


def _is_date(text: str) -> bool:
    try:
        date.fromisoformat(text)
    except ValueError:
        return False
    return True


def placed_sun(
    data: Mapping[str, Any], changes: Mapping[str, Any], sun: SunAt, name: str
) -> dict[str, object]:
    """Give the overrides that place a scene's first sun.

    Args:
        data: the scene's values, as TOML gives them.
        changes: its other overrides, by dotted key.
        sun: a place and a moment.
        name: what messages call the scene.

    Raises:
        InputError: the scene has no sun, or another override places it.
    """
    lights = changes.get("light", data.get("light"))
    number = _first_sun(lights if isinstance(lights, list | tuple) else (), changes)
    if number is None:
        raise InputError(
            f"{name}: has no sun to be placed by time, only lamps; choose a scene with a sun, or"
            " add --set light.0.type=sun"
        )
    for key in (*AT, *TIME_AND_PLACE):
        place = f"light.{number}.{key}"
        if changes.get(place) is not None:
            raise InputError(
                f"--set {place}: the sun is placed by time and place, too; give one of the two"
            )
    return sun.overrides(number)


def _first_sun(lights: list[Any] | tuple[Any, ...], changes: Mapping[str, Any]) -> int | None:
    for number, light in enumerate(lights):
        written = light.get("type", "sun") if isinstance(light, dict) else "sun"
        if changes.get(f"light.{number}.type", written) == "sun":
            return number
    return None
