"""The process that renders for the window, as the window's side sees it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterator
from multiprocessing import Pipe
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rtbow.base.cache import keep_arrays, kept_arrays
from rtbow.scene.text.file import load_scene
from rtbow.tables.mie.build import kept_table, parts
from rtbow.tables.mie.lookup import node_range, standard_axes
from rtbow.view.document.messages import (
    DrawFrame,
    Failed,
    FrameDrawn,
    Progressed,
    Reload,
    Reply,
    TakeSpectrum,
)
from rtbow.view.worker.handle import Worker
from rtbow.view.worker.server import Server

pytestmark = pytest.mark.slow

PATIENCE_S = 120.0


def uniform(*size_px: int, **values: object):
    return load_scene("uniform", {"camera.size_px": list(size_px), **values})


def answers(worker: Worker, count: int = 1) -> list[Reply]:
    """Wait for replies, those that only tell of progress left out."""
    found: list[Reply] = []
    end = time.monotonic() + PATIENCE_S
    while len(found) < count and time.monotonic() < end:
        worker.wait(0.1)
        found += [reply for reply in worker.replies() if not isinstance(reply, Progressed)]
    return found


def draw(worker: Worker, scene, method="auto") -> Reply:
    worker.send(DrawFrame(worker.next_number(), scene, method))
    (reply,) = answers(worker)
    return reply


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    with Worker() as one:
        yield one


def mapped() -> int:
    """Count the shared memory that this process holds."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return sum("/dev/shm/psm_" in line for line in lines)


def test_frames_of_growing_size_hold_no_more_memory_than_three(worker):
    for k, width in enumerate((16, 40, 100, 250, 400, 30, 420, 440, 460, 480, 500)):
        frame = draw(worker, uniform(width, width // 2))
        assert isinstance(frame, FrameDrawn), frame
        assert frame.rgb.shape == (width // 2, width, 3), k
        assert frame.rgb.max() > 0.0
        del frame
        assert mapped() <= 3


def test_a_frame_somebody_looks_at_outlives_its_memory(worker):
    frame = draw(worker, uniform(64, 36))
    seen = frame.rgb.copy()
    for width in (300, 600, 900, 1200):
        draw(worker, uniform(width, width // 2))
    np.testing.assert_array_equal(frame.rgb, seen)


def test_tables_that_processes_build_are_built_here(empty_cache):
    """A Lorenz-Mie table of another spread is made by processes of the renderer's own."""
    axes, radii_um = standard_axes(0.2), (1.0, 10.0)
    *others, last = parts(axes, node_range(axes, radii_um))
    for part in others:  # built before; one is left, of some seconds
        sizes = part.nodes[1] - part.nodes[0]
        ones = np.ones((sizes, 2, len(axes.angle_nodes)), np.float32)
        assert keep_arrays("mie-part", part.key, {"values": ones, "efficiency": np.ones(sizes)})
    mie = {"theory": "mie", "size_spread": 0.2}
    with Worker() as one:
        frame = draw(
            one, uniform(16, 9, scattering=mie, **{"droplets.radius.radius_um": 5.0}), "spectral"
        )
    assert isinstance(frame, FrameDrawn), frame
    assert frame.rgb.max() > 0.0
    assert kept_table(axes, radii_um) is not None
    assert kept_arrays("mie-part", last.key) is None  # it is in the table now


def test_each_request_learns_that_the_process_is_lost(worker):
    slow = uniform(1500, 1000)
    first = worker.next_number()
    worker.send(DrawFrame(first, slow, "reference"))
    worker.send(TakeSpectrum(worker.next_number(), slow, (0.0, 1.0, 0.2)))
    worker.send(Reload(worker.next_number()))
    time.sleep(0.5)
    os.kill(worker.process_id, signal.SIGKILL)
    lost = answers(worker, 2)
    assert [(type(one), one.number) for one in lost] == [(Failed, first), (Failed, first + 1)]
    assert all(one.kind == "defect" for one in lost)
    assert not worker.busy
    assert isinstance(draw(worker, uniform(32, 18)), FrameDrawn)  # started again


def test_a_newer_frame_ends_one_that_takes_minutes(worker):
    slow, quick = uniform(1500, 1000), uniform(16, 9)
    worker.send(DrawFrame(worker.next_number(), slow, "reference"))
    time.sleep(1.0)
    begun = time.monotonic()
    frame = draw(worker, quick, "reference")
    assert frame.scene == quick
    assert time.monotonic() - begun < 20.0
    assert not worker.busy


def test_a_process_that_looks_at_nothing_is_replaced(worker, monkeypatch):
    draw(worker, uniform(16, 9))
    assert not worker.revive()
    stuck = worker.process_id
    os.kill(stuck, signal.SIGSTOP)  # as in a loop of the C library
    monkeypatch.setattr(worker, "_stuck_s", 0.3)
    newest = uniform(32, 18)
    worker.send(DrawFrame(worker.next_number(), uniform(24, 12), "auto"))
    worker.send(DrawFrame(worker.next_number(), newest, "auto"))
    assert not worker.revive()
    time.sleep(0.4)
    begun = time.monotonic()
    assert worker.revive()
    assert time.monotonic() - begun < 1.0
    assert not worker.revive()
    (frame,) = answers(worker)
    assert frame.scene == newest
    assert worker.process_id != stuck
    assert not worker.busy
    end = time.monotonic() + 20.0
    while alive(stuck) and time.monotonic() < end:
        time.sleep(0.1)
    assert not alive(stuck)


def test_preparing_for_moves_tells_of_a_mistake_of_ours_and_goes_on():
    ours, theirs = Pipe()
    server = Server(theirs, "auto")

    def broken() -> None:
        raise ZeroDivisionError("half a table")

    server._renderer = SimpleNamespace(is_rough=False, prepare_moves=broken)
    server._resting = True
    server._prepare_moves()
    reply = ours.recv()
    assert (reply.number, reply.kind) == (0, "defect")
    assert "half a table" in reply.message
    server._prepare_moves()  # not again until the next frame
    assert not ours.poll()


def test_a_spectrum_that_waits_gives_way_to_a_newer_one():
    _, theirs = Pipe()
    server = Server(theirs, "auto")
    scene = uniform(16, 9)
    for number in (1, 2, 3):
        server._take(TakeSpectrum(number, scene, (0.0, 1.0, 0.0)))
    server._take(DrawFrame(4, scene, "auto"))
    assert [request.number for request in server._waiting] == [3, 4]


# --- The window's process ends ------------------------------------------------------------------

ENDING = """
    import os, signal, sys, time
    from rtbow.scene.text.file import load_scene
    from rtbow.view.document.messages import DrawFrame
    from rtbow.view.worker.handle import Worker

    def main():
        worker = Worker()
        size, method = (([1500, 1000], "reference") if "busy" in sys.argv else ([16, 9], "auto"))
        scene = load_scene("uniform", {"camera.size_px": size})
        worker.send(DrawFrame(worker.next_number(), scene, method))
        worker.wait(60.0)
        print(worker.process_id, flush=True)
        if "killed" in sys.argv:
            os.kill(os.getpid(), signal.SIGKILL)
        if "stuck" in sys.argv:  # as in a loop of the C library
            os.kill(worker.process_id, signal.SIGSTOP)

    if __name__ == "__main__":
        main()
"""


def alive(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


@pytest.mark.parametrize("how", [("killed",), ("killed", "busy"), ("busy",), (), ("stuck",)])
def test_the_renderer_never_outlives_the_window(tmp_path, how):
    script = tmp_path / "ending.py"
    script.write_text(textwrap.dedent(ENDING))
    result = subprocess.run(
        [sys.executable, str(script), *how], capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert result.returncode == (-signal.SIGKILL if "killed" in how else 0), result.stderr
    process = int(result.stdout)
    end = time.monotonic() + 20.0
    while alive(process) and time.monotonic() < end:
        time.sleep(0.1)
    assert not alive(process)
    if "killed" not in how and "stuck" not in how:
        assert result.stderr == ""


def test_shared_memory_goes_with_a_process_that_was_ended():
    before = set(os.listdir("/dev/shm"))
    with Worker() as one:
        draw(one, uniform(64, 36))
        assert set(os.listdir("/dev/shm")) - before
    assert not set(os.listdir("/dev/shm")) - before
