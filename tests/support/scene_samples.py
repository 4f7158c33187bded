"""Scenes for tests to change and to break."""

import re
from collections.abc import Mapping

import pytest

from rtbow.base.errors import InputError
from rtbow.base.resources import resource_dir
from rtbow.scene.text.file import scene_from_text

BASE = """\
# A scene to break.
[camera]
size_px = [64, 36]

[[light]]
type = "sun"
altitude_deg = 20.0

[droplets]
box_m = [[-1500.0, 200.0, 0.0], [1500.0, 1200.0, 1100.0]]

[droplets.radius]
distribution = "constant"
radius_um = 500.0

[droplets.density]
number_per_m3 = 1000.0
"""

UNIFORM = (resource_dir("scenes") / "uniform.toml").read_text("utf-8")
FROM_FILE = '[[light]]\n[droplets]\nfile = "shower.npz"\n'


_PLACE = re.compile(r"(?m)^storm\.toml: line ([0-9]+): (?!is not)")


def problems(text: str, overrides: Mapping[str, object] | None = None) -> list[str]:
    """Return the lines of the message about a wrong scene called ``storm.toml``.

    Numbers of lines in front of keys are left out.
    """
    with pytest.raises(InputError) as caught:
        scene_from_text(text, "storm.toml", overrides=overrides)
    message = str(caught.value)
    for leak in ("Input should", "pydantic", "http", "value_error", "[type="):
        assert leak not in message
    for number in _PLACE.findall(message):
        assert 1 <= int(number) <= text.count("\n") + 1
    return _PLACE.sub("storm.toml: ", message).splitlines()
