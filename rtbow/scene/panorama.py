"""A camera that shows the whole sphere: what it has no use for, and the shape of its picture."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError
from pydantic_core import InitErrorDetails

from rtbow.scene.table import misplaced, refused

PANORAMA = "panorama"
DEFAULT_SIZE_PX = (1280, 640)
"""Of a picture whose scene does not say it."""
LENS_ALONE: dict[str, tuple[object, ...]] = {
    "altitude_deg": (0,), "fov_deg": (), "focal_length_mm": (), "sensor_mm": (), "roll_deg": (0,),
    "lens_shift": ([0, 0], (0, 0)),
}  # fmt: skip
"""Keys that only a camera with a lens has a use for, with the values that change nothing."""
_GIVEN = f'camera.projection = "{PANORAMA}"'


def as_panorama(data: dict[str, Any]) -> dict[str, Any]:
    """Check and complete the values of a panorama's camera.

    Args:
        data: the camera's values, which need not be valid; what else is wrong is refused later.

    Returns:
        The same with those that follow: the camera is level, and its picture twice as wide as high.

    Raises:
        ValidationError: keys of a lens, a look up or down, or a picture of another shape.
    """
    data = {key: value for key, value in data.items() if key not in LENS_ALONE or value is not None}
    problems = [
        misplaced(
            (key,),
            f"cannot be given together with {_GIVEN}, which shows all directions; leave it out, or"
            ' set camera.projection = "perspective"',
        )
        for key, idle in LENS_ALONE.items()
        if key in data and data[key] not in idle
    ]
    look = data.get("look")
    if isinstance(look, list | tuple) and len(look) == 2 and look[1] != 0:
        problems.append(
            _refused("look", look, f"must have an altitude of 0 with {_GIVEN}, which stays level")
        )
    size = data.setdefault("size_px", DEFAULT_SIZE_PX)
    if _is_pair(size) and size[0] != 2 * size[1]:
        wide, high = fitting(size)
        problems.append(
            _refused(
                "size_px", size,
                f"must be twice as wide as high with {_GIVEN}, such as [{wide}, {high}]",
            )
        )  # fmt: skip
    if problems:
        raise ValidationError.from_exception_data("Camera", problems)
    return data if isinstance(look, str) else {"altitude_deg": 0.0, **data}


def fitting(size: tuple[int, int]) -> tuple[int, int]:
    """Give the size of a panorama that is as wide as a picture, to an even number."""
    high = max(size[0] // 2, 1)
    return 2 * high, high


def make_whole(camera: dict[str, Any], given: set[str]) -> None:
    """Turn the values of a camera with a lens into those of a panorama, in place.

    Args:
        camera: the values, which need not be valid.
        given: keys that stay, whatever they say.
    """
    look = camera.get("look")
    if "look" not in given and isinstance(look, list | tuple) and len(look) == 2:
        del camera["look"]
        camera.setdefault("azimuth_deg", look[0])
    for key in LENS_ALONE.keys() - given:
        camera.pop(key, None)
    size: Any = camera.get("size_px")
    if "size_px" not in given and _is_pair(size) and size[0] != 2 * size[1]:
        camera["size_px"] = list(fitting(size))


def _refused(key: str, value: object, message: str) -> InitErrorDetails:
    return InitErrorDetails(type=refused(message), loc=(key,), input=value)


def _is_pair(size: Any) -> bool:
    """Whether a value is a size, two whole numbers."""
    pair = isinstance(size, list | tuple) and len(size) == 2
    return pair and all(isinstance(x, int) and not isinstance(x, bool) and x > 0 for x in size)
