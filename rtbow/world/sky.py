"""What is around the drops and gives light of its own: the air, and the ground below."""

from __future__ import annotations

from dataclasses import dataclass

from rtbow.scene.model import Scene


@dataclass(frozen=True)
class Surroundings:
    """What is around the drops.

    Attributes:
        glows: whether the air's own light is drawn.
        albedo: of the ground; None where there is none, and what is below the horizon is black.
    """

    glows: bool
    albedo: float | None


def surroundings(scene: Scene) -> Surroundings | None:
    """Give what a scene has around its drops; None if there is nothing."""
    if not scene.has_surroundings:
        return None
    glows = scene.atmosphere is not None and scene.atmosphere.sky
    return Surroundings(glows, None if scene.ground is None else scene.ground.albedo)


def surroundings_notes(scene: Scene) -> tuple[str, ...]:
    """Say what of the lights a scene's surroundings do not show."""
    if scene.has_surroundings and any(light.type == "point" for light in scene.light):
        return ("lamps light the drops alone, not the air that glows nor the ground",)
    return ()
