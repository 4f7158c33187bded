"""The error of a frame against the float64 reference, on some of its pixels.

The reference takes a CPU minutes to hours for a whole frame. Its radiance along a ray does not
depend on the others, so a sample of the frame's own pixels is compared, spread evenly over it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rtbow.base.arrays import Array, Float32, Indices, Progress, floats, no_progress
from rtbow.base.cache import cached_arrays, file_digest, source_digest
from rtbow.bench.row import SampleDifference
from rtbow.frames.difference import FrameDifference, frame_difference
from rtbow.physics.light.colour import rgb_to_xyz
from rtbow.scene.model import Scene
from rtbow.scene.text.values import scene_files
from rtbow.world.world import resolve

REFERENCE_STEP_NM = 1.0
"""Wavelength step of the reference, in nm: fine enough to be the truth for coarser ones."""
SAMPLE_SEED = 1
DARK_CD_M2 = 1e-9
"""Luminance below which a frame has no light to compare: a thousandth of what an eye in the dark
sees. The dark side of a bow falls off to 1e-30 and below, where float32 has ended."""
REFERENCE_CODE = ("base.limits", "bench.error", "physics", "tables", "world", "reference")
"""The packages and modules from whose code the reference's numbers follow. The scene is none of
them: its values are in the cache's key."""
_AT_A_TIME = 128
"""Pixels whose reference is computed together: the cross-sections of more would fill the memory."""


@dataclass(frozen=True)
class PixelSample:
    """Some pixels of a frame.

    Attributes:
        size_px: the frame's width and height.
        rows: row of each, first on top (n,).
        columns: column of each (n,).
    """

    size_px: tuple[int, int]
    rows: Indices
    columns: Indices

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def whole(self) -> bool:
        """Whether these are all of the frame's pixels."""
        return len(self) == self.size_px[0] * self.size_px[1]

    def of(self, frame: Array | Float32) -> Array:
        """Give these pixels (n, 3) of a frame (h, w, 3), in float64."""
        return floats(frame[self.rows, self.columns])

    def describe(self) -> str:
        """Say where the pixels are."""
        pixels = self.size_px[0] * self.size_px[1]
        if self.whole:
            return f"all {pixels} pixels"
        return (
            f"{len(self)} of {pixels} pixels: one at random, with seed {SAMPLE_SEED}, in each of as"
            " many equal cells of the frame"
        )


def sample_pixels(size_px: tuple[int, int], count: int | None) -> PixelSample:
    """Choose pixels of a frame, one at random in each cell of a grid over it.

    Args:
        size_px: the frame's width and height.
        count: how many; None, or more than the frame has, takes all.
    """
    width, height = size_px
    if count is None or count >= width * height:
        rows, columns = np.indices((height, width)).reshape(2, -1)
        return PixelSample(size_px, rows, columns)
    rng = np.random.default_rng(SAMPLE_SEED)
    # Cells about as wide as high, and none narrower than a pixel.
    bands = int(np.clip(round((count * height / width) ** 0.5), -(-count // width), height))
    bands = max(min(bands, count), 1)
    chosen_rows: list[Indices] = []
    chosen_columns: list[Indices] = []
    for band in range(bands):
        across = count * (band + 1) // bands - count * band // bands
        top, bottom = height * band // bands, height * (band + 1) // bands
        edges = width * np.arange(across + 1) // across
        chosen_rows.append(rng.integers(top, bottom, across))
        chosen_columns.append(rng.integers(edges[:-1], edges[1:]))
    return PixelSample(size_px, np.concatenate(chosen_rows), np.concatenate(chosen_columns))


def reference_xyz(scene: Scene, sample: PixelSample, progress: Progress = no_progress) -> Array:
    """Compute the reference at some pixels, or take it from the cache.

    Args:
        scene: the scene, at the frame's size; its wavelength step is not used.
        sample: the pixels.
        progress: wraps the loop over groups of pixels.

    Returns:
        X, Y, Z (n, 3), Y in cd/m².

    Raises:
        InputError: a spectrum or volume is not usable.
    """
    xyz = np.zeros((len(sample), 3))
    for part, columns in scene.parts():
        inside = (sample.columns >= columns.start) & (sample.columns < columns.stop)
        if inside.any():
            rows, places = sample.rows[inside], sample.columns[inside]
            xyz[inside] = _part_xyz(part, rows, places, progress)
    return xyz


def _part_xyz(part: Scene, rows: Indices, columns: Indices, progress: Progress) -> Array:
    def build() -> dict[str, Array]:
        # Slow to import, and not needed for what the cache has.
        from rtbow.reference.render import radiance_of_pixels

        step = part.render.model_copy(update={"wavelength_step_nm": REFERENCE_STEP_NM})
        world = resolve(part.model_copy(update={"render": step}))
        groups_xyz = [
            radiance_of_pixels(world, rows[i : i + _AT_A_TIME], columns[i : i + _AT_A_TIME])
            for i in progress(range(0, len(rows), _AT_A_TIME))
        ]
        return {"xyz": np.concatenate(groups_xyz)}

    return floats(cached_arrays("bench-reference", _key(part, rows, columns), build)["xyz"])


def _key(part: Scene, rows: Indices, columns: Indices) -> str:
    """Name all that the reference at some pixels depends on."""
    files = [Path(name) for name in scene_files(part)]
    if part.scattering.theory == "mie":
        from rtbow.tables.mie.axes import COMPACT_FILE

        files.append(COMPACT_FILE)
    return " ".join(
        [
            source_digest(*REFERENCE_CODE),
            f"{REFERENCE_STEP_NM:g} nm",
            part.model_dump_json(exclude={"compare", "render"}),
            # A file that cannot be read fails with its own message when it is used.
            *(file_digest(file) for file in files if file.is_file()),
            hashlib.sha256(np.stack([rows, columns]).astype("<i8").tobytes()).hexdigest(),
        ]
    )


def colour_error(rgb: Array, truth_xyz: Array) -> FrameDifference | None:
    """Measure how far pixels are from the reference.

    Args:
        rgb: linear Rec. 709 in cd/m² (n, 3).
        truth_xyz: the reference (n, 3).

    Returns:
        The difference over the pixels with light, against the reference's white; against the
        frame's own where it alone has light that anybody could see; None where neither has.
    """
    shown_xyz = rgb_to_xyz(rgb)
    if truth_xyz[:, 1].max(initial=0.0) > DARK_CD_M2:
        return frame_difference(shown_xyz, truth_xyz)
    if shown_xyz[:, 1].max(initial=0.0) > DARK_CD_M2:
        return frame_difference(truth_xyz, shown_xyz)
    return None


def sample_difference(rgb: Array, truth_xyz: Array, sample: PixelSample) -> SampleDifference:
    """Measure how far the sampled pixels of a frame are from the reference.

    Args:
        rgb: linear Rec. 709 in cd/m² (n, 3).
        truth_xyz: the reference (n, 3).
        sample: where the pixels are.
    """
    return SampleDifference(
        colour_error(rgb, truth_xyz),
        pixels=len(sample),
        pixels_lit=int(np.count_nonzero(np.any(truth_xyz != 0.0, axis=-1))),
        sample=sample.describe(),
        reference_step_nm=REFERENCE_STEP_NM,
    )
