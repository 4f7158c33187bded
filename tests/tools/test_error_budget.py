"""The error budget's own parts: document, air mass, strips."""

import numpy as np
import pytest

from budget import STAGES
from budget.air import kasten_young
from budget.error_budget import Row, Stage, document, run_stage
from budget.strips import reference_strip, strip_angles, strip_rays, strip_scene, table_strip
from rtbow.frames.difference import Spread, frame_difference


def stub(failing):
    """A stage with a row of each kind and a note, which may fail after them."""

    def measure():
        frame = np.ones((5, 3))
        yield Row("a picture", "nowhere", frame_difference(1.02 * frame, frame), headline=True)
        yield Row("a number", "somewhere", relative=Spread(1e-7, 0.5, 2.0))
        yield "a finding " * 30
        if failing:
            raise RuntimeError("the lamp went out")

    return Stage("A stub: of a stage", "What is compared.", measure)


def test_document_has_every_stage_in_full():
    said = []
    outcomes = [
        run_stage(name, stub(name == "second"), said.append) for name in ("first", "second")
    ]
    text = document(outcomes, {"GL renderer": "a wheel"})
    lines = text.splitlines()
    assert lines[0] == "# Error budget"
    assert "- GL renderer: a wheel" in lines
    assert "`python tools/accuracy.py budget --stage second`" in lines
    assert sum(line == "## A stub: of a stage" for line in lines) == 2
    # The summary has the headlines, and each stage all its rows.
    assert sum("| a picture |" in line for line in lines) == 4
    assert sum("| a number |" in line for line in lines) == 2
    assert "| a number | somewhere | – | – | – | 1e-05 % | 50 % | 200 % | – |" in lines
    assert "(#a-stub-of-a-stage)" in text
    # What a stage found before it failed is kept, and the failure is said twice.
    assert "**Failed: RuntimeError: the lamp went out**" in lines
    assert "**Failed, and incomplete below: A stub: of a stage.**" in lines
    assert max(len(line) for line in lines if not line.startswith("|")) <= 100
    assert any("a picture" in line for line in said)
    assert text.endswith("\n")
    assert not text.endswith("\n\n")


def test_document_is_the_same_for_the_same_numbers():
    both = [document([run_stage("one", stub(False), lambda _: None)], {}) for _ in range(2)]
    assert both[0] == both[1]


def test_kasten_young():
    # Their table 2, for the ISO standard atmosphere; the formula fits it within 0.5 %.
    table = {0: 38.09, 1: 26.26, 5: 10.316, 10: 5.584, 20: 2.904, 30: 1.994, 90: 1.0}
    for altitude, mass in table.items():
        assert kasten_young(altitude) == pytest.approx(mass, rel=5e-3)
    # The formula itself, at the horizon.
    assert kasten_young(0.0) == pytest.approx(37.92, abs=5e-3)


def test_strip_of_the_table_is_that_of_the_reference():
    theta = strip_angles()[::10]
    rays = strip_rays(theta)
    assert np.abs(np.linalg.norm(rays, axis=1) - 1.0).max() < 1e-12
    scene = strip_scene({"render.wavelength_step_nm": 40.0})
    looked, direct = table_strip(scene, theta), reference_strip(scene, theta)
    # A wrong angle, sun or length of the rays would show at once; the table errs by 0.2 %.
    assert np.abs(looked - direct).max() < 4e-3 * direct.max()


def test_stages_have_names_that_the_command_takes():
    expected = "theory table wavelength march air float32 storage rain"
    assert list(STAGES) == expected.split()
    assert len({stage.title for stage in STAGES.values()}) == len(STAGES)
