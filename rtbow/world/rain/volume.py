"""The droplet volume: a grid of radii and number densities in a box, and its file."""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array
from rtbow.base.errors import CHECK_PATH, InputError
from rtbow.base.files import write_atomic
from rtbow.base.limits import MAX_DENSITY_PER_M3, MAX_GRID_POINTS, MAX_RADIUS_UM, MIN_RADIUS_UM
from rtbow.physics.sizes import Sizes
from rtbow.scene.droplets import Density, Droplets
from rtbow.scene.model import Scene
from rtbow.scene.text.values import place_of
from rtbow.world.rain.drops import distribution, draw_drops

Field = NDArray[np.float32]

MAX_GRID = 1024
"""Most grid points along an axis."""
_SOME_UM = 10.0
"""The radius that stands for those of an empty volume."""
_MAX_COORDINATE_M = 1e7
"""A box lies within this distance of the origin along each axis, as in a scene's ``box_m``."""


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


_EXPECTED = (
    "expected an .npz with radius_um and number_per_m3 of one shape (nx, ny, nz), 2 to"
    f" {MAX_GRID} points along each axis, and box_m (2, 3); tools/build_droplets.py makes one"
)

# What zip and npy readers raise over damaged bytes.
_UNREADABLE = (
    OSError, ValueError, EOFError, KeyError, RuntimeError, MemoryError, zipfile.BadZipFile,
    zlib.error,
)  # fmt: skip


def _check_size(path: Path) -> None:
    """Refuse arrays that are too large, by their headers, before any of them is unpacked."""
    if not zipfile.is_zipfile(path):
        return  # load_volume says what it is instead
    with zipfile.ZipFile(path) as archive:
        for name in ("radius_um.npy", "number_per_m3.npy", "box_m.npy"):
            if name not in archive.namelist():
                continue
            with archive.open(name) as file:
                version = np.lib.format.read_magic(file)
                read = {
                    (1, 0): np.lib.format.read_array_header_1_0,
                    (2, 0): np.lib.format.read_array_header_2_0,
                }.get(version)
                shape = read(file)[0] if read else ()
            if math.prod(shape) > MAX_GRID_POINTS:
                raise InputError(
                    f"{path}: {name.removesuffix('.npy')} has {math.prod(shape):,} points; must"
                    f" have up to {MAX_GRID_POINTS:,}; use a coarser volume"
                )


def load_volume(path: Path) -> DropletVolume:
    """Read and check a volume file.

    Raises:
        InputError: not there, not an ``.npz``, arrays missing, of unequal shape, out of range.
    """
    try:
        # Opened here, since np.load leaves a file open that turns out to be damaged.
        with path.open("rb") as file:
            # Of anything else than zip and npy, np.load says that it is a pickle.
            if not file.read(6).startswith((b"PK", b"\x93NUMPY")):
                raise InputError(f"{path}: is not an .npz file; {_EXPECTED}")
            _check_size(path)
            file.seek(0)
            data = np.load(file, allow_pickle=False)
            if not isinstance(data, np.lib.npyio.NpzFile):
                raise InputError(f"{path}: is a single array; {_EXPECTED}")
            wanted = ("radius_um", "number_per_m3", "box_m")
            missing = [name for name in wanted if name not in data.files]
            if missing:
                raise InputError(f"{path}: lacks {', '.join(missing)}; {_EXPECTED}")
            radius, number, box = (data[name] for name in wanted)
    except FileNotFoundError:
        raise InputError(f"{path}: volume file not found; {CHECK_PATH}; {_EXPECTED}") from None
    except _UNREADABLE as error:
        raise InputError(f"{path}: not a readable volume ({error}); {_EXPECTED}") from None

    for name, array in (("radius_um", radius), ("number_per_m3", number), ("box_m", box)):
        if array.dtype.kind not in "fiu":
            raise InputError(f"{path}: {name} holds {array.dtype}, not numbers; {_EXPECTED}")
    if radius.ndim != 3 or radius.shape != number.shape:
        raise InputError(
            f"{path}: radius_um {radius.shape} and number_per_m3 {number.shape}; {_EXPECTED}"
        )
    if not all(2 <= n <= MAX_GRID for n in radius.shape):
        raise InputError(f"{path}: grid of {radius.shape} points; {_EXPECTED}")
    if box.shape != (2, 3):
        raise InputError(f"{path}: box_m has shape {box.shape}; {_EXPECTED}")
    # NaN fails each comparison.
    if not np.all(np.abs(box) <= _MAX_COORDINATE_M) or not np.all(box[1] > box[0]):
        raise InputError(
            f"{path}: box_m = {box.tolist()}; must be two finite corners within"
            f" ±{_MAX_COORDINATE_M:g} m, the second greater along east, north and up"
        )
    with np.errstate(over="ignore"):  # refused below
        radius = radius.astype(np.float32)
        number = number.astype(np.float32)
    if not np.all((number >= 0.0) & (number <= MAX_DENSITY_PER_M3)):
        raise InputError(
            f"{path}: number_per_m3 has values that are negative, not finite or beyond"
            f" {MAX_DENSITY_PER_M3:g}; must be 0..{MAX_DENSITY_PER_M3:g}"
        )
    # Where there are no drops their radius means nothing, but a NaN would still spread.
    filled = number > 0.0
    outside = (radius < MIN_RADIUS_UM) | (radius > MAX_RADIUS_UM)
    if not np.all(np.isfinite(radius)) or np.any(outside & filled):
        raise InputError(
            f"{path}: radius_um must be finite, and within {MIN_RADIUS_UM:g}-{MAX_RADIUS_UM:g} µm"
            " wherever number_per_m3 > 0"
        )
    return DropletVolume(box.astype(np.float64), radius, number)
