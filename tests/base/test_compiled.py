"""Compiled code in the cache: verified before it is executed, harmless when it cannot be kept."""

import os
import pickle
import stat
import subprocess
import sys

import pytest

from rtbow.base import cache, compiled, errors, files


def tripled(value):
    return 3.0 * value + 1.0


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache folder, and nothing remembered of any other."""
    path = tmp_path / "cache"
    path.mkdir(mode=0o700)
    monkeypatch.setenv("RTBOW_CACHE_DIR", str(path))
    for remembered in (compiled._folder, cache._tidy_once, errors.notice):
        remembered.cache_clear()
    yield path
    compiled._folder.cache_clear()


def hits():
    """Call the function as a new process would; give how often its code came from the cache."""
    dispatcher = compiled.compiled()(tripled)
    assert dispatcher(2.0) == 7.0
    return sum(dispatcher.stats.cache_hits.values())


def kept(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_second_process_reads_what_the_first_compiled(folder):
    assert hits() == 0
    (file,) = kept(folder)
    assert file.suffix == ".nbc"
    assert stat.S_IMODE(file.stat().st_mode) & 0o022 == 0
    assert hits() == 1
    assert cache.cache_size() == file.stat().st_size
    cache.clear_cache()
    assert kept(folder) == []


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[:100],
        lambda data: data[:-1],
        lambda data: data + b"\0",
        lambda data: bytes([data[0] ^ 1]) + data[1:],
        lambda data: data[: len(data) // 2] + b"\xff" + data[len(data) // 2 + 1 :],
        lambda data: b"\x80\x04N.",
        lambda data: b"neither code nor pickle",
    ],
    ids=["empty", "beginning", "cut", "longer", "digest", "bit", "pickle", "foreign"],
)
def test_damaged_file_is_compiled_anew_and_replaced(folder, damage):
    hits()
    (file,) = kept(folder)
    file.write_bytes(damage(file.read_bytes()))
    assert hits() == 0
    assert hits() == 1
    assert kept(folder) == [file]


def test_file_of_another_function_is_not_executed(folder):
    hits()
    (file,) = kept(folder)
    payload = file.read_bytes()[32:]
    file.write_bytes(compiled._sealed("other-0123456789abcdef.nbc", payload))
    assert hits() == 0
    assert hits() == 1


class Trap:
    """Unpickling it makes a folder."""

    def __init__(self, place):
        self.place = str(place)

    def __reduce__(self):
        return os.mkdir, (self.place,)


def test_sealed_file_that_is_no_code_costs_time_only(folder, tmp_path):
    hits()
    (file,) = kept(folder)
    for content in (b"", b"cos\nno_such_name\n.", pickle.dumps((1, 2)), pickle.dumps(7)):
        files.write_atomic(file, compiled._sealed(file.name, content), mode=0o600)
        assert hits() == 0
        assert hits() == 1


def trapped(folder, tmp_path):
    """Put a trap where code is; tell whether a run steps into it."""
    (file,) = kept(folder)
    content = compiled._sealed(file.name, pickle.dumps(Trap(tmp_path / "trap")))
    file.unlink()
    file.write_bytes(content)
    file.chmod(0o600)
    compiled._folder.cache_clear()
    assert hits() == 0
    return file, (tmp_path / "trap").exists()


def test_traps_would_work(folder, tmp_path):
    """What follows means something: without its guard, reading the file executes it."""
    hits()
    assert trapped(folder, tmp_path)[1]


@pytest.mark.parametrize("mode", [0o777, 0o775, 0o702])
@pytest.mark.parametrize("level", [0, 1, 2])
def test_folder_that_others_can_write_is_not_used(folder, tmp_path, caplog, mode, level):
    hits()
    place = [folder, folder / "numba", kept(folder)[0].parent][level]
    place.chmod(mode)
    file, stepped = trapped(folder, tmp_path)
    assert not stepped
    assert file.read_bytes().endswith(pickle.dumps(Trap(tmp_path / "trap"))), "was written to"
    (line,) = caplog.messages
    assert f"rtbow: compiled code is not kept: {place} can be written by others" in line
    assert "chmod go-w" in line
    assert "RTBOW_CACHE_DIR" in line


@pytest.mark.parametrize(("above", "used"), [(0o1777, 1), (0o777, 0)])
def test_folders_above_may_be_open_only_with_the_sticky_bit(folder, above, used):
    folder.parent.chmod(above)
    hits()
    assert hits() == used


def test_cache_folder_may_have_the_sticky_bit(folder):
    folder.chmod(0o1777)
    hits()
    assert hits() == 1
    assert stat.S_IMODE((folder / "numba").stat().st_mode) == 0o700


@pytest.mark.parametrize("level", [0, 1, 2, 3])
def test_what_belongs_to_another_user_is_not_executed(folder, tmp_path, monkeypatch, level):
    hits()
    (file,) = kept(folder)
    place = [folder, folder / "numba", file.parent, file][level]
    if os.getuid() != 0:
        pytest.skip("only the superuser can give files away")
    content = compiled._sealed(file.name, pickle.dumps(Trap(tmp_path / "trap")))
    file.write_bytes(content)
    os.chown(place, 12345, -1)
    compiled._folder.cache_clear()
    assert hits() == 0
    assert not (tmp_path / "trap").exists()


def test_file_that_others_can_write_is_replaced(folder):
    hits()
    (file,) = kept(folder)
    file.chmod(0o666)
    assert hits() == 0
    assert hits() == 1


@pytest.mark.parametrize("obstacle", ["file", "write", "mkdir"])
def test_unusable_folder_costs_time_only(folder, monkeypatch, obstacle):
    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device")

    if obstacle == "file":
        folder.rmdir()
        folder.write_text("a file where the folder should be")
    elif obstacle == "write":
        monkeypatch.setattr(os, "write", fail)
    else:
        monkeypatch.setattr(os, "mkdir", fail)
    assert hits() == 0
    assert hits() == 0


def test_pipe_in_place_of_a_file_does_not_wait(folder):
    hits()
    (file,) = kept(folder)
    file.unlink()
    os.mkfifo(file)
    assert hits() == 0
    assert hits() == 1


def test_only_a_few_versions_are_kept(folder):
    for n in range(9):
        version = folder / "numba" / f"{n:016x}"
        version.mkdir(parents=True, mode=0o700)
        os.utime(version, (n, n))
    hits()
    (file,) = kept(folder)
    names = {path.name for path in (folder / "numba").iterdir()}
    assert names == {file.parent.name, *(f"{n:016x}" for n in (6, 7, 8))}


KILLED = """
import os, signal, sys
from rtbow.base import files

def killed(descriptor, data, *, sync):
    os.write(descriptor, data[:10])
    os.kill(os.getpid(), signal.SIGKILL)

files._write_and_close = killed
files.write_atomic(sys.argv[1], b"x" * 1000)
"""


def test_leftovers_of_killed_writers_are_removed_and_no_others(folder):
    hits()
    (file,) = kept(folder)
    for place in (folder, file.parent):
        subprocess.run([sys.executable, "-c", KILLED, str(place / "target")], check=False)
    precious = folder / "precious.tmp"
    precious.write_text("of somebody else")
    live = file.parent / ".rtbow-0123456789abcdef.tmp"
    leftovers = set(kept(folder)) - {file, precious}
    assert len(leftovers) == 2
    with live.open("wb") as writer:
        files._lock(writer.fileno())
        compiled._folder.cache_clear()
        cache._tidy_once.cache_clear()
        assert hits() == 1
        cache.kept_arrays("table", "key")
        assert set(kept(folder)) == {file, precious, live}
    compiled._folder.cache_clear()
    assert hits() == 1
    assert set(kept(folder)) == {file, precious}


INTERRUPTED = """
import os, signal, sys, threading, time
from typing import NamedTuple
import numpy as np
from rtbow.base.compiled import compiled, prange

class Terms(NamedTuple):
    first: np.ndarray
    factor: np.ndarray

@compiled(parallel=True)
def sums(terms: Terms, count: int):
    up, down = np.zeros(len(terms.first)), np.zeros(len(terms.first))
    for k in prange(len(up)):
        for n in range(count):
            up[k] += np.sin(terms.first[k] + n)
            down[k] -= np.sin(terms.factor[k] * n)
    return up, down

# A shell's job in the background may ignore it, and what it starts does, too.
signal.signal(signal.SIGINT, signal.default_int_handler)

class Ended(BaseException):
    pass

def end(*_):
    raise Ended

signal.signal(signal.SIGTERM, end)
terms = Terms(np.ones(4), np.ones(4))
sums(terms, 1)
begun = time.perf_counter()
sums(terms, 1_000_000)
count = int(1_000_000 / (time.perf_counter() - begun))
number = getattr(signal, sys.argv[1])
threading.Timer(0.2, os.kill, (os.getpid(), number)).start()
try:
    sums(terms, count)
except (KeyboardInterrupt, Ended) as error:
    print(type(error).__name__, signal.getsignal(signal.SIGTERM) is end)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "raised"), [("SIGINT", "KeyboardInterrupt"), ("SIGTERM", "Ended")]
)
def test_a_signal_while_several_arrays_are_made_is_raised_afterwards(tmp_path, number, raised):
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    done = subprocess.run(
        [sys.executable, script, number], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, f"{raised} True\n"), done.stderr
