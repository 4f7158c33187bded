"""Frames as pictures in a notebook."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import InputError
from rtbow.frames.display import EV_LIMIT, auto_exposure_ev, display, require_finite
from rtbow.frames.image import png_bytes


@dataclass(frozen=True, eq=False)
class Picture:
    """A frame as displayed; a notebook draws it where a cell ends with one.

    Attributes:
        rgb: 8 bit sRGB (h, w, 3), first row on top.
        exposure_ev: exposure value (ISO 100) that it is shown at.
    """

    rgb: NDArray[np.uint8]
    exposure_ev: float

    def _repr_png_(self) -> bytes:
        """Give the PNG that IPython and Jupyter draw."""
        return png_bytes(self.rgb, {"exposureEV100": f"{self.exposure_ev:.6g}"})

    def __repr__(self) -> str:
        height, width = self.rgb.shape[:2]
        return f"<picture of {width} x {height} pixels at EV {self.exposure_ev:.2f}>"


def tone_map(frame: NDArray[np.float32], ev: float | None = None) -> NDArray[np.uint8]:
    """Give the picture that a frame is as a ``.png``: exposed, brought into gamut, sRGB.

    Args:
        frame: linear Rec. 709 in cd/m² (h, w, 3), as :meth:`rtbow.Renderer.render` gives it.
        ev: exposure value (ISO 100), as after ``--exposure``; None chooses one by the frame.

    Returns:
        8 bit sRGB (h, w, 3), first row on top.

    Raises:
        InputError: not such an array, or no such exposure.
        RtbowError: the frame holds a NaN or an infinity.
    """
    return _picture("tone_map", frame, "ev", ev).rgb


def show(frame: NDArray[np.float32], exposure_ev: float | None = None) -> Picture:
    """Show a frame in a notebook: the value of a cell's last line, or an argument of ``display``.

    Args:
        frame: linear Rec. 709 in cd/m² (h, w, 3), as :meth:`rtbow.Renderer.render` gives it.
        exposure_ev: exposure value (ISO 100); None chooses one by the frame.

    Returns:
        The picture; the frame stays as it is.

    Raises:
        InputError: not such an array, or no such exposure.
        RtbowError: the frame holds a NaN or an infinity.
    """
    return _picture("show", frame, "exposure_ev", exposure_ev)


def _picture(
    caller: str, frame: NDArray[np.float32], name: str, exposure_ev: float | None
) -> Picture:
    """Check a frame and an exposure, for a caller and its argument's name, and show it."""
    numbers = isinstance(frame, np.ndarray) and frame.dtype.kind in "fiu"
    if not numbers or frame.ndim != 3 or frame.shape[2] != 3 or not frame.size:
        what = f"{type(frame).__name__} {getattr(frame, 'shape', '')}".rstrip()
        raise InputError(
            f"{caller} takes a frame, an array of numbers (height, width, 3), not {what}; pass what"
            " Renderer.render() returns"
        )
    radiance = frame.astype(np.float32)
    require_finite(radiance)
    if exposure_ev is None:
        exposure_ev = auto_exposure_ev(radiance)
    elif (
        isinstance(exposure_ev, bool)
        or not isinstance(exposure_ev, int | float | np.number)
        or not abs(exposure_ev) <= EV_LIMIT  # NaN is not
    ):
        raise InputError(
            f"{name} = {exposure_ev!r}; must be a number, {-EV_LIMIT:g}..{EV_LIMIT:g} EV, such"
            " as 13, or None for one chosen by the frame"
        )
    return Picture(display(radiance, float(exposure_ev)), float(exposure_ev))
