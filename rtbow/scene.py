"""The scene: what is in the picture, checked and frozen, with the units in the names.

Every field carries its description, unit and allowed range, so that panels, documents and error
messages speak from one source. :mod:`rtbow.scene_file` makes scenes from TOML text.
"""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    Strict,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic.config import JsonDict
from pydantic_core import InitErrorDetails, PydanticCustomError

from rtbow.constants import (
    DEFAULT_DELTA_E,
    LEAST_DELTA_E,
    MAX_DENSITY_PER_M3,
    MAX_DISC_DEG,
    MAX_GRID_POINTS,
    MAX_RADIUS_UM,
    MIN_RADIUS_UM,
    MOST_DELTA_E,
    SIZE_SPREADS,
    SUN_DIAMETER_DEG,
    VISIBLE_NM,
    WATER_C,
)
from rtbow.errors import InputError

AXES = ("east", "north", "up")
_DRAWN = "how the drops' radii are distributed"
_SPECTRUM = "E490, equal-energy, a CIE name (FL2, HP1, LED-B3) or a CSV file of wavelength_nm,value"

# Types of list items and lists; TOML has lists where the model has tuples, hence the lax Strict.
# 10,000 km holds every scene on Earth, and squares of lengths still fit in float32.
Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]
Point = Annotated[tuple[Coordinate, Coordinate, Coordinate], Strict(False)]
Box = Annotated[tuple[Point, Point], Strict(False)]
GridSize = Annotated[int, Field(ge=2, le=1024)]
Grid = Annotated[tuple[GridSize, GridSize, GridSize], Strict(False)]
AltitudeDeg = Annotated[float, Field(ge=-90, le=90)]
RadiusUm = Annotated[float, Field(ge=MIN_RADIUS_UM, le=MAX_RADIUS_UM)]
Pixels = Annotated[int, Field(ge=1, le=16384)]
Order = Annotated[int, Field(ge=1, le=2)]


def refused(message: str) -> PydanticCustomError:
    """Return the error for a value: shown as ``key = value; message``."""
    return PydanticCustomError("refused", "{message}", {"message": message})


def _misplaced(path: tuple[str, ...], message: str) -> InitErrorDetails:
    """Return the problem of a key that does not fit here: shown as ``key message``."""
    error = PydanticCustomError("misplaced", "{message}", {"message": message})
    return InitErrorDetails(type=error, loc=path, input=None)


def _missing(path: tuple[str, ...], remedy: str) -> InitErrorDetails:
    """Return the problem of a key that is needed here: shown as ``key is missing; remedy``."""
    error = PydanticCustomError("missing_here", "{message}", {"message": remedy})
    return InitErrorDetails(type=error, loc=path, input=None)


def _shown(
    unit: str, effect: str, usual: tuple[float, float] | None = None, *, log: bool = False
) -> JsonDict:
    """Return the metadata with which panels and documents show a field.

    Args:
        unit: empty for names, switches and counts.
        effect: what it does to the bow.
        usual: the range that a slider covers, of a number that may be far beyond it.
        log: whether a slider moves by factors.
    """
    shown: JsonDict = {"unit": unit, "effect": effect}
    if usual is not None:
        shown["usual"] = [*usual]
    if log:
        shown["log"] = True
    return shown


class Table(BaseModel):
    """A TOML table: frozen, no unknown keys, no conversions but int to float, no NaN, no inf."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Camera(Table):
    """A perspective camera."""

    position_m: Point = Field(
        (0.0, 0.0, 1.6),
        description="the eye: east, north, up",
        json_schema_extra=_shown(
            "m",
            "Near drops fill more of the view, and the lamp's bow changes its shape; a sun's stays "
            "about the antisolar point.",
            (-2000.0, 2000.0),
        ),
    )
    azimuth_deg: float = Field(
        0.0,
        description="direction of view, clockwise from north",
        json_schema_extra=_shown(
            "deg", "Turns the view; the bow stands opposite the sun.", (-180.0, 180.0)
        ),
    )
    altitude_deg: AltitudeDeg = Field(
        20.0,
        description="direction of view, above the horizon",
        json_schema_extra=_shown(
            "deg", "Raises the view; the bow's top stands at 42 degrees less the sun's altitude."
        ),
    )
    fov_deg: float = Field(
        75.0,
        gt=0,
        lt=180,
        description="horizontal field of view, whole angle, over the full width",
        json_schema_extra=_shown(
            "deg", "Zooms: the primary bow is 84 degrees across, the secondary 102.", (5.0, 150.0)
        ),
    )
    size_px: Annotated[tuple[Pixels, Pixels], Strict(False)] = Field(
        (1280, 720),
        description="width and height of the picture",
        json_schema_extra=_shown("px", "More pixels show finer fringes."),
    )
    polarizer_deg: float | None = Field(
        None,
        ge=-360,
        le=360,
        description="a polarising filter before the lens: the direction that it lets pass, "
        "counterclockwise from horizontal as the eye sees it; left out: none",
        json_schema_extra=_shown(
            "deg",
            "The bow is polarised along its arc: a filter along it lets it pass, one across it all "
            "but puts it out.",
            (-90.0, 90.0),
        ),
    )


class SunLight(Table):
    """A uniform disc at infinity."""

    type: Literal["sun"] = Field(
        "sun",
        description="the kind of light",
        json_schema_extra=_shown(
            "",
            "The sun's bow is round about the antisolar point, a lamp's bends through the volume.",
        ),
    )
    altitude_deg: AltitudeDeg = Field(
        20.0,
        description="where the disc's centre stands, above the horizon",
        json_schema_extra=_shown(
            "deg",
            "A higher sun lowers the bow; above 42 degrees the primary is below the horizon. A "
            "low one reddens it.",
        ),
    )
    azimuth_deg: float = Field(
        180.0,
        description="where the disc's centre stands, clockwise from north",
        json_schema_extra=_shown("deg", "Turns the bow about the eye.", (0.0, 360.0)),
    )
    spectrum: str = Field(
        "E490",
        min_length=1,
        description=_SPECTRUM,
        json_schema_extra=_shown(
            "", "The colours that the bow can have: a line spectrum gives separate lines."
        ),
    )
    angular_diameter_deg: float = Field(
        SUN_DIAMETER_DEG,
        ge=0,
        le=MAX_DISC_DEG,
        description="the disc across; 0 is a point at infinity",
        json_schema_extra=_shown(
            "deg", "A wider disc blurs the colours and the supernumerary bows.", (0.0, 5.0)
        ),
    )
    irradiance_w_m2: float | None = Field(
        None,
        gt=0,
        le=1e12,
        description="irradiance over 380-780 nm above the air, facing the light; "
        "left out: the 654.95 of E490",
        json_schema_extra=_shown(
            "W/m²", "All of the bow grows brighter alike.", (1.0, 2000.0), log=True
        ),
    )


class PointLight(Table):
    """A small lamp that radiates equally in all directions."""

    type: Literal["point"] = Field(
        "point",
        description="the kind of light",
        json_schema_extra=_shown(
            "",
            "The sun's bow is round about the antisolar point, a lamp's bends through the volume.",
        ),
    )
    position_m: Point = Field(
        description="where the lamp hangs: east, north, up",
        json_schema_extra=_shown(
            "m",
            "The bow's surface passes through eye and lamp; its shape changes with both.",
            (-500.0, 500.0),
        ),
    )
    spectrum: str = Field(
        "E490",
        min_length=1,
        description=_SPECTRUM,
        json_schema_extra=_shown(
            "", "The colours that the bow can have: a sodium lamp's is yellow throughout."
        ),
    )
    luminous_flux_lm: float = Field(
        gt=0,
        le=1e12,
        description="luminous flux in all directions",
        json_schema_extra=_shown(
            "lm", "All of the bow grows brighter alike.", (10.0, 1e6), log=True
        ),
    )
    diameter_m: float = Field(
        0.1,
        ge=0,
        le=10,
        description="the glowing sphere across: drops see a disc, and none are inside; "
        "0 is a point",
        json_schema_extra=_shown("m", "A wider lamp blurs the bow in the drops near it."),
    )


Light = Annotated[SunLight | PointLight, Field(discriminator="type")]


class ConstantRadius(Table):
    """All drops alike."""

    distribution: Literal["constant"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    radius_um: RadiusUm = Field(
        description="radius of every drop",
        json_schema_extra=_shown(
            "µm",
            "Small drops make a wide pale bow, large ones a narrow one of strong colours.",
            log=True,
        ),
    )


class _Mixed(Table):
    """Drops of several sizes: one drawn for each grid point, or all of them everywhere."""

    # Narrowed below; declared here so that it stays the first key.
    distribution: str = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    mixing: Literal["per-point", "local"] = Field(
        "per-point",
        description="per-point: each grid point has drops of one size, drawn at random; "
        "local: each has the whole distribution",
        json_schema_extra=_shown(
            "",
            "Per point, fringes of single sizes shimmer through the rain; local gives the smooth "
            "bow of the whole mixture.",
        ),
    )


class _RadiusRange(_Mixed):
    """Radii between two ends."""

    min_um: RadiusUm = Field(
        description="smallest radius",
        json_schema_extra=_shown("µm", "Small drops add a wide, pale band.", log=True),
    )
    max_um: RadiusUm = Field(
        description="largest radius",
        json_schema_extra=_shown("µm", "Large drops narrow the bow and deepen its red.", log=True),
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

    distribution: Literal["uniform"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )


class NormalRadius(_Mixed):
    """Radii drawn from a bell curve."""

    distribution: Literal["normal"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    mean_um: RadiusUm = Field(
        description="mean radius",
        json_schema_extra=_shown(
            "µm",
            "Small drops make a wide pale bow, large ones a narrow one of strong colours.",
            log=True,
        ),
    )
    std_um: float = Field(
        ge=0.1,
        le=MAX_RADIUS_UM,
        description="standard deviation of the radius",
        json_schema_extra=_shown("µm", "More spread washes out the supernumerary bows.", log=True),
    )


class LognormalRadius(_Mixed):
    """Radii whose logarithms follow a bell curve."""

    distribution: Literal["lognormal"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    median_um: RadiusUm = Field(
        description="radius that half of the drops exceed",
        json_schema_extra=_shown(
            "µm",
            "Small drops make a wide pale bow, large ones a narrow one of strong colours.",
            log=True,
        ),
    )
    log_std: float = Field(
        ge=0.01,
        le=2,
        description="standard deviation of ln(radius)",
        json_schema_extra=_shown("", "More spread washes out the supernumerary bows.", log=True),
    )


class _Effective(_Mixed):
    """A distribution given by its mean radius and variance, both weighted by area."""

    effective_radius_um: RadiusUm = Field(
        description="mean radius, weighted by area",
        json_schema_extra=_shown(
            "µm", "Below 30 a white fogbow, above 500 a bow of strong colours.", log=True
        ),
    )


class GammaRadius(_Effective):
    """Hansen's gamma distribution, the common one for clouds."""

    distribution: Literal["gamma"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    effective_variance: float = Field(
        ge=1e-4,
        le=0.45,
        description="variance over mean square of the radius, weighted by area",
        json_schema_extra=_shown("", "More spread washes out the supernumerary bows.", log=True),
    )


class ModifiedGammaRadius(_Effective):
    """Deirmendjian's modified gamma distribution: r^alpha exp(-b r^exponent)."""

    distribution: Literal["modified-gamma"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )
    effective_variance: float = Field(
        ge=1e-4,
        le=0.45,
        description="variance over mean square of the radius, weighted by area",
        json_schema_extra=_shown("", "More spread washes out the supernumerary bows.", log=True),
    )
    exponent: float = Field(
        ge=0.5,
        le=5,
        description="power of the radius in the exponential; 1 is gamma",
        json_schema_extra=_shown("", "Higher powers cut off the largest drops."),
    )


class MarshallPalmerRadius(_RadiusRange):
    """Radii of rain, whose number follows from the rain rate."""

    distribution: Literal["marshall-palmer"] = Field(
        description=_DRAWN,
        json_schema_extra=_shown(
            "", "Wide distributions wash out the supernumerary bows, narrow ones show them."
        ),
    )


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


class Density(Table):
    """How many drops there are, directly or by the rain they make."""

    number_per_m3: float | None = Field(
        None,
        ge=0,
        le=MAX_DENSITY_PER_M3,
        description="drops in a cubic metre; every distribution but marshall-palmer",
        json_schema_extra=_shown(
            "1/m³",
            "More drops make a brighter bow, until they hide each other.",
            (1.0, 1e6),
            log=True,
        ),
    )
    rain_rate_mm_h: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="rain rate, from which the density follows; with marshall-palmer",
        json_schema_extra=_shown(
            "mm/h",
            "Heavier rain has more and larger drops: a brighter bow of stronger colours.",
            (0.1, 200.0),
            log=True,
        ),
    )


def density_key(distribution: str) -> str:
    """Return the one key of ``[droplets.density]`` that goes with a radius distribution."""
    return "rain_rate_mm_h" if distribution == "marshall-palmer" else "number_per_m3"


class Droplets(Table):
    """The volume of drops: described by its distributions, or read from a file."""

    box_m: Box | None = Field(
        None,
        description="lower and upper corner: [[east, north, up], [east, north, up]]",
        json_schema_extra=_shown(
            "m", "The bow is seen only where a ray meets the box.", (-2000.0, 2000.0)
        ),
    )
    grid: Grid | None = Field(
        None,
        description="grid points along east, north, up; left out: a uniform volume",
        json_schema_extra=_shown(
            "", "Finer grids show finer shafts and more drawn radii.", (2.0, 128.0)
        ),
    )
    seed: int = Field(
        1,
        ge=0,
        description="seed of the random radii",
        json_schema_extra=_shown("", "Other random drops of the same distribution.", (0.0, 100.0)),
    )
    extinction: bool = Field(
        False,
        description="the rain's own attenuation, towards light and eye",
        json_schema_extra=_shown("", "Dense rain dims what lies deep in it."),
    )
    extinction_efficiency: float | None = Field(
        None,
        ge=0,
        le=5,
        description="light that a drop takes away, over what falls on it; left out: by drop size, "
        "2 for cloud drops to 1 for rain, whose diffraction stays within the light's disc",
        json_schema_extra=_shown("", "Higher values let less light out of the rain."),
    )
    file: str | None = Field(
        None,
        min_length=1,
        description="volume file (.npz), instead of box_m, grid, radius and density",
        json_schema_extra=_shown("", "The rain's own shape: the bow brightens in its shafts."),
    )
    radius: Radius | None = Field(
        None,
        description="the drops' radii",
        json_schema_extra=_shown("", "The size of the drops decides the bow's width and colours."),
    )
    density: Density | None = Field(
        None,
        description="the number of drops",
        json_schema_extra=_shown("", "More drops make a brighter bow, until they hide each other."),
    )

    @field_validator("grid")
    @classmethod
    def _grid_fits_memory(cls, grid: Grid | None) -> Grid | None:
        if grid is not None and math.prod(grid) > MAX_GRID_POINTS:
            raise refused(
                f"has {math.prod(grid):,} points; must have up to {MAX_GRID_POINTS:,}, "
                "such as [512, 512, 512]"
            )
        return grid

    @field_validator("box_m")
    @classmethod
    def _box_has_a_volume(cls, box: Box | None) -> Box | None:
        if box is None:
            return None
        wrong = []
        for axis, low, high in zip(AXES, *box, strict=True):
            if high <= low:
                shape = "flat" if high == low else "turned inside out"
                wrong.append(f"it is {shape} along {axis} ({low:g} to {high:g})")
        if wrong:
            raise refused(
                "the second corner must exceed the first on each axis: " + ", ".join(wrong)
            )
        return box

    @property
    def one_kind(self) -> bool:
        """Whether drops are of one kind everywhere: one radius, or one mixture of radii."""
        radius = self.radius
        return isinstance(radius, ConstantRadius) or (
            radius is not None and radius.mixing == "local"
        )

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        problems = list(self._problems_with_file() if self.file else self._problems_of_parts())
        if problems:
            raise ValidationError.from_exception_data(type(self).__name__, problems)
        return self

    def _problems_with_file(self) -> Iterator[InitErrorDetails]:
        for key in ("box_m", "grid", "radius", "density"):
            if getattr(self, key) is not None:
                yield _misplaced(
                    (key,),
                    "cannot be given together with droplets.file: the volume file carries its "
                    f"own {key.removesuffix('_m')}; leave one of the two out",
                )

    def _problems_of_parts(self) -> Iterator[InitErrorDetails]:
        for key, remedy in (
            ("box_m", "give two corners, such as [[-500, 200, 0], [500, 800, 400]]"),
            ("radius", 'add [droplets.radius] with distribution = "constant", radius_um = 500'),
            ("density", "add [droplets.density] with number_per_m3 = 1000"),
        ):
            if getattr(self, key) is None:
                yield _missing((key,), f"{remedy}, or name a volume in droplets.file")
        if self.radius is None:
            return
        choice = f'distribution = "{self.radius.distribution}"'
        if self.grid is None and not self.one_kind:
            remedy = (
                "draws a radius at each grid point: give their number, such as [64, 64, 32], or "
                'all sizes everywhere with radius.mixing = "local"'
            )
            yield _missing(("grid",), f"{choice} {remedy}")
        if self.density is None:
            return
        wanted = density_key(self.radius.distribution)
        for key, example in (("number_per_m3", "1000"), ("rain_rate_mm_h", "5.0")):
            given = getattr(self.density, key) is not None
            if key == wanted and not given:
                yield _missing(("density", key), f"{choice} needs it, such as {example}")
            elif key != wanted and given:
                message = f"does not go with {choice}; give {wanted} instead"
                yield _misplaced(("density", key), message)


class Atmosphere(Table):
    """The air; a scene without this table has none."""

    rayleigh: bool = Field(
        True,
        description="attenuation by the air's molecules",
        json_schema_extra=_shown("", "The air takes blue away: far rain and low suns redden."),
    )


class Scattering(Table):
    """How a drop scatters light."""

    theory: Literal["airy", "mie"] = Field(
        "airy",
        description="theory of the single drop: airy for the bows alone, mie for all that a "
        "sphere does, exactly",
        json_schema_extra=_shown(
            "", "Mie adds the glory, the corona and the light between the bows."
        ),
    )
    size_spread: float = Field(
        0.02,
        ge=SIZE_SPREADS[0],
        le=SIZE_SPREADS[1],
        description="standard deviation of ln(radius) about each drop size, which blurs the "
        "resonances of a single size (mie); 0.02 is 2 %",
        json_schema_extra=_shown("", "More spread blurs the finest fringes."),
    )
    orders: Annotated[tuple[Order, ...], Strict(False)] = Field(
        (1, 2),
        min_length=1,
        description="internal reflections: 1 primary bow, 2 secondary; mie has all",
        json_schema_extra=_shown("", "1 is the primary bow, 2 the secondary, reversed and paler."),
    )
    water_temperature_c: float = Field(
        20.0,
        ge=WATER_C[0],
        le=WATER_C[1],
        description="sets the refractive index of water",
        json_schema_extra=_shown(
            "°C",
            "Warmer water bends light less: the bow widens by a hundredth of a degree a kelvin.",
        ),
    )

    @field_validator("orders")
    @classmethod
    def _each_order_once(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) < len(value):
            raise refused("must name each order once, such as [1, 2]")
        return tuple(sorted(value))


class Render(Table):
    """How finely the picture is computed."""

    wavelength_step_nm: float = Field(
        5.0,
        ge=0.05,
        le=40,
        description="must divide 400 nm evenly; methods spectral and reference",
        json_schema_extra=_shown(
            "nm", "Coarse steps show as bands in fringes and under line spectra.", log=True
        ),
    )
    steps: int | None = Field(
        None,
        ge=1,
        le=100_000,
        description="samples along a ray; left out: follows the grid",
        json_schema_extra=_shown("", "Few samples miss shafts of rain.", (1.0, 1000.0), log=True),
    )

    max_delta_e: float = Field(
        DEFAULT_DELTA_E,
        ge=LEAST_DELTA_E,
        le=MOST_DELTA_E,
        description="colour difference (CIEDE2000, 99th percentile of pixels) from the truth that"
        " method fast may have",
        json_schema_extra=_shown("", "A larger error is a quicker picture.", log=True),
    )

    @field_validator("wavelength_step_nm")
    @classmethod
    def _divides_the_range(cls, step: float) -> float:
        low, high = VISIBLE_NM
        count = (high - low) / step
        if abs(count - round(count)) > 1e-9 * count:
            below, above = _even_step(math.ceil(count), 1), _even_step(math.floor(count), -1)
            raise refused(f"must divide {low:g}-{high:g} nm evenly, as {below} and {above} do")
        return step


def _even_step(count: int, direction: int) -> str:
    """Return the nearest step (nm) that divides 400 nm evenly and ends after four decimals."""
    while 4_000_000 % count:
        count += direction
    return f"{400 / count:.4f}".rstrip("0").rstrip(".")


class Compare(Table):
    """The picture split between the scene as it stands and with some keys changed."""

    split: float = Field(
        0.5,
        ge=0,
        le=1,
        description="share of the width, from the left, that shows the scene as it stands",
        json_schema_extra=_shown("", "Where the two pictures meet."),
    )
    right: dict[str, Any] = Field(
        description='keys and values of the rest, such as { "atmosphere.rayleigh" = false }',
        json_schema_extra=_shown("", "What differs on the right."),
    )

    def __hash__(self) -> int:
        return hash((self.split, *sorted(self.right)))


class Scene(Table):
    """All that a picture depends on.

    Two scenes are equal when their values are, whatever text they came from.
    """

    camera: Camera = Field(Camera(), description="the eye")
    light: Annotated[tuple[Light, ...], Strict(False)] = Field(
        min_length=1, description="the lights, one or more"
    )
    droplets: Droplets = Field(description="the drops")
    atmosphere: Atmosphere | None = Field(None, description="the air; left out: none")
    scattering: Scattering = Field(Scattering(), description="scattering by a drop")
    render: Render = Field(Render(), description="how finely the picture is computed")
    compare: Compare | None = Field(
        None, description="the picture split between two settings; left out: one picture"
    )

    @field_validator("light", mode="before")
    @classmethod
    def _suns_by_default(cls, lights: object) -> object:
        if not isinstance(lights, list | tuple):
            return lights
        return [{"type": "sun", **x} if isinstance(x, dict) else x for x in lights]

    _right: "Scene | None" = PrivateAttr(default=None)
    _source_text: str = PrivateAttr(default="")
    _source_name: str = PrivateAttr(default="scene")

    @property
    def source_text(self) -> str:
        """The TOML text the scene came from, overrides as ``# --set key=value`` at its end."""
        return self._source_text

    @property
    def source_name(self) -> str:
        """The built-in scene's name, or the path as it was given."""
        return self._source_name

    def parts(self) -> tuple[tuple["Scene", slice], ...]:
        """The scenes that make up the picture and the columns that each fills, left to right.

        Raises:
            InputError: there is a ``compare``, but no scene of its right part; scene files and
                their overrides make one.
        """
        width = self.camera.size_px[0]
        if self.compare is None:
            return ((self, slice(0, width)),)
        if self._right is None:
            raise InputError(
                f"{self._source_name}: compare is without the scene of its right part; load the "
                "scene with load_scene or scene_from_text, or add it using with_right"
            )
        column = round(self.compare.split * width)
        both = ((self, slice(0, column)), (self._right, slice(column, width)))
        return tuple(part for part in both if part[1].start < part[1].stop)

    def with_right(self, right: "Scene") -> Self:
        """Return the same scene with the scene of the right part of its ``compare``."""
        copy = self.model_copy()
        copy._right = right
        return copy

    def with_source(self, text: str, name: str) -> Self:
        """Return the same scene with the text and name it came from."""
        copy = self.model_copy()
        copy._source_text, copy._source_name = text, name
        return copy

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return all(getattr(self, key) == getattr(other, key) for key in type(self).model_fields)
