"""Fields of air without aerosol, interpolated among some that were solved ahead.

At each wavelength such a field depends on the depths of molecules and ozone and on what the ground
sends back. Fields of some depths and grounds come with the program (``tools/make_clear_sky.py``
makes them), so that no clear sky has to be solved for: polynomials in the depths go through their
logarithms, and over the albedo A a field is f + a A / (1 - s A), a series of reflections between
ground and air.

Against fields that are solved for, they are within 0.1 % at all nodes down to suns at -6 degrees,
and within 7 % to -17, where a ten-thousandth of a day's light is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rtbow.base.arrays import Array, floats
from rtbow.base.resources import resource_dir
from rtbow.tables.sky.light import Air, Scattered

MOST_MOLECULES, MOST_OZONE = 0.55, 0.06
"""Depths up to which fields are known: at 365 nm, and of 440 DU."""
_COUNT = 12
MOLECULES = 0.5 * MOST_MOLECULES * (1.0 - np.cos(np.pi * (np.arange(_COUNT) + 0.5) / _COUNT))
"""Chebyshev's nodes."""
OZONE = floats([0.0, 0.0125, 0.03, MOST_OZONE])
ALBEDOS = (0.0, 0.5, 1.0)
"""Of even grounds; the fourth is water."""
WATER_INDEX = 1.335
"""In the middle of the visible: with the ends' own, 1.343 and 1.330, a field differs by 0.5 % at
most, where water mirrors a high sun's red light."""

FILE = "clear-sky.npz"

Packed = npt.NDArray[np.uint16]


class Coded(NamedTuple):
    """Fields over the depth of the molecules that scatter, as smooth functions of it.

    Attributes:
        mean: of black ground, logarithms of the first three components over the depth, and the
            fourth over their sum; of another ground the light over that of black ground, times the
            depth: what it sends up does not go with the depth (..., molecules, H, Z, 4).
        ground: logarithms of the irradiance over the depth (..., molecules, Z).
        heights_m: of the nodes (H,).
        zeniths_rad: of the sun at the nodes (Z,).
    """

    mean: Array
    ground: Array
    heights_m: Array
    zeniths_rad: Array


def coded(field: Scattered, black: Scattered, molecules: Array) -> Coded:
    """Give what is kept of a field whose wavelengths stand for depths of molecules (W,).

    Args:
        field: the field.
        black: that of the same air over black ground, which may be the same.
        molecules: the depths.
    """
    mean, ground = np.moveaxis(field.mean, -1, 0), field.ground.T
    over = _per_depth(np.moveaxis(black.mean, -1, 0), molecules)
    kept = _per_depth(mean, molecules) if field is black else mean / over
    if field is black:
        kept[..., 3] = mean[..., 3] / np.maximum(mean[..., :3].sum(axis=-1), _LEAST)
        kept[..., :3] = np.log(np.maximum(kept[..., :3], _LEAST))
    logarithm = np.log(np.maximum(ground / molecules[:, None], _LEAST))
    return Coded(kept, logarithm, field.heights_m, field.zeniths_rad)


_LEAST = 1e-38


def _per_depth(mean: Array, molecules: Array) -> Array:
    """Three components over the depth, and the sum of them (W, H, Z, 4)."""
    positive = np.maximum(mean[..., :3] / molecules[:, None, None, None], _LEAST)
    return np.concatenate([positive, positive.sum(axis=-1, keepdims=True)], axis=-1)


def _of_black(kept: Array, molecules: Array) -> Array:
    """The mean (W, H, Z, 4) over black ground."""
    positive = np.exp(kept[..., :3]) * molecules[:, None, None, None]
    fourth = kept[..., 3:] * positive.sum(axis=-1, keepdims=True)
    return np.concatenate([positive, fourth], axis=-1)


def clear_field(air: Air, empty: Scattered) -> Scattered | None:
    """Interpolate a field; None where it is of none that are known.

    Args:
        air: the air and the ground, at W wavelengths.
        empty: a field of the same nodes.
    """
    molecules = air.depth[0]
    ozone = air.depth[1] if len(air.depth) > 1 else np.zeros(len(molecules))
    water = air.water > 0.0
    if (
        air.hazy or len(air.depth) > 2 or molecules.max() > MOST_MOLECULES
        or ozone.max() > MOST_OZONE or molecules.min() <= 0.0
        or (water.any() and not water.all())
    ):  # fmt: skip
        return None
    kept, waves = _kept(), len(molecules)
    if not (
        np.array_equal(kept.heights_m, empty.heights_m)
        and np.array_equal(kept.zeniths_rad, empty.zeniths_rad)
    ):
        return None
    shares = np.einsum("ow,mw->omw", _lagrange(OZONE, ozone), _lagrange(MOLECULES, molecules))
    shares = shares.reshape(-1, waves)

    def between(part: Array) -> Array:
        """Interpolate what is kept of a ground (ozone, molecules, ...) at the wavelengths."""
        return floats((shares.T @ part.reshape(len(shares), -1)).reshape(waves, *part.shape[2:]))

    black = _of_black(between(kept.mean[0]), molecules)
    over = _per_depth(black, molecules)
    kinds = [len(ALBEDOS)] if water.all() else range(len(ALBEDOS))
    means = [between(kept.mean[kind]) * over if kind else black for kind in kinds]
    irradiances = [np.exp(between(kept.ground[kind])) * molecules[:, None] for kind in kinds]
    mean, ground = (
        part[0] if water.all() else _over_albedo(part, air.albedo) for part in (means, irradiances)
    )
    return empty._replace(mean=np.ascontiguousarray(np.moveaxis(mean, 0, -1)), ground=ground.T)


def _over_albedo(grounds: Sequence[Array], albedo: Array) -> Array:
    """Interpolate between ``ALBEDOS`` at one for each wavelength (W,), the first axis."""
    black, half, white = grounds
    some, all_ = half - black, white - black
    # Of all_ = a / (1 - s) and some = a / 2 / (1 - s / 2).
    again = np.clip((2.0 * some - all_) / np.where(some == all_, 1.0, some - all_), 0.0, 0.9)
    share = albedo.reshape(-1, *[1] * (black.ndim - 1))
    return floats(black + all_ * (1.0 - again) * share / (1.0 - again * share))


def _lagrange(nodes: Array, at: Array) -> Array:
    """Shares of values at nodes (N,) in those at places (W,) of the polynomial through them."""
    apart = np.where(np.eye(len(nodes), dtype=bool), 1.0, nodes[:, None] - nodes)
    away = np.where(np.eye(len(nodes), dtype=bool)[..., None], 1.0, at - nodes[None, :, None])
    return floats(away.prod(axis=1) / apart.prod(axis=1)[:, None])


@lru_cache(maxsize=1)
def _kept() -> Coded:
    # Opened here: given a path, NumPy asks for the current folder, which may be gone.
    with (resource_dir("data") / FILE).open("rb") as opened, np.load(opened) as file:
        mean, ground = _unpacked(file["mean"], -2), _unpacked(file["ground"], -1)
        nodes = file["heights_m"], file["zeniths_rad"]
    mean[..., 3] /= _SHARES
    mean[1:, ..., :3] = np.exp(mean[1:, ..., :3])
    mean[1:, ..., 3] *= mean[1:, ..., :3].sum(axis=-1)
    return Coded(mean, ground, *nodes)


_LOW, _STEP = -24.0, 32.0 / 65535
"""Of kept logarithms: what is darker than 4e-11 per depth counts as that."""
_SHARES = 8.0
"""By which shares from -1 to 1 are multiplied to be kept alike."""


def packed(kept: Coded) -> dict[str, Packed | Array]:
    """Give what the file holds of fields (grounds, ozone, ...): the nodes, and logarithms in 16
    bits, as steps from one angle of the sun to the next, which are small."""
    mean = kept.mean.copy()
    mean[1:, ..., 3] /= mean[1:, ..., :3].sum(axis=-1)
    mean[1:, ..., :3] = np.log(np.maximum(mean[1:, ..., :3], _LEAST))
    mean[..., 3] *= _SHARES
    return {
        "mean": _packed(mean, -2), "ground": _packed(kept.ground, -1),
        "heights_m": kept.heights_m, "zeniths_rad": kept.zeniths_rad,
    }  # fmt: skip


def _packed(values: Array, axis: int) -> Packed:
    whole = np.rint(np.clip((values - _LOW) / _STEP, 0.0, 65535.0)).astype(np.uint16)
    return np.diff(whole, axis=axis, prepend=np.zeros_like(np.take(whole, [0], axis)))


def _unpacked(steps: Packed, axis: int) -> Array:
    return floats(_LOW + _STEP * np.cumsum(steps, axis=axis, dtype=np.uint16))
