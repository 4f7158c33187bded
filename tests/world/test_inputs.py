"""Files that a world was made of: noticed when their content changes under the same name."""

from __future__ import annotations

import os

import numpy as np
import pytest

import rtbow
import rtbow.world.inputs
from rtbow.render.renderer import Renderer
from rtbow.world.inputs import InputFile
from rtbow.world.rain.volume import DropletVolume, save_volume
from rtbow.world.world import moved, resolve


@pytest.fixture
def volume(tmp_path, monkeypatch):
    """Write a volume of drops of a radius into one file, in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def write(radius_um: float):
        shape = (2, 2, 2)
        box_m = np.array([[-150.0, 20.0, 0.0], [150.0, 120.0, 110.0]])
        radius, number = np.full(shape, radius_um, np.float32), np.full(shape, 99.0, np.float32)
        save_volume(DropletVolume(box_m, radius, number), tmp_path / "rain.npz")

    return write


def scene(**camera):
    values = {f"camera.{key}": value for key, value in camera.items()}
    size = {"camera.size_px": [24, 14], "droplets": {"file": "rain.npz"}}
    return rtbow.load_scene("uniform", size | values)


class TestFile:
    @pytest.fixture(params=[0, 1 << 20], ids=["by its status", "by its content"])
    def file(self, request, tmp_path, monkeypatch):
        monkeypatch.setattr(rtbow.world.inputs, "_ALWAYS_READ_BYTES", request.param)
        path = tmp_path / "lamp.csv"
        path.write_text("380,1\n780,2\n")
        return path

    def test_another_content_of_the_same_size_and_time(self, file):
        read, status = InputFile.read(str(file)), file.stat()
        assert read.unchanged
        file.write_text("380,2\n780,1\n")
        os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
        assert not read.unchanged

    def test_the_same_content_once_more(self, file):
        read = InputFile.read(str(file))
        other = file.with_suffix(".new")
        other.write_bytes(file.read_bytes())
        other.replace(file)
        assert read.unchanged

    def test_gone_and_come_back(self, file):
        read, content = InputFile.read(str(file)), file.read_bytes()
        file.unlink()
        assert not read.unchanged
        gone = InputFile.read(str(file))
        assert gone.unchanged
        file.write_bytes(content)
        assert read.unchanged
        assert not gone.unchanged

    def test_a_large_one_that_has_rested_is_not_read_again(self, file, monkeypatch):
        monkeypatch.setattr(rtbow.world.inputs, "_ALWAYS_READ_BYTES", 0)
        monkeypatch.setattr(rtbow.world.inputs, "_SETTLED_S", -1.0)
        read = InputFile.read(str(file))
        assert read.settled
        monkeypatch.setattr(rtbow.world.inputs, "file_digest", lambda _: pytest.fail("was read"))
        assert read.unchanged

    @pytest.mark.parametrize("path", ["no/such.csv", "nul\0.csv", "/"])
    def test_what_cannot_be_read(self, path):
        assert InputFile.read(path).unchanged


def test_a_world_moves_while_its_files_stay(volume):
    volume(300.0)
    world = resolve(scene())
    assert moved(world, scene()) is world
    assert moved(world, scene(azimuth_deg=5.0)).volume is world.volume
    volume(200.0)
    assert moved(world, scene()) is None
    assert moved(world, scene(azimuth_deg=5.0)) is None


@pytest.mark.parametrize("method", ["fast", "spectral"])
def test_a_renderer_shows_the_volume_as_it_is(volume, method):
    volume(300.0)
    with Renderer(scene(), "osmesa") as renderer:
        large = renderer.render(method)
        volume(30.0)
        np.testing.assert_array_equal(renderer.render(method), large)  # until it is shown again
        renderer.show(scene())
        small = renderer.render(method)
    with Renderer(scene(), "osmesa") as other:
        np.testing.assert_array_equal(other.render(method), small)
    assert np.abs(small - large).max() > 0.1 * large.max()


@pytest.mark.parametrize("method", ["fast", "reference"])
def test_a_renderer_shows_the_spectrum_as_it_is(tmp_path, method):
    """A lamp that turns from blue to red, in a file of as many bytes."""
    path = tmp_path / "lamp.csv"

    def lamp(peak_nm: float):
        lines = (f"{nm},{np.exp(-(((nm - peak_nm) / 30.0) ** 2)):.6f}" for nm in range(380, 785, 5))
        path.write_text("wavelength_nm,value\n" + "\n".join(lines))
        overrides = {"camera.size_px": [4, 3], "light.0.spectrum": path}
        return rtbow.load_scene("uniform", overrides)

    with Renderer(lamp(450.0), "osmesa") as renderer:
        red, _, blue = renderer.render(method).sum(axis=(0, 1))
        assert red < blue
        renderer.show(lamp(620.0))
        red, _, blue = renderer.render(method).sum(axis=(0, 1))
        assert red > blue
    with Renderer(lamp(450.0), "osmesa") as renderer:
        red, _, blue = renderer.render(method).sum(axis=(0, 1))
        assert red < blue
