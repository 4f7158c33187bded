"""The drops of a scene: where they are, how many, and of which radii."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, Strict, ValidationError, field_validator, model_validator
from pydantic_core import InitErrorDetails

from rtbow.base.arrays import AXES
from rtbow.base.limits import (
    LEAST_EXTENT_M,
    MAX_COORDINATE_M,
    MAX_DENSITY_PER_M3,
    MAX_GRID_POINTS,
)
from rtbow.scene.radius import ConstantRadius, Radius, density_key
from rtbow.scene.table import Point, Table, misplaced, missing, refused, shown_as

Box = Annotated[tuple[Point, Point], Strict(False)]
Extent = Annotated[float, Field(ge=LEAST_EXTENT_M, le=MAX_COORDINATE_M)]
Around = Annotated[tuple[Extent, Extent], Strict(False)]
GridSize = Annotated[int, Field(ge=2, le=1024)]
Grid = Annotated[tuple[GridSize, GridSize, GridSize], Strict(False)]


BY_PARTS = ("box_m", "around_m", "grid", "radius", "density")
"""Keys that describe the drops where no volume file does."""


class Density(Table):
    """How many drops there are, directly or by the rain they make."""

    number_per_m3: float | None = Field(
        None,
        ge=0,
        le=MAX_DENSITY_PER_M3,
        description="drops per cubic metre, of every size that the distribution has; for all but "
        "marshall-palmer, table and gamma by n0",
        json_schema_extra=shown_as(
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
        description="rain rate, which sets the number of drops; for marshall-palmer",
        json_schema_extra=shown_as(
            "mm/h",
            "Heavier rain has more and larger drops: a brighter bow of stronger colours.",
            (0.1, 200.0),
            log=True,
        ),
    )


class Droplets(Table):
    """The volume of drops: described by distributions, or read from a file."""

    box_m: Box | None = Field(
        None,
        description="lower and upper corner: [[east, north, up], [east, north, up]]",
        json_schema_extra=shown_as(
            "m", "The bow appears only where the line of sight crosses the box.", (-2000.0, 2000.0)
        ),
    )
    around_m: Around | None = Field(
        None,
        description="rain around the camera, instead of box_m: how far it reaches to the east, "
        "west, north and south, and how high it goes above the eye; it begins at the ground",
        json_schema_extra=shown_as(
            "m", "The bow appears whichever way the sun stands.", (10.0, 4000.0)
        ),
    )
    grid: Grid | None = Field(
        None,
        description="grid points along east, north, up; left out: a uniform volume",
        json_schema_extra=shown_as(
            "", "A finer grid resolves narrower shafts and draws more radii.", (2.0, 128.0)
        ),
    )
    seed: int = Field(
        1,
        ge=0,
        description="seed of the random radii",
        json_schema_extra=shown_as(
            "", "Another seed draws other drops from the same distribution.", (0.0, 100.0)
        ),
    )
    extinction: bool = Field(
        False,
        description="attenuation by the rain itself, from the light and to the eye",
        json_schema_extra=shown_as("", "Dense rain dims what lies deep in it."),
    )
    extinction_efficiency: float | None = Field(
        None,
        ge=0,
        le=5,
        description="light that a drop removes, relative to the light that falls on it; left out: "
        "by drop size, from 2 for cloud drops to 1 for rain, whose diffraction stays within the "
        "light's disc",
        json_schema_extra=shown_as("", "Higher values let less light out of the rain."),
    )
    scattering_orders: Literal["single", "all"] = Field(
        "single",
        description='light that drops scatter once, or "all": more than once, too, which implies '
        "extinction; for suns and lamps",
        json_schema_extra=shown_as(
            "",
            "What one drop takes out of the light comes back by way of others: dense rain glows.",
        ),
    )
    skylight: bool = Field(
        False,
        description="drops lit by the sky and the ground, too, where there is either, and rain "
        "that attenuates",
        json_schema_extra=shown_as("", "The sky brightens the dark band between the bows."),
    )
    file: str | None = Field(
        None,
        min_length=1,
        description="volume file (.npz), instead of box_m, grid, radius and density",
        json_schema_extra=shown_as("", "Gives the rain a shape: shafts brighten the bow."),
    )
    radius: Radius | None = Field(
        None,
        description="the drops' radii",
        json_schema_extra=shown_as(
            "", "The size of the drops decides the bow's width and colours."
        ),
    )
    density: Density | None = Field(
        None,
        description="the number of drops; left out where the distribution counts them: table, "
        "gamma by n0",
        json_schema_extra=shown_as(
            "", "More drops make a brighter bow, until they hide each other."
        ),
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
        thin = [
            f"it is {high - low:g} m thick along {axis}"
            for axis, low, high in zip(AXES, *box, strict=True)
            if high - low < LEAST_EXTENT_M
        ]
        if thin:
            raise refused(f"{', '.join(thin)}; must be {LEAST_EXTENT_M:g} m at least on each axis")
        return box

    @property
    def dims(self) -> bool:
        """Whether the rain attenuates light."""
        return self.extinction or self.scattering_orders == "all"

    @property
    def one_kind(self) -> bool:
        """Whether the drops are the same everywhere: of one radius, or one mixture of radii."""
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
        for key in BY_PARTS:
            if getattr(self, key) is not None:
                own = "box" if key in ("box_m", "around_m") else key
                yield misplaced(
                    (key,),
                    "cannot be given together with droplets.file: the volume file carries its "
                    f"own {own}; leave one of the two out",
                )

    def _problems_of_parts(self) -> Iterator[InitErrorDetails]:
        counted = self.radius is not None and _density_key(self.radius) is None
        for key, remedy in (
            (
                "box_m",
                "give two corners, such as [[-500, 200, 0], [500, 800, 400]], or rain around the "
                "camera, such as around_m = [1000, 800]",
            ),
            ("radius", 'add [droplets.radius] with distribution = "constant", radius_um = 500'),
            ("density", "add [droplets.density] with number_per_m3 = 1000"),
        ):
            placed = key == "box_m" and self.around_m is not None
            if getattr(self, key) is None and not (key == "density" and counted) and not placed:
                yield missing((key,), f"{remedy}, or name a volume in droplets.file")
        if self.radius is None:
            return
        choice = f'distribution = "{self.radius.distribution}"'
        if self.grid is None and not self.one_kind:
            remedy = (
                "draws a radius at each grid point: give their number, such as [64, 64, 32], or "
                'mix all sizes everywhere with radius.mixing = "local"'
            )
            yield missing(("grid",), f"{choice} {remedy}")
        if self.density is not None:
            yield from self._problems_of_density(choice, self.density, _density_key(self.radius))

    def _problems_of_density(
        self, choice: str, density: Density, wanted: str | None
    ) -> Iterator[InitErrorDetails]:
        for key, example in (("number_per_m3", "1000"), ("rain_rate_mm_h", "5.0")):
            given = getattr(density, key) is not None
            if key == wanted and not given:
                yield missing(("density", key), f"{choice} needs it, such as {example}")
            elif given and wanted is None:
                source = "its file" if choice.endswith('"table"') else "n0"
                message = f"does not go with {choice}, whose drops {source} counts; leave it out"
                yield misplaced(("density", key), message)
            elif key != wanted and given:
                message = f"does not go with {choice}; give {wanted} instead"
                yield misplaced(("density", key), message)


def _density_key(radius: Radius) -> str | None:
    return density_key(radius.distribution, radius.model_dump(exclude_none=True))
