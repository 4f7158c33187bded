"""Numbers as people write them: what the messages say to write instead."""

import pytest

from rtbow.base.errors import InputError
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.numbers import remedy
from rtbow.sequence.animation import parse_move
from scene_samples import BASE, problems

TYPED = [
    ("5,0", "write 5.0 with a point"),
    ("-0,25", "write -0.25 with a point"),
    ("5°", "write 5 without the sign °"),
    ("5.5 °", "write 5.5 without the sign °"),
    ("5,5°", "write 5.5 without the sign °"),
    ("20 %", "write 20 without the sign %"),
    ("500 µm", "write 500 without µm: the key's name has its unit"),
    ("35mm", "write 35 without mm: the key's name has its unit"),
    ("5 degrees", "write 5 without degrees: the key's name has its unit"),
    ("−5", "write -5 with a plain minus sign (-)"),
    (".5", "write 0.5 with a digit before the point"),
    ("5.", "write 5.0 with a digit behind the point"),
    ("05", "write 5 without zeros in front"),
    ("1 000", "write 1000 without marks between thousands"),
]


@pytest.mark.parametrize(("typed", "says"), TYPED)
def test_a_number_as_people_write_it(typed, says):
    assert remedy(typed) == says
    (line,) = problems(BASE.replace("altitude_deg = 20.0", f"altitude_deg = {typed} # low"))
    assert line.startswith("storm.toml: not valid TOML: ")
    assert line.endswith(f"; {says}")
    (line,) = problems(BASE, {"light.0.altitude_deg": typed})
    assert line == (
        f'--set light.0.altitude_deg = "{typed}"; must be a number, -90..90 deg; {says}'
    )


@pytest.mark.parametrize("number", ["500", "500.0", "-1e3", "+5", "1_000", "0", "0.05"])
def test_numbers_of_toml_need_no_remedy(number):
    assert remedy(number) == ""
    scene_from_text(BASE.replace("azimuth_deg = 180.0", f"azimuth_deg = {number}"))


@pytest.mark.parametrize("text", ["FL2", "wide", "5,0,0", "2024-12-21", "1/2", "", "°", "m", "5 x"])
def test_other_texts_are_left_alone(text):
    assert remedy(text) == ""


def test_moves_say_it_too():
    with pytest.raises(InputError, match=r"2,5 is not a number; write 2\.5 with a point"):
        parse_move("light.0.altitude_deg=2,5:40")
