"""Method ``spectral``: the paper's march with a wavelength loop, as a GLSL fragment shader."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from rtbow import atmosphere, constants
from rtbow.airy import SCALE_POWER
from rtbow.arrays import Float32, Progress, no_progress
from rtbow.camera import camera_basis, polarizer_pass
from rtbow.colour import XYZ_TO_RGB
from rtbow.context import GlContext
from rtbow.errors import InputError
from rtbow.extinction import RainExtinction, mean_extinction_towards, rain_extinction
from rtbow.glsl import Define, compile_program, glsl_literal
from rtbow.lights import NEAREST_M, Lamp, Sun
from rtbow.optics import Optics, scene_optics, table_sections
from rtbow.scene import Camera, Scene
from rtbow.section_table import SectionTable, angle_axis, section_table
from rtbow.sections import Sections
from rtbow.steps import LEAST_RAIN_SAMPLES, lamp_steps, most_steps, step_rates
from rtbow.table import NEAR_S_FIXED, NEAR_Z_LOW, POLE_DISTANCE, airy_table, shader_constants
from rtbow.volume import DropletVolume, build_volume

_MAX_STEPS = 1 << 20
_MAX_SECTIONS = 128
"""Cross-sections that a pixel may keep in an array, over wavelengths and suns. Mesa's CPU driver
takes 0.4 s to compile an array of 81 and minutes for one of 401."""
_LOOPS = 65_000
_LOOP_BUDGET = 45_000
"""Loop iterations of one pixel in one pass. Mesa's CPU driver ends all of a shader's loops after
65,535 iterations in sum, silently; longer marches are drawn in several passes that add up."""
_TILE_SECONDS = 0.15
"""Rows are drawn in strips of about this long, so that an interrupt is heard and progress shows."""


_LAMP_DEPTH_SAMPLES = 4
"""Samples of the rain's extinction within a step at a lamp, which may be long in distance."""

_Texture = moderngl.Texture | moderngl.Texture3D | moderngl.TextureArray

_BLOCK = 4
"""Mesa's CPU driver shades blocks of 4 x 4 pixels: a strip that cuts them pays for their whole."""


def _matrix_literal(matrix: NDArray[np.float64]) -> str:
    """Write a matrix as GLSL, which lists columns first."""
    values = ", ".join(glsl_literal(float(v)) for v in matrix.T.ravel())
    return f"mat3({values})"


@dataclass(frozen=True)
class Parts:
    """What a scene is made of, as the shader needs it.

    Attributes:
        optics: per-wavelength numbers.
        volume: the drops.
        sections: cross-sections to be laid out in a table, or None for Airy's bows in place.
        rain: the drops' own extinction, or None.
    """

    optics: Optics
    volume: DropletVolume
    sections: Sections | None
    rain: RainExtinction | None


def scene_parts(scene: Scene, progress: Progress = no_progress) -> Parts:
    """Compute a scene's parts.

    Raises:
        InputError: a spectrum or volume is not usable.
    """
    optics = scene_optics(scene)
    volume = build_volume(scene.droplets)
    return Parts(
        optics,
        volume,
        table_sections(scene, optics, volume, progress),
        rain_extinction(scene, optics, volume) if scene.droplets.extinction else None,
    )


def shader_defines(scene: Scene, parts: Parts) -> dict[str, Define]:
    """Give the shader's constants, and the switches that change its shape for a scene.

    ``shaders/README.md`` lists the switches.
    """
    optics, volume = parts.optics, parts.volume
    table, rain = parts.sections is not None, parts.rain is not None
    sides = ", ".join(glsl_literal(b.side) for b in optics.bows)
    bow_rows = 0 if table else len(optics.bows)
    lights = len(optics.suns) + len(optics.lamps)
    bows: dict[str, Define] = (
        {} if table else {"BOW_COUNT": len(optics.bows), "BOW_SIDE": f"float[]({sides})"}
    )
    return {
        **shader_constants(),
        "EARTH_RADIUS_M": constants.EARTH_RADIUS_M,
        "SCALE_HEIGHT_M": constants.SCALE_HEIGHT_M,
        "MAX_HEIGHT_M": atmosphere.MAX_HEIGHT_M,
        "ALTITUDE_CURVE": atmosphere.ALTITUDE_CURVE,
        "XYZ_TO_RGB": _matrix_literal(XYZ_TO_RGB),
        "NEAREST_M": NEAREST_M,
        "NO_PLANE": constants.NO_PLANE,
        "MAX_STEPS": _MAX_STEPS,
        "LEAST_STEPS": LEAST_RAIN_SAMPLES if rain else 1,
        "LAMP_DEPTH_SAMPLES": _LAMP_DEPTH_SAMPLES,
        "WAVELENGTH_COUNT": len(optics.wavelength_nm),
        **bows,
        "FIRST_LIGHT_ROW": bow_rows,
        "RAIN_ROW": bow_rows + lights,
        "SUN_COUNT": len(optics.suns),
        "LAMP_COUNT": len(optics.lamps),
        "GRID": not volume.uniform,
        "AIR": optics.has_air,
        "EXTINCTION": rain,
        "ATTENUATION": optics.has_air or rain,
        "POLARIZER": scene.camera.polarizer_deg is not None,
        "TABLE": table,
        "DISC": not table
        and (
            any(sun.disc_rad > 0.0 for sun in optics.suns)
            or any(lamp.radius_m > 0.0 for lamp in optics.lamps)
        ),
        "WIDE": not table and _widest_disc(optics, volume) > NEAR_S_FIXED,
        "ONE_RADIUS": _one_radius(parts),
        "POLE": not table and _pole_in_view(scene.camera, optics),
    }


def _widest_disc(optics: Optics, volume: DropletVolume) -> float:
    """Largest scaled disc of any sun, bow, wavelength and drop; infinite for lamps with a size."""
    if any(lamp.radius_m > 0.0 for lamp in optics.lamps):
        return np.inf  # a drop may be next to the lamp
    disc = max((sun.disc_rad for sun in optics.suns), default=0.0)
    scale = max(float(bow.scale.max()) for bow in optics.bows)
    return float(scale * (volume.radius_range_um[1] * 1e-6) ** SCALE_POWER * disc)


def _one_radius(parts: Parts) -> bool:
    """Whether all drops are alike, so that cross-sections need computing once per pixel."""
    optics = parts.optics
    smallest, largest = parts.volume.radius_range_um
    # With attenuation the shader keeps an array of them; very fine wavelength steps would
    # outgrow it.
    dims = optics.has_air or parts.rain is not None
    held = len(optics.wavelength_nm) * len(optics.suns) if dims else 0
    return smallest == largest and held <= _MAX_SECTIONS


def _pole_in_view(camera: Camera, optics: Optics) -> bool:
    """Whether any pixel lies where a disc covers rings about a bow's pole.

    That is about the antisolar point for the primary, about the sun for the secondary.
    """
    # The picture lies within the cone of its corner.
    axis, right, up = camera_basis(camera)
    cone = np.arctan(np.hypot(np.linalg.norm(right), np.linalg.norm(up)))
    for sun in optics.suns:
        reach = cone + POLE_DISTANCE * sun.disc_rad
        for bow in optics.bows:
            towards_pole = -bow.side * sun.direction
            angle = np.arccos(np.clip(towards_pole @ axis, -1.0, 1.0))
            if sun.disc_rad > 0.0 and angle < reach:
                return True
    return False


def bow_edges(optics: Optics, volume: DropletVolume) -> list[float]:
    """Give, per bow, the scattering angle beyond which it is dark.

    The table's first column is dark for the drop that reaches furthest, the smallest; each
    wavelength's own angle and the widest disc are allowed for.
    """
    smallest = max(volume.radius_range_um[0], constants.MIN_RADIUS_UM) * 1e-6
    disc = max((sun.disc_rad for sun in optics.suns), default=0.0)
    edges = []
    for bow in optics.bows:
        reach = -NEAR_Z_LOW / (bow.scale * smallest**SCALE_POWER) + disc
        limits = bow.angle_rad - bow.side * reach
        edges.append(float(limits.min() if bow.side > 0 else limits.max()))
    return edges


def spectral_rows(parts: Parts, *, components: bool) -> Float32:
    """Lay out the per-wavelength numbers as the shader reads them.

    Args:
        parts: the scene's.
        components: the bows' strength of both components, for a polariser.

    Returns:
        float32 (bows + suns + lamps + rain, W, 4): per bow angle, scale, and strength (or
        perpendicular and parallel strength); per light the weights to X, Y, Z and the air depth;
        for rain the extinction relative to the middle of the visible.
    """
    optics = parts.optics
    zeros = np.zeros(len(optics.wavelength_nm))
    rows = []
    for b in () if parts.sections is not None else optics.bows:
        strength = (b.perpendicular, b.parallel) if components else (b.strength, zeros)
        rows.append(np.stack([b.angle_rad, b.scale, *strength], axis=1))
    for weights in (*optics.sun_weights, *optics.lamp_weights):
        rows.append(np.column_stack([weights, optics.air_depth]))
    if parts.rain is not None:
        rows.append(np.stack([parts.rain.ratio, zeros, zeros, zeros], axis=1))
    return np.stack(rows).astype(np.float32)


def _scattering_range(camera: Camera, optics: Optics) -> tuple[float, float]:
    """Least and greatest scattering angle of any sun in the picture, rad."""
    axis, right, up = camera_basis(camera)
    cone = np.arctan(np.hypot(np.linalg.norm(right), np.linalg.norm(up)))
    to_axis = [float(np.arccos(np.clip(sun.direction @ axis, -1.0, 1.0))) for sun in optics.suns]
    # A hair more, for float32.
    return max(min(to_axis) - cone - 1e-4, 0.0), min(max(to_axis) + cone + 1e-4, np.pi)


class SpectralPass:
    """A scene's textures and program on one GL context.

    Args:
        gl: the context; it must be current here and in :meth:`render`.
        scene: the scene.

    Raises:
        InputError: a spectrum or volume is not usable, or beyond what this GL device takes.
    """

    def __init__(self, gl: GlContext, scene: Scene, progress: Progress = no_progress) -> None:
        self._gl = gl
        self._scene = scene
        parts = scene_parts(scene, progress)
        self._check_limits(scene.camera, parts.volume, parts.optics)
        defines = shader_defines(scene, parts)
        self._program = compile_program(gl.ctx, "fullscreen.vert", "rainbow.frag", defines)
        self._triangle = gl.ctx.vertex_array(self._program, [])
        self._textures: dict[str, _Texture] = {}
        self._upload(parts, defines)
        self._set_scene(parts)

    def _check_limits(self, camera: Camera, volume: DropletVolume, optics: Optics) -> None:
        limits = self._gl.limits
        largest = min(limits.texture_2d, *limits.viewport)
        if max(camera.size_px) > largest:
            raise InputError(
                f"camera.size_px = {list(camera.size_px)}; this GL device ({self._gl.renderer})"
                f" takes up to {largest} pixels a side; render smaller, or with --method reference"
            )
        if max(volume.shape) > limits.texture_3d:
            raise InputError(
                f"droplet grid {volume.shape}; this GL device ({self._gl.renderer}) takes up to"
                f" {limits.texture_3d} points a side; use a coarser volume"
            )
        if self._loops_per_step(optics) > _LOOP_BUDGET:
            raise InputError(
                f"{len(self._scene.light)} lights at {len(optics.wavelength_nm)} wavelengths are"
                " more than a shader's loops hold; use fewer lights, a larger"
                " render.wavelength_step_nm, or --method reference"
            )
        if len(optics.wavelength_nm) > limits.texture_2d:
            raise InputError(
                f"render.wavelength_step_nm = {self._scene.render.wavelength_step_nm:g}; gives"
                f" {len(optics.wavelength_nm)} wavelengths, this GL device takes up to"
                f" {limits.texture_2d}; use a larger step"
            )

    @staticmethod
    def _loops_per_step(optics: Optics) -> int:
        lights = len(optics.suns) + len(optics.lamps)
        each = len(optics.wavelength_nm) * (1 + len(optics.bows)) + _LAMP_DEPTH_SAMPLES + 4
        return 4 + lights * each

    def _check_depth_loops(self, optics: Optics) -> None:
        """Refuse marches in several passes each of which would sum depths for too long."""
        # Every pass sums the rain's depth from the start of the ray: once for all suns, and with
        # several samples a step for each lamp.
        suns = 1 if optics.suns else 0
        prefix = self._steps * (suns + len(optics.lamps) * (1 + _LAMP_DEPTH_SAMPLES))
        if prefix > _LOOPS - _LOOP_BUDGET:
            raise InputError(
                f"{self._steps} steps along a ray through rain that attenuates, for"
                f" {len(self._scene.light)} lights, are more than a shader's loops hold; use a"
                " smaller render.steps, a coarser volume, fewer lamps, a larger"
                " render.wavelength_step_nm, or --method reference"
            )

    def _texture(self, data: Float32, channels: int, *, linear: bool) -> moderngl.Texture:
        rows, columns = data.shape[:2]
        contiguous = np.ascontiguousarray(data, dtype=np.float32)
        texture = self._gl.ctx.texture((columns, rows), channels, contiguous, dtype="f4")
        mode = moderngl.LINEAR if linear else moderngl.NEAREST
        texture.filter = (mode, mode)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def _upload(self, parts: Parts, defines: Mapping[str, Define]) -> None:
        optics, volume = parts.optics, parts.volume
        rows = spectral_rows(parts, components=bool(defines["POLARIZER"]))
        self._textures["spectral"] = self._texture(rows, 4, linear=False)
        if parts.sections is None:
            self._upload_airy(optics, defines)
        else:
            self._upload_sections(parts, parts.sections, components=bool(defines["POLARIZER"]))
        if defines["AIR"] and optics.suns:
            column = atmosphere.column_table().log_column
            self._textures["columnTable"] = self._texture(column, 1, linear=True)
        if defines["GRID"]:
            moments = volume.moments()
            if parts.rain is not None:
                field = parts.rain.field.astype(np.float32)[..., None]
                moments = np.concatenate([moments, field], axis=-1)
                self._upload_depths(parts, parts.rain)
            self._textures["dropletMoments"] = self._volume_texture(moments)

    def _upload_airy(self, optics: Optics, defines: Mapping[str, Define]) -> None:
        table = airy_table()
        near = 2 if optics.lamps else 1  # suns need no running integral
        self._textures["airyNearTable"] = self._texture(table.near[..., :near], near, linear=True)
        if defines["DISC"]:
            self._textures["airyFringeTable"] = self._texture(table.fringe[None], 2, linear=True)
        if defines["POLE"]:
            self._textures["airyPoleTable"] = self._texture(table.pole, 2, linear=True)

    def _upload_sections(self, parts: Parts, sections: Sections, *, components: bool) -> None:
        optics, volume = parts.optics, parts.volume
        count = len(optics.wavelength_nm)
        radii = volume.size_range_um
        largest = radii[1] * 1e-6
        if optics.suns:
            discs = tuple(sorted({sun.disc_rad for sun in optics.suns}))
            low, high = _scattering_range(self._scene.camera, optics)
            table = section_table(
                sections, count, angle_axis(low, high, discs[0], largest), radii, volume.sizes,
                discs, components=components, running=False,
            )  # fmt: skip
            self._set_sections("section", table)
            layers = [discs.index(sun.disc_rad) * count for sun in optics.suns]
            self._set_array("sunLayer", layers)
        if optics.lamps:
            table = section_table(
                sections, count, angle_axis(0.0, np.pi, 0.0, largest), radii, volume.sizes,
                (0.0,), components=components, running=True,
            )  # fmt: skip
            self._set_sections("lamp", table)

    def _set_sections(self, name: str, table: SectionTable) -> None:
        """Upload a table of cross-sections and set the uniforms of its axes."""
        layers, rows, columns, channels = table.values.shape
        limits = self._gl.limits
        if columns > limits.texture_2d or rows > limits.texture_2d or layers > limits.layers:
            raise InputError(
                f"cross-sections of {layers} wavelengths, {rows} radii and {columns} angles; this"
                f" GL device ({self._gl.renderer}) takes up to {limits.layers} layers of"
                f" {limits.texture_2d} texels a side; use a larger render.wavelength_step_nm"
            )
        kind = "f2" if table.values.dtype == np.float16 else "f4"
        texture = self._gl.ctx.texture_array(
            (columns, rows, layers), channels, np.ascontiguousarray(table.values), dtype=kind
        )
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = False
        self._textures[f"{name}Table"] = texture
        angles, radii = table.angles, table.radii
        low, high = angles.ends
        self._set(f"{name}Angles", (angles.linear, angles.pole, angles.width))
        self._set(f"{name}Places", (low, 1.0 / (high - low)))
        first = float(np.log(radii.radius_m[0]))
        self._set(f"{name}Radii", (first, radii.per_fold, table.scale))

    def _upload_depths(self, parts: Parts, rain: RainExtinction) -> None:
        lights: tuple[Sun | Lamp, ...] = (*parts.optics.suns, *parts.optics.lamps)
        blocks = [mean_extinction_towards(light, parts.volume, rain.field) for light in lights]
        stacked = np.concatenate(blocks)[..., None]
        if len(stacked) > self._gl.limits.texture_3d:
            most = self._gl.limits.texture_3d // len(blocks[0])
            raise InputError(
                f"light: {len(lights)} lights through rain that attenuates; this GL device"
                f" ({self._gl.renderer}) takes up to {most}; use fewer, or droplets.extinction ="
                " false"
            )
        self._textures["rainToLights"] = self._volume_texture(stacked)

    def _volume_texture(self, data: Float32) -> moderngl.Texture3D:
        depth, rows, columns, channels = data.shape
        contiguous = np.ascontiguousarray(data, dtype=np.float32)
        texture = self._gl.ctx.texture3d((columns, rows, depth), channels, contiguous, dtype="f4")
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = texture.repeat_z = False
        return texture

    def _set(self, name: str, value: object) -> None:
        # The compiler drops what a scene does not use, and its uniform with it.
        if name in self._program:
            self._program[name] = value

    def _set_array(self, name: str, values: Sequence[object]) -> None:
        # moderngl takes a single value, not a list, for an array of one.
        if values:
            self._set(name, values if len(values) > 1 else values[0])

    def _set_scene(self, parts: Parts) -> None:
        optics, volume = parts.optics, parts.volume
        camera, steps = self._scene.camera, self._scene.render.steps
        eye = np.array(camera.position_m)
        for unit, name in enumerate(self._textures):
            self._set(name, unit)
        self._set("frameSize", tuple(float(n) for n in camera.size_px))
        self._set("cameraBasis", tuple(camera_basis(camera).ravel()))
        self._set("eyeHeight", float(eye[2]))
        # Relative to the eye in float64, so that float32 keeps its digits far from the origin.
        self._set("boxLow", tuple(volume.box_m[0] - eye))
        self._set("boxHigh", tuple(volume.box_m[1] - eye))
        self._set("uniformDensity", float(volume.number_per_m3[0, 0, 0]))
        self._set("oneRadius", volume.radius_range_um[0] * 1e-6)
        if camera.polarizer_deg is not None:
            self._set("polarizerPass", tuple(polarizer_pass(camera)))
        rain = parts.rain.greatest if parts.rain is not None else 0.0
        self._set("uniformExtinction", rain)
        rates = step_rates(volume, optics, rain)
        self._set("cellsPerMetre", tuple(rates.cells_per_metre))
        self._set("airPerMetre", rates.air_per_metre)
        self._set("fixedSteps", steps or 0)
        least = LEAST_RAIN_SAMPLES if parts.rain is not None else 1
        self._steps = min(steps or max(most_steps(rates, volume), least), _MAX_STEPS)
        self._steps_per_pass = _LOOP_BUDGET // self._loops_per_step(optics)
        if optics.lamps:
            # Each stretch of a ray gets its half of an even number.
            count = steps or lamp_steps(rates, volume)
            self._steps = max(self._steps, count + count % 2)
            self._set("lampSteps", count)
        if parts.rain is not None and self._steps > self._steps_per_pass:
            self._check_depth_loops(optics)
        if optics.lamps:
            spheres = [(*(lamp.position_m - eye), lamp.radius_m) for lamp in optics.lamps]
            self._set_array("lampSphere", spheres)
        directions = [tuple(sun.direction) for sun in optics.suns]
        shapes = [(sun.altitude_rad, sun.disc_rad) for sun in optics.suns]
        if parts.sections is None:
            self._set_array("bowEdge", bow_edges(optics, volume))
        self._set_array("sunDirection", directions)
        self._set_array("sunShape", shapes)

    def render(self, progress: Progress = no_progress, columns: slice = slice(None)) -> Float32:
        """Draw the frame.

        Args:
            progress: wraps the loop over the picture's rows.
            columns: which columns of the picture, a slice of step 1; all by default.

        Returns:
            Linear Rec. 709 in cd/m², float32 (h, columns, 3), first row on top.
        """
        ctx = self._gl.ctx
        width, height = self._scene.camera.size_px
        left, right, _ = columns.indices(width)
        target = ctx.texture((width, height), 4, dtype="f4")
        frame = ctx.framebuffer([target])
        frame.use()
        frame.clear()
        ctx.disable(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        ctx.enable(moderngl.BLEND)
        ctx.blend_func = moderngl.ONE, moderngl.ONE
        for unit, texture in enumerate(self._textures.values()):
            texture.use(unit)
        for first, count in _strips(height, progress):
            frame.scissor = (left, height - first - count, right - left, count)
            for step in range(0, self._steps, self._steps_per_pass):
                self._set("stepRange", (step, step + self._steps_per_pass))
                self._triangle.render(moderngl.TRIANGLES, vertices=3)
                ctx.finish()
        ctx.disable(moderngl.BLEND)
        frame.scissor = (0, 0, width, height)
        pixels = np.frombuffer(target.read(), dtype=np.float32).reshape(height, width, 4)
        return np.ascontiguousarray(pixels[::-1, left:right, :3])


def _strips(height: int, progress: Progress) -> Iterator[tuple[int, int]]:
    """Cut rows into strips that take about ``_TILE_SECONDS`` each, by the time of the last one.

    Yields the first row and the number of rows; ``progress`` sees every row once.
    """
    rows = iter(progress(range(height)))
    first, count = 0, _BLOCK
    while first < height:
        # Down to a multiple of the block, counted from GL's first row, which is the lowest.
        bottom = max(height - first - count, 0) // _BLOCK * _BLOCK
        count = height - first - bottom
        begun = time.perf_counter()
        yield first, count
        for _ in range(count):
            next(rows, None)
        spent = max(time.perf_counter() - begun, 1e-6)
        first += count
        count = max(int(count * min(max(_TILE_SECONDS / spent, 0.25), 4.0)), 1)
    next(rows, None)  # lets the wrapper finish its line
