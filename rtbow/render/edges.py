"""Where the edges of the rain are in a picture whose pixels are means over their area.

There a pixel takes more than one ray (``shaders/common/footprint.glsl``). Mesa's CPU driver runs
the code of a branch that no pixel takes, so that a program that could would cost every pixel:
blocks of pixels at the edges are found ahead and drawn by a program of their own.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rtbow.base.arrays import Array, Float32, Indices, floats
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import GlProgram, Texture, row_texture
from rtbow.render.uniforms import MOST_BEND, MOST_KINK, NEAR_LAMP
from rtbow.world.camera.view import View

BLOCK = 4
"""Pixels along a block's sides: those that Mesa's CPU driver shades together."""
_COARSE = 16
"""Pixels along the blocks that are looked at first."""

Mask = NDArray[np.bool_]


def edge_blocks(view: View, box_m: Array, lamp_m: Array | None = None) -> Mask:
    """Find the blocks in which some pixel's length of rain is not as good as linear.

    Args:
        view: the picture.
        box_m: where the drops are (2, 3).
        lamp_m: a lamp whose surroundings count, too (3,).

    Returns:
        Booleans (rows, columns) of blocks, the lowest row first.
    """
    width, height = view.size_px
    parts = _COARSE // BLOCK
    rows, columns = -(-height // _COARSE), -(-width // _COARSE)
    across, up = np.meshgrid(np.arange(columns), np.arange(rows))
    coarse = _at_edges(view, box_m, lamp_m, across.ravel(), up.ravel(), _COARSE)
    across, up = across.ravel()[coarse], up.ravel()[coarse]
    within = np.arange(parts)
    finer_across = np.repeat(parts * across[:, None] + within, parts, axis=0).ravel()
    finer_up = (np.repeat(parts * up[:, None] + within, parts, axis=1)).ravel()
    mask = np.zeros((parts * rows, parts * columns), dtype=np.bool_)
    mask[finer_up, finer_across] = _at_edges(view, box_m, lamp_m, finer_across, finer_up, BLOCK)
    return mask


def _at_edges(
    view: View, box_m: Array, lamp_m: Array | None, across: Indices, up: Indices, block: int
) -> Mask:
    """Say which of some blocks (n,) may have such pixels; never too few.

    A block's rays are bounded by their components, each by itself: from these follow the least and
    the greatest distance at which any of them meets a face.
    """
    rays, _ = view.rays_through(
        floats((across + 0.5) * block), floats(view.size_px[1] - (up + 0.5) * block)
    )
    pixel, wide = view.block_extents(rays, block)
    low, high = box_m - view.eye_m
    flat = np.abs(rays) < wide  # some ray may be along the faces
    with np.errstate(divide="ignore", invalid="ignore"):
        sides = np.stack([rays - 0.5 * wide, rays + 0.5 * wide], axis=1)  # (n, 2, 3)
        met = np.stack([low / sides, high / sides])
        near, far = met.min(axis=0), met.max(axis=0)
    inside = (low <= 0.0) & (high >= 0.0)
    entry = np.where(flat, np.where(inside, -np.inf, 0.0), near.min(axis=1))
    entry_last = np.where(flat, np.where(inside, -np.inf, np.inf), near.max(axis=1))
    leave = np.where(flat, np.inf, far.max(axis=1))
    leave_first = np.where(flat, np.abs(met).min(axis=(0, 2)), far.min(axis=1))
    soonest, latest = np.maximum(entry.max(axis=1), 0.0), leave.min(axis=1)
    # Faces that may be the first, or the last, one that a ray meets.
    firsts, lasts = entry_last > soonest[:, None], leave_first < latest[:, None]
    least = np.where(lasts, leave_first, np.inf).min(axis=1)
    least -= np.where(firsts, entry_last, 0.0).max(axis=1)
    # Within a pixel, at the block's ray that meets the faces at the most grazing angle.
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = 0.71 * pixel / np.maximum(np.abs(rays) - 0.5 * wide, 0.0)
        near_wide = np.where(firsts, np.abs(entry_last) * bend, 0.0).sum(axis=1)
        far_wide = np.where(lasts, np.abs(leave) * bend, 0.0).sum(axis=1)
        kink = np.where(firsts.sum(axis=1) > 1, near_wide, 0.0)
        kink += np.where(lasts.sum(axis=1) > 1, far_wide, 0.0)
        even = (kink < MOST_KINK * least) & ~np.any((firsts | lasts) & (bend > MOST_BEND), axis=1)
    edges = ~((soonest > latest) | even)
    if lamp_m is not None:
        towards = lamp_m - view.eye_m
        side = np.linalg.norm(np.cross(towards, rays), axis=1)
        reach = (NEAR_LAMP + block) * view.pixel_rad
        edges |= side < reach * np.maximum(rays @ towards, 0.0)
    return np.asarray(edges)


def rectangles(mask: Mask, size_px: tuple[int, int]) -> Float32:
    """Give the rectangles that cover a mask's blocks, each once.

    Args:
        mask: of blocks (rows, columns), the lowest row first.
        size_px: of the picture.

    Returns:
        Left, bottom, right and top (n, 4), from -1 to 1 across the picture.
    """
    padded = np.zeros((mask.shape[0], mask.shape[1] + 2), dtype=np.int8)
    padded[:, 1:-1] = mask
    change = np.diff(padded, axis=1)
    found: list[list[int]] = []
    open_: dict[tuple[int, int], int] = {}  # runs of the last row: places in the list
    for row in range(len(mask)):
        starts, ends = np.flatnonzero(change[row] > 0), np.flatnonzero(change[row] < 0)
        runs = list(zip(starts.tolist(), ends.tolist(), strict=True))
        here = {}
        for run in runs:
            if run in open_:
                found[open_[run]][3] = row + 1
                here[run] = open_[run]
            else:
                here[run] = len(found)
                found.append([run[0], row, run[1], row + 1])
        open_ = here
    corners = np.array(found, dtype=float).reshape(-1, 4) * BLOCK
    across = np.minimum(2.0 * corners / np.array([*size_px, *size_px]) - 1.0, 1.0)
    return np.asarray(across, dtype=np.float32)


class PixelPass:
    """The last pass of a light: one program or, where pixels are areas, another for the edges.

    Args:
        gl: the context; it must be current here and in every method.
        fragment: file name of the fragment stage.
        defines: its constants and switches; PIXEL_AREA among them.
        whole: draw all of the picture as its edges.

    Attributes:
        programs: which take all that is bound and set.
    """

    def __init__(
        self, gl: GlContext, fragment: str, defines: Mapping[str, Define], *, whole: bool = False
    ) -> None:
        self._gl, self._whole = gl, whole
        if not defines["PIXEL_AREA"]:
            self.programs = [GlProgram(gl, fragment, {**defines, "PIXEL_EDGES": False})]
            return
        self.programs = [
            GlProgram(gl, fragment, {**defines, "PIXEL_EDGES": edges}, "common/rectangles.vert")
            for edges in (False, True)
        ]
        self._counts = [0, 0]
        self._placed: tuple[bytes, ...] = ()

    def place(self, view: View, box_m: Array, lamp_m: Array | None = None) -> None:
        """Find the edges of a picture (:func:`edge_blocks`)."""
        if len(self.programs) == 1:
            return
        key = tuple(
            [np.array(view.size_px).tobytes(), view.basis.tobytes(), view.eye_m.tobytes()]
            + [part.tobytes() for part in (box_m, lamp_m) if part is not None]
        )
        if key == self._placed:
            return
        self._placed = key
        edges = edge_blocks(view, box_m, lamp_m) | self._whole
        for number, mask in enumerate((~edges, edges)):
            rects = rectangles(mask, view.size_px)
            self._counts[number] = len(rects)
            if len(rects):
                texture = row_texture(self._gl, rects[None], linear=False)
                self.programs[number].bind("rectangles", texture)

    def bind(self, name: str, texture: Texture) -> None:
        """Take a texture for a sampler of all programs that have it."""
        for program in self.programs:
            program.bind(name, texture)

    def set(self, name: str, value: Any) -> None:
        """Set a uniform of all programs that have it."""
        for program in self.programs:
            program.set(name, value)

    def draw(self) -> None:
        """Draw over the bound framebuffer."""
        if len(self.programs) == 1:
            self.programs[0].use()
            self.programs[0].draw()
            return
        for program, count in zip(self.programs, self._counts, strict=True):
            if count:
                program.use()
                program.draw(6 * count)
