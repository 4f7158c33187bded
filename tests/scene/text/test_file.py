"""Scene files: finding and reading them, their paths and source, and the text after --set."""

from pathlib import Path

import pytest

from rtbow.base.errors import InputError
from rtbow.scene.text import file as scene_file
from rtbow.scene.text.file import (
    builtin_scenes,
    load_scene,
    parse_set,
    scene_from_text,
    scene_title,
)
from scene_samples import BASE, FROM_FILE, problems


@pytest.fixture
def scenes_dir(tmp_path, monkeypatch) -> Path:
    """A folder of built-in scenes of our own."""
    folder = tmp_path / "builtin"
    (folder / "figures").mkdir(parents=True)
    for name in ("default", "shower", "figures/fig1"):
        (folder / f"{name}.toml").write_text(BASE, encoding="utf-8")
    (folder / "README.md").write_text("# Scenes", encoding="utf-8")
    monkeypatch.setattr(scene_file, "resource_dir", lambda kind: folder)
    return folder


# --- text that is no TOML, files that cannot be read


@pytest.mark.parametrize(
    ("text", "reason", "place"),
    [
        ("[camera\n", "Expected ']'", "(at line 1, column 8)"),
        ("a = 1\nb 2\n", "Expected '='", "(at line 2, column 3)"),
        ("a = 1\nb = [\n", "Invalid value", "(at end of document)"),
        (f"a = {'9' * 5000}", "a number has too many digits", ""),
        (f"a = {'[' * 9000}", "lists or tables are nested too deeply", "(at line 1)"),
    ],
    ids=["table", "key", "end", "digits", "depth"],
)
def test_a_syntax_error_says_what_and_where(text, reason, place):
    (line,) = problems(text)
    assert line.startswith(f"storm.toml: not valid TOML: {reason}")
    assert line.endswith(place)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("[camera]\nfov_deg = 60\n[droplets]\n[camera]\n", "line 4, column 8"),
        ("[camera]\nfov_deg = 60\nfov_deg = 70 # wide\n", "line 3, column 13"),
        ("a = 1\n[ a ]\n", "line 2, column 5"),
        ("a.b = 1\na.b = 2\n", "line 2, column 8"),
        ('a = 1\n"a" = 2\n', "line 2, column 8"),
        ("a = {}\na.b = 1\n", "line 2, column 8"),
        ("a = {x = 1, x = 2}\n", "line 1, column 18"),
        ("a = 1\na = [\n1,\n2]", "end of document"),
    ],
)
def test_what_is_given_twice(text, place):
    (line,) = problems(text)
    assert line.startswith("storm.toml: not valid TOML: ")
    assert line.endswith(f" (at {place})")


@pytest.mark.parametrize(
    "heads",
    [("[light]", "[light]"), ("[[light]]", " [light] # one more"), ("[light]", "[[light]]")],
)
def test_lights_in_single_brackets_have_a_remedy(heads):
    (line,) = problems("\n".join(heads))
    assert "(at line 2, column " in line
    assert line.endswith("; write [[light]], in double brackets, for each light")


def test_the_remedy_for_lights_stays_away_from_other_mistakes():
    (line,) = problems("[light]\naltitude_deg\n")
    assert line.endswith("(at line 2, column 13)")


def test_huge_integers_are_refused_like_other_values():
    (line,) = problems(BASE.replace("radius_um = 500.0", f"radius_um = 0x{'f' * 5000}"))
    assert line.startswith("storm.toml: droplets.radius.radius_um = ")


@pytest.mark.parametrize(
    "lines",
    [
        'spectrum = "moon"\nmoon_distance_km = ',
        "time = 2020-06-01T12:00:00Z\nlatitude_deg = 5.0\nlongitude_deg = ",
    ],
)
def test_huge_integers_are_refused_where_others_follow_from_them(lines):
    text = BASE.replace('type = "sun"', f'type = "sun"\n{lines}1{"0" * 400}')
    assert text != BASE
    assert problems(text)
    with pytest.raises(InputError, match=r"light\.0"):
        load_scene("uniform", {"light.0.spectrum": "moon", "light.0.moon_distance_km": 10**400})


def test_a_missing_file(tmp_path, scenes_dir):
    path = tmp_path / "none.toml"
    with pytest.raises(InputError, match=r"none\.toml: there is no such file"):
        load_scene(path)
    with pytest.raises(InputError, match="the built-in scene is called shower"):
        load_scene(tmp_path / "shower.toml")


def test_a_folder_is_no_scene(tmp_path):
    (tmp_path / "dir.toml").mkdir()
    with pytest.raises(InputError, match=r"dir\.toml: is a folder"):
        load_scene(tmp_path / "dir.toml")


def test_text_must_be_utf8(tmp_path):
    path = tmp_path / "latin.toml"
    path.write_bytes(b"# one\n# caf\xe9\n")
    with pytest.raises(InputError, match=r"latin\.toml: line 2: is not UTF-8"):
        load_scene(path)


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    path = tmp_path / "bom.toml"
    path.write_bytes(b"\xef\xbb\xbf" + BASE.encode())
    assert load_scene(path).source_text == BASE


def test_an_unreadable_file(monkeypatch):
    def refuse(path, most):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(scene_file, "read_limited", refuse)
    with pytest.raises(InputError, match=r"closed\.toml: cannot be read: Permission denied"):
        load_scene("closed.toml")


def test_a_path_that_no_system_has():
    with pytest.raises(InputError, match="cannot be read"):
        load_scene("nul\0.toml")
    with pytest.raises(InputError, match="cannot be read"):
        load_scene(f"{'x' * 5000}.toml")


# --- finding scenes


def test_builtin_scenes_are_found_by_name(scenes_dir):
    assert list(builtin_scenes()) == ["default", "figures/fig1", "shower"]
    assert builtin_scenes()["figures/fig1"] == scenes_dir / "figures" / "fig1.toml"
    assert load_scene().source_name == "default"
    assert load_scene("figures/fig1").source_name == "figures/fig1"
    assert load_scene("shower") == load_scene(scenes_dir / "shower.toml")


def test_an_unknown_name_brings_the_nearest_ones(scenes_dir, tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r'no built-in scene named "showr"; did you mean shower\?'):
        load_scene("showr")
    with pytest.raises(InputError, match="built-in scenes are default, figures/fig1, shower"):
        load_scene("xyzzy")
    monkeypatch.chdir(tmp_path)
    Path("xyzzy").write_text(BASE)
    with pytest.raises(InputError, match=r"file xyzzy can be read once its name ends with \.toml"):
        load_scene("xyzzy")
    with pytest.raises(InputError, match='named ""'):
        load_scene("")


def test_a_file_is_found_without_its_suffix(scenes_dir, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    for path in (Path("mine.toml"), Path("mine") / "rain.toml"):
        path.write_text(BASE)
        got = load_scene(path.with_suffix(""))
        assert (got, got.source_name) == (load_scene(path), str(path))


def test_a_builtin_scene_goes_before_a_file_of_its_name(scenes_dir, tmp_path, monkeypatch, caplog):
    monkeypatch.chdir(tmp_path)
    Path("shower.toml").write_text(BASE.replace("500.0", "77.0"))
    assert load_scene("shower").source_text == BASE
    assert caplog.messages == [
        "rtbow: shower is the built-in scene; to read the file, write shower.toml"
    ]
    assert load_scene("shower.toml").droplets.radius.radius_um == 77.0


def test_a_file_beside_does_not_hide_a_builtin_scene(scenes_dir, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("shower").write_text("not a scene")
    assert load_scene("shower").source_text == BASE


@pytest.mark.parametrize(
    ("text", "title"),
    [
        (BASE, "A scene to break."),
        ("\n\n##  Low sun \n# more\n", "Low sun"),
        ("[camera]\n# not a title\n", ""),
        ("", ""),
    ],
)
def test_the_title_is_the_first_comment(tmp_path, text, title):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    assert scene_title(path) == title


# --- paths and source


def test_paths_are_relative_to_the_scene_file(tmp_path, monkeypatch):
    folder = tmp_path / "scenes"
    folder.mkdir()
    (folder / "storm.toml").write_text(
        '[[light]]\nspectrum = "../lamp.csv"\n[[light]]\nspectrum = "FL2"\n'
        '[droplets]\nfile = "rain/shower.npz"\n'
    )
    monkeypatch.chdir(tmp_path)
    got = load_scene("scenes/storm.toml", {"light.1.spectrum": "other.CSV"})
    assert got.light[0].spectrum == str(tmp_path / "lamp.csv")
    assert got.light[1].spectrum == str(tmp_path / "other.CSV")
    assert got.droplets.file == str(folder / "rain" / "shower.npz")
    assert load_scene("scenes/storm.toml").light[1].spectrum == "FL2"


def test_absolute_paths_stay(tmp_path):
    path = tmp_path / "shower.npz"
    assert scene_from_text(FROM_FILE, overrides={"droplets.file": path}).droplets.file == str(path)


def test_the_source_is_the_text_and_the_overrides(tmp_path):
    path = tmp_path / "storm.toml"
    path.write_text(BASE.rstrip("\n"))
    assert load_scene(path).source_text == BASE.rstrip("\n")
    assert load_scene(path).source_name == str(path)
    changes = {"camera.size_px": (32, 16), "light.0.spectrum": "FL2", "atmosphere.rayleigh": False}
    got = load_scene(path, changes)
    assert got.source_text == BASE + (
        "# --set camera.size_px=[32, 16]\n"
        '# --set light.0.spectrum="FL2"\n'
        "# --set atmosphere.rayleigh=false\n"
    )
    again = scene_from_text(
        got.source_text,
        overrides=dict(
            parse_set(line.removeprefix("# --set "))
            for line in got.source_text.splitlines()
            if line.startswith("# --set ")
        ),
    )
    assert again == got


# --- the text after --set


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("light.0.altitude_deg=5", "light.0.altitude_deg", 5),
        ("camera.size_px=[640,360]", "camera.size_px", [640, 360]),
        (" camera.fov_deg = 60.5 ", "camera.fov_deg", 60.5),
        ("atmosphere.rayleigh=true", "atmosphere.rayleigh", True),
        ('light.0.spectrum="E490"', "light.0.spectrum", "E490"),
        ("light.0.spectrum=FL2", "light.0.spectrum", "FL2"),
        ("light.0.spectrum=LED-B3", "light.0.spectrum", "LED-B3"),
        ("light.0.spectrum=equal-energy", "light.0.spectrum", "equal-energy"),
        ("droplets.file=rain/a=b #2.npz", "droplets.file", "rain/a=b #2.npz"),
        ("droplets.file='a b.npz'", "droplets.file", "a b.npz"),
        ("atmosphere.rayleigh=True", "atmosphere.rayleigh", "True"),
        (
            "droplets.radius={distribution='constant'}",
            "droplets.radius",
            {"distribution": "constant"},
        ),
    ],
)
def test_parse_set(text, key, value):
    assert parse_set(text) == (key, value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("light.0.altitude_deg", "write key.path=value"),
        ("=5", "write key.path=value"),
        ("camera.fov_deg=", "write key.path=value"),
        ("camera.size_px=[640,360", r"\[640,360 is not a TOML value"),
        ('light.0.spectrum="FL2', "is not a TOML value"),
        ("camera.fov_deg=5\nx=3", "give one value, on one line"),
        (f"camera.fov_deg={'[' * 9000}", "is not a TOML value"),
    ],
    ids=["no equals", "no key", "no value", "open list", "open text", "two lines", "depth"],
)
def test_parse_set_refuses(text, message):
    with pytest.raises(InputError, match=message):
        parse_set(text)


def test_text_where_a_number_belongs_is_shown_as_text():
    assert problems(BASE, dict([parse_set("camera.fov_deg=wide")])) == [
        '--set camera.fov_deg = "wide"; must be a number, 1e-06 or more and less than 180 deg'
    ]
