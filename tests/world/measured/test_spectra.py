"""Spectra: published totals, exact bins, lamps by name, and every way a file can be wrong."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from rtbow.base.errors import InputError
from rtbow.physics.light.colour import colour_matching
from rtbow.physics.light.spectrum import Spectrum, bin_means, colour_weights, wavelength_bins
from rtbow.world.measured.spectra import load_spectrum, spectrum_names

STEPS_NM = [0.5, 1.0, 2.0, 5.0, 8.0, 16.0, 40.0]


def fine_integral(spectrum, low, high, factor=None):
    """Integral on points so dense that straight lines between them are all there is."""
    nm = np.unique(np.concatenate([np.linspace(low, high, 400_001), spectrum.wavelength_nm]))
    nm = nm[(nm >= low) & (nm <= high)]
    value = np.interp(nm, spectrum.wavelength_nm, spectrum.value)
    if factor is not None:
        value = value * np.interp(nm, *factor)
    return trapezoid(value, nm)


class TestE490:
    def test_total_is_the_solar_constant(self):
        sun = load_spectrum("E490")
        assert sun.absolute
        assert sun.integral(0.0, 2e6) == pytest.approx(1366.1, abs=0.06)

    def test_visible_part(self):
        assert load_spectrum("E490").visible == pytest.approx(654.95, abs=0.006)

    def test_illuminance(self):
        weights = colour_weights(load_spectrum("E490"), wavelength_bins(1.0))
        assert weights[:, 1].sum() == pytest.approx(133.3e3, abs=0.05e3)

    def test_colour_is_between_d55_and_d65(self):
        xyz = colour_weights(load_spectrum("E490"), wavelength_bins(5.0)).sum(axis=0)
        x, y = xyz[:2] / xyz.sum()
        assert 0.3127 < x < 0.3324
        assert 0.3290 < y < 0.3474

    def test_points_instead_of_bins_are_wrong_by_percents(self):
        # Its structure is as fine as 1 nm: that is why bins are integrated.
        sun = load_spectrum("E490")
        nm, cmf = colour_matching()
        worst = 0.0
        for step_nm in (5.0, 10.0):
            at = wavelength_bins(step_nm)
            weights = colour_weights(sun, at)
            points = np.interp(at.wavelength_nm, sun.wavelength_nm, sun.value)
            widths = np.diff(at.edges_nm)
            sampled = [
                (points * widths * np.interp(at.wavelength_nm, nm, cmf[:, k])).sum()
                for k in range(3)
            ]
            worst = max(worst, np.abs(np.array(sampled) / weights.sum(axis=0) - 1.0).max())
        # Z by 0.9 % at 5 nm and 2.0 % at 10 nm; single bins by up to 23 %.
        assert 0.015 < worst < 0.025


@pytest.mark.parametrize("name", ["E490", "equal-energy", "FL2", "HP1", "LED-B3"])
@pytest.mark.parametrize("step_nm", STEPS_NM)
def test_bins_conserve_the_integral(name, step_nm):
    spectrum = load_spectrum(name)
    bins = wavelength_bins(step_nm)
    assert bins.wavelength_nm[0] == 380.0
    assert bins.wavelength_nm[-1] == 780.0
    assert len(bins.wavelength_nm) == round(400.0 / step_nm) + 1
    np.testing.assert_allclose(np.diff(bins.wavelength_nm), step_nm)
    weights = colour_weights(spectrum, bins)
    assert weights.shape == (len(bins.wavelength_nm), 3)
    nm, cmf = colour_matching()
    exact = [fine_integral(spectrum, 380.0, 780.0, (nm, cmf[:, k])) for k in range(3)]
    np.testing.assert_allclose(weights.sum(axis=0), exact, rtol=1e-7)


@pytest.mark.parametrize("step_nm", [1.0, 5.0, 40.0])
def test_each_bin_is_its_own_integral(step_nm):
    spectrum = load_spectrum("FL2")
    bins = wavelength_bins(step_nm)
    weights = colour_weights(spectrum, bins)
    nm, cmf = colour_matching()
    for k in (0, 1, len(weights) // 2, len(weights) - 1):
        low, high = bins.edges_nm[k], bins.edges_nm[k + 1]
        assert low <= bins.wavelength_nm[k] <= high
        expected = fine_integral(spectrum, low, high, (nm, cmf[:, 0]))
        assert weights[k, 0] == pytest.approx(expected, rel=1e-6)
        mean = fine_integral(spectrum, low, high) / (high - low)
        assert bin_means(spectrum, bins)[k] == pytest.approx(mean, rel=1e-6)


def test_equal_energy_is_white_of_equal_parts():
    spectrum = load_spectrum("equal-energy")
    assert not spectrum.absolute
    assert spectrum.visible == pytest.approx(400.0)
    x, y, z = colour_weights(spectrum, wavelength_bins(5.0)).sum(axis=0)
    # CIE 1931: chromaticity of E, (1/3, 1/3); the functions' areas are equal to 1e-4.
    assert x / (x + y + z) == pytest.approx(1 / 3, abs=2e-4)
    assert y / (x + y + z) == pytest.approx(1 / 3, abs=2e-4)
    assert y == pytest.approx(683.0 * 106.857, rel=1e-4)  # sum of the function at 1 nm


@pytest.mark.parametrize(
    ("name", "x", "y"),
    # CIE 15:2004, tables T.6.1 and T.8.1, and CIE 15:2018 for the LED.
    [("FL2", 0.3721, 0.3751), ("HP1", 0.533, 0.415), ("LED-B3", 0.3756, 0.3723)],
)
def test_lamps_have_their_published_colour(name, x, y):
    spectrum = load_spectrum(name)
    assert not spectrum.absolute
    got = colour_weights(spectrum, wavelength_bins(5.0)).sum(axis=0)
    np.testing.assert_allclose(got[:2] / got.sum(), (x, y), atol=0.0015)


def test_every_name_loads():
    names = spectrum_names()
    assert {"E490", "equal-energy", "A", "D65", "FL12", "HP5"} <= set(names)
    for name in names:
        spectrum = load_spectrum(name)
        assert spectrum.visible > 0.0
        assert np.all(np.diff(spectrum.wavelength_nm) > 0.0)


def test_scaled_has_the_irradiance_asked_for():
    scaled = load_spectrum("FL2").scaled(3.5)
    assert scaled.absolute
    assert scaled.visible == pytest.approx(3.5)
    shape = scaled.value / load_spectrum("FL2").value
    assert np.ptp(shape[np.isfinite(shape)]) < 1e-12


def test_integral_of_a_triangle():
    triangle = Spectrum("t", np.array([500.0, 510.0, 530.0]), np.array([0.0, 2.0, 0.0]))
    assert triangle.integral(380.0, 780.0) == pytest.approx(30.0)
    assert triangle.integral(500.0, 505.0) == pytest.approx(2.5)
    assert triangle.integral(505.0, 510.0) == pytest.approx(7.5)
    assert triangle.integral(600.0, 700.0) == 0.0


@pytest.mark.parametrize(
    ("wrong", "meant"), [("FL22", "FL2"), ("e490", "E490"), ("led-b3", "LED-B3"), ("hp1", "HP1")]
)
def test_unknown_name_names_the_nearest(wrong, meant):
    with pytest.raises(InputError) as caught:
        load_spectrum(wrong)
    message = str(caught.value)
    assert repr(wrong) in message
    assert meant in message.split("Allowed")[0]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("AM0", "sunlight above the air (AM0) is called E490"),
        ("sun", "is called E490"),
        ("AM1.5", "sunlight at the ground"),
        ("AM1.5G", "sunlight at the ground"),
        ("5800K", "colour temperatures have no names"),
        ("5800 K", "colour temperatures have no names"),
        ("blackbody", "have no names"),
        ("white", "is called equal-energy"),
        ("532nm", "have no names"),
    ],
)
def test_letters_alone_do_not_mislead(wrong, said):
    with pytest.raises(InputError) as caught:
        load_spectrum(wrong)
    assert said in str(caught.value)
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "meant"),
    [("F11", "FL11"), ("CIE D65", "D65"), ("illuminant a", "A"), ("D65K", "D65")],
)
def test_other_names_of_illuminants(wrong, meant):
    with pytest.raises(InputError, match=rf"did you mean {meant}\?"):
        load_spectrum(wrong)


def test_names_of_no_series_have_no_hint():
    with pytest.raises(InputError) as caught:
        load_spectrum("lantern")
    assert "did you mean" not in str(caught.value)


@pytest.mark.parametrize("name", ["none.csv", "none.txt", "none.spdx", "lamps/none", "none#2"])
def test_a_file_that_is_not_there(tmp_path, name):
    path = tmp_path / name
    with pytest.raises(InputError, match="spectrum file not found; check the path") as caught:
        load_spectrum(str(path))
    assert str(caught.value).startswith(str(path).partition("#")[0])


@pytest.mark.parametrize("name", ["lamp", "LAMP.CSV", "lamp.txt", "lamp.with.dots.1"])
def test_any_file_is_read_whatever_its_name(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text("\ufeff# a lamp\r\nnm,v\r\n\r\n380,0\r\n 500.5 , 2e0\r\n780,0\r\n")
    spectrum = load_spectrum(name)
    np.testing.assert_array_equal(spectrum.wavelength_nm, [380.0, 500.5, 780.0])
    np.testing.assert_array_equal(spectrum.value, [0.0, 2.0, 0.0])
    assert not spectrum.absolute


def test_a_known_name_is_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FL2").write_text("380,1\n780,1\n")
    assert load_spectrum("FL2").visible != 400.0


def test_a_folder_is_no_spectrum(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "folder").mkdir()
    for name in ("folder.csv", "folder", "."):
        with pytest.raises(InputError, match="is a folder"):
            load_spectrum(name)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        (b"", None, "holds no spectrum"),
        (b"# nothing\n\n", None, "holds no spectrum"),
        (b"wavelength_nm,value\n", None, "holds no table of numbers"),
        (b"380\n780\n", None, "holds no table of numbers"),
        (b"380,1\n", None, "a single point"),
        (b"380,1\n600,1\n500,1\n780,1\n", 3, "sort"),
        (b"780,1\n500,1\n600,1\n380,1\n", 3, "sort"),
        (b"380,1\n500,1\n500,2\n780,1\n", 3, "sort"),
        (b"380,1\n500,red\n780,1\n", 2, "two numbers"),
        (b"380,1\n500,nan\n780,1\n", 2, "NaN"),
        (b"380,1\n500,inf\n780,1\n", 2, "infinity"),
        (b"380,1\nnan,1\n780,1\n", 2, "NaN"),
        (b"380,1\n500,-0.5\n780,1\n", 2, "negative"),
        (b"-380,1\n500,5\n780,1\n", 1, "no wavelength"),
        (b"380,0\n780,0\n", None, "zero over"),
        (b"300,5\n379,0\n800,0\n", None, "zero over"),
        (b"380,1e-320\n780,0\n", None, "scale the values"),
        (b"380,1e300\n780,1e300\n", None, "scale the values"),
        (b"380,1,2\n780,1,2\n", None, "2 columns of values"),
        (b"380;1\n780;1\n600;1\n", 3, "sort"),
        (b"\x89PNG\r\n\x1a\n\x00\x00\xff\xfe", None, "is not text"),
        (b"380,1\n780,\xff\n", 2, "two numbers"),
        (b"380,1\n500,\x00\n780,1\n", None, "is not text"),
    ],
)
def test_bad_files(tmp_path, text, line, said):
    path = tmp_path / "lamp.csv"
    path.write_bytes(text)
    with pytest.raises(InputError) as caught:
        load_spectrum(str(path))
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: " if line else f"{path}: ")
    assert said in message


@pytest.mark.parametrize(
    ("word", "names"),
    [
        ("sodium", ["HP1", "HP2"]),
        ("Sodium lamp", ["HP1", "HP2"]),
        ("street-lamp", ["HP1", "HP2"]),
        ("LED", ["LED-B3", "LED-B5", "LED-V2"]),
        ("warm white LED", ["LED-B1", "LED-V1", "LED-BH1"]),
        ("mercury vapour", ["HP3", "FL2"]),
        ("candle", ["A"]),
        ("halogen", ["A"]),
        ("metal halide", ["HP3", "HP4", "HP5"]),
        ("daylight", ["D65", "D50"]),
        ("moonlight", ["moon"]),
    ],
)
def test_common_words_lead_to_names(word, names):
    with pytest.raises(InputError) as caught:
        load_spectrum(word)
    _, asked = str(caught.value).split("did you mean ")
    meant = asked.split("?")[0]
    assert [part.split(" (")[0] for part in meant.split(" or ")] == names
    assert {*names} <= {*spectrum_names()}
