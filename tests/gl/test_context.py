"""Contexts open, draw, stay apart from each other, close, and say why where they cannot."""

from __future__ import annotations

import ctypes
import gc
import os
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

import moderngl
import numpy as np
import pytest

import rtbow.gl.context
import rtbow.gl.egl
from checkout import ROOT
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.gl.context import BACKENDS, GlContext, open_context, probe_backends
from screen import virtual_screen

HEADLESS = ("egl", "osmesa")
PREAMBLE = """
import numpy as np
from rtbow.gl.context import open_context, probe_backends
from rtbow.base.errors import UnavailableError
from test_context import Painter, interleave
"""


class Painter:
    """Draws a value with a shader into a float texture of its own context."""

    def __init__(self, gl: GlContext) -> None:
        self.gl = gl
        with gl.current() as ctx:
            self.program = ctx.program(
                vertex_shader="""#version 330 core
                void main() {
                    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
                    gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
                }""",
                fragment_shader="""#version 330 core
                uniform float value;
                out vec4 colour;
                void main() { colour = vec4(value, gl_FragCoord.xy, 1.0); }""",
            )
            self.triangle = ctx.vertex_array(self.program, [])
            self.target = ctx.framebuffer([ctx.texture((5, 3), 4, dtype="f4")])

    def draw(self, value: float) -> None:
        self.target.use()
        self.program["value"].value = value
        self.triangle.render(moderngl.TRIANGLES, vertices=3)

    def read(self) -> np.ndarray:
        pixels = np.frombuffer(self.target.read(components=4, dtype="f4"), np.float32)
        return pixels.reshape(3, 5, 4)

    def check(self, value: float) -> None:
        pixels = self.read()
        assert np.all(pixels[..., 0] == np.float32(value))
        assert np.all(pixels[..., 1] == np.arange(5) + 0.5)
        assert np.all(pixels[..., 2] == (np.arange(3) + 0.5)[:, None])
        assert self.gl.ctx.error == "GL_NO_ERROR"


def interleave(contexts: list[GlContext]) -> None:
    """Draw and read with all contexts in turn, one after the other and nested in each other."""
    painters = [Painter(gl) for gl in contexts]
    for turn in range(5):
        for i, painter in enumerate(painters):
            with painter.gl.current():
                painter.draw(10 * turn + i)
        for i, painter in enumerate(painters):
            with painter.gl.current():
                painter.check(10 * turn + i)

    def nest(depth: int) -> None:
        if depth == 3 * len(painters):
            return
        painter = painters[depth % len(painters)]
        with painter.gl.current():
            painter.draw(depth)
            painter.check(depth)
            nest(depth + 1)
            # The deepest visit of this context came last, and this one is current again.
            last = depth % len(painters) + 2 * len(painters)
            painter.check(last if depth != last else depth)
            painter.draw(last)

    nest(0)


def run_python(code: str, **environment: str | None) -> str:
    """Run code in a fresh interpreter; None removes a variable. Returns stdout."""
    env = {**os.environ, **{k: v for k, v in environment.items() if v is not None}}
    for name, value in environment.items():
        if value is None:
            env.pop(name, None)
    here = ROOT / "tests" / "support"
    env["PYTHONPATH"] = os.pathsep.join([str(ROOT), str(here), str(Path(__file__).parent)])
    result = subprocess.run(
        [sys.executable, "-c", PREAMBLE + textwrap.dedent(code)],
        env=env,
        capture_output=True,
        text=True,
        timeout=240,
    )
    assert result.returncode == 0, result.stderr
    assert result.stderr == "", "GLFW and Mesa must print nothing"
    return result.stdout


def resident_bytes() -> int:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


@pytest.fixture(scope="module")
def display() -> Iterator[str]:
    """A screen of its own; xvfb is needed, and a missing one is an error."""
    with virtual_screen() as name:
        yield name


@pytest.mark.parametrize("backend", HEADLESS)
def test_opens_draws_reads_and_closes(backend):
    with open_context(backend) as gl:
        assert gl.backend == backend
        assert gl.renderer
        assert gl.ctx.version_code >= 330
        # The least that OpenGL 3.3 promises: 1024 and 256 texels.
        assert gl.limits.texture_2d >= 1024
        assert gl.limits.texture_3d >= 256
        assert min(gl.limits.viewport) >= 1024
        painter = Painter(gl)
        with gl.current() as ctx:
            assert ctx is gl.ctx
            painter.draw(0.1)
            painter.check(0.1)
    assert gl.closed


@pytest.mark.parametrize("backend", HEADLESS)
def test_close_twice_and_open_again(backend):
    gl = open_context(backend)
    gl.close()
    gl.close()
    with pytest.raises(RtbowError, match=f"the {backend} context is closed"), gl.current():
        pass
    with open_context(backend) as again:
        painter = Painter(again)
        with again.current():
            painter.draw(3.0)
            painter.check(3.0)


@pytest.mark.parametrize("order", [HEADLESS, HEADLESS[::-1], ("egl", "egl", "osmesa", "osmesa")])
def test_contexts_side_by_side(order):
    contexts = [open_context(backend) for backend in order]
    interleave(contexts)
    contexts.pop(0).close()
    interleave(contexts)
    for gl in contexts:
        gl.close()


def test_opening_and_closing_leaves_what_is_current():
    with open_context("egl") as outer:
        painter = Painter(outer)
        with outer.current():
            inner = open_context("osmesa")
            painter.draw(1.0)
            painter.check(1.0)
            interleave([inner])
            painter.draw(2.0)
            inner.close()
            painter.check(2.0)


def test_close_while_current():
    with open_context("osmesa") as outer, outer.current():
        painter = Painter(outer)
        inner = open_context("egl")
        with inner.current():
            inner.close()
        painter.draw(4.0)
        painter.check(4.0)


def test_an_exception_inside_current_detaches():
    with open_context("osmesa") as first, open_context("egl") as second:
        painter = Painter(first)
        with first.current():
            with pytest.raises(KeyError), second.current():
                raise KeyError
            painter.draw(5.0)
            painter.check(5.0)


def test_nothing_is_current_outside():
    osmesa = ctypes.CDLL("libOSMesa.so.8")
    osmesa.OSMesaGetCurrentContext.restype = ctypes.c_void_p
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetCurrentContext.restype = ctypes.c_void_p
    with open_context("osmesa") as first, open_context("egl") as second:
        assert osmesa.OSMesaGetCurrentContext() is None
        assert egl.eglGetCurrentContext() is None
        with first.current():
            assert osmesa.OSMesaGetCurrentContext() is not None
            with second.current():  # OSMesa reads Mesa's common record and would name EGL's
                assert egl.eglGetCurrentContext() is not None
            assert egl.eglGetCurrentContext() is None
        assert osmesa.OSMesaGetCurrentContext() is None


def test_moderngl_default_context_is_left_alone():
    store = moderngl._store
    before = store.default_context
    with open_context("egl"):
        assert store.default_context is before
    assert store.default_context is before


def is_texture(gl: GlContext, name: int) -> bool:
    """Ask GL itself, in the context that is current."""
    if gl.backend == "osmesa":
        osmesa = ctypes.CDLL("libOSMesa.so.8")
        osmesa.OSMesaGetProcAddress.restype = ctypes.c_void_p
        address = osmesa.OSMesaGetProcAddress(b"glIsTexture")
        function = ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(address)
    else:
        function = ctypes.CDLL("libGL.so.1").glIsTexture
        function.restype = ctypes.c_ubyte
    return bool(function(name))


@pytest.mark.parametrize("backend", HEADLESS)
def test_dropped_objects_are_freed_in_their_own_context(backend):
    other = open_context("osmesa" if backend == "egl" else "egl")
    with open_context(backend) as gl, other:
        with gl.current() as ctx:
            texture = ctx.texture((2, 2), 4)
            name = texture.glo
            assert is_texture(gl, name)
        with other.current() as ctx:
            other_texture = ctx.texture((2, 2), 4)
            assert other_texture.glo == name
            del texture  # by its name alone it is the other context's texture
            gc.collect()
            assert is_texture(other, name)
        with gl.current():
            assert is_texture(gl, name)
        with gl.current():  # freed when the last visit ended
            assert not is_texture(gl, name)
        with other.current():
            assert is_texture(other, name)


@pytest.mark.parametrize("backend", HEADLESS)
def test_the_framebuffer_is_bound_again(backend):
    with open_context(backend) as gl:
        painter, other = Painter(gl), Painter(gl)
        with gl.current() as ctx:
            painter.target.use()
            with gl.current():
                other.draw(1.0)
            assert ctx.fbo is painter.target
            with gl.current():
                painter.target.release()  # what was bound before is no more
            ctx.framebuffer([ctx.texture((2, 2), 4)])
            assert ctx.error == "GL_NO_ERROR"


@pytest.mark.parametrize("backend", HEADLESS)
def test_fifty_contexts_do_not_leak(backend):
    def cycle() -> None:
        with open_context(backend) as gl, gl.current() as ctx:
            target = ctx.framebuffer([ctx.texture((512, 512), 4, dtype="f4")])
            target.use()
            target.clear(1.0, 2.0, 3.0, 4.0)
            target.read(dtype="f4")

    for _ in range(5):
        cycle()
    before = resident_bytes()
    for _ in range(50):
        cycle()
    # Each context that stayed would hold the 4 MiB of its texture, 200 MiB in all; Mesa itself
    # grows by about 5 MiB.
    assert resident_bytes() - before < 40 * 2**20


def test_unknown_backend_is_an_input_error():
    with pytest.raises(InputError, match="must be one of auto, egl, osmesa, window"):
        open_context("vulkan")


@pytest.mark.parametrize("value", ["x", "-1", "1.0", "999", "٣"])
def test_wrong_egl_device_is_an_input_error(monkeypatch, value):
    monkeypatch.setenv("RTBOW_EGL_DEVICE", value)
    for backend in ("egl", "auto"):
        with pytest.raises(InputError, match=r"RTBOW_EGL_DEVICE = .*; must be .*; unset it"):
            open_context(backend)
    report = probe_backends()[0]
    assert report.backend == "egl"
    assert not report.ok
    assert "RTBOW_EGL_DEVICE" in report.help


def test_egl_device_by_index(monkeypatch):
    monkeypatch.setenv("RTBOW_EGL_DEVICE", "0")
    monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", "999")
    with open_context("egl") as gl:
        interleave([gl])
    assert os.environ["GLCONTEXT_DEVICE_INDEX"] == "999"


def test_a_later_egl_device_is_taken_where_the_first_fails(monkeypatch):
    create = rtbow.gl.egl._create_egl

    def second_only(index):
        if index == 0:
            raise RuntimeError("eglInitialize failed (0x3001)")
        return create(index - 1)

    monkeypatch.delenv("RTBOW_EGL_DEVICE", raising=False)
    monkeypatch.setattr(rtbow.gl.egl, "_create_egl", second_only)
    with open_context("egl") as gl:
        interleave([gl])


def test_every_egl_device_that_fails_is_listed(monkeypatch):
    def fail(index):
        found = "requested device index 2, but found 2 devices"
        raise RuntimeError("eglInitialize failed (0x3001)" if index < 2 else found)

    monkeypatch.delenv("RTBOW_EGL_DEVICE", raising=False)
    monkeypatch.setattr(rtbow.gl.egl, "_create_egl", fail)
    with pytest.raises(UnavailableError) as caught:
        open_context("egl")
    message = str(caught.value)
    assert "device 0: eglInitialize failed (0x3001); device 1: eglInitialize" in message
    for word in ("RTBOW_EGL_DEVICE", "libgl1-mesa-dri", "container"):
        assert word in message


def test_auto_takes_the_first_that_opens(monkeypatch):
    with open_context() as gl:
        assert gl.backend == "egl"

    def fail(index):
        raise RuntimeError("libEGL.so.1 not loaded")

    monkeypatch.setattr(rtbow.gl.egl, "_create_egl", fail)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with open_context() as gl:
        assert gl.backend == "osmesa"


@pytest.mark.parametrize("backend", ["auto", *BACKENDS])
def test_reasons_and_help_where_nothing_works(backend):
    output = run_python(
        f"""
        import rtbow.gl.osmesa
        rtbow.gl.osmesa._OSMESA_LIBRARIES = ("libOSMesa-that-is-not-there.so",)
        try:
            open_context({backend!r})
        except UnavailableError as error:
            print(error.exit_code, error)
        for report in probe_backends():
            assert not report.ok and report.reason and report.help
        """,
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent",
        DISPLAY=None,
        WAYLAND_DISPLAY=None,
        RTBOW_EGL_DEVICE=None,
    )
    assert output.startswith("3 no OpenGL 3.3 core context here")
    expected = {
        "egl": ("egl: EGL finds no device", "libegl1 libgl1 libgl1-mesa-dri"),
        "window": ("window: no display", "xvfb"),
        "osmesa": ("osmesa: libOSMesa-that-is-not-there.so", "libosmesa6"),
    }
    for name, words in expected.items():
        for word in words:
            assert (word in output) == (backend in ("auto", name)), output


def test_mesa_without_drivers_names_the_package():
    output = run_python(
        """
        try:
            open_context("egl")
        except UnavailableError as error:
            print(error)
        """,
        LIBGL_DRIVERS_PATH="/nonexistent",
        RTBOW_EGL_DEVICE=None,
    )
    assert "eglInitialize failed (0x3001)" in output
    assert "libgl1-mesa-dri" in output


def test_window_on_a_display_that_is_not_there():
    output = run_python(
        """
        try:
            open_context("window")
        except UnavailableError as error:
            print(error)
        """,
        DISPLAY=":9999",
        WAYLAND_DISPLAY=None,
    )
    assert "Failed to open display" in output
    assert "xvfb" in output


def test_window_alone(display):
    output = run_python(
        """
        with open_context("window") as gl:
            assert gl.window
            interleave([gl])
            print(gl.backend, gl.closed)
        with open_context("window") as gl:  # GLFW was terminated and starts again
            interleave([gl])
        import glfw
        glfw.ERROR_REPORTING = "ignore"
        glfw.get_platform()
        print(glfw.get_error()[0] == glfw.NOT_INITIALIZED)
        """,
        DISPLAY=display,
        WAYLAND_DISPLAY=None,
    )
    assert output.split() == ["window", "False", "True"]


def test_all_kinds_side_by_side(display):
    run_python(
        """
        import itertools
        for order in itertools.permutations(["window", "osmesa", "egl"]):
            contexts = [open_context(backend) for backend in order]
            interleave(contexts)
            contexts.pop(0).close()
            interleave(contexts)
            for gl in contexts:
                gl.close()
        with open_context("window") as first, open_context("window") as second:
            interleave([first, second])
            first.close()
            interleave([second])
        """,
        DISPLAY=display,
        WAYLAND_DISPLAY=None,
    )


def test_auto_takes_a_window_where_egl_fails(display):
    output = run_python(
        """
        with open_context() as gl:
            print(gl.backend)
        print([report.ok for report in probe_backends()])
        """,
        __EGL_VENDOR_LIBRARY_FILENAMES="/nonexistent",
        DISPLAY=display,
        WAYLAND_DISPLAY=None,
        RTBOW_EGL_DEVICE=None,
    )
    assert output.split("\n")[:2] == ["window", "[False, True, True]"]


def test_the_window_of_other_code_stays_current(display):
    run_python(
        """
        import glfw, moderngl
        glfw.init()
        glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
        window = glfw.create_window(8, 8, "other", None, None)
        glfw.make_context_current(window)
        ctx = moderngl.create_context()
        for backend in ("egl", "osmesa", "window"):
            with open_context(backend) as gl:
                interleave([gl])
                target = ctx.framebuffer([ctx.texture((2, 2), 4, dtype="f4")])
                target.clear(7.0)
                with gl.current():
                    pass
                assert np.frombuffer(target.read(dtype="f4"), np.float32)[0] == 7.0
            assert ctx.error == "GL_NO_ERROR"
        # GLFW is theirs, and so is the end of it.
        assert glfw.get_current_context()
        glfw.destroy_window(window)
        glfw.terminate()
        """,
        DISPLAY=display,
        WAYLAND_DISPLAY=None,
    )


def test_window_where_glfw_runs_without_a_display(display):
    output = run_python(
        """
        import glfw
        glfw.init_hint(glfw.PLATFORM, glfw.PLATFORM_NULL)
        glfw.init()
        for backend in ("egl", "osmesa"):
            with open_context(backend) as gl:
                interleave([gl])
        try:
            open_context("window")
        except UnavailableError as error:
            print(error)
        glfw.terminate()
        glfw.init_hint(glfw.PLATFORM, glfw.ANY_PLATFORM)
        with open_context("window") as gl:
            interleave([gl])
        """,
        DISPLAY=display,
        WAYLAND_DISPLAY=None,
    )
    assert "null platform" in output
    assert "terminate GLFW" in output


def test_import_is_light():
    output = run_python(
        """
        import subprocess, sys
        code = "import sys, rtbow.gl.context; print({'moderngl', 'glfw'} & set(sys.modules))"
        print(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout)
        """
    )
    assert output.strip() == "set()"
