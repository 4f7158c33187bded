"""Charts: what is drawn is the table's, and what is written says what it shows."""

import re

import numpy as np
import pytest
from click.testing import CliRunner

from rtbow.base.errors import InputError
from rtbow.cli.main import rtbow
from rtbow.physics.light.colour import xyz_to_rgb
from rtbow.study.charts import Setup, profiles
from rtbow.study.lee import lee_raster
from rtbow.tables.sections import water_sections


def run(*args):
    return CliRunner().invoke(rtbow, ["chart", *map(str, args)])


def words_of(path):
    """Give the words that a drawing shows, lines that follow each other joined."""
    shown = re.findall(r"<text[^>]*>([^<]*)</text>", path.read_text("utf-8"))
    return " ".join(" ".join(shown).split())


def test_profiles_are_the_tables():
    data = profiles(Setup(("airy", "mie"), 0.533), (50.0, 300.0), (550.0,), (120.0, 160.0))
    for theory in ("airy", "mie"):
        sections = water_sections(theory, np.array([550.0]), 20.0, (50.0, 300.0))
        k = 2345
        both = sections.sections(
            np.array([300e-6]), np.radians(data.theta_deg[k : k + 1]), np.radians(0.2665)
        )
        assert data.values[theory][1, 0, k] == pytest.approx(both[0, 0, 0].mean(), rel=1e-9)
    assert data.theta_deg[[0, -1]].tolist() == [120.0, 160.0]
    # Exact theory's primary of 300 µm is where Airy's is, within a hundredth of a degree or two.
    peaks = {t: data.theta_deg[data.values[t][1, 0].argmax()] for t in ("airy", "mie")}
    assert peaks["airy"] == pytest.approx(peaks["mie"], abs=0.03)
    assert data.mie_peak[1, 0] == pytest.approx(data.values["mie"][1, 0].max(), rel=1e-4)
    at_peak = data.difference[1, 0][data.values["mie"][1, 0].argmax()]
    assert abs(at_peak) < 0.05


def test_components_are_apart():
    across, along = (
        profiles(Setup(("mie",)), (300.0,), (550.0,), (137.0, 140.0), which).values["mie"].max()
        for which in ("perpendicular", "parallel")
    )
    assert across > 10.0 * along


def test_lee_diagram_has_the_bows_colours():
    # Few radii close together: the Mie table is read for all between them.
    fog, rain = (
        lee_raster(Setup(("airy", "mie")), radii, (135.0, 147.0), (2, 60)).relative("column")
        for radii in ((10.0, 10.5), (490.0, 510.0))
    )
    for theory in ("airy", "mie"):
        assert fog[theory].shape == (2, 60, 3)
        np.testing.assert_allclose(rain[theory][..., 1].max(axis=1), 1.0)
        rgb = xyz_to_rgb(rain[theory][0])  # red outside, at smaller scattering angles
        share = rgb / rgb.sum(axis=1, keepdims=True)
        bright = rain[theory][0, :, 1] > 0.1
        red, blue = (int(np.where(bright, share[:, c], -1.0).argmax()) for c in (0, 2))
        assert red < blue
        # Fogbows are all but white: compare chromaticities where they are bright.
        spread = []
        for column in (fog[theory][0], rain[theory][0]):
            light = column[column[:, 1] > 0.5]
            x = light[:, 0] / light.sum(axis=1)
            spread.append(float(x.max() - x.min()))
        assert spread[0] < 0.4 * spread[1], theory


def test_luminance_per_area_is_kept_between_radii():
    raster = lee_raster(Setup(), (100.0, 400.0), (135.0, 147.0), (2, 60))
    small, large = raster.xyz["airy"][..., 1].max(axis=1)
    shown = raster.relative("none")["airy"][..., 1].max(axis=1)
    # Columns at 141 and 283 um, a factor of 2 apart: area is a factor of 4.
    assert shown[0] / shown[1] == pytest.approx(4.0 * small / large)
    assert shown.max() == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["png", "svg"])
def test_charts_are_written(tmp_path, kind):
    for name, args in {
        "profile": ("profile", "--theory", "both", "--difference", "--radius-um", "20,100"),
        "log": ("profile", "--scale", "log"),
        "lee": (
            "lee",
            "--theory",
            "both",
            "--size",
            "6x8",
            "--radius-from",
            "90",
            "--radius-to",
            "110",
        ),
    }.items():
        path = tmp_path / f"{name}.{kind}"
        result = run(*args, "-o", path)
        assert result.exit_code == 0, result.output
        assert result.output.strip() == str(path)
        assert path.stat().st_size > 2000
    if kind == "svg":
        text = words_of(tmp_path / "profile.svg")
        for words in ("scattering angle, degrees", "angle from the antisolar point", "m² sr⁻¹"):
            assert words in text
        assert "Mie: all light, sizes spread by 2 %" in text
        assert "drop radius, µm" in words_of(tmp_path / "lee.svg")


def test_the_same_numbers_give_the_same_file(tmp_path):
    for name in ("a.svg", "b.svg"):
        run("profile", "-o", tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("profile", "-o", "t.txt"), "must be .png or .svg"),
        (("profile", "-o", "t.png", "--radius-um", "0"), "--radius-um: 0 is not allowed; must"),
        (("profile", "-o", "t.png", "--radius-um", "nan"), "--radius-um: nan is not allowed"),
        (("profile", "-o", "t.png", "--wavelength-nm", "900"), "must be 380..780 nm"),
        (("profile", "-o", "t.png", "--from-deg", "150", "--to-deg", "120"), "range is empty"),
        (("profile", "-o", "t.png", "--disc", "6"), "--disc: 6 is not allowed; must be 0..5"),
        (("profile", "-o", "t.png", "--spread", "0"), "--spread: 0 is not allowed; must be 1..20"),
        (("profile", "-o", "t.png", "--difference"), "needs both theories"),
        (("lee", "-o", "t.png", "--radius-from", "500", "--radius-to", "100"), "range is empty"),
        (("lee", "-o", "t.png", "--size", "1x5"), "must be 2..4000"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, args, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(words)):
        rtbow.main(["chart", *args], standalone_mode=False)
    assert not list(tmp_path.iterdir())
