"""A full-screen program on a GL context, with the textures and uniforms that it reads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Float32
from rtbow.base.errors import UnavailableError, UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define, compile_program

Texture = moderngl.Texture | moderngl.Texture3D | moderngl.TextureArray


_SAMPLER_TYPES = (0x8B5E, 0x8B5F, 0x8DC1)
"""GL_SAMPLER_2D, GL_SAMPLER_3D and GL_SAMPLER_2D_ARRAY."""


class GlProgram:
    """A program that draws one triangle over its target, its textures bound by name.

    Args:
        gl: the context; it must be current here and in every method.
        fragment: file name of the fragment stage.
        defines: constants and switches of both stages.
        vertex: file name of the vertex stage; one triangle over the target if left out.
    """

    def __init__(
        self,
        gl: GlContext,
        fragment: str,
        defines: Mapping[str, Define],
        vertex: str = "common/fullscreen.vert",
    ) -> None:
        self._gl = gl
        self._program = compile_program(gl.ctx, vertex, fragment, defines)
        self._triangle = gl.ctx.vertex_array(self._program, [])
        self._textures: dict[str, Texture] = {}
        self._placed = -1  # how many textures there were when the others got their units
        self._samplers = {
            name
            for name in self._program
            if getattr(self._program[name], "gl_type", None) in _SAMPLER_TYPES
        }

    @property
    def names(self) -> set[str]:
        """Uniforms and samplers that the compiler kept."""
        return set(self._program)

    @property
    def textures(self) -> Mapping[str, Texture]:
        """Its textures by the names of their samplers."""
        return self._textures

    def set(self, name: str, value: Any) -> None:
        """Set a uniform, if the program has it: the compiler drops what a scene does not use."""
        if name in self._program:
            self._program[name] = value

    def set_array(self, name: str, values: Sequence[Any]) -> None:
        """Set a uniform array, of one element too; an empty one is none."""
        # moderngl takes a single value, not a list, for an array of one.
        if values:
            self.set(name, values if len(values) > 1 else values[0])

    def bind(self, name: str, texture: Texture) -> None:
        """Take a texture, also one that other programs read, for a sampler that the program has."""
        if name in self._program:
            self._textures[name] = texture

    def texture(self, name: str, data: NDArray[Any], *, linear: bool = True) -> None:
        """Upload rows of texels, (rows, columns, channels) or (rows, columns)."""
        self._textures[name] = row_texture(self._gl, data, linear=linear)

    def volume(self, name: str, data: NDArray[Any]) -> None:
        """Upload a volume of texels, (depth, rows, columns, channels)."""
        self._textures[name] = volume_texture(self._gl, data)

    def layers(self, name: str, data: NDArray[Any]) -> None:
        """Upload layers of rows of texels, (layers, rows, columns, channels)."""
        layers, rows, columns, channels = data.shape
        size = (columns, rows, layers)
        self._textures[name] = _upload(self._gl.ctx.texture_array, size, channels, data, True)

    def use(self) -> None:
        """Bind the textures to the units that their samplers read."""
        for unit, (name, texture) in enumerate(self._textures.items()):
            texture.use(unit)
            self.set(name, unit)
        if self._placed != len(self._textures):
            self._place_unread()

    def _place_unread(self) -> None:
        """Give samplers without a texture units of their own.

        One that is passed on but never read counts as used: left at unit 0, it might share that
        with one of another type, and nothing would be drawn.
        """
        unread = sorted(self._samplers - self._textures.keys())
        for unit, name in enumerate(unread, len(self._textures)):
            self._program[name] = unit
        self._placed = len(self._textures)

    def draw(self, vertices: int = 3) -> None:
        """Draw over the bound framebuffer: one triangle, or as many as the vertices make."""
        self._triangle.render(moderngl.TRIANGLES, vertices=vertices)


def row_texture(gl: GlContext, data: NDArray[Any], *, linear: bool = True) -> moderngl.Texture:
    """Upload rows of texels, (rows, columns, channels) or (rows, columns), for several programs.

    Raises:
        UnsuitedError: the device takes no texture of that size.
    """
    if max(data.shape[:2]) > gl.limits.texture_2d:
        raise UnsuitedError(
            f"a table of {data.shape[0]} x {data.shape[1]} texels; this GL device"
            f" ({gl.renderer}) takes up to {gl.limits.texture_2d} a side; use a narrower range of"
            " radii, or --method reference"
        )
    rows, columns = data.shape[:2]
    channels = data.shape[2] if data.ndim == 3 else 1
    texture: moderngl.Texture = _upload(gl.ctx.texture, (columns, rows), channels, data, linear)
    return texture


def volume_texture(gl: GlContext, data: NDArray[Any]) -> moderngl.Texture3D:
    """Upload a volume of texels, (depth, rows, columns, channels), for several programs."""
    depth, rows, columns, channels = data.shape
    size = (columns, rows, depth)
    texture: moderngl.Texture3D = _upload(gl.ctx.texture3d, size, channels, data, True)
    texture.repeat_z = False
    return texture


def _upload(
    make: Any, size: tuple[int, ...], channels: int, data: NDArray[Any], linear: bool
) -> Any:
    half = data.dtype == np.float16
    contiguous = np.ascontiguousarray(data, dtype=np.float16 if half else np.float32)
    texture = make(size, channels, contiguous, dtype="f2" if half else "f4")
    mode = moderngl.LINEAR if linear else moderngl.NEAREST
    texture.filter = (mode, mode)
    texture.repeat_x = texture.repeat_y = False
    return texture


def texture_bytes(textures: Iterable[Texture]) -> int:
    """Memory that textures take, counting each once."""
    return sum(_bytes(texture) for texture in {id(one): one for one in textures}.values())


def _bytes(texture: Texture) -> int:
    texels = int(np.prod(texture.size))
    return texels * texture.components * (2 if texture.dtype == "f2" else 4)


class FrameTarget:
    """A frame on the device: linear Rec. 709 in float32.

    Args:
        gl: the context; it must be current here and in every method.
        size_px: width and height.
    """

    def __init__(self, gl: GlContext, size_px: tuple[int, int]) -> None:
        self._gl = gl
        self.size_px = size_px
        self.texture = gl.ctx.texture(size_px, 4, dtype="f4")
        try:
            self._frame = gl.ctx.framebuffer([self.texture])
        except moderngl.Error as error:
            raise UnavailableError(
                f"this GL device ({gl.renderer}) draws into no float32 texture of"
                f" {size_px[0]} x {size_px[1]} pixels ({error}); render smaller, choose another"
                " --backend, or render with --method reference"
            ) from error

    def begin(self, *, clear: bool = True) -> moderngl.Framebuffer:
        """Bind the frame, all black if it is cleared."""
        self._frame.use()
        self._frame.scissor = (0, 0, *self.size_px)
        if clear:
            self._frame.clear()
        self._gl.ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        return self._frame

    def use(self) -> None:
        """Bind the frame as it is."""
        self._frame.use()

    def read(self, columns: slice = slice(None)) -> Float32:
        """Read it: cd/m², (h, columns, 3), first row on top."""
        width, height = self.size_px
        pixels = np.frombuffer(self.texture.read(), dtype=np.float32).reshape(height, width, 4)
        return np.ascontiguousarray(pixels[::-1, columns, :3])


@contextmanager
def added_up(gl: GlContext, add: bool = True) -> Iterator[None]:
    """Let what is drawn meanwhile add to what is there, if it is to."""
    if not add:
        yield
        return
    gl.ctx.enable(moderngl.BLEND)
    gl.ctx.blend_func = moderngl.ONE, moderngl.ONE
    try:
        yield
    finally:
        gl.ctx.disable(moderngl.BLEND)


def check_sizes(gl: GlContext, size_px: tuple[int, int], grid: tuple[int, int, int]) -> None:
    """Check that a device takes a frame and a volume.

    Raises:
        UnavailableError: too many pixels or grid points a side.
    """
    largest = min(gl.limits.texture_2d, *gl.limits.viewport)
    if max(size_px) > largest:
        raise UnavailableError(
            f"camera.size_px = {list(size_px)}; this GL device ({gl.renderer}) takes up to"
            f" {largest} pixels a side; render smaller, or with --method reference"
        )
    if max(grid) > gl.limits.texture_3d:
        raise UnavailableError(
            f"droplet grid {grid}; this GL device ({gl.renderer}) takes up to"
            f" {gl.limits.texture_3d} points a side; use a coarser"
            " volume, or render with --method reference"
        )
