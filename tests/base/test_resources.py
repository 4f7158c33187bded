"""The files that travel with the package, in a checkout and in a wheel."""

import tomllib
from pathlib import Path

import pytest

from checkout import ROOT
from rtbow.base import resources
from rtbow.base.errors import UnavailableError
from rtbow.base.resources import resource_dir


def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *folders: str) -> Path:
    for folder in ("rtbow", *folders):
        (tmp_path / folder).mkdir(parents=True, exist_ok=True)
    monkeypatch.setattr(resources, "PACKAGE", tmp_path / "rtbow")
    return tmp_path


def test_this_checkout_has_all_three():
    assert resource_dir("shaders") == ROOT / "shaders"
    assert resource_dir("scenes") == ROOT / "scenes"
    assert resource_dir("data") == ROOT / "rtbow" / "data"


def test_a_wheel_has_them_inside_the_package(tmp_path, monkeypatch):
    folders = [f"rtbow/{kind}" for kind in ("shaders", "scenes", "data")]
    root = package(tmp_path, monkeypatch, *folders)
    for kind in ("shaders", "scenes", "data"):
        assert resource_dir(kind) == root / "rtbow" / kind


def test_a_checkout_has_them_beside_it(tmp_path, monkeypatch):
    root = package(tmp_path, monkeypatch, "scenes", "data")
    (root / "pyproject.toml").touch()
    assert resource_dir("scenes") == root / "scenes"
    with pytest.raises(UnavailableError):
        resource_dir("data")  # never beside the package


def test_another_projects_folder_in_site_packages_is_not_ours(tmp_path, monkeypatch):
    package(tmp_path, monkeypatch, "scenes")
    with pytest.raises(UnavailableError, match=r"has no scenes folder.*pip install"):
        resource_dir("scenes")


def test_the_wheel_is_built_with_these_folders():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    forced = project["tool"]["hatch"]["build"]["targets"]["wheel"]["force-include"]
    assert forced == {"shaders": "rtbow/shaders", "scenes": "rtbow/scenes"}
