"""The lights of a scene: suns and lamps."""

import os
import re
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from rtbow.base.limits import MAX_DISC_DEG
from rtbow.physics.constants import SUN_DIAMETER_DEG
from rtbow.scene.table import AltitudeDeg, Point, Table, shown_as

_KIND = Field(
    description="the kind of light",
    json_schema_extra=shown_as(
        "",
        "A sun's bow is a circle about the antisolar point; a lamp's is bent through the rain.",
    ),
)
E490 = "E490"
EQUAL_ENERGY = "equal-energy"
_SPECTRUM = (
    "E490, equal-energy, a CIE name (FL2, HP1, LED-B3) or a file of wavelengths and values, "
    "such as lamp.csv, or lamp.csv#3 for its third column"
)
_BEYOND = Field(
    description="what a spectrum file that ends within 380-780 nm has beyond: zero for no light, "
    "hold for its last value; left out: such a file is refused",
    json_schema_extra=shown_as("", "Light at the ends of the rainbow that was not measured."),
)
Beyond = Literal["zero", "hold"]


class SunLight(Table):
    """A uniform disc at infinity."""

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

    return "" if path in (E490, EQUAL_ENERGY, *illuminant_names()) else path
