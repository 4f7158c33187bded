"""The document that ``tools/performance.py`` writes."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

import performance
from bench_rows import LLVMPIPE, made_up, some_rows, some_scaling_rows
from rtbow.base.errors import InputError
from rtbow.bench.report import write_json


def on_device(row, renderer):
    return replace(row, machine=replace(row.machine, gl_renderer=renderer))


@pytest.mark.slow
def test_the_document_says_what_is_met(tmp_path):
    gpu = on_device(made_up("uniform", "fast", {}, 0.02, 0.3), "NVIDIA H200/PCIe/SSE2")
    files = [tmp_path / "a.json", tmp_path / "b.json"]
    write_json(files[0], some_rows())
    write_json(files[1], [*some_scaling_rows(), made_up("shower", "fast", {}, 8.0, 0.3)])
    output = tmp_path / "docs" / "performance.md"
    written = performance.write_document(performance.read_rows(files), output)
    text = output.read_text("utf-8")
    device = LLVMPIPE
    # uniform: the quickest that keeps the error; speed 1000 / 1.25, floor 1.25.
    assert (
        "| uniform | fast ΔE≤0.5 | 800 (≥ 500): met | 1.25 (≤ 1.5): met | 0.4 (≤ 0.5): met |"
        f" 1.25 | {device} |"
    ) in text
    assert "| shower | fast | 125 (≥ 200): **not met** | 8 (≤ 4): **not met** | 0.3" in text
    assert "| shower with droplets.extinction=true | fast | 222 (≥ 100): met" in text
    assert "0.6 (≤ 0.5): **not met**" in text
    assert "| figures/fig5f | fast | not measured | 20 (≤ 25): met | 0.5 (≤ 1): met |" in text
    assert "| lamp-shower | – | not measured | not measured | not measured |" in text
    assert "## On a GPU\n\nNot measured. No row was drawn on a GPU.\n" in text
    assert "rtbow bench --json a.json" in text
    assert "- downpour, fast: skipped: no filter; leave it out" in text
    assert "- shower, fast, 16: skipped: about 70 s; may take 60 s" in text
    assert "| 4096² | 1 |" in text
    for line in text.splitlines():
        if line.startswith("| ") and not line.startswith(("| ---", "| scene")):
            assert line.endswith((f"| {device} |", "| device |")), line
    for path in written:
        assert path.stat().st_size > 0
        if path.suffix == ".png":
            assert f"]({path.relative_to(output.parent).as_posix()})" in text
    assert len(written) == 3
    write_json(files[1], [gpu])
    performance.write_document(performance.read_rows(files), output)
    text = output.read_text("utf-8")
    assert "### NVIDIA H200/PCIe/SSE2" in text.partition("## On a GPU")[2]
    assert "No row was drawn on a GPU" not in text


def test_later_files_replace_earlier_rows(tmp_path):
    files = [tmp_path / "a.json", tmp_path / "b.json"]
    write_json(files[0], [made_up(ms=3.0), made_up("shower", ms=3.0)])
    write_json(files[1], [made_up(ms=4.0)])
    rows = performance.read_rows(files)
    assert [(row.scene, row.frame_ms) for row in rows] == [("uniform", 4.0), ("shower", 3.0)]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "cannot be read: No such file"),
        ("[", "a.json: Invalid JSON"),
        ("{}", "a.json: Input should be a valid"),
        ("[3]", "a.json: 0: Input should be"),
        # As earlier versions wrote it, with all numbers side by side.
        (
            '[{"scene": "a", "method": "fast", "setting": {}, "common": {}, "size_px": [1, 1]}]',
            "a.json: 0.machine: Field required",
        ),
        ('[{"scene": "uniform"}]', "a.json: 0.method: Field required; give a file that rtbow"),
    ],
)
def test_files_that_are_no_rows(tmp_path, content, words):
    path = tmp_path / "a.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=re.escape(words)):
        performance.read_rows([path])


def test_every_target_is_a_row_of_its_own():
    scenes = [target.scene for target in performance.TARGETS]
    assert len(set(scenes)) == len(scenes) == 6


@pytest.mark.parametrize(
    ("renderer", "gpu"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", False),
        ("softpipe", False),
        ("SWR (LLVM 8.0)", False),
        ("", False),
        ("NVIDIA H200/PCIe/SSE2", True),
        ("Mesa Intel(R) Graphics (ADL GT2)", True),
    ],
)
def test_what_counts_as_a_gpu(renderer, gpu):
    assert performance.on_gpu(on_device(made_up(), renderer)) is gpu
