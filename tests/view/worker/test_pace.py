"""The render scale, with renderers whose times are made up."""

from itertools import pairwise

import numpy as np
import pytest

from rtbow.view.worker.pace import STEPS, Pace

TARGET = 1.0 / 30.0


class Device:
    """A renderer that takes a + b scale², with noise and now and then a spike."""

    def __init__(self, a_ms, b_ms, rng=None, noise=0.1, spikes=0.03):
        self.a_ms, self.b_ms, self.rng, self.noise, self.spikes = a_ms, b_ms, rng, noise, spikes

    def mean(self, scale):
        return 1e-3 * (self.a_ms + self.b_ms * scale**2)

    def draw(self, scale):
        seconds = self.mean(scale)
        if self.rng is not None:
            seconds *= np.exp(self.noise * self.rng.normal())
            if self.rng.random() < self.spikes:
                seconds *= self.rng.uniform(3.0, 10.0)
        return seconds

    def best(self, target=TARGET):
        """The largest scale within the target; the least one if none is."""
        within = [s for s in STEPS if self.mean(s) <= target]
        return max(within, default=STEPS[0])


def move(pace, device, frames, now=0.0):
    """Change the scene before each frame; give the scales of the frames, and the time."""
    scales = []
    for _ in range(frames):
        pace.change(now)
        order = pace.next_order(now)
        assert not order.sharp
        scales.append(order.scale)
        now += device.draw(order.scale)
        pace.drawn(order, device.draw(order.scale))
    return scales, now


def changes(scales):
    return sum(a != b for a, b in pairwise(scales))


COSTS = [(a, b) for a in (0.0, 3.0, 15.0, 28.0) for b in (2.0, 10.0, 30.0, 60.0, 200.0, 900.0)]


@pytest.mark.parametrize(("a_ms", "b_ms"), COSTS)
def test_it_holds_the_target_without_wavering(a_ms, b_ms):
    device = Device(a_ms, b_ms)
    pace = Pace(TARGET)
    scales, _ = move(pace, device, 600)
    late = scales[300:]
    assert changes(late) == 0
    assert set(scales) <= set(STEPS)
    assert device.mean(late[-1]) <= 1.1 * TARGET or late[-1] == STEPS[0]
    # Between the thresholds, a tenth either way, nothing changes.
    assert STEPS.index(device.best()) - STEPS.index(late[-1]) <= 1


@pytest.mark.parametrize(("a_ms", "b_ms"), COSTS)
def test_noise_and_spikes_seldom_move_it(a_ms, b_ms, rng):
    device = Device(a_ms, b_ms, rng)
    pace = Pace(TARGET)
    scales, _ = move(pace, device, 1500)
    late = scales[150:]
    # Worst of these: 7 in 1350 frames, where a scale's time lies on a threshold.
    assert changes(late) <= 10
    assert np.median([device.mean(s) for s in late]) <= 1.15 * TARGET or set(late) == {STEPS[0]}
    assert STEPS.index(device.best()) - np.median([STEPS.index(s) for s in late]) <= 1


def test_a_heavier_scene_is_met_at_once():
    pace, device = Pace(TARGET), Device(1.0, 20.0)
    scales, now = move(pace, device, 100)
    assert scales[-1] == 1.0
    device.b_ms = 300.0
    scales, now = move(pace, device, 30, now)
    assert all(device.mean(s) <= 1.1 * TARGET for s in scales[4:])
    device.b_ms = 5000.0
    scales, now = move(pace, device, 30, now)
    assert set(scales[4:]) == {STEPS[0]}
    device.b_ms = 20.0
    scales, now = move(pace, device, 60, now)
    assert scales[-1] == 1.0


def test_one_slow_frame_changes_nothing():
    pace, device = Pace(TARGET), Device(1.0, 25.0)
    scales, now = move(pace, device, 100)
    slow = Device(2000.0, 0.0)
    for _ in range(10):
        move(pace, slow, 1, now)
        after, now = move(pace, device, 6, now)
        assert set(after) == {scales[-1]}


def test_a_rebuild_of_two_frames_is_made_good():
    pace, device = Pace(TARGET), Device(1.0, 25.0)
    before, now = move(pace, device, 100)
    move(pace, Device(2000.0, 0.0), 2, now)
    after, _ = move(pace, device, 60, now)
    assert after[-1] == before[-1]


def test_a_target_that_changes_is_met():
    pace, device = Pace(1.0 / 60.0), Device(1.0, 30.0)
    slow, now = move(pace, device, 100)
    pace.target_s = 1.0 / 20.0
    fast, _ = move(pace, device, 100, now)
    assert fast[-1] > slow[-1]
    assert device.mean(slow[-1]) <= 1.1 / 60.0


def rested(pace, device, now=0.0):
    """Draw what is asked for until nothing is; give the scales and the time."""
    scales = []
    for _ in range(1000):
        order = pace.next_order(now)
        if order is not None:
            scales.append(order.scale)
            assert pace.sharpening == order.sharp
            pace.drawn(order, device.draw(order.scale))
            now += device.draw(order.scale)
        else:
            due = pace.due_in_s(now)
            if due is None:
                return scales, now
            now += due
    raise AssertionError("never rests")


def test_the_full_picture_comes_once_nothing_changes():
    pace, device = Pace(TARGET), Device(1.0, 100.0)
    _, now = move(pace, device, 50)
    last = now
    pace.change(now)
    order = pace.next_order(now)
    pace.drawn(order, 0.03)
    assert pace.next_order(now + 0.2) is None
    assert pace.due_in_s(now + 0.2) == pytest.approx(0.05)
    scales, now = rested(pace, device, now)
    assert scales == [1.0]
    assert now >= last + 0.25
    assert pace.next_order(now + 100.0) is None
    assert pace.due_in_s(now + 100.0) is None
    assert not pace.sharpening


def test_it_starts_quick_and_rests_sharp():
    assert rested(Pace(TARGET), Device(1.0, 100.0))[0] == [0.5, 1.0]


def test_a_quick_device_has_nothing_to_sharpen():
    pace, device = Pace(TARGET), Device(1.0, 5.0)
    _, now = move(pace, device, 100)
    assert rested(pace, device, now)[0] == []
    pace.change(now)
    whole = pace.next_order(now + 10.0)
    assert whole.scale == 1.0
    pace.change(now + 10.0)
    assert not whole.sharp
    assert pace.next_order(now + 10.01) is None  # as quick as any, and waited for


def test_the_full_picture_does_not_count_as_slow():
    pace, device = Pace(TARGET), Device(1.0, 100.0)
    scales, now = move(pace, device, 100)
    for _ in range(20):
        _, now = rested(pace, device, now + 1.0)
        again, now = move(pace, device, 1, now)
        assert set(again) == {scales[-1]}


def test_a_quick_frame_is_waited_for():
    pace = Pace(TARGET)
    pace.change(0.0)
    order = pace.next_order(0.0)
    pace.change(0.01)
    assert pace.next_order(0.01) is None
    assert pace.next_order(0.4) is None
    pace.drawn(order, 0.4)
    following = pace.next_order(0.4)
    assert following.state == order.state + 1


def test_a_quick_frame_that_takes_far_too_long_gives_way():
    # A table of minutes, or the reference: whoever goes back to what was quick must not wait.
    pace = Pace(TARGET)
    order = pace.next_order(0.0)
    assert pace.next_order(60.0) is None  # nothing newer to give way to
    pace.change(60.0)
    following = pace.next_order(60.0)
    assert following.state == order.state + 1
    assert not following.sharp
    assert pace.next_order(60.1) is None


def test_frames_of_a_second_are_seen_while_the_scene_never_rests():
    pace, seconds, shown = Pace(TARGET), 1.4, 0
    order = begun = None
    for k in range(1000):
        now = 0.02 * k
        pace.change(now)
        if order is not None and now - begun >= seconds:
            pace.drawn(order, seconds)
            order, shown = None, shown + 1
        following = pace.next_order(now)
        if following is not None:
            order, begun = following, now
    # The first two, after 0.5 and 1 s, gave way.
    assert shown >= 11


def test_the_full_picture_gives_way_to_a_change():
    pace, device = Pace(TARGET), Device(1.0, 100.0)
    _, now = move(pace, device, 50)
    now += 1.0
    sharp = pace.next_order(now)
    assert sharp.sharp
    assert sharp.scale == 1.0
    assert pace.sharpening
    assert pace.next_order(now + 0.1) is None
    pace.change(now + 0.1)
    quick = pace.next_order(now + 0.1)
    assert not quick.sharp
    assert quick.state == sharp.state + 1
    # Should the old one come late, the new one is still to come.
    pace.drawn(sharp, 0.2)
    assert pace.next_order(now + 0.12) is None
    pace.drawn(quick, 0.03)
    assert pace.next_order(now + 0.5).sharp


def test_a_frame_that_fails_is_not_asked_for_again():
    pace = Pace(TARGET)
    for sharp in (False, True):
        order = pace.next_order(1.0 if sharp else 0.0)
        assert order.sharp is sharp
        pace.dropped(order)
    assert pace.next_order(5.0) is None
    assert pace.due_in_s(5.0) is None
    pace.change(6.0)
    assert pace.next_order(6.0) is not None


def test_other_steps():
    pace, device = Pace(TARGET, steps=(0.6, 1.0), settle_s=0.1), Device(1.0, 1000.0)
    scales, now = move(pace, device, 20)
    assert set(scales) == {0.6}
    assert rested(pace, device, now)[0] == [1.0]
    only = Pace(TARGET, steps=(1.0,))
    assert set(move(only, device, 20)[0]) == {1.0}


def test_while_a_frame_is_drawn_nothing_is_due_but_what_it_gives_way_to():
    pace = Pace(TARGET)
    pace.change(0.0)
    assert pace.due_in_s(0.0) == pytest.approx(0.25)
    pace.next_order(0.0)
    assert pace.due_in_s(0.1) is None
    assert pace.due_in_s(10.0) is None
    pace.change(10.0)  # the frame under way is late: it gives way at once
    assert pace.due_in_s(10.0) == 0.0
    assert pace.next_order(10.0) is not None
    pace.change(10.1)
    assert 0.0 < pace.due_in_s(10.2) < 4.0
