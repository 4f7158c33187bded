"""The tool for frames about sunset: it resumes, and puts its section into a document."""

import dusk
from budget.error_budget import DUSK_BEGIN, DUSK_END, section_of, with_section


def measured(case):
    dark = case.altitude_deg < -1.0
    values = {} if dark else {"auto": 0.2 - case.altitude_deg, "spectral": 0.02}
    return dusk.Measured("fast", values, values, 0 if dark else 300,
                         {"reference": 0, "auto": 1, "spectral": 0}, 12.5)  # fmt: skip


def test_a_run_resumes(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(dusk, "measure", lambda case: drawn.append(case) or measured(case))
    cases = [dusk.Case(a) for a in dusk.altitudes(0.0, -2.0, 0.5)]
    first = dusk.each(cases, tmp_path)
    assert len(drawn) == 5
    assert dusk.each(cases, tmp_path) == first
    assert len(drawn) == 5
    lines = first.splitlines()
    assert lines[2] == "| +0.0° | 300 | 12.5 | fast | 0.20 | 0.20 | 0.02 | 0.02 | 1 |"
    assert lines[-1] == "| -2.0° | 0 | 12.5 | fast | – | – | – | – | 1 |"
    # Of a group the worst frame with light, and the sum of the pixels.
    (row,) = dusk.summed([("all", cases)], tmp_path).splitlines()[2:]
    assert row == "| all | 3 of 5 | 3 | 1.20 | 0.02 | 5 |"


def test_section_is_replaced_or_added():
    section = f"{DUSK_BEGIN}\n\nnew\n\n{DUSK_END}"
    bare = "# Error budget\n\ntext\n"
    assert section_of(bare) == ""
    whole = with_section(bare, section)
    assert whole == f"# Error budget\n\ntext\n\n{section}\n"
    assert section_of(whole) == section
    assert with_section(f"a\n{DUSK_BEGIN}\nold\n{DUSK_END}\nb\n", section) == f"a\n{section}\nb\n"
