"""Keys that change nothing in a scene: left out of the panel until they mean something."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from panel_driver import is_red, staged, value
from rtbow.reference.render import render_reference
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene
from rtbow.view.panel.unused import unused_keys
from rtbow.world.world import resolve

MOON = {"light.0.spectrum": "moon"}
TIMED = MOON | {
    "light.0.time": "2013-05-27T03:46:00Z", "light.0.latitude_deg": 48.0,
    "light.0.longitude_deg": 11.0,
}  # fmt: skip
LOCAL = {
    "droplets.radius": {"distribution": "uniform", "min_um": 200.0, "max_um": 400.0,
                        "mixing": "local"},
}  # fmt: skip
CURTAIN = str(builtin_scenes()["default"].parent / "curtain.npz")
PER_POINT = LOCAL | {"droplets.radius.mixing": "per-point", "droplets.grid": [2, 2, 2]}


def spectrum_csv(folder: Any) -> str:
    path = folder / "lamp.csv"
    path.write_text("".join(f"{nm},{nm / 500}\n" for nm in range(370, 791, 10)))
    return str(path)


INDEX, NO_INDEX = {"scattering.refractive_index": 1.4}, {"scattering.refractive_index": None}
COMING = (
    ("droplets.extinction_efficiency", {}, {"droplets.extinction": True}),
    ("droplets.seed", {}, PER_POINT),
    ("droplets.grid", {}, PER_POINT),
    ("droplets.seed", LOCAL, PER_POINT),
    ("droplets.box_m.0.0", {"droplets.around_m": [900.0, 500.0]},
     {"droplets.box_m": [[-9.0, 1.0, 0.0], [9.0, 9.0, 9.0]]}),
    ("scattering.size_spread", {}, {"scattering.theory": "mie"}),
    ("scattering.orders.1", {"scattering.theory": "mie"}, {"scattering.theory": "airy"}),
    ("scattering.salinity_g_kg", INDEX, NO_INDEX),
    ("scattering.water_temperature_c", INDEX, NO_INDEX),
    ("light.0.moon_phase_deg", {}, MOON),
    ("light.0.moon_distance_km", MOON | {"light.0.irradiance_w_m2": 1.0},
     {"light.0.irradiance_w_m2": None}),
    ("light.0.moon_phase_deg", TIMED, {"light.0.altitude_deg": 20.0}),
    ("light.0.latitude_deg", {}, TIMED),
    ("light.0.beyond", {}, {"light.0.spectrum": "FILE"}),
    ("by date.use", MOON, {"light.0.spectrum": "E490"}),
    ("atmosphere.aerosol.asymmetry", {"atmosphere.aerosol": {}},
     {"atmosphere.aerosol.model": "custom"}),
    ("camera.sensor_mm", {}, {"camera.focal_length_mm": 28.0}),
)  # fmt: skip
"""Keys of the scene ``uniform``, what hides them and what brings them back."""


def test_a_key_comes_back_when_it_means_something(uniform, tmp_path):
    def is_seen(path: str) -> bool:
        uniform.frames(2)
        return path in uniform.seen or f"{path}/on" in uniform.seen

    for path, hidden, shown in COMING:
        changes = {k: spectrum_csv(tmp_path) if v == "FILE" else v for k, v in shown.items()}
        uniform.edits.change(hidden)
        assert not is_seen(path), path
        uniform.edits.change(changes)
        assert is_seen(path), path
        uniform.edits.undo()
        assert not is_seen(path), path
        if hidden:
            uniform.edits.undo()
        assert uniform.edits.scene == uniform.edits.opened.scene


def test_drops_of_a_file_have_no_seed(egl):
    with staged(egl, "shower") as stage:
        assert "droplets.extinction" in stage.seen
        assert "droplets.seed" not in stage.seen


def test_a_value_stays_while_its_key_is_hidden(egl):
    with staged(egl, "uniform", changes={"droplets.seed": 7, **PER_POINT}) as stage:
        assert "droplets.seed" in stage.seen
        stage.edits.change({"droplets.radius.mixing": "local"})
        stage.frames(2)
        assert "droplets.seed" not in stage.seen
        assert value(stage, "droplets.seed") == 7


def test_what_was_refused_stays_in_sight_though_its_key_says_nothing(egl):
    with staged(egl, "uniform", changes=PER_POINT) as stage:
        stage.enter("droplets.seed", "1.5")
        assert is_red(stage, "droplets.seed")
        stage.edits.change({"droplets.radius.mixing": "local"})
        stage.frames(2)
        assert is_red(stage, "droplets.seed")
        stage.panel.forget_refused()
        stage.frames(2)
        assert "droplets.seed" not in stage.seen


def test_what_the_chosen_method_does_not_ask_for_is_left_out(uniform):
    keys = {f"render.{key}" for key in ("wavelength_step_nm", "steps/on", "max_delta_e")}
    for method, unused in (
        ("auto", set()), ("fast", {"render.wavelength_step_nm"}),
        ("spectral", {"render.max_delta_e"}),
        ("reference", {"render.max_delta_e", "render.steps/on"}),
    ):  # fmt: skip
        uniform.state.method = method
        uniform.frames(2)
        assert keys - set(uniform.seen) == unused


def reference(scene: Scene) -> np.ndarray:
    return render_reference(resolve(scene))


@pytest.mark.parametrize(
    ("key", "other", "changes"),
    [
        ("droplets.extinction_efficiency", 2.0, {}),
        ("droplets.seed", 9, LOCAL),
        ("droplets.seed", 9, {"droplets.file": CURTAIN}),
        ("scattering.size_spread", 0.2, {}),
        ("scattering.water_temperature_c", 5.0, {"scattering.refractive_index": 1.4}),
        ("light.0.beyond", "hold", {}),
        ("light.0.moon_distance_km", 360000.0, MOON | {"light.0.irradiance_w_m2": 1.0,
                                                       "light.0.angular_diameter_deg": 0.5}),
        ("render.max_delta_e", 2.0, {}),
        ("render.steps", 3, {}),
    ],
)  # fmt: skip
def test_keys_that_are_left_out_change_no_pixel(key, other, changes):
    small = {"camera.size_px": [8, 5], "render.wavelength_step_nm": 40.0}
    scene = load_scene("uniform", small | changes)
    table, _, name = key.rpartition(".")
    part = scene.light[0] if table == "light.0" else getattr(scene, table)
    assert name in unused_keys(part, "reference")
    before = reference(scene)
    assert before.max() > 0.0
    after = reference(load_scene("uniform", small | changes | {key: other}))
    assert np.allclose(before, after, rtol=1e-12, atol=0.0)


def test_a_grid_of_equal_drops_changes_next_to_nothing():
    small = {"camera.size_px": [8, 5], "render.wavelength_step_nm": 40.0}
    before = reference(load_scene("uniform", small))
    after = reference(load_scene("uniform", small | {"droplets.grid": [4, 4, 4]}))
    assert np.allclose(before, after, rtol=1e-4)
