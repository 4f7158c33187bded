"""Tries seed after seed in a process of its own, which may hang, crash or take all memory."""

from __future__ import annotations

import importlib
import json
import logging
import math
import multiprocessing
import resource
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Protocol, cast

from rtbow.base.errors import RtbowError
from rtbow.base.files import write_atomic

SUBJECTS = ("scenes", "texts", "volumes")

_SLOWEST = 5
_SAVED_EVERY = 50
_SHOWN_FAILURES = 20
_WAITING = 10.0
"""Times as long as an input may take of the CPU, this is waited for it."""
_STARTING_S = 120.0
"""For imports and a GL context, on a machine that is busy."""


class Subject(Protocol):
    """What is fuzzed: a module of this package with these names.

    Attributes:
        suffix: of an input's file.
        seconds: that an input may take, of the CPU.
        mebibytes: that an input may take beyond what the process had before.
    """

    suffix: str
    seconds: float
    mebibytes: int

    def make(self, seed: int) -> bytes:
        """Make an input; the same seed makes the same one."""
        ...

    def attempt(self, path: Path) -> str:
        """Try an input; return how it ended, in a word. What it raises is a defect."""
        ...


def subject_of(name: str) -> Subject:
    """Return the module of a subject, by its name here or its full one."""
    return cast(Subject, importlib.import_module(f"fuzz.{name}" if name in SUBJECTS else name))


@dataclass
class Report:
    """What came of the seeds up to ``next_seed``.

    Attributes:
        next_seed: where another run goes on.
        seconds: that they took together, of the CPU.
        counts: of seeds by how they ended.
        slowest: seconds and seed, slowest first.
        failures: seed and what happened.
    """

    next_seed: int = 0
    seconds: float = 0.0
    counts: dict[str, int] = field(default_factory=dict)
    slowest: list[tuple[float, int]] = field(default_factory=list)
    failures: list[tuple[int, str]] = field(default_factory=list)

    def add(self, seed: int, outcome: str, seconds: float) -> None:
        """Count a seed."""
        self.next_seed = seed + 1
        self.seconds += seconds
        self.counts[outcome] = self.counts.get(outcome, 0) + 1
        times = [(t, s) for t, s in (*self.slowest, (round(seconds, 3), seed))]
        self.slowest = sorted(times, reverse=True)[:_SLOWEST]

    def text(self) -> str:
        """Write the counts, the slowest seeds, and the failures."""
        counts = ", ".join(f"{count} {what}" for what, count in sorted(self.counts.items()))
        lines = [f"{sum(self.counts.values())} inputs in {self.seconds:.0f} s of the CPU: {counts}"]
        slowest = ", ".join(f"{seed} ({seconds:.2f} s)" for seconds, seed in self.slowest)
        lines.append(f"slowest seeds: {slowest}")
        kinds = Counter(what.splitlines()[-1][:120] for _, what in self.failures)
        lines += [f"{count} times: {what}" for what, count in kinds.most_common(_SHOWN_FAILURES)]
        if self.failures:
            seeds = [str(seed) for seed, _ in self.failures[:_SHOWN_FAILURES]]
            lines.append(f"failing seeds: {', '.join(seeds)}")
        return "\n".join(lines)


class Fuzzer:
    """Tries seeds of a subject, keeping inputs that fail and a record in a folder.

    Args:
        subject: one of :data:`SUBJECTS`, or the full name of a module.
        folder: there already; its record says where to go on.
        make: as the subject's, of a part of its inputs.
    """

    def __init__(
        self,
        subject: str,
        folder: Path,
        make: Callable[[int], bytes] | None = None,
    ) -> None:
        self._name = subject
        self._subject = subject_of(subject)
        self._folder = folder
        self._record = folder / f"{subject}.json"
        self._make = make or self._subject.make
        self._child: _Child | None = None

    def run(
        self, seconds: float, seed: int | None = None, say: Callable[[str], object] = str
    ) -> Report:
        """Try seeds for a while; the last one is tried to its end, and at least one is.

        Args:
            seconds: how long, from when the process that tries them is ready.
            seed: the first one, without regard to the record; None goes on with the next one.
            say: is given a line about each failure.
        """
        report = self._recorded() if seed is None else Report(next_seed=seed)
        self._child = _Child(self._name)
        end = time.monotonic() + seconds
        try:
            self._try(report, say)
            while time.monotonic() < end:
                self._try(report, say)
                if report.next_seed % _SAVED_EVERY == 0:
                    self._save(report)
        finally:
            self._stop()
            self._save(report)
        return report

    def _try(self, report: Report, say: Callable[[str], object]) -> None:
        seed = report.next_seed
        content = self._make(seed)
        path = self._folder / f"current{self._subject.suffix}"
        path.write_bytes(content)
        if self._child is None:
            self._child = _Child(self._name)
        outcome, what, seconds = self._child.ask(path, self._subject.seconds)
        report.add(seed, outcome, seconds)
        if what:
            kept = self._folder / f"{seed}{self._subject.suffix}"
            kept.write_bytes(content)
            report.failures.append((seed, what))
            say(f"{kept}: {outcome}: {what.splitlines()[-1][:300]}")
            if outcome not in ("defect", "memory"):
                self._stop()  # dead, or not to be waited for

    def _stop(self) -> None:
        if self._child is not None:
            self._child.stop()
            self._child = None

    def _recorded(self) -> Report:
        if not self._record.exists():
            return Report()
        known = json.loads(self._record.read_text("utf-8"))
        known["slowest"] = [(seconds, seed) for seconds, seed in known["slowest"]]
        known["failures"] = [(seed, what) for seed, what in known["failures"]]
        return Report(**known)

    def _save(self, report: Report) -> None:
        write_atomic(self._record, json.dumps(asdict(report), indent=1).encode())


class _Child:
    """A process that tries inputs one after the other."""

    def __init__(self, subject: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(subject, theirs), daemon=True)
        self._process.start()
        theirs.close()
        if not self._pipe.poll(_STARTING_S) or self._pipe.recv() != "ready":
            raise RuntimeError(f"{subject} did not start")

    def ask(self, path: Path, seconds: float) -> tuple[str, str, float]:
        """Try an input.

        Returns:
            How it ended; what is wrong with that, empty if nothing is; and the time it took, in
            seconds of the CPU.
        """
        self._pipe.send(str(path))
        try:
            if not self._pipe.poll(_WAITING * seconds):
                return "hung", f"did nothing for {_WAITING * seconds:g} s", _WAITING * seconds
            outcome, what, taken = self._pipe.recv()
        except (EOFError, ConnectionError):
            self._process.join()
            if self._process.exitcode == -signal.SIGXCPU:
                return "too slow", f"took more than {seconds:g} s", seconds
            return "crashed", f"ended with exit code {self._process.exitcode}", 0.0
        return outcome, what, taken

    def stop(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(name: str, pipe: Connection) -> None:
    """Try the inputs that come through a pipe."""
    logging.getLogger("rtbow").addHandler(logging.NullHandler())  # notices are no outcome
    subject = subject_of(name)
    pipe.send("ready")
    while True:
        path = Path(pipe.recv())
        _limit(subject)
        start = time.process_time()
        try:
            outcome, what = subject.attempt(path), ""
        except MemoryError:
            outcome, what = "memory", f"took more than {subject.mebibytes} MiB"
        except Exception:
            outcome, what = "defect", traceback.format_exc(limit=-12).strip()
        pipe.send((outcome, what, time.process_time() - start))


def _limit(subject: Subject) -> None:
    """Bound the time and the memory that this process takes beyond what it has, for one input."""
    _, hard = resource.getrlimit(resource.RLIMIT_CPU)
    seconds = math.ceil(time.process_time() + subject.seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, hard))
    pages = int(Path("/proc/self/statm").read_text().split()[0])  # reserved
    most = pages * resource.getpagesize() + (subject.mebibytes << 20)
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (most, hard))


def refusal(error: RtbowError, lines: int, characters: int) -> str:
    """Return how an input ended that was refused: by the user's fault, in a short message.

    Args:
        error: what was raised.
        lines: that its message may have.
        characters: that each of them may have.

    Raises:
        RtbowError: the same, where it is a defect of rtbow or a lack of memory.
        AssertionError: the message is not fit to be shown.
    """
    if error.exit_code == 3 and "memory" in str(error):
        raise MemoryError from error
    if error.exit_code != 2:
        raise error
    message = str(error).splitlines()
    assert len(message) <= lines, f"a message of {len(message)} lines"
    for line in message:
        assert len(line) <= characters, f"a line of {len(line)} characters: {line[:200]}"
        assert line.isprintable(), f"characters that are not to be shown: {line[:200]!r}"
    return "refused"
