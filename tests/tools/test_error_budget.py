"""The error budget's own parts: colour difference, document, air mass, strips."""

import numpy as np
import pytest

from budget.error_budget import Note, Row, Stage, document, run_stage
from checkout import ROOT
from rtbow.frames.difference import Spread, delta_e_2000, frame_difference
from rtbow.physics.light.colour import D65_XYZ

TOOLS = ROOT / "tools"

# Sharma, Wu, Dalal, Color Res. Appl. 30, 21 (2005), table 1: pairs 1, 4, 7, 10, 17, 25, 31, 34.
SHARMA = [
    ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
    ((50.0, -1.3802, -84.2814), (50.0, 0.0, -82.7485), 1.0000),
    ((50.0, 0.0, 0.0), (50.0, -1.0, 2.0), 2.3669),
    ((50.0, 2.4900, -0.0010), (50.0, -2.4900, 0.0010), 7.1792),
    ((50.0, 2.5, 0.0), (73.0, 25.0, -18.0), 27.1492),
    ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
]


@pytest.fixture
def tools(monkeypatch):
    """The folder of tools, importable as it is for a script there."""
    monkeypatch.syspath_prepend(str(TOOLS))


def xyz_of(lab, white):
    """CIE 1976 L*a*b* to X, Y, Z, by its definition."""
    fy = (lab[0] + 16.0) / 116.0
    f = np.array([fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0])
    low = 3.0 * (6.0 / 29.0) ** 2 * (f - 4.0 / 29.0)
    return white * np.where(f > 6.0 / 29.0, f**3, low)


@pytest.mark.parametrize(("first", "second", "expected"), SHARMA)
def test_delta_e_of_published_pairs(first, second, expected):
    white = 7.0 * D65_XYZ
    found = delta_e_2000(xyz_of(first, white), xyz_of(second, white), white)
    # Printed with four digits.
    assert found == pytest.approx(expected, abs=6e-5)


def test_delta_e_keeps_the_shape():
    white = 1e4 * D65_XYZ
    grey = np.full((2, 3, 1), 0.2) * white
    assert delta_e_2000(grey, grey, white).shape == (2, 3)
    assert np.abs(delta_e_2000(grey, grey, white)).max() < 1e-12


def test_frame_difference_of_equal_brightening():
    rng = np.random.default_rng(3)
    frame = rng.uniform(10.0, 100.0, (8, 9, 1)) * D65_XYZ
    found = frame_difference(1.01 * frame, frame)
    assert found.l2 == pytest.approx(0.01)
    # X, Y or Z of D65: Z is greatest.
    level = np.percentile(frame[..., 1], 99.5)
    assert found.relative.worst == pytest.approx(0.01 * frame.max() / level)
    assert 0.0 < found.delta_e.median <= found.delta_e.p99 <= found.delta_e.worst < 0.5


def test_frame_difference_does_not_depend_on_the_unit():
    rng = np.random.default_rng(4)
    first, second = rng.uniform(0.1, 1.0, (2, 50, 3))
    one, other = frame_difference(first, second), frame_difference(9e3 * first, 9e3 * second)
    assert one.delta_e.worst == pytest.approx(other.delta_e.worst)
    assert one.relative.p99 == pytest.approx(other.relative.p99)


def test_black_pixels_do_not_count():
    frame = np.zeros((10, 10, 3))
    frame[0] = D65_XYZ
    found = frame_difference(1.1 * frame, frame)
    assert found.relative.median == pytest.approx(0.1 * D65_XYZ.max(), rel=1e-3)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_frames_with_holes_are_refused(bad):
    frame = np.ones((4, 3))
    broken = frame.copy()
    broken[1, 2] = bad
    with pytest.raises(ValueError, match="NaN"):
        frame_difference(broken, frame)
    with pytest.raises(ValueError, match="shapes"):
        frame_difference(frame[:2], frame)
    with pytest.raises(ValueError, match="no light"):
        frame_difference(frame, 0.0 * frame)


def stub(failing):
    """A stage with a row of each kind and a note, which may fail after them."""

    def measure():
        frame = np.ones((5, 3))
        yield Row("a picture", "nowhere", frame_difference(1.02 * frame, frame), headline=True)
        yield Row("a number", "somewhere", relative=Spread(1e-7, 0.5, 2.0))
        yield Note("a finding " * 30)
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


def test_kasten_young(tools):
    from budget.air import kasten_young

    # Their table 2, for the ISO standard atmosphere; the formula fits it within 0.5 %.
    table = {0: 38.09, 1: 26.26, 5: 10.316, 10: 5.584, 20: 2.904, 30: 1.994, 90: 1.0}
    for altitude, mass in table.items():
        assert kasten_young(altitude) == pytest.approx(mass, rel=5e-3)
    # The formula itself, at the horizon.
    assert kasten_young(0.0) == pytest.approx(37.92, abs=5e-3)


def test_strip_of_the_table_is_that_of_the_reference(tools):
    from budget.strips import reference_strip, strip_angles, strip_rays, strip_scene, table_strip

    theta = strip_angles()[::10]
    rays = strip_rays(theta)
    assert np.abs(np.linalg.norm(rays, axis=1) - 1.0).max() < 1e-12
    scene = strip_scene({"render.wavelength_step_nm": 40.0})
    looked, direct = table_strip(scene, theta), reference_strip(scene, theta)
    # A wrong angle, sun or length of the rays would show at once; the table errs by 0.2 %.
    assert np.abs(looked - direct).max() < 4e-3 * direct.max()


def test_stages_have_names_that_the_command_takes(tools):
    from budget import STAGES

    expected = "theory table wavelength march air float32 storage rain"
    assert list(STAGES) == expected.split()
    assert len({stage.title for stage in STAGES.values()}) == len(STAGES)
