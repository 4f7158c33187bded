"""What no shader draws: frames and volumes beyond the device, boxes beyond float32."""

from __future__ import annotations

import numpy as np

from rtbow.base.arrays import AXES
from rtbow.base.errors import UnsuitedError
from rtbow.base.limits import HIGHEST_SKY_M, LEAST_SHARE_OF_DISTANCE
from rtbow.gl.context import GlContext
from rtbow.gl.program import check_sizes
from rtbow.render.haze import check_haze
from rtbow.world.sky import Surroundings
from rtbow.world.world import World


def check_world(gl: GlContext, world: World) -> None:
    """Check that a device and float32 hold a world.

    Raises:
        UnavailableError: too many pixels or grid points a side.
        UnsuitedError: the box is too thin for its distance, or in the ground.
    """
    if world.around is not None:
        _check_ground(world, world.around)
    check_haze(world)
    check_sizes(gl, world.view.size_px, world.volume.shape)
    check_box(world)


def _check_ground(world: World, around: Surroundings) -> None:
    floor, ground = float(world.volume.box_m[0, 2]), around.ground_m
    if floor < ground:
        raise UnsuitedError(
            f"droplets.box_m begins {floor:g} m up, below what is around it: the ground hides drops"
            f" from --method reference alone; begin at {ground:g} or higher"
        )
    height = float(around.above_ground(world.view.eye_m)[2])
    if around.glows and height > HIGHEST_SKY_M:
        raise UnsuitedError(
            f"camera.position_m is {height:g} m above the ground, where the sky's edge is finer"
            f" than tables for shaders; go no higher than {HIGHEST_SKY_M:g} m, or use --method"
            " reference"
        )
    wet = around.ground is not None and around.ground.water
    if wet and around.aerosol is not None and world.view.polarizer is not None:
        raise UnsuitedError(
            "haze that water mirrors is drawn without camera.polarizer_deg alone; leave out the"
            " filter or the atmosphere.aerosol, or use --method reference"
        )


def check_box(world: World) -> None:
    """Check that float32 tells the faces of the drops' box apart, from the eye.

    Raises:
        UnsuitedError: it does not.
    """
    box, eye = world.volume.box_m, world.view.eye_m
    extent, distance = box[1] - box[0], np.abs(box - eye).max(axis=0)
    least = LEAST_SHARE_OF_DISTANCE * distance
    if np.all(extent >= least):
        return
    axis = int(np.argmin(extent / least))
    raise UnsuitedError(
        f"droplets.box_m is {extent[axis]:g} m thick along {AXES[axis]}, where it reaches"
        f" {distance[axis]:g} m from camera.position_m: too thin for a shader's numbers; must be"
        f" {least[axis]:g} m thick there, or no farther than"
        f" {extent[axis] / LEAST_SHARE_OF_DISTANCE:g} m; or use --method reference"
    )
