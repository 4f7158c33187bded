"""Tables on the terminal, and JSON."""

from __future__ import annotations

import json
import math

import pytest

from bench_rows import LLVMPIPE, made_up, some_rows, some_scaling_rows
from rtbow.bench.report import COLUMNS, short, table_lines, write_json


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0"), (12345.6, "12346"), (1.2345, "1.23"), (0.012345, "0.0123"),
     (0.0001234, "1e-04"), (99.6, "99.6"), (999.9, "1000")],
)  # fmt: skip
def test_short_numbers(value, text):
    assert short(value) == text


def test_the_table_fits_a_terminal():
    for rows in (some_rows(), some_scaling_rows()):
        lines = list(table_lines(rows))
        assert max(map(len, lines)) <= COLUMNS
        text = "\n".join(lines)
        assert LLVMPIPE in text
        assert "skipped: " in text
    lines = list(table_lines(some_rows()))
    titles = [line for line in lines if line.startswith("method")]
    assert len(titles) == 3
    assert len(set(titles)) == 1  # columns of all scenes stand in line
    assert any("shower with droplets.extinction=true, 640 × 360" in line for line in lines)
    assert "  fast: skipped: no filter; leave it out" in lines


def test_json_is_whole_rows(tmp_path):
    path = tmp_path / "bench.json"
    path.write_text("old")
    write_json(path, some_rows())
    text = path.read_text("utf-8")
    assert json.loads(text) == json.loads(json.dumps([row.as_json() for row in some_rows()]))
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, [made_up(error=math.nan)])
    assert path.read_text("utf-8") == text
