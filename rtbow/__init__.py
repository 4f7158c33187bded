"""Rainbows as radiance, from first principles, on the GPU.

>>> import rtbow
>>> with rtbow.Renderer(rtbow.load_scene("uniform")) as renderer:
...     rgb = renderer.render()
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.version import __version__

if TYPE_CHECKING:
    from rtbow.frames.notebook import show, tone_map
    from rtbow.render.renderer import Renderer
    from rtbow.scene.model import Scene
    from rtbow.scene.text.file import load_scene
    from rtbow.world.arrays import Volume, make_scene

__all__ = [
    "InputError",
    "Renderer",
    "RtbowError",
    "Scene",
    "UnavailableError",
    "Volume",
    "__version__",
    "load_scene",
    "make_scene",
    "show",
    "tone_map",
]

# Loaded when first asked for: importing rtbow alone costs nothing, and --help is quick.
_LAZY = {
    "Renderer": "rtbow.render.renderer",
    "Scene": "rtbow.scene.model",
    "Volume": "rtbow.world.arrays",
    "load_scene": "rtbow.scene.text.file",
    "make_scene": "rtbow.world.arrays",
    "show": "rtbow.frames.notebook",
    "tone_map": "rtbow.frames.notebook",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        from importlib import import_module

        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'rtbow' has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
