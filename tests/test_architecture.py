"""The layout's own rules: imports run one way, folders are small, no name repeats its folder."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from checkout import ROOT

PACKAGE = ROOT / "rtbow"

FLOORS = (
    {"base"},
    {"physics", "gl"},
    {"scene", "tables"},
    {"world"},
    {"frames", "reference"},
    {"render"},
    {"sequence", "study", "bench", "view"},
    {"cli"},
)
"""From the ground up; a package may import those of lower floors, and of its own floor none."""

NEVER = {
    "physics": {"gl", "scene"},
    "tables": {"gl", "scene"},
    "world": {"gl"},
    "reference": {"gl"},
    "frames": {"gl"},
    "gl": {"scene", "physics", "tables"},
}
"""Beyond the floors: who must never reach whom, in one step or several."""

MOST_FILES = 10

THOROUGH = ROOT / "tests" / "thorough.txt"


def modules():
    return sorted(path for path in PACKAGE.rglob("*.py") if path.name != "__main__.py")


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def imports() -> dict[str, set[str]]:
    """Every module with those of this package that it imports anywhere, in functions too."""
    known = {name_of(path) for path in modules()}
    found = {}
    for path in modules():
        targets = set()
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                targets |= {alias.name for alias in node.names if alias.name.startswith("rtbow.")}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}: relative imports hide where they lead"
                if node.module == "rtbow" or (node.module or "").startswith("rtbow."):
                    for alias in node.names:
                        inner = f"{node.module}.{alias.name}"
                        targets.add(inner if inner in known else node.module)
        found[name_of(path)] = targets
    return found


def package_of(module: str) -> str:
    return module.split(".")[1] if "." in module else ""


def arrows():
    return [(a, b) for a, targets in imports().items() for b in targets if package_of(a)]


def test_imports_run_downward_only():
    floor = {name: n for n, names in enumerate(FLOORS) for name in names}
    wrong = []
    for importer, imported in arrows():
        a, b = package_of(importer), package_of(imported)
        if a != b and floor[b] >= floor[a]:
            wrong.append(f"{importer} imports {imported}")
    assert not wrong, "\n".join(sorted(wrong))


@pytest.mark.parametrize("package", NEVER)
def test_some_packages_never_reach_others(package):
    reached, waiting = set(), [m for m in imports() if package_of(m) == package]
    while waiting:
        module = waiting.pop()
        if module not in reached:
            reached.add(module)
            waiting.extend(imports().get(module, ()))
    assert not {package_of(m) for m in reached} & NEVER[package]


def test_methods_see_no_scene():
    """What draws takes a world; the renderer alone, which resolves it, knows the scene."""
    seeing = {
        importer
        for importer, imported in arrows()
        if package_of(importer) in ("render", "reference") and package_of(imported) == "scene"
    }
    assert seeing == {"rtbow.render.renderer"}


def test_no_circle_of_modules():
    open_, done = [], set()

    def visit(module):
        if module in done:
            return
        assert module not in open_, " -> ".join([*open_[open_.index(module) :], module])
        open_.append(module)
        for target in sorted(imports().get(module, ())):
            visit(target)
        done.add(open_.pop())

    for module in imports():
        visit(module)


def test_every_package_has_its_floor():
    packages = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert packages <= set.union(*FLOORS)


def folders(root, *suffixes):
    found: dict[Path, list[Path]] = {}
    for suffix in suffixes:
        for path in root.rglob(f"*{suffix}"):
            if path.name not in ("__init__.py", "__main__.py"):
                found.setdefault(path.parent, []).append(path)
    return found


@pytest.mark.parametrize("kind", ["rtbow", "shaders", "tests"])
def test_no_folder_holds_more_than_ten_files(kind):
    crowded = {
        str(folder.relative_to(ROOT)): len(files)
        for folder, files in folders(ROOT / kind, ".py", ".glsl", ".frag", ".vert").items()
        if len(files) > MOST_FILES
    }
    assert not crowded


@pytest.mark.parametrize("kind", ["rtbow", "shaders", "tests"])
def test_no_name_repeats_its_folders(kind):
    wrong = [
        str(path.relative_to(ROOT))
        for folder, files in folders(ROOT / kind, ".py", ".glsl", ".frag", ".vert").items()
        for path in files
        if path.stem.removeprefix("test_").startswith(f"{folder.name}_")
    ]
    assert not wrong


def test_shaders_have_uniforms_in_mains_alone():
    """Functions take what they read as arguments, so that each can be drawn by itself in a test."""
    mains = {"spectral/pixel.glsl"}  # of two files that differ in the theory before it
    wrong = []
    for path in (ROOT / "shaders").rglob("*.glsl"):
        name = str(path.relative_to(ROOT / "shaders"))
        if name not in mains and re.search(r"^\s*uniform\s", path.read_text("utf-8"), re.MULTILINE):
            wrong.append(name)
    assert not wrong


def listed_as_thorough():
    lines = THOROUGH.read_text("utf-8").splitlines()
    return [line for line in lines if line and line[0] != "#"]


@pytest.mark.parametrize("line", listed_as_thorough())
def test_what_is_left_to_thorough_runs_is_a_test(line):
    file, _, name = line.partition("::")
    source = ROOT.joinpath("tests", file).read_text("utf-8")
    assert f"def {name.partition('[')[0]}(" in source
