"""Memory of this process and of the machine, as far as the system says."""

from __future__ import annotations

import os
import platform
import re
import sys
from pathlib import Path

_MIB = 2.0**20
_STATUS = "/proc/self/status"
_RESET = Path("/proc/self/clear_refs")


class PeakMemory:
    """The most memory that this process holds, from when this is made.

    Linux can start its record of the peak anew. Elsewhere the peak is that since the process
    began, and ``since`` says so.

    Attributes:
        since: ``"row"`` or ``"process"``.
        start_mib: what the process holds when this is made; None where the system does not say.
    """

    def __init__(self) -> None:
        try:
            _RESET.write_text("5")
            self.since = "row"
        except OSError:
            self.since = "process"
        self.start_mib = _mib(_STATUS, "VmRSS")

    def mib(self) -> float | None:
        """Give the peak so far; None where the system does not say."""
        peak = _mib(_STATUS, "VmHWM")
        return _usage_mib() if peak is None else peak


def _searched(path: str, pattern: str) -> str | None:
    """Give what a pattern's group matches in a file; None without file or match."""
    try:
        match = re.search(pattern, Path(path).read_text(), re.MULTILINE)
    except OSError:
        return None
    return match[1] if match else None


def _mib(path: str, name: str) -> float | None:
    kib = _searched(path, rf"^{name}:\s+(\d+) kB")
    return None if kib is None else int(kib) / 1024.0


def _usage_mib() -> float | None:
    try:
        import resource
    except ImportError:  # Windows
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / _MIB if sys.platform == "darwin" else peak / 1024.0  # bytes there, KiB else


def free_mib() -> float | None:
    """Give the memory that programs can still take; None where the system does not say."""
    return _mib("/proc/meminfo", "MemAvailable")


def cpu_name() -> str:
    """Name the CPU as the system does."""
    name = _searched("/proc/cpuinfo", r"^model name\s*:\s*(.*\S)")
    return name or platform.processor() or platform.machine()


def load_average() -> float | None:
    """Give the processes that wanted a CPU over the last minute, on average, ours included."""
    try:
        return os.getloadavg()[0]
    except (OSError, AttributeError):  # AttributeError: Windows
        return None
