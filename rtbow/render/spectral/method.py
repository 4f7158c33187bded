"""Method ``spectral``: the paper's march with a wavelength loop, as a GLSL fragment shader."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.base.errors import UnavailableError, UnsuitedError
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import (
    FrameTarget,
    GlProgram,
    added_up,
    row_texture,
    texture_bytes,
)
from rtbow.physics.air import rayleigh
from rtbow.render.checks import check_world
from rtbow.render.haze import SunHaze, haze_rows, hazy_rates
from rtbow.render.spectral.layout import (
    LAMP_DEPTH_SAMPLES,
    SEEN_ROUNDS,
    SEEN_SAMPLES,
    bow_edges,
    pieces,
    pixel_disc,
    pixel_points,
    shader_defines,
    spectral_rows,
)
from rtbow.render.uniforms import (
    MAX_STEPS,
    MOST_LOOPS,
    common_uniforms,
    lamp_points,
    set_uniforms,
    shadow_uniforms,
)
from rtbow.tables.airy import airy_table
from rtbow.tables.layout import SectionTable, angle_axis, section_table
from rtbow.world.optics import Optics
from rtbow.world.steps import LEAST_RAIN_SAMPLES, lamp_steps, most_steps, step_rates
from rtbow.world.world import World

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections
    from rtbow.world.rain.extinction import RainExtinction

_LOOP_BUDGET = 45_000
"""One pass takes so many loop iterations of one pixel; longer marches are drawn in several that add
up. The rest of what a driver takes is left to the sums of the rain's depth, which each pass begins
anew."""

_MOST_PASSES = 5_000
"""Passes over the picture that a march may take; past some thousands the depths that each sums
anew cost more than all else."""

_TILE_SECONDS = 0.15
"""A strip of rows is to take this long."""
_TILE_ROWS = 4
"""Strips are whole multiples of this many rows: Mesa's CPU driver shades blocks of 4 x 4 pixels: a
strip that cuts them pays for their whole."""


class SpectralMethod:
    """The textures and the program of a world on one GL context.

    Args:
        gl: the context; it must be current here and in :meth:`render`.
        world: what to draw.
        building: wraps the loop over parts of an exact table that has to be built first.

    Raises:
        InputError: a spectrum or volume is not usable.
        UnsuitedError: the world is beyond what a shader's loops or float32 hold.
        UnavailableError: the world is beyond what this GL device takes.
    """

    name: Literal["spectral"] = "spectral"

    def __init__(self, gl: GlContext, world: World, building: Progress = no_progress) -> None:
        self._gl, self._world = gl, world
        self._check_limits()
        defines = shader_defines(world)
        theory = "airy" if world.bows_in_place else "table"
        self._program = GlProgram(gl, f"spectral/{theory}.frag", defines)
        self._target: FrameTarget | None = None
        self._upload(defines, building)
        self._set_uniforms()

    def _check_limits(self) -> None:
        world, optics = self._world, self._world.optics
        check_world(self._gl, world)
        if self._loops_per_step(optics) > _LOOP_BUDGET:
            raise UnsuitedError(
                f"{len(optics.lights)} lights at {len(optics.wavelength_nm)} wavelengths are"
                " more than a shader's loops hold; use fewer lights, a larger"
                " render.wavelength_step_nm, or --method reference"
            )
        limit = self._gl.limits.texture_2d
        if len(optics.wavelength_nm) > limit:
            raise UnavailableError(
                f"render.wavelength_step_nm = {world.fineness.wavelength_step_nm:g}; gives"
                f" {len(optics.wavelength_nm)} wavelengths, this GL device ({self._gl.renderer})"
                f" takes up to {limit}; use a larger step, or render with --method reference"
            )

    def _loops_per_step(self, optics: Optics) -> int:
        bows, points = len(optics.bows), pixel_points(self._world)
        rest = LAMP_DEPTH_SAMPLES + 4
        sun = len(optics.wavelength_nm) * (1 + (bows + 1) * points if points else 1 + bows) + rest
        lamp = len(optics.wavelength_nm) * (1 + bows) + rest
        lamps = len(optics.lamps) * lamp_points(self._world)
        return 4 + len(optics.suns) * sun + lamps * lamp

    def _fit_depth_loops(self, optics: Optics) -> None:
        """Shorten passes so far that their loops have room for the depths that each sums anew.

        Every pass sums the rain's depth from the start of the ray: once for all suns, and with
        several samples a step for each lamp, after it has found what is seen of the ray.
        """
        suns = 1 if optics.suns else 0
        each = self._steps * (2 + LAMP_DEPTH_SAMPLES) + SEEN_ROUNDS * SEEN_SAMPLES
        prefix = self._steps * suns + len(optics.lamps) * lamp_points(self._world) * each
        left = min(_LOOP_BUDGET, MOST_LOOPS - prefix)
        self._steps_per_pass = left // self._loops_per_step(optics)
        if self._steps_per_pass < max(1, self._steps // _MOST_PASSES):
            raise UnsuitedError(
                f"{self._steps} steps along a ray through rain that attenuates, for"
                f" {len(optics.lights)} lights, are more than a shader's loops hold; use a"
                " smaller render.steps, a coarser volume, fewer lamps, a larger"
                " render.wavelength_step_nm, or --method reference"
            )

    def _upload(self, defines: Mapping[str, Define], building: Progress) -> None:
        world, optics = self._world, self._world.optics
        rows = spectral_rows(world, components=bool(defines["POLARIZER"]))
        self._program.texture("spectral", rows, linear=False)
        if world.bows_in_place:
            self._upload_airy(optics, defines)
        else:
            self._upload_sections(world.sections(building), components=bool(defines["POLARIZER"]))
        if defines["AIR"] and optics.suns:
            column = rayleigh.column_table().log_column
            self._program.texture("air.columns", column)
        if defines["HAZE"]:
            self._program.texture("haze.depths", haze_rows(world))
            set_uniforms(self._program, SunHaze(world, optics.suns[0]).uniforms())
        if defines["GRID"]:
            if world.rain is not None:
                self._upload_depths(world.rain)
            self._program.volume("volume.moments", world.moments())

    def _upload_airy(self, optics: Optics, defines: Mapping[str, Define]) -> None:
        table, program = airy_table(), self._program
        channels = 2 if optics.lamps else 1  # suns need no running integral
        textures = {"near": row_texture(self._gl, table.near[..., :channels])}
        if defines["DISC"]:
            textures["fringe"] = row_texture(self._gl, table.fringe[None])
        if defines["POLE"]:
            textures["pole"] = row_texture(self._gl, table.pole)
        for theory in ("sunTheory", "lampTheory"):
            for name, texture in textures.items():
                program.bind(f"{theory}.{name}", texture)
            program.set_array(f"{theory}.edge", bow_edges(self._world))

    def _upload_sections(self, sections: Sections, *, components: bool) -> None:
        optics, volume = self._world.optics, self._world.volume
        count = len(optics.wavelength_nm)
        radii = volume.size_range_um
        largest, unit = radii[1] * 1e-6, self._world.scatterer.medium.bow_unit
        if optics.suns:
            own = [pixel_disc(self._world, sun.disc_rad) for sun in optics.suns]
            discs = tuple(sorted(set(own)))
            ends = [self._world.view.angles_from(sun.direction) for sun in optics.suns]
            low, high = min(low for low, _ in ends), max(high for _, high in ends)
            table = section_table(
                sections, count, angle_axis(low, high, discs[0], largest, unit), radii,
                volume.sizes, discs, components=components, running=False,
            )  # fmt: skip
            self._set_sections("sunTheory", table)
            for k in range(len(own)):
                self._program.set(f"suns[{k}].layer", discs.index(own[k]) * count)
        if optics.lamps:
            table = section_table(
                sections, count, angle_axis(0.0, np.pi, 0.0, largest, unit), radii, volume.sizes,
                (0.0,), components=components, running=True,
            )  # fmt: skip
            self._set_sections("lampTheory", table)

    def _set_sections(self, theory: str, table: SectionTable) -> None:
        """Upload a table of cross-sections and set the uniforms of its axes."""
        layers, rows, columns, _ = table.values.shape
        limits = self._gl.limits
        if columns > limits.texture_2d or rows > limits.texture_2d or layers > limits.layers:
            raise UnavailableError(
                f"cross-sections of {layers} wavelengths, {rows} radii and {columns} angles; this"
                f" GL device ({self._gl.renderer}) takes up to {limits.layers} layers of"
                f" {limits.texture_2d} texels a side; use a larger render.wavelength_step_nm, or"
                " render with --method reference"
            )
        program, angles, radii = self._program, table.angles, table.radii
        program.layers(f"{theory}.sections", table.values)
        low, high = angles.ends
        for name, value in (
            ("angles.linear", angles.linear),
            ("angles.pole", angles.pole),
            ("angles.width", angles.width),
            ("angles.start", low),
            ("angles.perPlace", 1.0 / (high - low)),
            ("radii.first", float(np.log(radii.radius_m[0]))),
            ("radii.perFold", radii.per_fold),
            ("radii.scale", table.scale),
        ):
            program.set(f"{theory}.{name}", value)

    def _upload_depths(self, rain: RainExtinction) -> None:
        from rtbow.world.rain.extinction import mean_extinction_towards

        lights, volume = self._world.optics.lights, self._world.volume
        blocks = [mean_extinction_towards(light, volume, rain.field) for light in lights]
        stacked = np.concatenate(blocks)[..., None]
        if len(stacked) > self._gl.limits.texture_3d:
            most = self._gl.limits.texture_3d // len(blocks[0])
            raise UnavailableError(
                f"light: {len(lights)} lights through rain that attenuates; this GL device"
                f" ({self._gl.renderer}) takes up to {most}; use fewer, droplets.extinction ="
                " false, or --method reference"
            )
        self._program.volume("volume.toLights", stacked)

    def _set_uniforms(self) -> None:
        world, optics, volume = self._world, self._world.optics, self._world.volume
        steps = world.fineness.steps
        rates = hazy_rates(step_rates(volume, optics, world.rain_per_m), world)
        set_uniforms(self._program, common_uniforms(world, volume.box_m, rates))
        self._program.set("volume.radius", volume.radius_range_um[0] * 1e-6)
        least = LEAST_RAIN_SAMPLES if world.rain is not None else 1
        parts = pieces(world)
        most = parts * steps if steps else max(most_steps(rates, volume), least)
        if not steps and parts > 1:
            most += parts * least  # each is rounded up, and has its least steps
        self._steps = min(most, MAX_STEPS)
        self._steps_per_pass = _LOOP_BUDGET // self._loops_per_step(optics)
        if optics.lamps:
            # Each stretch of a ray gets its half of an even number.
            count = steps or lamp_steps(rates, volume)
            self._steps = max(self._steps, count + count % 2)
            self._program.set("lampSteps", count)
        if world.rain is not None and self._steps > self._steps_per_pass:
            self._fit_depth_loops(optics)
        for k, lamp in enumerate(optics.lamps):
            self._program.set(f"lamps[{k}].centre", tuple(lamp.position_m - world.view.eye_m))
            self._program.set(f"lamps[{k}].radius", lamp.radius_m)
        for k, sun in enumerate(optics.suns):
            self._program.set(f"suns[{k}].towards", tuple(sun.direction))
            self._program.set(f"suns[{k}].altitude", sun.altitude_rad)
            self._program.set(f"suns[{k}].disc", sun.disc_rad)
            self._program.set(f"suns[{k}].shaded", world.shades(sun))
            for name, value in shadow_uniforms(sun, world.view.eye_m).items():
                self._program.set(f"suns[{k}].shadow.{name}", value)

    def prepare_moves(self) -> None:
        """Do nothing: this method has no tables that serve other places."""

    def move(self, world: World) -> bool:
        """Say whether a world is the one that is drawn: this method follows no moves."""
        return world is self._world

    @property
    def texture_bytes(self) -> int:
        """Memory of the textures."""
        return texture_bytes(self._program.textures.values())

    def draw(self, progress: Progress = no_progress, columns: slice = slice(None)) -> FrameTarget:
        """Draw the frame and wait until it is done.

        Args:
            progress: wraps the loop over the picture's rows.
            columns: which columns of the picture, a slice of step 1; all by default.
        """
        ctx = self._gl.ctx
        width, height = self._world.view.size_px
        left, right, _ = columns.indices(width)
        if self._target is None:
            self._target = FrameTarget(self._gl, (width, height))
        frame = self._target.begin()
        self._program.use()
        with added_up(self._gl):
            for first, count in strips(height, progress):
                frame.scissor = (left, height - first - count, right - left, count)
                for step in range(0, self._steps, self._steps_per_pass):
                    self._program.set("stepRange", (step, step + self._steps_per_pass))
                    self._program.draw()
                    ctx.finish()
        frame.scissor = (0, 0, width, height)
        return self._target

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame and read it (see :meth:`draw`).

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        return self.draw(progress, columns).read(columns)


def strips(height: int, progress: Progress) -> Iterator[tuple[int, int]]:
    """Cut rows into strips that take about ``_TILE_SECONDS`` each, by the time of the last one.

    Yields the first row and the number of rows; ``progress`` sees every row once.
    """
    rows = iter(progress(range(height)))
    first, count = 0, _TILE_ROWS
    while first < height:
        # Down to a multiple of the block, counted from GL's first row, which is the lowest.
        bottom = max(height - first - count, 0) // _TILE_ROWS * _TILE_ROWS
        count = height - first - bottom
        begun = time.perf_counter()
        yield first, count
        for _ in range(count):
            next(rows, None)
        spent = max(time.perf_counter() - begun, 1e-6)
        first += count
        count = max(int(count * min(max(_TILE_SECONDS / spent, 0.25), 4.0)), 1)
    next(rows, None)  # lets the wrapper finish its line
