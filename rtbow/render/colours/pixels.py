"""Colours averaged over pixels of several extents, where a pixel is a mean over its solid angle.

Across a pixel the scattering angle, or the folded chord that stands for it in a table, changes by
u along one side and by v along the other, evenly but for terms of second order: its values are
those of a trapezoid, the convolution of two boxes of the widths u and v, with the variance
(u² + v²) / 12. A table's colours are averaged over such trapezoids ahead, at levels of ``u² + v²``
and for some shapes. A pixel interpolates between the levels, and takes the nearest shape.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.world.camera.view import View

RIGHT_ANGLE_CHORD = float(np.sqrt(2.0))
"""The chord of a right angle in the unit circle, at which chords are folded."""
_STEP = 0.14
"""Distance of levels in the logarithm of the squared width, with what is blurred anyway."""
_MOST_SHAPES = 12
"""Shapes where pixels are wider than what is blurred anyway; fewer where they are narrower."""
_SHAPES_PER_LEVEL = 2.0
"""Where a table has not room for all lines, it has so many levels for each shape, or fewer."""
_SHARP = 0.5
"""Squared width over what is blurred anyway from which on all shapes are told apart."""
_MOST_TEXELS = 6_000_000
"""A table with all its lines has no more texels than about this, 96 MB: shapes and levels are left
out in turn, in volumes of many radii, which blur their fringes themselves."""
_NARROWEST = 1e-3
"""A box narrower than this, in columns of a table, is its middle."""
_AT_POLE = 1e-9
"""How near to a pole a table ends that reaches it."""
_ROAMING = 2.0
"""Tables of suns that move serve pixels up to this many times as wide, as in smaller pictures."""


@dataclass(frozen=True)
class PixelLevels:
    """Extents of pixels that a table has levels for.

    Attributes:
        squared: u² + v² of each level (L,), ascending, rad².
        shapes: how many shapes; they are even in 2 u v / (u² + v²), at the middles of as many
            parts.
        blur: what is added before the logarithm is taken in which levels are even, rad².
    """

    squared: Array
    shapes: int
    blur: float

    def extents(self) -> Iterator[tuple[float, float]]:
        """Give u and v of each line of a table: all levels of a shape, one shape after another."""
        for shape in (np.arange(self.shapes) + 0.5) / self.shapes:
            ratio = (1.0 - np.sqrt(1.0 - shape**2)) / shape
            for squared in self.squared:
                wide = float(np.sqrt(squared / (1.0 + ratio**2)))
                yield wide, float(ratio) * wide

    @property
    def first(self) -> float:
        """Logarithm of the first level."""
        return float(np.log(self.squared[0] + self.blur))

    @property
    def per_level(self) -> float:
        """Levels per unit of the logarithm."""
        last = float(np.log(self.squared[-1] + self.blur))
        return (len(self.squared) - 1) / (last - self.first)

    def hold(self, view: View) -> bool:
        """Whether all pixels of a picture have a level above them."""
        return view.pixel_rad**2 <= float(self.squared[-1]) + 1e-3 * self.blur


def pixel_levels(view: View, blur_rad: float, texels: int, *, roaming: bool) -> PixelLevels:
    """Choose levels for a picture, the first for no extent: at the edges of the rain parts of
    pixels count.

    At an angle α from the axis a pixel is p cos²α wide outwards and p cos α across, where p is the
    width of the picture plane's pixels at distance 1. ``u² + v²`` is the square of its width along
    the gradient of the scattering angle, whichever way that points, and p² at most; so is that of
    the chord, which grows no faster than the angle.

    Args:
        view: the picture.
        blur_rad: width of the finest detail that the light's disc leaves, as a radius.
        texels: of the table without levels.
        roaming: for other pictures, too.
    """
    most = (view.pixel_rad * (_ROAMING if roaming else 1.0)) ** 2
    blur = 3.0 * blur_rad**2  # a disc's variance, r² / 4, is that of a box of the width r √3
    rise, lines = float(np.log1p(most / blur)), max(_MOST_TEXELS // texels, 2)
    levels = 2 + int(rise / _STEP)
    shapes = 1 + int((_MOST_SHAPES - 1) * min(most / (_SHARP * blur), 1.0))
    while levels * shapes > lines and levels > 2:
        if shapes > 1 and shapes * _SHAPES_PER_LEVEL > levels:
            shapes -= 1
        else:
            levels -= 1
    return PixelLevels(floats(blur * np.expm1(np.linspace(0.0, rise, levels))), shapes, blur)


def over_pixels(values: Array, chord: Array, levels: PixelLevels) -> Array:
    """Average values over pixels, for each line of a table.

    Args:
        values: at folded chords, straight lines between them (..., N, C).
        chord: the chords, even and ascending (N,). What lies beyond a pole is mirrored; beyond
            other ends the last value holds.
        levels: the pixels' extents.

    Returns:
        The means (..., lines, N, C).
    """
    ends = chord[0] < _AT_POLE, chord[-1] > 2.0 * RIGHT_ANGLE_CHORD - _AT_POLE
    step = float(chord[-1] - chord[0]) / (len(chord) - 1)
    lines = []
    for extents in levels.extents():
        mean = np.moveaxis(values, -2, 0)
        for width in extents:
            mean = _box_mean(mean, width / step, ends)
        lines.append(np.moveaxis(mean, 0, -2))
    return np.stack(lines, axis=-3)


def _box_mean(values: Array, width: float, mirrored: tuple[bool, bool]) -> Array:
    """Average over a box about each of some even places, exactly for straight lines between them.

    Args:
        values: along the first axis (N, ...).
        width: of the box, in distances of places.
        mirrored: whether what lies before and behind is the mirror image, not the last value.
    """
    if width < _NARROWEST:
        return values
    # One place more than the box reaches beyond, so that it ends inside.
    reach, count = 0.5 * width, len(values)
    beyond = int(reach) + 2
    place = np.arange(-beyond, count + beyond)
    if mirrored[0]:
        place = np.abs(place)
    if mirrored[1]:
        place = np.where(place >= count, 2 * (count - 1) - place, place)
    wide = values[np.clip(place, 0, count - 1)]
    rise = np.zeros_like(wide)
    np.cumsum(0.5 * (wide[1:] + wide[:-1]), axis=0, out=rise[1:])

    def integral(shift: float) -> Array:
        first, part = divmod(beyond + shift, 1.0)
        at, after = (
            slice(int(first), int(first) + count),
            slice(int(first) + 1, int(first) + 1 + count),
        )
        slope = 0.5 * part * (wide[after] - wide[at])
        return floats(rise[at] + part * (wide[at] + slope))

    return floats((integral(reach) - integral(-reach)) / width)
