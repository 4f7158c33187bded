"""The command line as a whole: help, lists, versions, and what the machine lacks."""

from __future__ import annotations

import re

import click
import pytest

import rtbow.cli.main
import rtbow.render.renderer
from command_line import SMALL, Result, Summary, assert_message, assert_refused, contents, execute
from rtbow import __version__
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.resources import resource_dir


def commands(group: click.Group, *names: str):
    for name, command in group.commands.items():
        yield (*names, name), command
        if isinstance(command, click.Group):
            yield from commands(command, *names, name)


VERBS = dict(commands(rtbow.cli.main.rtbow))


@pytest.mark.parametrize("names", [(), *VERBS], ids=" ".join)
def test_help_has_an_example_that_works(call, monkeypatch, names):
    result = call(*names, "--help")
    assert result.code == 0
    assert result.err == ""
    assert result.out.startswith(f"Usage: {' '.join(('rtbow', *names))} ")
    assert call(*names, "-h") == result
    one = re.search(r"Example: rtbow (.*?)\n\n", result.out, re.DOTALL)
    several = re.search(r"Examples:\n(.*?)\n\n", result.out, re.DOTALL)
    examples = (
        [one[1]] if one else re.findall(r"^ +rtbow (.*)", several[1], re.M) if several else []
    )
    assert examples
    # Up to the verb's own function, the example is read as it would be typed.
    for command in VERBS.values():
        if not isinstance(command, click.Group):
            monkeypatch.setattr(command, "callback", lambda **_: None)
    for example in examples:
        args = example.split()
        assert args[: len(names)] == list(names)
        assert call(*args).code == 0


def test_no_verb_shows_the_help(call):
    result = call()
    assert result.code == 0
    assert "Usage: rtbow" in result.out
    assert_refused(call("rendr"), "No such command 'rendr'", "rtbow --help")
    assert_refused(call("table", "exprt"), "No such command 'exprt'", "rtbow table --help")


def test_version(call):
    assert call("--version").out == f"rtbow, version {__version__}\n"


def test_scenes_are_listed_one_line_each(call):
    result = call("scenes")
    assert result.code == 0
    folder = resource_dir("scenes")
    names = sorted(str(p.relative_to(folder))[: -len(".toml")] for p in folder.rglob("*.toml"))
    assert "figures/fig1" in names
    lines = result.out.splitlines()
    assert [line.split()[0] for line in lines] == names
    for line in lines:
        name, _, title = line.partition("  ")
        assert name
        assert len(title.split()) > 3


def test_info(call, monkeypatch, tmp_path):
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(tmp_path / "cache"))
    result = call("info")
    assert (result.code, result.err) == (0, "")
    first, *backends, packages, cache = result.out.splitlines()
    assert first.startswith(f"rtbow {__version__}, Python 3.")
    for backend in ("egl", "osmesa"):
        assert any(re.match(rf"{backend} +works: .+, OpenGL \d\.\d", line) for line in backends)
    assert any(line.startswith("window") for line in backends)
    assert re.search(r"moderngl \d.* numpy \d", packages)
    assert cache == f"cache: {tmp_path / 'cache'}, 0.0 MiB"
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("args", [["--help"], ["render", "--help"], ["--version"], ["nosuch"]])
def test_what_needs_no_numbers_loads_none(tmp_path, args):
    code = """
import atexit, sys
heavy = {"numpy", "scipy", "moderngl", "pydantic", "colour", "OpenEXR", "PIL", "numba", "tqdm"}
atexit.register(lambda: print("LOADED", sorted(heavy & set(sys.modules))))
"""
    assert execute(*args, cwd=tmp_path, code=code).out.endswith("LOADED []\n")


NO_GL = {
    "code": 'import rtbow.gl.osmesa; rtbow.gl.osmesa._OSMESA_LIBRARIES = ("libOSMesa-none.so",)',
    "env": {
        "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent",
        "DISPLAY": "",
        "WAYLAND_DISPLAY": "",
        "RTBOW_EGL_DEVICE": "",
    },
}


def test_without_gl_the_packages_are_named(tmp_path):
    result = execute("render", "uniform", "-o", "x.exr", *SMALL, cwd=tmp_path, **NO_GL)
    assert_message(result, 3, "no OpenGL 3.3 core context here")
    for package in ("libegl1", "libgl1", "libgl1-mesa-dri", "libosmesa6", "xvfb"):
        assert package in result.err
    assert contents(tmp_path) == {}


@pytest.mark.slow
def test_without_gl_the_reference_and_the_rest_work(tmp_path):
    args = ("-o", "x.exr", "--size", "8x5", "--method", "reference")
    result = execute("render", "uniform", *args, cwd=tmp_path, **NO_GL)
    assert result == Result(0, "x.exr\n", Summary("reference"))
    result = execute("info", cwd=tmp_path, **NO_GL)
    assert result.code == 0
    assert result.out.count("does not work") == 3


def test_a_named_backend_that_is_not_there(call, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    result = call("render", "uniform", "-o", "x.exr", *SMALL, "--backend", "window")
    assert_message(result, 3, "backend window", "no display")


def test_too_little_memory(call, tmp_path, monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(rtbow.render.renderer.Renderer, "_render_shader", fail)
    result = call("render", "uniform", "-o", "x.exr")
    assert_message(result, 3, "not enough memory; render smaller")
    assert contents(tmp_path) == {}


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (InputError("storm.toml: wrong"), 2, "rtbow: storm.toml: wrong"),
        (UnavailableError("no display"), 3, "rtbow: no display"),
        (RtbowError("a defect"), 1, "rtbow: a defect"),
        (click.ClickException("no such thing"), 2, "rtbow: no such thing"),
        (click.UsageError("No such verb."), 2, "rtbow: No such verb (see rtbow --help)"),
        (click.Abort(), 130, "interrupted; nothing was left half written"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_how_errors_end(call, monkeypatch, error, code, message):
    def work(**_):
        raise error

    monkeypatch.setattr(rtbow.cli.main.rtbow, "main", work)
    assert call() == Result(code, "", f"{message}\n")


@pytest.mark.parametrize("error", [SystemError("something else"), OSError(2, "gone"), ValueError()])
def test_other_errors_are_defects(monkeypatch, error):
    def call(**_):
        raise error

    monkeypatch.setattr(rtbow.cli.main.rtbow, "main", call)
    with pytest.raises(type(error)):
        rtbow.cli.main.main()


def test_the_end_of_a_file_is_a_defect_and_no_interruption(monkeypatch):
    def work(**_):
        raise EOFError("Ran out of input")

    monkeypatch.setattr(VERBS[("scenes",)], "callback", work)
    monkeypatch.setattr("sys.argv", ["rtbow", "scenes"])
    with pytest.raises(EOFError, match="Ran out"):
        rtbow.cli.main.main()
