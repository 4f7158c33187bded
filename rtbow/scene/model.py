"""The scene: what is in the picture, checked and frozen, with the units in the names.

:mod:`rtbow.scene.text.file` makes scenes from TOML text.
"""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self, TypeVar, get_args

from pydantic import (
    Field,
    PrivateAttr,
    Strict,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from rtbow.base.errors import InputError
from rtbow.base.limits import (
    DEEPEST_AIR_M,
    DEFAULT_DELTA_E,
    INDICES,
    LEAST_DELTA_E,
    LEAST_FOV_DEG,
    MOST_DELTA_E,
    SALINITIES_G_KG,
    SALT_WATER_C,
    SIZE_SPREADS,
    TOP_M,
    WATER_C,
)
from rtbow.physics.constants import VISIBLE_NM
from rtbow.physics.drop.medium import Medium
from rtbow.scene.aim import LOOKED_AT, box_around, look_deg
from rtbow.scene.air import Atmosphere, Ground
from rtbow.scene.droplets import Droplets
from rtbow.scene.lens import FOCAL_LENGTHS_MM, with_field_of_view
from rtbow.scene.lights import Light, PointLight
from rtbow.scene.panorama import PANORAMA, as_panorama
from rtbow.scene.table import AltitudeDeg, Point, Table, misplaced, refused, shown_as

Pixels = Annotated[int, Field(ge=1, le=16384)]
Look = Literal["antisolar", "sun", "bow-top", "lamp"]
_LOOKS = ", ".join(f'"{look}"' for look in get_args(Look))
Order = Annotated[int, Field(ge=1, le=2)]
SensorSide = Annotated[float, Field(ge=0.5, le=1000)]
Shift = Annotated[float, Field(ge=-2, le=2)]


class Camera(Table):
    """A camera: a lens before a plane, or all directions."""

    position_m: Point = Field(
        (0.0, 0.0, 1.6),
        description="position of the eye: east, north, up",
        json_schema_extra=shown_as(
            "m",
            "Near drops fill more of the view. A lamp's bow changes shape; a sun's stays centred "
            "on the antisolar point.",
            (-2000.0, 2000.0),
        ),
    )
    azimuth_deg: float = Field(
        0.0,
        description="direction of view, clockwise from north",
        json_schema_extra=shown_as(
            "deg", "Turns the view; the bow stands opposite the sun.", (-180.0, 180.0)
        ),
    )
    altitude_deg: AltitudeDeg = Field(
        20.0,
        description="direction of view, above the horizon",
        json_schema_extra=shown_as(
            "deg", "Raises the view; the bow's top stands at 42 degrees less the sun's altitude."
        ),
    )
    look: Look | None = Field(
        None,
        description="what the camera looks at, instead of azimuth_deg and altitude_deg: antisolar "
        "for the point that the bow surrounds, sun, bow-top for the top of the bow, lamp; or "
        "[azimuth, altitude]; left out: azimuth_deg and altitude_deg",
        json_schema_extra=shown_as(
            "", "The view follows the first sun, or the first lamp where there is no sun."
        ),
    )
    projection: Literal["perspective", "panorama"] = Field(
        "perspective",
        description="perspective for the picture of a lens, panorama for all directions: azimuth "
        "across, azimuth_deg in the middle, and altitude, zenith on top; twice as wide as high, "
        "without altitude_deg, fov_deg and what else a lens has",
        json_schema_extra=shown_as(
            "", "A panorama shows the whole bow, its sky and the sun in one picture."
        ),
    )
    fov_deg: float = Field(
        75.0,
        ge=LEAST_FOV_DEG,
        lt=180,
        description="horizontal field of view, the full angle over the width of the picture",
        json_schema_extra=shown_as(
            "deg", "Zooms: the primary bow is 84 degrees across, the secondary 102.", (5.0, 150.0)
        ),
    )
    focal_length_mm: float | None = Field(
        None,
        ge=FOCAL_LENGTHS_MM[0],
        le=FOCAL_LENGTHS_MM[1],
        description="of the lens, instead of fov_deg; the picture takes the largest part of the "
        "sensor that has its shape, and one that is higher than wide turns the sensor",
        json_schema_extra=shown_as(
            "mm",
            "On full frame 20 mm and less show the whole primary bow.",
            (8.0, 400.0),
            log=True,
        ),
    )
    sensor_mm: Annotated[tuple[SensorSide, SensorSide], Strict(False)] | None = Field(
        None,
        description="width and height of the sensor behind that lens; left out: full frame, "
        "[36, 24]",
        json_schema_extra=shown_as("mm", "A smaller sensor sees less through the same lens."),
    )
    roll_deg: float = Field(
        0.0,
        ge=-360,
        le=360,
        description="turn of the camera about its axis, clockwise as the photographer sees it",
        json_schema_extra=shown_as("deg", "Leans the horizon to the other side.", (-90.0, 90.0)),
    )
    lens_shift: Annotated[tuple[Shift, Shift], Strict(False)] = Field(
        (0.0, 0.0),
        description="shift of the lens to the right and up, in widths and heights of the picture: "
        "it shows more of what is there, without a turn of the camera",
        json_schema_extra=shown_as("", "Shows the top of the bow and keeps uprights upright."),
    )
    size_px: Annotated[tuple[Pixels, Pixels], Strict(False)] = Field(
        (1280, 720),
        description="width and height of the picture",
        json_schema_extra=shown_as("px", "More pixels show finer fringes."),
    )
    pixel: Literal["centre", "area"] = Field(
        "centre",
        description="what a pixel shows: centre for the light along the ray through its centre, "
        "area for the mean over its solid angle, as a camera's does, and as the window does where "
        "this is left out and all drops are alike",
        json_schema_extra=shown_as(
            "",
            "Fringes finer than the pixels make false rings (moiré) at their centres; the mean "
            "over their area has none.",
        ),
    )
    polarizer_deg: float | None = Field(
        None,
        ge=-360,
        le=360,
        description="polarising filter in front of the lens: the direction that it passes, "
        "counterclockwise from the picture's horizontal as the eye sees it; left out: no filter",
        json_schema_extra=shown_as(
            "deg",
            "The bow is polarised along its arc: a filter along the arc passes it, one across the "
            "arc almost extinguishes it.",
            (-90.0, 90.0),
        ),
    )

    @model_validator(mode="before")
    @classmethod
    def _through_a_lens(cls, data: Any) -> Any:
        """Fill in the field of view of a lens."""
        size: tuple[int, int] = cls.model_fields["size_px"].default
        return with_field_of_view(data, size) if isinstance(data, dict) else data

    @model_validator(mode="before")
    @classmethod
    def _looks_at_angles(cls, data: Any) -> Any:
        """Take ``look = [azimuth, altitude]`` as these two angles."""
        look = data.get("look") if isinstance(data, dict) else None
        if isinstance(look, str):  # angles that an override leaves out follow from it
            return {k: v for k, v in data.items() if k not in LOOKED_AT or v is not None}
        if not isinstance(look, list | tuple):
            return data
        if not _are_angles(look):
            return data  # refused below
        angles = dict(zip(LOOKED_AT, look, strict=True))
        beside = [key for key in angles if data.get(key) not in (None, angles[key])]
        if beside:
            raise ValidationError.from_exception_data(
                cls.__name__, [_one_too_many((key,), "look") for key in beside]
            )
        return {**data, **angles, "look": None}

    @model_validator(mode="before")
    @classmethod
    def _shows_all_directions(cls, data: Any) -> Any:  # before the others: the last goes first
        """Check and complete a panorama."""
        whole = isinstance(data, dict) and data.get("projection") == PANORAMA
        return as_panorama(data) if whole else data

    @property
    def whole_sphere(self) -> bool:
        """Whether the picture shows all directions."""
        return self.projection == PANORAMA

    @field_validator("look", mode="before")
    @classmethod
    def _looks_at_something(cls, look: object) -> object:
        if look is None or look in get_args(Look):
            return look
        raise refused(
            f"must be one of {_LOOKS}, or [azimuth, altitude] in degrees, the altitude -90..90,"
            " such as [180.0, 20.0]"
        )


def _are_angles(pair: Sequence[object]) -> bool:
    """Whether these are an azimuth and an altitude, degrees."""
    angles = [x for x in pair if isinstance(x, int | float) and not isinstance(x, bool)]
    return len(angles) == len(pair) == 2 and math.isfinite(angles[0]) and -90 <= angles[1] <= 90


def _one_too_many(path: tuple[str, ...], other: str) -> InitErrorDetails:
    """Return the problem of a key that stands beside another one, which says the same."""
    return misplaced(path, f"cannot be given together with {other}; leave one of the two out")


class Scattering(Table):
    """How a drop scatters light."""

    theory: Literal["airy", "mie"] = Field(
        "airy",
        description="theory of the single drop: airy for the two bows alone, mie for all that a "
        "sphere scatters, exactly",
        json_schema_extra=shown_as(
            "", "Mie adds the glory, the corona and the light between the bows."
        ),
    )
    size_spread: float = Field(
        0.02,
        ge=SIZE_SPREADS[0],
        le=SIZE_SPREADS[1],
        description="standard deviation of ln(radius) about each drop size, which blurs the "
        "resonances of a single size (mie); 0.02 is 2 %",
        json_schema_extra=shown_as("", "More spread blurs the finest fringes."),
    )
    orders: Annotated[tuple[Order, ...], Strict(False)] = Field(
        (1, 2),
        min_length=1,
        description="internal reflections: 1 for the primary bow, 2 for the secondary; mie has all",
        json_schema_extra=shown_as("", "The secondary bow is reversed and paler."),
    )
    water_temperature_c: float = Field(
        20.0,
        ge=WATER_C[0],
        le=WATER_C[1],
        description="sets the refractive index of water",
        json_schema_extra=shown_as(
            "°C",
            "Warmer water bends light less: the bow widens by a hundredth of a degree per kelvin.",
        ),
    )
    salinity_g_kg: float = Field(
        0.0,
        ge=SALINITIES_G_KG[0],
        le=SALINITIES_G_KG[1],
        description="salt in the water, of which the sea has 35; at 0 to 30 °C",
        json_schema_extra=shown_as(
            "g/kg", "Sea water bends light more: the bow of sea spray is 0.9 degrees smaller."
        ),
    )
    refractive_index: float | None = Field(
        None,
        description="index of refraction relative to air at all wavelengths, 1.2..1.9, instead of "
        "water's; left out: water",
        json_schema_extra=shown_as(
            "", "A higher index makes a smaller bow, of 23 degrees with 1.5.", INDICES
        ),
    )

    @field_validator("orders")
    @classmethod
    def _each_order_once(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) < len(value):
            raise refused("must name each order once, such as [1, 2]")
        return tuple(sorted(value))

    @field_validator("salinity_g_kg")
    @classmethod
    def _salt_water_is_known(cls, salinity: float, info: ValidationInfo) -> float:
        low, high = SALT_WATER_C
        temperature_c = info.data.get("water_temperature_c", low)
        if salinity and not low <= temperature_c <= high:
            raise refused(
                f"goes with a water_temperature_c of {low:g}..{high:g} °C, over which the index of "
                f"sea water is known; it is {temperature_c:g}"
            )
        return salinity

    @field_validator("refractive_index")
    @classmethod
    def _has_bows(cls, index: float | None, info: ValidationInfo) -> float | None:
        if index is None:
            return None
        low, high = INDICES
        if not low <= index <= high:
            raise refused(
                f"must be {low:g}..{high:g}, relative to air: from 2 on a sphere has no primary "
                "bow, and close to it that is lost in the glory"
            )
        if info.data.get("salinity_g_kg"):
            raise refused("replaces the index of water: leave salinity_g_kg out")
        return index

    @property
    def medium(self) -> Medium:
        """What the drops are made of."""
        return Medium(self.water_temperature_c, self.salinity_g_kg, self.refractive_index)


class Render(Table):
    """How finely the picture is computed."""

    wavelength_step_nm: float = Field(
        5.0,
        ge=0.05,
        le=40,
        description="step between wavelengths, which must divide 400 nm evenly; methods "
        "spectral and reference",
        json_schema_extra=shown_as(
            "nm", "Coarse steps show as bands in fringes and under line spectra.", log=True
        ),
    )
    steps: int | None = Field(
        None,
        ge=1,
        le=100_000,
        description="samples along a ray; left out: set by the grid",
        json_schema_extra=shown_as("", "Few samples miss shafts of rain.", (1.0, 1000.0), log=True),
    )
    max_delta_e: float = Field(
        DEFAULT_DELTA_E,
        ge=LEAST_DELTA_E,
        le=MOST_DELTA_E,
        description="error allowed to method fast: colour difference from the truth (CIEDE2000, "
        "99th percentile of pixels)",
        json_schema_extra=shown_as("", "Pictures with larger errors are drawn faster.", log=True),
    )

    samples: int = Field(
        4096,
        ge=16,
        le=10_000_000,
        description="random walks of light from each ray where drops are lit by others, sky or "
        "ground; method reference",
        json_schema_extra=shown_as(
            "", "Four times as many halve the noise.", (256.0, 65536.0), log=True
        ),
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
    """Return the nearest step (nm) of at most four decimals that divides 400 nm evenly."""
    while 4_000_000 % count:
        count += direction
    return f"{400 / count:.4f}".rstrip("0").rstrip(".")


class Compare(Table):
    """A picture split between the scene as it stands and the scene with some keys changed."""

    split: float = Field(
        0.5,
        ge=0,
        le=1,
        description="fraction of the width, from the left, that shows the scene as it stands",
        json_schema_extra=shown_as("", "Where the two pictures meet."),
    )
    right: dict[str, Any] = Field(
        description='keys and values of the right part, such as { "atmosphere.rayleigh" = false }',
        json_schema_extra=shown_as("", "Changes the scene on the right."),
    )

    def __hash__(self) -> int:
        return hash((self.split, *sorted(self.right)))


_AnyTable = TypeVar("_AnyTable", bound=Table)


class Scene(Table):
    """Everything that a picture depends on.

    Two scenes are equal when their values are, whatever text they came from.
    """

    camera: Camera = Field(Camera(), description="the eye")
    light: Annotated[tuple[Light, ...], Strict(False)] = Field(
        min_length=1, description="the lights, one or more"
    )
    droplets: Droplets = Field(description="the drops")
    atmosphere: Atmosphere | None = Field(None, description="the air; left out: none")
    ground: Ground | None = Field(None, description="the ground; left out: none")
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

    @model_validator(mode="after")
    def _aimed(self) -> Self:
        self._aim()
        return self

    def _aim(self) -> None:
        """Fill in where rain around the camera is, and where a camera looks that follows a light.

        What follows is no value that was given, so that it is worked out anew with other lights.
        """
        droplets, camera = self.droplets, self.camera
        if droplets.around_m is not None:
            ground_m = 0.0 if self.ground is None else self.ground.height_m
            box = {"box_m": box_around(camera.position_m, droplets.around_m, ground_m)}
            object.__setattr__(self, "droplets", self._following(droplets, box, "around_m"))
        if camera.look is not None:
            angles = dict(zip(LOOKED_AT, self._look_deg(camera.look), strict=True))
            if camera.whole_sphere:
                angles["altitude_deg"] = 0.0
            object.__setattr__(self, "camera", self._following(camera, angles, "look"))

    def _following(
        self, table: _AnyTable, values: dict[str, Any], source: Literal["look", "around_m"]
    ) -> _AnyTable:
        """Return a table with values that follow from another key; others must not be given."""
        name = "camera" if source == "look" else "droplets"
        given = (key for key in values if key in table.model_fields_set)
        beside = [key for key in given if getattr(table, key) not in (None, values[key])]
        if beside:
            problems = [_one_too_many((name, key), f"{name}.{source}") for key in beside]
            raise ValidationError.from_exception_data(type(self).__name__, problems)
        copy = table.model_copy(update=values)
        copy.model_fields_set.difference_update(values)
        return copy

    def _look_deg(self, look: Look) -> tuple[float, float]:
        reflections = 1 if self.scattering.theory == "mie" else self.scattering.orders[0]
        bow_deg = self.scattering.medium.bow_radius_deg(reflections)
        try:
            return look_deg(look, self.light, self.camera.position_m, bow_deg, self.droplets.box_m)
        except PydanticCustomError as error:
            problem = InitErrorDetails(type=error, loc=("camera", "look"), input=look)
            raise ValidationError.from_exception_data(type(self).__name__, [problem]) from None

    @model_validator(mode="after")
    def _air_reaches_down(self) -> Self:
        """Refuse what lies far below the ground, where there is air."""
        if self.atmosphere is None or not self.atmosphere.rayleigh:
            return self
        places: list[tuple[tuple[str | int, ...], Point]] = [
            (("camera", "position_m"), self.camera.position_m)
        ]
        for number, light in enumerate(self.light):
            if isinstance(light, PointLight):
                places.append((("light", number, light.type, "position_m"), light.position_m))
        if self.droplets.box_m is not None:
            places.append((("droplets", "box_m"), self.droplets.box_m[0]))
        problems = [
            InitErrorDetails(
                type=refused(
                    f"{at[2]:g} m up; must be {DEEPEST_AIR_M:g} m at least where"
                    " atmosphere.rayleigh = true: no light gets through the air below"
                ),
                loc=key,
                input=list(at),
            )
            for key, at in places
            if at[2] < DEEPEST_AIR_M
        ]
        if problems:
            raise ValidationError.from_exception_data(type(self).__name__, problems)
        return self

    @property
    def glows(self) -> bool:
        """Whether the air's own light is drawn."""
        return self.atmosphere is not None and self.atmosphere.sky

    @property
    def has_surroundings(self) -> bool:
        """Whether the air's own light or a ground is drawn."""
        return self.glows or self.ground is not None

    @model_validator(mode="after")
    def _eye_in_the_air(self) -> Self:
        """Refuse an eye in the ground or above the air, where they are drawn."""
        height = self.camera.position_m[2]
        lowest = 0.0 if self.ground is None else self.ground.height_m
        if not self.has_surroundings or lowest <= height <= TOP_M + lowest:
            return self
        problem = InitErrorDetails(
            type=refused(
                f"{height:g} m up; must be {lowest:g}..{TOP_M + lowest:g} with atmosphere.sky or"
                " ground: above the ground, and where air is taken to be"
            ),
            loc=("camera", "position_m"),
            input=list(self.camera.position_m),
        )
        raise ValidationError.from_exception_data(type(self).__name__, [problem])

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
        """Return the scenes that make up the picture and the columns of each, left to right.

        Raises:
            InputError: there is a ``compare``, but no scene of its right part, which comes with
                scenes that are loaded.
        """
        width = self.camera.size_px[0]
        if self.compare is None:
            return ((self, slice(0, width)),)
        if self._right is None:
            raise InputError(
                f"{self._source_name}: compare lacks the scene of its right part; load the "
                "scene with load_scene or scene_from_text, or add that part using with_right"
            )
        column = round(self.compare.split * width)
        both = ((self, slice(0, column)), (self._right, slice(column, width)))
        return tuple(part for part in both if part[1].start < part[1].stop)

    def with_camera(self, camera: Camera) -> Self:
        """Return the same scene with another camera; what follows from its place follows.

        Raises:
            ValidationError: the camera looks at a light that the scene lacks.
        """
        copy = self.model_copy(update={"camera": camera})
        copy._aim()
        return copy

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
