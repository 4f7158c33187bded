"""Skies made beside the pictures: what stands in for them, what is solved for, what is given up."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

import rtbow.view.worker.skies as skies_module
from rtbow.physics.constants import SEA_LEVEL_HPA
from rtbow.render.renderer import Renderer
from rtbow.render.sky.wanted import SkiesAtOnce, Wanted
from rtbow.scene.air import Aerosol
from rtbow.scene.text.file import load_scene
from rtbow.tables.sky.rays import Eye
from rtbow.tables.sky.seen import PHASE_PARTS, SkyTable
from rtbow.view.worker.skies import BesideSkies, Waiting
from rtbow.view.worker.sky_processes import Maker, Solver
from rtbow.world.measured.albedo import load_albedo
from rtbow.world.sky import Ground, Surroundings

PATIENCE_S = 60.0
CLEAR = Surroundings(SEA_LEVEL_HPA, True, Ground(load_albedo(0.3), 0.0), 0.0, None)
OZONE = replace(CLEAR, ozone_du=300.0)
HAZY = replace(CLEAR, aerosol=Aerosol())


def wanted(
    altitude_deg: float, around: Surroundings = CLEAR, height_m: float = 2.0, **eye: object
) -> Wanted:
    place = {"distances_m": np.zeros(0), "polarised": False, **eye}
    return Wanted(around, Eye(height_m, np.radians(altitude_deg), **place), np.eye(3), np.eye(3))


def table(value: float, hazy: bool = False) -> SkyTable:
    """A sky that is of one value everywhere."""
    layers = np.full((1, 1, 2, 2, 3), value, np.float32)
    glare = np.full((1, PHASE_PARTS, 2, 2, 3), value, np.float32) if hazy else None
    phase = np.ones((PHASE_PARTS, 2), np.float32) if hazy else None
    return SkyTable(layers, glare, phase, layers[0], layers[0, 0, :, 0], -0.01, None)


def shown(seen) -> float:
    """The value of a sky, NaN where there is none."""
    return float("nan") if seen is None else float(seen[1].layers.mean())


@dataclass
class Processes:
    """Stands for both processes: skies have the sun's altitude for a value, plus their ozone."""

    unknown: list[Surroundings] = field(default_factory=list)
    asked: list[Wanted] = field(default_factory=list)
    solving: list[FakeSolver] = field(default_factory=list)
    go: threading.Event = field(default_factory=threading.Event)


class FakeMaker:
    def __init__(self, processes: Processes) -> None:
        self._processes = processes
        self._busy = False

    def know(self, around, field) -> None:
        # Both ends would wait to be heard: fields are larger than what a pipe holds.
        assert not self._busy, "told of an air while it sums a sky"
        self._processes.unknown.remove(around)

    def begin(self, one: Wanted) -> None:
        self._busy = True
        self._processes.asked.append(one)

    def wait(self, seconds: float) -> bool:
        return self._processes.go.wait(seconds)

    def take(self) -> SkyTable | None:
        self._busy = False
        last = self._processes.asked[-1]
        if last.around in self._processes.unknown:
            return None
        value = np.degrees(last.eye.sun_altitude_rad) + last.around.ozone_du
        return table(value, last.around.aerosol is not None)

    def close(self) -> None:
        self._processes.go.set()


class FakeSolver:
    def __init__(self, processes: Processes, around: Surroundings) -> None:
        self.around, self.share, self.alive, self.closed = around, 0.0, True, False
        self.result: tuple[()] | None = None
        self.coming = 0.0
        processes.solving.append(self)

    def take(self):
        self.share = self.coming
        return self.result

    def close(self) -> None:
        self.closed = True


class Painter:
    """Asks for skies as a method does, a picture at a time."""

    def __init__(self) -> None:
        self.news: list[Waiting | None] = []
        self.skies = BesideSkies(self.news.append)

    def paint(self, *suns: Wanted):
        self.skies.begin()
        seen = self.skies.seen(suns)
        self.skies.end()
        return seen

    def until(self, condition) -> None:
        end = time.monotonic() + PATIENCE_S
        while not condition():
            assert time.monotonic() < end, self.news
            time.sleep(0.005)

    def rest(self, one: Wanted):
        """Paint until a picture has the sky itself."""
        self.until(lambda: self.paint(one) and not self.skies.behind)
        return self.paint(one)[0]


@pytest.fixture
def processes(monkeypatch) -> Processes:
    made = Processes()
    made.go.set()
    monkeypatch.setattr(skies_module, "Maker", lambda: FakeMaker(made))
    monkeypatch.setattr(skies_module, "Solver", lambda around: FakeSolver(made, around))
    monkeypatch.setattr(skies_module, "_REST_S", 0.05)
    monkeypatch.setattr(skies_module, "_LOOK_S", 0.01)
    return made


@pytest.fixture
def painter(processes) -> Iterator[Painter]:
    made = Painter()
    yield made
    made.skies.close()


def test_a_picture_never_waits_and_is_told_of_its_sky(processes, painter):
    processes.go.clear()
    assert painter.paint(wanted(20.0)) == [None]
    assert painter.skies.behind == "no sky so far: it is being made"
    assert painter.news == []
    processes.go.set()
    painter.until(lambda: None in painter.news)
    first, again = painter.paint(wanted(20.0))[0], painter.paint(wanted(20.0))[0]
    assert shown(first) == pytest.approx(20.0)
    assert first[1] is again[1]
    assert painter.skies.behind == ""


def test_between_two_suns_the_sky_is_between_theirs(processes, painter):
    for altitude in (10.0, 14.0, 30.0):
        painter.rest(wanted(altitude))
    processes.go.clear()
    (seen,) = painter.paint(wanted(11.0))
    assert shown(seen) == pytest.approx(11.0)
    assert np.degrees(seen[0].sun_altitude_rad) == pytest.approx(11.0)
    assert painter.skies.behind == "sky of suns at 10° and 14° for now"
    assert shown(painter.paint(wanted(35.0))[0]) == pytest.approx(30.0)
    assert shown(painter.paint(wanted(-5.0))[0]) == pytest.approx(10.0)


def test_the_nearest_eye_stands_in_for_one_that_flies(processes, painter):
    painter.rest(wanted(10.0, height_m=2.0))
    painter.rest(wanted(10.0, height_m=5000.0))
    processes.go.clear()
    (seen,) = painter.paint(wanted(10.0, height_m=600.0))
    assert seen[0].height_m == 2.0


@pytest.mark.parametrize(
    "other", [{"polarised": True}, {"distances_m": np.ones(3)}], ids=["filter", "layers"]
)
def test_a_sky_of_other_parts_stands_in_for_none(processes, painter, other):
    painter.rest(wanted(10.0))
    processes.go.clear()
    assert painter.paint(wanted(10.0, **other)) == [None]


def test_haze_has_its_parts_where_a_clear_sky_stands_in_and_the_other_way_round(processes, painter):
    painter.rest(wanted(10.0))
    processes.go.clear()
    for _ in range(2):  # the same object each time: it is uploaded once
        (seen,) = painter.paint(wanted(10.0, HAZY))
    assert seen[1] is painter.paint(wanted(10.0, HAZY))[0][1]
    assert seen[1].glare.shape == (1, PHASE_PARTS, 2, 2, 3)
    assert not seen[1].glare.any()
    assert painter.skies.behind == "sky of the former air for now"
    processes.go.set()
    painter.rest(wanted(12.0, HAZY))
    processes.go.clear()
    (seen,) = painter.paint(wanted(12.0, OZONE))
    assert seen[1].glare is None
    assert seen[1].phase is None


def test_skies_of_other_suns_are_made_ahead_at_rest_and_given_up_for_a_picture(processes, painter):
    painter.rest(wanted(20.0))
    painter.skies.ahead()
    painter.until(lambda: len(processes.asked) == 7)
    suns = sorted(round(np.degrees(one.eye.sun_altitude_rad)) for one in processes.asked)
    assert suns == [12, 16, 18, 20, 22, 24, 28]
    told = len(painter.news)
    assert shown(painter.paint(processes.asked[3])[0]) == pytest.approx(24.0)
    assert painter.skies.behind == ""
    assert len(painter.news) == told  # it was there: nobody had to be told
    processes.go.clear()
    painter.skies.ahead()
    painter.until(lambda: len(processes.asked) == 8)
    painter.paint(wanted(60.0))
    processes.go.set()
    painter.until(lambda: not painter.skies._wanted)
    assert len(processes.asked) == 9


def test_the_sky_of_a_moving_sun_is_made_where_it_will_be(processes, painter):
    processes.go.clear()
    painter.paint(wanted(10.0))
    painter.until(lambda: len(processes.asked) == 1)
    for altitude in np.arange(10.0, 12.0, 0.1):
        painter.paint(wanted(altitude))
        time.sleep(0.005)
    processes.go.set()
    painter.until(lambda: len(processes.asked) > 1)
    ahead = np.degrees(processes.asked[1].eye.sun_altitude_rad)
    assert 11.9 < ahead < 18.0  # by 6 degrees at most
    assert shown(painter.rest(wanted(11.9))) == pytest.approx(11.9)


def test_an_air_is_solved_for_beside_the_pictures_of_the_former_one(processes, painter):
    painter.rest(wanted(10.0))
    processes.unknown = [OZONE]
    assert shown(painter.paint(wanted(10.0, OZONE))[0]) == pytest.approx(10.0)
    painter.until(lambda: processes.solving)
    painter.until(lambda: Waiting(0.0, "new air, the former air is shown:") in painter.news)
    # The sun moves meanwhile, under the former air.
    painter.paint(wanted(25.0, OZONE))
    painter.until(lambda: shown(painter.paint(wanted(25.0, OZONE))[0]) == pytest.approx(25.0))
    processes.solving[0].coming = 0.5
    painter.until(lambda: any(one and one.share == 0.5 for one in painter.news))
    processes.solving[0].result = ()
    assert shown(painter.rest(wanted(25.0, OZONE))) == pytest.approx(325.0)
    assert processes.solving[0].closed
    assert len(processes.solving) == 1
    assert Waiting(None, "") in painter.news


def test_an_air_that_is_solved_while_a_sky_is_summed_is_told_afterwards(processes, painter):
    painter.rest(wanted(10.0))
    processes.unknown = [OZONE]
    painter.paint(wanted(10.0, OZONE))
    painter.until(lambda: processes.solving)
    processes.go.clear()
    before = len(processes.asked)
    painter.paint(wanted(25.0, OZONE))  # under the former air, until its own is known
    painter.until(lambda: len(processes.asked) > before)
    processes.solving[0].result = ()
    painter.until(lambda: processes.solving[0].closed)
    processes.go.set()
    assert shown(painter.rest(wanted(25.0, OZONE))) == pytest.approx(325.0)


def test_an_air_that_is_wanted_no_more_is_given_up_at_once(processes, painter):
    painter.rest(wanted(10.0))
    processes.unknown = [OZONE, replace(OZONE, ozone_du=310.0)]
    painter.paint(wanted(10.0, OZONE))
    painter.until(lambda: processes.solving)
    painter.paint(wanted(10.0, processes.unknown[1]))
    painter.until(lambda: processes.solving[0].closed and len(processes.solving) == 2)
    painter.paint(wanted(10.0))
    painter.until(lambda: processes.solving[1].closed)
    assert painter.news[-1] == Waiting(None, "")


def test_airs_that_a_slider_passes_are_not_solved_for(processes, painter, monkeypatch):
    monkeypatch.setattr(skies_module, "_REST_S", 0.5)
    painter.rest(wanted(10.0))
    processes.unknown = [replace(CLEAR, ozone_du=float(du)) for du in range(300, 310)]
    for around in processes.unknown[:]:
        painter.paint(wanted(10.0, around))
        time.sleep(0.02)
    painter.until(lambda: processes.solving)
    time.sleep(0.1)
    assert [one.around.ozone_du for one in processes.solving] == [309.0]


def test_closing_ends_what_is_being_solved(processes, painter):
    painter.rest(wanted(10.0))
    processes.unknown = [OZONE]
    painter.paint(wanted(10.0, OZONE))
    painter.until(lambda: processes.solving)
    painter.skies.close()
    assert processes.solving[0].closed


def test_an_air_that_cannot_be_solved_for_beside_says_why_in_the_picture(
    processes, painter, monkeypatch
):
    def fail(*_):
        raise MemoryError

    painter.rest(wanted(10.0))
    processes.unknown = [OZONE]
    painter.paint(wanted(10.0, OZONE))
    painter.until(lambda: processes.solving)
    monkeypatch.setattr(SkiesAtOnce, "solve", fail)
    painter.news.clear()
    processes.solving[0].alive = False
    painter.until(lambda: None in painter.news)
    with pytest.raises(MemoryError):
        painter.paint(wanted(10.0, OZONE))


# --- With the processes themselves ----------------------------------------------------------------


SCENE = {
    "camera.size_px": [32, 18], "camera.fov_deg": 100.0, "atmosphere.sky": True,
    "ground.albedo": 0.3,
}  # fmt: skip


@pytest.mark.slow
def test_the_frame_at_rest_is_that_of_a_sky_made_at_once():
    painter = Painter()
    scene = load_scene("uniform", SCENE)
    with Renderer(scene) as renderer:
        at_once = renderer.render("fast")
    with Renderer(scene, skies=painter.skies) as renderer:

        def paint():
            painter.skies.begin()
            renderer.show(scene)
            frame = renderer.render("fast")
            painter.skies.end()
            return frame

        first = paint()
        assert first.mean() < 0.9 * at_once.mean()
        painter.until(lambda: None in painter.news)
        assert np.array_equal(paint(), at_once)
        assert painter.skies.behind == ""
    painter.skies.close()


@pytest.mark.slow
def test_the_maker_refuses_an_air_that_is_not_kept(empty_cache):
    maker = Maker()
    maker.begin(wanted(10.0, replace(CLEAR, ozone_du=500.0)))
    assert maker.wait(PATIENCE_S)
    assert maker.take() is None
    maker.close()
    assert not maker.alive


@pytest.mark.slow
def test_the_solver_ends_at_once(empty_cache):
    solver = Solver(replace(CLEAR, ozone_du=500.0))
    time.sleep(3.0)
    assert solver.alive
    solver.close()
    assert not solver.alive
