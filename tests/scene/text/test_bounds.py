"""Texts and values that no scene has: refused before they take time, with short messages."""

import os
import tomllib

import pytest

from rtbow.base.errors import InputError
from rtbow.scene.text.bounds import check_text, check_values
from rtbow.scene.text.file import builtin_scenes, load_scene, parse_set, scene_from_text
from scene_samples import BASE

LONG = "x" * 200_000


@pytest.mark.parametrize("path", builtin_scenes().values(), ids=lambda path: path.stem)
def test_built_in_scenes_are_within_them(path):
    check_text(path.read_text("utf-8"))


def parts(count, part="a", dot="."):
    return dot.join([part] * count)


@pytest.mark.parametrize(
    "text",
    [
        f"{parts(3000)} = 1",
        f"{parts(3000, chr(34) * 2, ' . ')} = 1",
        f"[{parts(3000)}]",
        f"[[{parts(3000, chr(39) + 'a.b' + chr(39))}]]",
        f"a = {{ {parts(3000)} = 1 }}",
        f"# all's well\na = '#' # \"\n{parts(3000)} = 1",
        f'a = """\n"""\n{parts(3000)} = 1',
        "a = " + "[" * 2000 + "]" * 2000,
        "a = " + "{ a = " * 2000 + "1" + "}" * 2000,
        f"[{parts(90)}]\n{parts(90)} = 1",
        f"{parts(90)} = {{ {parts(90)} = 1 }}",
        f"a = '{'x' * 2_000_000}'",
        f"a = {'9' * 5000}",
    ],
    ids=["key", "quoted", "table", "tables", "inline", "hash", "after-text", "lists", "inlines",
         "table-and-key", "key-and-inline", "size", "digits"],
)  # fmt: skip
def test_what_takes_long_is_refused(text):
    with pytest.raises(InputError) as caught:
        scene_from_text(text, "storm.toml")
    assert str(caught.value).startswith("storm.toml: not valid TOML: ")
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    "text",
    [
        f"a = '{parts(3000)} {'[' * 500}'",
        f'a = "\\"{parts(3000)} {"{" * 500}"',
        f'a = """\n\\""" {parts(3000)}\n{"[" * 500}"""""',
        f"a = '''\n''' # {parts(3000)}",
        f"# {parts(3000)} {'[' * 500}\na = 1",
        "\n".join("a = [[1.5, 2.5], [3]]" for _ in range(500)),
        "a = " + "[" * 90 + "]" * 90,
        f"{parts(90)} = 1",
    ],
)
def test_what_is_in_texts_and_comments_does_not_count(text):
    check_text(text)


@pytest.mark.parametrize("unit", ['"""', "'''", '"', "'", '\\"', '"\\', "[", "a.", '""""', "#\n"])
def test_every_text_is_read_in_one_pass(unit):
    """Whatever is left open: a million characters would take hours, were each place tried anew."""
    text = unit * (1_000_000 // len(unit))
    try:
        check_text(text)
    except InputError:
        check_text(f"# {text}" if "\n" not in text else "")


def test_tokens_end_where_the_parser_has_them_end():
    for value in ('"""a""""', '"""a"""""', "'''a''''", '"\\\\"', "''", '""', '"""\\""""', "''''''"):
        text = f"a = {value} # {'[' * 200}\nb = {'[' * 99}{']' * 99}"
        tomllib.loads(text)
        check_text(text)
        with pytest.raises(InputError, match="line 2"):
            check_text(f"a = {value}\nb = {'[' * 101}")


def nested(levels):
    value: object = 1
    for _ in range(levels):
        value = [value]
    return value


def test_overrides_have_the_same_bounds():
    endless: list[object] = []
    endless.append(endless)
    for value in (nested(50_000), endless, {"a": nested(200)}):
        with pytest.raises(InputError, match=r"^--set camera\.fov_deg: lists or tables"):
            scene_from_text(BASE, overrides={"camera.fov_deg": value})
    check_values(nested(99))


@pytest.mark.parametrize(
    "change",
    [
        f'camera.fov_deg = "{LONG}"',
        f"camera.{LONG} = 1",
        f'camera."{LONG}" = 1',
        f"{LONG} = 1",
        f'light.0.type = "{LONG}"',
        f'droplets.radius.distribution = "{LONG}"',
        f"camera.fov_deg = [{'1, ' * 50_000}]",
        f"camera.fov_deg = {{ {LONG} = 1 }}",
        f"camera.fov_deg = {'9' * 4000}",
        f"camera.fov_deg = 0x{'f' * 200_000}",
        f"camera.fov_deg.{LONG} = 1",
        f"camera.size_px.{LONG} = 1",
        f"compare.right.{LONG} = 1",
        f"light = [{'{ x = 1 }, ' * 1000}]",
        "camera.fov_deg = 2013-05-27T13:46:00Z",
        "camera.fov_deg = 13:46:00",
        "camera.fov_deg = 1e400",
        "camera.fov_deg = -nan",
        'camera."\\u0000" = 1',
        f"camera.fov_deg = {'[' * 99}{']' * 99}",
    ],
    ids=lambda change: change[:30],
)
def test_messages_stay_short(change):
    key, _, value = change.partition(" = ")
    with pytest.raises(InputError) as typed:
        scene_from_text(BASE, overrides=dict([parse_set(f"{key}={value}")]))
    written = BASE.replace("[camera]", f"{change}\n[camera]", 1)
    with pytest.raises(InputError) as in_text:
        scene_from_text(written if key.startswith(("comp", "x")) else f"{change}\n", "storm.toml")
    for caught in (typed, in_text):
        lines = str(caught.value).splitlines()
        assert len(lines) <= 12
        for line in lines:
            assert len(line) < 600
            assert line.isprintable()


@pytest.mark.parametrize("text", ["a", "=", f"{LONG}=", f"=\0{LONG}", f"camera.fov_deg=[{LONG}"])
def test_settings_that_are_none_have_short_messages(text):
    with pytest.raises(InputError) as caught:
        parse_set(text)
    assert len(str(caught.value)) < 300
    assert str(caught.value).isprintable()


def test_names_and_files_that_are_no_scenes(tmp_path):
    pipe, large, folder = (tmp_path / f"{name}.toml" for name in ("pipe", "large", "folder"))
    os.mkfifo(pipe)
    folder.mkdir()
    with large.open("wb") as file:
        file.truncate(1 << 34)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(bytes(range(256)))
    for name in (pipe, large, folder, binary, "a\0b", "a\0b.toml", LONG, "/dev/zero", "/dev/null"):
        with pytest.raises(InputError) as caught:
            load_scene(name)
        assert len(str(caught.value)) < 1000
        assert str(caught.value).isprintable()


@pytest.mark.parametrize("name", ["rain\0.npz", "rain\n.npz", f"{LONG}.npz"])
def test_odd_names_of_volumes(name):
    from rtbow.world.rain.volume import scene_volume

    scene = scene_from_text(BASE, overrides={"droplets.file": name})
    with pytest.raises(InputError) as caught:
        scene_volume(scene)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 1200
