"""What a scene may say of a camera that shows all directions."""

import pytest

from rtbow import InputError, load_scene, make_scene
from rtbow.scene.model import Camera
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.values import changed_scene, differences, scene_text, values_of
from scene_samples import BASE, problems

ALL = 'camera.projection = "panorama"'
PANORAMA = BASE.replace("size_px = [64, 36]", 'projection = "panorama"')
ON = {"camera.projection": "panorama"}
WRONG = "cannot be given together with"


def with_keys(text):
    """A panorama with further keys of its camera."""
    return PANORAMA.replace("[[light]]", f"{text}\n[[light]]")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("fov_deg = 75", f"camera.fov_deg {WRONG} {ALL}, which shows all directions; leave it out"),
        ("focal_length_mm = 50", f"camera.focal_length_mm {WRONG}"),
        ("focal_length_mm = 50\nsensor_mm = [36, 24]", f"camera.sensor_mm {WRONG}"),
        ("altitude_deg = 10", f"camera.altitude_deg {WRONG}"),
        ("roll_deg = -1", f"camera.roll_deg {WRONG}"),
        ("lens_shift = [0, 0.1]", f"camera.lens_shift {WRONG}"),
        ("look = [90, 5]", f"camera.look = [90, 5]; must have an altitude of 0 with {ALL}"),
        ("size_px = [64, 36]", f"camera.size_px = [64, 36]; must be twice as wide as high with"
         f" {ALL}, such as [64, 32]"),
        ("size_px = [1, 1]", "such as [2, 1]"),
        ("size_px = [33, 33]", "such as [32, 16]"),
        ("size_px = [64]", "camera.size_px = [64]; must be"),
        ("altitude_deg = true", "camera.altitude_deg"),
    ],
)  # fmt: skip
def test_what_does_not_go_with_it(text, says):
    assert any(says in line for line in problems(with_keys(text)))


def test_what_goes_with_it():
    text = "altitude_deg = 0\nroll_deg = 0.0\nlens_shift = [0, 0]\nazimuth_deg = 9\npixel = 'area'"
    camera = scene_from_text(with_keys(text)).camera
    assert camera.whole_sphere
    assert camera.size_px == (1280, 640)
    assert camera.altitude_deg == 0.0
    assert camera.azimuth_deg == 9.0
    assert Camera(projection="panorama").altitude_deg == 0.0
    assert not Camera().whole_sphere
    (line,) = problems(PANORAMA.replace('"panorama"', '"sphere"'))
    assert 'must be one of "perspective", "panorama"' in line


def test_an_override_drops_what_only_a_lens_has():
    for name in ("default", "figures/fig1", "street-lamp", "whole-sky"):
        camera = load_scene(name, ON).camera
        assert camera.size_px[0] == 2 * camera.size_px[1]
        assert camera.azimuth_deg == load_scene(name).camera.azimuth_deg
    assert load_scene("default", ON).camera.size_px == (1280, 640)
    sized = load_scene("default", {**ON, "camera.size_px": [640, 320]})
    assert sized.camera.size_px == (640, 320)
    keys = "look = [90.0, 30.0]\nfocal_length_mm = 20\nroll_deg = 3"
    lens = BASE.replace("[camera]", f"[camera]\n{keys}")
    turned = scene_from_text(lens, overrides=ON).camera
    assert (turned.azimuth_deg, turned.altitude_deg, turned.size_px) == (90.0, 0.0, (64, 32))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"camera.fov_deg": 60}, f"--set camera.fov_deg {WRONG} {ALL}"),
        ({"camera.altitude_deg": 5}, f"--set camera.altitude_deg {WRONG} {ALL}"),
        (
            {"camera.size_px": [640, 360]},
            "--set camera.size_px = [640, 360]; must be twice as",
        ),
        ({"camera.size_px.0": 640}, "must be twice as wide"),
    ],
)
def test_what_is_typed_beside_it_is_refused(changes, says):
    (line,) = problems(BASE, {**ON, **changes})
    assert says in line


def test_a_text_that_says_both_is_refused_whatever_is_typed():
    text = with_keys("fov_deg = 60")
    assert problems(text) == problems(text, ON)
    scene = scene_from_text(text, overrides={"camera.projection": "perspective"})
    assert scene.camera.fov_deg == 60.0


@pytest.mark.parametrize("look", ["antisolar", "bow-top", "sun"])
def test_a_look_turns_the_azimuth_alone(look):
    scene = load_scene("default", {**ON, "camera.look": look, "light.0.azimuth_deg": 100.0})
    lens = load_scene("default", {"camera.look": look, "light.0.azimuth_deg": 100.0})
    assert scene.camera.azimuth_deg == lens.camera.azimuth_deg
    assert scene.camera.altitude_deg == 0.0
    assert changed_scene(scene, {"camera.pixel": "area"}).camera.look == look


@pytest.mark.parametrize("changes", [{}, {"camera.look": "sun"}, {"camera.azimuth_deg": 9}])
def test_its_values_read_back(changes):
    scene = load_scene("shower", {**ON, **changes})
    assert scene_from_text(scene_text(scene)) == scene
    assert not {"fov_deg", "altitude_deg", "roll_deg", "lens_shift"} & {*values_of(scene)["camera"]}
    lens = load_scene("shower")
    assert changed_scene(lens, differences(lens, scene)) == scene
    assert changed_scene(scene, differences(scene, lens)) == lens


def test_both_parts_of_a_picture_share_it():
    right = '[compare]\nright = { "camera.projection" = "perspective" }\n'
    (line,) = problems(PANORAMA + right)
    assert "compare.right.camera.projection: both parts share it" in line
    dry = '[compare]\nright = { "droplets.density.number_per_m3" = 0 }\n'
    parts = scene_from_text(PANORAMA + dry).parts()
    assert [part.camera.whole_sphere for part, _ in parts] == [True, True]


def test_a_scene_of_values():
    drops = {"around_m": [9, 9], "radius": {"distribution": "constant", "radius_um": 9},
             "density": {"number_per_m3": 9}}  # fmt: skip
    scene = make_scene(camera={"projection": "panorama"}, light={}, droplets=drops)
    assert scene.camera.size_px == (1280, 640)
    with pytest.raises(InputError, match="fov_deg cannot be given"):
        make_scene(camera={"projection": "panorama", "fov_deg": 9}, light={}, droplets=drops)
