"""Memory of this process and of the machine, as far as the system tells."""

from __future__ import annotations

import os
import platform
import re
import sys
from pathlib import Path

_MIB = 2.0**20
_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")


class PeakMemory:
    """The most memory that this process holds, from when this is made.

    Linux can start its record of the peak anew. Elsewhere the peak is that since the process
    began, and ``since`` says so.

    Attributes:
        since: ``"row"`` or ``"process"``.
        start_mib: what the process holds when this is made; None where the system does not tell.
    """

    def __init__(self) -> None:
        try:
            _RESET.write_text("5")
            self.since = "row"
        except OSError:
            self.since = "process"
        self.start_mib = _status_mib("VmRSS")

    def mib(self) -> float | None:
        """Give the peak so far; None where the system does not tell."""
        peak = _status_mib("VmHWM")
        return _usage_mib() if peak is None else peak


def _status_mib(name: str) -> float | None:
    try:
        found = re.search(rf"^{name}:\s+(\d+) kB", _STATUS.read_text(), re.MULTILINE)
    except OSError:
        return None
    return int(found[1]) / 1024.0 if found else None


def _usage_mib() -> float | None:
    try:
        import resource
    except ImportError:  # Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / _MIB if sys.platform == "darwin" else peak / 1024.0  # bytes there, KiB else


def free_mib() -> float | None:
    """Give the memory that programs can still take; None where the system does not tell."""
    try:
        found = re.search(r"^MemAvailable:\s+(\d+) kB", Path("/proc/meminfo").read_text(), re.M)
    except OSError:
        return None
    return int(found[1]) / 1024.0 if found else None


def cpu_name() -> str:
    """Name the CPU as the system does."""
    try:
        found = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.M)
    except OSError:
        found = None
    return found[1].strip() if found else platform.processor() or platform.machine()


def cpu_count() -> int:
    """Count the CPUs that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def load_average() -> float | None:
    """Give the processes that wanted a CPU over the last minute, on average, ours included."""
    try:
        return os.getloadavg()[0]
    except (OSError, AttributeError):  # AttributeError: Windows
        return None
