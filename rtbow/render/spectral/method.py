"""Method ``spectral``: the paper's march with a wavelength loop, as a GLSL fragment shader."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np

from rtbow.base.arrays import Float32, Progress, no_progress
from rtbow.base.errors import InputError, UnavailableError
from rtbow.gl.context import GlContext
from rtbow.gl.glsl import Define
from rtbow.gl.program import (
    FrameTarget,
    GlProgram,
    added_up,
    check_sizes,
    texture_bytes,
)
from rtbow.physics.air import rayleigh
from rtbow.render.spectral.layout import (
    LAMP_DEPTH_SAMPLES,
    bow_edges,
    shader_defines,
    spectral_rows,
)
from rtbow.render.spectral.strips import strips
from rtbow.render.uniforms import (
    MAX_STEPS,
    MOST_LOOPS,
    common_uniforms,
    set_uniforms,
)
from rtbow.scene.model import Camera, Scene
from rtbow.tables.airy import airy_table
from rtbow.tables.layout import SectionTable, angle_axis, section_table
from rtbow.world.lights import Lamp, Sun
from rtbow.world.optics import Optics
from rtbow.world.rain.volume import DropletVolume
from rtbow.world.steps import (
    LEAST_RAIN_SAMPLES,
    lamp_steps,
    most_steps,
    step_rates,
)
from rtbow.world.world import Parts, scattering_range, scene_parts

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections
    from rtbow.world.rain.extinction import RainExtinction

_LOOP_BUDGET = 45_000
"""Loop iterations of one pixel in one pass; longer marches are drawn in several that add up. The
rest is left to the sums of the rain's depth, which each pass begins anew."""


class SpectralPass:
    """A scene's textures and program on one GL context.

    Args:
        gl: the context; it must be current here and in :meth:`render`.
        scene: the scene.

    Raises:
        InputError: a spectrum or volume is not usable, or beyond what a shader's loops hold.
        UnavailableError: the scene is beyond what this GL device takes.
    """

    method: Literal["spectral"] = "spectral"

    def __init__(self, gl: GlContext, scene: Scene, progress: Progress = no_progress) -> None:
        gl.ctx.gc()  # what is left of a pass before
        self._gl = gl
        self._scene = scene
        parts = scene_parts(scene, progress)
        self._check_limits(scene.camera, parts.volume, parts.optics)
        defines = shader_defines(scene, parts)
        self._program = GlProgram(gl, "spectral/pixel.frag", defines)
        self._target: FrameTarget | None = None
        self._upload(parts, defines)
        self._set_scene(parts)

    def _check_limits(self, camera: Camera, volume: DropletVolume, optics: Optics) -> None:
        check_sizes(self._gl, camera.size_px, volume.shape)
        if self._loops_per_step(optics) > _LOOP_BUDGET:
            raise InputError(
                f"{len(self._scene.light)} lights at {len(optics.wavelength_nm)} wavelengths are"
                " more than a shader's loops hold; use fewer lights, a larger"
                " render.wavelength_step_nm, or --method reference"
            )
        limit = self._gl.limits.texture_2d
        if len(optics.wavelength_nm) > limit:
            raise UnavailableError(
                f"render.wavelength_step_nm = {self._scene.render.wavelength_step_nm:g}; gives"
                f" {len(optics.wavelength_nm)} wavelengths, this GL device ({self._gl.renderer})"
                f" takes up to {limit}; use a larger step, or render with --method reference"
            )

    @staticmethod
    def _loops_per_step(optics: Optics) -> int:
        lights = len(optics.suns) + len(optics.lamps)
        each = len(optics.wavelength_nm) * (1 + len(optics.bows)) + LAMP_DEPTH_SAMPLES + 4
        return 4 + lights * each

    def _check_depth_loops(self, optics: Optics) -> None:
        """Refuse marches in several passes each of which would sum depths for too long."""
        # Every pass sums the rain's depth from the start of the ray: once for all suns, and with
        # several samples a step for each lamp.
        suns = 1 if optics.suns else 0
        prefix = self._steps * (suns + len(optics.lamps) * (1 + LAMP_DEPTH_SAMPLES))
        if prefix > MOST_LOOPS - _LOOP_BUDGET:
            raise InputError(
                f"{self._steps} steps along a ray through rain that attenuates, for"
                f" {len(self._scene.light)} lights, are more than a shader's loops hold; use a"
                " smaller render.steps, a coarser volume, fewer lamps, a larger"
                " render.wavelength_step_nm, or --method reference"
            )

    def _upload(self, parts: Parts, defines: Mapping[str, Define]) -> None:
        optics = parts.optics
        rows = spectral_rows(parts, components=bool(defines["POLARIZER"]))
        self._program.texture("spectral", rows, linear=False)
        if parts.sections is None:
            self._upload_airy(optics, defines)
        else:
            self._upload_sections(parts, parts.sections, components=bool(defines["POLARIZER"]))
        if defines["AIR"] and optics.suns:
            column = rayleigh.column_table().log_column
            self._program.texture("columnTable", column)
        if defines["GRID"]:
            if parts.rain is not None:
                self._upload_depths(parts, parts.rain)
            self._program.volume("dropletMoments", parts.moments())

    def _upload_airy(self, optics: Optics, defines: Mapping[str, Define]) -> None:
        table = airy_table()
        near = 2 if optics.lamps else 1  # suns need no running integral
        self._program.texture("airyNearTable", table.near[..., :near])
        if defines["DISC"]:
            self._program.texture("airyFringeTable", table.fringe[None])
        if defines["POLE"]:
            self._program.texture("airyPoleTable", table.pole)

    def _upload_sections(self, parts: Parts, sections: Sections, *, components: bool) -> None:
        optics, volume = parts.optics, parts.volume
        count = len(optics.wavelength_nm)
        radii = volume.size_range_um
        largest = radii[1] * 1e-6
        if optics.suns:
            discs = tuple(sorted({sun.disc_rad for sun in optics.suns}))
            low, high = scattering_range(self._scene.camera, optics)
            table = section_table(
                sections, count, angle_axis(low, high, discs[0], largest), radii, volume.sizes,
                discs, components=components, running=False,
            )  # fmt: skip
            self._set_sections("section", table)
            layers = [discs.index(sun.disc_rad) * count for sun in optics.suns]
            self._program.set_array("sunLayer", layers)
        if optics.lamps:
            table = section_table(
                sections, count, angle_axis(0.0, np.pi, 0.0, largest), radii, volume.sizes,
                (0.0,), components=components, running=True,
            )  # fmt: skip
            self._set_sections("lamp", table)

    def _set_sections(self, name: str, table: SectionTable) -> None:
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
        self._program.layers(f"{name}Table", table.values)
        angles, radii = table.angles, table.radii
        low, high = angles.ends
        self._program.set(f"{name}Angles", (angles.linear, angles.pole, angles.width))
        self._program.set(f"{name}Places", (low, 1.0 / (high - low)))
        first = float(np.log(radii.radius_m[0]))
        self._program.set(f"{name}Radii", (first, radii.per_fold, table.scale))

    def _upload_depths(self, parts: Parts, rain: RainExtinction) -> None:
        from rtbow.world.rain.extinction import mean_extinction_towards

        lights: tuple[Sun | Lamp, ...] = (*parts.optics.suns, *parts.optics.lamps)
        blocks = [mean_extinction_towards(light, parts.volume, rain.field) for light in lights]
        stacked = np.concatenate(blocks)[..., None]
        if len(stacked) > self._gl.limits.texture_3d:
            most = self._gl.limits.texture_3d // len(blocks[0])
            raise UnavailableError(
                f"light: {len(lights)} lights through rain that attenuates; this GL device"
                f" ({self._gl.renderer}) takes up to {most}; use fewer, droplets.extinction ="
                " false, or --method reference"
            )
        self._program.volume("rainToLights", stacked)

    def _set_scene(self, parts: Parts) -> None:
        optics, volume = parts.optics, parts.volume
        steps = self._scene.render.steps
        rates = step_rates(volume, optics, parts.rain_per_m)
        set_uniforms(self._program, common_uniforms(self._scene, parts, volume.box_m, rates))
        self._program.set("oneRadius", volume.radius_range_um[0] * 1e-6)
        least = LEAST_RAIN_SAMPLES if parts.rain is not None else 1
        self._steps = min(steps or max(most_steps(rates, volume), least), MAX_STEPS)
        self._steps_per_pass = _LOOP_BUDGET // self._loops_per_step(optics)
        if optics.lamps:
            # Each stretch of a ray gets its half of an even number.
            count = steps or lamp_steps(rates, volume)
            self._steps = max(self._steps, count + count % 2)
            self._program.set("lampSteps", count)
        if parts.rain is not None and self._steps > self._steps_per_pass:
            self._check_depth_loops(optics)
        if optics.lamps:
            spheres = [(*(lamp.position_m - parts.eye_m), lamp.radius_m) for lamp in optics.lamps]
            self._program.set_array("lampSphere", spheres)
        directions = [tuple(sun.direction) for sun in optics.suns]
        shapes = [(sun.altitude_rad, sun.disc_rad) for sun in optics.suns]
        if parts.sections is None:
            self._program.set_array("bowEdge", bow_edges(optics, volume))
        self._program.set_array("sunDirection", directions)
        self._program.set_array("sunShape", shapes)

    def prepare_moves(self) -> None:
        """Do nothing: there are no tables that serve other places."""

    def move(self, scene: Scene) -> bool:
        """Take over another scene, if it is the same one."""
        return scene == self._scene

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
        width, height = self._scene.camera.size_px
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
