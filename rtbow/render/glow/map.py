"""The rain's own glow as one eye sees it: a map over directions, for shaders.

Light that drops scatter more than once, over the share of light that the rain takes along the same
ray: the mean brightness of the rain itself. That has no edge where the rain ends, and hardly a
detail that lights behind it do not make. So random walks from some nodes do
(:mod:`rtbow.reference.orders`), and a smooth surface through what they find, as rough as their
errors allow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, Steps, floats, no_progress
from rtbow.physics.geometry import box_span
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.reference.orders import Orders
from rtbow.reference.paths import Counted
from rtbow.world.world import World

_NODES = (25, 17)
"""Across and upwards, where no light is behind the rain."""
_AROUND = np.radians([0.4, 0.8, 1.6, 3.2, 6.4, 12.8])
"""About a light: there the rain's brightness falls as the angle grows."""
WITHIN = 0.025
"""Error of a map, as a share of its light, that is aimed at: CIEDE2000 0.6 of the glow alone."""
_PATHS, _MOST_ROUNDS = 500_000, 10
"""Random walks of a round, and rounds at most."""
_LEAST_SHARE = 1e-9
"""Of the light of a ray that the rain takes, for a node to count."""
_STIFF = 30.0
"""Penalty on bends of the first surface."""
_STIFFER = 100.0
"""By this much more bends of the colour count."""
_SMOOTHINGS = 10.0 ** np.arange(-0.5, 4.0, 0.5)
"""Penalties on bends that are tried."""


@dataclass(frozen=True)
class GlowMap:
    """Brightness of the rain by direction.

    Attributes:
        azimuth_rad: of the columns (A,), ascending, clockwise from north; whole turns may be added.
        altitude_rad: of the rows (B,), ascending.
        rgb: linear Rec. 709 in cd/m² (B, A, 3).
        error: standard error of the luminance after smoothing, as a share, in the mean.
    """

    azimuth_rad: Array
    altitude_rad: Array
    rgb: Float32
    error: float

    @classmethod
    def of(
        cls, orders: Orders, counted: Counted, *, within: float = WITHIN, seed: int = 0,
        building: Progress = no_progress,
    ) -> GlowMap:  # fmt: skip
        """Make the map of a world.

        Args:
            orders: the world, ready for random walks.
            counted: which light.
            within: error at which walks end, unless they are too many already.
            seed: of the random numbers.
            building: wraps the loop over rounds of walks.
        """
        azimuth, altitude = _axes(orders.world)
        rays = _directions(azimuth, altitude)
        share = 1.0 - orders.passed(rays)
        lit = np.flatnonzero(share > _LEAST_SHARE)
        weight = np.where(share > _LEAST_SHARE, share, 0.0).reshape(len(altitude), len(azimuth))
        total, xyz, error = np.zeros((len(rays), 3)), np.zeros((*weight.shape, 3)), 0.0
        rounds = Steps(_MOST_ROUNDS if len(lit) else 0, "following light through the rain")
        for number in building(rounds):
            each = max(_PATHS // len(lit), 64)
            found = orders.along(rays[lit], counted, paths=each, seed=seed + number)
            total[lit] += found.mean / share[lit, None]
            values = total.reshape(*weight.shape, 3) / (number + 1)
            xyz, error = _smoothed(values, weight)
            if error < within:
                break
        rgb = xyz_to_rgb(np.maximum(xyz, 0.0)).astype(np.float32)
        return cls(azimuth, altitude, rgb, error)


def _directions(azimuth: Array, altitude: Array) -> Array:
    """Unit vectors (B A, 3)."""
    up, turn = (one.ravel() for one in np.meshgrid(altitude, azimuth, indexing="ij"))
    level = np.cos(up)
    return floats(np.stack([level * np.sin(turn), level * np.cos(turn), np.sin(up)], axis=1))


def _axes(world: World) -> tuple[Array, Array]:
    """Azimuths and altitudes of the nodes: over all of the rain, dense about lights behind it."""
    (west, east), (low, high) = _extent(world)
    azimuth = np.linspace(west, east, _NODES[0])
    altitude = np.linspace(low, high, _NODES[1])
    towards = [sun.direction for sun in world.optics.suns]
    towards += [lamp.position_m - world.view.eye_m for lamp in world.optics.lamps]
    for vector in towards:
        up = float(np.arctan2(vector[2], np.hypot(vector[0], vector[1])))
        turn = float(np.arctan2(vector[0], vector[1]))
        turn = west + (turn - west) % (2.0 * np.pi)
        level = max(np.cos(up), 0.05)
        offsets = np.concatenate([-_AROUND[::-1], [0.0], _AROUND])
        beside = turn + offsets / level
        if turn > east:
            continue
        azimuth = np.concatenate([azimuth, beside[(beside > west) & (beside < east)]])
        over = up + offsets
        altitude = np.concatenate([altitude, over[(over > low) & (over < high)]])
    return _apart(azimuth), _apart(altitude)


def _apart(nodes: Array) -> Array:
    """Nodes in order, without those that another is close to."""
    nodes = np.sort(nodes)
    kept, near = [nodes[0]], min(0.5 * _AROUND[0], float(np.ptp(nodes)) / (2.0 * max(_NODES)))
    for node in nodes[1:]:
        if node - kept[-1] > near:
            kept.append(node)
    kept[-1] = nodes[-1]
    return floats(kept)


def _extent(world: World) -> tuple[tuple[float, float], tuple[float, float]]:
    """Azimuths and altitudes between which the rain is seen, rad."""
    box, eye = world.volume.box_m, world.view.eye_m
    whole = (-np.pi, np.pi), (-0.5 * np.pi, 0.5 * np.pi)
    if np.all((eye >= box[0]) & (eye <= box[1])):
        return whole
    above = box_span(eye, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), box)
    if np.any(above[1] > above[0]):
        return whole
    t = np.linspace(0.0, 1.0, 17)
    grid = np.stack(np.meshgrid(t, t, t), axis=-1).reshape(-1, 3)
    face = np.any((grid == 0.0) | (grid == 1.0), axis=1)
    away = box[0] + grid[face] * (box[1] - box[0]) - eye
    up = np.arctan2(away[:, 2], np.hypot(away[:, 0], away[:, 1]))
    middle = np.arctan2(*(0.5 * (box[0] + box[1]) - eye)[:2])
    turn = (np.arctan2(away[:, 0], away[:, 1]) - middle + np.pi) % (2.0 * np.pi) - np.pi
    margin = 1e-3
    return (
        (float(middle + turn.min() - margin), float(middle + turn.max() + margin)),
        (float(up.min() - margin), float(up.max() + margin)),
    )  # fmt: skip


def _smoothed(values: Array, share: Array) -> tuple[Array, float]:
    """Lay a smooth surface through values (B, A, C) that count by the share of light that rain
    takes there (B, A); where that is nothing, they are not known.

    Second differences from node to node count against it, by the penalty of which the surface is
    the best for values that were left out (generalised cross-validation: Craven and Wahba, Numer.
    Math. 31, 377, 1979). Errors are shares of the light, so that all is judged beside a first
    surface, a stiff one; by the second channel, the luminance.

    Returns:
        The surface, and its error in the mean as a share.
    """
    rows, columns = share.shape
    if not share.any():
        return np.zeros_like(values), 0.0
    bends = np.concatenate([
        np.kron(_second(rows), np.eye(columns)), np.kron(np.eye(rows), _second(columns)),
    ])  # fmt: skip
    bend = bends.T @ bends + 1e-9 * np.eye(rows * columns)
    weight = share.ravel() / share.mean(where=share > 0.0)
    flat, count = values.reshape(-1, values.shape[2]), weight.sum()
    least = 1e-3 * float(weight @ flat[:, 1]) / count
    first = np.linalg.solve(np.diag(weight) + _STIFF * bend, weight * flat[:, 1])
    level = np.maximum(first, least)
    ratio = flat / level[:, None]
    best, chosen, left = np.inf, float(_SMOOTHINGS[0]), 0.0
    for penalty in _SMOOTHINGS:
        inverse = np.linalg.inv(np.diag(weight) + penalty * bend)
        surface = inverse @ (weight[:, None] * ratio)
        free = float(np.sum(np.diag(inverse) * weight))
        missed = float(weight @ (ratio[:, 1] - surface[:, 1]) ** 2) / max(count - free, 1e-3)
        score = missed / max(count - free, 1e-3)
        if score < best:
            best, chosen, left = score, float(penalty), float(np.sqrt(missed * free / count))

    def surface_of(penalty: float) -> Array:
        system = np.diag(weight) + penalty * bend
        return floats(np.linalg.solve(system, weight[:, None] * ratio) * level[:, None])

    # The colour changes more slowly than the luminance, and its noise is the greater.
    stiff = np.maximum(surface_of(_STIFFER * chosen), least)
    light = surface_of(chosen)[:, 1:2]
    return floats((stiff / stiff[:, 1:2] * light).reshape(values.shape)), left


def _second(count: int) -> Array:
    """Second differences of values in a row."""
    out = np.zeros((max(count - 2, 0), count))
    for k in range(count - 2):
        out[k, k : k + 3] = 1.0, -2.0, 1.0
    return out
