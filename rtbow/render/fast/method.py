"""Method ``fast``: colours integrated over wavelengths ahead of the march."""

from __future__ import annotations

from typing import Any, Literal

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.gl.context import GlContext
from rtbow.gl.program import FrameTarget, check_sizes, texture_bytes
from rtbow.render.fast.columns import kind_of
from rtbow.render.fast.lamp import FastLamp
from rtbow.render.fast.shared import FastScene, fast_scene
from rtbow.render.fast.sun import FastSun
from rtbow.render.fast.tolerance import settings_for
from rtbow.scene.model import Scene
from rtbow.world.camera import picture_cone
from rtbow.world.world import CONE_MARGIN, scene_parts


class FastPass:
    """A scene's textures and programs on one GL context.

    Args:
        gl: the context; it must be current here and in every method.
        scene: the scene; its ``render.max_delta_e`` sets how coarse the method may be.
        progress: wraps the loop over parts of an exact table that has to be built first.

    Raises:
        InputError: a spectrum or volume is not usable.
        UnavailableError: the picture or volume is beyond what this GL device takes.
        UnsuitedError: the method cannot draw this scene within that error.
    """

    method: Literal["fast"] = "fast"

    def __init__(self, gl: GlContext, scene: Scene, progress: Progress = no_progress) -> None:
        gl.ctx.gc()  # what is left of a pass before
        parts = scene_parts(scene, tables=False)
        check_sizes(gl, scene.camera.size_px, parts.volume.shape)
        settings = settings_for(scene.render.max_delta_e, kind_of(parts.volume))
        self._here = fast_scene(gl, scene, parts, settings)
        self._still, self._seen = _without_places(scene), scene
        self._target: FrameTarget | None = None
        self._roaming = False
        self._lights = _make_lights(self._here, progress, roaming=False)

    def move(self, scene: Scene) -> bool:
        """Take over another scene, if it differs only in where camera and lights are, and in size.

        The first move to another place makes tables that serve all places; from then on moves are
        quick. Another size alone never needs them.

        Returns:
            Whether it does; if not, nothing has changed.

        Raises:
            UnavailableError: the picture is beyond what this GL device takes; nothing has changed.
            UnsuitedError: the method cannot draw it there; nothing has changed.
        """
        if _without_places(scene) != self._still:
            return False
        check_sizes(self._here.gl, scene.camera.size_px, self._here.parts.volume.shape)
        here = self._here.moved(scene)
        roaming = self._roaming or not _same_view(self._seen, scene)
        try:
            lights = self._moved_lights(here, roaming)
        except Exception:
            for one in self._lights:
                one.move(self._here)  # those before the one that could not be drawn there
            raise
        self._here, self._lights, self._roaming = here, lights, roaming
        here.gl.ctx.gc()  # programs and textures that have been replaced
        return True

    def prepare_moves(self) -> None:
        """Make the tables that moves to other places take, if there are none yet.

        Raises:
            UnsuitedError: the method cannot draw the scene from everywhere.
        """
        if not self._roaming:
            self._lights = _make_lights(self._here, no_progress, roaming=True)
            self._roaming = True
            self._here.gl.ctx.gc()

    def _moved_lights(self, here: FastScene, roaming: bool) -> list[FastSun | FastLamp]:
        if roaming and self._roaming:
            return [one if one.move(here) else one.anew(here) for one in self._lights]
        if not roaming and all(one.move(here) for one in self._lights):
            return self._lights
        return _make_lights(here, no_progress, roaming=roaming)

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        return texture_bytes(texture for light in self._lights for texture in light.textures)

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done.

        Args:
            progress: is told that all rows are done.
            columns: which columns of the picture, a slice of step 1; all by default.
        """
        width, height = self._here.scene.camera.size_px
        if self._target is None or self._target.size_px != (width, height):
            self._target = FrameTarget(self._here.gl, (width, height))
        left, right, _ = columns.indices(width)
        frame = self._target.begin(clear=not self._lights)
        frame.scissor = (left, 0, right - left, height)
        for number, light in enumerate(self._lights):
            # The first writes every pixel: neither reading nor clearing what is there costs little.
            light.draw(self._target, add=number > 0)
        self._here.gl.ctx.finish()
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


def _make_lights(here: FastScene, progress: Progress, *, roaming: bool) -> list[FastSun | FastLamp]:
    optics = here.parts.optics
    suns = [FastSun(here, k, progress, roaming=roaming) for k in range(len(optics.suns))]
    lamps = [FastLamp(here, k, progress, roaming=roaming) for k in range(len(optics.lamps))]
    return [*suns, *lamps]


def _same_view(baked: Scene, scene: Scene) -> bool:
    """Whether a scene's picture has no angle that the tables baked for another lack."""
    camera = scene.camera.model_copy(update={"size_px": baked.camera.size_px})
    if camera != baked.camera or scene.light != baked.light:
        return False
    # Half of the margin is left to float32.
    wider = picture_cone(scene.camera)[1] - picture_cone(baked.camera)[1]
    return wider <= 0.5 * CONE_MARGIN


def _without_places(scene: Scene) -> dict[str, Any]:
    """Give all of a scene but where its camera and lights are, and what of the picture it fills."""
    values = scene.model_dump(exclude={"compare"})
    for name in ("position_m", "azimuth_deg", "altitude_deg", "fov_deg", "size_px"):
        values["camera"].pop(name)
    for light in values["light"]:
        for name in ("position_m", "azimuth_deg", "altitude_deg"):
            light.pop(name, None)
    return values
