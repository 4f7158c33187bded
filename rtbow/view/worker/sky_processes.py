"""The processes in which a window's skies are made: one sums them, one solves for an air."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any

from rtbow.render.sky.wanted import Wanted
from rtbow.tables.sky.light import Scattered
from rtbow.tables.sky.seen import SkyTable
from rtbow.world.sky import Surroundings

_MOST_FIELDS = 4
"""Airs whose scattered light is kept in memory: up to 6 MB each."""
_NICE = 5
"""Of the process that solves, beside that which draws and is nice itself."""


class _Process:
    """A process and the pipe to it, whose end ends it."""

    def __init__(self, work: Callable[..., None], *args: object) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(theirs, *args), daemon=True)
        self._process.start()
        theirs.close()

    @property
    def alive(self) -> bool:
        """Whether it is still at work."""
        return self._process.is_alive()

    def close(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join(1.0)
        self._pipe.close()


class Maker(_Process):
    """Sums skies, one after the other."""

    def __init__(self) -> None:
        super().__init__(_make)

    def know(self, around: Surroundings, field: Scattered) -> None:
        """Tell it what an air has scattered, which the cache may not keep."""
        self._pipe.send((around, tuple(field)))

    def begin(self, wanted: Wanted) -> None:
        """Have a sky made."""
        self._pipe.send(wanted)

    def wait(self, seconds: float) -> bool:
        """Wait for the sky; give whether it is there."""
        return self._pipe.poll(seconds)

    def take(self) -> SkyTable | None:
        """Give the sky; None where its air would have to be solved for.

        Raises:
            EOFError, OSError: the process has ended.
        """
        reply = self._pipe.recv()
        return None if reply is None else SkyTable(*reply)


class Solver(_Process):
    """Solves for what an air scatters.

    Args:
        around: the air and the ground.

    Attributes:
        share: how far it is.
    """

    def __init__(self, around: Surroundings) -> None:
        super().__init__(_solve, around)
        self.share = 0.0

    def take(self) -> Scattered | None:
        """Hear how far it is; give the field once it is there."""
        with suppress(EOFError, OSError):
            while self._pipe.poll():
                message = self._pipe.recv()
                if not isinstance(message, float):
                    return Scattered(*message)
                self.share = message
        return None


class _UnknownError(Exception):
    """An air would have to be solved for."""


def _refuse(_: Any) -> Iterator[Any]:
    raise _UnknownError
    yield


def _make(pipe: Connection) -> None:
    """Sum skies until the pipe's other end goes."""
    fields: list[tuple[Surroundings, Scattered]] = []
    with suppress(EOFError, OSError):
        while True:
            asked = pipe.recv()
            if not isinstance(asked, Wanted):
                around, field = asked
                fields = [*fields[1 - _MOST_FIELDS :], (around, Scattered(*field))]
                continue
            try:
                known = next((field for air, field in fields if air == asked.around), None)
                if known is None:
                    known = asked.around.field(_refuse)
                    fields = [*fields[1 - _MOST_FIELDS :], (asked.around, known)]
                pipe.send(tuple(asked.made(known)))
            except _UnknownError:
                pipe.send(None)


def _solve(pipe: Connection, around: Surroundings) -> None:
    """Solve for an air, and send shares of the work and then the field."""
    if hasattr(os, "nice"):
        os.nice(_NICE)
    threading.Thread(target=_end_with, args=(pipe,), daemon=True).start()

    def progress(items: Any) -> Iterator[Any]:
        listed = list(items)
        for number, item in enumerate(listed):
            pipe.send(number / len(listed))
            yield item

    pipe.send(tuple(around.field(progress)))
    pipe.close()


def _end_with(pipe: Connection) -> None:
    """End this process once the other end of its pipe has gone."""
    with suppress(EOFError, OSError):
        pipe.recv()
    os._exit(0)
