"""How the radii of a scene's drops are distributed."""

from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from rtbow.base.limits import MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.scene.table import Table, refused, shown_as

RadiusUm = Annotated[float, Field(ge=MIN_RADIUS_UM, le=MAX_RADIUS_UM)]

_DISTRIBUTION = Field(
    description="how the drops' radii are distributed",
    json_schema_extra=shown_as(
        "", "Wide distributions wash out the supernumerary bows; narrow ones show them."
    ),
)
_SHOWN_SIZE = shown_as(
    "µm", "Small drops make a wide, pale bow, large ones a narrow bow of strong colours.", log=True
)
_SPREAD = "More spread washes out the supernumerary bows."


class ConstantRadius(Table):
    """Drops that all have the same radius."""

    distribution: Annotated[Literal["constant"], _DISTRIBUTION]
    radius_um: RadiusUm = Field(
        description="radius of every drop",
        json_schema_extra=_SHOWN_SIZE,
    )


class _Mixed(Table):
    """Drops of several sizes: one size drawn for each grid point, or all sizes everywhere."""

    # Narrowed below; declared here so that it stays the first key.
    distribution: Annotated[str, _DISTRIBUTION]
    mixing: Literal["per-point", "local"] = Field(
        "per-point",
        description="per-point: each grid point has drops of one size, drawn at random; "
        "local: each has the whole distribution",
        json_schema_extra=shown_as(
            "",
            "Per point, fringes of single sizes show through the rain; local gives the smooth bow "
            "of the whole mixture.",
        ),
    )


class _RadiusRange(_Mixed):
    """Radii between two ends."""

    min_um: RadiusUm = Field(
        description="smallest radius",
        json_schema_extra=shown_as("µm", "Small drops add a wide, pale band.", log=True),
    )
    max_um: RadiusUm = Field(
        description="largest radius",
        json_schema_extra=shown_as(
            "µm", "Large drops narrow the bow and deepen its red.", log=True
        ),
    )

    @field_validator("max_um")
    @classmethod
    def _above_min(cls, value: float, info: ValidationInfo) -> float:
        least = info.data.get("min_um")
        if least is not None and value <= least:
            raise refused(f"must be greater than min_um = {least:g}")
        return value


class UniformRadius(_RadiusRange):
    """Radii drawn evenly between two ends."""

    distribution: Annotated[Literal["uniform"], _DISTRIBUTION]


class NormalRadius(_Mixed):
    """Radii drawn from a bell curve."""

    distribution: Annotated[Literal["normal"], _DISTRIBUTION]
    mean_um: RadiusUm = Field(
        description="mean radius",
        json_schema_extra=_SHOWN_SIZE,
    )
    std_um: float = Field(
        ge=0.1,
        le=MAX_RADIUS_UM,
        description="standard deviation of the radius",
        json_schema_extra=shown_as("µm", _SPREAD, log=True),
    )


class LognormalRadius(_Mixed):
    """Radii whose logarithms follow a bell curve."""

    distribution: Annotated[Literal["lognormal"], _DISTRIBUTION]
    median_um: RadiusUm = Field(
        description="radius that half of the drops exceed",
        json_schema_extra=_SHOWN_SIZE,
    )
    log_std: float = Field(
        ge=0.01,
        le=2,
        description="standard deviation of ln(radius)",
        json_schema_extra=shown_as("", _SPREAD, log=True),
    )


class _Effective(_Mixed):
    """A distribution given by its mean radius and variance, both weighted by area."""

    effective_radius_um: RadiusUm = Field(
        description="mean radius, weighted by area",
        json_schema_extra=shown_as(
            "µm", "Below 30 a white fogbow, above 500 a bow of strong colours.", log=True
        ),
    )
    effective_variance: float = Field(
        ge=1e-4,
        le=0.45,
        description="variance over mean square of the radius, weighted by area",
        json_schema_extra=shown_as("", _SPREAD, log=True),
    )


class GammaRadius(_Effective):
    """Hansen's gamma distribution, the common one for clouds."""

    distribution: Annotated[Literal["gamma"], _DISTRIBUTION]


class ModifiedGammaRadius(_Effective):
    """Deirmendjian's modified gamma distribution: r^alpha exp(-b r^exponent)."""

    distribution: Annotated[Literal["modified-gamma"], _DISTRIBUTION]
    exponent: float = Field(
        ge=0.5,
        le=5,
        description="power of the radius in the exponential; 1 gives gamma",
        json_schema_extra=shown_as("", "Higher powers cut off the largest drops."),
    )


class MarshallPalmerRadius(_RadiusRange):
    """Radii of raindrops, whose numbers follow from the rain rate."""

    distribution: Annotated[Literal["marshall-palmer"], _DISTRIBUTION]


Radius = Annotated[
    ConstantRadius
    | UniformRadius
    | NormalRadius
    | LognormalRadius
    | GammaRadius
    | ModifiedGammaRadius
    | MarshallPalmerRadius,
    Field(discriminator="distribution"),
]
