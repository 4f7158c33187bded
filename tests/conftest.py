"""Fixtures for every test: contexts, a seeded generator, the command line, images of a failure."""

from __future__ import annotations

import re
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import ArrayLike

import rtbow.cli.main
import rtbow.render.renderer
from command_line import Result
from rtbow.base.cache import FOLDER_VARIABLE, code_dir
from rtbow.gl.context import Backend, GlContext, open_context

if TYPE_CHECKING:
    from panel_driver import Stage

GL_BACKENDS: tuple[Backend, ...] = ("osmesa", "egl")

THOROUGH = Path(__file__).with_name("thorough.txt")
"""Tests that ``make test`` leaves to ``make thorough``."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of that list."""
    if not THOROUGH.exists():  # a copy of this file in a test of failures
        return
    lines = set(THOROUGH.read_text("utf-8").splitlines())
    for item in items:
        name = item.nodeid.removeprefix("tests/")
        if name in lines or name.partition("[")[0] in lines:
            item.add_marker(pytest.mark.thorough)


_call_failed = pytest.StashKey[bool]()


@pytest.fixture(scope="session")
def gl_contexts() -> Iterator[Callable[[Backend], GlContext]]:
    """Open each backend's context at most once in a session; one that does not open is an error."""
    contexts: dict[str, GlContext] = {}

    def get(backend: Backend) -> GlContext:
        if backend not in contexts:
            contexts[backend] = open_context(backend)
        return contexts[backend]

    yield get
    for context in contexts.values():
        context.close()


@pytest.fixture(params=GL_BACKENDS)
def gl(
    request: pytest.FixtureRequest, gl_contexts: Callable[[Backend], GlContext]
) -> Iterator[GlContext]:
    """A context, current for the test, once on OSMesa and once on EGL; no GL error may remain."""
    context = gl_contexts(request.param)
    with context.current() as ctx:
        assert ctx.error == "GL_NO_ERROR", "left by an earlier test"
        yield context
        assert ctx.error == "GL_NO_ERROR"


@pytest.fixture
def egl(gl_contexts: Callable[[Backend], GlContext]) -> Iterator[GlContext]:
    """The EGL context, current for the test; no GL error may remain."""
    context = gl_contexts("egl")
    with context.current() as ctx:
        yield context
        assert ctx.error == "GL_NO_ERROR"


@pytest.fixture
def uniform(egl: GlContext) -> Iterator[Stage]:
    """A panel with all sections open: a sun, drops of one radius, air."""
    from panel_driver import staged

    with staged(egl, "uniform") as stage:
        stage.open_all()
        yield stage


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    """A screen of its own, tall enough for all of the panel, that windows open on; its name."""
    from screen import SCREEN_PX, virtual_screen

    with pytest.MonkeyPatch.context() as patch, virtual_screen(*SCREEN_PX) as name:
        patch.setenv("DISPLAY", name)
        yield name


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator that gives every test the same numbers in every run."""
    return np.random.default_rng(20240607)


@pytest.fixture
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache folder of the test's own that holds compiled code alone, which processes that the
    test starts would be half a minute at otherwise."""
    folder, compiled = tmp_path / "cache", code_dir()
    if compiled.is_dir():
        shutil.copytree(compiled, folder / compiled.name)
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


@pytest.fixture
def call(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Callable[..., Result]:
    """Run the command line in this process and in an empty folder: quick."""
    monkeypatch.chdir(tmp_path)

    def run(*args: str) -> Result:
        monkeypatch.setattr(sys, "argv", ["rtbow", *args])
        with pytest.raises(SystemExit) as stop:
            rtbow.cli.main.main()
        out, err = capsys.readouterr()
        assert isinstance(stop.value.code, int)
        return Result(stop.value.code, out, err)

    return run


@pytest.fixture
def no_rendering(monkeypatch: pytest.MonkeyPatch) -> None:
    """What draws nothing opens no device either."""

    def fail(*_: object) -> None:
        raise AssertionError("opened a renderer")

    monkeypatch.setattr(rtbow.render.renderer.Renderer, "__init__", fail)


@pytest.fixture
def failure_dir(request: pytest.FixtureRequest) -> Path:
    """Where images of failing tests are kept; not made until there is one."""
    return request.config.rootpath / "test-failures"


@pytest.fixture
def save_failure(
    request: pytest.FixtureRequest, failure_dir: Path
) -> Iterator[Callable[[str, ArrayLike, ArrayLike], None]]:
    """Hand in images before they are compared; they are written if the test then fails.

    ``save_failure(name, frame, reference)`` writes ``<test>-<name>-frame.npy``, ``-reference.npy``
    and, where the shapes agree, ``-difference.npy``.
    """
    images: dict[str, tuple[np.ndarray, np.ndarray]] = {}

    def save(name: str, frame: ArrayLike, reference: ArrayLike) -> None:
        images[name] = (np.array(frame), np.array(reference))  # copies: a test may go on with them

    yield save
    if not request.node.stash.get(_call_failed, False):
        return
    for name, (frame, reference) in images.items():
        stem = re.sub(r"[^\w.-]+", "_", f"{request.node.name}-{name}")
        failure_dir.mkdir(parents=True, exist_ok=True)
        np.save(failure_dir / f"{stem}-frame.npy", frame)
        np.save(failure_dir / f"{stem}-reference.npy", reference)
        if frame.shape == reference.shape:
            difference = frame.astype(np.float64) - reference.astype(np.float64)
            np.save(failure_dir / f"{stem}-difference.npy", difference)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """Tell the fixtures whether the test itself failed."""
    outcome = yield
    report = outcome.get_result()
    if report.when == "call":
        item.stash[_call_failed] = report.failed
