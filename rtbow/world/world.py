"""A scene resolved: everything that any method needs to know about it, worked out once.

Methods take a world and see nothing of the scene behind it. What only some of them need, and what
takes long, is worked out when it is first asked for and kept with the world.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rtbow.base.arrays import Array, Float32, Progress, floats, no_progress
from rtbow.physics.air.earth_shadow import edge_height_m, shadow_reaches
from rtbow.physics.drop.airy import bow_width
from rtbow.physics.drop.medium import Medium
from rtbow.scene.lens import LENS_KEYS
from rtbow.scene.lights import TIME_AND_PLACE, SunLight
from rtbow.scene.model import Scene
from rtbow.scene.text.values import scene_files
from rtbow.tables.mixtures import KeptMixtures
from rtbow.world.camera.notes import lens_notes
from rtbow.world.camera.resolve import view_of
from rtbow.world.camera.view import View
from rtbow.world.inputs import InputFile, input_files
from rtbow.world.lights import Sun, lamps, light_notes, suns
from rtbow.world.optics import Optics, scene_optics
from rtbow.world.rain.drops import left_out
from rtbow.world.rain.volume import DropletVolume, scene_volume
from rtbow.world.sky import Surroundings, dimming_air, surroundings, surroundings_notes

if TYPE_CHECKING:
    from rtbow.tables.sections import Sections, Theory
    from rtbow.world.rain.extinction import RainExtinction


@dataclass(frozen=True)
class Scatterer:
    """How a single drop scatters.

    Attributes:
        theory: ``airy`` or ``mie``.
        orders: internal reflections (airy; mie has all).
        medium: what it is made of.
        spread: standard deviation of ln(radius) about each size (mie).
    """

    theory: Theory
    orders: tuple[int, ...]
    medium: Medium
    spread: float

    def sections(
        self, wavelength_nm: Array, radii_um: tuple[float, float], progress: Progress = no_progress
    ) -> Sections:
        """Give the cross-sections of drops between two radii at wavelengths in air (W,).

        Args:
            wavelength_nm: the wavelengths.
            radii_um: least and greatest radius that will be asked for.
            progress: wraps the loop over parts of an exact table that must be built.

        Raises:
            InputError: wavelengths or a temperature beyond the table.
        """
        # Imported here, with the compiler of what is summed on the CPU.
        from rtbow.tables.sections import drop_sections

        return drop_sections(
            self.theory, wavelength_nm, self.medium, radii_um,
            orders=self.orders, spread=self.spread, progress=progress,
        )  # fmt: skip

    def mixtures(self, wavelength_nm: Array, progress: Progress = no_progress) -> Sections:
        """Give the cross-sections of drops of mixed sizes at wavelengths in air (W,).

        Their tables are kept: nothing is built or read before a mixture is asked for.

        Args:
            wavelength_nm: the wavelengths.
            progress: wraps the work where a table must be built.
        """
        return KeptMixtures(
            self.theory, self.orders, self.medium, self.spread, floats(wavelength_nm), progress
        )


@dataclass(frozen=True)
class Fineness:
    """How finely a scene asks to be computed.

    Attributes:
        wavelength_step_nm: of methods spectral and reference.
        steps: samples along a ray; None where they follow the grid.
        max_delta_e: CIEDE2000 at the 99th percentile of pixels that method fast may have.
        samples: random walks from each ray of the reference, where drops scatter light again.
    """

    wavelength_step_nm: float
    steps: int | None
    max_delta_e: float
    samples: int


class SunKey(NamedTuple):
    """What a scene calls a sun.

    Attributes:
        name: its key, such as ``light.0``.
        timed: whether a time and a place say where it stands.
    """

    name: str
    timed: bool


@dataclass(frozen=True)
class World:
    """A scene resolved.

    Attributes:
        view: the eye, the picture and the filter before it.
        optics: per-wavelength numbers, and the lights.
        scatterer: how a single drop scatters.
        volume: the drops.
        rain: the drops' own extinction, or None.
        fineness: how finely it asks to be computed.
        around: the air's own light and the ground, or None.
        haze: air whose ozone and aerosol dim light beside its molecules, or None.
        notes: what of the scene is not drawn as it stands, in words.
    """

    view: View
    optics: Optics
    scatterer: Scatterer
    volume: DropletVolume
    rain: RainExtinction | None
    fineness: Fineness
    around: Surroundings | None
    haze: Surroundings | None
    notes: tuple[str, ...]
    _scene: Scene = field(repr=False)
    _still: dict[str, Any] = field(repr=False)
    _files: tuple[InputFile, ...] = field(default=(), repr=False, compare=False)
    _tables: dict[str, Sections] = field(default_factory=dict, repr=False, compare=False)

    @property
    def sun_keys(self) -> tuple[SunKey, ...]:
        """The scene's keys of ``optics.suns``, for messages."""
        return tuple(
            SunKey(f"light.{number}", light.time is not None)
            for number, light in enumerate(self._scene.light)
            if isinstance(light, SunLight)
        )

    @property
    def looks(self) -> bool:
        """Whether the scene says what the camera looks at, and so takes no angles beside it."""
        return self._scene.camera.look is not None

    @property
    def scatters_again(self) -> bool:
        """Whether light of suns and lamps that drops scatter more than once counts."""
        return self._scene.droplets.scattering_orders == "all"

    @property
    def skylight(self) -> bool:
        """Whether light of the sky and the ground that drops scatter counts."""
        return self._scene.droplets.skylight and _skylight_note(self._scene) == ""

    @property
    def rain_per_m(self) -> float:
        """Greatest extinction by the rain, 1/m; 0 where it does not attenuate."""
        return self.rain.greatest if self.rain is not None else 0.0

    @property
    def rain_depth(self) -> float:
        """Greatest optical depth of the rain across its box."""
        return self.rain_per_m * float(np.linalg.norm(np.diff(self.volume.box_m, axis=0)))

    def shades(self, sun: Sun) -> bool:
        """Whether the Earth keeps a sun from some of the drops' box.

        The sun's altitude then counts at each drop, on a sphere; elsewhere it is taken as that at
        the eye all over the box, whose flat shadow must not reach the box either.
        """
        if not self.optics.has_air:
            return False
        box, eye = self.volume.box_m, self.view.eye_m
        flat = sun.altitude_rad < 0.0 and box[0, 2] < edge_height_m(sun.altitude_rad)
        return bool(flat) or shadow_reaches(box, eye, sun.direction)

    @property
    def bows_in_place(self) -> bool:
        """Whether a drop's bows can be evaluated where it is: Airy's theory, one size a point."""
        return self.scatterer.theory == "airy" and self.volume.sizes is None

    @property
    def narrowest_bow_rad(self) -> float:
        """Width of the main bow of the largest drops, rad."""
        return bow_width(self.volume.size_range_um[1] * 1e-6, self.scatterer.medium.bow_unit)

    def sections(self, progress: Progress = no_progress) -> Sections:
        """Give cross-sections of the drops at the world's wavelengths, built when first asked for.

        Args:
            progress: wraps the loop over parts of an exact table that must be built.

        Raises:
            InputError: wavelengths or a temperature beyond the table.
        """
        if "sections" not in self._tables:
            nm = self.optics.wavelength_nm
            self._tables["sections"] = (
                self.scatterer.sections(nm, self.volume.size_range_um, progress)
                if self.volume.sizes is None
                else self.scatterer.mixtures(nm, progress)
            )
        return self._tables["sections"]

    def moments(self) -> Float32:
        """Give what the shader interpolates at grid points: density, density times radius and,
        where rain dims rain, extinction; (nz, ny, nx, 2 or 3)."""
        moments = self.volume.moments()
        if self.rain is None:
            return moments
        extinction = self.rain.field.astype(np.float32)[..., None]
        return np.concatenate([moments, extinction], axis=-1)

    def differs_in_places_alone(self, other: World) -> bool:
        """Whether two worlds differ in where camera and lights are and in the size alone."""
        return self._still is other._still or self._still == other._still


def resolve(scene: Scene) -> World:
    """Resolve a scene.

    Raises:
        InputError: a spectrum or volume is not usable.
    """
    files = input_files(scene_files(scene))  # before they are read: a later change is seen
    optics = scene_optics(scene)
    volume = scene_volume(scene)
    scattering, render = scene.scattering, scene.render
    rain = None
    if scene.droplets.dims:
        # Imported here, with the compiler of what is summed on the CPU.
        from rtbow.world.rain.extinction import rain_extinction

        rain = rain_extinction(scene, optics, volume)
    return World(
        view_of(scene.camera),
        optics,
        Scatterer(
            scattering.theory, scattering.orders, scattering.medium, scattering.size_spread,
        ),
        volume,
        rain,
        Fineness(
            render.wavelength_step_nm, render.steps, render.max_delta_e, render.samples,
        ),
        surroundings(scene),
        dimming_air(scene),
        _notes(scene),
        scene,
        _without_places(scene),
        files,
    )  # fmt: skip


def _notes(scene: Scene) -> tuple[str, ...]:
    """Say what of a scene is not drawn as it stands."""
    radius = scene.droplets.radius
    told = "" if radius is None else left_out(radius)
    return (
        *((f"droplets.radius: {told}",) if told else ()),
        *((_skylight_note(scene),) if scene.droplets.skylight and _skylight_note(scene) else ()),
        *lens_notes(scene),
        *surroundings_notes(scene),
        *light_notes(scene),
    )


def _skylight_note(scene: Scene) -> str:
    """Say why neither sky nor ground can light a scene's drops; empty if they can."""
    if not scene.has_surroundings:
        return (
            "droplets.skylight: no sky or ground lights the drops; add atmosphere.sky or [ground]"
        )
    if not scene.droplets.dims:
        return (
            "droplets.skylight: is left out where rain takes no light out of the sky behind it; add"
            " droplets.extinction = true"
        )
    return ""


def moved(world: World, scene: Scene) -> World | None:
    """Give the world of a scene that differs from its own in where camera and lights are.

    Returns:
        A world that shares all else with this one, this one itself where nothing differs, or None
        if the scenes differ in more, or a file that they name has another content by now.
    """
    before = world._scene
    if not all(file.unchanged for file in world._files):
        return None
    if _without_places(scene) != world._still:
        return None
    if scene == before:
        return world
    optics = world.optics
    if scene.light != before.light:
        # Spectra do not move, and their sums over the wavelengths would take a while.
        optics = replace(optics, suns=suns(scene), lamps=lamps(scene))
    return replace(world, view=view_of(scene.camera), optics=optics, _scene=scene)


def with_step(world: World, step_nm: float) -> World:
    """Give a world as its scene is with another step of wavelengths, nm.

    Raises:
        InputError: a spectrum or volume is not usable any more.
    """
    scene = world._scene
    render = scene.render.model_copy(update={"wavelength_step_nm": step_nm})
    return resolve(scene.model_copy(update={"render": render}))


def _without_places(scene: Scene) -> dict[str, Any]:
    """Give all of a scene but where its camera and lights are, and what of the picture it fills."""
    values = scene.model_dump(exclude={"compare"})
    for name in (
        "position_m", "azimuth_deg", "altitude_deg", "look", "roll_deg", "fov_deg", *LENS_KEYS,
        "lens_shift", "size_px",
    ):  # fmt: skip
        values["camera"].pop(name)
    values["droplets"].pop("around_m")  # its box says where the drops are
    for light in values["light"]:
        for name in ("position_m", "azimuth_deg", "altitude_deg", *TIME_AND_PLACE):
            light.pop(name, None)
    return values
