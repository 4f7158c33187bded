"""A frame on file with the scene that its metadata hold, so that its bows can be measured."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rtbow.base.arrays import Float32
from rtbow.base.errors import InputError, shown_path
from rtbow.frames.bows.measured import FrameMeasures, measured
from rtbow.frames.image import EXPOSURE_TEXT, read_exr
from rtbow.scene.model import Scene
from rtbow.scene.text.file import scene_of_frame
from rtbow.world.world import resolve


@dataclass(frozen=True)
class StoredFrame:
    """A frame with its scene.

    Attributes:
        rgb: linear Rec. 709 in cd/m² (h, w, 3).
        scene: what it shows.
        exposure_ev: exposure value (ISO 100) of the picture of the same run; None without one.
    """

    rgb: Float32
    scene: Scene
    exposure_ev: float | None

    def measured(self) -> FrameMeasures:
        """Measure it.

        Raises:
            InputError: a spectrum or volume of its scene is not usable.
        """
        parts = self.scene.parts()
        return measured(
            [resolve(part) for part, _ in parts], [columns for _, columns in parts], self.rgb
        )


def stored_frame(path: str) -> StoredFrame:
    """Read a frame with its scene.

    Args:
        path: an ``.exr`` that rtbow wrote.

    Raises:
        InputError: a file that is no such frame, that holds no scene, or has another size.
    """
    shown = shown_path(path)
    if Path(path).suffix.lower() != ".exr":
        raise InputError(
            f"{shown}: is a displayed picture, which has lost its luminance; must be .exr; render"
            " it with -o NAME.exr as well"
        )
    rgb, texts = read_exr(path)
    if not texts.get("scene"):
        raise InputError(
            f"{shown}: holds no scene in its metadata, so that nothing says where camera and sun"
            " are; name a frame that rtbow render wrote, or a SCENE"
        )
    scene = scene_of_frame(texts["scene"], texts.get("sceneName", ""), path)
    height, width = rgb.shape[:2]
    if scene.camera.size_px != (width, height):
        raise InputError(
            f"{shown}: has {width} x {height} pixels, its scene"
            f" {scene.camera.size_px[0]} x {scene.camera.size_px[1]}: it was cropped or scaled;"
            " name the frame as rtbow wrote it"
        )
    exposure = texts.get(EXPOSURE_TEXT)
    try:
        return StoredFrame(rgb, scene, None if exposure is None else float(exposure))
    except ValueError:
        return StoredFrame(rgb, scene, None)
