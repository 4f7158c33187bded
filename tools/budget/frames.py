"""Frames as X, Y, Z, by either method."""

from __future__ import annotations

from importlib.metadata import version

import rtbow
from rtbow.base.arrays import Array, floats
from rtbow.gl.context import open_context
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.render.renderer import MethodName
from rtbow.scene.model import Scene
from rtbow.world.world import resolve

SIZE = [64, 36]
SIZE_NAME = f"{SIZE[0]}×{SIZE[1]}"


def frame(scene: Scene, method: MethodName) -> Array:
    """Render a scene, by the shader on EGL or by the reference: X, Y, Z (h, w, 3)."""
    if method == "reference":
        from rtbow.reference.render import render_reference

        # Renderer gives float32, which would hide what float32 does.
        return rgb_to_xyz(render_reference(resolve(scene)))
    with rtbow.Renderer(scene, "egl") as renderer:
        return rgb_to_xyz(floats(renderer.render(method)))


def facts() -> dict[str, str]:
    """Give what the budget's numbers depend on: the GL renderer, and libraries' versions."""
    with open_context("egl") as gl:
        device = f"{gl.renderer}; {gl.version}"
    packages = ("numpy", "colour-science", "moderngl")
    return {
        "GL renderer (EGL)": device,
        "Python packages": ", ".join(f"{name} {version(name)}" for name in packages),
    }
