"""Renderers in processes forked from one that has drawn: they draw, or say what to do."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

import rtbow
import rtbow.gl.process
from checkout import ROOT
from rtbow.gl.context import open_context
from rtbow.gl.driver import BackendError

SIZE = {"camera.size_px": [8, 6], "render.wavelength_step_nm": 40.0}

FORKING = """
import gc, json, os, sys
from multiprocessing import get_context
import rtbow

SIZE = {"camera.size_px": [8, 6], "render.wavelength_step_nm": 40.0}

def draw(method, backend="auto"):
    with rtbow.Renderer(rtbow.load_scene("uniform", SIZE), backend) as renderer:
        try:
            return [renderer.render(method).tolist(), renderer.backend]
        except rtbow.RtbowError as error:
            return [type(error).__name__, str(error)]

def draw_with_the_parents():
    frame = renderer.render().tolist()
    renderer.close()
    return [frame, renderer.backend]

renderer = rtbow.Renderer(rtbow.load_scene("uniform", SIZE))
renderer.render()
told = {"parent": [draw("auto"), draw("reference")]}
with get_context("fork").Pool(1) as pool:
    for name, work, args in (
        ("auto", draw, ("auto",)),
        ("reference", draw, ("reference",)),
        ("egl", draw, ("auto", "egl")),
        ("inherited", draw_with_the_parents, ()),
    ):
        told[name] = pool.apply_async(work, args).get(timeout=60)
child = os.fork()
if not child:  # ends as scripts do, and collects what its parent holds
    del renderer
    gc.collect()
    sys.exit(7)
told["exit code"] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
told["after"] = renderer.render().tolist()
print(json.dumps(told))
"""


def draw(altitude_deg: float) -> tuple[float, str]:
    """Draw a frame in a worker: the sum of its values, and the backend."""
    scene = rtbow.load_scene("uniform", SIZE | {"light.0.altitude_deg": altitude_deg})
    with rtbow.Renderer(scene) as renderer:
        return float(renderer.render().sum()), renderer.backend


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_forked_from_one_that_has_drawn():
    env = {**os.environ, "PYTHONPATH": str(ROOT), "LP_NUM_THREADS": "2", "NUMBA_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", FORKING], env=env, capture_output=True, text=True, timeout=240
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    (frame, backend), (reference, _) = told["parent"]
    assert backend == "egl"
    assert told["auto"] == [frame, "osmesa"]  # with which the parent had not drawn
    assert told["reference"] == [reference, "none"]
    assert told["inherited"] == [frame, "none"]
    assert told["exit code"] == 7
    assert told["after"] == frame
    kind, message = told["egl"]
    assert kind == "UnavailableError"
    assert "forked" in message
    assert 'get_context("spawn")' in message


@pytest.mark.slow
def test_workers_that_are_not_forked_from_it():
    here = draw(10.0)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        assert pool.submit(draw, 10.0).result(timeout=120) == here


@pytest.mark.slow
def test_joblib():
    joblib = pytest.importorskip("joblib")
    here = draw(10.0)
    assert joblib.Parallel(n_jobs=2)(joblib.delayed(draw)(10.0) for _ in range(2)) == [here, here]


class TestWhatTheParentHadOpened:
    @pytest.fixture(autouse=True)
    def nothing_else(self, monkeypatch):
        monkeypatch.setattr(rtbow.gl.process, "_inherited", inherited := {})
        self.inherited = inherited

    def test_another_backend_draws_as_quickly(self):
        self.inherited["egl"] = "llvmpipe (LLVM 15.0.6, 256 bits)"
        with open_context() as context:
            assert context.backend in ("window", "osmesa")
        with pytest.raises(rtbow.UnavailableError, match=r"forked from .*spawn"):
            open_context("egl")

    def test_a_gpu_is_not_replaced_in_silence(self):
        self.inherited["egl"] = "NVIDIA H200/PCIe/SSE2"
        with pytest.raises(rtbow.UnavailableError, match=r"the GPU belongs to .*spawn"):
            open_context()
        with open_context("osmesa") as context:  # asked for by name
            assert context.backend == "osmesa"

    def test_none_is_left(self):
        self.inherited |= dict.fromkeys(("egl", "window", "osmesa"), "llvmpipe")
        with pytest.raises(rtbow.UnavailableError, match="does not work here; start workers"):
            open_context()


def test_a_lock_is_not_held_by_the_parents_threads(monkeypatch):
    lock = rtbow.gl.process.Lock()
    lock.__enter__()  # as another thread of the parent might
    here = os.getpid()
    monkeypatch.setattr(rtbow.gl.process.os, "getpid", lambda: here + 1)
    before = lock._lock
    with lock:
        assert lock._lock is not before


@pytest.mark.parametrize(
    "error",
    [
        rtbow.RtbowError("a"),
        rtbow.InputError("b"),
        rtbow.UnavailableError("c"),
        BackendError("no display", "install one"),
    ],
)
def test_errors_travel_between_processes(error):
    """A pool whose worker raises what cannot be read back waits for ever."""
    back = pickle.loads(pickle.dumps(error))
    assert type(back) is type(error)
    assert str(back) == str(error)
    assert vars(back) == vars(error)
