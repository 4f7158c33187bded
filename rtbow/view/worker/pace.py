"""The scale of the next frame: quick while the scene changes, sharp once it rests.

Times are arguments, all in seconds of one clock: nothing here reads a clock.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

STEPS = (0.25, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0)
"""Shares of the full width; from one to the next, pixels grow by about a half."""

_FIRST_SCALE = 0.5
_WINDOW = 5
"""Frames of one scale whose median time counts, so that a single slow one does not."""
_SLOW = 1.1
"""Times above this share of the target make pictures smaller ..."""
_STALLED = 1.5
"""... above this one after two frames already ..."""
_QUICK = 0.85
"""... and larger ones are drawn if they are expected to take less than this share. Between both
nothing changes."""
_REMEMBERED_FRAMES = 600
"""Frames after which a measured ratio between two scales is forgotten."""
_GIVES_WAY_S = (0.5, 4.0)
"""Time after which a quick frame gives way to a change, at first and at most."""
_TRIED_AFTER_FRAMES = 60
"""Frames after which an unmeasured larger scale is tried: not all time may go into pixels."""


@dataclass(frozen=True)
class Order:
    """A frame to draw.

    Attributes:
        state: which state of the scene it shows; every change makes another.
        scale: share of the full width and height.
        sharp: whether it is the full picture of a scene that has come to rest.
    """

    state: int
    scale: float
    sharp: bool


class Pace:
    """Keeps a frame time while the scene changes, and asks for the full picture afterwards.

    Args:
        target_s: time that a frame is to take while the scene changes.
        steps: scales to choose from, ascending, 1 the last.
        settle_s: how long nothing must have changed before the full picture is asked for.
    """

    def __init__(
        self, target_s: float, steps: Sequence[float] = STEPS, settle_s: float = 0.25
    ) -> None:
        self.target_s = target_s
        self._steps = tuple(steps)
        self._settle_s = settle_s
        self._step = max(k for k, s in enumerate(self._steps) if s <= _FIRST_SCALE or k == 0)
        self._times: deque[float] = deque(maxlen=_WINDOW)
        self._before: tuple[int, float] | None = None
        # By step: how much longer the next scale takes, and the frame that showed it.
        self._growth: dict[int, tuple[float, int]] = {}
        self._frames = self._since = 0
        self._state = 0
        self._changed_s: float | None = None
        self._under_way: Order | None = None
        self._asked_s = 0.0
        self._gives_way_s = _GIVES_WAY_S[0]
        self._shown: Order | None = None

    @property
    def scale(self) -> float:
        """The scale of frames while the scene changes."""
        return self._steps[self._step]

    @property
    def sharpening(self) -> bool:
        """Whether the full picture of a scene at rest is being drawn."""
        return self._under_way is not None and self._under_way.sharp

    def change(self, now_s: float) -> None:
        """Note that the scene, the camera or the view's size has changed."""
        self._state += 1
        self._changed_s = now_s

    def next_order(self, now_s: float) -> Order | None:
        """Give the frame to draw now; None if there is none, or one is under way.

        The full picture gives way to the next change: its order is then no longer under way. A
        quick frame is waited for, so that continual changes show, but not one that takes far longer
        than those before, as when tables are built for minutes. Each that gave way leaves the next
        one twice the time, so that one is drawn at last.
        """
        if self._changed_s is None:
            self._changed_s = now_s
        waiting = self._under_way
        late = now_s - self._asked_s >= self._gives_way_s
        if waiting is not None and (waiting.state == self._state or not (waiting.sharp or late)):
            return None
        order = Order(self._state, self.scale, False)
        if self._settled(now_s):
            order = Order(self._state, self._steps[-1], self.scale < self._steps[-1])
        shown = self._shown
        if shown is not None and shown.state == order.state and shown.scale >= order.scale:
            return None
        if waiting is not None and not waiting.sharp:
            self._gives_way_s = min(2.0 * self._gives_way_s, _GIVES_WAY_S[1])
        self._under_way, self._asked_s = order, now_s
        return order

    def due_in_s(self, now_s: float) -> float | None:
        """Give the time until another picture is to be asked for; None if none is before a frame
        has come or the scene has changed."""
        shown, waiting = self._shown, self._under_way
        done = shown is not None and shown.state == self._state and shown.scale >= self._steps[-1]
        if done or self.sharpening or self._changed_s is None:
            return None
        due_s = self._changed_s + self._settle_s
        if waiting is not None:
            if waiting.state == self._state:
                return None
            due_s = self._asked_s + self._gives_way_s
        return max(due_s - now_s, 0.0)

    def drawn(self, order: Order, seconds: float) -> None:
        """Note that a frame is shown, and how long it took."""
        self._end(order)
        self._shown = order
        if not order.sharp:
            self._gives_way_s = min(max(2.0 * seconds, _GIVES_WAY_S[0]), _GIVES_WAY_S[1])
        if order.sharp or order.scale != self.scale:
            return
        self._frames += 1
        self._times.append(seconds)
        self._learn()
        self._choose()

    def dropped(self, order: Order) -> None:
        """Note that a frame will not come: it was superseded, or could not be drawn.

        Its state of the scene is not asked for again until the next change, except for the full
        picture if this was a quick one.
        """
        self._end(order)
        self._shown = order

    def _end(self, order: Order) -> None:
        if order == self._under_way:
            self._under_way = None

    def _settled(self, now_s: float) -> bool:
        return self._changed_s is not None and now_s - self._changed_s >= self._settle_s

    def _learn(self) -> None:
        """Learn how much longer a step takes than the one below, once both were measured."""
        if self._before is None or len(self._times) < 3:
            return
        other, seconds = self._before
        own = median(self._times)
        if other == self._step - 1:
            self._grows(other, own / seconds)
        elif other == self._step + 1:
            self._grows(self._step, seconds / own)

    def _grows(self, step: int, ratio: float) -> None:
        # A scene that changed in between may give any ratio.
        self._growth[step] = min(max(ratio, 1.0), self._worst(step)), self._frames

    def _worst(self, step: int) -> float:
        """How much longer the next step takes if all of the time goes into pixels."""
        return (self._steps[step + 1] / self._steps[step]) ** 2

    def _choose(self) -> None:
        """Go to another scale if this one is too slow, or the next is quick enough."""
        usual = median(self._times)
        stalled = min(list(self._times)[-2:]) if len(self._times) >= 2 else 0.0
        if stalled > _STALLED * self.target_s:
            self._go_down(stalled)
        elif len(self._times) >= 3 and usual > _SLOW * self.target_s:
            self._go_down(usual)
        elif len(self._times) == _WINDOW and self._step + 1 < len(self._steps):
            known = self._growth.get(self._step)
            if known is not None and self._frames - known[1] > _REMEMBERED_FRAMES:
                known = None
            # Where nothing is known, half of the time is put down to pixels; later it is measured.
            growth = known[0] if known else self._worst(self._step) ** 0.5
            patient = known is None and self._frames - self._since >= _TRIED_AFTER_FRAMES
            if usual * growth <= _QUICK * self.target_s or (patient and usual <= self.target_s):
                self._go(self._step + 1, usual)

    def _go_down(self, seconds: float) -> None:
        step = self._step - 1
        while step > 0 and self._expected(step, seconds) > self.target_s:
            step -= 1
        if step >= 0:
            self._go(step, seconds)

    def _expected(self, step: int, seconds: float) -> float:
        """Time at another step if all of it goes into pixels."""
        return seconds * (self._steps[step] / self.scale) ** 2

    def _go(self, step: int, seconds: float) -> None:
        self._before = self._step, seconds
        self._step, self._since = step, self._frames
        self._times.clear()
