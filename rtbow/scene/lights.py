"""The lights of a scene: suns and lamps."""

from typing import Annotated, Literal

from pydantic import Field

from rtbow.base.limits import MAX_DISC_DEG
from rtbow.physics.constants import SUN_DIAMETER_DEG
from rtbow.scene.table import (
    AltitudeDeg,
    Point,
    Table,
    shown_as,
)

_KIND = Field(
    description="the kind of light",
    json_schema_extra=shown_as(
        "",
        "The sun's bow is round about the antisolar point, a lamp's bends through the volume.",
    ),
)
_SPECTRUM = "E490, equal-energy, a CIE name (FL2, HP1, LED-B3) or a CSV file of wavelength_nm,value"


class SunLight(Table):
    """A uniform disc at infinity."""

    type: Annotated[Literal["sun"], _KIND] = "sun"
    altitude_deg: AltitudeDeg = Field(
        20.0,
        description="where the disc's centre stands, above the horizon",
        json_schema_extra=shown_as(
            "deg",
            "A higher sun lowers the bow; above 42 degrees the primary is below the horizon. A "
            "low one reddens it.",
        ),
    )
    azimuth_deg: float = Field(
        180.0,
        description="where the disc's centre stands, clockwise from north",
        json_schema_extra=shown_as("deg", "Turns the bow about the eye.", (0.0, 360.0)),
    )
    spectrum: str = Field(
        "E490",
        min_length=1,
        description=_SPECTRUM,
        json_schema_extra=shown_as(
            "", "The colours that the bow can have: a line spectrum gives separate lines."
        ),
    )
    angular_diameter_deg: float = Field(
        SUN_DIAMETER_DEG,
        ge=0,
        le=MAX_DISC_DEG,
        description="the disc across; 0 is a point at infinity",
        json_schema_extra=shown_as(
            "deg", "A wider disc blurs the colours and the supernumerary bows.", (0.0, 5.0)
        ),
    )
    irradiance_w_m2: float | None = Field(
        None,
        gt=0,
        le=1e12,
        description="irradiance over 380-780 nm above the air, facing the light; "
        "left out: the 654.95 of E490",
        json_schema_extra=shown_as(
            "W/m²", "All of the bow grows brighter alike.", (1.0, 2000.0), log=True
        ),
    )


class PointLight(Table):
    """A small lamp that radiates equally in all directions."""

    type: Annotated[Literal["point"], _KIND] = "point"
    position_m: Point = Field(
        description="where the lamp hangs: east, north, up",
        json_schema_extra=shown_as(
            "m",
            "The bow's surface passes through eye and lamp; its shape changes with both.",
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
    luminous_flux_lm: float = Field(
        gt=0,
        le=1e12,
        description="luminous flux in all directions",
        json_schema_extra=shown_as(
            "lm", "All of the bow grows brighter alike.", (10.0, 1e6), log=True
        ),
    )
    diameter_m: float = Field(
        0.1,
        ge=0,
        le=10,
        description="the glowing sphere across: drops see a disc, and none are inside; "
        "0 is a point",
        json_schema_extra=shown_as("m", "A wider lamp blurs the bow in the drops near it."),
    )


Light = Annotated[SunLight | PointLight, Field(discriminator="type")]
