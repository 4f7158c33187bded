"""Renderers in several threads: one for each, one for all, closed or dropped by another one."""

from __future__ import annotations

import gc
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import rtbow
import rtbow.gl.context
from rtbow.render.renderer import Renderer

THREADS = 4


@pytest.fixture(scope="module")
def scene():
    return rtbow.load_scene("uniform", {"camera.size_px": [24, 14]})


def in_threads(work: Callable[[int], object], count: int = THREADS) -> list[object]:
    """Do something in several threads at once; give what each returned, or its error."""
    done: list[object] = [None] * count
    together = threading.Barrier(count)

    def run(number: int) -> None:
        try:
            together.wait()
            done[number] = work(number)
        except BaseException as error:
            done[number] = error

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive()
    return done


@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_one_for_all(scene, backend):
    with Renderer(scene, backend) as renderer:
        inside, most = 0, 0

        def watch(rows):
            nonlocal inside, most
            inside, most = inside + 1, max(most, inside + 1)
            time.sleep(0.02)  # others come in if they can
            yield from rows
            inside -= 1

        frames = in_threads(lambda _: renderer.render("spectral", watch))
        assert most == 1
        for frame in (*frames, renderer.render("spectral")):
            np.testing.assert_array_equal(frame, frames[0])
        in_threads(lambda _: renderer.close(), 1)
        with pytest.raises(rtbow.RtbowError, match="closed"):
            renderer.render()


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["egl", "osmesa"])
def test_one_for_each(scene, backend):
    methods = ("fast", "spectral")

    def draw(number: int) -> object:
        with Renderer(scene, backend) as renderer:
            return [renderer.render(methods[number % 2]) for _ in range(2)]

    drawn = in_threads(draw)
    for number, frames in enumerate(drawn):
        np.testing.assert_array_equal(frames, drawn[number % 2])


@pytest.mark.slow
def test_the_reference_in_several(scene):
    small = rtbow.load_scene("uniform", {"camera.size_px": [4, 3]})
    drawn = in_threads(lambda _: Renderer(small).render("reference"))
    for frame in drawn:
        np.testing.assert_array_equal(frame, drawn[0])


def test_what_is_dropped_is_freed_when_the_next_opens(scene, monkeypatch):
    """Wherever Python collects a renderer, its context is closed by a thread that is at rest."""
    closed = []
    close = rtbow.gl.context.GlContext.close
    monkeypatch.setattr(
        rtbow.gl.context.GlContext, "close", lambda self: (closed.append(self), close(self))
    )

    def drop(_: int) -> None:
        renderer = Renderer(scene, "egl")
        renderer.render()
        renderer.itself = renderer  # so that the collector finds it, later
        del renderer
        gc.collect()

    with Renderer(scene, "egl") as other:
        first = other.render()
        in_threads(drop, 1)
        assert closed == []
        np.testing.assert_array_equal(other.render(), first)
        with Renderer(scene, "egl") as another:
            np.testing.assert_array_equal(another.render(), first)
        assert len(closed) == 2
        np.testing.assert_array_equal(other.render(), first)
    assert all(context.closed for context in closed)
