"""``compare``: a picture split between a scene and the same scene with some keys changed."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import rtbow
from rtbow.base.errors import InputError
from rtbow.scene.model import Scene
from rtbow.scene.text.file import load_scene, parse_set, scene_from_text
from rtbow.world.rain.volume import DropletVolume, save_volume
from scene_samples import BASE, problems

SMALL = BASE.replace("[64, 36]", "[20, 9]") + "[render]\nwavelength_step_nm = 20.0\n"
RIGHT = '[compare]\n[compare.right]\natmosphere.rayleigh = true\n"light.0.altitude_deg" = 5.0\n'
CHANGES = {"atmosphere.rayleigh": True, "light.0.altitude_deg": 5.0}
METHODS = [("spectral", "osmesa"), ("spectral", "egl"), ("reference", "auto")]
by_method = pytest.mark.parametrize(("method", "backend"), METHODS)


def render(scene, method="spectral", backend="osmesa"):
    with rtbow.Renderer(scene, backend) as renderer:
        return renderer.render(method)


def scene(text=SMALL, overrides=None):
    return scene_from_text(text, "storm.toml", overrides=overrides)


def right_of(split_scene):
    """The scene of the right part."""
    return split_scene.parts()[-1][0]


# --- Pictures ---------------------------------------------------------------------------------


@by_method
def test_each_half_is_that_of_its_own_scene(method, backend):
    frame = render(scene(SMALL + RIGHT), method, backend)
    left, right = render(scene(), method, backend), render(scene(SMALL, CHANGES), method, backend)
    assert np.any(left[:, 10:] != right[:, 10:])
    np.testing.assert_array_equal(frame[:, :10], left[:, :10])
    np.testing.assert_array_equal(frame[:, 10:], right[:, 10:])


@pytest.mark.slow
@by_method
@pytest.mark.parametrize(("split", "column"), [(0.0, 0), (0.3, 6), (0.32, 6), (0.33, 7), (1.0, 20)])
def test_split(method, backend, split, column):
    split_scene = scene(SMALL + RIGHT, {"compare.split": split})
    frame = render(split_scene, method, backend)
    left, right = render(scene(), method, backend), render(scene(SMALL, CHANGES), method, backend)
    assert frame.shape == (9, 20, 3)
    np.testing.assert_array_equal(frame[:, :column], left[:, :column])
    np.testing.assert_array_equal(frame[:, column:], right[:, column:])
    # What shows nothing is not worked out.
    assert len(split_scene.parts()) == (1 if column in (0, 20) else 2)


def test_one_column():
    text = (SMALL + RIGHT).replace("[20, 9]", "[1, 9]")
    assert render(scene(text)).shape == (9, 1, 3)


def test_a_lamp_beside_a_sun():
    changes = {
        "light.0.type": "point",
        "light.0.position_m": [0.0, 400.0, 100.0],
        "light.0.luminous_flux_lm": 1e9,
        "light.0.diameter_m": 0.0,
        "droplets.radius.radius_um": 200.0,
    }
    split_scene = scene(SMALL, {f"compare.right.{key}": value for key, value in changes.items()})
    frame = render(split_scene)
    np.testing.assert_array_equal(frame[:, :10], render(scene())[:, :10])
    np.testing.assert_array_equal(frame[:, 10:], render(scene(SMALL, changes))[:, 10:])


def test_rendering_twice_is_the_same():
    with rtbow.Renderer(scene(SMALL + RIGHT), "osmesa") as renderer:
        first = renderer.render("spectral")
        np.testing.assert_array_equal(renderer.render("spectral"), first)


# --- Keys -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "right",
    [
        RIGHT,
        "[compare.right]\natmosphere.rayleigh = true\nlight.0.altitude_deg = 5.0\n",
        '[compare.right]\n"atmosphere.rayleigh" = true\n"light.0.altitude_deg" = 5.0\n',
        '[compare.right]\natmosphere = { rayleigh = true }\nlight = { "0.altitude_deg" = 5 }\n',
        "[compare.right.atmosphere]\nrayleigh = true\n[compare.right.light.0]\naltitude_deg = 5\n",
        '[compare]\nright = { atmosphere = {}, "light.0" = { altitude_deg = 5 } }\n',
    ],
)
def test_keys_nested_and_dotted(right):
    got = scene(SMALL + right)
    assert got.compare.split == 0.5
    assert right_of(got) == scene(SMALL, CHANGES)


def test_a_whole_list_of_lights():
    lights = 'light = [{ altitude_deg = 5.0 }, { spectrum = "FL2" }]\n'
    got = right_of(scene(f"{SMALL}[compare.right]\n{lights}"))
    assert [light.altitude_deg for light in got.light] == [5.0, 20.0]
    assert got.light[1].spectrum == "FL2"


def test_a_new_distribution_drops_the_keys_of_the_old():
    text = (
        f'{SMALL}[compare.right.droplets]\nradius.distribution = "uniform"\nradius.min_um = 300\n'
        "radius.max_um = 500\ngrid = [4, 4, 4]\n"
    )
    assert right_of(scene(text)).droplets.radius.max_um == 500.0
    assert scene(text).droplets.radius.radius_um == 500.0


def test_set_reaches_both_parts_or_the_right_one():
    text = SMALL + RIGHT
    both = scene(text, {"droplets.radius.radius_um": 80.0, "camera.size_px": [8, 6]})
    assert [part.droplets.radius.radius_um for part, _ in both.parts()] == [80.0, 80.0]
    assert [part.camera.size_px for part, _ in both.parts()] == [(8, 6)] * 2
    for set_text in ("compare.right.droplets.radius.radius_um=80",
                     "compare.right={droplets={radius={radius_um=80.0}}}"):  # fmt: skip
        one = scene(text, dict([parse_set(set_text)]))
        assert [part.droplets.radius.radius_um for part, _ in one.parts()] == [500.0, 80.0]
    again = scene(text, {"compare.right.light.0.altitude_deg": 12.0})
    assert right_of(again).light[0].altitude_deg == 12.0
    assert right_of(again).atmosphere.rayleigh is True  # the others stay


def test_set_alone_makes_a_comparison():
    got = scene(SMALL, dict([parse_set("compare.right.atmosphere.rayleigh=true")]))
    assert got.compare.split == 0.5
    assert got.atmosphere is None
    assert right_of(got).atmosphere.rayleigh is True


def test_none_takes_the_comparison_out():
    assert len(scene(SMALL + RIGHT, {"compare": None}).parts()) == 1


@pytest.mark.parametrize(
    ("right", "line"),
    [
        (
            "camera.fov = 5",
            "compare.right.camera.fov: unknown key camera.fov; did you mean camera.fov_deg?",
        ),
        ("lights.0 = 5", "compare.right.lights.0: unknown key lights; did you mean light?"),
        ("seed = 5", "compare.right.seed: unknown key seed; did you mean droplets.seed?"),
        (
            "light.1.altitude_deg = 5",
            "compare.right.light.1.altitude_deg: light has 1 item; the last is light.0",
        ),
        (
            "camera.fov_deg = 500",
            "compare.right.camera.fov_deg = 500; must be 1e-06 or more and less than 180 deg",
        ),
        (
            "camera.azimuth_deg = nan",
            "compare.right.camera.azimuth_deg = nan; must be a finite number",
        ),
        (
            "light = [{ foo = 3 }]",
            "compare.right: unknown key light.0.foo; known here: type, altitude_deg, azimuth_deg, "
            "spectrum, beyond, angular_diameter_deg, visible, irradiance_w_m2, time, latitude_deg, "
            "longitude_deg, moon_phase_deg, moon_distance_km",
        ),
        (
            "camera.size_px = [20, 9]",
            "compare.right.camera.size_px: both parts share it; leave it out of compare.right",
        ),
        (
            "camera.size_px.0 = 20",
            "compare.right.camera.size_px.0: both parts share it; leave it out of compare.right",
        ),
        (
            "camera = {}",
            "compare.right.camera: both parts share camera.size_px; change single keys, such as "
            "camera.fov_deg",
        ),
        (
            "compare.split = 0.1",
            "compare.right.compare.split: both parts share it; leave it out of compare.right",
        ),
        (
            "compare.right.camera.fov_deg = 9",
            "compare.right.compare.right.camera.fov_deg: both parts share it; leave it out of "
            "compare.right",
        ),
    ],
)
def test_a_wrong_key_is_named_where_it_stands(right, line):
    assert problems(f"{SMALL}[compare.right]\n{right}\n") == [f"storm.toml: {line}"]


def test_a_wrong_key_after_set_is_named_there():
    assert problems(SMALL, {"compare.right.camera.fov": 60}) == [
        "--set compare.right.camera.fov: unknown key camera.fov; did you mean camera.fov_deg?"
    ]
    assert problems(SMALL, {"compare.right.camera.fov_deg": 360}) == [
        "--set compare.right.camera.fov_deg = 360; must be 1e-06 or more and less than 180 deg"
    ]
    # Beside a right one of the file.
    assert problems(SMALL + RIGHT, {"compare.right": {"camera": {"size_px": [4, 4]}}}) == [
        "--set compare.right.camera.size_px: both parts share it; leave it out of compare.right"
    ]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("[compare]\nsplit = 1.5\nright = {}", "compare.split = 1.5; must be 0..1"),
        (
            "[compare]\nsplit = nan\nright = {}",
            "compare.split = nan; must be a finite number, 0..1",
        ),
        ("[compare]", "compare.right is missing; give a table of scene keys and values"),
        ("[compare]\nright = 5", "compare.right = 5; must be a table of scene keys and values"),
        ("[compare]\nleft = {}\nright = {}", "unknown key compare.left; known here: split, right"),
    ],
)
def test_a_wrong_table(text, line):
    assert problems(f"{SMALL}{text}\n") == [f"storm.toml: {line}"]


def test_a_deeply_nested_key_is_refused_like_any_other():
    (line,) = problems(f"{SMALL}[compare.right]\n{'.'.join('a' * 3000)} = 1\n")
    assert "more than 100 parts" in line
    assert len(line) < 200
    (line,) = problems(f"{SMALL}[compare.right]\n{'.'.join('a' * 90)} = 1\n")
    assert "unknown key a" in line


# --- Paths ------------------------------------------------------------------------------------


def test_paths_are_relative_to_the_scene_file(tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    text = (
        '[compare.right]\nlight.0.spectrum = "../lamp.csv"\n"droplets.file" = "rain/shower.npz"\n'
    )
    (folder / "storm.toml").write_text(SMALL + text)
    monkeypatch.chdir(tmp_path)
    got = right_of(load_scene("scenes/storm.toml"))
    assert got.light[0].spectrum == str(tmp_path / "lamp.csv")
    assert got.droplets.file == str(folder / "rain" / "shower.npz")
    # Those after --set are relative to the current folder.
    changes = {"compare.right.droplets.file": "other.npz", "compare.right.light.0.spectrum": "FL2"}
    got = right_of(load_scene("scenes/storm.toml", changes))
    assert got.droplets.file == str(tmp_path / "other.npz")
    assert got.light[0].spectrum == "FL2"


@pytest.mark.parametrize(
    "right",
    [
        'light = [{ spectrum = "lamp.csv" }]',
        'light.0 = { spectrum = "lamp.csv" }',
        '"light.0" = { "spectrum" = "lamp.csv" }',
        'light = { "0.spectrum" = "lamp.csv" }',
    ],
)
def test_paths_in_every_form(tmp_path, right):
    path = tmp_path / "storm.toml"
    path.write_text(f"{SMALL}[compare.right]\n{right}\n")
    assert right_of(load_scene(path)).light[0].spectrum == str(tmp_path / "lamp.csv")


def test_files_are_read_from_there(tmp_path, monkeypatch):
    box = np.array([[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]])
    number = np.full((2, 2, 2), 500.0, np.float32)
    volume = DropletVolume(box, np.full((2, 2, 2), 500.0, np.float32), number)
    folder = tmp_path / "scenes"
    folder.mkdir()
    save_volume(volume, folder / "half.npz")
    (folder / "storm.toml").write_text(f'{SMALL}[compare.right]\ndroplets.file = "half.npz"\n')
    monkeypatch.chdir(tmp_path)
    frame, whole = render(load_scene(Path("scenes/storm.toml"))), render(scene())
    np.testing.assert_allclose(
        frame[:, 10:], 0.5 * whole[:, 10:], rtol=0.0, atol=1e-5 * whole.max()
    )


def test_an_unusable_file_is_named():
    with pytest.raises(InputError, match=r"storm\.toml, right part: light\.0\.spectrum: .*FL99"):
        render(scene(SMALL, {"compare.right.light.0.spectrum": "FL99"}))


# --- The scene as a value ---------------------------------------------------------------------


def test_a_split_scene_is_a_value_like_others():
    got = scene(SMALL + RIGHT)
    other = scene(SMALL + RIGHT, {"compare.right.light.0.altitude_deg": 6.0})
    assert got == scene(SMALL + RIGHT)
    assert hash(got) == hash(scene(SMALL + RIGHT))
    assert got != other
    assert got != scene()
    copy = pickle.loads(pickle.dumps(got))
    assert copy == got
    assert right_of(copy) == right_of(got)


def test_the_source_holds_what_was_changed():
    got = scene(SMALL + RIGHT, {"compare.right.light.0.altitude_deg": 6.0})
    assert got.source_text.endswith("# --set compare.right.light.0.altitude_deg=6.0\n")


def test_a_split_scene_without_its_right_part_is_not_drawn():
    """What a plain validation makes lacks the other scene; half a picture would go unnoticed."""
    bare = Scene.model_validate(scene(SMALL + RIGHT).model_dump(exclude_none=True))
    with pytest.raises(InputError, match="load_scene"):
        render(bare)
    whole = bare.with_right(scene(SMALL, CHANGES))
    np.testing.assert_array_equal(render(whole), render(scene(SMALL + RIGHT)))
