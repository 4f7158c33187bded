"""What ``rtbow info`` says of a scene, against figures worked by hand."""

import re

import numpy as np
import pytest

import rtbow
from rtbow.world.rain.volume import DropletVolume, build_volume
from rtbow.world.report import drop_moments, scene_report

BOX = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])


def numbers(report, label):
    """The numbers of a line."""
    line = next(line for line in report.splitlines() if line.startswith(f"{label}:"))
    return [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", line.partition(":")[2])]


def test_drops_of_one_size():
    scene = rtbow.load_scene(
        "uniform",
        {
            "droplets.radius.radius_um": 500.0, "droplets.density.number_per_m3": 1000.0,
            "droplets.box_m": [[-100.0, 100.0, -100.0], [100.0, 600.0, 500.0]],
            "camera.altitude_deg": 0.0, "droplets.extinction_efficiency": 1.0,
            "light.0.irradiance_w_m2": 100.0, "light.0.spectrum": "equal-energy",
        },
    )  # fmt: skip
    report = scene_report(scene)
    assert numbers(report, "number") == [1000.0, 3.0]  # per m3
    assert numbers(report, "liquid water")[0] == pytest.approx(523.6e-3, rel=1e-3)
    # 4.03 m/s (Gunn and Kinzer) of it.
    assert numbers(report, "rain rate")[0] == pytest.approx(0.5236 * 4.03 * 3.6, rel=0.01)
    assert numbers(report, "effective radius") == [500.0, 0.0]
    # 1000 pi (0.5 mm)² = 7.854e-4 per m, twice that and what grazes the edge.
    extinction = numbers(report, "extinction")
    assert extinction[0] == pytest.approx(2.0 * 0.7854, rel=0.01)
    assert 0.7854 in [pytest.approx(n, rel=1e-3) for n in extinction[1:]]
    depth = numbers(report, "optical depth")
    assert depth[1] == pytest.approx(500.0)
    assert depth[2] == pytest.approx(0.3927, rel=1e-3)
    assert depth[0] == pytest.approx(0.3927 * extinction[0] / 0.7854, rel=1e-3)
    # 100 W/m² evenly over 400 nm: 683 · 0.25 · 106.86 lx (the integral of V).
    light = next(line for line in report.splitlines() if line.startswith("light 0"))
    lux = float(re.search(r"(\S+) lx", light)[1])
    assert lux == pytest.approx(683.0 * 0.25 * 106.86, rel=1e-3)
    assert "note" not in report


def test_lamps_and_what_is_left_out():
    scene = rtbow.load_scene(
        "uniform",
        {
            "light": [
                {"type": "point", "position_m": [0.0, -3.0, 5.6], "luminous_flux_lm": 5000.0}
            ],
            "droplets.radius": {
                "distribution": "lognormal", "median_um": 2.0, "log_std": 0.6, "mixing": "local",
            },
            "droplets.density.number_per_m3": 1e6, "scattering.refractive_index": 1.5,
        },
    )  # fmt: skip
    report = scene_report(scene)
    # 5000 lm / 4 pi at 5 m.
    light = next(line for line in report.splitlines() if line.startswith("light 0"))
    assert float(re.search(r"(\S+) lx", light)[1]) == pytest.approx(
        5000.0 / (4.0 * np.pi * 25.0), rel=1e-3
    )
    assert "5000 lm" in light
    assert "index 1.5000" in report
    assert "22.84" in report
    assert "rain rate" not in report  # of beads
    assert "of their number" in report.splitlines()[-1]


def test_a_grid_is_averaged_as_it_is_interpolated():
    number = np.zeros((3, 2, 2), np.float32)
    number[1] = 8.0  # the middle plane, which half of the box belongs to
    radius = np.full((3, 2, 2), 100.0, np.float32)
    drops = drop_moments(DropletVolume(BOX, radius, number))
    assert drops.sum(0) == pytest.approx(4.0)
    assert drops.effective_radius_m == pytest.approx(1e-4)
    assert drop_moments(DropletVolume(BOX, radius, 0.0 * number)) is None


def test_drops_drawn_at_grid_points_have_the_moments_of_the_mixture():
    scene = rtbow.load_scene(
        "figures/fig5f", {"droplets.box_m": BOX.tolist(), "droplets.grid": [40, 40, 40]}
    )
    drawn = drop_moments(build_volume(scene.droplets))
    mixed = drop_moments(
        build_volume(scene.droplets.model_copy(update={
            "grid": None,
            "radius": scene.droplets.radius.model_copy(update={"mixing": "local"}),
        }))
    )  # fmt: skip
    assert drawn.sum(0) == pytest.approx(mixed.sum(0), rel=0.02)
    assert drawn.effective_radius_m == pytest.approx(mixed.effective_radius_m, rel=0.02)
    assert drawn.effective_variance == pytest.approx(mixed.effective_variance, rel=0.05)


def test_air_and_ground_are_told():
    changes = {"atmosphere.aerosol.model": "maritime-clean", "ground.height_m": -20.0}
    report = scene_report(rtbow.load_scene("default", changes))
    air = next(line for line in report.splitlines() if line.startswith("air"))
    for words in ("1013.25 hPa", "300 DU", "maritime-clean, of depth 0.096", "its own light"):
        assert words in air
    ground = next(line for line in report.splitlines() if line.startswith("ground"))
    assert "0.089" in ground
    assert "-20 m" in ground
    bare = scene_report(rtbow.load_scene("uniform", {"atmosphere": None}))
    assert "air:              none" in bare
    assert "ground" not in bare
