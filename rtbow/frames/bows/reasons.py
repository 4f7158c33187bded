"""Why a frame shows no bow, or nothing at all, and which key with which value would change that.

A value is proposed only where the same geometry finds a bow with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from rtbow.base.arrays import Array, Float32
from rtbow.frames.bows.places import Sight, sight_of
from rtbow.physics.geometry import angle_between, direction

if TYPE_CHECKING:
    from rtbow.world.lights import Sun
    from rtbow.world.world import World

_HIGH_SUN_DEG = 20.0
"""Altitude of a sun that is proposed: its primary's top stands 22 degrees high."""
_WIDER_DEG = (75.0, 100.0, 120.0)
"""Fields of view that are proposed."""
_OPAQUE = 50.0
"""Optical depth of the rain from which on it is taken to be the reason of a black frame."""
_NUMBER_PER_M3 = 1000.0
_SKIPPED = 16
"""Of so many rows and columns, one is looked at first for light."""

Keys = Mapping[str, float]


def reasons(
    worlds: Sequence[World], columns: Sequence[slice], black: Sequence[bool]
) -> tuple[str, ...]:
    """Say why parts of a frame show no bow, each in one line with the remedy; none where all do.

    Args:
        worlds: of the parts.
        columns: that each part fills.
        black: whether each part has no light (:func:`is_black`).
    """
    said = map(part_reason, worlds, columns, black)
    return tuple(dict.fromkeys(line for line in said if line))


def is_black(rgb: Float32) -> bool:
    """Tell whether no pixel (h, w, 3) has any light."""
    return not ((rgb[::_SKIPPED, ::_SKIPPED] > 0.0).any() or (rgb > 0.0).any())


def part_reason(world: World, columns: slice, black: bool) -> str:
    """Say why a part of a frame shows no bow; empty where one is in view.

    A sun below the horizon that no air and no Earth hides is said, too: nobody sees such a bow.

    Args:
        world: of the part.
        columns: that it fills.
        black: whether it has no light.
    """
    head = "the picture is black: " if black else "no bow in the picture: "
    sight = sight_of(world, columns)
    if sight is None:
        return f"{head}there are no drops; {_filled(world)}"
    if _buried(world):
        return (
            f"{head}the rain (droplets.box_m) lies below the ground, which hides it; a box that"
            " begins at its height stands on it"
        )
    if not sight.bow_shows:
        return head + _unseen(world, sight)
    if black:
        return head + _dark(world, sight)
    return _impossible(world)


def _buried(world: World) -> bool:
    """Whether all drops are below the ground."""
    if world.around is None or world.around.ground is None:
        return False
    return float(world.volume.box_m[1, 2]) <= world.around.ground_m


def _filled(world: World) -> str:
    fills = f"droplets.density.number_per_m3 = {_NUMBER_PER_M3:g} fills the box"
    return fills if world.volume.uniform else f"{fills}; a volume file has its own number_per_m3"


# --- No bow in view -----------------------------------------------------------------------------


def _unseen(world: World, sight: Sight) -> str:
    found = next((said for said in _remedies(world, sight) if said), _no_remedy(world))
    return f"{_cause(world, sight)}; {found}"


def _cause(world: World, sight: Sight) -> str:
    """Say what keeps the first light's bow out of the picture."""
    if not sight.rain_shows:
        return "the rain (droplets.box_m) lies outside of the picture"
    if not sight.suns:
        return "no bow of a lamp stands in the rain that it shows"
    sun, key = sight.suns[0], world.sun_keys[0].name
    altitude_deg = np.degrees(sun.altitude_rad)
    if not len(sight.bow_directions()):
        top_deg = np.degrees(np.pi - sight.bands[0].middle_rad) - altitude_deg
        if top_deg < 0.0:
            return (
                f"the sun ({key}) is {altitude_deg:.3g} deg high, so that its bow lies below the"
                " horizon, where there is no rain"
            )
        return f"there is no rain (droplets.box_m) where the bow of {key} stands"
    if angle_between(sight.view.forward, -sun.direction) > 0.5 * np.pi:
        return f"the bow stands opposite the sun ({key}), behind the camera"
    return f"the bow of {key} stands outside of the picture"


def _remedies(world: World, sight: Sight) -> Iterator[str]:
    """Propose changes from the least to the greatest; empty texts where they do not help."""
    for keys, changed in _turns(sight):
        yield _turned(world, changed.bow_shows, keys, changed, "the bow")
    for fov_deg in _WIDER_DEG:
        if fov_deg > sight.view.fov_deg:
            widened = sight.widened(fov_deg)
            yield _if(widened.bow_shows, {"camera.fov_deg": fov_deg}, "the bow")
    for keys, changed in _other_suns(world, sight):
        yield _if(changed.bow_shows, keys, "a bow")
    if not sight.rain_shows:
        for keys, changed in _towards(sight, sight.box_m.mean(axis=0) - sight.view.eye_m):
            yield _turned(world, changed.rain_shows, keys, changed, "the rain")


def _if(helps: bool, keys: Keys, what: str) -> str:
    if not helps:
        return ""
    values = " and ".join(f"{key} = {value:g}" for key, value in keys.items())
    return f"{values} {'shows' if len(keys) == 1 else 'show'} {what}"


def _turned(world: World, helps: bool, keys: Keys, changed: Sight, what: str) -> str:
    """Propose angles of the camera, or where it looks if its scene says that."""
    if not (helps and world.looks):
        return _if(helps, keys, what)
    azimuth, altitude = (_rounded(angle) for angle in changed.looking_deg)
    return f"camera.look = [{azimuth:g}, {altitude:g}] shows {what}"


def _turns(sight: Sight) -> Iterator[tuple[Keys, Sight]]:
    """Turn the camera towards the bow: by azimuth alone, by altitude alone, by both."""
    for sun in sight.suns[:1]:  # level with the point opposite the sun the bow is symmetric
        yield from list(_towards(sight, -sun.direction))[:1]
    directions = sight.bow_directions()
    if len(directions):
        yield from _towards(sight, directions[0])


def _towards(sight: Sight, vector: Array) -> Iterator[tuple[Keys, Sight]]:
    """Turn the camera towards a vector (3,): by azimuth alone, by altitude alone, by both."""
    old_azimuth, old_altitude = sight.looking_deg
    azimuth = _rounded(np.degrees(np.arctan2(vector[0], vector[1])))
    altitude = _rounded(np.degrees(np.arctan2(vector[2], np.hypot(vector[0], vector[1]))))
    by_azimuth, by_altitude = {"camera.azimuth_deg": azimuth}, {"camera.altitude_deg": altitude}
    yield by_azimuth, sight.turned(azimuth, old_altitude)
    yield by_altitude, sight.turned(old_azimuth, altitude)
    yield by_azimuth | by_altitude, sight.turned(azimuth, altitude)


def _other_suns(world: World, sight: Sight) -> Iterator[tuple[Keys, Sight]]:
    """Move a sun: to another altitude, and to behind the camera as well."""
    behind = _rounded((sight.looking_deg[0] + 180.0) % 360.0)
    for number, (sun, key) in enumerate(zip(sight.suns, world.sun_keys, strict=True)):
        if key.timed:  # which refuses other keys beside the time
            continue
        azimuth = float(np.degrees(np.arctan2(sun.direction[0], sun.direction[1])))
        high = {f"{key.name}.altitude_deg": _HIGH_SUN_DEG}
        yield high, _with_sun(sight, number, azimuth)
        yield high | {f"{key.name}.azimuth_deg": behind}, _with_sun(sight, number, behind)


def _with_sun(sight: Sight, number: int, azimuth_deg: float) -> Sight:
    moved: list[Sun] = list(sight.suns)
    moved[number] = replace(
        moved[number],
        direction=direction(azimuth_deg, _HIGH_SUN_DEG),
        altitude_rad=float(np.radians(_HIGH_SUN_DEG)),
    )
    return replace(sight, suns=tuple(moved))


def _no_remedy(world: World) -> str:
    timed = next((key for key in world.sun_keys if key.timed), None)
    if timed is not None:
        return f"another {timed.name}.time, with the sun lower than 42 deg, may show one"
    return "change droplets.box_m, so that rain stands opposite a light"


def _rounded(angle_deg: float) -> float:
    return float(np.round(angle_deg)) + 0.0  # of -0, 0


# --- A bow in view, but black or out of this world -----------------------------------------------


def _dark(world: World, sight: Sight) -> str:
    """Say why a picture that could show a bow has no light."""
    down = _sunken(world)
    if down and world.optics.has_air and not sight.lamps:
        sun, key = down[0]
        return f"the sun ({key}) is {_below(sun)}, behind the Earth; {_risen(world)}"
    if world.rain_depth > _OPAQUE:
        return (
            f"the rain lets no light through, with an optical depth of {world.rain_depth:.2g};"
            " droplets.density.number_per_m3 a hundredth of what it is, or droplets.extinction ="
            " false, lets it"
        )
    return "no light reaches the eye from the drops; rtbow info SCENE shows drops and lights"


def _impossible(world: World) -> str:
    """Say that a sun shines from below the horizon, where there is no air that the Earth shades."""
    down = _sunken(world)
    if world.optics.has_air or not down or len(down) < len(world.optics.suns):
        return ""
    sun, key = down[0]
    return (
        f"the sun ({key}) is {_below(sun)}, and without air nothing hides it: nobody sees such a"
        f" bow; {_risen(world)}"
    )


def _sunken(world: World) -> list[tuple[Sun, str]]:
    """Give the suns whose whole disc is below the horizon, with their keys."""
    pairs = zip(world.optics.suns, world.sun_keys, strict=True)
    return [(sun, key.name) for sun, key in pairs if sun.altitude_rad < -sun.disc_rad]


def _below(sun: Sun) -> str:
    return f"{-np.degrees(sun.altitude_rad):.3g} deg below the horizon"


def _risen(world: World) -> str:
    key = world.sun_keys[0]
    if key.timed:
        return f"another {key.name}.time raises it"
    return f"{key.name}.altitude_deg = {_HIGH_SUN_DEG:g} raises it"
