"""Which keys of drops and of what they are made of go together."""

import pytest

import rtbow
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.values import changed_scene, scene_files, scene_text

ULBRICH = {"distribution": "gamma", "n0": 8e3, "mu": 2.0, "lambda_per_mm": 4.0}


def set_on(name, table, **more):
    return rtbow.load_scene(name, {f"droplets.radius.{k}": v for k, v in table.items()} | more)


@pytest.mark.parametrize(
    ("radius", "message"),
    [
        ({"mu": 2.5}, 'does not belong to distribution = "constant", which takes radius_um; leave'),
        ({"distribution": "gamma", "mu": 2.0, "n0": 1.0}, "lambda_per_mm is missing; n0 and mu"),
        ({"distribution": "gamma"}, "effective_radius_um is missing; give a number, such as 10"),
        (ULBRICH | {"effective_variance": 0.1}, "does not go with n0 and mu and lambda_per_mm"),
        (ULBRICH | {"n0": 1e60}, "drops per m³ (m⁻³ mm^(-1-mu) is its unit); must be up to"),
        (ULBRICH | {"lambda_per_mm": 0.4}, "makes an effective radius of 6.25e+03 µm, which must"),
        (ULBRICH | {"mu": -3.0}, "must be greater than -3 and up to 100"),
        ({"distribution": "gamma", "Lambda": 2.0}, "did you mean droplets.radius.lambda_per_mm?"),
        ({"distribution": "table"}, "droplets.radius.file is missing"),
        (
            {
                "distribution": "modified-gamma", "effective_radius_um": 900.0,
                "effective_variance": 0.528, "exponent": 1.0,
            },
            "effective_variance = 0.528; must be up to 0.476 with exponent = 1",
        ),
    ],
)  # fmt: skip
def test_wrong_drops(radius, message):
    with pytest.raises(rtbow.InputError) as caught:
        set_on("uniform", radius, **{"droplets.grid": [4, 4, 4]})
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"refractive_index": 2.1}, "must be 1.2..1.9, relative to air: from 2 on a sphere has no"),
        ({"refractive_index": 1.0}, "must be 1.2..1.9"),
        ({"refractive_index": 1.5, "salinity_g_kg": 5.0}, "leave salinity_g_kg out"),
        ({"salinity_g_kg": 41.0}, "must be 0..40"),
        ({"salinity_g_kg": 5.0, "water_temperature_c": -5.0}, "water_temperature_c of 0..30"),
    ],
)
def test_wrong_media(keys, message):
    with pytest.raises(rtbow.InputError) as caught:
        rtbow.load_scene("uniform", {f"scattering.{key}": value for key, value in keys.items()})
    assert message in str(caught.value)


def test_drops_that_count_themselves_need_no_density(tmp_path):
    scene = set_on("fogbow", {key: ULBRICH[key] for key in ("n0", "mu", "lambda_per_mm")})
    assert scene.droplets.radius.effective_variance is None
    assert scene.droplets.density.number_per_m3 is None
    assert scene_from_text(scene_text(scene)) == scene
    back = changed_scene(
        scene,
        {
            "droplets.radius.effective_radius_um": 10.0, "droplets.radius.effective_variance": 0.1,
            "droplets.density.number_per_m3": 5.0,
        },
    )  # fmt: skip
    assert back.droplets.radius.n0 is None
    with pytest.raises(rtbow.InputError, match="whose drops n0 counts; leave it out"):
        changed_scene(scene, {"droplets.density.number_per_m3": 5.0})


def test_a_table_is_beside_its_scene(tmp_path):
    file = tmp_path / "rain.toml"
    file.write_text(
        "[[light]]\n[droplets]\nbox_m = [[-9, 9, 0], [9, 99, 9]]\n[droplets.radius]\n"
        'distribution = "table"\nfile = "sizes.csv"\n',
        encoding="utf-8",
    )
    scene = rtbow.load_scene(file)
    assert scene.droplets.radius.file == str(tmp_path / "sizes.csv")
    assert scene.droplets.radius.mixing == "local"  # as measured
    assert scene_files(scene) == (str(tmp_path / "sizes.csv"),)
    assert 'file = "sizes.csv"' in scene_text(scene, tmp_path)
    with pytest.raises(rtbow.InputError, match="whose drops its file counts; leave it out"):
        rtbow.load_scene(file, {"droplets.density.number_per_m3": 5.0})
