"""Draws Dear ImGui's lists with moderngl, on any context: a window's or none."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
from imgui_bundle import imgui

from rtbow.gl.glsl import compile_program

if TYPE_CHECKING:
    from rtbow.gl.context import GlContext

_LAYOUT = "2f 2f 4f1"
_OVER: Any = (
    moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA,
)  # fmt: skip
"""Blending of colour and of opacity."""
_START_BYTES = 1 << 16
_INDEX_BYTES = 4  # lists are put together, and hold more vertices than 16 bits count


class ImguiRenderer:
    """Keeps ImGui's textures and draws its lists; one for each ImGui context.

    Args:
        gl: the context; it must be current here and in every method.
    """

    def __init__(self, gl: GlContext) -> None:
        self._ctx = gl.ctx
        self._program = _compiled(gl.ctx)
        self._textures: dict[int, moderngl.Texture] = {}
        self._vertices = self._indices = 0
        self._grow(_START_BYTES, _START_BYTES)
        io = imgui.get_io()
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        io.backend_flags |= imgui.BackendFlags_.renderer_has_vtx_offset
        platform = imgui.get_platform_io()
        platform.renderer_texture_max_width = gl.limits.texture_2d
        platform.renderer_texture_max_height = gl.limits.texture_2d

    def _grow(self, vertex_bytes: int, index_bytes: int) -> None:
        if vertex_bytes <= self._vertices and index_bytes <= self._indices:
            return
        self._vertices = max(self._vertices, 2 * vertex_bytes)
        self._indices = max(self._indices, 2 * index_bytes)
        self._vertex_buffer = self._ctx.buffer(reserve=self._vertices, dynamic=True)
        self._index_buffer = self._ctx.buffer(reserve=self._indices, dynamic=True)
        self._connect()

    def _connect(self) -> None:
        """Bind the buffers to the program."""
        content = [(self._vertex_buffer, _LAYOUT, "place", "texel", "tint")]
        self._array = self._ctx.vertex_array(
            self._program, content, self._index_buffer, _INDEX_BYTES
        )

    def recompile(self) -> None:
        """Make the program anew, its shaders having changed.

        Raises:
            RtbowError: a shader does not compile; the program stays as it was.
        """
        self._program = _compiled(self._ctx)
        self._connect()

    def render(self, data: imgui.ImDrawData, target: moderngl.Framebuffer) -> None:
        """Draw what ``imgui.render`` put together over a framebuffer."""
        self._update_textures()
        scale = data.framebuffer_scale
        width = int(data.display_size.x * scale.x)
        height = int(data.display_size.y * scale.y)
        if width <= 0 or height <= 0:
            return
        commands = self._upload(data, (width, height))
        target.use()
        target.viewport = (0, 0, width, height)
        ctx = self._ctx
        ctx.enable_only(moderngl.BLEND)
        ctx.blend_func = _OVER
        across, down = 2.0 / data.display_size.x, -2.0 / data.display_size.y
        self._program["toScreen"] = (
            across, down, -1.0 - data.display_pos.x * across, 1.0 - data.display_pos.y * down,
        )  # fmt: skip
        self._program["image"] = 0
        bound = None
        for name, scissor, first, count in commands:
            if name != bound:
                self._textures[name].use(0)
                bound = name
            target.scissor = scissor
            self._array.render(moderngl.TRIANGLES, vertices=count, first=first)
        target.scissor = (0, 0, width, height)
        ctx.disable(moderngl.BLEND)

    def _upload(
        self, data: imgui.ImDrawData, size: tuple[int, int]
    ) -> list[tuple[int, tuple[int, int, int, int], int, int]]:
        """Upload all lists; give texture, scissor, first index and count of each command."""
        lists = [one for one in data.cmd_lists if one.vtx_buffer.size()]
        vertices = sum(one.vtx_buffer.size() for one in lists)
        indices = sum(one.idx_buffer.size() for one in lists)
        self._grow(vertices * imgui.VERTEX_SIZE, indices * _INDEX_BYTES)
        self._vertex_buffer.orphan()
        self._index_buffer.orphan()
        every = np.empty(indices, dtype=np.uint32)
        commands = []
        vertex = index = 0
        for one in lists:
            count = one.vtx_buffer.size()
            # Views of ImGui's own memory: copied by the upload, and not kept.
            self._vertex_buffer.write(
                _memory(one.vtx_buffer.data_address(), count * imgui.VERTEX_SIZE),
                offset=vertex * imgui.VERTEX_SIZE,
            )
            own = one.idx_buffer.size()
            memory = _memory(one.idx_buffer.data_address(), own * imgui.INDEX_SIZE)
            theirs = np.ndarray(own, dtype=f"u{imgui.INDEX_SIZE}", buffer=memoryview(memory))
            for command in one.cmd_buffer:
                first, many = command.idx_offset, command.elem_count
                place = slice(index + first, index + first + many)
                # The offset of the list's vertices stands in the indices: 3.3 core has no other.
                every[place] = theirs[first : first + many]
                every[place] += np.uint32(vertex + command.vtx_offset)
                scissor = _scissor(command.clip_rect, data, size)
                if many and scissor is not None:
                    commands.append((command.tex_ref.get_tex_id(), scissor, index + first, many))
            vertex += count
            index += own
        self._index_buffer.write(every)
        return commands

    def _update_textures(self) -> None:
        """Make, change and drop textures as ImGui asks for."""
        status = imgui.ImTextureStatus
        for wanted in imgui.get_platform_io().textures:
            if wanted.status == status.want_create:
                size = wanted.width, wanted.height
                texture = self._ctx.texture(size, 4, wanted.get_pixels_array())
                texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
                texture.repeat_x = texture.repeat_y = False
                self._textures[texture.glo] = texture
                wanted.set_tex_id(texture.glo)
                wanted.set_status(status.ok)
            elif wanted.status == status.want_updates:
                texture = self._textures[wanted.tex_id]
                pixels = wanted.get_pixels_array().reshape(wanted.height, wanted.width, 4)
                for part in wanted.updates:
                    changed = pixels[part.y : part.y + part.h, part.x : part.x + part.w]
                    viewport = (part.x, part.y, part.w, part.h)
                    texture.write(np.ascontiguousarray(changed), viewport=viewport, alignment=1)
                wanted.set_status(status.ok)
            elif wanted.status == status.want_destroy and wanted.unused_frames > 0:
                self._textures.pop(wanted.tex_id, None)
                wanted.set_tex_id(0)
                wanted.set_status(status.destroyed)


def _compiled(ctx: moderngl.Context) -> moderngl.Program:
    return compile_program(ctx, "view/imgui.vert", "view/imgui.frag", {})


def _memory(address: int, size: int) -> ctypes.Array[ctypes.c_char]:
    return (ctypes.c_char * size).from_address(address)


def _scissor(
    clip: imgui.ImVec4, data: imgui.ImDrawData, size: tuple[int, int]
) -> tuple[int, int, int, int] | None:
    """Give a command's rectangle in the framebuffer, counted from below; None if it is empty."""
    left, top, right, bottom = clip.x, clip.y, clip.z, clip.w
    x, y, scale = data.display_pos.x, data.display_pos.y, data.framebuffer_scale
    left, right = max((left - x) * scale.x, 0.0), min((right - x) * scale.x, size[0])
    top, bottom = max((top - y) * scale.y, 0.0), min((bottom - y) * scale.y, size[1])
    if right <= left or bottom <= top:
        return None
    return int(left), int(size[1] - bottom), int(right - left), int(bottom - top)
