"""The cache of arrays: verified when read, harmless when it cannot be used."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rtbow.base import cache
from rtbow.base.errors import InputError, RtbowError


@pytest.fixture
def folder(tmp_path, monkeypatch):
    path = tmp_path / "cache"
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(path))
    return path


class Builder:
    """Counts how often it has to work."""

    def __init__(self, **arrays):
        self.arrays = arrays or {"a": np.arange(6.0).reshape(2, 3), "b": np.array([True, False])}
        self.runs = 0

    def __call__(self):
        self.runs += 1
        return self.arrays


def assert_same(got, expected):
    assert got.keys() == expected.keys()
    for name, array in expected.items():
        np.testing.assert_array_equal(got[name], array, strict=True)


def only_file(folder):
    (file,) = folder.iterdir()
    return file


def test_second_call_reads_what_the_first_built(folder):
    build = Builder()
    first = cache.cached_arrays("table", "key", build)
    second = cache.cached_arrays("table", "key", build)
    assert build.runs == 1
    assert_same(first, build.arrays)
    assert_same(second, build.arrays)
    name = only_file(folder).name
    assert name.startswith("table-")
    assert name.endswith(".npz")
    assert len(name) == len("table-.npz") + 16


@pytest.mark.parametrize(
    "array",
    [
        np.array(3.5),
        np.zeros((0, 4), dtype=np.float32),
        np.arange(24, dtype=">f4").reshape(2, 3, 4),
        np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        np.arange(20.0)[::3],
        np.array(["é", "bow"]),
        np.array([(1, 2.0)], dtype=[("n", "i4"), ("x", "f8")]),
    ],
    ids=["scalar", "empty", "big-endian", "fortran", "strided", "text", "record"],
)
def test_every_kind_of_array_comes_back_as_it_was(folder, array):
    build = Builder(value=array, file=array)  # "file" is a reserved word of np.savez
    cache.cached_arrays("table", "key", build)
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert build.runs == 1


def test_another_key_or_name_is_another_file(folder):
    for name, key in (("table", "1"), ("table", "2"), ("other", "1"), ("table", "\udcff é")):
        build = Builder(x=np.array([hash((name, key))]))
        assert_same(cache.cached_arrays(name, key, build), build.arrays)
        assert build.runs == 1
    assert len(list(folder.iterdir())) == 4


def test_read_arrays_can_be_changed_by_the_caller(folder):
    build = Builder()
    for _ in range(2):
        got = cache.cached_arrays("table", "key", build)
        got["a"][0, 0] = 1.0


def damage_every_byte_step(data):
    for position in range(0, len(data), 7):
        yield data[:position] + bytes([data[position] ^ 0x20]) + data[position + 1 :]


def test_damaged_file_is_never_believed(folder):
    build = Builder()
    cache.cached_arrays("table", "key", build)
    file = only_file(folder)
    good = file.read_bytes()
    for bad in damage_every_byte_step(good):
        file.write_bytes(bad)
        assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert build.runs > 10


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"not an archive", None])
def test_truncated_or_foreign_file_is_rebuilt_and_replaced(folder, content):
    build = Builder()
    cache.cached_arrays("table", "key", build)
    file = only_file(folder)
    good = file.read_bytes()
    file.write_bytes(good[: len(good) // 2] if content is None else content)
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert build.runs == 2
    assert only_file(folder).read_bytes() == good


def test_valid_archive_without_digest_is_rebuilt(folder):
    build = Builder()
    cache.cached_arrays("table", "key", build)
    np.savez(only_file(folder), a=np.zeros((2, 3)), b=np.array([True, False]))
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert build.runs == 2


def test_file_of_another_key_is_rebuilt(folder):
    other = Builder(a=np.ones(3))
    cache.cached_arrays("table", "other", other)
    foreign = only_file(folder)
    content = foreign.read_bytes()
    foreign.unlink()
    build = Builder()
    cache.cached_arrays("table", "key", build)
    only_file(folder).write_bytes(content)
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert build.runs == 2


def test_pickled_file_is_not_executed(folder, tmp_path):
    class Trap:
        def __reduce__(self):
            return (os.mkdir, (str(tmp_path / "trapped"),))

    build = Builder()
    cache.cached_arrays("table", "key", build)
    np.savez(only_file(folder), a=np.array([Trap()], dtype=object))
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)
    assert not (tmp_path / "trapped").exists()


def test_array_of_objects_is_refused(folder):
    with pytest.raises(RtbowError, match="array a holds Python objects"):
        cache.cached_arrays("table", "key", Builder(a=np.array([{}], dtype=object)))


def test_unusable_folder_costs_only_time(folder, recwarn):
    folder.write_text("a file where the folder should be")
    build = Builder()
    for runs in (1, 2):
        assert_same(cache.cached_arrays("table", "key", build), build.arrays)
        assert build.runs == runs
    assert cache.cache_size() == 0
    cache.clear_cache()
    assert folder.read_text() == "a file where the folder should be"
    assert not recwarn.list


def test_full_disk_costs_only_time(folder, monkeypatch):
    def full(path, data):
        raise InputError("no space left on device")

    monkeypatch.setattr(cache, "write_atomic", full)
    build = Builder()
    assert_same(cache.cached_arrays("table", "key", build), build.arrays)


def test_missing_home_creates_no_folder_named_tilde(tmp_path, monkeypatch):
    monkeypatch.delenv("RTBOW_CACHE_DIR", raising=False)
    monkeypatch.setattr(cache.platformdirs, "user_cache_dir", lambda *a, **k: "~/.cache/rtbow")
    monkeypatch.chdir(tmp_path)
    cache.cached_arrays("table", "key", Builder())
    assert not list(tmp_path.iterdir())


def test_folder_follows_environment(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RTBOW_CACHE_DIR", "here")
    assert cache.cache_dir() == tmp_path / "here"
    monkeypatch.setenv("RTBOW_CACHE_DIR", "~/there")
    assert cache.cache_dir() == Path.home() / "there"
    monkeypatch.setenv("RTBOW_CACHE_DIR", "")
    assert cache.cache_dir().name.lower() in ("rtbow", "cache")


def test_size_and_clearing_concern_own_files_only(folder):
    assert cache.cache_size() == 0
    cache.cached_arrays("table", "1", Builder())
    cache.cached_arrays("table", "2", Builder())
    leftover = folder / ".rtbow-0123456789abcdef.tmp"
    leftover.write_bytes(b"left by a killed process")
    own = sum(file.stat().st_size for file in folder.iterdir())
    foreign = folder / "holiday.npz"
    foreign.write_bytes(b"precious")
    assert cache.cache_size() == own
    cache.clear_cache()
    assert list(folder.iterdir()) == [foreign]
    assert cache.cache_size() == 0


RACER = """
import contextlib
import sys
import numpy as np
from rtbow.base.cache import cache_dir, cached_arrays

print("ready", flush=True)
sys.stdin.readline()
expected = {"a": np.arange(300_000.0), "b": np.arange(7)}
sizes = set()
for turn in range(60):
    got = cached_arrays("race", "key", lambda: expected)
    assert got.keys() == expected.keys()
    assert all(np.array_equal(got[k], expected[k]) for k in expected)
    with contextlib.suppress(FileNotFoundError):
        for file in cache_dir().glob("race-*.npz"):
            sizes.add(len(file.read_bytes()))
            if turn % 3 == 0:
                file.unlink()
print(*sizes)
"""


def test_processes_starting_at_once_do_not_spoil_it(folder):
    racers = [
        subprocess.Popen(
            [sys.executable, "-c", RACER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(4)
    ]
    for racer in racers:
        assert racer.stdout.readline() == "ready\n"
    for racer in racers:
        racer.stdin.write("go\n")
        racer.stdin.flush()
    sizes = []
    for racer in racers:
        output, errors = racer.communicate()
        assert racer.returncode == 0, errors
        sizes += output.split()
    # No reader has ever met a file that was half written.
    assert len(set(sizes)) == 1
    assert all(file.name.startswith("race-") for file in folder.iterdir()), "temporary files left"
