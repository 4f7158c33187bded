"""The sun by date, time and place, in the panel."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from datetime import date, datetime, timedelta, timezone
from functools import lru_cache

from imgui_bundle import imgui

from rtbow.base.errors import InputError
from rtbow.view.panel import widgets
from rtbow.view.panel.layout import Rows
from rtbow.view.panel.rows import Row, Slide, own_row, shown_number

Direction = tuple[float, float]
"""Altitude and azimuth in degrees."""
_DIGITS = 2
"""Decimals of the sun's altitude and azimuth, in degrees."""
_DAY_MIN = 24 * 60
_STEP_MIN = 5


def _row(name: str, label: str, unit: str, description: str, slide: Slide | None = None) -> Row:
    effect = "Sets the sun's altitude and azimuth."
    return own_row(f"by date.{name}", label, description, effect, "number", unit=unit, slide=slide)


_LATITUDE = _row("latitude", "latitude", "deg", "of the place, north is positive", Slide(-90, 90))
_LONGITUDE = _row(
    "longitude", "longitude", "deg", "of the place, east is positive", Slide(-180, 180)
)
_DATE = _row("date", "date", "", "day of the year; type it as 2026-06-21")
_TIME = _row(
    "time", "time", "", "on a clock there; type it as 18:30", Slide(0, _DAY_MIN // _STEP_MIN)
)
_OFFSET = _row(
    "offset", "UTC offset", "h", "of the clock, such as 2 for summer in Paris", Slide(-12, 14)
)
_USE = own_row(
    "by date.use", "by date and place",
    "take altitude and azimuth from a date, time and place; off once the sun is moved by other"
    " means",
)  # fmt: skip
_MOST_REMEMBERED = 2000
_SETTINGS = ("latitude_deg", "longitude_deg", "day", "minutes", "offset_h")


@dataclass
class SunByDate:
    """A place and a time, from which a sun's altitude and azimuth follow.

    Attributes:
        on: whether it is shown.
        latitude_deg, longitude_deg: the place, north and east positive.
        day: the date.
        minutes: since midnight, on the clock there.
        offset_h: of that clock from UTC.

    The scene has only the sun's direction. The settings that led to it are remembered, so that
    they follow the sun when a change is undone.
    """

    on: bool = False
    latitude_deg: float = 48.0
    longitude_deg: float = 11.0
    day: date = date(2026, 6, 21)
    minutes: int = 18 * 60
    offset_h: float = 2.0
    _at_deg: Direction | None = None
    _led_to: dict[Direction, tuple[object, ...]] = field(default_factory=dict, repr=False)

    @classmethod
    def now(cls) -> SunByDate:
        """Give today, by this computer's clock."""
        clock = datetime.now().astimezone()
        offset = clock.utcoffset() or timedelta()
        minutes = (clock.hour * 60 + clock.minute) // _STEP_MIN * _STEP_MIN
        return cls(day=clock.date(), minutes=minutes, offset_h=offset.total_seconds() / 3600)

    def direction_deg(self) -> tuple[float, float]:
        """Give the sun's altitude and azimuth.

        Raises:
            InputError: a place or a year that is out of range.
        """
        from rtbow.physics.light.sun_position import sun_position

        zone = timezone(timedelta(hours=self.offset_h))
        midnight = datetime(self.day.year, self.day.month, self.day.day, tzinfo=zone)
        when = midnight + timedelta(minutes=self.minutes)
        sun = sun_position(when, self.latitude_deg, self.longitude_deg)
        return round(sun.altitude_deg, _DIGITS), round(sun.azimuth_deg, _DIGITS)

    def _look(self, at_deg: Direction) -> None:
        """Follow a sun that was moved by other means, with the settings that led there or off."""
        if at_deg == self._at_deg:
            return
        self._at_deg = at_deg
        settings = self._led_to.get(at_deg)
        self.on = settings is not None
        for name, value in zip(_SETTINGS, settings or (), strict=False):
            setattr(self, name, value)

    def _led(self, at_deg: Direction) -> None:
        """Remember which settings led to a direction."""
        self._at_deg = at_deg
        self._led_to.pop(at_deg, None)  # the newest goes last
        self._led_to[at_deg] = tuple(getattr(self, name) for name in _SETTINGS)
        if len(self._led_to) > _MOST_REMEMBERED:
            del self._led_to[next(iter(self._led_to))]

    def draw(
        self,
        rows: Rows,
        light: str,
        at_deg: Direction,
        change: Callable[[dict[str, object], object], str],
    ) -> None:
        """Draw the box that shows it, and its sliders.

        Args:
            rows: of the frame.
            light: path of the sun.
            at_deg: its altitude and azimuth.
            change: takes changes of the scene and their gesture.
        """
        self._look(at_deg)

        def apply(gesture: object) -> str:
            try:
                altitude, azimuth = self.direction_deg()
            except (InputError, ValueError, OverflowError) as error:
                return str(error)
            message = change(
                {f"{light}.altitude_deg": altitude, f"{light}.azimuth_deg": azimuth}, gesture
            )
            if not message:
                self._led((altitude, azimuth))
            return message

        def use(value: object, gesture: object) -> str:
            self.on = bool(value)
            if not self.on:
                self._led_to.pop(at_deg, None)
            return apply(gesture) if self.on else ""

        if rows.begin_row(_USE, False):
            rows.label(_USE.label)
            widgets.flag(rows, _USE.path, self.on, use)
            rows.end_row()
        if not self.on:
            return
        self._sliders(rows, apply)
        imgui.text_disabled(_hours(self.latitude_deg, self.longitude_deg, self.day, self.offset_h))

    def _sliders(self, rows: Rows, apply: Callable[[object], str]) -> None:
        def take(name: str, value: object, gesture: object) -> str:
            before, kind = getattr(self, name), _KINDS[name]
            if kind is float and isinstance(value, int) and not isinstance(value, bool):
                value = float(value)  # typed without a point
            if not isinstance(value, kind):
                return f"{value}; must be {_EXPECTED[name]}"
            setattr(self, name, value)
            message = apply(gesture)
            if message:
                setattr(self, name, before)
            return message

        def number(
            row: Row,
            name: str,
            value: float,
            stored: Callable[[object], object] = lambda value: value,
            text: Callable[[float], str] | None = None,
            read: Callable[[str], object] = widgets.read_number,
        ) -> None:
            def set_value(value: object, gesture: object) -> str:
                return take(name, stored(value), gesture)

            def put_back(before: float) -> None:
                setattr(self, name, stored(before))
                rows.drafts.undo()

            if rows.begin_row(row, False):
                rows.label(row.label)
                widgets.number(
                    rows, row.path, value, rows.value_width, set_value, row.slide, unit=row.unit,
                    show=text or shown_number, write=text or repr, read=read, put_back=put_back,
                )  # fmt: skip
                rows.end_row()

        def to_day(value: object) -> object:
            """Give the date of a day of the year."""
            first = date(self.day.year, 1, 1)
            return first + timedelta(days=value - 1) if isinstance(value, int) else value

        def to_minutes(value: object) -> object:
            return round(value * _STEP_MIN) if isinstance(value, int | float) else value

        def date_text(number: float) -> str:
            return f"{to_day(int(number))}"

        days = date(self.day.year, 12, 31).timetuple().tm_yday
        in_year = replace(_DATE, slide=Slide(1, days, whole=True))
        number(in_year, "day", self.day.timetuple().tm_yday, to_day, date_text, read_date)
        number(_TIME, "minutes", self.minutes / _STEP_MIN, to_minutes, _time_text, read_time)
        number(_OFFSET, "offset_h", self.offset_h)
        number(_LATITUDE, "latitude_deg", self.latitude_deg)
        number(_LONGITUDE, "longitude_deg", self.longitude_deg)


_KINDS: dict[str, type] = {
    "day": date, "minutes": int, "offset_h": float, "latitude_deg": float, "longitude_deg": float,
}  # fmt: skip
_EXPECTED = {
    "day": "a date such as 2026-06-21",
    "minutes": "a time such as 18:30",
    "offset_h": "a number of hours, -24..24",
    "latitude_deg": "a number, -90..90 degrees",
    "longitude_deg": "a number, -180..180 degrees",
}


def _time_text(steps: float) -> str:
    hours, minutes = divmod(round(steps * _STEP_MIN), 60)
    return f"{hours:02d}:{minutes:02d}"


def read_date(text: str) -> object:
    """Read a date; what is none stays text."""
    try:
        return date.fromisoformat(text.strip())
    except ValueError:
        return text


def read_time(text: str) -> object:
    """Read a time of day in the slider's steps; what is none stays text."""
    hours, _, minutes = text.strip().partition(":")
    try:
        total = int(hours) * 60 + int(minutes or 0)
    except ValueError:
        return text
    return total / _STEP_MIN if 0 <= total <= _DAY_MIN else text


@lru_cache(maxsize=8)
def _hours(latitude_deg: float, longitude_deg: float, day: date, offset_h: float) -> str:
    """Say when the sun rises and sets."""
    from rtbow.physics.light.sun_position import sun_hours

    zone = timezone(timedelta(hours=offset_h))
    try:
        rise, setting = sun_hours(latitude_deg, longitude_deg, day)
    except InputError:
        return "the sun neither rises nor sets on that day"
    return (
        f"the sun rises at {rise.astimezone(zone):%H:%M}, sets at {setting.astimezone(zone):%H:%M}"
    )
