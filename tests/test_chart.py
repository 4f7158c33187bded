"""Charts: what is drawn is the table's, and what is written says what it shows."""

import re

import numpy as np
import pytest
from click.testing import CliRunner

from rtbow.chart import Setup, lee_raster, profiles
from rtbow.cli import rtbow
from rtbow.colour import xyz_to_rgb
from rtbow.errors import InputError
from rtbow.sections import water_sections


def run(tmp_path, *args):
    result = CliRunner().invoke(rtbow, ["chart", *map(str, args)])
    return result


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
    raster = lee_raster(Setup(("airy", "mie")), (10.0, 600.0), (135.0, 147.0), (12, 60))
    for theory, xyz in raster.relative("column").items():
        assert xyz.shape == (12, 60, 3)
        np.testing.assert_allclose(xyz[..., 1].max(axis=1), 1.0)
        rgb = xyz_to_rgb(xyz[-1])  # 550 µm: red outside, at smaller scattering angles
        share = rgb / rgb.sum(axis=1, keepdims=True)
        bright = xyz[-1, :, 1] > 0.1
        red, blue = (int(np.where(bright, share[:, c], -1.0).argmax()) for c in (0, 2))
        assert red < blue
        # Fogbows are all but white: compare chromaticities where they are bright.
        spread = []
        for column in (0, -1):
            light = xyz[column][xyz[column, :, 1] > 0.5]
            x = light[:, 0] / light.sum(axis=1)
            spread.append(float(x.max() - x.min()))
        assert spread[0] < 0.4 * spread[1], theory


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_charts_are_written(tmp_path, kind):
    for name, args in {
        "profile": ("profile", "--theory", "both", "--difference", "--radius-um", "20,100"),
        "log": ("profile", "--scale", "log"),
        "lee": ("lee", "--theory", "both", "--size", "6x8"),
    }.items():
        path = tmp_path / f"{name}.{kind}"
        result = run(tmp_path, *args, "-o", path)
        assert result.exit_code == 0, result.output
        assert result.output.strip() == str(path)
        assert path.stat().st_size > 2000
    if kind == "svg":
        text = (tmp_path / "profile.svg").read_text("utf-8")
        for words in ("scattering angle, degrees", "angle from the antisolar point", "m² sr⁻¹"):
            assert words in text
        assert "Mie: all light, sizes spread by 2 %" in re.sub(r"\s+", " ", text)
        assert "drop radius, µm" in (tmp_path / "lee.svg").read_text("utf-8")


def test_the_same_numbers_give_the_same_file(tmp_path):
    for name in ("a.svg", "b.svg"):
        run(tmp_path, "profile", "-o", tmp_path / name)
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
