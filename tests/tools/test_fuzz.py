"""The fuzzers: every key is drawn over all its range, defects are noticed, a few seconds hold."""

import functools
import json
import math
import os
import signal
import time

import numpy as np
import pytest

from fuzz import scenes
from fuzz.extremes import VOLUMES, bounds, draw, scene_text, scene_values
from fuzz.harness import Fuzzer
from fuzz.volumes import sound_volume
from rtbow.base.errors import InputError, RtbowError
from rtbow.scene.text.file import scene_from_text
from rtbow.scene.text.schema import node_at, walk_fields

# --- what is drawn


def keys(values, table=""):
    """Yield the dotted keys of values, with 0 for the tables of a list."""
    for key, value in values.items():
        name = f"{table}.{key}" if table else key
        if isinstance(value, list) and value and isinstance(value[0], dict):
            for item in value:
                yield from keys(item, f"{name}.0")
        elif isinstance(value, dict) and key != "right":
            yield from keys(value, name)
        else:
            yield name


def test_every_key_of_the_schema_is_drawn():
    drawn = set()
    for seed in range(400):
        drawn |= set(keys(scene_values(np.random.default_rng(seed), "any")))
    assert drawn == {f"{table}.{key}" if table else key for table, key, _ in walk_fields()}


NUMBERS = [
    key
    for table, name, _ in walk_fields()
    if (node := node_at(key := f"{table}.{name}")) is not None
    and node.annotation in (int, float)
    # Dear ones are rare, or left out.
    and key not in ("render.wavelength_step_nm", "render.steps", "render.samples")
]


@pytest.mark.parametrize("key", NUMBERS)
def test_both_ends_of_every_range_are_drawn(key):
    node = node_at(key)
    rng = np.random.default_rng(1)
    values = [draw(rng, node, key) for _ in range(200)]
    low, high = bounds(node)
    assert all(low <= value <= high for value in values)
    for end in (low, high):
        assert math.isinf(end) or end in values
    assert len(set(values)) > 20


def test_a_text_that_nothing_says_how_to_draw_is_noticed():
    with pytest.raises(KeyError, match=r"fuzz/extremes\.py"):
        draw(np.random.default_rng(1), node_at("light.0.spectrum"), "light.0.filter")


def test_most_scenes_are_valid():
    valid = 0
    for seed in range(100):
        try:
            scene_from_text(scene_text(np.random.default_rng(seed), "any"))
            valid += 1
        except InputError:
            pass
    assert valid > 80


def buried_or_hazy_under_a_lamp(values):
    """Whether no shader draws a scene, for its ground or for its haze."""
    air, low = values.get("atmosphere", {}), values["droplets"].get("box_m", [[0.0, 0.0, 1e9]])[0]
    buried = "ground" in values and low[2] < values["ground"].get("height_m", 0.0)
    hazy = "ozone_du" in air or "aerosol" in air
    return buried or (hazy and any(light["type"] == "point" for light in values["light"]))


def test_pixels_are_areas_only_where_the_reference_does_not_draw_alone():
    drawn = [scene_values(np.random.default_rng(seed)) for seed in range(400)]
    slow = [values for values in drawn if buried_or_hazy_under_a_lamp(values)]
    assert len(slow) > 50
    assert all(values["camera"]["pixel"] == "centre" for values in slow)
    assert sum(values["camera"].get("pixel") == "area" for values in drawn) > 30


def test_same_seed_same_input():
    assert scenes.make(5) == scenes.make(5) != scenes.make(6)
    volumes = [sound_volume(np.random.default_rng(n)) for n in range(VOLUMES)]
    assert len(set(volumes)) == VOLUMES


# --- what is noticed: this module is a subject itself

suffix = ".txt"
seconds = 1.0
mebibytes = 64


def never_end():
    while True:
        pass


DEEDS = {
    "sound": lambda: "read",
    "raises": lambda: 1 // 0,
    "is a defect": lambda: (_ for _ in ()).throw(RtbowError("not finite")),
    "crashes": lambda: os.kill(os.getpid(), signal.SIGSEGV),
    "never ends": never_end,
    "takes memory": lambda: np.ones(64 << 20),
    "waits": lambda: time.sleep(3600.0),
}


def make(seed):
    return list(DEEDS)[seed % len(DEEDS)].encode()


def attempt(path):
    return str(DEEDS[path.read_text()]())


@pytest.mark.slow
def test_whatever_an_input_does_is_noticed_and_kept(tmp_path, monkeypatch):
    monkeypatch.setattr("fuzz.harness._WAITING", 60.0)
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    said = []
    fuzzer = Fuzzer("test_fuzz", tmp_path)
    report = fuzzer.run(0.0, 0, said.append)
    for deed in list(DEEDS)[1:]:
        if deed == "waits":
            monkeypatch.setattr("fuzz.harness._WAITING", 0.5)
        fuzzer._try(report, said.append)
    fuzzer._stop()
    assert report.counts == {
        "read": 1, "defect": 2, "crashed": 1, "too slow": 1, "memory": 1, "hung": 1
    }  # fmt: skip
    for seed, (deed, line) in enumerate(zip(list(DEEDS)[1:], said, strict=True), start=1):
        kept = tmp_path / f"{seed}.txt"
        assert kept.read_text() == deed
        assert line.startswith(f"{kept}: ")
    assert [seed for seed, _ in report.failures] == [1, 2, 3, 4, 5, 6]
    assert "ZeroDivisionError" in report.text()
    assert "failing seeds: 1, 2, 3, 4, 5, 6" in report.text()


# --- a few seconds of each


@pytest.mark.slow
@pytest.mark.parametrize(
    ("subject", "part"),
    [
        ("texts", None),
        ("volumes", None),
        ("scenes", functools.partial(scenes.make, cost="quick")),
    ],
)
def test_no_input_ends_in_a_defect(tmp_path, subject, part):
    report = Fuzzer(subject, tmp_path, part).run(4.0)
    assert not report.failures, report.text()
    assert sum(report.counts.values()) == report.next_seed > 0


def test_a_later_run_goes_on(tmp_path, monkeypatch):
    class Sound:
        """A process that finds nothing wrong."""

        def __init__(self, subject):
            pass

        def ask(self, path, seconds):
            return "read", "", float(path.read_bytes())

        def stop(self):
            pass

    monkeypatch.setattr("fuzz.harness._Child", Sound)
    fuzzer = Fuzzer("volumes", tmp_path, lambda seed: str(seed % 7).encode())
    assert fuzzer.run(0.0).next_seed == 1
    assert fuzzer.run(0.0).next_seed == 2
    assert fuzzer.run(0.0, 12).next_seed == 13  # a seed of one's own begins anew
    report = fuzzer.run(0.0)
    assert report.next_seed == 14
    assert report.slowest == [(6.0, 13), (5.0, 12)]
    assert report == Fuzzer("volumes", tmp_path)._recorded()
    recorded = json.loads((tmp_path / "volumes.json").read_text())
    assert recorded["counts"] == {"read": 2}
