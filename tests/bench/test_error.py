"""Sampled pixels, their reference, and its cache."""

from __future__ import annotations

import ast

import numpy as np
import pytest

from checkout import ROOT
from rtbow.bench.error import (
    REFERENCE_CODE,
    PixelSample,
    colour_error,
    reference_xyz,
    sample_pixels,
)
from rtbow.bench.scaling import write_smooth_volume
from rtbow.physics.light.colour import rgb_to_xyz, xyz_to_rgb
from rtbow.reference.render import render_reference
from rtbow.scene.text.file import load_scene
from rtbow.world.camera.resolve import pixel_directions
from rtbow.world.world import resolve


@pytest.mark.parametrize("size", [(640, 360), (7, 5), (100, 1), (1, 90), (33, 200)])
@pytest.mark.parametrize("count", [1, 3, 17, 34, 400])
def test_a_sample_has_its_count_and_no_pixel_twice(size, count):
    sample = sample_pixels(size, count)
    assert len(sample) == min(count, size[0] * size[1])
    assert len(set(zip(sample.rows, sample.columns, strict=True))) == len(sample)
    assert sample.rows.min() >= 0
    assert sample.columns.min() >= 0
    assert sample.rows.max() < size[1]
    assert sample.columns.max() < size[0]


def test_a_sample_is_spread_evenly_and_the_same_each_time():
    sample = sample_pixels((640, 360), 400)
    for places, side in ((sample.rows, 360), (sample.columns, 640)):
        quarters = np.histogram(places, bins=4, range=(0, side))[0]
        assert quarters.min() >= 80
        assert quarters.max() <= 120
    assert np.array_equal(sample.rows, sample_pixels((640, 360), 400).rows)
    assert sample_pixels((9, 5), None).whole
    assert sample_pixels((9, 5), 1000).describe() == "all 45 pixels"


def test_the_reference_is_that_of_the_whole_frame(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    scene = load_scene("uniform", {"camera.size_px": [12, 7], "render.wavelength_step_nm": 20.0})
    fine = {"camera.size_px": [12, 7], "render.wavelength_step_nm": 1.0}
    whole = render_reference(resolve(load_scene("uniform", fine)))
    sample = sample_pixels((12, 7), 30)
    np.testing.assert_allclose(
        xyz_to_rgb(reference_xyz(scene, sample)), sample.of(whole), rtol=1e-9, atol=1e-9
    )


def test_both_parts_of_a_comparison_have_their_own_reference(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    split = {"split": 0.5, "right": {"droplets.density.number_per_m3": 3000.0}}
    scene = load_scene("uniform", {"camera.size_px": [12, 6], "compare": split})
    plain = load_scene("uniform", {"camera.size_px": [12, 6]})
    sample = sample_pixels((12, 6), None)
    both, one = (reference_xyz(each, sample).reshape(6, 12, 3) for each in (scene, plain))
    np.testing.assert_allclose(both[:, :6], one[:, :6])
    np.testing.assert_allclose(both[:, 6:], 3.0 * one[:, 6:])
    assert one[:, 6:].max() > 0.0


def test_the_reference_is_kept_between_runs(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    calls = []

    def counted(world, rays):
        calls.append(len(rays))
        return np.ones((len(rays), 3))

    monkeypatch.setattr("rtbow.reference.render.radiance_along", counted)
    few, more = sample_pixels((12, 7), 10), sample_pixels((12, 7), 11)
    size = {"camera.size_px": [12, 7]}
    scene = load_scene("uniform", size)
    for _ in range(2):
        reference_xyz(scene, few)
    assert calls == [10]
    # What methods alone read makes no other reference; other pixels and other drops do.
    reference_xyz(load_scene("uniform", {**size, "render.wavelength_step_nm": 10.0}), few)
    assert calls == [10]
    reference_xyz(scene, more)
    reference_xyz(load_scene("uniform", {**size, "droplets.radius.radius_um": 301.0}), few)
    assert calls == [10, 11, 10]


def test_another_volume_of_the_same_name_is_another_reference(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    calls = []
    monkeypatch.setattr(
        "rtbow.reference.render.radiance_along",
        lambda world, rays: calls.append(world) or np.ones((len(rays), 3)),
    )
    path = tmp_path / "drops.npz"
    box = np.array([[-1.0, 1.0, 0.0], [1.0, 2.0, 1.0]])
    changes = {"camera.size_px": [8, 4], "droplets.file": str(path)}
    for side in (2, 3, 3):
        write_smooth_volume(path, side, box)
        reference_xyz(load_scene("uniform", changes), sample_pixels((8, 4), 5))
    assert len(calls) == 2


def imports_of(module: str) -> set[str]:
    """The modules of this package that a module imports anywhere, in functions too."""
    path = ROOT.joinpath(*module.split("."))
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            modules = {name for name in inner if (ROOT / f"{name.replace('.', '/')}.py").exists()}
            found |= modules or {node.module}
    return {name for name in found if name.startswith("rtbow.")}


def test_the_cache_knows_all_code_that_the_reference_runs():
    reached, waiting = set(), {"rtbow.reference.render", "rtbow.bench.error"}
    while waiting:
        module = waiting.pop()
        reached.add(module)
        waiting |= imports_of(module) - reached
    assert "rtbow.world.rain.volume" in reached
    assert "rtbow.tables.mie.direct" in reached
    # What holds no numbers of the reference: a scene's are in the key by their values, and a frame
    # is compared with what the cache gave.
    beside = ("base", "scene", "bench", "frames.difference")
    for module in reached:
        name = module.removeprefix("rtbow.")
        assert any(f"{name}.".startswith(f"{known}.") for known in (*REFERENCE_CODE, *beside)), name


def test_an_exact_reference_follows_the_table_that_ships(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    calls = []
    monkeypatch.setattr(
        "rtbow.reference.render.radiance_along",
        lambda world, rays: calls.append(world) or np.ones((len(rays), 3)),
    )
    table = tmp_path / "table.bin"
    monkeypatch.setattr("rtbow.tables.mie.axes.COMPACT_FILE", table)
    size = {"camera.size_px": [8, 4]}
    exact = load_scene("uniform", {**size, "scattering.theory": "mie"})
    for content in ("one", "other", "other"):
        table.write_text(content)
        reference_xyz(exact, sample_pixels((8, 4), 5))
        reference_xyz(load_scene("uniform", size), sample_pixels((8, 4), 5))
    assert [world.scatterer.theory for world in calls] == ["mie", "airy", "mie"]


def test_a_dark_reference_has_no_error():
    assert colour_error(np.zeros((4, 3)), np.zeros((4, 3))) is None
    # Float32 ends where the dark side of a bow goes on: nobody sees either.
    assert colour_error(np.zeros((4, 3)), np.full((4, 3), 1e-25)) is None
    lit = colour_error(np.full((4, 3), 1e-3), np.zeros((4, 3)))
    assert lit.delta_e.median > 50.0
    same = np.full((4, 3), 2.0)
    assert colour_error(same, rgb_to_xyz(same)).delta_e.worst == 0.0


def test_rays_are_those_of_the_pixels(monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path))
    asked = []
    monkeypatch.setattr(
        "rtbow.reference.render.radiance_along",
        lambda world, rays: asked.append(rays) or np.ones((len(rays), 3)),
    )
    scene = load_scene("uniform", {"camera.size_px": [9, 5], "camera.pixel": "centre"})
    sample = sample_pixels((9, 5), 12)
    reference_xyz(scene, sample)
    expected = pixel_directions(scene.camera)[sample.rows, sample.columns]
    np.testing.assert_array_equal(np.concatenate(asked), expected)


def test_samples_of_frames_are_float64():
    sample = PixelSample((2, 1), np.array([0]), np.array([1]))
    found = sample.of(np.arange(6, dtype=np.float32).reshape(1, 2, 3))
    assert found.dtype == np.float64
    assert found.tolist() == [[3.0, 4.0, 5.0]]
