"""The skies of a window's pictures, made beside them.

Summing the sky of a moved sun takes some tenths of a second, and solving for another air up to
minutes. Neither is waited for: two processes do it (:mod:`rtbow.view.worker.sky_processes`), for
drawing holds Python's lock, and a thread would not get on meanwhile. Until a sky is there, those
of the nearest suns stand in for it, or those of the former air.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rtbow.base.arrays import Progress, no_progress
from rtbow.render.sky.wanted import Seen, SkiesAtOnce, Wanted
from rtbow.tables.sky.light import Scattered
from rtbow.view.worker.sky_processes import Maker, Solver
from rtbow.view.worker.stand_ins import (
    Parts,
    alike,
    between,
    distance,
    same_place,
    turned,
    with_parts,
    words_for,
)
from rtbow.world.sky import Surroundings

_MOST_SKIES = 24
"""Skies that are kept: each takes 2 MB in haze with rain that dims, a tenth of that without."""
_REST_S = 0.3
"""How long an air must be wanted before it is solved for: a slider passes through many."""
_AHEAD_DEG = (2.0, -2.0, 4.0, -4.0, 8.0, -8.0)
"""Suns beside that of a picture at rest whose skies are made before they are asked for."""
_FARTHEST_DEG = 6.0
"""How far ahead of a moving sun its sky is made."""
_STILL_DEG = 0.02
_WAY = 4
"""Pictures after which a sun that differs from one to the next is taken to be dragged."""
_MEMORY_S = 1.0
"""How long a sun's way counts for where it is expected next."""
_LOOK_S = 0.1
_MOST_CONVERTED = 8
"""Skies of another air that are kept as they are drawn in the place of others."""


@dataclass(frozen=True)
class Waiting:
    """What a picture waits for.

    Attributes:
        share: how far it is, 0 to 1; None where that is not known.
        what: what is being made, and what the picture shows until then.
    """

    share: float | None
    what: str


class BesideSkies:
    """Makes skies beside the pictures (:class:`rtbow.render.sky.wanted.Skies`).

    Args:
        news: is told, from another thread, what the last picture waits for, and None as soon as
            another picture would show more of it.

    Attributes:
        behind: what stands in for a sky of the picture that was begun last; empty if nothing does.
    """

    def __init__(self, news: Callable[[Waiting | None], object]) -> None:
        self._news = news
        self._change = threading.Condition()
        self._made: list[tuple[Wanted, Seen]] = []
        self._converted: list[tuple[Seen, Parts, Seen]] = []
        self._solved: list[tuple[Surroundings, Scattered]] = []
        self._wanted: list[Wanted] = []
        self._missing: list[Wanted] = []
        self._ahead: list[Wanted] = []
        self._unknown: list[Surroundings] = []
        self._failed: list[Surroundings] = []
        self._suns: list[tuple[float, float]] = []
        self._took_s = 0.3
        self._maker: Maker | None = None
        self._solver: Solver | None = None
        self._asked: tuple[Surroundings, float] | None = None
        self._thread: threading.Thread | None = None
        self._closed = False
        self.behind = ""

    # --- what the methods ask for -------------------------------------------------------------

    def begin(self) -> None:
        """Begin a picture: what the one before wants is made until this one wants something."""
        with self._change:
            self._missing, self._ahead, self.behind = [], [], ""

    def end(self) -> None:
        """End a picture: what it did not want is given up."""
        with self._change:
            self._wanted = self._missing
            self._change.notify_all()

    def solve(self, around: Surroundings, building: Progress) -> None:
        """Leave it to the processes."""

    def seen(self, wanted: Sequence[Wanted]) -> list[Seen | None]:
        """Give skies or what stands in for them, and have those made that are missing."""
        for one in wanted:
            if one.around in self._failed:  # here it says what is wrong
                at_once = SkiesAtOnce()
                at_once.solve(one.around, no_progress)
                return at_once.seen(wanted)
        with self._change:
            self._note_way(wanted)
            seen = [self._exact(one) for one in wanted]
            missing = [one for one, found in zip(wanted, seen, strict=True) if found is None]
            if missing:
                self._missing = self._wanted = [*self._missing, *missing]
                self._start()
                self._change.notify_all()
            return [found or self._stand_in(one) for one, found in zip(wanted, seen, strict=True)]

    def ahead(self) -> None:
        """Have the skies of suns beside those of the last picture made, until another begins."""
        with self._change:
            if self._wanted or not self._made:
                return
            last = self._made[-1][0]
            self._ahead = [turned(last, np.radians(step)) for step in _AHEAD_DEG]
            self._start()
            self._change.notify_all()

    def close(self) -> None:
        """End the thread and both processes; what is being made is given up."""
        with self._change:
            self._closed = True
            self._wanted, self._ahead = [], []
            self._change.notify_all()
            for process in (self._solver, self._maker):
                if process is not None:
                    process.close()

    # --- what stands in -----------------------------------------------------------------------

    def _exact(self, wanted: Wanted) -> Seen | None:
        """Give the sky that is wanted, and make it the last one used."""
        for number, (one, seen) in enumerate(self._made):
            if one.same_as(wanted):
                self._made.append(self._made.pop(number))
                return seen
        return None

    def _stand_in(self, wanted: Wanted) -> Seen | None:
        """Give the sky between those of the nearest suns on both sides, or of the nearest one.

        Those of the same air come first, then those of the air that was seen last.
        """
        usable = [pair for pair in self._made if alike(pair[0], wanted)]
        if not usable:
            self.behind = "no sky so far: it is being made"
            return None
        same = [pair for pair in usable if pair[0].around == wanted.around]
        latest = usable[-1][0].around
        choice = same or [pair for pair in usable if pair[0].around == latest]
        choice.sort(key=lambda pair: distance(pair[0].eye, wanted.eye))
        altitude = wanted.eye.sun_altitude_rad
        first = choice[0]
        above = first[0].eye.sun_altitude_rad > altitude
        second = next(
            (
                pair
                for pair in choice[1:]
                if (pair[0].eye.sun_altitude_rad > altitude) != above
                and same_place(pair[0].eye, first[0].eye)
            ),
            None,
        )
        self.behind = words_for(first[0], second and second[0], of_another_air=not same)
        parts = Parts.of(wanted.around)
        if second is None or first[0].eye.sun_altitude_rad == altitude:
            return self._same(first[1], parts)
        low, high = first[0].eye.sun_altitude_rad, second[0].eye.sun_altitude_rad
        share = (altitude - low) / (high - low)
        blended = between(first[1], second[1], float(share), altitude)
        return with_parts(blended, parts)

    def _same(self, seen: Seen, parts: Parts) -> Seen:
        """Give a sky with some parts, or without: the same object as last time."""
        for before, had, converted in self._converted:
            if before is seen and had == parts:
                return converted
        made = with_parts(seen, parts)
        self._converted = [*self._converted[1 - _MOST_CONVERTED :], (seen, parts, made)]
        return made

    def _note_way(self, wanted: Sequence[Wanted]) -> None:
        """Remember where the first sun stood, and when."""
        now = time.monotonic()
        self._suns = [(at, sun) for at, sun in self._suns if now - at < _MEMORY_S]
        self._suns += [(now, one.eye.sun_altitude_rad) for one in wanted[:1]]

    def _expected(self) -> float:
        """By how much the sun will have moved when a sky that is begun now is there, rad."""
        if not self._suns:
            return 0.0
        last_s, last = self._suns[-1]
        way = 1
        while way < len(self._suns):
            (_, before), (_, after) = self._suns[-way - 1], self._suns[-way]
            if abs(after - before) < np.radians(_STILL_DEG):
                break
            way += 1
        first_s, first = self._suns[-way]
        if way < _WAY or last_s <= first_s:  # a jump is no way
            return 0.0
        if time.monotonic() - last_s > self._took_s:
            return 0.0
        step = 1.5 * self._took_s * (last - first) / (last_s - first_s)
        return float(np.clip(step, -np.radians(_FARTHEST_DEG), np.radians(_FARTHEST_DEG)))

    # --- the thread ---------------------------------------------------------------------------

    def _start(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._work, daemon=True, name="skies")
            self._thread.start()

    def _work(self) -> None:
        while True:
            with self._change:
                if not (self._closed or self._wanted or self._ahead):
                    self._give_up()
                    self._change.wait()
                elif not self._closed and self._todo is None:
                    self._change.wait(_LOOK_S)  # the solver works
                if self._closed:
                    return
                todo = self._todo
            self._look_at_solver()
            if todo is not None:
                self._make(todo)

    @property
    def _todo(self) -> Wanted | None:
        """The sky to make next: one that is wanted, of the former air where its own is unknown, or
        one ahead of need."""
        for one in reversed(self._wanted):
            if one.around in self._unknown:
                former = self._former(one)
                if former is not None and not self._has(former):
                    return former
            elif not self._has(one):
                step = self._expected() if len(self._wanted) == 1 else 0.0
                return turned(one, step) if step else one
        return next((one for one in self._ahead if not self._has(one)), None)

    def _has(self, wanted: Wanted) -> bool:
        return any(one.same_as(wanted) for one, _ in self._made)

    def _former(self, wanted: Wanted) -> Wanted | None:
        """Give the sky of the air that was seen last, for the same eye and sun."""
        airs = [one.around for one, _ in self._made if one.around not in self._unknown]
        return replace(wanted, around=airs[-1]) if airs else None

    def _make(self, todo: Wanted) -> None:
        """Make a sky, and say so if a picture waits for it."""
        begun = time.monotonic()
        with self._change:
            if self._closed:
                return
            maker = self._maker = self._maker or Maker()
            solved, self._solved = self._solved, []
        try:
            # While it sums a sky it would not listen, nor would this thread to its reply.
            for around, field in solved:
                maker.know(around, field)
            maker.begin(todo)
            while not maker.wait(_LOOK_S):
                self._look_at_solver()
            made = maker.take()
        except (EOFError, OSError):
            self._maker = None
            self._fail(todo.around)
            return
        with self._change:
            if made is None:
                self._unknown.append(todo.around)
                self._ahead = []
                return
            self._took_s = time.monotonic() - begun
            self._made.append((todo, (todo.eye, made)))
            del self._made[:-_MOST_SKIES]
            waited_for = bool(self._wanted)
            self._wanted = [one for one in self._wanted if not self._has(one)]
        if waited_for:
            self._news(None)

    def _fail(self, around: Surroundings) -> None:
        with self._change:
            if self._closed:
                return
            self._failed.append(around)
            self._wanted = [one for one in self._wanted if one.around != around]
        self._news(None)

    # --- the solver ---------------------------------------------------------------------------

    def _look_at_solver(self) -> None:
        """Have the air solved for that is wanted, and no other."""
        with self._change:
            wanted = [one.around for one in self._wanted if one.around in self._unknown]
        if not wanted:
            self._give_up()
            return
        around, now = wanted[0], time.monotonic()
        if self._asked is None or self._asked[0] != around:
            self._give_up()
            self._asked = around, now
        if self._solver is None:
            with self._change:
                begin = now - self._asked[1] >= _REST_S and not self._closed
                if begin:
                    self._solver = Solver(around)
            if begin:
                self._say(0.0)
            return
        before, alive = self._solver.share, self._solver.alive
        solved = self._solver.take()
        if solved is not None:
            self._end_solver()
            with self._change:
                self._solved.append((around, solved))
                self._unknown.remove(around)
        elif not alive:
            self._end_solver()
            self._fail(around)
        elif self._solver.share != before:
            self._say(self._solver.share)

    def _say(self, share: float) -> None:
        shown = "the former air is shown" if self._made else "shown without its sky"
        self._news(Waiting(share, f"new air, {shown}:"))

    def _give_up(self) -> None:
        self._asked = None
        if self._solver is not None:
            self._end_solver()

    def _end_solver(self) -> None:
        if self._solver is not None:
            self._solver.close()
        self._solver = None
        self._news(Waiting(None, ""))
