"""The table that ``tools/sky_error`` prints."""

import subprocess
import sys

import pytest

from checkout import ROOT
from skies.check import Check
from sky_error.row import Row, rows_of


def test_numbers_stand_with_their_units_and_bounds():
    assert Row("a share", 0.0123, 0.02).cells() == ("a share", "1.23 %", "2.00 %")
    assert Row("a share", -0.03, 0.02).cells() == ("a share", "-3.00 %, not met", "2.00 %")
    assert Row("a time", 0.5, unit="s").cells() == ("a time", "0.50 s", "")
    assert Row("polarisation", 0.0105, 0.02, "").cells() == ("polarisation", "0.0105", "0.0200")


def test_a_number_that_is_none_meets_no_bound():
    (row,) = rows_of([Check("broken", float("nan"), 0.02)])
    assert not row.holds


def run(*words):
    command = [sys.executable, ROOT / "tools" / "sky_error", *words]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT)


@pytest.mark.slow
def test_parts_are_listed_and_others_refused():
    listed = run("--list")
    assert listed.returncode == 0
    names = [line.split()[0] for line in listed.stdout.splitlines()]
    assert {"molecules", "measured", "cost"} <= set(names)
    refused = run("clouds")
    assert refused.returncode == 2
    assert all(name in refused.stderr for name in ("clouds", *names))
