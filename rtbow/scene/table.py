"""The base of a scene's tables, the metadata of their fields, and errors about them.

Every field carries its description, unit and allowed range, so that panels, documents and error
messages have one source.
"""

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, Strict
from pydantic.config import JsonDict
from pydantic_core import InitErrorDetails, PydanticCustomError

from rtbow.base.limits import MAX_COORDINATE_M

# TOML has lists where the models have tuples, hence Strict(False).
Coordinate = Annotated[float, Field(ge=-MAX_COORDINATE_M, le=MAX_COORDINATE_M)]
Point = Annotated[tuple[Coordinate, Coordinate, Coordinate], Strict(False)]
AltitudeDeg = Annotated[float, Field(ge=-90, le=90)]


class Table(BaseModel):
    """A TOML table: frozen, no unknown keys, no conversions but int to float, no NaN, no inf."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def number(value: object) -> float | None:
    """Give a value as what is computed from it before it is checked takes it: a float, infinite
    where a whole number is beyond all floats; None where it is no number."""
    if not isinstance(value, float | int):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def refused(message: str) -> PydanticCustomError:
    """Return the error for a value: shown as ``key = value; message``."""
    return PydanticCustomError("refused", "{message}", {"message": message})


def misplaced(path: tuple[str, ...], message: str) -> InitErrorDetails:
    """Return the problem of a key in the wrong place: shown as ``key message``."""
    error = PydanticCustomError("misplaced", "{message}", {"message": message})
    return InitErrorDetails(type=error, loc=path, input=None)


def missing(path: tuple[str, ...], remedy: str) -> InitErrorDetails:
    """Return the problem of a missing key: shown as ``key is missing; remedy``."""
    error = PydanticCustomError("missing_here", "{message}", {"message": remedy})
    return InitErrorDetails(type=error, loc=path, input=None)


def shown_as(
    unit: str, effect: str, usual: tuple[float, float] | None = None, *, log: bool = False
) -> JsonDict:
    """Return the metadata with which panels and documents show a field.

    Args:
        unit: empty for names, switches and counts.
        effect: what the field does to the bow.
        usual: range of a slider, where the allowed range is far wider.
        log: whether the slider is logarithmic.
    """
    shown: JsonDict = {"unit": unit, "effect": effect}
    if usual is not None:
        shown["usual"] = [*usual]
    if log:
        shown["log"] = True
    return shown
