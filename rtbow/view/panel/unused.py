"""Keys that say nothing where others stand as they do: the panel leaves them out.

Such a key keeps its value, whatever that is, and comes back as soon as it means something.
"""

from __future__ import annotations

from functools import singledispatch

from pydantic import BaseModel

from rtbow.scene.aim import LOOKED_AT
from rtbow.scene.air import FREE_AEROSOL, Aerosol
from rtbow.scene.droplets import Droplets
from rtbow.scene.lights import LIT, MOON, TIME_AND_PLACE, PointLight, SunLight, spectrum_file
from rtbow.scene.model import Camera, Render, Scattering

_OF_METHODS = {
    "fast": {"wavelength_step_nm", "samples"},
    "spectral": {"max_delta_e", "samples"},
    "reference": {"max_delta_e", "steps"},
}
"""Keys that a method does not ask for. Of auto, which may take any method, there are none."""


@singledispatch
def unused_keys(table: BaseModel, method: str = "auto") -> set[str]:
    """Give the keys of a table that change nothing in the picture, or that follow from others.

    Args:
        table: its values.
        method: by which the picture is drawn.
    """
    return set()


@unused_keys.register
def _(camera: Camera, method: str = "auto") -> set[str]:
    unused = {"projection"}  # the window shows pictures of a lens alone
    unused |= set(LOOKED_AT) if camera.look is not None else set()
    return unused if camera.focal_length_mm is not None else unused | {"sensor_mm"}


@unused_keys.register
def _(sun: SunLight, method: str = "auto") -> set[str]:
    unused = _unused_beyond(sun)
    if sun.time is None:  # the panel sets a sun's direction by date and place, above
        unused |= {*TIME_AND_PLACE}
    if sun.spectrum != MOON or sun.time is not None:
        unused |= {*LIT}
    elif sun.irradiance_w_m2 is not None:
        unused.add("moon_distance_km")  # only the phase has a colour
    return unused


@unused_keys.register
def _(lamp: PointLight, method: str = "auto") -> set[str]:
    return _unused_beyond(lamp)


def _unused_beyond(light: SunLight | PointLight) -> set[str]:
    """Spectra that have names are whole."""
    return set() if spectrum_file(light.spectrum) else {"beyond"}


@unused_keys.register
def _(droplets: Droplets, method: str = "auto") -> set[str]:
    unused = set() if droplets.dims else {"extinction_efficiency"}
    if droplets.around_m is not None:
        unused.add("box_m")
    if droplets.one_kind:  # at every point of a grid alike
        unused.add("grid")
    if droplets.one_kind or droplets.file is not None:
        unused.add("seed")  # nothing is drawn at random
    return unused


@unused_keys.register
def _(scattering: Scattering, method: str = "auto") -> set[str]:
    unused = {"size_spread" if scattering.theory == "airy" else "orders"}
    if scattering.refractive_index is not None:  # instead of water's
        unused |= {"water_temperature_c", "salinity_g_kg"}
    return unused


@unused_keys.register
def _(aerosol: Aerosol, method: str = "auto") -> set[str]:
    return set() if aerosol.model == "custom" else {*FREE_AEROSOL}


@unused_keys.register
def _(render: Render, method: str = "auto") -> set[str]:
    return _OF_METHODS.get(method, set())
