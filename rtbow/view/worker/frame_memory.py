"""Frames in memory that two processes share: one writes them in turn, the other copies them out."""

from __future__ import annotations

from dataclasses import dataclass, field
from multiprocessing.shared_memory import SharedMemory

import numpy as np

from rtbow.base.arrays import Float32

_BUFFERS = 3
"""Slots of shared memory: one frame shown, one on its way, one being written."""
_LEAST_BYTES = 1 << 16
"""Least size of a frame's memory."""


@dataclass
class FrameRing:
    """Frames in shared memory, written in turn; a slot's memory grows by powers of two."""

    memories: list[SharedMemory | None] = field(default_factory=lambda: [None] * _BUFFERS)
    turn: int = 0

    def put(self, rgb: Float32) -> tuple[int, str]:
        """Copy a frame; give its slot and the name of its memory."""
        self.turn = (self.turn + 1) % _BUFFERS
        memory = self.memories[self.turn]
        if memory is None or memory.size < rgb.nbytes:
            self._free(self.turn)
            size = 1 << max(rgb.nbytes - 1, _LEAST_BYTES - 1).bit_length()
            memory = self.memories[self.turn] = SharedMemory(create=True, size=size)
        np.ndarray(rgb.shape, np.float32, memory.buf)[:] = rgb
        return self.turn, memory.name

    def free(self) -> None:
        """Release all memory."""
        for slot in range(_BUFFERS):
            self._free(slot)

    def _free(self, slot: int) -> None:
        memory, self.memories[slot] = self.memories[slot], None
        if memory is not None:
            memory.close()
            memory.unlink()


class FrameReader:
    """The other side of a :class:`FrameRing`."""

    def __init__(self) -> None:
        self._memories: dict[int, SharedMemory] = {}

    def take(self, slot: int, name: str, size_px: tuple[int, int]) -> Float32:
        """Copy a frame out: float32 (h, w, 3).

        Args:
            slot: of the ring.
            name: of the slot's memory.
            size_px: width and height.

        Raises:
            FileNotFoundError: a later frame needed a larger memory there.
        """
        memory = self._memories.get(slot)
        if memory is None or memory.name != name:
            if memory is not None:
                self._memories.pop(slot).close()
            memory = self._memories[slot] = SharedMemory(name)
        width, height = size_px
        # A copy: later frames are written there, and NumPy does not keep the memory mapped.
        return np.ndarray((height, width, 3), np.float32, memory.buf).copy()

    def close(self) -> None:
        """Let go of all memory."""
        for memory in self._memories.values():
            memory.close()
        self._memories.clear()
