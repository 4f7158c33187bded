"""``rtbow info`` of a spectrum, and what scenes take from spectrum files."""

import re

import numpy as np
import pytest
from PIL import Image

from command_line import SMALL, Result, Summary, assert_refused, contents
from lamp_samples import FILE_VALUES, rows
from rtbow.frames.image import read_exr
from rtbow.study.spectra import colour_temperature
from rtbow.world.measured.spectra import spectrum_names


def lines_of(result):
    assert (result.code, result.err) == (0, "")
    return dict(line.split(":", 1) for line in result.out.splitlines() if ":" in line)


def test_a_sun_with_its_unit(call):
    lines = lines_of(call("info", "E490"))
    assert "119.5-1000000 nm, 1697 points" in lines["range"]
    assert "654.946 W/m² over 380-780 nm, illuminance 13331" in lines["irradiance"]


@pytest.mark.parametrize(
    ("name", "kelvin", "duv", "xy"),
    # CIE 15:2004, tables T.1, T.3 and T.8.1; Duv of a black body is 0.
    [("A", 2856, 0.0, (0.4476, 0.4074)), ("D65", 6504, 0.0032, (0.3127, 0.3290)),
     ("FL2", 4230, 0.0019, (0.3721, 0.3751))],
)  # fmt: skip
def test_published_colours(call, name, kelvin, duv, xy):
    lines = lines_of(call("info", name))
    _, x, _, y, *_ = lines["chromaticity"].replace(",", "").split()
    assert (float(x), float(y)) == pytest.approx(xy, abs=3e-4)
    got = colour_temperature(xy)
    assert got == (pytest.approx(kelvin, abs=8), pytest.approx(duv, abs=5e-4))
    assert f"{float(lines['temperature'].split()[0]):.0f}" in lines["temperature"]
    assert float(lines["temperature"].split()[0]) == pytest.approx(kelvin, abs=8)


def test_a_file_and_its_picture(call, tmp_path):
    (tmp_path / "lamp.csv").write_text("wavelength (nm),mW m-2 nm-1\n" + rows())
    result = call("info", "lamp.csv", "-o", "lamp.png")
    lines = lines_of(result)
    assert lines["format"].strip() == "text, columns separated by commas, column 'mW m-2 nm-1'"
    assert lines["abscissa"].strip() == "nm"
    assert lines["range"].strip() == "380-780 nm, 81 points, steps of 5 nm"
    assert lines["irradiance"].strip().startswith("0.197475 W/m²")
    assert result.out.endswith("lamp.png\n")
    with Image.open("lamp.png") as picture:
        assert picture.width > 500
    assert sorted(contents(tmp_path)) == ["lamp.csv", "lamp.png"]


def test_a_file_that_ends_early_is_described(call, tmp_path):
    (tmp_path / "lamp.txt").write_text("400 1\n700 1\n")
    lines = lines_of(call("info", "lamp.txt"))
    assert "beyond: zero or hold" in lines["beyond"]
    assert "not named with its column" in lines["abscissa"]


def test_a_laser_has_no_temperature(call, tmp_path):
    (tmp_path / "laser.csv").write_text("nm,v\n380,0\n531,0\n532,1\n533,0\n780,0\n")
    assert lines_of(call("info", "laser.csv"))["temperature"].strip().startswith("none")


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("nope",), "spectrum 'nope' is not known"),
        (("none.csv",), "spectrum file not found"),
        (("-o", "x.png"), "nothing to draw"),
        (("FL2", "-o", "x.jpg"), "must be .png or .svg"),
    ],
)
def test_wrong_subjects(call, tmp_path, args, words):
    result = call("info", *args)
    assert (result.code, result.out) == (2, "")
    assert words in result.err
    assert contents(tmp_path) == {}


def test_noise_is_told_where_a_scene_takes_the_file(call, tmp_path):
    (tmp_path / "lamp.csv").write_text("nm,v\n" + rows(y=FILE_VALUES - 0.023))
    render = ("render", "uniform", "-o", "x.exr", *SMALL, "--set", "light.0.spectrum=lamp.csv")
    note = "note: lamp.csv: 1 of 81 values are below zero, by 0.00021 of the greatest at most, and"
    assert call(*render).err == Summary("fast", notes=f"{note} are taken as zero\n")
    assert call(*render, "-q") == Result(0, "", "")


def test_beyond_the_range_of_a_file(call, tmp_path):
    """A flat lamp that ends at 600 nm: held, it is the light of equal energy; else it lacks red."""
    (tmp_path / "lamp.csv").write_text("nm,v\n380,1\n600,1\n")
    frames = {}
    for name, sets in {
        "equal": ["spectrum=equal-energy"],
        "hold": ["spectrum=lamp.csv", "beyond=hold"],
        "zero": ["spectrum=lamp.csv", "beyond=zero"],
    }.items():
        args = [arg for text in sets for arg in ("--set", f"light.0.{text}")]
        assert call("render", "uniform", "-o", f"{name}.exr", *SMALL, *args).code == 0
        frames[name] = read_exr(f"{name}.exr")[0]
    np.testing.assert_allclose(frames["hold"], frames["equal"], rtol=1e-5)
    red = {name: frame[..., 0].sum() / frame[..., 2].sum() for name, frame in frames.items()}
    assert red["zero"] < 0.6 * red["equal"]
    result = call("render", "uniform", "-o", "x.exr", *SMALL, "--set", "light.0.spectrum=lamp.csv")
    assert result.code == 2
    result = call("render", "uniform", "-o", "x.exr", *SMALL, "--set", "light.0.beyond=more")
    assert result.code == 2
    assert 'must be one of "zero", "hold"' in result.err


def test_the_list_of_spectra(call):
    result = call("spectra")
    assert (result.code, result.err) == (0, "")
    lines = dict(line.split(maxsplit=1) for line in result.out.splitlines())
    assert lines.keys() == {*spectrum_names()}
    assert lines["HP1"] == "standard high-pressure sodium lamp, 1959 K, Ra 8"
    # CIE 15:2018, tables of fluorescent lamps and LEDs, whose temperatures are rounded.
    for name, kelvin, index in [
        ("A", 2856, 100), ("FL1", 6430, 76), ("FL2", 4230, 64), ("FL4", 2940, 51),
        ("FL7", 6500, 90), ("FL8", 5000, 95), ("FL11", 4000, 83), ("FL12", 3000, 83),
        ("LED-B1", 2733, 82), ("LED-B3", 4103, 85), ("LED-RGB1", 2840, 57),
    ]:  # fmt: skip
        *_, temperature, ra = lines[name].split(", ")
        assert float(temperature.removesuffix(" K")) == pytest.approx(kelvin, abs=8)
        assert ra == f"Ra {index}"
    assert all(re.match(r"[A-Za-z].*, \d+ K, Ra \d+$", text) for text in lines.values())


@pytest.mark.parametrize(
    ("subject", "says"),
    [("shwer", "did you mean shower?"), ("drops.npz", "droplets.file"), ("-", "render alone")],
)
def test_what_is_neither_scene_nor_spectrum_is_told_apart(call, subject, says):
    assert_refused(call("info", subject), says)
