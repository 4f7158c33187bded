"""What of a scene's camera is not drawn as its text has it."""

from __future__ import annotations

import tomllib

from rtbow.scene.model import Scene
from rtbow.scene.panorama import LENS_ALONE, PANORAMA

_TYPED = "# --set camera."
"""What stands before an override of the camera at the end of a scene's text."""


def lens_notes(scene: Scene) -> tuple[str, ...]:
    """Say what a panorama leaves out or changes of the camera that its scene's text has.

    That is where an override has made it a panorama: a text that says so itself has no such keys.
    """
    camera, text = scene.camera, scene.source_text
    if not camera.whole_sphere or f"{_TYPED}projection=" not in text:
        return ()
    before = tomllib.loads(text).get("camera", {})
    if before.get("projection") == PANORAMA:
        return ()
    idle = [key for key, values in LENS_ALONE.items() if before.get(key, 0) not in (0, *values)]
    look = before.get("look")
    if isinstance(look, list) and look[1] != 0 and camera.look is None:
        idle.append("the altitude of look")
    size = before.get("size_px", [*camera.size_px])
    said = [f"{', '.join(idle)} of its camera left out"] if idle else []
    if size != [*camera.size_px] and f"{_TYPED}size_px" not in text:
        said.append(f"size_px = {[*camera.size_px]} instead of {size}")
    if not said:
        return ()
    return (f"a panorama shows all directions, twice as wide as high: {'; '.join(said)}",)
