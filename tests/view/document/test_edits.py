"""Changing a scene by hand: nothing refused is taken, nothing taken is lost."""

import shlex
from contextlib import suppress
from pathlib import Path

import pytest

from checkout import ROOT
from rtbow.base.errors import InputError
from rtbow.scene.model import Scene
from rtbow.scene.text.file import builtin_scenes, load_scene, parse_set, scene_title, typed_override
from rtbow.scene.text.values import scene_text
from rtbow.view.document.edits import Edits, Opened


@pytest.fixture
def edits() -> Edits:
    return Edits(Opened(load_scene("uniform"), "uniform"))


def opened(name: str, *typed: str) -> Opened:
    return Opened(load_scene(name, dict(map(parse_set, typed))), name, typed)


def altitude(edits: Edits) -> float:
    return edits.scene.light[0].altitude_deg


def test_a_refused_change_leaves_all_as_it_was(edits):
    before = edits.scene
    with pytest.raises(InputError, match=r"light\.0\.altitude_deg = 91"):
        edits.change({"light.0.altitude_deg": 91.0})
    assert edits.scene is before
    assert not edits.can_undo


def test_the_window_shows_no_panorama(edits):
    before = edits.scene
    whole = {"camera.projection": "panorama"}
    with pytest.raises(InputError, match="the window shows pictures of a lens"):
        edits.change(whole)
    assert edits.scene is before
    with pytest.raises(InputError, match="use rtbow render"):
        Edits(Opened(load_scene("uniform", whole), "uniform"))


def test_changes_are_undone_and_made_again_in_order(edits):
    first = altitude(edits)
    edits.change({"light.0.altitude_deg": 5.0})
    edits.change({"light.0.altitude_deg": 6.0})
    edits.undo()
    assert altitude(edits) == 5.0
    edits.undo()
    assert altitude(edits) == first
    edits.undo()
    edits.redo()
    edits.redo()
    edits.redo()
    assert altitude(edits) == 6.0
    assert not edits.can_redo


def test_a_drag_is_one_change(edits):
    first = altitude(edits)
    for value in (1.0, 2.0, 3.0):
        edits.change({"light.0.altitude_deg": value}, gesture="drag")
    edits.end_gesture()
    edits.change({"light.0.altitude_deg": 4.0}, gesture="drag")
    edits.undo()
    assert altitude(edits) == 3.0
    edits.undo()
    assert altitude(edits) == first


def test_a_new_change_forgets_what_was_undone(edits):
    edits.change({"light.0.altitude_deg": 5.0})
    edits.undo()
    edits.change({"camera.fov_deg": 50.0})
    assert not edits.can_redo


def test_opening_another_scene_can_be_undone(edits):
    first = edits.scene
    edits.change({"camera.fov_deg": 50.0})
    edits.open(Opened(load_scene("red-sun"), "red-sun"))
    assert edits.changes == {}
    edits.undo()
    assert edits.opened.name == "uniform"
    assert edits.changes == {"camera.fov_deg": 50.0}
    edits.undo()
    assert edits.scene == first
    assert not edits.unsaved


def test_a_saved_scene_loads_as_the_same(edits, tmp_path: Path):
    edits.change({"light.0.altitude_deg": 0.1 + 0.2})
    assert edits.unsaved
    edits.save(tmp_path / "found.toml")
    assert not edits.unsaved
    assert load_scene(tmp_path / "found.toml") == edits.scene
    assert edits.command() == f"rtbow render {tmp_path / 'found.toml'}"


def test_a_scene_is_saved_as_toml_alone(edits, tmp_path: Path):
    with pytest.raises(InputError, match=r"ends with \.toml"):
        edits.save(tmp_path / "found.txt")


def test_saving_is_not_undone(edits, tmp_path: Path):
    """What comes after a saved scene, and what came before it, is saved where it was."""
    first, path = edits.scene, tmp_path / "found.toml"
    edits.change({"camera.fov_deg": 50.0})
    edits.change({"camera.fov_deg": 55.0})
    edits.undo()
    edits.save(path)
    edits.undo()
    assert edits.scene == first
    assert edits.opened.file == path
    assert edits.changes == {"camera.fov_deg": first.camera.fov_deg}
    assert edits.unsaved
    edits.redo()
    assert not edits.unsaved
    edits.redo()
    assert edits.scene.camera.fov_deg == 55.0
    assert edits.opened.file == path


def test_a_scene_from_before_another_was_opened_keeps_its_file(edits, tmp_path: Path):
    edits.open(Opened(load_scene("red-sun"), "red-sun"))
    edits.save(tmp_path / "found.toml")
    edits.undo()
    assert edits.opened.name == "uniform"


def test_a_file_that_was_just_saved_opens_without_a_step(edits, tmp_path: Path):
    path = tmp_path / "found.toml"
    edits.change({"camera.fov_deg": 50.0})
    edits.save(path)
    edits.open(Opened(load_scene(path), str(path)))
    edits.undo()
    assert edits.changes == {"camera.fov_deg": load_scene("uniform").camera.fov_deg}
    assert not edits.can_undo


def test_another_file_is_replaced_only_if_it_is_said(edits, tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    own, other = tmp_path / "own.toml", tmp_path / "other.toml"
    other.write_text("precious\n")
    assert edits.replaces(other)
    with pytest.raises(InputError, match=r"other\.toml: this file exists.*replace it"):
        edits.save(other)
    assert other.read_text() == "precious\n"
    assert edits.opened.name == "uniform"
    assert not edits.replaces(own)
    edits.save(own)
    edits.change({"camera.fov_deg": 50.0})
    edits.save(own)
    edits.save(Path("../") / tmp_path.name / "own.toml")
    edits.save(other, replace=True)
    assert load_scene(other) == edits.scene
    edits.open(Opened(load_scene(own), str(own)))
    edits.save(other)


def test_an_opened_file_is_ones_own(tmp_path: Path):
    path = tmp_path / "own.toml"
    path.write_text(scene_text(load_scene("uniform")))
    edits = Edits(Opened(load_scene(path), str(path)))
    edits.change({"camera.fov_deg": 50.0})
    edits.save(path)
    assert load_scene(path).camera.fov_deg == 50.0


def test_a_scene_keeps_the_comments_it_begins_with(tmp_path: Path):
    path, title = tmp_path / "own.toml", "# My bow.\n\n# Seen from the pier.\n"
    path.write_text(f"\ufeff{title}\n" + scene_text(load_scene("uniform")), encoding="utf-8")
    edits = Edits(Opened(load_scene(path), str(path)))
    edits.change({"camera.fov_deg": 50.0})
    for place in (path, path, tmp_path / "copy.toml"):
        edits.save(place)
        assert place.read_text().startswith(f"{title}\n[")
        assert place.read_text().count("#") == 2
        assert scene_title(place) == "My bow."
        assert load_scene(place) == edits.scene


def test_the_title_of_a_built_in_scene_is_not_that_of_what_became_of_it(edits, tmp_path: Path):
    edits.change({"droplets.radius.radius_um": 10.0})
    edits.save(tmp_path / "found.toml")
    assert "#" not in (tmp_path / "found.toml").read_text()


def rerun(command: str) -> Scene:
    """Load the scene of a command line, as ``rtbow`` does."""
    words = shlex.split(command)
    assert words[:2] == ["rtbow", "render"]
    at = words.index("--set") if "--set" in words else len(words)
    assert all(word == "--set" for word in words[at::2])
    name = words[2] if at == 3 else None
    return load_scene(name, dict(map(parse_set, words[at + 1 :: 2])))


def test_the_command_makes_the_same_scene(edits):
    edits.change({"light.0.spectrum": "FL2", "camera.polarizer_deg": 10.0})
    edits.change({"droplets.radius.radius_um": 333.3})
    words = shlex.split(edits.command("render", "-o", "a b.exr"))
    assert words[:3] == ["rtbow", "render", "uniform"]
    assert words[-2:] == ["-o", "a b.exr"]
    assert words[3:-2:2] == ["--set"] * 3
    assert rerun(shlex.join(words[:-2])) == edits.scene


GAMMA = {
    "distribution": "gamma", "mixing": "local", "effective_radius_um": 300.0,
    "effective_variance": 0.1,
}  # fmt: skip
LAMP = {"type": "point", "position_m": [0.0, -4.0, 4.0], "luminous_flux_lm": 5000.0}
SUN = {"type": "sun", "altitude_deg": 7.0, "azimuth_deg": 170.0}


@pytest.mark.parametrize(
    ("typed", "changes"),
    [
        (["light.0.altitude_deg=5"], [{"light.0.altitude_deg": 30.0}, {"light": [SUN, LAMP]}]),
        (["droplets.radius.radius_um=70"], [{"droplets.radius": GAMMA}]),
        (["compare.right.camera.fov_deg=30"], [{"compare.right": {}}]),
        (["compare.right.camera.fov_deg=30"], [{"compare": None}]),
        (["camera={fov_deg=60, altitude_deg=9}"], [{"camera.fov_deg": 30.0}]),
    ],
)
def test_the_command_says_what_was_typed_as_it_is_now(typed, changes):
    edits = Edits(opened("uniform", *typed))
    assert rerun(edits.command()) == edits.scene
    for change in changes:
        edits.change(change)
        assert rerun(edits.command()) == edits.scene


def test_the_command_says_what_a_file_typed_at_first_had_left_out(tmp_path: Path):
    """``--set droplets.file`` takes out the grid, which must not come back with the box."""
    volume = builtin_scenes()["default"].parent / "shower.npz"
    edits = Edits(opened("downpour", "droplets.grid=[4, 4, 4]"))
    path = tmp_path / "grid.toml"
    edits.save(path)
    edits = Edits(opened(str(path), f"droplets.file={volume}"))
    edits.change(
        {"droplets.file": None, "droplets.box_m": [[-9.0, 1.0, 0.0], [9.0, 9.0, 9.0]],
         "droplets.radius": {"distribution": "constant", "radius_um": 50.0},
         "droplets.density": {"number_per_m3": 5.0}}
    )  # fmt: skip
    assert edits.scene.droplets.grid is None
    assert rerun(edits.command()) == edits.scene


def test_the_command_needs_no_file_that_has_gone_or_lacks_what_was_typed(tmp_path: Path):
    path = tmp_path / "own.toml"
    text = scene_text(load_scene("street-lamp"))
    path.write_text(text.replace("fov_deg = ", "fov_deg = 9"))
    with pytest.raises(InputError):
        load_scene(path)
    edits = Edits(opened(str(path), "camera.fov_deg=70"))
    edits.change({"atmosphere": {"rayleigh": True}})
    assert rerun(edits.command()) == edits.scene
    path.unlink()
    assert rerun(edits.command()) == edits.scene


def test_the_command_starts_from_the_file_as_it_is_now(tmp_path: Path):
    path = tmp_path / "own.toml"
    text = scene_text(load_scene("uniform"))
    path.write_text(text)
    edits = Edits(opened(str(path), "camera.altitude_deg=3"))
    path.write_text(text.replace("radius_um = 300.0", "radius_um = 50.0"))
    assert rerun(edits.command()) == edits.scene


POOL: tuple[dict[str, object], ...] = (
    {"light.0.altitude_deg": 12.5}, {"light.0": LAMP}, {"light": [SUN]}, {"light": [LAMP, SUN]},
    {"light.0.spectrum": "FL2"}, {"light.1.azimuth_deg": 100.0}, {"light.0.type": "point"},
    {"droplets.radius": GAMMA}, {"droplets.radius.radius_um": 44.0}, {"droplets.grid": [3, 4, 5]},
    {"droplets.grid": None}, {"droplets.radius": {"distribution": "constant", "radius_um": 9.0}},
    {"droplets.radius": {"distribution": "marshall-palmer", "min_um": 100.0, "max_um": 900.0,
                         "mixing": "local"}, "droplets.density": {"rain_rate_mm_h": 5.0}},
    {"droplets.density.number_per_m3": 70.0}, {"droplets.file": "scenes/shower.npz"},
    {"droplets.file": None, "droplets.box_m": [[-9.0, 1.0, 0.0], [9.0, 9.0, 9.0]],
     "droplets.radius": {"distribution": "constant", "radius_um": 50.0},
     "droplets.density": {"number_per_m3": 5.0}},
    {"atmosphere": None}, {"atmosphere": {"rayleigh": True}}, {"atmosphere.rayleigh": False},
    {"camera": {"fov_deg": 33.0}}, {"camera.position_m.2": 17.0}, {"camera.polarizer_deg": 5.0},
    {"camera.polarizer_deg": None}, {"compare": {"split": 0.25, "right": {}}}, {"compare": None},
    {"compare.right": {"camera.fov_deg": 20.0, "light.0.altitude_deg": 2.0}},
    {"compare.right": {"atmosphere": "none"}}, {"compare.right.light": [LAMP]},
    {"compare.right": {}}, {"compare.split": 0.75}, {"render.steps": 64}, {"render.steps": None},
    {"scattering.orders": [2]}, {"scattering": {"theory": "mie"}},
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", ["uniform", "shower", "two-lamps", "fogbow"])
def test_after_any_changes_the_command_makes_the_same_scene(name, rng, monkeypatch):
    monkeypatch.chdir(ROOT)
    made = 0
    for _ in range(40):
        edits = None
        while edits is None:
            some = [POOL[k] for k in rng.choice(len(POOL), rng.integers(0, 4), replace=False)]
            typed = [typed_override(*one) for change in some for one in change.items()]
            with suppress(InputError):
                edits = Edits(opened(name, *typed))
        for k in rng.integers(0, len(POOL), 8):
            with suppress(InputError):
                edits.change(POOL[k])
                made += 1
            if rng.random() < 0.2:
                edits.undo()
            assert rerun(edits.command()) == edits.scene
    assert made > 100


def test_a_file_that_somebody_else_has_changed_is_not_replaced(tmp_path: Path):
    path = tmp_path / "mine.toml"
    path.write_text("# mine\n" + scene_text(load_scene("uniform")))
    edits = Edits(Opened(load_scene(path), str(path)))
    edits.change({"camera.fov_deg": 50.0})
    edits.save(path)
    edits.change({"camera.fov_deg": 51.0})
    edits.save(path)
    path.write_text(path.read_text() + "# a note\n")
    edits.change({"camera.fov_deg": 52.0})
    with pytest.raises(InputError, match="changed by another program"):
        edits.save(path)
    assert path.read_text().endswith("# a note\n")
    edits.open(Opened(load_scene(path), str(path)))
    edits.change({"camera.fov_deg": 53.0})
    edits.save(path)
    path.write_text("broken")
    with pytest.raises(InputError, match="changed by another program"):
        edits.save(path)
    edits.save(path, replace=True)
    assert load_scene(path).camera.fov_deg == 53.0


COMMENTED = """\
# My evening
[camera]
fov_deg = 60.0 # a wide lens

[[light]]
altitude_deg = 12.5 # measured

# the rain
[droplets]
box_m = [[-200.0, 100.0, 0.0], [200.0, 300.0, 200.0]]
radius = { distribution = "constant", radius_um = 300.0 }
density = { number_per_m3 = 1000.0 }
"""


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_saving_over_a_file_changes_its_values_alone(tmp_path: Path, ends: str):
    path = tmp_path / "mine.toml"
    path.write_bytes(COMMENTED.replace("\n", ends).encode())
    edits = Edits(opened(str(path)))
    edits.change({"light.0.altitude_deg": 3.25})
    edits.save(path)
    expected = COMMENTED.replace("altitude_deg = 12.5", "altitude_deg = 3.25").replace("\n", ends)
    assert path.read_bytes() == expected.encode()
    edits.save(tmp_path / "other.toml")
    assert (tmp_path / "other.toml").read_bytes() == expected.encode()


def test_the_question_tells_whose_file_it_is(tmp_path: Path):
    path, other = tmp_path / "mine.toml", tmp_path / "other.toml"
    path.write_text(COMMENTED)
    other.write_text(COMMENTED)
    edits = Edits(opened(str(path)))
    assert not edits.replaces(path)
    path.write_text(COMMENTED + "# somebody else\n")
    assert edits.replaces(path)
    assert "changed by another program" in edits.question(path)
    assert "not opened here" in edits.question(other)
    with pytest.raises(InputError, match="changed by another program"):
        edits.save(path)
