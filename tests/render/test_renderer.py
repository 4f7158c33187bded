"""The Python API: scenes in, radiance out, and nothing but RtbowErrors."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import moderngl
import numpy as np
import pytest

import rtbow
import rtbow.render.spectral.method
from rtbow.render.renderer import Renderer
from rtbow.render.spectral.method import strips

SMALL = {"camera.size_px": [32, 18]}


@pytest.fixture
def scene():
    return rtbow.load_scene("uniform", SMALL)


@pytest.fixture(params=["egl", "osmesa"])
def renderer(request, scene):
    with Renderer(scene, request.param) as renderer:
        yield renderer


class TestFrame:
    def test_shape_type_and_origin(self, renderer):
        assert renderer.backend == "none"  # opened when first needed
        frame = renderer.render()
        assert frame.shape == (18, 32, 3)
        assert frame.dtype == np.float32
        assert frame.flags.c_contiguous
        assert renderer.method_used == "fast"
        assert renderer.backend in ("egl", "osmesa")
        assert renderer.gl_renderer

    def test_first_row_is_on_top(self, renderer):
        """Looking up by 20 degrees, the lowest rays pass below the box and the highest do not."""
        luminance = renderer.render() @ np.array([0.2126, 0.7152, 0.0722], np.float32)
        assert np.all(luminance[0] > 0.0)
        assert np.all(luminance[-1] == 0.0)

    def test_the_same_every_time(self, renderer):
        np.testing.assert_array_equal(renderer.render(), renderer.render("fast"))
        np.testing.assert_array_equal(renderer.render("spectral"), renderer.render("spectral"))

    def test_near_the_reference(self, renderer, save_failure):
        """What remains is the table's and float32's error: 5.6e-4 of the peak at worst."""
        frame, reference = renderer.render("spectral"), renderer.render("reference")
        save_failure("uniform", frame, reference)
        assert reference.dtype == np.float32
        assert renderer.method_used == "reference"
        assert renderer.gl_renderer == "CPU, float64"
        assert np.abs(frame - reference).max() < 1e-3 * reference.max()

    def test_progress_sees_every_row_once(self, renderer):
        rows: list[int] = []

        def watch(items):
            for item in items:
                rows.append(item)
                yield item

        for method in ("spectral", "reference"):
            rows.clear()
            renderer.render(method, watch)
            assert rows == list(range(18))


def test_why_auto_is_not_fast(scene):
    """It is said of the scene that is shown, and stays said."""
    point = rtbow.load_scene("uniform", SMALL | {"light.0.angular_diameter_deg": 0})
    with Renderer(point) as renderer:
        assert renderer.unsuited == ""
        for method in ("auto", "spectral", "auto"):
            renderer.draw(method)
            assert renderer.method_used == "spectral"
            assert "a point of light" in renderer.unsuited
        renderer.show(scene)
        assert renderer.unsuited == ""
        renderer.draw()
        assert (renderer.method_used, renderer.unsuited) == ("fast", "")
        renderer.show(point)
        renderer.draw()
        assert "a point of light" in renderer.unsuited
        renderer.show(point)
        renderer.draw()
        assert "a point of light" in renderer.unsuited


def test_the_reference_needs_no_gl(scene, monkeypatch):
    def fail(*_):
        raise AssertionError("opened a GL context")

    monkeypatch.setattr("rtbow.gl.context.open_context", fail)
    with Renderer(scene) as renderer:
        renderer.render("reference")
        assert renderer.backend == "none"


def test_renderers_side_by_side(scene):
    other_scene = rtbow.load_scene("uniform", SMALL | {"light.0.altitude_deg": 5})
    with Renderer(scene, "egl") as one, Renderer(other_scene, "osmesa") as other:
        first, second = one.render(), other.render()
        assert np.any(first != second)
        np.testing.assert_array_equal(one.render(), first)
        other.close()
        np.testing.assert_array_equal(one.render(), first)


class TestRefusals:
    def test_after_closing(self, renderer):
        renderer.close()
        renderer.close()
        for method in ("spectral", "reference"):
            with pytest.raises(rtbow.RtbowError, match="closed"):
                renderer.render(method)

    @pytest.mark.parametrize("method", ["quick", "", None, "SPECTRAL"])
    def test_unknown_method(self, scene, method):
        with (
            Renderer(scene) as renderer,
            pytest.raises(rtbow.InputError, match="must be one of auto, fast, spectral, reference"),
        ):
            renderer.render(method)

    @pytest.mark.parametrize("backend", ["vulkan", "", None, ["egl"]])
    def test_unknown_backend(self, scene, backend):
        with pytest.raises(rtbow.InputError, match="must be one of auto, egl, osmesa, window"):
            Renderer(scene, backend)

    @pytest.mark.parametrize("wrong", ["uniform", Path("a.toml"), None, 3, {"camera": {}}])
    def test_what_is_no_scene(self, scene, wrong):
        with pytest.raises(rtbow.InputError, match=r"make one with rtbow\.load_scene") as caught:
            Renderer(wrong)
        if isinstance(wrong, str):
            assert 'load_scene("uniform")' in str(caught.value)
        with Renderer(scene) as renderer:
            with pytest.raises(rtbow.InputError, match=r"make one with rtbow\.load_scene"):
                renderer.show(wrong)
            assert renderer.scene is scene

    def test_sent_to_another_process(self, scene):
        with Renderer(scene) as renderer:
            for send in (pickle.dumps, copy.copy):
                with pytest.raises(rtbow.InputError, match="send its scene"):
                    send(renderer)
        assert pickle.loads(pickle.dumps(scene)) == scene

    @pytest.mark.parametrize("hook", ["progress", "building"])
    def test_a_hook_that_is_no_function(self, scene, hook):
        with (
            Renderer(scene) as renderer,
            pytest.raises(rtbow.InputError, match="must be a function"),
        ):
            renderer.render(**{hook: 3})

    @pytest.mark.parametrize("method", ["fast", "spectral", "reference"])
    @pytest.mark.parametrize(
        "overrides",
        [{"light.0.spectrum": "E491"}, {"droplets.file": "missing.npz"}],
    )
    def test_what_the_scene_names_is_not_there(self, method, overrides):
        scene = rtbow.load_scene("uniform", SMALL | overrides)
        with Renderer(scene) as renderer, pytest.raises(rtbow.InputError):
            renderer.render(method)

    @pytest.mark.parametrize("bad", [np.nan, np.inf])
    def test_a_frame_that_is_not_finite(self, scene, monkeypatch, bad):
        frame = np.zeros((18, 32, 3), np.float32)
        frame[3, 4, 1] = bad
        monkeypatch.setattr(Renderer, "_render_shader", lambda *_: frame)
        with Renderer(scene) as renderer, pytest.raises(rtbow.RtbowError, match="row 3, column 4"):
            renderer.render()

    @pytest.mark.parametrize(
        ("error", "message"),
        [
            (MemoryError(), "not enough memory; render smaller"),
            (
                moderngl.Error("the framebuffer is not complete"),
                r"32 x 18 pixels .*; render smaller",
            ),
        ],
    )
    def test_too_little_memory(self, scene, monkeypatch, error, message):
        def fail(*_):
            raise error

        monkeypatch.setattr(rtbow.render.spectral.method.SpectralMethod, "render", fail)
        with Renderer(scene) as renderer:
            with pytest.raises(rtbow.UnavailableError, match=message):
                renderer.render("spectral")
            monkeypatch.undo()
            renderer.render("spectral")  # and it goes on where there is enough

    def test_load_scene(self, tmp_path):
        endless: dict[str, object] = {}
        endless["camera"] = endless
        for name, overrides in (
            ("nosuch", None),
            (tmp_path, None),
            (tmp_path / "missing.toml", None),
            ("uniform", {"camera.size_px": [0, 5]}),
            ("uniform", {"camera.size": [5, 5]}),
            ("uniform", {"camera.fov_deg": np.nan}),
            ("uniform", {"": 5}),
            (3, None),
            (["uniform"], None),
            (b"uniform", None),
            (rtbow.load_scene("uniform"), None),
            ("uniform", 3),
            ("uniform", "camera.fov_deg=30"),
            ("uniform", [("camera.fov_deg", 30)]),
            ("uniform", {"camera.size_px": "32x18"}),
            ("uniform", {"camera.fov_deg": object()}),
            ("uniform", {"camera": endless}),
        ):
            with pytest.raises(rtbow.InputError):
                rtbow.load_scene(name, overrides)


@pytest.mark.parametrize("height", [1, 2, 5, 18, 1000])
def test_strips_cover_every_row_once(height):
    rows: list[int] = []
    for first, count in strips(height, lambda items: items):
        rows += range(first, first + count)
    assert rows == list(range(height))


def test_only_what_is_public_is_offered():
    for name in rtbow.__all__:
        assert getattr(rtbow, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = rtbow.nothing


def test_more_lights_than_a_shaders_loops_hold_are_refused():
    # Mesa's CPU driver would end the loops early and give a wrong frame without a word.
    suns = [{"altitude_deg": 20.0}] * 8
    scene = rtbow.load_scene(
        "uniform", {"light": suns, "render.wavelength_step_nm": 0.1, "camera.size_px": [4, 4]}
    )
    with (
        rtbow.Renderer(scene, "osmesa") as renderer,
        pytest.raises(rtbow.InputError, match=r"8 lights at 4001 wavelengths.*larger"),
    ):
        renderer.render("spectral")
