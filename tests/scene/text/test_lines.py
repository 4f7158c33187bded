"""The line of a scene's text in which a key stands."""

import pytest

from rtbow.base.errors import InputError
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.lines import Lines

TEXT = '''\
# A title

[camera]
position_m = [
  0.0,   # east

  1.0,
]
fov_deg = 60

[[light]]
altitude_deg = 3

[[light]]
# at the corner
type = "point"
spectrum = """
[droplets]
"""
camera.note = 1
[droplets]
radius = { distribution = "constant", radius_um = 3 }

# the rain
box_m = [[1],
  [2]]
[compare.right]
"camera.fov_deg" = 3
'''


@pytest.mark.parametrize(
    ("key", "line"),
    [
        (("camera",), 3),
        (("camera", "position_m"), 4),
        (("camera", "position_m", 1), 4),
        (("camera", "fov_deg"), 9),
        (("camera", "not there"), 3),
        (("light",), 11),
        (("light", 0, "altitude_deg"), 12),
        (("light", 1), 14),
        (("light", 1, "type"), 16),
        (("light", 1, "spectrum"), 17),
        (("light", 1, "camera", "note"), 20),
        (("light", 1, "diameter_m"), 14),
        (("light", 2, "type"), 11),
        (("droplets",), 21),
        (("droplets", "radius", "radius_um"), 22),
        (("droplets", "radius", "min_um"), 22),
        (("droplets", "box_m", 1, 0), 25),
        (("compare", "right", "camera.fov_deg"), 28),
        (("render", "max_delta_e"), None),
    ],
)
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_keys_are_found_in_their_lines(key, line, ends):
    assert Lines(TEXT.replace("\n", ends)).of(key) == line


def test_an_empty_text_has_no_lines():
    assert Lines("").of(("camera",)) is None


@pytest.mark.slow
def test_each_key_of_a_long_text_is_found():
    text = "".join(f"[table{k}]\n# {k}\nkey = {k}\n" for k in range(100))
    lines = Lines(text)
    assert [lines.of((f"table{k}", "key")) for k in range(100)] == [3 * k + 3 for k in range(100)]


@pytest.mark.slow
def test_long_statements_take_no_long_time():
    """Lists over thousands of lines, and texts whose lines look like statements."""
    numbers = "\n".join("[1.0, 2.0]," for _ in range(4_000))
    prose = "\n".join("key = 3\n[table]" for _ in range(50))
    text = f'[a]\nlist = [\n{numbers}\n]\nnext = 1\nprose = """\n{prose}\n"""\nlast = 2\n'
    lines = Lines(text)
    assert lines.of(("a", "list", 3_999, 1)) == 2
    assert lines.of(("a", "next")) == 4_004
    assert lines.of(("a", "prose")) == 4_005
    assert lines.of(("a", "last")) == 4_107
    odd = text.replace(prose, 20 * prose)
    assert Lines(odd).of(("a", "last")) in (None, 1 + odd.count("\n", 0, odd.index("last =")))


@pytest.mark.parametrize("quoted", ['"a b" . c = 1', "'a b'.c=1", '"a b".c    =    1  # = 2'])
def test_keys_in_quotes(quoted):
    assert Lines(f"\n[t]\nx = 1\n{quoted}\n").of(("t", "a b", "c")) == 4


SCENE = """\
[camera]
fov_deg = 60.0

[[light]]
altitude_deg = 12.5
[[light]]
altitude_deg = 13.0

[droplets]
box_m = [[-200.0, 100.0, 0.0], [200.0, 300.0, 200.0]]
density = { number_per_m3 = 1000.0 }
[droplets.radius]
distribution = "constant"
radius_um = 300.0

[compare]
split = 0.5
[compare.right]
"light.0.altitude_deg" = 3.0
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("fov_deg = 60.0", "fov_deg = 600", "a.toml: line 2: camera.fov_deg = 600; "),
        ("13.0", "91", "a.toml: line 7: light.1.altitude_deg = 91; "),
        ("12.5", "12\nazimut_deg = 3", "a.toml: line 6: unknown key light.0.azimut_deg; "),
        ('"constant"', '"even"', 'a.toml: line 13: droplets.radius.distribution = "even"; '),
        ("radius_um = 300.0", "", "a.toml: line 12: droplets.radius.radius_um is missing; "),
        ("= 3.0\n", "= 300.0\n", "a.toml: line 19: compare.right.light.0.altitude_deg = 300.0; "),
        (
            '"light.0.altitude_deg" = 3.0',
            '"camera.size_px" = [3, 3]',
            "a.toml: line 19: compare.right.camera.size_px: both parts share it; ",
        ),
        ("[droplets", "[raindrops", "a.toml: line 9: unknown key raindrops; "),
    ],
)
def test_messages_about_values_tell_the_line(old, new, message):
    with pytest.raises(InputError) as caught:
        scene_from_text(SCENE.replace(old, new), "a.toml")
    assert str(caught.value).startswith(message)


def test_what_was_typed_has_no_line():
    with pytest.raises(InputError, match=r"^--set camera\.fov_deg = 600; "):
        scene_from_text(SCENE, "a.toml", overrides={"camera.fov_deg": 600})
