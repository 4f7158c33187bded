"""The droplet volume: a grid of radii and number densities in a box, and its file."""

from __future__ import annotations

import io
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array
from rtbow.base.errors import InputError
from rtbow.base.files import write_atomic
from rtbow.physics.sizes import Sizes
from rtbow.scene.droplets import Density, Droplets
from rtbow.scene.model import Scene
from rtbow.scene.text.values import place_of
from rtbow.world.rain.drops import distribution, draw_drops
from rtbow.world.rain.volume_file import Field, read_volume_file

_SOME_UM = 10.0
"""The radius that stands for those of an empty volume."""


@dataclass(frozen=True)
class DropletVolume:
    """Radii and number densities at the points of a regular grid.

    Point i of n along an axis lies at ``lo + i/(n-1) (hi - lo)``, so the outermost points lie on
    the box faces. Between points density is interpolated trilinearly, and radius as the ratio of
    the interpolated ``density · radius`` to it, so that an empty point pulls nothing. Outside the
    box there are no drops.

    Attributes:
        box_m: lower and upper corner, float64 (2, 3): east, north, up.
        radius_um: float32 (nx, ny, nz); (1, 1, 1) is a uniform volume.
        number_per_m3: float32, same shape.
        sizes: the sizes that drops have at every point, if they are mixed there; the radius is
            then their effective one.
    """

    box_m: Array
    radius_um: Field
    number_per_m3: Field
    sizes: Sizes | None = None

    @property
    def shape(self) -> tuple[int, int, int]:
        """Grid points along east, north and up."""
        nx, ny, nz = self.radius_um.shape
        return nx, ny, nz

    @property
    def uniform(self) -> bool:
        """Whether the volume is one value all over, without a grid."""
        return self.shape == (1, 1, 1)

    @cached_property  # over all points, and asked for again and again
    def radius_range_um(self) -> tuple[float, float]:
        """Least and greatest radius where there are drops; (0, 0) in an empty volume."""
        filled = self.number_per_m3 > 0.0
        if not filled.any():
            return 0.0, 0.0
        least = self.radius_um.min(where=filled, initial=np.inf)
        return float(least), float(self.radius_um.max(where=filled, initial=0.0))

    @cached_property
    def filled_box_m(self) -> Array | None:
        """Corners (2, 3) of the least box that holds all drops, m: whole cells, and nothing of an
        empty one; None where there are no drops."""
        filled = self.number_per_m3 > 0.0
        if not filled.any():
            return None
        low, extent = self.box_m[0], self.box_m[1] - self.box_m[0]
        box = self.box_m.copy()
        for axis, count in enumerate(self.shape):
            if count == 1:
                continue
            others = tuple(other for other in range(3) if other != axis)
            points = np.flatnonzero(filled.any(axis=others))
            # Density falls to nothing over the cell beyond the last point with drops.
            first, last = max(points[0] - 1, 0), min(points[-1] + 1, count - 1)
            box[0, axis] = low[axis] + first / (count - 1) * extent[axis]
            box[1, axis] = low[axis] + last / (count - 1) * extent[axis]
        return box

    @property
    def size_range_um(self) -> tuple[float, float]:
        """Least and greatest radius of any drop, mixed ones included.

        An empty volume has some radius, so that tables can be made, which nothing looks up.
        """
        if self.sizes is not None:
            return self.sizes.range_um
        least, most = self.radius_range_um
        return (least, most) if most > 0.0 else (_SOME_UM, _SOME_UM)

    def gridded(self) -> DropletVolume:
        """Give the same drops on a grid of two points at least along each axis, as files hold."""
        if not self.uniform:
            return self
        return DropletVolume(
            self.box_m,
            np.tile(self.radius_um, (2, 2, 2)),
            np.tile(self.number_per_m3, (2, 2, 2)),
            self.sizes,
        )

    def moments(self) -> NDArray[np.float32]:
        """Give what is interpolated: density [m⁻³] and density · radius [m⁻²].

        Returns:
            float32 (nz, ny, nx, 2), east fastest: a texture's own order.
        """
        moments = np.empty((*self.shape[::-1], 2), dtype=np.float32)
        moments[..., 0] = self.number_per_m3.transpose(2, 1, 0)
        np.multiply(moments[..., 0], self.radius_um.transpose(2, 1, 0), out=moments[..., 1])
        moments[..., 1] *= np.float32(1e-6)
        return moments


def scene_volume(scene: Scene) -> DropletVolume:
    """Make the volume that a scene asks for, as :func:`build_volume`.

    Raises:
        InputError: the file of volume or drop sizes is not usable; says which key names it.
    """
    try:
        return build_volume(scene.droplets)
    except InputError as error:
        key = "droplets.radius.file" if scene.droplets.file is None else "droplets.file"
        raise InputError(f"{place_of(scene, key)}: {error}") from None


def build_volume(droplets: Droplets) -> DropletVolume:
    """Make the volume that a scene asks for, drawn from its seed or read from its file.

    Raises:
        InputError: the file of volume or drop sizes is not usable.
    """
    if droplets.file is not None:
        return load_volume(Path(droplets.file))
    assert droplets.box_m is not None  # the scene checks that box, radius and density are there
    assert droplets.radius is not None
    density = droplets.density or Density()
    shape = droplets.grid or (1, 1, 1)
    box = np.array(droplets.box_m, dtype=np.float64)
    if droplets.one_kind:
        sizes = distribution(droplets.radius, density)
        return DropletVolume(
            box_m=box,
            radius_um=np.full(shape, sizes.effective_radius_m * 1e6, dtype=np.float32),
            number_per_m3=np.full(shape, sizes.number_per_m3, dtype=np.float32),
            sizes=sizes if len(sizes.radius_m) > 1 else None,
        )
    rng = np.random.default_rng(droplets.seed)
    radius_m, number = draw_drops(droplets.radius, density, int(np.prod(shape)), rng)
    return DropletVolume(
        box_m=box,
        radius_um=(radius_m * 1e6).astype(np.float32).reshape(shape),
        number_per_m3=number.astype(np.float32).reshape(shape),
    )


def save_volume(volume: DropletVolume, path: Path) -> None:
    """Write a volume file, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        radius_um=volume.radius_um,
        number_per_m3=volume.number_per_m3,
        box_m=volume.box_m,
    )
    write_atomic(path, buffer.getvalue())


def load_volume(path: Path) -> DropletVolume:
    """Read and check a volume file (see :mod:`rtbow.world.rain.volume_file`).

    Raises:
        InputError: not there, not an ``.npz``, arrays missing, of unequal shape, out of range.
        UnavailableError: not enough memory.
    """
    return DropletVolume(*read_volume_file(path))
