"""The rain's own extinction: what drops take out of a beam, towards the eye and the lights.

A drop takes Q times the light that falls on it: exact theory has Q_ext, close to 2 for large drops,
half of which is light that diffraction turns by a small angle only. Of that, what stays within the
light's own disc is not lost: it still comes from the disc, and blurs what is seen through the rain
by no more than the disc does already. Its share is the energy of Airy's diffraction pattern within
the disc's radius, 1 - J0²(v) - J1²(v) with v = x sin(radius) (Born and Wolf, section 8.5.2). So Q
falls from 2 for cloud drops to 1 for rain; ``droplets.extinction_efficiency`` sets it.

The field holds extinction at 550 nm; other wavelengths differ by a factor each, taken from the
drops' effective radius: exact for one radius or mixture. In a volume of several radii the depth at
another wavelength is off by up to 14 % for 10-50 µm, 5 % for 100-1000 µm, 1 % for 300-700 µm
(docs/accuracy.md).
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.base.jobs import cores
from rtbow.physics.constants import SUN_DIAMETER_DEG
from rtbow.scene.model import Scene
from rtbow.tables.mie.efficiency import extinction_efficiencies
from rtbow.world.lights import Lamp, Sun
from rtbow.world.optics import Optics
from rtbow.world.rain.volume import DropletVolume

MIDDLE_NM = 550.0
"""Wavelength of the field."""
NO_SUN_DISC_RAD = float(np.radians(0.5 * SUN_DIAMETER_DEG))
"""Angle within which diffraction is not lost in a scene without a sun."""
MOST_POINTS = 64
"""Points along an axis of the depths towards a light, at most; they hold mean extinctions along
whole paths, which vary more smoothly than the rain."""
LEAST_POINTS = 24


@dataclass(frozen=True)
class RainExtinction:
    """The extinction by a scene's rain.

    Attributes:
        field: extinction at 550 nm at the grid's points, 1/m, (nz, ny, nx); (1, 1, 1) if uniform.
        ratio: extinction at each wavelength over that at 550 nm (W,).
    """

    field: Array
    ratio: Array

    @property
    def greatest(self) -> float:
        """Greatest extinction anywhere, 1/m."""
        return float(self.field.max())


def disc_share(x: Array, disc_rad: float) -> Array:
    """Give the share of a drop's diffracted light that stays within an angle, same shape as x."""
    v = floats(x) * np.sin(disc_rad)
    zeroth, first = _bessel(v)
    return floats(1.0 - zeroth**2 - first**2)


def _bessel(v: Array) -> tuple[Array, Array]:
    """J0 and J1 by Bessel's own integral over half a turn. Its even sum of n points errs by J of
    order 2 n, which is rounding where n is 32 more than half v. SciPy's import takes longer."""
    count = 32 + int(0.5 * np.max(v, initial=0.0))
    zeroth, first = np.zeros(v.shape), np.zeros(v.shape)
    for angle in np.pi * (np.arange(count) + 0.5) / count:
        phase = v * np.sin(angle)
        zeroth += np.cos(phase)
        first += np.cos(angle - phase)
    return zeroth / count, first / count


def effective_efficiencies(scene: Scene, optics: Optics, radius_m: Array, nm: Array) -> Array:
    """Give the efficiency Q with which a scene's drops take light out of a beam.

    Args:
        scene: the scene.
        optics: its lights.
        radius_m: drop radii (R,).
        nm: wavelengths (W,).

    Returns:
        (R, W): the scene's ``droplets.extinction_efficiency``, or Q_ext less what diffraction
        leaves within the largest sun's disc.
    """
    fixed = scene.droplets.extinction_efficiency
    if fixed is not None:
        return np.full((len(radius_m), len(nm)), fixed)
    discs = [sun.disc_rad for sun in optics.suns]
    x = 2.0 * np.pi * floats(radius_m)[:, None] / (floats(nm) * 1e-9)
    exact = extinction_efficiencies(radius_m, nm, scene.scattering.medium)
    return floats(exact - disc_share(x, max(discs, default=NO_SUN_DISC_RAD)))


def rain_extinction(scene: Scene, optics: Optics, volume: DropletVolume) -> RainExtinction:
    """Compute a scene's extinction field and its dependence on the wavelength."""
    nm = np.concatenate([[MIDDLE_NM], optics.wavelength_nm])
    number = volume.number_per_m3.transpose(2, 1, 0).astype(np.float64)
    if volume.sizes is not None:
        area = volume.sizes.share * np.pi * volume.sizes.radius_m**2
        sections = area @ effective_efficiencies(scene, optics, volume.sizes.radius_m, nm)
        return RainExtinction(number * sections[0], sections[1:] / max(sections[0], 1e-300))
    least, most = volume.radius_range_um
    if most <= 0.0:  # no drops anywhere
        return RainExtinction(np.zeros_like(number), np.ones(len(optics.wavelength_nm)))
    radius = volume.radius_um.transpose(2, 1, 0).astype(np.float64) * 1e-6
    # At some sizes, and linearly between: Q is smooth once it is averaged over the spread.
    nodes = np.geomspace(least, most, 200 if most > least else 1) * 1e-6
    middle = effective_efficiencies(scene, optics, nodes, nm[:1])[:, 0]
    efficiency = np.interp(np.clip(radius, nodes[0], nodes[-1]), nodes, middle)
    area = number * np.pi * radius**2
    mean_radius = float(np.sum(area * radius) / np.sum(area))
    spectrum = effective_efficiencies(scene, optics, np.array([mean_radius]), nm)[0]
    return RainExtinction(area * efficiency, spectrum[1:] / max(spectrum[0], 1e-300))


_TOGETHER = 65536
"""Ways that a thread follows at once: as many as its calls are worth."""


def _mean_towards(
    points: Array, directions: Array, lengths: Array, box: Array, field: Array, per_metre: Array
) -> Array:
    # Even pieces of half a cell, one sample each: cuts at the grid's planes would cost more than
    # they gain over a whole path.
    rate = np.max(np.abs(directions) * per_metre, axis=1)
    counts = 1 + (2.0 * rate * lengths).astype(np.int64)
    means = np.zeros(len(points))

    def follow(first: int) -> None:
        order = first + np.argsort(-counts[first : first + _TOGETHER], kind="stable")
        count, length = counts[order], lengths[order]
        start, step = points[order].T.copy(), directions[order].T.copy()
        total = np.zeros(len(order))
        left = len(order)
        for k in range(int(count[0])):
            while count[left - 1] <= k:
                left -= 1
            along = (k + 0.5) / count[:left] * length[:left]
            total[:left] += _interpolated(start[:, :left] + along * step[:, :left], box, field)
        means[order] = total / count

    with ThreadPoolExecutor(cores()) as pool:  # NumPy lets go of Python's lock
        list(pool.map(follow, range(0, len(points), _TOGETHER)))
    return means


def _interpolated(points: Array, box: Array, field: Array) -> Array:
    """A field (nz, ny, nx) between its grid points, at points (3, n) of the box."""
    corners = np.zeros(points.shape[1], dtype=np.int64)
    shares: list[Array] = []
    steps: list[int] = []
    strides = (1, field.shape[2], field.shape[2] * field.shape[1])
    for axis in range(3):
        count = field.shape[2 - axis]
        if count == 1:
            shares.append(np.zeros(points.shape[1]))
            steps.append(0)
            continue
        low, high = box[0, axis], box[1, axis]
        place = (points[axis] - low) / (high - low) * (count - 1)
        index = np.clip(np.floor(place).astype(np.int64), 0, count - 2)
        corners += strides[axis] * index
        shares.append(place - index)
        steps.append(strides[axis])
    values, total = field.ravel(), np.zeros(points.shape[1])
    for k in range(2):
        share_z = shares[2] if k else 1.0 - shares[2]
        for j in range(2):
            share_y = share_z * (shares[1] if j else 1.0 - shares[1])
            for i in range(2):
                share = share_y * (shares[0] if i else 1.0 - shares[0])
                total += share * values[corners + i * steps[0] + j * steps[1] + k * steps[2]]
    return total


def paths_to(light: Sun | Lamp, points: Array, box: Array) -> tuple[Array, Array]:
    """Give the ways from points of a box to a light.

    Args:
        light: a sun or a lamp.
        points: places in the box (n, 3), m.
        box: corners (2, 3), m.

    Returns:
        Unit directions (n, 3), and how far each way leads through the box, m, (n,): to its faces,
        or to a lamp inside.
    """
    if isinstance(light, Sun):
        directions = np.broadcast_to(light.direction, points.shape)
        distance = np.full(len(points), np.inf)
    else:
        away = light.position_m - points
        distance = np.linalg.norm(away, axis=1)
        directions = away / np.maximum(distance, 1e-9)[:, None]
    leave = _exits(points, directions, box)
    return np.ascontiguousarray(directions), np.maximum(np.minimum(leave, distance), 0.0)


def _exits(points: Array, direction: Array, box: Array) -> Array:
    """Distances (n,) from points within a box to where directions (n, 3) leave it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        spans = np.where(direction > 0.0, box[1] - points, box[0] - points) / direction
    return floats(np.min(np.where(direction == 0.0, np.inf, spans), axis=1))


def with_second(field: Array) -> Array:
    """Give a field with the second channel that the kernels expect, unused, (nz, ny, nx, 2)."""
    return np.ascontiguousarray(np.stack([field, np.zeros_like(field)], axis=-1))


def mean_extinction_along(
    points: Array, directions: Array, lengths: Array, volume: DropletVolume, field: Array
) -> Array:
    """Give the mean extinction along straight ways through a volume (n,), 1/m.

    Args:
        points: starts in the box (n, 3), m.
        directions: unit directions (n, 3).
        lengths: of the ways (n,), m.
        volume: the volume.
        field: extinction at its grid points (nz, ny, nx).
    """
    cells = (np.array(volume.shape) - 1.0) / (volume.box_m[1] - volume.box_m[0])
    return _mean_towards(points, directions, lengths, volume.box_m, field, cells)


def mean_extinction_towards(light: Sun | Lamp, volume: DropletVolume, field: Array) -> Float32:
    """Give the mean extinction from points of a volume towards a light, within the box.

    The mean is over the path; times the path's length it is the optical depth, right up to the
    edges of the box, where the length has kinks and the mean has none.

    Args:
        light: a sun or a lamp.
        volume: the volume.
        field: extinction at its grid points (nz, ny, nx).

    Returns:
        float32 (nz', ny', nx'): on at most MOST_POINTS points a side.
    """
    counts = [min(max(2 * n - 1, LEAST_POINTS), MOST_POINTS) for n in volume.shape]
    axes = [np.linspace(volume.box_m[0, a], volume.box_m[1, a], counts[a]) for a in range(3)]
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    directions, lengths = paths_to(light, points, volume.box_m)
    means = mean_extinction_along(points, directions, lengths, volume, field)
    return np.asarray(means.reshape(counts[::-1]), dtype=np.float32)
