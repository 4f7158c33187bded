"""Method ``fast``: colours integrated over wavelengths ahead of the march."""

from __future__ import annotations

from typing import Literal

from rtbow.arrays import Float32, Progress, no_progress
from rtbow.context import GlContext
from rtbow.fast_lamp import FastLamp
from rtbow.fast_settings import settings_for
from rtbow.fast_sun import FastSun
from rtbow.fast_volume import kind_of
from rtbow.gl_program import FrameTarget, check_sizes, texture_bytes, volume_texture
from rtbow.parts import scene_parts
from rtbow.scene import Scene


class FastPass:
    """A scene's textures and programs on one GL context.

    Args:
        gl: the context; it must be current here and in every method.
        scene: the scene; its ``render.max_delta_e`` sets how coarse the method may be.
        progress: wraps the loop over parts of an exact table that has to be built first.

    Raises:
        InputError: a spectrum or volume is not usable, or beyond what this GL device takes.
        UnsuitedError: the method cannot draw this scene within that error.
    """

    method: Literal["fast"] = "fast"

    def __init__(self, gl: GlContext, scene: Scene, progress: Progress = no_progress) -> None:
        self._gl, self._scene = gl, scene
        parts = scene_parts(scene, tables=False)
        settings = settings_for(scene.render.max_delta_e, kind_of(parts.volume))
        check_sizes(gl, scene.camera.size_px, parts.volume.shape)
        self._target: FrameTarget | None = None
        drops = None if parts.volume.uniform else volume_texture(gl, parts.moments())
        self._lights: list[FastSun | FastLamp] = [
            FastSun(gl, scene, parts, number, settings, drops, progress)
            for number in range(len(parts.optics.suns))
        ]
        self._lights += [
            FastLamp(gl, scene, parts, number, settings, drops, progress)
            for number in range(len(parts.optics.lamps))
        ]

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
        width, height = self._scene.camera.size_px
        if self._target is None:
            self._target = FrameTarget(self._gl, (width, height))
        left, right, _ = columns.indices(width)
        frame = self._target.begin(clear=not self._lights)
        frame.scissor = (left, 0, right - left, height)
        for number, light in enumerate(self._lights):
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
