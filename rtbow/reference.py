"""Method ``reference``: the radiance integral in float64 on the CPU, plainly and without tables.

Each ray is cut where it crosses the planes of the droplet grid; between cuts the drops vary
smoothly and Gauss-Legendre nodes integrate them. At every node and wavelength Airy's intensity is
evaluated itself and averaged over the light's disc by quadrature on the sphere; air columns
towards the sun are quadratures through spherical shells. This is what every faster method is
measured against, so it shares with them only the scene, the spectra and the optics formulas.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rtbow.airy import RADIUS_POWER, SCALE_POWER
from rtbow.arrays import Array, Indices, Progress, floats, no_progress
from rtbow.atmosphere import segment_column, sun_column
from rtbow.camera import box_span, pixel_directions
from rtbow.colour import xyz_to_rgb
from rtbow.disc import disc_nodes
from rtbow.lights import NEAREST_M
from rtbow.optics import Optics, scene_optics
from rtbow.reference_kernel import integrate_spectrum, sample_rays
from rtbow.reference_lamp_kernel import integrate_lamp, lamp_pieces
from rtbow.scene import Scene
from rtbow.volume import DropletVolume, build_volume

_MOST_NODES = 24
"""Gauss-Legendre nodes between two cuts, at most; see the kernel for how many a piece takes."""
_AIR_CELL_M = 200.0
"""Longest piece of a ray in air: attenuation over it is a polynomial of degree 5 to 1e-12."""
_LAMP_PIECE_RAD = 0.01
"""Largest angle of a piece at a lamp. Drops and air vary over it by midpoint rule; the
cross-section's integral over it is exact."""
_DISC_NODES = 16
"""Nodes over the disc beside those that the fringe phase across it asks for."""


@dataclass(frozen=True)
class _Samples:
    """Samples along the rays of one row of pixels, concatenated.

    Attributes:
        start: first sample of each pixel, and the end of the last, (pixels + 1,).
        distance_m: distance from the eye (n,).
        weight: density times length, m⁻² (n,).
        radius_m: drop radius (n,).
    """

    start: Indices
    distance_m: Array
    weight: Array
    radius_m: Array


@lru_cache(maxsize=1)
def _gauss_rules() -> Array:
    """Gauss-Legendre rules of 1 to ``_MOST_NODES`` nodes: (rules, 2, nodes), padded with zeros."""
    rules = np.zeros((_MOST_NODES, 2, _MOST_NODES))
    for n in range(1, _MOST_NODES + 1):
        rules[n - 1, :, :n] = np.polynomial.legendre.leggauss(n)
    return rules


def _sample_row(
    origin: Array, rays: Array, volume: DropletVolume, moments: Array, has_air: bool
) -> _Samples:
    entry, leave = box_span(origin, rays, volume.box_m)
    # Without air and without a grid the integrand is constant along the ray.
    longest = _AIR_CELL_M if has_air else np.inf
    start, distance, weight, radius = sample_rays(
        origin, rays, entry, leave, volume.box_m, moments, longest, _gauss_rules()
    )
    return _Samples(start, distance, weight, radius)


def _disc_angles(optics: Optics, light: int, theta: float, radius_m: float) -> tuple[Array, Array]:
    """Give nodes over a light's disc, enough for the fringes of this angle and drop size."""
    disc = optics.suns[light].disc_rad
    phase = 0.0
    for bow in optics.bows:
        scale = bow.scale.max() * radius_m**SCALE_POWER
        excess = np.max(bow.side * (theta - bow.angle_rad)) + 2.0 * disc
        phase = max(phase, 2.0 * scale * disc * np.sqrt(max(scale * excess, 1.0)))
    return disc_nodes(theta, disc, _DISC_NODES + int(0.6 * phase))


def _sun_xyz(optics: Optics, origin: Array, rays: Array, samples: _Samples) -> Array:
    """Integrate one row of pixels under the suns: X, Y, Z (pixels, 3)."""
    counts = np.diff(samples.start)
    rise = np.repeat(rays[:, 2], counts)
    height = origin[2] + samples.distance_m * rise
    air = optics.has_air
    eye_column = (
        segment_column(origin[2], rise, samples.distance_m)
        if air
        else np.zeros_like(samples.distance_m)
    )
    bow_numbers, sides = _bow_arrays(optics)

    xyz = np.zeros((len(rays), 3))
    for light, sun in enumerate(optics.suns):
        column = eye_column + (sun_column(height, sun.altitude_rad) if air else 0.0)
        # theta = 0 is forward: light travels along -direction and on towards the eye along -ray.
        theta = 2.0 * np.arctan2(
            np.linalg.norm(sun.direction - rays, axis=-1),
            np.linalg.norm(sun.direction + rays, axis=-1),
        )
        angles, weights, first = [], [], [0]
        for pixel, angle in enumerate(theta):
            if counts[pixel]:
                part = slice(samples.start[pixel], samples.start[pixel + 1])
                nodes, shares = _disc_angles(
                    optics, light, float(angle), float(samples.radius_m[part].max())
                )
                angles.append(nodes)
                weights.append(shares)
            first.append(first[-1] + (len(angles[-1]) if counts[pixel] else 0))
        if not angles:
            continue
        xyz += integrate_spectrum(
            samples.start,
            samples.weight,
            samples.radius_m**SCALE_POWER,
            samples.radius_m**RADIUS_POWER,
            column,
            np.array(first),
            np.concatenate(angles),
            np.concatenate(weights),
            bow_numbers,
            sides,
            optics.air_depth,
            optics.sun_weights[light],
        )
    return xyz


def _lamp_xyz(
    optics: Optics, origin: Array, rays: Array, volume: DropletVolume, moments: Array
) -> Array:
    """Integrate one row of pixels under the lamps: X, Y, Z (pixels, 3)."""
    entry, leave = box_span(origin, rays, volume.box_m)
    longest = _AIR_CELL_M if optics.has_air else np.inf
    xyz = np.zeros((len(rays), 3))
    for lamp, weights in zip(optics.lamps, optics.lamp_weights, strict=True):
        start, pieces = lamp_pieces(
            origin, rays, entry, leave, volume.box_m, moments, longest,
            lamp.position_m, lamp.radius_m, _LAMP_PIECE_RAD, NEAREST_M,
        )  # fmt: skip
        column = np.zeros(len(pieces))
        if optics.has_air:
            rise = np.repeat(rays[:, 2], np.diff(start))
            height = origin[2] + pieces[:, 0] * rise
            at = origin + pieces[:, :1] * np.repeat(rays, np.diff(start), axis=0)
            distance = np.linalg.norm(at - lamp.position_m, axis=1)
            slope = (height - lamp.position_m[2]) / distance
            column = segment_column(origin[2], rise, pieces[:, 0])
            column = column + segment_column(lamp.position_m[2], slope, distance)
        xyz += integrate_lamp(
            start, pieces, column, *_bow_arrays(optics), optics.air_depth, weights
        )
    return xyz


def _bow_arrays(optics: Optics) -> tuple[Array, Array]:
    """Bows as the kernels take them: (bows, 3, W) of angle, scale and strength; sides (bows,)."""
    numbers = [np.stack([b.angle_rad, b.scale, b.strength]) for b in optics.bows]
    return np.stack(numbers), np.array([b.side for b in optics.bows])


def _moments(volume: DropletVolume) -> Array:
    """Density and density times radius in float64, (nz, ny, nx, 2).

    Their ratio is then the radius to the last digits, and drops of one radius stay of one radius.
    """
    density = floats(volume.number_per_m3)
    moments = np.stack([density, density * floats(volume.radius_um) * 1e-6], axis=-1)
    return np.ascontiguousarray(moments.transpose(2, 1, 0, 3))


def radiance_along(scene: Scene, rays: Array) -> Array:
    """Give what the eye receives along some rays, in float64.

    Args:
        scene: the scene; its camera's position counts, not its direction.
        rays: unit directions (n, 3).

    Returns:
        X, Y, Z (n, 3), Y in cd/m².
    """
    optics = scene_optics(scene)
    volume = build_volume(scene.droplets)
    origin = floats(scene.camera.position_m)
    return _rays_xyz(optics, origin, rays, volume, _moments(volume))


def _rays_xyz(
    optics: Optics, origin: Array, rays: Array, volume: DropletVolume, moments: Array
) -> Array:
    xyz = np.zeros((len(rays), 3))
    if optics.suns:
        samples = _sample_row(origin, rays, volume, moments, optics.has_air)
        xyz += _sun_xyz(optics, origin, rays, samples)
    if optics.lamps:
        xyz += _lamp_xyz(optics, origin, rays, volume, moments)
    return xyz


def render_reference(
    scene: Scene, progress: Progress = no_progress, columns: slice = slice(None)
) -> Array:
    """Render a scene in float64 at its own wavelength step (1 nm is the standard of truth).

    Args:
        scene: the scene.
        progress: wraps the loop over the picture's rows.
        columns: which columns of the picture; all by default.

    Returns:
        Linear Rec. 709 R, G, B in cd/m², float64 (h, columns, 3), first row on top.

    Raises:
        InputError: a spectrum or volume file is not usable.
    """
    optics = scene_optics(scene)
    volume = build_volume(scene.droplets)
    moments = _moments(volume)
    width, height = scene.camera.size_px
    width = len(range(width)[columns])
    origin = np.array(scene.camera.position_m, dtype=np.float64)
    xyz = np.zeros((height, width, 3))
    for row in progress(range(height)):
        rays = pixel_directions(scene.camera, slice(row, row + 1))[0, columns]
        xyz[row] = _rays_xyz(optics, origin, rays, volume, moments)
    return xyz_to_rgb(xyz)
