"""The world around the drops: the air and the ground."""

from __future__ import annotations

from pydantic import Field, ValidationInfo, field_validator

from rtbow.scene.table import Table, refused, shown_as


class Atmosphere(Table):
    """The air; a scene without this table has none."""

    rayleigh: bool = Field(
        True,
        description="attenuation by the air's molecules",
        json_schema_extra=shown_as("", "Air removes blue light: distant rain and low suns redden."),
    )
    sky: bool = Field(
        False,
        description="the air's own light: what its molecules scatter of the suns' light, before, "
        "within and behind the rain",
        json_schema_extra=shown_as("", "The bow stands in a blue sky."),
    )

    @field_validator("sky")
    @classmethod
    def _glows_where_it_is(cls, sky: bool, info: ValidationInfo) -> bool:
        if sky and not info.data.get("rayleigh", True):
            raise refused("needs rayleigh = true: it is the air's molecules that glow")
        return sky


class Ground(Table):
    """The ground, a sphere that touches height 0 below the eye; a scene without this table has
    none."""

    albedo: float = Field(
        0.2,
        ge=0,
        le=1,
        description="share of the light that the ground sends back, evenly to all sides, at all "
        "wavelengths",
        json_schema_extra=shown_as("", "Snow has 0.8, sand 0.3, grass 0.05 to 0.2, water less."),
    )
