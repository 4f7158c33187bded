"""A camera as photographers have it: a lens of some focal length before a sensor."""

from __future__ import annotations

import math
from typing import Any

from pydantic import ValidationError

from rtbow.scene.table import misplaced

FULL_FRAME_MM = (36.0, 24.0)
"""The sensor where none is given."""
FOCAL_LENGTHS_MM = (0.1, 1e4)
LENS_KEYS = ("focal_length_mm", "sensor_mm")


def frame_width_mm(sensor_mm: tuple[float, float], size_px: tuple[int, int]) -> float:
    """Give the width of the part of a sensor that a picture takes, mm.

    It is the largest part of the picture's shape. A picture that is higher than wide is taken with
    the camera turned: the sensor's long side stands upright, too.

    Args:
        sensor_mm: width and height.
        size_px: width and height of the picture.
    """
    long, short = max(sensor_mm), min(sensor_mm)
    width, height = size_px
    across, upright = (long, short) if width >= height else (short, long)
    return min(across, upright * width / height)


def field_of_view_deg(width_mm: float, focal_length_mm: float) -> float:
    """Give the angle that a lens has over a width of the sensor."""
    return math.degrees(2.0 * math.atan(0.5 * width_mm / focal_length_mm))


def zoomed(camera: Any, fov_deg: float) -> dict[str, float]:
    """Give the values of a camera's keys that another horizontal field of view changes."""
    changed = {"fov_deg": fov_deg}
    if camera.focal_length_mm is not None:
        # Of the width that the camera has: a window may show its picture in another size.
        old, new = (math.tan(math.radians(0.5 * fov)) for fov in (camera.fov_deg, fov_deg))
        low, high = FOCAL_LENGTHS_MM
        changed["focal_length_mm"] = min(max(camera.focal_length_mm * old / new, low), high)
    return changed


def with_field_of_view(data: dict[str, Any], size_px: tuple[int, int]) -> dict[str, Any]:
    """Fill in a camera's field of view from its lens.

    Args:
        data: the camera's values, which need not be valid; what is wrong is refused later.
        size_px: of the picture, where they do not say it.

    Raises:
        ValidationError: both are given, or a sensor without a lens.
    """
    focal, sensor = (data.get(key) for key in LENS_KEYS)
    if focal is None:
        if sensor is not None:
            raise _misplaced("sensor_mm", "goes with focal_length_mm; give that, too, or leave it")
        return data
    size = _pair(data.get("size_px", size_px))
    sides = _pair(FULL_FRAME_MM if sensor is None else sensor)
    if size is None or sides is None or not _positive(focal):
        return data
    fov_deg = field_of_view_deg(frame_width_mm(sides, (int(size[0]), int(size[1]))), focal)
    given = data.get("fov_deg")
    if given is not None and given != fov_deg:
        raise _misplaced(
            "fov_deg",
            f"cannot be given together with focal_length_mm = {focal:g}, which makes it"
            f" {fov_deg:.4g}; leave one of the two out",
        )
    return {**data, "fov_deg": fov_deg}


def _pair(value: object) -> tuple[float, float] | None:
    """Give two positive numbers; None if they are not."""
    if isinstance(value, list | tuple) and len(value) == 2 and all(map(_positive, value)):
        return value[0], value[1]
    return None


def _positive(value: object) -> bool:
    """Whether a value is a number that a length or a count can be."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and 1e-3 < value < 1e6  # type: ignore[operator]


def _misplaced(key: str, message: str) -> ValidationError:
    return ValidationError.from_exception_data("Camera", [misplaced((key,), message)])
