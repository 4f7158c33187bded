"""The verb ``rtbow bench``."""

from __future__ import annotations

import json
import re
import sys

import pytest
from click.testing import CliRunner

from rtbow.base.errors import InputError
from rtbow.cli.main import rtbow as command_line


def bench(*args):
    return CliRunner().invoke(command_line, ["bench", *map(str, args)])


def test_the_verb_writes_what_it_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["rtbow", "bench", "uniform"])
    file, plot = tmp_path / "b.json", tmp_path / "b.png"
    result = bench(
        "uniform", "uniform", "--size", "16x9", "--method", "spectral", "--frames", 3,
        "--error-pixels", 40, "--set", "droplets.radius.radius_um=400", "--json", file,
        "--plot", plot,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    (row,) = json.loads(file.read_text("utf-8"))  # one, though it was named twice
    assert row["common"] == {"droplets.radius.radius_um": 400}
    assert row["command"] == "rtbow bench uniform"
    assert plot.stat().st_size > 2000
    lines = result.output.splitlines()
    assert lines[-2:] == [str(file), str(plot)]
    assert any(line.startswith("spectral 5 nm ") for line in lines)
    quiet = bench("uniform", "--size", "8x4", "--method", "spectral", "--error-pixels", 0, "-q")
    assert quiet.output == ""


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("unifrom",), 'no built-in scene named "unifrom"; did you mean uniform'),
        (("unifrom",), "? random-1, random-2 and so on, to random-999999, are drawn at random"),
        (("nope",), ". random-1, random-2 and so on, to random-999999, are drawn at random"),
        (("random-0",), "random-1, random-2 and so on"),
        (("--method", "reference"), "--method reference: cannot be timed; must be "),
        (("--method", "quick"), "--method quick: cannot be timed; must be "),
        (("--method", "spectral", "--max-delta-e", "0.5"), "goes with method fast; add"),
        (("--json", "b.txt"), "must be .json"),
        (("--json", "nowhere/b.json"), "there is no folder nowhere"),
        (("--plot", "b.pdf"), "must be .png or .svg"),
        (("--plot", "b.png", "--error-pixels", "0"), "leave --error-pixels 0 out"),
        (("--scaling", "uniform", "shower"), "--scaling takes one scene, not 2"),
        (("--scaling", "--error-pixels", "3"), "--scaling compares no pixels"),
        (("--scaling-limit-s", "3"), "goes with --scaling; add it"),
        (("--scaling", "--scaling-limit-s", "nan"), "nan: must be a finite number of seconds"),
        (("--scaling", "--scaling-limit-s", "inf"), "inf: must be a finite number of seconds"),
        (("--scaling", "--scaling-limit-s", "0"), "0: must be a finite number of seconds, greater"),
        (("--set", "radius=3"), "unknown key radius"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, args, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(words)):
        command_line.main(["bench", *args], standalone_mode=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("--size", "big"), "is not a size"),
        (("--error-pixels", "-4"), "is not a number of pixels; write 400, 0 for none, or all"),
        (("--frames", "2"), "3<=x<=10000"),
        (("--max-delta-e", "0.5", "--max-delta-e", "0"), "'0' is no error that method fast can"),
        (("--max-delta-e", "nan"), "write a number, 0.25..20"),
        (("plot.png",), "name a .toml file or a built-in scene"),
    ],
)
def test_bad_options(args, words):
    result = bench(*args)
    assert result.exit_code == 2
    assert words in result.output
