"""What method ``fast`` keeps while camera and lights move, and what it makes anew."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

import rtbow
import rtbow.render.fast.light
import rtbow.render.fast.shared
import rtbow.world.steps
from rtbow.base.errors import UnsuitedError
from rtbow.gl.context import GlContext, open_context
from rtbow.render.colours.basis import LightBasis
from rtbow.render.fast.lamp import FastLamp
from rtbow.render.fast.method import FastMethod
from rtbow.render.fast.shared import Plan, plan_world
from rtbow.scene.model import Compare, Scene
from rtbow.world.optics import scene_optics
from rtbow.world.world import moved, resolve

pytestmark = pytest.mark.slow

SUN = {"type": "sun", "altitude_deg": 20.0, "azimuth_deg": 180.0, "spectrum": "FL2"}
LAMP = {"type": "point", "position_m": [0.0, -2.0, 4.0], "luminous_flux_lm": 1e6}


@pytest.fixture(scope="module")
def context() -> Iterator[GlContext]:
    context = open_context("osmesa")
    yield context
    context.close()


def make(*lights: Mapping[str, Any], air: bool = True, camera: Any = ()) -> Scene:
    """Drops of many sizes at each point of a small grid, in a small picture."""
    return Scene.model_validate(
        {
            "camera": {"size_px": [20, 12], "fov_deg": 30.0, "altitude_deg": 20.0} | dict(camera),
            "light": [dict(one) for one in lights],
            "droplets": {
                "box_m": [[-50.0, 10.0, 0.0], [50.0, 90.0, 60.0]],
                "grid": [6, 5, 4],
                "radius": {"distribution": "uniform", "min_um": 5.0, "max_um": 6.0},
                "density": {"number_per_m3": 1e4},
            },
            "atmosphere": {"rayleigh": air},
            "render": {"wavelength_step_nm": 40.0, "max_delta_e": 5.0},
        }
    )


def looking(scene: Scene, azimuth_deg: float) -> Scene:
    camera = scene.camera.model_copy(update={"azimuth_deg": azimuth_deg})
    return scene.model_copy(update={"camera": camera})


def follow(fast: FastMethod, scene: Scene) -> bool:
    """Let the method take over a scene, if that has moved only."""
    world = moved(fast.plan.world, scene)
    return world is not None and fast.move(world)


def lit(scene: Scene, *changes: Mapping[str, Any]) -> Scene:
    lights = [
        one.model_copy(update=dict(new)) for one, new in zip(scene.light, changes, strict=True)
    ]
    return scene.model_copy(update={"light": tuple(lights)})


# --- What follows from the volume alone --------------------------------------------------------


def test_optics_of_moved_lights_are_those_of_their_scene():
    scene = make(SUN, LAMP)
    there = lit(scene, {"altitude_deg": 5.0}, {"position_m": (1.0, 2.0, 3.0)})
    optics = moved(resolve(scene), there).optics
    fresh = scene_optics(there)
    assert optics.bows is not fresh.bows
    for name in ("wavelength_nm", "air_depth", "sun_weights", "lamp_weights"):
        np.testing.assert_array_equal(getattr(optics, name), getattr(fresh, name))
    for ours, theirs in zip(optics.lights, fresh.lights, strict=True):
        for one in fields(ours):
            if one.name != "spectrum":
                np.testing.assert_array_equal(getattr(ours, one.name), getattr(theirs, one.name))


def test_moves_do_not_run_over_the_volume(context, monkeypatch):
    scene = make(SUN, LAMP)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        assert follow(fast, looking(scene, 5.0))
        for module, name in (
            (rtbow.world.steps, "roughness"),
            (rtbow.world.steps, "_unevenness"),
            (rtbow.render.fast.shared, "filled_box"),
            (rtbow.render.fast.shared, "radius_rows"),
            (rtbow.render.fast.shared, "volume_texture"),
        ):
            monkeypatch.setattr(module, name, None)
        for azimuth in (10.0, 20.0):
            assert follow(fast, looking(scene, azimuth))
        assert follow(fast, lit(scene, {"altitude_deg": 18.0}, {"position_m": (1.0, -2.0, 4.0)}))


def test_a_moved_camera_keeps_optics_and_rates():
    scene = make(SUN)
    world = resolve(scene)
    plan = plan_world(world)
    turned = moved(world, looking(scene, 30.0))
    there = plan.moved(turned)
    assert there.world.optics is world.optics
    assert there.rates is plan.rates
    assert there.uniforms["camera.basis"] != plan.uniforms["camera.basis"]
    low = there.moved(moved(turned, lit(looking(scene, 30.0), {"altitude_deg": 2.0})))
    assert low.rates.air_per_metre > plan.rates.air_per_metre
    np.testing.assert_array_equal(low.rates.cells_per_metre, plan.rates.cells_per_metre)


def test_other_scenes_are_not_moves(context):
    scene = make(SUN)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        for other in (make(SUN, air=False), make(SUN | {"spectrum": "E490"}), make(SUN, SUN)):
            assert not follow(fast, other)
        assert follow(fast, make(SUN, camera={"fov_deg": 20.0}))


# --- Lights that cannot move -------------------------------------------------------------------


def baked(monkeypatch: pytest.MonkeyPatch) -> list[LightBasis]:
    """Record the lights that are baked from now on."""
    found: list[LightBasis] = []
    real = rtbow.render.fast.light.outcomes

    def outcomes(gl: Any, drops: Any, light: LightBasis, *rest: Any, **named: Any) -> Any:
        found.append(light)
        return real(gl, drops, light, *rest, **named)

    monkeypatch.setattr(rtbow.render.fast.light, "outcomes", outcomes)
    return found


def test_only_the_light_that_cannot_move_is_made_anew(context, monkeypatch):
    scene = make(SUN, LAMP)
    sunset = lit(scene, {"altitude_deg": -0.05}, {})  # no cubic follows its column: another program
    away = lit(scene, {}, {"position_m": (0.0, -4000.0, 4.0)})  # beyond the lamp's columns of air
    with context.current():
        fast = FastMethod(context, resolve(scene))
        assert follow(fast, looking(scene, 1.0))
        sun, lamp = fast.lights
        found = baked(monkeypatch)
        assert follow(fast, sunset)
        assert fast.lights[0] is not sun
        assert fast.lights[1] is lamp
        assert not found, "what drops make of a sun does not depend on where it is"
        fresh = FastMethod(context, resolve(sunset)).render()
        # 0.2 %, of tables that cover more air.
        np.testing.assert_allclose(fast.render(), fresh, rtol=0.0, atol=3e-3 * fresh.max())
        sun, found[:] = fast.lights[0], []
        assert follow(fast, lit(sunset, {}, {"position_m": (0.0, -3.0, 4.0)}))
        assert fast.lights[0] is sun
        assert follow(fast, lit(away, {"altitude_deg": -0.05}, {}))
        assert fast.lights[0] is sun
        assert fast.lights[1] is not lamp
        assert len(found) == 1


def test_lights_go_back_where_one_cannot_be_drawn(context, monkeypatch):
    scene = make(SUN, LAMP)
    there = lit(looking(scene, 3.0), {"altitude_deg": 9.0}, {"position_m": (9.0, 8.0, 7.0)})
    with context.current():
        fast = FastMethod(context, resolve(scene))
        assert follow(fast, looking(scene, 2.0))
        before = fast.render()
        real = FastLamp.move

        def move(self: FastLamp, plan: Plan) -> bool:
            if plan.world.optics.lamps[0].position_m[0] == 9.0:
                raise UnsuitedError("not there")
            return real(self, plan)

        monkeypatch.setattr(FastLamp, "move", move)
        with pytest.raises(UnsuitedError, match="not there"):
            follow(fast, there)
        np.testing.assert_array_equal(fast.render(), before)
        monkeypatch.undo()
        assert follow(fast, there)
        assert np.abs(fast.render() - before).max() > 0.0


def test_an_eye_so_near_a_wide_lamp_that_no_table_follows_is_refused(context):
    """As a scene that begins there is: what the method promises holds wherever the camera goes."""
    values = make(LAMP | {"diameter_m": 8.0}).model_dump(exclude_none=True)
    values["droplets"]["radius"] = {"distribution": "uniform", "min_um": 200.0, "max_um": 400.0}
    values["light"][0]["position_m"] = [0.0, -2000.0, 4.0]
    values["camera"]["position_m"] = [0.0, 0.0, 1.6]
    values["render"]["max_delta_e"] = 0.5
    scene = Scene.model_validate(values)
    near = scene.model_copy(
        update={"camera": scene.camera.model_copy(update={"position_m": (0.0, -1980.0, 1.6)})}
    )
    with context.current():
        with pytest.raises(UnsuitedError, match="so large a lamp"):
            FastMethod(context, resolve(near))
        fast = FastMethod(context, resolve(scene))
        before = fast.render()
        fast.prepare_moves()
        with pytest.raises(UnsuitedError, match="so large a lamp"):
            follow(fast, near)
        after = fast.render()
    np.testing.assert_allclose(after, before, rtol=1e-2, atol=1e-3 * before.max())


# --- Memory ------------------------------------------------------------------------------------


def test_moves_leave_nothing_on_the_device(context):
    """What moves replace is freed whenever the context is left."""
    scene = make(SUN, LAMP)
    with context.current():
        fast = FastMethod(context, resolve(scene))
    for _ in range(2):
        for altitude in (20.0, 10.0, 5.0, 3.0, 2.0, 1.5, 1.0, 0.5, -0.05):
            with context.current():
                assert follow(fast, lit(scene, {"altitude_deg": altitude}, {}))
            assert not context.ctx.objects
    made = fast.texture_bytes
    with context.current():
        assert follow(fast, lit(scene, {"altitude_deg": 20.0}, {}))
    assert fast.texture_bytes < 1.5 * made


def test_shown_scenes_leave_nothing_on_the_device():
    """A renderer's context is left before the methods of another scene are made."""
    with rtbow.Renderer(make(SUN, LAMP), "osmesa") as renderer:
        waiting = []
        for density in (1e4, 2e4, 3e4, 4e4):
            for method in ("fast", "spectral"):
                renderer.render(method)
            other = make(SUN, LAMP).model_dump(exclude_none=True)
            other["droplets"]["density"]["number_per_m3"] = density
            renderer.show(Scene.model_validate(other))
            waiting.append((renderer.texture_bytes, len(renderer._context.ctx.objects)))
    assert waiting[1:] == [(0, 0)] * 3


# --- Size of the picture -----------------------------------------------------------------------

SMOOTH = {
    "file": None,
    "grid": [6, 5, 4],
    "radius": {"distribution": "constant", "radius_um": 300.0},
}


def sized(scene: Scene, size_px: tuple[int, int], fov_deg: float) -> Scene:
    camera = scene.camera.model_copy(update={"size_px": size_px, "fov_deg": fov_deg})
    return scene.model_copy(update={"camera": camera})


def with_nodes(*lights: Mapping[str, Any]) -> Scene:
    values = make(*lights, camera={"size_px": [96, 54], "fov_deg": 10.0}).model_dump(
        exclude_none=True
    )
    values["render"]["max_delta_e"] = 0.25
    values["droplets"] |= {key: value for key, value in SMOOTH.items() if value is not None}
    return Scene.model_validate(values)


@pytest.mark.slow
@pytest.mark.parametrize("light", [SUN, LAMP])
def test_another_size_keeps_tables_and_programs_and_draws_the_same(context, light):
    scene = with_nodes(light)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        fast.prepare_moves()
        (one,) = fast.lights
        programs = one.marching
        for size, fov in (((48, 27), 10.0), ((120, 60), 10.0), ((96, 54), 35.0)):
            there = sized(scene, size, fov)
            fresh = FastMethod(context, resolve(there))
            fresh.prepare_moves()
            assert follow(fast, there)
            assert fast.lights == [one]
            assert one.marching is programs
            assert one.plan.block == fresh.lights[0].plan.block > 1
            np.testing.assert_array_equal(fast.render(), fresh.render())


def test_pictures_too_coarse_for_nodes_are_made_anew(context):
    scene = with_nodes(SUN)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        assert follow(fast, scene)
        (before,) = fast.lights
        assert follow(fast, sized(scene, (16, 9), 60.0))
        assert fast.lights[0] is not before
        assert fast.lights[0].plan.block == 0


def test_where_a_picture_is_split_is_no_other_scene(context):
    scene = with_nodes(SUN)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        split = scene.model_copy(update={"compare": Compare(split=0.3, right={})})
        assert follow(fast, split)


def test_another_size_alone_needs_no_tables_for_other_places(context):
    scene = with_nodes(SUN)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        table = fast.lights[0].table
        for size in ((48, 27), (61, 34), (160, 90)):
            there = sized(scene, size, scene.camera.fov_deg)
            assert follow(fast, there)
            assert fast.lights[0].table is table
            fresh = FastMethod(context, resolve(there)).render()
            np.testing.assert_allclose(fast.render(), fresh, rtol=1e-2, atol=1e-3 * fresh.max())
        assert follow(fast, sized(scene, (54, 96), scene.camera.fov_deg))
        assert fast.lights[0].table is not table


def test_moves_can_be_prepared(context):
    scene = with_nodes(SUN)
    with context.current():
        fast = FastMethod(context, resolve(scene))
        before = fast.render()
        fast.prepare_moves()
        (one,) = fast.lights
        np.testing.assert_allclose(fast.render(), before, rtol=1e-2, atol=1e-3 * before.max())
        assert follow(fast, looking(scene, 5.0))
        assert fast.lights == [one]
        fast.prepare_moves()
        assert fast.lights == [one]
