"""The installed wheel works alone: shaders, scenes and data travel in it."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from checkout import ROOT
from rtbow.frames.image import read_exr

pytestmark = pytest.mark.slow


def run(*command, **options):
    done = subprocess.run(
        [sys.executable, *map(str, command)], capture_output=True, text=True, **options
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    # No isolation: the build tools are installed, and tests need no network.
    run("-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT, cwd=folder)
    (path,) = folder.glob("rtbow-*.whl")
    return path


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    folder = tmp_path_factory.mktemp("installed")
    run("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", folder, wheel)
    return folder


@pytest.fixture
def environment(installed, tmp_path):
    # First on the path, before the checkout that an editable install adds; an empty cache, as
    # on a machine that has never run it.
    return {
        **os.environ,
        "PYTHONPATH": str(installed),
        "PYTHONSAFEPATH": "1",
        "RTBOW_CACHE_DIR": str(tmp_path / "cache"),
    }


@pytest.fixture
def empty_folder(tmp_path):
    folder = tmp_path / "empty"
    folder.mkdir()
    return folder


@pytest.mark.parametrize(
    ("folder", "kept_as", "patterns"),
    [
        ("shaders", "rtbow/shaders", ("*.glsl", "*.vert", "*.frag")),
        ("scenes", "rtbow/scenes", ("*.toml", "*.npz", "*.png")),
        ("rtbow/data", "rtbow/data", ("*.csv",)),
        ("rtbow", "rtbow", ("*.py", "py.typed")),
    ],
)
def test_wheel_holds_every_file(wheel, folder, kept_as, patterns):
    source = ROOT / folder
    wanted = {
        f"{kept_as}/{file.relative_to(source).as_posix()}"
        for pattern in patterns
        for file in source.rglob(pattern)
    }
    assert wanted
    assert wanted <= set(zipfile.ZipFile(wheel).namelist())


def test_wheel_holds_nothing_else(wheel):
    tops = {name.split("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"rtbow"}


def test_installed_wheel_is_what_runs(installed, environment, empty_folder):
    code = "import rtbow; print(rtbow.__file__)"
    found = run("-c", code, env=environment, cwd=empty_folder).strip()
    assert Path(found).resolve().is_relative_to(installed.resolve())


def test_installed_wheel_renders_the_default_scene(environment, empty_folder):
    command = ("-m", "rtbow", "render", "-o", "x.exr", "--size", "32x18")
    run(*command, env=environment, cwd=empty_folder)
    assert os.listdir(empty_folder) == ["x.exr"]
    frame, metadata = read_exr(empty_folder / "x.exr")
    assert frame.shape == (18, 32, 3)
    assert np.isfinite(frame).all()
    assert frame.max() > 0.0
    # The frame says how it was made, the scene's text among it.
    assert any("[camera]" in text for text in metadata.values())
