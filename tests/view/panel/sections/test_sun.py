"""The sun of a date, time and place, in the panel."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

import pytest

from panel_driver import Stage, is_red
from rtbow.physics.light.sun_position import sun_position

# --- The sun by date ------------------------------------------------------------------------------


def test_the_sun_stands_where_it_does_at_a_date_time_and_place(uniform):
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.latitude", "59.9")
    uniform.enter("by date.longitude", "10.75")
    uniform.enter("by date.date", "2026-06-21")
    uniform.enter("by date.time", "18:30")
    uniform.enter("by date.offset", "2")
    when = datetime(2026, 6, 21, 18, 30, tzinfo=timezone(timedelta(hours=2)))
    found = sun_position(when, 59.9, 10.75)
    sun = uniform.edits.scene.light[0]
    assert sun.altitude_deg == pytest.approx(found.altitude_deg, abs=0.006)
    assert sun.azimuth_deg == pytest.approx(found.azimuth_deg, abs=0.006)
    before = uniform.edits.scene
    uniform.drag("by date.time", 0.5, 0.4)
    assert uniform.edits.scene.light[0].azimuth_deg != sun.azimuth_deg
    uniform.edits.undo()
    assert uniform.edits.scene == before


def stands(stage: Stage) -> tuple[float, float]:
    sun = stage.edits.scene.light[0]
    return sun.altitude_deg, sun.azimuth_deg


def test_date_time_and_place_go_back_with_the_sun(uniform):
    sun = uniform.panel.sun
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.date", "2026-06-21")
    uniform.enter("by date.time", "18:30")
    uniform.drag("by date.time", 0.5, 0.4)
    later = sun.minutes
    assert later != 18 * 60 + 30
    uniform.enter("by date.latitude", "20")
    for _ in range(2):
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Undo")
        assert (sun.minutes, sun.latitude_deg) == (later, 48.0)
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Undo")
        assert sun.minutes == 18 * 60 + 30
        assert sun.direction_deg() == stands(uniform)
        uniform.click("Redo")
        uniform.click("Redo")
        assert (sun.minutes, sun.latitude_deg) == (later, 20.0)
    while uniform.edits.can_undo:
        uniform.click("Undo")
    assert not sun.on
    uniform.click("Redo")
    assert sun.on


def test_a_sun_that_was_moved_by_hand_is_not_that_of_the_date(uniform):
    uniform.click("by date.use", 0.1)
    assert "by date.time" in uniform.seen
    uniform.enter("light.0.altitude_deg", "12.3")
    assert not uniform.panel.sun.on
    assert "by date.time" not in uniform.seen
    uniform.click("Undo")
    assert uniform.panel.sun.on
    uniform.click("by date.use", 0.1)
    uniform.frames(3)
    assert not uniform.panel.sun.on
    uniform.enter("light.0.altitude_deg", "12.3")
    uniform.click("Undo")
    assert not uniform.panel.sun.on


@pytest.mark.parametrize(("year", "days"), [(2026, 365), (2028, 366)])
def test_the_slider_of_days_ends_with_its_year(uniform, year, days):
    sun = uniform.panel.sun
    uniform.click("by date.use", 0.1)
    uniform.enter("by date.date", f"{year}-06-21")
    uniform.drag("by date.date", 0.5, 1.2)
    assert str(sun.day) == f"{year}-12-31"
    assert sun.day.timetuple().tm_yday == days
    uniform.drag("by date.date", 0.9, -0.2)
    assert str(sun.day) == f"{year}-01-01"


@pytest.mark.parametrize(
    ("path", "text"),
    [
        ("by date.date", "yesterday"), ("by date.date", "2500-01-01"), ("by date.time", "25:99"),
        ("by date.offset", "99"), ("by date.latitude", "91"), ("by date.longitude", "west"),
    ],
)  # fmt: skip
def test_a_wrong_date_or_place_is_refused(uniform, path, text):
    uniform.click("by date.use", 0.1)
    before = uniform.edits.scene
    uniform.enter(path, text)
    assert uniform.panel.rows.drafts.texts[path].message
    assert uniform.edits.scene is before
    assert is_red(uniform, path)


@pytest.mark.parametrize("name", ["latitude", "longitude", "offset"])
def test_a_whole_number_is_a_number_like_others(uniform, name):
    uniform.click("by date.use", 0.1)
    for text, value in (("7", 7.0), ("8.5", 8.5), ("9", 9.0)):
        uniform.enter(f"by date.{name}", text)
        attribute = {"offset": "offset_h"}.get(name, f"{name}_deg")
        assert getattr(uniform.panel.sun, attribute) == value
    uniform.drag(f"by date.{name}", 0.5, 0.6)
    assert getattr(uniform.panel.sun, attribute) != 9.0
