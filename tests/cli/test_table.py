"""``rtbow table``: what it shows, exports and builds."""

from __future__ import annotations

import re

import numpy as np
import OpenEXR
import pytest

from command_line import Result, assert_refused, contents, execute
from rtbow.physics.drop.airy import airy_squared, bow
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.disc import disc_mean


def test_table_build_and_info(call, monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    result = call("table", "info", "--samples", "100")
    assert (result.code, result.err) == (0, "")
    assert re.match(r"near +\d+x\d+x2 +\d+ KiB\nfringe +\d+x2 +\d+ KiB\n", result.out)
    assert result.out.count(" deg: median") == 4
    kept = contents(tmp_path)
    assert len(kept) == 1
    result = call("table", "build")
    assert re.fullmatch(r"airy: built in [\d.]+ s, ready in [\d.]+ s, \d+ KiB\n", result.out)
    assert contents(tmp_path) == kept


RADII_UM = (20.0, 250.0, 1500.0)
WAVES_NM = (400.0, 550.5, 700.0)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """One table, written in both formats."""
    folder = tmp_path_factory.mktemp("table")
    args = ("--radius-um", "20,250,1500", "--wavelength-nm", "400,550.5,700", "--angles", "361")
    for suffix in ("npz", "exr"):
        result = execute("table", "export", f"t.{suffix}", *args, cwd=folder)
        assert result == Result(0, f"t.{suffix}\n", "")
    assert sorted(contents(folder)) == ["t.exr", "t.npz"]
    return folder


def test_exported_arrays(exported):
    with np.load(exported / "t.npz", allow_pickle=False) as table:
        names = ["radius_um", "wavelength_nm", "theta_rad", "perpendicular", "parallel"]
        assert table.files == [*names, "scattering_m2"]
        assert [table[n].dtype for n in names] == ["f8", "f8", "f8", "f4", "f4"]
        assert table["scattering_m2"].shape == (3, 3)
        assert table["perpendicular"].shape == table["parallel"].shape == (3, 3, 361)
        assert tuple(table["radius_um"]) == RADII_UM
        assert tuple(table["wavelength_nm"]) == WAVES_NM
        np.testing.assert_array_equal(table["theta_rad"], np.linspace(0.0, np.pi, 361))


def directly(
    order: int, component: str, radius_m: float, nm: float, theta: float, disc_rad: float
) -> float:
    """Average Airy's intensity over the disc, by quadrature on the sphere."""
    one = np.array([nm])
    b = bow(order, one * 1e-9, relative_index(one, 20.0))
    scale = b.side * b.scale[0] * radius_m ** (2 / 3)
    mean = disc_mean(lambda at: airy_squared(scale * (at - b.angle_rad[0])), theta, disc_rad, 1000)
    return float(getattr(b, component)[0]) * radius_m ** (7 / 3) * float(mean)


@pytest.mark.parametrize("component", ["perpendicular", "parallel"])
def test_exported_values(exported, component):
    """Airy's function averaged over the disc, both bows; 7.0e-4 of the peak off at worst."""
    disc_rad = np.radians(0.5 * 0.533)
    with np.load(exported / "t.npz", allow_pickle=False) as table:
        theta, values = table["theta_rad"], table[component]
    for r, radius_um in enumerate(RADII_UM):
        for w, nm in enumerate(WAVES_NM):
            row = values[r, w]
            for t in (0, 100, 256, 260, 278, int(row.argmax()), 290, 320, 359, 360):
                direct = sum(
                    directly(k, component, radius_um * 1e-6, nm, float(theta[t]), disc_rad)
                    for k in (1, 2)
                )
                assert abs(row[t] - direct) < 1e-3 * row.max()


def test_exported_channels(exported):
    with (
        np.load(exported / "t.npz", allow_pickle=False) as table,
        OpenEXR.File(str(exported / "t.exr"), separate_channels=True) as file,
    ):
        channels = file.channels()
        assert sorted(channels) == sorted(
            f"{name}.{nm}nm" for name in ("perpendicular", "parallel") for nm in (400, 550.5, 700)
        )
        for name in ("perpendicular", "parallel"):
            pixels = channels[f"{name}.550.5nm"].pixels
            assert pixels.dtype == np.float32
            np.testing.assert_array_equal(pixels, table[name][:, 1])
        assert file.header()["radius_um"] == "20,250,1500"
        assert file.header()["discDeg"] == "0.533"


def test_wavelengths_that_lie_close_keep_their_own_channels(call):
    waves = ("--wavelength-nm", "500.00001,500.00002")
    call("table", "export", "t.exr", "--radius-um", "100", *waves, "--angles", "5", "-q")
    with OpenEXR.File("t.exr", separate_channels=True) as file:
        assert len(file.channels()) == 4


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["t.txt"], "must be .npz or .exr"),
        (["t.npz", "--radius-um", "0"], "--radius-um: 0 is not allowed; must be 1..5000"),
        (["t.npz", "--radius-um", "100,nan"], "--radius-um: nan is not allowed"),
        (["t.npz", "--radius-um", "1e400"], "--radius-um: inf is not allowed"),
        (["t.npz", "--radius-um", "500,100"], "--radius-um: 100 follows 500; sort"),
        (["t.npz", "--radius-um", "100,100"], "--radius-um: 100 follows 100"),
        (["t.npz", "--radius-um", "a,b"], "'a,b' is not a list of numbers such as"),
        (["t.npz", "--radius-um", "100,"], "'100,' is not a list of numbers"),
        (["t.npz", "--radius-um="], "'' is not a list of numbers"),
        (["t.npz", "--wavelength-nm", "0.5"], "--wavelength-nm: 0.5 is not allowed; must be 200.."),
        (["t.npz", "--disc", "nan"], "--disc: nan is not allowed; must be 0..5"),
        (["t.npz", "--disc", "6"], "--disc: 6 is not allowed; must be 0..5"),
        (["t.npz", "--disc=-1"], "--disc: -1 is not allowed"),
        (["t.npz", "--disc", "wide"], "--disc"),
        (["t.npz", "--angles", "1"], "--angles"),
        (["t.npz", "--angles", "1000000"], "5.2e+09 values; must be at most 1e+08"),
        (["t.npz", "--theory", "ray"], "ray"),
        (
            ["t.npz", "--theory", "mie", "--spread", "0"],
            "--spread: 0 is not allowed; must be 1..20",
        ),
        (["t.npz", "--theory", "mie", "--spread", "nan"], "--spread: nan"),
        (["t.npz", "--for", "mitsuba"], "must be .xml or .txt"),
        (["t.xml", "--for", "mitsuba"], "--radius-um: gives 64 numbers"),
        (["t.npz", "--spectrum", "E490"], "--spectrum goes with --for texture"),
        (["t.exr", "--for", "texture", "--beyond", "zero"], "--beyond goes with --spectrum"),
        (["t.exr", "--for", "texture", "--spectrum", "E49"], "spectrum 'E49' is not known"),
        (["t.npz", "--spread", "5"], "--spread goes with --theory mie"),
        (["t.npz", "--theory", "mie", "--wavelength-nm", "300"], "300 is not allowed; must be 380"),
        (["out/t.npz"], "there is no folder out"),
        ([], "OUTPUT"),
    ],
)
def test_wrong_exports(call, tmp_path, args, words):
    assert_refused(call("table", "export", *args), words)
    assert contents(tmp_path) == {}


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--spread", "5"], "go with --theory mie"),
        (["--scheduler", "tcp://127.0.0.1:1"], "go with --theory mie"),
        (["--theory", "mie", "--spread", "50"], "--spread: 50 is not allowed; must be 1..20"),
        (["--theory", "mie", "--max-radius-um", "1"], "--max-radius-um: 1 is not allowed"),
        (["--theory", "mie", "--workers", "0"], "--workers"),
    ],
)
def test_wrong_builds(call, tmp_path, args, words):
    assert_refused(call("table", "build", *args), words)
    assert contents(tmp_path) == {}
