"""The window on scenes with a sky: pictures never wait for it, and end with what render draws."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import rtbow
from rtbow.frames.display import auto_exposure_ev
from rtbow.scene.text.file import load_scene
from rtbow.view.app import Viewer
from rtbow.view.document.edits import Opened

pytestmark = pytest.mark.slow

AROUND = {"atmosphere.sky": True, "ground.albedo": 0.3, "camera.size_px": [160, 90]}
NEW_AIR = {"atmosphere.aerosol": {"model": "custom", "optical_depth_550": 0.037123}}
"""Which neither comes with the program nor is solved for elsewhere, so that it is in no cache."""
PATIENCE_S = 240.0


class Window:
    """A window on a scene, without hands."""

    def __init__(self) -> None:
        self.viewer = Viewer(Opened(load_scene("uniform", AROUND), "uniform"))

    def until(self, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, (self.viewer.state.stale, self.viewer.state.progresses)
            self.viewer.state.wake()
            self.viewer.step()

    def settle(self) -> None:
        self.until(lambda: self.viewer.state.frame is not None)
        end = time.monotonic() + PATIENCE_S
        while not self.viewer.settled:
            assert time.monotonic() < end, self.viewer.state.frame
            self.viewer.step()

    def change(self, **values: object) -> None:
        changes = {key.replace("__", "."): value for key, value in values.items()}
        assert self.viewer.change(changes) == ""

    def next_frame(self) -> None:
        count = self.viewer.state.frames_shown
        self.until(lambda: self.viewer.state.frames_shown > count)


@pytest.fixture(scope="module")
def opened_window(screen: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Window]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("current"))
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("data")))
        made = Window()
        yield made
        made.viewer.close()


@pytest.fixture
def window(opened_window: Window) -> Window:
    """The window on its first scene, settled."""
    viewer = opened_window.viewer
    viewer.edits.open(Opened(load_scene("uniform", AROUND), "uniform"))
    opened_window.settle()
    return opened_window


def assert_is_the_scenes(viewer: Viewer) -> None:
    """Compare the picture with what render draws of its scene."""
    shown = viewer.state.frame
    assert shown is not None
    assert shown.scene == viewer._live_scene(1.0)
    with rtbow.Renderer(shown.scene) as renderer:
        rgb = renderer.render()
    found = viewer.frame_rgb
    assert found is not None
    assert found.shape == rgb.shape
    # Tables for all places differ by the method's error.
    assert np.percentile(np.abs(found - rgb), 99) < 0.01 * rgb.max()
    assert abs(np.log(found.mean() / rgb.mean())) < 2e-3
    np.testing.assert_allclose(shown.exposure_ev, auto_exposure_ev(rgb), atol=0.05)


def test_the_picture_at_rest_is_that_of_render(window):
    scene = window.viewer._live_scene(1.0)
    assert scene.has_surroundings
    assert scene.camera.pixel == "area"
    assert 12.0 < window.viewer.state.frame.exposure_ev < 16.0
    assert_is_the_scenes(window.viewer)


def test_a_moved_sun_has_a_sky_at_once_and_its_own_at_last(window):
    viewer = window.viewer
    window.change(light__0__altitude_deg=33.3)
    window.next_frame()
    behind = viewer.state.frame.behind
    assert behind.startswith("sky of suns at ")
    assert viewer.frame_rgb[0].mean() > 1000.0  # daylight
    assert not viewer.settled
    window.settle()
    assert viewer.state.frame.behind == ""
    assert_is_the_scenes(viewer)


def test_an_air_is_solved_for_beside_and_given_up(window):
    viewer = window.viewer
    before = viewer.state.frame
    assert viewer.change(NEW_AIR) == ""
    window.until(lambda: "sky" in viewer.state.progresses)
    assert viewer.state.progresses["sky"][1] == "new air, the former air is shown:"
    assert viewer.state.frame.behind == "sky of the former air for now"
    np.testing.assert_allclose(viewer.state.frame.exposure_ev, before.exposure_ev, atol=0.1)
    # Camera and sun move meanwhile.
    window.change(camera__azimuth_deg=20.0)
    window.next_frame()
    window.change(light__0__altitude_deg=27.0)
    window.next_frame()
    assert viewer.state.frame.behind
    for _ in range(3):
        viewer.undo()
    window.until(lambda: "sky" not in viewer.state.progresses)
    window.settle()
    assert_is_the_scenes(viewer)


def test_haze_without_a_sky_follows_a_moved_sun_in_the_end(window):
    viewer = window.viewer
    haze = {"model": "custom", "optical_depth_550": 0.1}
    assert viewer.change({"atmosphere.sky": False, "atmosphere.aerosol": haze}) == ""
    window.settle()
    for altitude in (24.0, 28.0, 32.0):
        window.change(light__0__altitude_deg=altitude)
        window.next_frame()
    window.settle()
    assert_is_the_scenes(viewer)


def test_a_window_that_closes_gives_up_what_is_solved_for(window):
    """The last one: it closes the window that all tests here share."""
    assert window.viewer.change(NEW_AIR) == ""
    window.until(lambda: "sky" in window.viewer.state.progresses)
    drawing = window.viewer.worker.process_id
    beside = children(drawing)
    assert len(beside) >= 2  # the maker and the solver
    window.viewer.close()
    end = time.monotonic() + PATIENCE_S
    while any(map(alive, [drawing, *beside])):
        assert time.monotonic() < end
        time.sleep(0.05)


def alive(process: int) -> bool:
    """Whether a process runs: neither gone nor waiting to be looked at."""
    try:
        state = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def children(process: int) -> list[int]:
    """The processes that a process has started from any of its threads."""
    found: list[int] = []
    for task in os.listdir(f"/proc/{process}/task"):
        text = Path(f"/proc/{process}/task/{task}/children").read_text("utf-8")
        found += [int(number) for number in text.split()]
    return found
