"""The world around the drops: the air and the ground."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from rtbow.base.limits import GROUND_HEIGHTS_M, MOST_AEROSOL_DEPTH, PRESSURES_HPA
from rtbow.physics.constants import SEA_LEVEL_HPA, VISIBLE_NM
from rtbow.scene.table import Table, number, refused, shown_as

CUSTOM_AEROSOL = {
    "optical_depth_550": 0.15,
    "angstrom_exponent": 1.3,
    "single_scattering_albedo": 0.93,
    "asymmetry": 0.7,
    "scale_height_m": 1200.0,
}
"""What an aerosol that is no known mixture has where a key is left out."""
FREE_AEROSOL = tuple(key for key in CUSTOM_AEROSOL if key != "optical_depth_550")
"""Keys that go with such an aerosol alone."""
ALBEDOS = ("grass",)
"""Grounds that are known by name."""
_MOST_VIOLET_DEPTH = 3.2
"""Depth at the shortest wavelength up to which the sky holds its error: the mixtures have 2.1 to
3.1 there at the greatest depth."""


class Aerosol(Table):
    """Haze: small particles in the air, of a known mixture or by a few numbers."""

    model: Literal[
        "continental-clean", "continental-average", "continental-polluted", "maritime-clean",
        "custom",
    ] = Field(
        "continental-average",
        description="mixture of OPAC at a relative humidity of 70 %, in a layer up to 2 km; or "
        "custom, by the numbers below",
        json_schema_extra=shown_as("", "Haze whitens the sky and dims what is far."),
    )  # fmt: skip
    optical_depth_550: float | None = Field(
        None,
        ge=0,
        le=MOST_AEROSOL_DEPTH,
        description="vertical optical depth at 550 nm; left out: the model's,"
        f" {CUSTOM_AEROSOL['optical_depth_550']:g} of custom",
        json_schema_extra=shown_as("", "More of it hides what is far.", (0.0, 1.0)),
    )
    angstrom_exponent: float | None = Field(
        None,
        ge=-1,
        le=4,
        description="of custom: exponent of the depth's fall with the wavelength; left out: "
        f"{CUSTOM_AEROSOL['angstrom_exponent']:g}",
        json_schema_extra=shown_as("", "Small particles have a large one: their haze is blue."),
    )
    single_scattering_albedo: float | None = Field(
        None,
        ge=0,
        le=1,
        description="of custom: share of the depth that is scattering; the rest is absorbed; left "
        f"out: {CUSTOM_AEROSOL['single_scattering_albedo']:g}",
        json_schema_extra=shown_as("", "Soot lowers it, and darkens the haze."),
    )
    asymmetry: float | None = Field(
        None,
        ge=-0.9,
        le=0.9,
        description="of custom: parameter of the phase function of Cornette and Shanks; left out: "
        f"{CUSTOM_AEROSOL['asymmetry']:g}",
        json_schema_extra=shown_as("", "Large particles have a large one: the sun has a glare."),
    )
    scale_height_m: float | None = Field(
        None,
        ge=100,
        le=20_000,
        description="of custom: height over which its density falls by a factor e; left out: "
        f"{CUSTOM_AEROSOL['scale_height_m']:g}",
        json_schema_extra=shown_as("m", "A low layer is thick towards the horizon.", log=True),
    )

    @field_validator("optical_depth_550", mode="before")
    @classmethod
    def _is_within_the_error(cls, depth: object) -> object:
        given = number(depth)
        if given is not None and given > MOST_AEROSOL_DEPTH:
            raise refused(
                f"must be 0..{MOST_AEROSOL_DEPTH:g}: up to there the sky holds its error, and"
                " beyond are dust storms"
            )
        return depth

    @model_validator(mode="after")
    def _numbers_go_with_custom(self) -> Self:
        given = [key for key in FREE_AEROSOL if getattr(self, key) is not None]
        if self.model != "custom" and given:
            raise refused(
                f'{given[0]} goes with model = "custom"; leave it out, or change the model'
            )
        if self.model == "custom":
            self._check_violet()
        return self

    def _check_violet(self) -> None:
        depth, exponent = (
            CUSTOM_AEROSOL[key] if getattr(self, key) is None else getattr(self, key)
            for key in ("optical_depth_550", "angstrom_exponent")
        )
        violet = depth * (550.0 / VISIBLE_NM[0]) ** exponent
        if violet > _MOST_VIOLET_DEPTH:
            raise refused(
                f"a depth of {violet:.3g} at {VISIBLE_NM[0]:g} nm, where the sky holds its error up"
                f" to {_MOST_VIOLET_DEPTH:g}; lower optical_depth_550 or angstrom_exponent"
            )


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

    ozone_du: float = Field(
        0.0,
        ge=0,
        le=1000,
        description="column of ozone, Dobson units; it takes yellow and orange light high above the"
        " rain",
        json_schema_extra=shown_as(
            "DU", "300 is usual: a low sun's sky is blue by it.", (0.0, 500.0)
        ),
    )
    pressure_hpa: float = Field(
        SEA_LEVEL_HPA,
        ge=PRESSURES_HPA[0],
        le=PRESSURES_HPA[1],
        description="of the air at height 0, as a barometer there shows it: the molecules' depth is"
        " in proportion",
        json_schema_extra=shown_as(
            "hPa", "Thin air of high places: a darker sky.", (500.0, 1050.0)
        ),
    )
    aerosol: Aerosol | None = Field(
        None,
        description="haze; left out: none",
        json_schema_extra=shown_as("", "The sky is whiter, what is far is dimmer."),
    )

    @field_validator("sky")
    @classmethod
    def _glows_where_it_is(cls, sky: bool, info: ValidationInfo) -> bool:
        if sky and not info.data.get("rayleigh", True):
            raise refused("needs rayleigh = true: it is the air's molecules that glow")
        return sky

    @field_validator("ozone_du", "aerosol")
    @classmethod
    def _within_air(cls, value: object, info: ValidationInfo) -> object:
        if value and not info.data.get("rayleigh", True):
            raise refused("needs rayleigh = true: there is no air without its molecules")
        return value


class Ground(Table):
    """The ground, an even sphere below the eye; a scene without this table has none."""

    albedo: float | str = Field(
        0.2,
        description="share of the light that the ground sends back, evenly to all sides: a number"
        " 0..1, grass, or a file of wavelengths and values over 380-780 nm, such as soil.csv",
        json_schema_extra=shown_as(
            "", "Snow has 0.8, sand 0.3, grass 0.03 to 0.09, bare soil 0.1.", (0.0, 1.0)
        ),
    )
    water: bool = Field(
        False,
        description="still water instead, which mirrors the sky and the suns; albedo does not count"
        " then",
        json_schema_extra=shown_as("", "The sky stands on its head below the horizon."),
    )
    height_m: float = Field(
        0.0,
        ge=GROUND_HEIGHTS_M[0],
        le=GROUND_HEIGHTS_M[1],
        description="of the ground, above the height 0 of scene and air; the eye must be above it",
        json_schema_extra=shown_as("m", "Plateaus, or the top of an even layer of cloud."),
    )

    @field_validator("albedo", mode="before")
    @classmethod
    def _share_or_spectrum(cls, albedo: object) -> object:
        share = None if isinstance(albedo, bool) else number(albedo)
        if share is not None and not 0.0 <= share <= 1.0:  # NaN, too
            raise refused(_ALBEDO)
        if share is None and not (isinstance(albedo, str) and albedo):
            raise refused(_ALBEDO)
        return albedo if share is None else share


_ALBEDO = f"must be 0..1, {', '.join(ALBEDOS)}, or the name of a file"
