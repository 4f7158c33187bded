"""Ozone and aerosol on the way of the drops' light, as the shaders' methods take them.

Ozone lies high above the rain: it dims a sun's spectrum alike for all drops. Aerosol dims each
drop's light by the depths of its layer towards the sun and to the eye; its depth at other
wavelengths is that at 550 nm times a ratio.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from rtbow.base.arrays import Array, Float32, floats
from rtbow.base.errors import UnsuitedError
from rtbow.physics.air.earth_shadow import place_over_sphere
from rtbow.physics.air.rayleigh import horizon_rad
from rtbow.physics.light.spectrum import Spectrum, colour_weights, wavelength_bins
from rtbow.tables.sky.air import shells_of
from rtbow.tables.sky.light import Air
from rtbow.world.lights import Sun
from rtbow.world.steps import StepRates
from rtbow.world.world import World

_MIDDLE_NM = 550.0
_HEIGHTS = 1024
"""Heights at which depths are kept, from the ground to the highest of drops and eye."""
_PLACES = 9
"""Along each side of the rain's box, at which depths are looked at."""
_MOST_OZONE = 0.02
"""The ozone's depth may differ between drops by twice this; it is taken as its middle."""
_SAMPLES_PER_M = 1.0 / 150.0
"""Of rays through rain in haze, whose layers are a kilometre high: within 1e-3 of its light."""


def hazy(world: World) -> bool:
    """Whether aerosol dims a world's light."""
    return world.haze is not None and world.haze.aerosol is not None


def hazy_rates(rates: StepRates, world: World) -> StepRates:
    """Give rates of samples that follow the haze, too."""
    if not hazy(world):
        return rates
    return replace(rates, air_per_metre=max(rates.air_per_metre, _SAMPLES_PER_M))


def check_haze(world: World) -> None:
    """Check that shaders draw a world's ozone and aerosol.

    Raises:
        UnsuitedError: they do not.
    """
    if world.haze is None:
        return
    if world.optics.lamps:
        raise UnsuitedError(
            "atmosphere.ozone_du and aerosol with a lamp: shaders have them for suns alone; leave"
            " them out, or use --method reference"
        )
    for sun, key in zip(world.optics.suns, world.sun_keys, strict=True):
        shaded = hazy(world) and world.shades(sun)
        if shaded or SunHaze(world, sun).ozone_spread > _MOST_OZONE:
            raise UnsuitedError(
                f"atmosphere.ozone_du and aerosol with {key.name} so low that its way through them"
                " differs between drops by more than shaders follow; leave them out, or use"
                " --method reference"
            )


@dataclass(frozen=True)
class SunHaze:
    """Ozone and aerosol between a sun, a world's drops and its eye.

    Attributes:
        world: the world.
        sun: the sun.
    """

    world: World
    sun: Sun

    @cached_property
    def _air(self) -> Air:
        assert self.world.haze is not None
        return self.world.haze.air(floats([_MIDDLE_NM]))

    def _above_ground(self, height_m: Array) -> Array:
        assert self.world.haze is not None
        return self.world.haze.above_ground(height_m)

    def _sun_columns(self, height_m: Array) -> Array:
        clear = self.sun.altitude_rad - horizon_rad(height_m)
        return shells_of(self._air).column_at(height_m, clear)

    @cached_property
    def _ozone_columns(self) -> Array:
        """Vertical columns of ozone before drops that the sun reaches, at some places."""
        if not self.world.shades(self.sun):
            low, high = self._above_ground(self.world.volume.box_m[:, 2])
            return floats(self._sun_columns(np.linspace(low, high, _PLACES))[1])
        # Over the sphere, whose shadow falls on others.
        places, eye = self._places, self.world.view.eye_m
        height, altitude = place_over_sphere(places, eye, self.sun.direction)
        height = self._above_ground(height)
        clear = altitude - horizon_rad(height)
        lit = clear >= 0.0
        columns = floats(shells_of(self._air).column_at(height[lit], clear[lit])[1])
        return columns if len(columns) else np.zeros(1)

    @cached_property
    def _places(self) -> Array:
        """Places in the drops' box (n, 3)."""
        low, high = self.world.volume.box_m
        sides = [np.linspace(low[axis], high[axis], _PLACES) for axis in range(3)]
        return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 3)

    @property
    def ozone_spread(self) -> float:
        """By how much the ozone's greatest depth differs between drops, halved."""
        assert self.world.haze is not None
        if self.world.haze.ozone_du == 0.0:
            return 0.0
        air = self.world.haze.air(floats([600.0]))
        return float(0.5 * np.ptp(self._ozone_columns) * air.beam[1, 0])

    @cached_property
    def _ozone_column(self) -> float:
        """Vertical columns of ozone before the drops."""
        assert self.world.haze is not None
        if self.world.haze.ozone_du == 0.0:
            return 0.0
        return float(self._ozone_columns.mean())

    @cached_property
    def top_m(self) -> float:
        """Height up to which depths are kept."""
        world = self.world
        box, eye = world.volume.box_m, world.view.eye_m
        return max(float(self._above_ground(floats([box[1, 2], eye[2]])).max()), 1.0)

    @cached_property
    def depths(self) -> Array:
        """The aerosol's optical depth at 550 nm from heights to the sun and to the ground (N, 2),
        evenly from the ground to ``top_m``."""
        height = np.linspace(0.0, self.top_m, _HEIGHTS)
        shells = shells_of(self._air)
        below = np.cumsum(shells.amounts(height[:-1], height[1:], np.diff(height))[-1])
        both = [self._sun_columns(height)[-1], np.concatenate([[0.0], below])]
        return floats(self._air.beam[-1, 0] * np.stack(both, axis=1))

    @property
    def middle(self) -> float:
        """Middle of the depths at 550 nm of light from the sun to the eye by way of the drops."""
        return 0.5 * sum(self.ends)

    @property
    def colour_spread(self) -> float:
        """By how much the depths at 450 and 650 nm differ more between drops than at their middle,
        halved."""
        ratio = self.ratio(floats([450.0, 650.0]))
        return float(0.5 * (self.ends[1] - self.ends[0]) * np.ptp(ratio))

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Least and greatest of these depths."""
        places, eye = self._places, self.world.view.eye_m
        height = self._above_ground(places[:, 2])
        level = np.full(len(height), self._above_ground(eye)[2])
        length = np.linalg.norm(places - eye, axis=1)
        to_eye = shells_of(self._air).amounts(level, height, length)[-1] * self._air.beam[-1, 0]
        to_sun = np.interp(height, np.linspace(0.0, self.top_m, _HEIGHTS), self.depths[:, 0])
        depth = to_eye + to_sun
        return float(depth.min()), float(depth.max())

    def ratio(self, wavelength_nm: Array) -> Array:
        """Give the aerosol's depth at wavelengths (W,) over that at 550 nm."""
        assert self.world.haze is not None
        return floats(self.world.haze.air(wavelength_nm).beam[-1] / self._air.beam[-1, 0])

    def left(self, wavelength_nm: Array, depth: float) -> Array:
        """Give the share of light at wavelengths (W,) that ozone and a depth of aerosol leave."""
        assert self.world.haze is not None
        exponent = np.zeros(len(wavelength_nm))
        air = self.world.haze.air(wavelength_nm)
        if self.world.haze.ozone_du:
            exponent -= air.beam[1] * self._ozone_column
        if depth:
            exponent -= depth * air.beam[-1] / self._air.beam[-1, 0]
        return np.exp(exponent)

    def spectrum(self) -> Spectrum:
        """Give the sun's spectrum behind the ozone and the middle of the haze."""
        own = self.sun.spectrum
        nm = wavelength_bins(1.0).wavelength_nm
        nodes = np.union1d(own.wavelength_nm, nm)
        nodes = nodes[(nodes >= nm[0]) & (nodes <= nm[-1])]
        left = np.interp(nodes, nm, self.left(nm, self.middle if hazy(self.world) else 0.0))
        value = np.interp(nodes, own.wavelength_nm, own.value, left=0.0, right=0.0)
        return replace(own, wavelength_nm=nodes, value=value * left)

    @cached_property
    def excess(self) -> Array:
        """By how much X, Y and Z are dimmed more than light at 550 nm per depth of haze (3,)."""
        bins = wavelength_bins(1.0)
        weights = colour_weights(self.spectrum(), bins)
        total = np.maximum(weights.sum(axis=0), 1e-300)
        return floats(self.ratio(bins.wavelength_nm) @ weights / total - 1.0)

    def uniforms(self) -> Mapping[str, Any]:
        """Give the uniforms that ``air/haze.glsl`` reads of it."""
        return {
            "haze.perHeight": 1.0 / self.top_m,
            "haze.eyeHeight": float(self._above_ground(self.world.view.eye_m)[2]),
        }


def haze_rows(world: World) -> Float32:
    """Give the depths of all of a world's suns (suns, N, 2), as textures have them."""
    rows = [SunHaze(world, sun).depths for sun in world.optics.suns]
    return np.asarray(rows, dtype=np.float32)
