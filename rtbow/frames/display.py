"""From radiance to a displayed picture: exposure, gamut, sRGB curve and dithering.

Exposure follows photography: at exposure value EV (for ISO 100) a camera's brightest
luminance is ``L_max = 78 / (S q) · 2^EV = 1.2 · 2^EV`` cd/m², from ISO 12232's saturation-based
speed with S = 100 and a lens and vignetting factor q = 0.65. A pixel's displayed value, before the
sRGB curve, is luminance over ``L_max``. Sunlit scenes lie near EV 15, one more EV halves the
picture's brightness.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow.base.errors import InputError, RtbowError
from rtbow.physics.light.colour import LUMINANCE_WEIGHTS

# 78 / (100 · 0.65): cd/m² that saturate the camera at EV 0.
SATURATION_LUMINANCE_EV0 = 1.2
# Automatic exposure keeps this share of the pixels' brightest components ...
AUTO_QUANTILE = 0.995
# ... at or below this share of full scale, which leaves room for the bow's saturated colours.
AUTO_LEVEL = 0.8
# The exposure of a sunlit scene ("sunny 16"); a black frame is black at any value.
BLACK_FRAME_EV = 15.0
# float32 luminances span about ±149 powers of two; automatic exposure always stays inside.
EV_LIMIT = 200.0

Floats = NDArray[np.floating[Any]]


def require_finite(rgb: Floats) -> None:
    """Raise RtbowError, naming the first such pixel, if a frame holds a NaN or an infinity.

    Args:
        rgb: Frame, shape (h, w, 3).

    Raises:
        RtbowError: A component is not finite. Every later clamp would hide it.
    """
    finite = np.isfinite(rgb)
    if finite.all():
        return
    bad = ~finite.all(axis=-1)
    row, column = (int(i) for i in np.unravel_index(np.argmax(bad), bad.shape))
    raise RtbowError(
        f"frame: pixel row {row}, column {column} is {rgb[row, column].tolist()}, and "
        f"{int(bad.sum())} of {bad.size} pixels are not finite; "
        "this is a defect of rtbow: please report it with the scene"
    )


def max_luminance(exposure_ev: float) -> float:
    """Return the luminance in cd/m² that is shown as full white at an exposure value (ISO 100).

    Raises:
        InputError: The exposure value is not within ±200, far beyond anything that floats hold.
    """
    if not abs(exposure_ev) <= EV_LIMIT:
        raise InputError(
            f"exposure: {exposure_ev:g}; must be auto or -{EV_LIMIT:g}..{EV_LIMIT:g} EV (ISO 100); "
            "a sunlit scene has about 15, a lamp at night about 4"
        )
    return SATURATION_LUMINANCE_EV0 * math.exp2(exposure_ev)


def auto_exposure_ev(rgb: Floats) -> float:
    """Return the exposure value at which a frame is well exposed.

    The 99.5th percentile of the brightest component, over all pixels with light, is brought to 0.8
    of full scale. Negative components are brought into gamut first, so that the saturated colours
    of a bow are judged as they will be shown.

    Args:
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3).

    Returns:
        Exposure value for ISO 100; 15 for a frame without any light.

    Raises:
        RtbowError: A component is not finite.
    """
    require_finite(rgb)
    brightest = gamut_map(rgb, white=math.inf).max(axis=-1)
    lit = brightest[brightest > 0.0]
    if lit.size == 0:
        return BLACK_FRAME_EV
    level = float(np.quantile(lit, AUTO_QUANTILE))
    # Two logarithms: the quotient of a very small level would leave the range of floats.
    return math.log2(level) - math.log2(AUTO_LEVEL * SATURATION_LUMINANCE_EV0)


def gamut_map(rgb: Floats, white: float = 1.0) -> NDArray[np.float64]:
    """Move colours that cannot be shown towards the grey of equal luminance until they can.

    A colour with a negative component moves until its least component is 0, one with a component
    above ``white`` until its greatest is ``white``; luminance and hue's direction are kept. A
    luminance above ``white`` gives white, one of 0 or less gives black.

    Args:
        rgb: Linear Rec. 709, shape (..., 3).
        white: Greatest value that can be shown; infinity leaves bright colours alone.

    Returns:
        Colours of the same shape, every component in [0, white].
    """
    colours = np.asarray(rgb, dtype=np.float64)
    grey = np.clip(colours @ LUMINANCE_WEIGHTS, 0.0, white)[..., np.newaxis]
    least = colours.min(axis=-1, keepdims=True)
    greatest = colours.max(axis=-1, keepdims=True)
    # Share of the way from grey to the colour that can be shown.
    share = np.ones_like(grey)
    np.divide(grey, grey - least, out=share, where=least < 0.0)
    if math.isfinite(white):
        room = np.ones_like(grey)
        np.divide(white - grey, greatest - grey, out=room, where=greatest > white)
        share = np.minimum(share, room)
    # The clip takes off rounding only: 1e-16 of the grey.
    return np.clip(grey + share * (colours - grey), 0.0, white)


def srgb_encode(linear: Floats) -> NDArray[np.float64]:
    """Return the sRGB code values in [0, 1] of linear values in [0, 1] (IEC 61966-2-1)."""
    values = np.asarray(linear, dtype=np.float64)
    return np.where(
        values <= 0.0031308,
        12.92 * values,
        1.055 * np.maximum(values, 0.0031308) ** (1.0 / 2.4) - 0.055,
    )


def display(rgb: Floats, exposure_ev: float) -> NDArray[np.uint8]:
    """Return the picture that a frame shows on an sRGB display.

    Rounding is dithered by up to half a code value either way, so that smooth dark gradients do
    not band; the same frame always gives the same picture. All three channels share the dither
    and grey stays grey.

    Args:
        rgb: Linear Rec. 709 in cd/m², shape (h, w, 3).
        exposure_ev: Exposure value for ISO 100.

    Returns:
        8 bit sRGB, shape (h, w, 3).

    Raises:
        InputError: The exposure value is out of range.
        RtbowError: A component is not finite.
    """
    require_finite(rgb)
    height, width = rgb.shape[:2]
    relative = np.asarray(rgb, dtype=np.float64) / max_luminance(exposure_ev)
    codes = 255.0 * srgb_encode(gamut_map(relative))
    return np.floor(codes + _dither(height, width)[..., np.newaxis]).astype(np.uint8)


def _dither(height: int, width: int) -> NDArray[np.float64]:
    """Return interleaved gradient noise inside (0, 1): even within any 3 × 3 pixels.

    Source: J. Jimenez, Next Generation Post Processing in Call of Duty: Advanced Warfare,
    SIGGRAPH 2014.
    """
    x = np.arange(width, dtype=np.float64)
    y = np.arange(height, dtype=np.float64)[:, np.newaxis]
    noise = np.mod(52.9829189 * np.mod(0.06711056 * x + 0.00583715 * y, 1.0), 1.0)
    # Kept off 0 and 1, so that rounding does not change a whole code value.
    return 0.001 + 0.998 * noise
