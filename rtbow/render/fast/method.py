"""Method ``fast``: colours integrated over wavelengths ahead of the march."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.gl.context import GlContext
from rtbow.gl.program import FrameTarget, texture_bytes, volume_texture
from rtbow.render.checks import check_world
from rtbow.render.fast.lamp import FastLamp
from rtbow.render.fast.shared import Plan, plan_world
from rtbow.render.fast.sun import FastSun
from rtbow.world.world import World

_WIDE_PIXEL_RAD = 0.01
"""Width of a pixel that is a mean over its area, from which on a volume of many radii is tabled for
each place anew."""


class FastMethod:
    """The textures and programs of a world on one GL context (:class:`rtbow.render.method.Method`).

    Args:
        gl: the context; it must be current here and in every method.
        world: what to draw; the error that it allows sets how coarse the method may be.
        building: wraps the loop over parts of an exact table that has to be built first.
        frugal: refuse tables that take far longer than the frame by ``spectral``.

    Raises:
        UnavailableError: the picture or volume is beyond what this GL device takes.
        UnsuitedError: the method cannot draw this world within that error.

    Attributes:
        keeps_haze: whether :meth:`move` leaves the haze before the drops as it is, to be quick.
    """

    name: Literal["fast"] = "fast"

    def __init__(
        self, gl: GlContext, world: World, building: Progress = no_progress, *, frugal: bool = False
    ) -> None:
        check_world(gl, world)
        self._gl, self._seen = gl, world
        self.keeps_haze = False
        self.plan = plan_world(world, frugal=frugal)
        self._drops = None if world.volume.uniform else volume_texture(gl, world.moments())
        self._target: FrameTarget | None = None
        self._roaming = False
        self.lights = self._make_lights(self.plan, building, roaming=False)

    def move(self, world: World) -> bool:
        """Take over a world that differs only in where camera and lights are, and in size.

        The first move to another place makes tables that serve all places; from then on moves are
        quick. Another size alone never needs them.

        Returns:
            Whether it does; if not, nothing has changed.

        Raises:
            UnavailableError: the picture is beyond what this GL device takes; nothing has changed.
            UnsuitedError: the method cannot draw it there; nothing has changed.
        """
        if not world.differs_in_places_alone(self.plan.world):
            return False
        if not (self.keeps_haze or self._same_haze(world)):
            return False
        check_world(self._gl, world)
        plan = self.plan.moved(world)
        same = world.optics is self._seen.optics and world.view.shows_no_more_than(self._seen.view)
        roaming = self._roaming or not same
        wide = world.view.area and world.view.pixel_rad > _WIDE_PIXEL_RAD
        if roaming and wide and len(plan.radii.rows) > 1:
            # Tables for all places have too few lines for wide pixels of many radii: 0.8 in
            # CIEDE2000 at pixels of a degree, where those for one place leave 0.3.
            return False
        try:
            lights = self._moved_lights(plan, roaming)
        except Exception:
            for light in self.lights:
                light.move(self.plan)  # those before the one that could not be drawn there
            raise
        self.plan, self.lights, self._roaming = plan, lights, roaming
        return True

    def _same_haze(self, world: World) -> bool:
        """Whether haze dims another world's light as it does this one's: its tables are of one sun
        and one eye."""
        if world.haze is None:
            return True
        seen = self._seen
        same = world.optics is seen.optics and bool(np.all(world.view.eye_m == seen.view.eye_m))
        return same or not self.lights

    @property
    def has_former_haze(self) -> bool:
        """Whether the drops are dimmed as under a sun, or before an eye, of an earlier world."""
        return not self._same_haze(self.plan.world)

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take, if there are none yet.

        Raises:
            UnsuitedError: the method cannot draw the world from everywhere.
        """
        if not self._roaming:
            self.lights = self._make_lights(self.plan, no_progress, roaming=True)
            self._roaming = True

    def _moved_lights(self, plan: Plan, roaming: bool) -> list[FastSun | FastLamp]:
        if roaming and self._roaming:
            return [light if light.move(plan) else light.anew(plan) for light in self.lights]
        if not roaming and all(light.move(plan) for light in self.lights):
            return self.lights
        return self._make_lights(plan, no_progress, roaming=roaming)

    def _make_lights(
        self, plan: Plan, building: Progress, *, roaming: bool
    ) -> list[FastSun | FastLamp]:
        optics, gl, drops = plan.world.optics, self._gl, self._drops
        suns = [
            FastSun(gl, plan, k, drops, building, roaming=roaming) for k in range(len(optics.suns))
        ]
        lamps = [
            FastLamp(gl, plan, k, drops, building, roaming=roaming)
            for k in range(len(optics.lamps))
        ]
        return [*suns, *lamps]

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        return texture_bytes(texture for light in self.lights for texture in light.textures)

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done.

        Args:
            progress: sees all rows when they are done, at once.
            columns: which columns of the picture, a slice of step 1; all by default.
        """
        width, height = self.plan.world.view.size_px
        if self._target is None or self._target.size_px != (width, height):
            self._target = FrameTarget(self._gl, (width, height))
        left, right, _ = columns.indices(width)
        frame = self._target.begin(clear=not self.lights)
        frame.scissor = (left, 0, right - left, height)
        for number, light in enumerate(self.lights):
            # The first writes every pixel: neither reading nor clearing what is there costs little.
            light.draw(self._target, add=number > 0)
        self._gl.ctx.finish()
        frame.scissor = (0, 0, width, height)
        for _ in progress(range(height)):
            pass
        return self._target

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it (see :meth:`draw`).

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        return self.draw(progress, columns).read(columns)
