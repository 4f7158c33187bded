"""How the radii of a scene's drops are distributed."""

from collections.abc import Collection
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic_core import InitErrorDetails

from rtbow.base.limits import MAX_DENSITY_PER_M3, MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.physics.distributions import LEAST_POWER, effective_variance, ulbrich_moment
from rtbow.scene.table import Table, misplaced, missing, refused, shown_as

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


_MIXING = (
    "per-point: each grid point has drops of one size, drawn at random; "
    "local: each has the whole distribution"
)
_SHOWN_MIXING = shown_as(
    "",
    "Per point, fringes of single sizes show through the rain; local gives the smooth bow "
    "of the whole mixture.",
)


class _Mixed(Table):
    """Drops of several sizes: one size drawn for each grid point, or all sizes everywhere."""

    # Narrowed below; declared here so that it stays the first key.
    distribution: Annotated[str, _DISTRIBUTION]
    mixing: Literal["per-point", "local"] = Field(
        "per-point",
        description=_MIXING,
        json_schema_extra=_SHOWN_MIXING,
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


_EFFECTIVE_RADIUS = "mean radius, weighted by area"
_EFFECTIVE_VARIANCE = "variance over mean square of the radius, weighted by area"
_SHOWN_EFFECTIVE = shown_as(
    "µm", "Below 30 a white fogbow, above 500 a bow of strong colours.", log=True
)
_SHOWN_SPREAD = shown_as("", _SPREAD, log=True)
_EFFECTIVE_KEYS = ("effective_radius_um", "effective_variance")
_ULBRICH_KEYS = ("n0", "mu", "lambda_per_mm")


class GammaRadius(_Mixed):
    """Gamma distribution: Hansen's of clouds, by effective radius and variance, or Ulbrich's of
    rain, N(D) = n0 D^mu exp(-lambda D), which counts its drops itself."""

    distribution: Annotated[Literal["gamma"], _DISTRIBUTION]
    effective_radius_um: RadiusUm | None = Field(
        None,
        description=f"{_EFFECTIVE_RADIUS}; with effective_variance",
        json_schema_extra=_SHOWN_EFFECTIVE,
    )
    effective_variance: float | None = Field(
        None,
        ge=1e-4,
        le=0.45,
        description=f"{_EFFECTIVE_VARIANCE}; with effective_radius_um",
        json_schema_extra=_SHOWN_SPREAD,
    )
    n0: float | None = Field(
        None,
        gt=0,
        le=1e100,
        description="drops per m³ and per mm^(1 + mu) of diameter, with mu and lambda_per_mm, "
        "instead of effective radius, variance and density: N(D) = n0 D^mu exp(-lambda D), D in mm",
        json_schema_extra=shown_as("", "More drops make a brighter bow.", (1.0, 1e6), log=True),
    )
    mu: float | None = Field(
        None,
        gt=-3,
        le=100,
        description="power of the diameter; with n0 and lambda_per_mm",
        json_schema_extra=shown_as("", "Higher powers narrow the distribution.", (-1.0, 10.0)),
    )
    lambda_per_mm: float | None = Field(
        None,
        gt=0,
        le=1e6,
        description="rate at which larger drops become rarer, per mm of diameter; with n0 and mu",
        json_schema_extra=shown_as(
            "1/mm", "Higher rates leave smaller drops: a wider, paler bow.", (0.5, 20.0), log=True
        ),
    )

    @property
    def ulbrich(self) -> tuple[float, float, float] | None:
        """n0 in m⁻³ mm^(-1-mu), mu and lambda in mm⁻¹, if it is given by these."""
        if self.n0 is None or self.mu is None or self.lambda_per_mm is None:
            return None
        return self.n0, self.mu, self.lambda_per_mm

    @model_validator(mode="after")
    def _given_in_one_way(self) -> Self:
        problems = self._missing_or_too_many()
        ulbrich = self.ulbrich
        if not problems and ulbrich is not None:
            problems = _ulbrich_problems(*ulbrich)
        if problems:
            raise ValidationError.from_exception_data(type(self).__name__, problems)
        return self

    def _missing_or_too_many(self) -> list[InitErrorDetails]:
        effective, ulbrich = (
            [key for key in keys if getattr(self, key) is not None]
            for keys in (_EFFECTIVE_KEYS, _ULBRICH_KEYS)
        )
        if effective and ulbrich:
            message = (
                f"does not go with {' and '.join(ulbrich)}: give {' and '.join(_EFFECTIVE_KEYS)},"
                f" or {', '.join(_ULBRICH_KEYS)}"
            )
            return [misplaced((key,), message) for key in effective]
        keys = _ULBRICH_KEYS if ulbrich else _EFFECTIVE_KEYS
        return [
            missing((key,), _remedy_of_gamma(key, ulbrich))
            for key in keys
            if getattr(self, key) is None
        ]


def _remedy_of_gamma(key: str, ulbrich: list[str]) -> str:
    value = {"effective_variance": 0.1, "mu": 2.0, "lambda_per_mm": 4.0}.get(key, 1e4)
    if key == "effective_radius_um":
        value = 10.0
    if ulbrich:
        need = "needs" if len(ulbrich) == 1 else "need"
        return f"{' and '.join(ulbrich)} {need} it, such as {key} = {value:g}"
    return f"give a number, such as {value:g}, or {', '.join(_ULBRICH_KEYS)} of N(D)"


def _ulbrich_problems(n0: float, mu: float, lambda_per_mm: float) -> list[InitErrorDetails]:
    """Refuse drops that are too small, too large or too many."""
    effective_um = 500.0 * (mu + 3.0) / lambda_per_mm
    if not MIN_RADIUS_UM <= effective_um <= MAX_RADIUS_UM:
        low, high = (500.0 * (mu + 3.0) / end for end in (MAX_RADIUS_UM, MIN_RADIUS_UM))
        message = refused(
            f"makes an effective radius of {effective_um:.3g} µm, which must be "
            f"{MIN_RADIUS_UM:g}..{MAX_RADIUS_UM:g} µm: with mu = {mu:g}, {low:.3g}..{high:.3g}"
        )
        return [InitErrorDetails(type=message, loc=("lambda_per_mm",), input=lambda_per_mm)]
    # Where the drops' number is infinite, that of drops of the least radius with all their area.
    drops = (
        ulbrich_moment(n0, mu, lambda_per_mm, 0)
        if mu > -1.0
        else ulbrich_moment(n0, mu, lambda_per_mm, 2) / (2e-3 * MIN_RADIUS_UM) ** 2
    )
    if drops > MAX_DENSITY_PER_M3:
        message = refused(
            f"makes {drops:.3g} drops per m³ (m⁻³ mm^(-1-mu) is its unit); must be up to "
            f"{n0 * (MAX_DENSITY_PER_M3 / drops):.3g}, which makes {MAX_DENSITY_PER_M3:g}"
        )
        return [InitErrorDetails(type=message, loc=("n0",), input=n0)]
    return []


class ModifiedGammaRadius(_Mixed):
    """Deirmendjian's modified gamma distribution: r^alpha exp(-b r^exponent)."""

    distribution: Annotated[Literal["modified-gamma"], _DISTRIBUTION]
    effective_radius_um: RadiusUm = Field(
        description=_EFFECTIVE_RADIUS, json_schema_extra=_SHOWN_EFFECTIVE
    )
    effective_variance: float = Field(
        ge=1e-4,
        le=1.04,
        description=f"{_EFFECTIVE_VARIANCE}; the greatest depends on the exponent: 1.04 with 0.5, "
        "0.47 with 1, 0.25 with 2, 0.15 with 5",
        json_schema_extra=_SHOWN_SPREAD,
    )
    exponent: float = Field(
        ge=0.5,
        le=5,
        description="power of the radius in the exponential; 1 gives gamma",
        json_schema_extra=shown_as("", "Higher powers cut off the largest drops."),
    )

    @model_validator(mode="after")
    def _has_a_number_of_drops(self) -> Self:
        most = effective_variance(LEAST_POWER, self.exponent)
        if self.effective_variance > most:
            message = refused(
                f"must be up to {int(1e3 * most) / 1e3:g} with exponent = {self.exponent:g}: "
                "of a wider distribution small drops would be without number"
            )
            where = ("effective_variance",)
            problem = InitErrorDetails(type=message, loc=where, input=self.effective_variance)
            raise ValidationError.from_exception_data(type(self).__name__, [problem])
        return self


class MarshallPalmerRadius(_RadiusRange):
    """Radii of raindrops, whose numbers follow from the rain rate."""

    distribution: Annotated[Literal["marshall-palmer"], _DISTRIBUTION]


class TableRadius(_Mixed):
    """Radii counted in classes of size, with the number of drops in each, from a file."""

    distribution: Annotated[Literal["table"], _DISTRIBUTION]
    file: str = Field(
        min_length=1,
        description="file of drop sizes (.csv): lines diameter_um,number_per_m3_um (drops per m³ "
        "and µm of diameter), or the 32 classes of an OTT Parsivel",
        json_schema_extra=shown_as("", "The measured sizes decide the bow's width and colours."),
    )
    mixing: Literal["per-point", "local"] = Field(
        "local",
        description=_MIXING,
        json_schema_extra=_SHOWN_MIXING,
    )


def density_key(distribution: str, keys: Collection[str] = ()) -> str | None:
    """Return the key of ``[droplets.density]`` that a distribution of radii needs.

    Args:
        distribution: its name.
        keys: those that its table has.

    Returns:
        The key, or None if the distribution counts its drops itself.
    """
    if distribution == "table" or (
        distribution == "gamma" and not {*_ULBRICH_KEYS}.isdisjoint(keys)
    ):
        return None
    return "rain_rate_mm_h" if distribution == "marshall-palmer" else "number_per_m3"


def replaced_keys(distribution: str, keys: Collection[str]) -> tuple[str, ...]:
    """Return the keys of a distribution that others, newly given, take the place of."""
    if distribution != "gamma":
        return ()
    if not {*_ULBRICH_KEYS}.isdisjoint(keys):
        return _EFFECTIVE_KEYS
    return () if {*_EFFECTIVE_KEYS}.isdisjoint(keys) else _ULBRICH_KEYS


Radius = Annotated[
    ConstantRadius
    | UniformRadius
    | NormalRadius
    | LognormalRadius
    | GammaRadius
    | ModifiedGammaRadius
    | MarshallPalmerRadius
    | TableRadius,
    Field(discriminator="distribution"),
]
