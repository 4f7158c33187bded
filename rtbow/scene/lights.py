"""The lights of a scene: suns and lamps."""

import os
import re
from datetime import date, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from rtbow.base.errors import InputError
from rtbow.base.limits import MAX_DISC_DEG
from rtbow.physics.constants import (
    MOON_DISTANCE_KM,
    MOON_DISTANCES_KM,
    MOON_PHASES_DEG,
    SUN_DIAMETER_DEG,
)
from rtbow.scene.table import AltitudeDeg, Point, Table, number, refused, shown_as

_KIND = Field(
    description="the kind of light",
    json_schema_extra=shown_as(
        "",
        "A sun's bow is a circle about the antisolar point; a lamp's is bent through the rain.",
    ),
)
E490 = "E490"
EQUAL_ENERGY = "equal-energy"
MOON = "moon"
"""The spectrum of a light that is the Moon: sunlight times its reflectance."""
_SPECTRUM = (
    "E490, moon, equal-energy, a CIE name (FL2, HP1, LED-B3) or a file of wavelengths and values, "
    "such as lamp.csv, or lamp.csv#3 for its third column"
)
_BEYOND = Field(
    description="what a spectrum file that ends within 380-780 nm has beyond: zero for no light, "
    "hold for its last value; left out: such a file is refused",
    json_schema_extra=shown_as("", "Light at the ends of the rainbow that was not measured."),
)
Beyond = Literal["zero", "hold"]
_DIGITS = 6
AT = ("altitude_deg", "azimuth_deg")
"""Where a light at infinity stands, unless time and place say it."""
LIT = ("moon_phase_deg", "moon_distance_km")
"""How the Moon is lit, unless time and place say it."""
FROM_TIME = (*AT, *LIT)
"""What follows from a light's time and place."""
TIME_AND_PLACE = ("time", "latitude_deg", "longitude_deg")


def _moment(value: object) -> object:
    """Take a date and time of TOML as its text."""
    return value.isoformat() if isinstance(value, date) else value  # a datetime is a date, too


class SunLight(Table):
    """A uniform disc at infinity: the sun, the Moon, or a light of any other spectrum."""

    type: Annotated[Literal["sun"], _KIND] = "sun"
    altitude_deg: AltitudeDeg = Field(
        20.0,
        description="altitude of the disc's centre above the horizon",
        json_schema_extra=shown_as(
            "deg",
            "A higher sun lowers the bow; above 42 degrees the primary is below the horizon. A "
            "low one reddens it.",
        ),
    )
    azimuth_deg: float = Field(
        180.0,
        description="azimuth of the disc's centre, clockwise from north",
        json_schema_extra=shown_as("deg", "Turns the bow around the eye.", (0.0, 360.0)),
    )
    spectrum: str = Field(
        "E490",
        min_length=1,
        description=_SPECTRUM,
        json_schema_extra=shown_as(
            "", "The colours that the bow can have: a line spectrum gives separate lines."
        ),
    )
    beyond: Annotated[Beyond | None, _BEYOND] = None
    angular_diameter_deg: float = Field(
        SUN_DIAMETER_DEG,
        ge=0,
        le=MAX_DISC_DEG,
        description="diameter of the disc; 0 is a point at infinity",
        json_schema_extra=shown_as(
            "deg", "A wider disc blurs the colours and the supernumerary bows.", (0.0, 5.0)
        ),
    )
    visible: bool = Field(
        True,
        description="the disc itself is drawn where there is a sky or a ground, behind the air and "
        "the rain",
        json_schema_extra=shown_as("", "Without it a picture towards the sun is not dazzled."),
    )
    irradiance_w_m2: float | None = Field(
        None,
        gt=0,
        le=1e12,
        description="irradiance over 380-780 nm above the air, on a surface facing the light; "
        "left out: 654.95, that of E490",
        json_schema_extra=shown_as(
            "W/m²", "Makes the whole bow brighter or darker.", (1.0, 2000.0), log=True
        ),
    )
    time: Annotated[str, BeforeValidator(_moment)] | None = Field(
        None,
        description="date and time with offset from UTC, such as 2013-05-27T13:46:00Z: places the"
        " light as it is seen from latitude_deg and longitude_deg, instead of altitude_deg and"
        " azimuth_deg",
        json_schema_extra=shown_as("", "The sun of that moment; with spectrum moon, the Moon."),
    )
    latitude_deg: float | None = Field(
        None,
        ge=-90,
        le=90,
        description="of the place, north is positive",
        json_schema_extra=shown_as("deg", "Where the sky of that time is seen."),
    )
    longitude_deg: float | None = Field(
        None,
        ge=-180,
        le=180,
        description="of the place, east is positive",
        json_schema_extra=shown_as("deg", "Where the sky of that time is seen."),
    )
    moon_phase_deg: float | None = Field(
        None,
        ge=MOON_PHASES_DEG[0],
        le=MOON_PHASES_DEG[1],
        description="angle at the Moon between sun and eye, with spectrum moon: 0 is full, 90 "
        "half; left out: 0",
        json_schema_extra=shown_as("deg", "A half moon gives a tenth of the light of a full one."),
    )
    moon_distance_km: float | None = Field(
        None,
        ge=MOON_DISTANCES_KM[0],
        le=MOON_DISTANCES_KM[1],
        description=f"of the Moon, with spectrum moon; left out: {MOON_DISTANCE_KM:g}",
        json_schema_extra=shown_as(
            "km", "At its nearest it is 30 % brighter than at its farthest."
        ),
    )

    @model_validator(mode="before")
    @classmethod
    def _placed(cls, data: Any) -> Any:
        """Fill in what follows from time and place, and the size of the Moon."""
        if not isinstance(data, dict):
            return data
        moon = data.get("spectrum") == MOON
        if not moon:
            for key in LIT:
                if data.get(key) is not None:
                    raise refused(f'{key} goes with spectrum = "{MOON}"; leave it out')
        if data.get("time") is not None:
            data = {**data, **_by_time(data, moon)}
        if moon and data.get("angular_diameter_deg") is None:
            from rtbow.physics.light.moon import diameter_deg

            distance = number(data.get("moon_distance_km") or MOON_DISTANCE_KM)
            if distance is not None and distance >= MOON_DISTANCES_KM[0]:
                data = {**data, "angular_diameter_deg": round(diameter_deg(distance), _DIGITS)}
        return data


def _by_time(data: dict[str, Any], moon: bool) -> dict[str, float]:
    """Give what follows from a light's time and place, by key; the rest is checked later."""
    from rtbow.physics.light.sun_position import moon_position, sun_position

    text = _moment(data["time"])
    try:
        when = datetime.fromisoformat(str(text))
    except ValueError:
        raise refused(
            f"time = {str(text)[:40]!r} is no date and time; write for example 2013-05-27T13:46:00Z"
        ) from None
    place = [number(data.get(key)) for key in ("latitude_deg", "longitude_deg")]
    numbers = [at for at in place if at is not None]
    if len(numbers) < 2:
        raise refused("time needs a place: give latitude_deg and longitude_deg in degrees, too")
    try:
        if moon:
            at = moon_position(when, *numbers)
            values: tuple[float, ...] = (
                at.altitude_deg,
                at.azimuth_deg,
                at.phase_deg,
                at.distance_km,
            )
        else:
            seen = sun_position(when, *numbers)
            values = (seen.altitude_deg, seen.azimuth_deg)
    except InputError as error:
        raise refused(str(error)) from None
    found = dict(zip(FROM_TIME, (round(v, _DIGITS) for v in values), strict=False))
    for key, value in found.items():
        if data.get(key) is not None and data[key] != value:
            raise refused(
                f"{key} = {data[key]} beside time, which makes it {value:g}; leave one of them out"
            )
    return found


class PointLight(Table):
    """A small lamp that radiates equally in all directions."""

    type: Annotated[Literal["point"], _KIND] = "point"
    position_m: Point = Field(
        description="position of the lamp: east, north, up",
        json_schema_extra=shown_as(
            "m",
            "The bow is a surface through the eye and the lamp; its shape changes with both.",
            (-500.0, 500.0),
        ),
    )
    spectrum: str = Field(
        "E490",
        min_length=1,
        description=_SPECTRUM,
        json_schema_extra=shown_as(
            "", "The colours that the bow can have: a sodium lamp's is yellow throughout."
        ),
    )
    beyond: Annotated[Beyond | None, _BEYOND] = None
    luminous_flux_lm: float = Field(
        gt=0,
        le=1e12,
        description="luminous flux, summed over all directions",
        json_schema_extra=shown_as(
            "lm", "Makes the whole bow brighter or darker.", (10.0, 1e6), log=True
        ),
    )
    diameter_m: float = Field(
        0.1,
        ge=0,
        le=10,
        description="diameter of the glowing sphere: drops see it as a disc, and none are inside; "
        "0 is a point",
        json_schema_extra=shown_as("m", "A wider lamp blurs the bow in the drops near it."),
    )


Light = Annotated[SunLight | PointLight, Field(discriminator="type")]


def spectrum_file(spectrum: str, folder: Path | None = None) -> str:
    """Return the path of the file that a light's spectrum names; nothing if it is a name.

    Args:
        spectrum: the key's value: a name, or a path, perhaps with ``#column`` behind it.
        folder: where relative paths start; the current folder if None.
    """
    start = folder or Path()
    path, mark, _ = spectrum.rpartition("#")
    if not mark or os.path.exists(start / spectrum):
        path = spectrum
    # FL3.1 and AM1.5 are names: a file's suffix begins with a letter.
    if re.search(r"[/\\]|\.[A-Za-z_]\w*$", path):
        return path
    if not os.path.isfile(start / path):
        return path if mark and path != spectrum else ""
    from rtbow.physics.light.cie import illuminant_names

    return "" if path in (E490, MOON, EQUAL_ENERGY, *illuminant_names()) else path
