"""What is known of the process's memory and of the machine."""

from __future__ import annotations

import numpy as np

from rtbow.base.jobs import cores
from rtbow.bench.memory import PeakMemory, cpu_name


def test_peak_memory_grows_with_what_is_held():
    memory = PeakMemory()
    held = np.ones(80_000_000, dtype=np.uint8)  # too large to take the place of what was freed
    assert memory.mib() is None or memory.mib() > held.nbytes / 2**20
    if memory.since == "row":
        assert memory.mib() >= memory.start_mib + 60.0
        del held
        assert PeakMemory().mib() < memory.mib() + 20.0
    assert cores() >= 1
    assert cpu_name()
