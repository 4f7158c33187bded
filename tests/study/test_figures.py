"""The figures' command: what is finished stays, what is damaged is made again."""

import json
import re

import pytest

import rtbow
from rtbow.study import figures
from rtbow.study.claims import CLAIMS

pytestmark = pytest.mark.slow

SIZE = (64, 36)
ONLY = ["fig1", "fig5a"]


@pytest.fixture
def rendered(monkeypatch):
    """Names of the scenes rendered so far."""
    names = []
    true_render = rtbow.Renderer.render

    def render(self, *args, **more):
        names.append(self.scene.source_name.removeprefix("figures/"))
        return true_render(self, *args, **more)

    monkeypatch.setattr(rtbow.Renderer, "render", render)
    return names


def test_all_scenes_of_the_paper_are_there():
    assert figures.figure_names() == [
        "fig1", "fig5a", "fig5b", "fig5c", "fig5d", "fig5e", "fig5f", "fig7a", "fig7b", "fig7c",
        "fig8-30", "fig8-20", "fig8-10", "fig9a", "fig9b", "fig9c", "fig9d",
    ]  # fmt: skip
    needed = {name for claim in CLAIMS for name in claim.needs}
    assert needed == set(figures.figure_names())


def test_page_and_numbers(tmp_path, rendered):
    out = tmp_path / "made here"
    figures.make_figures(out, ONLY, SIZE, "osmesa")
    assert rendered == ONLY
    rows = json.loads((out / "figures.json").read_text())
    assert len(rows) == len(CLAIMS)
    by_text = {row["text"]: row for row in rows}
    first = by_text[CLAIMS[0].text]
    assert first["figure"] == "1"
    assert isinstance(first["holds"], bool)
    assert first["measured"]["primary_red_deg"] == pytest.approx(41.3, abs=0.5)
    assert {row["holds"] for row in rows if row["figure"] == "9"} == {None}
    page = (out / "index.html").read_text()
    pictures = re.findall(r'src="([^"]+)"', page)
    assert "fig1.png" in pictures
    assert "fig6.png" in pictures
    assert all((out / picture).is_file() for picture in pictures)
    assert "://" not in page  # opens from disk, with nothing from elsewhere


def test_finished_frames_are_kept_and_others_made(tmp_path, rendered):
    figures.make_figures(tmp_path, ["fig1"], SIZE, "osmesa")
    figures.make_figures(tmp_path, ONLY, SIZE, "osmesa")
    assert rendered == ONLY
    assert "fig1.png" in (tmp_path / "index.html").read_text()
    (tmp_path / "fig1.exr").write_bytes((tmp_path / "fig1.exr").read_bytes()[:500])
    figures.make_figures(tmp_path, ONLY, SIZE, "osmesa")
    assert rendered == [*ONLY, "fig1"]
    figures.make_figures(tmp_path, ["fig5a"], (32, 18), "osmesa")  # another size
    assert rendered == [*ONLY, "fig1", "fig5a"]


def test_an_interrupted_run_goes_on(tmp_path, rendered, monkeypatch):
    write = figures.write_exr

    def interrupted(path, *args):
        if path.name == "fig5a.exr":
            raise KeyboardInterrupt
        write(path, *args)

    monkeypatch.setattr(figures, "write_exr", interrupted)
    with pytest.raises(KeyboardInterrupt):
        figures.make_figures(tmp_path, ONLY, SIZE, "osmesa")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fig1.exr"]
    monkeypatch.setattr(figures, "write_exr", write)
    figures.make_figures(tmp_path, ONLY, SIZE, "osmesa")
    assert rendered == ["fig1", "fig5a", "fig5a"]


def test_bad_requests(tmp_path):
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(rtbow.InputError, match="is a file"):
        figures.make_figures(file, ["fig1"], SIZE)
    with pytest.raises(rtbow.InputError, match=r"--only fig5g: no such figure.*fig5"):
        figures.make_figures(tmp_path / "new", ["fig5g"], SIZE)
    assert not (tmp_path / "new").exists()
