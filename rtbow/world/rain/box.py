"""Where the rain is, without reading its drops."""

from __future__ import annotations

import zipfile

import numpy as np

from rtbow.base.arrays import Array, floats
from rtbow.scene.droplets import Droplets
from rtbow.world.inputs import InputFile


def box_of(droplets: Droplets) -> Array | None:
    """Give the rain's lower and upper corner (2, 3), m; None where its file cannot be read.

    Nothing else is read of a volume file; its mistakes are reported by rendering.
    """
    if droplets.file is None:
        return floats(droplets.box_m)
    kept = _boxes.get(droplets.file)
    if kept is None or not kept[0].unchanged:
        if len(_boxes) >= _MOST_BOXES:
            _boxes.clear()
        # As it is before it is read, so that a later change is seen.
        kept = _boxes[droplets.file] = InputFile.read(droplets.file), _file_box(droplets.file)
    return kept[1]


_boxes: dict[str, tuple[InputFile, Array | None]] = {}
"""Volume files, and the boxes in them."""
_MOST_BOXES = 16


def _file_box(path: str) -> Array | None:
    try:
        with np.load(path, allow_pickle=False) as data:
            box = floats(data["box_m"])
    except (OSError, KeyError, ValueError, TypeError, IndexError, zipfile.BadZipFile):
        return None
    return box if box.shape == (2, 3) else None
