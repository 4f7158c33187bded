"""Moments of a scene's drops against the closed forms of whole distributions."""

import os

import numpy as np
import pytest
from scipy.special import erfc, gamma, gammaincc

import rtbow
from rtbow.render.renderer import Renderer
from rtbow.scene.droplets import Density
from rtbow.world.rain.drops import distribution, left_out
from rtbow.world.rain.volume import build_volume, scene_volume


def drops_of(radius, number=None, **more):
    """A scene whose every place has a distribution of radii."""
    overrides = {f"droplets.radius.{key}": value for key, value in radius.items()}
    if number is not None:
        overrides["droplets.density.number_per_m3"] = number
    return rtbow.load_scene("uniform", {**overrides, "droplets.radius.mixing": "local", **more})


def moments(scene):
    """Number, sum of radius² and of radius³ (µm) in a cubic metre."""
    radius = scene.droplets.radius
    sizes = distribution(radius, scene.droplets.density or Density())
    um = 1e6 * sizes.radius_m
    return np.array([sizes.number_per_m3 * (sizes.share @ um**k) for k in (0, 2, 3)])


@pytest.mark.parametrize(
    ("n0", "mu", "rate"), [(1.2e5, 2.5, 5.0), (6e6, 5.0, 8.2), (9e3, 1.0, 2.5), (1e12, 6.0, 450.0)]
)
def test_ulbrichs_gamma(n0, mu, rate):
    scene = drops_of({"distribution": "gamma", "n0": n0, "mu": mu, "lambda_per_mm": rate})
    whole = [n0 * gamma(mu + k + 1) / rate ** (mu + k + 1) * 500.0**k for k in (0, 2, 3)]
    np.testing.assert_allclose(moments(scene), whole, rtol=1e-3)
    assert left_out(scene.droplets.radius) == ""


@pytest.mark.parametrize("mu", [0.0, -0.5, -1.0, -1.5])
def test_what_small_drops_of_ulbrichs_gamma_lack_is_said(mu):
    n0, rate = 5e3, 2.5
    scene = drops_of({"distribution": "gamma", "n0": n0, "mu": mu, "lambda_per_mm": rate})
    whole = [n0 * gamma(mu + k + 1) / rate ** (mu + k + 1) * 500.0**k for k in (2, 3)]
    np.testing.assert_allclose(moments(scene)[1:], whole, rtol=1e-3)
    said = left_out(scene.droplets.radius)
    assert said.endswith("nearly all of their number" if mu <= -1.0 else "% of their number")


@pytest.mark.parametrize(
    ("median_um", "deviation", "said"),
    [
        (10.0, 0.3, ""),
        # Shares of a normal distribution beyond (ln(1/1.2) - k s²) / s, k = 0, 2, 3.
        (1.2, 0.7885, "41 % of their number, 3.5 % of their cross-section area, 0.47 % of"),
        (1000.0, 0.9933, "5.3 % of their number, 64 % of their cross-section area, 91 % of"),
    ],
)
def test_lognormal(median_um, deviation, said):
    radius = {"distribution": "lognormal", "median_um": median_um, "log_std": deviation}
    scene = drops_of(radius, 1e6)
    assert said in left_out(scene.droplets.radius)
    whole = [1e6 * median_um**k * np.exp(0.5 * (k * deviation) ** 2) for k in (0, 2, 3)]
    if said:
        lacking = [float(part.partition(" %")[0]) for part in said.split(", ")]
        lacking += [0.47] if "0.47" in said and len(lacking) < 3 else []
        np.testing.assert_allclose(1.0 - moments(scene) / whole, np.array(lacking) / 100, atol=6e-3)
    else:
        np.testing.assert_allclose(moments(scene), whole, rtol=1e-3)


@pytest.mark.parametrize(
    ("exponent", "variance", "alpha"), [(0.5, 0.528, 1.0), (2.0, 0.1, None), (1.0, 0.45, -0.7778)]
)
def test_modified_gamma(exponent, variance, alpha):
    radius = {
        "distribution": "modified-gamma", "effective_radius_um": 300.0,
        "effective_variance": variance, "exponent": exponent,
    }  # fmt: skip
    number, area, volume = moments(drops_of(radius, 1e3))
    assert volume / area == pytest.approx(300.0, rel=1e-3)
    if alpha is not None:
        # M0 M4 / M2² from the gamma function.
        m = [gamma((alpha + k + 1.0) / exponent) for k in (0, 2, 3)]
        assert volume**2 * 1e3 / area**3 == pytest.approx(m[2] ** 2 * m[0] / m[1] ** 3, rel=5e-3)
    assert number <= 1e3


def test_hansens_gamma_counts_drops_that_are_too_small():
    radius = {"distribution": "gamma", "effective_radius_um": 3.0, "effective_variance": 0.4}
    number, area, volume = moments(drops_of(radius, 1e6))
    # Of the shape k = (1 - 2 v) / v = 0.5 and the scale 1.2 µm: M2 = k (k + 1) 1.2² = 1.08 µm².
    assert number == pytest.approx(1e6 * erfc(np.sqrt(1.0 / 1.2)), rel=1e-3)
    assert area == pytest.approx(1.08e6 * gammaincc(2.5, 1.0 / 1.2), rel=1e-3)
    assert volume == pytest.approx(3.0 * 1.08e6 * gammaincc(3.5, 1.0 / 1.2), rel=1e-3)


def test_draws_at_grid_points_have_the_same_number():
    radius = {"distribution": "gamma", "effective_radius_um": 3.0, "effective_variance": 0.4}
    whole = scene_volume(drops_of(radius, 1e6))
    drawn = scene_volume(
        drops_of(radius, 1e6, **{"droplets.radius.mixing": "per-point", "droplets.grid": [6, 6, 6]})
    )
    assert drawn.number_per_m3[0, 0, 0] == pytest.approx(whole.number_per_m3[0, 0, 0], rel=1e-3)


TABLE = "mid_mm,width_mm,log10_N_per_m3_mm\n" + "\n".join(
    f"{mid},{width},{value}"
    for mid, width, value in [
        (0.312, 0.125, 2.9), (0.437, 0.125, 2.99), (0.562, 0.125, 3.0), (0.812, 0.125, 2.9),
        (1.187, 0.125, 2.7), (1.875, 0.25, 2.0), (2.75, 0.5, 1.0), (4.25, 0.5, -0.8),
    ]
)  # fmt: skip


def test_a_table_has_its_sums(tmp_path):
    path = tmp_path / "parsivel.csv"
    path.write_text(TABLE, encoding="utf-8")
    d, w, log = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    whole = [np.sum(10.0**log * w * (500.0 * d) ** k) for k in (0, 2, 3)]
    scene = drops_of({"distribution": "table", "file": str(path)})
    np.testing.assert_allclose(moments(scene), whole, rtol=1e-3)
    drawn = rtbow.load_scene(
        "uniform",
        {
            "droplets.radius.distribution": "table", "droplets.radius.file": str(path),
            "droplets.radius.mixing": "per-point", "droplets.grid": [20, 20, 20],
        },
    )  # fmt: skip
    volume = build_volume(drawn.droplets)
    assert volume.number_per_m3.mean() == pytest.approx(whole[0], rel=1e-3)
    mean_area = np.mean(volume.number_per_m3 * volume.radius_um.astype(np.float64) ** 2)
    assert mean_area == pytest.approx(whole[1], rel=0.05)


def test_drops_beyond_those_that_can_be_drawn(tmp_path):
    path = tmp_path / "hail.csv"
    path.write_text("diameter_mm,width_mm,number_per_m3_mm\n1,1,9\n12,2,0.5\n", encoding="utf-8")
    scene = drops_of({"distribution": "table", "file": str(path)})
    assert moments(scene)[0] == pytest.approx(9.0, rel=1e-3)
    assert "10 % of their number" in left_out(scene.droplets.radius)
    path.write_text("diameter_mm,width_mm,number_per_m3_mm\n12,2,0.5\n", encoding="utf-8")
    assert moments(scene)[0] == 0.0
    assert "nearly all of their number" in left_out(scene.droplets.radius)


def test_a_table_that_is_wrong_is_named_with_its_key(tmp_path):
    path = tmp_path / "none.csv"
    scene = drops_of({"distribution": "table", "file": str(path)})
    with pytest.raises(rtbow.InputError, match=r"^--set droplets.radius.file: .*csv: .*not fo"):
        scene_volume(scene)


def test_files_are_known_by_what_they_hold(tmp_path):
    path = tmp_path / "sizes.csv"
    path.write_text(TABLE, encoding="utf-8")
    scene = drops_of({"distribution": "table", "file": str(path)})
    with Renderer(scene) as renderer:
        before = renderer._resolved()[0]
        renderer.show(scene)
        assert renderer._resolved()[0] is before
        state = path.stat()
        path.write_text(TABLE.replace("2.99", "1.99"), encoding="utf-8")
        os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))  # as some editors and copies do
        renderer.show(scene)
        after = renderer._resolved()[0]
        assert after.volume.number_per_m3 < before.volume.number_per_m3
        # A camera that moves does not hide it.
        path.write_text(TABLE, encoding="utf-8")
        renderer.show(rtbow.load_scene("uniform", {
            "droplets.radius": {"distribution": "table", "file": str(path)},
            "droplets.density": {}, "camera.azimuth_deg": 3.0,
        }))  # fmt: skip
        assert renderer._resolved()[0].volume.number_per_m3 == before.volume.number_per_m3
        path.unlink()
        renderer.show(scene)
        with pytest.raises(rtbow.InputError, match="not found"):
            renderer.render("reference")


def test_what_is_left_out_is_noted():
    haze = drops_of({"distribution": "lognormal", "median_um": 1.2, "log_std": 0.8}, 1e6)
    with Renderer(haze) as renderer:
        assert len(renderer.notes) == 1
        assert renderer.notes[0].startswith("droplets.radius: drops outside 1..5000 um")
    with Renderer(rtbow.load_scene("fogbow")) as renderer:
        assert renderer.notes == ()
