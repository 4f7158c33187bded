"""Draw the pictures of docs/viewer.md: the live window, operated on a screen of its own.

    python tools/make_viewer_pictures.py [-o docs/viewer]

Needs Xvfb.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

if TYPE_CHECKING:
    from rtbow.view.app import Viewer

_SCREEN = (1600, 1000)
_SIZE = [960, 540]
_PATIENCE_S = 120.0


def take(path: Path, name: str, screen: str, act: Callable[[Viewer, Any], None]) -> None:
    """Open a scene, do something with it, and write the window as a PNG."""
    from rtbow.frames.image import write_png
    from rtbow.scene.text.file import load_scene
    from rtbow.view.app import Viewer
    from rtbow.view.document.edits import Opened
    from screen import Hands  # type: ignore[import-not-found]  # of the tests

    scene = load_scene(name, {"camera.size_px": _SIZE})
    viewer, hands = Viewer(Opened(scene, name)), Hands(screen)
    try:
        _settle(viewer)
        act(viewer, hands)
        _settle(viewer)
        write_png(path, viewer.stage.image(), {"scene": scene.source_text})
    finally:
        hands.close()
        viewer.close()
    print(path)


def _settle(viewer: Viewer) -> None:
    viewer.state.wake()
    rest, end = time.monotonic() + 1.0, time.monotonic() + _PATIENCE_S
    while time.monotonic() < end and not (viewer.settled and time.monotonic() > rest):
        viewer.step()


def _point(viewer: Viewer, hands: Any, x: float, y: float, button: int = 0) -> None:
    """Move the mouse to a place, in shares of the picture's size, and press a button there."""
    area = viewer.stage.view_units()
    assert area is not None
    hands.move(area[0] + x * area[2], area[1] + y * area[3])
    for _ in range(3):
        viewer.state.wake()
        viewer.step()
    if button:
        for down in (True, False):
            hands.button(down, button)
            viewer.state.wake()
            viewer.step()


def overview(viewer: Viewer, hands: Any) -> None:
    """The window as it opens, the mouse on the bow."""
    _point(viewer, hands, 0.5, 0.36)


def circles(viewer: Viewer, hands: Any) -> None:
    """Descartes circles, grid and the edges of the rain."""
    viewer.state.overlays |= {"circles", "grid", "box"}
    _point(viewer, hands, 0.98, 0.98)


def spectrum(viewer: Viewer, hands: Any) -> None:
    """A marked point with its spectrum and the cut through it."""
    _point(viewer, hands, 0.3, 0.578, button=3)
    end = time.monotonic() + _PATIENCE_S
    while viewer.state.spectrum is None and time.monotonic() < end:
        viewer.step()
    _point(viewer, hands, 0.3, 0.578)


def compared(viewer: Viewer, hands: Any) -> None:
    """The picture split between drops of two sizes."""
    viewer.split(True)
    viewer.change({"compare.right": {"droplets.radius.radius_um": 80.0}})
    viewer.state.side = "right"
    _point(viewer, hands, 0.98, 0.98)


def false_colours(viewer: Viewer, hands: Any) -> None:
    """Luminance in false colours."""
    viewer.state.overlays |= {"false"}
    _point(viewer, hands, 0.98, 0.98)


PICTURES: dict[str, tuple[str, Callable[[Viewer, Any], None]]] = {
    "window": ("shower", overview),
    "circles": ("curtain", circles),
    "spectrum": ("curtain", spectrum),
    "split": ("uniform", compared),
    "false-colours": ("shower", false_colours),
}


def main() -> None:
    """Run the command line."""
    from screen import virtual_screen

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "viewer")
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    with virtual_screen(*_SCREEN) as screen:
        os.environ["DISPLAY"] = screen
        for name, (scene, act) in PICTURES.items():
            take(given.output / f"{name}.png", scene, screen, act)


if __name__ == "__main__":
    main()
